//! `fieldstone fields`: coarse graining.

mod account;
mod binned;
mod body_force;
mod cells;
mod clock;
mod contacts;
mod faces;
mod frames;
mod names;
mod output;
mod request;
mod settings;
mod to_particles;
mod watch;

use std::path::PathBuf;
use std::time::Instant;

use anyhow::{anyhow, bail};
use clap::Args;
use fieldstone::fields::{FieldName, FieldsError, UserQuantity};
use fieldstone::io::{BackgroundSeries, read_restart};
use fieldstone::mesh::Cells;
use fieldstone::particles::{Domain, Particles};

use super::arguments::{Periodic, available_memory};
use super::{outputs, report};
use account::{Account, Seen};
use binned::MOST_TYPES;
use body_force::body_forces;
use cells::{CellSet, bytes_per_cell, over_particles};
use clock::Clock;
use faces::FaceSums;
use frames::{Frame, Outcome, OverTime, Plan, Source, compute, with_displacements};
pub(crate) use names::mercury_name;
use output::{Content, Writer};
use request::Run;
use settings::{Settings, Sign};
use to_particles::particle_field;
use watch::Watch;

/// Continuum fields from particles and contacts: density, velocity, stress, temperature, … on a grid or mesh
///
/// Exact overlaps conserve mass, momentum and stress to rounding, and the account printed at the end shows it. All
/// settings may stand in a TOML file instead, which the result repeats.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:\n  \
    fieldstone fields --particles dump.chute --contacts pair.dump --contacts-preset liggghts-pair\n    \
    --contacts wall.dump --contacts-preset liggghts-wall --cells 10,10,20 --out chute.vti\n  \
    fieldstone fields --particles box.data --contacts box.fstat --restart box.restart --cells 20\n    \
    --function lucy --width 0.5 --out box.stat\n  \
    fieldstone fields --particles 'dump_*.chute' --coordinates Z --cells 50 --fields density,velocity\n    \
    --average --out profile.csv\n  \
    fieldstone fields settings.toml\n\n\
    Units: those of the input, which must agree with each other; stress is force per area in them.")]
pub(crate) struct FieldsCommand {
    /// Settings as TOML, with the long options' names as keys; options on the command line go before them
    #[arg(value_name = "SETTINGS", conflicts_with = "config")]
    file: Option<PathBuf>,
    /// The same, as an option
    #[arg(long, value_name = "SETTINGS")]
    config: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
}

impl FieldsCommand {
    pub fn run(self) -> anyhow::Result<()> {
        let begin = Instant::now();
        let file = self.config.or(self.file);
        let settings = match &file {
            Some(path) => self.settings.before(Settings::read(path)?),
            None => self.settings,
        };
        settings.check()?;
        Run::new(&settings, file.as_deref())?.run(begin)
    }
}

