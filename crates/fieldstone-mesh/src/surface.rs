//! Faces as planar pieces: each face that is not planar is fanned into triangles, once, for both its cells.

use std::ops::Range;

use fieldstone_geometry::{
    FaceTerms, PLANARITY, Vector, face_terms, polygon_area_vector, polygon_centroid, polygon_warp,
};
use glam::DVec3;

use crate::MeshParts;

/// What one face contributes to the overlap of a ball with its owner, in units of the ball's radius.
///
/// The neighbour gets the same with the other sign.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct FaceSum {
    /// Σ (d A + Ω) over the pieces.
    pub volume3: f64,
    /// Σ Ω.
    pub solid_angle: f64,
    /// Σ A, never negative.
    pub area: f64,
}

/// The planar pieces of all faces.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    /// The mesh's points, then the centroids that warped faces are fanned around.
    pub vertices: Vec<DVec3>,
    /// End of each face's pieces.
    face_ends: Vec<u32>,
    /// End of each piece's corners.
    piece_ends: Vec<u32>,
    corners: Vec<u32>,
    normals: Vec<DVec3>,
    /// Area-weighted centroid of each face.
    pub centroids: Vec<DVec3>,
    /// Area vector of each face.
    pub area_vectors: Vec<DVec3>,
    pub warped_faces: usize,
}

impl Surface {
    pub fn new(parts: &MeshParts) -> Self {
        let faces = parts.face_ends.len();
        let mut this = Self {
            vertices: parts.points.iter().map(|&p| DVec3::from(p)).collect(),
            face_ends: Vec::with_capacity(faces),
            piece_ends: Vec::with_capacity(faces),
            corners: Vec::with_capacity(parts.face_points.len()),
            normals: Vec::with_capacity(faces),
            centroids: Vec::with_capacity(faces),
            area_vectors: Vec::with_capacity(faces),
            warped_faces: 0,
        };
        let mut points = Vec::new();
        for face in 0..faces {
            let ring = parts.face(face);
            points.clear();
            points.extend(ring.iter().map(|&k| parts.points[k as usize]));
            let centroid = DVec3::from(polygon_centroid(&points));
            this.centroids.push(centroid);
            this.area_vectors.push(DVec3::from(polygon_area_vector(&points)));
            let diameter =
                points.iter().map(|&p| (DVec3::from(p) - DVec3::from(points[0])).length()).fold(0.0, f64::max);
            if polygon_warp(&points) <= PLANARITY * diameter {
                this.push_piece(ring);
            } else {
                this.warped_faces += 1;
                let apex = this.vertices.len() as u32;
                this.vertices.push(centroid);
                for (k, &a) in ring.iter().enumerate() {
                    this.push_piece(&[a, ring[(k + 1) % ring.len()], apex]);
                }
            }
            this.face_ends.push(this.piece_ends.len() as u32);
        }
        this
    }

    fn push_piece(&mut self, ring: &[u32]) {
        let points: Vec<[f64; 3]> = ring.iter().map(|&k| self.vertices[k as usize].to_array()).collect();
        // A piece without area has no normal and contributes nothing to either side.
        let Some(normal) = DVec3::from(polygon_area_vector(&points)).try_normalize() else { return };
        self.corners.extend_from_slice(ring);
        self.piece_ends.push(self.corners.len() as u32);
        self.normals.push(normal);
    }

    /// Pieces of a face.
    pub fn pieces(&self, face: usize) -> Range<usize> {
        let start = if face == 0 { 0 } else { self.face_ends[face - 1] as usize };
        start..self.face_ends[face] as usize
    }

    /// Corners of a piece.
    pub fn ring(&self, piece: usize) -> &[u32] {
        let start = if piece == 0 { 0 } else { self.piece_ends[piece - 1] as usize };
        &self.corners[start..self.piece_ends[piece] as usize]
    }

    /// Unit normal of a piece, out of the owner.
    pub fn normal(&self, piece: usize) -> DVec3 {
        self.normals[piece]
    }

    /// Signed distance of `point` from the plane of a piece, positive on the neighbour's side.
    pub fn height(&self, piece: usize, point: DVec3) -> f64 {
        self.normals[piece].dot(point - self.vertices[self.ring(piece)[0] as usize])
    }

    /// Contribution of `face` for the ball of radius 1/`scale` around `centre`.
    pub fn sum(&self, face: usize, centre: DVec3, scale: f64, ring: &mut Vec<Vector<f64>>) -> FaceSum {
        let mut sum = FaceSum::default();
        for piece in self.pieces(face) {
            ring.clear();
            ring.extend(self.ring(piece).iter().map(|&k| {
                let v = (self.vertices[k as usize] - centre) * scale;
                Vector::new(v.x, v.y, v.z)
            }));
            let n = self.normals[piece];
            let FaceTerms { distance, area, solid_angle } = face_terms(Vector::new(n.x, n.y, n.z), ring);
            sum.volume3 += distance * area + solid_angle;
            sum.solid_angle += solid_angle;
            sum.area += area;
        }
        sum
    }
}
