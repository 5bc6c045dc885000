//! Fig. 9: the two meshes of 27 hexahedra with a unit sphere at the origin.

use anyhow::{Result, anyhow};
use plotters::prelude::*;

use super::Settings;
use super::meshes::{Lattice, Split};
use super::plots::{Area, save};

/// Shear of the second mesh, in degrees.
const ANGLE: f64 = 45.0;
/// Direction of view: turned about z, then tilted towards the eye.
const TURN: f64 = 0.42;
const TILT: f64 = 0.38;

pub(super) fn run(settings: &Settings) -> Result<String> {
    save(&settings.folder.join("fig9.png"), (1400, 620), |root| {
        let panels = [(0.0, "27 hexahedra, regular".to_string()), (ANGLE, format!("sheared by {ANGLE}° along x"))];
        for (area, (angle, title)) in root.split_evenly((1, 2)).iter().zip(panels) {
            panel(area, &Lattice::new(Split::Hexahedra, angle), &title)?;
        }
        Ok(())
    })?;
    Ok("## The meshes (Fig. 9)\n\n![The meshes](fig9.png)\n\nThe two meshes of 27 hexahedra, with a unit sphere at the \
        origin. The others are made from them by splitting each hexahedron into 2 wedges or 5, 6, 20 or 24 \
        tetrahedra: 20 and 24 are the 5 and 6, each split into four around its centroid, as in the paper. Larger \
        spheres get more cells of the same kind. Every element has its corners at its own place, and every one of \
        them is evaluated alone.\n"
        .into())
}

fn panel(area: &Area<'_>, lattice: &Lattice, title: &str) -> Result<()> {
    let failed = |e: &dyn std::fmt::Display| anyhow!("{e}");
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .caption(title, ("sans-serif", 26))
        .build_cartesian_2d(-3.6..3.6, -2.98..2.98)
        .map_err(|e| failed(&e))?;
    let back = ShapeStyle { color: RGBColor(190, 190, 190).to_rgba(), filled: false, stroke_width: 1 };
    let front = ShapeStyle { color: RGBColor(40, 40, 40).to_rgba(), filled: false, stroke_width: 2 };
    let mut line = |points: Vec<[f64; 3]>, style: ShapeStyle| -> Result<()> {
        let points: Vec<(f64, f64)> = points.into_iter().map(project).collect();
        chart.draw_series(std::iter::once(PathElement::new(points, style))).map_err(|e| failed(&e))?;
        Ok(())
    };
    // Corners of cells 0 to 3 along each axis; a fourth cell's lower corners are the third's upper ones.
    let corner = |i: i32, j: i32, k: i32| lattice.corners([i - 1, j - 1, k - 1])[0];
    for (style, outside) in [(back, false), (front, true)] {
        for a in 0..=3 {
            for b in 0..=3 {
                // Lines along x, y and z; the eye sees the sides of large x, small y and large z.
                let [seen_x, seen_y, seen_z] = [b == 3 || a == 0, b == 3 || a == 3, b == 0 || a == 3];
                for (seen, ends) in [
                    (seen_x, [corner(0, a, b), corner(3, a, b)]),
                    (seen_y, [corner(a, 0, b), corner(a, 3, b)]),
                    (seen_z, [corner(a, b, 0), corner(a, b, 3)]),
                ] {
                    if seen == outside {
                        line(ends.to_vec(), style)?;
                    }
                }
            }
        }
        if !outside {
            sphere(&mut line)?;
        }
    }
    Ok(())
}

/// Outline, and circles of latitude and longitude.
fn sphere(line: &mut impl FnMut(Vec<[f64; 3]>, ShapeStyle) -> Result<()>) -> Result<()> {
    let thin = ShapeStyle { color: RGBColor(0, 114, 178).mix(0.45), filled: false, stroke_width: 1 };
    let thick = ShapeStyle { color: RGBColor(0, 114, 178).to_rgba(), filled: false, stroke_width: 3 };
    let circle = |at: &dyn Fn(f64, f64) -> [f64; 3]| -> Vec<[f64; 3]> {
        (0..=72).map(|k| (f64::from(k) / 72.0 * std::f64::consts::TAU).sin_cos()).map(|(s, c)| at(s, c)).collect()
    };
    for n in 1..6 {
        let (sin, cos) = (f64::from(n) * std::f64::consts::PI / 6.0).sin_cos();
        line(circle(&|s, c| [sin * c, sin * s, cos]), thin)?;
        line(circle(&|s, c| [c * cos, c * sin, s]), thin)?;
    }
    // The outline is the circle across the direction of view.
    let ((st, ct), (sp, cp)) = (TURN.sin_cos(), TILT.sin_cos());
    line(circle(&|s, c| [c * ct - s * st * sp, c * st + s * ct * sp, s * cp]), thick)
}

/// Orthographic projection: right and up.
fn project([x, y, z]: [f64; 3]) -> (f64, f64) {
    let ((st, ct), (sp, cp)) = (TURN.sin_cos(), TILT.sin_cos());
    let (right, away) = (x * ct + y * st, y * ct - x * st);
    (right, z * cp + away * sp)
}
