//! The state in time: lists, stages, what happens after each step.

mod departures;
mod free_surface;
mod integrators;

use std::time::Instant;

use fieldstone_particles::{Image, NeighbourGrid};
use fieldstone_surface::{Detection, Method};
use rayon::prelude::*;

use self::free_surface::Detector;
use crate::boundary_forces::{BoundaryForces, boundary_forces};
use crate::ghosts::Ghosts;
use crate::neighbour_count::NeighbourCount;
use crate::phases::{Phase, Phases};
use crate::spatial_order::spatial_order;
use crate::stage::Stage;
use crate::{Boundaries, Budget, Energies, Flow, Integrator, SphError, State};

/// Steps for which particles keep their order: neighbours in space part slowly.
const ORDER_LASTS: u64 = 20;

/// The δ-SPH solver.
///
/// Holds the state, the neighbour lists and what the run has gained and lost. Results do not depend on the number of
/// threads: every particle gathers its own sums, in the order of its list.
///
/// Memory: about 1.2 kB per particle for h/Δx = 2 in three dimensions, a third of it neighbour lists
/// ([`bytes`](Self::bytes) tells).
///
/// A drop in free flight keeps its momentum:
///
/// ```
/// use fieldstone_sph::{Boundaries, Flow, FluidOptions, Shape, Solver, State};
/// let mut fluid = FluidOptions::new(2, 0.05, 1.0, 0.0);
/// fluid.gravity = [0.0; 3];
/// let disc = Shape::Sphere { centre: [0.0; 3], radius: 0.5 };
/// let (x, _) = disc.lattice(0.05, 2);
/// let state = State {
///     u: x.iter().map(|x| [-x[0], x[1], 0.0]).collect(),
///     density: vec![1000.0; x.len()],
///     id: (0..x.len() as u32).collect(),
///     x,
/// };
/// let flow = Flow::new(fluid, Boundaries::new([-2.0; 3], [2.0; 3], 0.05));
/// let mut solver = Solver::new(flow, state)?;
/// for _ in 0..20 {
///     solver.step()?;
/// }
/// let momentum = solver.energies().momentum;
/// assert!(momentum.iter().all(|p| p.abs() < 1e-10));
/// # Ok::<(), fieldstone_sph::SphError>(())
/// ```
#[derive(Debug)]
pub struct Solver {
    flow: Flow,
    state: State,
    /// Region of each particle at the end of the last step: 0 free surface, 1 near it, 2 inside.
    regions: Vec<u8>,
    /// 1 on the free surface.
    free: Vec<u8>,
    shifts: Vec<([f64; 3], u8)>,
    stage: Stage,
    /// State between the stages of a step.
    middle: State,
    detector: Option<Detector>,
    detection: Detection,
    detection_grid: Option<NeighbourGrid>,
    images: Vec<Image>,
    time: f64,
    steps: u64,
    last_step: f64,
    fastest: f64,
    /// C_ν.
    viscous_factor: f64,
    /// Whether neighbours are to be listed anew at the start of the next step.
    lists_due: bool,
    /// Step from which on the particles are put in order when neighbours are listed.
    order_due: u64,
    budget: Budget,
    /// Fingerprint of the state at time 0.
    began: u32,
}

/// How long a step may be.
struct StepLength {
    length: f64,
    /// The length over the one that sound alone would allow.
    share: f64,
    /// Speed of the fastest particle.
    fastest: f64,
}

/// What a solver is restarted from, beside its flow.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Snapshot {
    pub(crate) state: State,
    pub(crate) regions: Vec<u8>,
    pub(crate) built_at: Vec<[f64; 3]>,
    pub(crate) listed_at: f64,
    pub(crate) time: f64,
    pub(crate) steps: u64,
    pub(crate) last_step: f64,
    pub(crate) fastest: f64,
    pub(crate) lists_due: bool,
    pub(crate) order_due: u64,
    pub(crate) budget: Budget,
    pub(crate) began: u32,
}

