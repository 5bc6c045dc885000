//! The viscous term in a flow with a closed form.
#![allow(clippy::unwrap_used)]

mod common;

use std::f64::consts::PI;

use common::{alone, long, run, state, tank};
use fieldstone_sph::{
    Boundaries, Case, Flow, FluidOptions, Integrator, SHIPPED, Shape, Slip, Solver, State, Viscosity,
};

/// The most of the parabola between two walls, over the exact one; the mean of its fit to all particles.
fn poiseuille(layers: usize, smoothing: f64) -> f64 {
    let (density, viscosity) = (1.0, 0.1);
    let mut fluid = FluidOptions::new(2, 1.0 / layers as f64, 1.0, 0.0);
    (fluid.density, fluid.smoothing, fluid.sound_speed) = (density, smoothing, 10.0);
    fluid.viscosity = Viscosity::Dynamic(viscosity);
    // The exact flow is as fast as 1 in the middle.
    fluid.gravity = [8.0 * viscosity / density, 0.0, 0.0];
    let mut boundaries = tank([0.0; 3], [0.5, 1.0, 0.0], &fluid, Slip::No);
    boundaries.walls.retain(|wall| wall.plane.normal()[0] == 0.0);
    boundaries.walls.push(fieldstone_sph::MirrorWall {
        plane: fieldstone_surface::Wall::new([0.0, -1.0, 0.0], -1.0).unwrap(),
        slip: Slip::No,
    });
    (boundaries.open[1][1], boundaries.periodic[0]) = (false, true);
    let exact = |x: [f64; 3]| 4.0 * x[1] * (1.0 - x[1]);
    let channel = Shape::Box { low: [0.0; 3], high: [0.5, 1.0, 0.0] };
    let state = state(&[channel], &fluid, |x| [exact(x), 0.0, 0.0], |_| 0.0);
    let mut solver = Solver::new(Flow::new(fluid, boundaries), state).unwrap();
    // What it differs by at the start has decayed to e⁻⁴.
    run(&mut solver, 4.0);
    let s = solver.state();
    let (product, square) =
        s.x.iter().zip(&s.u).fold((0.0, 0.0), |(p, q), (x, u)| (p + u[0] * exact(*x), q + exact(*x).powi(2)));
    product / square
}

#[test]
fn flow_between_walls_is_faster_by_what_the_viscous_sum_lacks() {
    // Eq. 7 for u = y²/2, summed over a square lattice whose rows stand anywhere to each other, is this share of μ, at any spacing.
    for (smoothing, share) in [(1.3, 0.8660), (1.5, 0.9193), (2.0, 0.9718)] {
        for &layers in if long() { &[20, 40][..] } else { &[20] } {
            let found = poiseuille(layers, smoothing);
            println!("Poiseuille, h/Δx = {smoothing}, H/Δx = {layers}: {found:.4} of {:.4}", 1.0 / share);
            assert!((found * share - 1.0).abs() < 0.01, "{found} of {}", 1.0 / share);
        }
    }
}

/// A periodic square or cube of `count` particles along each edge, at rest but for a velocity, with nothing but viscosity.
fn viscous_lattice(
    (dimension, count, smoothing): (usize, usize, f64),
    viscosity: f64,
    velocity: impl Fn([f64; 3]) -> [f64; 3],
) -> Solver {
    let edge: [f64; 3] = std::array::from_fn(|k| if k < dimension { count as f64 } else { 0.0 });
    let mut fluid = FluidOptions::new(dimension, 1.0, 1.0, 0.0);
    (fluid.density, fluid.smoothing, fluid.gravity) = (1.0, smoothing, [0.0; 3]);
    fluid.viscosity = Viscosity::Dynamic(viscosity);
    let mut boundaries = Boundaries::new([0.0; 3], edge, 1.0);
    boundaries.periodic = std::array::from_fn(|k| k < dimension);
    let state = state(&[Shape::Box { low: [0.0; 3], high: edge }], &fluid, velocity, |_| 0.0);
    Solver::new(Flow::new(fluid, boundaries), state).unwrap()
}

