//! Readers and writers, one file per format.
//!
//! A format ends here: readers return [`fieldstone_particles::Particles`] or [`fieldstone_mesh::Mesh`], so that
//! no other crate knows one file format from another.

mod assembly;
mod atomic_file;
mod columns;
mod csv;
mod csv_write;
mod data_array;
mod dump;
mod dump_box;
mod error;
mod frames;
mod gmsh;
mod lines;
mod mercury;
mod meshes;
pub mod openfoam;
mod particles;
pub mod source;
pub mod vtk;
mod xyz;

pub use atomic_file::AtomicFile;
pub use csv::{CsvReader, CsvTable, Separator};
pub use csv_write::{CsvWriter, write_csv, write_particles_csv};
pub use data_array::{DataArray, Values};
pub use dump::DumpReader;
pub use error::{IoError, Position};
pub use frames::FrameReader;
pub use gmsh::read_gmsh;
pub use mercury::MercuryReader;
pub use meshes::{FileKind, file_kind, read_mesh};
pub use particles::{OneFrame, ParticleOptions, open_particles, read_frame};
pub use xyz::XyzReader;
