//! Numbers of about 106 bits as unevaluated sums of two `f64`.
//!
//! A [`DoubleDouble`] holds $x = \mathit{hi} + \mathit{lo}$ with $|\mathit{lo}| \le \tfrac12\,\mathrm{ulp}(\mathit{hi})$.
//! Sums start from the error-free transformation [`two_sum`] (Knuth), products from [`two_prod`], whose error term
//! comes from [`f64::mul_add`]: that one is a fused multiply–add by definition, whatever the compiler's flags, so no
//! optimisation level can silently turn the extended precision off.
//!
//! | operation | relative error, $u = 2^{-53}$ |
//! |---|---|
//! | `+`, `-` | $\le 3u^2 + O(u^3)$ |
//! | `*` | $\le 5u^2$ |
//! | `/` | $\le 10u^2$ |
//! | [`DoubleDouble::sqrt`] | $\le 4u^2$ or better |
//!
//! The bounds hold while nothing overflows and no error term underflows, i.e. for magnitudes between about
//! $10^{-290}$ and $10^{300}$. Infinities and NaN come out as NaN, not as a wrong finite number.
//!
//! Source: `dekker1971`; the sum is the accurate one of `joldes2017` (`AccurateDWPlusDW`), the product its
//! `DWTimesDW3`.

use glam::DVec3;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Sum of two numbers as rounded value and exact error: `a + b == s + e`.
///
/// No condition on the magnitudes. Six operations.
///
/// ```
/// use fieldstone_geometry::double_double::two_sum;
/// assert_eq!(two_sum(1.0, 1e-30), (1.0, 1e-30));
/// ```
#[inline(always)]
pub fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let from_b = s - a;
    let from_a = s - from_b;
    (s, (a - from_a) + (b - from_b))
}

/// Sum as [`two_sum`], for `|a| ≥ |b|` or `a == 0`; three operations.
#[inline(always)]
pub fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    (s, b - (s - a))
}

/// Product of two numbers as rounded value and exact error: `a * b == p + e`.
///
/// ```
/// use fieldstone_geometry::double_double::two_prod;
/// let x = 1.0 + f64::EPSILON;
/// assert_eq!(two_prod(x, x), (1.0 + 2.0 * f64::EPSILON, f64::EPSILON * f64::EPSILON));
/// ```
#[inline(always)]
pub fn two_prod(a: f64, b: f64) -> (f64, f64) {
    let p = a * b;
    (p, a.mul_add(b, -p))
}

/// A number of about 32 significant decimal digits; see the [module](self) for the bounds.
///
/// ```
/// use fieldstone_geometry::double_double::DoubleDouble;
/// let third = DoubleDouble::from(1.0) / DoubleDouble::from(3.0);
/// let back = third * DoubleDouble::from(3.0) - DoubleDouble::from(1.0);
/// assert!(f64::from(back).abs() < 1e-31);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Default)]
pub struct DoubleDouble {
    // The order of the fields makes the derived comparison the numerical one: `hi` is the rounded value.
    hi: f64,
    lo: f64,
}

impl DoubleDouble {
    /// Nought.
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };
    /// One.
    pub const ONE: Self = Self { hi: 1.0, lo: 0.0 };

    /// Exact sum of two `f64`.
    #[inline(always)]
    pub fn from_sum(a: f64, b: f64) -> Self {
        let (hi, lo) = two_sum(a, b);
        Self { hi, lo }
    }

    /// Exact difference of two `f64`.
    #[inline(always)]
    pub fn from_difference(a: f64, b: f64) -> Self {
        Self::from_sum(a, -b)
    }

    /// Exact product of two `f64`.
    #[inline(always)]
    pub fn from_product(a: f64, b: f64) -> Self {
        let (hi, lo) = two_prod(a, b);
        Self { hi, lo }
    }

    /// The value rounded to `f64`.
    #[inline(always)]
    pub fn hi(self) -> f64 {
        self.hi
    }

    /// What [`hi`](Self::hi) leaves out.
    #[inline(always)]
    pub fn lo(self) -> f64 {
        self.lo
    }

    /// Absolute value.
    #[inline]
    pub fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    /// Whether both parts are finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.hi.is_finite() && self.lo.is_finite()
    }

    /// Square root: one Newton step from the `f64` root (Karp's trick: the correction needs `f64` only).
    ///
    /// NaN for negative numbers.
    ///
    /// ```
    /// use fieldstone_geometry::double_double::DoubleDouble;
    /// let root = DoubleDouble::from(2.0).sqrt();
    /// assert!(f64::from(root * root - DoubleDouble::from(2.0)).abs() < 1e-31);
    /// ```
    #[inline]
    pub fn sqrt(self) -> Self {
        if self.hi == 0.0 {
            return Self::ZERO;
        }
        let root = self.hi.sqrt();
        let rest = self - Self::from_product(root, root);
        let (hi, lo) = quick_two_sum(root, rest.hi / (2.0 * root));
        Self { hi, lo }
    }
}

impl From<f64> for DoubleDouble {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self { hi: value, lo: 0.0 }
    }
}

