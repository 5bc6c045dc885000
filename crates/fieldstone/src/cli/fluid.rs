//! Where the fluid is, as a field on nodes: what `grid` and `surface` have in common.

use anyhow::anyhow;
use clap::{Args, ValueEnum};
use fieldstone::io::SeriesFrame;
use fieldstone::mesh::Grid;
use fieldstone::surface::{
    Exact, LevelSetOptions, NodeField, Nodes, SurfaceDetection, SurfaceDistance, SurfaceError, Surroundings,
    density_field, implausibilities, level_set,
};

use super::arguments::{available_memory, check_memory, positive};
use super::report;

/// Bytes per node: the field, those interpolated to nodes, and their copies while they are written.
const NODE_BYTES: u64 = 120;

/// How the fluid's region is found.
#[derive(Debug, Args)]
pub(crate) struct FluidArguments {
    /// Field that says where the fluid is
    #[arg(long, value_enum, default_value = "level-set")]
    pub from: Source,
    /// Distance of the level set from the surface particles
    #[arg(long, value_enum, default_value = "blended")]
    distance: Distance,
    /// Smoothing length of --from density, in spacings
    #[arg(long, value_name = "H", default_value_t = 1.25, value_parser = positive, allow_negative_numbers = true)]
    smoothing: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Source {
    /// distance from the detected free surface: keeps drops and thin sheets
    LevelSet,
    /// the particles' volume, smoothed: the best volume, but drops of few particles vanish
    Density,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Distance {
    /// averaged over surface particles near by: continuous
    Blended,
    /// from the nearest surface particle alone, as published
    Nearest,
}

impl FluidArguments {
    /// The field, after warnings about what looks wrong.
    pub fn field(&self, frame: &SeriesFrame, surroundings: &Surroundings, nodes: &Nodes) -> anyhow::Result<NodeField> {
        let placed = |e: SurfaceError| anyhow!("{}: {e}", frame.path.display());
        let positions = frame.particles.positions();
        let method = Exact::default();
        let grid = surroundings.grid(positions, method.reach(surroundings.spacing)).map_err(placed)?;
        let scene = surroundings.scene(&grid);
        for finding in implausibilities(&scene) {
            report::warn(&format!("{}: {finding}", frame.path.display()));
        }
        if self.from == Source::Density {
            return density_field(positions, surroundings, nodes, self.smoothing).map_err(placed);
        }
        let distance = match self.distance {
            Distance::Blended => SurfaceDistance::Blended,
            Distance::Nearest => SurfaceDistance::Nearest,
        };
        let options = LevelSetOptions { distance, ..LevelSetOptions::default() };
        let detection = method.detect(&scene).map_err(placed)?;
        level_set(positions, surroundings, &detection, nodes, &options).map_err(placed)
    }
}

/// Nodes around the fluid's particles, refused where the memory does not suffice.
pub(crate) fn nodes(frame: &SeriesFrame, surroundings: &Surroundings, cell: f64) -> anyhow::Result<Nodes> {
    let spacing = surroundings.spacing;
    let positions = frame.particles.positions();
    let fluid: Vec<[f64; 3]> = match &surroundings.candidates {
        None => positions.to_vec(),
        Some(fluid) => positions.iter().zip(fluid).filter(|(_, fluid)| **fluid).map(|(p, _)| *p).collect(),
    };
    // Beyond the surface, and beyond the balls of the particles' volume.
    let nodes = Nodes::around(&fluid, 1.5 * spacing, cell * spacing)
        .map_err(|e| anyhow!("{}: --cell, --spacing: {e}", frame.path.display()))?;
    check_room(&nodes)?;
    Ok(nodes)
}

/// The same nodes, but along periodic axes from one end of the box to the other, the cells a little larger or smaller
/// so that they fit.
///
/// Cells beyond the box would hold again what those at its opposite face hold.
pub(crate) fn nodes_of_one_period(
    frame: &SeriesFrame,
    surroundings: &Surroundings,
    cell: f64,
) -> anyhow::Result<Nodes> {
    let nodes = nodes(frame, surroundings, cell)?;
    let Some(domain) = &surroundings.domain else { return Ok(nodes) };
    let (mut origin, mut spacing, mut counts) = (nodes.origin(), nodes.spacing(), nodes.counts());
    for k in (0..3).filter(|&k| domain.periodic()[k]) {
        let length = domain.lengths()[k];
        let cells = (length / spacing[k]).round().max(1.0);
        origin[k] = domain.low()[k];
        spacing[k] = length / cells;
        // A float that is no count saturates and is refused with the nodes.
        counts[k] = (cells as usize).saturating_add(1);
    }
    let nodes = Nodes::new(origin, spacing, counts)
        .map_err(|e| anyhow!("{}: --cell, --spacing, and the periodic box: {e}", frame.path.display()))?;
    check_room(&nodes)?;
    Ok(nodes)
}

fn check_room(nodes: &Nodes) -> anyhow::Result<()> {
    let cells = nodes.grid().map_or(0, |grid| grid.cells().iter().product::<usize>() as u64);
    check_memory(cells, NODE_BYTES, available_memory())
}

/// The grid whose corners are `nodes`.
pub(crate) fn cells(nodes: &Nodes) -> anyhow::Result<Grid> {
    nodes.grid().ok_or_else(|| anyhow!("--slice: a slice has no cells to sum over"))
}
