use crate::error::check;
use crate::{Parameter, SphError, WendlandC2};

/// How viscous the fluid is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Viscosity {
    /// Dynamic viscosity μ, in pressure times time.
    Dynamic(f64),
    /// The α of artificial viscosity: μ = α ρ₀ c₀ h / (2 (d + 2)), so that Eq. 4's 2 (d + 2) μ is α ρ₀ c₀ h.
    Alpha(f64),
}

/// The fluid, its discretisation, and gravity.
///
/// | symbol | meaning | default | unit |
/// |---|---|---|---|
/// | d | dimensions, 2 or 3 | 3 | – |
/// | Δx | initial distance of particles | – | length |
/// | h/Δx | smoothing length over spacing | 2 | – |
/// | ρ₀ | density at rest | 1000 | mass/length³ |
/// | c₀ | speed of sound, bounded by Eq. 3 | – | length/time |
/// | μ | viscosity | α = 0.02 | pressure · time |
/// | δ | density diffusion | 0.1 | – |
/// | g | gravity | (0, 0, −9.81), along −y in two dimensions | length/time² |
/// | σ | surface tension | 0 | force/length |
///
/// Source: `liu2022`, Sec. 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FluidOptions {
    /// 2 or 3; in two dimensions everything is in the plane z = 0.
    pub dimension: usize,
    /// Δx.
    pub spacing: f64,
    /// h/Δx.
    pub smoothing: f64,
    /// ρ₀.
    pub density: f64,
    /// c₀.
    pub sound_speed: f64,
    /// μ or α.
    pub viscosity: Viscosity,
    /// δ.
    pub delta: f64,
    /// g.
    pub gravity: [f64; 3],
    /// σ.
    pub surface_tension: f64,
    /// Expected largest speed U_max, of Eq. 3 and of the shifting's Mach number.
    pub expected_speed: f64,
    /// Expected largest pressure p_max of Eq. 3.
    pub expected_pressure: f64,
    /// Volume of every particle at rest; Δx^d where absent. A case sets it to the cell of the lattice that its fills are divided into.
    pub particle_volume: Option<f64>,
    /// Replace p_i + p_j by p_j − p_i where p_i < 0 and i is farther than 2h from the free surface: against tensile instability.
    ///
    /// Nearer, where the kernel misses neighbours, the difference would undo the condition p = 0 of the surface.
    ///
    /// Not conservative; off in `liu2022`.
    pub tensile_control: bool,
}

impl FluidOptions {
    /// Water-like numbers and the paper's parameters; c₀ is the bound of Eq. 3.
    pub fn new(dimension: usize, spacing: f64, expected_speed: f64, expected_pressure: f64) -> Self {
        let density = 1000.0;
        Self {
            dimension,
            spacing,
            smoothing: 2.0,
            density,
            sound_speed: sound_speed_bound(density, expected_speed, expected_pressure),
            viscosity: Viscosity::Alpha(0.02),
            delta: 0.1,
            gravity: if dimension == 2 { [0.0, -9.81, 0.0] } else { [0.0, 0.0, -9.81] },
            surface_tension: 0.0,
            expected_speed,
            expected_pressure,
            particle_volume: None,
            tensile_control: false,
        }
    }

    /// Smoothing length h.
    pub fn h(&self) -> f64 {
        self.smoothing * self.spacing
    }

    /// The kernel.
    pub fn kernel(&self) -> WendlandC2 {
        WendlandC2::new(self.h(), self.dimension)
    }

    /// Mass of every particle, ρ₀ times its volume at rest; per unit of length along z in two dimensions.
    pub fn particle_mass(&self) -> f64 {
        self.density * self.particle_volume.unwrap_or_else(|| self.spacing.powi(self.dimension as i32))
    }

    /// Dynamic viscosity μ.
    pub fn dynamic_viscosity(&self) -> f64 {
        match self.viscosity {
            Viscosity::Dynamic(mu) => mu,
            Viscosity::Alpha(alpha) => {
                alpha * self.density * self.sound_speed * self.h() / (2.0 * (self.dimension as f64 + 2.0))
            }
        }
    }

    /// Pressure of a density, Eq. 2: c₀² (ρ − ρ₀).
    pub fn pressure(&self, density: f64) -> f64 {
        self.sound_speed * self.sound_speed * (density - self.density)
    }

    /// Density of a pressure, the inverse of Eq. 2.
    pub fn density_at(&self, pressure: f64) -> f64 {
        self.density + pressure / (self.sound_speed * self.sound_speed)
    }

