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
const WIDTH: u32 = 1000;
const TITLE: u32 = 40;

/// Labels by one method.
pub(super) struct Panel<'a> {
    pub title: String,
    pub labels: &'a [bool],
}

/// Draws the panels two by two: red free surface, blue inner particles, green where a label differs from `reference`.
///
/// Particles are seen along y; drawn are those within `depth` of the nearest one, the nearest last.
pub(super) fn draw(
    path: &Path,
    solver: &Solver,
    depth: f64,
    reference: &[bool],
    panels: &[Panel<'_>],
) -> anyhow::Result<()> {
    let x = &solver.state().x;
    let boundaries = &solver.flow().boundaries;
    let spacing = solver.flow().fluid.spacing;
    let nearest = x.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min);
    let top = x.iter().map(|p| p[2]).fold(0.0, f64::max) + 2.0 * spacing;
    let mut order: Vec<usize> = (0..x.len()).filter(|&i| x[i][1] <= nearest + depth).collect();
    order.sort_by(|&a, &b| x[b][1].total_cmp(&x[a][1]).then(a.cmp(&b)));
    let scale = f64::from(WIDTH - 20) / (boundaries.high[0] - boundaries.low[0]);
    let height = TITLE + 20 + (scale * (top - boundaries.low[2])).ceil() as u32;
    let radius = ((0.45 * scale * spacing).round() as i32).max(1);
    let rows = panels.len().div_ceil(2);
    save(path, (2 * WIDTH, rows as u32 * height), |root| {
        for (area, panel) in root.split_evenly((rows, 2)).iter().zip(panels) {
            let style = ("sans-serif", 26).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Top));
            area.draw_text(&panel.title, &style, (10, 6)).map_err(|e| anyhow!("cannot draw: {e}"))?;
            for &i in &order {
                let right = 10 + (scale * (x[i][0] - boundaries.low[0])).round() as i32;
                let down = height as i32 - 10 - (scale * (x[i][2] - boundaries.low[2])).round() as i32;
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
