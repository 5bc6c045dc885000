//! What the ghosts of bodies take over from the fluid nearby.

use fieldstone_surface::WendlandC2;
use rayon::prelude::*;

use crate::FluidOptions;
use crate::points::{BodyState, Kind, Points};

/// Share of the kernel's volume below which a ghost counts as dry.
const DRY: f64 = 1e-6;

/// Interpolates density and velocity to the bodies' ghosts, and completes the carriers.
///
/// $$ p_g = \frac{\sum_j [p_j + \rho_0\,(g - a)\cdot(x_g - x_j)]\,W_{gj}V_j}{\sum_j W_{gj}V_j} $$
///
/// over fluid particles and their images, with the body's acceleration a across its nearest face: that along the face does not move the
/// fluid, whatever the friction, and would make a pressure where a plate slides through water. A ghost without any has p = 0 and volume 0: it stays out of every sum.
///
/// The velocity in the viscous term is 2U less that of the fluid nearby, so that the mean of both is the body's, U.
///
/// Source: `adami2012`, where a is the whole acceleration.
pub(crate) fn interpolate(points: &mut Points, fluid: &FluidOptions) {
    if points.bodies.x.is_empty() {
        return;
    }
    let kernel = fluid.kernel();
    let stiffness = fluid.density / (fluid.sound_speed * fluid.sound_speed);
    let state: Vec<BodyState> = (0..points.bodies.x.len())
        .into_par_iter()
        .map(|body| {
            let at = points.bodies.x[body];
            let acceleration = points.bodies.acceleration_across(body);
            let rest: [f64; 3] = std::array::from_fn(|k| stiffness * (fluid.gravity[k] - acceleration[k]));
            let (mut weight, mut density, mut velocity) = (0.0, 0.0, [0.0; 3]);
            for_each_fluid(points, &kernel, body, |j, w| {
                let [x, y, z, volume, rho, u, v, s] = points.carriers[j];
                let w = w * volume;
                weight += w;
                density += w * (rho + rest[0] * (at[0] - x) + rest[1] * (at[1] - y) + rest[2] * (at[2] - z));
                velocity = [velocity[0] + w * u, velocity[1] + w * v, velocity[2] + w * s];
            });
            if weight <= DRY {
                return BodyState { density: fluid.density, ..BodyState::default() };
            }
            BodyState {
                density: density / weight,
                velocity: velocity.map(|u| u / weight),
                gradient: [0.0; 3],
                wet: true,
            }
        })
        .collect();
    for (body, state) in state.iter().enumerate() {
        let rank = points.point_of_body(body);
        points.carriers[rank][3] = if state.wet { points.bodies.volume[body] } else { 0.0 };
        points.carriers[rank][4] = state.density;
        if points.needs_viscous {
            let body = points.bodies.pose_of(body).velocity;
            for ((column, u), fluid) in points.viscous[rank].iter_mut().zip(body).zip(state.velocity) {
                *column = 2.0 * u - fluid;
            }
        }
    }
    points.bodies.state = state;
}

/// Interpolates density gradients to the bodies' ghosts, and completes their column.
pub(crate) fn interpolate_gradients(points: &mut Points, fluid: &FluidOptions) {
    if points.bodies.x.is_empty() {
        return;
    }
    let kernel = fluid.kernel();
    let gradients: Vec<[f64; 3]> = (0..points.bodies.x.len())
        .into_par_iter()
        .map(|body| {
            let (mut weight, mut sum) = (0.0, [0.0; 3]);
            for_each_fluid(points, &kernel, body, |j, w| {
                let w = w * points.carriers[j][3];
                weight += w;
                sum = std::array::from_fn(|k| sum[k] + w * points.gradients[j][k]);
            });
            if weight <= DRY { [0.0; 3] } else { sum.map(|g| g / weight) }
        })
        .collect();
    for (body, gradient) in gradients.into_iter().enumerate() {
        let rank = points.point_of_body(body);
        points.gradients[rank] = [gradient[0], gradient[1], gradient[2], 0.0];
        points.bodies.state[body].gradient = gradient;
    }
}

/// Fluid particles and images around a body's ghost, with their kernel values; padding has none.
fn for_each_fluid(points: &Points, kernel: &WendlandC2, body: usize, mut visit: impl FnMut(usize, f64)) {
    let at = points.bodies.x[body];
    for &j in points.body_list.of(body) {
        let j = j as usize;
        if matches!(points.kind(j), Kind::Body(_)) {
            continue;
        }
        let carrier = &points.carriers[j];
        let squared = (0..3).map(|k| (carrier[k] - at[k]).powi(2)).sum::<f64>();
        let w = kernel.value_at_square(squared);
        if w > 0.0 {
            visit(j, w);
        }
    }
}
