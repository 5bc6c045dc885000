//! Floating-point numbers with 256 bits.

use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::LazyLock;

use super::atan2_by_halving;
use crate::Real;

/// Bits of the significand.
const BITS: i64 = 256;

/// A floating-point number with a 256-bit significand and a 64-bit exponent.
///
/// Sums, differences and products are truncated: their relative error is below $2^{-254}$, whatever cancels.
/// Quotients and square roots come from Newton's iteration and are good to $2^{-250}$, angles to $2^{-244}$.
/// There is no infinity and no NaN: converting one panics in debug builds and gives zero otherwise, dividing by
/// zero gives zero. The kernel feeds it finite numbers only and divides by nothing that can vanish.
///
/// About a hundred times slower than `f64`: it is the last resort for balls a million times larger than a flat
/// element.
#[derive(Debug, Clone, Copy)]
pub struct Wide {
    negative: bool,
    /// The value is significand · 2^(exponent − 256), the significand's top bit set, or all zero.
    exponent: i64,
    /// Most significant word first.
    significand: [u64; 4],
}

impl Wide {
    const ZERO: Self = Self { negative: false, exponent: 0, significand: [0; 4] };

    fn is_zero(&self) -> bool {
        self.significand[0] == 0
    }

    /// From five words, most significant first, of which the first may have leading zeros.
    fn normalised(negative: bool, exponent: i64, mut words: [u64; 5]) -> Self {
        let Some(first) = words.iter().position(|&w| w != 0) else { return Self::ZERO };
        words.rotate_left(first);
        let shift = words[0].leading_zeros();
        if shift > 0 {
            for k in 0..4 {
                words[k] = words[k] << shift | words[k + 1] >> (64 - shift);
            }
        }
        let moved = 64 * first as i64 + i64::from(shift);
        Self { negative, exponent: exponent - moved, significand: [words[0], words[1], words[2], words[3]] }
    }

    fn magnitude_order(&self, other: &Self) -> Ordering {
        match (self.is_zero(), other.is_zero()) {
            (true, true) => Ordering::Equal,
            (true, false) => Ordering::Less,
            (false, true) => Ordering::Greater,
            _ => self.exponent.cmp(&other.exponent).then(self.significand.cmp(&other.significand)),
        }
    }

    /// The number times 2^power.
    fn scaled(mut self, power: i64) -> Self {
        if !self.is_zero() {
            self.exponent += power;
        }
        self
    }

    /// The significand as an `f64` in [1/2, 1).
    fn leading(&self) -> f64 {
        (self.significand[0] >> 11) as f64 / (1u64 << 53) as f64
    }

    fn reciprocal(self) -> Self {
        if self.is_zero() {
            return Self::ZERO;
        }
        let unit = Self { negative: false, exponent: 0, ..self };
        let one = Self::from_f64(1.0);
        let mut x = Self::from_f64(1.0 / unit.leading());
        // 52 correct bits, then 104, 208, and all.
        for _ in 0..3 {
            x = x + x * (one - unit * x);
        }
        Self { negative: self.negative, ..x.scaled(-self.exponent) }
    }
}

impl Real for Wide {
    const ROUNDOFF: f64 = 8.6e-76; // 2^-250
    const ANGLE_ROUNDOFF: f64 = 4e-74; // 2^-244.5

    fn from_f64(x: f64) -> Self {
        debug_assert!(x.is_finite(), "{x} has no wide counterpart");
        if x == 0.0 || !x.is_finite() {
            return Self::ZERO;
        }
        let bits = x.to_bits();
        let biased = (bits >> 52 & 0x7ff) as i64;
        let fraction = bits & ((1 << 52) - 1);
        let (word, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
        // word · 2^exponent, with the word in the lowest place of the first of five words.
        Self::normalised(x < 0.0, exponent + 64, [word, 0, 0, 0, 0])
    }

    fn to_f64(self) -> f64 {
        if self.is_zero() {
            return 0.0;
        }
        let exponent = self.exponent.clamp(-2000, 2000) as i32;
        // In two steps, since 2^exponent alone may overflow or underflow.
        let magnitude = self.leading() * 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2);
        if self.negative { -magnitude } else { magnitude }
    }

