//! Weights of particles, branches and contact points in the cells.

use std::sync::atomic::{AtomicU64, Ordering};

use fieldstone_geometry::{Ball, Polyhedron, overlap_moments};
use fieldstone_mesh::Cells;

use super::frame::Frame;
use super::places::Places;
use super::segments::Segments;
use crate::binning::Binning;
use crate::periodic::{Image, Periods};
use crate::scatter::Pair;
use crate::{FieldsError, Kernel};

/// A kernel made ready for a set of cells: along averaged directions it is integrated, and divided by the extent.
pub(super) struct Sampling<'a> {
    places: Places<'a>,
    kernel: Kernel,
    averaged: [bool; 3],
    /// One over the extents of the averaged directions.
    share: f64,
}

impl<'a> Sampling<'a> {
    pub fn new<C: Cells>(cells: &'a C, kernel: Kernel) -> Result<Self, FieldsError> {
        let averaged = cells.averaged();
        let (low, high) = cells.bounds();
        let share = (0..3).filter(|&k| averaged[k]).map(|k| 1.0 / (high[k] - low[k])).product();
        let dimensions = averaged.iter().filter(|a| !**a).count();
        Ok(Self {
            // A Gaussian cut off within its width is as narrow as its cut-off.
            places: Places::new(cells, 0.2 * kernel.width().min(kernel.reach())),
            kernel: kernel.in_dimensions(dimensions)?,
            averaged,
            share,
        })
    }

    pub fn reach(&self) -> f64 {
        self.kernel.reach()
    }

    /// The resolved part of a vector.
    #[inline]
    fn resolved(&self, v: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| if self.averaged[k] { 0.0 } else { v[k] })
    }

    /// Pairs (cell, φ) of a point.
    pub fn point(&self, at: [f64; 3], mut emit: impl FnMut(u32, f64)) {
        let c = self.kernel.support();
        self.places.for_each(at.map(|x| x - c), at.map(|x| x + c), |cell, share, centre| {
            let d = self.resolved([centre[0] - at[0], centre[1] - at[1], centre[2] - at[2]]);
            let value = self.kernel.value(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            if value > 0.0 {
                emit(cell, value * self.share * share);
            }
        });
    }

    /// Pairs (cell, ψ) of a branch.
    pub fn branch(&self, start: [f64; 3], branch: [f64; 3], mut emit: impl FnMut(u32, f64)) {
        let c = self.kernel.support();
        let kernel = self.kernel.branch(self.resolved(branch));
        let low = std::array::from_fn(|k| start[k] + branch[k].min(0.0) - c);
        let high = std::array::from_fn(|k| start[k] + branch[k].max(0.0) + c);
        self.places.for_each(low, high, |cell, share, centre| {
            let x = self.resolved([centre[0] - start[0], centre[1] - start[1], centre[2] - start[2]]);
            let value = kernel.at(x);
            if value > 0.0 {
                emit(cell, value * self.share * share);
            }
        });
    }
}

/// How particles are weighed.
pub(super) enum ParticleWeights<'a, C: Cells> {
    Overlap(Binning<'a, C>),
    Sampled { sampling: Sampling<'a>, conserve: bool },
}

/// Working memory of one thread.
pub(super) struct Scratch<C: Cells> {
    cells: C::Scratch,
    row: Vec<(u32, f64)>,
}

impl<C: Cells> Scratch<C> {
    pub fn new(cells: C::Scratch) -> Self {
        Self { cells, row: Vec::new() }
    }
}

/// Everything that weighing needs to know.
pub(super) struct Weigher<'a, C: Cells> {
    pub cells: &'a C,
    pub weights: ParticleWeights<'a, C>,
    pub periods: Periods,
    /// First carrier of each particle where its images are carriers of their own.
    pub first_image: Option<&'a [u32]>,
    /// Part of each particle that the cells hold, as bits: the sum of its weights × cell volumes, but for methods that do
    /// not keep it ([`Binning::placed`]).
    pub placed: &'a [AtomicU64],
}

