//! Eight particles whose sums over neighbours are found together, one in each lane of a vector.

use crate::points::Carrier;

/// Particles of a cluster.
pub(crate) const LANES: usize = 8;

/// Neighbours whose distances are found at a time.
pub(crate) const BLOCK: usize = 32;

/// Smallest distance squared over h² in sums: a particle and itself, or two at one place, have a finite 1/r.
pub(crate) const TINY: f64 = 1e-24;

/// Positions of a cluster's receivers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Receivers {
    pub(crate) x: [f64; LANES],
    pub(crate) y: [f64; LANES],
    pub(crate) z: [f64; LANES],
}

impl Receivers {
    #[inline(always)]
    pub(crate) fn of(members: &[u32; LANES], carriers: &[Carrier]) -> Self {
        let mut at = Self { x: [0.0; LANES], y: [0.0; LANES], z: [0.0; LANES] };
        for l in 0..LANES {
            [at.x[l], at.y[l], at.z[l], ..] = carriers[members[l] as usize];
        }
        at
    }

    /// Square of the distance of a point to one of them.
    #[inline(always)]
    pub(crate) fn square(&self, lane: usize, x: f64, y: f64, z: f64) -> f64 {
        let (dx, dy, dz) = (x - self.x[lane], y - self.y[lane], z - self.z[lane]);
        dx.mul_add(dx, dy.mul_add(dy, dz * dz))
    }
}

/// Distances of a block of neighbours to the receivers of a cluster: squares over h², and first guesses of 1/root.
///
/// Found for a whole block before they are used: a root and a quotient take so long that a processor, one neighbour
/// after the other, would mostly wait for them.
pub(crate) struct Distances {
    pub(crate) squares: [[f64; LANES]; BLOCK],
    pub(crate) guesses: [[f64; LANES]; BLOCK],
}

impl Distances {
    pub(crate) const ZERO: Self = Self { squares: [[0.0; LANES]; BLOCK], guesses: [[0.0; LANES]; BLOCK] };

    /// Finds those of at most [`BLOCK`] neighbours.
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
}
