//! Flows that several tests use.
#![allow(dead_code, clippy::unwrap_used)]

use fieldstone_sph::{Boundaries, Flow, FluidOptions, MirrorWall, Motion, Shape, Slip, Solver, State, Viscosity};
use fieldstone_surface::Wall;

/// Whether the flows run at the resolutions and times that the documentation quotes, in minutes.
pub fn long() -> bool {
    std::env::var_os("FIELDSTONE_SPH_LONG").is_some()
}

/// A state on the lattice of shapes, with velocity and pressure as functions of the position.
pub fn state(
    shapes: &[Shape],
    fluid: &FluidOptions,
    velocity: impl Fn([f64; 3]) -> [f64; 3],
    pressure: impl Fn([f64; 3]) -> f64,
) -> State {
    let x: Vec<[f64; 3]> = shapes.iter().flat_map(|s| s.lattice(fluid.spacing, fluid.dimension).0).collect();
    State {
        u: x.iter().map(|&x| velocity(x)).collect(),
        density: x.iter().map(|&x| fluid.density_at(pressure(x))).collect(),
        id: (0..x.len() as u32).collect(),
        x,
    }
}

/// A floor along the lowest face and walls on all sides but the top.
pub fn tank(low: [f64; 3], high: [f64; 3], fluid: &FluidOptions, slip: Slip) -> Boundaries {
    let up = fluid.dimension - 1;
    let mut boundaries = Boundaries::new(low, high, fluid.spacing);
    for axis in 0..fluid.dimension {
        let mut normal = [0.0; 3];
        normal[axis] = 1.0;
        boundaries.walls.push(MirrorWall { plane: Wall::new(normal, low[axis]).unwrap(), slip });
        if axis != up {
            boundaries.walls.push(MirrorWall { plane: Wall::new(normal.map(|n| -n), -high[axis]).unwrap(), slip });
        }
    }
    boundaries.open[up][1] = true;
    boundaries
}

/// A column of water in the left corner of a tank in two dimensions.
pub fn dam_break(spacing: f64, slip: Slip) -> (Flow, State) {
    let mut fluid = FluidOptions::new(2, spacing, 2.0, 4000.0);
    fluid.sound_speed = 30.0;
    let boundaries = tank([0.0; 3], [1.2, 1.0, 0.0], &fluid, slip);
    let column = Shape::Box { low: [0.0; 3], high: [0.4, 0.3, 0.0] };
    let state = state(&[column], &fluid, |_| [0.0; 3], |x| 9810.0 * (0.3 - x[1]));
    (Flow::new(fluid, boundaries), state)
}

/// Steps until a time.
pub fn run(solver: &mut Solver, until: f64) {
    while solver.time() < until {
        solver.step().unwrap();
    }
}

/// Does something on one thread, with all that it would share out: small flows lose more by waking threads.
pub fn alone<T: Send>(what: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(what)
}

/// Steps until a time, on one thread.
pub fn run_alone(solver: &mut Solver, until: f64) {
    alone(|| run(solver, until));
}

/// State in the order of the particles' numbers, as bits.
pub fn bits(solver: &Solver) -> Vec<u64> {
    let state = solver.state();
    let mut order: Vec<usize> = (0..state.len()).collect();
    order.sort_by_key(|&i| state.id[i]);
    order
        .iter()
        .flat_map(|&i| state.x[i].into_iter().chain(state.u[i]).chain([state.density[i]]).map(f64::to_bits))
        .collect()
}

/// A smooth start to a constant speed along an axis, by 200 rows.
pub fn ramped(axis: usize, speed: f64, rise: f64, end: f64) -> Motion {
    let rows: Vec<(f64, [f64; 3])> = (0..=200)
        .map(|n| {
            let t = end * f64::from(n) / 200.0;
            // u = U (1 − cos(π t/T))/2 up to T.
            let k = std::f64::consts::PI / rise;
            let x = if t < rise { 0.5 * speed * (t - (k * t).sin() / k) } else { speed * (t - 0.5 * rise) };
            let mut displacement = [0.0; 3];
            displacement[axis] = x;
            (t, displacement)
        })
        .collect();
    Motion::new(&rows).unwrap()
}

/// Water in a tank with the velocity of a standing wave as it passes through rest.
pub struct Wave {
    pub flow: Flow,
    pub state: State,
    /// Wave number, and frequency by linear theory.
    pub k: f64,
    pub frequency: f64,
}

/// The first mode that fits into a tank of a length; `viscosity` is the dynamic one, `top` the tank's.
pub fn standing_wave(depth: f64, length: f64, amplitude: f64, dx: f64, viscosity: f64, top: f64) -> Wave {
    let mut fluid = FluidOptions::new(2, dx, 0.5, 9810.0 * depth);
    fluid.sound_speed = 20.0 * (9.81 * depth).sqrt();
    fluid.viscosity = Viscosity::Dynamic(viscosity);
    let boundaries = tank([0.0; 3], [length, top, 0.0], &fluid, Slip::Free);
    let k = 2.0 * std::f64::consts::PI / length;
    let frequency = (9.81 * k * (k * depth).tanh()).sqrt();
    let size = amplitude * frequency / (k * depth).sinh();
    let velocity =
        |x: [f64; 3]| [-size * (k * x[1]).cosh() * (k * x[0]).sin(), size * (k * x[1]).sinh() * (k * x[0]).cos(), 0.0];
    let block = Shape::Box { low: [0.0; 3], high: [length, depth, 0.0] };
    let state = state(&[block], &fluid, velocity, |x| 9810.0 * (depth - x[1]));
    Wave { flow: Flow::new(fluid, boundaries), state, k, frequency }
}

/// Whether a relative error is still the one that the documentation quotes: to a quarter of it, and to 0.3 % where it is small.
pub fn as_recorded(found: f64, recorded: f64) -> bool {
    (found - recorded).abs() <= (0.25 * recorded.abs()).max(0.003)
}
