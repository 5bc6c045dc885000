//! The largest empty cone against closed forms and brute force.
#![allow(clippy::unwrap_used)]

mod common;

use common::{block, directions, largest_empty_cone};
use fieldstone_particles::{NeighbourGrid, NeighbourOptions};
use fieldstone_surface::{Exact, Exposure, ScanningCone, Scene, SurfaceDetection, exposure};

fn exposures(positions: &[[f64; 3]], radius: f64, dimension: usize) -> Vec<Exposure> {
    let options = NeighbourOptions { dimension, ..NeighbourOptions::new(radius) };
    let grid = NeighbourGrid::build(positions, options).unwrap();
    exposure(&Scene::new(&grid, 1.0), radius).unwrap()
}

#[test]
fn closed_forms_hold() {
    use std::f64::consts::{FRAC_PI_2, PI};
    assert_eq!(exposures(&[[0.0; 3]], 2.5, 3)[0], Exposure { half_angle: PI, axis: [0.0; 3] });
    let pair = exposures(&[[0.0; 3], [1.0, 0.0, 0.0]], 2.5, 3);
    assert!((pair[0].half_angle - PI).abs() < 1e-7 && (pair[0].axis[0] + 1.0).abs() < 1e-9, "{pair:?}");
    // A row, a sheet, and the corner of an octant.
    let row = exposures(&[[-1.0, 0.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0]], 2.5, 3);
    assert!((row[1].half_angle - FRAC_PI_2).abs() < 1e-9, "{row:?}");
    let corner = exposures(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], 1.0, 3);
    assert!((corner[0].half_angle - (PI - (1.0f64 / 3.0).sqrt().acos())).abs() < 1e-9, "{corner:?}");
    let flat = exposures(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 1.2, 2);
    assert!((flat[0].half_angle - 0.75 * PI).abs() < 1e-12, "{flat:?}");
}

#[test]
fn the_exposure_is_the_brute_force_maximum_over_all_triples() {
    for (noise, seed) in [(0.0, 1), (0.05, 2), (0.3, 3), (1.0, 4)] {
        let positions = block([7, 7, 7], noise, seed);
        let found = exposures(&positions, 2.5, 3);
        for particle in (0..positions.len()).step_by(9) {
            let expected = largest_empty_cone(&directions(&positions, particle, 2.5));
            let error = found[particle].half_angle - expected;
            assert!(error.abs() < 1e-9, "noise {noise}, particle {particle}: {error:e} of {expected}");
        }
    }
}

#[test]
fn a_particle_is_on_the_surface_for_just_the_angles_below_its_exposure() {
    let positions = block([9, 9, 9], 0.4, 7);
    let found = exposures(&positions, 2.5, 3);
    for angle in [30.0f64, 45.0, 60.0] {
        let method = Exact::new(ScanningCone { angle, ..ScanningCone::default() }).unwrap();
        let grid = NeighbourGrid::build(&positions, NeighbourOptions::new(2.5)).unwrap();
        let detection = method.detect(&Scene::new(&grid, 1.0)).unwrap();
        for (particle, e) in found.iter().enumerate() {
            assert_eq!(detection.is_free_surface(particle), e.half_angle > angle.to_radians(), "{particle}: {e:?}");
        }
    }
}
