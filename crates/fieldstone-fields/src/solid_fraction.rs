//! Solid volume, solid fraction and void fraction of every cell.

use fieldstone_mesh::Cells;
use fieldstone_particles::{Domain, Particles};
use rayon::prelude::*;

use crate::checks::{check_length, check_parcel_weights};
use crate::periodic::Periods;
use crate::{FieldsError, Ledger, Method, NeumaierSum, Weights, smooth_conservatively};

/// Options of [`solid_fraction`]. The default is exact, without weights, smoothing or cap.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SolidFractionOptions {
    /// How volume is shared out among cells.
    pub method: Method,
    /// The box, where its periodic directions are to be honoured.
    pub domain: Option<Domain>,
    /// How many real particles each one stands for; one number per particle.
    pub parcel_weights: Option<Vec<f64>>,
    /// Length of a conservative smoothing, 0 for none. It passes the boundary of the `domain` where
    /// [`crate::smoothed_through`] says so.
    pub smoothing_length: f64,
    /// Largest solid fraction that is reported; the volume above it is dropped from the capped field only.
    pub cap: Option<f64>,
}

/// Fields of one frame, one number per cell.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidFraction {
    /// Volume of solid, unsmoothed and uncapped.
    pub solid_volume: Vec<f64>,
    /// Solid volume over cell volume, smoothed and capped where asked for.
    pub solid_fraction: Vec<f64>,
    /// 1 − solid fraction.
    pub void_fraction: Vec<f64>,
    /// The solid fraction before the cap, smoothed where asked for; there where a cap was asked for.
    pub uncapped: Option<Vec<f64>>,
    /// The solid fraction before smoothing and cap, where smoothing was asked for.
    pub unsmoothed: Option<Vec<f64>>,
    /// Where the volume went.
    pub ledger: Ledger,
}

impl SolidFraction {
    /// Largest number of `solid_fraction`, smoothed and capped as that is; the ledger has the largest one before.
    pub fn max_written(&self) -> f64 {
        self.solid_fraction.iter().copied().fold(0.0, f64::max)
    }
}

/// Solid fraction of every cell.
///
/// $$ \nu_c = \frac{1}{V_c} \sum_i w_i \, V_{c \cap i} $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | ν | solid fraction, one per cell | – |
/// | V_c | volume of the cell | length³ |
/// | V_{c∩i} | volume of particle i in the cell | length³ |
/// | w | parcel weight, 1 without | – |
///
/// Nothing is clamped: where particles overlap each other, ν may exceed 1, and the ledger counts it.
///
/// # Errors
/// Particles without radii; weights that are negative or not finite; no particle in any cell.
///
/// ```
/// use fieldstone_fields::{SolidFractionOptions, solid_fraction};
/// use fieldstone_mesh::Grid;
/// use fieldstone_particles::Particles;
/// let grid = Grid::new([0.0; 3], [1.0; 3], [1, 1, 1])?;
/// let one = Particles::new(vec![[0.5; 3]])?.with_uniform_radius(0.5)?;
/// let result = solid_fraction(&grid, &one, &SolidFractionOptions::default())?;
/// // The simple cubic packing.
/// assert!((result.solid_fraction[0] - std::f64::consts::PI / 6.0).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn solid_fraction<C: Cells>(
    cells: &C,
    particles: &Particles,
    options: &SolidFractionOptions,
) -> Result<SolidFraction, FieldsError> {
    solid_fraction_observed(cells, particles, options, &|_| ())
}

