//! The kernel for many faces at once, in lanes of eight `f64`.
//!
//! Plain loops over arrays of eight numbers, which the compiler turns into the vector instructions of the machine that it runs
//! on: [`pulp`] picks AVX-512, AVX2 or the baseline when the program starts. The formulas are those of
//! [`crate::face_terms`], which stays the reference; angles come from [`arctangent`].

mod arctangent;
mod faces;
mod lane;

pub(crate) use faces::{FaceBatch, PlaneFace};
