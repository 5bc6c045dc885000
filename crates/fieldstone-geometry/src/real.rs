//! The arithmetic that the overlap kernel needs, so that one source serves every precision.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number type that the kernel can be evaluated in.
///
/// `f64` is the only implementation that the library uses by itself. A caller with a wider type (for a
/// check, or for flat elements under huge balls) implements these operations and gets the same formulas.
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The nearest number of this type.
    fn from_f64(x: f64) -> Self;
    /// The nearest `f64`.
    fn to_f64(self) -> f64;
    /// Square root; the argument is not negative.
    fn sqrt(self) -> Self;
    /// Angle of the vector (x, y) with `self` as y, in (−π, π]; 0 for the zero vector.
    fn atan2(self, x: Self) -> Self;
    /// π.
    fn pi() -> Self;

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
