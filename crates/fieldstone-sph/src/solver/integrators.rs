//! Both time integrators, and what they book.

use std::time::Instant;

use rayon::prelude::*;

use super::{Flow, Solver};
use crate::SphError;
use crate::energy::{accumulate, sum_in_parts};
use crate::phases::Phase;
use crate::rates::Rate;

impl Solver {
    /// Sets `middle` to the state advanced with its own velocity and the latest rates.
    fn predict(&mut self, dt: f64) {
        let (state, rates, middle) = (&self.state, &self.stage.rates, &mut self.middle);
        let zipped = middle.x.par_iter_mut().zip(&mut middle.u).zip(&mut middle.density);
        let old = state.x.par_iter().zip(&state.u).zip(&state.density).zip(rates);
        zipped.zip(old).for_each(|(((x, u), density), (((x0, u0), density0), rate))| {
            for k in 0..3 {
                x[k] = x0[k] + dt * u0[k];
                u[k] = u0[k] + dt * rate.acceleration[k];
            }
            *density = density0 + dt * rate.density;
        });
    }

    pub(super) fn step_symplectic(&mut self, dt: f64) -> Result<(), SphError> {
        let mut clock = Instant::now();
        self.fit_middle();
        self.predict(0.5 * dt);
        self.stage.phases.add(Phase::Rest, &mut clock);
        self.stage.evaluate(&self.middle, self.time + 0.5 * dt, &self.flow, &self.regions)?;
        clock = Instant::now();
        self.book(dt);
        let (state, rates) = (&mut self.state, &self.stage.rates);
        let all = state.x.par_iter_mut().zip(&mut state.u).zip(&mut state.density).zip(rates);
        all.for_each(|(((x, u), density), rate)| {
            for k in 0..3 {
                let old = u[k];
                u[k] += dt * rate.acceleration[k];
                x[k] += 0.5 * dt * (old + u[k]);
            }
            *density += dt * rate.density;
        });
        self.stage.phases.add(Phase::Rest, &mut clock);
        Ok(())
    }

    pub(super) fn step_runge_kutta(&mut self, dt: f64) -> Result<(), SphError> {
        self.fit_middle();
        self.middle.u.copy_from_slice(&self.state.u);
        let mut moved: Vec<[f64; 3]> = self.state.u.clone();
        let mut sum: Vec<Rate> = self.stage.rates.clone();
        self.book(dt / 6.0);
        for (stage, weight) in [(0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let mut clock = Instant::now();
            // The velocity of the stage before moves the positions of this one.
            let velocity = self.middle.u.clone();
            self.predict(stage * dt);
            let advance = |(x, (x0, u)): (&mut [f64; 3], (&[f64; 3], &[f64; 3]))| {
                for k in 0..3 {
                    x[k] = x0[k] + stage * dt * u[k];
                }
            };
            self.middle.x.par_iter_mut().zip(self.state.x.par_iter().zip(&velocity)).for_each(advance);
            self.stage.phases.add(Phase::Rest, &mut clock);
            self.stage.evaluate(&self.middle, self.time + stage * dt, &self.flow, &self.regions)?;
            clock = Instant::now();
            self.book(weight * dt / 6.0);
            let latest = self.stage.rates.par_iter().zip(&self.middle.u);
            sum.par_iter_mut().zip(&mut moved).zip(latest).for_each(|((sum, moved), (rate, u))| {
                for k in 0..3 {
                    sum.acceleration[k] += weight * rate.acceleration[k];
                    moved[k] += weight * u[k];
                }
                sum.density += weight * rate.density;
            });
            self.stage.phases.add(Phase::Rest, &mut clock);
        }
        let state = &mut self.state;
        let all = state.x.par_iter_mut().zip(&mut state.u).zip(&mut state.density).zip(sum.par_iter().zip(&moved));
        all.for_each(|(((x, u), density), (rate, moved))| {
            for k in 0..3 {
                x[k] += dt / 6.0 * moved[k];
                u[k] += dt / 6.0 * rate.acceleration[k];
            }
            *density += dt / 6.0 * rate.density;
        });
        Ok(())
    }

    /// Makes `middle` as long as the state, which the prediction overwrites it with.
    fn fit_middle(&mut self) {
        let count = self.state.len();
        self.middle.x.resize(count, [0.0; 3]);
        self.middle.u.resize(count, [0.0; 3]);
        self.middle.density.resize(count, 0.0);
    }

    /// Adds the powers and forces of the latest evaluation to the budget.
    fn book(&mut self, dt: f64) {
        let powers =
            sum_in_parts(&self.stage.rates, |rate| [rate.viscous_power, rate.diffusive_power, rate.boundary_power]);
        self.budget.viscous += dt * powers[0];
        self.budget.diffusive += dt * powers[1];
        self.budget.boundaries += dt * powers[2];
        self.budget.surface_tension += dt * self.stage.tension_power;
        let forces = self.latest_forces();
        let Flow { fluid, .. } = &self.flow;
        let momentum = &mut self.budget.momentum;
        accumulate(&mut momentum.walls, -dt, forces.walls);
        forces.bodies.into_iter().for_each(|force| accumulate(&mut momentum.bodies, -dt, force));
        let mass = self.state.len() as f64 * fluid.particle_mass();
        accumulate(&mut momentum.weight, dt * mass, fluid.gravity);
        accumulate(&mut momentum.surface_tension, dt, self.stage.tension_force);
    }
}
