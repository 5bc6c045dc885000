//! By how much the overlaps of a sphere with all elements of a mesh miss the sphere's volume.

use anyhow::Result;
use fieldstone::fields::NeumaierSum;
use fieldstone::geometry::{Ball, PROMISE, decomposition, fast_overlap_volume, overlap_volume};
use indicatif::ProgressBar;
use rayon::prelude::*;

use super::Settings;
use super::meshes::Lattice;
use super::samples::{Schedule, Trial, trials};

/// The ways to compute an overlap that are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// The kernel in `f64` alone.
    Fast,
    /// The kernel with its promise of 1e-12 of the smaller volume, in more digits where `f64` cannot keep it.
    Promised,
    /// Caps, wedges and cones.
    Decomposition,
}

impl Way {
    pub const ALL: [Self; 3] = [Self::Fast, Self::Promised, Self::Decomposition];

    pub fn name(self) -> &'static str {
        match self {
            Self::Fast => "kernel in f64",
            Self::Promised => "kernel with promise",
            Self::Decomposition => "decomposition",
        }
    }
}

/// The spheres of one radius in one mesh.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Misses {
    /// Spheres that were tried each way.
    pub samples: [u32; 3],
    /// Worst |ΣV / V_ball − 1| each way.
    pub worst: [f64; 3],
    /// Pairs of sphere and element that overlap in part, and those of them that need more than `f64` for the promise.
    pub cut: u64,
    pub beyond_f64: u64,
}

impl Misses {
    pub fn worst(&self, way: Way) -> f64 {
        self.worst[way as usize]
    }

    pub fn samples(&self, way: Way) -> u32 {
        self.samples[way as usize]
    }

    fn merge(&mut self, other: &Self) {
        for way in 0..3 {
            self.samples[way] += other.samples[way];
            self.worst[way] = self.worst[way].max(other.worst[way]);
        }
        self.cut += other.cut;
        self.beyond_f64 += other.beyond_f64;
    }
}

/// A mesh, and how many spheres of a radius are to be tried each way in it.
pub(super) struct Job {
    pub lattice: Lattice,
    pub share: fn(way: Way, radius: f64, schedule: Schedule) -> u32,
}

/// Results of each job, radius by radius.
///
/// Every element of a mesh is built once per block of spheres and shown to all of them, so that building, which costs more
/// than finding that an element is inside or outside, does not dominate. Blocks do not depend on the number of
/// threads, and the sums of a sphere belong to one block: neither do the results.
pub(super) fn measure(settings: &Settings, jobs: &[Job], bar: &ProgressBar) -> Result<Vec<Vec<Misses>>> {
    let mut blocks = Vec::new();
    for (number, job) in jobs.iter().enumerate() {
        for block in blocks_of_trials(settings, job)? {
            blocks.push((number, block));
        }
    }
    // Long blocks first, so that no thread is left with one at the end.
    blocks.sort_by_key(|(number, block)| {
        let area: f64 = block.iter().map(|t| t.trial.ball.radius().powi(2)).sum();
        std::cmp::Reverse((area * (1 + jobs[*number].lattice.split.count()) as f64) as u64)
    });
    bar.set_length(blocks.len() as u64);
    let found: Vec<(usize, Vec<Misses>)> = blocks
        .into_par_iter()
        .with_max_len(1)
        .map(|(number, block)| {
            let misses = in_block(&jobs[number].lattice, &block, settings.radii.len())?;
            bar.inc(1);
            Ok((number, misses))
        })
        .collect::<Result<_>>()?;
    let mut results = vec![vec![Misses::default(); settings.radii.len()]; jobs.len()];
    for (number, misses) in found {
        for (to, from) in results[number].iter_mut().zip(&misses) {
            to.merge(from);
        }
    }
    Ok(results)
}

struct Task {
    trial: Trial,
    wanted: [bool; 3],
}

