use std::f64::consts::PI;

use super::sections::{FillSection, FlowName, Pressure, PressureName};
use crate::FluidOptions;

/// |g|.
fn size(gravity: [f64; 3]) -> f64 {
    gravity.iter().map(|g| g * g).sum::<f64>().sqrt()
}

/// Height, −g·x/|g|, of the corner of a box that is farthest against gravity.
pub(super) fn top_level((low, high): ([f64; 3], [f64; 3]), gravity: [f64; 3]) -> f64 {
    let height = |k: usize| -gravity[k] / size(gravity) * if gravity[k] > 0.0 { low[k] } else { high[k] };
    // Not −0, which messages would show.
    (0..3).map(height).sum::<f64>() + 0.0
}

impl FillSection {
    /// Velocity and pressure at a point of a fill between two corners; `up` is the last axis, along which waves stand.
    ///
    /// Hydrostatic pressure is p = ρ₀ g·(x − x_top) + ρ₀ |g| (L − L_top) with the part g of `levelling` gravity, along no periodic axis,
    /// the corner x_top that is farthest against g, its height L_top along −g, and the level L of the `surface`; L_top where that is
    /// absent.
    pub(super) fn initial(
        &self,
        x: [f64; 3],
        bounds: ([f64; 3], [f64; 3]),
        up: usize,
        fluid: &FluidOptions,
        levelling: [f64; 3],
    ) -> ([f64; 3], f64) {
        let (low, high) = bounds;
        let top = high[up];
        let middle: [f64; 3] = std::array::from_fn(|k| 0.5 * (low[k] + high[k]));
        let (dx, dy) = (x[0] - middle[0], x[1] - middle[1]);
        let rate = self.rate.unwrap_or(0.0);
        let wave_number = 2.0 * PI / self.wavelength.unwrap_or(1.0);
        let (velocity, pressure) = match self.flow {
            FlowName::Uniform => {
                let given = self.velocity.as_deref().unwrap_or_default();
                (std::array::from_fn(|k| given.get(k).copied().unwrap_or(0.0)), 0.0)
            }
            FlowName::Rotation => ([-rate * dy, rate * dx, 0.0], 0.0),
            FlowName::Strain => ([-rate * dx, rate * dy, 0.0], 0.0),
            FlowName::TaylorGreen => {
                let speed = self.speed.unwrap_or(0.0);
                let (kx, ky) = (wave_number * x[0], wave_number * x[1]);
                let velocity = [speed * kx.sin() * ky.cos(), -speed * kx.cos() * ky.sin(), 0.0];
                let pressure = 0.25 * fluid.density * speed * speed * ((2.0 * kx).cos() + (2.0 * ky).cos());
                (velocity, pressure)
            }
            FlowName::StandingWave => {
                let (depth, height) = (top - low[up], x[up] - low[up]);
                let gravity = fluid.gravity[up].abs();
                let frequency = (gravity * wave_number * (wave_number * depth).tanh()).sqrt();
                let size = self.amplitude.unwrap_or(0.0) * frequency / (wave_number * depth).sinh();
                let mut velocity = [0.0; 3];
                velocity[0] = -size * (wave_number * height).cosh() * (wave_number * x[0]).sin();
                velocity[up] = size * (wave_number * height).sinh() * (wave_number * x[0]).cos();
                (velocity, 0.0)
            }
        };
        let pressure = match self.pressure {
            Pressure::Uniform(p) => p,
            Pressure::Named(PressureName::Flow) => pressure,
            Pressure::Named(PressureName::Hydrostatic) => {
                let below = |k: usize| if levelling[k] > 0.0 { x[k] - low[k] } else { high[k] - x[k] };
                let weight: f64 = (0..3).map(|k| fluid.density * levelling[k].abs() * below(k)).sum();
                // Without a level nothing is added: not even what rounding makes of it.
                let above = self.surface.map_or(0.0, |level| level - top_level(bounds, levelling));
                weight + fluid.density * size(levelling) * above
            }
        };
        (velocity, pressure)
    }
}
