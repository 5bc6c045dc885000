//! Neighbours of clusters of receivers as indices of points, kept over stages and steps.

use rayon::prelude::*;

use crate::cells::Cells;
use crate::kernel::Receivers;

/// Receivers of a cluster: the lanes of the sums.
pub(crate) const LANES: usize = 8;

/// Clusters per task.
const CHUNK: usize = 32;

/// Cells per reach along each axis.
pub(crate) const CELLS_PER_REACH: f64 = 3.0;

/// Lists of consecutive clusters.
#[derive(Debug, Default)]
struct Chunk {
    /// Start of each cluster's list in `neighbours`, and one more.
    starts: Vec<u32>,
    neighbours: Vec<u32>,
}

/// For each cluster of receivers the points within a reach of any of them, themselves included.
///
/// A cluster is [`LANES`] consecutive points. One list for all of them is twice as long as each one's own, but a
/// neighbour's columns are read once for all lanes, nothing has to be brought into lanes or summed over them, and the
/// list is found in a fraction of the time.
#[derive(Debug, Default)]
pub(crate) struct NeighbourList {
    first: usize,
    count: usize,
    chunks: Vec<Chunk>,
}

/// Memory of one task.
#[derive(Debug, Default)]
struct Candidates {
    /// Squares of distances from the box around a cluster.
    squares: Vec<f64>,
    /// Places, among the cells' points, of those within reach of the box.
    places: Vec<u32>,
}

impl NeighbourList {
    /// Builds the lists for `count` receivers, points from `first` on.
    pub(crate) fn rebuild(&mut self, cells: &Cells, positions: &[[f64; 3]], first: usize, count: usize, reach: f64) {
        self.first = first;
        self.count = count;
        self.chunks.resize_with(count.div_ceil(CHUNK * LANES), Chunk::default);
        let receivers = positions[first..first + count].par_chunks(CHUNK * LANES);
        self.chunks.par_iter_mut().zip(receivers).for_each_init(
            Candidates::default,
            |candidates, (chunk, receivers)| {
                pulp::Arch::new().dispatch(Build { cells, receivers, reach, chunk, candidates });
            },
        );
    }

    /// Bytes that the lists take.
    pub(crate) fn bytes(&self) -> usize {
        self.chunks.iter().map(|c| 4 * (c.starts.capacity() + c.neighbours.capacity())).sum()
    }

    /// The list of the cluster of one receiver: all that is within its reach, and more.
    pub(crate) fn of(&self, receiver: usize) -> &[u32] {
        let cluster = receiver / LANES;
        let (chunk, local) = (&self.chunks[cluster / CHUNK], cluster % CHUNK);
        &chunk.neighbours[chunk.starts[local] as usize..chunk.starts[local + 1] as usize]
    }

    /// Fills `outputs`, one per receiver. Each depends on its own list only, so threads do not matter.
    pub(crate) fn sum<P: PairSum>(&self, pass: &P, outputs: &mut [P::Output]) {
        self.chunks.par_iter().zip(outputs.par_chunks_mut(CHUNK * LANES)).enumerate().for_each(
            |(index, (chunk, outputs))| {
                let first = self.first + index * CHUNK * LANES;
                pulp::Arch::new().dispatch(Sum { pass, first, chunk, outputs });
            },
        );
    }
}

/// Neighbours per block: roots are found for a whole block before they are used, because one after the other a
/// processor would mostly wait for them.
pub(crate) const BLOCK: usize = 32;

/// A sum over the neighbours of each receiver.
pub(crate) trait PairSum: Sync {
    type Output: Send + Copy;

    /// Sums of a cluster's members. Must be `#[inline(always)]`, and hold plain loops only: closures are not compiled
    /// with the processor's features.
    fn of(&self, members: &[u32; LANES], list: &[u32]) -> [Self::Output; LANES];
}

struct Sum<'a, P: PairSum> {
    pass: &'a P,
    first: usize,
    chunk: &'a Chunk,
    outputs: &'a mut [P::Output],
}

impl<P: PairSum> pulp::NullaryFnOnce for Sum<'_, P> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { pass, first, chunk, outputs } = self;
        for (local, outputs) in outputs.chunks_mut(LANES).enumerate() {
            let list = &chunk.neighbours[chunk.starts[local] as usize..chunk.starts[local + 1] as usize];
            let mut members = [0; LANES];
            for l in 0..LANES {
                // Lanes without a receiver repeat the last one.
                members[l] = (first + local * LANES + l.min(outputs.len() - 1)) as u32;
            }
            let sums = pass.of(&members, list);
            outputs.copy_from_slice(&sums[..outputs.len()]);
        }
    }
}