impl<C: Cells> Weigher<'_, C> {
    /// Calls `visit` with every image of a particle that may reach cells.
    pub fn images(&self, frame: &Frame<'_>, particle: usize, visit: impl FnMut(Image<'_>)) {
        let reach = match &self.weights {
            ParticleWeights::Overlap(binning) if binning.by_centre() => None,
            ParticleWeights::Overlap(_) => Some(frame.radii[particle]),
            ParticleWeights::Sampled { sampling, .. } => Some(sampling.reach()),
        };
        self.periods.for_each_image(frame.positions[particle], reach, visit);
    }

    /// The pairs of one particle.
    pub fn particle(
        &self,
        frame: &Frame<'_>,
        particle: usize,
        scratch: &mut Scratch<C>,
        out: &mut Vec<Pair>,
    ) -> Result<(), FieldsError> {
        if !frame.selected[particle] {
            return Ok(());
        }
        let mut carrier = self.first_image.map_or(particle as u32, |first| first[particle]);
        let step = u32::from(self.first_image.is_some());
        let begin = out.len();
        let mut failure = None;
        let mut placed = 0.0;
        match &self.weights {
            ParticleWeights::Overlap(binning) => {
                let share = 1.0 / frame.volumes[particle];
                self.images(frame, particle, |image| {
                    scratch.row.clear();
                    match Ball::new(image.centre, frame.radii[particle]) {
                        Ok(ball) => {
                            binning.bin(&ball, &image, particle as u64, &mut scratch.cells, &mut scratch.row);
                            placed += binning.placed(&ball, &scratch.row) * share;
                        }
                        Err(source) => failure = Some(FieldsError::Ball { particle, source }),
                    }
                    out.extend(scratch.row.iter().map(|&(cell, volume)| Pair {
                        cell,
                        carrier,
                        weight: volume * share,
                    }));
                    carrier += step;
                });
            }
            ParticleWeights::Sampled { sampling, conserve } => {
                let first = carrier;
                self.images(frame, particle, |image| {
                    sampling.point(image.centre, |cell, weight| {
                        placed += weight * self.cells.cell_volume(cell as usize);
                        out.push(Pair { cell, carrier, weight });
                    });
                    carrier += step;
                });
                if *conserve {
                    if placed > 0.0 {
                        out[begin..].iter_mut().for_each(|pair| pair.weight /= placed);
                        placed = 1.0;
                    } else if let Some((cell, image)) = self.home(frame, particle, scratch) {
                        let carrier = first + step * image;
                        out.push(Pair { cell, carrier, weight: 1.0 / self.cells.cell_volume(cell as usize) });
                        placed = 1.0;
                    }
                }
            }
        }
        self.placed[particle].store(f64::to_bits(placed), Ordering::Relaxed);
        failure.map_or(Ok(()), Err)
    }

    /// The cell that holds the centre of a particle between all samples, and the number of the image that lies there.
    ///
    /// Most images reach the cells with their rim alone: the first of them need not be the one whose centre is inside.
    fn home(&self, frame: &Frame<'_>, particle: usize, scratch: &mut Scratch<C>) -> Option<(u32, u32)> {
        let mut home = None;
        self.periods.for_each_point(frame.positions[particle], |point| {
            if home.is_none() {
                home = self.cells.locate(point, &mut scratch.cells).map(|cell| (cell, point));
            }
        });
        let (cell, point) = home?;
        // A point that rounding has put beside the outer face of the cells was moved onto it: its image is the nearest.
        let (mut image, mut nearest, mut number) = (0, f64::INFINITY, 0);
        self.images(frame, particle, |other| {
            let distance: f64 = (0..3).map(|k| (other.centre[k] - point[k]).powi(2)).sum();
            if distance < nearest {
                (image, nearest) = (number, distance);
            }
            number += 1;
        });
        Some((cell, image))
    }

    /// First moments of a particle's overlaps over its volume: three pairs per cell, for carriers 3 i + k.
    pub fn moments(
        &self,
        frame: &Frame<'_>,
        particle: usize,
        elements: &[Vec<(f64, Polyhedron)>],
        out: &mut Vec<Pair>,
    ) -> Result<(), FieldsError> {
        if !frame.selected[particle] {
            return Ok(());
        }
        let mut failure = None;
        let radius = frame.radii[particle];
        self.images(frame, particle, |image| match Ball::new(image.centre, radius) {
            Ok(ball) => {
                let centre = image.centre;
                self.cells.for_each_candidate(centre.map(|x| x - radius), centre.map(|x| x + radius), &mut |cell| {
                    let mut first = [0.0; 3];
                    for (sign, element) in &elements[cell as usize] {
                        let moments = overlap_moments(&ball, element);
                        (0..3).for_each(|k| first[k] += sign * moments.first[k]);
                    }
                    for (k, first) in first.into_iter().enumerate() {
                        if first != 0.0 {
                            let weight = first / frame.volumes[particle];
                            out.push(Pair { cell, carrier: (3 * particle + k) as u32, weight });
                        }
                    }
                });
            }
            Err(source) => failure = Some(FieldsError::Ball { particle, source }),
        });
        failure.map_or(Ok(()), Err)
    }
}

/// How branches and contact points are weighed.
pub(super) enum ContactWeights<'a, C: Cells> {
    Sampled(Sampling<'a>),
    Segments(Segments<'a, C>),
}

impl<C: Cells> ContactWeights<'_, C> {
    /// Pairs of the branch from `start`, in all images.
    pub fn branch(
        &self,
        periods: &Periods,
        start: [f64; 3],
        branch: [f64; 3],
        scratch: &mut Scratch<C>,
        mut emit: impl FnMut(u32, f64),
    ) {
        match self {
            Self::Sampled(sampling) => {
                let c = sampling.reach();
                let low = std::array::from_fn(|k| start[k] + branch[k].min(0.0) - c);
                let high = std::array::from_fn(|k| start[k] + branch[k].max(0.0) + c);
                periods.for_each(low, high, |shift| {
                    sampling.branch(std::array::from_fn(|k| start[k] + shift[k]), branch, &mut emit);
                });
            }
            Self::Segments(segments) => periods.for_each_segment(start, branch, |from, along| {
                segments.fractions(from, along, &mut scratch.cells, &mut emit);
            }),
        }
    }

    /// Pairs of a contact point, in all images.
    pub fn point(&self, periods: &Periods, at: [f64; 3], scratch: &mut Scratch<C>, mut emit: impl FnMut(u32, f64)) {
        match self {
            Self::Sampled(sampling) => {
                periods.for_each_image(at, Some(sampling.reach()), |image| sampling.point(image.centre, &mut emit));
            }
            Self::Segments(segments) => periods.for_each_point(at, |at| {
                if let Some(cell) = segments.locate(at, &mut scratch.cells) {
                    emit(cell, 1.0);
                }
            }),
        }
    }
}
