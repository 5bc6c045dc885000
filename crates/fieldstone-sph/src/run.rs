//! A case from its start, or a checkpoint, to its end, with everything that it leaves behind.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use fieldstone_io::vtk::{VtkEncoding, read_pvd, write_pvd, write_vtp_particles};
use fieldstone_io::{AtomicFile, IoError, write_number};
use fieldstone_particles::{Particles, Quantity};

use crate::gauges::{gauge_columns, gauge_row};
use crate::{Boundaries, Case, GaugeSection, Prepared, Solver, SphError};

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// The end time is reached.
    Finished,
    /// The checkpoint's time, this one, is the end or beyond it: nothing was computed or written.
    Beyond(f64),
    /// It was asked to stop, and a checkpoint is written.
    Interrupted,
}

/// Where a run puts its files.
///
/// | file | what |
/// |---|---|
/// | `particles_00000.vtp`, … | all particles: velocity, density, pressure; region with detection, shift with shifting |
/// | `particles.pvd` | the series with its times, for ParaView |
/// | `gauges.csv` | [`gauge_columns`](crate::gauge_columns) |
/// | `checkpoint.bin` | where to go on |
/// | `failure.vtp` | the particles as a step failed; removed when the run starts again |
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunFolder(PathBuf);

impl RunFolder {
    /// The folder; made where it is missing.
    ///
    /// # Errors
    /// [`SphError::Io`].
    pub fn create(folder: &Path) -> Result<Self, SphError> {
        std::fs::create_dir_all(folder).map_err(|e| system(folder, e))?;
        Ok(Self(folder.into()))
    }

    /// The folder of a run that has left a checkpoint; nothing is made.
    ///
    /// # Errors
    /// [`SphError::Checkpoint`] where there is none.
    pub fn begun(folder: &Path) -> Result<Self, SphError> {
        let begun = Self(folder.into());
        std::fs::metadata(begun.checkpoint()).map_err(|e| SphError::Checkpoint {
            file: begun.checkpoint().display().to_string(),
            message: if begun.frames().is_ok_and(|frames| !frames.is_empty()) {
                format!(
                    "cannot be read: {e}; the run that left particles here was stopped before its first checkpoint: remove \
                     particles_*.vtp, then run without --resume, or give the run's folder with --out"
                )
            } else {
                format!("cannot be read: {e}; run without --resume first, or give the run's folder with --out")
            },
        })?;
        Ok(begun)
    }

    /// The checkpoint.
    pub fn checkpoint(&self) -> PathBuf {
        self.0.join("checkpoint.bin")
    }

    /// The particles at a failure.
    pub fn failure(&self) -> PathBuf {
        self.0.join("failure.vtp")
    }

    /// The files of the series that are there, sorted: whatever run they are of.
    ///
    /// # Errors
    /// [`SphError::Io`] where the folder cannot be read.
    pub fn frames(&self) -> Result<Vec<PathBuf>, SphError> {
        let fault = |source| SphError::from(IoError::System { path: self.0.clone(), action: "read", source });
        let mut frames = Vec::new();
        for entry in std::fs::read_dir(&self.0).map_err(fault)? {
            let path = entry.map_err(fault)?.path();
            let number =
                path.file_name().and_then(|name| name.to_str()?.strip_prefix("particles_")?.strip_suffix(".vtp"));
            if number.is_some_and(|n| n.parse::<usize>().is_ok()) {
                frames.push(path);
            }
        }
        frames.sort();
        Ok(frames)
    }

    /// The series.
    pub fn series(&self) -> PathBuf {
        self.0.join("particles.pvd")
    }

    /// Files that the series lists and that are not there; none where there is no series.
    ///
    /// # Errors
    /// [`SphError::Io`] where the series cannot be read.
    pub fn missing_frames(&self) -> Result<Vec<PathBuf>, SphError> {
        if !self.series().exists() {
            return Ok(Vec::new());
        }
        let listed = read_pvd(&self.series())?.into_iter();
        let beside = listed.filter_map(|(_, file)| file.file_name().map(|name| self.0.join(name)));
        Ok(beside.filter(|path| !path.exists()).collect())
    }

    /// The table of gauges.
    pub fn gauges(&self) -> PathBuf {
        self.0.join("gauges.csv")
    }
}

