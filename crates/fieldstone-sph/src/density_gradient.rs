use glam::{DMat3, DVec3};

use crate::FluidOptions;
use crate::cluster::{BLOCK, Distances, LANES, Receivers, improved};
use crate::neighbour_list::PairSum;
use crate::pair::slope;
use crate::points::Carrier;

/// Sum of a diagonal below which a particle counts as alone.
const ALONE: f64 = 1e-3;

/// det M over the cube (square) of a third (half) of its trace below which M counts as singular: neighbours in a
/// plane, on a line, or none.
const SINGULAR: f64 = 0.02;

/// Corrected density gradient.
///
/// $$ \langle\nabla\rho\rangle_i^L = L_i \sum_j (\rho_j - \rho_i)\,\nabla_i W_{ij} V_j, \qquad
///    L_i = \Big[\sum_j (x_j - x_i)\otimes\nabla_i W_{ij} V_j\Big]^{-1} $$
///
/// The fourth number is 1 where M is singular (spray, sheets) and the gradient therefore 0.
///
/// Source: `liu2022`, Eq. 6.
pub(crate) struct DensityGradient<'a> {
    carriers: &'a [Carrier],
    /// 1/h².
    inverse_square: f64,
    factor: f64,
    dimension: usize,
}

impl<'a> DensityGradient<'a> {
    pub(crate) fn new(fluid: &FluidOptions, carriers: &'a [Carrier]) -> Self {
        let kernel = fluid.kernel();
        Self {
            carriers,
            inverse_square: 1.0 / (fluid.h() * fluid.h()),
            factor: kernel.slope_factor(),
            dimension: fluid.dimension,
        }
    }
}

impl PairSum for DensityGradient<'_> {
    type Output = [f64; 4];

    #[inline(always)]
    fn of(&self, members: &[u32; LANES], list: &[u32]) -> [[f64; 4]; LANES] {
        let zero = [0.0f64; LANES];
        let at = Receivers::of(members, self.carriers);
        let mut ri = zero;
        for l in 0..LANES {
            ri[l] = self.carriers[members[l] as usize][4];
        }
        let (mut xx, mut xy, mut xz, mut yy, mut yz, mut zz) = (zero, zero, zero, zero, zero, zero);
        let (mut xr, mut yr, mut zr) = (zero, zero, zero);
        let mut distances = Distances::ZERO;
        for block in list.chunks(BLOCK) {
            distances.find(&at, self.carriers, block, self.inverse_square);
            for ((&j, squares), guesses) in block.iter().zip(&distances.squares).zip(&distances.guesses) {
                let [x, y, z, v, r, ..] = self.carriers[j as usize];
                for l in 0..LANES {
                    let (dx, dy, dz) = (x - at.x[l], y - at.y[l], z - at.z[l]);
                    let s = squares[l];
                    let g = slope(s, improved(guesses[l], s), v);
                    let (gx, gy, gz) = (g * dx, g * dy, g * dz);
                    let dr = r - ri[l];
                    xx[l] = gx.mul_add(dx, xx[l]);
                    xy[l] = gx.mul_add(dy, xy[l]);
                    xz[l] = gx.mul_add(dz, xz[l]);
                    yy[l] = gy.mul_add(dy, yy[l]);
                    yz[l] = gy.mul_add(dz, yz[l]);
                    zz[l] = gz.mul_add(dz, zz[l]);
                    xr[l] = gx.mul_add(dr, xr[l]);
                    yr[l] = gy.mul_add(dr, yr[l]);
                    zr[l] = gz.mul_add(dr, zr[l]);
                }
            }
        }
        let mut gradients = [[0.0; 4]; LANES];
        for l in 0..LANES {
            let sums = [xx[l], xy[l], xz[l], yy[l], yz[l], zz[l], xr[l], yr[l], zr[l]];
            gradients[l] = corrected(sums.map(|sum| self.factor * sum), self.dimension);
        }
        gradients
    }
}

