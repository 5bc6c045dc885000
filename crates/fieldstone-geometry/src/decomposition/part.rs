//! Volume and sphere area of one part of the ball, added and subtracted together.

use std::f64::consts::PI;
use std::ops::{Add, AddAssign, Mul, Sub, SubAssign};

/// A part of the unit ball: its volume, three times, and the area of the sphere that bounds it.
///
/// Both follow from the same arc tangents, so carrying the area along costs a few multiplications.
/// Three times the volume has no thirds in it: with 4π/3 for the ball, π/3 for a cap and 1/3 for a wedge, each rounded on
/// its own, the terms of Eq. 2 cancel less well, and always with the same sign (ten times the error in a mesh's sum).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Part {
    pub triple_volume: f64,
    pub area: f64,
}

impl Part {
    /// The whole unit ball.
    pub const BALL: Self = Self { triple_volume: 4.0 * PI, area: 4.0 * PI };

    /// The cap beyond the plane at signed distance `d` from the centre.
    #[inline(always)]
    pub fn cap(d: f64) -> Self {
        let d = d.clamp(-1.0, 1.0);
        Self { triple_volume: PI * (1.0 - d) * (1.0 - d) * (2.0 + d), area: crate::cap::cap_area(1.0, d) }
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { triple_volume: self.triple_volume.abs(), area: self.area.abs() }
    }
}

impl Add for Part {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { triple_volume: self.triple_volume + other.triple_volume, area: self.area + other.area }
    }
}

impl Sub for Part {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { triple_volume: self.triple_volume - other.triple_volume, area: self.area - other.area }
    }
}

impl Mul<f64> for Part {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self { triple_volume: self.triple_volume * factor, area: self.area * factor }
    }
}

impl AddAssign for Part {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Part {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
