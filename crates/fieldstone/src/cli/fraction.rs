//! `fieldstone fraction`: the solid fraction of every cell.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, anyhow, bail};
use clap::Args;
use fieldstone::fields::{
    FieldsError, Method, ParcelWeight, SolidFraction, SolidFractionOptions, count_centres, smoothed_through,
    solid_fraction_observed,
};
use fieldstone::io::openfoam::{Dimensions, FieldEncoding, VolField, write_vol_field};
use fieldstone::io::vtk::{self, VtkArrays, VtkEncoding};
use fieldstone::io::{DataArray, IoError, write_csv};
use fieldstone::mesh::{Cells, Grid, Mesh};
use fieldstone::particles::{Domain, Particles};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use super::arguments::{
    CellSet, CellsArguments, ParticleArguments, Periodic, bounds, ending, fraction, not_negative, unused_parcels,
};
use super::publish::Published;
use super::timing::Timing;
use super::{outputs, report};

/// Solid fraction of every cell of a mesh or grid, from a packing of spheres
///
/// Writes solid_fraction, void_fraction, solid_volume, cell_volume and particle_count (centres) for each cell, and
/// accounts for all volume: binned + clipped (outside the mesh) = particle volume.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:\n  \
    fieldstone fraction --mesh case --particles dump.liggghts --out solid.vtu\n  \
    fieldstone fraction --mesh case --particles dump.liggghts --out case/0\n  \
    fieldstone fraction --grid 0,0.04,0,0.04,0,0.08 --cells 20,20,40 --particles dump.liggghts.gz --out solid.vti\n  \
    fieldstone fraction --mesh vessel.msh --particles xyz.csv --diameter 0.006 --method divided --out rough.csv\n\n\
    Units: all lengths as in the input; volumes are their cubes.")]
pub(crate) struct Fraction {
    #[command(flatten)]
    cells: CellsArguments,
    #[command(flatten)]
    particles: ParticleArguments,
    /// kernel, kernel-f64 or decomposition (exact); centre, centre-smoothed, cube, divided, sampled:N, monte-carlo:N
    ///
    /// Exact: kernel, for any cells and sizes, to 1e-12 of the smaller volume; kernel-f64, the same without the promise,
    /// much faster for balls many times larger than cells; decomposition, an independent check. Approximations in use elsewhere:
    /// centre, the whole ball to the cell of its centre, on a common face the upper cell of a grid and the first of a mesh;
    /// centre-smoothed, then averaged with the face neighbours, which does not conserve volume; cube of equal volume; divided,
    /// 29 points; sampled:N, a regular grid of about N points in the ball; monte-carlo:N, N random points, the same in every run.
    #[arg(long, default_value = "kernel")]
    method: Method,
    /// Result: .vtu (mesh), .vti (grid), .csv (either), or an OpenFOAM time folder such as CASE/0
    ///
    /// A time folder gets fields only where the mesh is that of its case at that time: of a moving mesh give --mesh CASE/TIME.
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// Also write the summary as JSON; - is standard output, and the report then goes to standard error
    ///
    /// Keys: particles, cells, mesh_volume, particle_volume, binned_volume, clipped_volume (below 0 where volume is counted
    /// twice), max_solid_fraction before smoothing and cap, max_written_fraction after them, cells_above_one, inverted_cells,
    /// seconds with read, search, overlap, write; overlaps evaluated, and beyond_f64, how many of them needed more than
    /// 64-bit floats.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Real particles per simulated one: a number, or the name of a column, such as OpenFOAM's nParticle
    #[arg(long, value_name = "COLUMN|W", allow_negative_numbers = true)]
    parcel_weight: Option<ParcelWeight>,
    /// Smooth conservatively over this length (standard deviation of the Gaussian, in the input's unit); the unsmoothed
    /// field is kept as solid_fraction_unsmoothed
    ///
    /// On a grid that spans the box it passes periodic boundaries; on meshes, and along tilted periods, every boundary is a
    /// wall to it, and a warning says so.
    #[arg(long, value_name = "LENGTH", value_parser = not_negative, allow_negative_numbers = true)]
    smooth: Option<f64>,
    /// Report no solid fraction above this, e.g. 0.64; the uncapped field, smoothed where asked for, is kept as
    /// solid_fraction_uncapped
    #[arg(long, value_name = "FRACTION", value_parser = fraction, allow_negative_numbers = true)]
    cap: Option<f64>,
    /// Periodic directions: auto (those of the file, where the mesh does not reach beyond the box), none, or e.g. xy
    ///
    /// auto in a tilted box: where the cells are no wider than the box.
    #[arg(long, default_value = "auto", value_name = "AXES")]
    periodic: Periodic,
    /// The simulation's box, in place of that of the file; --periodic says along which axes it is periodic
    #[arg(
        long = "box",
        value_name = "XMIN,XMAX,YMIN,YMAX,ZMIN,ZMAX",
        value_parser = bounds,
        allow_hyphen_values = true
    )]
    bounds: Option<[f64; 6]>,
    /// Print a table of where the time went
    #[arg(short, long)]
    verbose: bool,
    /// Write an OpenFOAM time folder in binary instead of text
    #[arg(long)]
    binary: bool,
}

