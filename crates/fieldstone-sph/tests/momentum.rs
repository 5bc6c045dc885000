//! The momentum budget over whole runs: what the fluid gains is what walls, bodies and weight gave it, to rounding.
#![allow(clippy::unwrap_used)]

mod common;

use common::{alone, dam_break, ramped, run_alone as run};
use fieldstone_sph::{
    Body, Boundaries, Flow, FluidOptions, Integrator, Motion, Shape, ShiftingOptions, Slip, Solver, State, Viscosity,
};

/// Largest component of the residual over the size of all impulses.
fn relative_residual(solver: &Solver) -> f64 {
    let b = &solver.budget().momentum;
    let size = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
    let scale = size(b.start) + size(b.walls) + size(b.bodies) + size(b.weight) + size(b.removed);
    solver.momentum_residual().iter().fold(0.0, |m: f64, r| m.max(r.abs())) / scale
}

#[test]
fn the_momentum_of_a_dam_break_against_an_obstacle_is_closed_to_rounding_over_the_whole_run() {
    for (integrator, slip) in [(Integrator::Symplectic, Slip::No), (Integrator::RungeKutta4, Slip::Free)] {
        let (mut flow, state) = dam_break(0.02, slip);
        flow.time_step.integrator = integrator;
        flow.shifting = Some(ShiftingOptions::default());
        flow.boundaries.bodies.push(Body::new(Shape::Box { low: [0.6, -0.1, 0.0], high: [0.7, 0.1, 0.0] }, slip));
        // Over the obstacle and out through the right face.
        flow.boundaries.walls.retain(|w| w.plane.normal()[0] >= 0.0);
        flow.boundaries.open[0][1] = true;
        flow.boundaries.high[0] = 0.9;
        let mut solver = Solver::new(flow, state).unwrap();
        run(&mut solver, 0.5);
        let budget = *solver.budget();
        let (momentum, found) = (budget.momentum, relative_residual(&solver));
        println!("{integrator:?} {slip:?}: {} steps, {} removed, residual {found:e}", solver.steps(), budget.removed);
        println!("{momentum:?} {}", budget.reflections);
        assert!(budget.removed > 10 && momentum.removed[0] > 0.0, "{budget:?}");
        // The left wall pushes to the right, the obstacle to the left, the floor up.
        assert!(momentum.walls[0] > 1.0 && momentum.bodies[0] < -1.0 && momentum.walls[1] > 100.0, "{momentum:?}");
        assert!(found < 1e-12, "{integrator:?} {slip:?}: {found:e}");
    }
}

#[test]
fn a_particle_put_back_before_a_wall_has_got_its_momentum_from_the_wall() {
    let mut fluid = FluidOptions::new(2, 0.02, 1.0, 0.0);
    fluid.viscosity = Viscosity::Dynamic(0.0);
    fluid.gravity = [0.0; 3];
    let boundaries = common::tank([0.0; 3], [1.0, 1.0, 0.0], &fluid, Slip::Free);
    // Drops far apart, so fast that density cannot turn them round before the floor.
    let x: Vec<[f64; 3]> = (1..5).map(|i| [0.2 * f64::from(i), 0.05, 0.0]).collect();
    let state = State {
        u: vec![[0.1, -8.0, 0.0]; x.len()],
        density: vec![1000.0; x.len()],
        id: (0..x.len() as u32).collect(),
        x,
    };
    let mut solver = Solver::new(Flow::new(fluid, boundaries), state).unwrap();
    run(&mut solver, 0.02);
    assert!(solver.budget().reflections > 0, "{:?}", solver.budget());
    let momentum = solver.budget().momentum;
    assert!(momentum.walls[1] > 1.5 * momentum.start[1].abs(), "{momentum:?}");
    assert!(relative_residual(&solver) < 1e-12, "{:?}", solver.momentum_residual());
}

