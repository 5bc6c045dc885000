use glam::DVec3;

use crate::kernel::Smoothing;
use crate::moments::{Moments, smallest_eigenvalue};
use crate::neighbourhood::Neighbourhood;
use crate::scan::{Visitor, scan};
use crate::{Scene, SurfaceError};

/// Smallest eigenvalue of M below which its inverse would mostly amplify noise.
const ILL_CONDITIONED: f64 = 0.1;

/// Outward unit normals of all candidates, in particle order.
///
/// $$ n_i = -\frac{L_i \sum_j V_j \nabla_i W_{ij}}{\lVert\cdot\rVert}, \qquad
///    L_i^{-1} = M_i = \sum_j V_j\,(x_j - x_i) \otimes \nabla_i W_{ij} $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | n | normal, away from the fluid | – |
/// | W | [`Smoothing`], Wendland C2 with h = 2 Δx in the paper | length^−d |
///
/// Where M is nearly singular (spray, sheets) the plain gradient is used. Zero where it vanishes (no neighbours,
/// symmetric ones) and for particles that are no candidates. Inside the fluid a normal has no meaning.
///
/// Source: `marrone2010`; kernel `liu2022`, Eq. 8.
///
/// # Errors
/// As [`SurfaceDetection::label`](crate::SurfaceDetection::label).
///
/// ```
/// use fieldstone_surface::{Kernel, Smoothing, Surroundings, normals};
/// // The particle in the middle of a block's upper face.
/// let block: Vec<[f64; 3]> = (0..729).map(|i| [i % 9, i / 9 % 9, i / 81].map(f64::from)).collect();
/// let surroundings = Surroundings::new(1.0);
/// let smoothing = Smoothing { kernel: Kernel::WendlandC2, length: 2.0 };
/// let grid = surroundings.grid(&block, smoothing.support())?;
/// let [x, y, z] = normals(&surroundings.scene(&grid), &smoothing)?[8 * 81 + 4 * 9 + 4];
/// assert!(x.abs() < 1e-12 && y.abs() < 1e-12 && (z - 1.0).abs() < 1e-12);
/// # Ok::<(), fieldstone_surface::SurfaceError>(())
/// ```
pub fn normals(scene: &Scene<'_>, smoothing: &Smoothing) -> Result<Vec<[f64; 3]>, SurfaceError> {
    smoothing.validate()?;
    let reach = smoothing.support() * scene.spacing;
    scene.validate("normal", reach)?;
    let visitor = NormalVisitor { moments: Moments::new(smoothing, scene), dimension: scene.grid.dimension() };
    let mut sorted = Vec::new();
    scan(scene, reach, &visitor, &mut sorted);
    Ok(scene.grid.ranks().iter().map(|&rank| sorted[rank as usize]).collect())
}

struct NormalVisitor<'a> {
    moments: Moments<'a>,
    dimension: usize,
}

impl Visitor for NormalVisitor<'_> {
    type Scratch = Vec<f64>;
    type Output = [f64; 3];

    #[inline(always)]
    fn visit(&self, _: usize, hood: &Neighbourhood, weights: &mut Vec<f64>) -> [f64; 3] {
        if hood.len == 0 {
            return [0.0; 3];
        }
        let matrix = self.moments.matrix(hood, weights);
        let outward = -self.moments.gradient(hood, weights);
        // M has no unit, so the gradient's size is that of 1/Δx: rounding of a symmetric sum is far below it.
        let scale: f64 =
            weights.iter().zip(&hood.squared).map(|(w, s)| if *w > 0.0 { w * s.sqrt() } else { 0.0 }).sum();
        if outward.length() <= 1e-12 * scale {
            return [0.0; 3];
        }
        let corrected = if smallest_eigenvalue(&matrix, self.dimension) > ILL_CONDITIONED {
            matrix.inverse() * outward
        } else {
            outward
        };
        let normal: DVec3 = corrected.normalize_or_zero();
        normal.to_array()
    }
}
