//! The angle of a vector from the four operations and the square root, in any precision.

use crate::Real;

/// Angle of (x, y) in (−π, π]; 0 for the zero vector.
///
/// The vector is folded into the first octant, the tangent halved `halvings` times by
/// $\tan\frac\theta2 = \tan\theta / (1 + \sqrt{1 + \tan^2\theta})$, and the rest summed as
/// $\arctan z = \sum_k (-1)^k z^{2k+1} / (2k+1)$ with `reciprocals` of the odd numbers; their count is that of the terms.
///
/// Each halving shrinks z by more than 2, so the truncation is below $2^{-2h(n + 1/2)}$ for h halvings and n
/// terms. Every step is a contraction: rounding errors of a few units per step add up, they do not grow, and
/// the doubling at the end is exact.
pub(crate) fn atan2_by_halving<R: Real>(y: R, x: R, halvings: u32, reciprocals: &[R]) -> R {
    let zero = R::from_f64(0.0);
    let one = R::from_f64(1.0);
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay > ax;
    let (long, short) = if steep { (ay, ax) } else { (ax, ay) };
    if long == zero {
        return zero;
    }
    let mut z = short / long;
    for _ in 0..halvings {
        z = z / (one + (one + z * z).sqrt());
    }
    let z2 = -(z * z);
    let mut sum = zero;
    for &reciprocal in reciprocals.iter().rev() {
        sum = sum * z2 + reciprocal;
    }
    let mut angle = sum * z * R::from_f64(f64::from(1u32 << halvings));
    let half_pi = R::pi() * R::from_f64(0.5);
    if steep {
        angle = half_pi - angle;
    }
    if x < zero {
        angle = R::pi() - angle;
    }
    if y < zero { -angle } else { angle }
}
