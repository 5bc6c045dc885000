//! What pairs of particles do to each other: the same for the rates of particles and for the forces on what bounds them.

use crate::FluidOptions;
use crate::shifting::INSIDE;

/// (1 − q/2)³ V, the slope of the kernel of Wendland with the volume of a neighbour but for the kernel's factor, from s = (r/h)² and its
/// 1/√s; 0 beyond the kernel.
#[inline(always)]
pub(crate) fn slope(s: f64, inverse: f64, volume: f64) -> f64 {
    let left = (-0.5 * s).mul_add(inverse, 1.0);
    let left = if left > 0.0 { left } else { 0.0 };
    left * left * (left * volume)
}

/// Factors of the sums in Eq. 4.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairFactors {
    /// 1/h².
    pub(crate) inverse_square: f64,
    /// Of the kernel's slope.
    pub(crate) slope: f64,
    /// c₀².
    pub(crate) stiffness: f64,
    /// ρ₀.
    pub(crate) rest_density: f64,
    /// 2 (d + 2) μ.
    friction: f64,
    /// m.
    pub(crate) mass: f64,
}

impl PairFactors {
    pub(crate) fn new(fluid: &FluidOptions) -> Self {
        let h = fluid.h();
        Self {
            inverse_square: 1.0 / (h * h),
            slope: fluid.kernel().slope_factor(),
            stiffness: fluid.sound_speed * fluid.sound_speed,
            rest_density: fluid.density,
            friction: 2.0 * (fluid.dimension as f64 + 2.0) * fluid.dynamic_viscosity(),
            mass: fluid.particle_mass(),
        }
    }

    /// What added to ρ_j is p_i + p_j over c₀².
    ///
    /// With tensile control, which `tensile` has the regions for, p_i changes its sign inside where it is negative.
    #[inline(always)]
    pub(crate) fn own(&self, density: f64, tensile: Option<&[u8]>, i: usize) -> f64 {
        let excess = density - self.rest_density;
        let flips = match tensile {
            None => false,
            Some(regions) => regions[i] == INSIDE,
        };
        (if excess < 0.0 && flips { -excess } else { excess }) - self.rest_density
    }

    /// Of the sum of (p_i + p_j)/c₀² in the acceleration of a particle with a density.
    #[inline(always)]
    pub(crate) fn pressure(&self, density: f64) -> f64 {
        -self.slope * self.stiffness / density
    }

    /// Of the sum of π_ij in it, with distances over h.
    #[inline(always)]
    pub(crate) fn friction(&self, density: f64) -> f64 {
        self.slope * self.friction * self.inverse_square / density
    }
}
