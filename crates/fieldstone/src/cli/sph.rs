//! `fieldstone sph`: the δ-SPH solver on cases described in TOML.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Context, bail};
use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand};
use fieldstone::sph::{Case, Outcome, Phase, Phases, RunFolder, SHIPPED, Solver};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use super::{outputs, report, sph_warnings};

/// Free-surface flow by smoothed particle hydrodynamics (δ-SPH)
#[derive(Debug, Args)]
#[command(after_long_help = "Example:\n  \
    fieldstone sph new dam-break --spacing 0.02 > dam.toml\n  \
    fieldstone sph check dam.toml\n  \
    fieldstone sph run dam.toml\n\n\
    Ctrl-C writes a checkpoint; fieldstone sph run dam.toml --resume goes on from it, with the same bits as a run that \
    was never stopped.")]
pub(crate) struct Sph {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    New(New),
    Check(Check),
    Run(Run),
}

/// Print a case to start from
#[derive(Debug, Args)]
struct New {
    /// Which one
    #[arg(value_parser = PossibleValuesParser::new(SHIPPED.iter().map(|c| c.name)))]
    case: String,
    /// Initial distance of particles, in the case's unit of length
    #[arg(long, value_name = "DX", value_parser = super::arguments::positive, allow_negative_numbers = true)]
    spacing: Option<f64>,
}

