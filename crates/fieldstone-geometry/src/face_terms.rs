//! What one planar face contributes to the overlap with a ball, as a sum over its directed edges.

use crate::{Real, Vector};

/// Contribution of one planar face, for the ball of radius 1 around the origin.
///
/// With these for every face $f$ of a closed polyhedron, and $A_s$ the area of the sphere inside it,
///
/// $$ 3 V = \sum_f \left( d_f A_f + \Omega_f \right), \qquad A_s = \sum_f \Omega_f, \qquad
///    \frac{\partial V}{\partial c} = -\sum_f n_f A_f . $$
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceTerms<R> {
    /// $d$: signed distance of the face's plane from the centre, along the outward normal.
    pub distance: R,
    /// $A$: area of the face inside the ball; 0 exactly where they do not meet.
    pub area: R,
    /// $\Omega$: solid angle, with the sign of $d$, under which the centre sees the part of the face outside the ball.
    pub solid_angle: R,
}

/// Terms of the planar polygon `corners` with outward unit `normal`, for the unit ball around the origin.
///
/// The polygon is split into signed right triangles between the foot point $P$ of the centre on the plane, the
/// foot of each edge's line, and the points of the edge; each piece of an edge outside the ball adds
///
/// $$ A \mathrel{+}= \tfrac12 s^2 \Delta\varphi, \quad \Omega \mathrel{+}= d\,\Delta\varphi - \Delta G, \quad
///    \Delta\varphi = \operatorname{atan2}\bigl(h(b-a),\, h^2+ab\bigr), \quad
///    \Delta G = \operatorname{atan2}\bigl(hd(bR_a - aR_b),\, h^2R_aR_b + d^2ab\bigr) $$
///
/// and the piece inside adds $A \mathrel{+}= \tfrac12 h\,(b-a)$.
///
/// | symbol | meaning |
/// |---|---|
/// | $d$ | signed distance of the plane; $s^2 = 1 - d^2$ |
/// | $h$ | signed distance of $P$ from the edge's line, positive inside |
/// | $a, b$ | ends of the piece along the edge, measured from the foot of $P$ |
/// | $R_a, R_b$ | their distances from the centre |
///
/// Each term is continuous in the input, so nothing has to be classified consistently between faces, edges
/// and corners: a rounding error stays a rounding error. Two angles do jump, always together: where a face is
/// not cut ($|d| \ge 1$) its $\Delta\varphi$ and $\Delta G$ are taken from one complex quotient.
///
/// Preconditions: at least three corners, in one plane, counter-clockwise around `normal`; an edge of length
/// zero is passed over. Cost: two `atan2` per edge piece outside the ball.
///
/// ```
/// use fieldstone_geometry::{Vector, face_terms};
/// // A large square through the centre: the disc is inside, and half a turn of it outside is seen edge-on.
/// let square = [[-9., -9., 0.], [9., -9., 0.], [9., 9., 0.], [-9., 9., 0.]].map(Vector::<f64>::from_f64);
/// let terms = face_terms(Vector::new(0.0, 0.0, 1.0), &square);
/// assert!((terms.area - std::f64::consts::PI).abs() < 1e-15);
/// assert_eq!(terms.solid_angle, 0.0);
/// ```
pub fn face_terms<R: Real>(normal: Vector<R>, corners: &[Vector<R>]) -> FaceTerms<R> {
    let zero = R::from_f64(0.0);
    let one = R::from_f64(1.0);
    let half = R::from_f64(0.5);
    let distance = normal.dot(corners[0]);
    let mut doubt = Doubt::default();
    doubt.about_cut(distance);
    if distance.abs() >= one {
        let solid_angle = uncut_solid_angle(normal, distance, corners);
        return doubt.applied_to(FaceTerms { distance, area: zero, solid_angle });
    }

    let d = distance;
    let s2 = (one - d) * (one + d);
    // Sums over the edges; the angle around P is kept apart from the rest of the area.
    let mut triangles = zero;
    let mut turn = zero;
    let mut angle = zero;
    let mut any_inside = false;
    for_each_edge(normal, d, corners, |edge| {
        let half_chord2 = s2 - edge.h * edge.h;
        doubt.about_edge(edge.h, half_chord2);
        if half_chord2 <= zero {
            let (phi, g) = outside_piece(d, edge.h, edge.start, edge.end);
            turn = turn + phi;
            angle = angle + g;
            return;
        }
        let t = half_chord2.sqrt();
        let (a, b) = (edge.start.t, edge.end.t);
        doubt.about_order(a, t);
        doubt.about_order(b, t);
        if a < -t {
            let end = if b < -t { edge.end } else { EdgePoint { t: -t, r: one } };
            let (phi, g) = outside_piece(d, edge.h, edge.start, end);
            turn = turn + phi;
            angle = angle + g;
        }
        if b > t {
            let start = if a > t { edge.start } else { EdgePoint { t, r: one } };
            let (phi, g) = outside_piece(d, edge.h, start, edge.end);
            turn = turn + phi;
            angle = angle + g;
        }
        let (low, high) = (a.max(-t), b.min(t));
        if low < high {
            any_inside = true;
            triangles = triangles + edge.h * (high - low);
        }
    });

    let terms = if any_inside {
        FaceTerms { distance, area: half * (triangles + s2 * turn), solid_angle: d * turn - angle }
    } else {
        // No edge enters the ball: the turn is a whole number of times 2π, and the disc is in the face or not at all.
        let two_pi = R::from_f64(2.0) * R::pi();
        let turns = (turn / two_pi).to_f64();
        doubt.about_turns(turns, turn, s2);
        let turns = R::from_f64(turns.round());
        FaceTerms { distance, area: R::pi() * s2 * turns, solid_angle: d * two_pi * turns - angle }
    };
    doubt.applied_to(terms)
}

