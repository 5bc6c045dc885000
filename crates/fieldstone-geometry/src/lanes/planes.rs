//! Distances of balls from the planes of a polyhedron.

use super::inside::{Face, PlacedBalls};
use super::lane::Lanes;
use crate::edge_frames::EdgeFrames;

/// A ball whose centre is farther than this beyond a plane, in radii, is apart from a convex polyhedron whatever the rounding.
pub(super) const APART: f64 = -1.0 - 1e-9;

/// How balls lie to the planes of a polyhedron.
pub(crate) struct PlanesSeen<L: Lanes> {
    /// A bit for each piece whose plane any of the balls reaches.
    pub in_reach: u32,
    /// Whether the ball is clear of the polyhedron beyond one of the planes.
    pub apart: L::Mask,
    /// Whether the centre is a radius or more beyond one of the planes.
    pub beyond: L::Mask,
    /// Whether the centre is beyond none of the planes.
    pub centre_inside: L::Mask,
    /// Whether rounding hides the centre's side of more than one plane.
    pub unresolved: L::Mask,
}

/// offset − direction · centre, in radii.
///
/// Scaled last: near a plane the difference is small and nearly exact, as it would not be of numbers already rounded to a
/// multiple of 1 / radius.
#[inline(always)]
pub(super) fn height<L: Lanes>(offset: f64, direction: &[f64; 3], balls: &PlacedBalls<L>) -> L {
    let [x, y, z] = balls.centre;
    let xy = y.like(-direction[1]).mul_add(y, x.like(-direction[0]).mul_add(x, x.like(offset)));
    z.like(-direction[2]).mul_add(z, xy) * balls.scale
}

/// The planes one after another, each for all balls.
#[inline(always)]
pub(super) fn plane_by_plane<L: Lanes, const N: usize>(
    frames: &EdgeFrames,
    balls: &PlacedBalls<L>,
    faces: &mut [Face<L>; N],
) -> PlanesSeen<L> {
    let (zero, one) = (balls.scale.like(0.0), balls.scale.like(1.0));
    let (no, yes) = (zero.less(zero), zero.less(one));
    let mut seen = PlanesSeen { in_reach: 0, apart: no, beyond: no, centre_inside: yes, unresolved: no };
    let mut hidden = zero;
    for (k, (face, plane)) in faces.iter_mut().zip(&frames.planes).enumerate() {
        let distance = height(plane.offset, &plane.normal, balls);
        face.distance = distance;
        seen.in_reach |= u32::from(L::any(distance.abs().less(one))) << k;
        seen.apart = seen.apart | distance.less(one.like(APART));
        seen.beyond = seen.beyond | !(-one).less(distance);
        seen.centre_inside = seen.centre_inside & !distance.less(zero);
        hidden = hidden + L::select(distance.abs().less(balls.resolution), one, zero);
    }
    seen.unresolved = one.less(hidden);
    seen
}
