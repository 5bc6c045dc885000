use rayon::prelude::*;

use crate::cluster::{TINY, inverse_root};
use crate::energy::accumulate;
use crate::pair::{PairFactors, slope};
use crate::points::{Kind, Points};
use crate::{Boundaries, FluidOptions, MirrorWall};

/// Particles per task.
const CHUNK: usize = 256;

/// Forces of the fluid on what bounds it; per unit of length along z in two dimensions.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BoundaryForces {
    /// On all mirror walls together.
    pub walls: [f64; 3],
    /// On each body.
    pub bodies: Vec<[f64; 3]>,
}

impl BoundaryForces {
    fn none(bodies: usize) -> Self {
        Self { walls: [0.0; 3], bodies: vec![[0.0; 3]; bodies] }
    }

    fn add(&mut self, other: &Self) {
        let bodies = self.bodies.iter_mut().zip(&other.bodies);
        for (sum, part) in bodies.chain([(&mut self.walls, &other.walls)]) {
            for k in 0..3 {
                sum[k] += part[k];
            }
        }
    }
}

/// Sums the pair forces between fluid particles and ghosts: what Eq. 4 gives them, with the opposite sign and with
/// the slope and the factors of [`Rates`](crate::rates::Rates), so that momentum is accounted for to rounding.
///
/// A ghost of a body beyond a mirror wall stands for the body's part before it: what is across the wall of the force on it is the
/// wall's. Otherwise the water beside a post would press it to the floor, by 0.4 Δx times the pressure there and unit of width.
///
/// Images through periodic faces are fluid. With tensile control `tensile` has the regions, as for the rates.
/// Summed in a fixed order: by particle within tasks of fixed size, then by task.
pub(crate) fn boundary_forces(
    points: &Points,
    fluid: &FluidOptions,
    boundaries: &Boundaries,
    tensile: Option<&[u8]>,
) -> BoundaryForces {
    let bodies = boundaries.bodies.len();
    let pair = PairFactors::new(fluid);
    let of_particle = |i: usize, sum: &mut BoundaryForces| {
        let own = &points.carriers[i];
        let rest = pair.own(own[4], tensile, i);
        let (of_pressure, of_friction) = (pair.pressure(own[4]), pair.friction(own[4]));
        for &j in points.fluid_list.of(i) {
            let j = j as usize;
            if !points.is_solid(j) {
                continue;
            }
            let other = &points.carriers[j];
            let d: [f64; 3] = std::array::from_fn(|k| other[k] - own[k]);
            let s = ((d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) * pair.inverse_square).max(TINY);
            let inverse = inverse_root(s);
            let g = slope(s, inverse, other[3]);
            if g <= 0.0 {
                continue;
            }
            let (velocity, weight) = if points.needs_viscous {
                let [u, v, w, weight] = points.viscous[j];
                ([u, v, w], weight)
            } else {
                ([other[5], other[6], other[7]], 1.0)
            };
            let approach: f64 = (0..3).map(|k| (velocity[k] - own[5 + k]) * d[k]).sum();
            let acceleration = of_pressure * (other[4] + rest) + of_friction * weight * approach * (inverse * inverse);
            let size = -pair.mass * g * acceleration;
            let force = d.map(|d| size * d);
            let on_body = match points.kind(j) {
                Kind::Body(b) => {
                    let on_body = along_walls(force, [other[0], other[1], other[2]], &boundaries.walls);
                    accumulate(&mut sum.bodies[points.bodies.body[b] as usize], 1.0, on_body);
                    on_body
                }
                _ => [0.0; 3],
            };
            accumulate(&mut sum.walls, 1.0, std::array::from_fn(|k| force[k] - on_body[k]));
        }
    };
    let parts: Vec<BoundaryForces> = points
        .beside
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut sum = BoundaryForces::none(bodies);
            chunk.iter().for_each(|&i| of_particle(i as usize, &mut sum));
            sum
        })
        .collect();
    let mut sum = BoundaryForces::none(bodies);
    parts.iter().for_each(|part| sum.add(part));
    sum
}

/// A vector at a place, without its part across the walls that the place lies behind.
fn along_walls(mut vector: [f64; 3], place: [f64; 3], walls: &[MirrorWall]) -> [f64; 3] {
    for wall in walls.iter().filter(|wall| wall.plane.distance(place) < 0.0) {
        let normal = wall.plane.normal();
        let across: f64 = (0..3).map(|k| vector[k] * normal[k]).sum();
        accumulate(&mut vector, -across, normal);
    }
    vector
}
