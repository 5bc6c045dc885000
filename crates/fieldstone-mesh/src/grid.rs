//! Cartesian grids: cells by arithmetic, ball overlaps by the closed form for boxes.

use fieldstone_geometry::{Ball, ElementKind, PROMISE, Polyhedron, corner_volume, fast_overlap_volume, overlap_volume};

use crate::cells::ElementSink;
use crate::{Cells, Coordinates, MeshError, PathCounts};

/// A grid of equal boxes; cells are numbered with x fastest.
///
/// ```
/// use fieldstone_geometry::Ball;
/// use fieldstone_mesh::{Cells, Grid};
/// let grid = Grid::new([0.0; 3], [2.0; 3], [2, 2, 2])?;
/// let mut found = Vec::new();
/// grid.overlap_ball(&Ball::new([1.0; 3], 0.5)?, &mut grid.scratch(), &mut found);
/// // Centred on the common corner: an eighth for each of the eight cells.
/// assert_eq!(found.len(), 8);
/// assert!(found.iter().all(|&(_, v)| (v - std::f64::consts::PI / 48.0).abs() < 1e-16));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    low: [f64; 3],
    high: [f64; 3],
    cells: [usize; 3],
    averaged: [bool; 3],
}

/// Bound of the rounding error of the eightfold difference of [`corner_volume`], relative to r³: twice the largest of 800,000
/// cells cut by random balls, and by such with their centres on and near planes. `error_bounds.rs` repeats them.
pub(crate) const ROUNDING: f64 = 48.0 * f64::EPSILON;

/// Working memory of a [`Grid`]: volumes at the grid's corners around one ball.
#[derive(Debug, Clone, Default)]
pub struct GridScratch {
    planes: [Vec<f64>; 3],
    nodes: Vec<f64>,
    fast: bool,
    counts: PathCounts,
}

impl Grid {
    /// A grid of `cells` boxes between two corners.
    ///
    /// # Errors
    /// [`MeshError::Grid`] for bounds that are not finite or not rising, or no cells along an axis;
    /// [`MeshError::TooLarge`] beyond 2³² − 2 cells; [`MeshError::GridPlanes`] where planes fall together because coordinates of
    /// this size are too coarse for the cells.
    pub fn new(low: [f64; 3], high: [f64; 3], cells: [usize; 3]) -> Result<Self, MeshError> {
        for k in 0..3 {
            let extent = high[k] - low[k];
            if cells[k] == 0 || extent.is_nan() || extent <= 0.0 || extent.is_infinite() {
                return Err(MeshError::Grid { axis: ['x', 'y', 'z'][k], low: low[k], high: high[k], cells: cells[k] });
            }
        }
        let count = cells.iter().try_fold(1usize, |n, &c| n.checked_mul(c)).unwrap_or(usize::MAX);
        if count >= u32::MAX as usize {
            return Err(MeshError::TooLarge { what: "cells", count });
        }
        let this = Self { low, high, cells, averaged: [false; 3] };
        for k in 0..3 {
            // A plane is off by three units of the last digit at most; only below twice that is there anything to look for.
            let largest = low[k].abs().max(high[k].abs());
            if this.spacing()[k] > 8.0 * (largest - largest.next_down()) {
                continue;
            }
            if let Some(plane) = (0..cells[k]).find(|&i| this.plane(k, i + 1) <= this.plane(k, i)) {
                let axis = ['x', 'y', 'z'][k];
                return Err(MeshError::GridPlanes { axis, plane, at: this.plane(k, plane), cells: cells[k] });
            }
        }
        Ok(this)
    }

    /// A grid that resolves the marked directions only; the others have one cell over the whole extent.
    ///
    /// Kernels are integrated along an averaged direction and divided by the extent, whatever lies beyond it; exact
    /// overlaps are with the cell itself.
    ///
    /// # Errors
    /// As [`Grid::new`]; the numbers of cells along averaged directions are not looked at.
    ///
    /// ```
    /// use fieldstone_mesh::{Cells, Grid};
    /// // A profile over depth.
    /// let grid = Grid::resolving([0.0; 3], [4.0, 4.0, 2.0], [1, 1, 20], "Z".parse::<fieldstone_mesh::Coordinates>()?)?;
    /// assert_eq!((grid.cell_count(), grid.averaged()), (20, [true, true, false]));
    /// # Ok::<(), fieldstone_mesh::MeshError>(())
    /// ```
    pub fn resolving(
        low: [f64; 3],
        high: [f64; 3],
        cells: [usize; 3],
        coordinates: Coordinates,
    ) -> Result<Self, MeshError> {
        let averaged = coordinates.resolved().map(|r| !r);
        let cells = std::array::from_fn(|k| if averaged[k] { 1 } else { cells[k] });
        Ok(Self { averaged, ..Self::new(low, high, cells)? })
    }

