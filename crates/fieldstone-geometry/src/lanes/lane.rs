//! Numbers that are computed with together, one or many.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use pulp::{Simd, bytemuck};

/// A number, or a register of numbers: what the kernels of this module are written in.
///
/// There is no NaN among them, so comparisons have two answers.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// An answer for each of the numbers.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask> + Not<Output = Self::Mask>;

    /// `x` in every place; `self` only says of what kind.
    fn like(self, x: f64) -> Self;
    /// self · factor + term, rounded once where the machine can.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    fn sqrt(self) -> Self;
    fn abs(self) -> Self;
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
    fn less(self, other: Self) -> Self::Mask;
    /// The magnitude of this with the sign of the other.
    fn with_sign_of(self, other: Self) -> Self;
    /// The power of two $2^{-e}$ of a positive number $x = m 2^e$, 1 ≤ m < 2.
    fn inverse_power_of_two(self) -> Self;

    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    fn any(mask: Self::Mask) -> bool;
}

const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
/// Minus the exponent of x, as bits, is this minus the exponent's bits of x.
const TWICE_BIAS: u64 = 0x7fe0_0000_0000_0000;

/// One number; FUSED as the registers of the same machine, so that the bits are the same.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Single<const FUSED: bool>(pub f64);

impl<const FUSED: bool> Lanes for Single<FUSED> {
    type Mask = bool;

    #[inline(always)]
    fn like(self, x: f64) -> Self {
        Self(x)
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(if FUSED { self.0.mul_add(factor.0, term.0) } else { self.0 * factor.0 + term.0 })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(if self.0 < other.0 { self.0 } else { other.0 })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(if self.0 > other.0 { self.0 } else { other.0 })
    }

    #[inline(always)]
    fn less(self, other: Self) -> bool {
        self.0 < other.0
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        Self(self.0.copysign(other.0))
    }

    #[inline(always)]
    fn inverse_power_of_two(self) -> Self {
        Self(f64::from_bits(TWICE_BIAS.wrapping_sub(self.0.to_bits() & EXPONENT)))
    }

    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }
}

/// A register: eight numbers with AVX-512, four with AVX2.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Register<S: Simd>(S, S::f64s);

impl<S: Simd> Register<S> {
    /// Whether a product and a sum are rounded once: where it would not be one instruction, it would be a slow call.
    pub const FUSED: bool = S::F64_LANES >= 4;

    /// The first numbers of a slice, as many as fit.
    #[inline(always)]
    pub fn load(simd: S, numbers: &[f64]) -> Self {
        Self(simd, S::as_simd_f64s(numbers).0[0])
    }

    #[inline(always)]
    pub fn store(self, numbers: &mut [f64]) {
        S::as_mut_simd_f64s(numbers).0[0] = self.1;
    }

    #[inline(always)]
    pub fn splat(simd: S, x: f64) -> Self {
        Self(simd, simd.splat_f64s(x))
    }
}

impl<S: Simd> Lanes for Register<S> {
    type Mask = Answers<S>;

    #[inline(always)]
    fn like(self, x: f64) -> Self {
        Self::splat(self.0, x)
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        if Self::FUSED { Self(self.0, self.0.mul_add_e_f64s(self.1, factor.1, term.1)) } else { self * factor + term }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0, self.0.sqrt_f64s(self.1))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0, self.0.abs_f64s(self.1))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0, self.0.min_f64s(self.1, other.1))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0, self.0.max_f64s(self.1, other.1))
    }

    #[inline(always)]
    fn less(self, other: Self) -> Answers<S> {
        Answers(self.0, self.0.less_than_f64s(self.1, other.1))
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        let sign = self.0.and_f64s(other.1, self.0.splat_f64s(-0.0));
        Self(self.0, self.0.or_f64s(self.abs().1, sign))
    }

    #[inline(always)]
    fn inverse_power_of_two(self) -> Self {
        let exponent = self.0.and_f64s(self.1, self.0.splat_f64s(f64::from_bits(EXPONENT)));
        let bits = self.0.sub_u64s(self.0.splat_u64s(TWICE_BIAS), bytemuck::cast(exponent));
        Self(self.0, bytemuck::cast(bits))
    }

    #[inline(always)]
    fn select(mask: Answers<S>, yes: Self, no: Self) -> Self {
        Self(yes.0, yes.0.select_f64s(mask.1, yes.1, no.1))
    }

    #[inline(always)]
    fn any(mask: Answers<S>) -> bool {
        bytemuck::bytes_of(&mask.1).iter().any(|&byte| byte != 0)
    }
}

/// An answer for each number of a register.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answers<S: Simd>(S, S::m64s);

impl<S: Simd> BitAnd for Answers<S> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0, self.0.and_m64s(self.1, other.1))
    }
}

impl<S: Simd> BitOr for Answers<S> {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0, self.0.or_m64s(self.1, other.1))
    }
}

impl<S: Simd> Not for Answers<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0, self.0.not_m64s(self.1))
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt, $instruction:ident) => {
        impl<const FUSED: bool> $trait for Single<FUSED> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0 $op other.0)
            }
        }

        impl<S: Simd> $trait for Register<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0, self.0.$instruction(self.1, other.1))
            }
        }
    };
}

operator!(Add, add, +, add_f64s);
operator!(Sub, sub, -, sub_f64s);
operator!(Mul, mul, *, mul_f64s);
operator!(Div, div, /, div_f64s);

impl<const FUSED: bool> Neg for Single<FUSED> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<S: Simd> Neg for Register<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0, self.0.neg_f64s(self.1))
    }
}
