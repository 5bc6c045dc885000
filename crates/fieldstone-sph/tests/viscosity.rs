//! The viscous term in a flow with a closed form.
#![allow(clippy::unwrap_used)]

mod common;

use common::{long, run, state, tank};
use fieldstone_sph::{Flow, FluidOptions, Shape, Slip, Solver, Viscosity};

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
