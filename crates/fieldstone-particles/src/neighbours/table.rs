//! Which slot of a bounded table a cell of the unbounded grid falls into.

/// Cells per reach along each axis. Two: 125 small cells hold 40 % fewer strangers than 27 large ones.
pub(super) const CELLS_PER_REACH: i64 = 2;

/// Cell coordinates saturate here: beyond, rounding of position over width would exceed the cells' margin.
const FARTHEST_CELL: f64 = 1e9;

/// Axis-parallel cells of equal width, folded into a table of bounded size.
///
/// Cell `c` of an axis goes to slot `c mod slots`. Where the cloud is larger than the table, distant cells share a
/// slot; the distance test tells them apart, so an outlier costs neither memory nor correctness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Table {
    origin: [f64; 3],
    inverse_width: f64,
    slots: [i64; 3],
}

impl Default for Table {
    fn default() -> Self {
        Self { origin: [0.0; 3], inverse_width: 1.0, slots: [1; 3] }
    }
}

impl Table {
    /// A table for points between `low` and `high`, most of them between `core_low` and `core_high`.
    pub(super) fn new(
        low: [f64; 3],
        high: [f64; 3],
        core: impl FnOnce() -> [[f64; 3]; 2],
        reach: f64,
        cap: usize,
    ) -> Self {
        // The margin keeps two points within reach at most CELLS_PER_REACH cells apart whatever the rounding.
        let inverse_width = CELLS_PER_REACH as f64 / (reach * (1.0 + 4e-6));
        let cells = |low: [f64; 3], high: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|k| (((high[k] - low[k]) * inverse_width).floor() + 1.0).clamp(1.0, FARTHEST_CELL))
        };
        let mut origin = low;
        let mut extent = cells(low, high);
        let cap = cap as f64;
        if extent.iter().product::<f64>() > cap {
            let [core_low, core_high] = core();
            // An outlier at the origin would push the cloud itself to where coordinates saturate.
            origin = core_low;
            extent = cells(core_low, core_high).map(|c| c + 2.0 * CELLS_PER_REACH as f64);
            while extent.iter().product::<f64>() > cap {
                let longest = extent.iter().copied().fold(0.0, f64::max);
                let axis = extent.iter().position(|&c| c == longest).unwrap_or(0);
                extent[axis] = (0.8 * extent[axis]).floor().max(1.0);
            }
        }
        Self { origin, inverse_width, slots: extent.map(|c| c as i64) }
    }

    /// Number of slots.
    pub(super) fn len(&self) -> usize {
        (self.slots[0] * self.slots[1] * self.slots[2]) as usize
    }

    #[inline(always)]
    fn cell(&self, axis: usize, x: f64) -> i64 {
        ((x - self.origin[axis]) * self.inverse_width).floor().clamp(-FARTHEST_CELL, FARTHEST_CELL) as i64
    }

    #[inline(always)]
    fn fold(&self, axis: usize, cell: i64) -> i64 {
        // Cells outside the table are rare, and the division of a remainder is slow.
        if cell >= 0 && cell < self.slots[axis] { cell } else { cell.rem_euclid(self.slots[axis]) }
    }

    /// Slot of a point.
    #[inline(always)]
    pub(super) fn slot(&self, x: [f64; 3]) -> usize {
        let [i, j, k]: [i64; 3] = std::array::from_fn(|axis| self.fold(axis, self.cell(axis, x[axis])));
        ((k * self.slots[1] + j) * self.slots[0] + i) as usize
    }

    /// Runs of consecutive slots that hold all points within `radius` of `x`.
    #[inline(always)]
    pub(super) fn runs_around(&self, x: [f64; 3], radius: f64, mut visit: impl FnMut(usize, usize)) {
        let padded = radius * (1.0 + 1e-9);
        let first = std::array::from_fn(|axis| self.cell(axis, x[axis] - padded));
        let last = std::array::from_fn(|axis| self.cell(axis, x[axis] + padded));
        self.runs(first, last, &mut visit);
    }

    /// Runs of consecutive slots that hold all points within reach of any point in `slot`.
    #[inline(always)]
    pub(super) fn runs_around_slot(&self, slot: usize, mut visit: impl FnMut(usize, usize)) {
        let slot = slot as i64;
        let row = slot / self.slots[0];
        let home = [slot % self.slots[0], row % self.slots[1], row / self.slots[1]];
        self.runs(home.map(|c| c - CELLS_PER_REACH), home.map(|c| c + CELLS_PER_REACH), &mut visit);
    }

    /// No slot is visited twice, even where the cells asked for outnumber the slots.
    #[inline(always)]
    fn runs(&self, first: [i64; 3], last: [i64; 3], visit: &mut impl FnMut(usize, usize)) {
        let span: [i64; 3] = std::array::from_fn(|k| (last[k] - first[k] + 1).min(self.slots[k]));
        let start: [i64; 3] = std::array::from_fn(|k| self.fold(k, first[k]));
        let [nx, ny, nz] = self.slots;
        for dk in 0..span[2] {
            let k = (start[2] + dk) % nz;
            for dj in 0..span[1] {
                let j = (start[1] + dj) % ny;
                let row = (k * ny + j) * nx;
                let end = start[0] + span[0];
                visit((row + start[0]) as usize, (row + end.min(nx)) as usize);
                if end > nx {
                    visit(row as usize, (row + end - nx) as usize);
                }
            }
        }
    }
}
