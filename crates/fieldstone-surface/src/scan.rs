//! Visits the neighbourhood of every particle, cell by cell and in parallel.

use std::ops::Range;

use fieldstone_particles::NeighbourGrid;
use rayon::prelude::*;

use crate::Scene;
use crate::neighbourhood::{CellSurroundings, Neighbourhood};

/// Points per task: enough to amortise the scratch, few enough for any number of threads.
const POINTS_PER_TASK: usize = 2048;

/// What is computed from each neighbourhood.
pub(crate) trait Visitor: Sync {
    type Scratch: Default;
    type Output: Copy + Default + Send;

    /// Called for each candidate, with its index in the caller's order.
    fn visit(&self, particle: usize, hood: &Neighbourhood, scratch: &mut Self::Scratch) -> Self::Output;
}

/// Fills `sorted` with the visitor's output for each sorted point; images and particles that are no candidates get
/// the default.
///
/// Every output depends on its own neighbourhood only, so the number of threads does not matter.
pub(crate) fn scan<V: Visitor>(scene: &Scene<'_>, radius: f64, visitor: &V, sorted: &mut Vec<V::Output>) {
    let grid = scene.grid;
    sorted.clear();
    sorted.resize(grid.point_count(), V::Output::default());
    let mut tasks: Vec<(Range<usize>, &mut [V::Output])> = Vec::new();
    let mut rest = sorted.as_mut_slice();
    let mut first = 0;
    for cell in 0..grid.cell_count() {
        let points = grid.cell(first).start..grid.cell(cell).end;
        if points.len() >= POINTS_PER_TASK || cell + 1 == grid.cell_count() {
            let (mine, others) = rest.split_at_mut(points.len());
            rest = others;
            tasks.push((first..cell + 1, mine));
            first = cell + 1;
        }
    }
    tasks.into_par_iter().for_each_init(Local::<V>::default, |local, (cells, outputs)| {
        pulp::Arch::new().dispatch(Task { scene, radius, visitor, grid, cells, outputs, local });
    });
}

struct Local<V: Visitor> {
    surroundings: CellSurroundings,
    hood: Neighbourhood,
    scratch: V::Scratch,
}

impl<V: Visitor> Default for Local<V> {
    fn default() -> Self {
        Self {
            surroundings: CellSurroundings::default(),
            hood: Neighbourhood::default(),
            scratch: V::Scratch::default(),
        }
    }
}

struct Task<'a, V: Visitor> {
    scene: &'a Scene<'a>,
    radius: f64,
    visitor: &'a V,
    grid: &'a NeighbourGrid,
    cells: Range<usize>,
    outputs: &'a mut [V::Output],
    local: &'a mut Local<V>,
}

/// Everything is inlined into `call`, which [`pulp`] compiles for AVX-512, AVX2 and the baseline. Rust never contracts
/// products and sums, so the bits are the same on all of them.
impl<V: Visitor> pulp::NullaryFnOnce for Task<'_, V> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { scene, radius, visitor, grid, cells, outputs, local } = self;
        let Local { surroundings, hood, scratch } = local;
        let [x, y, z] = grid.sorted_positions();
        let sources = grid.sources();
        let limit = radius * radius;
        let first = grid.cell(cells.start).start;
        let wanted = |sorted: usize| {
            !grid.is_image(sorted) && scene.candidates.is_none_or(|candidates| candidates[sources[sorted] as usize])
        };
        for cell in cells {
            let home = grid.cell(cell);
            if !home.clone().any(wanted) {
                continue;
            }
            surroundings.collect(grid, cell);
            for sorted in home {
                if wanted(sorted) {
                    surroundings.neighbours_of([x[sorted], y[sorted], z[sorted]], limit, hood);
                    outputs[sorted - first] = visitor.visit(sources[sorted] as usize, hood, scratch);
                }
            }
        }
    }
}
