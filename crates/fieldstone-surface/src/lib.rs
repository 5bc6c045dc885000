//! Free-surface particles of smoothed particle hydrodynamics (SPH): exact labels, and seven other methods to compare.
//!
//! A particle is on the free surface if a cone of half-angle θ from it holds no neighbour within R ([`ScanningCone`];
//! the paper's θ = 45° and R = 2.5 Δx are the default). [`Exact`] decides that for every particle in about a
//! microsecond, neighbour search included; [`Geometrical`] is the same criterion by the published algorithm. The others
//! are what SPH codes use instead.
//!
//! | method | dimensions | criterion | source |
//! |---|---|---|---|
//! | [`Exact`] | 2, 3 | an empty cone | `liu2022` |
//! | [`Geometrical`] | 2, 3 | the same, as printed | `liu2022`, Algorithm 1 |
//! | [`SemiGeometrical`] | 2, 3 | position divergence, then an empty cone | `liu2022`, Eq. 29, 30 |
//! | [`Sun`] | 2 | an empty sector | Sun et al., in `liu2022` |
//! | [`Dilts`] | 2 | the particle's circle is exposed | `dilts2000` |
//! | [`Haque`] | 3 | the particle's sphere is exposed | `haque2007` |
//! | [`Marrone`] | 2, 3 | eigenvalue, then an umbrella along the normal | `marrone2010` |
//! | [`Wang`] | 2, 3 | position divergence, then an umbrella along the normal | `wang2019` |
//!
//! All implement [`SurfaceDetection`] on a [`Scene`]: particles sorted by a
//! [`NeighbourGrid`](fieldstone_particles::NeighbourGrid), with images behind [`Wall`]s and periodic boundaries. A
//! solver makes a scene of what it has; [`detect_surface`] does everything from positions on. [`exposure`] is the
//! continuous form of the criterion, [`normals`] and [`levels`] go with the labels, [`Comparison`] and [`sensitivity`]
//! judge them.
//!
//! From the labels on: [`level_set`] and [`density_field`] say on [`Nodes`] where the fluid is, [`iso_surface`] makes a
//! closed [`TriangleMesh`] of it, and [`interpolate`] brings quantities of particles to nodes or to the surface.
//!
//! Labels do not depend on the number of threads, nor on the processor.

mod arc_cover;
mod comparison;
mod cone;
mod density_field;
mod detection;
mod dilts;
mod divergence_thresholds;
mod error;
mod estimate_spacing;
mod exact;
mod exposed_ball;
mod exposure;
mod fluid_region;
mod geometrical;
mod haque;
mod intervals;
mod iso_surface;
mod kernel;
mod level_set;
mod levels;
mod marrone;
mod method;
mod moments;
mod moving_least_squares;
mod neighbourhood;
mod nodes;
mod normals;
mod perturbed_surface;
mod plausibility;
mod scan;
mod scene;
mod semi_geometrical;
mod sensitivity;
mod sun;
mod surface;
mod surroundings;
mod triangle_mesh;
mod umbrella;
mod walls;
mod wang;
mod wendland_c2;

pub use comparison::Comparison;
pub use cone::ScanningCone;
pub use density_field::density_field;
pub use detection::{Detection, SurfaceDetection, TIE};
pub use dilts::Dilts;
pub use divergence_thresholds::{Depth, DivergenceThresholds, lattice_divergence};
pub use error::SurfaceError;
pub use estimate_spacing::estimate_spacing;
pub use exact::{Exact, WitnessCache};
pub use exposure::{Exposure, exposure};
pub use fluid_region::PeriodicFaces;
pub use geometrical::Geometrical;
pub use haque::Haque;
pub use iso_surface::{Walls, iso_surface};
pub use kernel::{Kernel, Smoothing};
pub use level_set::{LevelSetOptions, SurfaceDistance, level_set};
pub use levels::levels;
pub use marrone::Marrone;
pub use method::Method;
pub use moving_least_squares::{Column, Interpolated, Support, interpolate};
pub use nodes::{NodeField, Nodes};
pub use normals::normals;
pub use perturbed_surface::{InnerParticles, PerturbedSurface};
pub use plausibility::implausibilities;
pub use scene::Scene;
pub use semi_geometrical::SemiGeometrical;
pub use sensitivity::{Sensitivity, sensitivity};
pub use sun::Sun;
pub use surface::{Surface, SurfaceOptions, detect_surface};
pub use surroundings::Surroundings;
pub use triangle_mesh::{Topology, TriangleMesh};
pub use walls::{Wall, wall_images};
pub use wang::Wang;
pub use wendland_c2::WendlandC2;
