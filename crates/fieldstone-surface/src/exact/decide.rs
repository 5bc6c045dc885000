//! Is a particle's sphere of directions covered? Masks, then branch and bound, then arcs.

use glam::DVec3;

use super::cover_table::{CoverTable, Square, WORDS, cell_of};
use crate::arc_cover::{Cap, uncovered_direction};
use crate::neighbourhood::{LANES, Neighbourhood};

/// Divisions of a square before the arcs decide; squares then are 0.1° wide.
const MAX_DIVISIONS: u32 = 7;

pub(crate) enum Decision {
    /// With an uncovered direction.
    Free([f64; 3]),
    Inner,
}

/// Memory for one particle after the other.
#[derive(Debug, Default)]
pub(crate) struct DecideScratch {
    cells: Vec<u32>,
    directions: UnitDirections,
    stack: Vec<(Square, u32)>,
    caps: Vec<Cap>,
    arcs: Vec<(f64, f64)>,
}

/// Unit directions to the neighbours, filled up with zero vectors, which cover nothing.
#[derive(Debug, Default)]
pub(crate) struct UnitDirections {
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) z: Vec<f64>,
}

impl UnitDirections {
    #[inline(always)]
    pub(crate) fn fill(&mut self, hood: &Neighbourhood) {
        let count = hood.padded_len();
        self.x.resize(count, 0.0);
        self.y.resize(count, 0.0);
        self.z.resize(count, 0.0);
        let (hx, hy, hz, hs) = (&hood.x[..count], &hood.y[..count], &hood.z[..count], &hood.squared[..count]);
        let (x, y, z) = (&mut self.x[..count], &mut self.y[..count], &mut self.z[..count]);
        for k in 0..count {
            let inverse = 1.0 / hs[k].sqrt();
            x[k] = hx[k] * inverse;
            y[k] = hy[k] * inverse;
            z[k] = hz[k] * inverse;
        }
    }

    /// Fills the padding with the first direction, for angles beyond 90°, where zero vectors would count.
    pub(crate) fn repeat_first(&mut self, len: usize) {
        for k in len..self.x.len() {
            (self.x[k], self.y[k], self.z[k]) = (self.x[0], self.y[0], self.z[0]);
        }
    }

    /// Largest z_j · m.
    #[inline(always)]
    pub(crate) fn nearest(&self, m: DVec3) -> f64 {
        let mut best = [-1.0f64; LANES];
        // By index: zipped iterators are not inlined where this is used often, and cost more than the numbers.
        let (xs, ys, zs) =
            (self.x.as_chunks::<LANES>().0, self.y.as_chunks::<LANES>().0, self.z.as_chunks::<LANES>().0);
        let (ys, zs) = (&ys[..xs.len()], &zs[..xs.len()]);
        for k in 0..xs.len() {
            let (x, y, z) = (&xs[k], &ys[k], &zs[k]);
            for l in 0..LANES {
                let dot = x[l] * m.x + y[l] * m.y + z[l] * m.z;
                best[l] = if dot > best[l] { dot } else { best[l] };
            }
        }
        best.into_iter().fold(-1.0, f64::max)
    }

    /// Largest z_j · m, and whether a single neighbour is within the angle of all corners.
    #[inline(always)]
    fn nearest_and_cover(&self, m: DVec3, square: &Square, cos: f64) -> (f64, bool) {
        let mut nearest = [-1.0f64; LANES];
        let mut best = [-1.0f64; LANES];
        let [a, b, c, d] = square.corners;
        let lanes = self.x.chunks_exact(LANES).zip(self.y.chunks_exact(LANES)).zip(self.z.chunks_exact(LANES));
        for ((x, y), z) in lanes {
            for l in 0..LANES {
                let dot = |p: DVec3| x[l] * p.x + y[l] * p.y + z[l] * p.z;
                let min = |s: f64, t: f64| if s < t { s } else { t };
                let centre = dot(m);
                let corners = min(min(dot(a), dot(b)), min(dot(c), dot(d)));
                nearest[l] = if centre > nearest[l] { centre } else { nearest[l] };
                best[l] = if corners > best[l] { corners } else { best[l] };
            }
        }
        (nearest.into_iter().fold(-1.0, f64::max), best.into_iter().any(|b| b >= cos))
    }