    /// Lower corner.
    pub fn low(&self) -> [f64; 3] {
        self.low
    }

    /// Upper corner.
    pub fn high(&self) -> [f64; 3] {
        self.high
    }

    /// Cells along each axis.
    pub fn cells(&self) -> [usize; 3] {
        self.cells
    }

    /// Side lengths of a cell.
    pub fn spacing(&self) -> [f64; 3] {
        std::array::from_fn(|k| (self.high[k] - self.low[k]) / self.cells[k] as f64)
    }

    /// Coordinate of grid plane `index` (0 to the number of cells) along `axis`.
    #[inline]
    pub fn plane(&self, axis: usize, index: usize) -> f64 {
        if index == self.cells[axis] {
            return self.high[axis];
        }
        self.low[axis] + (self.high[axis] - self.low[axis]) * (index as f64 / self.cells[axis] as f64)
    }

    /// Number of the cell at the given indices.
    pub fn cell_at(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.cells[0] * (j + self.cells[1] * k)
    }

    /// Indices of a cell.
    pub fn indices(&self, cell: usize) -> [usize; 3] {
        let [nx, ny, _] = self.cells;
        [cell % nx, cell / nx % ny, cell / (nx * ny)]
    }

    /// Centre of a cell.
    pub fn centre(&self, cell: usize) -> [f64; 3] {
        let at = self.indices(cell);
        std::array::from_fn(|k| 0.5 * (self.plane(k, at[k]) + self.plane(k, at[k] + 1)))
    }

    /// Lower and upper corner of a cell.
    pub fn cell_bounds(&self, cell: usize) -> ([f64; 3], [f64; 3]) {
        let at = self.indices(cell);
        (std::array::from_fn(|k| self.plane(k, at[k])), std::array::from_fn(|k| self.plane(k, at[k] + 1)))
    }

    /// Cells along `axis` that an open interval meets, as a half-open range.
    pub fn span(&self, axis: usize, low: f64, high: f64) -> [usize; 2] {
        let count = self.cells[axis];
        let index = |x: f64| {
            let t = (x - self.low[axis]) / (self.high[axis] - self.low[axis]) * count as f64;
            t.floor().clamp(0.0, count as f64) as usize
        };
        // Division and the planes round differently: step to where the planes themselves say.
        let mut first = index(low);
        while first > 0 && self.plane(axis, first) > low {
            first -= 1;
        }
        while first < count && self.plane(axis, first + 1) <= low {
            first += 1;
        }
        let mut last = index(high).max(first);
        while last < count && self.plane(axis, last) < high {
            last += 1;
        }
        while last > first && self.plane(axis, last - 1) >= high {
            last -= 1;
        }
        [first, last]
    }
}

impl Cells for Grid {
    type Scratch = GridScratch;

    const PLACES_IN_MEMORY: bool = false;

    fn scratch(&self) -> GridScratch {
        GridScratch::default()
    }

    fn fast_scratch(&self) -> GridScratch {
        GridScratch { fast: true, ..GridScratch::default() }
    }

    fn path_counts(&self, scratch: &GridScratch) -> PathCounts {
        scratch.counts
    }

    fn cell_count(&self) -> usize {
        self.cells.iter().product()
    }

    fn cell_volume(&self, cell: usize) -> f64 {
        let (low, high) = self.cell_bounds(cell);
        (0..3).map(|k| high[k] - low[k]).product()
    }

    fn cell_centre(&self, cell: usize) -> [f64; 3] {
        self.centre(cell)
    }

    fn averaged(&self) -> [bool; 3] {
        self.averaged
    }

