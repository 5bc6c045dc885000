//! Volume and sphere area of one part of the ball, added and subtracted together.

use std::ops::{Add, AddAssign, Mul, Sub, SubAssign};

/// A part of the unit ball: its volume and the area of the sphere that bounds it.
///
/// Both follow from the same arc tangents, so carrying the area along costs a few multiplications.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Part {
    pub volume: f64,
    pub area: f64,
}

impl Part {
    /// The whole unit ball.
    pub const BALL: Self = Self { volume: 4.0 / 3.0 * std::f64::consts::PI, area: 4.0 * std::f64::consts::PI };

    /// The cap beyond the plane at signed distance `d` from the centre.
    #[inline(always)]
    pub fn cap(d: f64) -> Self {
        Self { volume: crate::cap::cap_volume(1.0, d), area: crate::cap::cap_area(1.0, d) }
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { volume: self.volume.abs(), area: self.area.abs() }
    }
}

impl Add for Part {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { volume: self.volume + other.volume, area: self.area + other.area }
    }
}

impl Sub for Part {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { volume: self.volume - other.volume, area: self.area - other.area }
    }
}

impl Mul<f64> for Part {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self { volume: self.volume * factor, area: self.area * factor }
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