/// What the branches not taken would have given, where rounding leaves open which one is right.
///
/// Only numbers that know their error ([`Real::TRACKED`]) ask; for others all of this compiles to nothing. With δ the
/// distance from the decision plus the error of the number decided on, the two branches differ by
///
/// | decision | δ from | area | solid angle |
/// |---|---|---|---|
/// | the plane cuts the ball | abs(d) − 1 | disc: π s² ≤ 2πδ (1 + δ/2) | its cap: 2πδ |
/// | the edge's line enters the disc | t² = s² − h² | ≤ π t² | ≤ π t², as 1/R − 1 ≤ t² within the chord |
/// | P lies left or right of an edge outside | h | π h², since s² ≤ h² | 2π (1 − abs(d)) ≤ 2π h² |
/// | an end of the edge is inside | t ∓ a | ≤ δ | ≤ π δ |
/// | the disc is inside the face | turns | π s² | 2π s² |
///
/// and about twice that is added.
#[derive(Default)]
struct Doubt {
    area: f64,
    solid_angle: f64,
}

impl Doubt {
    #[inline(always)]
    fn add(&mut self, area: f64) {
        self.area += area;
        self.solid_angle += 2.0 * area;
    }

    #[inline(always)]
    fn about_cut<R: Real>(&mut self, d: R) {
        if R::TRACKED {
            let gap = (d.abs() - R::from_f64(1.0)).to_f64().abs();
            if gap <= d.error() {
                self.add(16.0 * (gap + d.error()));
            }
        }
    }

    #[inline(always)]
    fn about_edge<R: Real>(&mut self, h: R, half_chord2: R) {
        if R::TRACKED {
            let (size, error) = (h.to_f64().abs(), h.error());
            if size <= error {
                self.add(8.0 * (size + error) * (size + error));
            }
            let (gap, error) = (half_chord2.to_f64().abs(), half_chord2.error());
            if gap <= error {
                self.add(8.0 * (gap + error));
            }
        }
    }

    #[inline(always)]
    fn about_order<R: Real>(&mut self, a: R, t: R) {
        if R::TRACKED {
            let error = a.error() + t.error();
            let gap = (a.abs() - t).to_f64().abs();
            if gap <= error {
                self.add(4.0 * (gap + error));
            }
        }
    }