/// Decay −(u·Du/Dt)/(u·u) of a velocity at the start, over ν/h².
fn decay(of: (usize, usize, f64), velocity: impl Fn([f64; 3]) -> [f64; 3]) -> f64 {
    let mut solver = viscous_lattice(of, 0.3, velocity);
    let rates = alone(|| solver.accelerations().unwrap());
    let (product, square) = solver.state().u.iter().zip(&rates).fold((0.0, 0.0), |(p, q), (u, a)| {
        (p - (0..3).map(|k| u[k] * a[k]).sum::<f64>(), q + u.iter().map(|u| u * u).sum::<f64>())
    });
    product / square * of.2 * of.2 / 0.3
}

#[test]
fn no_velocity_decays_faster_than_the_largest_eigenvalue_and_layers_against_each_other_do_as_fast() {
    for of in [(2, 12, 1.3), (2, 12, 1.5), (2, 40, 2.0), (3, 8, 1.3), (3, 20, 2.0)] {
        let (dimension, count, smoothing) = of;
        let mut fluid = FluidOptions::new(dimension, 1.0, 1.0, 0.0);
        fluid.smoothing = smoothing;
        let largest = fluid.viscous_eigenvalue();
        // All that repeat within the length, along an edge, with the velocity along it.
        let waves = (1..=count / 2).map(|m| 2.0 * PI * m as f64 / count as f64);
        let found = waves.map(|k| decay(of, |x| [(k * (x[0] - 0.5)).cos(), 0.0, 0.0])).fold(0.0, f64::max);
        println!("d = {dimension}, h/Δx = {smoothing}: {found:.4} of {largest:.4}");
        assert!(found <= largest * (1.0 + 1e-4), "{found} of {largest}");
        // Wave numbers of a finite box miss the worst by a little, but not where layers alternate.
        assert!(found >= largest * if smoothing < 1.7 { 1.0 - 1e-4 } else { 0.99 }, "{found} of {largest}");
        // Waves at any angle to the lattice, with the velocity at any angle to them.
        for turn in 0..24u32 {
            let part = |n: u32| f64::from((turn * n + 3) % 7) - 2.9;
            let wave = |n: u32| 2.0 * PI * f64::from((turn * n + 5) % count as u32) / count as f64;
            let (k, u) = ([wave(3), wave(5), wave(11)], [part(2), part(3), if dimension == 3 { part(5) } else { 0.0 }]);
            let velocity = |x: [f64; 3]| u.map(|u| u * ((0..dimension).map(|a| k[a] * x[a]).sum::<f64>() + 0.7).cos());
            let found = decay(of, velocity);
            assert!(found <= largest * (1.0 + 1e-4), "{k:?} {u:?}: {found} of {largest}");
        }
    }
}

#[test]
fn the_documentation_says_how_fast_the_fastest_decay_is() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/sph.md")).unwrap();
    let mut rows = 0;
    for line in text
        .lines()
        .skip_while(|line| !line.contains("λ h²/ν in two dimensions"))
        .skip(2)
        .take_while(|l| l.starts_with('|'))
    {
        let numbers: Vec<f64> = line.split('|').filter_map(|word| word.trim().parse().ok()).collect();
        let [smoothing, plane, symplectic, runge_kutta, space, symplectic_space, runge_kutta_space] = numbers[..]
        else {
            panic!("{line}")
        };
        for (dimension, eigenvalue, limits) in
            [(2, plane, [symplectic, runge_kutta]), (3, space, [symplectic_space, runge_kutta_space])]
        {
            let mut fluid = FluidOptions::new(dimension, 0.1, 1.0, 0.0);
            fluid.smoothing = smoothing;
            let found = fluid.viscous_eigenvalue();
            assert!((found - eigenvalue).abs() < 0.006, "{line}: {found}");
            for (integrator, limit) in [Integrator::Symplectic, Integrator::RungeKutta4].into_iter().zip(limits) {
                assert!((integrator.viscous_limit(&fluid) - limit).abs() < 6e-5, "{line}");
            }
        }
        rows += 1;
    }
    assert_eq!(rows, 6);
}

