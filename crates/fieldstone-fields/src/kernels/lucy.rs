//! Lucy's kernel: smooth, of finite reach, and with closed line integrals.

use super::integral_of_power;

/// $1 - 6 q^2 + 8 q^3 - 3 q^4 = (1 - q)^3 (1 + 3 q)$ for q ≤ 1.
///
/// As a product, which keeps its digits where the kernel vanishes: means over few particles at their edges need them.
///
/// Source: `lucy1977`.
#[inline]
pub(super) fn shape(q2: f64) -> f64 {
    let q = q2.sqrt();
    let rest = 1.0 - q;
    rest * rest * rest * (1.0 + 3.0 * q)
}

/// Integral of the shape over one, two or three dimensions.
pub(super) fn mass(dimensions: usize) -> f64 {
    use std::f64::consts::PI;
    match dimensions {
        1 => 4.0 / 5.0,
        2 => PI / 5.0,
        _ => 16.0 * PI / 105.0,
    }
}

/// $\int_{a}^{b} \mathrm{shape}(h^2 + t^2) \, dt$ within the reach.
#[inline]
pub(super) fn along(h2: f64, a: f64, b: f64) -> f64 {
    let polynomial = |t: f64| {
        let t2 = t * t;
        t * (1.0 - 6.0 * (h2 + t2 / 3.0) - 3.0 * (h2 * h2 + t2 * (2.0 / 3.0 * h2 + 0.2 * t2)))
    };
    polynomial(b) - polynomial(a) + 8.0 * integral_of_power(3, h2, a, b)
}
