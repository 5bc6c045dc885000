//! Periodic axes: the weight along them, bodies at their faces, levels beside them.
#![allow(clippy::unwrap_used)]

mod common;

use common::{run_alone as run, state, tank};
use fieldstone_sph::{
    Body, Boundaries, Case, Flow, FluidOptions, Integrator, Motion, Shape, Slip, Solver, SphError, Viscosity,
    gauge_columns, gauge_row,
};

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
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("checkpoint.bin");
        solver.write_checkpoint(&path).unwrap();
        let resumed = Solver::read_checkpoint(&path, solver.flow().clone()).unwrap();
        assert_eq!(resumed.budget(), solver.budget());
        println!("g {weight}: {wrapping} through the period, residual {residual:e}");
        assert!(wrapping > through, "{wrapping} {through}");
        assert!(residual.abs() < 1e-3 * through, "{residual} of {through}");
    }
}

/// A doubly periodic flow of unit speed with water everywhere but in bodies.
fn around(bodies: Vec<Body>) -> Result<Solver, SphError> {
    let mut fluid = FluidOptions::new(2, 0.05, 1.0, 0.0);
    fluid.gravity = [0.0; 3];
    fluid.viscosity = Viscosity::Dynamic(5.0);
    let mut boundaries = Boundaries::new([0.0; 3], [2.0, 2.0, 0.0], fluid.spacing);
    boundaries.periodic = [true, true, false];
    boundaries.bodies = bodies;
    let square = Shape::Box { low: [0.0; 3], high: [2.0, 2.0, 0.0] };
    let mut all = state(&[square], &fluid, |_| [1.0, 0.0, 0.0], |_| 0.0);
    all.x.retain(|&x| !boundaries.bodies.iter().any(|body| body.contains(x, 0.0, 2)));
    let count = all.x.len();
    all.u.truncate(count);
    all.density.truncate(count);
    all.id.truncate(count);
    Solver::new(Flow::new(fluid, boundaries), all)
}

fn disc(x: f64, y: f64) -> Body {
    Body::new(Shape::Sphere { centre: [x, y, 0.0], radius: 0.3 }, Slip::No)
}

#[test]
fn a_body_at_a_periodic_face_that_is_not_given_on_both_sides_of_it_is_refused() {
    let box_from =
        |low: f64, high: f64| Body::new(Shape::Box { low: [low, 0.8, 0.0], high: [high, 1.2, 0.0] }, Slip::Free);
    for (bodies, body) in [
        (vec![disc(0.0, 1.0)], 0),
        (vec![disc(1.0, 1.0), disc(1.0, 2.0)], 1),
        // Inside, but fluid across the face is within its reach.
        (vec![box_from(0.1, 0.5)], 0),
        (vec![box_from(0.0, 2.0)], 0),
        // The other half is elsewhere.
        (vec![disc(0.0, 1.0), disc(2.0, 0.5)], 0),
        (vec![disc(0.0, 0.0), disc(2.0, 0.0)], 0),
    ] {
        let error = around(bodies).unwrap_err();
        assert!(matches!(error, SphError::CutBody { body: b, .. } if b == body), "{error}");
        assert!(error.to_string().contains("give it a second time"), "{error}");
    }
    // Out of reach of the faces, through both of them, or outside altogether.
    for body in [disc(0.5, 1.0), box_from(0.2, 1.8), box_from(-0.2, 2.2), box_from(2.2, 2.6)] {
        assert!(around(vec![body]).is_ok());
    }
}

#[test]
fn a_body_given_on_both_sides_of_a_face_is_the_body_in_the_middle() {
    let forces = [
        vec![disc(1.0, 1.0)],
        vec![disc(0.0, 1.0), disc(2.0, 1.0)],
        vec![disc(0.0, 0.0), disc(2.0, 0.0), disc(0.0, 2.0), disc(2.0, 2.0)],
    ]
    .map(|bodies| {
        let mut solver = around(bodies).unwrap();
        run(&mut solver, 0.05);
        let forces = solver.boundary_forces().unwrap().bodies;
        (solver.state().len(), forces.iter().map(|f| f[0]).sum::<f64>())
    });
    println!("{forces:?}");
    assert!(forces[0].1.abs() > 100.0, "{forces:?}");
    for (count, force) in &forces[1..] {
        assert_eq!(*count, forces[0].0);
        // Ghosts beyond a face see images of the fluid up to 2h beyond it only.
        assert!((force / forces[0].1 - 1.0).abs() < 5e-4, "{forces:?}");
    }
}

#[test]
fn a_body_that_moves_to_a_periodic_face_before_the_end_is_refused_with_its_line() {
    let text = |end: f64| {
        format!(
            "dimension = 2\nspacing = 0.05\n[domain]\nlow = [0, 0]\nhigh = [2, 1]\nperiodic = [\"x\"]\n[fluid]\ndensity = 1000\n\
             expected_speed = 1\ngravity = [0, 0]\n[time]\nend = {end}\n[[fill]]\nshape = \"box\"\nlow = [0, 0]\nhigh = [2, 0.5]\n\
             [[body]]\nshape = \"box\"\nlow = [0.5, 0.2]\nhigh = [0.8, 0.4]\nmotion = [[0, 0, 0], [2, 2, 0]]\n"
        )
    };
    assert!(Case::parse(&text(0.9), "c.toml").is_ok());
    let error = Case::parse(&text(1.1), "c.toml").unwrap_err().to_string();
    assert!(error.starts_with("c.toml:18: body 0 reaches from 0.5 to 1.9") && error.contains("2h"), "{error}");
    // To and fro: the farthest place counts, not the last.
    let motion = Motion::new(&[(0.0, [0.0; 3]), (1.0, [0.8, 0.0, 0.0]), (2.0, [0.0; 3])]).unwrap();
    assert!(around(vec![Body { motion: Some(motion), ..disc(0.8, 1.0) }]).is_ok(), "at the start all is well");
}
