use std::f64::consts::PI;

use crate::neighbour_list::{BLOCK, LANES};
use crate::points::Carrier;

/// The Wendland C2 kernel of a smoothing length.
///
/// $$ W = \alpha_d\,(1 + 2q)\,(1 - q/2)^4, \quad q = r/h \le 2, \qquad
///    \alpha_2 = \frac{7}{4\pi h^2},\quad \alpha_3 = \frac{21}{16\pi h^3} $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | h | smoothing length | length |
/// | r | distance | length |
///
/// Source: `liu2022`, Eq. 8, 9.
///
/// ```
/// use fieldstone_sph::WendlandC2;
/// let kernel = WendlandC2::new(0.5, 3);
/// // ∫ W dV = 1, by the midpoint rule in shells.
/// let shell = |n: i32| { let r = (f64::from(n) + 0.5) * 1e-3; 4.0 * std::f64::consts::PI * r * r * 1e-3 * kernel.value(r) };
/// assert!(((0..1000).map(shell).sum::<f64>() - 1.0).abs() < 1e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WendlandC2 {
    h: f64,
    alpha: f64,
}

impl WendlandC2 {
    /// The kernel in 2 or 3 dimensions.
    pub fn new(h: f64, dimension: usize) -> Self {
        let alpha = if dimension == 2 { 7.0 / (4.0 * PI * h * h) } else { 21.0 / (16.0 * PI * h * h * h) };
        Self { h, alpha }
    }

    /// Smoothing length.
    pub fn smoothing_length(&self) -> f64 {
        self.h
    }

    /// Distance from which on the kernel is zero: 2h.
    pub fn reach(&self) -> f64 {
        2.0 * self.h
    }

    /// W(r).
    pub fn value(&self, r: f64) -> f64 {
        let q = r / self.h;
        if q >= 2.0 {
            return 0.0;
        }
        let left = 1.0 - 0.5 * q;
        self.alpha * (1.0 + 2.0 * q) * (left * left) * (left * left)
    }

    /// α_d, the factor of [`value`](Self::value).
    pub(crate) fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Factor f of g(r) = f (1 − q/2)³, where ∇ᵢW = g (x_j − x_i).
    pub(crate) fn slope_factor(&self) -> f64 {
        5.0 * self.alpha / (self.h * self.h)
    }

    /// g(r) = −W′(r)/r.
    pub(crate) fn slope(&self, r: f64) -> f64 {
        let left = (1.0 - 0.5 * r / self.h).max(0.0);
        self.slope_factor() * left * left * left
    }
}

/// Smallest distance squared over h² in sums: a particle and itself, or two at one place, have a finite 1/r.
pub(crate) const TINY: f64 = 1e-24;

/// Positions of a cluster's receivers.
pub(crate) struct Receivers {
    pub(crate) x: [f64; LANES],
    pub(crate) y: [f64; LANES],
    pub(crate) z: [f64; LANES],
}

impl Receivers {
    /// Square of the distance of a point to one of them.
    #[inline(always)]
    pub(crate) fn square(&self, lane: usize, x: f64, y: f64, z: f64) -> f64 {
        let (dx, dy, dz) = (x - self.x[lane], y - self.y[lane], z - self.z[lane]);
        dx.mul_add(dx, dy.mul_add(dy, dz * dz))
    }
}

/// Distances of a block of neighbours to the receivers of a cluster: squares over h², and first guesses of 1/root.
pub(crate) struct Distances {
    pub(crate) squares: [[f64; LANES]; BLOCK],
    pub(crate) guesses: [[f64; LANES]; BLOCK],
}

impl Distances {
    pub(crate) const ZERO: Self = Self { squares: [[0.0; LANES]; BLOCK], guesses: [[0.0; LANES]; BLOCK] };

    #[inline(always)]
    pub(crate) fn find(&mut self, receivers: &Receivers, carriers: &[Carrier], block: &[u32], inverse_square: f64) {
        for ((&j, squares), guesses) in block.iter().zip(&mut self.squares).zip(&mut self.guesses) {
            let [x, y, z, ..] = carriers[j as usize];
            for l in 0..LANES {
                let s = receivers.square(l, x, y, z) * inverse_square;
                let s = if s > TINY { s } else { TINY };
                squares[l] = s;
                guesses[l] = guess(s);
            }
        }
    }
}

/// 1/√s for TINY ≤ s ≤ 10³⁰, to seven digits.
///
/// Processors take several times as long for the root and the quotient in 64 bits. Both particles of a pair get the
/// same bits, so nothing that is conserved is lost.
#[inline(always)]
fn guess(s: f64) -> f64 {
    f64::from(1.0 / (s as f32).sqrt())
}

/// 1/√s from a guess of seven digits by one step of Newton, relative error below 4·10⁻¹⁴.
#[inline(always)]
pub(crate) fn improved(guess: f64, s: f64) -> f64 {
    let half = -0.5 * s;
    guess * (half * guess).mul_add(guess, 1.5)
}

/// 1/√s as the sums have it, for TINY ≤ s ≤ 10³⁰.
pub(crate) fn inverse_root(s: f64) -> f64 {
    improved(guess(s), s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_root_is_one_to_fourteen_digits() {
        let mut s = TINY;
        while s < 1e30 {
            let error = inverse_root(s) * s.sqrt() - 1.0;
            assert!(error.abs() < 4e-14, "{s}: {error:e}");
            s *= 1.000_37;
        }
    }

    #[test]
    fn the_slope_is_the_derivative_of_the_value() {
        for dimension in [2, 3] {
            let kernel = WendlandC2::new(0.7, dimension);
            for n in 1..28 {
                let (r, d) = (0.05 * f64::from(n), 1e-6);
                let derivative = (kernel.value(r + d) - kernel.value(r - d)) / (2.0 * d);
                let expected = -kernel.slope(r) * r;
                assert!((derivative - expected).abs() < 1e-7 * kernel.value(0.0), "{r}: {derivative} {expected}");
            }
        }
    }
}
