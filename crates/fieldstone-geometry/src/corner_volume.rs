//! Volume of the unit ball below a corner: the closed form behind balls in Cartesian grids.

use std::f64::consts::{FRAC_PI_2, PI};

/// Volume of the part of the unit ball (around the origin) with x ≤ a, y ≤ b and z ≤ c.
///
/// The volume in the box `[a0, a1] × [b0, b1] × [c0, c1]` is the eightfold difference of this function at the
/// box's corners, and a grid needs one value per corner.
///
/// With two or three of the planes cutting the ball in reach of each other, the octant's surface is summed as in
/// [`crate::face_terms`], with edges that run to infinity. Otherwise the caps are disjoint or contain each
/// other, and the volume is a sum of simpler ones:
///
/// $$ 3V = \frac{\pi}{2} + \sum_f \left( d_f A_f + \Omega_f \right) $$
///
/// Coordinates of 1 and above do not cut; ±∞ is allowed. NaN gives NaN. Accuracy: 4e-15 absolute, and below 3e-16 at nine
/// of ten corners; of corners on the sphere, near axes and anywhere the largest error seen is 3.1e-15.
/// Cost: up to 12 `atan2` where all three planes meet inside the ball, none where only one of them cuts.
///
/// ```
/// use fieldstone_geometry::corner_volume;
/// let ball = 4.0 / 3.0 * std::f64::consts::PI;
/// assert!((corner_volume([0.0, 0.0, 0.0]) - ball / 8.0).abs() < 1e-16);
/// assert!((corner_volume([0.0, 2.0, f64::INFINITY]) - ball / 2.0).abs() < 1e-15);
/// ```
pub fn corner_volume([a, b, c]: [f64; 3]) -> f64 {
    if a <= -1.0 || b <= -1.0 || c <= -1.0 {
        return 0.0;
    }
    match (a >= 1.0, b >= 1.0, c >= 1.0) {
        (true, true, _) => below_one(c),
        (true, _, true) => below_one(b),
        (_, true, true) => below_one(a),
        (true, false, false) => below_two(b, c),
        (false, true, false) => below_two(a, c),
        (false, false, true) => below_two(a, b),
        (false, false, false) => below_three(a, b, c),
    }
}

/// Part of the unit ball with x ≤ a.
#[inline]
fn below_one(a: f64) -> f64 {
    let a = a.min(1.0);
    PI / 3.0 * (1.0 + a) * (1.0 + a) * (2.0 - a)
}

/// Part with x ≤ a and y ≤ b, both planes cutting the ball.
fn below_two(a: f64, b: f64) -> f64 {
    if a * a + b * b >= 1.0 {
        // The line where the planes meet misses the ball.
        return match (a > 0.0, b > 0.0) {
            (false, false) => 0.0,
            (false, true) => below_one(a),
            (true, false) => below_one(b),
            (true, true) => below_one(a) + below_one(b) - 4.0 / 3.0 * PI,
        };
    }
    let (area_a, angle_a) = half_plane(a, b);
    let (area_b, angle_b) = half_plane(b, a);
    ((PI + angle_a + angle_b) + (a * area_a + b * area_b)) / 3.0
}

/// Part with x ≤ a, y ≤ b and z ≤ c, all planes cutting the ball.
fn below_three(a: f64, b: f64, c: f64) -> f64 {
    let apart = |u: f64, v: f64| u * u + v * v >= 1.0;
    // Where the line of two planes misses the ball, one of them decides, or what they cut off is disjoint.
    for (u, v, w) in [(a, b, c), (b, c, a), (c, a, b)] {
        if apart(u, v) {
            return match (u > 0.0, v > 0.0) {
                (false, false) => 0.0,
                (false, true) => below_two(u, w),
                (true, false) => below_two(v, w),
                (true, true) => below_two(u, w) + below_two(v, w) - below_one(w),
            };
        }
    }
    let (mut areas, mut angles) = (0.0, FRAC_PI_2);
    for (d, u, v) in [(a, b, c), (b, c, a), (c, a, b)] {
        let (first_area, first_angle) = ray(d, u, v);
        let (second_area, second_angle) = ray(d, v, u);
        // The quarter circle at infinity closes the face.
        areas += d * (first_area + second_area + (1.0 - d * d) * (0.5 * FRAC_PI_2));
        angles += d * FRAC_PI_2 + first_angle + second_angle;
    }
    (angles + areas) / 3.0
}

/// Area in the ball and solid angle outside it of the face at distance d with in-plane coordinate ≤ h.
fn half_plane(d: f64, h: f64) -> (f64, f64) {
    let s2 = (1.0 - d) * (1.0 + d);
    // Both ends of the line run to infinity, and it meets the ball (the caller has seen to it).
    let t = (s2 - h * h).max(0.0).sqrt();
    let phi = h.atan2(t);
    let g = (h * d * (1.0 - t)).atan2(h * h + d * d * t);
    (0.5 * s2 * PI + h * t + s2 * phi, d * PI + 2.0 * (d * phi - g))
}

/// Terms of the edge at distance h from the foot point, running from −∞ to t, of a face at distance d.
fn ray(d: f64, h: f64, t: f64) -> (f64, f64) {
    let s2 = (1.0 - d) * (1.0 + d);
    let half_chord = (s2 - h * h).max(0.0).sqrt();
    let (mut phi, mut g) = from_infinity(d, h, t.min(-half_chord), t > -half_chord);
    let mut area = 0.0;
    if t > -half_chord {
        area = 0.5 * h * (t.min(half_chord) + half_chord);
    }
    if t > half_chord {
        let r = (d * d + h * h + t * t).sqrt();
        phi += (h * (t - half_chord)).atan2(h * h + half_chord * t);
        let lever = (d * d + h * h) * ((t - half_chord) * (t + half_chord)) / (t + half_chord * r);
        g += (h * d * lever).atan2(h * h * r + d * d * half_chord * t);
    }
    (area + 0.5 * s2 * phi, d * phi - g)
}

/// (Δφ, ΔG) from −∞ to t; the point is on the sphere where `on_sphere`.
fn from_infinity(d: f64, h: f64, t: f64, on_sphere: bool) -> (f64, f64) {
    let beyond = d * d + h * h;
    let r = if on_sphere { 1.0 } else { (beyond + t * t).sqrt() };
    let lever = if t < 0.0 { beyond / (r - t) } else { r + t };
    (h.atan2(-t), (h * d * lever).atan2(h * h * r - d * d * t))
}
