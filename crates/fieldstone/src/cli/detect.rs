//! `fieldstone detect`: free-surface particles.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{anyhow, bail};
use clap::Args;
use fieldstone::io::vtk::{VtkEncoding, write_vtp_particles_with};
use fieldstone::io::{DataArray, SeriesFrame, Values, write_particles_csv};
use fieldstone::particles::Quantity;
use fieldstone::surface::{
    Comparison, Detection, Method, ScanningCone, Surface, SurfaceError, SurfaceOptions, Surroundings, implausibilities,
};
use serde::Serialize;

use super::arguments::{ending, positive};
use super::sph_frames::{NumberedOutput, SphArguments, written};
use super::timing::Timing;
use super::{outputs, report};

/// Free-surface particles of smoothed particle hydrodynamics
///
/// Writes the particles with free_surface (1 or 0), level (0 free surface, 1 vicinity, 2 inner), normal (outward) and on
/// request exposure: the half-angle of the widest cone without a neighbour, in degrees.
///
/// The fluid ends at planes (--wall) and at particles (--boundary); there is no option for the bodies of fieldstone sph run,
/// and the fluid's sides at them come out as free surface. region in the frames of such a run, 0 on the free surface,
/// counts bodies.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:\n  \
    fieldstone detect --particles frame.bgeo --spacing 0.01 --out surface.vtp\n  \
    fieldstone detect --particles frame.vtk --spacing 0.01 --wall 0,0,1,0 --compare marrone,wang,haque --out surface.vtp\n  \
    fieldstone detect --particles 'PartFluid_{}.vtk' --spacing 0.01 --boundary type=0 --out surface_{}.vtp\n\n\
    Units: all lengths as in the input.")]
pub(crate) struct Detect {
    #[command(flatten)]
    sph: SphArguments,
    /// exact, geometrical, semi, haque (3-D), marrone, wang, sun (2-D) or dilts (2-D)
    ///
    /// exact: the criterion of the geometrical method, decided fast. geometrical: the same by the published algorithm.
    /// semi: position divergence first. The others are what SPH codes use.
    #[arg(long, value_name = "METHOD", default_value = "exact")]
    method: Method,
    /// Half-angle of the scanning cone in degrees, for exact, geometrical, semi and sun
    #[arg(long, value_name = "DEGREES", default_value_t = 45.0, allow_negative_numbers = true)]
    theta: f64,
    /// Radius within which neighbours count, in spacings, for the same methods
    #[arg(long, value_name = "R", default_value_t = 2.5, allow_negative_numbers = true)]
    radius: f64,
    /// Also label by these methods, and print how they differ from --method
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',')]
    compare: Vec<Method>,
    /// Distance from the free surface that counts as its vicinity, in spacings
    #[arg(long, value_name = "V", default_value_t = 4.0, value_parser = positive, allow_negative_numbers = true)]
    vicinity: f64,
    /// Add exposure and exposure_axis: some hundred times as long as the detection
    ///
    /// About 0.2 ms of one core per particle of a disordered flow, 0.6 ms on a lattice.
    #[arg(long)]
    exposure: bool,
    /// Leave level and normal out
    #[arg(long, conflicts_with = "exposure")]
    labels_only: bool,
    /// Result: .vtp or .csv; {} in its name stands for the number of the frame, from 0
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// Also write the summary as JSON: of a list of frames where --out holds {}
    ///
    /// - is standard output, and the report then goes to standard error.
    ///
    /// Keys of each frame: frame, file, particles, boundary, spacing, method, free_surface, isolated, duplicates, seconds
    /// with read, detect, fields, write; comparison with method, seconds, free_surface, reference, misses,
    /// false_positives, accuracy.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Serialize)]
struct Summary {
    frame: usize,
    file: String,
    particles: usize,
    boundary: usize,
    spacing: f64,
    method: &'static str,
    free_surface: usize,
    isolated: usize,
    duplicates: usize,
    seconds: Seconds,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    comparison: Vec<Row>,
}

#[derive(Serialize)]
struct Seconds {
    read: f64,
    detect: f64,
    fields: f64,
    write: f64,
}

#[derive(Serialize)]
struct Row {
    method: &'static str,
    seconds: f64,
    free_surface: usize,
    reference: usize,
    misses: usize,
    false_positives: usize,
    accuracy: Option<f64>,
}

