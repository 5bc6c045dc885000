//! x
use fieldstone_bench::{Pairs, Shape};
use fieldstone_geometry::{OverlapBatch, overlap_volume};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let r: f64 = a[2].parse().unwrap();
    let pairs = Pairs::new(Shape::Hexahedron, r, 20000, 1);
    let mut v = vec![0.0; pairs.len()];
    let t = std::time::Instant::now();
    if a[1] == "batch" {
        let mut b = OverlapBatch::default();
        for _ in 0..300 {
            pairs.batch(&mut b, &mut v);
        }
        println!("{:?}", b.path_counts());
    } else {
        let mut s = 0.0;
        for _ in 0..300 {
            s += pairs.sum(|b, p, _| overlap_volume(b, p));
        }
        println!("{s}");
    }
    println!("{} ns", t.elapsed().as_secs_f64() * 1e9 / 300.0 / pairs.len() as f64);
}