impl Run<'_> {
    /// The middle of the frames' times.
    fn middle(&self, clock: &Clock) -> anyhow::Result<f64> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for frame in self.series(false) {
            let frame = frame?;
            let time = clock.time_of(&frame.path, frame.index, &frame.particles);
            (low, high) = (low.min(time), high.max(time));
        }
        Ok(0.5 * (low + high))
    }

    fn over_time(&self, clock: &Clock) -> anyhow::Result<OverTime> {
        Ok(match self.settings.smooth {
            _ if self.settings.average == Some(true) => OverTime::Mean,
            None => OverTime::Each,
            Some(width) if self.format.is_series() => OverTime::SmoothEach(width),
            Some(width) => OverTime::SmoothAt { width, at: self.middle(clock)? },
        })
    }

    fn run(mut self, begin: Instant) -> anyhow::Result<()> {
        let restart = self.settings.restart.as_deref().map(read_restart).transpose()?;
        if let Some(restart) = &restart {
            restart.warnings.iter().for_each(|warning| report::warn(warning));
        }
        let mut series = self.series(true).in_background(rayon::current_num_threads())?;
        let Some(first) = series.next().transpose()? else {
            let count = self.series(false).count_frames()?;
            bail!("{}: {}; check --frames", self.files[0].display(), self.range.why_empty(count))
        };
        let (clock, note) = Clock::new(&self.files, self.particle_options(), self.settings.timestep, &first.particles)?;
        if let Some(note) = note.filter(|_| self.settings.timestep.is_some() || self.settings.smooth.is_some()) {
            report::warn(&note);
        }
        let over_time = self.over_time(&clock)?;
        let source = Source { settings: self.settings, restart: restart.as_ref(), clock: &clock, bounds: self.bounds };
        let first = source.frame(first)?;
        first.particles.radii().map_err(|e| anyhow!("{}: {e}; give one for all with --radius", first.name))?;
        self.options.quantities = self.quantities(&first)?;
        if self.settings.fields.as_deref() == Some("all") && first.particles.quantity("angular_velocity").is_err() {
            self.options.fields.retain(|field| !needs_spin(*field));
        }
        self.species = self.species(&first)?;
        let laid = over_particles(self.settings, &first)?;
        let settings = laid.as_ref().map_or(self.settings, |(settings, _)| settings);
        let cells = CellSet::new(settings, &first.particles, self.periodic, self.columns())?;
        let (laid, note) = laid.unzip();
        self.laid = laid;
        let job = Job { cells: &cells, first, series: &mut series, source, over_time };
        let keep = self.settings.face_fields.is_some();
        let account = match &cells {
            CellSet::Mesh(mesh) => {
                let faces = |frame: &Frame, domain: Option<&Domain>| {
                    FaceSums::new(mesh.as_ref(), &frame.particles, frame.contacts.as_ref(), domain, keep)
                };
                self.on_cells(mesh.as_ref(), Some(&faces), job)?
            }
            CellSet::Grid(grid) => {
                let faces = |frame: &Frame, domain: Option<&Domain>| {
                    FaceSums::new(grid, &frame.particles, frame.contacts.as_ref(), domain, keep)
                };
                self.on_cells(grid, Some(&faces), job)?
            }
            CellSet::Cylinder(grid) => self.on_cells(grid, None, job)?,
        };
        // A run that is refused needs no more said of it.
        note.iter().chain(series.warnings()).for_each(|warning| report::warn(warning));
        if let Some(path) = &self.settings.json {
            account.write(path, begin.elapsed().as_secs_f64())?;
        }
        let text = format!(
            "{}{:<20} {:.2}\n{:<20} {}\n",
            account.text(),
            "seconds",
            begin.elapsed().as_secs_f64(),
            "written to",
            self.out.display()
        );
        outputs::report_beside(self.settings.json.as_deref(), &text)
    }

    /// Fields of all frames, to files.
    fn on_cells<C: Cells>(
        &mut self,
        cells: &C,
        faces: Option<&FacesInBox<'_>>,
        job: Job<'_>,
    ) -> anyhow::Result<Account> {
        let domain = self.domain_of(&job.first, cells.bounds())?;
        self.options.domain = domain;
        let settings = self.settings;
        if settings.face_fields.is_some() && job.first.contacts.is_none() && !moves(&job.first.particles) {
            bail!("--face-fields: {}: there are neither contacts nor velocities; give --contacts", job.first.name);
        }
        let mut writer = self.writer(job.cells)?;
        let refused = match (self.displaced(), settings.smooth.is_some()) {
            (true, _) => Some("displacement"),
            (_, true) => Some("--smooth"),
            _ => None,
        };
        let watch = Watch::new(refused, &job.first)?;
        let rest = job.series.map(|frame| job.source.frame(frame?));
        let frames = std::iter::once(Ok(job.first)).chain(rest).map(|frame| {
            let frame = frame?;
            self.check_types(&frame)?;
            watch.see(&frame)?;
            Ok(frame)
        });
        let sign = if settings.sign == Some(Sign::Tension) { "tension" } else { "compression" };
        let mut account = Account::new(&self.options, job.cells.count(), self.gravity, sign);
        let mut sink = |mut outcome: Outcome| {
            account.add(&outcome.fields, |cell| cells.cell_volume(cell));
            account.add_balance(outcome.balance);
            let contents = self.complete(cells, &mut outcome)?;
            writer.put(outcome, contents)
        };
        let in_box;
        let faces = match faces {
            Some(faces) => {
                in_box = |frame: &Frame| faces(frame, domain.as_ref());
                Some(&in_box as &frames::FaceSource<'_>)
            }
            None => None,
        };
        let plan = Plan {
            options: &self.options,
            species: &self.species,
            faces,
            keep_particles: settings.to_particles.is_some(),
            at_once: self.at_once(job.cells.count()),
        };
        if self.displaced() {
            compute(cells, &plan, job.over_time, with_displacements(frames), &mut sink)?;
        } else {
            compute(cells, &plan, job.over_time, frames, &mut sink)?;
        }
        let (seen, warnings) = watch.finish(domain.is_some());
        account.seen = seen;
        if self.displaced() {
            self.leave_out_the_last(&mut account.seen)?;
        }
        self.check_binned(cells, &account)?;
        writer.finish()?;
        warnings.iter().for_each(|warning| report::warn(warning));
        Ok(account)
    }

    /// The box whose images count: as the first frame and the options say.
    fn domain_of(&self, first: &Frame, bounds: ([f64; 3], [f64; 3])) -> anyhow::Result<Option<Domain>> {
        let given = matches!(self.periodic, Periodic::Given(axes) if axes != [false; 3]);
        if given && first.particles.domain().is_none() {
            bail!("--periodic: {}: the files state no box; give it with --box", first.name);
        }
        let (domain, note) = self.periodic.domain(&first.particles, bounds)?;
        if let Some(note) = note {
            report::warn(&note);
        }
        Ok(domain)
    }

    /// Where the results go.
    fn writer<'b>(&'b self, cells: &'b CellSet) -> anyhow::Result<Writer<'b>> {
        let settings = self.laid.as_ref().unwrap_or(self.settings);
        let echo = format!("{}{}", settings.echo()?, self.legend());
        let mut writer = Writer::new(self.out, self.format, cells, echo, self.settings)?;
        let beside = [&self.settings.face_fields, &self.settings.to_particles];
        beside.into_iter().flatten().try_for_each(|path| writer.beside(path))?;
        Ok(writer)
    }

    /// Adds the fields that are made of others, and gives what is written beside the fields on cells.
    fn complete<C: Cells>(&self, cells: &C, outcome: &mut Outcome) -> anyhow::Result<Vec<Content>> {
        if let Some(g) = self.gravity {
            let forces = body_forces(&outcome.fields, g);
            outcome.fields.fields.extend(forces);
        }
        let mut contents = Vec::new();
        if self.settings.face_fields.is_some() {
            contents.push(Content::Faces(std::mem::take(&mut outcome.faces)));
        }
        if let Some(particles) = outcome.particles.take() {
            let fields = &outcome.fields.fields;
            let names = fields.iter().map(|field| (particle_field(field), field.components.clone())).collect();
            contents.push(Content::Particles(self.at_particles(cells, particles, &outcome.fields)?, names));
        }
        Ok(contents)
    }

    /// The user's quantities, with whole columns of the first frame taken apart into components.
    fn quantities(&self, first: &Frame) -> anyhow::Result<Vec<UserQuantity>> {
        let make = |asked: &settings::QuantityName| {
            let columns: Vec<&str> = asked.columns.iter().map(String::as_str).collect();
            let quantity = UserQuantity::of_columns(&asked.name, &columns, asked.kind, &first.particles)
                .map_err(|e| anyhow!("--quantity {asked}: {}: {e}{}", first.name, asked.kind_hint()))?;
            if !matches!(quantity.columns.len(), 1 | 3 | 6 | 9) {
                bail!(
                    "--quantity {asked}: {}: the columns hold {} numbers per particle, which is neither a scalar (1), a \
                     vector (3), a symmetric tensor (6) nor a square one (9)",
                    first.name,
                    quantity.columns.len()
                );
            }
            Ok(quantity)
        };
        self.settings.quantities.iter().map(make).collect()
    }

    /// Takes the last frame, which has no displacements, out of those that the result is of.
    fn leave_out_the_last(&self, seen: &mut Seen) -> anyhow::Result<()> {
        if seen.frames < 2 {
            bail!(
                "--fields: {}: displacements are those to the next frame, and there is no frame after it; give at least two \
                 (--frames)",
                seen.last
            );
        }
        seen.frames -= 1;
        // One result by default is that of the last two frames: nothing that was asked for is missing.
        if self.settings.frames.is_some() || !self.one_frame() {
            report::warn(&format!("{}: there is no next frame to be displaced to, so it is in no result", seen.last));
        }
        Ok(())
    }

    /// Frames that are computed at the same time: as many as there are threads, where half of the free memory holds
    /// them, and the results before them that are still being written.
    fn at_once(&self, cells: usize) -> usize {
        let frame = (cells as u64).saturating_mul(bytes_per_cell(self.columns())).max(1);
        let fit = available_memory().map_or(1, |bytes| bytes / 2 / (2 * frame));
        rayon::current_num_threads().min(usize::try_from(fit).unwrap_or(usize::MAX)).max(1)
    }

    /// Types that get fields of their own.
    fn species(&self, first: &Frame) -> anyhow::Result<Vec<i64>> {
        if self.settings.per_species != Some(true) {
            return Ok(Vec::new());
        }
        let found = first.particles.types();
        let found = found.ok_or_else(|| anyhow!("--per-species: {}: the particles have no types", first.name))?;
        let mut types = self.options.selection.types.clone().unwrap_or_else(|| found.to_vec());
        types.sort_unstable();
        types.dedup();
        if types.len() > MOST_TYPES {
            bail!(
                "--per-species: {}: there are {} types, and each gets fields of its own; name up to {MOST_TYPES} of them \
                 with --species",
                first.name,
                types.len()
            );
        }
        Ok(types)
    }

    /// Refuses a frame with a type that would be missing among the species.
    fn check_types(&self, frame: &Frame) -> anyhow::Result<()> {
        let wanted = self.settings.per_species == Some(true) && self.options.selection.types.is_none();
        let types = frame.particles.types().unwrap_or_default();
        match types.iter().find(|kind| wanted && self.species.binary_search(kind).is_err()) {
            Some(new) => bail!(
                "--per-species: {}: type {new} is not in the first frame; name all types with --species",
                frame.name
            ),
            None => Ok(()),
        }
    }
}

/// What crosses the faces in a frame, with its periodic box.
type FacesInBox<'a> = dyn Fn(&Frame, Option<&Domain>) -> Result<FaceSums, FieldsError> + Sync + 'a;

fn moves(particles: &Particles) -> bool {
    particles.quantity("velocity").is_ok()
}

/// What is to be done on cells of one kind.
struct Job<'a> {
    cells: &'a CellSet,
    first: Frame,
    series: &'a mut BackgroundSeries,
    source: Source<'a>,
    over_time: OverTime,
}

/// Whether a field is of spins, and says little of particles without them.
fn needs_spin(field: FieldName) -> bool {
    matches!(field, FieldName::AngularMomentum | FieldName::SpinDensity | FieldName::AngularVelocity)
}