fn system(path: &Path, source: std::io::Error) -> SphError {
    IoError::System { path: path.into(), action: "write", source }.into()
}

/// Prepares a case and runs it, as [`Prepared::run`] does.
///
/// # Errors
/// As [`Case::prepare`] and [`Prepared::run`].
pub fn run(
    case: &Case,
    folder: &RunFolder,
    resume: bool,
    interrupt: &AtomicBool,
    watch: impl FnMut(&Solver),
) -> Result<Outcome, SphError> {
    case.prepare()?.run(folder, resume, interrupt, watch)
}

impl Prepared<'_> {
    /// Runs the case to its end, or until `interrupt` is set, calling `watch` after every step.
    ///
    /// Time steps are never shortened to hit a time of output, so the cadence of output does not touch the result: a
    /// file is written at the first step at or after its time. With `resume` the run goes on from its checkpoint, with the
    /// same bits as if it had never stopped; files and rows later than the checkpoint are made anew. The case's fills must make the
    /// particles that the run began with.
    ///
    /// # Errors
    /// As [`Solver::step`]: the last checkpoint stays, and the particles as they were then are written to
    /// `failure.vtp` where they are finite; that of an earlier attempt is removed at the start. [`SphError::Io`], [`SphError::Checkpoint`].
    pub fn run(
        self,
        folder: &RunFolder,
        resume: bool,
        interrupt: &AtomicBool,
        mut watch: impl FnMut(&Solver),
    ) -> Result<Outcome, SphError> {
        let case = self.case;
        let output = &case.sections.output;
        let end = case.sections.time.end;
        let (mut solver, measured) = if resume { self.resumed(folder)? } else { (self.solver()?, String::new()) };
        if resume && solver.time() >= end {
            return Ok(Outcome::Beyond(solver.time()));
        }
        // A table that is begun anew may have others.
        let goes_on = resume && folder.gauges().exists();
        if goes_on {
            same_gauges(&measured, &case.sections.gauge, &folder.gauges())?;
        }
        let measured = measured_by(&case.sections.gauge);
        // Of an attempt that this one replaces.
        if folder.failure().exists() {
            std::fs::remove_file(folder.failure()).map_err(|e| system(&folder.failure(), e))?;
        }
        let mut series = Series::open(folder, resume.then(|| solver.time()))?;
        let columns = gauge_columns(&case.sections.gauge, solver.detects());
        let mut gauges = Table::open(&folder.gauges(), &columns, resume.then(|| solver.time()))?;
        let mut frames = Schedule::new(output.every.unwrap_or(end / 50.0), &solver, resume);
        let mut rows = Schedule::new(output.gauges_every.unwrap_or(end / 500.0), &solver, resume);
        let mut last_checkpoint = Instant::now();
        // What is in the checkpoint is of the old table's gauges.
        let mut due = resume && !goes_on;
        loop {
            if frames.due(&solver) {
                series.write(&solver)?;
            }
            if rows.due(&solver) {
                let row = gauge_row(&mut solver, &case.sections.gauge)?;
                gauges.row(&row)?;
            }
            let finished = solver.time() >= end;
            let stop = interrupt.load(Ordering::Relaxed);
            if finished || stop || due || last_checkpoint.elapsed().as_secs_f64() >= output.checkpoint_every {
                gauges.flush()?;
                solver.write_checkpoint_with(&folder.checkpoint(), &measured)?;
                (last_checkpoint, due) = (Instant::now(), false);
            }
            if finished {
                return Ok(Outcome::Finished);
            }
            if stop {
                return Ok(Outcome::Interrupted);
            }
            if let Err(error) = solver.step() {
                gauges.flush()?;
                // The culprit may have no position that a file could hold; the error names it all the same.
                if let Ok(particles) = particles_of(&solver) {
                    write_vtp_particles(&folder.failure(), &particles, VtkEncoding::default())?;
                }
                return Err(error);
            }
            watch(&solver);
        }
    }

    /// The solver of a checkpoint and what its gauges measure, if the case still begins as the run did: its flow is asked for by the checkpoint itself.
    fn resumed(self, folder: &RunFolder) -> Result<(Solver, String), SphError> {
        let (solver, measured) = Solver::of_checkpoint(&folder.checkpoint(), self.flow)?;
        if solver.began_with(&self.state) {
            return Ok((solver, measured));
        }
        let message = "the run began with other particles than the fills make; only [time], k_cfl and the output may change: put \
                   the fills back, or start anew in another folder";
        Err(SphError::Checkpoint { file: folder.checkpoint().display().to_string(), message: message.into() })
    }
}