impl Solver {
    /// A solver at time 0.
    ///
    /// # Errors
    /// As [`Flow::validate`]; [`SphError::Length`], and [`SphError::Broken`] for a state that is not one.
    pub fn new(flow: Flow, state: State) -> Result<Self, SphError> {
        flow.validate()?;
        Self::of_checked(flow, state)
    }

    /// As [`new`](Self::new), with a flow that was validated.
    pub(crate) fn of_checked(flow: Flow, state: State) -> Result<Self, SphError> {
        let began = state.fingerprint();
        let mut solver = Self::with(flow, state)?;
        solver.began = began;
        solver.check_particles()?;
        let energies = solver.energies();
        solver.budget.start = energies.total();
        solver.budget.momentum.start = energies.momentum;
        if solver.detector.is_some() {
            solver.detect()?;
            solver.find_regions()?;
        }
        Ok(solver)
    }

    fn with(flow: Flow, state: State) -> Result<Self, SphError> {
        let count = state.len();
        for (name, found) in
            [("the velocity", state.u.len()), ("the density", state.density.len()), ("the number", state.id.len())]
        {
            if found != count {
                return Err(SphError::Length { name, found, expected: count });
            }
        }
        let wanted =
            flow.detection.or((flow.shifting.is_some() || flow.fluid.tensile_control).then_some(Method::Exact));
        let detector = wanted.map(Detector::new).transpose()?;
        Ok(Self {
            regions: vec![2; count],
            free: vec![0; count],
            shifts: Vec::new(),
            stage: Stage::new(&flow)?,
            middle: state.clone(),
            detector,
            detection: Detection::default(),
            detection_grid: None,
            images: Vec::new(),
            time: 0.0,
            steps: 0,
            last_step: 0.0,
            fastest: 0.0,
            viscous_factor: flow.time_step.viscous_factor(&flow.fluid),
            lists_due: true,
            order_due: 0,
            budget: Budget::default(),
            began: 0,
            flow,
            state,
        })
    }

    pub(crate) fn restored(flow: Flow, snapshot: Snapshot) -> Result<Self, SphError> {
        let mut solver = Self::with(flow, snapshot.state)?;
        solver.free = snapshot.regions.iter().map(|&r| u8::from(r == 0)).collect();
        solver.regions = snapshot.regions;
        solver.time = snapshot.time;
        solver.steps = snapshot.steps;
        solver.last_step = snapshot.last_step;
        solver.fastest = snapshot.fastest;
        solver.lists_due = snapshot.lists_due;
        solver.order_due = snapshot.order_due;
        solver.budget = snapshot.budget;
        solver.began = snapshot.began;
        if !snapshot.lists_due {
            solver.stage.place_bodies(snapshot.listed_at, &solver.flow);
            solver.stage.build(&snapshot.built_at, &solver.flow)?;
        }
        Ok(solver)
    }

    pub(crate) fn snapshot(&self) -> Snapshot {
        Snapshot {
            state: self.state.clone(),
            regions: self.regions.clone(),
            built_at: if self.lists_due { Vec::new() } else { self.stage.built_at.clone() },
            listed_at: if self.lists_due { 0.0 } else { self.stage.listed_at },
            time: self.time,
            steps: self.steps,
            last_step: self.last_step,
            fastest: self.fastest,
            lists_due: self.lists_due,
            order_due: self.order_due,
            budget: self.budget,
            began: self.began,
        }
    }

    /// Whether the state at time 0 was this one, to the bit; also after a restart.
    pub fn began_with(&self, state: &State) -> bool {
        self.began == state.fingerprint()
    }

    /// The flow.
    pub fn flow(&self) -> &Flow {
        &self.flow
    }

    /// The particles.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Region of each particle: 0 free surface, 1 within 2h of it, 2 inside; all 2 without detection.
    pub fn regions(&self) -> &[u8] {
        &self.regions
    }

    /// Whether every step finds the free surface.
    pub fn detects(&self) -> bool {
        self.detector.is_some()
    }