impl Detect {
    pub fn run(self) -> anyhow::Result<()> {
        let out = NumberedOutput::new("--out", &self.out);
        self.check(&out)?;
        let (summaries, paths) = self.sph.each_frame(&out, |frame, path, read| self.frame(frame, path, read))?;
        out.write_json(self.json.as_deref(), &summaries)?;
        let mut text = String::new();
        if let [one] = summaries.as_slice() {
            text += &counts(one);
        } else {
            text += &frame_table(&summaries);
        }
        for summary in summaries.iter().filter(|s| !s.comparison.is_empty()) {
            text += &comparison_table(summary, summaries.len() > 1);
        }
        let _ = writeln!(text, "written to           {}", written(&paths));
        outputs::report_beside(self.json.as_deref(), &text)
    }

    fn check(&self, out: &NumberedOutput) -> anyhow::Result<()> {
        match ending(&self.out).as_str() {
            "vtp" | "csv" => {}
            _ => bail!("--out {}: the ending is not known; use .vtp or .csv", self.out.display()),
        }
        let dimension = usize::from(self.sph.dimension);
        for (option, method) in
            [("--method", self.method)].into_iter().chain(self.compare.iter().map(|&m| ("--compare", m)))
        {
            if !method.supports(dimension) {
                bail!("{option} {method}: this method does not exist in {dimension} dimensions; see --dimension");
            }
        }
        // Angle and radius are refused before any file is read.
        self.method.with_cone(self.cone()).map_err(|e| anyhow!("--theta, --radius: {e}"))?;
        let inputs = self.sph.inputs();
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        out.check_with_json(&inputs, self.json.as_deref())
    }

    fn cone(&self) -> ScanningCone {
        ScanningCone { radius: self.radius, angle: self.theta }
    }

    fn frame(&self, frame: &SeriesFrame, path: &Path, read: f64) -> anyhow::Result<Summary> {
        let file = frame.path.display().to_string();
        let placed = |e: SurfaceError| anyhow!("{file}: {e}");
        let surroundings = self.sph.surroundings(frame)?;
        let positions = frame.particles.positions();
        let mut timing = Timing::default();

        let (reference, seconds) = self.label(self.method, positions, &surroundings, &file)?;
        let mut comparison = Vec::new();
        for &method in &self.compare {
            let (other, seconds) = self.label(method, positions, &surroundings, "")?;
            let difference = Comparison::new(&reference.labels(), &other.labels()).map_err(placed)?;
            comparison.push(Row {
                method: method.name(),
                seconds,
                free_surface: other.free_surface(),
                reference: difference.reference,
                misses: difference.misses,
                false_positives: difference.false_positives,
                accuracy: difference.accuracy(),
            });
        }
        let columns =
            timing.measure("fields", || self.columns(positions, &surroundings, reference.clone())).map_err(placed)?;
        timing.measure("write", || write(path, frame, &columns))?;
        let boundary = surroundings.candidates.iter().flatten().filter(|fluid| !**fluid).count();
        Ok(Summary {
            frame: frame.index,
            file,
            particles: positions.len(),
            boundary,
            spacing: surroundings.spacing,
            method: self.method.name(),
            free_surface: reference.free_surface(),
            isolated: reference.isolated(),
            duplicates: reference.coincident(),
            seconds: Seconds {
                read,
                detect: seconds,
                fields: timing.seconds("fields"),
                write: timing.seconds("write"),
            },
            comparison,
        })
    }

    /// Labels by a method, and the time that they took, sorting included.
    fn label(
        &self,
        method: Method,
        positions: &[[f64; 3]],
        surroundings: &Surroundings,
        warn_of: &str,
    ) -> anyhow::Result<(Detection, f64)> {
        let named = |e: SurfaceError| anyhow!("{method}: {e}");
        let method = method.with_cone(self.cone()).map_err(named)?;
        let start = Instant::now();
        let grid = surroundings.grid(positions, method.reach(surroundings.spacing)).map_err(named)?;
        let scene = surroundings.scene(&grid);
        let detection = method.detect(&scene).map_err(named)?;
        let seconds = start.elapsed().as_secs_f64();
        if !warn_of.is_empty() {
            for finding in implausibilities(&scene) {
                report::warn(&format!("{warn_of}: {finding}"));
            }
        }
        Ok((detection, seconds))
    }

