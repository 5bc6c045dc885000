//! Sums over a polyhedron's edges inside the ball.

use std::f64::consts::{PI, TAU};

use super::arctangent::atan2;
use super::lane::Lanes;
use super::planes::height;
use crate::edge_frames::{Edge, EdgeFrames, Plane};

/// How much nearer than a corner to its foot an edge may be to the centre.
const EDGE_RATIO: f64 = 32.0;

/// Complex numbers below this have no angle that matters: see [`sums_inside`].
const VANISHING: f64 = 1e-60;

/// Products below this are scaled up: two more factors of some 1e-80 must not underflow.
const SMALL_PRODUCT: f64 = 1e-100;

/// Balls as the kernel wants them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedBalls<L> {
    /// Centre, relative to the polyhedron's origin.
    pub centre: [L; 3],
    /// 1 / radius.
    pub scale: L,
    /// Distance from a plane, in radii, below which rounding hides its side.
    pub resolution: L,
}

/// What [`sums_inside`] finds, in units of the ball's radius.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InsideSums<L: Lanes> {
    /// Three times the volume.
    pub volume3: L,
    /// $\sum_f (1 + A_f \kappa_f)$ over the faces in reach, see [`crate::ErrorBound`].
    pub sensitivity: L,
    /// $\sum_f A_f w_f$.
    pub warped_area: L,
    /// Whether a face is in the ball anywhere.
    pub touched: L::Mask,
    /// Whether the ball lies beyond one of the planes of a convex polyhedron.
    pub apart: L::Mask,
    /// Whether the centre is in the polyhedron.
    pub centre_inside: L::Mask,
    /// The least distance, squared, of the centre's foot from a corner, and 32 times that of the centre from an edge; 1 without any.
    pub nearest2: L,
}

/// The sum of angles, kept as a product of complex numbers and a count of turns.
#[derive(Clone, Copy)]
struct Turning<L> {
    re: L,
    im: L,
    turns: L,
}

impl<L: Lanes> Turning<L> {
    #[inline(always)]
    fn zero(like: L) -> Self {
        Self { re: like.like(1.0), im: like.like(0.0), turns: like.like(0.0) }
    }

    /// Adds the angle of `re` + i `im`, in (−π, π].
    ///
    /// Two angles above 0 of which the sum is below have gone past half a turn, and the other way round. By signs alone, so
    /// it is exact for the product as it is rounded. Two angles of exactly π make a whole turn, which the sign of the product
    /// does not show: that they are both beyond a quarter turn does.
    #[inline(always)]
    fn add(&mut self, re: L, im: L) {
        let (zero, one) = (re.like(0.0), re.like(1.0));
        let product = (self.re * re - self.im * im, self.re.mul_add(im, self.im * re));
        let (below, other, after) = (self.im.less(zero), im.less(zero), product.1.less(zero));
        let up = L::select(!below & !other & (after | (self.re.less(zero) & re.less(zero))), one, zero);
        let down = L::select(below & other & !after, one, zero);
        self.turns = self.turns + (up - down);
        (self.re, self.im) = product;
    }

    /// Scales the product to the size of 1 where it has become small.
    #[inline(always)]
    fn renormalise(&mut self) {
        let size = self.re.abs().max(self.im.abs());
        if L::any(size.less(size.like(SMALL_PRODUCT))) {
            let scale = size.inverse_power_of_two();
            (self.re, self.im) = (self.re * scale, self.im * scale);
        }
    }

    /// The vector whose angle is the sum but for whole turns: −0 would be the angle −π where the rule above has counted π.
    #[inline(always)]
    fn vector(&self) -> (L, L) {
        (self.im + self.im.like(0.0), self.re)
    }

    #[inline(always)]
    fn angle(&self, remainder: L) -> L {
        self.turns.mul_add(self.re.like(TAU), remainder)
    }
}

/// A piece as the ball sees it, and its sums.
///
/// Kept piece by piece. Arrays of one quantity each would be set by the compiler in registers of eight numbers, where the machine
/// has them: for a single ball that costs more than all of the arrays.
#[derive(Clone, Copy)]
#[repr(align(32))]
pub(crate) struct Face<L: Lanes> {
    pub distance: L,
    /// Whether the foot P of the centre is inside all edges.
    foot_inside: L::Mask,
    any_edge: bool,
    /// $\sum h (b - a)$.
    triangles: L,
    /// The product of the complex numbers whose angles are Δφ.
    turn: (L, L),
}

