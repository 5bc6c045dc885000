//! Times the methods.
use fieldstone_particles::*;
use fieldstone_surface::*;
use std::time::Instant;
fn main() {
    let n: usize = std::env::args().nth(1).map_or(100, |a| a.parse().unwrap());
    let noise: f64 = std::env::args().nth(2).map_or(0.3, |a| a.parse().unwrap());
    let mut seed = 1u64;
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let positions: Vec<[f64; 3]> = (0..n * n * n)
        .map(|i| {
            [(i % n) as f64 + noise * next(), (i / n % n) as f64 + noise * next(), (i / n / n) as f64 + noise * next()]
        })
        .collect();
    let count = positions.len() as f64;
    let t = Instant::now();
    let e = Exact::default();
    println!("table {:.1} ms", t.elapsed().as_secs_f64() * 1e3);
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(|| {
        for _ in 0..3 {
            let t = Instant::now();
            let grid = NeighbourGrid::build(&positions, NeighbourOptions::new(2.5)).unwrap();
            let b = t.elapsed().as_secs_f64();
            let d = e.detect(&Scene::new(&grid, 1.0)).unwrap();
            let x = t.elapsed().as_secs_f64();
            println!(
                "build {:.3} exact {:.3} µs total {:.3}: {}",
                b * 1e6 / count,
                (x - b) * 1e6 / count,
                x * 1e6 / count,
                d.free_surface()
            );
            let mut sum = 0usize;
            let t = Instant::now();
            for i in 0..positions.len() {
                grid.for_each_neighbour(i, 2.5, |_, _, _| sum += 1).unwrap();
            }
            println!("neighbours {:.3} µs {}", t.elapsed().as_secs_f64() * 1e6 / count, sum as f64 / count);
        }
        if n <= 50 {
            let grid = NeighbourGrid::build(&positions, NeighbourOptions::new(2.5)).unwrap();
            let t = Instant::now();
            let d = Geometrical::default().detect(&Scene::new(&grid, 1.0)).unwrap();
            println!("geometrical {:.3} {}", t.elapsed().as_secs_f64() * 1e6 / count, d.free_surface());
            assert!(d.labels() == e.detect(&Scene::new(&grid, 1.0)).unwrap().labels());
        }
    });
}
