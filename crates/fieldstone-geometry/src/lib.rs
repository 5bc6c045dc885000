//! Exact overlap of balls with polyhedra.

mod element;

pub use element::{CornerOrder, ElementKind};
