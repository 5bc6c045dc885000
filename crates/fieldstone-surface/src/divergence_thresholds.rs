use crate::kernel::{Kernel, Smoothing};
use crate::{Scene, SurfaceError};

/// Position divergence below which a particle is on the free surface, and above which it is an inner one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DivergenceThresholds {
    /// λ < `free`: free surface.
    pub free: f64,
    /// λ > `inner`: inner.
    pub inner: f64,
}

impl DivergenceThresholds {
    /// The paper's, for three dimensions and its kernels.
    pub const PAPER: Self = Self { free: 1.8, inner: 2.8 };

    /// Thresholds for any kernel, smoothing length and dimension, derived from the lattice as the paper's are.
    ///
    /// $$ \lambda_\text{free} = \frac{1.8}{1.874}\,\lambda_1, \qquad \lambda_\text{inner} = \frac{2.8}{2.571}\,\lambda_2 $$
    ///
    /// | symbol | meaning |
    /// |---|---|
    /// | λ₁, λ₂ | position divergence of the first and second layer below a plane surface of the lattice |
    ///
    /// λ_inner is lowered to the middle between second and third layer where it would exceed the third.
    ///
    /// Source: `liu2022`, Sec. 3.2 ("the thresholds vary with respect to the ratio h/Δx and kernel function").
    pub fn from_lattice(smoothing: &Smoothing, dimension: usize) -> Self {
        let layer = |n| lattice_divergence(smoothing, &Depth::plane(n), dimension);
        let inner = 2.8 / 2.571 * layer(2);
        let inner = if inner < layer(3) { inner } else { 0.5 * (layer(2) + layer(3)) };
        Self { free: 1.8 / 1.874 * layer(1), inner }
    }

    /// How much room the lattice leaves: the corner's second layer above `free`, the third layer above `inner`.
    ///
    /// Where the first is negative, inner particles at corners are taken for free ones without the second step.
    pub fn margins(&self, smoothing: &Smoothing, dimension: usize) -> [f64; 2] {
        let corner = Depth { layers: [Some(2); 3] };
        [
            lattice_divergence(smoothing, &corner, dimension) - self.free,
            lattice_divergence(smoothing, &Depth::plane(3), dimension) - self.inner,
        ]
    }

    pub(crate) fn choose(
        given: Option<Self>,
        smoothing: &Smoothing,
        scene: &Scene<'_>,
        papers: [Smoothing; 2],
    ) -> Result<Self, SurfaceError> {
        let dimension = scene.grid.dimension();
        let chosen = match given {
            Some(given) => given,
            None if dimension == 3 && papers.contains(smoothing) => Self::PAPER,
            None => Self::from_lattice(smoothing, dimension),
        };
        if chosen.free <= chosen.inner && chosen.inner.is_finite() {
            return Ok(chosen);
        }
        Err(SurfaceError::Option {
            name: "the position divergence of free-surface particles",
            value: chosen.free,
            allowed: "at most that of inner particles",
        })
    }
}

/// The smoothings that the paper's thresholds were chosen for.
pub(crate) const PAPER_SMOOTHINGS: [Smoothing; 2] = [
    Smoothing { kernel: Kernel::WendlandC2, length: 2.0 },
    Smoothing { kernel: Kernel::ImprovedGaussian, length: 1.5 },
];

/// Where a particle of a lattice is: its layer from the surface along each axis, from 1, or `None` far from any.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Depth {
    /// Layer along x, y and z; z is ignored in two dimensions.
    pub layers: [Option<i32>; 3],
}

impl Depth {
    /// Layer `n` below a plane surface.
    pub fn plane(n: i32) -> Self {
        Self { layers: [Some(n), None, None] }
    }
}

/// Position divergence of a particle in a lattice of unit spacing (Eq. 29), in closed form a finite sum.
///
/// ```
/// use fieldstone_surface::{Depth, Kernel, Smoothing, lattice_divergence};
/// let smoothing = Smoothing { kernel: Kernel::WendlandC2, length: 2.0 };
/// let surface = lattice_divergence(&smoothing, &Depth::plane(1), 3);
/// assert!((surface - 1.874).abs() < 5e-4);
/// ```
pub fn lattice_divergence(smoothing: &Smoothing, depth: &Depth, dimension: usize) -> f64 {
    let slope = smoothing.slope(1.0, dimension);
    let reach = smoothing.support().floor() as i32;
    let range = |axis: usize| {
        if axis >= dimension {
            return 0..=0;
        }
        // Missing beyond the surface is everything more than `layer − 1` away.
        -depth.layers[axis].map_or(reach, |layer| reach.min(layer - 1))..=reach
    };
    let mut total = 0.0;
    for i in range(0) {
        for j in range(1) {
            for k in range(2) {
                let squared = f64::from(i * i + j * j + k * k);
                let mut g = [0.0];
                slope.fill(&[squared], &mut g);
                total += g[0] * squared;
            }
        }
    }
    total
}
