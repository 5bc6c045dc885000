//! Polyhedral meshes and Cartesian grids.

mod cell_list;
mod error;
mod mesh;

pub use cell_list::CellList;
pub use error::MeshError;
pub use mesh::{Mesh, MeshParts, Patch, Zone};
