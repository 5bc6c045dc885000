//! `fieldstone fields`: coarse graining.

mod account;
mod binned;
mod cells;
mod clock;
mod contacts;
mod faces;
mod frames;
mod names;
mod output;
mod settings;

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{anyhow, bail};
use clap::Args;
use fieldstone::fields::{
    CoarseGrainingOptions, Field, FieldName, Fields, FieldsError, Function, Kernel, Method, Selection, UserQuantity,
    Weights, field_at_particles,
};
use fieldstone::io::{
    BackgroundSeries, ContactFiles, FrameRange, ParticleOptions, Series, find_files, find_times, read_restart,
};
use fieldstone::mesh::Cells;
use fieldstone::particles::{Contacts, Domain, Particles, Quantity};
use indicatif::{ProgressBar, ProgressStyle};

use super::arguments::{Periodic, available_memory};
use super::{outputs, report};
use account::{Account, Seen};
use cells::{CellSet, bytes_per_cell};
use clock::{Clock, TimeOrder};
use faces::FaceSums;
use frames::{Frame, Outcome, OverTime, Plan, Source, compute, with_displacements};
use names::ascii;
pub(crate) use names::mercury_name;
use output::{CellKind, Content, Format, Writer, check_side};
use settings::{FunctionName, Settings, Sign};

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
            Some(path) => self.settings.or(Settings::read(path)?),
            None => self.settings,
        };
        settings.check()?;
        Run::new(&settings, file.as_deref())?.run(begin)
    }
}

/// What is known before anything is read.
struct Run<'a> {
    settings: &'a Settings,
    out: &'a Path,
    format: Format,
    files: Vec<PathBuf>,
    /// Time of each file, where a .pvd lists them.
    times: Vec<f64>,
    contacts: Vec<ContactFiles>,
    range: FrameRange,
    periodic: Periodic,
    /// In place of the files' box.
    bounds: Option<Domain>,
    options: CoarseGrainingOptions,
    gravity: Option<[f64; 3]>,
    /// Types that get fields of their own.
    species: Vec<i64>,
}

impl<'a> Run<'a> {
    fn new(settings: &'a Settings, config: Option<&Path>) -> anyhow::Result<Self> {
        let particles = settings.particles.as_deref().ok_or_else(|| anyhow!("give the particles: --particles FILE"))?;
        let out = settings.out.as_deref().ok_or_else(|| anyhow!("give the result's name: --out OUT"))?;
        let cylindrical =
            matches!(settings.coordinates.as_deref().map(str::to_ascii_uppercase).as_deref(), Some("R" | "RZ" | "RTZ"));
        let kind = match (&settings.mesh, cylindrical) {
            (Some(_), _) => CellKind::Mesh,
            (None, true) => CellKind::Cylinder,
            (None, false) => CellKind::Grid,
        };
        let format = Format::of(out, kind)?;
        let files = find_files(particles)?;
        let contacts: Vec<ContactFiles> = (settings.contacts.0.iter())
            .map(|source| Ok(ContactFiles { files: find_files(&source.file)?, options: source.options() }))
            .collect::<anyhow::Result<_>>()?;
        refuse_repeats(&contacts)?;
        let inputs: Vec<&Path> = (files.iter().chain(contacts.iter().flat_map(|source| &source.files)))
            .map(PathBuf::as_path)
            .chain(settings.restart.as_deref())
            .chain(settings.mesh.as_deref())
            .chain(config)
            .collect();
        outputs::check("--out", out, &inputs)?;
        let mut taken = [&inputs[..], &[out]].concat();
        let sides = [
            ("--face-fields", &settings.face_fields),
            ("--to-particles", &settings.to_particles),
            ("--json", &settings.json),
        ];
        for (option, path) in sides {
            if let Some(path) = path {
                outputs::check(option, path, &taken)?;
                taken.push(path);
            }
        }
        let cells_ending = if kind == CellKind::Mesh { ".vtu" } else { ".vti" };
        let lists = [
            ("--out", Some(out), cells_ending),
            ("--face-fields", settings.face_fields.as_deref(), ".vtp"),
            ("--to-particles", settings.to_particles.as_deref(), ".vtp"),
        ];
        for (option, path, ending) in lists {
            if let Some(path) = path.filter(|path| super::arguments::ending(path) == "pvd") {
                let before = format!("{}_", path.file_stem().unwrap_or_default().to_string_lossy());
                outputs::NumberedNames::beside(path, &before, ending).check(option, path, &taken)?;
            }
        }
        if let Some(path) = &settings.face_fields {
            if kind == CellKind::Cylinder {
                bail!(
                    "--face-fields goes with grids and meshes: what crosses the curved faces of cylindrical cells is not \
                     computed"
                );
            }
            check_side("--face-fields", path, &["vtp"], format.is_series())?;
        }
        if let Some(path) = &settings.to_particles {
            if settings.average == Some(true) || settings.smooth.is_some() {
                bail!("--to-particles needs the fields of one frame at a time; leave out --average and --smooth");
            }
            if matches!(settings.function, Some(FunctionName::Kernel(_))) {
                bail!("--to-particles goes with overlaps, whose weights are volumes: --function exact");
            }
            check_side("--to-particles", path, &["vtp", "csv"], format.is_series())?;
        }
        let gravity = settings.gravity.as_ref().map(|g| g.exactly("gravity")).transpose()?;
        let mut run = Self {
            settings,
            out,
            format,
            files,
            times: find_times(particles)?,
            contacts,
            range: FrameRange::default(),
            periodic: settings.periodic.as_deref().unwrap_or("auto").parse().map_err(|e| anyhow!("--periodic: {e}"))?,
            bounds: None,
            options: CoarseGrainingOptions::default(),
            gravity,
            species: Vec::new(),
        };
        run.bounds = run.bounds()?;
        run.options = run.options()?;
        run.range = run.range()?;
        Ok(run)
    }

