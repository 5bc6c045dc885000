//! Kernels at a point, and their integrals along a branch: one file per function.

mod gauss;
mod heaviside;
mod linear;
mod lucy;

use std::fmt;
use std::str::FromStr;

use crate::FieldsError;

/// Shape of a kernel.
///
/// | shape | φ(d), q = d/w | reach | norm in 1, 2, 3 dimensions |
/// |---|---|---|---|
/// | Gauss | $e^{-q^2/2}$ | 3 w, or as given | renormalised within the reach |
/// | Lucy | $1 - 6q^2 + 8q^3 - 3q^4$ | w | $5/(4w)$, $5/(\pi w^2)$, $105/(16 \pi w^3)$ |
/// | Heaviside | 1 | w | $1/(2w)$, $1/(\pi w^2)$, $3/(4 \pi w^3)$ |
/// | Linear | $1 - q$ | w | $1/w$, $3/(\pi w^2)$, $3/(\pi w^3)$ |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KernelShape {
    /// Gaussian of standard deviation w (`gauss`).
    Gauss,
    /// Lucy's quartic (`lucy`; `lucy1977`).
    Lucy,
    /// Constant (`heaviside`).
    Heaviside,
    /// Cone (`linear`).
    Linear,
}

impl FromStr for KernelShape {
    type Err = FieldsError;

    fn from_str(text: &str) -> Result<Self, FieldsError> {
        match text.to_ascii_lowercase().as_str() {
            "gauss" => Ok(Self::Gauss),
            "lucy" => Ok(Self::Lucy),
            "heaviside" => Ok(Self::Heaviside),
            "linear" => Ok(Self::Linear),
            _ => Err(FieldsError::UnknownKernel(text.into())),
        }
    }
}

impl fmt::Display for KernelShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Gauss => "gauss",
            Self::Lucy => "lucy",
            Self::Heaviside => "heaviside",
            Self::Linear => "linear",
        })
    }
}

/// A coarse-graining function φ: positive, of finite reach, with integral 1.
///
/// Resolved along one, two or three directions: along the others it is integrated, so its unit is
/// 1/length to the number of dimensions.
///
/// ```
/// use fieldstone_fields::{Kernel, KernelShape};
/// let lucy = Kernel::new(KernelShape::Lucy, 1.0, None)?.in_dimensions(3)?;
/// assert!((lucy.value(0.0) - 105.0 / (16.0 * std::f64::consts::PI)).abs() < 1e-14);
/// // The mean along a branch through the centre, as long as the reach.
/// let mean = lucy.along_branch([0.0; 3], [1.0, 0.0, 0.0]);
/// assert!((mean - lucy.value(0.0) * 0.4).abs() < 1e-14);
/// # Ok::<(), fieldstone_fields::FieldsError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kernel {
    shape: KernelShape,
    width: f64,
    reach: f64,
    dimensions: usize,
    /// Factor of the shape in the kernel.
    norm: f64,
}

/// Branches shorter than this, in widths, are integrated by quadrature: the difference of two nearly equal
/// antiderivatives would lose more digits than three points do.
const SHORT: f64 = 1e-4;

impl Kernel {
    /// A kernel of the given width; `reach` is where a Gaussian is cut off, three widths unless given. The others end at
    /// their width.
    ///
    /// # Errors
    /// [`FieldsError::Option`] for a width or reach that is not between 1e-100 and 1e100, [`FieldsError::Combination`] for
    /// the reach of a kernel that is no Gaussian.
    pub fn new(shape: KernelShape, width: f64, reach: Option<f64>) -> Result<Self, FieldsError> {
        let reach = match shape {
            KernelShape::Gauss => reach.unwrap_or(3.0 * width),
            _ if reach.is_some() => {
                return Err(FieldsError::Combination {
                    what: "only a Gaussian has a cut-off of its own, and lucy, heaviside and linear end at their width: leave the cut-off out, or choose gauss",
                });
            }
            _ => width,
        };
        for (name, value) in [("the kernel's width", width), ("the kernel's cut-off", reach)] {
            if !(1e-100..=1e100).contains(&value) {
                return Err(FieldsError::Option { name, value, allowed: "between 1e-100 and 1e100" });
            }
        }
        Self { shape, width, reach, dimensions: 3, norm: 0.0 }.in_dimensions(3)
    }

