//! Arithmetic beyond `f64`: wider numbers, and numbers that know their own rounding error.

mod arctangent;
mod tracked;
mod wide;

pub use tracked::Tracked;
pub use wide::Wide;

pub(crate) use arctangent::atan2_by_halving;
