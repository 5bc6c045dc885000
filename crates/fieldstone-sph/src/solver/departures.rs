//! Particles that have passed a wall, are inside a body, left through an opening, or are lost.

use rayon::prelude::*;

use super::Solver;
use crate::energy::accumulate;
use crate::{Boundaries, Energies, SphError};

impl Solver {
    /// A particle that has passed a mirror changes places with its image.
    pub(super) fn reflect_at_walls(&mut self) {
        let fluid = &self.flow.fluid;
        let stiffness = fluid.density / (fluid.sound_speed * fluid.sound_speed);
        for wall in &self.flow.boundaries.walls {
            let normal = wall.plane.normal();
            let passed = |&i: &usize| wall.plane.distance(self.state.x[i]) < 0.0;
            let passed: Vec<usize> = (0..self.state.len()).into_par_iter().filter(passed).collect();
            for i in passed {
                let x = self.state.x[i];
                let before = Energies::of_particle(x, self.state.u[i], self.state.density[i], fluid);
                let image = wall.plane.mirror(x);
                let across: f64 = (0..3).map(|k| self.state.u[i][k] * normal[k]).sum();
                let depth: f64 = (0..3).map(|k| fluid.gravity[k] * (image[k] - x[k])).sum();
                for (u, n) in self.state.u[i].iter_mut().zip(normal) {
                    *u -= 2.0 * across * n;
                }
                self.state.x[i] = image;
                self.state.density[i] += stiffness * depth;
                let after = Energies::of_particle(image, self.state.u[i], self.state.density[i], fluid);
                self.budget.shifting += after.total() - before.total();
                accumulate(&mut self.budget.momentum.walls, -2.0 * across * fluid.particle_mass(), normal);
                self.budget.reflections += 1;
            }
        }
    }

    /// Counts the particles inside bodies where these are now: nothing puts them back.
    pub(super) fn count_in_bodies(&mut self) {
        let Boundaries { bodies, .. } = &self.flow.boundaries;
        if bodies.is_empty() {
            return;
        }
        let dimension = self.flow.fluid.dimension;
        let x = &self.state.x;
        // Whoever has no ghost in reach is in no body.
        let beside = self.stage.points.beside.par_iter().map(|&i| x[i as usize]);
        let inside = |x: &[f64; 3]| bodies.iter().any(|body| body.contains(*x, self.time, dimension));
        self.budget.in_bodies += beside.filter(inside).count() as u64;
    }

    pub(super) fn check_particles(&self) -> Result<(), SphError> {
        let Boundaries { low, high, periodic, open, padding, .. } = &self.flow.boundaries;
        let dimension = self.flow.fluid.dimension;
        let flat = dimension == 2;
        let bad = (0..self.state.len()).into_par_iter().find_map_first(|i| {
            let (position, velocity, density) = (self.state.x[i], self.state.u[i], self.state.density[i]);
            let (step, time, id) = (self.steps, self.time, self.state.id[i]);
            let what = if !position.iter().chain(&velocity).all(|x| x.is_finite()) {
                Some(format!("velocity {velocity:?}"))
            } else if !(density > 0.0 && density.is_finite()) {
                Some(format!("density {density}"))
            } else if flat && (position[2] != 0.0 || velocity[2] != 0.0) {
                Some(format!("velocity {velocity:?}; in two dimensions z and its velocity must be 0"))
            } else {
                None
            };
            if let Some(what) = what {
                return Some(SphError::Broken { step, time, id, position, what });
            }
            let passed = (0..dimension).find(|&k| {
                // A periodic particle is wrapped when the lists are built next.
                let margin = if periodic[k] { high[k] - low[k] } else { *padding };
                position[k] < low[k] - margin && !open[k][0] || position[k] > high[k] + margin && !open[k][1]
            });
            let remedy = if periodic[passed?] {
                "no particle that is well passes a whole period between two lists: lessen the time step (cfl), or look at the flow \
                 before that"
            } else {
                "open that side, or find what pushes it out"
            };
            Some(SphError::Lost { step, time, id, position, velocity, remedy })
        });
        bad.map_or(Ok(()), Err)
    }

    pub(super) fn remove_beyond_openings(&mut self) -> bool {
        let Boundaries { low, high, open, .. } = &self.flow.boundaries;
        if open.iter().flatten().all(|open| !open) {
            return false;
        }
        let stays = |x: &[f64; 3]| {
            (0..self.flow.fluid.dimension).all(|k| !(open[k][0] && x[k] < low[k] || open[k][1] && x[k] > high[k]))
        };
        if self.state.x.par_iter().all(stays) {
            return false;
        }
        let (kept, gone): (Vec<u32>, Vec<u32>) =
            (0..self.state.len() as u32).partition(|&i| stays(&self.state.x[i as usize]));
        for &i in &gone {
            let i = i as usize;
            let (x, u, density) = (self.state.x[i], self.state.u[i], self.state.density[i]);
            let energies = Energies::of_particle(x, u, density, &self.flow.fluid);
            self.budget.removed_energy += energies.total();
            self.budget.removed_mass += self.flow.fluid.particle_mass();
            accumulate(&mut self.budget.momentum.removed, 1.0, energies.momentum);
            self.budget.removed += 1;
        }
        self.state.reorder(&kept);
        self.regions = crate::state::picked(&self.regions, &kept);
        self.free = crate::state::picked(&self.free, &kept);
        // Those of before: should the step fail yet, no particle shows another's.
        self.shifts.clear();
        self.stage.built_at.clear();
        self.forget_witnesses();
        self.order_due = self.steps;
        true
    }
}
