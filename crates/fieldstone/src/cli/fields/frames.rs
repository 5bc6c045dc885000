//! Frames made ready for coarse graining, and what becomes of them over time.

use std::borrow::Cow;
use std::collections::VecDeque;

use anyhow::{anyhow, bail};
use fieldstone::fields::{
    CoarseGraining, CoarseGrainingOptions, Fields, FieldsError, ParcelWeight, Selection, displacements,
    gaussian_time_weights,
};
use fieldstone::io::{MercuryRestart, SeriesFrame};
use fieldstone::mesh::Cells;
use fieldstone::particles::{Contacts, Domain, Particles, ParticlesError, Quantity};
use rayon::prelude::*;

use super::clock::Clock;
use super::faces::{FaceFields, FaceSums};
use super::settings::Settings;
use crate::cli::report;

/// A frame with everything that fields may need.
pub(super) struct Frame {
    /// Place among all frames of the files.
    pub index: usize,
    pub time: f64,
    /// File and frame, for messages.
    pub name: String,
    pub particles: Particles,
    pub contacts: Option<Contacts>,
    /// What crosses the cells' faces, once it has been looked at.
    pub faces: Option<FaceSums>,
}

/// What frames are completed with.
pub(super) struct Source<'a> {
    pub settings: &'a Settings,
    pub restart: Option<&'a MercuryRestart>,
    pub clock: &'a Clock,
    /// In place of the files' box.
    pub bounds: Option<Domain>,
}

impl Source<'_> {
    pub fn frame(&self, frame: SeriesFrame) -> anyhow::Result<Frame> {
        let settings = self.settings;
        let SeriesFrame { index, path, mut particles, contacts } = frame;
        let name = format!("{}, frame {index}", path.display());
        if particles.is_empty() {
            // A pour begins, and an open flow ends, with such frames: means over time count them.
            report::warn(&format!("{name}: the frame holds no particle: its fields are those of empty space"));
            particles = of_no_particle(particles)?;
        }
        if let Some(radius) = settings.radius {
            particles = particles.with_uniform_radius(radius).map_err(|e| anyhow!("--radius: {e}"))?;
        }
        if let Some(restart) = self.restart {
            particles = restart.complete(particles).map_err(|e| anyhow!("--restart: {name}: {e}"))?;
        }
        // The restart file has a box, too.
        if let Some(bounds) = self.bounds {
            particles = particles.with_domain(bounds);
        }
        if let Some(column) = &settings.mass_column {
            let found = particles.column(column).map_err(|e| anyhow!("--mass-column: {name}: {e}"))?;
            if found.components != 1 {
                bail!(
                    "--mass-column {column}: {name}: the column has {} numbers per particle; one is needed",
                    found.components
                );
            }
            if let Some(k) = found.data.iter().position(|m| !(m.is_finite() && *m > 0.0)) {
                bail!(
                    "--mass-column {column}: {name}: particle {k} has {}; masses must be positive and finite",
                    found.data[k]
                );
            }
            let masses = Quantity { name: "mass".into(), components: 1, data: found.data.clone() };
            particles = particles.with_quantity(masses)?;
        }
        let time = self.clock.time_of(&path, index, &particles);
        Ok(Frame { index, time, name, particles, contacts, faces: None })
    }
}

/// A frame without particles, with columns without rows: not every format has columns where there is no row.
fn of_no_particle(particles: Particles) -> anyhow::Result<Particles> {
    let mut completed = particles.with_radii(Vec::new())?.with_ids(Vec::new())?.with_types(Vec::new())?;
    for (name, components) in [("mass", 1), ("velocity", 3)] {
        completed = without_rows(completed, name, components)?;
    }
    Ok(completed)
}

/// The same with one more column, where it is missing.
fn without_rows(particles: Particles, name: &str, components: usize) -> anyhow::Result<Particles> {
    if particles.quantity(name).is_ok() {
        return Ok(particles);
    }
    Ok(particles.with_quantity(Quantity { name: name.into(), components, data: Vec::new() })?)
}

impl Frame {
    /// An error with the frame that it is about.
    pub fn placed(&self, error: FieldsError) -> anyhow::Error {
        match &error {
            FieldsError::NoMass { .. } => anyhow!(
                "{}: {error}\n  for MercuryDPM give the .restart file (--restart); a column of another name with --mass-column",
                self.name
            ),
            FieldsError::Particles(ParticlesError::NoColumn { name, .. }) if name == "velocity" => anyhow!(
                "{}: {error}\n  give a file with velocities (columns vx vy vz, say), or leave out of --fields what needs them",
                self.name
            ),
            FieldsError::Option { .. } | FieldsError::Combination { .. } | FieldsError::NoFrames => error.into(),
            _ => anyhow!("{}: {error}", self.name),
        }
    }
}

