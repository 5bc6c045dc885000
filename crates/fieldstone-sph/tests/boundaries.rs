//! Walls, periodic faces, and the plane of two dimensions: what stands beside them sees what it should.
#![allow(clippy::unwrap_used)]

mod common;

use common::{dam_break, run, state, tank};
use fieldstone_sph::{
    Body, Case, DirectionName, Flow, FluidOptions, Motion, Shape, Slip, Solver, SphError, front, level_over,
    pressure_at,
};
use fieldstone_surface::{Method, ScanningCone};
use fieldstone_testing::Random;

#[test]
fn a_run_detects_beside_walls_and_periodic_faces_as_the_detection_by_itself_does() {
    // With h = Δx the lists end at 2 Δx, and most methods look farther.
    for method in [Method::Exact, Method::SemiGeometrical, Method::Marrone, Method::Wang] {
        for periodic in [false, true] {
            let mut fluid = FluidOptions::new(2, 0.02, 2.0, 4000.0);
            (fluid.sound_speed, fluid.smoothing) = (30.0, 1.0);
            let mut boundaries = tank([0.0; 3], [0.4, 1.0, 0.0], &fluid, Slip::Free);
            if periodic {
                boundaries.walls.retain(|w| w.plane.normal()[0] == 0.0);
                boundaries.periodic[0] = true;
            }
            let sheet = Shape::Box { low: [0.0; 3], high: [0.4, 0.3, 0.0] };
            let mut state = state(&[sheet], &fluid, |_| [0.0; 3], |_| 0.0);
            // With a third of them gone at random, labels hang on a few neighbours.
            let mut random = Random(1);
            state.x.retain(|_| random.below(3) > 0);
            let count = state.x.len();
            state.u.truncate(count);
            state.density.truncate(count);
            state.id.truncate(count);
            let mut flow = Flow::new(fluid, boundaries);
            flow.detection = Some(method);
            let solver = Solver::new(flow, state).unwrap();
            let found: Vec<bool> = solver.regions().iter().map(|&r| r == 0).collect();
            let labels = solver.labels(method.with_cone(ScanningCone::default()).unwrap().as_ref()).unwrap();
            assert_eq!(found, labels, "{method} {periodic}");
            assert!(found.contains(&true) && found.contains(&false));
        }
    }
}

#[test]
fn gauges_at_a_periodic_face_see_what_is_beyond_it() {
    let mut fluid = FluidOptions::new(2, 0.02, 2.0, 4000.0);
    fluid.sound_speed = 30.0;
    let mut boundaries = tank([0.0; 3], [0.4, 1.0, 0.0], &fluid, Slip::Free);
    boundaries.walls.retain(|w| w.plane.normal()[0] == 0.0);
    boundaries.periodic[0] = true;
    // Only the right half is filled, and twice as high at its end.
    let shapes = [
        Shape::Box { low: [0.2, 0.0, 0.0], high: [0.4, 0.1, 0.0] },
        Shape::Box { low: [0.36, 0.1, 0.0], high: [0.4, 0.2, 0.0] },
    ];
    let state = state(&shapes, &fluid, |_| [0.0; 3], |x| 1000.0 * x[1]);
    let solver = Solver::new(Flow::new(fluid, boundaries), state).unwrap();
    let at = |x: f64| (pressure_at(&solver, [x, 0.1, 0.0]), level_over(&solver, [x, 0.0, 0.0]));
    let (low, high) = (at(0.0), at(0.4));
    assert!((low.0 - high.0).abs() < 1e-9 && low.0 > 50.0, "{low:?} {high:?}");
    assert!((low.1 - 0.2).abs() < 1e-12 && low.1 == high.1, "{low:?} {high:?}");
}

