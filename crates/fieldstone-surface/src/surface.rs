use crate::kernel::{Kernel, Smoothing};
use crate::levels::levels_of;
use crate::plausibility::third_coordinate;
use crate::{Detection, Exposure, SurfaceDetection, SurfaceError, Surroundings, exposure, implausibilities, normals};

/// What [`detect_surface`] computes beside the labels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceOptions {
    /// Outward normals of all candidates, by the kernel and smoothing length given.
    pub normals: Option<Smoothing>,
    /// Levels: free surface, vicinity within this multiple of the spacing, inside.
    pub vicinity: Option<f64>,
    /// Largest empty cones, among neighbours within this multiple of the spacing.
    pub exposure: Option<f64>,
}

impl SurfaceOptions {
    /// Labels alone.
    pub const LABELS: Self = Self { normals: None, vicinity: None, exposure: None };

    /// Everything, with the paper's parameters: Wendland C2 and h = 2 Δx, a vicinity of 4 Δx, R = 2.5 Δx.
    pub const ALL: Self = Self {
        normals: Some(Smoothing { kernel: Kernel::WendlandC2, length: 2.0 }),
        vicinity: Some(4.0),
        exposure: Some(2.5),
    };
}

/// Result of [`detect_surface`], in particle order.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Labels and counts.
    pub detection: Detection,
    /// Outward unit normals, where asked for.
    pub normals: Option<Vec<[f64; 3]>>,
    /// 0 free surface, 1 vicinity, 2 inside, where asked for.
    pub levels: Option<Vec<u8>>,
    /// Largest empty cones, where asked for.
    pub exposures: Option<Vec<Exposure>>,
    /// What looks wrong about the input: [`implausibilities`], and z that varies in two dimensions.
    pub warnings: Vec<String>,
}

/// Labels particles from scratch: sorts them, makes images at walls and periodic boundaries, applies a method.
///
/// For many frames; a solver that has its neighbours already calls the [`SurfaceDetection`] itself.
///
/// # Errors
/// As [`Surroundings::grid`] and [`SurfaceDetection::label`].
///
/// ```
/// use fieldstone_surface::{Exact, SurfaceOptions, Surroundings, Wall, detect_surface};
/// let block: Vec<[f64; 3]> =
///     (0..1000).map(|i| [i % 10, i / 10 % 10, i / 100].map(|k| 0.1 * (f64::from(k) + 0.5))).collect();
/// // A floor: the bottom layer is no surface, but for its rim.
/// let walls = vec![Wall::new([0.0, 0.0, 1.0], 0.0)?];
/// let surroundings = Surroundings { walls, ..Surroundings::new(0.1) };
/// let surface = detect_surface(&block, &Exact::default(), &surroundings, &SurfaceOptions::LABELS)?;
/// assert_eq!(surface.detection.free_surface(), 1000 - 8 * 8 * 9);
/// # Ok::<(), fieldstone_surface::SurfaceError>(())
/// ```
pub fn detect_surface(
    positions: &[[f64; 3]],
    method: &dyn SurfaceDetection,
    surroundings: &Surroundings,
    options: &SurfaceOptions,
) -> Result<Surface, SurfaceError> {
    let spacing = surroundings.spacing;
    let grid = surroundings.grid(positions, method.reach(spacing))?;
    let scene = surroundings.scene(&grid);
    let mut warnings = implausibilities(&scene);
    warnings.extend(third_coordinate(positions, surroundings.dimension, spacing));
    let surface = Surface::of_detection(positions, method.detect(&scene)?, surroundings, options)?;
    Ok(Surface { warnings, ..surface })
}

impl Surface {
    /// What `options` ask for about particles that have their labels already; without warnings.
    ///
    /// # Errors
    /// As [`Surroundings::grid`], [`levels`](crate::levels), [`normals`] and [`exposure`].
    ///
    /// ```
    /// use fieldstone_surface::{Exact, Surface, SurfaceDetection, SurfaceOptions, Surroundings};
    /// let block: Vec<[f64; 3]> = (0..729).map(|i| [i % 9, i / 9 % 9, i / 81].map(f64::from)).collect();
    /// let surroundings = Surroundings::new(1.0);
    /// let method = Exact::default();
    /// let grid = surroundings.grid(&block, method.reach(1.0))?;
    /// let detection = method.detect(&surroundings.scene(&grid))?;
    /// let options = SurfaceOptions { vicinity: Some(1.5), ..SurfaceOptions::LABELS };
    /// let surface = Surface::of_detection(&block, detection, &surroundings, &options)?;
    /// // Below the outermost layer there are 7³ particles, of which 5³ are inside.
    /// let vicinity = surface.levels.iter().flatten().filter(|level| **level == 1).count();
    /// assert_eq!(vicinity, 343 - 125);
    /// # Ok::<(), fieldstone_surface::SurfaceError>(())
    /// ```
    pub fn of_detection(
        positions: &[[f64; 3]],
        detection: Detection,
        surroundings: &Surroundings,
        options: &SurfaceOptions,
    ) -> Result<Self, SurfaceError> {
        // Each looks as far as it has to: one grid for the widest would slow the others down.
        let spacing = surroundings.spacing;
        let normals = match &options.normals {
            None => None,
            Some(smoothing) => {
                let grid = surroundings.grid(positions, smoothing.support() * spacing)?;
                Some(normals(&surroundings.scene(&grid), smoothing)?)
            }
        };
        let exposures = match options.exposure {
            None => None,
            Some(radius) => {
                let grid = surroundings.grid(positions, radius * spacing)?;
                Some(exposure(&surroundings.scene(&grid), radius)?)
            }
        };
        let levels = match options.vicinity {
            None => None,
            Some(vicinity) => {
                let reach = vicinity * spacing;
                let candidates = surroundings.candidates.as_deref();
                Some(levels_of(positions, &surroundings.options(reach), candidates, &detection, reach)?)
            }
        };
        Ok(Self { detection, normals, levels, exposures, warnings: Vec::new() })
    }
}