/// Count particles, and estimate memory and time from two steps
#[derive(Debug, Args)]
struct Check {
    /// The case (.toml)
    case: PathBuf,
    /// Write the figures as JSON, too; - is standard output, and the report then goes to standard error
    ///
    /// Keys: fluid, ghost and free_surface, numbers of particles; neighbours, the mean within the kernel; time_step, the first;
    /// steps and seconds to the end, as that step and its cost have it; bytes; excess_mass, of all particles over what the fills'
    /// shapes hold, and excess_of_fills, of each fill's over the cells of its lattice, as shares.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Run a case to its end
///
/// Leaves particles_*.vtp with particles.pvd for ParaView, gauges.csv and checkpoint.bin.
#[derive(Debug, Args)]
struct Run {
    /// The case (.toml)
    case: PathBuf,
    /// Folder for the results; made where it is missing [default: the case's name without .toml]
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Go on from the folder's checkpoint; end time and outputs may differ
    #[arg(long)]
    resume: bool,
    /// Print where the time went
    #[arg(short, long)]
    verbose: bool,
}

impl Sph {
    pub fn run(self) -> anyhow::Result<()> {
        match self.what {
            What::New(command) => command.run(),
            What::Check(command) => command.run(),
            What::Run(command) => command.run(),
        }
    }
}

impl New {
    fn run(self) -> anyhow::Result<()> {
        let Some(case) = SHIPPED.iter().find(|c| c.name == self.case) else { bail!("no such case") };
        report::print(case.at_spacing(self.spacing)?.text())
    }
}

/// What `check` finds.
#[derive(Debug, Serialize)]
struct Figures {
    fluid: usize,
    ghost: usize,
    free_surface: usize,
    neighbours: f64,
    time_step: f64,
    steps: u64,
    bytes: usize,
    seconds: f64,
    /// By how much the particles are heavier than the fills' shapes, relatively.
    excess_mass: f64,
    /// By how much those of each fill are heavier than the cells of its lattice.
    excess_of_fills: Vec<f64>,
}

impl Check {
    fn run(self) -> anyhow::Result<()> {
        if let Some(path) = &self.json {
            outputs::check_json(path, &[&self.case])?;
        }
        let case = Case::read(&self.case)?;
        let figures = measure(&case)?;
        let text = format!(
            "fluid                {}\nghost                {}\nfree surface         {}\nneighbours           {:.0}\n\
             time step            {:.3e}\nsteps                {}\nmemory               {}\n\
             estimated time       {}\n{}",
            figures.fluid,
            figures.ghost,
            figures.free_surface,
            figures.neighbours,
            figures.time_step,
            figures.steps,
            memory(figures.bytes),
            duration(figures.seconds),
            if figures.excess_mass.abs() > 1e-9 {
                format!(
                    "excess mass          {:+.2} %: fills are round, or no whole number of spacings long\n",
                    100.0 * figures.excess_mass
                )
            } else {
                String::new()
            },
        );
        if let Some(path) = &self.json {
            outputs::write_json(path, &figures)?;
        }
        outputs::report_beside(self.json.as_deref(), &text)
    }
}

fn measure(case: &Case) -> anyhow::Result<Figures> {
    let prepared = case.prepare()?;
    sph_warnings::before(&prepared)?;
    let (excess_mass, excess_of_fills) = (prepared.excess_mass()?, prepared.excess_of_fills()?);
    let mut solver = prepared.solver()?;
    // Counted by the exact detection, whichever the case uses.
    let labels = solver.labels(&fieldstone::surface::Exact::default())?;
    let free_surface = labels.iter().filter(|&&free| free).count();
    let (fluid, ghost) = (solver.state().len(), solver.ghost_count());
    let time_step = solver.allowed_step()?;
    // The first step warms up; the second tells the cost. The time step hardly changes in these flows.
    solver.step()?;
    let start = Instant::now();
    solver.step()?;
    let seconds = start.elapsed().as_secs_f64();
    let steps = (case.sections.time.end / time_step).ceil();
    Ok(Figures {
        fluid,
        ghost,
        free_surface,
        neighbours: solver.mean_neighbours()?,
        time_step,
        steps: steps as u64,
        bytes: solver.bytes(),
        seconds: steps * seconds,
        excess_mass,
        excess_of_fills,
    })
}

fn duration(seconds: f64) -> String {
    if seconds < 0.01 {
        "less than 0.01 s".into()
    } else if seconds < 1.0 {
        format!("{seconds:.2} s")
    } else if seconds < 10.0 {
        format!("{seconds:.1} s")
    } else if seconds < 120.0 {
        format!("{seconds:.0} s")
    } else if seconds < 7200.0 {
        format!("{:.0} min", seconds / 60.0)
    } else {
        format!("{:.1} h", seconds / 3600.0)
    }
}

fn memory(bytes: usize) -> String {
    let bytes = bytes as f64;
    if bytes < 1e6 {
        format!("{:.0} kB", bytes / 1e3)
    } else if bytes < 1e9 {
        format!("{:.1} MB", bytes / 1e6)
    } else {
        format!("{:.2} GB", bytes / 1e9)
    }
}

impl Run {
    fn run(self) -> anyhow::Result<()> {
        let case = Case::read(&self.case)?;
        // What cannot start leaves no folder behind.
        let prepared = case.prepare()?;
        sph_warnings::before(&prepared)?;
        let fluid = prepared.flow().fluid;
        let again = self.resume_command();
        let folder = self.out.unwrap_or_else(|| default_folder(&self.case));
        let files = if self.resume { RunFolder::begun(&folder)? } else { RunFolder::create(&folder)? };
        if !self.resume && files.checkpoint().exists() {
            bail!(
                "{}: there is a checkpoint of an earlier run; go on from it with --resume, or give another folder with \
                 --out",
                files.checkpoint().display()
            );
        }
        if let Some(frame) = files.frames()?.first().filter(|_| !self.resume) {
            bail!(
                "{}: there are particles of an earlier run without a checkpoint; remove particles_*.vtp, or give another folder \
                 with --out",
                frame.display()
            );
        }
        if self.resume {
            sph_warnings::of_lost_files(&files)?;
        }
        let interrupt = stop_on_ctrl_c()?;
        let bar = progress()?;
        let mut last = None;
        let start = Instant::now();
        let mut first_time = None;
        let mut densest = 0.0f64;
        let mut energies = None;
        let outcome = prepared.run(&files, self.resume, &interrupt, |solver| {
            let first = *first_time.get_or_insert(solver.time());
            show(&bar, solver, case.sections.time.end, first, start);
            densest = solver.state().density.iter().fold(densest, |most, &density| most.max(density));
            if solver.time() >= case.sections.time.end || interrupt.load(Ordering::Relaxed) {
                energies = Some((solver.energy_residual(), solver.energies().kinetic));
            }
            last = Some((*solver.phases(), solver.state().len(), *solver.budget(), solver.fastest(), solver.steps()));
        })?;
        bar.finish_and_clear();
        if let Some((phases, particles, budget, fastest, steps)) = last {
            let mut text = format!("particles            {particles}\nremoved              {}\n", budget.removed);
            text.push_str(&format!("steps                {steps}\n"));
            if self.verbose {
                text.push_str(&phase_table(&phases, particles));
            }
            text.push_str(&format!("largest speed        {fastest:.4}\n"));
            report::print(&text)?;
            if let Some(warning) = sph_warnings::too_compressible(&fluid, fastest, fluid.pressure(densest).max(0.0)) {
                let unstable =
                    energies.and_then(|(residual, kinetic)| sph_warnings::unstable(fastest, residual, kinetic));
                report::warn(&unstable.unwrap_or(warning));
            }
            if budget.in_bodies > 0 {
                report::warn(&format!(
                    "{} times a particle ended a step deeper than a spacing inside a body, or between bodies without room (in_bodies in \
                     {}): the flow there is wrong; let bodies start outside the fluid, leave it room, or lessen the spacing",
                    budget.in_bodies,
                    files.gauges().display()
                ));
            }
        }
        match outcome {
            Outcome::Finished => report::print(&format!("written to           {}\n", folder.display())),
            Outcome::Beyond(time) => report::print(&format!(
                "already at t = {time}, beyond the end {}: nothing was computed\n",
                case.sections.time.end
            )),
            Outcome::Interrupted => bail!("stopped; {} is written: go on with {again}", files.checkpoint().display()),
        }
    }
}

impl Run {
    /// The command that goes on from where this one stops.
    fn resume_command(&self) -> String {
        let mut command = format!("fieldstone sph run {} --resume", self.case.display());
        if let Some(out) = &self.out {
            command.push_str(&format!(" --out {}", out.display()));
        }
        command
    }
}

fn default_folder(case: &Path) -> PathBuf {
    let folder = case.with_extension("");
    if folder == case { case.with_extension("results") } else { folder }
}

/// What Ctrl-C sets; once per process.
pub(super) fn stop_on_ctrl_c() -> anyhow::Result<Arc<AtomicBool>> {
    let interrupt = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupt);
    ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed)).context("cannot listen for Ctrl-C")?;
    Ok(interrupt)
}

