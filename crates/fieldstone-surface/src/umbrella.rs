//! The umbrella-shaped region along a particle's normal, in which no neighbour may be.

use std::f64::consts::SQRT_2;

use glam::DVec3;

use crate::neighbourhood::Neighbourhood;

/// Whether the region along the unit normal `n` is empty.
///
/// With T = x_i + h n, a neighbour is inside where |x_ji| ≥ √2 h and |x_jT| < h, or where |x_ji| < √2 h and, in three
/// dimensions, its direction is within 45° of n; in two, |n·x_jT| + |τ·x_jT| < h.
///
/// Source: `marrone2010`.
#[inline(always)]
pub(crate) fn is_empty(hood: &Neighbourhood, n: DVec3, h: f64, dimension: usize) -> bool {
    let tip = h * n;
    let tangent = DVec3::new(-n.y, n.x, 0.0);
    for k in 0..hood.len {
        let x = DVec3::new(hood.x[k], hood.y[k], hood.z[k]);
        let from_tip = x - tip;
        let inside = if hood.squared[k] >= 2.0 * h * h {
            from_tip.length_squared() < h * h
        } else if dimension == 2 {
            n.dot(from_tip).abs() + tangent.dot(from_tip).abs() < h
        } else {
            // cos 45° = √2/2; equality is not inside.
            n.dot(x) * SQRT_2 > hood.squared[k].sqrt()
        };
        if inside {
            return false;
        }
    }
    true
}
