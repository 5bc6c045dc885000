use rayon::prelude::*;

use crate::FluidOptions;
use crate::points::{Kind, Points};

/// Forces of the fluid on what bounds it; per unit of length along z in two dimensions.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BoundaryForces {
    /// On all mirror walls together.
    pub walls: [f64; 3],
    /// On each body.
    pub bodies: Vec<[f64; 3]>,
}

/// Sums the pair forces between fluid particles and ghosts: what Eq. 4 gives them, with the opposite sign.
///
/// Images through periodic faces are fluid; their forces cancel in the sum over walls.
pub(crate) fn boundary_forces(points: &Points, fluid: &FluidOptions, bodies: usize) -> BoundaryForces {
    let kernel = fluid.kernel();
    let friction = 2.0 * (fluid.dimension as f64 + 2.0) * fluid.dynamic_viscosity();
    let mass = fluid.particle_mass();
    let count = points.fluid_count();
    let per_particle: Vec<Vec<(Option<u16>, [f64; 3])>> = (0..count)
        .into_par_iter()
        .map(|i| {
            let own = &points.carriers[i];
            let mut forces = Vec::new();
            for &j in points.fluid_list.of(i) {
                let j = j as usize;
                let body = match points.kind(j) {
                    Kind::Fluid(_) => continue,
                    Kind::Body(b) => Some(points.bodies.body[b]),
                    Kind::Image(_) => None,
                };
                let other = &points.carriers[j];
                let d: [f64; 3] = std::array::from_fn(|k| other[k] - own[k]);
                let squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                let g = kernel.slope(squared.sqrt());
                if g == 0.0 || squared == 0.0 {
                    continue;
                }
                let (velocity, weight) = if points.needs_viscous {
                    let [u, v, w, weight] = points.viscous[j];
                    ([u, v, w], weight)
                } else {
                    ([other[5], other[6], other[7]], 1.0)
                };
                let approach: f64 = (0..3).map(|k| (velocity[k] - own[5 + k]) * d[k]).sum();
                let pressure = fluid.pressure(own[4]) + fluid.pressure(other[4]);
                let volumes = mass / own[4] * other[3];
                let size = volumes * g * (pressure - weight * friction * approach / squared);
                forces.push((body, d.map(|x| size * x)));
            }
            forces
        })
        .collect();
    let mut sum = BoundaryForces { walls: [0.0; 3], bodies: vec![[0.0; 3]; bodies] };
    for (body, force) in per_particle.into_iter().flatten() {
        let target = match body {
            Some(body) => &mut sum.bodies[body as usize],
            None => &mut sum.walls,
        };
        for k in 0..3 {
            target[k] += force[k];
        }
    }
    sum
}
