//! How long a step viscosity and sound let an integrator make.

use crate::{FluidOptions, Integrator, WendlandC2};

/// Wave numbers at which the decay of a mode is looked at, from 0 to that of layers that alternate: between two of them it differs by
/// less than a part in ten thousand.
const WAVE_NUMBERS: usize = 512;

/// Share of the longest stable step that is taken where no factor is given.
///
/// Particles that have left their lattice by up to 0.2 Δx along every axis, each at random, raise the largest eigenvalue by 43 % for
/// h/Δx = 1, 13 % for 1.3, 8 % for 2 in two dimensions; by up to 0.3 Δx by 32 % for 1.3, 14 % for 2. Walls, with slip or without, do not
/// raise it. `tests/viscosity.rs` measures that.
const SHARE: f64 = 0.65;

impl FluidOptions {
    /// Largest eigenvalue λ of the viscous sum of Eq. 7, over ν/h²: velocities of the mode that decays fastest do so as e^(−λt).
    ///
    /// $$ \frac{\lambda h^2}{\nu} = \max_k\ 2(d + 2)\,h^2\sum_j \big(1 - \cos k x_j\big)\,\frac{x_j^2}{r_j^2}\,g_j\,\Delta x^d,
    ///    \qquad \nabla W = -g\,x $$
    ///
    /// over the neighbours at x_j, …, of a particle on a square lattice: the worst mode has its velocity along its wave vector, along an
    /// edge of the lattice. For h/Δx below 1.7 layers go against each other by turns.
    ///
    /// Accuracy: 1e-4. Cost: some tens of microseconds.
    ///
    /// ```
    /// use fieldstone_sph::FluidOptions;
    /// let eigenvalue = |dimension| FluidOptions::new(dimension, 0.01, 1.0, 0.0).viscous_eigenvalue();
    /// assert!((eigenvalue(2) - 17.168).abs() < 2e-3 && (eigenvalue(3) - 15.915).abs() < 2e-3);
    /// ```
    pub fn viscous_eigenvalue(&self) -> f64 {
        // In units of Δx; of layers x = n, of which those on either side count alike.
        let h = self.smoothing;
        let factor = 2.0 * (self.dimension as f64 + 2.0) * h * h;
        let kernel = WendlandC2::new(h, self.dimension);
        let most = kernel.reach().ceil() as i64;
        let across = if self.dimension == 3 { -most..=most } else { 0..=0 };
        let layer = |n: i64| -> f64 {
            let rows = (-most..=most).flat_map(|i| across.clone().map(move |j| i * i + j * j));
            let squares = rows.map(|square| (n * n + square) as f64);
            let along = |square: f64| kernel.slope(square.sqrt()) * (n * n) as f64 / square;
            2.0 * factor * squares.map(along).sum::<f64>()
        };
        let layers: Vec<f64> = (1..=most).map(layer).collect();
        let decay = |wave: usize| -> f64 {
            let phase = std::f64::consts::PI * wave as f64 / WAVE_NUMBERS as f64;
            layers.iter().enumerate().map(|(n, of)| of * (1.0 - (phase * (n + 1) as f64).cos())).sum()
        };
        (1..=WAVE_NUMBERS).map(decay).fold(0.0, f64::max)
    }
}

impl Integrator {
    /// How far its interval of stability reaches along the negative real axis: a decay e^(−λt) is followed for steps up to this over λ.
    ///
    /// 2 for two stages, |1 − z + z²/2| ≤ 1; 2.785 for the four of Runge and Kutta.
    pub fn real_interval(self) -> f64 {
        match self {
            Self::Symplectic => 2.0,
            // The root of z³/24 − z²/6 + z/2 = 1.
            Self::RungeKutta4 => 2.785_293_563_405_282,
        }
    }

    /// The largest C_ν with which the viscous step is stable on the lattice: the [interval](Self::real_interval) over the largest
    /// [eigenvalue](FluidOptions::viscous_eigenvalue).
    ///
    /// | h/Δx | 1.0 | 1.3 | 1.5 | 2.0 | 3.0 | 4.0 |
    /// |---|---|---|---|---|---|---|
    /// | symplectic, 2D | 0.149 | 0.115 | 0.112 | 0.116 | 0.120 | 0.121 |
    /// | symplectic, 3D | 0.134 | 0.111 | 0.113 | 0.126 | 0.130 | 0.130 |
    ///
    /// and 1.393 times that with Runge–Kutta.
    ///
    /// ```
    /// use fieldstone_sph::{FluidOptions, Integrator};
    /// let fluid = FluidOptions::new(2, 0.01, 1.0, 0.0);
    /// assert!((Integrator::Symplectic.viscous_limit(&fluid) - 0.1165).abs() < 1e-4);
    /// assert!((Integrator::RungeKutta4.viscous_limit(&fluid) - 0.1622).abs() < 1e-4);
    /// ```
    pub fn viscous_limit(self, fluid: &FluidOptions) -> f64 {
        self.real_interval() / fluid.viscous_eigenvalue()
    }

    /// C_ν where none is given: 0.65 of the [limit](Self::viscous_limit), the rest being for particles that have left their lattice.
    pub fn viscous_default(self, fluid: &FluidOptions) -> f64 {
        SHARE * self.viscous_limit(fluid)
    }

    /// CFL beyond which waves of sound grow whatever damps them, and what it must be, in words.
    ///
    /// The fastest wave on a lattice has an angular frequency ω of 1.05 to 1.16 c₀/h (h/Δx from 1 to 4); damped, its two roots have the
    /// product ω², or more, and nothing farther from 0 than 2.2, or 3.0, over the step is stable.
    pub(crate) fn cfl_limit(self) -> (f64, &'static str) {
        match self {
            Self::Symplectic => {
                (2.1, "above 0 and at most 2.1: beyond, waves of sound grow with symplectic steps, some from 0.75 on")
            }
            Self::RungeKutta4 => {
                (2.9, "above 0 and at most 2.9: beyond, waves of sound grow with Runge–Kutta steps, some from 2 on")
            }
        }
    }
}
