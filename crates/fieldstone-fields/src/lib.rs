//! From particles to fields on cells.
//!
//! [`Weights`] holds the volume that each particle has in each cell, exactly ([`Method::Kernel`]) or by one of
//! the approximations in use elsewhere ([`Method`]); [`solid_fraction`] turns it into solid volume, solid
//! fraction and void fraction, and accounts for every bit of volume in a [`Ledger`].
//!
//! [`CoarseGraining`] makes continuum fields of particles and their contacts ([`FieldName`] lists them), with exact
//! weights or with a [`Kernel`]; [`contact_traction`] and [`solid_flux`] are what crosses the faces of cells, and close
//! the balances of momentum and solid volume of each.

mod binning;
mod checks;
mod coarse_graining;
mod curve;
mod erf;
mod error;
mod face_fields;
mod interpolation;
mod kernels;
mod ledger;
mod method;
mod neumaier;
mod parcel_weight;
mod periodic;
mod scatter;
mod smoothing;
mod solid_fraction;
mod time_weights;
mod weights;

pub use coarse_graining::{
    CoarseGraining, CoarseGrainingLedger, CoarseGrainingOptions, ContactForm, Field, FieldName, Fields, Function,
    MeanVelocity, QuantityKind, Selection, SignConvention, UserQuantity, component_names, displacements,
};
pub use error::FieldsError;
pub use face_fields::{ContactTraction, SolidFlux, contact_traction, solid_flux};
pub use interpolation::field_at_particles;
pub use kernels::{BranchKernel, Kernel, KernelShape};
pub use ledger::Ledger;
pub use method::Method;
pub use neumaier::NeumaierSum;
pub use parcel_weight::ParcelWeight;
pub use smoothing::{smooth_conservatively, smoothed_through};
pub use solid_fraction::{SolidFraction, SolidFractionOptions, count_centres, solid_fraction, solid_fraction_observed};
pub use time_weights::gaussian_time_weights;
pub use weights::Weights;
