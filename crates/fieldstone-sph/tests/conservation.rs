//! What a discretisation conserves exactly, and what the budget must explain.
#![allow(clippy::unwrap_used)]

mod common;

use common::{bits, dam_break, run, state, tank};
use fieldstone_sph::{
    Body, Boundaries, Flow, FluidOptions, Integrator, Shape, ShiftingOptions, Slip, Solver, Viscosity,
};
use fieldstone_surface::Method;

fn with_everything(slip: Slip) -> (Flow, fieldstone_sph::State) {
    let (mut flow, state) = dam_break(0.02, slip);
    flow.boundaries.bodies.push(Body::new(Shape::Box { low: [0.6, -0.1, 0.0], high: [0.7, 0.2, 0.0] }, slip));
    flow.shifting = Some(ShiftingOptions::default());
    (flow, state)
}

#[test]
fn forces_on_fluid_walls_and_bodies_and_weight_sum_to_zero() {
    for slip in [Slip::Free, Slip::No] {
        let (flow, state) = with_everything(slip);
        let (mass, gravity) = (flow.fluid.particle_mass(), flow.fluid.gravity);
        let mut solver = Solver::new(flow, state).unwrap();
        let mut push = 0.0;
        for time in [0.02, 0.16, 0.18, 0.2, 0.22, 0.24, 0.26, 0.28] {
            run(&mut solver, time);
            let inertia = solver.accelerations().unwrap();
            let forces = solver.boundary_forces().unwrap();
            let mut scale = 0.0;
            let mut sum = [0.0; 3];
            for k in 0..2 {
                scale += inertia.iter().map(|a| mass * a[k].abs()).sum::<f64>();
                sum[k] = inertia.iter().map(|a| mass * (a[k] - gravity[k])).sum::<f64>()
                    + forces.walls[k]
                    + forces.bodies[0][k];
            }
            assert!(forces.walls[1] < 0.0, "the floor is pressed down: {forces:?}");
            assert!(sum.iter().all(|s| s.abs() <= 1e-12 * scale), "{slip:?} {time}: {sum:?} of {scale}");
            push += forces.bodies[0][0] / 8.0;
        }
        // Hydrostatic pressure over the body's height would be 196; the wave hits it.
        assert!(push > 50.0, "the wave pushes the body forward: {push}");
    }
}

#[test]
fn momentum_of_a_drop_in_free_flight_is_kept_to_rounding() {
    let mut fluid = FluidOptions::new(2, 0.02, 1.0, 0.0);
    fluid.gravity = [0.3, -2.0, 0.0];
    let disc = Shape::Sphere { centre: [0.0; 3], radius: 0.3 };
    let state = state(&[disc], &fluid, |x| [0.5 - x[0], x[1], 0.0], |_| 0.0);
    let mut solver = Solver::new(Flow::new(fluid, Boundaries::new([-2.0; 3], [2.0; 3], 0.02)), state).unwrap();
    let start = solver.energies().momentum;
    run(&mut solver, 0.2);
    let mass = solver.state().len() as f64 * fluid.particle_mass();
    let end = solver.energies().momentum;
    for k in 0..2 {
        let expected = start[k] + mass * fluid.gravity[k] * solver.time();
        assert!((end[k] - expected).abs() < 1e-12 * mass, "{k}: {} {expected}", end[k]);
    }
}

#[test]
fn the_energy_budget_closes_and_better_with_the_fourth_order_integrator() {
    let mut residuals = Vec::new();
    for integrator in [Integrator::Symplectic, Integrator::RungeKutta4] {
        let (mut flow, state) = dam_break(0.02, Slip::Free);
        flow.time_step.integrator = integrator;
        flow.shifting = Some(ShiftingOptions::default());
        let mut solver = Solver::new(flow, state).unwrap();
        run(&mut solver, 0.5);
        let energies = solver.energies();
        let budget = *solver.budget();
        let moved = budget.start - energies.potential;
        assert!(moved > 100.0 && energies.kinetic > 0.4 * moved, "the column falls: {energies:?} {budget:?}");
        assert!(budget.viscous < 0.0 && budget.diffusive < 0.0, "{budget:?}");
        residuals.push(solver.energy_residual().abs() / moved);
    }
    assert!(residuals[0] < 0.01 && residuals[1] < 0.002, "{residuals:?}");
}

