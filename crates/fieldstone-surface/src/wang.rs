use crate::detection::{Judge, check};
use crate::divergence_thresholds::PAPER_SMOOTHINGS;
use crate::kernel::{Kernel, Smoothing};
use crate::moments::Moments;
use crate::neighbourhood::Neighbourhood;
use crate::{Detection, DivergenceThresholds, Scene, SurfaceDetection, SurfaceError, umbrella};

/// Wang's method: the position divergence, then an umbrella along the normal.
///
/// $$ \lambda_i = \sum_j V_j\,(x_j - x_i) \cdot \nabla_i W_{ij}, \qquad
///    n_i = -\frac{\sum_j V_j \nabla_i W_{ij}}{\lVert\cdot\rVert} $$
///
/// | symbol | meaning | default |
/// |---|---|---|
/// | λ | below `free` a free-surface particle, above `inner` an inner one | [`DivergenceThresholds`]: 1.8, 2.8 in 3-D |
/// | W, h | [`Smoothing`] | improved Gaussian, h = 1.5 Δx |
///
/// In between, the particle is free if no neighbour is in the umbrella along n, as in [`Marrone`](crate::Marrone). The
/// method saves the matrix, so the normal is the plain gradient's.
///
/// Source: `wang2019`; `liu2022`, Sec. 4 and Eq. 29. The thresholds are those of the semi-geometrical method: on the
/// lattice this kernel gives the values that they were derived from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wang {
    /// Kernel and smoothing length.
    pub smoothing: Smoothing,
    /// Thresholds; `None` for the paper's, or derived from the lattice where those do not apply.
    pub thresholds: Option<DivergenceThresholds>,
}

impl Default for Wang {
    fn default() -> Self {
        Self { smoothing: Smoothing { kernel: Kernel::ImprovedGaussian, length: 1.5 }, thresholds: None }
    }
}

impl Wang {
    pub(crate) const NAME: &'static str = "wang";
}

impl SurfaceDetection for Wang {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn reach(&self, spacing: f64) -> f64 {
        self.smoothing.support() * spacing
    }

    fn label(&self, scene: &Scene<'_>, detection: &mut Detection) -> Result<(), SurfaceError> {
        self.smoothing.validate()?;
        check(self, scene)?;
        let judge = UmbrellaJudge {
            moments: Moments::new(&self.smoothing, scene),
            h: self.smoothing.length * scene.spacing,
            dimension: scene.grid.dimension(),
            thresholds: DivergenceThresholds::choose(self.thresholds, &self.smoothing, scene, PAPER_SMOOTHINGS)?,
        };
        detection.fill(scene, self.reach(scene.spacing), &judge);
        Ok(())
    }
}

struct UmbrellaJudge<'a> {
    moments: Moments<'a>,
    h: f64,
    dimension: usize,
    thresholds: DivergenceThresholds,
}

impl Judge for UmbrellaJudge<'_> {
    type Scratch = Vec<f64>;

    #[inline(always)]
    fn is_free(&self, _: usize, hood: &Neighbourhood, weights: &mut Vec<f64>) -> bool {
        let divergence = self.moments.divergence(hood, weights);
        if divergence < self.thresholds.free {
            return true;
        }
        if divergence > self.thresholds.inner {
            return false;
        }
        let normal = -self.moments.gradient(hood, weights).normalize_or_zero();
        umbrella::is_empty(hood, normal, self.h, self.dimension)
    }
}