#[test]
fn water_that_is_no_whole_number_of_spacings_deep_weighs_on_the_floor_what_it_weighs() {
    let text = "dimension = 2\nspacing = 0.05\n[domain]\nlow = [0, 0]\nhigh = [0.52, 1]\n[fluid]\ndensity = 1000\nalpha = 0.2\n\
                expected_speed = 2\nexpected_pressure = 5000\ngravity = [0, -9.81]\n[time]\nend = 4\n[[wall]]\nkind = \"tank\"\n\
                [[fill]]\nshape = \"box\"\nlow = [0, 0]\nhigh = [0.52, 0.47]\npressure = \"hydrostatic\"\n";
    let mut solver = Case::parse(text, "still.toml").unwrap().solver().unwrap();
    run(&mut solver, 3.0);
    let (mut pressure, mut count) = (0.0, 0.0);
    while solver.time() < 4.0 {
        solver.step().unwrap();
        pressure += pressure_at(&solver, [0.26, 0.0, 0.0]);
        count += 1.0;
    }
    // With particles of ρ₀ Δx², lighter than their cells, it was 18 % above what they weigh.
    println!("floor: {} of {}", pressure / count, 9810.0 * 0.47);
    assert!((pressure / count / (9810.0 * 0.47) - 1.0).abs() < 0.02, "{}", pressure / count);
}

#[test]
fn fronts_run_both_ways() {
    let fluid = FluidOptions::new(2, 0.02, 2.0, 4000.0);
    let boundaries = tank([0.0; 3], [1.0, 1.0, 0.0], &fluid, Slip::Free);
    // A droplet at either end of the tank is no front.
    let column = Shape::Box { low: [0.3, 0.0, 0.0], high: [0.5, 0.4, 0.0] };
    let droplet = |x: f64| Shape::Box { low: [x, 0.1, 0.0], high: [x + 0.02, 0.12, 0.0] };
    let state = state(&[column, droplet(0.1), droplet(0.9)], &fluid, |_| [0.0; 3], |_| 0.0);
    let solver = Solver::new(Flow::new(fluid, boundaries), state).unwrap();
    for (direction, expected) in [
        (DirectionName::X, 0.5),
        (DirectionName::AgainstX, 0.3),
        (DirectionName::Y, 0.4),
        (DirectionName::AgainstY, 0.0),
    ] {
        let found = front(&solver, direction);
        assert!((found - expected).abs() < 1e-12, "{direction:?}: {found} for {expected}");
    }
}

#[test]
fn a_particle_that_passes_a_whole_period_is_not_told_to_open_the_side() {
    let (mut flow, mut state) = dam_break(0.02, Slip::Free);
    flow.boundaries.walls.retain(|w| w.plane.normal()[0] == 0.0);
    flow.boundaries.periodic[0] = true;
    state.x[7][0] = 3.0;
    let error = Solver::new(flow, state).unwrap_err().to_string();
    assert!(error.contains("passes a whole period between two lists: lessen the time step"), "{error}");
    assert!(!error.contains("open that side"), "{error}");
}

#[test]
fn a_plane_flow_stays_in_its_plane() {
    let (flow, mut state) = dam_break(0.02, Slip::Free);
    state.x[7][2] = 0.01;
    let error = Solver::new(flow, state).unwrap_err().to_string();
    assert!(
        error.contains("particle 7") && error.contains("in two dimensions z and its velocity must be 0"),
        "{error}"
    );
}

/// Water at rest beside bodies that are boxes; each moves by a motion or not.
fn beside(boxes: &[([f64; 2], [f64; 2], Option<Motion>)]) -> Result<Solver, SphError> {
    let mut fluid = FluidOptions::new(2, 0.02, 1.0, 4000.0);
    fluid.sound_speed = 30.0;
    let mut boundaries = tank([0.0; 3], [0.8, 0.6, 0.0], &fluid, Slip::Free);
    for (low, high, motion) in boxes {
        let shape = Shape::Box { low: [low[0], low[1], 0.0], high: [high[0], high[1], 0.0] };
        boundaries.bodies.push(Body { motion: motion.clone(), ..Body::new(shape, Slip::Free) });
    }
    let water = Shape::Box { low: [0.0; 3], high: [0.48, 0.3, 0.0] };
    let state = state(&[water], &fluid, |_| [0.0; 3], |x| 9810.0 * (0.3 - x[1]));
    Solver::new(Flow::new(fluid, boundaries), state)
}

