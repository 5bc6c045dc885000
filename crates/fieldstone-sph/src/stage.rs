//! One evaluation of the right-hand sides.

use std::time::Instant;

use rayon::prelude::*;

use crate::density_gradient::DensityGradient;
use crate::phases::{Phase, Phases};
use crate::points::Points;
use crate::rates::{Rate, Rates};
use crate::surface_tension::SurfaceTension;
use crate::{Flow, SphError, State, body_state};

/// Neighbours, columns and rates of the latest state that was evaluated.
#[derive(Debug)]
pub(crate) struct Stage {
    pub(crate) points: Points,
    pub(crate) rates: Vec<Rate>,
    pub(crate) gradients: Vec<[f64; 4]>,
    tension: SurfaceTension,
    /// Power of surface tension and its force on the fluid as a whole, of the latest evaluation.
    pub(crate) tension_power: f64,
    pub(crate) tension_force: [f64; 3],
    /// Time at which bodies are where they are.
    placed_at: f64,
    /// Time at which they were where the lists were built.
    pub(crate) listed_at: f64,
    /// Whether there are lists.
    listed: bool,
    /// Positions that they were built for.
    pub(crate) built_at: Vec<[f64; 3]>,
    /// Margin of the lists beyond the kernel's reach.
    pub(crate) skin: f64,
    pub(crate) phases: Phases,
}

impl Stage {
    pub(crate) fn new(flow: &Flow) -> Result<Self, SphError> {
        let skin = flow.skin * flow.fluid.spacing;
        let reach = flow.fluid.kernel().reach() + skin;
        Ok(Self {
            points: Points::new(&flow.fluid, &flow.boundaries, reach)?,
            rates: Vec::new(),
            gradients: Vec::new(),
            tension: SurfaceTension::default(),
            tension_power: 0.0,
            tension_force: [0.0; 3],
            placed_at: 0.0,
            listed_at: 0.0,
            listed: false,
            built_at: Vec::new(),
            skin,
            phases: Phases::default(),
        })
    }

    /// Puts the bodies where they are at a time.
    pub(crate) fn place_bodies(&mut self, time: f64, flow: &Flow) {
        self.points.bodies.place(&flow.boundaries, time);
        self.placed_at = time;
    }

    /// Builds the lists for positions.
    pub(crate) fn build(&mut self, x: &[[f64; 3]], flow: &Flow) -> Result<(), SphError> {
        let mut clock = Instant::now();
        self.points.list_neighbours(x, &flow.boundaries)?;
        self.built_at.clear();
        self.built_at.extend_from_slice(x);
        self.listed = true;
        self.listed_at = self.placed_at;
        self.phases.lists_built += 1;
        self.phases.add(Phase::Neighbours, &mut clock);
        Ok(())
    }

    /// Drops the lists: the particles are not those that they were built for.
    pub(crate) fn forget_lists(&mut self) {
        self.built_at.clear();
        self.listed = false;
    }

    /// Largest distance of a particle, or of a body, from where the lists were built; infinite without lists.
    pub(crate) fn displacement(&self, x: &[[f64; 3]]) -> f64 {
        if !self.listed || self.built_at.len() != x.len() {
            return f64::INFINITY;
        }
        let square = |(a, b): (&[f64; 3], &[f64; 3])| {
            let (dx, dy, dz) = (a[0] - b[0], a[1] - b[1], a[2] - b[2]);
            dx * dx + dy * dy + dz * dz
        };
        let particles = x.par_iter().zip(&self.built_at).map(square).reduce(|| 0.0, f64::max).sqrt();
        particles.max(self.points.bodies.moved())
    }

    /// Builds the lists where a particle may have moved out of them.
    pub(crate) fn ensure_lists(&mut self, x: &[[f64; 3]], flow: &Flow) -> Result<(), SphError> {
        // A position that is not a number moves no maximum; the check after the step names it.
        if 2.0 * self.displacement(x) > self.skin { self.build(x, flow) } else { Ok(()) }
    }

    /// Rates of a state at a time; `regions` of the particles are for tensile control.
    pub(crate) fn evaluate(&mut self, state: &State, time: f64, flow: &Flow, regions: &[u8]) -> Result<(), SphError> {
        self.place_bodies(time, flow);
        self.ensure_lists(&state.x, flow)?;
        let mut clock = Instant::now();
        let fluid = &flow.fluid;
        self.points.fill_carriers(state, fluid.particle_mass());
        body_state::interpolate(&mut self.points, fluid);
        self.phases.add(Phase::Columns, &mut clock);

        let points = &self.points;
        self.gradients.resize(state.len(), [0.0; 4]);
        let gradient = DensityGradient::new(fluid, &points.carriers);
        points.fluid_list.sum(&gradient, &mut self.gradients);
        self.phases.add(Phase::Gradient, &mut clock);
        self.points.fill_gradients(&self.gradients);
        body_state::interpolate_gradients(&mut self.points, fluid);
        self.phases.add(Phase::Columns, &mut clock);

        let points = &self.points;
        self.rates.resize(state.len(), Rate::default());
        let tensile = fluid.tensile_control.then_some(regions);
        if points.needs_viscous {
            points.fluid_list.sum(&Rates::<true>::new(fluid, points, tensile), &mut self.rates);
        } else {
            points.fluid_list.sum(&Rates::<false>::new(fluid, points, tensile), &mut self.rates);
        }
        (self.tension_power, self.tension_force) = (0.0, [0.0; 3]);
        if fluid.surface_tension > 0.0 {
            (self.tension_power, self.tension_force) = self.tension.add(fluid, points, &mut self.rates);
        }
        self.phases.add(Phase::Rates, &mut clock);
        Ok(())
    }
}
