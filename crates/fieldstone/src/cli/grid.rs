//! `fieldstone grid`: particle quantities on a regular grid.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{anyhow, bail};
use clap::Args;
use fieldstone::fields::{Method, Weights};
use fieldstone::io::vtk::{VtkArrays, VtkEncoding, VtkImage, write_vti};
use fieldstone::io::{DataArray, SeriesFrame, Values};
use fieldstone::mesh::Cells;
use fieldstone::particles::{Particles, Quantity};
use fieldstone::surface::{
    Column, Interpolated, Nodes, PeriodicFaces, Support, SurfaceError, Surroundings, interpolate,
};

use super::arguments::{ending, positive};
use super::fluid::{FluidArguments, Source, cells, nodes, nodes_of_one_period};
use super::sph_frames::{NumberedOutput, SphArguments, fluid_particles, written};
use super::{report, sph_checks};

/// Particle quantities on a regular grid, by moving least squares or conservatively
///
/// Writes on the grid's nodes level_set (or volume_share with --from density), each column of the particles, interpolated,
/// and support: 2 linear, 1 weighted mean because the neighbours do not span space, 0 no particle or no fluid. With
/// --conserve also on its cells the totals of columns, shared out by the exact overlap with balls of the particles'
/// volumes. With --dimension 2 the nodes are one layer, in the plane of the particles.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:\n  \
    fieldstone grid --particles frame.vtu --spacing 0.01 --out fields.vti\n  \
    fieldstone grid --particles frame.vtu --spacing 0.01 --fields pressure --slice y=0.15 --out slice.vti\n  \
    fieldstone grid --particles frame.vtu --spacing 0.01 --conserve mass --cell 2 --out mass.vti\n  \
    fieldstone grid --particles run/particles.pvd --spacing 0.02 --dimension 2 --wall 0,1,0,0 --out fields.vti\n\n\
    Units: all lengths as in the input.")]
pub(crate) struct GridFields {
    #[command(flatten)]
    sph: SphArguments,
    #[command(flatten)]
    fluid: FluidArguments,
    /// Size of the cells, in spacings
    #[arg(long, value_name = "C", default_value_t = 1.0, value_parser = positive, allow_negative_numbers = true)]
    cell: f64,
    /// Columns of the particles to interpolate [default: all]
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    fields: Option<Vec<String>>,
    /// Smoothing length of the interpolation, in spacings
    #[arg(long, value_name = "H", default_value_t = 1.5, value_parser = positive, allow_negative_numbers = true)]
    interpolation_length: f64,
    /// Interpolate wherever there are particles near, also outside the fluid's surface
    #[arg(long)]
    beyond_surface: bool,
    /// Columns of which each particle's amount is shared out among cells, such as mass; in three dimensions
    ///
    /// Along periodic axes the cells end at the box, and are made to fit into it.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    conserve: Vec<String>,
    /// Only the plane at this position, e.g. y=0.15
    #[arg(long, value_name = "AXIS=POSITION", conflicts_with = "conserve")]
    slice: Option<Slice>,
    /// Result: .vti; {} in its name stands for the number of the frame, from 0
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// A plane across an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Slice {
    axis: usize,
    at: f64,
}

impl FromStr for Slice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("'{text}' is no plane; give an axis and a position, as in y=0.15");
        let (axis, at) = text.split_once('=').ok_or_else(wrong)?;
        let axis = AXES.iter().position(|name| *name == axis.trim()).ok_or_else(wrong)?;
        let at = at.trim().parse().ok().filter(|at: &f64| at.is_finite()).ok_or_else(wrong)?;
        Ok(Self { axis, at })
    }
}

/// What the report says about a column that was shared out.
struct Total {
    name: String,
    particles: f64,
    cells: f64,
}

struct Outcome {
    frame: usize,
    nodes: [usize; 3],
    support: [usize; 3],
    totals: Vec<Total>,
}

