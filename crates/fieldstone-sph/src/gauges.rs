use crate::{Boundaries, DirectionName, Flow, FluidOptions, GaugeKind, GaugeSection, Solver, SphError};

/// Names of the columns of a run's table: the flow as a whole, then the gauges; `free_surface` only where a run `detects` it.
///
/// | column | meaning |
/// |---|---|
/// | `time`, `step`, `dt`, `particles`, `free_surface` | |
/// | `kinetic`, `potential`, `compression` | energies |
/// | `viscous`, `diffusive`, `boundaries`, `shifting`, `surface_tension`, `wrapping`, `removed_energy` | the [`Budget`](crate::Budget) |
/// | `residual` | what the budget does not explain |
/// | `removed_mass`, `reflections`, `in_bodies`, `singular` | as in the budget, since the start |
/// | `momentum_x`, … | momentum |
/// | `impulse_walls_x`, …, `impulse_bodies_x`, … | impulses on the fluid since the start |
/// | `momentum_residual_x`, … | what the [`MomentumBudget`](crate::MomentumBudget) does not explain |
pub fn gauge_columns(gauges: &[GaugeSection], detects: bool) -> Vec<String> {
    let mut names: Vec<String> = [
        "time",
        "step",
        "dt",
        "particles",
        "free_surface",
        "kinetic",
        "potential",
        "compression",
        "viscous",
        "diffusive",
        "boundaries",
        "shifting",
        "surface_tension",
        "wrapping",
        "removed_energy",
        "residual",
        "removed_mass",
        "reflections",
        "in_bodies",
        "singular",
        "momentum_x",
        "momentum_y",
        "momentum_z",
    ]
    .map(String::from)
    .to_vec();
    names.retain(|name| detects || name != "free_surface");
    for what in ["impulse_walls", "impulse_bodies", "momentum_residual"] {
        names.extend(["x", "y", "z"].map(|axis| format!("{what}_{axis}")));
    }
    for gauge in gauges {
        if gauge.kind == GaugeKind::Force {
            names.extend(["x", "y", "z"].map(|axis| format!("{}_{axis}", gauge.name)));
        } else {
            names.push(gauge.name.clone());
        }
    }
    names
}

/// A row of the table, in the order of [`gauge_columns`].
///
/// # Errors
/// As [`Solver::boundary_forces`], where a force is measured.
pub fn gauge_row(solver: &mut Solver, gauges: &[GaugeSection]) -> Result<Vec<f64>, SphError> {
    let energies = solver.energies();
    let budget = *solver.budget();
    let mut row = vec![solver.time(), solver.steps() as f64, solver.last_step(), solver.state().len() as f64];
    if solver.detects() {
        row.push(solver.regions().iter().filter(|&&r| r == 0).count() as f64);
    }
    row.extend([
        energies.kinetic,
        energies.potential,
        energies.compression,
        budget.viscous,
        budget.diffusive,
        budget.boundaries,
        budget.shifting,
        budget.surface_tension,
        budget.wrapping,
        budget.removed_energy,
        solver.energy_residual(),
        budget.removed_mass,
        budget.reflections as f64,
        budget.in_bodies as f64,
        budget.singular as f64,
    ]);
    for vector in [energies.momentum, budget.momentum.walls, budget.momentum.bodies, solver.momentum_residual()] {
        row.extend(vector);
    }
    let forces = if gauges.iter().any(|g| g.kind == GaugeKind::Force) { Some(solver.boundary_forces()?) } else { None };
    for gauge in gauges {
        match gauge.kind {
            GaugeKind::Pressure => row.push(pressure_at(solver, gauge.place())),
            GaugeKind::Level => row.push(level_over(solver, gauge.place())),
            GaugeKind::Front => row.push(front(solver, gauge.axis.unwrap_or_default())),
            GaugeKind::Force => {
                let body = gauge.body.unwrap_or(0);
                row.extend(forces.as_ref().and_then(|f| f.bodies.get(body)).copied().unwrap_or_default());
            }
        }
    }
    Ok(row)
}

