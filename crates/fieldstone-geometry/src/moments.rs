//! First and second moments of ball ∩ polyhedron, as sums over faces.

use crate::certified::{PROMISE, Precision};
use crate::double_double::DoubleDouble;
use crate::overlap::{Placement, placement};
use crate::precision::{Tracked, Wide};
use crate::{Ball, FaceTerms, Polyhedron, Real, Vector, face_terms};

/// Volume, first and second moments of ball ∩ polyhedron about the ball's centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// $\int dV$.
    pub volume: f64,
    /// $\int x \, dV$.
    pub first: [f64; 3],
    /// $\int x_i x_j \, dV$ as xx, xy, xz, yy, yz, zz.
    pub second: [f64; 6],
    /// Bound of the error of the volume.
    pub volume_error: f64,
    /// Bound of the error of each first moment.
    pub first_error: f64,
    /// Bound of the error of each second moment.
    pub second_error: f64,
    /// Arithmetic that was needed.
    pub precision: Precision,
}

impl Moments {
    /// Centroid of the overlap, relative to the ball's centre; `None` where there is no overlap.
    pub fn centroid(&self) -> Option<[f64; 3]> {
        (self.volume > 0.0).then(|| self.first.map(|m| m / self.volume))
    }
}

/// Volume, first and second moments of the part of `ball` inside `polyhedron`, about the ball's centre.
///
/// Since $1 - |x|^2$ vanishes on the unit sphere, the divergence theorem leaves integrals over the plane faces only:
///
/// $$ \int x \, dV = -\tfrac12 \sum_f n_f K_f, \qquad
///    \int |x|^2 dV = \tfrac15 \Bigl( 3V - \sum_f d_f K_f \Bigr), $$
/// $$ 2 \int x_i x_j \, dV = \delta_{ij} \Bigl( V - \int |x|^2 dV \Bigr) - \sum_f n_i \, Q_{f,j} $$
///
/// | symbol | meaning |
/// |---|---|
/// | $K_f$ | $\int_{f \cap B} (1 - \lvert x\rvert^2) \, dA$ |
/// | $Q_f$ | $\int_{f \cap B} (1 - \lvert x\rvert^2) \, x \, dA$ |
/// | $n_f, d_f$ | outward normal and distance of the face's plane |
///
/// The moment of a spinning ball's momentum in a cell follows: a velocity $v + \omega \times x$ gives
/// $\rho (V v + \omega \times \int x \, dV)$.
///
/// Accuracy: with V the smaller volume and R the smaller of the radius and the distance of the farthest corner, the
/// errors are below 1e-12 V, 1e-12 V R and 1e-12 V R². By running error analysis, first in `f64`, then in more
/// digits. Cost: about five times [`crate::overlap_volume`].
///
/// Source: derived here.
///
/// ```
/// use fieldstone_geometry::{Ball, Polyhedron, overlap_moments};
/// // Half a ball: its centroid is 3/8 r from the plane.
/// let half = Polyhedron::cuboid([-2.0, -2.0, 0.0], [2.0; 3])?;
/// let moments = overlap_moments(&Ball::new([0.0; 3], 1.0)?, &half);
/// assert!((moments.centroid().unwrap_or_default()[2] - 0.375).abs() < 1e-15);
/// // Second moments of half a ball are half the ball's, 4π/15.
/// assert!((moments.second[0] - 2.0 * std::f64::consts::PI / 15.0).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn overlap_moments(ball: &Ball, polyhedron: &Polyhedron) -> Moments {
    if matches!(placement(ball, polyhedron), Placement::Apart) {
        return Moments {
            volume: 0.0,
            first: [0.0; 3],
            second: [0.0; 6],
            volume_error: 0.0,
            first_error: 0.0,
            second_error: 0.0,
            precision: Precision::F64,
        };
    }
    let smaller = ball.volume().min(polyhedron.volume());
    let (low, high) = polyhedron.bounds();
    let centre = ball.centre();
    let far2: f64 = (0..3).map(|k| (high[k] - centre[k]).abs().max((centre[k] - low[k]).abs()).powi(2)).sum();
    let reach = ball.radius().min(far2.sqrt());
    let keeps = |m: &Moments| {
        m.volume_error <= PROMISE * smaller
            && m.first_error <= PROMISE * smaller * reach
            && m.second_error <= PROMISE * smaller * reach * reach
    };
    let mut moments = evaluate::<Tracked<f64>>(ball, polyhedron, Precision::F64);
    if !keeps(&moments) {
        moments = evaluate::<Tracked<DoubleDouble>>(ball, polyhedron, Precision::DoubleDouble);
    }
    if !keeps(&moments) {
        moments = evaluate::<Tracked<Wide>>(ball, polyhedron, Precision::Wide);
    }
    moments
}

