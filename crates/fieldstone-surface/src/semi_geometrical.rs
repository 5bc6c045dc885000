use crate::detection::{Judge, check};
use crate::divergence_thresholds::PAPER_SMOOTHINGS;
use crate::geometrical::{CircleJudge, CircleScratch};
use crate::kernel::{Kernel, Smoothing};
use crate::moments::Moments;
use crate::neighbourhood::Neighbourhood;
use crate::sun::SectorJudge;
use crate::{Detection, DivergenceThresholds, ScanningCone, Scene, SurfaceDetection, SurfaceError};

/// The semi-geometrical method: the position divergence, then the geometrical test for those near the surface.
///
/// $$ \lambda_i < \lambda_\text{free} \Rightarrow i \in F, \qquad
///    \lambda_\text{free} \le \lambda_i \le \lambda_\text{inner}\ \wedge\ \exists\,C = \emptyset \Rightarrow i \in F, \qquad
///    \text{otherwise } i \notin F $$
///
/// | symbol | meaning | default |
/// |---|---|---|
/// | λ | position divergence Σ V_j (x_j − x_i)·∇ᵢW, by the actual m/ρ | – |
/// | λ_free, λ_inner | [`DivergenceThresholds`] | 1.8, 2.8 |
/// | W, h | [`Smoothing`] | Wendland C2, h = 2 Δx |
/// | C | [`ScanningCone`] | R = 2.5 Δx, θ = 45° |
///
/// For fidelity to the paper. The labels differ from those of [`Exact`](crate::Exact) where λ decides alone, and the
/// position divergence by itself costs more than the exact answer.
///
/// Source: `liu2022`, Sec. 3.2, Eq. 29, 30.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SemiGeometrical {
    /// The scanning cone of the second step.
    pub cone: ScanningCone,
    /// Kernel and smoothing length of the first step.
    pub smoothing: Smoothing,
    /// Thresholds; `None` for the paper's, or derived from the lattice where those do not apply.
    pub thresholds: Option<DivergenceThresholds>,
}

impl Default for SemiGeometrical {
    fn default() -> Self {
        Self {
            cone: ScanningCone::default(),
            smoothing: Smoothing { kernel: Kernel::WendlandC2, length: 2.0 },
            thresholds: None,
        }
    }
}

impl SemiGeometrical {
    pub(crate) const NAME: &'static str = "semi";
}

impl SurfaceDetection for SemiGeometrical {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn reach(&self, spacing: f64) -> f64 {
        self.smoothing.support().max(self.cone.radius) * spacing
    }

    fn label(&self, scene: &Scene<'_>, detection: &mut Detection) -> Result<(), SurfaceError> {
        self.cone.validate()?;
        self.smoothing.validate()?;
        check(self, scene)?;
        let radius = self.cone.radius * scene.spacing;
        let judge = TwoStepJudge {
            moments: Moments::new(&self.smoothing, scene),
            thresholds: DivergenceThresholds::choose(self.thresholds, &self.smoothing, scene, PAPER_SMOOTHINGS)?,
            limit: radius * radius,
            circles: CircleJudge::new(&self.cone, radius),
            sectors: SectorJudge::new(&self.cone),
            dimension: scene.grid.dimension(),
        };
        detection.fill(scene, self.reach(scene.spacing), &judge);
        Ok(())
    }
}

struct TwoStepJudge<'a> {
    moments: Moments<'a>,
    thresholds: DivergenceThresholds,
    limit: f64,
    circles: CircleJudge,
    sectors: SectorJudge,
    dimension: usize,
}

#[derive(Default)]
struct TwoStepScratch {
    weights: Vec<f64>,
    inner: Neighbourhood,
    circles: CircleScratch,
    arcs: Vec<(f64, f64)>,
}

impl Judge for TwoStepJudge<'_> {
    type Scratch = TwoStepScratch;

    #[inline(always)]
    fn is_free(&self, particle: usize, hood: &Neighbourhood, scratch: &mut TwoStepScratch) -> bool {
        let divergence = self.moments.divergence(hood, &mut scratch.weights);
        if divergence < self.thresholds.free {
            return true;
        }
        if divergence > self.thresholds.inner {
            return false;
        }
        hood.restrict_into(self.limit, &mut scratch.inner);
        if scratch.inner.len == 0 {
            return true;
        }
        if self.dimension == 2 {
            self.sectors.is_free(particle, &scratch.inner, &mut scratch.arcs)
        } else {
            self.circles.is_free(particle, &scratch.inner, &mut scratch.circles)
        }
    }
}
