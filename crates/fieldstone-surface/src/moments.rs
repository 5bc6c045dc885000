//! Kernel sums over a neighbourhood: position divergence, gradient, renormalisation matrix.

use glam::{DMat3, DVec3};

use crate::Scene;
use crate::kernel::{Slope, Smoothing};
use crate::neighbourhood::{LANES, Neighbourhood};

/// Sums of one kernel over the particles of a scene.
pub(crate) struct Moments<'a> {
    slope: Slope,
    dimension: usize,
    uniform: f64,
    volumes: Option<&'a [f64]>,
    sources: &'a [u32],
}

impl<'a> Moments<'a> {
    pub(crate) fn new(smoothing: &Smoothing, scene: &Scene<'a>) -> Self {
        let dimension = scene.grid.dimension();
        Self {
            slope: smoothing.slope(scene.spacing, dimension),
            dimension,
            uniform: scene.spacing.powi(dimension as i32),
            volumes: scene.volumes,
            sources: scene.grid.sources(),
        }
    }

    /// V_j g(r_ij) of every neighbour, up to the padded length.
    #[inline(always)]
    fn weigh(&self, hood: &Neighbourhood, weights: &mut Vec<f64>) {
        let count = hood.padded_len();
        weights.resize(count, 0.0);
        self.slope.fill(&hood.squared[..count], &mut weights[..count]);
        match self.volumes {
            None => weights.iter_mut().for_each(|w| *w *= self.uniform),
            Some(volumes) => {
                for (w, &sorted) in weights.iter_mut().zip(&hood.sorted[..hood.len]) {
                    *w *= volumes[self.sources[sorted as usize] as usize];
                }
            }
        }
        // The padding's distance is enormous, where both kernels vanish.
    }

    /// λ = Σ V_j (x_j − x_i)·∇ᵢW.
    #[inline(always)]
    pub(crate) fn divergence(&self, hood: &Neighbourhood, weights: &mut Vec<f64>) -> f64 {
        self.weigh(hood, weights);
        let mut sums = [0.0f64; LANES];
        let squared = &hood.squared[..weights.len()];
        for (w, s) in weights.chunks_exact(LANES).zip(squared.chunks_exact(LANES)) {
            for l in 0..LANES {
                // Outside the support 0 · MAX is 0.
                sums[l] += w[l] * s[l];
            }
        }
        sums.into_iter().sum()
    }

    /// Σ V_j ∇ᵢW, which points inwards, by the weights of the last sum.
    #[inline(always)]
    pub(crate) fn gradient(&self, hood: &Neighbourhood, weights: &[f64]) -> DVec3 {
        let mut sums = [[0.0f64; LANES]; 3];
        let n = weights.len();
        let lanes = weights
            .chunks_exact(LANES)
            .zip(hood.x[..n].chunks_exact(LANES))
            .zip(hood.y[..n].chunks_exact(LANES))
            .zip(hood.z[..n].chunks_exact(LANES));
        for (((w, x), y), z) in lanes {
            for l in 0..LANES {
                sums[0][l] += w[l] * x[l];
                sums[1][l] += w[l] * y[l];
                sums[2][l] += w[l] * z[l];
            }
        }
        DVec3::from_array(sums.map(|s| s.into_iter().sum()))
    }

    /// M = Σ V_j (x_j − x_i) ⊗ ∇ᵢW, symmetric; in two dimensions its zz entry is 1.
    #[inline(always)]
    pub(crate) fn matrix(&self, hood: &Neighbourhood, weights: &mut Vec<f64>) -> DMat3 {
        self.weigh(hood, weights);
        let mut sums = [[0.0f64; LANES]; 6];
        let n = weights.len();
        let lanes = weights
            .chunks_exact(LANES)
            .zip(hood.x[..n].chunks_exact(LANES))
            .zip(hood.y[..n].chunks_exact(LANES))
            .zip(hood.z[..n].chunks_exact(LANES));
        for (((w, x), y), z) in lanes {
            for l in 0..LANES {
                let (wx, wy, wz) = (w[l] * x[l], w[l] * y[l], w[l] * z[l]);
                sums[0][l] += wx * x[l];
                sums[1][l] += wy * y[l];
                sums[2][l] += wz * z[l];
                sums[3][l] += wx * y[l];
                sums[4][l] += wx * z[l];
                sums[5][l] += wy * z[l];
            }
        }
        let [xx, yy, zz, xy, xz, yz] = sums.map(|s| s.into_iter().sum::<f64>());
        let zz = if self.dimension == 2 { 1.0 } else { zz };
        DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
    }
}

/// Smallest eigenvalue of a symmetric matrix; of its upper left 2 × 2 block in two dimensions.
///
/// Cyclic Jacobi rotations: exact to rounding also where eigenvalues coincide, as on every lattice.
pub(crate) fn smallest_eigenvalue(m: &DMat3, dimension: usize) -> f64 {
    let mut a = m.to_cols_array_2d();
    let pairs: &[(usize, usize)] = if dimension == 2 { &[(0, 1)] } else { &[(0, 1), (0, 2), (1, 2)] };
    for _ in 0..20 {
        let off: f64 = pairs.iter().map(|&(p, q)| a[p][q].abs()).sum();
        let diagonal: f64 = (0..dimension).map(|k| a[k][k].abs()).sum();
        if off <= 1e-15 * diagonal {
            break;
        }
        for &(p, q) in pairs {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            let turn = |(x, y): (f64, f64)| (c * x - s * y, s * x + c * y);
            for row in &mut a {
                (row[p], row[q]) = turn((row[p], row[q]));
            }
            let (first, second) = (a[p], a[q]);
            for (k, pair) in first.into_iter().zip(second).enumerate() {
                (a[p][k], a[q][k]) = turn(pair);
            }
        }
    }
    (0..dimension).map(|k| a[k][k]).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use fieldstone_testing::Random;

    use super::*;

    #[test]
    fn the_smallest_eigenvalue_is_a_root_of_the_characteristic_polynomial() {
        let mut random = Random(5);
        for _ in 0..200 {
            let [xx, yy, zz, xy, xz, yz] = std::array::from_fn(|_| random.uniform(-1.0, 1.0));
            let m = DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz));
            let least = smallest_eigenvalue(&m, 3);
            let shifted = m - DMat3::from_diagonal(DVec3::splat(least));
            assert!(shifted.determinant().abs() < 1e-13);
            // Below the smallest eigenvalue all leading minors are positive.
            let below = m - DMat3::from_diagonal(DVec3::splat(least - 1e-6));
            assert!(below.x_axis.x > 0.0 && below.x_axis.x * below.y_axis.y - below.x_axis.y.powi(2) > 0.0);
            assert!(below.determinant() > 0.0);
        }
        let repeated = DMat3::from_diagonal(DVec3::new(0.5, 0.5, 0.2));
        assert_eq!(smallest_eigenvalue(&repeated, 3), 0.2);
        assert_eq!(smallest_eigenvalue(&repeated, 2), 0.5);
    }
}
