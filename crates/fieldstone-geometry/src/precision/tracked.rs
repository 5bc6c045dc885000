//! Numbers that carry a bound of their own rounding error.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::Real;

/// A computed value with a bound of its distance from the exact result of the same formula on exact input.
///
/// Running error analysis: each operation passes on the errors of its operands and adds its own rounding. The bound
/// is an `f64`, rounded up at every step. Comparisons look at the values alone; code that branches on them has
/// to add what the other branch would have given ([`Real::with_error`]).
///
/// ```
/// use fieldstone_geometry::Real;
/// use fieldstone_geometry::precision::Tracked;
/// let third = Tracked::<f64>::from_f64(1.0) / Tracked::from_f64(3.0);
/// let nothing = third * Tracked::from_f64(3.0) - Tracked::from_f64(1.0);
/// assert!(nothing.error() > 0.0 && nothing.error() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Tracked<R> {
    value: R,
    error: f64,
}

/// Rounds a bound up by more than the few roundings that its formula has had.
#[inline]
fn up(bound: f64) -> f64 {
    bound * (1.0 + 8.0 * f64::EPSILON) + f64::MIN_POSITIVE
}

/// A product in which nothing times an infinite error is nothing.
#[inline]
fn times(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

impl<R: Real> Tracked<R> {
    /// The computed value.
    pub fn value(self) -> R {
        self.value
    }

    #[inline]
    fn magnitude(self) -> f64 {
        self.value.to_f64().abs()
    }

    /// A fresh result with the error passed on by its operands and its own rounding.
    #[inline]
    fn rounded(value: R, passed_on: f64) -> Self {
        let own = value.to_f64().abs() * R::ROUNDOFF;
        Self { value, error: up(passed_on + own) }
    }
}

impl<R: Real> Real for Tracked<R> {
    const ROUNDOFF: f64 = R::ROUNDOFF;
    const ANGLE_ROUNDOFF: f64 = R::ANGLE_ROUNDOFF;
    const TRACKED: bool = true;

    #[inline]
    fn from_f64(x: f64) -> Self {
        Self { value: R::from_f64(x), error: 0.0 }
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self.value.to_f64()
    }

    #[inline]
    fn sqrt(self) -> Self {
        let x = self.value.to_f64();
        if x <= 0.0 {
            return Self { value: R::from_f64(0.0), error: up((x.max(0.0) + self.error).sqrt()) };
        }
        let root = self.value.sqrt();
        let low = (x - self.error).max(0.0).sqrt();
        Self::rounded(root, up(self.error / (root.to_f64() + low)))
    }

    #[inline]
    fn atan2(self, x: Self) -> Self {
        let angle = self.value.atan2(x.value);
        let (y_size, x_size) = (self.magnitude(), x.magnitude());
        // The nearest that the vector can be to the origin; the angle moves by at most the error across over that.
        let length = y_size.hypot(x_size);
        let shift = self.error.hypot(x.error);
        let nearest = length * (1.0 - 4.0 * f64::EPSILON) - shift;
        let passed_on = if shift == 0.0 {
            0.0
        } else if nearest > 0.0 {
            let across = (x_size * self.error + y_size * x.error) / length;
            // The exact change is the arc sine of (error across / length); it is below π/2 times its argument.
            let first = up(across) + shift * (shift / nearest);
            (first / nearest).min(std::f64::consts::PI)
        } else {
            std::f64::consts::PI
        };
        Self { value: angle, error: up(passed_on + R::ANGLE_ROUNDOFF * angle.to_f64().abs()) }
    }

    #[inline]
    fn pi() -> Self {
        Self { value: R::pi(), error: 4.0 * R::ROUNDOFF }
    }

    #[inline]
    fn error(self) -> f64 {
        self.error
    }

    #[inline]
    fn with_error(self, more: f64) -> Self {
        Self { value: self.value, error: up(self.error + more) }
    }

    #[inline]
    fn confined(self, limit: Self) -> Self {
        let largest = up(limit.magnitude() + limit.error);
        // Zero with the whole range as its error is better than a value of which less is known.
        if self.error > largest { Self { value: R::from_f64(0.0), error: largest } } else { self }
    }
}

impl<R: Real> PartialEq for Tracked<R> {
    #[inline]
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl<R: Real> PartialOrd for Tracked<R> {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl<R: Real> Neg for Tracked<R> {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self { value: -self.value, error: self.error }
    }
}

impl<R: Real> Add for Tracked<R> {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        Self::rounded(self.value + other.value, self.error + other.error)
    }
}

impl<R: Real> Sub for Tracked<R> {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::rounded(self.value - other.value, self.error + other.error)
    }
}

impl<R: Real> Mul for Tracked<R> {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        let passed_on = times(self.magnitude(), other.error)
            + times(other.magnitude(), self.error)
            + times(self.error, other.error);
        Self::rounded(self.value * other.value, up(passed_on))
    }
}

impl<R: Real> Div for Tracked<R> {
    type Output = Self;

    #[inline]
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        let nearest = other.magnitude() * (1.0 - 2.0 * f64::EPSILON) - other.error;
        let passed_on =
            if nearest > 0.0 { (self.error + quotient.to_f64().abs() * other.error) / nearest } else { f64::INFINITY };
        Self::rounded(quotient, up(passed_on))
    }
}
