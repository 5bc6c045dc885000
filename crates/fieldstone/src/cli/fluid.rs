//! Where the fluid is, as a field on nodes: what `grid` and `surface` have in common.

use anyhow::{anyhow, bail};
use clap::{Args, ValueEnum};
use fieldstone::io::SeriesFrame;
use fieldstone::mesh::Grid;
use fieldstone::surface::{
    Exact, LevelSetOptions, NodeField, Nodes, PeriodicFaces, SurfaceDetection, SurfaceDistance, SurfaceError,
    Surroundings, density_field, implausibilities, level_set,
};

use super::arguments::{available_memory, positive};
use super::report;
use super::sph_frames::fluid_positions;

/// Bytes per node: the field, those interpolated to nodes, and their copies while they are written.
const NODE_BYTES: u64 = 120;

/// Bytes per node of each further number: a column's as it is interpolated, spread over the nodes and written.
const COLUMN_BYTES: u64 = 24;

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
    pub fn field(
        &self,
        frame: &SeriesFrame,
        surroundings: &Surroundings,
        nodes: &Nodes,
        faces: PeriodicFaces,
    ) -> anyhow::Result<NodeField> {
        let placed = |e: SurfaceError| anyhow!("{}: {e}", frame.path.display());
        let positions = frame.particles.positions();
        let method = Exact::default();
        let grid = surroundings.grid(positions, method.reach(surroundings.spacing)).map_err(placed)?;
        let scene = surroundings.scene(&grid);
        for finding in implausibilities(&scene) {
            report::warn(&format!("{}: {finding}", frame.path.display()));
        }
        if self.from == Source::Density {
            return density_field(positions, surroundings, nodes, self.smoothing, faces).map_err(placed);
        }
        let distance = match self.distance {
            Distance::Blended => SurfaceDistance::Blended,
            Distance::Nearest => SurfaceDistance::Nearest,
        };
        let options = LevelSetOptions { distance, periodic_faces: faces, ..LevelSetOptions::default() };
        let detection = method.detect(&scene).map_err(placed)?;
        level_set(positions, surroundings, &detection, nodes, &options).map_err(placed)
    }
}

/// Nodes around the fluid's particles, refused where the memory does not suffice for their fields: `numbers` of columns each.
pub(crate) fn nodes(
    frame: &SeriesFrame,
    surroundings: &Surroundings,
    cell: f64,
    numbers: usize,
) -> anyhow::Result<Nodes> {
    let spacing = surroundings.spacing;
    let fluid = fluid_positions(&frame.particles, surroundings.candidates.as_deref());
    // Beyond the surface, and beyond the balls of the particles' volume.
    let file = frame.path.display();
    let nodes = Nodes::around(&fluid, 1.5 * spacing, cell * spacing)
        .map_err(|e| anyhow!("{file}: --cell, --spacing: {e}; {}", extent(&fluid)))?;
    let nodes = match fluid.first() {
        // A flow in the plane has one layer of nodes, at the z of its particles.
        Some(particle) if surroundings.dimension == 2 => {
            nodes.slice(2, particle[2]).map_err(|e| anyhow!("{file}: z of the particles: {e}"))?
        }
        _ => nodes,
    };
    check_room(&nodes, numbers, available_memory()).map_err(|e| anyhow!("{file}: {e}; {}", extent(&fluid)))?;
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
    numbers: usize,
) -> anyhow::Result<Nodes> {
    let nodes = nodes(frame, surroundings, cell, numbers)?;
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
    check_room(&nodes, numbers, available_memory()).map_err(|e| anyhow!("{}: {e}", frame.path.display()))?;
    Ok(nodes)
}

/// Refuses nodes for whose fields the memory does not suffice: systems that promise more than they have end the program
/// without a word.
fn check_room(nodes: &Nodes, numbers: usize, available: Option<u64>) -> anyhow::Result<()> {
    let count = nodes.len() as u64;
    let needed = count.saturating_mul(NODE_BYTES + COLUMN_BYTES * numbers as u64);
    let gigabytes = |bytes: u64| bytes as f64 / 1e9;
    match available {
        Some(available) if needed > available => bail!(
            "--cell, --spacing: the fields on {count} nodes need about {:.1} GB of memory, and {:.1} GB are free; give larger \
             cells",
            gigabytes(needed),
            gigabytes(available)
        ),
        _ => Ok(()),
    }
}

/// Where the particles are, and which of them is far from all others, if one is.
fn extent(positions: &[[f64; 3]]) -> String {
    let sorted = |k: usize| {
        let mut along: Vec<f64> = positions.iter().map(|p| p[k]).collect();
        along.sort_unstable_by(f64::total_cmp);
        along
    };
    let axes = [sorted(0), sorted(1), sorted(2)];
    let last = positions.len().saturating_sub(1);
    let vector = |at: usize| {
        let [x, y, z] = [0, 1, 2].map(|k| axes[k].get(at).map_or(f64::NAN, |&x| report::short(x)));
        format!("({x}, {y}, {z})")
    };
    let middle = [0, 1, 2].map(|k| axes[k].get(last / 2).copied().unwrap_or(f64::NAN));
    let distance = |p: &[f64; 3]| (0..3).map(|k| (p[k] - middle[k]).powi(2)).sum::<f64>().sqrt();
    let mut far: Vec<(f64, &[f64; 3])> = positions.iter().map(|p| (distance(p), p)).collect();
    far.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    let stray = match far.as_slice() {
        [first, second, ..] if first.0 > STRAY * second.0 => {
            let [x, y, z] = first.1.map(report::short);
            format!("; the particle at ({x}, {y}, {z}) is far from all others: leave it out")
        }
        _ => String::new(),
    };
    format!("the particles reach from {} to {}{stray}", vector(0), vector(last))
}

/// A particle is far from all others where it is so many times farther from their middle than the next one.
const STRAY: f64 = 3.0;

/// The grid whose corners are `nodes`.
pub(crate) fn cells(nodes: &Nodes) -> anyhow::Result<Grid> {
    nodes.grid().ok_or_else(|| anyhow!("--slice: a slice has no cells to sum over"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_for_whose_columns_the_memory_does_not_suffice_are_refused_with_both_numbers() {
        let nodes = Nodes::new([0.0; 3], [1.0; 3], [100; 3]).unwrap();
        let message = check_room(&nodes, 5, Some(200_000_000)).unwrap_err().to_string();
        assert!(
            message.contains("on 1000000 nodes need about 0.2 GB") && message.contains("0.2 GB are free"),
            "{message}"
        );
        assert!(check_room(&nodes, 0, Some(200_000_000)).is_ok() && check_room(&nodes, 5, None).is_ok());
    }
}