impl GridFields {
    pub fn run(self) -> anyhow::Result<()> {
        let out = NumberedOutput::new("--out", &self.out);
        if ending(&self.out) != "vti" {
            bail!("--out {}: the ending is not known; use .vti", self.out.display());
        }
        self.check_plane()?;
        let inputs = self.sph.inputs();
        out.check(&inputs.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
        let (outcomes, paths) = self.sph.each_frame(&out, |frame, path, _| self.frame(frame, path))?;
        let mut text = String::new();
        for outcome in &outcomes {
            text += &describe(outcome, outcomes.len() > 1);
        }
        let _ = writeln!(text, "written to           {}", written(&paths));
        report::print(&text)
    }

    /// Refuses what there is in three dimensions alone.
    fn check_plane(&self) -> anyhow::Result<()> {
        if self.sph.dimension == 3 {
            return Ok(());
        }
        if let Some(name) = self.conserve.first() {
            bail!(
                "--conserve {name}: amounts are shared out by balls, in three dimensions; leave it out with --dimension 2"
            );
        }
        match self.slice {
            Some(Slice { axis: 2, at }) => bail!(
                "--slice z={at}: with --dimension 2 the nodes are one layer, in the plane of the particles; leave it out, or \
                 give a line of them as x=… or y=…"
            ),
            _ => Ok(()),
        }
    }

    fn frame(&self, frame: &SeriesFrame, path: &Path) -> anyhow::Result<Outcome> {
        let file = frame.path.display();
        let placed = |e: SurfaceError| anyhow!("{file}: {e}");
        let surroundings = self.sph.surroundings(frame)?;
        self.sph.check_spacing(frame, &surroundings)?;
        let quantities = self.quantities(&frame.particles).map_err(|e| anyhow!("--fields: {file}: {e}"))?;
        let fluid = surroundings.candidates.as_deref();
        for column in &quantities {
            sph_checks::finite("--fields", column, fluid, &file.to_string())?;
        }
        for name in &self.conserve {
            let column = frame.particles.column(name).map_err(|e| anyhow!("--conserve {name}: {file}: {e}"))?;
            sph_checks::finite("--conserve", &column, fluid, &file.to_string())?;
        }
        let numbers = quantities.iter().map(|q| q.components).sum();
        let nodes = match self.slice {
            None if self.conserve.is_empty() => nodes(frame, &surroundings, self.cell, numbers)?,
            None => nodes_of_one_period(frame, &surroundings, self.cell, numbers)?,
            Some(Slice { axis, at }) => nodes(frame, &surroundings, self.cell, 0)?
                .slice(axis, at)
                .map_err(|e| anyhow!("--slice: {file}: {e}"))?,
        };
        let region = self.fluid.field(frame, &surroundings, &nodes, PeriodicFaces::Pass)?;
        let columns: Vec<Column<'_>> =
            quantities.iter().map(|q| Column { components: q.components, data: &q.data }).collect();
        let inside: Vec<usize> = (0..nodes.len()).filter(|&n| self.beyond_surface || region.holds_fluid(n)).collect();
        let points: Vec<[f64; 3]> = inside.iter().map(|&n| nodes.position(n)).collect();
        let positions = frame.particles.positions();
        let found =
            interpolate(positions, &surroundings, &columns, &points, self.interpolation_length).map_err(placed)?;
        let (arrays, support) = spread(&nodes, &inside, &quantities, &found);
        if support[0] == nodes.len() {
            report::warn(&format!("{file}: {}", self.why_empty()));
        }
        let name = if self.fluid.from == Source::Density { "volume_share" } else { "level_set" };
        let mut point_data = vec![DataArray::scalar(name, region.values)];
        point_data.extend(arrays);

        let (mut cell_data, mut totals) = (Vec::new(), Vec::new());
        if !self.conserve.is_empty() {
            self.share_out(frame, &surroundings, &nodes, &mut cell_data, &mut totals)?;
        }
        let counts = nodes.counts();
        let image = VtkImage::aligned(nodes.origin(), nodes.spacing(), counts.map(|n| n - 1));
        let arrays =
            VtkArrays { points: &point_data, cells: &cell_data, time: frame.particles.time(), ..VtkArrays::default() };
        write_vti(path, &image, arrays, VtkEncoding::default())?;
        Ok(Outcome { frame: frame.index, nodes: counts, support, totals })
    }

    /// What to do where no node holds fluid.
    fn why_empty(&self) -> String {
        let (place, remedy) = match self.slice {
            Some(Slice { axis, at }) => (format!("--slice {}={at}: the plane", AXES[axis]), "choose another position"),
            None => ("the grid".into(), "the spacing or --from may not fit the particles"),
        };
        let more =
            if self.beyond_surface { "" } else { ", or take what is outside the surface, too, with --beyond-surface" };
        format!("{place} holds no fluid, so all its values are 0: {remedy}{more}")
    }

    fn quantities<'a>(&self, particles: &'a Particles) -> anyhow::Result<Vec<Cow<'a, Quantity>>> {
        match &self.fields {
            None => Ok(particles.quantities().iter().map(Cow::Borrowed).collect()),
            Some(names) => names.iter().map(|name| Ok(particles.column(name)?)).collect(),
        }
    }

    /// Totals of columns in cells: each particle's amount goes to cells by their shares of its ball.
    fn share_out(
        &self,
        frame: &SeriesFrame,
        surroundings: &Surroundings,
        nodes: &Nodes,
        cell_data: &mut Vec<DataArray>,
        totals: &mut Vec<Total>,
    ) -> anyhow::Result<()> {
        let file = frame.path.display();
        let positions = frame.particles.positions();
        let fluid = fluid_particles(&frame.particles, surroundings.candidates.as_deref());
        let uniform = surroundings.spacing.powi(3);
        let radii = fluid
            .iter()
            .map(|&k| surroundings.volumes.as_ref().map_or(uniform, |v| v[k]))
            .map(|volume| (0.75 / std::f64::consts::PI * volume).cbrt())
            .collect();
        let balls = Particles::new(fluid.iter().map(|&k| positions[k]).collect())
            .and_then(|balls| balls.with_radii(radii))
            .map_err(|e| anyhow!("{file}: {e}"))?;
        let grid = cells(nodes)?;
        let domain = surroundings.domain.as_ref();
        let weights = Weights::build(&grid, &balls, Method::Kernel, domain).map_err(|e| anyhow!("{file}: {e}"))?;
        if weights.outside().iter().zip(weights.particle_volumes()).any(|(out, whole)| *out > 1e-12 * whole) {
            // Volumes far above the spacing's cube: balls reach beyond the nodes' margin.
            report::warn(&format!("{file}: some particles reach beyond the grid; check the spacing and its unit"));
        }
        let ball_volumes = weights.particle_volumes();
        let share = weights.sum_over_particles(&vec![1.0; fluid.len()])?;
        let fraction = share.iter().enumerate().map(|(cell, v)| v / grid.cell_volume(cell)).collect();
        cell_data.push(DataArray::scalar("volume_fraction", fraction));
        for name in &self.conserve {
            let column = frame.particles.column(name).map_err(|e| anyhow!("--conserve {name}: {file}: {e}"))?;
            let mut sums = vec![0.0; column.components * share.len()];
            for component in 0..column.components {
                let amount = |n: usize| column.data[fluid[n] * column.components + component];
                let densities: Vec<f64> = (0..fluid.len()).map(|n| amount(n) / ball_volumes[n]).collect();
                let cells = weights.sum_over_particles(&densities)?;
                let suffix = if column.components == 1 { String::new() } else { format!("[{}]", component + 1) };
                totals.push(Total {
                    name: format!("{name}{suffix}"),
                    particles: (0..fluid.len()).map(amount).sum(),
                    cells: cells.iter().sum(),
                });
                for (cell, sum) in cells.into_iter().enumerate() {
                    sums[cell * column.components + component] = sum;
                }
            }
            cell_data.push(DataArray::floats(format!("{name}_total"), column.components, sums));
        }
        Ok(())
    }
}

