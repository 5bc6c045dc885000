use glam::DVec3;

use crate::arc_cover::{Cap, uncovered_direction};
use crate::detection::{Judge, check};
use crate::exposed_ball::{check_ball_radius, half_angle};
use crate::neighbourhood::Neighbourhood;
use crate::{Detection, Scene, SurfaceDetection, SurfaceError};

/// The three-dimensional exposure method: part of the particle's sphere is outside all neighbours' balls.
///
/// $$ i \in F \iff \partial B_i \not\subset \bigcup_j B_j, \qquad \psi_j = \arccos\frac{d_{ij}}{2 R_s} $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | R_s | radius of all balls, 1.25 Δx by default | length |
/// | ψ_j | half-angle of the cap of sphere i inside ball j | rad |
///
/// Misses concave surfaces below about 133°, and takes inner particles for free ones where holes between particles are
/// wider than the balls: beyond 1.44 Δx in a cubic lattice, 1.77 Δx in the densest packing. Cost: all arcs of all circles, N² per particle.
///
/// Source: `haque2007`; `liu2022`, Sec. 4, for R_s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Haque {
    /// Radius of the balls over the spacing Δx.
    pub radius: f64,
}

impl Default for Haque {
    fn default() -> Self {
        Self { radius: 1.25 }
    }
}

impl Haque {
    pub(crate) const NAME: &'static str = "haque";
    pub(crate) const DIMENSION: usize = 3;
}

impl SurfaceDetection for Haque {
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
        detection.fill(scene, self.reach(scene.spacing), &BallJudge { diameter: self.reach(scene.spacing) });
        Ok(())
    }
}

struct BallJudge {
    diameter: f64,
}

impl Judge for BallJudge {
    type Scratch = (Vec<Cap>, Vec<(f64, f64)>);

    fn is_free(&self, _: usize, hood: &Neighbourhood, (caps, arcs): &mut Self::Scratch) -> bool {
        caps.clear();
        for k in 0..hood.len {
            let distance = hood.squared[k].sqrt();
            let axis = DVec3::new(hood.x[k], hood.y[k], hood.z[k]) / distance;
            caps.push(Cap::new(axis, half_angle(distance, self.diameter)));
        }
        uncovered_direction(caps, arcs).is_some()
    }
}