impl<L: Lanes> Face<L> {
    /// The vector whose angle is that of the turn: −0 would be the angle −π.
    #[inline(always)]
    fn vector(&self) -> (L, L) {
        (self.turn.1 + self.turn.1.like(0.0), self.turn.0)
    }

    /// $\sum \Delta\varphi$ over the pieces of edges inside the disc of a convex polygon.
    ///
    /// From outside, a convex polygon is seen under less than half a turn, so the angle of the product is the sum. From
    /// inside the sum is between 0 and a whole turn: it is the angle, or a turn more. Where the angle is near 0, so that rounding
    /// may have taken its sign, it is a turn more if the triangles have an area: their edges are not that near.
    #[inline(always)]
    fn turn(&self, angle: L) -> L {
        let (zero, tiny) = (angle.like(0.0), angle.like(1e-6));
        let more = angle.less(-tiny) | (angle.less(tiny) & tiny.less(self.triangles));
        angle + L::select(self.foot_inside & more, angle.like(TAU), zero)
    }
}

/// Angles of the turns of the first three pieces in reach, and of the sum over all.
#[inline(always)]
fn first_angles<L: Lanes, const N: usize>(faces: &[Face<L>; N], in_reach: u32, sum: &Turning<L>) -> [L; 4] {
    let first = in_reach;
    let second = first & first.wrapping_sub(1);
    let third = second & second.wrapping_sub(1);
    // Where there are less than three, the angle of some other is found in vain.
    let (a, b) =
        (faces[first.trailing_zeros() as usize % N].vector(), faces[second.trailing_zeros() as usize % N].vector());
    let (c, d) = (faces[third.trailing_zeros() as usize % N].vector(), sum.vector());
    L::arc_tangents([a.0, b.0, c.0, d.0], [a.1, b.1, c.1, d.1])
}

