//! Where fields are written to: one file, one per frame, or block after block.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use fieldstone::fields::{Field, Function, KernelShape};
use fieldstone::io::vtk::{self, VtkArrays, VtkEncoding, VtkImage};
use fieldstone::io::{CsvWriter, DataArray, StatField, StatHeader, StatWriter, write_particles_csv_named};
use fieldstone::mesh::{Cells, Coordinates};

use fieldstone::particles::Particles;

use super::cells::CellSet;
use super::faces::FaceFields;
use super::frames::Outcome;
use super::names::mercury_name;
use super::settings::{Encoding, Settings};
use crate::cli::arguments::ending;
use crate::cli::publish::Published;

/// What kind of file is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Vti,
    Vtu,
    Csv,
    Pvd,
    Stat,
}

/// Kinds of cells, as far as they decide on the files that can hold them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CellKind {
    Mesh,
    Grid,
    Cylinder,
}

impl Format {
    pub fn of(path: &Path, cells: CellKind) -> anyhow::Result<Self> {
        let format = match ending(path).as_str() {
            "vti" => Self::Vti,
            "vtu" => Self::Vtu,
            "csv" => Self::Csv,
            "pvd" => Self::Pvd,
            "stat" => Self::Stat,
            _ => bail!("--out {}: the ending is not known; use .vti, .vtu, .pvd, .csv or .stat", path.display()),
        };
        let (name, fits) = match cells {
            CellKind::Mesh => ("a mesh is written as .vtu, .pvd or .csv", &[Self::Vtu, Self::Pvd, Self::Csv][..]),
            CellKind::Grid => {
                ("a grid is written as .vti, .pvd, .csv or .stat", &[Self::Vti, Self::Pvd, Self::Csv, Self::Stat][..])
            }
            CellKind::Cylinder => ("cylindrical cells are written as .csv", &[Self::Csv][..]),
        };
        if !fits.contains(&format) {
            bail!("--out {}: {name}", path.display());
        }
        Ok(format)
    }

    /// Whether one file holds, or leads to, the results of many frames.
    pub fn is_series(self) -> bool {
        matches!(self, Self::Pvd | Self::Stat)
    }
}

/// Results on their way to files, which get their names when all results are there.
///
/// A file, and a series with its list, is there as a whole or not at all. One output follows the other, the fields on
/// cells first: where one cannot be written, those before it are there.
pub(super) struct Writer<'a> {
    path: &'a Path,
    cells: &'a CellSet,
    /// The settings that led here, as TOML.
    echo: String,
    width: f64,
    encoding: VtkEncoding,
    state: State,
    /// What is written beside the fields on cells.
    sides: Vec<Side<'a>>,
}

enum State {
    One(Format, Option<Box<Outcome>>),
    Series(Staged),
    Stat(Option<StatWriter>),
}

/// Files of a series, which get their names when all are there, and the list of them over time.
struct Staged {
    list: PathBuf,
    folder: tempfile::TempDir,
    steps: Vec<(f64, PathBuf)>,
}

impl Staged {
    fn new(list: &Path) -> anyhow::Result<Self> {
        let parent = list.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = tempfile::Builder::new().prefix(".fieldstone-").tempdir_in(parent);
        let folder = folder.with_context(|| format!("{}: cannot write", list.display()))?;
        Ok(Self { list: list.into(), folder, steps: Vec::new() })
    }

    /// Adds a frame's file, which `write` writes.
    fn add(
        &mut self,
        index: usize,
        time: f64,
        ending: &str,
        write: impl FnOnce(&Path) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let stem = self.list.file_stem().unwrap_or_default().to_string_lossy();
        let name = PathBuf::from(format!("{stem}_{index}.{ending}"));
        write(&self.folder.path().join(&name))?;
        self.steps.push((time, name));
        Ok(())
    }

    /// Gives the files their names and writes the list: the whole series is there, or what was there before.
    fn finish(self) -> anyhow::Result<()> {
        let parent = self.list.parent().unwrap_or(Path::new(""));
        let names = self.steps.iter().map(|(_, name)| (self.folder.path().join(name), parent.join(name)));
        let published = Published::new(&names.collect::<Vec<_>>(), self.folder.path())?;
        let listed = vtk::write_pvd(&self.list, &self.steps);
        if listed.is_err() {
            published.take_back();
        }
        Ok(listed?)
    }
}

/// Files beside the fields on cells.
struct Side<'a> {
    path: &'a Path,
    series: Option<Staged>,
    /// The only result, with its time.
    pending: Option<(Content, f64)>,
}

