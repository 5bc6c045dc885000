use crate::{Detection, Exact, ScanningCone, SurfaceDetection, SurfaceError, Surroundings};

/// Free-surface particles for one radius and angle of the cone.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// The cone.
    pub cone: ScanningCone,
    /// The labels.
    pub detection: Detection,
}

/// Exact labels for all combinations of sphere radius R/Δx and cone angle θ in degrees, radius by radius.
///
/// | R/Δx | θ | what the paper says |
/// |---|---|---|
/// | larger | | small holes are missed |
/// | smaller | | inner particles are taken for free ones |
/// | | larger | concave surfaces are missed |
/// | | smaller | inner particles are taken for free ones |
///
/// Source: `liu2022`, Sec. 3.1.4 and Fig. 12.
///
/// # Errors
/// A radius or angle outside its range; as [`Surroundings::grid`].
///
/// ```
/// use fieldstone_surface::{Surroundings, sensitivity};
/// let block: Vec<[f64; 3]> = (0..729).map(|i| [i % 9, i / 9 % 9, i / 81].map(f64::from)).collect();
/// let found = sensitivity(&block, &Surroundings::new(1.0), &[2.0, 2.5], &[45.0])?;
/// // On a lattice the outermost layer, for either radius.
/// let counts: Vec<usize> = found.iter().map(|case| case.detection.free_surface()).collect();
/// assert_eq!(counts, [729 - 343; 2]);
/// # Ok::<(), fieldstone_surface::SurfaceError>(())
/// ```
pub fn sensitivity(
    positions: &[[f64; 3]],
    surroundings: &Surroundings,
    radii: &[f64],
    angles: &[f64],
) -> Result<Vec<Sensitivity>, SurfaceError> {
    let mut results = Vec::with_capacity(radii.len() * angles.len());
    let methods = angles
        .iter()
        .map(|&angle| Exact::new(ScanningCone { angle, ..ScanningCone::default() }))
        .collect::<Result<Vec<_>, _>>()?;
    for &radius in radii {
        let cone = ScanningCone { radius, ..ScanningCone::default() };
        cone.validate()?;
        let grid = surroundings.grid(positions, radius * surroundings.spacing)?;
        for method in &methods {
            let method = method.with_radius(radius);
            let detection = method.detect(&surroundings.scene(&grid))?;
            results.push(Sensitivity { cone: method.cone(), detection });
        }
    }
    Ok(results)
}
