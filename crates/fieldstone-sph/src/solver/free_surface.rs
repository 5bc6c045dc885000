//! The free surface at the end of a step, and the shifts that follow from it.

use std::time::Instant;

use fieldstone_particles::{Image, NeighbourGrid, NeighbourOptions};
use fieldstone_surface::{Exact, Method, ScanningCone, Scene, SurfaceDetection, WitnessCache};
use rayon::prelude::*;

use super::Solver;
use crate::energy::sum_in_parts;
use crate::ghosts::Ghosts;
use crate::phases::Phase;
use crate::shifting::Shift;
use crate::{ShiftingOptions, SphError};

/// Finds the free surface, with what is kept from step to step.
#[derive(Debug)]
pub(super) enum Detector {
    Exact(Box<Exact>, WitnessCache),
    Other(Box<dyn SurfaceDetection + Send>),
}

impl Detector {
    pub(super) fn new(method: Method) -> Result<Self, SphError> {
        Ok(match method {
            Method::Exact => Self::Exact(Box::default(), WitnessCache::default()),
            other => Self::Other(other.with_cone(ScanningCone::default())?),
        })
    }

    fn reach(&self, spacing: f64) -> f64 {
        match self {
            Self::Exact(exact, _) => exact.reach(spacing),
            Self::Other(method) => method.reach(spacing),
        }
    }
}

impl Solver {
    /// Labels of the present state by any detection method: true for the free surface.
    ///
    /// # Errors
    /// As [`SurfaceDetection::label`].
    pub fn labels(&self, method: &dyn SurfaceDetection) -> Result<Vec<bool>, SphError> {
        let fluid = &self.flow.fluid;
        let reach = method.reach(fluid.spacing);
        let images = self.images_within(reach);
        let (positions, candidates, volumes) = self.surroundings();
        let options = NeighbourOptions { dimension: fluid.dimension, ..NeighbourOptions::new(reach) };
        let grid = NeighbourGrid::build_with_images(&positions, &images, options)?;
        let scene =
            Scene { grid: &grid, spacing: fluid.spacing, volumes: Some(&volumes), candidates: Some(&candidates) };
        let mut labels = method.detect(&scene)?.labels();
        labels.truncate(self.state.len());
        Ok(labels)
    }

    /// Images of the particles within `reach` of a wall or periodic face.
    fn images_within(&self, reach: f64) -> Vec<Image> {
        let mut ghosts = Ghosts::new(&self.flow.boundaries, self.flow.fluid.dimension, [0.0; 3]);
        ghosts.rebuild(&self.state.x, &self.flow.boundaries, reach * (1.0 + 1e-9));
        let image = |i: usize| Image { source: ghosts.images[i].0, position: ghosts.position_of(i, &self.state.x) };
        (0..ghosts.images.len()).map(image).collect()
    }

    /// Positions, which of them are fluid, and volumes, of fluid particles and bodies' ghosts.
    fn surroundings(&self) -> (Vec<[f64; 3]>, Vec<bool>, Vec<f64>) {
        let bodies = &self.stage.points.bodies;
        let mut positions = self.state.x.clone();
        positions.extend_from_slice(&bodies.x);
        let mut candidates = vec![true; self.state.len()];
        candidates.resize(positions.len(), false);
        let mass = self.flow.fluid.particle_mass();
        let mut volumes: Vec<f64> = self.state.density.iter().map(|d| mass / d).collect();
        volumes.extend_from_slice(&bodies.volume);
        (positions, candidates, volumes)
    }

    pub(super) fn forget_witnesses(&mut self) {
        if let Some(Detector::Exact(_, cache)) = &mut self.detector {
            cache.clear();
        }
    }

    /// Labels the free surface of the present state.
    pub(super) fn detect(&mut self) -> Result<(), SphError> {
        self.stage.ensure_lists(&self.state.x, &self.flow)?;
        let mut clock = Instant::now();
        let (positions, candidates, volumes) = self.surroundings();
        let Some(reach) = self.detector.as_ref().map(|d| d.reach(self.flow.fluid.spacing)) else { return Ok(()) };
        if reach <= self.flow.fluid.kernel().reach() {
            self.stage.points.images_of(&self.state.x, &mut self.images);
        } else {
            // The lists' images end with the kernel.
            self.images = self.images_within(reach);
        }
        let Some(detector) = &mut self.detector else { return Ok(()) };
        let (fluid, count) = (&self.flow.fluid, self.state.len());
        let grid = match &mut self.detection_grid {
            Some(grid) => {
                grid.rebuild(&positions, &self.images)?;
                grid
            }
            none => {
                let options = NeighbourOptions { dimension: fluid.dimension, ..NeighbourOptions::new(reach) };
                none.insert(NeighbourGrid::build_with_images(&positions, &self.images, options)?)
            }
        };
        let scene = Scene { grid, spacing: fluid.spacing, volumes: Some(&volumes), candidates: Some(&candidates) };
        match detector {
            Detector::Exact(exact, cache) => exact.label_with(&scene, cache, &mut self.detection)?,
            Detector::Other(method) => method.label(&scene, &mut self.detection)?,
        }
        let detection = &self.detection;
        (0..count).into_par_iter().map(|i| u8::from(detection.is_free_surface(i))).collect_into_vec(&mut self.free);
        self.stage.phases.add(Phase::Detection, &mut clock);
        Ok(())
    }

    /// Regions of the present state, where nothing is shifted.
    pub(super) fn find_regions(&mut self) -> Result<(), SphError> {
        let mut clock = Instant::now();
        self.sum_shifts(&ShiftingOptions::default(), 1.0)?;
        self.regions.par_iter_mut().zip(&self.shifts).for_each(|(region, (_, found))| *region = *found);
        self.shifts.clear();
        self.stage.phases.add(Phase::Detection, &mut clock);
        Ok(())
    }

    pub(super) fn shift(&mut self, shifting: &ShiftingOptions, share: f64) -> Result<(), SphError> {
        let mut clock = Instant::now();
        self.sum_shifts(shifting, share)?;
        let (mass, gravity) = (self.flow.fluid.particle_mass(), self.flow.fluid.gravity);
        let moved = self.state.x.par_iter_mut().zip(&mut self.regions).zip(&self.shifts);
        moved.for_each(|((x, region), (shift, found))| {
            x.iter_mut().zip(shift).for_each(|(x, s)| *x += s);
            *region = *found;
        });
        let [fall] = sum_in_parts(&self.shifts, |(s, _)| [gravity[0] * s[0] + gravity[1] * s[1] + gravity[2] * s[2]]);
        self.budget.shifting -= mass * fall;
        self.stage.phases.add(Phase::Shifting, &mut clock);
        Ok(())
    }

    /// Shift and region of each particle; `share` is the step over the one that sound alone would allow.
    fn sum_shifts(&mut self, shifting: &ShiftingOptions, share: f64) -> Result<(), SphError> {
        self.stage.ensure_lists(&self.state.x, &self.flow)?;
        let fluid = &self.flow.fluid;
        let points = &mut self.stage.points;
        points.fill_shifting(&self.state, fluid.particle_mass(), &self.free);
        self.shifts.resize(self.state.len(), ([0.0; 3], 2));
        if shifting.n == 4 {
            points.fluid_list.sum(&Shift::<true>::new(fluid, shifting, share, &points.carriers), &mut self.shifts);
        } else {
            points.fluid_list.sum(&Shift::<false>::new(fluid, shifting, share, &points.carriers), &mut self.shifts);
        }
        Ok(())
    }
}
