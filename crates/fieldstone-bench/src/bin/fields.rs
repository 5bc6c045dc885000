//! Seconds that the 29 standard fields take on 20³, 50³ and 100³ cells: 100,000 spheres, 300,000 contacts.
//!
//! `cargo run --release -p fieldstone-bench --bin fields [REPEATS]`, with `RAYON_NUM_THREADS` for
//! another number of threads. Reading and writing are not in it. The best of the repeats is printed: elapsed seconds,
//! and processor seconds of all threads, which other work on the machine disturbs less.
#![allow(clippy::unwrap_used)]

use std::time::Instant;

use fieldstone_bench::process_seconds;
use fieldstone_fields::{
    CoarseGraining, CoarseGrainingOptions, FieldName, Function, Kernel, KernelShape, Method, Weights,
};
use fieldstone_mesh::Grid;
use fieldstone_particles::{Contact, Contacts, Particles, Partner, Quantity};

const COUNTS: [usize; 3] = [50, 50, 40];

/// A cubic packing shaken by a tenth of its spacing; each sphere touches its next in each direction.
fn packing() -> (Particles, Contacts) {
    let mut seed = 1u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let [nx, ny, nz] = COUNTS;
    let count = nx * ny * nz;
    let mut positions = Vec::with_capacity(count);
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                positions.push([i, j, k].map(|n| n as f64 + 0.5 + 0.2 * random()));
            }
        }
    }
    let radii: Vec<f64> = (0..count).map(|_| 0.5 + 0.05 * random()).collect();
    let velocities: Vec<f64> = (0..3 * count).map(|_| random()).collect();
    let mut contacts = Contacts::new();
    for at in 0..count {
        let [i, j, k] = [at % nx, at / nx % ny, at / (nx * ny)];
        for (inside, step) in [(i + 1 < nx, 1), (j + 1 < ny, nx), (k + 1 < nz, nx * ny)] {
            let branch: [f64; 3];
            let partner = if inside {
                branch = std::array::from_fn(|a| positions[at + step][a] - positions[at][a]);
                Partner::Particle((at + step) as u32)
            } else {
                // The faces of the box are walls.
                branch = std::array::from_fn(|a| if [1, nx, nx * ny][a] == step { radii[at] } else { 0.0 });
                Partner::Wall(step as i64)
            };
            let arm = if inside { branch.map(|b| 0.5 * b) } else { branch };
            let force = branch.map(|b| -b * (1.0 + random()));
            contacts.push(count, Contact { particle: at as u32, partner, force, arm, branch }).unwrap();
        }
    }
    let particles = Particles::new(positions)
        .unwrap()
        .with_radii(radii)
        .unwrap()
        .with_quantity(Quantity { name: "velocity".into(), components: 3, data: velocities })
        .unwrap();
    (particles, contacts)
}

/// Elapsed and processor seconds of a task.
fn timed<T>(task: impl FnOnce() -> T) -> ([f64; 2], T) {
    let (start, before) = (Instant::now(), process_seconds());
    let result = task();
    ([start.elapsed().as_secs_f64(), process_seconds() - before], result)
}

fn least(best: &mut [f64; 2], seconds: [f64; 2]) {
    best.iter_mut().zip(seconds).for_each(|(b, s)| *b = b.min(s));
}

fn main() {
    let repeats: usize = std::env::args().nth(1).map_or(3, |n| n.parse().expect("a number of repeats"));
    let (particles, contacts) = packing();
    println!(
        "{} spheres, {} contacts, {} threads, best of {repeats}",
        particles.len(),
        contacts.len(),
        rayon::current_num_threads()
    );
    println!("{:>6} {:>34} {:>9} {:>9} {:>14}", "cells", "function", "elapsed", "processor", "mass error");
    let functions = [
        ("exact", Function::Overlap(Method::Kernel)),
        ("exact, decomposition method", Function::Overlap(Method::Decomposition)),
        ("gauss, w = 0.5", Function::Kernel(Kernel::new(KernelShape::Gauss, 0.5, None).unwrap())),
        ("lucy, w = 1", Function::Kernel(Kernel::new(KernelShape::Lucy, 1.0, None).unwrap())),
    ];
    for n in [20, 50, 100] {
        let grid = Grid::new([0.0; 3], COUNTS.map(|c| c as f64), [n; 3]).unwrap();
        for (name, function) in functions {
            let mut best = [f64::INFINITY; 2];
            let mut ledger = None;
            let repeats = if function == Function::Overlap(Method::Decomposition) { 1 } else { repeats };
            for _ in 0..repeats {
                let options = CoarseGrainingOptions {
                    function,
                    fields: FieldName::standard(),
                    particle_density: Some(2.0),
                    ..CoarseGrainingOptions::default()
                };
                let (seconds, fields) = timed(|| {
                    let mut grains = CoarseGraining::new(&grid, options).unwrap();
                    grains.accumulate(&particles, Some(&contacts), 1.0).unwrap();
                    grains.finish().unwrap()
                });
                least(&mut best, seconds);
                ledger = Some(fields.ledger);
            }
            let l = ledger.unwrap();
            let error = (l.mass_in - l.mass_binned - l.mass_clipped) / l.mass_in;
            println!("{:>6} {name:>34} {:>9.3} {:>9.3} {error:>14.1e}", format!("{n}³"), best[0], best[1]);
        }
        let mut best = [[f64::INFINITY; 2]; 2];
        let ones = vec![1.0; particles.len()];
        for _ in 0..repeats {
            let (seconds, weights) = timed(|| Weights::build(&grid, &particles, Method::Kernel, None).unwrap());
            least(&mut best[0], seconds);
            let (seconds, _) = timed(|| weights.sum_over_particles(&ones).unwrap());
            least(&mut best[1], seconds);
        }
        for (name, best) in ["Weights::build alone", "sum_over_particles alone"].iter().zip(best) {
            println!("{:>6} {name:>34} {:>9.3} {:>9.3}", format!("{n}³"), best[0], best[1]);
        }
    }
}