    /// Options of the library, but for what the first frame decides.
    fn options(&self) -> anyhow::Result<CoarseGrainingOptions> {
        let settings = self.settings;
        let defaults = CoarseGrainingOptions::default();
        let function = match settings.function.unwrap_or(FunctionName::Overlap(Method::Kernel)) {
            FunctionName::Overlap(method) => {
                if settings.width.is_some() || settings.cutoff.is_some() || settings.conserve == Some(true) {
                    bail!(
                        "--width, --cutoff and --conserve go with kernels: --function gauss, lucy, heaviside or linear"
                    );
                }
                Function::Overlap(method)
            }
            FunctionName::Kernel(shape) => {
                let Some(width) = settings.width else {
                    bail!("--function {shape} needs a width: --width W, about a particle's radius or more")
                };
                let cutoff = settings.cutoff;
                Function::Kernel(Kernel::new(shape, width, cutoff).map_err(|e| anyhow!("--width, --cutoff: {e}"))?)
            }
        };
        let asked = settings.fields.as_deref().unwrap_or("standard");
        // Made of the density after all frames.
        let named = |word: &str| word.trim() == "body_force_density";
        if asked.split(',').any(named) && self.gravity.is_none() {
            bail!("--fields body_force_density: the density's weight needs --gravity GX,GY,GZ");
        }
        let asked: Vec<&str> = asked.split(',').map(|word| if named(word) { "density" } else { word }).collect();
        let mut fields = FieldName::parse_list(&asked.join(",")).map_err(|e| anyhow!("--fields: {e}"))?;
        if self.contacts.is_empty() && matches!(settings.fields.as_deref(), None | Some("all")) {
            fields.retain(|field| !field.needs_contacts());
        }
        if self.gravity.is_some() && !fields.contains(&FieldName::Density) {
            bail!("--gravity makes body_force_density of the density; add density to --fields");
        }
        let radii = settings.radii.as_ref().map(|radii| radii.exactly("radii")).transpose()?;
        let region = settings.region.as_ref().map(|region| region.exactly("region")).transpose()?;
        let selection = Selection {
            types: settings.species.as_ref().map(|types| types.0.clone()),
            radii,
            region: region.map(|[x0, x1, y0, y1, z0, z1]: [f64; 6]| [[x0, y0, z0], [x1, y1, z1]]),
        };
        selection.check().map_err(|e| anyhow!("--radii, --region: {e}"))?;
        Ok(CoarseGrainingOptions {
            function,
            contact_form: settings.stress_form.map(Into::into),
            fields,
            sign: settings.sign.unwrap_or(Sign::Compression).into(),
            mean_velocity: settings.mean_velocity.map_or(defaults.mean_velocity, Into::into),
            walls_in_contact_force: settings.walls.map_or(defaults.walls_in_contact_force, Into::into),
            conserve: settings.conserve.unwrap_or(false),
            selection,
            particle_density: settings.density,
            ..defaults
        })
    }

