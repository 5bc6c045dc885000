//! Fields on the faces of cells, which close the balance of each cell to rounding.

mod contact_traction;
mod solid_flux;

pub use contact_traction::{ContactTraction, contact_traction};
pub use solid_flux::{SolidFlux, solid_flux};