/// Volume and error bound of unit balls with a polyhedron of up to N pieces, from the parts of its edges inside.
///
/// [`crate::face_terms`] adds up the solid angle Ω of the faces *outside* the ball, for which every face is needed. Around a
/// closed polyhedron the whole faces make 4π with the centre inside and 0 without, so with Ω′ the solid angle of what is
/// *inside*,
///
/// $$ 3 V = 4\pi\,[0 \in \text{polyhedron}] + \sum_f (d_f A_f - \Omega'_f), $$
///
/// and faces out of reach contribute nothing. With P the foot of the centre on the plane, w = 1 with P in the face and
/// 0 without, and the sums over the pieces of edges inside the ball,
///
/// $$ A = \tfrac12 \sum h\,(b-a) + \tfrac12 s^2 \bigl(2\pi w - \sum \Delta\varphi\bigr), \qquad
///    \operatorname{sgn}(d)\,\Omega' = \sum (\Delta\varphi - \Delta G) + (1 - |d|) \bigl(2\pi w - \sum \Delta\varphi\bigr), $$
///
/// in the notation of `face_terms`, ΔG with |d|. Angles that are summed with one factor are multiplied as complex numbers: one arc
/// tangent per face and one for all. What belongs to the edge alone (ends of the piece inside, their distances, the lever
/// $b R_a - a R_b$) is computed once for both of its faces.
///
/// Unlike there, the terms are not continuous: they jump where the centre passes through a face, all together and
/// by a whole turn. That is sound only while it is beyond doubt which face the centre passes, so not where it is near an edge:
/// `nearest2` tells, and is 0 on more than one plane at once (an edge's line, or a polyhedron without thickness), and where a sum near 0 hides whether the centre is in a polyhedron that is not convex. Where h and d are both near zero, so is the number whose angle ΔG is, while |ΔG| ≤ |d Δφ|: it is left out.
///
/// Source: derived here; products of angles with turns counted by signs.
#[inline(always)]
pub(crate) fn sums_inside<L: Lanes, const N: usize>(
    frames: &EdgeFrames,
    convex: bool,
    balls: &PlacedBalls<L>,
) -> InsideSums<L> {
    let scale = balls.scale;
    let (zero, one) = (scale.like(0.0), scale.like(1.0));
    let (no, yes) = (zero.less(zero), zero.less(one));
    let mut faces = [Face { distance: one, foot_inside: yes, any_edge: false, triangles: zero, turn: (one, zero) }; N];
    let seen = L::planes(frames, balls, &mut faces);
    // A bit for each edge of one piece that any of the balls reaches, and for those of two.
    let (mut of_one, mut of_two) = (0u64, 0u64);
    let mut pieces = seen.in_reach;
    while pieces != 0 {
        let edges = frames.planes[pieces.trailing_zeros() as usize % N].edges;
        pieces &= pieces - 1;
        of_two |= of_one & edges;
        of_one |= edges;
    }
    // The foot on a piece cannot be beyond an edge to one out of reach, where edges are sharp and the ball is not apart: but if
    // that is hidden by rounding, nothing is sure.
    of_one = if frames.sharp { 0 } else { of_one & !of_two };
    let doubtful = seen.unresolved | if frames.sharp { seen.beyond } else { no };
    let mut sums = InsideSums {
        volume3: zero,
        sensitivity: zero,
        warped_area: zero,
        touched: no,
        apart: if convex { seen.apart } else { no },
        centre_inside: seen.centre_inside,
        nearest2: L::select(doubtful, zero, one),
    };
    let mut angle = Turning::zero(scale);
    let mut any_edge = false;
    // An edge inside the ball has both of its planes in reach; any other only tells where the foot on its piece is.
    while of_one != 0 {
        let [first, second] = &frames.edges[of_one.trailing_zeros() as usize].sides;
        of_one &= of_one - 1;
        let side = if seen.in_reach >> first.piece & 1 == 1 { first } else { second };
        let face = &mut faces[side.piece as usize % N];
        face.foot_inside = face.foot_inside & !height(side.offset, &side.outward, balls).less(zero);
    }
    while of_two != 0 {
        let edge = &frames.edges[of_two.trailing_zeros() as usize];
        of_two &= of_two - 1;
        any_edge |= add_edge(edge, balls, &mut faces, &mut angle, &mut sums.nearest2);
    }
    let mut first = [zero; 4];
    if any_edge {
        if L::FOUR_AT_ONCE {
            first = first_angles(&faces, seen.in_reach, &angle);
        } else {
            let (y, x) = angle.vector();
            first[3] = atan2(y, x);
        }
    }
    let (mut pieces, mut count) = (seen.in_reach, 0);
    while pieces != 0 {
        let k = pieces.trailing_zeros() as usize % N;
        pieces &= pieces - 1;
        let face = &faces[k];
        let turn = if !face.any_edge {
            zero
        } else if L::FOUR_AT_ONCE && count < 3 {
            first[count]
        } else {
            let (y, x) = face.vector();
            atan2(y, x)
        };
        count += 1;
        add_face(face, turn, &frames.planes[k], scale, &mut sums);
    }
    if any_edge {
        sums.volume3 = sums.volume3 - angle.angle(first[3]);
    }
    if !convex {
        // Without the 4π of a centre inside the sum lies between −4π and 0, otherwise between 0 and 4π.
        let undecided = sums.volume3.abs().less(scale.like(1e-9));
        sums.centre_inside = sums.volume3.less(zero);
        sums.nearest2 = L::select(undecided, zero, sums.nearest2);
    }
    sums.volume3 = sums.volume3 + L::select(sums.centre_inside, scale.like(4.0 * PI), zero);
    sums
}

/// An edge as seen from a ball that it enters.
struct Nearby<L> {
    /// Distance of the centre from either plane.
    d: [L; 2],
    /// Distance of its foot on either plane from the edge's line.
    h: [L; 2],
    /// Ends of the edge, measured along it from the foot.
    a: L,
    b: L,
}

