//! Readers and writers, one file per format.
//!
//! A format ends here: readers return [`fieldstone_particles::Particles`] or [`fieldstone_mesh::Mesh`], so that
//! no other crate knows one file format from another.

mod atomic_file;
mod data_array;
mod error;
mod frames;
pub mod source;
pub mod vtk;

pub use atomic_file::AtomicFile;
pub use data_array::{DataArray, Values};
pub use error::{IoError, Position};
pub use frames::FrameReader;
