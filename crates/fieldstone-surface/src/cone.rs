use crate::{SurfaceError, TIE};

/// The scanning cone of the geometrical criterion.
///
/// A particle is on the free surface if and only if some direction has no neighbour within the angle θ of it, among
/// the neighbours within R. The default is the paper's: R = 2.5 Δx and θ = 45°.
///
/// Source: `liu2022`, Sec. 3.1 and 3.1.4.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanningCone {
    /// Radius R of the sphere over the spacing Δx.
    pub radius: f64,
    /// Half-angle θ in degrees, above 0 and below 90.
    pub angle: f64,
}

impl Default for ScanningCone {
    fn default() -> Self {
        Self { radius: 2.5, angle: 45.0 }
    }
}

impl ScanningCone {
    pub(crate) fn validate(&self) -> Result<(), SurfaceError> {
        if !(self.radius > 0.0 && self.radius <= 100.0) {
            return Err(SurfaceError::Option {
                name: "the radius of the sphere over the spacing",
                value: self.radius,
                allowed: "above 0 and at most 100",
            });
        }
        if !(self.angle > 0.0 && self.angle < 89.999_999) {
            return Err(SurfaceError::Option {
                name: "the angle of the cone in degrees",
                value: self.angle,
                allowed: "above 0 and below 90",
            });
        }
        Ok(())
    }

    /// Half-angle of the caps in radians, enlarged by the tie.
    pub(crate) fn cap_angle(&self) -> f64 {
        self.angle.to_radians() + TIE
    }
}
