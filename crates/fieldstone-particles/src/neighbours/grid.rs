use std::ops::Range;

use super::NeighbourOptions;
use super::table::Table;
use crate::ParticlesError;

/// Points sorted by cell, to find all neighbours within a radius.
///
/// Holds every particle once, wrapped into the box, and an [`Image`](super::Image) of each one that reaches in
/// through a periodic boundary, so a displacement is always a plain difference of two sorted positions.
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | reach | largest radius that may be asked for | length |
/// | *sorted index* | place of a point, particle or image, in the sorted arrays | – |
/// | *source* | particle that a sorted point is, or is an image of | – |
///
/// The order is that of the cells, within a cell that of the particles: the same for any number of threads. Memory is
/// about 40 bytes per point and at most 8 cells per point; far outliers share cells with others instead of stretching
/// the grid. Building and one query per particle are linear in their number.
///
/// ```
/// use fieldstone_particles::{Domain, NeighbourGrid, NeighbourOptions};
/// let unit = Domain::new([0.0; 3], [1.0; 3], [true, false, false])?;
/// let options = NeighbourOptions { domain: Some(unit), ..NeighbourOptions::new(0.25) };
/// let grid = NeighbourGrid::build(&[[0.05, 0.5, 0.5], [0.95, 0.5, 0.5], [0.5, 0.5, 0.5]], options)?;
/// let mut found = Vec::new();
/// grid.for_each_neighbour(0, 0.25, |j, displacement, distance_squared| {
///     found.push((j, (displacement[0] * 1e9).round() / 1e9, (distance_squared * 1e9).round() / 1e9));
/// })?;
/// assert_eq!(found, [(1, -0.1, 0.01)]);
/// # Ok::<(), fieldstone_particles::ParticlesError>(())
/// ```
#[derive(Debug, Clone)]
pub struct NeighbourGrid {
    pub(super) options: NeighbourOptions,
    pub(super) table: Table,
    /// First sorted index of each slot, and one more.
    pub(super) starts: Vec<u32>,
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) z: Vec<f64>,
    pub(super) sources: Vec<u32>,
    /// Sorted index of each particle.
    pub(super) ranks: Vec<u32>,
    pub(super) work: super::build::Work,
}

impl NeighbourGrid {
    /// The options that the grid was built with.
    pub fn options(&self) -> &NeighbourOptions {
        &self.options
    }

    /// Largest radius that may be asked for.
    pub fn reach(&self) -> f64 {
        self.options.reach
    }

    /// 2 or 3.
    pub fn dimension(&self) -> usize {
        self.options.dimension
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.ranks.len()
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.ranks.is_empty()
    }

    /// Number of points: particles and images.
    pub fn point_count(&self) -> usize {
        self.sources.len()
    }

    /// x, y and z of all points, in sorted order; z is 0 in two dimensions.
    pub fn sorted_positions(&self) -> [&[f64]; 3] {
        [&self.x, &self.y, &self.z]
    }

    /// The particle that each sorted point is, or is an image of.
    pub fn sources(&self) -> &[u32] {
        &self.sources
    }

    /// What each sorted point is: particle `p` where `p` is below [`len`](Self::len), else image `p − len`.
    ///
    /// The images given to [`build_with_images`](Self::build_with_images) come first, those through periodic
    /// boundaries after them.
    pub fn origins(&self) -> &[u32] {
        &self.work.order
    }

    /// Sorted index of each particle.
    pub fn ranks(&self) -> &[u32] {
        &self.ranks
    }

    /// Whether a sorted point is an image instead of a particle.
    #[inline(always)]
    pub fn is_image(&self, sorted: usize) -> bool {
        self.ranks[self.sources[sorted] as usize] as usize != sorted
    }

    /// Number of cells, most of which may be empty.
    pub fn cell_count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Sorted indices of the points in a cell.
    #[inline(always)]
    pub fn cell(&self, cell: usize) -> Range<usize> {
        self.starts[cell] as usize..self.starts[cell + 1] as usize
    }

    /// Ranges of sorted indices that together hold every point within reach of any point in the cell, each once.
    ///
    /// They hold others, too: the caller tests the distance. For hot kernels, which copy the candidates of a cell once
    /// and use them for all its points.
    #[inline(always)]
    pub fn for_each_range_around(&self, cell: usize, mut visit: impl FnMut(Range<usize>)) {
        self.table.runs_around_slot(cell, |from, to| {
            let range = self.starts[from] as usize..self.starts[to] as usize;
            if !range.is_empty() {
                visit(range);
            }
        });
    }

    /// Calls `visit(j, displacement, distance²)` for every point within `radius` of `at` (`distance ≤ radius`).
    ///
    /// `displacement` leads from `at` to the point; j is the particle, also where an image of it was found, so one
    /// particle may come several times in a small periodic box. `at` is wrapped into the box first.
    ///
    /// # Errors
    /// [`ParticlesError::BeyondReach`] where `radius` exceeds the reach.
    pub fn for_each_within(
        &self,
        at: [f64; 3],
        radius: f64,
        mut visit: impl FnMut(usize, [f64; 3], f64),
    ) -> Result<(), ParticlesError> {
        let at = self.options.domain.map_or(at, |domain| domain.wrap(at));
        self.visit_sorted(at, radius, |sorted, displacement, squared| {
            visit(self.sources[sorted] as usize, displacement, squared);
        })
    }

    /// As [`for_each_within`](Self::for_each_within) around a particle, without the particle itself; its own images
    /// count. A particle at the same place comes with distance 0.
    ///
    /// Give each particle its own `radius` for particle sets of several sizes.
    ///
    /// # Errors
    /// [`ParticlesError::BeyondReach`] where `radius` exceeds the reach; [`ParticlesError::UnknownIndex`].
    pub fn for_each_neighbour(
        &self,
        particle: usize,
        radius: f64,
        mut visit: impl FnMut(usize, [f64; 3], f64),
    ) -> Result<(), ParticlesError> {
        let Some(&rank) = self.ranks.get(particle) else {
            return Err(ParticlesError::UnknownIndex { index: particle, particle_count: self.len() });
        };
        let rank = rank as usize;
        self.visit_sorted([self.x[rank], self.y[rank], self.z[rank]], radius, |sorted, displacement, squared| {
            if sorted != rank {
                visit(self.sources[sorted] as usize, displacement, squared);
            }
        })
    }

    #[inline(always)]
    fn visit_sorted(
        &self,
        at: [f64; 3],
        radius: f64,
        mut visit: impl FnMut(usize, [f64; 3], f64),
    ) -> Result<(), ParticlesError> {
        if radius.is_nan() || radius > self.options.reach {
            return Err(ParticlesError::BeyondReach { radius, reach: self.options.reach });
        }
        if self.sources.is_empty() || radius < 0.0 {
            return Ok(());
        }
        let at = if self.options.dimension == 2 { [at[0], at[1], 0.0] } else { at };
        let limit = radius * radius;
        self.table.runs_around(at, radius, |from, to| {
            let run = self.starts[from] as usize..self.starts[to] as usize;
            let points = self.x[run.clone()].iter().zip(&self.y[run.clone()]).zip(&self.z[run.clone()]);
            for (sorted, ((x, y), z)) in run.zip(points) {
                let displacement = [x - at[0], y - at[1], z - at[2]];
                let [dx, dy, dz] = displacement;
                let squared = dx * dx + dy * dy + dz * dz;
                if squared <= limit {
                    visit(sorted, displacement, squared);
                }
            }
        });
        Ok(())
    }
}