/// Each frame but the last with the displacements to the one after it.
pub(super) fn with_displacements(
    frames: impl Iterator<Item = anyhow::Result<Frame>>,
) -> impl Iterator<Item = anyhow::Result<Frame>> {
    let mut before: Option<Frame> = None;
    frames.filter_map(move |frame| {
        let next = match frame {
            Ok(frame) => frame,
            Err(error) => return Some(Err(error)),
        };
        let result = before.take().map(|frame| {
            let moved = displacements(&frame.particles, &next.particles).map_err(|e| frame.placed(e))?;
            if moved.len() != frame.particles.len() && frame.contacts.is_some() {
                bail!(
                    "{}: {} particles are gone by the next frame, so displacements and contacts cannot be had at once; leave \
                     the contacts out, or the displacements",
                    frame.name,
                    frame.particles.len() - moved.len()
                );
            }
            Ok(Frame { particles: moved, ..frame })
        });
        before = Some(next);
        result
    })
}

/// What becomes of the frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum OverTime {
    /// A result for each.
    Each,
    /// Their mean.
    Mean,
    /// A Gaussian mean around each, of this standard deviation.
    SmoothEach(f64),
    /// The same around one time.
    SmoothAt { width: f64, at: f64 },
}

/// What to make of the frames.
pub(super) struct Plan<'a> {
    pub options: &'a CoarseGrainingOptions,
    /// Types of particles that get fields of their own, beside those of all.
    pub species: &'a [i64],
    /// What crosses the faces in a frame, where the cells have faces.
    pub faces: Option<&'a FaceSource<'a>>,
    /// Whether the particles are needed after their fields are there.
    pub keep_particles: bool,
    /// Frames that are computed at the same time, where each has its own result.
    pub at_once: usize,
}

/// What crosses the faces in a frame.
pub(super) type FaceSource<'a> = dyn Fn(&Frame) -> Result<FaceSums, FieldsError> + Sync + 'a;

/// Fields of one time.
pub(super) struct Outcome {
    pub fields: Fields,
    pub time: f64,
    /// Place of the frame that this is the result of, or is centred at.
    pub index: usize,
    pub faces: FaceFields,
    /// The worst frame's residual.
    pub balance: Option<f64>,
    /// Where they were asked to be kept.
    pub particles: Option<Particles>,
}

/// A result on its way.
struct Running<'a, C: Cells> {
    plan: &'a Plan<'a>,
    all: CoarseGraining<'a, C>,
    species: Vec<CoarseGraining<'a, C>>,
    faces: FaceFields,
    balance: Option<f64>,
}

impl<'a, C: Cells> Running<'a, C> {
    fn new(cells: &'a C, plan: &'a Plan<'a>) -> Result<Self, FieldsError> {
        let options = plan.options;
        let of_type = |species: &i64| {
            let selection = Selection { types: Some(vec![*species]), ..options.selection.clone() };
            CoarseGraining::new(cells, CoarseGrainingOptions { selection, ..options.clone() })
        };
        Ok(Self {
            plan,
            all: CoarseGraining::new(cells, options.clone())?,
            species: plan.species.iter().map(of_type).collect::<Result<_, _>>()?,
            faces: FaceFields::default(),
            balance: None,
        })
    }

    fn add(&mut self, frame: &Frame, weight: f64) -> anyhow::Result<()> {
        let mut particles = Cow::Borrowed(&frame.particles);
        if particles.is_empty() {
            let columns = self.plan.options.quantities.iter().flat_map(|quantity| &quantity.columns);
            let mut completed = without_rows(frame.particles.clone(), "angular_velocity", 3)?;
            completed = without_rows(completed, "displacement", 3)?;
            if let Some(ParcelWeight::Column(name)) = &self.plan.options.parcel_weight
                && completed.column(name).is_err()
            {
                completed = without_rows(completed, name, 1)?;
            }
            for column in columns {
                // Of a vector the columns are named one by one, its last component last.
                let component = column.strip_suffix(']').and_then(|c| c.rsplit_once('['));
                let component = component.and_then(|(name, k)| Some((name, k.parse::<usize>().ok()?)));
                completed = match component {
                    _ if completed.column(column).is_ok() => completed,
                    Some((name, _)) => without_rows(completed, name, 9)?,
                    None => without_rows(completed, column, 1)?,
                };
            }
            particles = Cow::Owned(completed);
        }
        for grains in std::iter::once(&mut self.all).chain(&mut self.species) {
            grains.accumulate(&particles, frame.contacts.as_ref(), weight).map_err(|e| frame.placed(e))?;
        }
        if let Some(faces) = &frame.faces {
            self.faces.add(faces, weight);
            self.balance = match (self.balance, faces.balance) {
                (Some(a), Some(b)) => Some(a.max(b)),
                (a, b) => a.or(b),
            };
        }
        Ok(())
    }

    fn finish(self, time: f64, index: usize) -> anyhow::Result<Outcome> {
        let mut fields = self.all.finish()?;
        for (species, grains) in self.plan.species.iter().zip(self.species) {
            let own = grains.finish()?.fields.into_iter().map(|mut field| {
                field.name = format!("{}_species_{species}", field.name);
                field
            });
            fields.fields.extend(own);
        }
        let (faces, balance) = (self.faces.mean(), self.balance);
        Ok(Outcome { fields, time, index, faces, balance, particles: None })
    }
}