    #[inline(always)]
    pub(crate) fn sum(&self) -> DVec3 {
        let mut total = [[0.0f64; LANES]; 3];
        let lanes = self.x.chunks_exact(LANES).zip(self.y.chunks_exact(LANES)).zip(self.z.chunks_exact(LANES));
        for ((x, y), z) in lanes {
            for l in 0..LANES {
                total[0][l] += x[l];
                total[1][l] += y[l];
                total[2][l] += z[l];
            }
        }
        DVec3::from_array(total.map(|t| t.into_iter().sum()))
    }
}

/// Decides on a particle with at least one neighbour; `known` is a direction to try first.
#[inline(always)]
pub(crate) fn decide(
    table: &CoverTable,
    hood: &Neighbourhood,
    known: Option<[f64; 3]>,
    scratch: &mut DecideScratch,
) -> Decision {
    let DecideScratch { cells, directions, stack, caps, arcs } = scratch;
    if let Some(known) = known {
        directions.fill(hood);
        if directions.nearest(DVec3::from_array(known).normalize_or_zero()) < table.cos {
            return Decision::Free(known);
        }
    }
    let count = hood.padded_len();
    cells.resize(count, 0);
    let (x, y, z, cells) = (&hood.x[..count], &hood.y[..count], &hood.z[..count], &mut cells[..count]);
    for k in 0..count {
        cells[k] = cell_of(x[k], y[k], z[k]);
    }
    let mut covered = [0u64; WORDS];
    for &cell in &cells[..hood.len] {
        let set = table.covered(cell as usize);
        for w in 0..WORDS {
            covered[w] |= set[w];
        }
    }
    if covered == table.all {
        return Decision::Inner;
    }
    if known.is_none() {
        directions.fill(hood);
    }
    let away = -directions.sum().normalize_or_zero();
    if away != DVec3::ZERO && directions.nearest(away) < table.cos {
        return Decision::Free(away.to_array());
    }
    search(table, directions, covered, stack, caps, arcs)
}

/// Steps 3 and 4, for the squares that are not in `covered`.
#[inline(always)]
fn search(
    table: &CoverTable,
    directions: &UnitDirections,
    covered: [u64; WORDS],
    stack: &mut Vec<(Square, u32)>,
    caps: &mut Vec<Cap>,
    arcs: &mut Vec<(f64, f64)>,
) -> Decision {
    stack.clear();
    let mut undecided = false;
    for (word, (all, covered)) in table.all.iter().zip(covered).enumerate() {
        let mut left = all & !covered;
        while left != 0 {
            stack.push((table.squares[word * 64 + left.trailing_zeros() as usize], 0));
            left &= left - 1;
            while let Some((square, divisions)) = stack.pop() {
                let centre = square.centre();
                let (nearest, is_covered) = directions.nearest_and_cover(centre, &square, table.cos);
                if nearest < table.cos {
                    return Decision::Free(centre.to_array());
                }
                if is_covered {
                    continue;
                }
                if divisions < MAX_DIVISIONS {
                    stack.extend(square.quarters(centre).map(|quarter| (quarter, divisions + 1)));
                } else {
                    undecided = true;
                }
            }
        }
    }
    if !undecided {
        return Decision::Inner;
    }
    caps.clear();
    let axes = directions.x.iter().zip(&directions.y).zip(&directions.z).map(|((&x, &y), &z)| DVec3::new(x, y, z));
    caps.extend(axes.filter(|axis| *axis != DVec3::ZERO).map(|axis| Cap::new(axis, table.angle)));
    match uncovered_direction(caps, arcs) {
        Some(direction) => Decision::Free(direction.to_array()),
        None => Decision::Inner,
    }
}