/// What to say where `--smooth` ends at a boundary that is none for the particles.
fn unsmoothed_boundary<C: Cells>(cells: &C, domain: &Domain) -> Option<String> {
    let through = smoothed_through(cells, Some(domain));
    let (low, high) = cells.bounds();
    // Cells that do not reach from one end of the period to the other have an end there in any case.
    let spans = |k: usize| high[k] - low[k] > domain.cell_vectors()[k][k] * (1.0 - 1e-9);
    let ends: String =
        (0..3).filter(|&k| domain.periodic()[k] && spans(k) && !through[k]).map(|k| ['x', 'y', 'z'][k]).collect();
    (!ends.is_empty()).then(|| {
        format!(
            "--smooth does not pass the periodic boundary along {ends}: it does where --grid spans whole \
             periods of an upright box; cells beside that boundary are smoothed as beside a wall"
        )
    })
}

/// Results on cells of either kind, ready to be written.
pub(crate) struct Outcome {
    pub fields: SolidFraction,
    pub counts: Vec<u32>,
    pub cell_volumes: Vec<f64>,
}

impl Fraction {
    pub fn run(self) -> anyhow::Result<()> {
        let mut timing = Timing::default();
        let target = self.target()?;
        let given_box = self.bounds.map(|bounds| self.periodic.given_box(bounds)).transpose()?;
        let particles = timing.measure("read", || self.particles.read())?;
        let particles = match given_box {
            Some(domain) => particles.with_domain(domain),
            None => particles,
        };
        let cells = timing.measure("read", || self.cells.read())?;
        target.check(&cells, self.cells.mesh.as_deref())?;

        let (outcome, inverted) = match &cells {
            CellSet::Mesh(mesh) => {
                let found = mesh.inverted_cells().len() + mesh.inverted_elements();
                if found > 0 {
                    report::warn(&inside_out(mesh, &self.cells.name()));
                }
                (self.compute(mesh.as_ref(), &particles, found, &mut timing)?, found)
            }
            CellSet::Grid(grid) => (self.compute(grid, &particles, 0, &mut timing)?, 0),
        };
        timing.measure("write", || target.write(&cells, &outcome, self.binary))?;

        if let Some(path) = &self.json {
            write_summary(path, &outcome, inverted, &timing)?;
        }
        let ledger = &outcome.fields.ledger;
        if ledger.cells_above_one > 0 && self.method.is_exact() {
            report::warn(&self.too_full(ledger.max_solid_fraction));
        }
        let mut text = report::ledger(&outcome.fields, inverted);
        let _ = writeln!(text, "written to           {}", self.out.display());
        if self.verbose {
            let _ = write!(text, "\n{}", timing.table());
        }
        outputs::report_beside(self.json.as_deref(), &text)
    }

    /// Why there may be more solid in a cell than it has room for.
    fn too_full(&self, most: f64) -> String {
        // The bodies of soft spheres overlap by some percent of their volume.
        let absurd = most > MOST_BY_OVERLAP;
        let mut causes = Vec::new();
        if let Some(weight) = &self.parcel_weight {
            causes.push(format!("check --parcel-weight {weight}"));
        }
        match (self.particles.radius, self.particles.diameter) {
            (Some(radius), _) => causes.push(format!("check --radius {radius} and its unit")),
            (_, Some(diameter)) => causes.push(format!("check --diameter {diameter} and its unit")),
            _ if absurd => causes.push("check the unit of the file's radii".into()),
            _ => {}
        }
        if !absurd {
            causes.push("particles that overlap each other give them, too".into());
        }
        match causes.as_slice() {
            [_] if !absurd => "solid fractions above 1 come from particles that overlap each other".into(),
            _ => format!("solid fractions are up to {most:.3}, and no cell holds more than 1: {}", causes.join("; ")),
        }
    }

