//! Radii and sphere centres.

use anyhow::Context;
use fieldstone::geometry::Ball;

use crate::cli::reproduce::random::SplitMix;

/// Spheres per radius in the paper.
pub(super) const PAPER_SAMPLES: u32 = 100_000;

/// How many spheres each radius gets.
#[derive(Debug, Clone, Copy)]
pub(super) enum Schedule {
    /// The paper's number at every radius.
    Full,
    /// This number up to radius 1, a tenth up to 4, a fiftieth above: the work per sphere grows with the square of
    /// the radius, and so does the number of overlaps that each of them tests.
    Thinned(u32),
}

impl Schedule {
    pub fn at(self, radius: f64) -> u32 {
        match self {
            Self::Full => PAPER_SAMPLES,
            // The last digit of a radius must not decide.
            Self::Thinned(n) if radius <= 1.0 + 1e-9 => n,
            Self::Thinned(n) if radius <= 4.0 + 1e-9 => n.div_ceil(10),
            Self::Thinned(n) => n.div_ceil(50),
        }
    }

    /// One in `part` of them, where they are thinned at all.
    pub fn part(self, radius: f64, part: u32) -> u32 {
        match self {
            Self::Full => PAPER_SAMPLES,
            Self::Thinned(_) => self.at(radius).div_ceil(part),
        }
    }
}

/// 41 radii from 0.05 to 20, in 40 equal intervals of the logarithm (Sec. 5.1).
pub(super) fn paper_radii() -> Vec<f64> {
    (0..=40).map(|k| 5e-2 * 400f64.powf(f64::from(k) / 40.0)).collect()
}

/// A sphere, and which radius it is a sample of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trial {
    pub radius: usize,
    pub ball: Ball,
}

/// `count` spheres of `radius`, number `index` among the radii, with centres uniform in $[-½, ½]^3$.
///
/// The same in every run, and sphere `k` of a radius is the same however many there are.
pub(super) fn trials(index: usize, radius: f64, count: u32) -> anyhow::Result<Vec<Trial>> {
    let mut random = SplitMix::new(index as u64);
    (0..count)
        .map(|_| {
            let centre = std::array::from_fn(|_| random.uniform() - 0.5);
            Ok(Trial { radius: index, ball: Ball::new(centre, radius).context("--radii")? })
        })
        .collect()
}