#[test]
fn one_and_two_threads_give_the_same_bits() {
    let runs: Vec<Vec<u64>> = [1, 2]
        .into_iter()
        .map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let (flow, state) = with_everything(Slip::No);
                let mut solver = Solver::new(flow, state).unwrap();
                run(&mut solver, 0.15);
                bits(&solver)
            })
        })
        .collect();
    assert!(!runs[0].is_empty() && runs[0] == runs[1]);
}

#[test]
fn what_leaves_through_the_open_top_is_counted_with_its_mass_and_energy() {
    let (flow, mut state) = dam_break(0.02, Slip::Free);
    for u in &mut state.u {
        *u = [0.0, 4.0, 0.0];
    }
    let mut flow = flow;
    flow.fluid.expected_speed = 2.9;
    flow.boundaries.high[1] = 0.45;
    let count = state.len();
    let mut solver = Solver::new(flow, state).unwrap();
    run(&mut solver, 0.25);
    let budget = *solver.budget();
    assert!(budget.removed > 20, "{budget:?}");
    assert_eq!(solver.state().len() as u64 + budget.removed, count as u64);
    let mass = budget.removed as f64 * solver.flow().fluid.particle_mass();
    assert!((budget.removed_mass - mass).abs() < 1e-9 * mass);
    assert!(solver.energy_residual().abs() < 0.01 * budget.start, "{}", solver.energy_residual());
}

#[test]
fn a_flow_goes_on_when_its_last_particle_has_left() {
    let mut fluid = FluidOptions::new(2, 0.05, 4.0, 10_000.0);
    fluid.gravity = [0.0, -9.81, 0.0];
    let mut boundaries = Boundaries::new([0.0; 3], [1.0, 1.0, 0.0], 0.05);
    boundaries.open = [[true; 2], [true; 2], [false; 2]];
    let block = Shape::Box { low: [0.2, 0.0, 0.0], high: [0.5, 0.3, 0.0] };
    let state = state(&[block], &fluid, |_| [0.0; 3], |_| 0.0);
    let count = state.len() as u64;
    let mut flow = Flow::new(fluid, boundaries);
    flow.shifting = Some(ShiftingOptions::default());
    let mut solver = Solver::new(flow, state).unwrap();
    run(&mut solver, 0.4);
    assert_eq!((solver.state().len(), solver.budget().removed), (0, count));
}

#[test]
fn a_flow_does_not_vary_along_a_periodic_direction_or_between_slipping_walls() {
    let mut found = Vec::new();
    for periodic in [true, false] {
        let mut fluid = FluidOptions::new(3, 0.05, 2.0, 4000.0);
        fluid.sound_speed = 30.0;
        let mut boundaries = tank([0.0; 3], [1.2, 0.45, 1.0], &fluid, Slip::Free);
        if periodic {
            boundaries.walls.retain(|w| w.plane.normal()[1] == 0.0);
            boundaries.periodic[1] = true;
        }
        let column = Shape::Box { low: [0.0; 3], high: [0.4, 0.45, 0.3] };
        let state = state(&[column], &fluid, |_| [0.0; 3], |x| 9810.0 * (0.3 - x[2]));
        let mut solver = Solver::new(Flow::new(fluid, boundaries), state).unwrap();
        run(&mut solver, 0.1);
        let state = solver.state();
        let mut order: Vec<usize> = (0..state.len()).collect();
        order.sort_by_key(|&i| state.id[i]);
        // Along y, of the lattice 8 × 9 × 6.
        for x in 0..8 {
            for z in 0..6 {
                let at = |y: usize| state.x[order[(x * 9 + y) * 6 + z]];
                assert!((1..9).all(|y| (at(y)[0] - at(0)[0]).abs() < 1e-9 && (at(y)[2] - at(0)[2]).abs() < 1e-9));
                found.push(at(4)[0]);
            }
        }
    }
    let (periodic, walls) = found.split_at(48);
    assert!(periodic.iter().zip(walls).all(|(a, b)| (a - b).abs() < 1e-9));
}

