//! Times the detection methods beside each other, neighbour search included.
//!
//! ```sh
//! cargo run --release -p fieldstone-surface --example detection_timing -- 100 0.3 0 3
//! ```
//!
//! The arguments are the particles along the edge of a block, their random offset over the spacing, how many of them
//! the slow methods (geometrical, semi-geometrical, Haque) get along each edge, 0 for none and the block's own edge for
//! all, and the turns. Methods take turns; printed is processor time of one thread, the median over the turns, and the
//! ratio to the exact method. Then follow the exact method with known witnesses, over the number of particles, and by
//! two threads in wall-clock time, which tells something on a quiet machine only.
#![allow(clippy::unwrap_used)]

use std::time::Instant;

use fieldstone_particles::{NeighbourGrid, NeighbourOptions};
use fieldstone_surface::{
    Detection, Exact, Geometrical, Haque, Marrone, Scene, SemiGeometrical, SurfaceDetection, Wang, WitnessCache,
};
use fieldstone_testing::Random;

fn block(side: usize, noise: f64) -> Vec<[f64; 3]> {
    let mut random = Random(1);
    let mut offset = || noise * random.uniform(-1.0, 1.0);
    let lattice = |i: usize| [i % side, i / side % side, i / (side * side)];
    (0..side.pow(3)).map(|i| lattice(i).map(|k| k as f64 + offset())).collect()
}

/// Processor time of this thread in seconds.
fn clock() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    times[times.len() / 2]
}

fn run(positions: &[[f64; 3]], method: &dyn SurfaceDetection) -> (f64, f64, usize) {
    let start = clock();
    let grid = NeighbourGrid::build(positions, NeighbourOptions::new(method.reach(1.0))).unwrap();
    let built = clock();
    let found = method.detect(&Scene::new(&grid, 1.0)).unwrap().free_surface();
    let per_particle = 1e6 / positions.len() as f64;
    ((clock() - start) * per_particle, (built - start) * per_particle, found)
}

fn main() {
    let argument = |n: usize, default: f64| std::env::args().nth(n).map_or(default, |a| a.parse().unwrap());
    let (side, noise) = (argument(1, 100.0) as usize, argument(2, 0.3));
    let (slow_side, turns) = (argument(3, 30.0) as usize, argument(4, 3.0) as usize);
    let positions = block(side, noise);
    let exact = Exact::default();
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().unwrap();

    println!("{} particles, offset {noise}, one thread, µs per particle", positions.len());
    let fast: [&dyn SurfaceDetection; 3] = [&exact, &Wang::default(), &Marrone::default()];
    let slow: [&dyn SurfaceDetection; 4] =
        [&exact, &Geometrical::default(), &SemiGeometrical::default(), &Haque::default()];
    let slow_positions = block(slow_side, noise);
    for (methods, positions) in [(&fast[..], &positions), (&slow[..], &slow_positions)] {
        if positions.is_empty() {
            continue;
        }
        println!(
            "{:>14} {:>10} {:>10} {:>8} {:>10}  ({} particles)",
            "method",
            "total",
            "sorting",
            "ratio",
            "found",
            positions.len()
        );
        let mut times = vec![Vec::new(); methods.len()];
        let mut last = vec![(0.0, 0); methods.len()];
        for _ in 0..turns.max(1) {
            for (m, method) in methods.iter().enumerate() {
                let (total, built, found) = run(positions, *method);
                times[m].push(total);
                last[m] = (built, found);
            }
        }
        let ratio = |m: usize| median(times[m].iter().zip(&times[0]).map(|(a, b)| a / b).collect());
        for (m, method) in methods.iter().enumerate() {
            let total = median(times[m].clone());
            println!("{:>14} {total:>10.3} {:>10.3} {:>8.2} {:>10}", method.name(), last[m].0, ratio(m), last[m].1);
        }
    }

    println!("exact method with known witnesses, sorting left out");
    let grid = NeighbourGrid::build(&positions, NeighbourOptions::new(2.5)).unwrap();
    let (mut cache, mut detection) = (WitnessCache::default(), Detection::default());
    for step in 0..3 {
        let start = clock();
        exact.label_with(&Scene::new(&grid, 1.0), &mut cache, &mut detection).unwrap();
        println!("  step {step}: {:.3}", (clock() - start) * 1e6 / positions.len() as f64);
    }

    println!("counting neighbours within 2.5, sorting included");
    let start = clock();
    let grid = NeighbourGrid::build(&positions, NeighbourOptions::new(2.5)).unwrap();
    let mut pairs = 0;
    for particle in 0..positions.len() {
        grid.for_each_neighbour(particle, 2.5, |_, _, _| pairs += 1).unwrap();
    }
    println!(
        "  {:.3} for {:.1} neighbours",
        (clock() - start) * 1e6 / positions.len() as f64,
        pairs as f64 / positions.len() as f64
    );

    println!("exact method over the number of particles");
    for side in [22, 46, 100].into_iter().filter(|s| *s <= side) {
        let positions = block(side, noise);
        let total = median((0..turns).map(|_| run(&positions, &exact).0).collect());
        println!("  {:>8}: {total:.3}", positions.len());
    }

    println!("exact method by one and two threads, wall-clock time");
    let pools = [1, 2].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap());
    let mut speed_ups = Vec::new();
    for _ in 0..turns.max(1) {
        let [one, two] = [&pools[0], &pools[1]].map(|pool| {
            let start = Instant::now();
            pool.install(|| {
                let grid = NeighbourGrid::build(&positions, NeighbourOptions::new(2.5)).unwrap();
                exact.detect(&Scene::new(&grid, 1.0)).unwrap()
            });
            start.elapsed().as_secs_f64()
        });
        speed_ups.push(one / two);
    }
    println!("  speed-up {:.2}", median(speed_ups));
}
