//! The arithmetic that the overlap kernel needs, so that one source serves every precision.

use std::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::LazyLock;

use crate::double_double::DoubleDouble;
use crate::precision::atan2_by_halving;

/// A real number type that the kernel can be evaluated in.
///
/// The library has `f64`, [`crate::double_double::DoubleDouble`] (106 bits), [`crate::precision::Wide`] (256 bits), and
/// each of them with a running error bound as [`crate::precision::Tracked`].
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Bound of the relative rounding error of one operation or square root.
    const ROUNDOFF: f64;
    /// Bound of the relative rounding error of an angle.
    const ANGLE_ROUNDOFF: f64;
    /// Whether numbers carry a bound of their error.
    const TRACKED: bool = false;

    /// The nearest number of this type.
    fn from_f64(x: f64) -> Self;
    /// The number as an `f64`, rounded or truncated.
    fn to_f64(self) -> f64;
    /// Square root; the argument is not negative.
    fn sqrt(self) -> Self;
    /// Angle of the vector (x, y) with `self` as y, in (−π, π]; 0 for the zero vector.
    fn atan2(self, x: Self) -> Self;
    /// π.
    fn pi() -> Self;

    /// Bound of the error that this number carries; 0 unless [`Real::TRACKED`].
    #[inline]
    fn error(self) -> f64 {
        0.0
    }

    /// The same number with more error; unchanged unless [`Real::TRACKED`].
    #[inline]
    fn with_error(self, _more: f64) -> Self {
        self
    }

    /// The same number, known to be no larger in magnitude than `limit`; unchanged unless [`Real::TRACKED`].
    #[inline]
    fn confined(self, _limit: Self) -> Self {
        self
    }

    /// Absolute value.
    #[inline]
    fn abs(self) -> Self {
        if self < Self::from_f64(0.0) { -self } else { self }
    }

    /// The smaller of two numbers.
    #[inline]
    fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    /// The larger of two numbers.
    #[inline]
    fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
}

impl Real for f64 {
    const ROUNDOFF: f64 = 0.5 * f64::EPSILON;
    const ANGLE_ROUNDOFF: f64 = f64::EPSILON;

    #[inline]
    fn from_f64(x: f64) -> Self {
        x
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline]
    fn atan2(self, x: Self) -> Self {
        f64::atan2(self, x)
    }

    #[inline]
    fn pi() -> Self {
        std::f64::consts::PI
    }

    #[inline]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline]
    fn min(self, other: Self) -> Self {
        f64::min(self, other)
    }

    #[inline]
    fn max(self, other: Self) -> Self {
        f64::max(self, other)
    }
}

impl Real for DoubleDouble {
    // 10 u² for a quotient is the largest of its operations.
    const ROUNDOFF: f64 = 1.3e-31;
    const ANGLE_ROUNDOFF: f64 = 5e-30;

    #[inline]
    fn from_f64(x: f64) -> Self {
        Self::from(x)
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self.hi()
    }

    #[inline]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    fn atan2(self, x: Self) -> Self {
        static RECIPROCALS: LazyLock<Vec<DoubleDouble>> =
            LazyLock::new(|| (0..14).map(|k| DoubleDouble::ONE / DoubleDouble::from(f64::from(2 * k + 1))).collect());
        atan2_by_halving(self, x, 4, &RECIPROCALS)
    }

    #[inline]
    fn pi() -> Self {
        // The second word is what the first leaves of π.
        Self::from_sum(std::f64::consts::PI, 1.224_646_799_147_353_2e-16)
    }
}
