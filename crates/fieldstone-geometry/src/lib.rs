//! Exact overlap of balls with polyhedra.
//!
//! [`overlap_volume`] and [`overlap`] take any closed polyhedron with planar faces (others are triangulated when
//! it is built) and a ball of any size, and return volume, sphere area, face areas and gradient as sums over
//! directed edges; [`face_terms`] has the formulas. They promise an error below 1e-12 of the smaller volume: where a
//! bound of the rounding errors in `f64` exceeds that, the same formulas run in more digits ([`certified_overlap`]).
//! [`fast_overlap_volume`] stays in `f64` and returns the bound. [`decomposition`] is the method of Strobl et al. by caps, wedges and
//! cones, an independent check.
//!
//! All lengths are in one unit of the user's choice; nothing depends on which.

mod ball;
mod batch;
mod cap;
mod certified;
mod corner_volume;
pub mod decomposition;
pub mod double_double;
mod edge_frames;
mod element;
mod face_terms;
mod inside;
mod lanes;
mod moments;
mod overlap;
mod polygon;
mod polyhedron;
pub mod precision;
mod real;
mod vector;

pub use ball::{Ball, BallError};
pub use batch::OverlapBatch;
pub use cap::{cap_area, cap_volume};
pub use certified::{CertifiedOverlap, PROMISE, Precision, certified_overlap, overlap_in};
pub use corner_volume::corner_volume;
pub use element::{CornerOrder, ElementKind};
pub use face_terms::{FaceTerms, face_terms, polygon_solid_angle};
pub use moments::{Moments, overlap_moments};
pub use overlap::{ErrorBound, Overlap, fast_overlap, fast_overlap_volume, overlap, overlap_volume, volume_from_terms};
pub use polygon::{flatness, is_exactly_planar, polygon_area_vector, polygon_centroid, polygon_warp, warp_bound};
pub use polyhedron::{ElementError, Orientation, PLANARITY, Polyhedron};
pub use real::Real;
pub use vector::Vector;
