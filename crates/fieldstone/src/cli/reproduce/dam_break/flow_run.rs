//! A flow that is computed once, in a folder of its own, and looked at by several figures.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context, anyhow, bail};
use clap::ValueEnum;
use fieldstone::io::vtk::{VtkEncoding, read_pvd, read_vtk_particles, write_vtp_particles};
use fieldstone::io::{AtomicFile, CsvTable};
use fieldstone::particles::Particles;
use fieldstone::sph::{Case, CaseIntegrator, Outcome, RunFolder, Solver, State, particles_of, run};

use crate::cli::reproduce::progress;

/// Time integrators by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum IntegratorName {
    /// Predictor-corrector, two evaluations per step
    Symplectic,
    /// Runge-Kutta of fourth order, four evaluations, for CFL numbers above 1
    Rk4,
}

/// What is not as the case has it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Changes {
    pub integrator: Option<IntegratorName>,
    pub cfl: Option<f64>,
    /// Of artificial viscosity, instead of whatever viscosity the case has.
    pub alpha: Option<f64>,
    /// Eq. 11 to the letter: the nearest free-surface particle does not push.
    pub eq11_as_printed: bool,
}

impl Changes {
    /// Puts them into a case. The shift per step goes with the step.
    pub fn apply(self, case: &mut Case) {
        if let Some(name) = self.integrator {
            case.sections.time.integrator = match name {
                IntegratorName::Symplectic => CaseIntegrator::Symplectic,
                IntegratorName::Rk4 => CaseIntegrator::Rk4,
            };
        }
        if let Some(cfl) = self.cfl {
            let former = case.sections.time.cfl;
            case.sections.time.cfl = cfl;
            if let Some(k_cfl) = case.sections.shifting.as_mut().and_then(|s| s.k_cfl.as_mut()) {
                *k_cfl *= cfl / former;
            }
        }
        if self.alpha.is_some() {
            case.sections.fluid.alpha = self.alpha;
            case.sections.fluid.viscosity = None;
        }
        if let (true, Some(shifting)) = (self.eq11_as_printed, &mut case.sections.shifting) {
            shifting.nearest_counts = false;
        }
    }

    /// Of the flow's folder.
    fn suffix(self) -> String {
        let integrator = match self.integrator {
            Some(IntegratorName::Rk4) => "_rk4",
            _ => "",
        };
        let number = |name: &str, value: Option<f64>| value.map(|v| format!("_{name}{v}")).unwrap_or_default();
        let shifting = if self.eq11_as_printed { "_eq11" } else { "" };
        integrator.to_string() + &number("cfl", self.cfl) + &number("alpha", self.alpha) + shifting
    }
}

/// Where flows are kept, and what stops them.
#[derive(Debug)]
pub(super) struct Flows {
    pub folder: PathBuf,
    pub changes: Changes,
    pub interrupt: Arc<AtomicBool>,
}

/// A flow with the times at which it is looked at.
pub(super) struct FlowRun {
    pub case: Case,
    folder: PathBuf,
    /// Times whose frames are kept.
    times: Vec<f64>,
}

/// The particles of a flow at a time.
pub(super) struct Frame {
    /// The state as a solver of its own, whose clock is at 0.
    pub solver: Solver,
    pub time: f64,
}

impl Flows {
    /// Computes a flow to the last of `times`, or goes on where an earlier call was stopped.
    ///
    /// A flow of the same name that has frames at all `times` is not computed again; one of other settings is refused. Frames
    /// at `others` are kept, too, where the flow passes them.
    pub fn run(&self, name: &str, mut case: Case, times: &[f64], others: &[f64]) -> anyhow::Result<FlowRun> {
        self.changes.apply(&mut case);
        let spacing = case.sections.spacing;
        let folder = self.folder.join("flows").join(format!("{name}_{spacing}{}", self.changes.suffix()));
        let end = times.iter().copied().fold(0.0, f64::max);
        case.sections.time.end = end;
        case.sections.output.checkpoint_every = 60.0;
        let flow = FlowRun { case, folder, times: [times, others].concat() };
        flow.refuse_other_settings()?;
        if !times.iter().all(|&t| flow.has_frame(t)) {
            self.compute(&flow, name)?;
        }
        Ok(flow)
    }

