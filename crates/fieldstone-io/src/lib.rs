//! Readers and writers, one file per format.
//!
//! A format ends here: readers return [`fieldstone_particles::Particles`], [`fieldstone_particles::Contacts`] or
//! [`fieldstone_mesh::Mesh`], so that no other crate knows one file format from another.
//!
//! | to read | use |
//! |---|---|
//! | one frame of particles, whatever the format | [`read_frame`] |
//! | frames one by one | [`open_particles`], a [`FrameReader`] |
//! | contacts of a frame | [`open_contacts`], a [`ContactReader`] |
//! | many frames with their contacts, from many files, on a thread of their own | [`Series`] |
//! | what MercuryDPM keeps apart: densities, walls, periodic boundaries | [`read_restart`] |
//! | a mesh | [`read_mesh`] |
//! | a surface of triangles | [`read_stl`] |
//! | coarse-grained fields as MercuryCG writes them | [`read_stat`], [`StatWriter`] |

mod assembly;
mod atomic_file;
mod bgeo;
mod column_names;
mod columns;
mod contact_assembly;
mod contact_columns;
mod contact_dump;
mod contact_repeats;
mod contact_resolver;
mod contact_table;
mod contacts;
mod csv;
mod csv_write;
mod data_array;
mod dump;
mod dump_box;
mod dump_stream;
mod error;
mod frame_range;
mod frames;
mod gmsh;
mod lammps_walls;
mod line_blocks;
mod lines;
mod mercury;
mod mercury_contacts;
mod mercury_restart;
mod meshes;
mod number_rows;
mod obj_write;
pub mod openfoam;
mod particles;
mod ply;
mod ply_write;
mod point_columns;
mod series;
pub mod source;
mod stat;
mod stl;
mod stl_write;
mod surface_check;
mod units;
pub mod vtk;
mod xyz;

pub use atomic_file::AtomicFile;
pub use bgeo::read_bgeo;
pub use contact_columns::ContactColumns;
pub use contact_dump::ContactDumpReader;
pub use contact_table::ContactTableReader;
pub use contacts::{ContactOptions, ContactPreset, ContactReader, FrameStamp, open_contacts};
pub use csv::{CsvReader, CsvTable, Separator};
pub use csv_write::{CsvWriter, write_csv, write_number, write_particles_csv, write_particles_csv_named};
pub use data_array::{DataArray, Values};
pub use dump::DumpReader;
pub use error::{IoError, Position};
pub use frame_range::{FrameRange, find_files, find_times};
pub use frames::FrameReader;
pub use gmsh::read_gmsh;
pub use lammps_walls::lammps_wall_contacts;
pub use mercury::MercuryReader;
pub use mercury_contacts::MercuryContactReader;
pub use mercury_restart::{MercuryRestart, MercurySpecies, MercuryWall, read_restart};
pub use meshes::{FileKind, file_kind, read_mesh};
pub use number_rows::read_number_rows;
pub use obj_write::write_obj;
pub use particles::{OneFrame, ParticleOptions, open_particles, read_frame, read_frame_with_warnings};
pub use ply::read_ply;
pub use ply_write::write_ply;
pub use series::{BackgroundSeries, ContactFiles, Series, SeriesFrame};
pub use stat::{StatBlock, StatField, StatFile, StatHeader, StatWriter, read_stat};
pub use stl::read_stl;
pub use stl_write::write_stl;
pub use xyz::XyzReader;
