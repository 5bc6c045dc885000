//! Which time steps the integrators bear, what they cost, and what they change: the dam-break slab.
//!
//! ```sh
//! cargo run --release -p fieldstone-sph --example time_step -- 0.04 0.6 symplectic:0.25 rk4:1.0 rk4:1.5:1.5:0.2
//! ```
//!
//! The arguments are the spacing, the end time, and for each run an integrator with its CFL number, the k_CFL of the
//! shifting (by default the CFL number, so that particles are shifted as far per unit of time) and the lists' margin
//! over Δx. A row is printed every 0.1 s.
#![allow(clippy::unwrap_used)]

use fieldstone_sph::{DirectionName, Integrator, SHIPPED, Solver, front};

/// Processor time of the whole program.
fn clock() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let spacing: f64 = arguments[0].parse().unwrap();
    let end: f64 = arguments[1].parse().unwrap();
    let case = SHIPPED.iter().find(|c| c.name == "dam-break-slab").unwrap().at_spacing(Some(spacing)).unwrap();
    println!(
        "run, time, front, kinetic, potential, compression, residual, free surface, mean pressure, steps, evaluations, lists, seconds"
    );
    for run in &arguments[2..] {
        let parts: Vec<&str> = run.split(':').collect();
        let mut flow = case.flow().unwrap();
        let (integrator, stages) = match parts[0] {
            "symplectic" => (Integrator::Symplectic, 2),
            _ => (Integrator::RungeKutta4, 4),
        };
        flow.time_step.integrator = integrator;
        flow.time_step.cfl = parts[1].parse().unwrap();
        if let Some(shifting) = &mut flow.shifting {
            shifting.k_cfl = parts.get(2).map_or(flow.time_step.cfl, |k| k.parse().unwrap());
        }
        if let Some(skin) = parts.get(3) {
            flow.skin = skin.parse().unwrap();
        }
        let mut solver = Solver::new(flow, case.state().unwrap()).unwrap();
        let start = clock();
        let mut next = 0.1;
        while solver.time() < end {
            if let Err(error) = solver.step() {
                println!("{run}: {error}");
                break;
            }
            if solver.time() >= next {
                next += 0.1;
                report(run, &solver, stages, clock() - start);
            }
        }
    }
}

fn report(run: &str, solver: &Solver, stages: u64, seconds: f64) {
    let energies = solver.energies();
    let free = solver.regions().iter().filter(|&&r| r == 0).count();
    let pressure = solver.state().density.iter().map(|&d| solver.flow().fluid.pressure(d)).sum::<f64>();
    println!(
        "{run}, {:.3}, {:.4}, {:.2}, {:.2}, {:.3}, {:.3}, {free}, {:.0}, {}, {}, {}, {seconds:.2}",
        solver.time(),
        front(solver, DirectionName::X),
        energies.kinetic,
        energies.potential,
        energies.compression,
        solver.energy_residual(),
        pressure / solver.state().len() as f64,
        solver.steps(),
        stages * solver.steps(),
        solver.phases().lists_built,
    );
}