#[test]
fn surface_tension_counts_and_what_tensile_control_creates_is_the_residual() {
    let mut residuals = Vec::new();
    for tensile in [false, true] {
        let mut fluid = FluidOptions::new(2, 0.02, 1.0, 10.0);
        (fluid.surface_tension, fluid.tensile_control) = (5.0, tensile);
        fluid.gravity = [0.0; 3];
        // Torn apart, and more on one side than on the other: the pressure is below 0 also far from the surface.
        let disc = Shape::Sphere { centre: [0.0; 3], radius: 0.2 };
        let state = common::state(&[disc], &fluid, |x| [x[0] + 8.0 * x[0] * x[0], x[1], 0.0], |_| 0.0);
        let boundaries = Boundaries::new([-1.0; 3], [1.0; 3], fluid.spacing);
        let mut solver = Solver::new(Flow::new(fluid, boundaries), state).unwrap();
        run(&mut solver, 0.1);
        let scale = solver.state().u.iter().map(|u| u[0].hypot(u[1])).sum::<f64>() * fluid.particle_mass();
        residuals.push(solver.momentum_residual()[0].hypot(solver.momentum_residual()[1]) / scale);
    }
    println!("{residuals:?}");
    assert!(residuals[0] < 1e-12, "{residuals:?}");
    assert!(residuals[1] > 1e-9, "tensile control is not conservative: {residuals:?}");
}

/// A closed channel without gravity, filled from a piston's face to the right wall but for a gap.
fn channel(motion: Option<Motion>, slip: Slip) -> Solver {
    let mut fluid = FluidOptions::new(2, 0.02, 0.5, 0.0);
    fluid.sound_speed = 10.0;
    fluid.gravity = [0.0; 3];
    let mut boundaries = common::tank([0.0; 3], [1.0, 0.2, 0.0], &fluid, slip);
    let lid = boundaries.walls[2];
    let plane = fieldstone_surface::Wall::new([0.0, -1.0, 0.0], -0.2).unwrap();
    boundaries.walls.push(fieldstone_sph::MirrorWall { plane, ..lid });
    boundaries.open = [[false; 2]; 3];
    let piston = Shape::Box { low: [0.0, -0.1, 0.0], high: [0.2, 0.3, 0.0] };
    boundaries.bodies.push(Body { motion, ..Body::new(piston, slip) });
    let water = Shape::Box { low: [0.2, 0.0, 0.0], high: [0.8, 0.2, 0.0] };
    let state = common::state(&[water], &fluid, |_| [0.0; 3], |_| 0.0);
    Solver::new(Flow::new(fluid, boundaries), state).unwrap()
}

#[test]
fn a_piston_gives_the_fluid_its_mass_times_its_velocity() {
    let speed = 0.2;
    // Sound runs to and fro in the block of 0.6 in 4 L/c = 0.24: the start is no faster than that.
    let mut solver = channel(Some(ramped(0, speed, 0.24, 1.0)), Slip::Free);
    let count = solver.state().len();
    run(&mut solver, 0.3);
    let (mut sum, mut duration) = (0.0, 0.0);
    alone(|| {
        while duration < 0.24 {
            let dt = solver.step().unwrap();
            sum += dt * solver.budget().momentum.bodies[0];
            duration += dt;
        }
    });
    let energies = solver.energies();
    let mass = count as f64 * solver.flow().fluid.particle_mass();
    let momentum = solver.budget().momentum;
    let ratio = sum / duration / (mass * speed);
    println!("impulse of the piston over m U {ratio}, residual {:e}", relative_residual(&solver));
    assert_eq!(solver.state().len(), count);
    assert!(relative_residual(&solver) < 1e-12, "{momentum:?}");
    // The gap of 0.2 is not closed yet, so all of it is the piston's.
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
    assert!(momentum.walls[0].abs() < 1e-9 * momentum.bodies[0], "{momentum:?}");
    // What the piston has done is energy of the fluid.
    assert!(solver.energy_residual().abs() < 0.02 * energies.kinetic, "{}", solver.energy_residual());
    // No particle is left behind in the piston.
    let face = 0.2 + solver.flow().boundaries.bodies[0].pose(solver.time()).displacement[0];
    assert!(solver.state().x.iter().all(|x| x[0] > face - 0.002), "{face}");
}