/// Computes fields and hands them on, one result after the other.
///
/// Frames with a result each are computed some at a time, while the results before them are handed on. The results and
/// their order are those of one frame after the other.
pub(super) fn compute<C: Cells>(
    cells: &C,
    plan: &Plan<'_>,
    over_time: OverTime,
    frames: impl Iterator<Item = anyhow::Result<Frame>>,
    sink: &mut dyn FnMut(Outcome) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let look_at_faces = |mut frame: Frame| -> anyhow::Result<Frame> {
        let found = plan.faces.map(|faces| faces(&frame)).transpose();
        frame.faces = found.map_err(|e| frame.placed(e))?;
        Ok(frame)
    };
    if over_time == OverTime::Each {
        let one = |frame: Frame| -> anyhow::Result<Outcome> {
            let frame = look_at_faces(frame)?;
            let mut running = Running::new(cells, plan)?;
            running.add(&frame, 1.0)?;
            let outcome = running.finish(frame.time, frame.index)?;
            Ok(Outcome { particles: plan.keep_particles.then_some(frame.particles), ..outcome })
        };
        return some_at_a_time(plan.at_once, frames, one, sink);
    }
    let mut frames = frames.map(|frame| look_at_faces(frame?));
    let start = || Running::new(cells, plan);
    match over_time {
        OverTime::Each | OverTime::Mean => {
            let mut running = start()?;
            let (mut sum, mut count) = (0.0, 0usize);
            for frame in frames {
                let frame = frame?;
                running.add(&frame, 1.0)?;
                (sum, count) = (sum + frame.time, count + 1);
            }
            sink(running.finish(sum / count.max(1) as f64, 0)?)
        }
        OverTime::SmoothAt { width, at } => {
            let mut running = start()?;
            let (mut weights, mut nearest) = (0.0, None::<(f64, String)>);
            for frame in frames {
                let frame = frame?;
                let weight = gaussian_time_weights(&[frame.time], at, width, None)?[0];
                weights += weight;
                if nearest.as_ref().is_none_or(|(time, _)| (frame.time - at).abs() < (time - at).abs()) {
                    nearest = Some((frame.time, frame.name.clone()));
                }
                running.add(&frame, weight)?;
            }
            if let Some((time, name)) = nearest.filter(|_| weights == 0.0) {
                bail!(
                    "--smooth {width}: one result is around {at}, the middle of the frames' times, and no frame lies within \
                     three widths of it: the nearest is {name}, at {time}; give a larger width, other --frames, or a .pvd or \
                     .stat file for a result around each frame"
                );
            }
            sink(running.finish(at, 0)?)
        }
        OverTime::SmoothEach(width) => {
            // Frames within reach of the one that a result is for, and which of them that is.
            let mut window: VecDeque<Frame> = VecDeque::new();
            let mut centre = 0;
            loop {
                if window.len() == centre {
                    let Some(frame) = frames.next() else { return Ok(()) };
                    window.push_back(frame?);
                }
                let (at, index) = (window[centre].time, window[centre].index);
                while window.back().is_none_or(|frame| frame.time <= at + 3.0 * width) {
                    let Some(frame) = frames.next() else { break };
                    window.push_back(frame?);
                }
                while window.front().is_some_and(|frame| frame.time < at - 3.0 * width) {
                    window.pop_front();
                    centre -= 1;
                }
                let times: Vec<f64> = window.iter().map(|frame| frame.time).collect();
                let mut running = start()?;
                for (frame, weight) in window.iter().zip(gaussian_time_weights(&times, at, width, None)?) {
                    if weight > 0.0 {
                        running.add(frame, weight)?;
                    }
                }
                sink(running.finish(at, index)?)?;
                centre += 1;
            }
        }
    }
}

/// Computes `at_once` frames in parallel, while the results before them are handed on; in the order of the frames.
fn some_at_a_time(
    at_once: usize,
    mut frames: impl Iterator<Item = anyhow::Result<Frame>>,
    one: impl Fn(Frame) -> anyhow::Result<Outcome> + Sync,
    sink: &mut dyn FnMut(Outcome) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let mut ready: Vec<Outcome> = Vec::new();
    loop {
        let batch: Vec<Frame> = frames.by_ref().take(at_once.max(1)).collect::<Result<_, _>>()?;
        let last = batch.is_empty();
        let mut computed = Vec::new();
        let handed_on = rayon::in_place_scope(|scope| {
            // What is handed on stays on this thread, which is none of the pool's.
            scope.spawn(|_| batch.into_par_iter().map(&one).collect_into_vec(&mut computed));
            ready.drain(..).try_for_each(&mut *sink)
        });
        handed_on?;
        ready = computed.into_iter().collect::<anyhow::Result<_>>()?;
        if last {
            return Ok(());
        }
    }
}