/// What such a file holds.
pub(super) enum Content {
    Faces(FaceFields),
    /// With the names of the fields' components.
    Particles(Box<Particles>, Vec<(String, Vec<String>)>),
}

impl Content {
    fn write(&self, path: &Path, cells: &CellSet, time: f64, echo: &str, encoding: VtkEncoding) -> anyhow::Result<()> {
        match self {
            Self::Faces(faces) => faces.write(path, cells, time, echo, encoding),
            Self::Particles(particles, names) => {
                let names: Vec<(&str, &[String])> =
                    names.iter().map(|(name, list)| (name.as_str(), &list[..])).collect();
                if ending(path) == "csv" {
                    return Ok(write_particles_csv_named(path, particles, &names)?);
                }
                Ok(vtk::write_vtp_particles_named(path, particles, &names, encoding)?)
            }
        }
    }
}

/// Checks the name of a file beside the fields: one of `endings`, or a list of such files where the fields are one.
pub(super) fn check_side(option: &str, path: &Path, endings: &[&str], series: bool) -> anyhow::Result<()> {
    let wanted = if series { &["pvd"][..] } else { endings };
    if !wanted.contains(&ending(path).as_str()) {
        let why = if series { ", since there is a result for each frame" } else { "" };
        bail!("{option} {}: give a name that ends in .{}{why}", path.display(), wanted.join(" or ."));
    }
    Ok(())
}

impl<'a> Writer<'a> {
    pub fn new(
        path: &'a Path,
        format: Format,
        cells: &'a CellSet,
        echo: String,
        settings: &Settings,
    ) -> anyhow::Result<Self> {
        let state = match format {
            Format::Stat => State::Stat(None),
            Format::Pvd => State::Series(Staged::new(path)?),
            one => State::One(one, None),
        };
        let width = settings.width.unwrap_or(0.0);
        let encoding = settings.encoding.unwrap_or(match cells {
            // Meshes are read by programs that know zlib only; grids have most cells, and those programs read none.
            CellSet::Mesh(_) => Encoding::Zlib,
            _ => Encoding::Lz4,
        });
        let encoding = encoding.into();
        Ok(Self { path, cells, echo, width, encoding, state, sides: Vec::new() })
    }

    /// Adds a file beside the fields on cells; results come with contents for the sides in the order of this.
    pub fn beside(&mut self, path: &'a Path) -> anyhow::Result<()> {
        let series = if ending(path) == "pvd" { Some(Staged::new(path)?) } else { None };
        self.sides.push(Side { path, series, pending: None });
        Ok(())
    }

    /// Takes a result, and what belongs beside it.
    pub fn put(&mut self, outcome: Outcome, contents: Vec<Content>) -> anyhow::Result<()> {
        for (side, content) in self.sides.iter_mut().zip(contents) {
            match &mut side.series {
                Some(staged) => staged.add(outcome.index, outcome.time, "vtp", |path| {
                    content.write(path, self.cells, outcome.time, &self.echo, self.encoding)
                })?,
                None => side.pending = Some((content, outcome.time)),
            }
        }
        match &mut self.state {
            State::One(_, Some(_)) => bail!(
                "--out {}: the frames give several results, and this file holds one; give a .pvd or .stat file, or \
                 --average, --smooth, or one frame (--frames)",
                self.path.display()
            ),
            State::One(_, slot) => *slot = Some(Box::new(outcome)),
            State::Series(staged) => {
                let ending = if matches!(self.cells, CellSet::Mesh(_)) { "vtu" } else { "vti" };
                let (cells, echo, encoding) = (self.cells, &self.echo, self.encoding);
                staged
                    .add(outcome.index, outcome.time, ending, |path| write_vtk(path, cells, outcome, echo, encoding))?;
            }
            State::Stat(writer) => {
                let CellSet::Grid(grid) = self.cells else { bail!("this output does not go with these cells") };
                let fields = &outcome.fields.fields;
                let writer = match writer {
                    Some(writer) => writer,
                    None => {
                        let header = StatHeader {
                            coordinates: Coordinates::new(grid.averaged().map(|averaged| !averaged)),
                            low: grid.low(),
                            high: grid.high(),
                            time_min: outcome.time,
                            points: grid.cells(),
                            width: self.width,
                            function: function_words(outcome.fields.function),
                        };
                        let columns = fields.iter().map(|field| StatField {
                            name: mercury_name(&field.name),
                            components: field.components.len(),
                        });
                        writer.insert(StatWriter::create(self.path, header, columns.collect())?)
                    }
                };
                let data: Vec<&[f64]> = fields.iter().map(|field| field.data.as_slice()).collect();
                writer.block(outcome.time, &data)?;
            }
        }
        Ok(())
    }

