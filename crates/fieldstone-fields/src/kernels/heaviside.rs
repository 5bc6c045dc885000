//! The Heaviside kernel: 1 within the reach.

/// 1 for q ≤ 1.
#[inline]
pub(super) fn shape(_: f64) -> f64 {
    1.0
}

/// Length, area or volume of the unit ball.
pub(super) fn mass(dimensions: usize) -> f64 {
    use std::f64::consts::PI;
    match dimensions {
        1 => 2.0,
        2 => PI,
        _ => 4.0 / 3.0 * PI,
    }
}

/// Length of the line within the reach.
#[inline]
pub(super) fn along(a: f64, b: f64) -> f64 {
    b - a
}