    /// Where results go, with everything refused that would fail or do harm later.
    fn target(&self) -> anyhow::Result<Target<'_>> {
        let target = Target::new(&self.out, &self.cells)?;
        let files = self.particles.files()?;
        let mut inputs: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
        inputs.push(&self.particles.particles);
        inputs.extend(self.cells.mesh.as_deref());
        match &target {
            Target::TimeFolder(path) => outputs::check_folder("--out", path)?,
            _ if self.binary => bail!("--binary goes with an OpenFOAM time folder as --out, such as CASE/0"),
            Target::Vtu(path) | Target::Vti(path) | Target::Csv(path) => outputs::check("--out", path, &inputs)?,
        }
        if let Some(path) = &self.json {
            inputs.push(&self.out);
            outputs::check_json(path, &inputs)?;
        }
        Ok(target)
    }

    /// The fields, with warnings about what they are made from and add up to; inverted cells have been told of.
    fn compute<C: Cells>(
        &self,
        cells: &C,
        particles: &Particles,
        inverted: usize,
        timing: &mut Timing,
    ) -> anyhow::Result<Outcome> {
        let periodic = self.periodic.domain(particles, cells.bounds());
        let (domain, note) = periodic.map_err(|e| anyhow!("{}: {e}", self.particles.particles.display()))?;
        if let Some(note) = note {
            report::warn(&note);
        }
        if let (Some(domain), Some(_)) = (&domain, self.smooth.filter(|length| *length > 0.0))
            && let Some(warning) = unsmoothed_boundary(cells, domain)
        {
            report::warn(&warning);
        }
        let options = SolidFractionOptions {
            method: self.method,
            domain,
            parcel_weights: self.parcel_weights(particles)?,
            smoothing_length: self.smooth.unwrap_or(0.0),
            cap: self.cap,
        };
        let outcome = compute(cells, particles, &options, timing).map_err(|error| self.placed(error))?;
        let ledger = &outcome.fields.ledger;
        if inverted == 0
            && !report::repeats(domain.as_ref(), cells.bounds())
            && let Some(warning) = report::counted_twice("volume", ledger.clipped_volume, ledger.particle_volume)
        {
            report::warn(&warning);
        }
        Ok(outcome)
    }

    /// An error with the file that it concerns.
    fn placed(&self, error: anyhow::Error) -> anyhow::Error {
        let file = self.particles.particles.display();
        match error.downcast_ref() {
            Some(FieldsError::NothingInside { .. }) => anyhow!("{file} in {}: {error}", self.cells.name()),
            Some(
                FieldsError::Ball { .. }
                | FieldsError::RadiusRange { .. }
                | FieldsError::Particles(_)
                | FieldsError::ParcelWeight { .. },
            ) => {
                anyhow!("{file}: {error}")
            }
            _ => error,
        }
    }

    fn parcel_weights(&self, particles: &Particles) -> anyhow::Result<Option<Vec<f64>>> {
        let file = self.particles.particles.display();
        let Some(weight) = &self.parcel_weight else {
            if let Some(warning) = unused_parcels(particles) {
                report::warn(&format!("{file}: {warning}"));
            }
            return Ok(None);
        };
        match weight.of(particles) {
            Ok(weights) => Ok(Some(weights)),
            Err(error @ FieldsError::ParcelWeight { .. }) => Err(error.into()),
            Err(error) => bail!("--parcel-weight {weight}: {file}: {error}"),
        }
    }
}

/// Solid fractions above this do not come from spheres that are pressed into each other.
const MOST_BY_OVERLAP: f64 = 2.0;

/// The task itself, with progress on standard error where that is a terminal.
pub(crate) fn compute<C: Cells>(
    cells: &C,
    particles: &Particles,
    options: &SolidFractionOptions,
    timing: &mut Timing,
) -> anyhow::Result<Outcome> {
    let counts = timing.measure("search", || count_centres(cells, particles, options.domain.as_ref()))?;
    let bar = ProgressBar::new(particles.len() as u64).with_style(ProgressStyle::with_template(
        "{bar:30} {percent:>3} %  {human_pos} of {human_len} particles, {eta} left",
    )?);
    let done = AtomicUsize::new(0);
    let fields = timing.measure("overlap", || {
        solid_fraction_observed(cells, particles, options, &|n| {
            bar.set_position((done.fetch_add(n, Ordering::Relaxed) + n) as u64);
        })
    });
    bar.finish_and_clear();
    let cell_volumes = (0..cells.cell_count()).map(|cell| cells.cell_volume(cell)).collect();
    Ok(Outcome { fields: fields?, counts, cell_volumes })
}

