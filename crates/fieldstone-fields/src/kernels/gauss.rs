//! The Gaussian, cut off by a sphere and renormalised.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use crate::erf::erf;

/// $e^{-q^2/2}$, q in units of the width.
#[inline]
pub(super) fn shape(q2: f64) -> f64 {
    (-0.5 * q2).exp()
}

/// One over the integral of the shape over the part of one, two or three dimensions within `reach`.
///
/// The integral in closed form cancels for short reaches, to nothing in the end, and so do powers of their ratio to the
/// width. There it is the series
/// $$ S_d \, c^d \, e^{-q^2/2} \sum_k \frac{q^{2k}}{d \, (d + 2) \cdots (d + 2k)}, \qquad q = c/w, $$
/// with the reach c and the unit sphere's surface $S_d$, 2, 2π or 4π: all its terms are positive.
pub(super) fn norm(dimensions: usize, width: f64, reach: f64) -> f64 {
    let q = reach / width;
    let power = dimensions as i32;
    if q >= 1.0 {
        1.0 / (mass(dimensions, q) * width.powi(power))
    } else {
        1.0 / (series(dimensions, q) * reach.powi(power))
    }
}

/// Integral within `reach` widths, from one on.
fn mass(dimensions: usize, reach: f64) -> f64 {
    let edge = (-0.5 * reach * reach).exp();
    let inside = erf(reach * FRAC_1_SQRT_2);
    match dimensions {
        1 => (2.0 * PI).sqrt() * inside,
        2 => 2.0 * PI * (1.0 - edge),
        _ => (2.0 * PI).powf(1.5) * (inside - (2.0 / PI).sqrt() * reach * edge),
    }
}

/// The same over the power of the reach, up to one width.
fn series(dimensions: usize, reach: f64) -> f64 {
    let surface = [2.0, 2.0 * PI, 4.0 * PI][dimensions - 1];
    let mut divisor = dimensions as f64;
    let mut term = 1.0 / divisor;
    let mut sum = term;
    while term > 1e-17 * sum {
        divisor += 2.0;
        term *= reach * reach / divisor;
        sum += term;
    }
    surface * (-0.5 * reach * reach).exp() * sum
}

/// $\int_{a}^{b} \mathrm{shape}(h^2 + t^2) \, dt$.
#[inline]
pub(super) fn along(h2: f64, a: f64, b: f64) -> f64 {
    /// √(π/2).
    const HALF_ROOT: f64 = 1.253_314_137_315_500_3;
    shape(h2) * HALF_ROOT * (erf(b * FRAC_1_SQRT_2) - erf(a * FRAC_1_SQRT_2))
}