    fn sqrt(self) -> Self {
        if self.is_zero() || self.negative {
            return Self::ZERO;
        }
        let odd = self.exponent.rem_euclid(2);
        let unit = Self { exponent: odd, ..self };
        let half = Self::from_f64(0.5);
        let three = Self::from_f64(3.0);
        let mut y = Self::from_f64(1.0 / unit.to_f64().sqrt());
        for _ in 0..3 {
            y = y * half * (three - unit * y * y);
        }
        // One correction of the root itself removes what the product of root and reciprocal has lost.
        let root = unit * y;
        let root = root + (unit - root * root) * y * half;
        root.scaled((self.exponent - odd) / 2)
    }

    fn atan2(self, x: Self) -> Self {
        static RECIPROCALS: LazyLock<Vec<Wide>> =
            LazyLock::new(|| (0..16).map(|k| Wide::from_f64(1.0) / Wide::from_f64(f64::from(2 * k + 1))).collect());
        atan2_by_halving(self, x, 8, &RECIPROCALS)
    }

    fn pi() -> Self {
        let significand = [0xC90F_DAA2_2168_C234, 0xC4C6_628B_80DC_1CD1, 0x2902_4E08_8A67_CC74, 0x020B_BEA6_3B13_9B22];
        Self { negative: false, exponent: 2, significand }
    }
}

impl PartialEq for Wide {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl PartialOrd for Wide {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        let sign = |x: &Self| if x.is_zero() { 0 } else { 1 - 2 * i32::from(x.negative) };
        let order = sign(self)
            .cmp(&sign(other))
            .then_with(|| if self.negative { other.magnitude_order(self) } else { self.magnitude_order(other) });
        Some(order)
    }
}

impl Neg for Wide {
    type Output = Self;

    fn neg(self) -> Self {
        Self { negative: !self.negative && !self.is_zero(), ..self }
    }
}

impl Add for Wide {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (large, small) = if self.magnitude_order(&other) == Ordering::Less { (other, self) } else { (self, other) };
        if small.is_zero() {
            return large;
        }
        let shift = large.exponent - small.exponent;
        if shift > BITS + 63 {
            return large;
        }
        // A fifth word keeps what the shift pushes out: with a shift of at most 64 nothing is lost, and beyond that
        // at most one bit can cancel.
        let [a, b, c, d] = large.significand;
        let a = [0, a, b, c, d, 0];
        let mut shifted = [0u64; 6];
        let (words, bits) = ((shift / 64) as usize, (shift % 64) as u32);
        for (k, &word) in small.significand.iter().enumerate() {
            if let Some(to) = shifted.get_mut(k + 1 + words) {
                *to |= word >> bits;
            }
            if bits > 0
                && let Some(to) = shifted.get_mut(k + 2 + words)
            {
                *to |= word << (64 - bits);
            }
        }
        let subtract = large.negative != small.negative;
        let mut sum = [0u64; 6];
        let mut carry = false;
        for k in (0..6).rev() {
            let (partial, first) =
                if subtract { a[k].overflowing_sub(shifted[k]) } else { a[k].overflowing_add(shifted[k]) };
            let (word, second) = if subtract {
                partial.overflowing_sub(u64::from(carry))
            } else {
                partial.overflowing_add(u64::from(carry))
            };
            sum[k] = word;
            carry = first || second;
        }
        if sum[0] != 0 {
            // A carry out of the top: one word more, whose lowest word is beyond the precision.
            return Self::normalised(large.negative, large.exponent + 64, [sum[0], sum[1], sum[2], sum[3], sum[4]]);
        }
        Self::normalised(large.negative, large.exponent, [sum[1], sum[2], sum[3], sum[4], sum[5]])
    }
}

impl Sub for Wide {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Wide {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self::ZERO;
        }
        let mut product = [0u64; 8];
        for i in (0..4).rev() {
            let mut carry = 0u128;
            for j in (0..4).rev() {
                let at = i + j + 1;
                let sum = u128::from(self.significand[i]) * u128::from(other.significand[j])
                    + u128::from(product[at])
                    + carry;
                product[at] = sum as u64;
                carry = sum >> 64;
            }
            product[i] = carry as u64;
        }
        let [a, b, c, d, e, ..] = product;
        Self::normalised(self.negative != other.negative, self.exponent + other.exponent, [a, b, c, d, e])
    }
}

