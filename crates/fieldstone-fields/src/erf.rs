//! The error function, from a table of its Taylor expansions.

use std::f64::consts::PI;
use std::sync::LazyLock;

/// Nodes per unit.
const DENSITY: f64 = 32.0;
/// From here on the function is 1 to the last bit.
const LAST: f64 = 6.0;

/// Taylor coefficients of orders 0 to 7 about each node.
static NODES: LazyLock<Vec<[f64; 8]>> =
    LazyLock::new(|| (0..=(LAST * DENSITY) as usize).map(|k| expansion(k as f64 / DENSITY)).collect());

/// $\operatorname{erf}(x) = \frac{2}{\sqrt\pi} \int_0^x e^{-t^2} dt$.
///
/// Expanded to order 7 about the nearest of nodes 1/32 apart: the first term left out is below 1e-16. Absolute error at
/// most 5e-16, against 40 digits. Line integrals of a Gaussian take two of these for every point that a branch reaches.
#[inline]
pub(crate) fn erf(x: f64) -> f64 {
    let a = x.abs();
    if a >= LAST {
        return x.signum();
    }
    let node = (a * DENSITY).round();
    let d = a - node / DENSITY;
    let c = &NODES[node as usize];
    let sum = c[0] + d * (c[1] + d * (c[2] + d * (c[3] + d * (c[4] + d * (c[5] + d * (c[6] + d * c[7]))))));
    sum.copysign(x)
}

fn expansion(x: f64) -> [f64; 8] {
    let slope = 2.0 / PI.sqrt() * (-x * x).exp();
    // erf = slope Σ 2ⁿ x²ⁿ⁺¹ / (2n+1)!!: all terms positive, so nothing cancels.
    let (mut term, mut series, mut n) = (x, x, 0.0);
    while term > 1e-18 * series {
        n += 1.0;
        term *= 2.0 * x * x / (2.0 * n + 1.0);
        series += term;
    }
    let mut c = [(slope * series).min(1.0); 8];
    // Derivative n + 1 is (−1)ⁿ Hₙ(x) times the slope, with Hermite's polynomials.
    let (mut before, mut hermite, mut factorial) = (0.0, 1.0, 1.0);
    for (order, coefficient) in c.iter_mut().enumerate().skip(1) {
        factorial *= order as f64;
        let sign = if order % 2 == 1 { 1.0 } else { -1.0 };
        *coefficient = sign * hermite * slope / factorial;
        let next = 2.0 * x * hermite - 2.0 * (order as f64 - 1.0) * before;
        (before, hermite) = (hermite, next);
    }
    c
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_function_agrees_with_forty_digits() {
        // mpmath.erf at 40 digits.
        let known = [
            (1e-9, 1.128_379_167_095_512_6e-9),
            (0.1, 0.112_462_916_018_284_9),
            (0.484_375, 0.506_662_196_372_917_9),
            (1.0, 0.842_700_792_949_714_9),
            (2.121_320_343_559_643, 0.997_300_203_936_739_8),
            (3.3, 0.999_996_942_290_203_6),
            (5.99, 1.0),
            (7.0, 1.0),
        ];
        for (x, value) in known {
            assert!((erf(x) - value).abs() < 5e-16, "erf({x}) = {:e}", erf(x));
            assert_eq!(erf(-x), -erf(x));
        }
    }
}
