//! Neighbour search within a fixed reach: a counting-sort cell list.

mod build;
mod grid;
mod table;

pub use grid::NeighbourGrid;

use crate::{Domain, ParticlesError};

/// Options of a [`NeighbourGrid`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeighbourOptions {
    /// Largest radius that is ever asked for; above 0.
    pub reach: f64,
    /// 3, or 2: then z is ignored and every displacement has z = 0.
    pub dimension: usize,
    /// The box, where its periodic directions are to be honoured.
    pub domain: Option<Domain>,
}

impl NeighbourOptions {
    /// Three dimensions, nothing periodic.
    pub fn new(reach: f64) -> Self {
        Self { reach, dimension: 3, domain: None }
    }

    pub(crate) fn validate(&self) -> Result<(), ParticlesError> {
        if !(self.reach > 0.0 && self.reach.is_finite()) {
            return Err(ParticlesError::Reach { value: self.reach });
        }
        if self.dimension != 2 && self.dimension != 3 {
            return Err(ParticlesError::Dimension { value: self.dimension });
        }
        if let Some(domain) = &self.domain {
            let (periodic, lengths) = (domain.periodic(), domain.lengths());
            for axis in 0..self.dimension {
                // Each box length within the reach multiplies the number of images.
                if periodic[axis] && self.reach > 4.0 * lengths[axis] {
                    return Err(ParticlesError::ReachBeyondBox {
                        reach: self.reach,
                        axis: ['x', 'y', 'z'][axis],
                        length: lengths[axis],
                    });
                }
            }
        }
        Ok(())
    }
}

/// A copy of a particle elsewhere: behind a mirror plane, or in the next periodic box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Image {
    /// Index of the particle that it is a copy of.
    pub source: u32,
    /// Where the copy is.
    pub position: [f64; 3],
}
