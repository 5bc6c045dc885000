use std::f64::consts::TAU;

use crate::detection::{Judge, check};
use crate::intervals::gap_on_circle;
use crate::neighbourhood::Neighbourhood;
use crate::{Detection, ScanningCone, Scene, SurfaceDetection, SurfaceError};

/// The two-dimensional geometrical method: a sector of half-angle θ without a neighbour.
///
/// $$ i \in F \iff \exists\, \alpha:\ |\alpha - \alpha_j| > \theta \quad \forall\, j:\ 0 < d_{ij} \le R $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | α_j | direction of neighbour j | rad |
/// | θ, R | half-angle and radius of the sector, [`ScanningCone`] | rad, length |
///
/// Exact: the directions are sorted and a gap wider than 2θ is looked for. A concave wedge of just 2θ is a tie and
/// counts as covered ([`TIE`](crate::TIE)).
///
/// Source: the method of Sun et al., as `liu2022` describes it in Sec. 1 and 4.1.
///
/// ```
/// use fieldstone_particles::{NeighbourGrid, NeighbourOptions};
/// use fieldstone_surface::{Scene, Sun, SurfaceDetection};
/// let square: Vec<[f64; 3]> = (0..100).map(|i| [f64::from(i % 10), f64::from(i / 10), 0.0]).collect();
/// let method = Sun::default();
/// let options = NeighbourOptions { dimension: 2, ..NeighbourOptions::new(method.reach(1.0)) };
/// let grid = NeighbourGrid::build(&square, options)?;
/// assert_eq!(method.detect(&Scene::new(&grid, 1.0))?.free_surface(), 36);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sun {
    /// The sector.
    pub cone: ScanningCone,
}

impl Sun {
    pub(crate) const NAME: &'static str = "sun";
    pub(crate) const DIMENSION: usize = 2;
}

impl SurfaceDetection for Sun {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn only_dimension(&self) -> Option<usize> {
        Some(Self::DIMENSION)
    }

    fn reach(&self, spacing: f64) -> f64 {
        self.cone.radius * spacing
    }

    fn label(&self, scene: &Scene<'_>, detection: &mut Detection) -> Result<(), SurfaceError> {
        self.cone.validate()?;
        check(self, scene)?;
        detection.fill(scene, self.reach(scene.spacing), &SectorJudge::new(&self.cone));
        Ok(())
    }
}

/// The criterion in two dimensions, for all methods that share it.
pub(crate) struct SectorJudge {
    angle: f64,
}

impl SectorJudge {
    pub(crate) fn new(cone: &ScanningCone) -> Self {
        Self { angle: cone.cap_angle() }
    }

    /// Direction of an empty sector's axis.
    pub(crate) fn empty_direction(&self, hood: &Neighbourhood, arcs: &mut Vec<(f64, f64)>) -> Option<f64> {
        arcs.clear();
        for k in 0..hood.len {
            let direction = hood.y[k].atan2(hood.x[k]);
            arcs.push((direction - self.angle, direction + self.angle));
        }
        gap_on_circle(arcs).map(|a| if a >= TAU { a - TAU } else { a })
    }
}

impl Judge for SectorJudge {
    type Scratch = Vec<(f64, f64)>;

    fn is_free(&self, _: usize, hood: &Neighbourhood, arcs: &mut Self::Scratch) -> bool {
        self.empty_direction(hood, arcs).is_some()
    }
}
