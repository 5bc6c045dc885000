//! Volumes of many overlaps at once: many balls in one element, many elements in one ball, or any pairs.

use glam::DVec3;

use crate::certified::{self, PROMISE, Wanted};
use crate::lanes::{FaceBatch, PlaneFace};
use crate::overlap::{Placement, placement};
use crate::{Ball, ErrorBound, FaceTerms, Polyhedron, Vector, face_terms, volume_from_terms};

/// Pairs whose faces are evaluated together: enough to fill lanes, few enough to stay in the cache.
const BLOCK: usize = 64;

/// Computes volumes of overlaps in batches, faces in lanes of eight; keeps its memory between calls.
///
/// The results keep the promise of [`crate::overlap_volume`] and agree with it to rounding: the angles come from another
/// arc tangent. A pair gets the same bits whatever else is in the batch.
///
/// ```
/// use fieldstone_geometry::{Ball, OverlapBatch, Polyhedron, overlap_volume};
/// let cube = Polyhedron::cuboid([0.0; 3], [1.0; 3])?;
/// let balls = [0.1, 0.3, 0.6].map(|r| Ball::new([0.9, 0.8, 0.5], r));
/// let balls = balls.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let mut volumes = [0.0; 3];
/// OverlapBatch::default().balls_in_element(&balls, &cube, &mut volumes);
/// for (ball, volume) in balls.iter().zip(volumes) {
///     assert!((volume - overlap_volume(ball, &cube)).abs() < 1e-15);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct OverlapBatch {
    triangles: FaceBatch<3>,
    quadrilaterals: FaceBatch<4>,
    /// Terms of faces that do not go into lanes.
    others: Vec<FaceTerms<f64>>,
    faces: Vec<FaceEntry>,
    pairs: Vec<PairEntry>,
    shifted: Vec<DVec3>,
    ring: Vec<Vector<f64>>,
    beyond_f64: u64,
    evaluated: u64,
}

#[derive(Debug, Clone, Copy)]
enum Slot {
    Triangle,
    Quadrilateral,
    Other,
}

#[derive(Debug, Clone, Copy)]
struct FaceEntry {
    slot: Slot,
    index: u32,
    flatness: f64,
    warp: f64,
}

#[derive(Debug, Clone, Copy)]
struct PairEntry {
    /// Where the result goes.
    at: usize,
    /// End of its faces.
    end: usize,
    /// Distance of the farthest corner, in radii.
    reach: f64,
}

impl OverlapBatch {
    /// Volume of each ball inside one element.
    ///
    /// # Panics
    /// Where `out` is shorter than `balls`.
    pub fn balls_in_element(&mut self, balls: &[Ball], element: &Polyhedron, out: &mut [f64]) {
        self.run(balls.len(), |k| (&balls[k], element), out);
    }

    /// Volume of one ball inside each element.
    ///
    /// # Panics
    /// Where `out` is shorter than `elements`.
    pub fn ball_in_elements(&mut self, ball: &Ball, elements: &[Polyhedron], out: &mut [f64]) {
        self.run(elements.len(), |k| (ball, &elements[k]), out);
    }

    /// Volume of the ball inside the element for each pair of indices into the two lists.
    ///
    /// # Panics
    /// Where an index is out of range, or `out` is shorter than `pairs`.
    pub fn pairs(&mut self, balls: &[Ball], elements: &[Polyhedron], pairs: &[(u32, u32)], out: &mut [f64]) {
        let pair = |k: usize| (&balls[pairs[k].0 as usize], &elements[pairs[k].1 as usize]);
        self.run(pairs.len(), pair, out);
    }

    /// Pairs evaluated so far, not counting those clearly apart or inside, and how many of them needed more digits than
    /// `f64` has.
    pub fn path_counts(&self) -> (u64, u64) {
        (self.evaluated, self.beyond_f64)
    }

