//! What more threads can give at best.

use std::hint::black_box;
use std::time::Instant;

use rayon::ThreadPool;
use rayon::prelude::*;

/// Parts of the work: a multiple of any likely number of threads.
const PARTS: u32 = 24;

/// Time of day, in seconds, in which `pool` does a fixed amount of arithmetic that touches no memory.
///
/// Two threads need more than half of the time that one needs where cores are shared with other programs. The ratio
/// of this time with one and with two, taken in turns with that of a job, is what the job's own could be at best.
pub fn arithmetic_seconds(pool: &ThreadPool) -> f64 {
    let start = Instant::now();
    pool.install(|| {
        (0..PARTS).into_par_iter().for_each(|part| {
            let mut lanes = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, f64::from(part)];
            for _ in 0..1_000_000 {
                for x in &mut lanes {
                    *x = *x * 0.999 + 0.1;
                }
            }
            black_box(lanes);
        });
    });
    start.elapsed().as_secs_f64()
}
