//! Particles seen from the side, in the paper's colours.

use std::path::Path;

use anyhow::anyhow;
use fieldstone::sph::Solver;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::cli::reproduce::plots::save;

const FREE: RGBColor = RGBColor(220, 30, 30);
const INNER: RGBColor = RGBColor(40, 70, 200);
const MISIDENTIFIED: RGBColor = RGBColor(20, 160, 40);

/// Width of each panel in pixels.
const WIDTH: u32 = 860;
const TITLE: u32 = 36;
const MARGIN: u32 = 10;

/// Labels by one method.
pub(super) struct Panel<'a> {
    pub title: String,
    pub labels: &'a [bool],
}

/// What is seen, along y.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    /// Left and right end.
    pub x: [f64; 2],
    /// Lower and upper end.
    pub z: [f64; 2],
    /// Nearest and farthest.
    pub y: [f64; 2],
}

impl View {
    /// Everything up to `depth` behind the tank's near face, in its full length.
    pub fn whole(solver: &Solver, depth: f64) -> Self {
        let (state, flow) = (solver.state(), solver.flow());
        let top = state.x.iter().map(|p| p[2]).fold(0.0, f64::max) + 2.0 * flow.fluid.spacing;
        let [low, high] = [flow.boundaries.low, flow.boundaries.high];
        Self { x: [low[0], high[0]], z: [low[2], top], y: [low[1], low[1] + depth] }
    }

    /// The layer of particles whose plane is nearest to the middle of the tank, between two ends along x.
    pub fn middle_layer(solver: &Solver, x: [f64; 2]) -> Self {
        let (flow, spacing) = (solver.flow(), solver.flow().fluid.spacing);
        let [low, high] = [flow.boundaries.low, flow.boundaries.high];
        let layers = ((high[1] - low[1]) / spacing).round();
        let y = low[1] + ((0.5 * layers).floor() + 0.5).min(layers - 0.5) * spacing;
        Self { x, y: [y - 0.5 * spacing, y + 0.5 * spacing], ..Self::whole(solver, 0.0) }
    }

    pub fn sees(&self, p: [f64; 3]) -> bool {
        let within = |value: f64, [low, high]: [f64; 2]| low <= value && value <= high;
        within(p[0], self.x) && within(p[1], self.y) && within(p[2], self.z)
    }
}

/// Draws the panels, `columns` in a row: red free surface, blue inner particles, green where a label differs from
/// `reference`; the nearest particles last.
pub(super) fn draw(
    path: &Path,
    solver: &Solver,
    view: View,
    columns: usize,
    reference: &[bool],
    panels: &[Panel<'_>],
) -> anyhow::Result<()> {
    let x = &solver.state().x;
    let mut order: Vec<usize> = (0..x.len()).filter(|&i| view.sees(x[i])).collect();
    order.sort_by(|&a, &b| x[b][1].total_cmp(&x[a][1]).then(a.cmp(&b)));
    let scale = f64::from(WIDTH - 2 * MARGIN) / (view.x[1] - view.x[0]);
    let height = TITLE + 2 * MARGIN + (scale * (view.z[1] - view.z[0])).ceil() as u32;
    let radius = ((0.45 * scale * solver.flow().fluid.spacing).round() as i32).max(1);
    let rows = panels.len().div_ceil(columns);
    save(path, (columns as u32 * WIDTH, rows as u32 * height), |root| {
        for (area, panel) in root.split_evenly((rows, columns)).iter().zip(panels) {
            let style = ("sans-serif", 24).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Top));
            area.draw_text(&panel.title, &style, (MARGIN as i32, 6)).map_err(|e| anyhow!("cannot draw: {e}"))?;
            for &i in &order {
                let right = MARGIN as i32 + (scale * (x[i][0] - view.x[0])).round() as i32;
                let down = (height - MARGIN) as i32 - (scale * (x[i][2] - view.z[0])).round() as i32;
                let colour = match (panel.labels[i], reference[i]) {
                    (true, true) => FREE,
                    (false, false) => INNER,
                    _ => MISIDENTIFIED,
                };
                area.draw(&Circle::new((right, down), radius, colour.filled()))
                    .map_err(|e| anyhow!("cannot draw: {e}"))?;
            }
        }
        Ok(())
    })
}