/// Measures an edge from the corner of it that is nearer to the centre.
///
/// The angles at points near the edge or its ends would magnify the rounding of distances from a corner far away, or of two
/// planes that do not meet in quite the same line: so the second plane's are those of the first, turned.
#[inline(always)]
fn nearby<L: Lanes>(edge: &Edge, balls: &PlacedBalls<L>) -> Nearby<L> {
    let (scale, length) = (balls.scale, balls.scale.like(edge.length));
    let (x, y) = (offset_from(edge.ends[0], balls), offset_from(edge.ends[1], balls));
    let second = dot(&edge.along, &x).less(length * length.like(-0.5));
    let x = [L::select(second, y[0], x[0]), L::select(second, y[1], x[1]), L::select(second, y[2], x[2])];
    let along = dot(&edge.along, &x);
    let a = L::select(second, along - length, along) * scale;
    let b = L::select(second, along, along + length) * scale;
    let (d, h) = (dot(&edge.normal, &x) * scale, dot(&edge.sides[0].outward, &x) * scale);
    let [[normal_d, normal_h], [outward_d, outward_h]] = edge.rotation;
    let turned = scale.like(normal_d).mul_add(d, scale.like(normal_h) * h);
    let other = scale.like(outward_d).mul_add(d, scale.like(outward_h) * h);
    Nearby { d: [d, turned], h: [h, other], a, b }
}

/// point − centre.
#[inline(always)]
fn offset_from<L: Lanes>(point: [f64; 3], balls: &PlacedBalls<L>) -> [L; 3] {
    let [x, y, z] = balls.centre;
    [x.like(point[0]) - x, y.like(point[1]) - y, z.like(point[2]) - z]
}

#[inline(always)]
fn dot<L: Lanes>(direction: &[f64; 3], v: &[L; 3]) -> L {
    let [x, y, z] = *v;
    z.like(direction[2]).mul_add(z, y.like(direction[1]).mul_add(y, x.like(direction[0]) * x))
}

/// Adds an edge to the sums of its faces; whether any of it is inside a ball.
#[inline(always)]
fn add_edge<L: Lanes, const N: usize>(
    edge: &Edge,
    balls: &PlacedBalls<L>,
    faces: &mut [Face<L>; N],
    angle: &mut Turning<L>,
    nearest2: &mut L,
) -> bool {
    let scale = balls.scale;
    let (zero, one) = (scale.like(0.0), scale.like(1.0));
    let [first, second] = &edge.sides;
    let (i, j) = (first.piece as usize % N, second.piece as usize % N);
    let mut h = [height(first.offset, &first.outward, balls), height(second.offset, &second.outward, balls)];
    let d = faces[i].distance;
    let entered = L::reaches(d) & L::reaches(faces[j].distance) & zero.less((one - d).mul_add(one + d, -(h[0] * h[0])));
    let mut d = [d, faces[j].distance];
    let (mut a, mut b) = (zero, zero);
    if L::any(entered) {
        let near = nearby(edge, balls);
        d = [L::select(entered, near.d[0], d[0]), L::select(entered, near.d[1], d[1])];
        h = [L::select(entered, near.h[0], h[0]), L::select(entered, near.h[1], h[1])];
        (a, b) = (near.a, near.b);
    }
    faces[i].foot_inside = faces[i].foot_inside & !h[0].less(zero);
    faces[j].foot_inside = faces[j].foot_inside & !h[1].less(zero);
    let h2 = h[0] * h[0];
    let half_chord2 = (one - d[0]).mul_add(one + d[0], -h2);
    let entered = entered & zero.less(half_chord2);
    let t = half_chord2.max(zero).sqrt();
    let (low, high) = (a.max(-t), b.min(t));
    let inside = entered & low.less(high);
    if !L::any(inside) {
        return false;
    }
    let beyond = d[0].mul_add(d[0], h2);
    let nearest = low.max(high.min(zero));
    let corner = a.abs().min(b.abs());
    let to_corner2 = corner.mul_add(corner, h2.min(h[1] * h[1]));
    let to_edge2 = nearest.mul_add(nearest, beyond) * scale.like(EDGE_RATIO * EDGE_RATIO);
    *nearest2 = L::select(inside, nearest2.min(to_edge2.min(to_corner2)), *nearest2);

    let (r_low, r_high) = (low.mul_add(low, beyond).sqrt(), high.mul_add(high, beyond).sqrt());
    let width = high - low;
    let product = low * high;
    // The difference high · r_low − low · r_high cancels where both ends lie on one side of the foot: there it is a quotient,
    // of which the divisor multiplies the other part of the complex number instead.
    let one_side = zero.less(product);
    let (far, close) = (high * r_low, low * r_high);
    let (mut divisor, mut lever) = (one, far - close);
    if L::any(one_side) {
        divisor = L::select(one_side, (far + close).abs(), divisor);
        lever = L::select(one_side, beyond * width * (high + low).abs(), lever);
    }
    let radii = r_low * r_high;

    for (at, h, d) in [(i, h[0], d[0].abs()), (j, h[1], d[1].abs())] {
        let face = &mut faces[at];
        let h2 = h * h;
        let z = (h2 + product, h * width);
        let w = (h2.mul_add(radii, d * d * product).mul_add(divisor, scale.like(VANISHING)), h * d * lever);
        let difference = (z.0.mul_add(w.0, z.1 * w.1), z.1 * w.0 - z.0 * w.1);
        let signed = L::select(face.distance.less(zero), -difference.1, difference.1);
        let z = (L::select(inside, z.0, one), L::select(inside, z.1, zero));
        let t = face.turn;
        face.any_edge = true;
        face.triangles = face.triangles + z.1;
        face.turn = (t.0 * z.0 - t.1 * z.1, t.0.mul_add(z.1, t.1 * z.0));
        angle.add(L::select(inside, difference.0, one), L::select(inside, signed, zero));
    }
    angle.renormalise();
    true
}

