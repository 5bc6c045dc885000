use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use crate::detection::{Judge, check};
use crate::neighbourhood::Neighbourhood;
use crate::sun::SectorJudge;
use crate::{Detection, ScanningCone, Scene, SurfaceDetection, SurfaceError};

/// Directions closer than this in radians coincide: below, Eq. 20 has too few digits to tell where two circles cross.
const COINCIDENT: f64 = 1e-7;

/// The geometrical method as it is printed: circles, sorted arcs and a dynamic list.
///
/// A cone of half-angle θ around each neighbour cuts a circle from the sphere of radius R. The particle is an inner one
/// if and only if every circle is covered by the others:
///
/// $$ \mathcal{H}\_{ij} = [0, 2\pi) \setminus \bigcup_k [\gamma_{ijk} - \beta_{ijk},\ \gamma_{ijk} + \beta_{ijk}] =
/// \emptyset \quad \forall\, j $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | θ, R | [`ScanningCone`] | rad, length |
/// | γ, β | middle and half-width of the part of circle j that circle k covers | rad |
///
/// Kept as the reference; [`Exact`](crate::Exact) gives the same labels up to a hundred times faster. In two
/// dimensions this is the method of [`Sun`](crate::Sun). Cost: about N²/2 arcs of an inverse 3×3 matrix each.
///
/// Source: `liu2022`, Sec. 3.1, Algorithm 1, Eq. 12–28.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Geometrical {
    /// The scanning cone.
    pub cone: ScanningCone,
}

impl Geometrical {
    pub(crate) const NAME: &'static str = "geometrical";
}

impl SurfaceDetection for Geometrical {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn reach(&self, spacing: f64) -> f64 {
        self.cone.radius * spacing
    }

    fn label(&self, scene: &Scene<'_>, detection: &mut Detection) -> Result<(), SurfaceError> {
        self.cone.validate()?;
        check(self, scene)?;
        let radius = self.reach(scene.spacing);
        if scene.grid.dimension() == 2 {
            detection.fill(scene, radius, &SectorJudge::new(&self.cone));
        } else {
            detection.fill(scene, radius, &CircleJudge::new(&self.cone, radius));
        }
        Ok(())
    }
}

/// Algorithm 1 on one particle.
pub(crate) struct CircleJudge {
    radius: f64,
    angle: f64,
}

impl CircleJudge {
    pub(crate) fn new(cone: &ScanningCone, radius: f64) -> Self {
        Self { radius, angle: cone.cap_angle() }
    }
}

/// Circle C_ij, with the particle at the origin.
struct Circle {
    centre: DVec3,
    radius: f64,
    x: DVec3,
    y: DVec3,
    z: DVec3,
}

#[derive(Default)]
pub(crate) struct CircleScratch {
    directions: Vec<DVec3>,
    /// The set ℒ: angle φ and neighbour.
    crossing: Vec<(f64, usize)>,
    exposed: Vec<(f64, f64)>,
    remaining: Vec<(f64, f64)>,
}

impl Judge for CircleJudge {
    type Scratch = CircleScratch;

    fn is_free(&self, _: usize, hood: &Neighbourhood, scratch: &mut CircleScratch) -> bool {
        let CircleScratch { directions, crossing, exposed, remaining } = scratch;
        directions.clear();
        directions.extend((0..hood.len).map(|k| DVec3::new(hood.x[k], hood.y[k], hood.z[k]) / hood.squared[k].sqrt()));
        for &z in directions.iter() {
            let circle = self.circle(z);
            crossing.clear();
            for (k, other) in directions.iter().enumerate() {
                let angle = z.dot(*other).clamp(-1.0, 1.0).acos();
                if angle > COINCIDENT && angle < 2.0 * self.angle {
                    crossing.push((angle, k));
                }
            }
            crossing.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            exposed.clear();
            exposed.push((0.0, TAU));
            for &(_, k) in crossing.iter() {
                let (middle, half) = self.crossing_of(&circle, directions[k]);
                remove(exposed, remaining, middle - half, middle + half);
                if exposed.is_empty() {
                    break;
                }
            }
            if !exposed.is_empty() {
                return true;
            }
        }
        false
    }
}

