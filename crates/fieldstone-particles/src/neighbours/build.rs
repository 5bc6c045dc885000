use rayon::prelude::*;

use super::table::Table;
use super::{Image, NeighbourGrid, NeighbourOptions};
use crate::ParticlesError;

/// Arrays that only building needs, kept to build again without allocating.
#[derive(Debug, Clone, Default)]
pub(super) struct Work {
    points: Vec<[f64; 3]>,
    images: Vec<Image>,
    slots: Vec<u32>,
    pub(super) order: Vec<u32>,
}

impl NeighbourGrid {
    /// Sorts the particles at `positions` into cells.
    ///
    /// # Errors
    /// [`ParticlesError::Reach`], [`ParticlesError::Dimension`], [`ParticlesError::ReachBeyondBox`] for the options;
    /// [`ParticlesError::NotFinite`] names the first bad position; [`ParticlesError::TooMany`].
    pub fn build(positions: &[[f64; 3]], options: NeighbourOptions) -> Result<Self, ParticlesError> {
        Self::build_with_images(positions, &[], options)
    }

    /// As [`build`](Self::build), with images that the caller has made, such as those behind mirror planes.
    ///
    /// Periodic images of particles and images are added to them.
    ///
    /// # Errors
    /// As [`build`](Self::build); [`ParticlesError::UnknownIndex`] where an image has no source.
    pub fn build_with_images(
        positions: &[[f64; 3]],
        images: &[Image],
        options: NeighbourOptions,
    ) -> Result<Self, ParticlesError> {
        options.validate()?;
        let mut grid = Self {
            options,
            table: Table::default(),
            starts: vec![0, 0],
            x: Vec::new(),
            y: Vec::new(),
            z: Vec::new(),
            sources: Vec::new(),
            ranks: Vec::new(),
            work: Work::default(),
        };
        grid.rebuild(positions, images)?;
        Ok(grid)
    }

    /// Sorts new positions with the same options into the same memory: for every time step.
    ///
    /// # Errors
    /// As [`build_with_images`](Self::build_with_images); the grid is unusable until the next success.
    pub fn rebuild(&mut self, positions: &[[f64; 3]], images: &[Image]) -> Result<(), ParticlesError> {
        self.collect_points(positions, images)?;
        let count = self.work.points.len();
        let table = self.fit_table();
        let points = &self.work.points;
        points.par_iter().map(|&p| table.slot(p) as u32).collect_into_vec(&mut self.work.slots);

        // Counting sort; equal slots keep the order of the points.
        let starts = &mut self.starts;
        starts.clear();
        starts.resize(table.len() + 1, 0);
        for &slot in &self.work.slots {
            starts[slot as usize + 1] += 1;
        }
        for slot in 1..starts.len() {
            starts[slot] += starts[slot - 1];
        }
        self.work.order.clear();
        self.work.order.resize(count, 0);
        for (point, &slot) in self.work.slots.iter().enumerate() {
            let next = &mut starts[slot as usize];
            self.work.order[*next as usize] = point as u32;
            *next += 1;
        }
        // Each start has moved to its slot's end, which is the next one's start.
        starts.copy_within(0..table.len(), 1);
        starts[0] = 0;
        self.table = table;

        let particles = positions.len();
        let images = &self.work.images;
        let order = &self.work.order;
        order.par_iter().map(|&p| points[p as usize][0]).collect_into_vec(&mut self.x);
        order.par_iter().map(|&p| points[p as usize][1]).collect_into_vec(&mut self.y);
        order.par_iter().map(|&p| points[p as usize][2]).collect_into_vec(&mut self.z);
        order
            .par_iter()
            .map(|&p| if (p as usize) < particles { p } else { images[p as usize - particles].source })
            .collect_into_vec(&mut self.sources);
        self.ranks.clear();
        self.ranks.resize(particles, 0);
        for (sorted, &point) in order.iter().enumerate() {
            if let Some(rank) = self.ranks.get_mut(point as usize) {
                *rank = sorted as u32;
            }
        }
        Ok(())
    }