/// Adds a piece to the sums, given the angle of its turn where it has edges in the ball.
#[inline(always)]
fn add_face<L: Lanes>(face: &Face<L>, angle: L, plane: &Plane, scale: L, sums: &mut InsideSums<L>) {
    let (zero, one) = (scale.like(0.0), scale.like(1.0));
    let d = face.distance;
    let reached = L::reaches(d);
    let to_pole = one - d.abs();
    let s2 = to_pole * (one + d.abs());
    let whole = L::select(face.foot_inside, scale.like(TAU), zero);
    let rest = if face.any_edge { whole - face.turn(angle) } else { whole };
    let area = scale.like(0.5) * s2.mul_add(rest, face.triangles);
    let area = L::select(reached, area.max(zero), zero);
    let rest = L::select(reached, rest, zero);
    let flat = to_pole * rest;
    sums.volume3 = sums.volume3 + d.mul_add(area, L::select(d.less(zero), flat, -flat));
    let meets = zero.less(area);
    sums.touched = sums.touched | meets;
    sums.sensitivity = sums.sensitivity + L::select(meets, scale.like(plane.flatness).mul_add(area, one), zero);
    sums.warped_area = scale.like(plane.warp).mul_add(area * scale, sums.warped_area);
}

#[cfg(test)]
mod tests {
    use pulp::Scalar;

    use super::super::lane::{OneNumber, Register};
    use super::*;

    fn sum(factors: &[(f64, f64)]) -> f64 {
        let number = |x| Register::splat(Scalar, x);
        let mut turning = Turning::zero(number(0.0));
        for &(re, im) in factors {
            turning.add(number(re), number(im));
        }
        let (y, x) = turning.vector();
        turning.angle(atan2(y, x)).number()
    }

    #[test]
    fn angles_of_exactly_half_a_turn_add_up_to_whole_turns() {
        for zero in [0.0, -0.0] {
            assert_eq!(sum(&[(-2.0, zero)]), PI);
            assert_eq!(sum(&[(-1.0, 0.0), (-1.0, zero)]), TAU);
            assert_eq!(sum(&[(0.0, 1.0), (0.0, 3.0), (-1.0, zero)]), TAU);
            assert_eq!(sum(&[(0.0, -1.0), (0.0, -3.0)]), -PI);
            assert_eq!(sum(&[(0.0, 1.0), (1.0, zero), (0.0, -1.0)]), 0.0);
        }
    }

    #[test]
    fn products_of_small_whole_numbers_never_lose_a_turn() {
        // All signs, all zeros: against the sum of the arc tangents.
        let numbers: Vec<(f64, f64)> = (-3..=3)
            .flat_map(|x| (-3..=3).map(move |y| (f64::from(x), f64::from(y))))
            .filter(|&z| z != (0.0, 0.0))
            .collect();
        for &a in &numbers {
            for &b in &numbers {
                for &c in &numbers {
                    let expected = [a, b, c].iter().map(|z| z.1.atan2(z.0)).sum::<f64>();
                    let found = sum(&[a, b, c]);
                    assert!((found - expected).abs() < 1e-14, "{a:?} {b:?} {c:?}: {found} for {expected}");
                }
            }
        }
    }
}
