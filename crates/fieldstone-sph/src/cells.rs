//! Points sorted into cells, to find those near a box.

use rayon::prelude::*;

/// Cells per point, beyond which cells grow: a few far points must not cost the memory of a fine grid.
const CELLS_PER_POINT: usize = 8;

/// Where cells are.
#[derive(Debug, Clone, Copy, Default)]
struct CellFrame {
    low: [f64; 3],
    width: f64,
    inverse_width: f64,
    slots: [usize; 3],
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
    fn slot(&self, axis: usize, x: f64) -> usize {
        (((x - self.low[axis]) * self.inverse_width) as usize).min(self.slots[axis] - 1)
    }

    /// Distance along an axis of a layer of cells from an interval.
    #[inline(always)]
    fn distance(&self, axis: usize, slot: usize, low: f64, high: f64) -> f64 {
        let from = self.low[axis] + slot as f64 * self.width;
        (from - high).max(low - (from + self.width)).max(0.0)
    }
}

/// Memory of a search.
#[derive(Debug, Default)]
pub(crate) struct Near {
    squares: Vec<f64>,
    places: Vec<u32>,
}

/// Cells of equal width that cover all points; those of a row along x follow each other in memory.
#[derive(Debug, Default)]
pub(crate) struct Cells {
    frame: CellFrame,
    /// First place of each cell, and one more.
    starts: Vec<u32>,
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

    /// Places of all points within `reach` of a box, in the order of the cells.
    ///
    /// To be compiled with the processor's features, like its caller.
    #[inline(always)]
    pub(crate) fn near_box<'a>(&self, low: [f64; 3], high: [f64; 3], reach: f64, near: &'a mut Near) -> &'a [u32] {
        let Near { squares, places } = near;
        let frame = self.frame;
        // Points are put into cells with rounding.
        let padded = reach + 1e-6 * frame.width;
        let (mut len, limit) = (0, reach * reach);
        for slot_z in frame.slot(2, low[2] - padded)..=frame.slot(2, high[2] + padded) {
            let dz = frame.distance(2, slot_z, low[2], high[2]);
            for slot_y in frame.slot(1, low[1] - padded)..=frame.slot(1, high[1] + padded) {
                let dy = frame.distance(1, slot_y, low[1], high[1]);
                let left = padded * padded - dy * dy - dz * dz;
                if left < 0.0 {
                    continue;
                }
                let along = left.sqrt();
                let row = (slot_z * frame.slots[1] + slot_y) * frame.slots[0];
                let from = self.starts[row + frame.slot(0, low[0] - along)] as usize;
                let to = self.starts[row + frame.slot(0, high[0] + along) + 1] as usize;
                let count = to - from;
                let (xs, ys, zs) = (&self.x[from..to], &self.y[from..to], &self.z[from..to]);
                if squares.len() < count {
                    squares.resize(count, 0.0);
                }
                let squares = &mut squares[..count];
                for k in 0..count {
                    let dx = beyond(xs[k], low[0], high[0]);
                    let dy = beyond(ys[k], low[1], high[1]);
                    let dz = beyond(zs[k], low[2], high[2]);
                    squares[k] = dx * dx + dy * dy + dz * dz;
                }
                if places.len() < len + count {
                    places.resize(len + count + 1024, 0);
                }
                // Without a branch: hits and misses come in no order that a processor could predict.
                let room = &mut places[len..len + count];
                let mut found = 0;
                for (place, square) in (from..to).zip(squares.iter()) {
                    room[found] = place as u32;
                    found += usize::from(*square <= limit);
                }
                len += found;
            }
        }
        &places[..len]
    }

    /// Bytes that the cells take.
    pub(crate) fn bytes(&self) -> usize {
        self.points.len() * (3 * 8 + 4 + 4) + self.starts.len() * 4
    }
}

/// Distance of a coordinate from an interval.
#[inline(always)]
fn beyond(x: f64, low: f64, high: f64) -> f64 {
    let (under, over) = (low - x, x - high);
    let outside = if under > over { under } else { over };
    if outside > 0.0 { outside } else { 0.0 }
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