/// The summary, in the order in which it is written.
#[derive(Serialize)]
struct Summary {
    particles: usize,
    cells: usize,
    mesh_volume: f64,
    particle_volume: f64,
    binned_volume: f64,
    clipped_volume: f64,
    max_solid_fraction: f64,
    max_written_fraction: f64,
    cells_above_one: usize,
    inverted_cells: usize,
    seconds: Seconds,
    overlaps: u64,
    beyond_f64: u64,
}

#[derive(Serialize)]
struct Seconds {
    read: f64,
    search: f64,
    overlap: f64,
    write: f64,
}

/// Writes the summary as JSON.
pub(crate) fn write_summary(path: &Path, outcome: &Outcome, inverted: usize, timing: &Timing) -> anyhow::Result<()> {
    let ledger = &outcome.fields.ledger;
    let summary = Summary {
        particles: ledger.particles,
        cells: ledger.cells,
        mesh_volume: ledger.mesh_volume,
        particle_volume: ledger.particle_volume,
        binned_volume: ledger.binned_volume,
        clipped_volume: ledger.clipped_volume,
        max_solid_fraction: ledger.max_solid_fraction,
        max_written_fraction: outcome.fields.max_written(),
        cells_above_one: ledger.cells_above_one,
        inverted_cells: inverted,
        seconds: Seconds {
            read: timing.seconds("read"),
            search: timing.seconds("search"),
            overlap: timing.seconds("overlap"),
            write: timing.seconds("write"),
        },
        overlaps: ledger.overlaps,
        beyond_f64: ledger.beyond_f64,
    };
    outputs::write_json(path, &summary)
}

/// Cell data in the order in which it is written.
pub(crate) fn cell_data(outcome: &Outcome) -> Vec<DataArray> {
    let fields = &outcome.fields;
    let mut data = vec![
        DataArray::scalar("solid_fraction", fields.solid_fraction.clone()),
        DataArray::scalar("void_fraction", fields.void_fraction.clone()),
        DataArray::scalar("solid_volume", fields.solid_volume.clone()),
        DataArray::scalar("cell_volume", outcome.cell_volumes.clone()),
        DataArray::integers("particle_count", outcome.counts.iter().map(|&n| n.into()).collect()),
    ];
    if let Some(uncapped) = &fields.uncapped {
        data.push(DataArray::scalar("solid_fraction_uncapped", uncapped.clone()));
    }
    if let Some(unsmoothed) = &fields.unsmoothed {
        data.push(DataArray::scalar("solid_fraction_unsmoothed", unsmoothed.clone()));
    }
    data
}

