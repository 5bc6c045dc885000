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
