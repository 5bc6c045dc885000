//! One ball on a machine with registers of four numbers.

use std::ops::{Add, Div, Mul, Neg, Sub};

use pulp::x86::V3;
use pulp::{bytemuck, f64x4, m64x4};

use super::arctangent::atan2;
use super::inside::{Face, PlacedBalls};
use super::lane::{EXPONENT, Lanes, OneNumber, Register, TWICE_BIAS};
use super::planes::{APART, PlanesSeen};
use crate::edge_frames::EdgeFrames;

/// One number, with the bits that the registers of the machine give; axes, planes and angles go four to a register.
///
/// Never eight, even where the machine has registers for that: one operation of eight numbers slows down all that follow by
/// a tenth. So the compiler must not make any of its own: see [`Face`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Single(pub V3, pub f64);

// No closures where registers are computed with: they would not be compiled for the machine's registers.

/// A bit for each answer.
#[inline(always)]
fn bits(simd: V3, answers: m64x4) -> u32 {
    simd.avx._mm256_movemask_pd(bytemuck::cast(answers)) as u32
}

/// The square of the length of the first three numbers.
#[inline(always)]
fn length2(simd: V3, v: f64x4) -> Single {
    Single(simd, v.2.mul_add(v.2, v.1.mul_add(v.1, v.0 * v.0)))
}

#[inline(always)]
fn register(v: [Single; 4]) -> Register<V3> {
    Register(v[0].0, f64x4(v[0].1, v[1].1, v[2].1, v[3].1))
}

impl Lanes for Single {
    type Mask = bool;

    const FOUR_AT_ONCE: bool = true;

    #[inline(always)]
    fn like(self, x: f64) -> Self {
        Self(self.0, x)
    }

    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        Self(self.0, self.1.mul_add(factor.1, term.1))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0, self.1.sqrt())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0, self.1.abs())
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0, if self.1 < other.1 { self.1 } else { other.1 })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0, if self.1 > other.1 { self.1 } else { other.1 })
    }

    #[inline(always)]
    fn less(self, other: Self) -> bool {
        self.1 < other.1
    }

    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        Self(self.0, self.1.copysign(other.1))
    }

    #[inline(always)]
    fn inverse_power_of_two(self) -> Self {
        Self(self.0, f64::from_bits(TWICE_BIAS.wrapping_sub(self.1.to_bits() & EXPONENT)))
    }

    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }

    #[inline(always)]
    fn to_box(centre: &[Self; 3], [low, high]: &[[f64; 4]; 2]) -> (Self, Self) {
        let simd = centre[0].0;
        let c = f64x4(centre[0].1, centre[1].1, centre[2].1, 0.0);
        let (to_low, to_high) = (simd.sub_f64x4(c, bytemuck::cast(*low)), simd.sub_f64x4(bytemuck::cast(*high), c));
        let zero = simd.splat_f64x4(0.0);
        let outside = simd.max_f64x4(simd.sub_f64x4(zero, to_low), simd.sub_f64x4(zero, to_high));
        let gap = simd.max_f64x4(outside, zero);
        let far = simd.max_f64x4(simd.abs_f64x4(to_low), simd.abs_f64x4(to_high));
        (length2(simd, gap), length2(simd, far))
    }

    #[inline(always)]
    fn planes<const N: usize>(
        frames: &EdgeFrames,
        balls: &PlacedBalls<Self>,
        faces: &mut [Face<Self>; N],
    ) -> PlanesSeen<Self> {
        let simd = balls.scale.0;
        let [x, y, z] = balls.centre;
        let (x, y, z) = (simd.splat_f64x4(x.1), simd.splat_f64x4(y.1), simd.splat_f64x4(z.1));
        let (scale, resolution) = (simd.splat_f64x4(balls.scale.1), simd.splat_f64x4(balls.resolution.1));
        let (zero, one) = (simd.splat_f64x4(0.0), simd.splat_f64x4(1.0));
        let (minus_one, far) = (simd.splat_f64x4(-1.0), simd.splat_f64x4(APART));
        let (mut in_reach, mut hidden) = (0, 0u32);
        let (mut apart, mut beyond, mut outside) = (0, 0, 0);
        for (block, (planes, faces)) in frames.blocks.iter().zip(faces.chunks_exact_mut(4)).enumerate() {
            let [nx, ny, nz, offset]: [f64x4; 4] = bytemuck::cast(*planes);
            let xy = simd.mul_add_f64x4(ny, y, simd.mul_add_f64x4(nx, x, offset));
            let distance = simd.mul_f64x4(simd.mul_add_f64x4(nz, z, xy), scale);
            let size = simd.abs_f64x4(distance);
            in_reach |= bits(simd, simd.cmp_lt_f64x4(size, one)) << (4 * block);
            hidden |= bits(simd, simd.cmp_lt_f64x4(size, resolution)) << (4 * block);
            apart |= bits(simd, simd.cmp_lt_f64x4(distance, far));
            beyond |= bits(simd, simd.cmp_le_f64x4(distance, minus_one));
            outside |= bits(simd, simd.cmp_lt_f64x4(distance, zero));
            let distances: [f64; 4] = bytemuck::cast(distance);
            for (face, distance) in faces.iter_mut().zip(distances) {
                face.distance = Self(simd, distance);
            }
        }
        PlanesSeen {
            in_reach,
            apart: apart != 0,
            beyond: beyond != 0,
            centre_inside: outside == 0,
            unresolved: hidden & hidden.wrapping_sub(1) != 0,
        }
    }

    /// There is no other ball that might have been meant.
    #[inline(always)]
    fn reaches(_: Self) -> bool {
        true
    }

    #[inline(always)]
    fn arc_tangents(y: [Self; 4], x: [Self; 4]) -> [Self; 4] {
        let simd = y[0].0;
        let [a, b, c, d]: [f64; 4] = bytemuck::cast(atan2(register(y), register(x)).1);
        [Self(simd, a), Self(simd, b), Self(simd, c), Self(simd, d)]
    }
}

impl OneNumber for Single {
    #[inline(always)]
    fn number(self) -> f64 {
        self.1
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Single {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0, self.1 $op other.1)
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Neg for Single {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0, -self.1)
    }
}