/// Mean pressure of the fluid within 2h, weighted by the kernel, each particle's pressure carried to the place along
/// gravity; 0 where the kernel's volume is less than a tenth full.
///
/// $$ p(x) = \frac{\sum_j [p_j + \rho_0\,g\cdot(x - x_j)]\,W(x - x_j)\,V_j}{\sum_j W(x - x_j)\,V_j} $$
///
/// Along periodic directions x − x_j is that to the nearest image.
pub fn pressure_at(solver: &Solver, at: [f64; 3]) -> f64 {
    let fluid = &solver.flow().fluid;
    let (kernel, state) = (fluid.kernel(), solver.state());
    let (mut weight, mut sum) = (0.0, 0.0);
    for (x, density) in state.x.iter().zip(&state.density) {
        let d = to_nearest_image(solver, *x, at);
        let squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        if squared < kernel.reach() * kernel.reach() {
            let w = kernel.value_at_square(squared) * fluid.particle_mass() / density;
            let rest: f64 = (0..3).map(|k| fluid.gravity[k] * d[k]).sum();
            weight += w;
            sum += w * (fluid.pressure(*density) + fluid.density * rest);
        }
    }
    if weight > 0.1 { sum / weight } else { 0.0 }
}

/// to − from, of the nearest image where the domain is periodic; 0 along what two dimensions do not have.
fn to_nearest_image(solver: &Solver, from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    let Boundaries { low, high, periodic, .. } = &solver.flow().boundaries;
    std::array::from_fn(|k| {
        let d = to[k] - from[k];
        if k >= solver.flow().fluid.dimension {
            0.0
        } else if periodic[k] {
            d - (high[k] - low[k]) * (d / (high[k] - low[k])).round()
        } else {
            d
        }
    })
}

/// Coordinate of the water's surface over a place: that of the highest particle within a spacing of the line through `at`, and half a
/// spacing; the domain's face below where there is none.
///
/// Up is against the largest component of gravity, where the axis is not periodic; along the last axis without gravity.
pub fn level_over(solver: &Solver, at: [f64; 3]) -> f64 {
    let Flow { fluid, boundaries, .. } = solver.flow();
    let (up, sign) = upwards(fluid, boundaries);
    let near = |x: &&[f64; 3]| {
        let d = to_nearest_image(solver, **x, at);
        (0..3).all(|k| k == up || d[k].abs() <= fluid.spacing)
    };
    let highest = solver.state().x.iter().filter(near).map(|x| sign * x[up]).fold(f64::NEG_INFINITY, f64::max);
    if highest.is_finite() {
        sign * (highest + 0.5 * fluid.spacing)
    } else if sign > 0.0 {
        boundaries.low[up]
    } else {
        boundaries.high[up]
    }
}

/// The axis along which levels are measured, and which way is up on it.
fn upwards(fluid: &FluidOptions, boundaries: &Boundaries) -> (usize, f64) {
    let gravity = boundaries.levelling(fluid.gravity);
    // The last of equal ones.
    let largest = (0..fluid.dimension).max_by(|&a, &b| gravity[a].abs().total_cmp(&gravity[b].abs()));
    let up = largest.unwrap_or(fluid.dimension - 1);
    (up, if gravity[up] > 0.0 { -1.0 } else { 1.0 })
}

/// Coordinate of the particle that is farthest along or against an axis, and half a spacing more; droplets without another particle
/// within 1.5 Δx do not count. Without any particle the domain's face behind.
pub fn front(solver: &Solver, direction: DirectionName) -> f64 {
    let (axis, sign) = (direction.axis(), direction.sign());
    let fluid = &solver.flow().fluid;
    let x = &solver.state().x;
    // Measured the way the front runs.
    let along = |i: usize| sign * x[i][axis];
    let mut order: Vec<usize> = (0..x.len()).collect();
    order.sort_unstable_by(|&a, &b| along(b).total_cmp(&along(a)).then(a.cmp(&b)));
    let reach = 1.5 * fluid.spacing;
    for (rank, &i) in order.iter().enumerate() {
        let close = |j: usize| to_nearest_image(solver, x[j], x[i]).iter().map(|d| d * d).sum::<f64>() <= reach * reach;
        let ahead = order[..rank].iter().rev().take_while(|&&j| along(j) - along(i) <= reach);
        let behind = order[rank + 1..].iter().take_while(|&&j| along(i) - along(j) <= reach);
        if ahead.chain(behind).any(|&j| close(j)) {
            return x[i][axis] + sign * 0.5 * fluid.spacing;
        }
    }
    let boundaries = &solver.flow().boundaries;
    if sign > 0.0 { boundaries.low[axis] } else { boundaries.high[axis] }
}
