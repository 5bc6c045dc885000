/// Where the volume went: what came in, what was placed in cells, what lies outside.
///
/// `particle_volume = binned_volume + clipped_volume` to rounding for every method that conserves volume
/// (all but centre-smoothed on cells of unequal size), and where cells are no wider than a periodic box: in wider ones
/// images are binned beside what they are images of, and `clipped_volume` turns negative to say so.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ledger {
    /// Particles read.
    pub particles: usize,
    /// Cells of the mesh or grid.
    pub cells: usize,
    /// Σ of the cells' volumes.
    pub mesh_volume: f64,
    /// Σ of w · 4/3 π r³ over the particles, with w the parcel weight.
    pub particle_volume: f64,
    /// Volume placed in cells.
    pub binned_volume: f64,
    /// Volume of particles outside all cells.
    pub clipped_volume: f64,
    /// Largest solid fraction of a cell, before smoothing and cap.
    pub max_solid_fraction: f64,
    /// Cells with a solid fraction above 1 (by more than 1e-12): particles that overlap each other, or an
    /// approximation at work.
    pub cells_above_one: usize,
    /// Overlaps evaluated, not counting cells clearly inside or outside a ball (exact kernel only).
    pub overlaps: u64,
    /// Of these, how many needed more digits than `f64` has to keep the promised accuracy.
    pub beyond_f64: u64,
}