impl Div for Wide {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let reciprocal = other.reciprocal();
        let quotient = self * reciprocal;
        // One step of residual correction, so that exact quotients come out exact to the last bits.
        quotient + (self - quotient * other) * reciprocal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wide(x: f64) -> Wide {
        Wide::from_f64(x)
    }

    #[test]
    fn converts_there_and_back_exactly() {
        for x in [0.0, 1.0, -1.5, 1e-300, f64::MAX, f64::MIN_POSITIVE, 5e-324, 0.1, -123456.789] {
            assert_eq!(wide(x).to_f64(), x);
        }
    }

    #[test]
    fn sums_keep_what_f64_loses() {
        let tiny = wide(1e-60);
        assert_eq!((wide(1.0) + tiny - wide(1.0)).to_f64(), 1e-60);
        assert_eq!((wide(1.0) - tiny - wide(1.0)).to_f64(), -1e-60);
        assert_eq!((wide(3.0) - wide(3.0)).to_f64(), 0.0);
        let almost = wide(1.0) - wide(2f64.powi(-255));
        assert_eq!((wide(1.0) - almost).to_f64(), 2f64.powi(-255));
        assert_eq!((wide(f64::MAX) + wide(f64::MAX)).scaled(-1).to_f64(), f64::MAX);
    }

    #[test]
    fn quotients_and_roots_multiply_back() {
        for x in [3.0, 0.7, 1e-200, 123_456_789.0, 2.0, 1.0 + f64::EPSILON] {
            let x = wide(x);
            let error = |a: Wide, b: Wide| ((a - b) / b).abs().to_f64();
            assert!(error(wide(1.0) / x * x, wide(1.0)) < 1e-76);
            assert!(error(x.sqrt() * x.sqrt(), x) < 2e-76);
        }
        assert_eq!(wide(9e8).sqrt().to_f64(), 3e4);
    }

    #[test]
    fn pi_satisfies_machins_formula() {
        // 16 arctan(1/5) − 4 arctan(1/239), by its own series in the same arithmetic.
        let arctan = |n: f64| {
            let (mut power, mut sum) = (wide(1.0) / wide(n), Wide::ZERO);
            for k in 0..120 {
                let term = power / wide(f64::from(2 * k + 1));
                sum = if k % 2 == 0 { sum + term } else { sum - term };
                power = power / wide(n * n);
            }
            sum
        };
        let pi = wide(16.0) * arctan(5.0) - wide(4.0) * arctan(239.0);
        assert!((pi - Wide::pi()).abs().to_f64() < 1e-74);
    }

    #[test]
    fn angles_add_up_in_every_octant() {
        // Rotating by the same angle twelve times is a full turn: the angles of (c, s)^k are k π/6.
        let (c, s) = (wide(3.0).sqrt() * wide(0.5), wide(0.5));
        let (mut x, mut y) = (wide(1.0), Wide::ZERO);
        for k in 0..12 {
            let turns = if k > 6 { k - 12 } else { k };
            if k != 6 {
                let expected = Wide::pi() * wide(f64::from(turns)) / wide(6.0);
                assert!((y.atan2(x) - expected).abs().to_f64() < 1e-74, "{k}");
            }
            (x, y) = (x * c - y * s, x * s + y * c);
        }
        assert_eq!(Wide::ZERO.atan2(wide(-1.0)), Wide::pi());
        assert_eq!(Wide::ZERO.atan2(Wide::ZERO).to_f64(), 0.0);
    }

    #[test]
    fn orders_numbers_of_either_sign() {
        let sorted = [-1e9, -2.0, -1.9999, -1e-9, 0.0, 1e-9, 1.0, 1.5, 1e9];
        for (i, &a) in sorted.iter().enumerate() {
            for (j, &b) in sorted.iter().enumerate() {
                assert_eq!(wide(a).partial_cmp(&wide(b)), Some(i.cmp(&j)), "{a} {b}");
            }
        }
    }
}
