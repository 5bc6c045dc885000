use crate::{FluidOptions, State};

/// What a run has gained and lost since its start; per unit of length along z in two dimensions.
///
/// $$ E_k + E_p + E_c - \text{start} = W_\nu + W_\delta + W_b + W_s + W_\sigma - \text{removed} + \text{residual} $$
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Budget {
    /// Energy at the start.
    pub start: f64,
    /// Work of the viscous term.
    pub viscous: f64,
    /// Compression energy by the density diffusion.
    pub diffusive: f64,
    /// Work of walls and bodies, by which pressure and divergence do not cancel; with tensile control its work, too.
    pub boundaries: f64,
    /// Potential energy by shifting and by putting particles back before a wall that they had passed.
    pub shifting: f64,
    /// Work of surface tension.
    pub surface_tension: f64,
    /// Energy of particles removed through open faces.
    pub removed_energy: f64,
    /// Mass of particles removed.
    pub removed_mass: f64,
    /// Number of particles removed.
    pub removed: u64,
    /// Times that a particle had passed a wall and was put back with its normal velocity reversed: by symmetry, it
    /// changed places with its image.
    pub reflections: u64,
    /// Times that a gradient was set to 0 for want of L.
    pub singular: u64,
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
