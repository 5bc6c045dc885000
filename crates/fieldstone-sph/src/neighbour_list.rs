//! Neighbours of clusters of receivers as indices of points, kept over stages and steps.

use rayon::prelude::*;

use crate::cells::{Cells, Near};
use crate::cluster::{LANES, Receivers};

/// Clusters per task.
const CHUNK: usize = 16;

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

impl NeighbourList {
    /// Builds the lists for `count` receivers, points from `first` on.
    pub(crate) fn rebuild(&mut self, cells: &Cells, positions: &[[f64; 3]], first: usize, count: usize, reach: f64) {
        self.first = first;
        self.count = count;
        self.chunks.resize_with(count.div_ceil(CHUNK * LANES), Chunk::default);
        let receivers = positions[first..first + count].par_chunks(CHUNK * LANES);
        self.chunks.par_iter_mut().zip(receivers).for_each_init(Near::default, |near, (chunk, receivers)| {
            pulp::Arch::new().dispatch(Build { cells, receivers, reach, chunk, near });
        });
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
            for (l, member) in members.iter_mut().enumerate() {
                // Lanes without a receiver repeat the last one.
                *member = (first + local * LANES + l.min(outputs.len() - 1)) as u32;
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
    near: &'a mut Near,
}

impl pulp::NullaryFnOnce for Build<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { cells, receivers, reach, chunk, near } = self;
        let Chunk { starts, neighbours } = chunk;
        let limit = reach * reach;
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
            let places = cells.near_box(low, high, reach, near);
            if neighbours.len() < len + places.len() {
                neighbours.resize(len + places.len() + 4096, 0);
            }
            let room = &mut neighbours[len..len + places.len()];
            let mut found = 0;
            for &place in places {
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

#[cfg(test)]
mod tests {
    use super::*;
    use fieldstone_testing::Random;

    #[test]
    fn every_list_holds_exactly_the_points_within_reach_of_a_receiver() {
        for (dimension, far) in [(2, 1.0), (3, 1.0), (3, 1e3)] {
            let mut random = Random(7);
            let mut positions: Vec<[f64; 3]> =
                (0..700).map(|_| std::array::from_fn(|k| if k < dimension { random.unit() } else { 0.0 })).collect();
            // One far away, for which cells have to grow, and two at one place.
            positions[350] = [far, far, 0.0];
            positions[10] = positions[11];
            let mut cells = Cells::default();
            cells.rebuild(&positions, 0.03);
            let (first, count, reach) = (100, 301, 0.1);
            let mut list = NeighbourList::default();
            list.rebuild(&cells, &positions, first, count, reach);
            for cluster in 0..count.div_ceil(LANES) {
                let members = first + cluster * LANES..(first + count).min(first + (cluster + 1) * LANES);
                let near = |j: &u32| {
                    members.clone().any(|i| {
                        let (a, b) = (positions[i], positions[*j as usize]);
                        (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>() <= reach * reach
                    })
                };
                let mut found = list.of(cluster * LANES).to_vec();
                found.sort_unstable();
                assert!(found.into_iter().eq((0..700).filter(near)), "{dimension} {far} {cluster}");
            }
        }
    }

    #[test]
    fn positions_that_are_not_numbers_neither_hang_nor_panic() {
        let mut positions = vec![[0.5; 3]; 40];
        positions[3] = [f64::NAN; 3];
        positions[8] = [f64::NAN, 0.0, 0.0];
        positions[20] = [f64::INFINITY, 0.0, f64::NEG_INFINITY];
        let mut cells = Cells::default();
        cells.rebuild(&positions, 0.03);
        let mut list = NeighbourList::default();
        list.rebuild(&cells, &positions, 0, 40, 0.1);
        assert!(list.of(32).len() >= 37);
    }
}
