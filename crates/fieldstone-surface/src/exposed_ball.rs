//! What the exposure methods in two and three dimensions share.

use crate::{SurfaceError, TIE};

/// Half-angle of the part of a circle or sphere inside another one of the same diameter, at `distance`.
#[inline(always)]
pub(crate) fn half_angle(distance: f64, diameter: f64) -> f64 {
    (distance / diameter).min(1.0).acos() + TIE
}

pub(crate) fn check_ball_radius(radius: f64) -> Result<(), SurfaceError> {
    if radius > 0.5 && radius <= 100.0 {
        return Ok(());
    }
    Err(SurfaceError::Option {
        name: "the radius of the particles' balls over the spacing",
        value: radius,
        allowed: "above 0.5, or no two balls overlap, and at most 100",
    })
}