    /// The same kernel, integrated over all but `dimensions` directions (0 to 3). In none it is 1.
    ///
    /// # Errors
    /// [`FieldsError::Option`] for more than three dimensions.
    pub fn in_dimensions(mut self, dimensions: usize) -> Result<Self, FieldsError> {
        if dimensions > 3 {
            let (name, value) = ("the kernel's number of dimensions", dimensions as f64);
            return Err(FieldsError::Option { name, value, allowed: "0, 1, 2 or 3" });
        }
        let over = |mass: f64| 1.0 / (mass * self.width.powi(dimensions as i32));
        self.norm = match self.shape {
            _ if dimensions == 0 => 1.0,
            KernelShape::Gauss => gauss::norm(dimensions, self.width, self.reach),
            KernelShape::Lucy => over(lucy::mass(dimensions)),
            KernelShape::Heaviside => over(heaviside::mass(dimensions)),
            KernelShape::Linear => over(linear::mass(dimensions)),
        };
        self.dimensions = dimensions;
        Ok(self)
    }

    /// Shape.
    pub fn shape(&self) -> KernelShape {
        self.shape
    }

    /// Width w.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Distance beyond which the kernel is zero.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// Distance beyond which nothing of the kernel is left in `f64`: the reach, but for a Gaussian of very long reach.
    pub(crate) fn support(&self) -> f64 {
        /// $e^{-q^2/2}$ is below the smallest number.
        const NOTHING_LEFT: f64 = 39.0;
        self.reach.min(NOTHING_LEFT * self.width)
    }

    /// φ at the square of a distance.
    #[inline]
    pub fn value(&self, distance2: f64) -> f64 {
        if self.dimensions == 0 {
            return 1.0;
        }
        if distance2 >= self.reach * self.reach {
            return 0.0;
        }
        self.norm * self.shape_at(distance2 / (self.width * self.width))
    }

    #[inline]
    fn shape_at(&self, q2: f64) -> f64 {
        match self.shape {
            KernelShape::Gauss => gauss::shape(q2),
            KernelShape::Lucy => lucy::shape(q2),
            KernelShape::Heaviside => heaviside::shape(q2),
            KernelShape::Linear => linear::shape(q2),
        }
    }

    /// The kernel averaged along a branch, made ready for many points.
    ///
    /// Components of `b` along directions that are integrated over must be zero.
    pub fn branch(&self, b: [f64; 3]) -> BranchKernel {
        let length = (b[0] * b[0] + b[1] * b[1] + b[2] * b[2]).sqrt();
        let is_point = self.dimensions == 0 || length == 0.0;
        let direction = if is_point { [0.0; 3] } else { b.map(|x| x / length) };
        let factor = if is_point { 1.0 } else { self.norm * self.width / length };
        BranchKernel { kernel: *self, direction, length: if is_point { 0.0 } else { length }, factor }
    }

    /// $\psi = \int_0^1 \varphi(x - s b) \, ds$ for one point: [`BranchKernel::at`] of [`Kernel::branch`].
    pub fn along_branch(&self, x: [f64; 3], b: [f64; 3]) -> f64 {
        self.branch(b).at(x)
    }
}

/// A kernel averaged along a branch.
///
/// $$ \psi(x) = \int_0^1 \varphi(x - s b) \, ds $$
///
/// In closed form for each shape. The Gaussian is cut off by the same sphere as the kernel itself, so that
/// $\varphi(x) - \varphi(x - b) = -\nabla\cdot(b\,\psi)$ holds for it as for the others. Error some 1e-12 of φ(0).
///
/// Source: `goldhirsch2010`, Eq. 37.
#[derive(Debug, Clone, Copy)]
pub struct BranchKernel {
    kernel: Kernel,
    direction: [f64; 3],
    length: f64,
    /// Norm and width of the kernel over the length.
    factor: f64,
}

impl BranchKernel {
    /// ψ at `x`, measured from where the branch starts; zero along directions that are integrated over.
    #[inline]
    pub fn at(&self, x: [f64; 3]) -> f64 {
        let kernel = &self.kernel;
        let n = self.direction;
        let along = x[0] * n[0] + x[1] * n[1] + x[2] * n[2];
        let across = [x[0] - along * n[0], x[1] - along * n[1], x[2] - along * n[2]];
        let h2 = across[0] * across[0] + across[1] * across[1] + across[2] * across[2];
        if self.length == 0.0 {
            return kernel.value(h2);
        }
        let chord2 = kernel.reach * kernel.reach - h2;
        if chord2 <= 0.0 {
            return 0.0;
        }
        let chord = chord2.sqrt();
        // The branch runs from −along to length − along, measured from the foot of the point.
        let (a, b) = ((-along).max(-chord), (self.length - along).min(chord));
        if a >= b {
            return 0.0;
        }
        let scale = 1.0 / kernel.width;
        let (h2, a, b) = (h2 * scale * scale, a * scale, b * scale);
        let integral = if b - a < SHORT {
            let (mid, half) = (0.5 * (a + b), 0.5 * (b - a));
            let off = half * 0.6f64.sqrt();
            let at = |t: f64| kernel.shape_at(h2 + t * t);
            half * (8.0 * at(mid) + 5.0 * (at(mid - off) + at(mid + off))) / 9.0
        } else {
            match kernel.shape {
                KernelShape::Gauss => gauss::along(h2, a, b),
                KernelShape::Lucy => lucy::along(h2, a, b),
                KernelShape::Heaviside => heaviside::along(a, b),
                KernelShape::Linear => linear::along(h2, a, b),
            }
        };
        self.factor * integral.max(0.0)
    }
}