/// Values at some of the nodes as columns on all of them, 0 at the others; and how many nodes have which support.
fn spread(
    nodes: &Nodes,
    inside: &[usize],
    quantities: &[Cow<'_, Quantity>],
    found: &Interpolated,
) -> (Vec<DataArray>, [usize; 3]) {
    let mut support = vec![Support::None as u8; nodes.len()];
    for (&node, &how) in inside.iter().zip(&found.support) {
        support[node] = how as u8;
    }
    let mut counts = [0; 3];
    support.iter().for_each(|&how| counts[usize::from(how)] += 1);
    let mut arrays = vec![DataArray { name: "support".into(), components: 1, values: Values::U8(support) }];
    for (quantity, values) in quantities.iter().zip(&found.values) {
        let width = quantity.components;
        let mut all = vec![0.0; nodes.len() * width];
        for (row, &node) in values.chunks_exact(width).zip(inside) {
            all[node * width..(node + 1) * width].copy_from_slice(row);
        }
        arrays.push(DataArray::floats(&quantity.name, width, all));
    }
    (arrays, counts)
}

fn describe(outcome: &Outcome, with_frame: bool) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<20} {value}");
    };
    if with_frame {
        line("frame", outcome.frame.to_string());
    }
    let [nx, ny, nz] = outcome.nodes;
    let [none, shepard, linear] = outcome.support;
    line("nodes", format!("{nx} × {ny} × {nz}"));
    line("linear", linear.to_string());
    line("weighted mean", shepard.to_string());
    line("without fluid", none.to_string());
    for Total { name, particles, cells } in &outcome.totals {
        let off = if *particles == 0.0 { *cells } else { cells / particles - 1.0 };
        line(&format!("{name} of particles"), report::number(*particles));
        line(&format!("{name} of cells"), format!("{}  ({off:+.1e})", report::number(*cells)));
    }
    text
}
