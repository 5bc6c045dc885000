//! The Gaussian, cut off by a sphere and renormalised.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use crate::erf::erf;

/// $e^{-q^2/2}$, q in units of the width.
#[inline]
pub(super) fn shape(q2: f64) -> f64 {
    (-0.5 * q2).exp()
}

/// Integral of the shape over the part of one, two or three dimensions within `reach` widths.
pub(super) fn mass(dimensions: usize, reach: f64) -> f64 {
    let edge = (-0.5 * reach * reach).exp();
    let inside = erf(reach * FRAC_1_SQRT_2);
    match dimensions {
        1 => (2.0 * PI).sqrt() * inside,
        2 => 2.0 * PI * (1.0 - edge),
        _ => (2.0 * PI).powf(1.5) * (inside - (2.0 / PI).sqrt() * reach * edge),
    }
}

/// $\int_{a}^{b} \mathrm{shape}(h^2 + t^2) \, dt$.
#[inline]
pub(super) fn along(h2: f64, a: f64, b: f64) -> f64 {
    /// √(π/2).
    const HALF_ROOT: f64 = 1.253_314_137_315_500_3;
    shape(h2) * HALF_ROOT * (erf(b * FRAC_1_SQRT_2) - erf(a * FRAC_1_SQRT_2))
}
