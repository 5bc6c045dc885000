//! From fields on cells back to particles.

use rayon::prelude::*;

use crate::checks::check_length;
use crate::{Field, FieldsError, Weights};

/// For each particle the mean of a field over the whole particle, the field being 0 outside the cells, component by component.
///
/// $$ q_i = \frac{1}{V_i} \sum_c V_{c \cap i}\, f_c $$
///
/// | symbol | meaning | shape |
/// |---|---|---|
/// | V_{c∩i} | volume of the particle in the cell: `weights` | particles × cells, sparse |
/// | f_c | the field | cells × components |
/// | q_i | the result | particles × components |
///
/// The transpose of the weights that make fields of particles, over the particle's whole volume. So
/// $\sum_i V_i q_i = \sum_c \nu_c V_c f_c$ to rounding: what cells give to particles, particles take from cells. A constant
/// comes back as that constant for a particle wholly in the cells, and times the part that is in them for others.
///
/// Cost: one multiplication and addition for each pair of particle and cell, and component.
///
/// # Errors
/// [`FieldsError::Length`] unless the field has as many cells as the weights.
///
/// ```
/// use fieldstone_fields::{Field, Method, Weights, field_at_particles};
/// use fieldstone_mesh::Grid;
/// use fieldstone_particles::Particles;
/// // A ball halved by the face between two cells.
/// let grid = Grid::new([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1])?;
/// let one = Particles::new(vec![[1.0, 0.5, 0.5]])?.with_uniform_radius(0.25)?;
/// let weights = Weights::build(&grid, &one, Method::Kernel, None)?;
/// let components = ["x", "y"].map(String::from).to_vec();
/// let wind = Field { name: "wind".into(), components, unit: "m/s".into(), data: vec![1.0, 0.0, 3.0, 5.0] };
/// let found = field_at_particles(&weights, &wind)?;
/// assert!((found[0] - 2.0).abs() < 1e-15 && (found[1] - 2.5).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn field_at_particles(weights: &Weights, field: &Field) -> Result<Vec<f64>, FieldsError> {
    let width = field.components.len();
    check_length("cells", field.data.len(), weights.cell_count() * width)?;
    let mut values = vec![0.0; weights.particles() * width];
    values.par_chunks_mut(width.max(1)).enumerate().for_each(|(particle, values)| {
        let (cells, volumes) = weights.row(particle);
        for (&cell, volume) in cells.iter().zip(volumes) {
            let numbers = &field.data[cell as usize * width..][..width];
            values.iter_mut().zip(numbers).for_each(|(sum, f)| *sum += volume * f);
        }
        let whole = weights.particle_volumes()[particle];
        values.iter_mut().for_each(|sum| *sum /= whole);
    });
    Ok(values)
}