    /// Latest shift of each particle; empty without shifting or before the first step.
    pub fn shifts(&self) -> impl Iterator<Item = [f64; 3]> {
        self.shifts.iter().map(|s| s.0)
    }

    /// Time reached.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Steps made since time 0.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Length of the latest step.
    pub fn last_step(&self) -> f64 {
        self.last_step
    }

    /// Gains and losses since the start.
    pub fn budget(&self) -> &Budget {
        &self.budget
    }

    /// Where the time went.
    pub fn phases(&self) -> &Phases {
        &self.stage.phases
    }

    /// Energies and momentum of the present state.
    pub fn energies(&self) -> Energies {
        Energies::of(&self.state, &self.flow.fluid)
    }

    /// What the energy budget does not explain: the error of time integration.
    pub fn energy_residual(&self) -> f64 {
        let b = &self.budget;
        let gains =
            b.viscous + b.diffusive + b.boundaries + b.shifting + b.surface_tension + b.wrapping - b.removed_energy;
        self.energies().total() - b.start - gains
    }

    /// What the momentum budget does not explain: rounding, and what tensile control creates.
    pub fn momentum_residual(&self) -> [f64; 3] {
        let (found, expected) = (self.energies().momentum, self.budget.momentum.expected());
        std::array::from_fn(|k| found[k] - expected[k])
    }

    /// Ghosts within the kernel's reach of the boundaries: images of particles, and particles of bodies.
    pub fn ghost_count(&self) -> usize {
        let mut ghosts = Ghosts::new(&self.flow.boundaries, self.flow.fluid.dimension, [0.0; 3]);
        ghosts.rebuild(&self.state.x, &self.flow.boundaries, self.flow.fluid.kernel().reach());
        ghosts.images.len() + self.stage.points.bodies.x.len()
    }

