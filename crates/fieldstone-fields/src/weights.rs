//! The volume that each particle has in each cell, as a sparse matrix.

use fieldstone_geometry::Ball;
use fieldstone_mesh::{Cells, PathCounts};
use fieldstone_particles::{Domain, Particles};
use rayon::prelude::*;

use crate::binning::Binning;
use crate::checks::{check_length, check_radii};
use crate::curve::along_a_curve;
use crate::periodic::Periods;
use crate::scatter::{Order, Pair, Sums};
use crate::{FieldsError, Method};

/// Particles handled by one task: large enough to hide its cost, small enough to balance.
const BLOCK: usize = 128;

/// Sparse matrix of volumes $V_{c \cap i}$: one row per particle, sorted by cell.
///
/// The same bits for any number of threads. Coupled solvers distribute forces back with the same rows
/// ([`crate::field_at_particles`]).
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
    paths: PathCounts,
}

struct Block {
    counts: Vec<usize>,
    pairs: Vec<(u32, f64)>,
    balls: Vec<f64>,
    outside: Vec<f64>,
    paths: PathCounts,
}

impl Weights {
    /// Bins every particle, in parallel.
    ///
    /// With a `domain`, its periodic directions are honoured: every image of a ball that reaches the cells is binned,
    /// wherever the cells and the particle lie. Cells that are several periods wide get several images of a ball.
    ///
    /// # Errors
    /// Particles without radii; a particle that is no ball; a radius of more than 20 lengths of a periodic box; such a box
    /// of which more than 10⁵ copies are within reach of the cells.
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
        check_radii(radii)?;
        let positions = particles.positions();
        let periods = Periods::new(domain, [false; 3], cells.bounds());
        periods.check_balls(radii)?;
        let binning = Binning::new(cells, method)?;
        let order = if C::PLACES_IN_MEMORY { along_a_curve(positions) } else { (0..positions.len()).collect() };
        let blocks: Vec<Block> = order
            .par_chunks(BLOCK)
            .map_init(
                || binning.scratch(),
                |scratch, particles| {
                    let before = binning.path_counts(scratch);
                    let mut block = bin_block(&binning, particles, positions, radii, &periods, scratch)?;
                    let after = binning.path_counts(scratch);
                    block.paths = PathCounts {
                        evaluated: after.evaluated - before.evaluated,
                        beyond_f64: after.beyond_f64 - before.beyond_f64,
                    };
                    done(particles.len());
                    Ok::<_, FieldsError>(block)
                },
            )
            .collect::<Result<_, _>>()?;
        Ok(Self::gather(&order, &blocks, cells.cell_count()))
    }

    /// Brings the rows of blocks back from the order in which particles were binned into that of the particles.
    fn gather(order: &[usize], blocks: &[Block], cell_count: usize) -> Self {
        let count = order.len();
        let (mut ends, mut rows) = (vec![0; count], vec![(0u32, 0u32); count]);
        let (mut balls, mut outside) = (vec![0.0; count], vec![0.0; count]);
        let mut paths = PathCounts::default();
        for (index, (particles, block)) in order.chunks(BLOCK).zip(blocks).enumerate() {
            paths.evaluated += block.paths.evaluated;
            paths.beyond_f64 += block.paths.beyond_f64;
            let mut start = 0;
            for (k, &particle) in particles.iter().enumerate() {
                ends[particle] = block.counts[k];
                balls[particle] = block.balls[k];
                outside[particle] = block.outside[k];
                rows[particle] = (index as u32, start);
                start += block.counts[k] as u32;
            }
        }
        let mut end = 0;
        for entry in &mut ends {
            end += *entry;
            *entry = end;
        }
        let (cells, volumes) = copy_rows(blocks, &rows, &ends);
        Self { ends, cells, volumes, balls, outside, cell_count, paths }
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

    /// Volume of each particle that lies outside all cells; negative where the cells hold a part of it in several
    /// periodic images.
    pub fn outside(&self) -> &[f64] {
        &self.outside
    }

    /// How many overlaps were evaluated, and how many of them needed more digits than `f64` has.
    pub fn path_counts(&self) -> PathCounts {
        self.paths
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
        // Each cell adds its particles in rising order, on one thread.
        let mut sums = Sums::new(self.cell_count, 1);
        sums.add(
            &Order::Numbered(self.particles()),
            values,
            || (),
            |particle, (), out| {
                let (cells, volumes) = self.row(particle);
                let pair = |(&cell, &weight)| Pair { cell, carrier: particle as u32, weight };
                out.extend(cells.iter().zip(volumes).map(pair));
                Ok(())
            },
        )?;
        Ok(sums.values)
    }
}

