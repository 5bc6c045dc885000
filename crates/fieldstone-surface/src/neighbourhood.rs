//! The neighbours of one particle, as a structure of arrays that vectorises.

use std::ops::Range;

use fieldstone_particles::NeighbourGrid;

/// Arrays are filled up to a multiple of this many entries, so that loops need no remainder.
pub(crate) const LANES: usize = 8;

/// Displacements to all neighbours at 0 < d ≤ R of one particle.
///
/// Entries from `len` up to the next multiple of [`LANES`] have displacement 0 and an enormous distance, so that
/// they add nothing to kernel sums and cover no direction.
#[derive(Debug, Default)]
pub(crate) struct Neighbourhood {
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) z: Vec<f64>,
    pub(crate) squared: Vec<f64>,
    /// Sorted indices; only the first `len` are meaningful.
    pub(crate) sorted: Vec<u32>,
    pub(crate) len: usize,
    /// Points at the very place of the particle, itself left out.
    pub(crate) coincident: usize,
}

impl Neighbourhood {
    pub(crate) fn padded_len(&self) -> usize {
        self.len.next_multiple_of(LANES)
    }

    #[inline(always)]
    fn resize(&mut self, capacity: usize) {
        if self.x.len() < capacity {
            self.x.resize(capacity, 0.0);
            self.y.resize(capacity, 0.0);
            self.z.resize(capacity, 0.0);
            self.squared.resize(capacity, 0.0);
            self.sorted.resize(capacity, 0);
        }
    }

    #[inline(always)]
    fn pad(&mut self) {
        for k in self.len..self.padded_len() {
            (self.x[k], self.y[k], self.z[k], self.squared[k]) = (0.0, 0.0, 0.0, f64::MAX);
        }
    }

    /// The neighbours among these whose distance squared is at most `limit`.
    #[inline(always)]
    pub(crate) fn restrict_into(&self, limit: f64, inner: &mut Self) {
        inner.resize(self.padded_len());
        let mut len = 0;
        for k in 0..self.len {
            if self.squared[k] <= limit {
                inner.x[len] = self.x[k];
                inner.y[len] = self.y[k];
                inner.z[len] = self.z[k];
                inner.squared[len] = self.squared[k];
                inner.sorted[len] = self.sorted[k];
                len += 1;
            }
        }
        inner.len = len;
        inner.coincident = self.coincident;
        inner.pad();
    }
}

/// The points around one cell, copied together once for all particles of the cell.
#[derive(Debug, Default)]
pub(crate) struct CellSurroundings {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    sorted: Vec<u32>,
    squared: Vec<f64>,
    hits: Vec<u32>,
}

impl CellSurroundings {
    #[inline(always)]
    pub(crate) fn collect(&mut self, grid: &NeighbourGrid, cell: usize) {
        let [x, y, z] = grid.sorted_positions();
        self.x.clear();
        self.y.clear();
        self.z.clear();
        self.sorted.clear();
        grid.for_each_range_around(cell, |range: Range<usize>| {
            self.x.extend_from_slice(&x[range.clone()]);
            self.y.extend_from_slice(&y[range.clone()]);
            self.z.extend_from_slice(&z[range.clone()]);
            self.sorted.extend(range.start as u32..range.end as u32);
        });
        self.squared.resize(self.x.len(), 0.0);
        self.hits.resize(self.x.len() + 1, 0);
    }

    /// The neighbours of the point at `at` within the square root of `limit`.
    #[inline(always)]
    pub(crate) fn neighbours_of(&mut self, at: [f64; 3], limit: f64, hood: &mut Neighbourhood) {
        let count = self.x.len();
        let (x, y, z, squared) = (&self.x[..count], &self.y[..count], &self.z[..count], &mut self.squared[..count]);
        for k in 0..count {
            let (dx, dy, dz) = (x[k] - at[0], y[k] - at[1], z[k] - at[2]);
            squared[k] = dx * dx + dy * dy + dz * dz;
        }
        // Without a branch: hits and misses come in no order that a processor could predict.
        let hits = &mut self.hits[..];
        let (mut len, mut at_zero) = (0, 0);
        for (k, &s) in squared.iter().enumerate() {
            hits[len] = k as u32;
            len += usize::from(s <= limit) & usize::from(s > 0.0);
            at_zero += usize::from(s == 0.0);
        }
        hood.resize(len.next_multiple_of(LANES));
        let hits = &hits[..len];
        let (hx, hy, hz) = (&mut hood.x[..len], &mut hood.y[..len], &mut hood.z[..len]);
        let (hs, hi) = (&mut hood.squared[..len], &mut hood.sorted[..len]);
        for (n, &k) in hits.iter().enumerate() {
            let k = k as usize;
            hx[n] = x[k] - at[0];
            hy[n] = y[k] - at[1];
            hz[n] = z[k] - at[2];
            hs[n] = squared[k];
            hi[n] = self.sorted[k];
        }
        hood.len = len;
        hood.coincident = usize::saturating_sub(at_zero, 1);
        hood.pad();
    }
}
