use fieldstone_particles::{Domain, NeighbourGrid, NeighbourOptions};

use crate::scene::check_spacing_value;
use crate::{Scene, SurfaceError, Wall, wall_images};

/// Everything about a particle set but its positions: spacing, dimension, box, walls, columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Surroundings {
    /// Initial distance of particles, Δx.
    pub spacing: f64,
    /// 2 or 3.
    pub dimension: usize,
    /// The box, where its periodic directions are to be honoured.
    pub domain: Option<Domain>,
    /// Plane walls that mirror particles.
    pub walls: Vec<Wall>,
    /// Which particles are to be labelled; the others are neighbours only. All where absent.
    pub candidates: Option<Vec<bool>>,
    /// m/ρ of each particle; Δx^d where absent.
    pub volumes: Option<Vec<f64>>,
}

impl Surroundings {
    /// Three dimensions, no box, no walls, all particles alike.
    pub fn new(spacing: f64) -> Self {
        Self { spacing, dimension: 3, domain: None, walls: Vec::new(), candidates: None, volumes: None }
    }

    /// Sorts particles and their images for methods that look as far as `reach`.
    ///
    /// # Errors
    /// The spacing is no length; dimensions other than 2 and 3; as [`NeighbourGrid::build`].
    pub fn grid(&self, positions: &[[f64; 3]], reach: f64) -> Result<NeighbourGrid, SurfaceError> {
        self.grid_between(&self.walls, positions, reach)
    }

    /// The same, with mirror images behind these walls alone.
    pub(crate) fn grid_between(
        &self,
        walls: &[Wall],
        positions: &[[f64; 3]],
        reach: f64,
    ) -> Result<NeighbourGrid, SurfaceError> {
        check_spacing_value(self.spacing)?;
        if !(2..=3).contains(&self.dimension) {
            let name = "the number of dimensions";
            return Err(SurfaceError::Option { name, value: self.dimension as f64, allowed: "2 or 3" });
        }
        // Positions that are not finite have no mirror image; the grid names them.
        let images = if positions.iter().all(|p| p.iter().all(|x| x.is_finite())) {
            wall_images(positions, walls, reach)
        } else {
            Vec::new()
        };
        Ok(NeighbourGrid::build_with_images(positions, &images, self.options(reach))?)
    }

    /// Options of a neighbour search that looks as far as `reach`.
    pub(crate) fn options(&self, reach: f64) -> NeighbourOptions {
        NeighbourOptions { reach, dimension: self.dimension, domain: self.domain }
    }

    /// The scene for a grid of these particles.
    pub fn scene<'a>(&'a self, grid: &'a NeighbourGrid) -> Scene<'a> {
        Scene { grid, spacing: self.spacing, volumes: self.volumes.as_deref(), candidates: self.candidates.as_deref() }
    }
}