struct Sums<R> {
    three_volumes: R,
    /// Σ n K.
    normal_k: Vector<R>,
    /// Σ d K.
    distance_k: R,
    /// Σ n ⊗ Q, the upper triangle and its transpose averaged.
    normal_q: [R; 6],
}

fn evaluate<R: Real>(ball: &Ball, polyhedron: &Polyhedron, precision: Precision) -> Moments {
    let zero = R::from_f64(0.0);
    let half = R::from_f64(0.5);
    let radius = R::from_f64(ball.radius());
    let centre = Vector::<R>::from_f64(ball.centre());
    let mut sums =
        Sums { three_volumes: zero, normal_k: Vector::new(zero, zero, zero), distance_k: zero, normal_q: [zero; 6] };
    polyhedron.for_each_planar_ring(&centre, radius, |_, ring, normal| sums.add(normal, ring));

    let volume = sums.three_volumes / R::from_f64(3.0);
    let trace = (sums.three_volumes - sums.distance_k) / R::from_f64(5.0);
    let r3 = radius * radius * radius;
    let (r4, r5) = (r3 * radius, r3 * radius * radius);
    let first = sums.normal_k * (-(half * r4));
    let diagonal = volume - trace;
    let second = [0, 1, 2, 3, 4, 5].map(|k| {
        let delta = if matches!(k, 0 | 3 | 5) { diagonal } else { zero };
        half * (delta - sums.normal_q[k]) * r5
    });
    let volume = volume * r3;
    let first = [first.x, first.y, first.z];
    let bound = |x: &R| x.error() + 4.0 * f64::EPSILON * x.to_f64().abs();
    Moments {
        volume: volume.to_f64().clamp(0.0, ball.volume().min(polyhedron.volume())),
        first: first.map(Real::to_f64),
        second: second.map(Real::to_f64),
        volume_error: bound(&volume),
        first_error: first.iter().map(bound).fold(0.0, f64::max),
        second_error: second.iter().map(bound).fold(0.0, f64::max),
        precision,
    }
}

impl<R: Real> Sums<R> {
    fn add(&mut self, normal: Vector<R>, ring: &[Vector<R>]) {
        let one = R::from_f64(1.0);
        let FaceTerms { distance: d, area, solid_angle } = face_terms(normal, ring);
        self.three_volumes = self.three_volumes + d * area + solid_angle;
        if d.abs() >= one && area.error() == 0.0 {
            return;
        }
        let s2 = (one - d) * (one + d);
        let (k, in_plane) = face_moments(s2, area, normal, ring);
        self.normal_k = self.normal_k + normal * k;
        self.distance_k = self.distance_k + d * k;
        let q = normal * (d * k) + in_plane;
        let n = normal;
        let mean = |a: R, b: R| R::from_f64(0.5) * (a + b);
        let product = [
            n.x * q.x,
            mean(n.x * q.y, n.y * q.x),
            mean(n.x * q.z, n.z * q.x),
            n.y * q.y,
            mean(n.y * q.z, n.z * q.y),
            n.z * q.z,
        ];
        for (sum, term) in self.normal_q.iter_mut().zip(product) {
            *sum = *sum + term;
        }
    }
}

/// $K = \int (1 - |x|^2) dA$ over the face's part in the ball, and $\int (s^2 - \rho^2) \, y \, dA$ with y the vector from
/// the foot of the centre and ρ its length.
///
/// With the polar form of the region around P, $K = \int \tfrac12 s^2 \rho^2 - \tfrac14 \rho^4 \, d\varphi$ along its boundary: on the
/// circle that is $\tfrac14 s^4 \Delta\varphi$, on an edge a polynomial. Since the area holds the same angles, $K = \tfrac12 s^2 A$ plus, for each
/// piece of an edge inside, the integral of $\tfrac14 \rho^2 (s^2 - \rho^2) \, d\varphi = \tfrac14 h (s^2 - h^2 - t^2) \, dt$. The vector is
/// $-\tfrac14 \oint (s^2 - \rho^2)^2 o \, dl$, to which the circle gives nothing.
fn face_moments<R: Real>(s2: R, area: R, normal: Vector<R>, ring: &[Vector<R>]) -> (R, Vector<R>) {
    let zero = R::from_f64(0.0);
    let constant = R::from_f64;
    let mut k = constant(0.5) * s2 * area;
    let mut in_plane = Vector::new(zero, zero, zero);
    for (index, &from) in ring.iter().enumerate() {
        let to = ring[if index + 1 == ring.len() { 0 } else { index + 1 }];
        let along = to - from;
        let length = along.length();
        if length <= zero {
            continue;
        }
        let e = along * (constant(1.0) / length);
        let o = e.cross(normal);
        let h = from.dot(o);
        // Squares of the half chord; where the line misses the disc there is nothing, and no more than rounding is
        // lost where it barely does, since all terms below have its third power at least.
        let c2 = s2 - h * h;
        if c2 <= zero {
            continue;
        }
        let c = c2.sqrt();
        let (low, high) = (from.dot(e).max(-c), to.dot(e).min(c));
        if low >= high {
            continue;
        }
        let powers = |t: R| {
            let t3 = t * t * t;
            (t, t3, t3 * t * t)
        };
        let ((a, a3, a5), (b, b3, b5)) = (powers(low), powers(high));
        let linear = c2 * (b - a) - (b3 - a3) / constant(3.0);
        k = k + constant(0.25) * h * linear;
        let quartic = c2 * c2 * (b - a) - constant(2.0) * c2 * (b3 - a3) / constant(3.0) + (b5 - a5) / constant(5.0);
        in_plane = in_plane + o * -(constant(0.25) * quartic);
    }
    (k, in_plane)
}

