//! Axis-parallel box in mesh: the overlap volume with every cell, by clipping.

use glam::DVec3;

use crate::{Mesh, MeshScratch};

impl Mesh {
    /// Appends the volume of the box from `low` to `high` in each cell.
    ///
    /// The cell is the signed sum of tetrahedra between a point in the box and the triangles of its surface; the
    /// part of each in the box is found by clipping the triangle's shadow: the volume under a triangle, down to
    /// the box's bottom, is integrated over what is left of it after clipping by the four sides, with its height
    /// limited to the box.
    pub(crate) fn overlap_cuboid_volumes(
        &self,
        low: DVec3,
        high: DVec3,
        scratch: &mut MeshScratch,
        out: &mut Vec<(u32, f64)>,
    ) {
        let start = out.len();
        self.tree.query(&self.bounds, low, high, |cell| {
            let at = cell as usize;
            let [a, b] = self.bounds[at];
            let volume = if a.cmpge(low).all() && b.cmple(high).all() {
                self.cell_volumes()[at]
            } else {
                let outward = self.orientation(at);
                let mut sum = 0.0;
                for (face, sign) in self.signed_faces(at) {
                    for piece in self.surface.pieces(face) {
                        let ring = self.surface.ring(piece);
                        let corner = |k: usize| self.surface.vertices[ring[k] as usize];
                        for k in 1..ring.len() - 1 {
                            sum += sign
                                * volume_below(
                                    [corner(0), corner(k), corner(k + 1)],
                                    low,
                                    high,
                                    &mut scratch.polygon,
                                    &mut scratch.clipped,
                                );
                        }
                    }
                }
                let extent = (high - low).max(DVec3::ZERO);
                (outward * sum).clamp(0.0, self.cell_volumes()[at].min(extent.x * extent.y * extent.z))
            };
            if volume > 0.0 {
                out.push((cell, volume));
            }
        });
        out[start..].sort_unstable_by_key(|&(cell, _)| cell);
    }
}

/// Signed volume of the part of the box below a triangle: positive where the triangle faces up.
fn volume_below(
    triangle: [DVec3; 3],
    low: DVec3,
    high: DVec3,
    polygon: &mut Vec<DVec3>,
    clipped: &mut Vec<DVec3>,
) -> f64 {
    polygon.clear();
    polygon.extend_from_slice(&triangle);
    for axis in 0..2 {
        clip(polygon, clipped, axis, low[axis], 1.0);
        clip(polygon, clipped, axis, high[axis], -1.0);
    }
    // Above the box's top the height is the box's; between bottom and top it is the triangle's own; below, nothing.
    let mut volume = 0.0;
    let mut above = polygon.clone();
    clip(&mut above, clipped, 2, high.z, 1.0);
    volume += shadow_volume(&above, |_| high.z - low.z);
    clip(polygon, clipped, 2, high.z, -1.0);
    clip(polygon, clipped, 2, low.z, 1.0);
    volume += shadow_volume(polygon, |z| z - low.z);
    volume
}

/// Keeps the part of the polygon with side · (coordinate − at) ≥ 0.
fn clip(polygon: &mut Vec<DVec3>, clipped: &mut Vec<DVec3>, axis: usize, at: f64, side: f64) {
    clipped.clear();
    let Some(&last) = polygon.last() else { return };
    let mut a = last;
    for &b in polygon.iter() {
        let (da, db) = (side * (a[axis] - at), side * (b[axis] - at));
        if (da < 0.0) != (db < 0.0) {
            let mut cut = a + (b - a) * (da / (da - db));
            cut[axis] = at;
            clipped.push(cut);
        }
        if db >= 0.0 {
            clipped.push(b);
        }
        a = b;
    }
    std::mem::swap(polygon, clipped);
}

/// Integral of a height that is linear over the polygon, over its projection onto the x–y plane.
fn shadow_volume(polygon: &[DVec3], height: impl Fn(f64) -> f64) -> f64 {
    let mut sum = 0.0;
    if let Some((&apex, rest)) = polygon.split_first() {
        for pair in rest.windows(2) {
            let (a, b) = (pair[0] - apex, pair[1] - apex);
            let area = 0.5 * (a.x * b.y - a.y * b.x);
            sum += area * (height(apex.z) + height(pair[0].z) + height(pair[1].z)) / 3.0;
        }
    }
    sum
}