/// The spheres of all radii in blocks of a like size of sphere; large spheres have large meshes to build.
fn blocks_of_trials(settings: &Settings, job: &Job) -> Result<Vec<Vec<Task>>> {
    // Upper end of the radii and number of spheres in a block.
    const CLASSES: [(f64, usize); 3] = [(1.0 + 1e-9, 20_000), (4.0 + 1e-9, 1_000), (f64::INFINITY, 250)];
    let mut classes: [Vec<Task>; 3] = Default::default();
    for (index, &radius) in settings.radii.iter().enumerate() {
        let shares = Way::ALL.map(|way| (job.share)(way, radius, settings.schedule));
        let count = shares.into_iter().max().unwrap_or(0);
        let class = CLASSES.iter().position(|c| radius <= c.0).unwrap_or(CLASSES.len() - 1);
        let wanted = trials(index, radius, count)?.into_iter().zip(0..);
        classes[class].extend(wanted.map(|(trial, k)| Task { trial, wanted: shares.map(|share| k < share) }));
    }
    let mut blocks = Vec::new();
    for (tasks, (_, size)) in classes.into_iter().zip(CLASSES) {
        let mut tasks = tasks.into_iter().peekable();
        while tasks.peek().is_some() {
            blocks.push(tasks.by_ref().take(size).collect());
        }
    }
    Ok(blocks)
}

/// All spheres of a block with all elements of the mesh that they reach.
fn in_block(lattice: &Lattice, block: &[Task], radii: usize) -> Result<Vec<Misses>> {
    let reach = block.iter().map(|t| 0.5 + t.trial.ball.radius()).fold(0.0, f64::max);
    let mut sums = vec![[NeumaierSum::default(); 3]; block.len()];
    let mut misses = vec![Misses::default(); radii];
    let (mut elements, mut near) = (Vec::new(), Vec::new());
    for cell in lattice.cells_covering(reach) {
        let corners = lattice.corners(cell);
        let low: [f64; 3] = std::array::from_fn(|k| corners.iter().map(|c| c[k]).fold(f64::INFINITY, f64::min));
        let high: [f64; 3] = std::array::from_fn(|k| corners.iter().map(|c| c[k]).fold(f64::NEG_INFINITY, f64::max));
        near.clear();
        near.extend((0..block.len()).filter(|&k| meets_box(&block[k].trial.ball, low, high)));
        if near.is_empty() {
            continue;
        }
        lattice.elements(cell, &mut elements)?;
        for element in &elements {
            let whole = element.polyhedron.volume();
            for &k in &near {
                let Task { trial, wanted } = &block[k];
                let (ball, seen) = (&trial.ball, &mut misses[trial.radius]);
                let sums = &mut sums[k];
                let (volume, bound) = fast_overlap_volume(ball, &element.polyhedron);
                if wanted[Way::Fast as usize] {
                    sums[Way::Fast as usize].add(volume);
                }
                if wanted[Way::Promised as usize] {
                    sums[Way::Promised as usize].add(overlap_volume(ball, &element.polyhedron));
                    seen.cut += u64::from(volume > 0.0 && volume < whole.min(ball.volume()));
                    seen.beyond_f64 += u64::from(bound > PROMISE * ball.volume().min(whole));
                }
                if wanted[Way::Decomposition as usize] {
                    sums[Way::Decomposition as usize].add(decomposition::overlap_volume(ball, &element.decomposed));
                }
            }
        }
    }
    for (task, sums) in block.iter().zip(&sums) {
        let whole = task.trial.ball.volume();
        let seen = &mut misses[task.trial.radius];
        for way in (0..3).filter(|&way| task.wanted[way]) {
            seen.samples[way] += 1;
            seen.worst[way] = seen.worst[way].max(((sums[way].value() - whole) / whole).abs());
        }
    }
    Ok(misses)
}

/// With a margin of rounding: what is decided wrongly here would be missing from the sum.
fn meets_box(ball: &Ball, low: [f64; 3], high: [f64; 3]) -> bool {
    let gap2: f64 = (0..3)
        .map(|k| {
            let x = ball.centre()[k];
            (low[k] - x).max(x - high[k]).max(0.0).powi(2)
        })
        .sum();
    gap2 <= ball.radius().powi(2) * (1.0 + 1e-12)
}