fn progress() -> anyhow::Result<ProgressBar> {
    let style = ProgressStyle::with_template("{msg} {bar:30} {percent:>3} %")?;
    Ok(ProgressBar::new(1000).with_style(style))
}

fn show(bar: &ProgressBar, solver: &Solver, end: f64, first: f64, start: Instant) {
    let done = solver.time() / end;
    let left = start.elapsed().as_secs_f64() * (end - solver.time()) / (solver.time() - first).max(f64::MIN_POSITIVE);
    bar.set_position((1000.0 * done) as u64);
    bar.set_message(format!(
        "t {:.4} of {end}, step {}, Δt {:.2e}, {} left",
        solver.time(),
        solver.steps(),
        solver.last_step(),
        if solver.time() > first { duration(left) } else { "?".into() }
    ));
}

/// Where the time of a run went.
fn phase_table(phases: &Phases, particles: usize) -> String {
    let total = phases.total().as_secs_f64().max(f64::MIN_POSITIVE);
    let work = (particles as f64 * phases.steps as f64).max(1.0);
    let mut text = String::from("phase            seconds   share   µs per particle and step\n");
    for phase in Phase::ALL {
        let time = phases.time(phase).as_secs_f64();
        let (share, each) = (100.0 * time / total, 1e6 * time / work);
        text.push_str(&format!("{:<14} {time:>9.2} {share:>6.1} % {each:>10.3}\n", phase.name()));
    }
    text.push_str(&format!("{:<14} {total:>9.2}   lists built {} times\n", "total", phases.lists_built));
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_that_goes_on_names_the_folder() {
        let run = |out: Option<&str>| Run {
            case: "dam.toml".into(),
            out: out.map(PathBuf::from),
            resume: false,
            verbose: false,
        };
        assert_eq!(run(None).resume_command(), "fieldstone sph run dam.toml --resume");
        assert_eq!(run(Some("there")).resume_command(), "fieldstone sph run dam.toml --resume --out there");
    }
}
