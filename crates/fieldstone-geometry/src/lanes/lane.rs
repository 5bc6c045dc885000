//! Numbers that are computed with together, one or many.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use pulp::{Scalar, Simd, bytemuck};

use super::arctangent::atan2;
use super::inside::{Face, PlacedBalls};
use super::planes::{PlanesSeen, plane_by_plane};
use crate::edge_frames::EdgeFrames;

/// A number, or a register of numbers: what the kernels of this module are written in.
///
/// There is no NaN among them, so comparisons have two answers.
///
/// The provided methods go through axes, planes and angles one after another, each for a register of balls. Where there is one
/// ball, a register holds the axes, planes or angles instead, with the same bits.
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

    /// Whether [`Lanes::arc_tangents`] takes the time of one.
    const FOUR_AT_ONCE: bool = false;

    /// Squares of the distances to the nearest and to the farthest point of a box, both corners padded with 0.
    #[inline(always)]
    fn to_box(centre: &[Self; 3], [low, high]: &[[f64; 4]; 2]) -> (Self, Self) {
        let zero = centre[0].like(0.0);
        let (mut near2, mut far2) = (zero, zero);
        for k in 0..3 {
            let (to_low, to_high) = (centre[k] - zero.like(low[k]), zero.like(high[k]) - centre[k]);
            let gap = (-to_low).max(-to_high).max(zero);
            near2 = gap.mul_add(gap, near2);
            let far = to_low.abs().max(to_high.abs());
            far2 = far.mul_add(far, far2);
        }
        (near2, far2)
    }

    /// Writes the distances from all planes into the faces, and tells how the balls lie to them.
    #[inline(always)]
    fn planes<const N: usize>(
        frames: &EdgeFrames,
        balls: &PlacedBalls<Self>,
        faces: &mut [Face<Self>; N],
    ) -> PlanesSeen<Self> {
        plane_by_plane(frames, balls, faces)
    }

    /// Which balls reach a plane that any of them reaches.
    #[inline(always)]
    fn reaches(distance: Self) -> Self::Mask {
        distance.abs().less(distance.like(1.0))
    }

    /// Angles of four vectors (x, y).
    #[inline(always)]
    fn arc_tangents(y: [Self; 4], x: [Self; 4]) -> [Self; 4] {
        [atan2(y[0], x[0]), atan2(y[1], x[1]), atan2(y[2], x[2]), atan2(y[3], x[3])]
    }
}

/// Lanes of which there is one.
pub(crate) trait OneNumber: Lanes {
    fn number(self) -> f64;
}

impl OneNumber for Register<Scalar> {
    #[inline(always)]
    fn number(self) -> f64 {
        self.1
    }
}

const ALL_BUT_SIGN: u64 = !(1 << 63);
pub(super) const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
/// Minus the exponent of x, as bits, is this minus the exponent's bits of x.
pub(super) const TWICE_BIAS: u64 = 0x7fe0_0000_0000_0000;

/// A register: eight numbers with AVX-512, four with AVX2, one where nothing is known of the machine.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Register<S: Simd>(pub(super) S, pub(super) S::f64s);

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
        // Not `abs_f64s`, which is not always compiled into its caller.
        Self(self.0, self.0.and_f64s(self.1, self.0.splat_f64s(f64::from_bits(ALL_BUT_SIGN))))
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
    ($trait:ident, $method:ident, $instruction:ident) => {
        impl<S: Simd> $trait for Register<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0, self.0.$instruction(self.1, other.1))
            }
        }
    };
}

operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Neg for Register<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0, self.0.neg_f64s(self.1))
    }
}