/// Cells and volumes of all rows, one after the other; `rows` says in which block each stands, and from where on.
fn copy_rows(blocks: &[Block], rows: &[(u32, u32)], ends: &[usize]) -> (Vec<u32>, Vec<f64>) {
    let count = ends.last().copied().unwrap_or(0);
    let (mut all_cells, mut all_volumes) = (vec![0; count], vec![0.0; count]);
    // In parallel: each task has its own part of the result.
    let mut parts = Vec::with_capacity(ends.len().div_ceil(BLOCK));
    let (mut cells_left, mut volumes_left) = (&mut all_cells[..], &mut all_volumes[..]);
    let mut start = 0;
    for ends in ends.chunks(BLOCK) {
        let stop = ends[ends.len() - 1];
        let (cells, more_cells) = cells_left.split_at_mut(stop - start);
        let (volumes, more_volumes) = volumes_left.split_at_mut(stop - start);
        (cells_left, volumes_left) = (more_cells, more_volumes);
        parts.push((start, ends, cells, volumes));
        start = stop;
    }
    parts.into_par_iter().zip(rows.par_chunks(BLOCK)).for_each(|((start, ends, cells, volumes), rows)| {
        let mut from = 0;
        for (&end, &(block, first)) in ends.iter().zip(rows) {
            let to = end - start;
            let row = &blocks[block as usize].pairs[first as usize..][..to - from];
            for ((cell, volume), pair) in cells[from..to].iter_mut().zip(&mut volumes[from..to]).zip(row) {
                (*cell, *volume) = *pair;
            }
            from = to;
        }
    });
    (all_cells, all_volumes)
}

fn bin_block<C: Cells>(
    binning: &Binning<'_, C>,
    particles: &[usize],
    positions: &[[f64; 3]],
    radii: &[f64],
    periods: &Periods,
    scratch: &mut C::Scratch,
) -> Result<Block, FieldsError> {
    let mut block = Block {
        counts: Vec::new(),
        pairs: Vec::new(),
        balls: Vec::new(),
        outside: Vec::new(),
        paths: PathCounts::default(),
    };
    let mut row = Vec::new();
    for &particle in particles {
        row.clear();
        let ball = |centre| Ball::new(centre, radii[particle]).map_err(|source| FieldsError::Ball { particle, source });
        let original = ball(positions[particle])?;
        let seed = particle as u64;
        let mut failure = None;
        let reach = if binning.by_centre() { None } else { Some(radii[particle]) };
        periods.for_each_image(positions[particle], reach, |image| match ball(image.centre) {
            Ok(moved) => binning.bin(&moved, &image, seed, scratch, &mut row),
            Err(error) => failure = Some(error),
        });
        if let Some(error) = failure {
            return Err(error);
        }
        merge_equal_cells(&mut row);
        let placed = binning.placed(&original, &row);
        let outside = original.volume() - placed;
        // What rounding leaves of a ball that is all inside is nothing.
        block.outside.push(if outside.abs() < 1e-13 * original.volume() { 0.0 } else { outside });
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

#[cfg(test)]
mod tests {
    use super::*;
    use fieldstone_geometry::{CornerOrder, ElementKind};
    use fieldstone_mesh::{CellList, Mesh};

    /// 4³ unit cubes.
    fn mesh_of_cubes() -> Mesh {
        let points = (0..125).map(|p| [p % 5, p / 5 % 5, p / 25].map(f64::from)).collect();
        let mut cells = CellList::new();
        for at in (0..125u32).filter(|p| p % 5 < 4 && p / 5 % 5 < 4 && p / 25 < 4) {
            let corners = [0, 1, 6, 5, 25, 26, 31, 30].map(|step| at + step);
            cells.push(ElementKind::Hexahedron, CornerOrder::Vtk, &corners).unwrap();
        }
        Mesh::from_cells(points, cells).unwrap()
    }

    #[test]
    fn particles_listed_in_another_order_get_the_same_rows() {
        let cells = mesh_of_cubes();
        // More than one block, all over the box, and two of them at the same place.
        let mut positions: Vec<[f64; 3]> =
            (0..500).map(|i| [7, 11, 13].map(|step| f64::from(i * step % 397) / 100.0)).collect();
        positions[499] = positions[3];
        let radii: Vec<f64> = (0..500).map(|i| 0.1 + 0.001 * f64::from(i)).collect();
        let build = |positions: Vec<[f64; 3]>, radii: Vec<f64>| {
            let particles = Particles::new(positions).unwrap().with_radii(radii).unwrap();
            Weights::build(&cells, &particles, Method::Kernel, None).unwrap()
        };
        let reversed = build(positions.iter().rev().copied().collect(), radii.iter().rev().copied().collect());
        let forward = build(positions, radii);
        for particle in 0..500 {
            assert_eq!(forward.row(particle), reversed.row(499 - particle));
            assert_eq!(forward.particle_volumes()[particle], reversed.particle_volumes()[499 - particle]);
            assert_eq!(forward.outside()[particle], reversed.outside()[499 - particle]);
        }
    }
}