/// As [`solid_fraction`]; `done` is called from any thread with the number of particles just binned.
///
/// # Errors
/// As [`solid_fraction`].
pub fn solid_fraction_observed<C: Cells>(
    cells: &C,
    particles: &Particles,
    options: &SolidFractionOptions,
    done: &(dyn Fn(usize) + Sync),
) -> Result<SolidFraction, FieldsError> {
    let count = particles.len();
    let ones;
    let parcels = match &options.parcel_weights {
        Some(w) => {
            check_length("particles", w.len(), count)?;
            check_parcel_weights(w)?;
            w
        }
        None => {
            ones = vec![1.0; count];
            &ones
        }
    };
    if let Some(cap) = options.cap
        && !(cap > 0.0 && cap <= 1.0)
    {
        return Err(FieldsError::Option { name: "the cap", value: cap, allowed: "above 0 and at most 1" });
    }
    let weights = Weights::build_observed(cells, particles, options.method, options.domain.as_ref(), done)?;
    if weights.cells().is_empty() && count > 0 {
        return Err(nothing_inside(cells, particles));
    }
    let solid_volume = weights.sum_over_particles(parcels)?;
    let cell_volumes: Vec<f64> = (0..cells.cell_count()).map(|c| cells.cell_volume(c)).collect();
    let over_cells = |volume: &[f64]| -> Vec<f64> { volume.iter().zip(&cell_volumes).map(|(v, c)| v / c).collect() };
    let exact = over_cells(&solid_volume);
    let total = |terms: &[f64]| terms.iter().zip(parcels).map(|(v, w)| v * w).collect::<NeumaierSum>().value();
    let ledger = Ledger {
        particles: count,
        cells: cells.cell_count(),
        mesh_volume: cell_volumes.iter().copied().collect::<NeumaierSum>().value(),
        particle_volume: total(weights.particle_volumes()),
        binned_volume: solid_volume.iter().copied().collect::<NeumaierSum>().value(),
        clipped_volume: total(weights.outside()),
        max_solid_fraction: exact.iter().copied().fold(0.0, f64::max),
        cells_above_one: exact.iter().filter(|&&f| f > 1.0 + 1e-12).count(),
        overlaps: weights.path_counts().evaluated,
        beyond_f64: weights.path_counts().beyond_f64,
    };
    let smoothed = options.smoothing_length != 0.0;
    let mut fraction = exact.clone();
    if smoothed {
        let domain = options.domain.as_ref();
        fraction = over_cells(&smooth_conservatively(cells, &solid_volume, options.smoothing_length, domain)?);
    }
    let uncapped = options.cap.is_some().then(|| fraction.clone());
    if let Some(cap) = options.cap {
        fraction.iter_mut().for_each(|f| *f = f.min(cap));
    }
    Ok(SolidFraction {
        solid_volume,
        void_fraction: fraction.iter().map(|f| 1.0 - f).collect(),
        solid_fraction: fraction,
        uncapped,
        unsmoothed: smoothed.then_some(exact),
        ledger,
    })
}

/// Number of particle centres in each cell; a centre on a common face counts once.
///
/// With a `domain`, every periodic image of a centre that lies in a cell counts, wherever the cells lie: in cells as wide
/// as the period each particle counts once, and once more for each further period that they span.
///
/// # Errors
/// [`FieldsError::BoxCopies`] for a periodic box of which more than 10⁵ copies reach the cells.
///
/// ```
/// use fieldstone_fields::count_centres;
/// use fieldstone_mesh::Grid;
/// use fieldstone_particles::Particles;
/// let grid = Grid::new([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1])?;
/// let three = Particles::new(vec![[0.5; 3], [1.5, 0.5, 0.5], [1.7, 0.5, 0.5]])?;
/// assert_eq!(count_centres(&grid, &three, None)?, [1, 2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn count_centres<C: Cells>(
    cells: &C,
    particles: &Particles,
    domain: Option<&Domain>,
) -> Result<Vec<u32>, FieldsError> {
    let periods = Periods::new(domain, [false; 3], cells.bounds());
    let mut counts = vec![0; cells.cell_count()];
    periods.check(0.0)?;
    let homes: Vec<Vec<u32>> = particles
        .positions()
        .par_chunks(1024)
        .map_init(
            || cells.scratch(),
            |scratch, chunk| {
                let mut homes = Vec::with_capacity(chunk.len());
                for &at in chunk {
                    periods.for_each_point(at, |image| homes.extend(cells.locate(image, scratch)));
                }
                homes
            },
        )
        .collect();
    for cell in homes.into_iter().flatten() {
        counts[cell as usize] += 1;
    }
    Ok(counts)
}

fn nothing_inside<C: Cells>(cells: &C, particles: &Particles) -> FieldsError {
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for p in particles.positions() {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    let (mesh_low, mesh_high) = cells.bounds();
    FieldsError::NothingInside {
        particles: particles.len(),
        particle_low: low,
        particle_high: high,
        mesh_low,
        mesh_high,
    }
}
