//! Cells that balls are binned into exactly: polyhedral meshes, Cartesian and cylindrical grids.
//!
//! [`Mesh`] is OpenFOAM's idea: points, faces, owner, neighbour. Each face that is not planar is split once into
//! triangles around its area-weighted centroid, so both its cells see one surface and nothing is lost between
//! them; for each ball a face is evaluated once and counted with opposite signs on its two sides. [`Grid`] is a
//! Cartesian grid with the closed form for boxes, [`CylinderGrid`] shells, rings and sectors around an axis. All
//! implement [`Cells`]; meshes and Cartesian grids also [`Faces`].

mod alone;
mod ball_overlap;
mod cell_list;
mod cell_tree;
mod cells;
mod coordinates;
mod cuboid_overlap;
mod cylinder;
mod cylinder_overlap;
mod error;
#[cfg(test)]
mod error_bounds;
mod face_inside;
mod faces;
mod from_cells;
mod grid;
mod grid_faces;
mod locate;
mod mesh;
mod mesh_cells;
mod mesh_faces;
mod ring_points;
mod rings;
mod shape;
mod surface;

pub use ball_overlap::{CellOverlap, MeshScratch};
pub use cell_list::CellList;
pub use cells::{Cells, ElementSink, PathCounts};
pub use coordinates::Coordinates;
pub use cylinder::CylinderGrid;
pub use error::MeshError;
pub use faces::Faces;
pub use grid::{Grid, GridScratch};
pub use mesh::{Mesh, MeshParts, Patch, Zone};
