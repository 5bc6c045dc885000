//! Fig. 16: particles, free surface, and pressure in the middle of the tank.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::anyhow;
use fieldstone::io::AtomicFile;
use fieldstone::surface::{Nodes, Walls, iso_surface};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::flow_run::{FlowRun, Frame};
use super::middle_slice::{MiddleSlice, surface_field};
use super::shaded;
use crate::cli::picture::viridis;
use crate::cli::reproduce::plots::save;

const WIDTH: u32 = 1000;
const TITLE: u32 = 34;

/// Pressure up to which colours go, of ρgH.
const RANGE: f64 = 1.0;
/// Bands of colour: their limits are the contours.
const BANDS: f64 = 16.0;

pub(super) fn section(flow: &FlowRun, folder: &Path) -> anyhow::Result<String> {
    let mut text = String::from(
        "## Fig. 16: particles, free surface, pressure\n\nTop: particles by pressure. Middle: the free surface, the level \
         φ = −Δx/4h of Eq. 34. Bottom: pressure by moving least squares in the plane in the middle of the tank, contours \
         every ρgH/16. The surface's volume over that of the particles:\n\n| time | volume | triangles |\n|---|---|---|\n",
    );
    let mut pictures = String::new();
    for time in [0.52, 1.42] {
        let frame = flow.frame(time)?;
        let name = format!("fig16_{time:.2}s.png");
        let (volume, triangles) = picture(&folder.join(&name), &frame)?;
        let _ = writeln!(text, "| {:.3} s | {volume:.4} | {triangles} |", frame.time);
        let _ = writeln!(pictures, "![Dam break at {time} s]({name})");
    }
    Ok(format!("{text}\n{pictures}\n"))
}

/// Draws one time; volume inside the surface over that of the particles, and the number of triangles.
fn picture(path: &Path, Frame { solver, time }: &Frame) -> anyhow::Result<(f64, usize)> {
    let (state, flow) = (solver.state(), solver.flow());
    let (fluid, boundaries) = (&flow.fluid, &flow.boundaries);
    let spacing = fluid.spacing;
    let mesh =
        iso_surface(&surface_field(solver, &Nodes::around(&state.x, 1.5 * spacing, 0.5 * spacing)?)?, Walls::Closed);
    let volume: f64 = state.density.iter().map(|d| fluid.particle_mass() / d).sum();
    let slice = MiddleSlice::new(solver, 0.25)?;
    write_line(&path.with_extension("csv"), &slice)?;

    let top = state.x.iter().map(|p| p[2]).fold(0.0, f64::max) + 2.0 * spacing;
    let length = boundaries.high[0] - boundaries.low[0];
    let scale = f64::from(WIDTH) / length;
    let height = (scale * top).ceil() as u32;
    let scale_of_pressure = 0.6 * fluid.density * -fluid.gravity[2] * RANGE;
    let colour = |pressure: f64| {
        let [r, g, b] = viridis(((pressure / scale_of_pressure * BANDS).floor() + 0.5) / BANDS);
        RGBColor(r, g, b)
    };
    save(path, (WIDTH, 3 * (height + TITLE)), |root| {
        let panels = root.split_evenly((3, 1));
        let failed = |e: &dyn std::fmt::Display| anyhow!("cannot draw: {e}");
        let titles = ["particles", "free surface", "pressure, contours every ρgH/16"];
        let style = ("sans-serif", 22).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Top));
        for (panel, title) in panels.iter().zip(titles) {
            panel.draw_text(&format!("{time:.3} s: {title}"), &style, (8, 6)).map_err(|e| failed(&e))?;
        }
        let place = |x: f64, z: f64| {
            ((scale * (x - boundaries.low[0])) as i32, (TITLE + height) as i32 - 1 - (scale * z) as i32)
        };
        let mut order: Vec<usize> = (0..state.len()).collect();
        order.sort_by(|&a, &b| state.x[b][1].total_cmp(&state.x[a][1]).then(a.cmp(&b)));
        let radius = ((0.45 * scale * spacing).round() as i32).max(1);
        for i in order {
            let dot = Circle::new(
                place(state.x[i][0], state.x[i][2]),
                radius,
                colour(fluid.pressure(state.density[i])).filled(),
            );
            panels[0].draw(&dot).map_err(|e| failed(&e))?;
        }
        let below_title = panels[1].margin(TITLE, 0, 0, 0);
        shaded::draw(&below_title, &mesh, boundaries.low, [boundaries.high[0], boundaries.high[1], top])?;
        for row in 0..height as i32 {
            for column in 0..WIDTH as i32 {
                let at = [
                    boundaries.low[0] + (f64::from(column) + 0.5) / scale,
                    (f64::from(height as i32 - 1 - row) + 0.5) / scale,
                ];
                if let Some(pressure) = slice.pressure(at) {
                    panels[2].draw_pixel((column, TITLE as i32 + row), &colour(pressure)).map_err(|e| failed(&e))?;
                }
            }
        }
        for [from, to] in slice.line() {
            let line = PathElement::new([place(from[0], from[1]), place(to[0], to[1])], BLACK);
            panels[2].draw(&line).map_err(|e| failed(&e))?;
        }
        Ok(())
    })?;
    Ok((mesh.volume() / volume, mesh.triangles.len()))
}

/// The free surface in the middle plane, a segment per row.
fn write_line(path: &Path, slice: &MiddleSlice) -> anyhow::Result<()> {
    let mut rows = String::from("x0,z0,x1,z1\n");
    for [[x0, z0], [x1, z1]] in slice.line() {
        let _ = writeln!(rows, "{x0:.5},{z0:.5},{x1:.5},{z1:.5}");
    }
    Ok(AtomicFile::write(path, |out| out.write_all(rows.as_bytes()))?)
}
