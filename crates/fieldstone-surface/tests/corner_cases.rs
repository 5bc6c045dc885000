//! Few, coincident, coplanar and impossible particles, for every method.
#![allow(clippy::unwrap_used)]

mod common;

use common::{block, labels};
use fieldstone_particles::{Domain, NeighbourGrid, NeighbourOptions};
use fieldstone_surface::{
    Exact, Method, ScanningCone, Scene, Surface, SurfaceDetection, SurfaceError, SurfaceOptions, Surroundings, Wall,
    detect_surface, sensitivity,
};

fn methods(dimension: usize) -> Vec<Box<dyn SurfaceDetection + Send>> {
    let supported = Method::ALL.into_iter().filter(|m| m.supports(dimension));
    supported.map(|m| m.with_cone(ScanningCone::default()).unwrap()).collect()
}

fn everything(positions: &[[f64; 3]], spacing: f64) -> Surface {
    detect_surface(positions, &Exact::default(), &Surroundings::new(spacing), &SurfaceOptions::ALL).unwrap()
}

#[test]
fn no_one_two_and_coincident_particles_are_on_the_surface_by_every_method() {
    for dimension in [2, 3] {
        for method in methods(dimension) {
            let label = |positions: &[[f64; 3]]| labels(positions, &*method, 1.0, dimension);
            assert_eq!(label(&[]), [false; 0], "{}", method.name());
            assert_eq!(label(&[[3.0; 3]]), [true], "{}", method.name());
            assert_eq!(label(&[[0.0; 3], [0.9, 0.0, 0.0]]), [true; 2], "{}", method.name());
            assert_eq!(label(&[[0.0; 3], [90.0, 0.0, 0.0]]), [true; 2], "{}", method.name());
            assert_eq!(label(&[[0.5; 3]; 9]), [true; 9], "{}", method.name());
        }
    }
    let surface = everything(&[[0.5; 3]; 9], 1.0);
    assert_eq!((surface.detection.coincident(), surface.detection.isolated()), (9, 9));
    let none = everything(&[], 1.0);
    assert!(none.detection.is_empty() && none.warnings.is_empty());
}

#[test]
fn many_duplicates_and_a_third_coordinate_in_two_dimensions_are_warned_of() {
    let sheet: Vec<[f64; 3]> = (0..400).map(|k| [f64::from(k % 20), f64::from(k / 20), 0.0]).collect();
    let warnings = |positions: &[[f64; 3]], dimension: usize| {
        let surroundings = Surroundings { dimension, ..Surroundings::new(1.0) };
        detect_surface(positions, &Exact::default(), &surroundings, &SurfaceOptions::LABELS).unwrap().warnings
    };
    assert_eq!(warnings(&sheet, 2), [""; 0]);
    // In x and z: seen in the plane of x and y, each particle lies in the place of 19 others.
    let upright: Vec<[f64; 3]> = sheet.iter().map(|p| [p[0], 0.0, p[1]]).collect();
    let found = warnings(&upright, 2);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].contains("of 200 particles looked at 200 lie in the place of another"), "{}", found[0]);
    assert!(found[1].contains("z runs from 0 to 19") && found[1].contains("swap the columns"), "{}", found[1]);
    // One in a hundred: a restart that wrote some particles twice.
    let mut twice = block([10, 10, 10], 0.0, 1);
    twice.extend_from_within(..10);
    assert_eq!(warnings(&twice, 3), [""; 0]);
}

#[test]
fn a_coplanar_sheet_and_a_thin_jet_are_all_surface() {
    for method in methods(3) {
        for counts in [[12, 12, 1], [1, 1, 20], [2, 2, 20]] {
            let labels = labels(&block(counts, 0.0, 1), &*method, 1.0, 3);
            assert!(labels.iter().all(|&l| l), "{} on {counts:?}", method.name());
        }
    }
}

#[test]
fn duplicates_are_counted_and_change_no_other_label() {
    let mut positions = block([8, 8, 8], 0.1, 1);
    let once = labels(&positions, &Exact::default(), 1.0, 3);
    let (inner, outer) = (positions[8 * 8 * 4 + 8 * 4 + 4], positions[0]);
    positions.extend([inner, outer]);
    let surface = everything(&positions, 1.0);
    assert_eq!(surface.detection.coincident(), 4);
    let twice = surface.detection.labels();
    assert_eq!(twice[..512], once);
    assert_eq!(twice[512..], [false, true]);
}

#[test]
fn a_position_that_is_not_a_number_is_an_error_naming_the_particle() {
    let mut positions = block([3, 3, 3], 0.0, 1);
    positions[17][2] = f64::NAN;
    let walls = vec![Wall::new([0.0, 0.0, 1.0], 0.0).unwrap()];
    let surroundings = Surroundings { walls, ..Surroundings::new(1.0) };
    let error = detect_surface(&positions, &Exact::default(), &surroundings, &SurfaceOptions::LABELS).unwrap_err();
    assert!(error.to_string().starts_with("particle 17 has z = NaN"), "{error}");
}

