//! What the commands for smoothed particle hydrodynamics share: frames in, their surroundings, numbered files out.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Instant;

use anyhow::{anyhow, bail};
use clap::Args;
use fieldstone::io::{BackgroundSeries, FrameRange, ParticleOptions, Series, SeriesFrame, find_files, find_times};
use fieldstone::particles::{Domain, Particles};
use fieldstone::surface::{Surroundings, Wall, estimate_spacing};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use serde::Serialize;

use super::arguments::{Periodic, bounds, list, positive};
use super::{outputs, report, sph_checks};

/// Particles in the frames that are worked on at the same time, and then those of one more: what memory has to hold.
const PARTICLES_TOGETHER: usize = 1_000_000;

/// Particles and everything about them that files do not say.
#[derive(Debug, Args)]
pub(crate) struct SphArguments {
    /// Particles: BGEO, VTK (.vtu, .vtp, .vtk), PLY, XYZ, CSV, dumps; .gz too. A pattern for many: {} stands for a number,
    /// * for any text; or a .pvd, which lists them
    ///
    /// Frames are counted from 0 in the order of the files, those with smaller numbers first: of Part_0010 and Part_0020
    /// the first is frame 0. --frames and {} in --out go by this count, not by the numbers in the files' names.
    #[arg(long, value_name = "FILE|PATTERN")]
    pub particles: String,
    /// Frames to take, START:STOP:STEP or one number, from 0; negative ones count from the end [default: all where --out
    /// holds {}, else the last]
    #[arg(long, value_name = "RANGE", allow_hyphen_values = true)]
    pub frames: Option<FrameRange>,
    /// Initial distance of the particles [default: estimated from their number density]
    #[arg(long, value_name = "DX", value_parser = positive, allow_negative_numbers = true)]
    pub spacing: Option<f64>,
    /// 2 (x and y; z must not vary) or 3
    #[arg(long, value_name = "D", default_value_t = 3, value_parser = clap::value_parser!(u8).range(2..=3))]
    pub dimension: u8,
    /// Periodic directions: auto (those of the file), none, or e.g. xy
    #[arg(long, default_value = "auto", value_name = "AXES")]
    pub periodic: Periodic,
    /// The periodic box, where the file states none
    #[arg(long = "box", value_name = "XMIN,XMAX,YMIN,YMAX,ZMIN,ZMAX", value_parser = bounds, allow_hyphen_values = true)]
    pub bounds: Option<[f64; 6]>,
    /// A plane wall nx·x + ny·y + nz·z = d that mirrors particles; the normal points into the fluid. May be repeated
    #[arg(long = "wall", value_name = "NX,NY,NZ,D", value_parser = wall, allow_hyphen_values = true)]
    pub walls: Vec<Wall>,
    /// Particles of which a column has this value are boundary: neighbours, but no fluid. May be repeated
    #[arg(long, value_name = "FIELD=VALUE")]
    pub boundary: Vec<Boundary>,
}

/// A condition on a column.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Boundary {
    field: String,
    value: f64,
}

impl FromStr for Boundary {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (field, value) = text.split_once('=').ok_or("give a column and a number, as in type=1")?;
        let value = value.trim().parse().map_err(|_| format!("'{value}' is no number; as in type=1"))?;
        Ok(Self { field: field.trim().into(), value })
    }
}

fn wall(text: &str) -> Result<Wall, String> {
    let [x, y, z, d] = list(text, "0,0,1,0 for the floor z = 0")?;
    Wall::new([x, y, z], d).map_err(|e| e.to_string())
}

impl SphArguments {
    /// The files, in their order, and which of their frames are asked for.
    fn files_and_range(&self, out: &NumberedOutput) -> anyhow::Result<(Vec<PathBuf>, FrameRange)> {
        let files = find_files(&self.particles)?;
        let range = match self.frames {
            Some(range) => range,
            None if out.is_numbered() => FrameRange::default(),
            None => "-1".parse()?,
        };
        Ok((files, range))
    }