    fn compute(&self, flow: &FlowRun, name: &str) -> anyhow::Result<()> {
        let files = RunFolder::create(&flow.folder)?;
        let text = flow.case.to_toml()?;
        AtomicFile::write(&flow.case_path(), |out| out.write_all(text.as_bytes()))?;
        let (end, resume) = (flow.case.sections.time.end, files.checkpoint().exists());
        let bar = progress(1000, name)?;
        let mut failure = None;
        let outcome = run(&flow.case, &files, resume, &self.interrupt, |solver| {
            bar.set_position((1000.0 * solver.time() / end) as u64);
            let before = solver.time() - solver.last_step();
            for &time in flow.times.iter().filter(|&&t| before < t && t <= solver.time()) {
                if let Err(error) = write_frame(&flow.frame_path(time), solver) {
                    failure.get_or_insert(error);
                    self.interrupt.store(true, std::sync::atomic::Ordering::Relaxed);
                }
            }
        })
        .with_context(|| format!("{}: remove the folder to compute the flow from its start", flow.folder.display()))?;
        bar.finish_and_clear();
        match (failure, outcome) {
            (Some(error), _) => Err(error),
            (None, Outcome::Finished | Outcome::Beyond(_)) => Ok(()),
            (None, Outcome::Interrupted) => {
                bail!("stopped; {} has a checkpoint: the same command goes on from it", flow.folder.display())
            }
        }
    }
}

fn write_frame(path: &Path, solver: &Solver) -> anyhow::Result<()> {
    Ok(write_vtp_particles(path, &particles_of(solver)?, VtkEncoding::default())?)
}

impl FlowRun {
    fn case_path(&self) -> PathBuf {
        self.folder.join("case.toml")
    }

    /// Fails where the folder has a flow that was computed with other settings, end and outputs apart.
    fn refuse_other_settings(&self) -> anyhow::Result<()> {
        let path = self.case_path();
        if !path.exists() {
            return Ok(());
        }
        let mut former = Case::read(&path).map(|case| case.sections);
        if let Ok(sections) = &mut former {
            sections.time.end = self.case.sections.time.end;
            sections.output.clone_from(&self.case.sections.output);
        }
        if former.is_ok_and(|sections| sections == self.case.sections) {
            return Ok(());
        }
        bail!("{}: this flow was computed with other settings; remove its folder, or give another one", path.display())
    }

    fn frame_path(&self, time: f64) -> PathBuf {
        self.folder.join(format!("frame_{time:.3}s.vtp"))
    }

    /// What the paper leaves open, in words: viscosity, and which neighbours count in Eq. 11.
    pub fn settings(&self) -> String {
        let fluid = &self.case.sections.fluid;
        let viscosity = match (fluid.alpha, fluid.viscosity) {
            (Some(alpha), _) => format!("α = {alpha}"),
            (None, Some(viscosity)) => format!("μ = {viscosity} Pa s"),
            (None, None) => "the default viscosity".into(),
        };
        let shifting = match &self.case.sections.shifting {
            Some(s) if s.enabled && s.nearest_counts => "Eq. 11 with the nearest free-surface particle",
            Some(s) if s.enabled => "Eq. 11 as printed",
            _ => "no shifting",
        };
        format!("{viscosity}, {shifting}")
    }

    /// Whether a frame at a time was kept.
    pub fn has_frame(&self, time: f64) -> bool {
        time == 0.0 || self.frame_path(time).exists()
    }

    /// The first particles at or after a time, one of those it was run for.
    pub fn frame(&self, time: f64) -> anyhow::Result<Frame> {
        if time == 0.0 {
            return Ok(Frame { solver: self.case.solver()?, time });
        }
        let path = &self.frame_path(time);
        let particles = read_vtk_particles(path)?;
        let column = |name: &str| particles.quantity(name).map_err(|e| anyhow!("{}: {e}", path.display()));
        let ids = particles.ids().unwrap_or_default().iter().map(|&id| u32::try_from(id));
        let state = State {
            x: particles.positions().to_vec(),
            u: column("velocity")?.data.as_chunks::<3>().0.to_vec(),
            density: column("density")?.data.clone(),
            id: ids.collect::<Result<_, _>>().with_context(|| path.display().to_string())?,
        };
        let solver = Solver::new(self.case.flow()?, state)?;
        Ok(Frame { solver, time: particles.time().unwrap_or(0.0) })
    }

    /// All frames of the run's series, with their times.
    pub fn series(&self) -> anyhow::Result<Vec<(f64, Particles)>> {
        let steps = read_pvd(&RunFolder::create(&self.folder)?.series())?;
        let read = |(time, path): (f64, PathBuf)| anyhow::Ok((time, read_vtk_particles(&path)?));
        steps.into_iter().map(read).collect()
    }

    /// The table of gauges.
    pub fn gauges(&self) -> anyhow::Result<CsvTable> {
        Ok(CsvTable::read(&self.folder.join("gauges.csv"))?)
    }
}
