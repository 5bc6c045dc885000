//! Weakly compressible smoothed particle hydrodynamics: δ-SPH with particle shifting and exact free-surface detection.
//!
//! A [`Solver`] advances a [`State`] (position, velocity, density of every fluid particle) under a [`Flow`]: the fluid
//! and its discretisation ([`FluidOptions`]), what is around it ([`Boundaries`]), and how time advances
//! ([`TimeStepOptions`]). A [`Case`] reads all that from TOML, [`run`] takes it to its end with a series of particle
//! files, gauges and checkpoints.
//!
//! $$ \frac{D\rho_i}{Dt} = -\rho_i\sum_j (u_j - u_i)\cdot\nabla_iW_{ij}V_j + \delta h c_0 D_i, \qquad
//!    p = c_0^2(\rho - \rho_0) $$
//! $$ \frac{Du_i}{Dt} = -\frac1{\rho_i}\sum_j(p_i + p_j)\nabla_iW_{ij}V_j + \frac{2(d+2)\mu}{\rho_i}\sum_j
//!    \pi_{ij}\nabla_iW_{ij}V_j + g + \frac{1}{\rho_i}f^s_i $$
//!
//! | what | where | source |
//! |---|---|---|
//! | state equation, bound of c₀ | [`FluidOptions`], [`sound_speed_bound`] | `liu2022`, Eq. 2, 3 |
//! | kernel | [`WendlandC2`] | Eq. 8, 9 |
//! | δ diffusion with the corrected gradient | in [`Solver::step`] | Eq. 5, 6 |
//! | particle shifting | [`ShiftingOptions`] | Eq. 10, 11 |
//! | free surface | any [`fieldstone_surface::Method`] | Sec. 3 |
//! | mirror walls, periodic faces, openings, bodies | [`Boundaries`], [`MirrorWall`], [`Body`] | |
//! | bodies and fills of any shape | [`ClosedSurface`] | |
//! | prescribed motion of bodies | [`Motion`] | `adami2012`, `fritsch1984` |
//! | energies and momentum, what was gained and lost | [`Energies`], [`Budget`], [`MomentumBudget`] | |
//!
//! Results are the same bits for any number of threads, and for a run that was stopped and resumed.
//!
//! A column of water falls for a tenth of a second, and its energy is accounted for:
//!
//! ```
//! use fieldstone_sph::{Case, SHIPPED};
//! let text = SHIPPED.iter().find(|c| c.name == "column-1-2").map_or("", |c| c.text);
//! let case = Case::parse(text, "column-1-2")?.with_spacing(0.0146)?;
//! let mut solver = case.solver()?;
//! while solver.time() < 0.1 {
//!     solver.step()?;
//! }
//! let front = fieldstone_sph::front(&solver, fieldstone_sph::DirectionName::X);
//! assert!(front > 0.16 && front < 0.25);
//! let released = solver.budget().start - solver.energies().potential;
//! assert!(released > 0.0 && solver.energy_residual().abs() < 0.01 * released);
//! # Ok::<(), fieldstone_sph::SphError>(())
//! ```

mod body;
mod body_repeats;
mod body_state;
mod boundaries;
mod boundary_forces;
mod case;
mod cells;
mod checkpoint;
mod closed_surface;
mod cluster;
mod density_gradient;
mod energy;
mod error;
mod flow;
mod gauges;
mod ghosts;
mod identity;
mod motion;
mod neighbour_count;
mod neighbour_list;
mod options;
mod pair;
mod parameter;
mod phases;
mod points;
mod rates;
mod run;
mod shifting;
mod solver;
mod spatial_order;
mod stability;
mod stage;
mod state;
mod surface_tension;
mod triangle_tree;

pub use body::{Body, Shape};
pub use boundaries::{Boundaries, MirrorWall, Slip};
pub use boundary_forces::BoundaryForces;
pub use case::{
    AxisName, BodyAtWall, BodySection, Case, CaseIntegrator, DirectionName, DomainSection, FillBesideWall, FillSection,
    FlowName, FluidSection, GaugeKind, GaugeSection, MotionSection, OutputSection, Prepared, Pressure, PressureName,
    SHIPPED, Sections, ShapeName, ShiftingSection, ShippedCase, SlipName, TimeSection, WallKind, WallSection,
};
pub use closed_surface::ClosedSurface;
pub use energy::{Budget, Energies, MomentumBudget};
pub use error::SphError;
pub use flow::Flow;
pub use gauges::{front, gauge_columns, gauge_row, level_over, pressure_at};
pub use motion::{Motion, Pose};
pub use options::{FluidOptions, Integrator, ShiftingOptions, TimeStepOptions, Viscosity, sound_speed_bound};
pub use parameter::Parameter;
pub use phases::{Phase, Phases};
pub use run::{Outcome, RunFolder, particles_of, run};
pub use solver::Solver;
pub use state::State;

#[doc(inline)]
pub use fieldstone_surface::WendlandC2;
