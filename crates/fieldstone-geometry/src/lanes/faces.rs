//! [`crate::face_terms`] for batches of triangles and convex quadrilaterals.

use std::f64::consts::{PI, TAU};

use super::arctangent::atan2;
use super::lane::{Lane, Mask, Vectors, WIDTH};
use crate::FaceTerms;

/// A triangle or a convex quadrilateral, moved and scaled so that the ball is the unit ball around the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlaneFace<const N: usize> {
    /// Outward unit normal.
    pub normal: [f64; 3],
    /// Corners, counter-clockwise around the normal.
    pub corners: [[f64; 3]; N],
    /// 1 / length of the edge from each corner to the next.
    pub inverse_lengths: [f64; N],
}

/// Working memory for batches of faces with N corners, N being 3 or 4.
#[derive(Debug, Clone)]
pub(crate) struct FaceBatch<const N: usize> {
    faces: Vec<PlaneFace<N>>,
    terms: Vec<FaceTerms<f64>>,
    /// Faces whose edges enter the ball.
    cut: Vec<u32>,
}

impl<const N: usize> Default for FaceBatch<N> {
    fn default() -> Self {
        Self { faces: Vec::new(), terms: Vec::new(), cut: Vec::new() }
    }
}

impl<const N: usize> FaceBatch<N> {
    /// Forgets all faces, keeps the memory.
    pub fn clear(&mut self) {
        self.faces.clear();
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.faces.len()
    }

    /// Adds a face; its terms will be at the index that [`FaceBatch::len`] had before.
    #[inline]
    pub fn push(&mut self, face: PlaneFace<N>) {
        self.faces.push(face);
    }

    /// Terms of all faces, in the order in which they were added.
    ///
    /// The same numbers for a face whatever else is in the batch.
    pub fn evaluate(&mut self) -> &[FaceTerms<f64>] {
        pulp::Arch::new().dispatch(|| self.evaluate_in_lanes());
        &self.terms
    }

    #[inline(always)]
    fn evaluate_in_lanes(&mut self) {
        self.terms.clear();
        self.terms.resize(self.faces.len(), FaceTerms { distance: 0.0, area: 0.0, solid_angle: 0.0 });
        self.cut.clear();
        for start in (0..self.faces.len()).step_by(WIDTH) {
            let at: [usize; WIDTH] = std::array::from_fn(|k| (start + k).min(self.faces.len() - 1));
            let (terms, cut) = whole_faces(&Group::gather(&self.faces, at));
            for k in 0..WIDTH.min(self.faces.len() - start) {
                if cut.0[k] == 0 {
                    self.terms[start + k] = terms.lane(k);
                } else {
                    self.cut.push((start + k) as u32);
                }
            }
        }
        for chunk in self.cut.chunks(WIDTH) {
            let at: [usize; WIDTH] = std::array::from_fn(|k| chunk[k.min(chunk.len() - 1)] as usize);
            let terms = partly_inside(&Group::gather(&self.faces, at));
            for (k, &face) in chunk.iter().enumerate() {
                self.terms[face as usize] = terms.lane(k);
            }
        }
    }
}

/// Eight faces, number by number.
struct Group<const N: usize> {
    normal: Vectors,
    corners: [Vectors; N],
    inverse_lengths: [Lane; N],
    distance: Lane,
}

impl<const N: usize> Group<N> {
    #[inline(always)]
    fn gather(faces: &[PlaneFace<N>], at: [usize; WIDTH]) -> Self {
        let mut normal = Vectors::zero();
        let mut corners = [Vectors::zero(); N];
        let mut inverse_lengths = [Lane::splat(0.0); N];
        for (k, &index) in at.iter().enumerate() {
            let face = &faces[index];
            normal.set(k, face.normal);
            for c in 0..N {
                corners[c].set(k, face.corners[c]);
                inverse_lengths[c].0[k] = face.inverse_lengths[c];
            }
        }
        Self { normal, corners, inverse_lengths, distance: normal.dot(corners[0]) }
    }

    /// Distance of P from the line of an edge, and the edge's ends along it.
    #[inline(always)]
    fn edge(&self, k: usize) -> (Lane, Lane, Lane) {
        let (from, to) = (self.corners[k], self.corners[if k + 1 == N { 0 } else { k + 1 }]);
        let e = to.minus(from).times(self.inverse_lengths[k]);
        (from.dot(e.cross(self.normal)), from.dot(e), to.dot(e))
    }
}

