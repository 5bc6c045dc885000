//! The volume that each particle has in each cell, as a sparse matrix.

use fieldstone_geometry::Ball;
use fieldstone_mesh::{Cells, PathCounts};
use fieldstone_particles::{Domain, Particles};
use rayon::prelude::*;

use crate::binning::Binning;
use crate::periodic::Periods;
use crate::scatter::{Order, Pair, Sums};
use crate::{FieldsError, Method};

/// Particles handled by one task: large enough to hide its cost, small enough to balance.
const BLOCK: usize = 128;

/// Radius over the length of a periodic box beyond which units must be wrong, and images too many to count.
const MOST_IMAGES: f64 = 20.0;

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
    /// Particles without radii; a particle that is no ball; a periodic box of which more than 10⁵ copies reach the cells.
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
        // The cube of a smaller one is 0, that of a larger one or a sum of them infinite. All are looked at before any
        // is binned, so that it is always the first one that is named.
        if let Some(particle) = radii.iter().position(|r| !(1e-100..=1e100).contains(r)) {
            return Err(FieldsError::RadiusRange { particle, radius: radii[particle] });
        }
        if let Some(domain) = domain {
            let shortest =
                (0..3).filter(|&k| domain.periodic()[k]).map(|k| domain.heights()[k]).fold(f64::INFINITY, f64::min);
            if let Some(particle) = radii.iter().position(|&r| r > MOST_IMAGES * shortest) {
                return Err(FieldsError::RadiusBox { particle, radius: radii[particle], length: shortest });
            }
        }
        let periods = Periods::new(domain, [false; 3], cells.bounds());
        periods.check()?;
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

        // Back into the order of the particles: first the length of each row, then what is in it.
        let mut ends = vec![0; positions.len()];
        let mut paths = PathCounts::default();
        let (mut balls, mut outside) = (vec![0.0; positions.len()], vec![0.0; positions.len()]);
        for (particles, block) in order.chunks(BLOCK).zip(&blocks) {
            paths.evaluated += block.paths.evaluated;
            paths.beyond_f64 += block.paths.beyond_f64;
            for (k, &particle) in particles.iter().enumerate() {
                ends[particle] = block.counts[k];
                balls[particle] = block.balls[k];
                outside[particle] = block.outside[k];
            }
        }
        let mut end = 0;
        for entry in &mut ends {
            end += *entry;
            *entry = end;
        }
        let mut rows = vec![(0u32, 0u32); positions.len()];
        for (index, (particles, block)) in order.chunks(BLOCK).zip(&blocks).enumerate() {
            let mut start = 0;
            for (&particle, &count) in particles.iter().zip(&block.counts) {
                rows[particle] = (index as u32, start);
                start += count as u32;
            }
        }
        let (mut all_cells, mut volumes) = (vec![0; end], vec![0.0; end]);
        // Rows are copied to where they belong in parallel: each task has its own part of the result.
        let mut parts = Vec::with_capacity(blocks.len());
        let (mut cells_left, mut volumes_left) = (&mut all_cells[..], &mut volumes[..]);
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
        Ok(Self { ends, cells: all_cells, volumes, balls, outside, cell_count: cells.cell_count(), paths })
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

pub(crate) fn check_length(what: &'static str, found: usize, expected: usize) -> Result<(), FieldsError> {
    if found == expected { Ok(()) } else { Err(FieldsError::Length { what, found, expected }) }
}

/// The particles in an order in which neighbours in the list are neighbours in space.
///
/// A simulation lists them in any order. The cells and faces around a ball are some kilobytes, and a mesh of any size
/// is beyond the caches: in the order of the list every ball would wait for memory.
///
/// The order is Morton's curve through 1024³ boxes around all particles, equal boxes by number.
pub(crate) fn along_a_curve(positions: &[[f64; 3]]) -> Vec<usize> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in positions {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    // Boxes are cubes: a flat layer of particles is walked as a layer.
    let extent = (0..3).map(|k| high[k] - low[k]).fold(f64::MIN_POSITIVE, f64::max);
    let mut keyed: Vec<(u32, usize)> = positions
        .par_iter()
        .enumerate()
        .map(|(particle, p)| {
            let key = (0..3).fold(0, |key, k| key | spread_bits(((p[k] - low[k]) / extent * 1023.0) as u32) << k);
            (key, particle)
        })
        .collect();
    keyed.par_sort_unstable();
    keyed.into_iter().map(|(_, particle)| particle).collect()
}

/// The lowest ten bits, two zeros between each and the next.
fn spread_bits(x: u32) -> u32 {
    let x = x.min(1023);
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
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
        if periods.any() {
            let mut failure = None;
            let reach = if binning.by_centre() { None } else { Some(radii[particle]) };
            periods.for_each_image(positions[particle], reach, |centre| match ball(centre) {
                Ok(image) => binning.bin(&image, seed, scratch, &mut row),
                Err(error) => failure = Some(error),
            });
            if let Some(error) = failure {
                return Err(error);
            }
        } else {
            binning.bin(&original, seed, scratch, &mut row);
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

    #[test]
    fn the_curve_visits_every_particle_once_also_in_a_plane_or_at_one_point() {
        for spread in [[1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [0.0; 3]] {
            let positions: Vec<[f64; 3]> =
                (0..1000).map(|i| [0, 1, 2].map(|k| spread[k] * f64::from(i * (2 * k as i32 + 7) % 101))).collect();
            let mut order = along_a_curve(&positions);
            order.sort_unstable();
            assert_eq!(order, (0..1000).collect::<Vec<_>>());
        }
        assert!(along_a_curve(&[]).is_empty());
    }
}
