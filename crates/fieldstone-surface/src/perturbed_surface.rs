use crate::SurfaceError;

/// How inner particles are placed below a [`PerturbedSurface`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InnerParticles {
    /// A square lattice.
    Uniform,
    /// The lattice without those to the right of and below the central trough.
    Lost,
    /// The lattice with additional ones to the right of and below the central trough.
    Aggregated,
}

/// A two-dimensional zigzag surface with inner particles below it, in units of the spacing.
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | `angle` | angle of the empty wedge above a trough | rad |
/// | `steps` | particles from trough to crest | – |
///
/// Surface particles are one spacing apart along the zigzag, whatever the angle. The central trough is at the origin,
/// and everything is symmetric to it but for lost and aggregated particles.
///
/// Source: `liu2022`, Sec. 4.1, Fig. 7 (175°, 130°, 85°) and Fig. 8 (100°).
#[derive(Debug, Clone, PartialEq)]
pub struct PerturbedSurface {
    /// All particles, those of the surface first.
    pub positions: Vec<[f64; 3]>,
    /// Number of surface particles.
    pub surface: usize,
    /// Index of the trough at the origin.
    pub trough: usize,
}

/// Troughs on either side of the central one.
const TROUGHS: usize = 2;

/// Inner particles go this far down below the origin.
const ROWS: i32 = 12;

/// Inner particles keep this distance from those of the surface.
const CLEARANCE: f64 = 0.95;

/// Inner particles are lost or aggregated within this distance of the trough.
const DISTURBED: f64 = 2.3;

impl PerturbedSurface {
    /// A surface of wedges of `angle`, with `steps` particles from trough to crest.
    ///
    /// # Errors
    /// [`SurfaceError::Option`] where `angle` is not between 0 and π or `steps` is 0.
    ///
    /// ```
    /// use fieldstone_surface::{InnerParticles, PerturbedSurface};
    /// let surface = PerturbedSurface::new(100f64.to_radians(), 3, InnerParticles::Uniform)?;
    /// assert_eq!(surface.positions[surface.trough], [0.0; 3]);
    /// # Ok::<(), fieldstone_surface::SurfaceError>(())
    /// ```
    pub fn new(angle: f64, steps: usize, inner: InnerParticles) -> Result<Self, SurfaceError> {
        if !(angle > 0.0 && angle < std::f64::consts::PI) {
            return Err(SurfaceError::Option {
                name: "the angle of the surface",
                value: angle,
                allowed: "above 0 and below π",
            });
        }
        if steps == 0 {
            return Err(SurfaceError::Option { name: "the particles per slope", value: 0.0, allowed: "at least 1" });
        }
        let (sin, cos) = (0.5 * angle).sin_cos();
        let arm = 2 * steps * TROUGHS;
        let at = |n: usize| {
            let (turn, along) = (n / steps, n % steps);
            let up = if turn.is_multiple_of(2) { along } else { steps - along };
            [n as f64 * sin, up as f64 * cos, 0.0]
        };
        let mut positions: Vec<[f64; 3]> = (1..=arm).rev().map(at).map(|[x, y, z]| [-x, y, z]).collect();
        positions.extend((0..=arm).map(at));
        let surface = positions.len();
        let half_width = arm as f64 * sin;
        let height = |x: f64| {
            let phase = (x.abs() / (steps as f64 * sin)) % 2.0;
            steps as f64 * cos * if phase > 1.0 { 2.0 - phase } else { phase }
        };
        let mut inside = Vec::new();
        for row in -ROWS..=(steps as f64 * cos).floor() as i32 {
            for column in -(half_width.floor() as i32)..=half_width.floor() as i32 {
                let (x, y) = (f64::from(column), f64::from(row));
                let clear = |p: &[f64; 3]| (p[0] - x).hypot(p[1] - y) >= CLEARANCE;
                if y < height(x) && positions.iter().all(clear) {
                    inside.push([x, y, 0.0]);
                }
            }
        }
        let disturbed = |p: &[f64; 3]| p[0] > 0.25 && p[1] < 0.0 && p[0].hypot(p[1]) < DISTURBED;
        match inner {
            InnerParticles::Uniform => {}
            InnerParticles::Lost => inside.retain(|p| !disturbed(p)),
            InnerParticles::Aggregated => {
                let twins: Vec<_> =
                    inside.iter().filter(|p| disturbed(p)).map(|p| [p[0] + 0.3, p[1] - 0.3, 0.0]).collect();
                inside.extend(twins);
            }
        }
        positions.extend(inside);
        Ok(Self { positions, surface, trough: arm })
    }
}
