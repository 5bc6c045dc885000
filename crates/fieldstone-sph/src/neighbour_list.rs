//! Neighbours of each receiver as indices of sorted points, kept over stages and steps.

use fieldstone_particles::NeighbourGrid;
use rayon::prelude::*;

/// Lanes of the sums over neighbours; lists are filled up to multiples of it.
pub(crate) const LANES: usize = 8;

/// Receivers per task.
pub(crate) const CHUNK: usize = 512;

/// Lists of consecutive receivers.
#[derive(Debug, Default)]
struct Chunk {
    /// Start of each receiver's list in `neighbours`, and one more.
    starts: Vec<u32>,
    neighbours: Vec<u32>,
}

/// For each receiver the sorted points within a reach, itself among them.
///
/// A list is filled up with the receiver's own index: at distance 0 it adds nothing to any sum.
#[derive(Debug, Default)]
pub(crate) struct NeighbourList {
    chunks: Vec<Chunk>,
}

/// Memory of one task.
#[derive(Debug, Default)]
struct Candidates {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    sorted: Vec<u32>,
    squared: Vec<f64>,
}

impl NeighbourList {
    /// Builds the lists for receivers given by their sorted indices.
    pub(crate) fn rebuild(&mut self, grid: &NeighbourGrid, receivers: &[u32], reach: f64) {
        let mut cell_of = vec![0u32; grid.point_count()];
        for cell in 0..grid.cell_count() {
            cell_of[grid.cell(cell)].fill(cell as u32);
        }
        self.chunks.resize_with(receivers.len().div_ceil(CHUNK), Chunk::default);
        self.chunks.par_iter_mut().zip(receivers.par_chunks(CHUNK)).for_each_init(
            Candidates::default,
            |candidates, (chunk, receivers)| {
                let task = Build { grid, receivers, cell_of: &cell_of, limit: reach * reach, chunk, candidates };
                pulp::Arch::new().dispatch(task);
            },
        );
    }

    /// Bytes that the lists take.
    pub(crate) fn bytes(&self) -> usize {
        self.chunks.iter().map(|c| 4 * (c.starts.capacity() + c.neighbours.capacity())).sum()
    }

    /// Number of entries, padding included.
    pub(crate) fn entries(&self) -> usize {
        self.chunks.iter().map(|c| c.neighbours.len()).sum()
    }

    /// The list of one receiver.
    pub(crate) fn of(&self, receiver: usize) -> &[u32] {
        let chunk = &self.chunks[receiver / CHUNK];
        let local = receiver % CHUNK;
        &chunk.neighbours[chunk.starts[local] as usize..chunk.starts[local + 1] as usize]
    }

    /// Fills `outputs`, one per receiver. Each depends on its own list only, so threads do not matter.
    pub(crate) fn sum<P: PairSum>(&self, pass: &P, outputs: &mut [P::Output]) {
        self.chunks.par_iter().zip(outputs.par_chunks_mut(CHUNK)).enumerate().for_each_init(
            P::Scratch::default,
            |scratch, (index, (chunk, outputs))| {
                pulp::Arch::new().dispatch(Sum { pass, first: index * CHUNK, chunk, outputs, scratch });
            },
        );
    }
}

/// A sum over the neighbours of each receiver.
pub(crate) trait PairSum: Sync {
    type Scratch: Default;
    type Output: Send;

    /// `list` has a multiple of [`LANES`] entries. Must be `#[inline(always)]`, and hold plain loops only: closures
    /// are not compiled with the processor's features.
    fn of(&self, receiver: usize, list: &[u32], scratch: &mut Self::Scratch) -> Self::Output;
}

struct Sum<'a, P: PairSum> {
    pass: &'a P,
    first: usize,
    chunk: &'a Chunk,
    outputs: &'a mut [P::Output],
    scratch: &'a mut P::Scratch,
}

impl<P: PairSum> pulp::NullaryFnOnce for Sum<'_, P> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { pass, first, chunk, outputs, scratch } = self;
        for (local, output) in outputs.iter_mut().enumerate() {
            let list = &chunk.neighbours[chunk.starts[local] as usize..chunk.starts[local + 1] as usize];
            *output = pass.of(first + local, list, scratch);
        }
    }
}

struct Build<'a> {
    grid: &'a NeighbourGrid,
    receivers: &'a [u32],
    cell_of: &'a [u32],
    limit: f64,
    chunk: &'a mut Chunk,
    candidates: &'a mut Candidates,
}

impl pulp::NullaryFnOnce for Build<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { grid, receivers, cell_of, limit, chunk, candidates } = self;
        let Candidates { x, y, z, sorted, squared } = candidates;
        let Chunk { starts, neighbours } = chunk;
        let [px, py, pz] = grid.sorted_positions();
        starts.clear();
        starts.push(0);
        neighbours.clear();
        let mut cell = u32::MAX;
        let mut len = 0;
        for &receiver in receivers {
            let r = receiver as usize;
            if cell_of[r] != cell {
                cell = cell_of[r];
                x.clear();
                y.clear();
                z.clear();
                sorted.clear();
                grid.for_each_range_around(cell as usize, |range| {
                    x.extend_from_slice(&px[range.clone()]);
                    y.extend_from_slice(&py[range.clone()]);
                    z.extend_from_slice(&pz[range.clone()]);
                    sorted.extend(range.start as u32..range.end as u32);
                });
                squared.resize(x.len(), 0.0);
            }
            let count = x.len();
            let (xi, yi, zi) = (px[r], py[r], pz[r]);
            let (xs, ys, zs) = (&x[..count], &y[..count], &z[..count]);
            let squares = &mut squared[..count];
            for k in 0..count {
                let (dx, dy, dz) = (xs[k] - xi, ys[k] - yi, zs[k] - zi);
                squares[k] = dx * dx + dy * dy + dz * dz;
            }
            if neighbours.len() < len + count + LANES {
                neighbours.resize(len + 2 * count + 64 * LANES, 0);
            }
            // Without a branch: hits and misses come in no order that a processor could predict.
            let mut found = 0;
            let room = &mut neighbours[len..len + count + LANES];
            for k in 0..count {
                room[found] = sorted[k];
                found += usize::from(squares[k] <= limit);
            }
            let padded = found.next_multiple_of(LANES);
            for slot in &mut room[found..padded] {
                *slot = receiver;
            }
            len += padded;
            starts.push(len as u32);
        }
        neighbours.truncate(len);
    }
}
