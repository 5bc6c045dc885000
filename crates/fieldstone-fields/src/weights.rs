//! The volume that each particle has in each cell, as a sparse matrix.

use fieldstone_geometry::Ball;
use fieldstone_mesh::Cells;
use fieldstone_particles::{Domain, Particles};
use rayon::prelude::*;

use crate::binning::Binning;
use crate::{FieldsError, Method};

/// Particles handled by one task: large enough to hide its cost, small enough to balance.
const BLOCK: usize = 128;

/// Sparse matrix of volumes $V_{c \cap i}$: one row per particle, sorted by cell.
///
/// The same bits for any number of threads. Coupled solvers distribute forces back with the same rows
/// ([`Weights::average_over_cells`]).
///
/// ```
/// use fieldstone_fields::{Method, Weights};
/// use fieldstone_mesh::Grid;
/// use fieldstone_particles::Particles;
/// let grid = Grid::new([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1])?;
/// let one = Particles::new(vec![[1.0, 0.5, 0.5]])?.with_uniform_radius(0.25)?;
/// let weights = Weights::build(&grid, &one, Method::Kernel, None)?;
/// // Half of the ball in each of the two cells.
/// assert_eq!(weights.row(0).0, [0, 1]);
/// assert!((weights.row(0).1[0] - weights.row(0).1[1]).abs() < 1e-17);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    ends: Vec<usize>,
    cells: Vec<u32>,
    volumes: Vec<f64>,
    balls: Vec<f64>,
    outside: Vec<f64>,
    cell_count: usize,
}

struct Block {
    counts: Vec<usize>,
    pairs: Vec<(u32, f64)>,
    balls: Vec<f64>,
    outside: Vec<f64>,
}

impl Weights {
    /// Bins every particle, in parallel.
    ///
    /// With a `domain`, its periodic directions are honoured: positions are wrapped, and every image of a ball
    /// that reaches into the box is binned.
    ///
    /// # Errors
    /// Particles without radii; a particle that is no ball.
    pub fn build<C: Cells>(
        cells: &C,
        particles: &Particles,
        method: Method,
        domain: Option<&Domain>,
    ) -> Result<Self, FieldsError> {
        Self::build_observed(cells, particles, method, domain, &|_| ())
    }

    /// As [`Weights::build`]; `done` is called from any thread with the number of particles just binned.
    ///
    /// # Errors
    /// As [`Weights::build`].
    pub fn build_observed<C: Cells>(
        cells: &C,
        particles: &Particles,
        method: Method,
        domain: Option<&Domain>,
        done: &(dyn Fn(usize) + Sync),
    ) -> Result<Self, FieldsError> {
        let radii = particles.radii()?;
        let positions = particles.positions();
        let binning = Binning::new(cells, method)?;
        let blocks: Vec<Block> = (0..positions.len().div_ceil(BLOCK))
            .into_par_iter()
            .map_init(
                || cells.scratch(),
                |scratch, block| {
                    let range = block * BLOCK..positions.len().min((block + 1) * BLOCK);
                    let count = range.len();
                    let block = bin_block(&binning, range, positions, radii, domain, scratch);
                    done(count);
                    block
                },
            )
            .collect::<Result<_, _>>()?;

        let mut this = Self {
            ends: Vec::with_capacity(positions.len()),
            cells: Vec::with_capacity(blocks.iter().map(|b| b.pairs.len()).sum()),
            volumes: Vec::new(),
            balls: Vec::with_capacity(positions.len()),
            outside: Vec::with_capacity(positions.len()),
            cell_count: cells.cell_count(),
        };
        this.volumes.reserve(this.cells.capacity());
        let mut end = 0;
        for block in blocks {
            for count in block.counts {
                end += count;
                this.ends.push(end);
            }
            this.cells.extend(block.pairs.iter().map(|p| p.0));
            this.volumes.extend(block.pairs.iter().map(|p| p.1));
            this.balls.extend(block.balls);
            this.outside.extend(block.outside);
        }
        Ok(this)
    }

    /// Number of particles (rows).
    pub fn particles(&self) -> usize {
        self.ends.len()
    }

    /// Number of cells (columns).
    pub fn cell_count(&self) -> usize {
        self.cell_count
    }

    /// Cells that a particle overlaps, rising, and its volume in each.
    pub fn row(&self, particle: usize) -> (&[u32], &[f64]) {
        let start = if particle == 0 { 0 } else { self.ends[particle - 1] };
        let range = start..self.ends[particle];
        (&self.cells[range.clone()], &self.volumes[range])
    }

    /// End of each particle's entries in [`Weights::cells`] and [`Weights::volumes`]: compressed sparse rows.
    pub fn row_ends(&self) -> &[usize] {
        &self.ends
    }

    /// Cell of each entry.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }

    /// Volume of each entry.
    pub fn volumes(&self) -> &[f64] {
        &self.volumes
    }

    /// Volume of each particle.
    pub fn particle_volumes(&self) -> &[f64] {
        &self.balls
    }

