//! What grids and meshes have in common.

use fieldstone_geometry::{Ball, ElementKind};

/// Receives the parts of a cell: sign, kind, corners in CGNS order. See [`Cells::for_each_element`].
pub type ElementSink<'a> = dyn FnMut(f64, ElementKind, &[[f64; 3]]) + 'a;

/// How many overlaps were evaluated, not counting cells that are clearly inside or outside a ball.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PathCounts {
    /// Overlaps evaluated.
    pub evaluated: u64,
    /// Of these, how many needed more digits than `f64` has.
    pub beyond_f64: u64,
}

/// Cells that balls, boxes and points are placed into: a [`crate::Mesh`] or a [`crate::Grid`].
///
/// Volumes are reported as pairs (cell, volume), sorted by cell, without zeros; what of a ball lies outside all
/// cells is in no pair.
pub trait Cells: Sync {
    /// Working memory of one thread.
    type Scratch: Send;

    /// Whether finding the cells around a place reads memory that belongs to that place.
    ///
    /// If so, balls that follow each other should be neighbours, or each waits for memory. `false` for cells that are
    /// found by arithmetic.
    const PLACES_IN_MEMORY: bool = true;

    /// Working memory for this set of cells. Volumes computed with it keep [`fieldstone_geometry::PROMISE`], but for round cells
    /// much smaller than the ball: see [`crate::CylinderGrid`].
    fn scratch(&self) -> Self::Scratch;

    /// Working memory with which balls are evaluated in `f64` alone: faster by far for balls much larger than the cells,
    /// with errors of some 1e-15 r³ per cell.
    fn fast_scratch(&self) -> Self::Scratch;

    /// How often balls have been evaluated with this working memory, and how often `f64` was not enough.
    fn path_counts(&self, scratch: &Self::Scratch) -> PathCounts;

    /// Number of cells.
    fn cell_count(&self) -> usize;

    /// Volume of a cell.
    fn cell_volume(&self, cell: usize) -> f64;

    /// Centre of a cell: its centroid, or for a round cell the point in the middle of its coordinates.
    fn cell_centre(&self, cell: usize) -> [f64; 3];

    /// Directions in which every cell spans the whole extent, and fields are averages (see [`crate::Grid::averaged`]).
    fn averaged(&self) -> [bool; 3] {
        [false; 3]
    }

    /// The Cartesian grid whose cells these are, where they are; centres are then found by arithmetic.
    fn as_grid(&self) -> Option<&crate::Grid> {
        None
    }

    /// The round cells that these are, where each is an average around a circle; kernels are then evaluated at points around
    /// it ([`crate::CylinderGrid::for_each_ring_point`]), else at the cells' centres.
    fn as_rings(&self) -> Option<&crate::CylinderGrid> {
        None
    }

    /// Lower and upper corner of the box around all cells.
    fn bounds(&self) -> ([f64; 3], [f64; 3]);

    /// Appends the volume of `ball` in each cell that it overlaps.
    fn overlap_ball(&self, ball: &Ball, scratch: &mut Self::Scratch, out: &mut Vec<(u32, f64)>);

    /// Appends the volume of the axis-parallel box in each cell that it overlaps.
    fn overlap_cuboid(&self, low: [f64; 3], high: [f64; 3], scratch: &mut Self::Scratch, out: &mut Vec<(u32, f64)>);

    /// The cell that holds `point`; `None` outside.
    ///
    /// On a common face, edge or corner it is one of the cells there, always the same. Grids give the upper one along each
    /// axis, as intervals that are closed below do and as [`Cells::clip_segment`] does, and at the upper end of all the last
    /// one. Meshes know no upper cell: they give the one that takes most of the directions around the point, and of equal ones
    /// the first.
    fn locate(&self, point: [f64; 3], scratch: &mut Self::Scratch) -> Option<u32>;

    /// Calls `visit` with each cell that shares a face with `cell`, and with the face's area over the distance of
    /// the two cells' centres. Two sectors of a cylinder, which share two faces, meet once, with the sum of both areas.
    fn for_each_neighbour(&self, cell: usize, visit: &mut dyn FnMut(u32, f64));

    /// Calls `visit` with each cell whose bounding box meets the given box, in any order.
    fn for_each_candidate(&self, low: [f64; 3], high: [f64; 3], visit: &mut dyn FnMut(u32));

    /// A cell as a signed sum of elements of standard kinds with planar faces, corners in CGNS order: the cell
    /// itself where it is one, else tetrahedra.
    fn for_each_element(&self, cell: usize, visit: &mut ElementSink<'_>);

    /// Whether [`Cells::for_each_element`] and [`Cells::overlap_cuboid`] mean anything: not for round cells.
    fn is_polyhedral(&self) -> bool {
        true
    }

    /// Calls `visit` with the cells that the segment passes and the fraction of its length in each, where the cells have
    /// a way of their own to find them; `false` where they have not.
    fn clip_segment(&self, start: [f64; 3], along: [f64; 3], visit: &mut dyn FnMut(u32, f64)) -> bool {
        let _ = (start, along, visit);
        false
    }
}