    /// Gives the files their names.
    pub fn finish(self) -> anyhow::Result<()> {
        match self.state {
            State::One(format, Some(outcome)) => match format {
                Format::Csv => write_csv(self.path, self.cells, &outcome, &self.echo)?,
                _ => write_vtk(self.path, self.cells, *outcome, &self.echo, self.encoding)?,
            },
            State::Series(staged) if !staged.steps.is_empty() => staged.finish()?,
            State::Stat(Some(writer)) => writer.finish()?,
            _ => bail!("there is no frame to write; check --frames"),
        }
        for side in self.sides {
            match (side.series, side.pending) {
                (Some(staged), _) => staged.finish()?,
                (None, Some((content, time))) => {
                    content.write(side.path, self.cells, time, &self.echo, self.encoding)?;
                }
                (None, None) => {}
            }
        }
        Ok(())
    }
}

/// The function as MercuryCG writes it into a header.
fn function_words(function: Function) -> String {
    match function {
        Function::Overlap(_) => "ExactOverlap".into(),
        Function::Kernel(kernel) => {
            let cutoff = kernel.reach();
            match kernel.shape() {
                KernelShape::Gauss => format!("Gauss width {} cutoff {cutoff}", kernel.width()),
                KernelShape::Lucy => format!("Lucy cutoff {cutoff}"),
                KernelShape::Heaviside => format!("Heaviside cutoff {cutoff}"),
                KernelShape::Linear => format!("Linear cutoff {cutoff}"),
            }
        }
    }
}

fn volumes(cells: &CellSet) -> Vec<f64> {
    (0..cells.count()).map(|cell| cells.volume(cell)).collect()
}

fn write_vtk(path: &Path, cells: &CellSet, outcome: Outcome, echo: &str, encoding: VtkEncoding) -> anyhow::Result<()> {
    let (mut data, mut components) = (Vec::new(), Vec::new());
    for field in outcome.fields.fields {
        data.push(DataArray::floats(&field.name, field.components.len(), field.data));
        if field.components.len() > 1 {
            components.push((field.name, field.components));
        }
    }
    data.push(DataArray::scalar("cell_volume", volumes(cells)));
    let names: Vec<(&str, &[String])> =
        components.iter().map(|(name, list)| (name.as_str(), list.as_slice())).collect();
    let arrays = VtkArrays {
        cells: &data,
        time: Some(outcome.time),
        texts: &[("fieldstone", echo)],
        component_names: &names,
        ..VtkArrays::default()
    };
    match cells {
        CellSet::Mesh(mesh) => vtk::write_vtu(path, mesh, arrays, encoding)?,
        CellSet::Grid(grid) => vtk::write_vti(path, &VtkImage::from(grid), arrays, encoding)?,
        CellSet::Cylinder(_) => bail!("this output does not go with these cells"),
    }
    Ok(())
}

/// Name of a column of a table.
fn column_name(field: &Field, component: usize) -> String {
    match field.components[component].as_str() {
        "" => field.name.clone(),
        name => format!("{}_{name}", field.name),
    }
}

fn write_csv(path: &Path, cells: &CellSet, outcome: &Outcome, echo: &str) -> anyhow::Result<()> {
    let fields = &outcome.fields.fields;
    let axes = match cells {
        CellSet::Cylinder(_) => ["r", "angle", "height"],
        _ => ["x", "y", "z"],
    };
    let mut names: Vec<String> = axes.map(String::from).into();
    names.push("cell_volume".into());
    for field in fields {
        names.extend((0..field.components.len()).map(|k| column_name(field, k)));
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let comment = format!("{echo}# time {}\n", outcome.time);
    let mut writer = CsvWriter::create_with_comment(path, &comment, &names)?;
    let mut row = Vec::new();
    for cell in 0..cells.count() {
        row.clear();
        row.extend(match cells {
            CellSet::Mesh(mesh) => mesh.cell_centre(cell),
            CellSet::Grid(grid) => grid.centre(cell),
            CellSet::Cylinder(grid) => {
                let [i, j, k] = grid.indices(cell);
                let mid = |a: f64, b: f64| 0.5 * (a + b);
                [
                    mid(grid.radius(i), grid.radius(i + 1)),
                    mid(grid.angle(j), grid.angle(j + 1)),
                    mid(grid.height(k), grid.height(k + 1)),
                ]
            }
        });
        row.push(cells.volume(cell));
        fields.iter().for_each(|field| row.extend_from_slice(field.cell(cell)));
        writer.row(&row)?;
    }
    Ok(writer.finish()?)
}