/// What gauges measure: a line for each, its name and, after a tab, the rest. Names hold no control characters.
fn measured_by(gauges: &[GaugeSection]) -> String {
    gauges.iter().map(|gauge| format!("{}\t{}\n", gauge.name, gauge.measured())).collect()
}

/// Refuses gauges of a name that the table has a column of, which holds something else.
fn same_gauges(before: &str, gauges: &[GaugeSection], table: &Path) -> Result<(), SphError> {
    for gauge in gauges {
        let line = before.lines().filter_map(|line| line.split_once('\t')).find(|(name, _)| *name == gauge.name);
        let now = gauge.measured();
        if let Some((name, was)) = line.filter(|(_, was)| *was != now) {
            let message = format!(
                "gauge '{name}' is {now}, but was {was} when the table was begun: go on with the gauges that it was begun with, \
                 or move it away to begin another"
            );
            return Err(SphError::Checkpoint { file: table.display().to_string(), message });
        }
    }
    Ok(())
}

/// All particles with their columns, in the order of their numbers; their mass too, by which amounts are shared out and
/// volumes are known. Those beyond a periodic face, which the solver wraps with its next lists, are where they come in.
///
/// # Errors
/// [`SphError::Particles`] where a position is not finite.
pub fn particles_of(solver: &Solver) -> Result<Particles, SphError> {
    let (state, fluid) = (solver.state(), &solver.flow().fluid);
    let mut order: Vec<usize> = (0..state.len()).collect();
    order.sort_unstable_by_key(|&i| state.id[i]);
    let scalar = |name: &str, value: &dyn Fn(usize) -> f64| Quantity {
        name: name.into(),
        components: 1,
        data: order.iter().map(|&i| value(i)).collect(),
    };
    let vector = |name: &str, values: &[[f64; 3]]| Quantity {
        name: name.into(),
        components: 3,
        data: order.iter().flat_map(|&i| values[i]).collect(),
    };
    let Boundaries { low, high, periodic, .. } = &solver.flow().boundaries;
    let wrapped = |x: [f64; 3]| {
        std::array::from_fn(|k| match high[k] - low[k] {
            length if periodic[k] && x[k] < low[k] => x[k] + length,
            length if periodic[k] && x[k] >= high[k] => x[k] - length,
            _ => x[k],
        })
    };
    let mut particles = Particles::new(order.iter().map(|&i| wrapped(state.x[i])).collect())?
        .with_ids(order.iter().map(|&i| i64::from(state.id[i])).collect())?
        .with_quantity(vector("velocity", &state.u))?
        .with_quantity(scalar("density", &|i| state.density[i]))?
        .with_quantity(scalar("mass", &|_| fluid.particle_mass()))?
        .with_quantity(scalar("pressure", &|i| fluid.pressure(state.density[i])))?;
    if solver.detects() {
        particles = particles.with_quantity(scalar("region", &|i| f64::from(solver.regions()[i])))?;
    }
    if solver.flow().shifting.is_some() {
        // None before the first step: every frame of a series has the same arrays.
        let mut shifts: Vec<[f64; 3]> = solver.shifts().collect();
        shifts.resize(state.len(), [0.0; 3]);
        particles = particles.with_quantity(vector("shift", &shifts))?;
    }
    Ok(particles.at(i64::try_from(solver.steps()).ok(), Some(solver.time())))
}

/// Times at which something is due: the first step at or after each multiple of a period.
struct Schedule {
    period: f64,
    next: u64,
}

impl Schedule {
    fn new(period: f64, solver: &Solver, resumed: bool) -> Self {
        let mut schedule = Self { period, next: 0 };
        if resumed {
            // What was due at the checkpoint's step is written.
            schedule.due(solver);
        }
        schedule
    }

