//! Points sorted into cells, to find those near a box.

use rayon::prelude::*;

/// Cells per point, beyond which cells grow: a few far points must not cost the memory of a fine grid.
const CELLS_PER_POINT: usize = 8;

/// Where cells are.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CellFrame {
    pub(crate) low: [f64; 3],
    pub(crate) width: f64,
    inverse_width: f64,
    pub(crate) slots: [usize; 3],
}

impl CellFrame {
    /// A frame of cells of at least `width` around points.
    fn new(positions: &[[f64; 3]], width: f64) -> Self {
        let (low, high) = bounds(positions);
        let most = CELLS_PER_POINT * positions.len() + 1024;
        let mut width = width;
        loop {
            let inverse_width = 1.0 / width;
            let slots: [usize; 3] = std::array::from_fn(|k| ((high[k] - low[k]) * inverse_width) as usize);
            let product = slots.iter().try_fold(1usize, |product, &s| product.checked_mul(s.checked_add(1)?));
            if product.is_some_and(|p| p <= most) {
                return Self { low, width, inverse_width, slots: slots.map(|s| s + 1) };
            }
            width *= 1.25;
        }
    }

    /// Cell of a coordinate; the first or the last one for what lies beyond or is not a number.
    #[inline(always)]
    pub(crate) fn slot(&self, axis: usize, x: f64) -> usize {
        (((x - self.low[axis]) * self.inverse_width) as usize).min(self.slots[axis] - 1)
    }
}

/// Cells of equal width that cover all points; those of a row along x follow each other in memory.
#[derive(Debug, Default)]
pub(crate) struct Cells {
    pub(crate) frame: CellFrame,
    /// First place of each cell, and one more.
    pub(crate) starts: Vec<u32>,
    /// Coordinates and index of the point at each place.
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) z: Vec<f64>,
    pub(crate) points: Vec<u32>,
    cell_of: Vec<u32>,
}

impl Cells {
    /// Sorts points into cells of at least `width`; those of a cell keep their order.
    pub(crate) fn rebuild(&mut self, positions: &[[f64; 3]], width: f64) {
        let frame = CellFrame::new(positions, width);
        self.frame = frame;
        let [nx, ny, nz] = frame.slots;
        positions
            .par_iter()
            .map(|x| {
                let [i, j, k]: [usize; 3] = std::array::from_fn(|k| frame.slot(k, x[k]));
                ((k * ny + j) * nx + i) as u32
            })
            .collect_into_vec(&mut self.cell_of);
        let starts = &mut self.starts;
        starts.clear();
        starts.resize(nx * ny * nz + 1, 0);
        for &cell in &self.cell_of {
            starts[cell as usize + 1] += 1;
        }
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        self.points.resize(positions.len(), 0);
        for (point, &cell) in self.cell_of.iter().enumerate() {
            let next = &mut starts[cell as usize];
            self.points[*next as usize] = point as u32;
            *next += 1;
        }
        // Each start has moved to its cell's end, which is the next one's start.
        starts.copy_within(0..nx * ny * nz, 1);
        starts[0] = 0;
        let points = &self.points;
        points.par_iter().map(|&p| positions[p as usize][0]).collect_into_vec(&mut self.x);
        points.par_iter().map(|&p| positions[p as usize][1]).collect_into_vec(&mut self.y);
        points.par_iter().map(|&p| positions[p as usize][2]).collect_into_vec(&mut self.z);
    }

    /// Bytes that the cells take.
    pub(crate) fn bytes(&self) -> usize {
        self.points.len() * (3 * 8 + 4 + 4) + self.starts.len() * 4
    }
}

/// The box around all finite points; a point at the origin where there is none.
fn bounds(positions: &[[f64; 3]]) -> ([f64; 3], [f64; 3]) {
    let none = || ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let (low, high) = positions
        .par_iter()
        .filter(|x| x.iter().all(|x| x.is_finite()))
        .fold(none, |(low, high), x| {
            (std::array::from_fn(|k| x[k].min(low[k])), std::array::from_fn(|k| x[k].max(high[k])))
        })
        .reduce(none, |a, b| {
            (std::array::from_fn(|k| a.0[k].min(b.0[k])), std::array::from_fn(|k| a.1[k].max(b.1[k])))
        });
    if low[0] <= high[0] { (low, high) } else { ([0.0; 3], [0.0; 3]) }
}