/// What to write, decided before any work is done.
enum Target<'a> {
    Vtu(&'a Path),
    Vti(&'a Path),
    Csv(&'a Path),
    TimeFolder(&'a Path),
}

impl<'a> Target<'a> {
    fn new(path: &'a Path, cells: &CellsArguments) -> anyhow::Result<Self> {
        let mesh = cells.mesh.is_some();
        let target = match ending(path).as_str() {
            "vtu" if mesh => Self::Vtu(path),
            "vti" if !mesh => Self::Vti(path),
            "csv" => Self::Csv(path),
            "vtu" => bail!("--out {}: a grid is written as .vti or .csv", path.display()),
            "vti" => bail!("--out {}: a mesh is written as .vtu, .csv or into an OpenFOAM time folder", path.display()),
            _ if mesh && is_time_folder(path) => Self::TimeFolder(path),
            _ if is_time_folder(path) => bail!(
                "--out {}: OpenFOAM's fields need a mesh (--mesh); a grid is written as .vti or .csv",
                path.display()
            ),
            _ if path.parent().is_some_and(is_time_folder) => bail!(
                "--out {}: results are not written into time folders of regions; use .vtu or .csv{}",
                path.display(),
                if mesh { "" } else { ", for a grid .vti or .csv" }
            ),
            _ => bail!(
                "--out {}: the ending is not known; use .vtu (mesh), .vti (grid), .csv, or an OpenFOAM time folder \
                 such as CASE/0",
                path.display()
            ),
        };
        Ok(target)
    }

    fn check(&self, cells: &CellSet, source: Option<&Path>) -> anyhow::Result<()> {
        if let (Self::TimeFolder(path), CellSet::Mesh(mesh)) = (self, cells) {
            let faces = mesh.parts().owner.len();
            let covered: usize = mesh.parts().patches.iter().map(|p| p.count).sum();
            if covered != faces - mesh.parts().neighbour.len() {
                bail!(
                    "--out {}: the mesh's patches do not cover its boundary, so OpenFOAM could not read the fields",
                    path.display()
                );
            }
            if let Some(source) = source {
                outputs::check_mesh_of_case("--out", path, mesh, source)?;
            }
        }
        Ok(())
    }

    fn write(&self, cells: &CellSet, outcome: &Outcome, binary: bool) -> anyhow::Result<()> {
        match (self, cells) {
            (Self::Vtu(path), CellSet::Mesh(mesh)) => write_vtu(path, mesh, outcome)?,
            (Self::Vti(path), CellSet::Grid(grid)) => write_vti(path, grid, outcome)?,
            (Self::TimeFolder(path), CellSet::Mesh(mesh)) => write_time_folder(path, mesh, outcome, binary)?,
            (Self::Csv(path), CellSet::Mesh(mesh)) => {
                write_table(path, mesh.cell_count(), |cell| mesh.cell_centre(cell), outcome)?;
            }
            (Self::Csv(path), CellSet::Grid(grid)) => {
                write_table(path, grid.cell_count(), |cell| grid.centre(cell), outcome)?;
            }
            _ => bail!("this output does not go with these cells"),
        }
        Ok(())
    }
}

/// Cells that are named in a warning.
const NAMED: usize = 5;

/// Which cells are inside out, and what that does to the volumes.
fn inside_out(mesh: &Mesh, name: &str) -> String {
    let twins = twins(mesh);
    let inverted: Vec<String> =
        mesh.inverted_cells().iter().filter(|cell| !twins.contains_key(cell)).map(u32::to_string).collect();
    let more = |count: usize| if count > NAMED { ", …" } else { "" };
    let mut parts = Vec::new();
    if !twins.is_empty() {
        let pairs = twins.iter().map(|(cell, first)| format!("cell {cell} has the corners of cell {first}"));
        parts.push(format!(
            "{} cells are listed twice ({}{}, from 0), and what lies in them is counted twice; list each once",
            twins.len(),
            pairs.take(NAMED).collect::<Vec<_>>().join(", "),
            more(twins.len())
        ));
    }
    if !inverted.is_empty() {
        parts.push(format!(
            "{} cells are inside out (cells {}{}, from 0): they count with their absolute volume, and what lies \
             in them and in the cells that they overlap is counted twice; mend the mesh",
            inverted.len(),
            inverted[..inverted.len().min(NAMED)].join(", "),
            more(inverted.len())
        ));
    }
    if mesh.inverted_elements() > 0 {
        parts.push(format!("{} elements are listed inside out and were mirrored", mesh.inverted_elements()));
    }
    format!("{name}: {}", parts.join("; "))
}

/// Cells that share all their faces with one other cell, and that cell: the same, listed before. They come out as inside
/// out, since the faces belong to the first.
fn twins(mesh: &Mesh) -> BTreeMap<u32, u32> {
    // None where there are several neighbours, or a boundary.
    let mut partner: BTreeMap<u32, Option<u32>> = BTreeMap::new();
    let inverted: BTreeSet<u32> = mesh.inverted_cells().iter().copied().collect();
    let mut see = |cell: u32, other: Option<u32>| {
        if inverted.contains(&cell) {
            let known = partner.entry(cell).or_insert(other);
            *known = known.filter(|_| *known == other);
        }
    };
    let parts = mesh.parts();
    for (face, &owner) in parts.owner.iter().enumerate() {
        let neighbour = parts.neighbour.get(face).copied();
        see(owner, neighbour);
        neighbour.into_iter().for_each(|neighbour| see(neighbour, Some(owner)));
    }
    partner.into_iter().filter_map(|(cell, other)| Some((cell, other?))).collect()
}

/// `0`, `0.25`, `1e-3`: a folder that OpenFOAM takes for a time.
fn is_time_folder(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().parse::<f64>().is_ok_and(|t| t.is_finite()))
}

pub(crate) fn write_vtu(path: &Path, mesh: &Mesh, outcome: &Outcome) -> anyhow::Result<()> {
    let cells = cell_data(outcome);
    vtk::write_vtu(path, mesh, VtkArrays { cells: &cells, ..VtkArrays::default() }, VtkEncoding::default())?;
    Ok(())
}

fn write_vti(path: &Path, grid: &Grid, outcome: &Outcome) -> anyhow::Result<()> {
    let image = vtk::VtkImage::aligned(grid.low(), grid.spacing(), grid.cells());
    let cells = cell_data(outcome);
    vtk::write_vti(path, &image, VtkArrays { cells: &cells, ..VtkArrays::default() }, VtkEncoding::default())?;
    Ok(())
}

fn write_time_folder(path: &Path, mesh: &Mesh, outcome: &Outcome, binary: bool) -> anyhow::Result<()> {
    let encoding = if binary { FieldEncoding::Binary } else { FieldEncoding::Text };
    let fields = &outcome.fields;
    let mut list = vec![
        ("alpha.solids", Dimensions::NONE, fields.solid_fraction.as_slice()),
        ("voidfraction", Dimensions::NONE, fields.void_fraction.as_slice()),
        ("solidVolume", Dimensions([0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0]), fields.solid_volume.as_slice()),
    ];
    if let Some(uncapped) = &fields.uncapped {
        list.push(("alpha.solids.uncapped", Dimensions::NONE, uncapped.as_slice()));
    }
    if let Some(unsmoothed) = &fields.unsmoothed {
        list.push(("alpha.solids.unsmoothed", Dimensions::NONE, unsmoothed.as_slice()));
    }
    if let Some((name, ..)) = list.iter().find(|(name, ..)| path.join(name).is_dir()) {
        bail!("{}: there is a folder of this name; remove it first", path.join(name).display());
    }
    // All fields are written beside the time folder first: it gets all of them or none.
    let case = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let staging = tempfile::Builder::new().prefix(".fieldstone-").tempdir_in(case);
    let staging = staging.with_context(|| format!("{}: cannot write", path.display()))?;
    let staged = staging.path().join(path.file_name().unwrap_or_default());
    let mut files = Vec::new();
    for (name, dimensions, values) in list {
        let field = VolField { name, dimensions, components: 1, values };
        let written = write_vol_field(&staged, &field, mesh.cell_count(), &mesh.parts().patches, encoding);
        let target = path.join(name);
        // The staging folder means nothing to the user.
        let written = written.map_err(|error| match error {
            IoError::System { action, source, .. } => IoError::System { path: target.clone(), action, source },
            IoError::Content { position, found, remedy, .. } => {
                IoError::Content { path: target.clone(), position, found, remedy }
            }
            other => other,
        })?;
        files.push((written, target));
    }
    let new = !path.is_dir();
    if new {
        std::fs::create_dir(path).with_context(|| format!("{}: cannot make the folder", path.display()))?;
    }
    let published = Published::new(&files, staging.path());
    if new && published.is_err() {
        let _ = std::fs::remove_dir(path);
    }
    drop(published?);
    // Of an earlier run, which this one does not replace.
    for name in ["alpha.solids.uncapped", "alpha.solids.unsmoothed"].map(|name| path.join(name)) {
        if name.is_file() && files.iter().all(|(_, to)| *to != name) {
            report::warn(&format!(
                "{}: the file is of an earlier run and does not belong to this result; remove it",
                name.display()
            ));
        }
    }
    Ok(())
}

fn write_table(path: &Path, cells: usize, centre: impl Fn(usize) -> [f64; 3], outcome: &Outcome) -> anyhow::Result<()> {
    let data = cell_data(outcome);
    let centres: Vec<[f64; 3]> = (0..cells).map(centre).collect();
    let axes: Vec<Vec<f64>> = (0..3).map(|k| centres.iter().map(|c| c[k]).collect()).collect();
    let values: Vec<Vec<f64>> = data.iter().map(|array| array.values.to_f64()).collect();
    let mut columns: Vec<(&str, &[f64])> = ["x", "y", "z"].into_iter().zip(axes.iter().map(Vec::as_slice)).collect();
    columns.extend(data.iter().zip(&values).map(|(array, v)| (array.name.as_str(), v.as_slice())));
    write_csv(path, &columns)?;
    Ok(())
}