#[test]
fn a_spacing_that_is_ten_times_off_is_warned_of() {
    let everything = |positions: &[[f64; 3]], spacing: f64| {
        detect_surface(positions, &Exact::default(), &Surroundings::new(spacing), &SurfaceOptions::LABELS).unwrap()
    };
    let positions = block([10, 10, 10], 0.1, 1);
    assert_eq!(everything(&positions, 1.0).warnings, [""; 0]);
    let large = everything(&positions, 10.0).warnings;
    assert!(large.len() == 1 && large[0].contains("check the spacing"), "{large:?}");
    let small = everything(&positions, 0.1).warnings;
    assert!(small.len() == 1 && small[0].contains("spacing 0.1 is too small"), "{small:?}");
    let slightly = everything(&positions, 0.45).warnings;
    assert!(slightly.len() == 1 && slightly[0].contains("taken for free-surface ones"), "{slightly:?}");
}

#[test]
fn two_dimensional_data_in_three_dimensions_is_warned_of() {
    let warnings = everything(&block([12, 12, 1], 0.0, 1), 1.0).warnings;
    assert!(warnings.len() == 1 && warnings[0].contains("all particles have z = 0.5"), "{warnings:?}");
    let flat = Surroundings { dimension: 2, ..Surroundings::new(1.0) };
    let surface = detect_surface(&block([12, 12, 1], 0.0, 1), &Exact::default(), &flat, &SurfaceOptions::ALL).unwrap();
    assert_eq!(surface.detection.free_surface(), 44);
    assert_eq!(surface.warnings, [""; 0]);
}

#[test]
fn the_twelve_nearest_neighbours_of_a_dense_packing_are_a_tie_and_cover() {
    // Directions (±1, ±1, 0) and permutations: caps of 45° around them just meet on the axes.
    let mut positions = vec![[0.0; 3]];
    for axis in 0..3 {
        for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let mut p = [0.0; 3];
            p[(axis + 1) % 3] = s;
            p[(axis + 2) % 3] = t;
            positions.push(p);
        }
    }
    for (angle, free) in [(44.999, true), (45.0, false), (45.001, false)] {
        let cone = ScanningCone { angle, ..ScanningCone::default() };
        for method in [Method::Exact, Method::Geometrical] {
            let label = labels(&positions, &*method.with_cone(cone).unwrap(), 1.0, 3)[0];
            assert_eq!(label, free, "{method} at {angle}°");
        }
    }
}

#[test]
fn a_concave_right_angle_of_a_lattice_is_seen_up_to_just_above_45_degrees() {
    // An L-shaped block. The widest cone on the inner edge is no tie, as it would be in two dimensions: tilted along
    // the edge, between the directions (1, 0, 0) and (2, 1, 0) and those upwards alike, it has 45.8°.
    let positions: Vec<[f64; 3]> =
        block([10, 6, 10], 0.0, 1).into_iter().filter(|p| !(p[0] > 5.0 && p[2] > 5.0)).collect();
    let edge = |p: &[f64; 3]| p[0] == 4.5 && p[2] == 4.5 && p[1] > 2.0 && p[1] < 4.0;
    let tilt = 5f64.sqrt() - 2.0;
    let widest = (1.0 / (2.0 + tilt * tilt).sqrt()).acos();
    let surface = everything(&positions, 1.0);
    for (angle, free) in [(45.0, true), (widest.to_degrees() - 1e-5, true), (widest.to_degrees() + 1e-5, false)] {
        let cone = ScanningCone { angle, ..ScanningCone::default() };
        for method in [Method::Exact, Method::Geometrical] {
            let labels = labels(&positions, &*method.with_cone(cone).unwrap(), 1.0, 3);
            for i in (0..positions.len()).filter(|&i| edge(&positions[i])) {
                assert_eq!(labels[i], free, "{method} at {angle}°");
                let found = surface.exposures.as_ref().unwrap()[i].half_angle;
                assert!((found - widest).abs() < 1e-9, "{found}");
            }
        }
    }
}

#[test]
fn haque_takes_inner_particles_for_free_ones_once_balls_leave_the_lattices_cells_open() {
    // The corners of a cell of a cubic lattice are √3/2 spacings away, and the balls have 1.25.
    let limit = 2.0 * 1.25 / 3f64.sqrt();
    let centre = 7 * 7 * 3 + 7 * 3 + 3;
    let haque = Method::Haque.with_cone(ScanningCone::default()).unwrap();
    for (factor, free) in [(0.999 * limit, false), (1.001 * limit, true)] {
        let spread: Vec<[f64; 3]> = block([7, 7, 7], 0.0, 1).iter().map(|p| p.map(|x| factor * x)).collect();
        assert_eq!(labels(&spread, &*haque, 1.0, 3)[centre], free, "{factor}");
    }
}

