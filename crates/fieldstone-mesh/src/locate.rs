//! Which cell holds a point?

use fieldstone_geometry::{Vector, polygon_solid_angle};
use glam::DVec3;

use crate::Mesh;

/// Turns below this are rounding; a corner shared by many cells still gives each of them more.
const LEAST_TURN: f64 = 1e-9;

impl Mesh {
    /// The cell with the largest winding number around `point`, the first of equal ones.
    ///
    /// Inside a cell the number is 1; on a common face 1/2 for both cells. A point that rounding puts between two
    /// cells therefore still gets one of them.
    pub(crate) fn locate_point(&self, point: DVec3, ring: &mut Vec<Vector<f64>>) -> Option<u32> {
        let mut best: Option<(u32, f64)> = None;
        self.tree.query(&self.bounds, point, point, |cell| {
            let turns = self.turns_around(cell as usize, point, ring);
            let better = match best {
                None => turns > LEAST_TURN,
                Some((other, most)) => turns > most + LEAST_TURN || (turns > most - LEAST_TURN && cell < other),
            };
            if better {
                best = Some((cell, turns));
            }
        });
        best.map(|(cell, _)| cell)
    }

    fn turns_around(&self, cell: usize, point: DVec3, ring: &mut Vec<Vector<f64>>) -> f64 {
        let outward = self.orientation(cell);
        let [low, high] = self.bounds[cell];
        let margin = 1e-12 * (high - low).max_element();
        if self.is_convex(cell) {
            let mut least = f64::INFINITY;
            for (face, sign) in self.signed_faces(cell) {
                for piece in self.surface.pieces(face) {
                    least = least.min(-outward * sign * self.surface.height(piece, point));
                }
            }
            if least.abs() > margin {
                return if least > 0.0 { 1.0 } else { 0.0 };
            }
        }
        let mut sum = 0.0;
        for (face, sign) in self.signed_faces(cell) {
            for piece in self.surface.pieces(face) {
                // A face that the point lies in takes no directions, and not half of all by the sign of a zero.
                if self.surface.height(piece, point).abs() <= margin {
                    continue;
                }
                ring.clear();
                ring.extend(self.surface.ring(piece).iter().map(|&k| {
                    let v = self.surface.vertices[k as usize] - point;
                    Vector::new(v.x, v.y, v.z)
                }));
                let n = self.surface.normal(piece);
                sum += sign * polygon_solid_angle(Vector::new(n.x, n.y, n.z), ring);
            }
        }
        outward * sum / (4.0 * std::f64::consts::PI)
    }
}
