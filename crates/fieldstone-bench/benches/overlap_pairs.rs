//! One partially overlapping pair after the other: kernel against decomposition.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fieldstone_bench::{Pairs, Shape};
use fieldstone_geometry::{OverlapBatch, decomposition, overlap, overlap_volume};

fn overlap_pairs(criterion: &mut Criterion) {
    for shape in Shape::ALL {
        for r in [0.1, 0.3, 0.6, 1.0] {
            let pairs = Pairs::new(shape, r, 2_000, 1);
            let case = format!("{},r={r}", shape.name());
            let size = pairs.len();
            let mut group = criterion.benchmark_group("pairs");
            group.throughput(Throughput::Elements(size as u64));
            group.bench_function(format!("overlap_volume[{case},kernel]/{size}"), |b| {
                b.iter(|| black_box(&pairs).sum(|ball, polyhedron, _| overlap_volume(ball, polyhedron)));
            });
            let (mut lanes, mut volumes) = (OverlapBatch::default(), vec![0.0; size]);
            group.bench_function(format!("overlap_volume[{case},batch]/{size}"), |b| {
                b.iter(|| black_box(&pairs).batch(&mut lanes, &mut volumes));
            });
            group.bench_function(format!("overlap[{case},kernel]/{size}"), |b| {
                b.iter(|| black_box(&pairs).sum(|ball, polyhedron, _| overlap(ball, polyhedron).volume));
            });
            group.bench_function(format!("overlap_volume[{case},decomposition]/{size}"), |b| {
                b.iter(|| black_box(&pairs).sum(|ball, _, element| decomposition::overlap_volume(ball, element)));
            });
            group.finish();
        }
    }
}

criterion_group!(benches, overlap_pairs);
criterion_main!(benches);