struct Build<'a> {
    cells: &'a Cells,
    receivers: &'a [[f64; 3]],
    reach: f64,
    chunk: &'a mut Chunk,
    candidates: &'a mut Candidates,
}

/// Distance of two intervals.
#[inline(always)]
fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[1]).max(b[0] - a[1]).max(0.0)
}

/// Distance of a coordinate from an interval.
#[inline(always)]
fn beyond(x: f64, low: f64, high: f64) -> f64 {
    let (under, over) = (low - x, x - high);
    let outside = if under > over { under } else { over };
    if outside > 0.0 { outside } else { 0.0 }
}

impl pulp::NullaryFnOnce for Build<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { cells, receivers, reach, chunk, candidates } = self;
        let Candidates { squares, places } = candidates;
        let Chunk { starts, neighbours } = chunk;
        let frame = cells.frame;
        let limit = reach * reach;
        // Points are put into cells with rounding.
        let padded = reach + 1e-6 * frame.width;
        starts.clear();
        starts.push(0);
        let mut len = 0;
        for members in receivers.chunks(LANES) {
            let mut at = Receivers { x: [0.0; LANES], y: [0.0; LANES], z: [0.0; LANES] };
            for l in 0..LANES {
                [at.x[l], at.y[l], at.z[l]] = members[l.min(members.len() - 1)];
            }
            let (mut low, mut high) = (members[0], members[0]);
            for x in members {
                for k in 0..3 {
                    low[k] = if x[k] < low[k] { x[k] } else { low[k] };
                    high[k] = if x[k] > high[k] { x[k] } else { high[k] };
                }
            }
            let mut near = 0;
            let [_, y0, z0] = [0, 1, 2].map(|k| frame.slot(k, low[k] - padded));
            let [_, y1, z1] = [0, 1, 2].map(|k| frame.slot(k, high[k] + padded));
            for slot_z in z0..=z1 {
                let from = frame.low[2] + slot_z as f64 * frame.width;
                let dz = apart([from, from + frame.width], [low[2], high[2]]);
                for slot_y in y0..=y1 {
                    let from = frame.low[1] + slot_y as f64 * frame.width;
                    let dy = apart([from, from + frame.width], [low[1], high[1]]);
                    let left = padded * padded - dy * dy - dz * dz;
                    if left < 0.0 {
                        continue;
                    }
                    let along = left.sqrt();
                    let row = (slot_z * frame.slots[1] + slot_y) * frame.slots[0];
                    let from = cells.starts[row + frame.slot(0, low[0] - along)] as usize;
                    let to = cells.starts[row + frame.slot(0, high[0] + along) + 1] as usize;
                    let count = to - from;
                    let (xs, ys, zs) = (&cells.x[from..to], &cells.y[from..to], &cells.z[from..to]);
                    if squares.len() < count {
                        squares.resize(count, 0.0);
                    }
                    let squared = &mut squares[..count];
                    for k in 0..count {
                        let dx = beyond(xs[k], low[0], high[0]);
                        let dy = beyond(ys[k], low[1], high[1]);
                        let dz = beyond(zs[k], low[2], high[2]);
                        squared[k] = dx * dx + dy * dy + dz * dz;
                    }
                    if places.len() < near + count {
                        places.resize(near + count + 1024, 0);
                    }
                    // Without a branch: hits and misses come in no order that a processor could predict.
                    let room = &mut places[near..near + count];
                    let mut found = 0;
                    for k in 0..count {
                        room[found] = (from + k) as u32;
                        found += usize::from(squared[k] <= limit);
                    }
                    near += found;
                }
            }
            if neighbours.len() < len + near {
                neighbours.resize(len + near + 4096, 0);
            }
            let room = &mut neighbours[len..len + near];
            let mut found = 0;
            for &place in &places[..near] {
                let place = place as usize;
                let (x, y, z) = (cells.x[place], cells.y[place], cells.z[place]);
                let mut hits = 0;
                for l in 0..LANES {
                    hits += u64::from(at.square(l, x, y, z) <= limit);
                }
                room[found] = cells.points[place];
                found += usize::from(hits > 0);
            }
            len += found;
            starts.push(len as u32);
        }
        neighbours.truncate(len);
    }
}
