//! `fieldstone fields`: coarse graining.

mod account;
mod cells;
mod contacts;
mod frames;
mod names;
mod output;
mod settings;

use std::cell::{Cell, RefCell};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use anyhow::{anyhow, bail};
use clap::Args;
use fieldstone::fields::{
    CoarseGrainingOptions, Field, FieldName, Fields, FieldsError, Function, Kernel, Method, Selection, UserQuantity,
    contact_traction,
};
use fieldstone::io::{
    BackgroundSeries, ContactFiles, FrameRange, MercuryRestart, ParticleOptions, Series, find_files, read_restart,
};
use fieldstone::mesh::Cells;
use fieldstone::particles::{Contacts, Domain, Particles};
use indicatif::{ProgressBar, ProgressStyle};

use super::arguments::Periodic;
use super::{outputs, report};
use account::{Account, Seen};
use cells::CellSet;
use frames::{Frame, Outcome, OverTime, compute, time_of, with_displacements};
pub(crate) use names::mercury_name;
use output::{CellKind, Format, Writer};
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
    contacts: Vec<ContactFiles>,
    range: FrameRange,
    periodic: Periodic,
    options: CoarseGrainingOptions,
    gravity: Option<[f64; 3]>,
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
        let inputs: Vec<&Path> = (files.iter().chain(contacts.iter().flat_map(|source| &source.files)))
            .map(PathBuf::as_path)
            .chain(settings.restart.as_deref())
            .chain(settings.mesh.as_deref())
            .chain(config)
            .collect();
        outputs::check("--out", out, &inputs)?;
        if let Some(path) = &settings.json {
            outputs::check("--json", path, &[&inputs[..], &[out]].concat())?;
        }
        let gravity = settings.gravity.as_ref().map(|g| g.exactly("gravity")).transpose()?;
        let mut run = Self {
            settings,
            out,
            format,
            files,
            contacts,
            range: FrameRange::default(),
            periodic: settings.periodic.as_deref().unwrap_or("auto").parse().map_err(|e| anyhow!("--periodic: {e}"))?,
            options: CoarseGrainingOptions::default(),
            gravity,
        };
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
        let mut fields = FieldName::parse_list(settings.fields.as_deref().unwrap_or("standard"))
            .map_err(|e| anyhow!("--fields: {e}"))?;
        if self.contacts.is_empty() && matches!(settings.fields.as_deref(), None | Some("all")) {
            fields.retain(|field| !field.needs_contacts());
        }
        if self.gravity.is_some() && !fields.contains(&FieldName::Density) {
            bail!("--gravity makes body_force_density of the density; add density to --fields");
        }
        let radii = settings.radii.as_ref().map(|radii| radii.exactly("radii")).transpose()?;
        let region = settings.region.as_ref().map(|region| region.exactly("region")).transpose()?;
        Ok(CoarseGrainingOptions {
            function,
            contact_form: settings.stress_form.map(Into::into),
            fields,
            sign: settings.sign.unwrap_or(Sign::Compression).into(),
            mean_velocity: settings.mean_velocity.map_or(defaults.mean_velocity, Into::into),
            walls_in_contact_force: settings.walls.map_or(defaults.walls_in_contact_force, Into::into),
            conserve: settings.conserve.unwrap_or(false),
            selection: Selection {
                types: settings.species.as_ref().map(|types| types.0.clone()),
                radii,
                region: region.map(|[x0, x1, y0, y1, z0, z1]: [f64; 6]| [[x0, y0, z0], [x1, y1, z1]]),
            },
            particle_density: settings.density,
            ..defaults
        })
    }

    fn displaced(&self) -> bool {
        self.options.fields.iter().any(|field| field.needs_displacement())
    }

    fn range(&self) -> anyhow::Result<FrameRange> {
        let settings = self.settings;
        let one_frame = !self.format.is_series() && settings.average != Some(true) && settings.smooth.is_none();
        let text = match settings.frames.as_deref() {
            Some(text) => text,
            None if one_frame && self.displaced() => "-2:",
            None if one_frame => "-1",
            None => ":",
        };
        text.parse().map_err(|e| anyhow!("--frames: {e}"))
    }

    fn series(&self, with_contacts: bool) -> Series {
        let options = ParticleOptions { allow_non_spherical: self.settings.allow_non_spherical.unwrap_or(false) };
        let series = Series::new(self.files.clone(), options).with_range(self.range);
        let contacts = self.contacts.iter().filter(|_| with_contacts).cloned();
        contacts.fold(series, Series::with_contacts)
    }

    /// The middle of the frames' times.
    fn middle(&self) -> anyhow::Result<f64> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for frame in self.series(false) {
            let frame = frame?;
            let time = time_of(self.settings, frame.index, &frame.particles);
            (low, high) = (low.min(time), high.max(time));
        }
        Ok(0.5 * (low + high))
    }

    fn over_time(&self) -> anyhow::Result<OverTime> {
        Ok(match self.settings.smooth {
            _ if self.settings.average == Some(true) => OverTime::Mean,
            None => OverTime::Each,
            Some(width) if self.format.is_series() => OverTime::SmoothEach(width),
            Some(width) => OverTime::SmoothAt { width, at: self.middle()? },
        })
    }

    fn run(mut self, begin: Instant) -> anyhow::Result<()> {
        let restart = self.settings.restart.as_deref().map(read_restart).transpose()?;
        if let Some(restart) = &restart {
            restart.warnings.iter().for_each(|warning| report::warn(warning));
        }
        let over_time = self.over_time()?;
        let mut series = self.series(true).in_background(1)?;
        let Some(first) = series.next().transpose()? else {
            bail!("{}: none of its frames is in the range; check --frames", self.files[0].display())
        };
        let first = Frame::new(self.settings, restart.as_ref(), first)?;
        first.particles.radii().map_err(|e| anyhow!("{}: {e}; give one for all with --radius", first.name))?;
        self.options.quantities = self.quantities(&first)?;
        if self.settings.fields.as_deref() == Some("all") && first.particles.quantity("angular_velocity").is_err() {
            self.options.fields.retain(|field| !needs_spin(*field));
        }
        let cells = CellSet::new(self.settings, &first.particles, self.columns())?;
        let mut job = Job { cells: &cells, first, series: &mut series, restart: restart.as_ref(), over_time };
        let account = match &cells {
            CellSet::Mesh(mesh) => {
                let balance = |p: &Particles, c: &Contacts, d: Option<&Domain>| {
                    contact_traction(mesh.as_ref(), p, c, d).map(|traction| traction.balance_residual)
                };
                self.on_cells(mesh.as_ref(), Some(&balance), &mut job)?
            }
            CellSet::Grid(grid) => {
                let balance = |p: &Particles, c: &Contacts, d: Option<&Domain>| {
                    contact_traction(grid, p, c, d).map(|traction| traction.balance_residual)
                };
                self.on_cells(grid, Some(&balance), &mut job)?
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
        balance: Option<&Balance<'_>>,
        job: &mut Job<'_>,
    ) -> anyhow::Result<Account> {
        let (domain, note) = self.periodic.domain(&job.first.particles, cells.bounds())?;
        if let Some(note) = note {
            report::warn(&note);
        }
        self.options.domain = domain;
        let echo = format!("{}{}", self.settings.echo()?, self.legend());
        let mut writer = Writer::new(self.out, self.format, job.cells, echo, self.settings)?;
        let bar =
            ProgressBar::new_spinner().with_style(ProgressStyle::with_template("{spinner} {pos} frames, {elapsed}")?);
        bar.enable_steady_tick(Duration::from_millis(200));
        let seen = RefCell::new(Seen::default());
        let changed = Cell::new(false);
        let first_box = job.first.particles.domain().copied();
        let settings = self.settings;
        let placeholder = Frame { particles: Particles::default(), contacts: None, name: String::new(), ..job.first };
        let first = std::mem::replace(&mut job.first, placeholder);
        let restart = job.restart;
        let rest = job.series.map(|frame| Frame::new(settings, restart, frame?));
        let frames = std::iter::once(Ok(first)).chain(rest).map(|frame| {
            let frame = frame?;
            changed.set(changed.get() || frame.particles.domain().copied() != first_box);
            let mut seen = seen.borrow_mut();
            seen.frames += 1;
            seen.particles = frame.particles.len();
            seen.contacts = frame.contacts.as_ref().map(Contacts::len);
            if let (Some(balance), Some(contacts)) = (balance, &frame.contacts) {
                let residual = balance(&frame.particles, contacts, domain.as_ref()).map_err(|e| frame.placed(e))?;
                seen.balance = Some(seen.balance.map_or(residual, |worst| worst.max(residual)));
            }
            bar.inc(1);
            Ok(frame)
        });
        let mut results = Account::default();
        let mut sink = |mut outcome: Outcome| {
            results.add(&outcome.fields, |cell| cells.cell_volume(cell));
            if let Some(g) = self.gravity {
                outcome.fields.fields.extend(body_force(&outcome.fields, g));
            }
            writer.put(outcome)
        };
        if self.displaced() {
            compute(cells, &self.options, job.over_time, with_displacements(frames), &mut sink)?;
        } else {
            compute(cells, &self.options, job.over_time, frames, &mut sink)?;
        }
        bar.finish_and_clear();
        writer.finish()?;
        if changed.get() && domain.is_some() {
            report::warn("the box changes between frames: periodic images are those of the first frame's box");
        }
        results.seen = seen.into_inner();
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
                .map_err(|e| anyhow!("--quantity {asked}: {}: {e}", first.name))?;
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

    /// Numbers per cell in the result.
    fn columns(&self) -> usize {
        let named: usize = self.options.fields.iter().map(|field| field.components().len()).sum();
        named + self.options.quantities.iter().map(|quantity| quantity.columns.len()).sum::<usize>()
    }

    /// Formulas and units, as comments below the settings.
    fn legend(&self) -> String {
        let lines = self.options.fields.iter().map(|field| {
            let components = field.components().join(" ");
            let components = if components.is_empty() { String::new() } else { format!(" ({components})") };
            format!("# {field}{components}: {}, in {}\n", field.formula(), field.unit())
        });
        lines.collect()
    }
}

/// Worst residual of the momentum balance of the cells, from a frame and its periodic box.
type Balance<'a> = dyn Fn(&Particles, &Contacts, Option<&Domain>) -> Result<f64, FieldsError> + 'a;

/// What is to be done on cells of one kind.
struct Job<'a> {
    cells: &'a CellSet,
    first: Frame,
    series: &'a mut BackgroundSeries,
    restart: Option<&'a MercuryRestart>,
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

/// ρ g, where the density is there.
fn body_force(fields: &Fields, g: [f64; 3]) -> Option<Field> {
    let density = fields.get("density")?;
    Some(Field {
        name: "body_force_density".into(),
        components: ["x", "y", "z"].map(String::from).into(),
        unit: "force/length³".into(),
        data: density.data.iter().flat_map(|rho| g.map(|g| rho * g)).collect(),
    })
}