/// Kinetic energy after steps over that before, and the most of it in between.
fn left_after(mut solver: Solver, steps: usize) -> (f64, f64) {
    alone(|| {
        let start = solver.energies().kinetic;
        let mut most = 0.0f64;
        for _ in 0..steps {
            solver.step().unwrap();
            most = most.max(solver.energies().kinetic);
        }
        (solver.energies().kinetic / start, most / start)
    })
}

/// A velocity that differs from particle to particle, without a pattern.
fn scattered(x: [f64; 3]) -> [f64; 3] {
    let sum = 12.9898 * x[0] + 78.233 * x[1] + 37.719 * x[2];
    [1.0, 2.0, 3.0].map(|n: f64| ((sum * n).sin() * 43758.5453).fract() * 0.1)
}

/// The same without its part along z.
fn scattered_in_plane(x: [f64; 3]) -> [f64; 3] {
    let [u, v, _] = scattered(x);
    [u, v, 0.0]
}

#[test]
fn a_viscous_fluid_comes_to_rest_with_both_integrators() {
    for integrator in [Integrator::Symplectic, Integrator::RungeKutta4] {
        // ν is 500 h c₀ and more: viscosity bounds the step.
        for of in [(2, 10, 1.3), (2, 10, 2.0), (3, 8, 1.3), (3, 8, 1.5)] {
            let still = |factor: Option<f64>| {
                let velocity =
                    |x: [f64; 3]| if of.0 == 2 { [scattered(x)[0], scattered(x)[1], 0.0] } else { scattered(x) };
                let mut solver = viscous_lattice(of, 1e4, velocity);
                let mut flow = solver.flow().clone();
                (flow.time_step.integrator, flow.time_step.viscous) = (integrator, factor);
                solver = Solver::new(flow, solver.state().clone()).unwrap();
                left_after(solver, 150)
            };
            // By the limit itself, too: what is refused begins where it ends.
            let mut fluid = FluidOptions::new(of.0, 1.0, 1.0, 0.0);
            fluid.smoothing = of.2;
            for factor in [None, Some(0.99 * integrator.viscous_limit(&fluid))] {
                let (left, most) = still(factor);
                println!("{integrator:?} {of:?} {factor:?}: {left:.3e}");
                assert!(left < 0.1 && most <= 1.0, "{integrator:?} {of:?} {factor:?}: {left} {most}");
            }
        }
    }
}

#[test]
fn a_viscous_fluid_between_walls_comes_to_rest_with_both_integrators() {
    for (integrator, slip, smoothing) in [
        (Integrator::Symplectic, Slip::No, 2.0),
        (Integrator::Symplectic, Slip::Free, 2.0),
        (Integrator::Symplectic, Slip::No, 1.3),
        (Integrator::RungeKutta4, Slip::No, 2.0),
    ] {
        let mut fluid = FluidOptions::new(2, 0.05, 1.0, 0.0);
        (fluid.smoothing, fluid.gravity, fluid.viscosity) = (smoothing, [0.0; 3], Viscosity::Dynamic(1e4));
        let block = Shape::Box { low: [0.0; 3], high: [0.5, 0.5, 0.0] };
        let state = state(&[block], &fluid, scattered_in_plane, |_| 0.0);
        let mut flow = Flow::new(fluid, tank([0.0; 3], [0.5, 1.0, 0.0], &fluid, slip));
        flow.time_step.integrator = integrator;
        let (left, most) = left_after(Solver::new(flow, state).unwrap(), 300);
        println!("{integrator:?} {slip:?} {smoothing}: {left:.3e}");
        assert!(left < 0.1 && most <= 1.0, "{integrator:?} {slip:?} {smoothing}: {left} {most}");
    }
}

