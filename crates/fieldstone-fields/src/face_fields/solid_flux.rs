//! The solid volume that crosses each face.

use fieldstone_geometry::Ball;
use fieldstone_mesh::Faces;
use fieldstone_particles::{Domain, Particles};
use rayon::prelude::*;

use crate::FieldsError;
use crate::checks::{check_radii, column};
use crate::periodic::Periods;

/// Particles handled by one task.
const BLOCK: usize = 512;

/// Solid volume per time across faces, and what it makes of the cells.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidFlux {
    /// For each face the solid volume that passes it along its normal, per time.
    pub fluxes: Vec<f64>,
    /// For each cell the rate at which its solid volume grows: the fluxes in less those out.
    pub rates: Vec<f64>,
}

/// The solid volume that crosses each face of the cells, and the exact rate of change of each cell's solid volume.
///
/// $$ Q_f = \sum_i v_i \cdot n_f A_{f \cap i}, \qquad
///    \frac{d (\nu_c V_c)}{dt} = -\sum_{f \in \partial c} \pm Q_f $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | n_f A_{f∩i} | vector area of the part of the face inside particle i | length² |
/// | v_i | velocity of the particle's centre; spin moves no volume | length/time |
/// | ± | + where the normal points out of the cell | |
///
/// This is the derivative of the exact overlap itself, so a flow solver's ∂ε/∂t = −∂ν/∂t and its fluxes agree to
/// rounding. Needs radii and the column `velocity`. With a `domain`, images are counted along its periodic directions.
///
/// # Errors
/// Particles without radii or velocities; velocities that are not finite; a radius that is no length between 1e-100 and
/// 1e100, or more than 20 times the length of a periodic box; a box of which more than 10⁵ copies reach the cells.
///
/// Source: Reynolds' transport theorem for the part of a rigid ball in a fixed cell.
///
/// ```
/// use fieldstone_fields::solid_flux;
/// use fieldstone_mesh::Grid;
/// use fieldstone_particles::{Particles, Quantity};
/// // A ball of radius 1/2 on its way from the first cell to the second: the face cuts its great circle.
/// let one = Particles::new(vec![[1.0, 0.5, 0.5]])?.with_uniform_radius(0.5)?
///     .with_quantity(Quantity { name: "velocity".into(), components: 3, data: vec![2.0, 0.0, 0.0] })?;
/// let grid = Grid::new([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1])?;
/// let flux = solid_flux(&grid, &one, None)?;
/// let disc = std::f64::consts::PI / 4.0;
/// assert!((flux.fluxes[grid.face_at(0, [1, 0, 0])] - 2.0 * disc).abs() < 1e-15);
/// assert!((flux.rates[1] - 2.0 * disc).abs() < 1e-15 && (flux.rates[0] + 2.0 * disc).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn solid_flux<C: Faces>(
    cells: &C,
    particles: &Particles,
    domain: Option<&Domain>,
) -> Result<SolidFlux, FieldsError> {
    let radii = particles.radii()?;
    check_radii(radii)?;
    let velocities = column(particles, "velocity", 3)?;
    let periods = Periods::new(domain, [false; 3], cells.bounds());
    periods.check_balls(radii)?;
    let blocks: Vec<Vec<(u32, f64)>> = particles
        .positions()
        .par_chunks(BLOCK)
        .enumerate()
        .map(|(block, positions)| {
            let mut through = Vec::new();
            let mut failure = None;
            for (k, &at) in positions.iter().enumerate() {
                let particle = block * BLOCK + k;
                let (r, v) = (radii[particle], &velocities[3 * particle..3 * particle + 3]);
                periods.for_each(at.map(|x| x - r), at.map(|x| x + r), |shift| {
                    match Ball::new(std::array::from_fn(|k| at[k] + shift[k]), r) {
                        Ok(ball) => cells.for_each_cut(&ball, &mut |face, area| {
                            through.push((face, v[0] * area[0] + v[1] * area[1] + v[2] * area[2]));
                        }),
                        Err(source) => failure = Some(FieldsError::Ball { particle, source }),
                    }
                });
            }
            failure.map_or(Ok(through), Err)
        })
        .collect::<Result<_, _>>()?;
    let mut fluxes = vec![0.0; cells.face_count()];
    blocks.iter().flatten().for_each(|&(face, q)| fluxes[face as usize] += q);
    let mut rates = vec![0.0; cells.cell_count()];
    for (face, q) in fluxes.iter().enumerate() {
        let [back, front] = cells.face_sides(face);
        back.into_iter().for_each(|cell| rates[cell as usize] -= q);
        front.into_iter().for_each(|cell| rates[cell as usize] += q);
    }
    Ok(SolidFlux { fluxes, rates })
}
