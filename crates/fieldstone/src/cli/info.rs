//! `fieldstone info`: what is inside a file.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use fieldstone::geometry::ElementKind;
use fieldstone::io::vtk::{self, VtkData, VtkImage, VtkLocation, VtkSummary};
use fieldstone::io::{CsvTable, FileKind, ParticleOptions, StatFile, file_kind, open_particles, read_mesh, read_stat};
use fieldstone::mesh::{Cells, Mesh};
use fieldstone::particles::Particles;

use super::arguments::ending_of_input;
use super::report::{self, number};

/// Tell what is inside a mesh or particle file
///
/// Meshes: cells by type, warped and concave cells, volumes, patches, zones, and results in a .vtu. Particles: frames,
/// columns, box and size distribution. Grids (.vti): cells, spacing and results. Lists of files over time (.pvd), results over
/// time (.stat), surfaces (.vtp), results on cells and readings of gauges over time as tables (.csv). All in the file's units.
#[derive(Debug, Args)]
pub(crate) struct Info {
    /// Any file or folder that fieldstone reads
    file: PathBuf,
}

impl Info {
    pub fn run(self) -> anyhow::Result<()> {
        let mut lines = Lines(String::new());
        let ending = ending_of_input(&self.file);
        match ending.as_str() {
            "pvd" if self.file.is_file() => {
                lines.list(&vtk::read_pvd(&self.file)?);
                return report::print(&lines.0);
            }
            "stat" if self.file.is_file() => {
                lines.stat(&read_stat(&self.file)?);
                return report::print(&lines.0);
            }
            "csv" if self.file.is_file() => {
                let table = CsvTable::read(&self.file)?;
                if table.has("cell_volume") {
                    lines.table_of_cells(&table)?;
                    return report::print(&lines.0);
                }
                if is_over_time(&table) {
                    lines.table_over_time(&table)?;
                    return report::print(&lines.0);
                }
            }
            _ => {}
        }
        let vtk = ["vtu", "vti", "vtk"].contains(&ending.as_str());
        if (vtk || ending == "vtp") && self.file.is_file() {
            let data = vtk::read_vtk(&self.file)?;
            if !data.has_volume_cells() && data.cells.types().iter().any(|kind| POLYGONS.contains(kind)) {
                lines.add("surface", format!("{} points", data.points.len()));
                lines.add("polygons", data.cells.types().iter().filter(|kind| POLYGONS.contains(kind)).count());
                lines.columns(&data);
                return report::print(&lines.0);
            }
            if let Some(image) = &data.image {
                lines.image(image);
                lines.columns(&data);
                return report::print(&lines.0);
            }
        }
        match file_kind(&self.file)? {
            FileKind::Mesh => {
                let mesh = read_mesh(&self.file)?;
                lines.mesh(&mesh);
                if vtk {
                    lines.columns(&vtk::read_vtk(&self.file)?);
                }
            }
            FileKind::Particles => {
                let options = ParticleOptions { allow_non_spherical: true };
                let mut reader = open_particles(&self.file, &options)?;
                let mut frames = 0;
                let mut last = None;
                while let Some(frame) = reader.next_frame()? {
                    frames += 1;
                    last = Some(frame);
                }
                lines.add("frames", frames);
                if let Some(particles) = last {
                    lines.particles(&particles);
                }
            }
        }
        report::print(&lines.0)
    }
}

/// Whether a table holds readings over time, as `gauges.csv` of `sph run`, and neither particles nor cells.
pub(crate) fn is_over_time(table: &CsvTable) -> bool {
    table.has("time") && ["x", "r"].iter().all(|name| !table.has(name))
}

/// VTK's codes of triangles, strips of them, polygons, pixels and quadrilaterals.
const POLYGONS: [u8; 5] = [5, 6, 7, 8, 9];

fn vector(v: [f64; 3]) -> String {
    format!("({}, {}, {})", number(v[0]), number(v[1]), number(v[2]))
}

/// Least and largest of a column's numbers, and how many values are none.
fn range(low: f64, high: f64, not_numbers: usize) -> String {
    match (low <= high, not_numbers) {
        (true, 0) => format!("{} to {}", number(low), number(high)),
        (true, n) => format!("{} to {}, {n} NaN", number(low), number(high)),
        (false, 0) => "no values".into(),
        (false, n) => format!("{n} NaN and no number"),
    }
}

/// Names and values, one a line.
struct Lines(String);

impl Lines {
    fn add(&mut self, name: &str, value: impl std::fmt::Display) {
        let _ = writeln!(self.0, "{name:<20} {value}");
    }

    fn mesh(&mut self, mesh: &Mesh) {
        let parts = mesh.parts();
        self.add("points", parts.points.len());
        self.add("faces", format!("{} ({} internal)", parts.owner.len(), parts.neighbour.len()));
        self.add("cells", mesh.cell_count());
        let mut kinds = BTreeMap::<ElementKind, usize>::new();
        for cell in 0..mesh.cell_count() {
            *kinds.entry(mesh.cell_kind(cell)).or_default() += 1;
        }
        for (kind, count) in kinds {
            self.add(&format!("  {kind}"), count);
        }
        self.add("warped faces", mesh.warped_faces());
        self.add("concave cells", mesh.concave_cells());
        self.add("inverted cells", mesh.inverted_cells().len() + mesh.inverted_elements());
        let volumes = mesh.cell_volumes();
        self.add("mesh volume", number(volumes.iter().sum()));
        self.add("smallest cell", number(volumes.iter().copied().fold(f64::INFINITY, f64::min)));
        self.add("largest cell", number(volumes.iter().copied().fold(0.0, f64::max)));
        let (low, high) = mesh.bounds();
        self.add("from", vector(low));
        self.add("to", vector(high));
        for patch in &parts.patches {
            self.add("patch", format!("{} ({}, {} faces)", patch.name, patch.kind, patch.count));
        }
        for zone in &parts.zones {
            self.add("zone", format!("{} ({} cells)", zone.name, zone.cells.len()));
        }
    }

