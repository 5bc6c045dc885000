//! Angles of eight vectors at once.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_8, PI};

use super::lane::Lanes;

/// (arctan(z)/z − 1)/z² as a polynomial in z², |z| ≤ tan(π/16); Chebyshev fit, relative error below 1e-17.
const COEFFICIENTS: [f64; 8] = [
    -0.333333333333333,
    0.19999999999977475,
    -0.1428571427985792,
    0.11111110347398925,
    -0.09090853036463323,
    0.07689882969041728,
    -0.06605144149371645,
    0.05027150538725712,
];

/// tan(π/16) and tan(3π/16), where the reference direction changes.
const LIMITS: [f64; 2] = [0.198_912_367_379_658, 0.668_178_637_919_298_9];
/// tan(π/8).
const MIDDLE: f64 = 0.414_213_562_373_095_03;

/// Angle of (x, y) in [−π, π]; 0 for the zero vector.
///
/// The vector is folded into the first octant and turned by the nearest of 0, π/8 and π/4, with one division for
/// both; what is left is below π/16. Error at most 5e-16 relative to the angle.
#[inline(always)]
pub(super) fn atan2<L: Lanes>(y: L, x: L) -> L {
    // No closures here and in all that is written in lanes: they would not be compiled for the machine's registers.
    let zero = x.like(0.0);
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ax.less(ay);
    let (long, short) = (ax.max(ay), ax.min(ay));
    // Guards the zero vector, whose angle is then 0.
    let long = long.max(x.like(f64::MIN_POSITIVE));
    let beyond_first = (long * x.like(LIMITS[0])).less(short);
    let beyond_second = (long * x.like(LIMITS[1])).less(short);
    let tangent = L::select(beyond_second, x.like(1.0), L::select(beyond_first, x.like(MIDDLE), zero));
    let base = L::select(beyond_second, x.like(FRAC_PI_4), L::select(beyond_first, x.like(FRAC_PI_8), zero));
    let z = (-tangent).mul_add(long, short) / tangent.mul_add(short, long);
    let z2 = z * z;
    // In pairs, pairs of pairs: a third of the time that one coefficient after the other would take.
    let z4 = z2 * z2;
    let low = pair(2, z2).mul_add(z4, pair(0, z2));
    let high = pair(6, z2).mul_add(z4, pair(4, z2));
    let sum = high.mul_add(z4 * z4, low);
    // The leading 1 is kept apart: z itself carries all its digits.
    let angle = base + (z * z2).mul_add(sum, z);
    let angle = L::select(steep, x.like(FRAC_PI_2) - angle, angle);
    let angle = L::select(x.less(zero), x.like(PI) - angle, angle);
    angle.with_sign_of(y)
}

/// Two terms of the polynomial, from k on.
#[inline(always)]
fn pair<L: Lanes>(k: usize, z2: L) -> L {
    z2.like(COEFFICIENTS[k + 1]).mul_add(z2, z2.like(COEFFICIENTS[k]))
}

#[cfg(test)]
mod tests {
    use fieldstone_testing::Random;
    use pulp::Scalar;

    use super::super::lane::{OneNumber, Register};
    use super::*;

    fn angle(y: f64, x: f64) -> f64 {
        atan2(Register::splat(Scalar, y), Register::splat(Scalar, x)).number()
    }

    #[test]
    fn agrees_with_the_standard_library_in_every_octant_and_at_every_scale() {
        let mut random = Random(1);
        let mut next = || random.uniform(-1.0, 1.0);
        let mut worst = 0.0f64;
        for round in 0..200_000 {
            let scale = 10f64.powi(round % 7 * 20 - 60);
            let tilt = if round % 3 == 0 { 1e-8 } else { 1.0 };
            let (y, x) = (next() * scale * tilt, next() * scale);
            let found = angle(y, x);
            let exact = y.atan2(x);
            worst = worst.max((found - exact).abs() / exact.abs().max(1e-300));
        }
        assert!(worst < 5e-16, "{worst:e}");
    }

    #[test]
    fn axes_diagonals_and_the_zero_vector_are_exact() {
        for (y, x) in
            [(0.0, 1.0), (1.0, 0.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (1.0, -1.0), (0.0, 0.0)]
        {
            assert_eq!(angle(y, x), f64::atan2(y, x), "{y} {x}");
        }
    }
}
