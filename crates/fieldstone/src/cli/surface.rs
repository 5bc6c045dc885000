//! `fieldstone surface`: the free surface as triangles.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{anyhow, bail};
use clap::{Args, ValueEnum};
use fieldstone::io::vtk::{VtkArrays, VtkEncoding, write_vtp_surface};
use fieldstone::io::{DataArray, SeriesFrame, write_obj, write_ply, write_stl};
use fieldstone::surface::{Column, PeriodicFaces, SurfaceError, TriangleMesh, Walls, interpolate, iso_surface};
use serde::Serialize;

use super::arguments::{ending, positive};
use super::fluid::{FluidArguments, nodes};
use super::sph_frames::{NumberedOutput, SphArguments, written};
use super::{outputs, report, sph_checks};

/// The surface of the fluid as triangles: watertight, manifold, with normals
///
/// Prints the surface's volume beside that of the particles, its area, and how its triangles hang together.
#[derive(Debug, Args)]
#[command(mut_arg("dimension", |dimension| dimension.hide(true)))]
#[command(after_long_help = "Examples:\n  \
    fieldstone surface --particles frame.bgeo --spacing 0.01 --out surface.ply\n  \
    fieldstone surface --particles 'frame_{}.vtu' --spacing 0.01 --fields velocity --out surface_{}.vtp\n\n\
    Units: all lengths as in the input; areas are their squares, volumes their cubes.")]
pub(crate) struct Surface {
    #[command(flatten)]
    sph: SphArguments,
    #[command(flatten)]
    fluid: FluidArguments,
    /// Size of the cells that the surface is found on, in spacings
    #[arg(long, value_name = "C", default_value_t = 0.5, value_parser = positive, allow_negative_numbers = true)]
    cell: f64,
    /// Where the fluid touches walls, boundary particles or the periodic box
    #[arg(long, value_enum, default_value = "closed")]
    at_walls: WallsName,
    /// Columns of the particles to interpolate to the surface, for .vtp and .ply
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    fields: Vec<String>,
    /// Result: .vtp, .ply, .obj or .stl; {} in its name stands for the number of the frame, from 0
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// Also write the summary as JSON: of a list of frames where --out holds {}
    ///
    /// - is standard output, and the report then goes to standard error.
    ///
    /// Keys of each frame: frame, file, particles, particle_volume, volume, area, points, triangles, parts, closed, manifold,
    /// euler_characteristic, open_edges, seconds.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum WallsName {
    /// the fluid's whole boundary, watertight
    Closed,
    /// the free surface alone
    Open,
}

#[derive(Serialize)]
struct Summary {
    frame: usize,
    file: String,
    particles: usize,
    particle_volume: f64,
    volume: Option<f64>,
    area: f64,
    points: usize,
    triangles: usize,
    parts: usize,
    closed: bool,
    manifold: bool,
    euler_characteristic: i64,
    open_edges: usize,
    seconds: f64,
}

impl Surface {
    pub fn run(self) -> anyhow::Result<()> {
        let out = NumberedOutput::new("--out", &self.out);
        self.check(&out)?;
        let (summaries, paths) = self.sph.each_frame(&out, |frame, path, _| self.frame(frame, path))?;
        out.write_json(self.json.as_deref(), &summaries)?;
        let mut text = match summaries.as_slice() {
            [one] => describe(one),
            all => frame_table(all),
        };
        let _ = writeln!(text, "written to           {}", written(&paths));
        outputs::report_beside(self.json.as_deref(), &text)
    }

    fn check(&self, out: &NumberedOutput) -> anyhow::Result<()> {
        let kind = ending(&self.out);
        match kind.as_str() {
            "vtp" | "ply" => {}
            "obj" | "stl" if self.fields.is_empty() => {}
            "obj" | "stl" => bail!("--fields: .{kind} has no place for them; use .vtp or .ply"),
            _ => bail!("--out {}: the ending is not known; use .vtp, .ply, .obj or .stl", self.out.display()),
        }
        if self.sph.dimension != 3 {
            bail!("--dimension 2: a surface has three; {}", sph_checks::COMMANDS_IN_PLANE);
        }
        let inputs = self.sph.inputs();
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        out.check_with_json(&inputs, self.json.as_deref())
    }

