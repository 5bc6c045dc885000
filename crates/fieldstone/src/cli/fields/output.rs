//! Where fields are written to: one file, one per frame, or block after block.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use fieldstone::fields::{Field, Function, KernelShape};
use fieldstone::io::vtk::{self, VtkArrays, VtkEncoding, VtkImage};
use fieldstone::io::{CsvWriter, DataArray, StatField, StatHeader, StatWriter};
use fieldstone::mesh::{Cells, Coordinates};

use super::cells::CellSet;
use super::frames::Outcome;
use super::names::mercury_name;
use super::settings::Settings;
use crate::cli::arguments::ending;

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

/// Results on their way to files, which appear when all are there.
pub(super) struct Writer<'a> {
    path: &'a Path,
    cells: &'a CellSet,
    /// The settings that led here, as TOML.
    echo: String,
    width: f64,
    encoding: VtkEncoding,
    state: State,
}

enum State {
    One(Format, Option<Outcome>),
    Series { staging: tempfile::TempDir, steps: Vec<(f64, PathBuf)> },
    Stat(Option<StatWriter>),
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
            Format::Pvd => {
                let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
                let staging = tempfile::Builder::new().prefix(".fieldstone-").tempdir_in(folder);
                let staging = staging.with_context(|| format!("{}: cannot write", path.display()))?;
                State::Series { staging, steps: Vec::new() }
            }
            one => State::One(one, None),
        };
        let (width, encoding) =
            (settings.width.unwrap_or(0.0), settings.encoding.map_or_else(VtkEncoding::default, Into::into));
        Ok(Self { path, cells, echo, width, encoding, state })
    }

    /// Takes a result.
    pub fn put(&mut self, outcome: Outcome) -> anyhow::Result<()> {
        match &mut self.state {
            State::One(_, Some(_)) => bail!(
                "--out {}: the frames give several results, and this file holds one; give a .pvd or .stat file, or \
                 --average, --smooth, or one frame (--frames)",
                self.path.display()
            ),
            State::One(_, slot) => *slot = Some(outcome),
            State::Series { staging, steps } => {
                let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
                let ending = if matches!(self.cells, CellSet::Mesh(_)) { "vtu" } else { "vti" };
                let name = PathBuf::from(format!("{stem}_{}.{ending}", outcome.index));
                let time = outcome.time;
                write_vtk(&staging.path().join(&name), self.cells, outcome, &self.echo, self.encoding)?;
                steps.push((time, name));
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
                Format::Csv => write_csv(self.path, self.cells, &outcome, &self.echo),
                _ => write_vtk(self.path, self.cells, outcome, &self.echo, self.encoding),
            },
            State::Series { staging, steps } if !steps.is_empty() => {
                let folder = self.path.parent().unwrap_or(Path::new(""));
                for (_, name) in &steps {
                    let target = folder.join(name);
                    std::fs::rename(staging.path().join(name), &target)
                        .with_context(|| format!("{}: cannot write", target.display()))?;
                }
                Ok(vtk::write_pvd(self.path, &steps)?)
            }
            State::Stat(Some(writer)) => Ok(writer.finish()?),
            _ => bail!("there is no frame to write; check --frames"),
        }
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