struct TermLanes {
    distance: Lane,
    area: Lane,
    solid_angle: Lane,
}

impl TermLanes {
    #[inline(always)]
    fn lane(&self, k: usize) -> FaceTerms<f64> {
        FaceTerms { distance: self.distance.0[k], area: self.area.0[k], solid_angle: self.solid_angle.0[k] }
    }
}

/// Faces that no edge of theirs enters the ball, and which of the eight are not of that kind.
#[inline(always)]
fn whole_faces<const N: usize>(group: &Group<N>) -> (TermLanes, Mask) {
    let (zero, one) = (Lane::splat(0.0), Lane::splat(1.0));
    let d = group.distance;
    let s2 = (one - d) * (one + d);
    let mut entered = zero.less(zero);
    let mut inside = zero.less(one);
    for k in 0..N {
        let (h, a, b) = group.edge(k);
        let half_chord2 = s2 - h * h;
        let t = half_chord2.max(zero).sqrt();
        entered = entered.or(zero.less(half_chord2).and(a.less(t)).and((-t).less(b)));
        inside = inside.and(zero.less(h));
    }
    let cut = d.abs().less(one);
    let edge_on = d.abs().less(Lane::splat(0.5)).and(inside);
    let elsewhere = cut.and(entered.or(edge_on));

    // The whole polygon's solid angle, by a fan of triangles.
    let radius: [Lane; N] = std::array::from_fn(|k| group.corners[k].dot(group.corners[k]).sqrt());
    let apex = group.corners[0];
    let mut solid_angle = zero;
    for k in 1..N - 1 {
        let (b, c) = (group.corners[k], group.corners[k + 1]);
        let twice_area = b.minus(apex).cross(c.minus(apex)).dot(group.normal);
        let denominator = radius[0] * radius[k] * radius[k + 1]
            + apex.dot(b) * radius[k + 1]
            + b.dot(c) * radius[0]
            + c.dot(apex) * radius[k];
        solid_angle = solid_angle + atan2(d * twice_area, denominator);
    }
    let solid_angle = solid_angle + solid_angle;
    let disc = cut.and(inside);
    let cap = (one.with_sign_of(d) - d) * Lane::splat(TAU);
    let terms = TermLanes {
        distance: d,
        area: disc.select(Lane::splat(PI) * s2, zero),
        solid_angle: solid_angle - disc.select(cap, zero),
    };
    (terms, elsewhere)
}

