//! fieldstone turns particles into fields, exactly.
//!
//! This crate gathers the others under one name; each works alone, too.
//!
//! | module | what |
//! |---|---|
//! | [`geometry`] | ball ∩ polyhedron: exact volumes, areas, gradients |
//! | [`mesh`] | polyhedral meshes, Cartesian and cylindrical grids, ball-in-mesh |
//! | [`particles`] | particle sets, contacts, periodic boxes, neighbour search |
//! | [`fields`] | solid fractions, coarse graining |
//! | [`surface`] | free-surface particles, level sets, iso-surfaces |
//! | [`sph`] | the δ-SPH solver and its cases |
//! | [`io`] | OpenFOAM, Gmsh, VTK, LIGGGHTS and LAMMPS dumps, CSV, … |
//!
//! The solid fraction of one cell of a simple cubic packing:
//!
//! ```
//! use fieldstone::fields::{SolidFractionOptions, solid_fraction};
//! use fieldstone::{mesh::Grid, particles::Particles};
//!
//! let grid = Grid::new([0.0; 3], [2.0; 3], [2, 2, 2])?;
//! let centres = (0..8).map(|i| [0, 1, 2].map(|k| f64::from(i >> k & 1) + 0.5)).collect();
//! let balls = Particles::new(centres)?.with_uniform_radius(0.5)?;
//! let result = solid_fraction(&grid, &balls, &SolidFractionOptions::default())?;
//! assert!(result.solid_fraction.iter().all(|f| (f - std::f64::consts::PI / 6.0).abs() < 1e-15));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use fieldstone_fields as fields;
pub use fieldstone_geometry as geometry;
pub use fieldstone_io as io;
pub use fieldstone_mesh as mesh;
pub use fieldstone_particles as particles;
pub use fieldstone_sph as sph;
pub use fieldstone_surface as surface;