#[test]
fn bodies_that_overlap_are_one_solid() {
    let (low, high) = ([0.48, -0.12], [0.8, 0.4]);
    // Twice the same, and an L with the part of it that closes the L: the same solid each time.
    let l = [(low, [0.64, 0.4], None), (low, [0.8, 0.12], None), ([0.56, 0.0], high, None)];
    let found = [vec![(low, high, None)], vec![(low, high, None); 2], l.to_vec()].map(|boxes| {
        let mut solver = beside(&boxes).unwrap();
        run(&mut solver, 0.05);
        let forces = solver.boundary_forces().unwrap().bodies;
        let sum = forces.iter().fold([0.0; 2], |sum, force| [sum[0] + force[0], sum[1] + force[1]]);
        println!("{} bodies: force {sum:?}, kinetic energy {:.2e}", boxes.len(), solver.energies().kinetic);
        (sum, forces, solver.energies().kinetic)
    });
    let [(one, _, kinetic), (twice, forces, same), (parts, ..)] = &found;
    assert!((one[0] / (0.5 * 9810.0 * 0.09) - 1.0).abs() < 0.02, "{one:?}");
    assert!(kinetic == same && twice == one && forces[1] == [0.0; 3], "{forces:?}");
    assert!((0..2).all(|k| (parts[k] - one[k]).abs() < 1e-9 * one[0]), "{parts:?} {one:?}");
    assert!(*kinetic < 0.01, "{kinetic}");
}

#[test]
fn water_beside_a_post_does_not_press_it_to_the_floor() {
    let mut solver = beside(&[([0.48, -0.12], [0.8, 0.4], None)]).unwrap();
    let forces = solver.boundary_forces().unwrap();
    let [across, up, _] = forces.bodies[0];
    println!("post: {across} of {}, lift {up}", 0.5 * 9810.0 * 0.09);
    assert!((across / (0.5 * 9810.0 * 0.09) - 1.0).abs() < 0.02, "{across}");
    // With what is across the floor on the ghosts below it, −0.4 Δx ρgH.
    assert!(up.abs() < 0.01 * 0.02 * 9810.0 * 0.3, "{up}");
    // What it does not carry, the floor does.
    let weight = 1000.0 * 9.81 * 0.48 * 0.3;
    assert!((forces.walls[1] / -weight - 1.0).abs() < 0.02, "{:?} {weight}", forces.walls);
}

#[test]
fn particles_that_get_into_bodies_are_put_back_but_not_from_deep_inside() {
    let mut rest = beside(&[([0.48, -0.12], [0.8, 0.4], None)]).unwrap();
    rest.step().unwrap();
    assert_eq!((rest.budget().in_bodies, rest.budget().reflections), (0, 0));
    // A body over the water's last three columns of 15 particles: 10, 30 and 50 mm deep, of spacing 20 mm.
    let mut inside = beside(&[([0.42, -0.12], [0.8, 0.4], None)]).unwrap();
    inside.step().unwrap();
    assert_eq!((inside.budget().in_bodies, inside.budget().reflections), (30, 15));
    let budget = *inside.budget();
    assert!(inside.momentum_residual().iter().all(|p| p.abs() < 1e-9), "{:?}", inside.momentum_residual());
    assert!(inside.energy_residual().abs() < 0.01 * budget.start.abs(), "{}", inside.energy_residual());
    inside.step().unwrap();
    assert_eq!(inside.budget().in_bodies, 60);
}

#[test]
fn bodies_that_overlap_and_do_not_move_alike_are_refused() {
    let motion = |x: f64| Some(Motion::new(&[(0.0, [0.0; 3]), (1.0, [x, 0.0, 0.0])]).unwrap());
    let (low, high) = ([0.6, -0.12], [0.8, 0.4]);
    let error = beside(&[(low, high, None), (low, high, motion(0.1))]).unwrap_err();
    assert!(matches!(error, SphError::Overlapping { first: 0, second: 1, .. }), "{error}");
    assert!(
        error.to_string().contains("only bodies at rest, or with the same motion, may overlap: move one"),
        "{error}"
    );
    assert!(beside(&[(low, high, motion(0.2)), (low, high, motion(0.1))]).is_err());
    // Side by side, or with the same motion, they may be.
    assert!(beside(&[(low, high, motion(0.1)), ([0.5, 0.32], high, motion(0.1))]).is_ok());
    assert!(beside(&[(low, [0.7, 0.4], None), ([0.7, 0.0], high, motion(0.1))]).is_ok());
}
