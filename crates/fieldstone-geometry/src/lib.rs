//! Exact overlap of balls with polyhedra.
//!
//! [`overlap_volume`] and [`overlap`] take any closed polyhedron with planar faces (others are triangulated when
//! it is built) and a ball of any size, and return volume, sphere area, face areas and gradient as sums over
//! directed edges; [`face_terms`] has the formulas.
//!
//! All lengths are in one unit of the user's choice; nothing depends on which.

mod ball;
mod cap;
mod certified;
mod corner_volume;
pub mod decomposition;
pub mod double_double;
mod element;
mod face_terms;
mod overlap;
mod polygon;
mod polyhedron;
pub mod precision;
mod real;
mod vector;

pub use ball::{Ball, BallError};
pub use cap::{cap_area, cap_volume};
pub use certified::{CertifiedOverlap, PROMISE, Precision, certified_overlap};
pub use corner_volume::corner_volume;
pub use element::{CornerOrder, ElementKind};
pub use face_terms::{FaceTerms, face_terms, polygon_solid_angle};
pub use overlap::{Overlap, error_estimate, overlap, overlap_volume, volume_from_terms};
pub use polygon::{polygon_area_vector, polygon_centroid, polygon_warp};
pub use polyhedron::{ElementError, Orientation, PLANARITY, Polyhedron};
pub use real::Real;
pub use vector::Vector;
