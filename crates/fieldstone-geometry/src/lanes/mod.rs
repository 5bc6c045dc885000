//! The kernel for convex pieces from what of them is inside the ball: for one ball, or for as many as a register holds.
//!
//! [`pulp`] picks AVX-512, AVX2 or the baseline when the program starts. A register holds balls where there are many; one ball has its
//! axes, planes and angles in registers instead. [`crate::face_terms`] stays the reference; angles come from
//! [`arctangent`].

mod arctangent;
mod inside;
mod lane;
mod planes;
#[cfg(target_arch = "x86_64")]
mod single;

pub(crate) use inside::{PlacedBalls, sums_inside};
pub(crate) use lane::{Lanes, OneNumber, Register};
#[cfg(target_arch = "x86_64")]
pub(crate) use single::Single;
