//! Fluid-particle-steps per second and core, with the time per phase.
//!
//! ```sh
//! cargo run --release -p fieldstone-bench --bin flow -- 60 2.0 30 2
//! ```
//!
//! The arguments are the particles along each edge of a falling column, h/Δx, the steps, the threads, the time at which
//! measuring begins (0.2 s: the front is fast, and lists are built often), and the lists' margin over Δx. Run are:
//! without detection and shifting, then with both. Ghosts are not counted as work done; the rate is that of the
//! processor time of all threads, so a busy machine matters less, the time per phase is that of the clock.
//!
//! With more than one thread, steps are then done by one and by all of them in turn; the median of the ratios of
//! neighbouring steps' times is the speed-up, and stands beside that of plain arithmetic in the same turns.
#![allow(clippy::unwrap_used)]

use std::time::Instant;

use fieldstone_bench::{arithmetic_seconds, median, process_seconds, take_turns};
use fieldstone_sph::{Boundaries, Flow, FluidOptions, MirrorWall, Phase, Shape, ShiftingOptions, Slip, Solver, State};
use fieldstone_surface::{Method, Wall};
use rayon::{ThreadPool, ThreadPoolBuilder};

fn dam_break(side: usize, smoothing: f64) -> (Flow, State) {
    let dx = 0.6 / side as f64;
    let mut fluid = FluidOptions::new(3, dx, 2.4, 6000.0);
    fluid.smoothing = smoothing;
    fluid.sound_speed = 48.0;
    let mut boundaries = Boundaries::new([0.0, 0.0, 0.0], [3.2, 0.6, 1.8], dx);
    for (normal, offset) in [
        ([0.0, 0.0, 1.0], 0.0),
        ([1.0, 0.0, 0.0], 0.0),
        ([-1.0, 0.0, 0.0], -3.2),
        ([0.0, 1.0, 0.0], 0.0),
        ([0.0, -1.0, 0.0], -0.6),
    ] {
        boundaries.walls.push(MirrorWall { plane: Wall::new(normal, offset).unwrap(), slip: Slip::Free });
    }
    let (x, _) = Shape::Box { low: [0.0; 3], high: [0.6; 3] }.lattice(dx, 3);
    let density = x.iter().map(|x| fluid.density_at(1000.0 * 9.81 * (0.6 - x[2]))).collect();
    let state = State { u: vec![[0.0; 3]; x.len()], density, id: (0..x.len() as u32).collect(), x };
    (Flow::new(fluid, boundaries), state)
}

/// Makes `steps` steps on all threads; prints their rate and where the time went.
fn rate(solver: &mut Solver, pool: &ThreadPool, steps: usize, what: &str) {
    let count = solver.state().len();
    let before = *solver.phases();
    let (start, wall) = (process_seconds(), Instant::now());
    for _ in 0..steps {
        pool.install(|| solver.step().unwrap());
    }
    let (seconds, elapsed) = (process_seconds() - start, wall.elapsed().as_secs_f64());
    let work = (count * steps) as f64;
    println!(
        "{count} particles, {:.0} neighbours, detection and shifting {what}: {:.0}k steps/s/core, {:.0}k steps/s, {} lists \
         in {steps} steps, {} bytes per particle",
        solver.mean_neighbours().unwrap(),
        1e-3 * work / seconds,
        1e-3 * work / elapsed,
        solver.phases().lists_built - before.lists_built,
        solver.bytes() / count
    );
    for phase in Phase::ALL {
        let time = (solver.phases().time(phase) - before.time(phase)).as_secs_f64();
        let per_step = 1e6 * time * pool.current_num_threads() as f64 / work;
        println!("  {:<11} {per_step:>7.3} µs per particle and step", phase.name());
    }
}

/// Makes steps by one thread and by all, in turn, and prints the speed-up.
fn speed_up(solver: &mut Solver, one: &ThreadPool, all: &ThreadPool, steps: usize) {
    let solver = std::cell::RefCell::new(solver);
    let step = |pool: &ThreadPool| {
        let solver: &mut Solver = &mut solver.borrow_mut();
        let start = Instant::now();
        pool.install(|| solver.step().unwrap());
        start.elapsed().as_secs_f64()
    };
    let [step_one, step_all, plain_one, plain_all] = take_turns(
        steps,
        [&mut || step(one), &mut || step(all), &mut || arithmetic_seconds(one), &mut || arithmetic_seconds(all)],
    );
    let ratio = |one: &[f64], all: &[f64]| median(one.iter().zip(all).map(|(a, b)| a / b));
    println!(
        "  {} threads are {:.2} times as fast as one; of arithmetic without memory {:.2} times",
        all.current_num_threads(),
        ratio(&step_one, &step_all),
        ratio(&plain_one, &plain_all)
    );
}

fn main() {
    let argument = |n: usize, default: f64| std::env::args().nth(n).map_or(default, |a| a.parse().unwrap());
    let (side, smoothing) = (argument(1, 60.0) as usize, argument(2, 2.0));
    let (steps, threads) = (argument(3, 30.0) as usize, argument(4, 1.0) as usize);
    let (warm, skin) = (argument(5, 0.0), argument(6, 0.0));
    let pool = |threads| ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let (one, all) = (pool(1), pool(threads));
    for with_surface in [false, true] {
        let (mut flow, state) = dam_break(side, smoothing);
        if skin > 0.0 {
            flow.skin = skin;
        }
        if with_surface {
            flow.shifting = Some(ShiftingOptions::default());
            flow.detection = Some(Method::Exact);
        }
        let mut solver = Solver::new(flow, state).unwrap();
        while solver.steps() < 3 || solver.time() < warm {
            all.install(|| solver.step().unwrap());
        }
        rate(&mut solver, &all, steps, if with_surface { "on" } else { "off" });
        if threads > 1 {
            speed_up(&mut solver, &one, &all, steps);
        }
    }
}
