//! Where kernels are evaluated: the centres of the cells or points around rings, found around a place.

use fieldstone_mesh::{Cells, CylinderGrid, Grid};

/// Cell centres or points around rings, to be found by the box that holds them.
pub(super) enum Places<'a> {
    /// By arithmetic.
    Grid(&'a Grid),
    /// By arithmetic, too: a narrow kernel asks for more points around a ring than memory holds.
    Rings {
        rings: &'a CylinderGrid,
        /// How far apart the points are at most.
        spacing: f64,
    },
    /// By buckets.
    Scattered(Buckets),
}

impl<'a> Places<'a> {
    pub fn new<C: Cells>(cells: &'a C, spacing: f64) -> Self {
        if let Some(grid) = cells.as_grid() {
            return Self::Grid(grid);
        }
        if let Some(rings) = cells.as_rings() {
            return Self::Rings { rings, spacing };
        }
        let centres: Vec<_> = (0..cells.cell_count()).map(|cell| (cell as u32, cells.cell_centre(cell))).collect();
        Self::Scattered(Buckets::new(&centres, cells.averaged()))
    }

    /// Calls `visit` with each cell whose centre lies in the box, the centre, and its share in the cell, in an order that
    /// is always the same; along averaged directions every centre does. Of a ring it visits the points around it.
    #[inline]
    pub fn for_each(&self, low: [f64; 3], high: [f64; 3], mut visit: impl FnMut(u32, f64, [f64; 3])) {
        match self {
            Self::Grid(grid) => {
                let (origin, spacing, count, averaged) = (grid.low(), grid.spacing(), grid.cells(), grid.averaged());
                let mut spans = [[0; 2]; 3];
                for k in 0..3 {
                    let at = |x: f64| (x - origin[k]) / spacing[k] - 0.5;
                    spans[k] = if averaged[k] {
                        [0, 1]
                    } else {
                        // One to either side, for what rounding may have taken away.
                        let first = at(low[k]).floor().clamp(0.0, count[k] as f64) as usize;
                        [first, (at(high[k]).ceil() + 1.0).clamp(0.0, count[k] as f64) as usize]
                    };
                }
                let centre = |axis: usize, i: usize| origin[axis] + (i as f64 + 0.5) * spacing[axis];
                for k in spans[2][0]..spans[2][1] {
                    for j in spans[1][0]..spans[1][1] {
                        let row = grid.cell_at([0, j, k]);
                        let (y, z) = (centre(1, j), centre(2, k));
                        for i in spans[0][0]..spans[0][1] {
                            visit((row + i) as u32, 1.0, [centre(0, i), y, z]);
                        }
                    }
                }
            }
            Self::Rings { rings, spacing } => rings.for_each_ring_point(low, high, *spacing, visit),
            Self::Scattered(buckets) => buckets.for_each(low, high, |cell, centre| visit(cell, 1.0, centre)),
        }
    }
}

/// Points sorted into equal boxes, about two to a box.
pub(super) struct Buckets {
    low: [f64; 3],
    scale: f64,
    counts: [usize; 3],
    ends: Vec<u32>,
    points: Vec<(u32, [f64; 3])>,
    averaged: [bool; 3],
}

impl Buckets {
    fn new(centres: &[(u32, [f64; 3])], averaged: [bool; 3]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (_, p) in centres {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        let extent: [f64; 3] = std::array::from_fn(|k| high[k] - low[k]);
        let longest = extent.into_iter().fold(f64::MIN_POSITIVE, f64::max);
        let bulk: f64 = extent.map(|e| e.max(1e-3 * longest)).iter().product();
        let size = (2.0 * bulk / centres.len().max(1) as f64).cbrt();
        let counts = extent.map(|e| (e / size) as usize + 1);
        let mut this = Self { low, scale: 1.0 / size, counts, ends: Vec::new(), points: Vec::new(), averaged };
        let home: Vec<usize> = centres.iter().map(|&(_, p)| this.bucket(p)).collect();
        let mut ends = vec![0u32; counts.iter().product::<usize>() + 1];
        home.iter().for_each(|&b| ends[b + 1] += 1);
        for b in 1..ends.len() {
            ends[b] += ends[b - 1];
        }
        let mut next = ends.clone();
        let mut points = vec![(0, [0.0; 3]); centres.len()];
        for (&b, &centre) in home.iter().zip(centres) {
            points[next[b] as usize] = centre;
            next[b] += 1;
        }
        this.ends = ends;
        this.points = points;
        this
    }

    fn index(&self, axis: usize, x: f64) -> usize {
        ((x - self.low[axis]) * self.scale).clamp(0.0, (self.counts[axis] - 1) as f64) as usize
    }

    fn bucket(&self, p: [f64; 3]) -> usize {
        self.index(0, p[0]) + self.counts[0] * (self.index(1, p[1]) + self.counts[1] * self.index(2, p[2]))
    }

    fn for_each(&self, low: [f64; 3], high: [f64; 3], mut visit: impl FnMut(u32, [f64; 3])) {
        let span = |axis: usize| {
            if self.averaged[axis] {
                return 0..=self.counts[axis] - 1;
            }
            self.index(axis, low[axis])..=self.index(axis, high[axis])
        };
        for k in span(2) {
            for j in span(1) {
                for i in span(0) {
                    let b = i + self.counts[0] * (j + self.counts[1] * k);
                    for &(cell, p) in &self.points[self.ends[b] as usize..self.ends[b + 1] as usize] {
                        if (0..3).all(|a| self.averaged[a] || (p[a] >= low[a] && p[a] <= high[a])) {
                            visit(cell, p);
                        }
                    }
                }
            }
        }
    }
}
