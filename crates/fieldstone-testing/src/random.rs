//! Random numbers for tests.

/// SplitMix64 from a seed: the same numbers in every run and on every machine, so that a failure comes back.
///
/// ```
/// use fieldstone_testing::Random;
/// assert_eq!(Random(1).uniform(-2.0, 3.0), Random(1).uniform(-2.0, 3.0));
/// ```
#[derive(Debug, Clone)]
pub struct Random(pub u64);

impl Random {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [low, high).
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in the logarithm.
    pub fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        self.uniform(low.ln(), high.ln()).exp()
    }

    /// Below `n`; 0 where that is 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n.max(1) as u64) as usize
    }

    /// A whole number from `low` to `high`.
    pub fn whole(&mut self, low: i64, high: i64) -> f64 {
        (low + self.below((high - low + 1) as usize) as i64) as f64
    }

    /// Each coordinate in [low, high).
    pub fn point(&mut self, low: f64, high: f64) -> [f64; 3] {
        [0; 3].map(|_| self.uniform(low, high))
    }

    /// A unit vector in any direction.
    pub fn direction(&mut self) -> [f64; 3] {
        loop {
            let p = self.point(-1.0, 1.0);
            let length2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
            if length2 > 1e-4 && length2 <= 1.0 {
                return p.map(|x| x / length2.sqrt());
            }
        }
    }
}