    fn as_grid(&self) -> Option<&Grid> {
        Some(self)
    }

    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        (self.low, self.high)
    }

    /// The volume of the ball below each corner of the grid ([`corner_volume`]), differenced three times: one
    /// closed form per cell instead of eight.
    fn overlap_ball(&self, ball: &Ball, scratch: &mut GridScratch, out: &mut Vec<(u32, f64)>) {
        let (centre, r) = (ball.centre(), ball.radius());
        let spans: [[usize; 2]; 3] =
            std::array::from_fn(|k| self.span(k, (centre[k] - r).next_down(), (centre[k] + r).next_up()));
        if spans.iter().any(|[a, b]| a >= b) {
            return;
        }
        for k in 0..3 {
            let planes = &mut scratch.planes[k];
            planes.clear();
            planes.extend((spans[k][0]..=spans[k][1]).map(|i| (self.plane(k, i) - centre[k]) / r));
        }
        let [xs, ys, zs] = &scratch.planes;
        let nodes = &mut scratch.nodes;
        nodes.clear();
        nodes.reserve(xs.len() * ys.len() * zs.len());
        for &z in zs {
            for &y in ys {
                nodes.extend(xs.iter().map(|&x| corner_volume([x, y, z])));
            }
        }

        let r3 = r * r * r;
        let (nx, ny) = (xs.len(), ys.len());
        let far = |values: &[f64], k: usize| values[k].abs().max(values[k + 1].abs());
        for k in 0..zs.len() - 1 {
            for j in 0..ny - 1 {
                for i in 0..nx - 1 {
                    // A grid's boxes are as near as the nearest of their points: what is apart by this is not evaluated.
                    let near = gap(xs, i).powi(2) + gap(ys, j).powi(2) + gap(zs, k).powi(2);
                    if near >= 1.0 + 8.0 * f64::EPSILON {
                        continue;
                    }
                    let cell = self.cell_at([spans[0][0] + i, spans[1][0] + j, spans[2][0] + k]);
                    let (dx, dy, dz) = (far(xs, i), far(ys, j), far(zs, k));
                    let whole = self.cell_volume(cell);
                    let volume = if dx * dx + dy * dy + dz * dz <= 1.0 - 8.0 * f64::EPSILON {
                        whole
                    } else {
                        let smaller = whole.min(ball.volume());
                        scratch.counts.evaluated += 1;
                        if ROUNDING * r3 <= PROMISE * smaller || scratch.fast {
                            let n = |di: usize, dj: usize, dk: usize| nodes[(i + di) + nx * ((j + dj) + ny * (k + dk))];
                            let top = (n(1, 1, 1) - n(0, 1, 1)) - (n(1, 0, 1) - n(0, 0, 1));
                            let bottom = (n(1, 1, 0) - n(0, 1, 0)) - (n(1, 0, 0) - n(0, 0, 0));
                            ((top - bottom) * r3).clamp(0.0, smaller)
                        } else {
                            let (volume, beyond) = self.overlap_cell(ball, cell);
                            scratch.counts.beyond_f64 += u64::from(beyond);
                            volume
                        }
                    };
                    if volume > 0.0 {
                        out.push((cell as u32, volume));
                    }
                }
            }
        }
    }

    fn overlap_cuboid(&self, low: [f64; 3], high: [f64; 3], _: &mut GridScratch, out: &mut Vec<(u32, f64)>) {
        let spans: [[usize; 2]; 3] = std::array::from_fn(|k| self.span(k, low[k], high[k]));
        let common =
            |axis: usize, i: usize| self.plane(axis, i + 1).min(high[axis]) - self.plane(axis, i).max(low[axis]);
        for k in spans[2][0]..spans[2][1] {
            for j in spans[1][0]..spans[1][1] {
                for i in spans[0][0]..spans[0][1] {
                    let volume = common(0, i) * common(1, j) * common(2, k);
                    if volume > 0.0 {
                        out.push((self.cell_at([i, j, k]) as u32, volume));
                    }
                }
            }
        }
    }

    fn locate(&self, point: [f64; 3], _: &mut GridScratch) -> Option<u32> {
        let mut at = [0; 3];
        for k in 0..3 {
            if !(point[k] >= self.low[k] && point[k] <= self.high[k]) {
                return None;
            }
            // Cells own their lower faces; the last cell its upper one too.
            let [first, _] = self.span(k, point[k], point[k]);
            at[k] = first.min(self.cells[k] - 1);
        }
        Some(self.cell_at(at) as u32)
    }

    fn for_each_neighbour(&self, cell: usize, visit: &mut dyn FnMut(u32, f64)) {
        let at = self.indices(cell);
        let spacing = self.spacing();
        for k in 0..3 {
            for step in [-1isize, 1] {
                let Some(index) = at[k].checked_add_signed(step).filter(|&i| i < self.cells[k]) else { continue };
                let mut other = at;
                other[k] = index;
                let area = spacing[(k + 1) % 3] * spacing[(k + 2) % 3];
                visit(self.cell_at(other) as u32, area / spacing[k]);
            }
        }
    }

    fn for_each_candidate(&self, low: [f64; 3], high: [f64; 3], visit: &mut dyn FnMut(u32)) {
        let spans: [[usize; 2]; 3] = std::array::from_fn(|k| self.span(k, low[k], high[k]));
        for k in spans[2][0]..spans[2][1] {
            for j in spans[1][0]..spans[1][1] {
                for i in spans[0][0]..spans[0][1] {
                    visit(self.cell_at([i, j, k]) as u32);
                }
            }
        }
    }

    fn for_each_element(&self, cell: usize, visit: &mut ElementSink<'_>) {
        let (low, high) = self.cell_bounds(cell);
        let sides = [[low[0], high[0]], [low[1], high[1]], [low[2], high[2]]];
        let order = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
        let corners = order.map(|at: [usize; 3]| [0, 1, 2].map(|k| sides[k][at[k]]));
        visit(1.0, ElementKind::Hexahedron, &corners);
    }

    fn clip_segment(&self, start: [f64; 3], along: [f64; 3], visit: &mut dyn FnMut(u32, f64)) -> bool {
        let ends: [[f64; 2]; 3] = std::array::from_fn(|k| [start[k] + along[k].min(0.0), start[k] + along[k].max(0.0)]);
        // A plane that the segment lies in belongs to the cells above it, the last one to those below, as for points.
        let spans: [[usize; 2]; 3] = std::array::from_fn(|k| {
            let [first, last] = self.span(k, ends[k][0], ends[k][1].next_up());
            if ends[k] == [self.high[k]; 2] { [self.cells[k] - 1, self.cells[k]] } else { [first, last.max(first)] }
        });
        for k in spans[2][0]..spans[2][1] {
            for j in spans[1][0]..spans[1][1] {
                for i in spans[0][0]..spans[0][1] {
                    let at = [i, j, k];
                    let (mut from, mut to) = (0.0f64, 1.0f64);
                    for axis in 0..3 {
                        // Planes that neither end is beyond cut nothing, whatever a quotient of roundings would say.
                        let [low, high] = ends[axis];
                        let [below, above] = [at[axis], at[axis] + 1].map(|index| self.plane(axis, index));
                        let cut = |plane: f64| (plane - start[axis]) / along[axis];
                        let rising = along[axis] > 0.0;
                        if low < below {
                            if rising { from = from.max(cut(below)) } else { to = to.min(cut(below)) }
                        }
                        if high > above {
                            if rising { to = to.min(cut(above)) } else { from = from.max(cut(above)) }
                        }
                    }
                    if to > from {
                        visit(self.cell_at(at) as u32, to - from);
                    }
                }
            }
        }
        true
    }
}

impl Grid {
    /// Overlap with one cell by the general kernel, and whether it took more digits than `f64` has.
    fn overlap_cell(&self, ball: &Ball, cell: usize) -> (f64, bool) {
        let (low, high) = self.cell_bounds(cell);
        // Cells are boxes by construction; one too thin for its coordinates holds nothing.
        let Ok(alone) = Polyhedron::cuboid(low, high) else { return (0.0, false) };
        let (volume, error) = fast_overlap_volume(ball, &alone);
        if error <= PROMISE * alone.volume().min(ball.volume()) {
            (volume, false)
        } else {
            (overlap_volume(ball, &alone), true)
        }
    }
}

/// Distance of the interval `values[k]..values[k + 1]` from 0.
fn gap(values: &[f64], k: usize) -> f64 {
    values[k].max(-values[k + 1]).max(0.0)
}