    /// The frames, read ahead on a thread of their own: as many as are worked on at the same time.
    fn series(&self, out: &NumberedOutput) -> anyhow::Result<BackgroundSeries> {
        let (files, range) = self.files_and_range(out)?;
        // Ellipsoids and clumps are no matter where only centres count.
        let options = ParticleOptions { allow_non_spherical: true };
        let times = find_times(&self.particles)?;
        Ok(Series::new(files, options)
            .with_times(times)
            .with_range(range)
            .in_background(rayon::current_num_threads())?)
    }

    /// Works on all frames: what came of each, and its file, in their order.
    ///
    /// `work` is given the frame, the name of its output, and the seconds that were waited for it to be read. Small frames are
    /// worked on together, a thread each, since many of their steps are too short to be shared out.
    pub fn each_frame<T: Send>(
        &self,
        out: &NumberedOutput,
        work: impl Fn(&SeriesFrame, &Path, f64) -> anyhow::Result<T> + Sync,
    ) -> anyhow::Result<(Vec<T>, Vec<Written>)> {
        let mut series = self.series(out)?;
        let (mut outcomes, mut paths) = (Vec::new(), Vec::new());
        let style = ProgressStyle::with_template("{spinner} {pos} frames in {elapsed}, {msg}")?;
        let bar = ProgressBar::new_spinner().with_style(style);
        loop {
            let mut together = Vec::new();
            let mut particles = 0;
            let mut failure = None;
            while together.len() < rayon::current_num_threads() && particles < PARTICLES_TOGETHER {
                let begun = Instant::now();
                let Some(frame) = series.next() else { break };
                match frame.map_err(anyhow::Error::from).and_then(|f| out.check_room(paths.len()).map(|()| f)) {
                    Ok(frame) => {
                        let path = out.at(frame.index);
                        particles += frame.particles.len();
                        paths.push(Written { from: frame.path.clone(), to: path.clone() });
                        together.push((frame, path, begun.elapsed().as_secs_f64()));
                    }
                    Err(error) => {
                        failure = Some(error);
                        break;
                    }
                }
            }
            if together.is_empty() && failure.is_none() {
                break;
            }
            let found: Vec<anyhow::Result<T>> = together
                .par_iter()
                .map(|(frame, path, read)| {
                    bar.set_message(frame.path.display().to_string());
                    let outcome = work(frame, path, *read);
                    bar.inc(1);
                    outcome
                })
                .collect();
            for outcome in found {
                outcomes.push(outcome?);
            }
            if let Some(error) = failure {
                return Err(error);
            }
        }
        bar.finish_and_clear();
        for warning in series.warnings() {
            report::warn(warning);
        }
        if outcomes.is_empty() {
            let (files, range) = self.files_and_range(out)?;
            let first = files[0].display().to_string();
            let count = Series::new(files, ParticleOptions { allow_non_spherical: true }).count_frames()?;
            bail!(
                "--particles {}: {}; frames count in the order of the input, of which 0 is in {first}: choose others with \
                 --frames",
                self.particles,
                range.why_empty(count)
            );
        }
        Ok((outcomes, paths))
    }

