//! Spherical caps.

use std::f64::consts::{FRAC_PI_3, TAU};

/// Volume that the plane at signed distance `d` from the centre cuts off a ball of radius `r`.
///
/// $$ V = \tfrac{\pi}{3}\,(r - d)^2\,(2r + d), \qquad -r \le d \le r $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | `r` | radius of the ball, > 0 | length |
/// | `d` | distance of the plane along its outward normal | length |
///
/// The cap is the part beyond the plane: zero for `d ≥ r`, the whole ball for `d ≤ −r`. Relative error a few
/// ε also near tangency, because `r − d` is formed before it is squared.
///
/// Source: `strobl2016`, Sec. 3.1.
///
/// ```
/// # use fieldstone_geometry::cap_volume;
/// assert!((cap_volume(1.0, 0.0) - 2.0 * std::f64::consts::FRAC_PI_3).abs() < 1e-15);
/// assert_eq!(cap_volume(1.0, 1.5), 0.0);
/// ```
#[inline]
pub fn cap_volume(r: f64, d: f64) -> f64 {
    let d = d.clamp(-r, r);
    FRAC_PI_3 * (r - d) * (r - d) * (2.0 * r + d)
}

/// Area of the sphere of radius `r` beyond the plane at signed distance `d` from its centre.
///
/// $$ A = 2\pi\,r\,(r - d), \qquad -r \le d \le r $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | `r` | radius of the ball, > 0 | length |
/// | `d` | distance of the plane along its outward normal | length |
///
/// The curved part only, without the disc. Zero for `d ≥ r`, the whole sphere for `d ≤ −r`.
///
/// Source: $\partial V / \partial r$ of the cap of `strobl2016`, Sec. 3.1.
///
/// ```
/// # use fieldstone_geometry::cap_area;
/// assert!((cap_area(2.0, 1.0) - 4.0 * std::f64::consts::PI).abs() < 1e-14);
/// ```
#[inline]
pub fn cap_area(r: f64, d: f64) -> f64 {
    TAU * r * (r - d.clamp(-r, r))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn cap_and_its_counterpart_make_the_ball() {
        for i in -12..=12 {
            let d = 0.25 * f64::from(i);
            let ball = 4.0 / 3.0 * PI * 8.0;
            assert!((cap_volume(2.0, d) + cap_volume(2.0, -d) - ball).abs() < 4e-15 * ball);
            assert!((cap_area(2.0, d) + cap_area(2.0, -d) - 16.0 * PI).abs() < 4e-15 * ball);
        }
    }

    #[test]
    fn cap_next_to_tangency_keeps_its_relative_accuracy() {
        // r − d = 2^-40 exactly, so V = π h² (1 − h/3).
        let h = 2f64.powi(-40);
        let exact = PI * h * h * (1.0 - h / 3.0);
        assert!((cap_volume(1.0, 1.0 - h) / exact - 1.0).abs() < 1e-15);
    }

    #[test]
    fn plane_beyond_the_ball_cuts_nothing_or_everything() {
        assert_eq!(cap_volume(1.0, 1.0), 0.0);
        assert_eq!(cap_volume(1.0, 7.0), 0.0);
        assert!((cap_volume(1.0, -7.0) - 4.0 / 3.0 * PI).abs() < 1e-15);
        assert_eq!(cap_area(1.0, 7.0), 0.0);
    }
}
