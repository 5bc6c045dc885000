use fieldstone_particles::{NeighbourGrid, NeighbourOptions};
use rayon::prelude::*;

use crate::{Detection, Scene, SurfaceError};

/// Where each particle is: 0 on the free surface, 1 in its vicinity, 2 inside.
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | `positions` | those that the scene's grid was built from | length |
/// | `vicinity` | largest distance from a free-surface particle that counts as vicinity, 4 Δx for h = 2 Δx | length |
///
/// Particles that are no candidates are 2: they are no fluid. Distances are through periodic boundaries, too, but not
/// through walls.
///
/// Source: `liu2022`, the regions F, V and I of Eq. 11.
///
/// # Errors
/// `vicinity` is not above 0 or `positions` are not those of the scene.
///
/// ```
/// use fieldstone_surface::{Exact, SurfaceDetection, Surroundings, levels};
/// // 9 × 9 × 9 particles: the outermost layer, the one below it, and 5 × 5 × 5 inside.
/// let block: Vec<[f64; 3]> = (0..729).map(|i| [i % 9, i / 9 % 9, i / 81].map(f64::from)).collect();
/// let surroundings = Surroundings::new(1.0);
/// let method = Exact::default();
/// let grid = surroundings.grid(&block, method.reach(1.0))?;
/// let scene = surroundings.scene(&grid);
/// let found = levels(&scene, &block, &method.detect(&scene)?, 1.5)?;
/// let count = |level: u8| found.iter().filter(|&&l| l == level).count();
/// assert_eq!([count(0), count(1), count(2)], [729 - 343, 343 - 125, 125]);
/// # Ok::<(), fieldstone_surface::SurfaceError>(())
/// ```
pub fn levels(
    scene: &Scene<'_>,
    positions: &[[f64; 3]],
    detection: &Detection,
    vicinity: f64,
) -> Result<Vec<u8>, SurfaceError> {
    levels_of(positions, scene.grid.options(), scene.candidates, detection, vicinity)
}

/// As [`levels`], by what of a scene it takes.
pub(crate) fn levels_of(
    positions: &[[f64; 3]],
    options: &NeighbourOptions,
    candidates: Option<&[bool]>,
    detection: &Detection,
    vicinity: f64,
) -> Result<Vec<u8>, SurfaceError> {
    if positions.len() != detection.len() {
        return Err(SurfaceError::Length { name: "positions", found: positions.len(), expected: detection.len() });
    }
    let surface: Vec<[f64; 3]> =
        positions.iter().enumerate().filter(|&(i, _)| detection.is_free_surface(i)).map(|(_, &p)| p).collect();
    let grid = NeighbourGrid::build(&surface, NeighbourOptions { reach: vicinity, ..*options })?;
    let level = |(particle, &at): (usize, &[f64; 3])| -> Result<u8, SurfaceError> {
        if detection.is_free_surface(particle) {
            return Ok(0);
        }
        if candidates.is_some_and(|candidates| !candidates[particle]) {
            return Ok(2);
        }
        let mut near = false;
        grid.for_each_within(at, vicinity, |_, _, _| near = true)?;
        Ok(if near { 1 } else { 2 })
    };
    positions.par_iter().enumerate().map(level).collect()
}
