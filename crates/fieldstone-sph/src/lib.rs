//! Weakly compressible smoothed particle hydrodynamics: δ-SPH with particle shifting and exact free-surface detection.

mod body;
mod body_state;
mod boundaries;
mod boundary_forces;
mod case;
mod checkpoint;
mod density_gradient;
mod energy;
mod error;
mod gauges;
mod ghosts;
mod kernel;
mod neighbour_list;
mod options;
mod phases;
mod points;
mod rates;
mod run;
mod shifting;
mod solver;
mod stage;
mod state;
mod surface_tension;

pub use body::{Body, Shape};
pub use boundaries::{Boundaries, MirrorWall, Slip};
pub use boundary_forces::BoundaryForces;
pub use case::{
    AxisName, BodySection, Case, CaseIntegrator, DomainSection, FillSection, FlowName, FluidSection, GaugeKind,
    GaugeSection, OutputSection, Pressure, PressureName, SHIPPED, Sections, ShapeName, ShiftingSection, ShippedCase,
    SlipName, TimeSection, WallKind, WallSection,
};
pub use energy::{Budget, Energies};
pub use error::SphError;
pub use gauges::{front, gauge_columns, gauge_row, level_over, pressure_at};
pub use kernel::WendlandC2;
pub use options::{FluidOptions, Integrator, ShiftingOptions, TimeStepOptions, Viscosity, sound_speed_bound};
pub use phases::{Phase, Phases};
pub use run::{Outcome, RunFolder, particles_of, run};
pub use solver::{Flow, Solver};
pub use state::State;