/// Faces that the sphere cuts through their edges.
///
/// The two pieces of an edge outside the ball have angles below a quarter turn each, so their sum is the angle of one
/// complex product.
#[inline(always)]
fn partly_inside<const N: usize>(group: &Group<N>) -> TermLanes {
    let (zero, one) = (Lane::splat(0.0), Lane::splat(1.0));
    let d = group.distance;
    let d2 = d * d;
    let s2 = (one - d) * (one + d);
    let radius: [Lane; N] = std::array::from_fn(|k| group.corners[k].dot(group.corners[k]).sqrt());
    let (mut triangles, mut turn, mut angle) = (zero, zero, zero);
    for k in 0..N {
        let (h, a, b) = group.edge(k);
        let (ra, rb) = (radius[k], radius[if k + 1 == N { 0 } else { k + 1 }]);
        let h2 = h * h;
        let beyond = d2 + h2;
        let half_chord2 = s2 - h2;
        let meets = zero.less(half_chord2);
        let t = half_chord2.max(zero).sqrt();

        let piece = |p: Lane, rp: Lane, q: Lane, rq: Lane, exists: Mask| {
            let product = p * q;
            let one_side = zero.less(product);
            let far = q * rp;
            let near = p * rq;
            let denominator = one_side.select(far + near, one);
            let lever = one_side.select(beyond * ((q - p) * (q + p)) / denominator, far - near);
            let phi = (exists.select(h2 + product, one), exists.select(h * (q - p), zero));
            let g = (exists.select(h2 * (rp * rq) + d2 * product, one), exists.select(h * d * lever, zero));
            (phi, g)
        };
        // Before the chord, or all of the edge where its line misses the disc; behind the chord.
        let reaches = meets.and((-t).less(b));
        let (phi1, g1) = piece(a, ra, reaches.select(-t, b), reaches.select(one, rb), meets.not().or(a.less(-t)));
        let starts = a.less(t);
        let (phi2, g2) = piece(starts.select(t, a), starts.select(one, ra), b, rb, meets.and(t.less(b)));
        let times = |u: (Lane, Lane), v: (Lane, Lane)| (u.0 * v.0 - u.1 * v.1, u.0 * v.1 + u.1 * v.0);
        let (phi, g) = (times(phi1, phi2), times(g1, g2));
        turn = turn + atan2(phi.1, phi.0);
        angle = angle + atan2(g.1, g.0);

        let (low, high) = (a.max(-t), b.min(t));
        triangles = triangles + meets.and(low.less(high)).select(h * (high - low), zero);
    }
    TermLanes { distance: d, area: Lane::splat(0.5) * (triangles + s2 * turn), solid_angle: d * turn - angle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Vector, face_terms};

    /// SplitMix64, uniform in (−1, 1).
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = *state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn face<const N: usize>(corners: [[f64; 3]; N]) -> PlaneFace<N> {
        let at = |k: usize| Vector::<f64>::from_f64(corners[k % N]);
        let n = (at(1) - at(0)).cross(at(2) - at(0));
        let n = n * (1.0 / n.length());
        let inverse_lengths = std::array::from_fn(|k| 1.0 / (at(k + 1) - at(k)).length());
        PlaneFace { normal: [n.x, n.y, n.z], corners, inverse_lengths }
    }

    fn compare<const N: usize>(faces: &[PlaneFace<N>]) {
        let mut batch = FaceBatch::default();
        faces.iter().for_each(|&f| batch.push(f));
        let found = batch.evaluate();
        assert_eq!(found.len(), faces.len());
        for (terms, face) in found.iter().zip(faces) {
            let corners: Vec<Vector<f64>> = face.corners.iter().map(|&c| Vector::from_f64(c)).collect();
            let exact = face_terms(Vector::from_f64(face.normal), &corners);
            let size = corners.iter().map(|c| c.length()).fold(1.0, f64::max);
            assert!((terms.area - exact.area).abs() < 2e-14 * size, "{face:?}: {terms:?} {exact:?}");
            assert!((terms.solid_angle - exact.solid_angle).abs() < 2e-14 * size, "{face:?}: {terms:?} {exact:?}");
        }
    }

    #[test]
    fn random_triangles_and_parallelograms_agree_with_the_plain_kernel() {
        let mut state = 7;
        let mut point = |scale: f64| [(); 3].map(|()| scale * random(&mut state));
        let (mut triangles, mut quads) = (Vec::new(), Vec::new());
        for round in 0..20_000 {
            let scale = [0.3, 1.0, 3.0, 30.0][round % 4];
            let (a, u, v) = (point(f64::max(scale, 1.0)), point(scale), point(scale));
            let at = |p: f64, q: f64| [0, 1, 2].map(|k| a[k] + p * u[k] + q * v[k]);
            triangles.push(face([a, at(1.0, 0.0), at(0.0, 1.0)]));
            quads.push(face([a, at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]));
        }
        compare(&triangles);
        compare(&quads);
    }

    #[test]
    fn lattice_squares_with_every_kind_of_touching_agree_with_the_plain_kernel() {
        let mut squares = Vec::new();
        for d in [-1.5, -1.0, -0.6, 0.0, 0.25, 0.8, 1.0, 2.0] {
            for i in -8..8 {
                for j in -8..8 {
                    let (x, y) = (f64::from(i) * 0.2, f64::from(j) * 0.2);
                    for side in [0.2, 0.6, 2.4] {
                        squares.push(face([[x, y, d], [x + side, y, d], [x + side, y + side, d], [x, y + side, d]]));
                    }
                }
            }
        }
        compare(&squares);
    }

    #[test]
    fn a_face_gets_the_same_bits_in_any_company() {
        let mut state = 3;
        let faces: Vec<PlaneFace<3>> =
            (0..37).map(|_| face([(); 3].map(|()| [(); 3].map(|()| 2.0 * random(&mut state))))).collect();
        let mut batch = FaceBatch::default();
        faces.iter().for_each(|&f| batch.push(f));
        let together: Vec<FaceTerms<f64>> = batch.evaluate().to_vec();
        for (k, &alone) in faces.iter().enumerate() {
            batch.clear();
            batch.push(alone);
            assert_eq!(batch.evaluate()[0], together[k]);
        }
    }
}