    /// Whether it is due now.
    fn due(&mut self, solver: &Solver) -> bool {
        let passed = (solver.time() / self.period).floor() as u64;
        let due = passed >= self.next;
        if due {
            self.next = passed.saturating_add(1);
        }
        due
    }
}

struct Series {
    folder: PathBuf,
    path: PathBuf,
    steps: Vec<(f64, PathBuf)>,
}

impl Series {
    fn open(folder: &RunFolder, until: Option<f64>) -> Result<Self, SphError> {
        let mut steps = Vec::new();
        if let Some(time) = until {
            let frames = folder.frames()?.len();
            if folder.series().exists() {
                steps = read_pvd(&folder.series())?;
            } else if frames > 0 {
                let message = format!(
                    "the series is missing, but there are {frames} of its files: put it back, or move particles_*.vtp away to begin \
                     another"
                );
                return Err(SphError::Checkpoint { file: folder.series().display().to_string(), message });
            }
            steps.retain(|(t, _)| *t <= time);
            for (_, file) in &mut steps {
                *file = file.file_name().map(PathBuf::from).unwrap_or_default();
            }
        }
        Ok(Self { folder: folder.0.clone(), path: folder.series(), steps })
    }

    /// Writes the next file. Numbers go on from those kept, whatever the period was: none of these is written over.
    fn write(&mut self, solver: &Solver) -> Result<(), SphError> {
        let number =
            |(_, file): &(f64, PathBuf)| file.file_stem()?.to_str()?.strip_prefix("particles_")?.parse::<usize>().ok();
        let frame = self.steps.iter().filter_map(number).max().map_or(0, |last| last + 1);
        let name = PathBuf::from(format!("particles_{frame:05}.vtp"));
        write_vtp_particles(&self.folder.join(&name), &particles_of(solver)?, VtkEncoding::default())?;
        self.steps.push((solver.time(), name));
        write_pvd(&self.path, &self.steps)?;
        Ok(())
    }
}

/// Whether a line is a row of as many numbers as there are columns, up to a time: what a full disk has cut is none, also where the
/// cut is within a number.
fn is_row_until(line: &str, columns: usize, time: f64) -> bool {
    let numbers: Vec<f64> = line.trim_end().split(',').map_while(|word| word.parse().ok()).collect();
    let fields = line.split(',').count();
    line.ends_with('\n') && numbers.len() == columns && fields == columns && numbers[0] <= time
}

/// A table that grows while the run goes on.
struct Table {
    path: PathBuf,
    file: File,
    waiting: Vec<u8>,
}

impl Table {
    fn open(path: &Path, columns: &[String], until: Option<f64>) -> Result<Self, SphError> {
        let head = columns.join(",");
        let mut kept = head.clone() + "\n";
        if let Some(time) = until
            && path.exists()
        {
            let fault = |message: String| SphError::Checkpoint { file: path.display().to_string(), message };
            let old = std::fs::read_to_string(path)
                .map_err(|e| fault(format!("cannot be read: {e}; move it away to begin another")))?;
            if old.lines().next() != Some(&head) {
                return Err(fault(
                    "its columns are not those of the case's gauges: go on with the gauges that it was begun with, or \
                     move it away to begin another"
                        .into(),
                ));
            }
            for row in old.split_inclusive('\n').skip(1).filter(|row| is_row_until(row, columns.len(), time)) {
                kept.push_str(row.trim_end());
                kept.push('\n');
            }
        }
        AtomicFile::write(path, |out| out.write_all(kept.as_bytes()))?;
        let file = OpenOptions::new().append(true).open(path).map_err(|e| system(path, e))?;
        Ok(Self { path: path.into(), file, waiting: Vec::new() })
    }

    fn row(&mut self, numbers: &[f64]) -> Result<(), SphError> {
        for (index, &number) in numbers.iter().enumerate() {
            if index > 0 {
                self.waiting.push(b',');
            }
            write_number(&mut self.waiting, number).map_err(|e| system(&self.path, e))?;
        }
        self.waiting.push(b'\n');
        if self.waiting.len() > 1 << 14 { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), SphError> {
        self.file.write_all(&self.waiting).map_err(|e| system(&self.path, e))?;
        self.waiting.clear();
        Ok(())
    }
}
