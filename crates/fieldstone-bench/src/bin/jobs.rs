//! Prints the cost of whole jobs: balls of 0.3 cells in 100,000 cells, microseconds per ball.
//!
//! `jobs [TURNS]`, by default 5. The last column is what two threads reach in the same turns where no memory is touched.

use std::hint::black_box;
use std::time::Instant;

use fieldstone_bench::{arithmetic_seconds, box_of_hexahedra, median, process_seconds, random_balls, take_turns};
use fieldstone_fields::{Method, Weights};
use fieldstone_mesh::{Cells, Grid, Mesh};
use fieldstone_particles::Particles;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// 100,000 unit cells.
const CELLS: [usize; 3] = [50, 50, 40];
/// Radius in cells.
const RADIUS: f64 = 0.3;

/// Runs the job once: every ball binned, and the solid volume of every cell added up. Returns the number of
/// (ball, cell) entries.
fn job<C: Cells>(cells: &C, balls: &Particles, method: Method) -> usize {
    let weights = Weights::build(cells, balls, method, None).expect("balls with radii");
    let volume = weights.sum_over_particles(&vec![1.0; balls.len()]).expect("a value per ball");
    black_box(volume);
    weights.cells().len()
}

/// Microseconds per ball: (processor time over all threads, time of day).
fn time<C: Cells>(pool: &ThreadPool, cells: &C, balls: &Particles, method: Method) -> (f64, f64) {
    let (cpu, wall) = (process_seconds(), Instant::now());
    pool.install(|| job(cells, balls, method));
    let per_ball = 1e6 / balls.len() as f64;
    (per_ball * (process_seconds() - cpu), per_ball * wall.elapsed().as_secs_f64())
}

fn threads(n: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(n).build().expect("threads")
}

fn one_and_two_threads<C: Cells>(name: &str, cells: &C, balls: &Particles, method: Method, turns: usize) {
    let (one, two) = (threads(1), threads(2));
    let per_ball = one.install(|| job(cells, balls, method)) as f64 / balls.len() as f64;
    let (mut busy_one, mut busy_two) = (Vec::new(), Vec::new());
    let mut first = || {
        let (cpu, wall) = time(&one, cells, balls, method);
        busy_one.push(cpu);
        wall
    };
    let mut second = || {
        let (cpu, wall) = time(&two, cells, balls, method);
        busy_two.push(cpu);
        wall
    };
    let (mut third, mut fourth) = (|| arithmetic_seconds(&one), || arithmetic_seconds(&two));
    let [wall_one, wall_two, one, two] = take_turns(turns, [&mut first, &mut second, &mut third, &mut fourth]);
    let ratio = |one: &[f64], two: &[f64]| median(one.iter().zip(two).map(|(a, b)| a / b));
    println!(
        "| {name} | {method} | {per_ball:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} |",
        median(busy_one),
        median(busy_two),
        wall_one.iter().copied().fold(f64::INFINITY, f64::min),
        wall_two.iter().copied().fold(f64::INFINITY, f64::min),
        ratio(&wall_one, &wall_two),
        ratio(&one, &two),
    );
}

fn growth<C: Cells>(name: &str, cells: &C, high: [f64; 3], turns: usize) {
    let one = threads(1);
    let counts = [10_000, 45_000, 100_000, 1_000_000];
    let sets = counts.map(|count| random_balls(count, RADIUS, high, 3));
    let mut runs = sets.each_ref().map(|balls| || time(&one, cells, balls, Method::Kernel).0);
    let [a, b, c, d] = &mut runs;
    let times = take_turns(turns.min(3), [a, b, c, d]).map(median);
    println!("| {name} | {:.2} | {:.2} | {:.2} | {:.2} |", times[0], times[1], times[2], times[3]);
}

fn main() {
    let turns = std::env::args().nth(1).map_or(5, |a| a.parse::<usize>().expect("TURNS is a whole number")).max(1);
    let high = CELLS.map(|n| n as f64);
    let straight: Mesh = box_of_hexahedra(CELLS, 0.0, 1);
    let warped: Mesh = box_of_hexahedra(CELLS, 0.2, 1);
    let grid = Grid::new([0.0; 3], high, CELLS).expect("a box");
    let balls = random_balls(100_000, RADIUS, high, 2);

    println!("100,000 balls of r = {RADIUS} cells in 100,000 cells, microseconds per ball, {turns} turns.\n");
    println!(
        "| mesh | method | cells per ball | cpu, 1 thread | cpu, 2 threads | best wall, 1 | best wall, 2 | wall 1 / wall 2, median | the same of arithmetic |"
    );
    println!("|---|---|---:|---:|---:|---:|---:|---:|---:|");
    one_and_two_threads("hexahedra", &straight, &balls, Method::Kernel, turns);
    one_and_two_threads("warped hexahedra", &warped, &balls, Method::Kernel, turns);
    one_and_two_threads("grid", &grid, &balls, Method::Kernel, turns);
    // The rival builds its elements for every job, and cuts warped cells into 24 tetrahedra: a turn takes long.
    one_and_two_threads("hexahedra", &straight, &balls, Method::Decomposition, turns.min(3));
    one_and_two_threads("warped hexahedra", &warped, &balls, Method::Decomposition, 1);

    println!("\nGrowth with the number of balls: microseconds of processor time per ball, 1 thread, kernel.\n");
    println!("| mesh | 10⁴ | 4.5·10⁴ | 10⁵ | 10⁶ |");
    println!("|---|---:|---:|---:|---:|");
    growth("hexahedra", &straight, high, turns);
    growth("warped hexahedra", &warped, high, turns);
    growth("grid", &grid, high, turns);
}
