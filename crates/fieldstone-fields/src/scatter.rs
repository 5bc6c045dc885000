//! Sums of weight × quantities over carriers, cell by cell: the product that every field is.

use rayon::prelude::*;

use crate::FieldsError;

/// Carriers handled by one task.
const BLOCK: usize = 256;
/// Blocks weighed before their pairs are added: bounds the memory, whatever the number of carriers.
const ROUND: usize = 32;
/// Numbers in one tile of cells: small enough for the nearest cache.
const TILE: usize = 1 << 15;
/// Least number of tiles, where there are as many cells.
const TILES: usize = 64;

/// One entry of a weight matrix: what `carrier` has in `cell`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair {
    pub cell: u32,
    pub carrier: u32,
    pub weight: f64,
}

/// For each cell, `columns` running sums.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sums {
    pub columns: usize,
    pub values: Vec<f64>,
}

impl Sums {
    pub fn new(cells: usize, columns: usize) -> Self {
        Self { columns, values: vec![0.0; cells * columns] }
    }

    /// The sums of one cell.
    pub fn cell(&self, cell: usize) -> &[f64] {
        &self.values[cell * self.columns..(cell + 1) * self.columns]
    }

    /// Adds weight × quantities for all pairs that `weigh` lists for each carrier in `order`.
    ///
    /// $$ S_{c,k} \mathrel{+}= \sum_i w_{ci}\, q_{ik} $$
    ///
    /// `quantities` holds `columns` numbers for each carrier that pairs name. Weighing is parallel over carriers, adding
    /// over tiles of cells, and each cell adds its pairs in the order of the carriers: the same bits for any number of
    /// threads, without a copy of the sums per thread. Only the pairs of one round are in memory.
    pub fn add<S: Send>(
        &mut self,
        order: &Order<'_>,
        quantities: &[f64],
        scratch: impl Fn() -> S + Sync,
        weigh: impl Fn(usize, &mut S, &mut Vec<Pair>) -> Result<(), FieldsError> + Sync,
    ) -> Result<(), FieldsError> {
        let columns = self.columns;
        if columns == 0 || order.len() == 0 {
            return Ok(());
        }
        let cells = self.values.len() / columns;
        // As many cells a tile as are a power of two, so that a shift finds the tile; some tiles for every thread even
        // where cells are few.
        let shift = (TILE / columns).min(cells / TILES).max(1).ilog2();
        let tiles = (cells >> shift) + 1;
        let blocks = order.len().div_ceil(BLOCK);
        for round in (0..blocks).step_by(ROUND) {
            let sorted: Vec<TilePairs> = (round..(round + ROUND).min(blocks))
                .into_par_iter()
                .map_init(
                    || (scratch(), Vec::new()),
                    |(scratch, pairs), block| {
                        pairs.clear();
                        for place in block * BLOCK..((block + 1) * BLOCK).min(order.len()) {
                            weigh(order.at(place), scratch, pairs)?;
                        }
                        Ok(TilePairs::new(pairs, shift, tiles))
                    },
                )
                .collect::<Result<_, FieldsError>>()?;
            self.values.par_chunks_mut(columns << shift).enumerate().for_each(|(tile, sums)| {
                let first = tile << shift;
                for pair in sorted.iter().flat_map(|block| block.tile(tile)) {
                    let at = (pair.cell as usize - first) * columns;
                    let carrier = pair.carrier as usize * columns;
                    let sums = &mut sums[at..at + columns];
                    for (sum, q) in sums.iter_mut().zip(&quantities[carrier..carrier + columns]) {
                        *sum += pair.weight * q;
                    }
                }
            });
        }
        Ok(())
    }
}

/// The pairs of one block, grouped by tile of cells, in their order within each.
struct TilePairs {
    ends: Vec<u32>,
    pairs: Vec<Pair>,
}

impl TilePairs {
    fn new(pairs: &[Pair], shift: u32, tiles: usize) -> Self {
        let mut ends = vec![0u32; tiles];
        for pair in pairs {
            ends[(pair.cell >> shift) as usize] += 1;
        }
        let mut start = 0;
        for end in &mut ends {
            let count = *end;
            *end = start;
            start += count;
        }
        let mut sorted = vec![Pair { cell: 0, carrier: 0, weight: 0.0 }; pairs.len()];
        for pair in pairs {
            let next = &mut ends[(pair.cell >> shift) as usize];
            sorted[*next as usize] = *pair;
            *next += 1;
        }
        Self { ends, pairs: sorted }
    }

    fn tile(&self, tile: usize) -> &[Pair] {
        let start = if tile == 0 { 0 } else { self.ends[tile - 1] };
        &self.pairs[start as usize..self.ends[tile] as usize]
    }
}

/// The order in which carriers are visited.
pub(crate) enum Order<'a> {
    /// As they are numbered.
    Numbered(usize),
    /// As listed.
    Listed(&'a [usize]),
}

impl Order<'_> {
    pub fn len(&self) -> usize {
        match self {
            Self::Numbered(count) => *count,
            Self::Listed(list) => list.len(),
        }
    }

    fn at(&self, place: usize) -> usize {
        match self {
            Self::Numbered(_) => place,
            Self::Listed(list) => list[place],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_a_plain_loop_whatever_the_number_of_threads() {
        let (cells, carriers, columns) = (40_000u32, 20_000usize, 3usize);
        let quantities: Vec<f64> = (0..carriers * columns).map(|k| (k as f64).sin()).collect();
        let pairs_of = |carrier: usize| {
            (0..5u32).map(move |k| Pair {
                cell: (carrier as u32).wrapping_mul(2_654_435_761).wrapping_add(k * 977) % cells,
                carrier: carrier as u32,
                weight: 1.0 / (1.0 + f64::from(k)),
            })
        };
        let mut plain = vec![0.0; cells as usize * columns];
        for pair in (0..carriers).flat_map(pairs_of) {
            for k in 0..columns {
                plain[pair.cell as usize * columns + k] +=
                    pair.weight * quantities[pair.carrier as usize * columns + k];
            }
        }
        for threads in [1, 2, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut sums = Sums::new(cells as usize, columns);
            pool.install(|| {
                sums.add(
                    &Order::Numbered(carriers),
                    &quantities,
                    || (),
                    |carrier, (), out| {
                        out.extend(pairs_of(carrier));
                        Ok(())
                    },
                )
            })
            .unwrap();
            assert_eq!(sums.values, plain);
        }
    }
}