    fn image(&mut self, image: &VtkImage) {
        self.add("regular grid", image.cells.map(|n| n.to_string()).join(" × "));
        self.add("cells", image.cell_count());
        self.add("origin", vector(image.origin));
        self.add("spacing", vector(image.spacing));
    }

    /// Files over time.
    fn list(&mut self, steps: &[(f64, PathBuf)]) {
        self.add("files over time", steps.len());
        if let [(first, from), .., (last, to)] = steps {
            let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            self.add("time", format!("{} to {}", number(*first), number(*last)));
            self.add("files", format!("{} to {}; info tells what is in one", name(from), name(to)));
        } else if let [(time, file)] = steps {
            self.add("time", number(*time));
            self.add("file", file.display());
        }
    }

    /// MercuryCG's results over time.
    fn stat(&mut self, file: &StatFile) {
        self.add("results on points", file.header.points.map(|n| n.to_string()).join(" × "));
        self.add("from", vector(file.header.low));
        self.add("to", vector(file.header.high));
        self.add("frames", file.blocks.len());
        if let [first, .., last] = file.blocks.as_slice() {
            self.add("time", format!("{} to {}", number(first.time), number(last.time)));
        }
        for (k, field) in file.fields.iter().enumerate() {
            let data = file.blocks.last().and_then(|block| block.data.get(k)).map_or(&[][..], Vec::as_slice);
            self.column("column", &field.name, field.components, data);
        }
    }

    /// Results on cells, a row each.
    fn table_of_cells(&mut self, table: &CsvTable) -> anyhow::Result<()> {
        self.add("cells, one a row", table.len());
        for name in table.names() {
            self.column("column", name, 1, &table.column(name)?);
        }
        Ok(())
    }

    /// Readings over time, a row each, as `sph run` writes those of gauges.
    fn table_over_time(&mut self, table: &CsvTable) -> anyhow::Result<()> {
        self.add("times, one a row", table.len());
        for name in table.names() {
            self.column("column", name, 1, &table.column(name)?);
        }
        Ok(())
    }

    /// A column with its range.
    fn column(&mut self, place: &str, name: &str, components: usize, data: &[f64]) {
        let shape = if components == 1 { String::new() } else { format!(" ({components} numbers)") };
        let (min, max) = data.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
        let not_numbers = data.iter().filter(|x| x.is_nan()).count();
        self.add(place, format!("{name}{shape}, {}", range(min, max, not_numbers)));
    }

    /// Results that a file has on its points and cells.
    fn columns(&mut self, data: &VtkData) {
        // The settings of `fields` are a text as the codes of its bytes, and their range says nothing.
        let settings = |column: &VtkSummary| column.location == VtkLocation::Field && column.name == "fieldstone";
        for column in data.summaries().into_iter().filter(|column| !settings(column)) {
            let place = match column.location {
                VtkLocation::Point => "point column",
                VtkLocation::Cell => "cell column",
                VtkLocation::Field => "column of the file",
            };
            let shape =
                if column.components == 1 { String::new() } else { format!(" ({} numbers)", column.components) };
            let ranges = column.ranges.into_iter().flatten();
            let [low, high] = ranges.fold([f64::INFINITY, f64::NEG_INFINITY], |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
            self.add(place, format!("{}{shape}, {}", column.name, range(low, high, column.not_numbers)));
        }
    }

    fn particles(&mut self, particles: &Particles) {
        self.add("particles", format!("{} in the last frame", particles.len()));
        if let Some(step) = particles.step() {
            self.add("step", step);
        }
        if let Some(time) = particles.time() {
            self.add("time", number(time));
        }
        if let Some(domain) = particles.domain() {
            let axes: String = (0..3).filter(|&k| domain.periodic()[k]).map(|k| ['x', 'y', 'z'][k]).collect();
            let periodic = if axes.is_empty() { "not periodic".into() } else { format!("periodic along {axes}") };
            self.add("box", format!("{} to {}, {periodic}", vector(domain.low()), vector(domain.high())));
            if !domain.is_orthogonal() {
                let [xy, xz, yz] = domain.tilt().map(number);
                self.add("  tilted by", format!("xy {xy}, xz {xz}, yz {yz}; the corners above are those without"));
            }
        }
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for p in particles.positions() {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        if !particles.is_empty() {
            self.add("from", vector(low));
            self.add("to", vector(high));
        }
        if let Some(types) = particles.types() {
            let mut counts = BTreeMap::<i64, usize>::new();
            types.iter().for_each(|&t| *counts.entry(t).or_default() += 1);
            for (kind, count) in counts {
                self.add(&format!("  type {kind}"), count);
            }
        }
        match particles.radii() {
            Err(_) => self.add("radius", "none in the file: give --radius or --diameter"),
            Ok([]) => {}
            Ok(radii) => {
                let mut sorted = radii.to_vec();
                sorted.sort_by(f64::total_cmp);
                let at = |share: f64| number(sorted[((sorted.len() - 1) as f64 * share).round() as usize]);
                self.add("radius", format!("{} smallest, {} largest", at(0.0), at(1.0)));
                self.add("  10 % below", at(0.1));
                self.add("  50 % below", at(0.5));
                self.add("  90 % below", at(0.9));
                let volume: f64 = radii.iter().map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3)).sum();
                self.add("particle volume", number(volume));
            }
        }
        for q in particles.quantities() {
            self.column("column", &q.name, q.components, &q.data);
        }
    }
}
