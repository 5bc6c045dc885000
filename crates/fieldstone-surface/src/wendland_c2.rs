use std::f64::consts::PI;

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
/// use fieldstone_surface::WendlandC2;
/// let kernel = WendlandC2::new(0.5, 3);
/// // ∫ W dV = 1, by the midpoint rule in shells.
/// let shell = |n: i32| { let r = (f64::from(n) + 0.5) * 1e-3; 4.0 * std::f64::consts::PI * r * r * 1e-3 * kernel.value(r) };
/// assert!(((0..1000).map(shell).sum::<f64>() - 1.0).abs() < 1e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WendlandC2 {
    h: f64,
    inverse_h: f64,
    alpha: f64,
}

impl WendlandC2 {
    /// The kernel in 2 or 3 dimensions.
    pub fn new(h: f64, dimension: usize) -> Self {
        let alpha = if dimension == 2 { 7.0 / (4.0 * PI * h * h) } else { 21.0 / (16.0 * PI * h * h * h) };
        Self { h, inverse_h: 1.0 / h, alpha }
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
        self.value_at_square(r * r)
    }

    /// W at a distance of which the square is given.
    #[inline(always)]
    pub fn value_at_square(&self, squared: f64) -> f64 {
        let q = squared.sqrt() * self.inverse_h;
        let left = (1.0 - 0.5 * q).max(0.0);
        self.alpha * (1.0 + 2.0 * q) * (left * left) * (left * left)
    }

    /// α_d, the factor of [`value`](Self::value).
    pub fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Factor f = 5 α_d / h² of g(r) = f (1 − q/2)³, where ∇ᵢW = g (x_j − x_i).
    pub fn slope_factor(&self) -> f64 {
        5.0 * self.alpha / (self.h * self.h)
    }

    /// g(r) = −W′(r)/r.
    pub fn slope(&self, r: f64) -> f64 {
        let left = (1.0 - 0.5 * r * self.inverse_h).max(0.0);
        self.slope_factor() * left * left * left
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
