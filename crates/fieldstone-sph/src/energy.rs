use rayon::prelude::*;

use crate::{FluidOptions, State};

/// What a run has gained and lost since its start; per unit of length along z in two dimensions.
///
/// $$ E_k + E_p + E_c - \text{start} = W_\nu + W_\delta + W_b + W_s + W_\sigma + W_p - \text{removed} + \text{residual} $$
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Budget {
    /// Energy at the start.
    pub start: f64,
    /// Work of the viscous term.
    pub viscous: f64,
    /// Compression energy by the density diffusion.
    pub diffusive: f64,
    /// Work of walls and bodies, moving ones included, by which pressure and divergence do not cancel; with tensile control its work, too.
    pub boundaries: f64,
    /// Potential energy by shifting and by putting particles back before a wall or body that they had got into.
    pub shifting: f64,
    /// Work of surface tension.
    pub surface_tension: f64,
    /// Potential energy by wrapping, W_p: m g·e L for each period L along −e by which a particle was put back. In a flow that its
    /// weight drives along a periodic axis, it is the work of the weight, where the potential energy stays the same.
    pub wrapping: f64,
    /// Energy of particles removed through open faces.
    pub removed_energy: f64,
    /// Mass of particles removed.
    pub removed_mass: f64,
    /// Number of particles removed.
    pub removed: u64,
    /// Times that a particle had passed a wall and was put back with its normal velocity reversed (by symmetry, it
    /// changed places with its image), or had got into a body and was put back without a velocity towards it.
    pub reflections: u64,
    /// Times that a particle ended a step inside a body, deeper than a spacing or with no way out.
    pub in_bodies: u64,
    /// Times that a particle began a step with a gradient of 0 for want of L.
    pub singular: u64,
    /// The momentum.
    pub momentum: MomentumBudget,
}

/// Momentum that the fluid had at the start, and impulses on it since, integrated with the stages of the time steps;
/// per unit of length along z in two dimensions.
///
/// $$ \sum m u - \text{start} = I_w + I_b + I_g + I_\sigma - \text{removed} + \text{residual} $$
///
/// Shifting moves positions only. Forces between particles cancel, so the residual is rounding; tensile control is
/// not conservative, and the residual is what it creates.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MomentumBudget {
    /// Momentum at the start.
    pub start: [f64; 3],
    /// Impulse of mirror walls, by pressure, friction and by putting particles back that had passed them.
    pub walls: [f64; 3],
    /// Impulse of all bodies.
    pub bodies: [f64; 3],
    /// Impulse of the weight.
    pub weight: [f64; 3],
    /// Impulse of surface tension, which is not a sum of pairs.
    pub surface_tension: [f64; 3],
    /// Momentum of particles removed through open faces.
    pub removed: [f64; 3],
}

impl MomentumBudget {
    /// What the fluid's momentum must be by the impulses.
    pub fn expected(&self) -> [f64; 3] {
        let Self { start, walls, bodies, weight, surface_tension, removed } = self;
        std::array::from_fn(|k| start[k] + walls[k] + bodies[k] + weight[k] + surface_tension[k] - removed[k])
    }
}

/// Adds `factor` times a vector to another.
pub(crate) fn accumulate(sum: &mut [f64; 3], factor: f64, vector: [f64; 3]) {
    for (sum, x) in sum.iter_mut().zip(vector) {
        *sum += factor * x;
    }
}

/// Energies and momentum of the fluid.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Energies {
    /// Σ m u²/2.
    pub kinetic: f64,
    /// −Σ m g·x.
    pub potential: f64,
    /// Σ m c₀² (ln(ρ/ρ₀) + ρ₀/ρ − 1), the work of Eq. 2.
    pub compression: f64,
    /// Σ m u.
    pub momentum: [f64; 3],
}

impl Energies {
    /// Sum of the three.
    pub fn total(&self) -> f64 {
        self.kinetic + self.potential + self.compression
    }

    /// Energies of a state.
    pub fn of(state: &State, fluid: &FluidOptions) -> Self {
        let mut sum = Self::default();
        for i in 0..state.len() {
            let one = Self::of_particle(state.x[i], state.u[i], state.density[i], fluid);
            sum.kinetic += one.kinetic;
            sum.potential += one.potential;
            sum.compression += one.compression;
            for k in 0..3 {
                sum.momentum[k] += one.momentum[k];
            }
        }
        sum
    }

    pub(crate) fn of_particle(x: [f64; 3], u: [f64; 3], density: f64, fluid: &FluidOptions) -> Self {
        let mass = fluid.particle_mass();
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let ratio = fluid.density / density;
        // ln(ρ/ρ₀) + ρ₀/ρ − 1 = t − ln(1 + t).
        let t = ratio - 1.0;
        Self {
            kinetic: 0.5 * mass * dot(u, u),
            potential: -mass * dot(fluid.gravity, x),
            compression: mass * fluid.sound_speed * fluid.sound_speed * (t - t.ln_1p()),
            momentum: u.map(|u| mass * u),
        }
    }
}

/// Items per part of a sum.
const PART: usize = 4096;

/// Sum over items, part by part: in an order that does not depend on the number of threads.
pub(crate) fn sum_in_parts<T: Sync, const N: usize>(items: &[T], term: impl Fn(&T) -> [f64; N] + Sync) -> [f64; N] {
    let add = |mut sum: [f64; N], part: [f64; N]| {
        sum.iter_mut().zip(part).for_each(|(sum, x)| *sum += x);
        sum
    };
    let parts: Vec<[f64; N]> = items.par_chunks(PART).map(|part| part.iter().map(&term).fold([0.0; N], add)).collect();
    parts.into_iter().fold([0.0; N], add)
}
