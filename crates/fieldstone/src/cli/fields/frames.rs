//! Frames made ready for coarse graining, and what becomes of them over time.

use std::collections::VecDeque;

use anyhow::{anyhow, bail};
use fieldstone::fields::{
    CoarseGraining, CoarseGrainingOptions, Fields, FieldsError, displacements, gaussian_time_weights,
};
use fieldstone::io::{MercuryRestart, SeriesFrame};
use fieldstone::mesh::Cells;
use fieldstone::particles::{Contacts, Particles, Quantity};

use super::settings::Settings;

/// A frame with everything that fields may need.
pub(super) struct Frame {
    /// Place among all frames of the files.
    pub index: usize,
    pub time: f64,
    /// File and frame, for messages.
    pub name: String,
    pub particles: Particles,
    pub contacts: Option<Contacts>,
}

/// Time that a frame is taken to be of: its own, else by its step, else its place in the series.
pub(super) fn time_of(settings: &Settings, index: usize, particles: &Particles) -> f64 {
    let steps = || particles.step().map_or(index as f64, |step| step as f64);
    particles.time().unwrap_or_else(|| settings.timestep.unwrap_or(1.0) * steps())
}

impl Frame {
    pub fn new(settings: &Settings, restart: Option<&MercuryRestart>, frame: SeriesFrame) -> anyhow::Result<Self> {
        let SeriesFrame { index, path, mut particles, contacts } = frame;
        let name = format!("{}, frame {index}", path.display());
        if particles.is_empty() {
            bail!("{name}: the frame holds no particle; leave it out with --frames");
        }
        if let Some(radius) = settings.radius {
            particles = particles.with_uniform_radius(radius).map_err(|e| anyhow!("--radius: {e}"))?;
        }
        if let Some(restart) = restart {
            particles = restart.complete(particles).map_err(|e| anyhow!("--restart: {name}: {e}"))?;
        }
        if let Some(column) = &settings.mass_column {
            let found = particles.quantity(column).map_err(|e| anyhow!("--mass-column: {name}: {e}"))?;
            if found.components != 1 {
                bail!(
                    "--mass-column {column}: {name}: the column has {} numbers per particle; one is needed",
                    found.components
                );
            }
            let masses = Quantity { name: "mass".into(), components: 1, data: found.data.clone() };
            particles = particles.with_quantity(masses)?;
        }
        let time = time_of(settings, index, &particles);
        Ok(Self { index, time, name, particles, contacts })
    }

    /// An error with the frame that it is about.
    pub fn placed(&self, error: FieldsError) -> anyhow::Error {
        match &error {
            FieldsError::NoMass { .. } => anyhow!(
                "{}: {error}\n  for MercuryDPM give the .restart file (--restart); a column of another name with --mass-column",
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

/// Fields of one time.
pub(super) struct Outcome {
    pub fields: Fields,
    pub time: f64,
    /// Place of the frame that this is the result of, or is centred at.
    pub index: usize,
}

/// Computes fields and hands them on, one result after the other.
pub(super) fn compute<C: Cells>(
    cells: &C,
    options: &CoarseGrainingOptions,
    over_time: OverTime,
    frames: impl Iterator<Item = anyhow::Result<Frame>>,
    sink: &mut dyn FnMut(Outcome) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let start = || CoarseGraining::new(cells, options.clone());
    let add = |grains: &mut CoarseGraining<'_, C>, frame: &Frame, weight: f64| {
        grains.accumulate(&frame.particles, frame.contacts.as_ref(), weight).map_err(|e| frame.placed(e))
    };
    match over_time {
        OverTime::Each => {
            for frame in frames {
                let frame = frame?;
                let mut grains = start()?;
                add(&mut grains, &frame, 1.0)?;
                sink(Outcome { fields: grains.finish()?, time: frame.time, index: frame.index })?;
            }
            Ok(())
        }
        OverTime::Mean => {
            let mut grains = start()?;
            let (mut sum, mut count) = (0.0, 0usize);
            for frame in frames {
                let frame = frame?;
                add(&mut grains, &frame, 1.0)?;
                (sum, count) = (sum + frame.time, count + 1);
            }
            sink(Outcome { fields: grains.finish()?, time: sum / count.max(1) as f64, index: 0 })
        }
        OverTime::SmoothAt { width, at } => {
            let mut grains = start()?;
            for frame in frames {
                let frame = frame?;
                add(&mut grains, &frame, gaussian_time_weights(&[frame.time], at, width, None)?[0])?;
            }
            sink(Outcome { fields: grains.finish()?, time: at, index: 0 })
        }
        OverTime::SmoothEach(width) => {
            let mut frames = frames;
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
                let mut grains = start()?;
                for (frame, weight) in window.iter().zip(gaussian_time_weights(&times, at, width, None)?) {
                    if weight > 0.0 {
                        add(&mut grains, frame, weight)?;
                    }
                }
                sink(Outcome { fields: grains.finish()?, time: at, index })?;
                centre += 1;
            }
        }
    }
}
