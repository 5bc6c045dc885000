use fieldstone_particles::NeighbourGrid;

use crate::SurfaceError;

/// What a detection looks at: sorted particles, their spacing, and optional columns in particle order.
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | `grid` | particles and their mirror and periodic images, sorted; its reach covers the method's | – |
/// | `spacing` | initial distance of particles, Δx | length |
/// | `volumes` | m/ρ of each particle; Δx^d where absent | length^d |
/// | `candidates` | which particles are to be labelled; the others (walls, bodies) are neighbours only | – |
///
/// Borrows everything, so a solver builds it anew each time step at no cost.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The sorted particles.
    pub grid: &'a NeighbourGrid,
    /// Initial distance of particles.
    pub spacing: f64,
    /// Volume of each particle.
    pub volumes: Option<&'a [f64]>,
    /// Which particles are to be labelled; all where absent.
    pub candidates: Option<&'a [bool]>,
}

impl<'a> Scene<'a> {
    /// All particles of a grid, of volume Δx^d each.
    pub fn new(grid: &'a NeighbourGrid, spacing: f64) -> Self {
        Self { grid, spacing, volumes: None, candidates: None }
    }

    pub(crate) fn validate(&self, method: &'static str, needed: f64) -> Result<(), SurfaceError> {
        check_spacing_value(self.spacing)?;
        let reach = self.grid.reach();
        if needed > reach * (1.0 + 1e-12) {
            return Err(SurfaceError::Reach { method, needed, reach });
        }
        let expected = self.grid.len();
        let lengths =
            [("the volume", self.volumes.map(<[f64]>::len)), ("candidates", self.candidates.map(<[bool]>::len))];
        for (name, length) in lengths {
            if let Some(found) = length
                && found != expected
            {
                return Err(SurfaceError::Length { name, found, expected });
            }
        }
        if let Some(volumes) = self.volumes
            && let Some(particle) = volumes.iter().position(|v| !(*v > 0.0 && v.is_finite()))
        {
            return Err(SurfaceError::Volume { particle, value: volumes[particle] });
        }
        Ok(())
    }
}

/// Squares of distances have to stay numbers.
pub(crate) fn check_spacing_value(spacing: f64) -> Result<(), SurfaceError> {
    if spacing > 1e-100 && spacing < 1e100 {
        return Ok(());
    }
    Err(SurfaceError::Option { name: "the spacing", value: spacing, allowed: "between 1e-100 and 1e100" })
}
