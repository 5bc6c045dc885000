//! Triangles seen obliquely, shaded by their normals.

use anyhow::anyhow;
use fieldstone::surface::TriangleMesh;
use plotters::element::BitMapElement;

use crate::cli::reproduce::plots::Area;

/// Directions to the right, up, and towards the eye: from the front, 5° from the left, 25° from above.
fn directions() -> [[f64; 3]; 3] {
    let ((s, c), (se, ce)) = (5f64.to_radians().sin_cos(), 25f64.to_radians().sin_cos());
    [[c, -s, 0.0], [s * se, c * se, ce], [-s * ce, -c * ce, se]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Draws a surface so that the box between `low` and `high` fills the area.
pub(super) fn draw(area: &Area<'_>, mesh: &TriangleMesh, low: [f64; 3], high: [f64; 3]) -> anyhow::Result<()> {
    let (width, height) = area.dim_in_pixel();
    let [to_right, up, near] = directions();
    let corners = (0..8).map(|c| [0, 1, 2].map(|k| if c >> k & 1 == 0 { low[k] } else { high[k] }));
    let (mut least, mut most) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for corner in corners {
        for (k, axis) in [to_right, up].into_iter().enumerate() {
            least[k] = least[k].min(dot(corner, axis));
            most[k] = most[k].max(dot(corner, axis));
        }
    }
    let scale = (f64::from(width - 1) / (most[0] - least[0])).min(f64::from(height - 1) / (most[1] - least[1]));
    let mut pixels = vec![255u8; 3 * width as usize * height as usize];
    let mut depth = vec![f64::NEG_INFINITY; width as usize * height as usize];
    let projected: Vec<[f64; 3]> = mesh
        .points
        .iter()
        .map(|&p| {
            let down = f64::from(height - 1) - scale * (dot(p, up) - least[1]);
            [scale * (dot(p, to_right) - least[0]), down, dot(p, near)]
        })
        .collect();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|p| projected[p as usize]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 {
            continue;
        }
        let ends = |k: usize, size: u32| {
            let low = a[k].min(b[k]).min(c[k]).ceil().max(0.0);
            let high = a[k].max(b[k]).max(c[k]).floor().min(f64::from(size - 1));
            low as i64..=high as i64
        };
        for y in ends(1, height) {
            for x in ends(0, width) {
                let (px, py) = (x as f64, y as f64);
                let v = ((px - a[0]) * (c[1] - a[1]) - (py - a[1]) * (c[0] - a[0])) / area;
                let w = ((b[0] - a[0]) * (py - a[1]) - (b[1] - a[1]) * (px - a[0])) / area;
                let u = 1.0 - v - w;
                if u < 0.0 || v < 0.0 || w < 0.0 {
                    continue;
                }
                let (at, z) = (y as usize * width as usize + x as usize, u * a[2] + v * b[2] + w * c[2]);
                if z <= depth[at] {
                    continue;
                }
                depth[at] = z;
                let normals = triangle.map(|p| mesh.normals[p as usize]);
                let normal: [f64; 3] =
                    std::array::from_fn(|k| u * normals[0][k] + v * normals[1][k] + w * normals[2][k]);
                let length = dot(normal, normal).sqrt().max(f64::MIN_POSITIVE);
                // Light from above and from the eye, on water.
                let light = 0.25 + 0.45 * (normal[2] / length).max(0.0) + 0.3 * (dot(normal, near) / length).abs();
                for (k, colour) in [90.0, 165.0, 235.0].into_iter().enumerate() {
                    pixels[3 * at + k] = (colour * light.min(1.0)) as u8;
                }
            }
        }
    }
    let image = BitMapElement::with_owned_buffer((0, 0), (width, height), pixels)
        .ok_or_else(|| anyhow!("the raster has the wrong size"))?;
    area.draw(&image).map_err(|e| anyhow!("cannot draw: {e}"))
}
