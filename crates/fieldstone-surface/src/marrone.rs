use crate::detection::{Judge, check};
use crate::kernel::{Kernel, Smoothing};
use crate::moments::{Moments, smallest_eigenvalue};
use crate::neighbourhood::Neighbourhood;
use crate::{Detection, Scene, SurfaceDetection, SurfaceError, umbrella};

/// Marrone's method: the smallest eigenvalue of the renormalisation matrix, then an umbrella along the normal.
///
/// $$ M_i = \sum_j V_j\,(x_j - x_i) \otimes \nabla_i W_{ij}, \qquad
///    n_i = -\frac{L_i \sum_j V_j \nabla_i W_{ij}}{\lVert\cdot\rVert}, \quad L_i = M_i^{-1} $$
///
/// | symbol | meaning | default |
/// |---|---|---|
/// | λ_min(M) | below `free` a free-surface particle, above `inner` an inner one | 0.20, 0.75 |
/// | W, h | [`Smoothing`] | improved Gaussian, h = 1.33 Δx |
///
/// In between, the particle is free if no neighbour is in the umbrella along n. Depends on the normal, so particles in
/// concave or disordered places are missed.
///
/// Source: `marrone2010`; `liu2022`, Sec. 4.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marrone {
    /// Kernel and smoothing length.
    pub smoothing: Smoothing,
    /// Eigenvalue below which a particle is on the free surface.
    pub free: f64,
    /// Eigenvalue above which a particle is an inner one.
    pub inner: f64,
}

impl Default for Marrone {
    fn default() -> Self {
        Self { smoothing: Smoothing { kernel: Kernel::ImprovedGaussian, length: 1.33 }, free: 0.20, inner: 0.75 }
    }
}

impl Marrone {
    pub(crate) const NAME: &'static str = "marrone";
}

impl SurfaceDetection for Marrone {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn reach(&self, spacing: f64) -> f64 {
        self.smoothing.support() * spacing
    }

    fn label(&self, scene: &Scene<'_>, detection: &mut Detection) -> Result<(), SurfaceError> {
        self.smoothing.validate()?;
        if self.free.is_nan() || self.inner.is_nan() || self.free > self.inner {
            return Err(SurfaceError::Option {
                name: "the eigenvalue of free-surface particles",
                value: self.free,
                allowed: "at most that of inner particles",
            });
        }
        check(self, scene)?;
        let judge = EigenvalueJudge {
            moments: Moments::new(&self.smoothing, scene),
            h: self.smoothing.length * scene.spacing,
            dimension: scene.grid.dimension(),
            free: self.free,
            inner: self.inner,
        };
        detection.fill(scene, self.reach(scene.spacing), &judge);
        Ok(())
    }
}

struct EigenvalueJudge<'a> {
    moments: Moments<'a>,
    h: f64,
    dimension: usize,
    free: f64,
    inner: f64,
}

impl Judge for EigenvalueJudge<'_> {
    type Scratch = Vec<f64>;

    #[inline(always)]
    fn is_free(&self, _: usize, hood: &Neighbourhood, weights: &mut Vec<f64>) -> bool {
        let matrix = self.moments.matrix(hood, weights);
        let eigenvalue = smallest_eigenvalue(&matrix, self.dimension);
        if eigenvalue < self.free {
            return true;
        }
        if eigenvalue > self.inner {
            return false;
        }
        let outward = -self.moments.gradient(hood, weights);
        // λ_min ≥ `free` > 0 keeps M away from singular; with a threshold of 0 the plain gradient has to do.
        let corrected = if eigenvalue > 1e-12 { matrix.inverse() * outward } else { outward };
        umbrella::is_empty(hood, corrected.normalize_or_zero(), self.h, self.dimension)
    }
}
