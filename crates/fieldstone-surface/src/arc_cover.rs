//! Do spherical caps cover the sphere? Answered exactly, by the arcs of each cap's circle that the others cover.

use glam::DVec3;

use crate::intervals::gap_on_circle;

/// Directions closer than this, in radians, are coaxial.
const COAXIAL: f64 = 1e-9;

/// A closed cap of the unit sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cap {
    pub(crate) axis: DVec3,
    pub(crate) cos: f64,
    pub(crate) sin: f64,
}

impl Cap {
    pub(crate) fn new(axis: DVec3, half_angle: f64) -> Self {
        let (sin, cos) = half_angle.sin_cos();
        Self { axis, cos, sin }
    }
}

/// Part of a circle that a cap covers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Cover {
    Nothing,
    /// |α| ≤ β around the direction of the covering cap's axis.
    Arc(f64),
    Everything,
}

/// Part of cap `j`'s circle that cap `k` covers.
///
/// $$ \cos \beta = \frac{\cos\psi_k - \cos\psi_j \cos\varphi}{\sin\psi_j \sin\varphi} $$
///
/// with the angle φ between their axes; all of the circle where that is below −1, nothing where it is above 1. Of
/// coaxial caps the larger one covers the smaller one's circle, and equal ones cover nothing of each other's.
pub(crate) fn cover_of_circle(j: &Cap, k: &Cap) -> Cover {
    let cos = j.axis.dot(k.axis);
    let sin = j.axis.cross(k.axis).length();
    if sin < COAXIAL && cos > 0.0 && (j.cos - k.cos).abs() < COAXIAL * j.sin {
        return Cover::Nothing;
    }
    let cos_beta = (k.cos - j.cos * cos) / (j.sin * sin);
    if cos_beta >= 1.0 {
        Cover::Nothing
    } else if cos_beta <= -1.0 {
        Cover::Everything
    } else {
        Cover::Arc(cos_beta.acos())
    }
}

/// A direction that no cap covers, on the circle of one of them; `None` where they cover the sphere.
///
/// The circle test is complete for one cap or more: an uncovered set is open, and its boundary lies on circles. Without
/// caps the answer is an arbitrary direction. Cost: N² arcs and N sorts.
///
/// Source: `liu2022`, Sec. 3.1, with the closed form instead of Eq. 18–25; `haque2007` for unequal caps.
pub(crate) fn uncovered_direction(caps: &[Cap], arcs: &mut Vec<(f64, f64)>) -> Option<DVec3> {
    if caps.is_empty() {
        return Some(DVec3::X);
    }
    'circles: for (j, cap) in caps.iter().enumerate() {
        let (x, y) = cap.axis.any_orthonormal_pair();
        arcs.clear();
        for (k, other) in caps.iter().enumerate() {
            if k == j {
                continue;
            }
            match cover_of_circle(cap, other) {
                Cover::Nothing => {}
                Cover::Everything => continue 'circles,
                Cover::Arc(beta) => {
                    let middle = other.axis.dot(y).atan2(other.axis.dot(x));
                    arcs.push((middle - beta, middle + beta));
                }
            }
        }
        if let Some(angle) = gap_on_circle(arcs) {
            let (sin, cos) = angle.sin_cos();
            return Some(cap.cos * cap.axis + cap.sin * (cos * x + sin * y));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use fieldstone_testing::Random;

    use super::*;

    /// A cap around any direction.
    fn cap(random: &mut Random, angle: impl FnOnce(&mut Random) -> f64) -> Cap {
        Cap::new(random.direction().into(), angle(random))
    }

    #[test]
    fn the_arc_formula_agrees_with_points_of_the_circle_for_two_thousand_pairs_of_caps() {
        let mut random = Random(1);
        let mut kinds = [0; 3];
        // About one pair of 23 is a circle wholly within the other cap.
        for _ in 0..2000 {
            let j = cap(&mut random, |r| r.uniform(0.05, 1.55));
            let k = cap(&mut random, |r| r.uniform(0.05, 1.55));
            let (x, y) = j.axis.any_orthonormal_pair();
            let cover = cover_of_circle(&j, &k);
            let middle = k.axis.dot(y).atan2(k.axis.dot(x));
            kinds[match cover {
                Cover::Nothing => 0,
                Cover::Arc(_) => 1,
                Cover::Everything => 2,
            }] += 1;
            for step in 0..360 {
                let alpha = f64::from(step).to_radians();
                let point = j.cos * j.axis + j.sin * (alpha.cos() * x + alpha.sin() * y);
                let depth = point.dot(k.axis) - k.cos;
                if depth.abs() < 1e-12 {
                    continue;
                }
                let from_middle = (alpha - middle + 9.0 * std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
                    - std::f64::consts::PI;
                let inside = match cover {
                    Cover::Nothing => false,
                    Cover::Everything => true,
                    Cover::Arc(beta) => from_middle.abs() <= beta,
                };
                assert_eq!(inside, depth > 0.0, "{j:?} {k:?} at {step}°");
            }
        }
        assert!(kinds.iter().all(|&n| n > 50), "{kinds:?}");
    }

    #[test]
    fn a_thousand_arrangements_of_caps_cover_the_sphere_where_every_sample_of_it_is_covered() {
        let mut random = Random(2);
        let samples: Vec<DVec3> = (0..4000).map(|_| random.direction().into()).collect();
        let (mut covered, mut open) = (0, 0);
        let mut arcs = Vec::new();
        for _ in 0..1000 {
            let largest = random.uniform(0.5, 1.5);
            let count = 1 + random.below(40);
            let caps: Vec<Cap> = (0..count).map(|_| cap(&mut random, |r| largest * r.uniform(0.6, 1.0))).collect();
            let is_free = |p: DVec3, margin: f64| caps.iter().all(|c| p.dot(c.axis) < c.cos + margin);
            match uncovered_direction(&caps, &mut arcs) {
                Some(direction) => {
                    open += 1;
                    assert!(is_free(direction, 1e-12), "{direction}");
                }
                None => {
                    covered += 1;
                    assert!(!samples.iter().any(|&p| is_free(p, -1e-12)));
                }
            }
        }
        assert!(covered > 100 && open > 100, "{covered} covered, {open} not");
    }

    #[test]
    fn coaxial_caps_nest_and_equal_ones_do_not_cover_each_other() {
        let (small, large) = (Cap::new(DVec3::Z, 0.4), Cap::new(DVec3::Z, 0.9));
        assert_eq!(cover_of_circle(&small, &large), Cover::Everything);
        assert_eq!(cover_of_circle(&large, &small), Cover::Nothing);
        assert_eq!(cover_of_circle(&small, &small), Cover::Nothing);
        let opposite = Cap::new(DVec3::NEG_Z, 0.4);
        assert_eq!(cover_of_circle(&small, &opposite), Cover::Nothing);
        assert!(uncovered_direction(&[small, small, large], &mut Vec::new()).is_some());
    }
}
