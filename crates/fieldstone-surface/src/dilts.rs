use crate::detection::{Judge, check};
use crate::exposed_ball::{check_ball_radius, half_angle};
use crate::intervals::gap_on_circle;
use crate::neighbourhood::Neighbourhood;
use crate::{Detection, Scene, SurfaceDetection, SurfaceError};

/// The two-dimensional exposure method: part of the particle's circle is outside all neighbours' circles.
///
/// $$ i \in F \iff \partial B_i \not\subset \bigcup_j B_j, \qquad \psi_j = \arccos\frac{d_{ij}}{2 R_s} $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | R_s | radius of all circles, 1.25 Δx by default | length |
/// | ψ_j | half-angle of the arc of circle i inside circle j | rad |
///
/// In a uniform distribution a concave surface is seen down to the angle θ_min = 2 arccos(Δx / 2R_s), 133° by default
/// ([`smallest_visible_angle`](Self::smallest_visible_angle)).
///
/// Source: `dilts2000`; `liu2022`, Sec. 4.1 and Eq. 31.
///
/// ```
/// let degrees = fieldstone_surface::Dilts::default().smallest_visible_angle().to_degrees();
/// assert!((degrees - 132.84).abs() < 0.01);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dilts {
    /// Radius of the circles over the spacing Δx.
    pub radius: f64,
}

impl Default for Dilts {
    fn default() -> Self {
        Self { radius: 1.25 }
    }
}

impl Dilts {
    /// Smallest angle of a concave surface that is still seen in a uniform distribution, in radians (Eq. 31).
    pub fn smallest_visible_angle(&self) -> f64 {
        2.0 * (0.5 / self.radius).acos()
    }
}

impl Dilts {
    pub(crate) const NAME: &'static str = "dilts";
    pub(crate) const DIMENSION: usize = 2;
}

impl SurfaceDetection for Dilts {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn only_dimension(&self) -> Option<usize> {
        Some(Self::DIMENSION)
    }

    fn reach(&self, spacing: f64) -> f64 {
        2.0 * self.radius * spacing
    }

    fn label(&self, scene: &Scene<'_>, detection: &mut Detection) -> Result<(), SurfaceError> {
        check_ball_radius(self.radius)?;
        check(self, scene)?;
        detection.fill(scene, self.reach(scene.spacing), &CircleJudge { diameter: self.reach(scene.spacing) });
        Ok(())
    }
}

struct CircleJudge {
    diameter: f64,
}

impl Judge for CircleJudge {
    type Scratch = Vec<(f64, f64)>;

    fn is_free(&self, _: usize, hood: &Neighbourhood, arcs: &mut Self::Scratch) -> bool {
        arcs.clear();
        for k in 0..hood.len {
            let direction = hood.y[k].atan2(hood.x[k]);
            let half = half_angle(hood.squared[k].sqrt(), self.diameter);
            arcs.push((direction - half, direction + half));
        }
        gap_on_circle(arcs).is_some()
    }
}
