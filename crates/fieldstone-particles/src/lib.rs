//! Particle sets and the boxes that they live in.
//!
//! [`Particles`] is a structure of arrays: positions, radii where the source has them, and any number of
//! named [`Quantity`] columns. A [`Domain`] is the simulation box, orthogonal or
//! triclinic, with its periodic directions; it wraps positions and lists the periodic images of a ball that reach
//! back into the box. [`Contacts`] hold forces between particles and with walls. A [`NeighbourGrid`] finds the
//! neighbours of every particle within a radius.
//!
//! Units are the user's: nothing in this crate assumes SI, and nothing mixes two lengths of different units.

mod columns;
mod contacts;
mod domain;
mod error;
mod neighbours;
mod particles;

pub use contacts::{Contact, Contacts, Partner};
pub use domain::{Domain, Images};
pub use error::ParticlesError;
pub use neighbours::{Image, NeighbourGrid, NeighbourOptions};
pub use particles::{Particles, Quantity};