#[test]
fn levels_are_by_distance_from_the_surface_and_normals_point_outwards() {
    let positions = block([15, 15, 15], 0.0, 1);
    let surface = everything(&positions, 1.0);
    let levels = surface.levels.unwrap();
    let normals = surface.normals.unwrap();
    for (i, p) in positions.iter().enumerate() {
        let depth = p.iter().map(|x| (x - 0.5).min(14.5 - x)).fold(f64::INFINITY, f64::min);
        let expected = if depth < 0.5 {
            0
        } else if depth <= 4.0 {
            1
        } else {
            2
        };
        assert_eq!(levels[i], expected, "{p:?}");
        let faces = p.iter().filter(|&&x| !(1.0..14.0).contains(&x)).count();
        if faces == 1 && p.iter().filter(|&&x| (4.6..10.4).contains(&x)).count() == 2 {
            let outward: f64 = (0..3)
                .map(|k| normals[i][k] * (p[k] - 7.5).signum() * f64::from(u8::from(!(1.0..14.0).contains(&p[k]))))
                .sum();
            assert!((outward - 1.0).abs() < 1e-12, "{p:?} {:?}", normals[i]);
        }
    }
    // Inside, every direction is as good as any other.
    assert_eq!(normals[15 * 15 * 7 + 15 * 7 + 7], [0.0; 3]);
}

#[test]
fn boundary_particles_are_neighbours_but_never_labelled() {
    let positions = block([8, 8, 12], 0.0, 1);
    let fluid: Vec<bool> = positions.iter().map(|p| p[2] > 4.0).collect();
    let surroundings = Surroundings { candidates: Some(fluid.clone()), ..Surroundings::new(1.0) };
    let surface = detect_surface(&positions, &Exact::default(), &surroundings, &SurfaceOptions::ALL).unwrap();
    for (i, p) in positions.iter().enumerate() {
        let side = p[..2].iter().any(|x| !(1.0..7.0).contains(x)) || p[2] > 11.0;
        assert_eq!(surface.detection.is_free_surface(i), fluid[i] && side, "{p:?}");
    }
}

#[test]
fn a_periodic_slab_has_surfaces_in_one_direction_only() {
    let positions = block([9, 3, 9], 0.0, 1);
    let domain = Domain::new([0.0; 3], [9.0, 3.0, 9.0], [true, true, false]).unwrap();
    let surroundings = Surroundings { domain: Some(domain), ..Surroundings::new(1.0) };
    for method in methods(3) {
        let surface = detect_surface(&positions, &*method, &surroundings, &SurfaceOptions::LABELS).unwrap();
        assert_eq!(surface.detection.free_surface(), 2 * 9 * 3, "{}", method.name());
    }
}

#[test]
fn parameters_outside_their_range_are_refused_with_the_range() {
    let refused = |cone: ScanningCone| Exact::new(cone).unwrap_err().to_string();
    let narrow = refused(ScanningCone { angle: 0.0, ..ScanningCone::default() });
    assert!(narrow.contains("above 0 and below 90"), "{narrow}");
    assert!(refused(ScanningCone { radius: f64::NAN, ..ScanningCone::default() }).contains("radius"));
    let grid = NeighbourGrid::build(&[[0.0; 3]], NeighbourOptions::new(2.0)).unwrap();
    let short = Exact::default().detect(&Scene::new(&grid, 1.0)).unwrap_err();
    assert!(matches!(short, SurfaceError::Reach { needed: 2.5, reach: 2.0, .. }), "{short}");
    let haque = Method::Haque.with_cone(ScanningCone::default()).unwrap();
    let flat = NeighbourGrid::build(&[], NeighbourOptions { dimension: 2, ..NeighbourOptions::new(2.5) }).unwrap();
    assert!(matches!(haque.detect(&Scene::new(&flat, 1.0)), Err(SurfaceError::Dimension { supported: 3, .. })));
    let volumes = [0.0];
    let grid = NeighbourGrid::build(&[[0.0; 3]], NeighbourOptions::new(2.5)).unwrap();
    let scene = Scene { volumes: Some(&volumes), ..Scene::new(&grid, 1.0) };
    assert!(matches!(Exact::default().detect(&scene), Err(SurfaceError::Volume { particle: 0, .. })));
    assert!(Exact::default().detect(&Scene::new(&grid, f64::NAN)).is_err());
    assert!(Wall::new([0.0; 3], 1.0).is_err());
}

#[test]
fn wider_cones_and_larger_spheres_find_fewer_particles() {
    let positions = block([10, 10, 10], 0.3, 2);
    let table = sensitivity(&positions, &Surroundings::new(1.0), &[1.5, 2.5, 4.0], &[30.0, 45.0, 70.0]).unwrap();
    let counts: Vec<usize> = table.iter().map(|s| s.detection.free_surface()).collect();
    assert_eq!((table[4].cone.radius, table[4].cone.angle), (2.5, 45.0));
    for row in counts.chunks(3) {
        assert!(row[0] >= row[1] && row[1] >= row[2], "{counts:?}");
    }
    for k in 0..3 {
        assert!(counts[k] >= counts[k + 3] && counts[k + 3] >= counts[k + 6], "{counts:?}");
    }
    assert!(counts[0] > counts[8]);
}
