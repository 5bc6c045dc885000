//! Particles that have passed a wall, got into a body, left through an opening, or are lost.

use rayon::prelude::*;

use super::Solver;
use crate::energy::accumulate;
use crate::{Boundaries, Energies, SphError};

/// How often a particle is put back in one step: out of one body it may come into the next.
const MOST_RETURNS: usize = 4;

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

    /// A particle that has got into a body is put back as far outside, and no longer approaches it.
    ///
    /// One that is deeper than a spacing did not get there in a step, and between bodies without room there is no outside: those stay, and
    /// are counted.
    pub(super) fn return_from_bodies(&mut self) {
        let Boundaries { bodies, .. } = &self.flow.boundaries;
        if bodies.is_empty() {
            return;
        }
        let fluid = &self.flow.fluid;
        let (dimension, time, x) = (fluid.dimension, self.time, &self.state.x);
        let stiffness = fluid.density / (fluid.sound_speed * fluid.sound_speed);
        let around = |x: [f64; 3]| bodies.iter().find(|body| body.contains(x, time, dimension));
        // Whoever has no ghost in reach is in no body.
        let beside = self.stage.points.beside.par_iter().map(|&i| i as usize);
        let inside: Vec<usize> = beside.filter(|&i| around(x[i]).is_some()).collect();
        for i in inside {
            let (start, mut u) = (self.state.x[i], self.state.u[i]);
            let mut place = start;
            for _ in 0..MOST_RETURNS {
                let Some(body) = around(place) else { break };
                let (way, depth) = (body.way_out(place, time, dimension), body.depth(place, time, dimension));
                if depth > fluid.spacing {
                    break;
                }
                let own = body.pose(time).velocity;
                let approach: f64 = (0..3).map(|k| (u[k] - own[k]) * way[k]).sum::<f64>().min(0.0);
                for k in 0..3 {
                    place[k] += 2.0 * depth * way[k];
                    u[k] -= approach * way[k];
                }
            }
            if around(place).is_some() {
                self.budget.in_bodies += 1;
                continue;
            }
            let before = Energies::of_particle(start, self.state.u[i], self.state.density[i], fluid);
            let depth: f64 = (0..3).map(|k| fluid.gravity[k] * (place[k] - start[k])).sum();
            (self.state.x[i], self.state.u[i]) = (place, u);
            self.state.density[i] += stiffness * depth;
            let after = Energies::of_particle(place, u, self.state.density[i], fluid);
            self.budget.boundaries += after.kinetic - before.kinetic;
            self.budget.shifting += after.total() - after.kinetic - (before.total() - before.kinetic);
            for k in 0..3 {
                self.budget.momentum.bodies[k] += after.momentum[k] - before.momentum[k];
            }
            self.budget.reflections += 1;
        }
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
        self.stage.forget_lists();
        self.forget_witnesses();
        self.order_due = self.steps;
        true
    }
}
