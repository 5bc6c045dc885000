use std::f64::consts::PI;

use super::sections::{FillSection, FlowName, Pressure, PressureName};
use crate::FluidOptions;

impl FillSection {
    /// Velocity and pressure at a point of a fill between two corners; `up` is the axis along gravity.
    pub(super) fn initial(
        &self,
        x: [f64; 3],
        bounds: ([f64; 3], [f64; 3]),
        up: usize,
        fluid: &FluidOptions,
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
            Pressure::Named(PressureName::Hydrostatic) => fluid.density * fluid.gravity[up].abs() * (top - x[up]),
        };
        (velocity, pressure)
    }
}