impl CircleJudge {
    /// Eq. 13–17.
    fn circle(&self, z: DVec3) -> Circle {
        let across = DVec3::Y.cross(z);
        let across = if across == DVec3::ZERO { DVec3::X.cross(z) } else { across };
        let x = across.normalize();
        let y = z.cross(x).normalize();
        Circle { centre: self.radius * self.angle.cos() * z, radius: self.radius * self.angle.sin(), x, y, z }
    }

    /// Middle γ and half-width β of the arc of a circle inside the cone around `other`: Eq. 18–24.
    fn crossing_of(&self, circle: &Circle, other: DVec3) -> (f64, f64) {
        let normal = circle.z.cross(other).normalize();
        let planes = DMat3::from_cols(circle.z, other, normal).transpose();
        let offset = self.radius * self.angle.cos();
        let point = planes.inverse() * DVec3::new(offset, offset, 0.0);
        let in_plane = point - circle.centre;
        let (x, y) = (in_plane.dot(circle.x), in_plane.dot(circle.y));
        let distance = (x * x + y * y).sqrt();
        let beta = (distance / circle.radius).min(1.0).acos();
        let gamma = if distance == 0.0 { 0.0 } else { (x / distance).clamp(-1.0, 1.0).acos() };
        (if y < 0.0 { TAU - gamma } else { gamma }, beta)
    }
}

/// Takes the closed interval from `start` to `end` out of the dynamic list: Eq. 26, 27.
fn remove(exposed: &mut Vec<(f64, f64)>, remaining: &mut Vec<(f64, f64)>, start: f64, end: f64) {
    if start < 0.0 {
        remove_within(exposed, remaining, 0.0, end);
        remove_within(exposed, remaining, start + TAU, TAU);
    } else if end >= TAU {
        remove_within(exposed, remaining, 0.0, end - TAU);
        remove_within(exposed, remaining, start, TAU);
    } else {
        remove_within(exposed, remaining, start, end);
    }
}

fn remove_within(exposed: &mut Vec<(f64, f64)>, remaining: &mut Vec<(f64, f64)>, start: f64, end: f64) {
    remaining.clear();
    for &(low, high) in exposed.iter() {
        if end < low || start > high {
            remaining.push((low, high));
            continue;
        }
        if low < start {
            remaining.push((low, start));
        }
        if end < high {
            remaining.push((end, high));
        }
    }
    std::mem::swap(exposed, remaining);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dynamic_list_is_empty_once_intervals_cover_the_turn() {
        let (mut exposed, mut work) = (vec![(0.0, TAU)], Vec::new());
        remove(&mut exposed, &mut work, -1.0, 1.0);
        assert_eq!(exposed, [(1.0, TAU - 1.0)]);
        remove(&mut exposed, &mut work, 2.0, 3.0);
        assert_eq!(exposed, [(1.0, 2.0), (3.0, TAU - 1.0)]);
        remove(&mut exposed, &mut work, 1.0, 2.5);
        remove(&mut exposed, &mut work, 2.9, 6.5);
        assert!(exposed.is_empty(), "{exposed:?}");
    }

    #[test]
    fn the_printed_arcs_are_those_of_the_closed_form() {
        let judge = CircleJudge { radius: 2.5, angle: 0.8 };
        let circle = judge.circle(DVec3::new(0.6, 0.0, 0.8));
        for step in 1..15 {
            let other = DVec3::new(0.6, (0.1 * f64::from(step)).sin(), 0.3).normalize();
            let angle = circle.z.angle_between(other);
            let (gamma, beta) = judge.crossing_of(&circle, other);
            assert!((beta.cos() - (0.5 * angle).tan() / 0.8f64.tan()).abs() < 1e-13);
            let direction = other.dot(circle.y).atan2(other.dot(circle.x)).rem_euclid(TAU);
            assert!((gamma - direction).abs() < 1e-7, "{gamma} {direction}");
        }
    }
}