    /// Particles, wrapped, then all images.
    fn collect_points(&mut self, positions: &[[f64; 3]], images: &[Image]) -> Result<(), ParticlesError> {
        let NeighbourOptions { reach, dimension, domain } = self.options;
        check_finite(positions, dimension)?;
        let flat = |p: [f64; 3]| if dimension == 2 { [p[0], p[1], 0.0] } else { p };
        let Work { points, images: all, .. } = &mut self.work;
        let wrap = |p: [f64; 3]| domain.map_or(p, |domain| domain.wrap(p));
        positions.par_iter().map(|&p| flat(wrap(p))).collect_into_vec(points);
        all.clear();
        for image in images {
            if image.source as usize >= positions.len() {
                return Err(ParticlesError::UnknownIndex {
                    index: image.source as usize,
                    particle_count: positions.len(),
                });
            }
            check_finite(&[image.position], dimension).map_err(|_| ParticlesError::NotFinite {
                index: image.source as usize,
                what: "an image at x, y or z".into(),
                value: f64::NAN,
            })?;
            all.push(Image { source: image.source, position: flat(image.position) });
        }
        if let Some(domain) = domain {
            let mut periodic = domain.periodic();
            periodic[2] &= dimension == 3;
            let domain = domain.with_periodic(periodic);
            let (low, high) = (domain.low(), domain.high());
            // An image on the very edge of the reach must not be lost to rounding.
            let padded = reach * (1.0 + 1e-9);
            let near =
                |p: &[f64; 3]| (0..3).any(|k| periodic[k] && (p[k] < low[k] + padded || p[k] > high[k] - padded));
            let given = all.len();
            for (source, &p) in points.iter().enumerate() {
                if near(&p) {
                    let copies = domain.images(p, padded).skip(1);
                    all.extend(copies.map(|position| Image { source: source as u32, position }));
                }
            }
            for image in 0..given {
                let Image { source, position } = all[image];
                let mut copies = domain.images(position, padded);
                if let Some(home) = copies.next() {
                    all[image].position = home;
                }
                all.extend(copies.map(|position| Image { source, position }));
            }
        }
        points.extend(all.iter().map(|image| image.position));
        if points.len() >= u32::MAX as usize {
            return Err(ParticlesError::TooMany { count: points.len() });
        }
        Ok(())
    }

    fn fit_table(&self) -> Table {
        let points = &self.work.points;
        let (low, high) = points
            .par_iter()
            .fold(
                || ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]),
                |(low, high), p| {
                    (std::array::from_fn(|k| p[k].min(low[k])), std::array::from_fn(|k| p[k].max(high[k])))
                },
            )
            .reduce(
                || ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]),
                |a, b| (std::array::from_fn(|k| a.0[k].min(b.0[k])), std::array::from_fn(|k| a.1[k].max(b.1[k]))),
            );
        if points.is_empty() {
            return Table::default();
        }
        let core = || {
            let stride = points.len().div_ceil(4096);
            let mut bounds = [[0.0; 3]; 2];
            for axis in 0..3 {
                let mut sample: Vec<f64> = points.iter().step_by(stride).map(|p| p[axis]).collect();
                sample.sort_unstable_by(f64::total_cmp);
                let margin = sample.len() / 100;
                bounds[0][axis] = sample[margin];
                bounds[1][axis] = sample[sample.len() - 1 - margin];
            }
            bounds
        };
        Table::new(low, high, core, self.options.reach, 8 * points.len() + 1024)
    }
}

fn check_finite(positions: &[[f64; 3]], dimension: usize) -> Result<(), ParticlesError> {
    let bad = positions.par_iter().position_first(|p| p[..dimension].iter().any(|x| !x.is_finite()));
    let Some(index) = bad else { return Ok(()) };
    let axis = (0..dimension).find(|&k| !positions[index][k].is_finite()).unwrap_or(0);
    Err(ParticlesError::NotFinite { index, what: ["x", "y", "z"][axis].into(), value: positions[index][axis] })
}
