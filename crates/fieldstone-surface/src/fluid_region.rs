//! Where the fluid is as far as walls, boundary particles and the box say.

use fieldstone_particles::{Domain, NeighbourGrid};

use crate::{Surroundings, Wall};

/// Whether the fluid ends at the faces of a periodic box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PeriodicFaces {
    /// It does: surfaces close around what one box holds.
    #[default]
    End,
    /// It goes on through them: quantities on the faces, and beyond them, are those of the particles' images.
    Pass,
}

/// What limits the fluid beside its free surface.
pub(crate) struct FluidRegion<'a> {
    walls: &'a [Wall],
    domain: Option<&'a Domain>,
    candidates: Option<&'a [bool]>,
    reach: f64,
}

/// Distances at a point, all positive inside the fluid.
pub(crate) struct Within {
    /// To the nearest fluid particle; infinite beyond the reach.
    pub nearest: f64,
    /// To the nearest limit that is no free surface; infinite without.
    pub limit: f64,
}

impl<'a> FluidRegion<'a> {
    pub(crate) fn new(surroundings: &'a Surroundings, reach: f64, faces: PeriodicFaces) -> Self {
        Self {
            walls: &surroundings.walls,
            domain: surroundings.domain.as_ref().filter(|_| faces == PeriodicFaces::End),
            candidates: surroundings.candidates.as_deref(),
            reach,
        }
    }

    /// Whether anything but free surfaces can limit the fluid.
    pub(crate) fn has_limits(&self) -> bool {
        !self.walls.is_empty() || self.domain.is_some() || self.candidates.is_some()
    }

    /// `points` holds all particles and their images.
    pub(crate) fn at(&self, points: &NeighbourGrid, at: [f64; 3]) -> Within {
        let (mut fluid, mut boundary) = (f64::INFINITY, f64::INFINITY);
        // The reach is that of the grid, which is at least ours.
        let _ = points.for_each_within(at, self.reach, |particle, _, squared| {
            match self.candidates {
                Some(candidates) if !candidates[particle] => boundary = boundary.min(squared),
                _ => fluid = fluid.min(squared),
            };
        });
        let nearest = fluid.sqrt();
        let mut limit = f64::INFINITY;
        if boundary.is_finite() {
            // Half way between fluid and boundary particles; farther away there is no fluid either.
            limit = 0.5 * (boundary.sqrt() - nearest.min(self.reach));
        }
        for wall in self.walls {
            limit = limit.min(wall.distance(at));
        }
        if let Some(domain) = self.domain {
            let (fractions, heights) = (domain.fractions(at), domain.heights());
            for axis in (0..3).filter(|&axis| domain.periodic()[axis]) {
                limit = limit.min(heights[axis] * fractions[axis].min(1.0 - fractions[axis]));
            }
        }
        Within { nearest, limit }
    }
}