    /// Volume of each particle that lies outside all cells.
    pub fn outside(&self) -> &[f64] {
        &self.outside
    }

    /// For each cell the sum over particles of volume × value.
    ///
    /// $$ s_c = \sum_i V_{c \cap i} \, q_i $$
    ///
    /// With q = 1 the solid volume, with the density the mass, with density × velocity the momentum of a cell.
    ///
    /// # Errors
    /// [`FieldsError::Length`] unless there is one value per particle.
    pub fn sum_over_particles(&self, values: &[f64]) -> Result<Vec<f64>, FieldsError> {
        check_length("particles", values.len(), self.particles())?;
        // Transposed by a counting sort, so that each cell adds its particles in rising order on one thread.
        let mut ends = vec![0usize; self.cell_count + 1];
        for &cell in &self.cells {
            ends[cell as usize + 1] += 1;
        }
        for cell in 0..self.cell_count {
            ends[cell + 1] += ends[cell];
        }
        let mut next = ends.clone();
        let mut terms = vec![0.0; self.cells.len()];
        let mut start = 0;
        for (&end, &value) in self.ends.iter().zip(values) {
            for (&cell, &volume) in self.cells[start..end].iter().zip(&self.volumes[start..end]) {
                let at = &mut next[cell as usize];
                terms[*at] = volume * value;
                *at += 1;
            }
            start = end;
        }
        // Not `sum`: that of no terms is -0, which files would show.
        let total = |cell: usize| terms[ends[cell]..ends[cell + 1]].iter().fold(0.0, |sum, term| sum + term);
        Ok((0..self.cell_count).into_par_iter().map(total).collect())
    }

    /// For each particle the average of a cell field over the part of the particle that lies in cells.
    ///
    /// $$ q_i = \frac{1}{V_i} \sum_c V_{c \cap i} \, f_c $$
    ///
    /// The transpose of [`Weights::sum_over_particles`] over the particle's whole volume, so that forces given to
    /// cells and taken from particles balance.
    ///
    /// # Errors
    /// [`FieldsError::Length`] unless there is one value per cell.
    pub fn average_over_cells(&self, field: &[f64]) -> Result<Vec<f64>, FieldsError> {
        check_length("cells", field.len(), self.cell_count)?;
        Ok((0..self.particles())
            .into_par_iter()
            .map(|i| {
                let (cells, volumes) = self.row(i);
                let sum: f64 = cells.iter().zip(volumes).map(|(&c, v)| v * field[c as usize]).sum();
                sum / self.balls[i]
            })
            .collect())
    }
}

pub(crate) fn check_length(what: &'static str, found: usize, expected: usize) -> Result<(), FieldsError> {
    if found == expected { Ok(()) } else { Err(FieldsError::Length { what, found, expected }) }
}

fn bin_block<C: Cells>(
    binning: &Binning<'_, C>,
    range: std::ops::Range<usize>,
    positions: &[[f64; 3]],
    radii: &[f64],
    domain: Option<&Domain>,
    scratch: &mut C::Scratch,
) -> Result<Block, FieldsError> {
    let mut block = Block { counts: Vec::new(), pairs: Vec::new(), balls: Vec::new(), outside: Vec::new() };
    let mut row = Vec::new();
    for particle in range {
        row.clear();
        // The cube of a smaller one is 0, that of a larger one or a sum of them infinite.
        if !(1e-100..=1e100).contains(&radii[particle]) {
            return Err(FieldsError::RadiusRange { particle, radius: radii[particle] });
        }
        let ball = |centre| Ball::new(centre, radii[particle]).map_err(|source| FieldsError::Ball { particle, source });
        let original = ball(positions[particle])?;
        let seed = particle as u64;
        match domain {
            None => binning.bin(&original, seed, scratch, &mut row),
            Some(domain) => {
                for centre in domain.images(positions[particle], radii[particle]) {
                    binning.bin(&ball(centre)?, seed, scratch, &mut row);
                }
            }
        }
        merge_equal_cells(&mut row);
        let placed = binning.placed(&original, &row);
        let outside = original.volume() - placed;
        // What rounding leaves of a ball that is all inside is nothing.
        block.outside.push(if outside < 1e-13 * original.volume() { 0.0 } else { outside });
        block.balls.push(original.volume());
        block.counts.push(row.len());
        block.pairs.extend_from_slice(&row);
    }
    Ok(block)
}

fn merge_equal_cells(row: &mut Vec<(u32, f64)>) {
    if row.windows(2).all(|w| w[0].0 < w[1].0) {
        return;
    }
    // Stable, so that equal cells add up in the order in which they were found.
    row.sort_by_key(|p| p.0);
    let mut kept = 0;
    for k in 1..row.len() {
        if row[k].0 == row[kept].0 {
            row[kept].1 += row[k].1;
        } else {
            kept += 1;
            row[kept] = row[k];
        }
    }
    row.truncate(kept + 1);
}