    /// The box that was given, with its periodic directions.
    fn bounds(&self) -> anyhow::Result<Option<Domain>> {
        let Some(bounds) = &self.settings.bounds else { return Ok(None) };
        Ok(Some(self.periodic.given_box(bounds.exactly("box")?)?))
    }

    fn displaced(&self) -> bool {
        self.options.fields.iter().any(|field| field.needs_displacement())
    }

    /// Whether the result is that of one frame.
    fn one_frame(&self) -> bool {
        !self.format.is_series() && self.settings.average != Some(true) && self.settings.smooth.is_none()
    }

    fn range(&self) -> anyhow::Result<FrameRange> {
        let one_frame = self.one_frame();
        let text = match self.settings.frames.as_deref() {
            Some(text) => text,
            None if one_frame && self.displaced() => "-2:",
            None if one_frame => "-1",
            None => ":",
        };
        text.parse().map_err(|e| anyhow!("--frames: {e}"))
    }

    fn particle_options(&self) -> ParticleOptions {
        ParticleOptions { allow_non_spherical: self.settings.allow_non_spherical.unwrap_or(false) }
    }

    fn series(&self, with_contacts: bool) -> Series {
        let series = Series::new(self.files.clone(), self.particle_options())
            .with_times(self.times.clone())
            .with_range(self.range);
        let series = match self.periodic {
            Periodic::Given(axes) => series.with_periodic(axes),
            Periodic::Auto => series,
        };
        let series = match self.bounds {
            Some(bounds) => series.with_box(bounds),
            None => series,
        };
        let contacts = self.contacts.iter().filter(|_| with_contacts).cloned();
        contacts.fold(series, Series::with_contacts)
    }

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
        let cells = CellSet::new(self.settings, &first.particles, self.periodic, self.columns())?;
        let mut job = Job { cells: &cells, first, series: &mut series, source, over_time };
        let keep = self.settings.face_fields.is_some();
        let account = match &cells {
            CellSet::Mesh(mesh) => {
                let faces = |frame: &Frame, domain: Option<&Domain>| {
                    FaceSums::new(mesh.as_ref(), &frame.particles, frame.contacts.as_ref(), domain, keep)
                };
                self.on_cells(mesh.as_ref(), Some(&faces), &mut job)?
            }
            CellSet::Grid(grid) => {
                let faces = |frame: &Frame, domain: Option<&Domain>| {
                    FaceSums::new(grid, &frame.particles, frame.contacts.as_ref(), domain, keep)
                };
                self.on_cells(grid, Some(&faces), &mut job)?
            }
            CellSet::Cylinder(grid) => self.on_cells(grid, None, &mut job)?,
        };
        series.warnings().iter().for_each(|warning| report::warn(warning));
        if let Some(path) = &self.settings.json {
            account.write(path, begin.elapsed().as_secs_f64())?;
        }
        report::print(&format!(
            "{}{:<20} {:.2}\n{:<20} {}\n",
            account.text(),
            "seconds",
            begin.elapsed().as_secs_f64(),
            "written to",
            self.out.display()
        ))
    }

    /// Fields of all frames, to files.
    fn on_cells<C: Cells>(
        &mut self,
        cells: &C,
        faces: Option<&FacesInBox<'_>>,
        job: &mut Job<'_>,
    ) -> anyhow::Result<Account> {
        if matches!(self.periodic, Periodic::Given(axes) if axes != [false; 3])
            && job.first.particles.domain().is_none()
        {
            bail!("--periodic: {}: the files state no box; give it with --box", job.first.name);
        }
        let (domain, note) = self.periodic.domain(&job.first.particles, cells.bounds())?;
        if let Some(note) = note {
            report::warn(&note);
        }
        self.options.domain = domain;
        let echo = format!("{}{}", self.settings.echo()?, self.legend());
        let mut writer = Writer::new(self.out, self.format, job.cells, echo, self.settings)?;
        let beside = [&self.settings.face_fields, &self.settings.to_particles];
        beside.into_iter().flatten().try_for_each(|path| writer.beside(path))?;
        let bar =
            ProgressBar::new_spinner().with_style(ProgressStyle::with_template("{spinner} {pos} frames, {elapsed}")?);
        bar.enable_steady_tick(Duration::from_millis(200));
        let seen = RefCell::new(Seen::default());
        let refused = match (self.displaced(), self.settings.smooth.is_some()) {
            (true, _) => Some("displacement"),
            (_, true) => Some("--smooth"),
            _ => None,
        };
        let order = RefCell::new(TimeOrder::new(refused));
        let changed = Cell::new(false);
        let first_box = job.first.particles.domain().copied();
        let settings = self.settings;
        if settings.face_fields.is_some() && job.first.contacts.is_none() && !moves(&job.first.particles) {
            bail!("--face-fields: {}: there are neither contacts nor velocities; give --contacts", job.first.name);
        }
        let placeholder =
            Frame { particles: Particles::default(), contacts: None, name: String::new(), faces: None, ..job.first };
        let first = std::mem::replace(&mut job.first, placeholder);
        let source = &job.source;
        let rest = job.series.map(|frame| source.frame(frame?));
        let frames = std::iter::once(Ok(first)).chain(rest).map(|frame| {
            let frame = frame?;
            self.check_types(&frame)?;
            order.borrow_mut().add(frame.time, &frame.name)?;
            changed.set(changed.get() || frame.particles.domain().copied() != first_box);
            let mut seen = seen.borrow_mut();
            seen.frames += 1;
            seen.particles = frame.particles.len();
            seen.contacts = frame.contacts.as_ref().map(Contacts::len);
            seen.found.add(&frame.particles);
            seen.last = frame.name.clone();
            bar.inc(1);
            Ok(frame)
        });
        let mut results = Account::default();
        let mut sink = |mut outcome: Outcome| {
            results.add(&outcome.fields, |cell| cells.cell_volume(cell));
            if let Some(residual) = outcome.balance {
                let mut seen = seen.borrow_mut();
                seen.balance = Some(seen.balance.map_or(residual, |worst| worst.max(residual)));
            }
            if let Some(g) = self.gravity {
                let forces = body_forces(&outcome.fields, g);
                outcome.fields.fields.extend(forces);
            }
            let mut contents = Vec::new();
            if settings.face_fields.is_some() {
                contents.push(Content::Faces(std::mem::take(&mut outcome.faces)));
            }
            if let Some(particles) = outcome.particles.take() {
                let fields = &outcome.fields.fields;
                let names = fields.iter().map(|field| (particle_field(field), field.components.clone())).collect();
                contents.push(Content::Particles(self.at_particles(cells, particles, &outcome.fields)?, names));
            }
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
        bar.finish_and_clear();
        results.seen = seen.into_inner();
        if self.displaced() {
            self.leave_out_the_last(&mut results.seen)?;
        }
        self.check_binned(cells, &results)?;
        writer.finish()?;
        if let Some(warning) = order.borrow().warning() {
            report::warn(&warning);
        }
        if changed.get() && domain.is_some() {
            report::warn("the box changes between frames: periodic images are those of the first frame's box");
        }
        results.cells = job.cells.count();
        results.gravity = self.gravity;
        results.sign = if settings.sign == Some(Sign::Tension) { "tension" } else { "compression" };
        let has = |needs: fn(FieldName) -> bool| self.options.fields.iter().any(|field| needs(*field));
        results.has_momentum = has(needs_momentum);
        results.has_stress = has(needs_stress);
        results.sampled = matches!(self.options.function, Function::Kernel(_)) && !self.options.conserve;
        Ok(results)
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

    /// Numbers per cell in the result.
    fn columns(&self) -> usize {
        let named: usize = self.options.fields.iter().map(|field| field.components().len()).sum();
        let own = named + self.options.quantities.iter().map(|quantity| quantity.columns.len()).sum::<usize>();
        own * (1 + self.species.len())
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
        if types.len() > MOST_SPECIES {
            bail!(
                "--per-species: {}: there are {} types, and each gets fields of its own; name up to {MOST_SPECIES} of them \
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

    /// The particles with the fields' means over them.
    fn at_particles<C: Cells>(&self, cells: &C, particles: Particles, fields: &Fields) -> anyhow::Result<Particles> {
        let Function::Overlap(method) = self.options.function else { return Ok(particles) };
        let weights = Weights::build(cells, &particles, method, self.options.domain.as_ref())?;
        let share = |i: usize| 1.0 - weights.outside()[i] / weights.particle_volumes()[i];
        let inside = (0..weights.particles()).map(share).collect();
        let mut quantities = vec![Quantity { name: "fraction_in_cells".into(), components: 1, data: inside }];
        for field in &fields.fields {
            let (name, components) = (particle_field(field), field.components.len());
            let mut data = field_at_particles(&weights, field)?;
            // Cells of several periods hold a particle more than once: the mean is over all its images in them.
            for (i, values) in data.chunks_exact_mut(components.max(1)).enumerate() {
                let times = share(i);
                if times > 1.0 + 1e-9 {
                    values.iter_mut().for_each(|value| *value /= times);
                }
            }
            quantities.push(Quantity { name, components, data });
        }
        quantities.into_iter().try_fold(particles, |all, quantity| {
            let name = quantity.name.clone();
            all.with_quantity(quantity).map_err(|e| anyhow!("--to-particles: {name}: {e}"))
        })
    }

    /// Formulas and units, as comments below the settings; in ASCII, since VTK reads nothing else.
    fn legend(&self) -> String {
        let lines = self.options.fields.iter().map(|field| {
            let components = field.components().join(" ");
            let components = if components.is_empty() { String::new() } else { format!(" ({components})") };
            ascii(&format!("# {field}{components}: {}, in {}\n", field.formula(), field.unit()))
        });
        lines.collect()
    }
}

/// Types that may get fields of their own without being named: more of them are no species, but numbers of particles.
const MOST_SPECIES: usize = 64;

/// What crosses the faces in a frame, with its periodic box.
type FacesInBox<'a> = dyn Fn(&Frame, Option<&Domain>) -> Result<FaceSums, FieldsError> + Sync + 'a;

/// Refuses a file of contacts that is given twice: each of its contacts would count twice.
fn refuse_repeats(contacts: &[ContactFiles]) -> anyhow::Result<()> {
    let mut seen: HashMap<PathBuf, &Path> = HashMap::new();
    for path in contacts.iter().flat_map(|source| &source.files) {
        let Ok(real) = path.canonicalize() else { continue };
        if let Some(before) = seen.insert(real, path) {
            let also = if before == path { String::new() } else { format!(", also as {}", before.display()) };
            bail!(
                "--contacts {}: the file is given twice{also}, and each of its contacts would count twice; give every file once",
                path.display()
            );
        }
    }
    Ok(())
}

/// What a field is called where it has been brought back to the particles.
fn particle_field(field: &Field) -> String {
    format!("field_{}", field.name)
}

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

fn needs_spin(field: FieldName) -> bool {
    matches!(field, FieldName::AngularMomentum | FieldName::SpinDensity | FieldName::AngularVelocity)
}

fn needs_stress(field: FieldName) -> bool {
    matches!(field, FieldName::ContactStress | FieldName::TotalStress | FieldName::Pressure)
}

fn needs_momentum(field: FieldName) -> bool {
    use FieldName::*;
    matches!(
        field,
        Momentum | Velocity | KineticStress | GranularTemperature | TotalStress | Pressure | MomentumWithSpin
    )
}

/// ρ g of every density there is: that of all, and those of species.
fn body_forces(fields: &Fields, g: [f64; 3]) -> Vec<Field> {
    let force = |density: &Field| {
        let of = density.name.strip_prefix("density").filter(|of| of.is_empty() || of.starts_with("_species_"))?;
        Some(Field {
            name: format!("body_force_density{of}"),
            components: ["x", "y", "z"].map(String::from).into(),
            unit: "force/length³".into(),
            data: density.data.iter().flat_map(|rho| g.map(|g| rho * g)).collect(),
        })
    };
    fields.fields.iter().filter_map(force).collect()
}
