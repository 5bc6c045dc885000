//! Periodic axes: the weight along them, bodies at their faces, levels beside them.
#![allow(clippy::unwrap_used)]

mod common;

use common::{run_alone as run, state, tank};
use fieldstone_sph::{Flow, FluidOptions, Integrator, Shape, Slip, Solver, Viscosity, gauge_columns, gauge_row};

#[test]
fn particles_that_are_faster_than_their_lists_last_are_wrapped_all_the_same() {
    // Half of the lists' margin is passed within a stage, so that they are made anew between stages, step by step.
    let mut fluid = FluidOptions::new(2, 0.02, 1.5, 0.0);
    fluid.gravity = [0.0; 3];
    let mut boundaries = tank([0.0; 3], [0.2, 0.2, 0.0], &fluid, Slip::Free);
    boundaries.walls.retain(|w| w.plane.normal()[0] == 0.0);
    boundaries.periodic[0] = true;
    let sheet = Shape::Box { low: [0.0; 3], high: [0.2, 0.2, 0.0] };
    let state = state(&[sheet], &fluid, |_| [1.5, 0.0, 0.0], |_| 0.0);
    let mut flow = Flow::new(fluid, boundaries);
    (flow.time_step.integrator, flow.time_step.cfl) = (Integrator::RungeKutta4, 1.5);
    let mut solver = Solver::new(flow, state).unwrap();
    run(&mut solver, 0.5);
    assert!(solver.state().x.iter().all(|x| x[0] > -0.01 && x[0] < 0.21));
    assert!(solver.state().u.iter().all(|u| (u[0] - 1.5).abs() < 1e-9));
}

#[test]
fn the_energy_of_a_flow_that_its_weight_drives_through_a_period_is_accounted_for() {
    for weight in [2.0, -2.0] {
        let mut fluid = FluidOptions::new(2, 0.02, 1.5, 0.0);
        fluid.viscosity = Viscosity::Dynamic(2.0);
        fluid.gravity = [weight, 0.0, 0.0];
        let mut boundaries = tank([0.0; 3], [0.2, 0.2, 0.0], &fluid, Slip::No);
        boundaries.walls.retain(|w| w.plane.normal()[0] == 0.0);
        boundaries.periodic[0] = true;
        let sheet = Shape::Box { low: [0.0; 3], high: [0.2, 0.2, 0.0] };
        let state = state(&[sheet], &fluid, |_| [0.5 * weight.signum(), 0.0, 0.0], |_| 0.0);
        let mass = state.len() as f64 * fluid.particle_mass();
        let mut flow = Flow::new(fluid, boundaries);
        (flow.time_step.integrator, flow.time_step.cfl) = (Integrator::RungeKutta4, 1.0);
        let mut solver = Solver::new(flow, state).unwrap();
        run(&mut solver, 1.0);
        // Each particle is through the period twice at least.
        let through = 2.0 * mass * 2.0 * 0.2;
        let residual = solver.energy_residual();
        let columns = gauge_columns(&[], false);
        let row = gauge_row(&mut solver, &[]).unwrap();
        let wrapping = row[columns.iter().position(|name| name == "wrapping").unwrap()];
        println!("g {weight}: {wrapping} through the period, residual {residual:e}");
        assert!(wrapping > through, "{wrapping} {through}");
        assert!(residual.abs() < 1e-3 * through, "{residual} of {through}");
    }
}
