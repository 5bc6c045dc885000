//! The linear kernel: a cone.

use super::integral_of_power;

/// $1 - q$ for q ≤ 1.
#[inline]
pub(super) fn shape(q2: f64) -> f64 {
    1.0 - q2.sqrt()
}

/// Integral of the shape over one, two or three dimensions.
pub(super) fn mass(dimensions: usize) -> f64 {
    use std::f64::consts::PI;
    match dimensions {
        1 => 1.0,
        2 => PI / 3.0,
        _ => PI / 3.0,
    }
}

/// $\int_{a}^{b} \mathrm{shape}(h^2 + t^2) \, dt$ within the reach.
#[inline]
pub(super) fn along(h2: f64, a: f64, b: f64) -> f64 {
    (b - a) - integral_of_power(1, h2, a, b)
}