    /// Files that must not be overwritten.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let mut files = find_files(&self.particles).unwrap_or_default();
        // A .pvd is an input beside the files that it lists.
        if Path::new(&self.particles).is_file() {
            files.push(PathBuf::from(&self.particles));
        }
        files
    }

    /// Everything about the particles of a frame but their positions.
    pub fn surroundings(&self, frame: &SeriesFrame) -> anyhow::Result<Surroundings> {
        let particles = &frame.particles;
        let file = frame.path.display();
        let dimension = usize::from(self.dimension);
        if particles.is_empty() {
            report::warn(&format!("{file}: frame {} holds no particle, and nothing is found in it", frame.index));
        }
        if dimension == 2 {
            sph_checks::in_plane(particles.positions(), &file.to_string())?;
        }
        let candidates = self.candidates(frame).map_err(|e| anyhow!("{file}: {e}"))?;
        let spacing = match self.spacing {
            Some(spacing) => spacing,
            None => {
                let fluid = fluid_positions(particles, candidates.as_deref());
                let estimate = estimate_spacing(&fluid, dimension).map_err(|e| anyhow!("{file}: {e}"))?;
                if particles.is_empty() {
                    bail!("{file}: frame {} holds no particle to estimate a spacing from; give --spacing", frame.index);
                }
                let Some(estimate) = estimate else {
                    bail!("{file}: {} particles are too few to estimate their spacing; give --spacing", fluid.len());
                };
                report::warn(&format!(
                    "{file}: spacing {estimate:.6} estimated; give --spacing for the simulation's own"
                ));
                estimate
            }
        };
        let volumes = volumes(particles);
        if let Some(volumes) = &volumes {
            // A spacing in another unit than the file's masses and densities shows here.
            let mut sorted = volumes.clone();
            sorted.sort_unstable_by(f64::total_cmp);
            let from_volume = sorted[sorted.len() / 2].powf(1.0 / dimension as f64);
            if !(0.5..=2.0).contains(&(from_volume / spacing)) {
                report::warn(&format!(
                    "{file}: mass over density is the volume of particles {from_volume:.3e} apart, but the spacing is \
                     {spacing}; check the spacing and its unit"
                ));
            }
        }
        sph_checks::before_walls(
            particles.positions(),
            candidates.as_deref(),
            &self.walls,
            spacing,
            &file.to_string(),
        )?;
        Ok(Surroundings {
            spacing,
            dimension,
            domain: self.domain(particles)?,
            walls: self.walls.clone(),
            candidates,
            volumes,
        })
    }

    /// Refuses a spacing that is off by so much that what is made of it would be nonsense.
    pub fn check_spacing(&self, frame: &SeriesFrame, surroundings: &Surroundings) -> anyhow::Result<()> {
        let Some(given) = self.spacing else { return Ok(()) };
        let file = frame.path.display().to_string();
        let fluid = fluid_positions(&frame.particles, surroundings.candidates.as_deref());
        match estimate_spacing(&fluid, surroundings.dimension).map_err(|e| anyhow!("{file}: {e}"))? {
            Some(measured) => sph_checks::spacing(given, measured, &file),
            None => Ok(()),
        }
    }

    fn domain(&self, particles: &Particles) -> anyhow::Result<Option<Domain>> {
        let given = match self.bounds {
            None => None,
            Some([x0, x1, y0, y1, z0, z1]) => {
                let periodic = [true, true, self.dimension == 3];
                Some(Domain::new([x0, y0, z0], [x1, y1, z1], periodic).map_err(|e| anyhow!("--box: {e}"))?)
            }
        };
        if given.is_some() && self.periodic == Periodic::Auto {
            bail!("--box: say along which axes the box is periodic, as in --periodic xy");
        }
        let Some(domain) = given.or(particles.domain().copied()) else {
            return match self.periodic {
                Periodic::Given(axes) if axes != [false; 3] => {
                    bail!("--periodic needs a box, and the particle file states none; give --box")
                }
                _ => Ok(None),
            };
        };
        let axes = match self.periodic {
            Periodic::Auto => domain.periodic(),
            Periodic::Given(axes) => axes,
        };
        Ok(axes.contains(&true).then(|| domain.with_periodic(axes)))
    }

    fn candidates(&self, frame: &SeriesFrame) -> anyhow::Result<Option<Vec<bool>>> {
        if self.boundary.is_empty() {
            return Ok(None);
        }
        let particles = &frame.particles;
        let mut fluid = vec![true; particles.len()];
        for Boundary { field, value } in &self.boundary {
            let column = particles.column(field).map_err(|e| anyhow!("--boundary {field}: {e}"))?;
            if column.components != 1 {
                bail!(
                    "--boundary {field}: the column has {0} numbers per particle; name one of them, {1}[1] to {1}[{0}]",
                    column.components,
                    column.name
                );
            }
            for (fluid, found) in fluid.iter_mut().zip(&column.data) {
                *fluid &= found != value;
            }
            // A frame of a series may be without boundary, so this is no error.
            if !column.data.is_empty() && !column.data.contains(value) {
                let name = frame.path.display();
                report::warn(&format!(
                    "--boundary {field}={value}: {name}: no particle has this value, so none of them is boundary by it; {}",
                    sph_checks::values(&column.data)
                ));
            }
        }
        if !fluid.is_empty() && !fluid.contains(&true) {
            bail!("--boundary: every particle is boundary; check the column and its value");
        }
        Ok(Some(fluid))
    }
}

/// The particles that are no boundary, by their indices.
pub(crate) fn fluid_particles(particles: &Particles, fluid: Option<&[bool]>) -> Vec<usize> {
    (0..particles.len()).filter(|&k| fluid.is_none_or(|f| f[k])).collect()
}