    #[inline(always)]
    fn about_turns<R: Real>(&mut self, turns: f64, turn: R, s2: R) {
        if R::TRACKED && (turns - turns.round()).abs() + turn.error() > 0.25 {
            self.add(8.0 * (s2.to_f64().abs() + s2.error()));
        }
    }

    #[inline(always)]
    fn applied_to<R: Real>(self, terms: FaceTerms<R>) -> FaceTerms<R> {
        if !R::TRACKED {
            return terms;
        }
        FaceTerms {
            area: terms.area.with_error(self.area),
            solid_angle: terms.solid_angle.with_error(self.solid_angle),
            ..terms
        }
    }
}

/// A point of an edge: `t` along it from the foot of P, and `r` from the centre.
#[derive(Clone, Copy)]
struct EdgePoint<R> {
    t: R,
    r: R,
}

/// A directed edge as P sees it.
struct Edge<R> {
    h: R,
    start: EdgePoint<R>,
    end: EdgePoint<R>,
}

#[inline]
fn for_each_edge<R: Real>(normal: Vector<R>, d: R, corners: &[Vector<R>], mut visit: impl FnMut(Edge<R>)) {
    let zero = R::from_f64(0.0);
    let Some(&last) = corners.last() else { return };
    let mut a = last;
    let d2 = d * d;
    for &b in corners {
        let along = b - a;
        let length = along.length();
        if length > zero {
            let e = along * (R::from_f64(1.0) / length);
            let h = a.dot(e.cross(normal));
            let (ta, tb) = (a.dot(e), b.dot(e));
            let beyond = d2 + h * h;
            let point = |t: R| EdgePoint { t, r: (beyond + t * t).sqrt() };
            visit(Edge { h, start: point(ta), end: point(tb) });
        }
        a = b;
    }
}

/// Numerator factor b R_a − a R_b of ΔG, without cancellation where both ends lie on one side of the foot.
#[inline]
fn leverage<R: Real>(beyond: R, a: EdgePoint<R>, b: EdgePoint<R>) -> R {
    let difference = b.t * a.r - a.t * b.r;
    if a.t * b.t > R::from_f64(0.0) {
        beyond * ((b.t - a.t) * (b.t + a.t)) / (b.t * a.r + a.t * b.r)
    } else {
        difference
    }
}

/// (Δφ, ΔG) of the piece of an edge from `a` to `b`, both outside the ball or on it.
#[inline]
fn outside_piece<R: Real>(d: R, h: R, a: EdgePoint<R>, b: EdgePoint<R>) -> (R, R) {
    let h2 = h * h;
    let d2 = d * d;
    let product = a.t * b.t;
    let phi = (h * (b.t - a.t)).atan2(h2 + product);
    let g = (h * d * leverage(d2 + h2, a, b)).atan2(h2 * (a.r * b.r) + d2 * product);
    (phi, g)
}

/// Solid angle under which the origin sees a planar polygon, positive where it looks at the polygon's back.
///
/// Around a point inside a closed polyhedron the faces add up to 4π, around one outside to 0, and around one on
/// a face to 2π: a face seen edge-on counts 0. Source: the uncut case of [`face_terms`].
pub fn polygon_solid_angle<R: Real>(normal: Vector<R>, corners: &[Vector<R>]) -> R {
    let distance = normal.dot(corners[0]);
    if distance == R::from_f64(0.0) { distance } else { uncut_solid_angle(normal, distance, corners) }
}

/// Solid angle of a polygon whose plane misses the ball, with the sign of `d`.
fn uncut_solid_angle<R: Real>(normal: Vector<R>, d: R, corners: &[Vector<R>]) -> R {
    let zero = R::from_f64(0.0);
    let distance = d.abs();
    let mut sum = zero;
    for_each_edge(normal, d, corners, |Edge { h, start: a, end: b }| {
        let h2 = h * h;
        let d2 = d * d;
        let product = a.t * b.t;
        let (zx, zy) = (h2 + product, h * (b.t - a.t));
        let (wx, wy) = (h2 * (a.r * b.r) + d2 * product, h * distance * leverage(d2 + h2, a, b));
        sum = sum + (zy * wx - zx * wy).atan2(zx * wx + zy * wy);
    });
    if d < zero { -sum } else { sum }
}