    fn run<'a>(&mut self, count: usize, pair: impl Fn(usize) -> (&'a Ball, &'a Polyhedron), out: &mut [f64]) {
        assert!(out.len() >= count, "{} results do not fit into {} places", count, out.len());
        let mut next = 0;
        while next < count {
            self.triangles.clear();
            self.quadrilaterals.clear();
            self.others.clear();
            self.faces.clear();
            self.pairs.clear();
            while next < count && self.pairs.len() < BLOCK {
                let (ball, element) = pair(next);
                if let Some(volume) = self.push(next, ball, element) {
                    out[next] = volume;
                }
                next += 1;
            }
            self.finish(&pair, out);
        }
    }

    /// The volume, where it is clear at once; else the pair's faces join the batch.
    fn push(&mut self, at: usize, ball: &Ball, element: &Polyhedron) -> Option<f64> {
        match placement(ball, element) {
            Placement::Apart => return Some(0.0),
            Placement::AllOfPolyhedron => return Some(element.volume()),
            Placement::Unknown => {}
        }
        let centre = DVec3::from(ball.centre()) - element.origin();
        let scale = 1.0 / ball.radius();
        self.shifted.clear();
        self.shifted.extend(element.vertices().iter().map(|&v| (v - centre) * scale));
        if element.is_convex() {
            // Beside one plane by more than its rounding: apart. On the inner side of all: all of the ball.
            let mut nearest = f64::INFINITY;
            for (piece, corners) in element.rings() {
                nearest = nearest.min(piece.normal.dot(self.shifted[corners[0] as usize]));
            }
            if nearest <= -1.0 - 1e-9 {
                return Some(0.0);
            }
            if nearest >= 1.0 + 1e-9 {
                return Some(ball.volume().min(element.volume()));
            }
        }
        let farthest2 = self.shifted.iter().map(|v| v.length_squared()).fold(0.0, f64::max);
        let mut side = 0;
        for (piece, corners) in element.rings() {
            let inverse = &element.inverse_lengths[side..side + corners.len()];
            side += corners.len();
            let corner = |k: usize| self.shifted[corners[k] as usize].to_array();
            let length = |k: usize| inverse[k] * ball.radius();
            let normal = piece.normal.to_array();
            let (slot, index) = match corners.len() {
                3 => {
                    let (corners, inverse_lengths) = (std::array::from_fn(corner), std::array::from_fn(length));
                    self.triangles.push(PlaneFace { normal, corners, inverse_lengths });
                    (Slot::Triangle, self.triangles.len() - 1)
                }
                4 if piece.simple => {
                    let (corners, inverse_lengths) = (std::array::from_fn(corner), std::array::from_fn(length));
                    self.quadrilaterals.push(PlaneFace { normal, corners, inverse_lengths });
                    (Slot::Quadrilateral, self.quadrilaterals.len() - 1)
                }
                _ => {
                    self.ring.clear();
                    self.ring.extend((0..corners.len()).map(|k| Vector::from_f64(corner(k))));
                    self.others.push(face_terms(Vector::from_f64(normal), &self.ring));
                    (Slot::Other, self.others.len() - 1)
                }
            };
            let (flatness, warp) = (piece.flatness, piece.warp * scale);
            self.faces.push(FaceEntry { slot, index: index as u32, flatness, warp });
        }
        self.pairs.push(PairEntry { at, end: self.faces.len(), reach: farthest2.sqrt() });
        None
    }

    fn finish<'a>(&mut self, pair: &impl Fn(usize) -> (&'a Ball, &'a Polyhedron), out: &mut [f64]) {
        let triangles = self.triangles.evaluate();
        let quadrilaterals = self.quadrilaterals.evaluate();
        let mut start = 0;
        for entry in &self.pairs {
            let (ball, element) = pair(entry.at);
            let mut bound = ErrorBound::new(entry.reach);
            let (mut volume3, mut solid_angle, mut touched) = (0.0, 0.0, false);
            for face in &self.faces[start..entry.end] {
                let terms = match face.slot {
                    Slot::Triangle => triangles[face.index as usize],
                    Slot::Quadrilateral => quadrilaterals[face.index as usize],
                    Slot::Other => self.others[face.index as usize],
                };
                volume3 += terms.distance * terms.area + terms.solid_angle;
                solid_angle += terms.solid_angle;
                touched |= terms.area != 0.0;
                if terms.distance.abs() < 1.0 {
                    bound.add(terms.area.abs(), face.flatness, face.warp);
                }
            }
            start = entry.end;
            self.evaluated += 1;
            let smaller = ball.volume().min(element.volume());
            out[entry.at] = if bound.volume(ball.radius()) <= PROMISE * smaller {
                volume_from_terms(ball, element.volume(), volume3, solid_angle, touched)
            } else {
                self.beyond_f64 += 1;
                certified::beyond_f64(ball, element, Wanted::Volume).overlap.volume
            };
        }
    }
}