/// Positions of the particles that are no boundary.
pub(crate) fn fluid_positions(particles: &Particles, fluid: Option<&[bool]>) -> Vec<[f64; 3]> {
    fluid_particles(particles, fluid).into_iter().map(|k| particles.positions()[k]).collect()
}

/// m/ρ of each particle, where the file has both and they make sense.
fn volumes(particles: &Particles) -> Option<Vec<f64>> {
    let column = |name| particles.quantity(name).ok().filter(|q| q.components == 1).map(|q| &q.data);
    let (mass, density) = (column("mass")?, column("density")?);
    let volumes: Vec<f64> = mass.iter().zip(density).map(|(m, rho)| m / rho).collect();
    volumes.iter().all(|v| *v > 0.0 && v.is_finite()).then_some(volumes)
}

/// The name of the output, with `{}` for the number of the frame where there are many.
#[derive(Debug, Clone)]
pub(crate) struct NumberedOutput {
    option: &'static str,
    path: PathBuf,
}

impl NumberedOutput {
    pub fn new(option: &'static str, path: &Path) -> Self {
        Self { option, path: path.into() }
    }

    fn is_numbered(&self) -> bool {
        self.name().contains("{}")
    }

    fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The file for one frame.
    pub fn at(&self, frame: usize) -> PathBuf {
        if !self.is_numbered() {
            return self.path.clone();
        }
        self.path.with_file_name(self.name().replacen("{}", &frame.to_string(), 1))
    }

    /// Refuses places that cannot be written to, before any work is done.
    pub fn check(&self, others: &[&Path]) -> anyhow::Result<()> {
        outputs::check(self.option, &self.at(0), others)?;
        match self.name().split_once("{}") {
            Some((before, after)) => {
                outputs::NumberedNames::beside(&self.path, before, after).check(self.option, &self.path, others)
            }
            None => Ok(()),
        }
    }

    /// The same, with a file for the summary, which must be none of the others either.
    pub fn check_with_json(&self, others: &[&Path], json: Option<&Path>) -> anyhow::Result<()> {
        let Some(json) = json else { return self.check(others) };
        let first = self.at(0);
        outputs::check_json(json, &[others, &[first.as_path()]].concat())?;
        self.check(&[others, &[json]].concat())
    }

    /// Writes what is known of each frame as JSON, where asked for: one object, or a list where there may be many.
    pub fn write_json<T: Serialize>(&self, json: Option<&Path>, summaries: &[T]) -> anyhow::Result<()> {
        let Some(path) = json else { return Ok(()) };
        match summaries {
            [one] if !self.is_numbered() => outputs::write_json(path, one),
            all => outputs::write_json(path, &all),
        }
    }

    /// Refuses a second frame for one file.
    fn check_room(&self, frames_before: usize) -> anyhow::Result<()> {
        if frames_before > 0 && !self.is_numbered() {
            bail!(
                "{} {}: there is more than one frame; give a name with {{}} for its number, or one frame with --frames",
                self.option,
                self.path.display()
            );
        }
        Ok(())
    }
}

/// A result, and the file whose frame it is of.
#[derive(Debug, Clone)]
pub(crate) struct Written {
    from: PathBuf,
    to: PathBuf,
}

/// Results that are named one by one; of more of them the first and the last.
const NAMED: usize = 12;

/// Where results went. The numbers in names are counts of frames, which need not be those in the names of the input: with
/// several files of it each result is told with its own.
pub(crate) fn written(results: &[Written]) -> String {
    let (first, last) = match results {
        [] => return "nothing".into(),
        [one] => return one.to.display().to_string(),
        [first, .., last] => (first, last),
    };
    if results.iter().all(|result| result.from == first.from) {
        return format!("{} … {}, {} files", first.to.display(), last.to.display(), results.len());
    }
    let line = |result: &Written| format!("{} from {}", result.to.display(), result.from.display());
    let lines: Vec<String> = if results.len() <= NAMED {
        results.iter().map(line).collect()
    } else {
        vec![line(first), format!("… {} files …", results.len()), line(last)]
    };
    lines.join(&format!("\n{:21}", ""))
}