    /// Mean number of points within the kernel's reach, the particle itself left out; 0 where there is no particle.
    ///
    /// Needs the solver to itself: the present state is evaluated for it, as at the start of a step. Neither the state nor
    /// what a checkpoint holds changes.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn mean_neighbours(&mut self) -> Result<f64, SphError> {
        self.evaluate()?;
        let points = &self.stage.points;
        let mut counts = vec![0u32; self.state.len()];
        points.fluid_list.sum(&NeighbourCount::new(self.flow.fluid.kernel().reach(), &points.carriers), &mut counts);
        // Each counts itself, unless its position is no number.
        let others: u64 = counts.iter().map(|&c| u64::from(c).saturating_sub(1)).sum();
        Ok(others as f64 / self.state.len().max(1) as f64)
    }

    /// Bytes that the solver holds from step to step; writing the particles takes some 100 more of each for a moment.
    pub fn bytes(&self) -> usize {
        // State and its middle, rates, gradients, shifts, positions of the lists, regions.
        let per_particle = 2 * (24 + 24 + 8 + 4) + 56 + 32 + 32 + 24 + 2;
        // Positions, volumes, what is fluid, sorted columns, directions that were free, labels; images with their sources.
        let detection = if self.detector.is_some() { 33 + 36 + 28 + 3 } else { 0 };
        self.state.len() * (per_particle + detection) + self.images.len() * (32 + 36) + self.stage.points.bytes()
    }

    /// Acceleration of every particle in the present state.
    ///
    /// Evaluates the state, as [`mean_neighbours`](Self::mean_neighbours) does.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn accelerations(&mut self) -> Result<Vec<[f64; 3]>, SphError> {
        self.evaluate()?;
        Ok(self.stage.rates.iter().map(|r| r.acceleration).collect())
    }

    /// Forces of the fluid on walls and bodies in the present state.
    ///
    /// Evaluates the state, as [`mean_neighbours`](Self::mean_neighbours) does.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn boundary_forces(&mut self) -> Result<BoundaryForces, SphError> {
        self.evaluate()?;
        Ok(self.latest_forces())
    }

    /// The time step that the present state allows.
    ///
    /// Evaluates the state, as [`mean_neighbours`](Self::mean_neighbours) does.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn allowed_step(&mut self) -> Result<f64, SphError> {
        self.evaluate()?;
        Ok(self.step_length().length)
    }

    /// Rates of the present state.
    fn evaluate(&mut self) -> Result<(), SphError> {
        self.stage.evaluate(&self.state, self.time, &self.flow, &self.regions)
    }

    /// Forces on walls and bodies in the latest evaluation.
    fn latest_forces(&self) -> BoundaryForces {
        let Flow { fluid, boundaries, .. } = &self.flow;
        let tensile = fluid.tensile_control.then_some(&self.regions[..]);
        boundary_forces(&self.stage.points, fluid, boundaries, tensile)
    }

    /// Largest speed of a particle at the start of any step since time 0.
    pub fn fastest(&self) -> f64 {
        self.fastest
    }

    /// The time step for the latest evaluation.
    fn step_length(&self) -> StepLength {
        let square = |v: &[f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let fastest = self.state.u.par_iter().map(square).reduce(|| 0.0, f64::max).sqrt();
        let acceleration = self.stage.rates.par_iter().map(|r| square(&r.acceleration)).reduce(|| 0.0, f64::max).sqrt();
        let Flow { fluid, time_step, .. } = &self.flow;
        let step = |speed, acceleration| time_step.step_with(self.viscous_factor, fluid, speed, acceleration);
        let allowed = step(fastest, acceleration);
        // A body counts with the fastest that it will be within the step.
        let motions = self.flow.boundaries.bodies.iter().filter_map(|b| b.motion.as_ref());
        let (speed, acceleration) = motions
            .map(|m| m.largest(self.time, self.time + allowed))
            .fold((fastest, acceleration), |(u, a), (v, b)| (u.max(v), a.max(b)));
        let length = step(speed, acceleration);
        StepLength { length, share: time_step.share_of_sound(fluid, speed, length), fastest }
    }

    /// Makes one time step and returns its length.
    ///
    /// # Errors
    /// [`SphError::Broken`] where a number is not one any more, [`SphError::Lost`] where a particle leaves the domain
    /// without an opening; the detection's errors. The state then is that of the failure, for a look.
    pub fn step(&mut self) -> Result<f64, SphError> {
        if self.lists_due {
            self.list_anew()?;
        }
        self.stage.place_bodies(self.time, &self.flow);
        let before = self.stage.displacement(&self.state.x);
        let listed = self.stage.phases.lists_built;
        self.evaluate()?;
        let mut clock = Instant::now();
        // Here and not with what is booked in every stage, of which integrators have different numbers.
        self.budget.singular += self.stage.gradients.par_iter().filter(|g| g[3] != 0.0).count() as u64;
        let StepLength { length: dt, share, fastest } = self.step_length();
        self.fastest = self.fastest.max(fastest);
        self.stage.phases.add(Phase::Rest, &mut clock);
        match self.flow.time_step.integrator {
            Integrator::Symplectic => self.step_symplectic(dt)?,
            Integrator::RungeKutta4 => self.step_runge_kutta(dt)?,
        }
        clock = Instant::now();
        self.time += dt;
        self.steps += 1;
        self.last_step = dt;
        self.stage.place_bodies(self.time, &self.flow);
        self.return_from_bodies();
        self.reflect_at_walls();
        self.check_particles()?;
        let removed = self.remove_beyond_openings();
        self.stage.phases.add(Phase::Rest, &mut clock);
        if self.detector.is_some() {
            self.detect()?;
            match self.flow.shifting {
                Some(shifting) => self.shift(&shifting, share)?,
                None => self.find_regions()?,
            }
        }
        clock = Instant::now();
        let after = self.stage.displacement(&self.state.x);
        // Lists made between the stages follow particles beyond a period: for those that are fast, nothing would ever be due.
        let followed = self.stage.phases.lists_built > listed && self.is_beyond_a_period();
        self.lists_due = removed || followed || 2.0 * (after + 1.2 * (after - before).max(0.0)) > self.stage.skin;
        self.stage.phases.steps += 1;
        self.stage.phases.add(Phase::Rest, &mut clock);
        Ok(dt)
    }

    /// Whether a particle is to be wrapped.
    fn is_beyond_a_period(&self) -> bool {
        let Boundaries { low, high, periodic, .. } = &self.flow.boundaries;
        let beyond = |x: &[f64; 3]| (0..3).any(|k| periodic[k] && !(low[k]..high[k]).contains(&x[k]));
        periodic.contains(&true) && self.state.x.par_iter().any(beyond)
    }

    /// Wraps periodic positions, puts the particles in order where that is due, and lists neighbours.
    fn list_anew(&mut self) -> Result<(), SphError> {
        let Boundaries { low, high, periodic, .. } = self.flow.boundaries;
        for axis in (0..3).filter(|&k| periodic[k]) {
            let length = high[axis] - low[axis];
            // Periods by which particles are put back, those along the axis less those against it.
            let mut periods = 0i64;
            for x in &mut self.state.x {
                if x[axis] < low[axis] {
                    x[axis] += length;
                    periods -= 1;
                } else if x[axis] >= high[axis] {
                    x[axis] -= length;
                    periods += 1;
                }
            }
            let fluid = &self.flow.fluid;
            self.budget.wrapping += fluid.particle_mass() * fluid.gravity[axis] * length * periods as f64;
        }
        if self.steps >= self.order_due {
            let order = spatial_order(&self.state.x);
            self.state.reorder(&order);
            self.regions = crate::state::picked(&self.regions, &order);
            self.free = crate::state::picked(&self.free, &order);
            if self.shifts.len() == order.len() {
                self.shifts = crate::state::picked(&self.shifts, &order);
            }
            self.forget_witnesses();
            self.order_due = self.steps + ORDER_LASTS;
        }
        self.stage.place_bodies(self.time, &self.flow);
        self.stage.build(&self.state.x, &self.flow)?;
        self.lists_due = false;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FluidOptions, Shape, ShiftingOptions};

    #[test]
    fn a_flow_without_particles_has_no_neighbours() {
        let fluid = FluidOptions::new(2, 0.1, 1.0, 0.0);
        let flow = Flow::new(fluid, Boundaries::new([-2.0; 3], [2.0; 3], 0.1));
        assert_eq!(Solver::new(flow, State::default()).unwrap().mean_neighbours().unwrap(), 0.0);
    }

    #[test]
    fn shifts_follow_their_particles_into_another_order() {
        let mut fluid = FluidOptions::new(2, 0.1, 1.0, 0.0);
        fluid.gravity = [0.0; 3];
        let (x, _) = Shape::Sphere { centre: [0.0; 3], radius: 1.0 }.lattice(0.1, 2);
        let count = x.len();
        let state = State {
            u: x.iter().map(|x| [-x[0], x[1], 0.0]).collect(),
            density: vec![1000.0; count],
            id: (0..count as u32).collect(),
            x,
        };
        let mut flow = Flow::new(fluid, Boundaries::new([-2.0; 3], [2.0; 3], 0.1));
        flow.shifting = Some(ShiftingOptions::default());
        let mut solver = Solver::new(flow, state).unwrap();
        solver.step().unwrap();
        let by_number = |solver: &Solver| {
            let mut all: Vec<_> = solver.state.id.iter().copied().zip(solver.shifts()).collect();
            all.sort_by_key(|(id, _)| *id);
            all
        };
        let before = by_number(&solver);
        assert!(before.iter().any(|(_, shift)| *shift != [0.0; 3]));
        solver.state.x.reverse();
        solver.state.id.reverse();
        solver.shifts.reverse();
        solver.order_due = 0;
        solver.list_anew().unwrap();
        assert_eq!(by_number(&solver), before);
    }
}
