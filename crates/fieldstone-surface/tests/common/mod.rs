//! Particle sets that several tests use.
#![allow(dead_code, clippy::unwrap_used)]

use fieldstone_particles::{NeighbourGrid, NeighbourOptions};
use fieldstone_surface::{Scene, SurfaceDetection};
use fieldstone_testing::Random;

/// A block of a unit lattice, in place of cell centres, moved by up to `noise` along each axis.
pub fn block(counts: [usize; 3], noise: f64, seed: u64) -> Vec<[f64; 3]> {
    let mut random = Random(seed);
    let mut positions = Vec::with_capacity(counts.iter().product());
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            for k in 0..counts[2] {
                let offset = random.point(-1.0, 1.0);
                let lattice = [i, j, k];
                positions.push(std::array::from_fn(|axis| lattice[axis] as f64 + 0.5 + noise * offset[axis]));
            }
        }
    }
    positions
}

/// Labels by a method, without walls.
pub fn labels(positions: &[[f64; 3]], method: &dyn SurfaceDetection, spacing: f64, dimension: usize) -> Vec<bool> {
    let options = NeighbourOptions { dimension, ..NeighbourOptions::new(method.reach(spacing)) };
    let grid = NeighbourGrid::build(positions, options).unwrap();
    method.detect(&Scene::new(&grid, spacing)).unwrap().labels()
}

/// Unit directions to all neighbours of a particle, by brute force.
pub fn directions(positions: &[[f64; 3]], particle: usize, radius: f64) -> Vec<[f64; 3]> {
    let at = positions[particle];
    positions
        .iter()
        .filter_map(|p| {
            let d: [f64; 3] = std::array::from_fn(|k| p[k] - at[k]);
            let squared = dot(d, d);
            (squared > 0.0 && squared <= radius * radius).then(|| d.map(|x| x / squared.sqrt()))
        })
        .collect()
}

pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Half-angle of the largest cone that holds none of the directions, by brute force and independently of the library:
/// the axis of a locally largest cone is equidistant from three directions, or opposite to the middle of two or one.
pub fn largest_empty_cone(directions: &[[f64; 3]]) -> f64 {
    // Coincident directions make no new triple.
    let mut z: Vec<[f64; 3]> = Vec::new();
    for d in directions {
        if z.iter().all(|e| (0..3).map(|k| (d[k] - e[k]).powi(2)).sum::<f64>() > 1e-24) {
            z.push(*d);
        }
    }
    let mut best = 0.0f64;
    let mut offer = |m: [f64; 3]| {
        let length = dot(m, m).sqrt();
        if length < 1e-9 {
            return;
        }
        for sign in [1.0, -1.0] {
            let m = m.map(|x| sign * x / length);
            // A candidate that is worse than the best needs no full pass.
            let mut largest = -1.0f64;
            let limit = best.cos();
            for d in &z {
                largest = largest.max(dot(m, *d));
                if largest > limit + 1e-15 {
                    break;
                }
            }
            best = best.max(largest.clamp(-1.0, 1.0).acos());
        }
    };
    for (i, a) in z.iter().enumerate() {
        offer(*a);
        // Neighbours on a single line leave a ring of equal cones.
        offer(cross(*a, [a[1] + 1.0, -a[0], a[0] + 2.0]));
        for (j, b) in z.iter().enumerate().skip(i + 1) {
            offer(std::array::from_fn(|k| a[k] + b[k]));
            for c in &z[j + 1..] {
                offer(cross(std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k])));
            }
        }
    }
    best
}
