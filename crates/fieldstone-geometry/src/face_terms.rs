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
/// and corners: a rounding error stays a rounding error.
///
/// Where no edge enters the ball the disc is in the polygon or not at all, and the solid angle is the whole
/// polygon's ([`polygon_solid_angle`]) less the disc's, $2\pi(1 - |d|)$.
///
/// Preconditions: at least three corners, in one plane, counter-clockwise around `normal`; an edge of length
/// zero is passed over; fewer corners panic. Cost: two `atan2` per edge piece outside the ball where an edge enters it, else one per
/// triangle of a fan.
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
    // By the nearest corner: the rounding of the distance grows with that of the corner it is measured by.
    let nearest = corners.iter().fold((corners[0], corners[0].dot(corners[0])), |(best, least), &corner| {
        let r2 = corner.dot(corner);
        if r2 < least { (corner, r2) } else { (best, least) }
    });
    let d = normal.dot(nearest.0);
    let mut doubt = Doubt::default();
    doubt.about_cut(d);
    if d.abs() >= one {
        let solid_angle = polygon_solid_angle(normal, corners);
        return doubt.applied_to(FaceTerms { distance: d, area: zero, solid_angle });
    }
    let s2 = (one - d) * (one + d);
    let edge = |k: usize| Edge::new(normal, corners[k], corners[if k + 1 == corners.len() { 0 } else { k + 1 }]);
    let mut stack = [const { None }; ON_STACK];
    let heap: Vec<Option<Edge<R>>>;
    let edges: &[Option<Edge<R>>] = if corners.len() <= ON_STACK {
        stack.iter_mut().take(corners.len()).enumerate().for_each(|(k, slot)| *slot = edge(k));
        &stack[..corners.len()]
    } else {
        heap = (0..corners.len()).map(edge).collect();
        &heap
    };
    for edge in edges.iter().flatten() {
        doubt.about_edge(edge, s2);
    }
    let terms = if edges.iter().flatten().any(|edge| edge.enters(s2)) {
        partly_inside(d, s2, edges, &mut doubt)
    } else {
        no_edge_inside(d, s2, normal, corners, edges, &mut doubt)
    };
    doubt.applied_to(terms)
}

/// Edges of a polygon that are kept without an allocation.
const ON_STACK: usize = 8;

/// A directed edge as P sees it.
#[derive(Clone, Copy)]
struct Edge<R> {
    /// Signed distance of P from the line.
    h: R,
    /// Ends, measured along the line from the foot of P.
    a: R,
    b: R,
}

impl<R: Real> Edge<R> {
    #[inline]
    fn new(normal: Vector<R>, from: Vector<R>, to: Vector<R>) -> Option<Self> {
        let along = to - from;
        let length = along.length();
        if length <= R::from_f64(0.0) {
            return None;
        }
        let e = along * (R::from_f64(1.0) / length);
        Some(Self { h: from.dot(e.cross(normal)), a: from.dot(e), b: to.dot(e) })
    }

    /// Whether a part of the edge lies in the disc of squared radius `s2` around P.
    #[inline]
    fn enters(&self, s2: R) -> bool {
        let half_chord2 = s2 - self.h * self.h;
        if half_chord2 <= R::from_f64(0.0) {
            return false;
        }
        let t = half_chord2.sqrt();
        self.a < t && self.b > -t
    }
}

/// A point of an edge: `t` along it from the foot of P, and `r` from the centre.
#[derive(Clone, Copy)]
struct EdgePoint<R> {
    t: R,
    r: R,
}

fn partly_inside<R: Real>(d: R, s2: R, edges: &[Option<Edge<R>>], doubt: &mut Doubt) -> FaceTerms<R> {
    let zero = R::from_f64(0.0);
    let one = R::from_f64(1.0);
    // Sums over the edges; the angle around P is kept apart from the rest of the area.
    let (mut triangles, mut turn, mut angle) = (zero, zero, zero);
    for edge in edges.iter().flatten() {
        let h2 = edge.h * edge.h;
        let beyond = d * d + h2;
        let point = |t: R| EdgePoint { t, r: (beyond + t * t).sqrt() };
        let half_chord2 = s2 - h2;
        let mut outside = |from: EdgePoint<R>, to: EdgePoint<R>| {
            let (phi, g) = outside_piece(d, edge.h, beyond, from, to);
            turn = turn + phi;
            angle = angle + g;
        };
        if half_chord2 <= zero {
            outside(point(edge.a), point(edge.b));
            continue;
        }
        let t = half_chord2.sqrt();
        doubt.about_order(edge.a, t);
        doubt.about_order(edge.b, t);
        if edge.a < -t {
            outside(point(edge.a), if edge.b < -t { point(edge.b) } else { EdgePoint { t: -t, r: one } });
        }
        if edge.b > t {
            outside(if edge.a > t { point(edge.a) } else { EdgePoint { t, r: one } }, point(edge.b));
        }
        let (low, high) = (edge.a.max(-t), edge.b.min(t));
        if low < high {
            triangles = triangles + edge.h * (high - low);
        }
    }
    let area = R::from_f64(0.5) * (triangles + s2 * turn);
    FaceTerms { distance: d, area, solid_angle: d * turn - angle }
}