    fn columns(
        &self,
        positions: &[[f64; 3]],
        surroundings: &Surroundings,
        detection: Detection,
    ) -> Result<Vec<DataArray>, SurfaceError> {
        let options = if self.labels_only {
            SurfaceOptions::LABELS
        } else {
            let exposure = self.exposure.then_some(self.radius);
            SurfaceOptions { vicinity: Some(self.vicinity), exposure, ..SurfaceOptions::ALL }
        };
        let surface = Surface::of_detection(positions, detection, surroundings, &options)?;
        let bytes =
            |name: &str, values: Vec<u8>| DataArray { name: name.into(), components: 1, values: Values::U8(values) };
        let mut columns = vec![bytes("free_surface", surface.detection.labels().into_iter().map(u8::from).collect())];
        columns.extend(surface.levels.map(|levels| bytes("level", levels)));
        columns.extend(surface.normals.map(|normals| DataArray::floats("normal", 3, normals.into_flattened())));
        if let Some(cones) = surface.exposures {
            columns.push(DataArray::scalar("exposure", cones.iter().map(|c| c.half_angle.to_degrees()).collect()));
            columns.push(DataArray::floats("exposure_axis", 3, cones.iter().flat_map(|c| c.axis).collect()));
        }
        Ok(columns)
    }
}

fn write(path: &Path, frame: &SeriesFrame, columns: &[DataArray]) -> anyhow::Result<()> {
    if ending(path) == "vtp" {
        write_vtp_particles_with(path, &frame.particles, columns, VtkEncoding::default())?;
        return Ok(());
    }
    let mut particles = frame.particles.clone();
    for column in columns {
        let data = column.values.to_f64();
        particles =
            particles.with_quantity(Quantity { name: column.name.clone(), components: column.components, data })?;
    }
    write_particles_csv(path, &particles)?;
    Ok(())
}

fn counts(summary: &Summary) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<20} {value}");
    };
    line("particles", summary.particles.to_string());
    if summary.boundary > 0 {
        line("boundary", summary.boundary.to_string());
    }
    line("spacing", report::number(summary.spacing));
    line("free surface", summary.free_surface.to_string());
    line("isolated", summary.isolated.to_string());
    line("duplicates", summary.duplicates.to_string());
    text
}

fn frame_table(summaries: &[Summary]) -> String {
    let mut text =
        format!("{:>6} {:>10} {:>12} {:>9} {:>10}\n", "frame", "particles", "free surface", "isolated", "duplicates");
    for s in summaries {
        let _ = writeln!(
            text,
            "{:>6} {:>10} {:>12} {:>9} {:>10}",
            s.frame, s.particles, s.free_surface, s.isolated, s.duplicates
        );
    }
    text
}

/// The layout of the tables that methods are published with: TP, EP and M, and what EP is made of.
fn comparison_table(summary: &Summary, with_frame: bool) -> String {
    let mut text = String::from("\n");
    if with_frame {
        let _ = writeln!(text, "frame {}", summary.frame);
    }
    let _ = writeln!(
        text,
        "{:<12} {:>9} {:>9} {:>8} {:>8} {:>8} {:>16}",
        "method", "seconds", "TP", "EP", "M", "misses", "false positives"
    );
    let accuracy = |m: Option<f64>| m.map_or("-".into(), |m| format!("{m:.3}"));
    let reference = (summary.free_surface > 0).then_some(1.0);
    let _ = writeln!(
        text,
        "{:<12} {:>9.4} {:>9} {:>8} {:>8} {:>8} {:>16}",
        summary.method,
        summary.seconds.detect,
        summary.free_surface,
        0,
        accuracy(reference),
        0,
        0
    );
    for row in &summary.comparison {
        let _ = writeln!(
            text,
            "{:<12} {:>9.4} {:>9} {:>8} {:>8} {:>8} {:>16}",
            row.method,
            row.seconds,
            row.reference,
            row.misses + row.false_positives,
            accuracy(row.accuracy),
            row.misses,
            row.false_positives
        );
    }
    text.push('\n');
    text
}