impl From<DoubleDouble> for f64 {
    #[inline(always)]
    fn from(value: DoubleDouble) -> Self {
        value.hi
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for DoubleDouble {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        // Both pairs are added exactly: the shorter sum, which adds `lo + lo` in one rounding, has no bound at all
        // where the operands nearly cancel, and cancelling differences are what these numbers are for.
        let (s, e) = two_sum(self.hi, other.hi);
        let (t, f) = two_sum(self.lo, other.lo);
        let (s, e) = quick_two_sum(s, e + t);
        let (hi, lo) = quick_two_sum(s, e + f);
        Self { hi, lo }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (p, e) = two_prod(self.hi, other.hi);
        let cross = self.hi.mul_add(other.lo, self.lo * other.hi);
        let (hi, lo) = quick_two_sum(p, e + cross);
        Self { hi, lo }
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        // Long division: two digits of 53 bits and the head of a third.
        let first = self.hi / other.hi;
        let rest = self - other * Self::from(first);
        let second = rest.hi / other.hi;
        let rest = rest - other * Self::from(second);
        let third = rest.hi / other.hi;
        let (hi, lo) = quick_two_sum(first, second);
        Self { hi, lo } + Self::from(third)
    }
}

impl AddAssign for DoubleDouble {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for DoubleDouble {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// Cross product (a₁ − a₀) × (b₁ − b₀), each pair given as `[to, from]`, as good as the last rounding.
///
/// The differences are exact and the products and their differences carry 106 bits, so that the direction is right
/// also where the factors are nearly parallel or the points lie close together.
///
/// Source: `strobl2016`, Sec. 4.4.
pub(crate) fn cross_of_differences(a: [DVec3; 2], b: [DVec3; 2]) -> DVec3 {
    let difference = |[to, from]: [DVec3; 2]| {
        [
            DoubleDouble::from_difference(to.x, from.x),
            DoubleDouble::from_difference(to.y, from.y),
            DoubleDouble::from_difference(to.z, from.z),
        ]
    };
    let (a, b) = (difference(a), difference(b));
    let component = |i: usize, j: usize| f64::from(a[i] * b[j] - a[j] * b[i]);
    DVec3::new(component(1, 2), component(2, 0), component(0, 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Integers below 2^53 split over two parts: every operation can be checked in `i128`.
    fn from_i128(value: i128) -> DoubleDouble {
        let hi = value as f64;
        DoubleDouble::from_sum(hi, (value - hi as i128) as f64)
    }

    fn to_i128(value: DoubleDouble) -> i128 {
        value.hi as i128 + value.lo as i128
    }

    proptest! {
        #[test]
        fn sum_and_difference_of_100_bit_integers_are_exact(a in -(1i128 << 100)..1i128 << 100, b in -(1i128 << 100)..1i128 << 100) {
            let (x, y) = (from_i128(a), from_i128(b));
            prop_assert_eq!(to_i128(x), a);
            prop_assert_eq!(to_i128(x + y), a + b);
            prop_assert_eq!(to_i128(x - y), a - b);
        }

        #[test]
        fn product_of_50_bit_integers_is_exact(a in -(1i128 << 50)..1i128 << 50, b in -(1i128 << 50)..1i128 << 50) {
            prop_assert_eq!(to_i128(from_i128(a) * from_i128(b)), a * b);
        }

        #[test]
        fn product_of_long_factors_is_right_to_104_bits(a in 1i128 << 60..1i128 << 63, b in 1i128 << 60..1i128 << 63) {
            let error = (to_i128(from_i128(a) * from_i128(b)) - a * b).unsigned_abs();
            prop_assert!(error <= ((a * b) as u128 >> 103) + 1, "{}", error);
        }

        #[test]
        fn quotient_undoes_the_product(a in 1e-20..1e20f64, b in 1e-20..1e20f64, low in -1e-17..1e-17f64) {
            let (a, b) = (DoubleDouble::from_sum(a, a * low), DoubleDouble::from_sum(b, -b * low));
            let rest = f64::from(a / b * b - a) / a.hi();
            prop_assert!(rest.abs() <= 16.0 * 2f64.powi(-106), "{}", rest);
        }

        #[test]
        fn root_squared_gives_the_number_back(a in 1e-20..1e20f64, low in -1e-17..1e-17f64) {
            let a = DoubleDouble::from_sum(a, a * low);
            let rest = f64::from(a.sqrt() * a.sqrt() - a) / a.hi();
            prop_assert!(rest.abs() <= 16.0 * 2f64.powi(-106), "{}", rest);
        }
    }

    #[test]
    fn cross_product_of_nearly_parallel_differences_is_right_to_the_last_bit() {
        // (1, 1 + ε, 0) × (1 + ε, 1 + 2ε, 0): z = 1 + 2ε − (1 + ε)² = −ε², below the rounding of either product.
        let e = f64::EPSILON;
        let (a, b) = (DVec3::new(1.0, 1.0 + e, 0.0), DVec3::new(1.0 + e, 1.0 + 2.0 * e, 0.0));
        assert_eq!(cross_of_differences([a, DVec3::ZERO], [b, DVec3::ZERO]), DVec3::new(0.0, 0.0, -e * e));
        assert_ne!(a.cross(b).z, -e * e);
    }

    #[test]
    fn a_difference_that_cancels_in_the_head_keeps_the_tail() {
        let a = DoubleDouble::from_sum(1.0, 1e-20);
        let b = DoubleDouble::from_sum(1.0, 3e-20);
        assert_eq!(f64::from(a - b), 1e-20 - 3e-20);
    }

    #[test]
    fn comparison_looks_at_the_tail_where_the_heads_agree() {
        assert!(DoubleDouble::from_sum(1.0, 1e-20) > DoubleDouble::ONE);
        assert!(DoubleDouble::from_sum(1.0, -1e-20) < DoubleDouble::ONE);
        assert_eq!((-DoubleDouble::ONE).abs(), DoubleDouble::ONE);
    }

    #[test]
    fn infinity_and_nan_do_not_become_finite() {
        let huge = DoubleDouble::from(f64::MAX);
        assert!(!(huge * huge).is_finite());
        assert!(!(DoubleDouble::ONE / DoubleDouble::ZERO).is_finite());
        assert!(!(-DoubleDouble::ONE).sqrt().is_finite());
        assert_eq!(DoubleDouble::ZERO.sqrt(), DoubleDouble::ZERO);
    }
}