fn no_edge_inside<R: Real>(
    d: R,
    s2: R,
    normal: Vector<R>,
    corners: &[Vector<R>],
    edges: &[Option<Edge<R>>],
    doubt: &mut Doubt,
) -> FaceTerms<R> {
    let zero = R::from_f64(0.0);
    let left = edges.iter().flatten().filter(|edge| edge.h > zero).count();
    let turns = if left == edges.iter().flatten().count() && corners.len() <= 4 {
        // To the left of three or four edges: inside, whether the polygon is convex or not.
        1.0
    } else if left == 0 {
        0.0
    } else {
        // The angles under which P sees the edges add up to a whole number of turns.
        let turn = edges
            .iter()
            .flatten()
            .fold(zero, |turn, edge| turn + (edge.h * (edge.b - edge.a)).atan2(edge.h * edge.h + edge.a * edge.b));
        let turns = turn.to_f64() / (2.0 * std::f64::consts::PI);
        doubt.about_turns(turns, turn, s2);
        turns.round()
    };
    let disc = R::from_f64(2.0 * turns) * R::pi();
    let solid_angle = if d.to_f64().abs() < NEARLY_EDGE_ON {
        // Triangles of a fan may have P on a side in common, where each one's solid angle is anything up to a half
        // turn; every edge of the polygon, though, is at least s away from P.
        let angle = edges.iter().flatten().fold(zero, |angle, edge| {
            let beyond = d * d + edge.h * edge.h;
            let point = |t: R| EdgePoint { t, r: (beyond + t * t).sqrt() };
            angle + outside_piece(d, edge.h, beyond, point(edge.a), point(edge.b)).1
        });
        d * disc - angle
    } else {
        let sign = R::from_f64(if d < zero { -1.0 } else { 1.0 });
        polygon_solid_angle(normal, corners) - (sign - d) * disc
    };
    FaceTerms { distance: d, area: R::from_f64(turns) * R::pi() * s2, solid_angle }
}

/// Distance of a plane below which its polygon is seen so flat that the foot of the centre may lie on the diagonals
/// of a fan.
const NEARLY_EDGE_ON: f64 = 0.5;

/// (Δφ, ΔG) of the piece of an edge between two points outside the ball or on it.
#[inline]
fn outside_piece<R: Real>(d: R, h: R, beyond: R, a: EdgePoint<R>, b: EdgePoint<R>) -> (R, R) {
    let h2 = h * h;
    let product = a.t * b.t;
    let phi = (h * (b.t - a.t)).atan2(h2 + product);
    // The difference b R_a − a R_b cancels where both ends lie on one side of the foot.
    let lever = if product > R::from_f64(0.0) {
        beyond * ((b.t - a.t) * (b.t + a.t)) / (b.t * a.r + a.t * b.r)
    } else {
        b.t * a.r - a.t * b.r
    };
    let g = (h * d * lever).atan2(h2 * (a.r * b.r) + d * d * product);
    // Outside the ball 1/R ≤ 1, so |ΔG| ≤ |d Δφ|: all that is known where h and d are both near zero.
    (phi, if R::TRACKED { g.confined(d * phi) } else { g })
}

/// Solid angle under which the origin sees a planar polygon, positive where it looks at the polygon's back.
///
/// $$ \tan\frac{\Omega}{2} = \frac{2 d A}{R_1R_2R_3 + (v_1 \cdot v_2) R_3 + (v_2 \cdot v_3) R_1 + (v_3 \cdot v_1) R_2} $$
///
/// for each triangle of a fan, with signed area A. Around a point inside a closed polyhedron the faces add up to
/// 4π, around one outside to 0. The numerator is
/// the triple product of the corners without its cancellation for far or small triangles.
///
/// Precondition: at least two corners; fewer panic. Source: `vanoosterom1983`, Eq. 8.
///
/// ```
/// use fieldstone_geometry::{Vector, polygon_solid_angle};
/// // From its centre each of the six faces of a cube takes a sixth of the sphere.
/// let face = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].map(|[x, y]| Vector::new(x, y, 1.0));
/// let solid_angle = polygon_solid_angle(Vector::new(0.0, 0.0, 1.0), &face);
/// assert!((solid_angle - 4.0 * std::f64::consts::PI / 6.0).abs() < 1e-15);
/// ```
pub fn polygon_solid_angle<R: Real>(normal: Vector<R>, corners: &[Vector<R>]) -> R {
    let zero = R::from_f64(0.0);
    let apex = corners[0];
    let d = normal.dot(apex);
    let mut sum = zero;
    let apex_r = apex.length();
    let mut b = corners[1];
    let mut b_r = b.length();
    for &c in &corners[2..] {
        let c_r = c.length();
        let twice_area = (b - apex).cross(c - apex).dot(normal);
        let denominator = apex_r * b_r * c_r + apex.dot(b) * c_r + b.dot(c) * apex_r + c.dot(apex) * b_r;
        sum = sum + (d * twice_area).atan2(denominator);
        (b, b_r) = (c, c_r);
    }
    R::from_f64(2.0) * sum
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
    fn about_edge<R: Real>(&mut self, edge: &Edge<R>, s2: R) {
        if R::TRACKED {
            let half_chord2 = s2 - edge.h * edge.h;
            let (gap, error) = (half_chord2.to_f64().abs(), half_chord2.error());
            if gap <= error {
                self.add(8.0 * (gap + error));
            }
            // On which side P lies decides only where the line misses the disc, and then s² ≤ h².
            let (size, error) = (edge.h.to_f64().abs(), edge.h.error());
            if size <= error {
                self.add(8.0 * (size + error) * (size + error));
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
