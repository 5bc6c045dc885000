use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::FluidOptions;
use crate::density_gradient::inverse_of_moments;
use crate::points::{Kind, Points};
use crate::rates::Rate;

/// |∇c| h above which a normal is reliable; at a flat surface it is 0.66 in two and in three dimensions.
const RELIABLE: f64 = 0.1;

/// Continuum surface force.
///
/// $$ f_i = -\sigma\,\kappa_i\,\hat n_i\;2\,|\nabla c|_i, \qquad \nabla c_i = \sum_j V_j\nabla_iW_{ij}, \qquad
///    \hat n_i = -\frac{L_i\nabla c_i}{|L_i\nabla c_i|}, \qquad
///    \kappa_i = \sum_j V_j(\hat n_j - \hat n_i)\cdot L'_i\nabla_iW_{ij} $$
///
/// Kernels see the fluid's side of the surface only, which is half of the delta function |∇c|: hence the 2. κ is
/// summed, and its L′ made, over neighbours with a reliable normal.
///
/// Source: `brackbill1992`; corrected gradients `liu2022`, Eq. 6.
#[derive(Debug, Default)]
pub(crate) struct SurfaceTension {
    /// Normal and |∇c| of each fluid particle.
    normals: Vec<[f64; 4]>,
}

impl SurfaceTension {
    /// Adds the accelerations; returns their power and the force on the fluid as a whole.
    pub(crate) fn add(&mut self, fluid: &FluidOptions, points: &Points, rates: &mut [Rate]) -> (f64, [f64; 3]) {
        (0..rates.len()).into_par_iter().map(|i| normal(fluid, points, i)).collect_into_vec(&mut self.normals);
        let normals = &self.normals;
        let mass = fluid.particle_mass();
        let each: Vec<[f64; 4]> = rates
            .par_iter_mut()
            .enumerate()
            .map(|(i, rate)| {
                let [nx, ny, nz, delta] = normals[i];
                if delta == 0.0 {
                    return [0.0; 4];
                }
                let own = &points.carriers[i];
                let size = -fluid.surface_tension * curvature(fluid, points, normals, i) * 2.0 * delta / own[4];
                let mut found = [0.0; 4];
                for (k, n) in [nx, ny, nz].into_iter().enumerate() {
                    rate.acceleration[k] += size * n;
                    found[k] = mass * size * n;
                    found[3] += found[k] * own[5 + k];
                }
                found
            })
            .collect();
        let sum = each.iter().fold([0.0; 4], |sum: [f64; 4], one| std::array::from_fn(|k| sum[k] + one[k]));
        (sum[3], [sum[0], sum[1], sum[2]])
    }
}

/// Outward normal and |∇c|; zero where it is not reliable.
fn normal(fluid: &FluidOptions, points: &Points, i: usize) -> [f64; 4] {
    let (mut gradient, mut moments) = (DVec3::ZERO, DMat3::ZERO);
    for_each_neighbour(fluid, points, i, |_, d, weight| {
        gradient += weight * d;
        moments += DMat3::from_cols(d * d.x, d * d.y, d * d.z) * weight;
    });
    let delta = gradient.length();
    if delta * fluid.h() < RELIABLE {
        return [0.0; 4];
    }
    let corrected = inverse_of_moments(moments, fluid.dimension).map_or(gradient, |l| l * gradient);
    let n = -corrected.normalize_or_zero();
    [n.x, n.y, n.z, delta]
}

fn curvature(fluid: &FluidOptions, points: &Points, normals: &[[f64; 4]], i: usize) -> f64 {
    let own = DVec3::new(normals[i][0], normals[i][1], normals[i][2]);
    let (mut slopes, mut moments) = (DMat3::ZERO, DMat3::ZERO);
    for_each_neighbour(fluid, points, i, |j, d, weight| {
        let n = match points.kind(j) {
            Kind::Fluid(k) => normals[k],
            Kind::Body(_) => return,
            Kind::Image(image) => {
                let (source, transform) = points.ghosts.images[image];
                let [x, y, z, delta] = normals[source as usize];
                let [x, y, z] = points.ghosts.transform(transform).velocity([x, y, z]);
                [x, y, z, delta]
            }
        };
        if n[3] > 0.0 {
            let difference = DVec3::new(n[0], n[1], n[2]) - own;
            // Columns: derivatives of n along x, y, z, before L′.
            slopes += DMat3::from_cols(difference * d.x, difference * d.y, difference * d.z) * weight;
            moments += DMat3::from_cols(d * d.x, d * d.y, d * d.z) * weight;
        }
    });
    let Some(l) = inverse_of_moments(moments, fluid.dimension) else { return 0.0 };
    let corrected = slopes * l;
    corrected.x_axis.x + corrected.y_axis.y + corrected.z_axis.z
}

/// Neighbours of a fluid particle: index, x_j − x_i, and V_j g with ∇ᵢW = g (x_j − x_i).
fn for_each_neighbour(fluid: &FluidOptions, points: &Points, i: usize, mut visit: impl FnMut(usize, DVec3, f64)) {
    let kernel = fluid.kernel();
    let own = &points.carriers[i];
    for &j in points.fluid_list.of(i) {
        let other = &points.carriers[j as usize];
        let d = DVec3::new(other[0] - own[0], other[1] - own[1], other[2] - own[2]);
        let g = kernel.slope(d.length());
        if g > 0.0 {
            visit(j as usize, d, g * other[3]);
        }
    }
}
