//! The faces of a mesh: crossed by segments, cutting balls.

use fieldstone_geometry::{Ball, Vector, face_terms};
use glam::DVec3;

use crate::{Faces, Mesh};

impl Faces for Mesh {
    fn face_count(&self) -> usize {
        self.parts().owner.len()
    }

    fn face_sides(&self, face: usize) -> [Option<u32>; 2] {
        [Some(self.parts().owner[face]), self.parts().neighbour.get(face).copied()]
    }

    fn face_vector(&self, face: usize) -> [f64; 3] {
        self.surface.area_vectors[face].to_array()
    }

    /// All corners are projected along the segment, each of them once and the same for all pieces that share it: a line
    /// that passes an edge within rounding is seen to pass exactly one of the two pieces.
    fn for_each_crossing(&self, start: [f64; 3], end: [f64; 3], visit: &mut dyn FnMut(u32, f64)) {
        let (start, end) = (DVec3::from(start), DVec3::from(end));
        let along = end - start;
        let length = along.length();
        if length == 0.0 {
            return;
        }
        let ahead = along / length;
        let (u, v) = ahead.any_orthonormal_pair();
        let (u, v) = if u.cross(v).dot(ahead) > 0.0 { (u, v) } else { (v, u) };
        let mut faces = Vec::new();
        self.tree.query(&self.bounds, start.min(end), start.max(end), |cell| {
            faces.extend_from_slice(self.cell_faces(cell as usize));
        });
        faces.sort_unstable();
        faces.dedup();
        for face in faces {
            let mut crossings = 0;
            for piece in self.surface.pieces(face as usize) {
                let at = |k: u32| {
                    let d = self.surface.vertices[k as usize] - start;
                    (u.dot(d), v.dot(d))
                };
                let ring = self.surface.ring(piece);
                let mut winding = 0;
                let mut a = at(ring[ring.len() - 1]);
                for &k in ring {
                    let b = at(k);
                    if (a.1 > 0.0) != (b.1 > 0.0) {
                        // Upwards counts +1 where the origin is to the left; ends in one order for both pieces.
                        let (low, high, way) = if a.1 > 0.0 { (b, a, -1) } else { (a, b, 1) };
                        if low.0 - low.1 * ((high.0 - low.0) / (high.1 - low.1)) > 0.0 {
                            winding += way;
                        }
                    }
                    a = b;
                }
                if winding != 0 {
                    let (before, after) = (self.surface.height(piece, start), self.surface.height(piece, end));
                    if (before > 0.0) != (after > 0.0) {
                        crossings += winding;
                    }
                }
            }
            if crossings != 0 {
                visit(face, f64::from(crossings));
            }
        }
    }

    fn for_each_cut(&self, ball: &Ball, visit: &mut dyn FnMut(u32, [f64; 3])) {
        let (centre, r) = (DVec3::from(ball.centre()), ball.radius());
        let mut faces = Vec::new();
        self.tree.query(&self.bounds, centre - r, centre + r, |cell| {
            faces.extend_from_slice(self.cell_faces(cell as usize));
        });
        faces.sort_unstable();
        faces.dedup();
        let mut ring = Vec::new();
        for face in faces {
            let mut vector = DVec3::ZERO;
            for piece in self.surface.pieces(face as usize) {
                if self.surface.height(piece, centre).abs() >= r {
                    continue;
                }
                ring.clear();
                ring.extend(self.surface.ring(piece).iter().map(|&k| {
                    let v = (self.surface.vertices[k as usize] - centre) / r;
                    Vector::new(v.x, v.y, v.z)
                }));
                let n = self.surface.normal(piece);
                vector += n * face_terms(Vector::new(n.x, n.y, n.z), &ring).area;
            }
            if vector != DVec3::ZERO {
                visit(face, (vector * (r * r)).to_array());
            }
        }
    }
}