#[test]
fn a_floor_without_slip_slows_the_flow_down_and_one_with_slip_does_not() {
    let mut speeds = Vec::new();
    for slip in [Slip::Free, Slip::No] {
        let mut fluid = FluidOptions::new(2, 0.02, 1.0, 0.0);
        fluid.gravity = [0.0; 3];
        fluid.viscosity = Viscosity::Dynamic(5.0);
        let mut boundaries = tank([0.0; 3], [0.4, 0.2, 0.0], &fluid, slip);
        boundaries.walls.retain(|w| w.plane.normal()[0] == 0.0);
        boundaries.periodic[0] = true;
        let sheet = Shape::Box { low: [0.0; 3], high: [0.4, 0.2, 0.0] };
        let state = state(&[sheet], &fluid, |_| [1.0, 0.0, 0.0], |_| 0.0);
        let mut solver = Solver::new(Flow::new(fluid, boundaries), state).unwrap();
        run(&mut solver, 0.5);
        let count = solver.state().len() as f64;
        speeds.push(solver.energies().momentum[0] / (count * fluid.particle_mass()));
    }
    // ∂u/∂t = ν ∂²u/∂y² from rest at the wall and no shear at the top: the mean decays by the series of cosines.
    let (nu, height, time) = (5e-3, 0.2, 0.5);
    let series = |n: i32| {
        let k = (f64::from(n) + 0.5) * std::f64::consts::PI;
        2.0 / (k * k) * (-nu * k * k / (height * height) * time).exp()
    };
    let expected: f64 = (0..50).map(series).sum();
    assert!((speeds[0] - 1.0).abs() < 1e-12, "{speeds:?}");
    assert!((speeds[1] - expected).abs() < 0.03, "{speeds:?} {expected}");
}

#[test]
fn detection_methods_can_be_exchanged_and_shifting_follows_them() {
    let mut counts = Vec::new();
    for method in [Method::Exact, Method::Wang, Method::Marrone, Method::Sun] {
        let (mut flow, state) = dam_break(0.02, Slip::Free);
        flow.detection = Some(method);
        flow.shifting = Some(ShiftingOptions::default());
        let mut solver = Solver::new(flow, state).unwrap();
        run(&mut solver, 0.1);
        let regions = solver.regions();
        counts.push([0, 1, 2].map(|r| regions.iter().filter(|&&x| x == r).count()));
        let unmoved = solver.shifts().zip(regions).all(|(s, &r)| r != 0 || s == [0.0; 3]);
        assert!(unmoved && solver.shifts().any(|s| s != [0.0; 3]));
    }
    // 20 × 15 particles: the top and the right side, a layer of 2h = 4 Δx below, the rest.
    assert!(counts.iter().all(|c| (30..=45).contains(&c[0]) && c[1] > 90 && c[2] > 60), "{counts:?}");
    assert_eq!(counts[0], counts[3]);
}

#[test]
fn detection_without_shifting_tells_the_regions_and_moves_nothing() {
    for tensile in [false, true] {
        let (mut flow, state) = dam_break(0.02, Slip::Free);
        flow.detection = Some(Method::Exact);
        flow.fluid.tensile_control = tensile;
        let mut solver = Solver::new(flow, state).unwrap();
        for _ in 0..3 {
            // The column's surface, what is within 2h of it, and the rest.
            let mut counts = [0; 3];
            solver.regions().iter().for_each(|&r| counts[r as usize] += 1);
            assert!(counts[0] > 20 && counts[1] > 2 * counts[0] && counts[2] > counts[0], "{counts:?}");
            assert_eq!(solver.shifts().count(), 0);
            solver.step().unwrap();
        }
    }
}

#[test]
fn a_lone_particle_is_counted_as_singular_once_per_step() {
    for integrator in [Integrator::Symplectic, Integrator::RungeKutta4] {
        let mut fluid = FluidOptions::new(2, 0.02, 1.0, 0.0);
        fluid.gravity = [0.0; 3];
        let x = vec![[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]];
        let state = fieldstone_sph::State { u: vec![[0.0; 3]; 2], density: vec![1000.0; 2], id: vec![0, 1], x };
        let mut flow = Flow::new(fluid, Boundaries::new([-1.0; 3], [1.0; 3], 0.02));
        flow.time_step.integrator = integrator;
        let mut solver = Solver::new(flow, state).unwrap();
        (0..11).for_each(|_| assert!(solver.step().unwrap() > 0.0));
        assert_eq!(solver.budget().singular, 22, "{integrator:?}");
    }
}
