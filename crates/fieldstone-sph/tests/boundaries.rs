//! Walls, periodic faces, and the plane of two dimensions: what stands beside them sees what it should.
#![allow(clippy::unwrap_used)]

mod common;

use common::{dam_break, state, tank};
use fieldstone_sph::{Flow, FluidOptions, Shape, Slip, Solver, level_over, pressure_at};
use fieldstone_surface::{Method, ScanningCone};

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
            let mut random = 1u64;
            state.x.retain(|_| {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                !(random >> 33).is_multiple_of(3)
            });
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
fn a_plane_flow_stays_in_its_plane() {
    let (flow, mut state) = dam_break(0.02, Slip::Free);
    state.x[7][2] = 0.01;
    let error = Solver::new(flow, state).unwrap_err().to_string();
    assert!(
        error.contains("particle 7") && error.contains("in two dimensions z and its velocity must be 0"),
        "{error}"
    );
}
