//! Balls in meshes: one thread without the sparse matrix, and the whole job on all threads.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fieldstone_bench::{box_of_hexahedra, random_balls};
use fieldstone_fields::{Method, Weights};
use fieldstone_geometry::Ball;
use fieldstone_mesh::{Cells, Grid, Mesh};
use fieldstone_particles::Particles;

const CELLS: [usize; 3] = [20, 20, 25];
const BALLS: usize = 10_000;

fn both<C: Cells>(criterion: &mut Criterion, name: &str, cells: &C, particles: &Particles) {
    let balls: Vec<Ball> = particles.positions().iter().map(|&p| Ball::new(p, 0.3).expect("a ball")).collect();
    let mut group = criterion.benchmark_group("mesh");
    group.throughput(Throughput::Elements(BALLS as u64));
    group.sample_size(20);
    let (mut scratch, mut row) = (cells.scratch(), Vec::new());
    group.bench_function(format!("overlap_ball[{name},r=0.3]/{BALLS}"), |b| {
        b.iter(|| {
            let mut entries = 0;
            for ball in &balls {
                row.clear();
                cells.overlap_ball(black_box(ball), &mut scratch, &mut row);
                entries += row.len();
            }
            entries
        });
    });
    group.bench_function(format!("weights[{name},r=0.3]/{BALLS}"), |b| {
        b.iter(|| Weights::build(cells, black_box(particles), Method::Kernel, None).expect("balls with radii"));
    });
    group.finish();
}

fn mesh_jobs(criterion: &mut Criterion) {
    let high = CELLS.map(|n| n as f64);
    let balls = random_balls(BALLS, 0.3, high, 2);
    let straight: Mesh = box_of_hexahedra(CELLS, 0.0, 1);
    both(criterion, "hexahedra", &straight, &balls);
    let warped: Mesh = box_of_hexahedra(CELLS, 0.2, 1);
    both(criterion, "warped", &warped, &balls);
    both(criterion, "grid", &Grid::new([0.0; 3], high, CELLS).expect("a box"), &balls);
}

criterion_group!(benches, mesh_jobs);
criterion_main!(benches);