#[cfg(test)]
mod tests {
    use fieldstone_testing::{Random, pairs};

    use super::*;
    use crate::{CornerOrder, ElementKind, Orientation};

    /// Pairs tried by default; `FIELDSTONE_PAIRS` asks for more.
    fn count() -> u64 {
        std::env::var("FIELDSTONE_PAIRS").ok().and_then(|n| n.parse().ok()).unwrap_or(4_000)
    }

    /// Largest difference of components, over what it may be.
    fn ratio(found: &[f64], exact: &[f64], allowed: f64) -> f64 {
        found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / allowed.max(f64::MIN_POSITIVE)
    }

    #[test]
    fn moments_of_any_pair_are_within_their_bounds_and_their_promise() {
        let (mut seen, mut worst, mut rough) = ([0; 3], [0.0f64; 3], [0.0f64; 3]);
        for seed in 0..count() {
            let random = &mut Random(seed);
            let (kind, corners) = pairs::element(random);
            let kind = ElementKind::STANDARD[kind];
            let Ok(element) = Polyhedron::element(kind, CornerOrder::Cgns, &corners, Orientation::Fix) else {
                continue;
            };
            let (centre, radius) = pairs::ball(&corners, element.bounds(), random);
            let Ok(ball) = Ball::new(centre, radius) else { continue };
            let found = overlap_moments(&ball, &element);
            let exact = evaluate::<Tracked<Wide>>(&ball, &element, Precision::Wide);
            // What f64 alone would give, so that more digits are seen to matter.
            let plain = evaluate::<Tracked<f64>>(&ball, &element, Precision::F64);
            seen[found.precision as usize] += 1;

            let volume = ball.volume().min(element.volume());
            let reach = radius.min(corners.iter().map(|p| distance(*p, centre)).fold(0.0, f64::max));
            let (low, high) = element.bounds();
            let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
            // Beyond that rounding alone makes an element, and even 256 bits do not keep the promise for all.
            let promised = element.volume() > 1e-20 * size.powi(3);
            let orders = [
                (&[found.volume][..], &[exact.volume][..], found.volume_error, exact.volume_error),
                (&found.first, &exact.first, found.first_error, exact.first_error),
                (&found.second, &exact.second, found.second_error, exact.second_error),
            ];
            for (order, (value, truth, bound, uncertain)) in orders.into_iter().enumerate() {
                let within = ratio(value, truth, bound + uncertain);
                assert!(within <= 1.0, "seed {seed}, order {order}: {within} of its bound, {found:?} {exact:?}");
                let promise = PROMISE * volume * reach.powi(order as i32);
                let kept = ratio(value, truth, promise + uncertain);
                assert!(
                    !promised || kept <= 1.0 + 1e-9,
                    "seed {seed}, order {order}: {kept} of the promise, {found:?}"
                );
                if promised {
                    worst[order] = worst[order].max(kept);
                }
                let plain = [&[plain.volume][..], &plain.first, &plain.second][order].to_vec();
                rough[order] = rough[order].max(ratio(&plain, truth, promise + uncertain));
            }
        }
        let [worst, plain] = [worst, rough].map(|errors| errors.map(|error| format!("{error:.1e}")));
        println!("{seen:?} in f64, 106 and 256 bits; largest error / promise {worst:?}, in f64 alone {plain:?}");
        assert!(seen[0] > 0 && seen[1] > 0 && rough.iter().all(|&error| error > 1.0), "{seen:?} {rough:?}");
    }

    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
    }
}
