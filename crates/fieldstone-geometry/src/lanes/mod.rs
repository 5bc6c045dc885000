//! The kernel for convex pieces from what of them is inside the ball: for one ball, or for as many as a register holds.
//!
//! [`pulp`] picks AVX-512, AVX2 or the baseline when the program starts. [`crate::face_terms`] stays the reference;
//! angles come from [`arctangent`].

mod arctangent;
mod inside;
mod lane;

pub(crate) use inside::{NEAR2, PlacedBalls, sums_inside};
pub(crate) use lane::{Lanes, Register, Single};
