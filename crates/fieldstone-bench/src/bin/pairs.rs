//! Prints nanoseconds per partially overlapping pair: kernel, decomposition, and their ratio.
//!
//! `pairs [TURNS] [PAIRS]`, by default 15 turns over at least 20,000 pairs per case.

use std::hint::black_box;

use fieldstone_bench::{Pairs, Shape, median, take_turns, thread_seconds};
use fieldstone_geometry::{OverlapBatch, decomposition, overlap_volume};

fn main() {
    let mut arguments =
        std::env::args().skip(1).map(|a| a.parse::<usize>().expect("TURNS and PAIRS are whole numbers"));
    let turns = arguments.next().unwrap_or(15).max(1);
    let at_least = arguments.next().unwrap_or(20_000).max(1);

    println!("Per partially overlapping pair, one thread, processor time, median of {turns} turns.\n");
    println!("| element | r | pairs | decomposition (ns) | one call (ns) | ratio | batch (ns) | ratio |");
    println!("|---|---:|---:|---:|---:|---:|---:|---:|");
    let mut logarithms = Vec::new();
    for shape in Shape::ALL {
        for r in [0.1, 0.3, 0.6, 1.0] {
            let pairs = Pairs::new(shape, r, at_least, 1);
            let count = pairs.len();
            let time = |work: &dyn Fn() -> f64| {
                let start = thread_seconds();
                black_box(work());
                1e9 * (thread_seconds() - start) / count as f64
            };
            let mut kernel = || time(&|| pairs.sum(|ball, polyhedron, _| overlap_volume(ball, polyhedron)));
            let (mut lanes, mut volumes) = (OverlapBatch::default(), vec![0.0; count]);
            let mut batch = || {
                let start = thread_seconds();
                pairs.batch(&mut lanes, &mut volumes);
                black_box(&volumes);
                1e9 * (thread_seconds() - start) / count as f64
            };
            let mut rival = || time(&|| pairs.sum(|ball, _, element| decomposition::overlap_volume(ball, element)));
            let [kernel, batch, rival] = take_turns(turns, [&mut kernel, &mut batch, &mut rival]);
            let ratios = [&kernel, &batch].map(|own| median(rival.iter().zip(own).map(|(r, own)| r / own)));
            logarithms.push(ratios.map(f64::ln));
            println!(
                "| {} | {r} | {count} | {:.0} | {:.0} | {:.2} | {:.0} | {:.2} |",
                shape.name(),
                median(rival),
                median(kernel),
                ratios[0],
                median(batch),
                ratios[1],
            );
        }
    }
    let mean = [0, 1].map(|k| (logarithms.iter().map(|l| l[k]).sum::<f64>() / logarithms.len() as f64).exp());
    println!("\nGeometric mean of the ratios: one call {:.2}, batch {:.2}", mean[0], mean[1]);
}
