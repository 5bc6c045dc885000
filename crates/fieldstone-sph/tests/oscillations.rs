//! Oscillations with known periods and decays. Small by default; FIELDSTONE_SPH_LONG=1 runs them at the resolutions that
//! the documentation quotes, in minutes.
#![allow(clippy::unwrap_used)]

mod common;

use std::f64::consts::PI;

use common::{Wave, as_recorded, long, standing_wave, state};
use fieldstone_sph::{Boundaries, Flow, FluidOptions, Integrator, Shape, ShiftingOptions, Solver, Viscosity};

/// Values of a quantity that oscillates about 0, step by step.
#[derive(Default)]
struct Oscillation {
    points: Vec<(f64, f64)>,
}

impl Oscillation {
    /// Runs a solver to a time.
    fn of(solver: &mut Solver, until: f64, quantity: impl Fn(&Solver) -> f64) -> Self {
        let mut points = vec![(0.0, quantity(solver))];
        while solver.time() < until {
            solver.step().unwrap();
            points.push((solver.time(), quantity(solver)));
        }
        Self { points }
    }

    /// Times of zeros, linear between steps.
    fn zeros(&self) -> Vec<f64> {
        let crossing = |w: &[(f64, f64)]| {
            let [(t0, q0), (t1, q1)] = [w[0], w[1]];
            (q0 * q1 < 0.0).then(|| t0 + (t1 - t0) * q0 / (q0 - q1))
        };
        self.points.windows(2).filter_map(crossing).collect()
    }

    fn period(&self) -> f64 {
        let zeros = self.zeros();
        2.0 * (zeros[zeros.len() - 1] - zeros[0]) / (zeros.len() - 1) as f64
    }

    /// Rate at which the extremes between zeros decay: the slope of their logarithms by least squares.
    fn decay(&self) -> f64 {
        let zeros = self.zeros();
        let extremes: Vec<(f64, f64)> = zeros
            .windows(2)
            .map(|w| {
                let between = self.points.iter().filter(|p| w[0] < p.0 && p.0 < w[1]);
                between.fold((0.0f64, 0.0f64), |a, b| if b.1.abs() > a.1 { (b.0, b.1.abs()) } else { a })
            })
            .map(|(t, q)| (t, q.ln()))
            .collect();
        let n = extremes.len() as f64;
        let (st, sq) = extremes.iter().fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
        let (a, b) =
            extremes.iter().fold((0.0, 0.0), |s, p| (s.0 + (p.0 - st) * (p.1 - sq), s.1 + (p.0 - st) * (p.0 - st)));
        -a / b
    }
}

#[test]
fn a_standing_wave_has_its_period_and_decays_as_its_viscosity_says() {
    let (depth, length, amplitude, nu) = (1.0, 2.0, 0.05, 0.0125);
    let dx = if long() { 0.025 } else { 0.05 };
    let Wave { mut flow, state, k, frequency } = standing_wave(depth, length, amplitude, dx, 1000.0 * nu, 1.5);
    flow.time_step.integrator = Integrator::RungeKutta4;
    flow.time_step.cfl = 1.5;
    let mut solver = Solver::new(flow, state).unwrap();
    // The wave's mode in the momentum.
    let wave = Oscillation::of(&mut solver, if long() { 5.0 } else { 3.0 }, |solver| {
        let s = solver.state();
        (0..s.len()).map(|i| s.u[i][1] * (k * s.x[i][0]).cos()).sum::<f64>()
    });
    let errors = [wave.period() / (2.0 * PI / frequency) - 1.0, wave.decay() / (2.0 * nu * k * k) - 1.0];
    println!("standing wave, H/Δx = {:.0}: relative errors of period and decay {errors:?}", depth / dx);
    // 0.3 % of the period is the wave's height.
    let bounds = if long() { [0.01, 0.1] } else { [0.02, 0.1] };
    assert!(errors.iter().zip(bounds).all(|(e, b)| e.abs() < b), "{errors:?}");
    let recorded = if long() { [0.0035, -0.085] } else { [0.013, -0.04] };
    assert!(errors.iter().zip(recorded).all(|(&e, r)| as_recorded(e, r)), "{errors:?} {recorded:?}");
}

#[test]
fn a_drop_oscillates_with_the_period_of_rayleigh() {
    let (radius, sigma, relative) = (0.4f64, 1.0, 0.05);
    let dx = 0.02;
    // n = 2 in two dimensions: ω² = n (n² − 1) σ/(ρ R³).
    let frequency = (6.0 * sigma / (1000.0 * radius * radius * radius)).sqrt();
    let mut fluid = FluidOptions::new(2, dx, 0.02, sigma / radius);
    fluid.sound_speed = 0.6;
    fluid.viscosity = Viscosity::Dynamic(0.2);
    fluid.gravity = [0.0; 3];
    fluid.surface_tension = sigma;
    let rate = frequency * relative;
    let disc = Shape::Sphere { centre: [0.0; 3], radius };
    let state = state(&[disc], &fluid, |x| [rate * x[0], -rate * x[1], 0.0], |_| sigma / radius);
    let mut flow = Flow::new(fluid, Boundaries::new([-1.0; 3], [1.0; 3], dx));
    flow.time_step.integrator = Integrator::RungeKutta4;
    flow.time_step.cfl = 1.0;
    flow.time_step.capillary = 1.0;
    flow.shifting = Some(ShiftingOptions { k_cfl: 1.0, ..ShiftingOptions::default() });
    let mut solver = Solver::new(flow, state).unwrap();
    let period = 2.0 * PI / frequency;
    let drop = Oscillation::of(&mut solver, 1.3 * period, |solver| {
        solver.state().x.iter().map(|x| x[0] * x[0] - x[1] * x[1]).sum::<f64>()
    });
    let error = drop.period() / period - 1.0;
    println!("drop, R/Δx = {:.0}: relative error of the period {error:.4}", radius / dx);
    assert!(error.abs() < 0.05 && as_recorded(error, 0.048), "{error}");
}
