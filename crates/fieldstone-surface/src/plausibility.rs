use crate::Scene;

/// Particles that are looked at.
const SAMPLE: usize = 256;

/// Share of them that may lie in the place of another: duplicates of a sloppy restart are far fewer.
const COINCIDENT: f64 = 0.05;

/// What looks wrong about the spacing or the dimension, as sentences for the user; empty where nothing does.
///
/// A spacing that is wrong by an order of magnitude makes all particles inner ones, or all isolated, and nothing fails:
/// so the typical distance of nearest neighbours among 256 particles is compared with it. Two-dimensional data in
/// three dimensions, where every particle is on the free surface, is noticed by one coordinate being constant.
/// Particles in the place of others are noticed where they are many.
///
/// ```
/// use fieldstone_surface::{Surroundings, implausibilities};
/// // Particles 1 apart, and a spacing in a unit ten times as large.
/// let block: Vec<[f64; 3]> = (0..729).map(|i| [i % 9, i / 9 % 9, i / 81].map(f64::from)).collect();
/// for (spacing, expected) in [(1.0, 0), (10.0, 1)] {
///     let surroundings = Surroundings::new(spacing);
///     let findings = implausibilities(&surroundings.scene(&surroundings.grid(&block, 2.5 * spacing)?));
///     assert_eq!(findings.len(), expected);
///     assert!(findings.iter().all(|text| text.contains("typically 1.000e0 apart, but the spacing is 10")));
/// }
/// # Ok::<(), fieldstone_surface::SurfaceError>(())
/// ```
pub fn implausibilities(scene: &Scene<'_>) -> Vec<String> {
    let grid = scene.grid;
    let mut findings = Vec::new();
    if grid.len() < 2 {
        return findings;
    }
    let [x, y, z] = grid.sorted_positions();
    let stride = grid.len().div_ceil(SAMPLE);
    let mut coincident = 0;
    let mut nearest: Vec<f64> = (0..grid.len())
        .step_by(stride)
        .map(|particle| {
            let (mut least, mut shared) = (f64::INFINITY, false);
            // The reach is the grid's own, and the particle exists.
            let searched = grid.for_each_neighbour(particle, grid.reach(), |_, _, squared| {
                shared |= squared == 0.0;
                if squared > 0.0 && squared < least {
                    least = squared;
                }
            });
            coincident += usize::from(shared);
            if searched.is_ok() { least.sqrt() } else { f64::INFINITY }
        })
        .collect();
    nearest.sort_unstable_by(f64::total_cmp);
    let typical = nearest[nearest.len() / 2];
    let spacing = scene.spacing;
    if typical.is_infinite() {
        findings.push(format!(
            "most particles have no neighbour within {}: the spacing {spacing} is too small, or the particles are spray",
            grid.reach()
        ));
    } else if typical < spacing / 3.0 {
        findings.push(format!(
            "nearest neighbours are typically {typical:.3e} apart, but the spacing is {spacing}: labels will be too few and \
             slow; check the spacing and its unit"
        ));
    } else if typical > 1.9 * spacing {
        findings.push(format!(
            "nearest neighbours are typically {typical:.3e} apart, but the spacing is {spacing}: inner particles will be \
             taken for free-surface ones; check the spacing and its unit"
        ));
    }
    if coincident as f64 > COINCIDENT * nearest.len() as f64 {
        findings.push(format!(
            "of {} particles looked at {coincident} lie in the place of another: check for duplicates, for walls among the \
             particles, and the dimension",
            nearest.len()
        ));
    }
    if grid.dimension() == 3 && grid.len() > 3 {
        for (name, values) in [("x", x), ("y", y), ("z", z)] {
            let [least, most] = range(values.iter().copied());
            if most - least < 1e-6 * spacing {
                findings.push(format!(
                    "all particles have {name} = {least}: in three dimensions every one of them is on the free surface; \
                     use dimension 2 (with z as the constant coordinate)"
                ));
            }
        }
    }
    findings
}

/// What looks wrong about z in two dimensions, where neighbour grids do not keep it.
pub(crate) fn third_coordinate(positions: &[[f64; 3]], dimension: usize, spacing: f64) -> Option<String> {
    let [least, most] = range(positions.iter().map(|p| p[2]));
    (dimension == 2 && most - least > 1e-6 * spacing).then(|| {
        format!(
            "z runs from {least} to {most}, but two dimensions are x and y: swap the columns if the particles lie in another \
             plane, or use dimension 3"
        )
    })
}

fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| [least.min(x), most.max(x)])
}