/// L applied to the plain gradient; zero with a mark where there is no L.
#[inline(always)]
fn corrected(s: [f64; 9], dimension: usize) -> [f64; 4] {
    const NONE: [f64; 4] = [0.0, 0.0, 0.0, 1.0];
    if dimension == 2 {
        let (trace, det) = (s[0] + s[3], s[0] * s[3] - s[1] * s[1]);
        if trace < ALONE || det < SINGULAR * 0.25 * trace * trace {
            return NONE;
        }
        return [(s[3] * s[6] - s[1] * s[7]) / det, (s[0] * s[7] - s[1] * s[6]) / det, 0.0, 0.0];
    }
    let (a, b, c) = (s[3] * s[5] - s[4] * s[4], s[2] * s[4] - s[1] * s[5], s[1] * s[4] - s[2] * s[3]);
    let (d, e, f) = (s[0] * s[5] - s[2] * s[2], s[1] * s[2] - s[0] * s[4], s[0] * s[3] - s[1] * s[1]);
    let (trace, det) = (s[0] + s[3] + s[5], s[0] * a + s[1] * b + s[2] * c);
    if trace < ALONE || det < SINGULAR / 27.0 * trace * trace * trace {
        return NONE;
    }
    [
        (a * s[6] + b * s[7] + c * s[8]) / det,
        (b * s[6] + d * s[7] + e * s[8]) / det,
        (c * s[6] + e * s[7] + f * s[8]) / det,
        0.0,
    ]
}

/// L of a matrix of moments; `None` where it is singular. For sums that are not hot.
pub(crate) fn inverse_of_moments(m: DMat3, dimension: usize) -> Option<DMat3> {
    let mut m = m;
    if dimension == 2 {
        m.z_axis = DVec3::Z * 0.5 * (m.x_axis.x + m.y_axis.y);
    }
    let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
    let bad = trace < ALONE || m.determinant() < SINGULAR / 27.0 * trace.powi(3);
    (!bad).then(|| m.inverse())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_field_has_its_gradient_also_at_the_surface_and_in_two_dimensions() {
        // Only a quarter (an eighth) of the neighbours: without L the gradient would be far off.
        for dimension in [2, 3] {
            let fluid = FluidOptions::new(dimension, 0.1, 1.0, 0.0);
            let mut carriers = Vec::new();
            for i in 0..125 {
                let x = [i % 5, i / 5 % 5, i / 25].map(|k| 0.1 * f64::from(k));
                if dimension == 3 || i < 25 {
                    let density = 1000.0 + 3.0 * x[0] - 2.0 * x[1] + if dimension == 3 { 5.0 * x[2] } else { 0.0 };
                    carriers.push([x[0], x[1], x[2], fluid.spacing.powi(dimension as i32), density, 0.0, 0.0, 0.0]);
                }
            }
            let list: Vec<u32> = (0..carriers.len() as u32).collect();
            let [x, y, z, mark] = DensityGradient::new(&fluid, &carriers).of(&[0; LANES], &list)[0];
            assert!((x - 3.0).abs() < 1e-9 && (y + 2.0).abs() < 1e-9, "{x} {y}");
            assert!((z - if dimension == 3 { 5.0 } else { 0.0 }).abs() < 1e-9 && mark == 0.0);
        }
    }

    #[test]
    fn neighbours_in_a_plane_or_on_a_line_give_zero_and_a_mark_instead_of_noise() {
        let fluid = FluidOptions::new(3, 0.1, 1.0, 0.0);
        for columns in [1, 5] {
            let mut carriers = Vec::new();
            for i in 0..5 * columns {
                let x = [0.1 * f64::from(i % 5), 0.1 * f64::from(i / 5)];
                carriers.push([x[0], x[1], 0.0, 1e-3, 1000.0 + x[0], 0.0, 0.0, 0.0]);
            }
            let list: Vec<u32> = (0..carriers.len() as u32).collect();
            let found = DensityGradient::new(&fluid, &carriers).of(&[0; LANES], &list)[0];
            assert_eq!(found, [0.0, 0.0, 0.0, 1.0]);
        }
    }
}