/// $\int_a^b (h^2 + t^2)^{p/2} dt$ for p = 1 or 3.
#[inline]
fn integral_of_power(power: u32, h2: f64, a: f64, b: f64) -> f64 {
    let (sa, sb) = ((h2 + a * a).sqrt(), (h2 + b * b).sqrt());
    // ln((b + s_b)/(a + s_a)), with the sum that does not cancel.
    let logarithm = if h2 == 0.0 {
        0.0
    } else if a >= 0.0 {
        ((b + sb) / (a + sa)).ln()
    } else if b <= 0.0 {
        ((sa - a) / (sb - b)).ln()
    } else {
        ((b + sb) * (sa - a) / h2).ln()
    };
    let first = 0.5 * (b * sb - a * sa + h2 * logarithm);
    if power == 1 { first } else { 0.25 * (b * sb * sb * sb - a * sa * sa * sa) + 0.75 * h2 * first }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [KernelShape; 4] =
        [KernelShape::Gauss, KernelShape::Lucy, KernelShape::Heaviside, KernelShape::Linear];

    /// Integral over 0..1 by Gauss–Legendre on many panels.
    fn integrate(f: impl Fn(f64) -> f64, panels: usize) -> f64 {
        let step = 1.0 / panels as f64;
        let off = 0.5 * 0.6f64.sqrt();
        (0..panels)
            .map(|k| {
                let mid = (k as f64 + 0.5) * step;
                step * (8.0 * f(mid) + 5.0 * (f(mid - off * step) + f(mid + off * step))) / 18.0
            })
            .sum()
    }

    #[test]
    fn every_kernel_has_integral_one_in_one_two_and_three_dimensions() {
        for shape in SHAPES {
            for dimensions in 1..=3 {
                let kernel = Kernel::new(shape, 0.7, None).unwrap().in_dimensions(dimensions).unwrap();
                let reach = kernel.reach();
                let surface = [2.0, 2.0 * std::f64::consts::PI, 4.0 * std::f64::consts::PI][dimensions - 1];
                let total = integrate(
                    |s| {
                        let d = s * reach;
                        reach * surface * d.powi(dimensions as i32 - 1) * kernel.value(d * d)
                    },
                    2000,
                );
                assert!((total - 1.0).abs() < 1e-12, "{shape} in {dimensions}: {total}");
            }
        }
    }

    #[test]
    fn a_gaussian_has_integral_one_whatever_its_cut_off_is_to_its_width() {
        let width = 0.7;
        for ratio in [1e-8, 1e-7, 1e-6, 1e-4, 1e-2, 0.1, 0.5, 0.999_999, 1.0, 1.5, 3.0, 8.0, 40.0] {
            for dimensions in 1..=3 {
                let reach = ratio * width;
                let kernel = Kernel::new(KernelShape::Gauss, width, Some(reach)).unwrap();
                let kernel = kernel.in_dimensions(dimensions).unwrap();
                let surface = [2.0, 2.0 * std::f64::consts::PI, 4.0 * std::f64::consts::PI][dimensions - 1];
                let shell = |s: f64| reach * surface * (s * reach).powi(dimensions as i32 - 1);
                let total = integrate(|s| shell(s) * kernel.value((s * reach).powi(2)), 4000);
                assert!((total - 1.0).abs() < 1e-12, "{ratio} widths, {dimensions} dimensions: {total}");
            }
        }
    }

    #[test]
    fn a_gaussian_cut_off_far_within_its_width_is_constant_and_one_cut_off_far_beyond_is_whole() {
        let unit_ball = [2.0, std::f64::consts::PI, 4.0 / 3.0 * std::f64::consts::PI];
        for dimensions in 1..=3 {
            let d = dimensions as i32;
            let centre = |width: f64, reach: f64| {
                let kernel = Kernel::new(KernelShape::Gauss, width, Some(reach)).unwrap();
                kernel.in_dimensions(dimensions).unwrap().value(0.0)
            };
            // 1 + d/(d + 2) q²/2 to first order.
            for (width, reach) in [(1.0, 1e-4), (1.0, 1e-6), (1.0, 1e-8), (2e3, 3e-6), (1e100, 1e-100), (1e-90, 1e-100)]
            {
                let q: f64 = reach / width;
                let expected = 1.0 + f64::from(d) / f64::from(d + 2) * 0.5 * q * q;
                let found = centre(width, reach) * unit_ball[dimensions - 1] * f64::powi(reach, d);
                assert!((found - expected).abs() < 2e-15, "{dimensions} dimensions, {reach} of {width}: {found}");
            }
            for (width, reach) in [(1.0, 10.0), (0.3, 12.0), (1e-3, 1e100)] {
                let whole = (2.0 * std::f64::consts::PI * width * width).powf(0.5 * f64::from(d));
                assert!(
                    (centre(width, reach) * whole - 1.0).abs() < 2e-15,
                    "{dimensions} dimensions, {reach} of {width}"
                );
            }
        }
    }

    #[test]
    fn line_integrals_agree_with_quadrature() {
        for shape in SHAPES {
            for dimensions in 1..=3 {
                let kernel = Kernel::new(shape, 0.8, None).unwrap().in_dimensions(dimensions).unwrap();
                let mut seed = 1u64;
                let mut random = || {
                    seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                    (seed >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
                };
                for scale in [1.0, 0.1, 1e-5] {
                    let mut worst = 0.0f64;
                    for _ in 0..40 {
                        let x = std::array::from_fn(|k| if k < dimensions { random() } else { 0.0 });
                        let b: [f64; 3] = std::array::from_fn(|k| if k < dimensions { scale * random() } else { 0.0 });
                        let exact = kernel.along_branch(x, b);
                        let sum = integrate(|s| kernel.value((0..3).map(|k| (x[k] - s * b[k]).powi(2)).sum()), 20_000);
                        worst = worst.max((exact - sum).abs() / kernel.value(0.0));
                    }
                    // A kernel that jumps at its reach is what quadrature is poor at.
                    let jumps = matches!(shape, KernelShape::Gauss | KernelShape::Heaviside);
                    let allowed = if jumps { 5e-5 } else { 2e-10 };
                    assert!(worst < allowed, "{shape}, {dimensions}, {scale}: {worst:e}");
                }
            }
        }
    }

    #[test]
    fn a_gaussian_of_long_reach_has_the_line_integral_of_the_whole_gaussian() {
        let kernel = Kernel::new(KernelShape::Gauss, 0.5, Some(5.0)).unwrap();
        let (x, b) = ([0.1, 0.2, -0.3], [0.9, 0.1, 0.2]);
        let sum = integrate(|s| kernel.value((0..3).map(|k| (x[k] - s * b[k]).powi(2)).sum()), 2000);
        assert!((kernel.along_branch(x, b) / sum - 1.0).abs() < 1e-13);
    }

    #[test]
    fn names_read_back_and_unknown_ones_are_listed() {
        for shape in SHAPES {
            assert_eq!(shape.to_string().parse::<KernelShape>().unwrap(), shape);
        }
        let message = "cubic".parse::<KernelShape>().unwrap_err().to_string();
        assert!(message.contains("gauss, lucy, heaviside, linear"), "{message}");
        assert!(Kernel::new(KernelShape::Lucy, f64::NAN, None).is_err());
    }

    #[test]
    fn only_a_gaussian_takes_a_cut_off() {
        assert_eq!(Kernel::new(KernelShape::Gauss, 1.0, Some(2.0)).unwrap().reach(), 2.0);
        for shape in [KernelShape::Lucy, KernelShape::Heaviside, KernelShape::Linear] {
            let message = Kernel::new(shape, 1.0, Some(1.0)).unwrap_err().to_string();
            assert!(message.contains("only a Gaussian has a cut-off"), "{shape}: {message}");
        }
    }

    #[test]
    fn a_kernel_has_at_most_three_dimensions() {
        for shape in SHAPES {
            let kernel = Kernel::new(shape, 1.0, None).unwrap();
            assert_eq!(kernel.in_dimensions(0).unwrap().value(4.0), 1.0);
            let message = kernel.in_dimensions(4).unwrap_err().to_string();
            assert_eq!(message, "the kernel's number of dimensions is 4; it must be 0, 1, 2 or 3");
        }
    }
}
