//! Faces as planar pieces: each face that is not planar is fanned into triangles, once, for both its cells.

use std::ops::Range;

use fieldstone_geometry::{
    FaceTerms, PLANARITY, Vector, face_terms, flatness, is_exactly_planar, polygon_area_vector, polygon_centroid,
    polygon_warp,
};
use glam::DVec3;

use crate::MeshParts;
use crate::face_inside::face_inside;

/// Sine of the least angle at a corner of a piece for it to count as convex.
const LEAST_BEND: f64 = 1e-6;

/// What one face contributes to the overlap of a ball with its owner, in units of the ball's radius.
///
/// The neighbour gets the same with the other sign. With Ω the solid angle under which the centre sees what of the
/// face is outside the ball ([`Surface::sum`]), or minus the one of what is inside ([`Surface::sum_inside`]).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct FaceSum {
    /// Σ (d A + Ω) over the pieces.
    pub volume3: f64,
    /// Σ Ω.
    pub solid_angle: f64,
    /// Σ A, never negative.
    pub area: f64,
    /// Least and largest d of the pieces; positive with the centre on the owner's side. [`Surface::sum_inside`] only.
    pub distances: [f64; 2],
    /// The largest 1/δ over edges inside the ball, see [`face_inside`]; 0 without any. [`Surface::sum_inside`] only.
    pub nearness: f64,
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
    /// Of each piece: a corner, and the unit normal out of the owner. Side by side, because every cell in reach of a
    /// ball is asked for its distance from the planes, and most for nothing else.
    planes: Vec<(DVec3, DVec3)>,
    /// Whether a piece turns left at every corner, by more than rounding.
    convex: Vec<bool>,
    /// Largest flatness and warp of each face's pieces, for the bound of the rounding error.
    pub shapes: Vec<[f64; 2]>,
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
            planes: Vec::with_capacity(faces),
            convex: Vec::with_capacity(faces),
            shapes: Vec::with_capacity(faces),
            centroids: Vec::with_capacity(faces),
            area_vectors: Vec::with_capacity(faces),
            warped_faces: 0,
        };
        let mut points = Vec::new();
        for face in 0..faces {
            let ring = parts.face(face);
            this.shapes.push([1.0, 0.0]);
            points.clear();
            points.extend(ring.iter().map(|&k| parts.points[k as usize]));
            let centroid = DVec3::from(polygon_centroid(&points));
            this.centroids.push(centroid);
            this.area_vectors.push(DVec3::from(polygon_area_vector(&points)));
            if polygon_warp(&points) <= PLANARITY * extent(&points) || is_exactly_planar(&points) {
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
        if let Some([flattest, warp]) = self.shapes.last_mut() {
            *flattest = flattest.max(flatness(&points));
            // Exactness costs more than it gains here: a face within rounding of its plane keeps that rounding.
            if ring.len() > 3 {
                *warp = warp.max(polygon_warp(&points) + 8.0 * f64::EPSILON * extent(&points));
            }
        }
        self.corners.extend_from_slice(ring);
        self.piece_ends.push(self.corners.len() as u32);
        self.planes.push((self.vertices[ring[0] as usize], normal));
        let n = ring.len();
        let side = |k: usize| self.vertices[ring[(k + 1) % n] as usize] - self.vertices[ring[k % n] as usize];
        self.convex.push((0..n).all(|k| {
            let (a, b) = (side(k), side(k + 1));
            normal.dot(a.cross(b)) > LEAST_BEND * a.length() * b.length()
        }));
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
        self.planes[piece].1
    }

    /// Signed distance of `point` from the plane of a piece, positive on the neighbour's side.
    pub fn height(&self, piece: usize, point: DVec3) -> f64 {
        let (corner, normal) = self.planes[piece];
        normal.dot(point - corner)
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
            let n = self.planes[piece].1;
            let FaceTerms { distance, area, solid_angle } = face_terms(Vector::new(n.x, n.y, n.z), ring);
            sum.volume3 += distance * area + solid_angle;
            sum.solid_angle += solid_angle;
            sum.area += area;
        }
        sum
    }

    /// As [`Surface::sum`], from what of `face` is inside the ball: a face that the ball does not reach costs a
    /// product per edge at most.
    ///
    /// `None` where the centre, or its foot on a plane, is too near an edge or a corner for that (see
    /// [`face_inside`]), and for pieces that are not convex.
    pub fn sum_inside(
        &self,
        face: usize,
        centre: DVec3,
        radius: f64,
        scale: f64,
        ring: &mut Vec<DVec3>,
    ) -> Option<FaceSum> {
        let mut sum = FaceSum { distances: [f64::INFINITY, f64::NEG_INFINITY], ..FaceSum::default() };
        for piece in self.pieces(face) {
            let (corner, normal) = self.planes[piece];
            let distance = normal.dot(corner - centre) * scale;
            sum.distances = [sum.distances[0].min(distance), sum.distances[1].max(distance)];
            if distance.abs() >= 1.0 {
                continue;
            }
            let corners = self.ring(piece);
            // Most pieces whose plane cuts the ball are themselves beside it.
            if self.beside(corners, centre, radius) {
                continue;
            }
            if !self.convex[piece] {
                return None;
            }
            ring.clear();
            ring.extend(corners.iter().map(|&k| (self.vertices[k as usize] - centre) * scale));
            let terms = face_inside(normal, distance, ring)?;
            sum.volume3 += terms.volume3;
            sum.solid_angle += terms.solid_angle;
            sum.area += terms.area;
            sum.nearness = sum.nearness.max(terms.nearness);
        }
        Some(sum)
    }

    /// Whether the box around some vertices misses the ball.
    fn beside(&self, corners: &[u32], centre: DVec3, radius: f64) -> bool {
        let (low, high) = corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &k| {
            let v = self.vertices[k as usize];
            (low.min(v), high.max(v))
        });
        (centre - centre.clamp(low, high)).length_squared() >= radius * radius
    }

    /// How often the ray from `point` along +x leaves the owner through `face`, minus how often it enters.
    ///
    /// Summed over a closed cell, the number of times that it winds around the point: exact, because the two pieces
    /// that share an edge see the very same rounded crossing. The point must not be on the face.
    pub fn crossings(&self, face: usize, point: DVec3) -> i32 {
        let mut sum = 0;
        for piece in self.pieces(face) {
            let ring = self.ring(piece);
            let at = |k: u32| self.vertices[k as usize] - point;
            let mut winding = 0;
            let (mut any_ahead, mut any_behind) = (false, false);
            let mut a = at(ring[ring.len() - 1]);
            for &k in ring {
                let b = at(k);
                if b.x > 0.0 {
                    any_ahead = true;
                } else {
                    any_behind = true;
                }
                if (a.y > 0.0) != (b.y > 0.0) {
                    let (low, high, way) = if a.y > 0.0 { (b, a, 1) } else { (a, b, -1) };
                    if low.z - low.y * ((high.z - low.z) / (high.y - low.y)) > 0.0 {
                        winding += way;
                    }
                }
                a = b;
            }
            if winding != 0 {
                let (corner, normal) = self.planes[piece];
                let ahead =
                    if any_ahead && any_behind { normal.dot(corner - point) * normal.x > 0.0 } else { any_ahead };
                sum += if ahead { winding } else { 0 };
            }
        }
        sum
    }
}

/// Largest distance of a corner from the first.
fn extent(points: &[[f64; 3]]) -> f64 {
    points.iter().map(|&p| (DVec3::from(p) - DVec3::from(points[0])).length()).fold(0.0, f64::max)
}
