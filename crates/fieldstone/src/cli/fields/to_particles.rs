//! Fields brought back to the particles.

use anyhow::anyhow;
use fieldstone::fields::{Field, Fields, Function, Weights, field_at_particles};
use fieldstone::mesh::Cells;
use fieldstone::particles::{Particles, Quantity};

use super::request::Run;

impl Run<'_> {
    /// The particles with the fields' means over them.
    pub(super) fn at_particles<C: Cells>(
        &self,
        cells: &C,
        particles: Particles,
        fields: &Fields,
    ) -> anyhow::Result<Particles> {
        let Function::Overlap(method) = self.options.function else { return Ok(particles) };
        let weights = Weights::build(cells, &particles, method, self.options.domain.as_ref())?;
        let share = |i: usize| 1.0 - weights.outside()[i] / weights.particle_volumes()[i];
        let inside = (0..weights.particles()).map(share).collect();
        let mut quantities = vec![Quantity { name: "fraction_in_cells".into(), components: 1, data: inside }];
        for field in &fields.fields {
            let (name, components) = (particle_field(field), field.components.len());
            let mut data = field_at_particles(&weights, field)?;
            // Cells of several periods hold a particle more than once: the mean is over all its images in them.
            for (i, values) in data.chunks_exact_mut(components.max(1)).enumerate() {
                let times = share(i);
                if times > 1.0 + 1e-9 {
                    values.iter_mut().for_each(|value| *value /= times);
                }
            }
            quantities.push(Quantity { name, components, data });
        }
        quantities.into_iter().try_fold(particles, |all, quantity| {
            let name = quantity.name.clone();
            all.with_quantity(quantity).map_err(|e| anyhow!("--to-particles: {name}: {e}"))
        })
    }
}

/// What a field is called where it has been brought back to the particles.
pub(super) fn particle_field(field: &Field) -> String {
    format!("field_{}", field.name)
}
