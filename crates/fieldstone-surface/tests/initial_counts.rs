//! The initial state of the paper's cases: all methods find the same surface, of a size that is known.
#![allow(clippy::unwrap_used)]

use fieldstone_surface::{Comparison, Method, ScanningCone, SurfaceDetection, Surroundings, Wall};

/// A column of fluid from a corner of the tank, on a lattice half a spacing off the walls.
fn column(corner: [f64; 3], extent: [f64; 3], spacing: f64) -> Vec<[f64; 3]> {
    let counts = extent.map(|e| (e / spacing).round() as usize);
    let mut positions = Vec::with_capacity(counts.iter().product());
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            for k in 0..counts[2] {
                let cell = [i, j, k];
                positions.push(std::array::from_fn(|axis| corner[axis] + (cell[axis] as f64 + 0.5) * spacing));
            }
        }
    }
    positions
}

/// Floor at z = 0 and side walls of a tank.
fn tank(length: f64, width: f64) -> Vec<Wall> {
    vec![
        Wall::new([0.0, 0.0, 1.0], 0.0).unwrap(),
        Wall::new([1.0, 0.0, 0.0], 0.0).unwrap(),
        Wall::new([-1.0, 0.0, 0.0], -length).unwrap(),
        Wall::new([0.0, 1.0, 0.0], 0.0).unwrap(),
        Wall::new([0.0, -1.0, 0.0], -width).unwrap(),
    ]
}

fn assert_count(positions: &[[f64; 3]], walls: Vec<Wall>, spacing: f64, expected: usize, methods: &[Method]) {
    let surroundings = Surroundings { walls, ..Surroundings::new(spacing) };
    let detect = |method: &dyn SurfaceDetection| {
        let grid = surroundings.grid(positions, method.reach(spacing)).unwrap();
        method.detect(&surroundings.scene(&grid)).unwrap().labels()
    };
    let reference = detect(&fieldstone_surface::Exact::default());
    assert_eq!(reference.iter().filter(|&&l| l).count(), expected);
    for method in methods {
        let labels = detect(&*method.with_cone(ScanningCone::default()).unwrap());
        let difference = Comparison::new(&reference, &labels).unwrap();
        assert_eq!(difference.misidentified(), 0, "{method}: {difference:?}");
    }
}

const ALL: [Method; 5] = [Method::Geometrical, Method::SemiGeometrical, Method::Haque, Method::Marrone, Method::Wang];

/// The reference methods take 0.1 ms per particle: on all of these cases that is minutes, so on request only.
fn all_or(usual: &'static [Method]) -> &'static [Method] {
    if std::env::var_os("FIELDSTONE_SURFACE_ALL").is_some() { &ALL } else { usual }
}

fn double_dam_break(spacing: f64) -> Vec<[f64; 3]> {
    let mut positions = column([0.0; 3], [0.8, 0.8, 1.2], spacing);
    positions.extend(column([1.2, 1.2, 0.0], [1.2, 1.2, 1.2], spacing));
    positions
}

#[test]
fn the_double_dam_break_starts_with_4142_free_surface_particles_at_twice_the_papers_spacing() {
    assert_count(&double_dam_break(0.04), tank(2.4, 2.4), 0.04, 4142, &ALL);
}

#[test]
fn the_obstacle_case_starts_with_4140_free_surface_particles_at_twice_the_papers_spacing() {
    let column = column([0.0; 3], [0.4, 0.6, 0.3], 0.01);
    assert_count(&column, tank(1.6, 0.6), 0.01, 4140, all_or(&[Method::Marrone, Method::Wang]));
}

#[test]
fn the_double_dam_break_starts_with_the_papers_16882() {
    assert_count(&double_dam_break(0.02), tank(2.4, 2.4), 0.02, 16_882, all_or(&[]));
}

#[test]
fn the_obstacle_case_starts_with_the_papers_16680() {
    assert_count(&column([0.0; 3], [0.4, 0.6, 0.3], 0.005), tank(1.6, 0.6), 0.005, 16_680, all_or(&[]));
}

#[test]
fn the_dam_break_starts_with_5370() {
    assert_count(&column([0.0; 3], [1.2, 0.3, 0.6], 0.01), tank(3.2, 0.3), 0.01, 5370, all_or(&[Method::Wang]));
}

#[test]
fn without_walls_the_obstacle_case_would_start_with_42168() {
    // What mirror images are for.
    assert_count(&column([0.0; 3], [0.4, 0.6, 0.3], 0.005), Vec::new(), 0.005, 42_168, &[]);
}