    /// Checks every number, and Eq. 3.
    ///
    /// # Errors
    /// [`SphError::Option`], [`SphError::SoundSpeed`].
    pub fn validate(&self) -> Result<(), SphError> {
        let positive = |parameter, x: f64| check(parameter, x, x > 0.0 && x.is_finite(), "finite and above 0");
        let not_negative = |parameter, x: f64| check(parameter, x, x >= 0.0 && x.is_finite(), "finite and at least 0");
        check(Parameter::Dimension, self.dimension as f64, matches!(self.dimension, 2 | 3), "2 or 3")?;
        positive(Parameter::Spacing, self.spacing)?;
        let smoothing = self.smoothing;
        check(Parameter::Smoothing, smoothing, (1.0..=4.0).contains(&smoothing), "between 1 and 4")?;
        positive(Parameter::Density, self.density)?;
        positive(Parameter::ParticleVolume, self.particle_volume.unwrap_or(1.0))?;
        positive(Parameter::SoundSpeed, self.sound_speed)?;
        match self.viscosity {
            Viscosity::Dynamic(mu) => not_negative(Parameter::Viscosity, mu)?,
            Viscosity::Alpha(alpha) => not_negative(Parameter::Alpha, alpha)?,
        }
        not_negative(Parameter::Delta, self.delta)?;
        not_negative(Parameter::SurfaceTension, self.surface_tension)?;
        not_negative(Parameter::ExpectedSpeed, self.expected_speed)?;
        not_negative(Parameter::ExpectedPressure, self.expected_pressure)?;
        for g in self.gravity {
            check(Parameter::Gravity, g, g.is_finite(), "finite")?;
        }
        if self.dimension == 2 {
            check(Parameter::GravityAlongZ, self.gravity[2], self.gravity[2] == 0.0, "0 in two dimensions")?;
        }
        let needed = sound_speed_bound(self.density, self.expected_speed, self.expected_pressure);
        // The bound itself is allowed, also where it was computed another way.
        if self.sound_speed < needed * (1.0 - 1e-9) {
            let by_speed = 10.0 * self.expected_speed >= needed;
            let cause = if by_speed {
                format!("an expected speed of {}", self.expected_speed)
            } else {
                format!("an expected pressure of {}", self.expected_pressure)
            };
            return Err(SphError::SoundSpeed { given: self.sound_speed, needed, cause });
        }
        Ok(())
    }
}

/// The lower bound of c₀, Eq. 3: 10 max(√(p_max/ρ₀), U_max).
///
/// ```
/// assert_eq!(fieldstone_sph::sound_speed_bound(1000.0, 2.0, 9000.0), 30.0);
/// ```
pub fn sound_speed_bound(density: f64, speed: f64, pressure: f64) -> f64 {
    10.0 * (pressure.max(0.0) / density).sqrt().max(speed)
}

/// How time advances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrator {
    /// Predictor to half a step, corrector with the rates found there: two evaluations, second order.
    Symplectic,
    /// The classical method of Runge and Kutta: four evaluations, fourth order.
    RungeKutta4,
}

/// Bounds of the time step.
///
/// $$ \Delta t = \min\left(\mathrm{CFL}\,\min\Big(\sqrt{h/a_{\max}},\ \frac{h}{\max(c_0, 10 u_{\max})}\Big),\
///    C_\nu \frac{h^2}{\nu},\ C_\sigma\sqrt{\frac{\rho_0 h^3}{2\pi\sigma}}\right) $$
///
/// ```
/// use fieldstone_sph::{FluidOptions, TimeStepOptions};
/// let fluid = FluidOptions::new(2, 0.01, 1.0, 0.0);
/// let mut options = TimeStepOptions::default();
/// assert!((options.viscous_factor(&fluid) - 0.0757).abs() < 1e-4);
/// options.viscous = Some(0.125);
/// let error = options.validate(&fluid).unwrap_err().to_string();
/// assert!(error.starts_with("the viscous factor of the time step is 0.125; it must be at most 0.1165,"), "{error}");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeStepOptions {
    /// The integrator; symplectic.
    pub integrator: Integrator,
    /// CFL, 0.25; at most 2.1, with Runge–Kutta 2.9.
    ///
    /// Beyond, waves of sound grow whatever damps them. In a dam break symplectic steps were unstable from 0.75 on, those of Runge and
    /// Kutta from 2.5 on, and lost energy at 0.5 and 2.
    pub cfl: f64,
    /// C_ν; where absent, 0.65 of the [largest stable one](Integrator::viscous_limit), which is the most that is allowed.
    pub viscous: Option<f64>,
    /// C_σ, 0.25; at most 4. Where it becomes unstable is not known: it hangs on the surface's shape.
    pub capillary: f64,
    /// Largest step allowed; none.
    pub largest: f64,
}

impl Default for TimeStepOptions {
    fn default() -> Self {
        Self { integrator: Integrator::Symplectic, cfl: 0.25, viscous: None, capillary: 0.25, largest: f64::INFINITY }
    }
}

