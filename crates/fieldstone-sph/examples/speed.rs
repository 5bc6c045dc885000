//! Fluid-particle-steps per second and core, with the time per phase.
//!
//! ```sh
//! cargo run --release -p fieldstone-sph --example speed -- 60 2.0 30 1
//! ```
//!
//! The arguments are the particles along each edge of a falling column, h/Δx, the steps, the threads, the time at which
//! measuring begins (0.2 s: the front is fast, and lists are built often), and the lists' margin over Δx. Run are:
//! without detection and shifting, then with both. Ghosts are not counted as work done; the rate is that of the
//! processor time of all threads, so a busy machine matters less, the time per phase is that of the clock.
#![allow(clippy::unwrap_used)]

use std::time::Instant;

use fieldstone_sph::{Boundaries, Flow, FluidOptions, MirrorWall, Phase, Shape, ShiftingOptions, Slip, Solver, State};
use fieldstone_surface::{Method, Wall};

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

/// Processor time of the whole program.
fn clock() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

fn main() {
    let argument = |n: usize, default: f64| std::env::args().nth(n).map_or(default, |a| a.parse().unwrap());
    let (side, smoothing) = (argument(1, 60.0) as usize, argument(2, 2.0));
    let (steps, threads) = (argument(3, 30.0) as usize, argument(4, 1.0) as usize);
    let (warm, skin) = (argument(5, 0.0), argument(6, 0.0));
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().unwrap();
    for with_surface in [false, true] {
        let (mut flow, state) = dam_break(side, smoothing);
        if skin > 0.0 {
            flow.skin = skin;
        }
        if with_surface {
            flow.shifting = Some(ShiftingOptions::default());
            flow.detection = Some(Method::Exact);
        }
        let count = state.len();
        let mut solver = Solver::new(flow, state).unwrap();
        while solver.steps() < 3 || solver.time() < warm {
            solver.step().unwrap();
        }
        let before = *solver.phases();
        let (start, wall) = (clock(), Instant::now());
        for _ in 0..steps {
            solver.step().unwrap();
        }
        let (seconds, elapsed) = (clock() - start, wall.elapsed().as_secs_f64());
        let work = (count * steps) as f64;
        println!(
            "{count} particles, {:.0} neighbours, detection and shifting {}: {:.0}k steps/s/core, {:.0}k steps/s, \
             {} lists in {steps} steps, {} bytes per particle",
            solver.mean_neighbours().unwrap(),
            if with_surface { "on" } else { "off" },
            1e-3 * work / seconds,
            1e-3 * work / elapsed,
            solver.phases().lists_built - before.lists_built,
            solver.bytes() / count
        );
        for phase in Phase::ALL {
            let time = (solver.phases().time(phase) - before.time(phase)).as_secs_f64();
            println!("  {:<11} {:>7.3} µs per particle and step", phase.name(), 1e6 * time * threads as f64 / work);
        }
    }
}