    fn frame(&self, frame: &SeriesFrame, path: &Path) -> anyhow::Result<Summary> {
        let start = Instant::now();
        let file = frame.path.display().to_string();
        let placed = |e: SurfaceError| anyhow!("{file}: {e}");
        sph_checks::not_in_plane(frame.particles.positions(), &file)?;
        let surroundings = self.sph.surroundings(frame)?;
        self.sph.check_spacing(frame, &surroundings)?;
        let particles = &frame.particles;
        let mut quantities = Vec::new();
        for name in &self.fields {
            let column = particles.column(name).map_err(|e| anyhow!("--fields {name}: {file}: {e}"))?;
            sph_checks::finite("--fields", &column, surroundings.candidates.as_deref(), &file)?;
            quantities.push(column);
        }
        let nodes = nodes(frame, &surroundings, self.cell, 0)?;
        let field = self.fluid.field(frame, &surroundings, &nodes, PeriodicFaces::End)?;
        let walls = match self.at_walls {
            WallsName::Closed => Walls::Closed,
            WallsName::Open => Walls::Open,
        };
        let mesh = iso_surface(&field, walls);
        if mesh.triangles.is_empty() {
            report::warn(&format!("{file}: there is no surface: the spacing or --smoothing may not fit the particles"));
        }
        let columns: Vec<Column<'_>> =
            quantities.iter().map(|q| Column { components: q.components, data: &q.data }).collect();
        let mut arrays = Vec::new();
        if !columns.is_empty() {
            let found =
                interpolate(particles.positions(), &surroundings, &columns, &mesh.points, 1.5).map_err(placed)?;
            for (quantity, values) in quantities.iter().zip(found.values) {
                arrays.push(DataArray::floats(&quantity.name, quantity.components, values));
            }
        }
        let topology = mesh.topology().map_err(placed)?;
        write(path, &mesh, arrays, particles.time())?;
        let volumes = surroundings.volumes.clone();
        let volumes = volumes.unwrap_or_else(|| vec![surroundings.spacing.powi(3); particles.len()]);
        let fluid = |k: usize| surroundings.candidates.as_ref().is_none_or(|c| c[k]);
        let counted = (0..particles.len()).filter(|&k| fluid(k));
        Ok(Summary {
            frame: frame.index,
            particles: counted.clone().count(),
            particle_volume: counted.map(|k| volumes[k]).sum(),
            // Of a surface with rims it means nothing.
            volume: topology.is_closed().then(|| mesh.volume()),
            area: mesh.area(),
            points: mesh.points.len(),
            triangles: mesh.triangles.len(),
            parts: topology.components,
            closed: topology.is_closed(),
            manifold: topology.is_manifold(),
            euler_characteristic: topology.euler_characteristic,
            open_edges: topology.open_edges,
            seconds: start.elapsed().as_secs_f64(),
            file,
        })
    }
}

fn write(path: &Path, mesh: &TriangleMesh, mut arrays: Vec<DataArray>, time: Option<f64>) -> anyhow::Result<()> {
    let TriangleMesh { points, triangles, normals } = mesh;
    match ending(path).as_str() {
        "ply" => write_ply(path, points, triangles, normals, &arrays)?,
        "obj" => write_obj(path, points, triangles, normals)?,
        "stl" => write_stl(path, points, triangles)?,
        _ => {
            arrays.insert(0, DataArray::floats("Normals", 3, normals.as_flattened().to_vec()));
            let arrays = VtkArrays { points: &arrays, time, ..VtkArrays::default() };
            write_vtp_surface(path, points, triangles, arrays, VtkEncoding::default())?;
        }
    }
    Ok(())
}

fn describe(s: &Summary) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<20} {value}");
    };
    line("particles", s.particles.to_string());
    line("particle volume", report::number(s.particle_volume));
    match s.volume {
        Some(volume) => {
            let share = 100.0 * (volume / s.particle_volume - 1.0);
            line("surface volume", format!("{}  ({share:+.3} %)", report::number(volume)));
        }
        None => line("surface volume", "none: the surface is open".into()),
    }
    line("surface area", report::number(s.area));
    line("triangles", s.triangles.to_string());
    line("parts", s.parts.to_string());
    let closed = if s.closed { "yes".into() } else { format!("no, {} open edges", s.open_edges) };
    line("watertight", closed);
    line("manifold", if s.manifold { "yes" } else { "no" }.into());
    text
}

fn frame_table(summaries: &[Summary]) -> String {
    let mut text = format!(
        "{:>6} {:>10} {:>14} {:>14} {:>12} {:>10} {:>6} {:>10}\n",
        "frame", "particles", "their volume", "volume", "area", "triangles", "parts", "watertight"
    );
    for s in summaries {
        let volume = s.volume.map_or("-".into(), |v| format!("{v:.6e}"));
        let _ = writeln!(
            text,
            "{:>6} {:>10} {:>14.6e} {volume:>14} {:>12.5e} {:>10} {:>6} {:>10}",
            s.frame,
            s.particles,
            s.particle_volume,
            s.area,
            s.triangles,
            s.parts,
            if s.closed { "yes" } else { "no" }
        );
    }
    text
}