impl TimeStepOptions {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SphError::Option`]; [`SphError::ViscousStep`] where the viscous step is unstable for the fluid's kernel.
    pub fn validate(&self, fluid: &FluidOptions) -> Result<(), SphError> {
        let (most, allowed) = self.integrator.cfl_limit();
        check(Parameter::Cfl, self.cfl, self.cfl > 0.0 && self.cfl <= most, allowed)?;
        if let Some(given) = self.viscous {
            check(Parameter::ViscousFactor, given, given > 0.0 && given.is_finite(), "finite and above 0")?;
            let limit = self.integrator.viscous_limit(fluid);
            if given > limit {
                return Err(SphError::ViscousStep { given, limit, default: self.integrator.viscous_default(fluid) });
            }
        }
        let capillary = self.capillary;
        check(Parameter::CapillaryFactor, capillary, capillary > 0.0 && capillary <= 4.0, "above 0 and at most 4")?;
        check(Parameter::LargestStep, self.largest, self.largest > 0.0, "above 0")
    }

    /// C_ν: the given one, or that of the integrator and the fluid's kernel.
    pub fn viscous_factor(&self, fluid: &FluidOptions) -> f64 {
        self.viscous.unwrap_or_else(|| self.integrator.viscous_default(fluid))
    }

    /// h/max(c₀, 10 u), the time in which sound crosses h.
    fn crossing(fluid: &FluidOptions, largest_speed: f64) -> f64 {
        fluid.h() / fluid.sound_speed.max(10.0 * largest_speed)
    }

    /// A step over the one that sound alone would allow, at most 1: 1 to the bit where sound bounds it.
    pub(crate) fn share_of_sound(&self, fluid: &FluidOptions, largest_speed: f64, step: f64) -> f64 {
        (step / (self.cfl * Self::crossing(fluid, largest_speed))).min(1.0)
    }

    /// The time step for a largest speed and acceleration.
    pub fn step(&self, fluid: &FluidOptions, largest_speed: f64, largest_acceleration: f64) -> f64 {
        self.step_with(self.viscous_factor(fluid), fluid, largest_speed, largest_acceleration)
    }

    /// The same with the [`viscous_factor`](Self::viscous_factor), which does not change from step to step.
    pub(crate) fn step_with(
        &self,
        viscous_factor: f64,
        fluid: &FluidOptions,
        largest_speed: f64,
        largest_acceleration: f64,
    ) -> f64 {
        let h = fluid.h();
        let sound = Self::crossing(fluid, largest_speed);
        let force = (h / largest_acceleration).sqrt();
        let viscous = viscous_factor * h * h * fluid.density / fluid.dynamic_viscosity();
        let capillary =
            self.capillary * (fluid.density * h.powi(3) / (2.0 * std::f64::consts::PI * fluid.surface_tension)).sqrt();
        (self.cfl * sound.min(force)).min(viscous).min(capillary).min(self.largest)
    }
}

/// Particle shifting, Eq. 10 and 11.
///
/// $$ \delta x_i = -\theta\,k_\text{CFL}\,\mathrm{Ma}\,f\,h^2 \sum_j V_j \left[\chi_i + R\Big(\frac{W_{ij}}{W(\Delta x)}\Big)^n\right]
///    \nabla_i W_{ij}, \qquad \chi_i = 1 \text{ inside, } 0 \text{ near the surface} $$
///
/// θ is the time step over CFL h/max(c₀, 10 u), at most 1: it is 1 where sound bounds the step, and where something else does, such as
/// viscosity or a `largest` step, the shift per unit of time stays what it was.
///
/// Not at all on the free surface; near it (within 2h of a free-surface particle) only neighbours that are no farther than the
/// nearest free-surface particle count.
///
/// Eq. 11 has them closer than that particle, which then does not push either: where the surface stretches, particles from below
/// crowd in between those on it, to 0.67 Δx from each other in a column that collapses; with it they stay 0.93 Δx apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShiftingOptions {
    /// k_CFL, 0.25.
    pub k_cfl: f64,
    /// R, 0.2.
    pub r: f64,
    /// n, 4.
    pub n: i32,
    /// f: the paper's 2; other sources have 4, from (2h)².
    pub factor: f64,
    /// Ma = U_max/c₀; from the expected speed where absent, which then must be above 0.
    pub mach: Option<f64>,
    /// Largest shift per step over the spacing, 0.1.
    pub cap: f64,
    /// Whether the nearest free-surface particle counts near the surface; false is Eq. 11 to the letter.
    pub nearest_counts: bool,
}

impl Default for ShiftingOptions {
    fn default() -> Self {
        Self { k_cfl: 0.25, r: 0.2, n: 4, factor: 2.0, mach: None, cap: 0.1, nearest_counts: true }
    }
}

impl ShiftingOptions {
    /// Ma, given or from the expected speed.
    pub(crate) fn mach_number(&self, fluid: &FluidOptions) -> f64 {
        self.mach.unwrap_or(fluid.expected_speed / fluid.sound_speed)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`SphError::Option`].
    pub fn validate(&self) -> Result<(), SphError> {
        let not_negative = |parameter, x: f64| check(parameter, x, x >= 0.0 && x.is_finite(), "finite and at least 0");
        not_negative(Parameter::ShiftingCfl, self.k_cfl)?;
        not_negative(Parameter::ShiftingR, self.r)?;
        not_negative(Parameter::ShiftingFactor, self.factor)?;
        check(Parameter::ShiftingN, self.n.into(), (1..=16).contains(&self.n), "a whole number from 1 to 16")?;
        if let Some(mach) = self.mach {
            not_negative(Parameter::ShiftingMach, mach)?;
        }
        check(Parameter::ShiftingCap, self.cap, self.cap > 0.0 && self.cap <= 0.5, "above 0, at most 0.5")
    }
}