#[test]
fn a_viscous_factor_beyond_the_stable_one_is_refused_with_it() {
    let text = SHIPPED.iter().find(|case| case.name == "taylor-green").unwrap().text;
    let with = |keys: &str| Case::parse(&text.replace("end = 1.0", &format!("end = 1.0\n{keys}")), "vortices.toml");
    let error = with("viscous = 0.125").unwrap_err().to_string();
    assert!(
        error.starts_with("vortices.toml:20: the viscous factor of the time step is 0.125; it must be at most 0.1165"),
        "{error}"
    );
    assert!(error.contains("leave it out for 0.0757"), "{error}");
    assert!(with("viscous = 0.116").is_ok() && with("viscous = 0.125\nintegrator = \"rk4\"").is_ok());
    let error = with("viscous = 0.17\nintegrator = \"rk4\"").unwrap_err().to_string();
    assert!(error.contains("at most 0.1622"), "{error}");
    assert!(with("viscous = -1").unwrap_err().to_string().contains("finite and above 0"));
    let error = with("cfl = 2.2").unwrap_err().to_string();
    assert!(error.contains("the CFL number is 2.2; it must be above 0 and at most 2.1"), "{error}");
    assert!(with("cfl = 2.2\nintegrator = \"rk4\"").is_ok());
}

/// Largest eigenvalue over ν/h² of the viscous sum for particles at rest under no pressure, by power iteration.
fn largest_decay(flow: &Flow, mut state: State) -> f64 {
    let fluid = &flow.fluid;
    let scale = fluid.h() * fluid.h() * fluid.density / fluid.dynamic_viscosity();
    let mut found = 0.0;
    for _ in 0..200 {
        let mut solver = Solver::new(flow.clone(), state).unwrap();
        let rates = alone(|| solver.accelerations().unwrap());
        let size = |all: &[[f64; 3]]| all.as_flattened().iter().map(|u| u * u).sum::<f64>().sqrt();
        found = size(&rates) / size(&solver.state().u) * scale;
        state = solver.state().clone();
        let length = size(&rates);
        state.u = rates.iter().map(|rate| rate.map(|a| 0.1 * a / length)).collect();
    }
    found
}

#[test]
fn the_margin_is_wide_enough_for_particles_off_the_lattice_and_walls_need_none() {
    let share = |fluid: &FluidOptions| Integrator::Symplectic.viscous_default(fluid) * fluid.viscous_eigenvalue() / 2.0;
    // What the documentation says that the largest eigenvalue rises by.
    for (smoothing, off, said) in
        [(1.0, 0.2, 0.43), (1.3, 0.2, 0.13), (1.3, 0.3, 0.32), (2.0, 0.2, 0.08), (2.0, 0.3, 0.14)]
    {
        let solver = viscous_lattice((2, 24, smoothing), 1.0, scattered_in_plane);
        let mut state = solver.state().clone();
        for (x, by) in state.x.iter_mut().zip(&solver.state().u) {
            (x[0], x[1]) = (x[0] + 10.0 * off * by[0], x[1] + 10.0 * off * by[1]);
        }
        let fluid = &solver.flow().fluid;
        let rise = largest_decay(solver.flow(), state) / fluid.viscous_eigenvalue() - 1.0;
        println!("h/Δx = {smoothing}, off by {off} Δx: {:+.1} %", 100.0 * rise);
        assert!((rise - said).abs() < 0.01 && (1.0 + rise) * share(fluid) < 1.0, "{smoothing}, {off}: {rise}");
    }
    for (smoothing, slip) in [(1.3, Slip::No), (2.0, Slip::No), (2.0, Slip::Free)] {
        let mut fluid = FluidOptions::new(2, 0.05, 1.0, 0.0);
        (fluid.smoothing, fluid.gravity, fluid.viscosity) = (smoothing, [0.0; 3], Viscosity::Dynamic(1.0));
        let block = Shape::Box { low: [0.0; 3], high: [1.0, 1.0, 0.0] };
        let state = state(&[block], &fluid, scattered_in_plane, |_| 0.0);
        let flow = Flow::new(fluid, tank([0.0; 3], [1.0, 2.0, 0.0], &fluid, slip));
        let found = largest_decay(&flow, state);
        assert!(found <= fluid.viscous_eigenvalue(), "{smoothing}, {slip:?}: {found}");
    }
}
