//! Eight numbers that are computed with together.

// Counted loops over two arrays: iterators would hide them from the vectoriser, or at least from the reader.
#![allow(clippy::needless_range_loop)]

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers in a lane: one register of AVX-512, two of AVX2, four of the x86-64 baseline.
pub(crate) const WIDTH: usize = 8;

/// Eight `f64`.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Lane(pub [f64; WIDTH]);

/// Eight answers, all bits set for yes.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Mask(pub [u64; WIDTH]);

impl Lane {
    #[inline(always)]
    pub fn splat(x: f64) -> Self {
        Self([x; WIDTH])
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = [0.0; WIDTH];
        for k in 0..WIDTH {
            out[k] = f(self.0[k], other.0[k]);
        }
        Self(out)
    }

    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(f64, f64) -> bool) -> Mask {
        let mut out = [0; WIDTH];
        for k in 0..WIDTH {
            out[k] = if f(self.0[k], other.0[k]) { u64::MAX } else { 0 };
        }
        Mask(out)
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    /// The smaller; plain comparison, since the kernel has no NaN.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    pub fn less(self, other: Self) -> Mask {
        self.compare(other, |a, b| a < b)
    }

    /// The magnitude of this with the sign of the other.
    #[inline(always)]
    pub fn with_sign_of(self, other: Self) -> Self {
        self.zip(other, f64::copysign)
    }
}

impl Mask {
    #[inline(always)]
    pub fn select(self, yes: Lane, no: Lane) -> Lane {
        let mut out = [0.0; WIDTH];
        for k in 0..WIDTH {
            out[k] = if self.0[k] != 0 { yes.0[k] } else { no.0[k] };
        }
        Lane(out)
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(u64, u64) -> u64) -> Self {
        let mut out = [0; WIDTH];
        for k in 0..WIDTH {
            out[k] = f(self.0[k], other.0[k]);
        }
        Self(out)
    }

    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        self.zip(other, |a, b| a & b)
    }

    #[inline(always)]
    pub fn or(self, other: Self) -> Self {
        self.zip(other, |a, b| a | b)
    }

    #[inline(always)]
    pub fn not(self) -> Self {
        Self(self.0.map(|a| !a))
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Lane {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $op b)
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Neg for Lane {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|a| -a))
    }
}

/// Eight vectors.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vectors {
    pub x: Lane,
    pub y: Lane,
    pub z: Lane,
}

impl Vectors {
    #[inline(always)]
    pub fn zero() -> Self {
        Self { x: Lane::splat(0.0), y: Lane::splat(0.0), z: Lane::splat(0.0) }
    }

    /// Puts a vector into one of the eight places.
    #[inline(always)]
    pub fn set(&mut self, place: usize, v: [f64; 3]) {
        self.x.0[place] = v[0];
        self.y.0[place] = v[1];
        self.z.0[place] = v[2];
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> Lane {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }

    #[inline(always)]
    pub fn times(self, factor: Lane) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}
