use std::fmt::Debug;

use rayon::prelude::*;

use crate::neighbourhood::Neighbourhood;
use crate::scan::{Visitor, scan};
use crate::{Scene, SurfaceError};

/// Angle in radians below which an uncovered sliver is a tie, and so covered.
///
/// All methods enlarge their caps by it. Without, rounding would decide where geometry does not: on the edge of a
/// concave right angle of a lattice, caps of 45° touch exactly.
pub const TIE: f64 = 1e-9;

const FREE: u8 = 1;
const ISOLATED: u8 = 2;
const COINCIDENT: u8 = 4;

/// A method that tells free-surface particles from inner ones.
///
/// All share one criterion for what they skip: neighbours at distance 0 are left out and reported
/// ([`Detection::coincident`]), and a particle without a neighbour is on the free surface.
pub trait SurfaceDetection: Debug + Sync {
    /// Name in messages and tables.
    fn name(&self) -> &'static str;

    /// The only number of dimensions that the method exists in, or `None` for 2 and 3.
    fn only_dimension(&self) -> Option<usize> {
        None
    }

    /// Largest distance of a neighbour that the method looks at.
    fn reach(&self, spacing: f64) -> f64;

    /// Labels the candidates of a scene; memory of `detection` is reused.
    ///
    /// # Errors
    /// A parameter outside its range, a column of the wrong length, a neighbour search of too small a reach, or the
    /// wrong number of dimensions.
    fn label(&self, scene: &Scene<'_>, detection: &mut Detection) -> Result<(), SurfaceError>;

    /// As [`label`](Self::label), into new memory.
    ///
    /// # Errors
    /// As [`label`](Self::label).
    fn detect(&self, scene: &Scene<'_>) -> Result<Detection, SurfaceError> {
        let mut detection = Detection::default();
        self.label(scene, &mut detection)?;
        Ok(detection)
    }
}

/// Labels of a particle set, in its own order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Detection {
    flags: Vec<u8>,
    sorted: Vec<u8>,
}

impl Detection {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.flags.len()
    }

    /// Whether there is no particle.
    pub fn is_empty(&self) -> bool {
        self.flags.is_empty()
    }

    /// Whether a particle is on the free surface.
    pub fn is_free_surface(&self, particle: usize) -> bool {
        self.flags[particle] & FREE != 0
    }

    /// One label per particle.
    pub fn labels(&self) -> Vec<bool> {
        self.flags.iter().map(|f| f & FREE != 0).collect()
    }

    /// Whether a particle has no neighbour at all.
    pub fn is_isolated(&self, particle: usize) -> bool {
        self.flags[particle] & ISOLATED != 0
    }

    /// Number of free-surface particles.
    pub fn free_surface(&self) -> usize {
        self.count(FREE)
    }

    /// Number of particles without a neighbour; they are on the free surface, too.
    pub fn isolated(&self) -> usize {
        self.count(ISOLATED)
    }

    /// Number of particles that share their place with another one.
    pub fn coincident(&self) -> usize {
        self.count(COINCIDENT)
    }

    fn count(&self, flag: u8) -> usize {
        self.flags.iter().filter(|&f| f & flag != 0).count()
    }

    pub(crate) fn fill<J: Judge>(&mut self, scene: &Scene<'_>, radius: f64, judge: &J) {
        scan(scene, radius, &Judging(judge), &mut self.sorted);
        self.take_sorted(scene);
    }

    /// As [`fill`](Self::fill), from flags that were computed elsewhere, in sorted order.
    pub(crate) fn fill_from(&mut self, scene: &Scene<'_>, flags: impl Fn(usize) -> u8 + Sync) {
        scene.grid.ranks().par_iter().map(|&rank| flags(rank as usize)).collect_into_vec(&mut self.flags);
    }

    fn take_sorted(&mut self, scene: &Scene<'_>) {
        let sorted = &self.sorted;
        scene.grid.ranks().par_iter().map(|&rank| sorted[rank as usize]).collect_into_vec(&mut self.flags);
    }
}

/// A method's decision on one particle that has at least one neighbour.
pub(crate) trait Judge: Sync {
    type Scratch: Default;

    fn is_free(&self, particle: usize, hood: &Neighbourhood, scratch: &mut Self::Scratch) -> bool;
}

struct Judging<'a, J>(&'a J);

impl<J: Judge> Visitor for Judging<'_, J> {
    type Scratch = J::Scratch;
    type Output = u8;

    #[inline(always)]
    fn visit(&self, particle: usize, hood: &Neighbourhood, scratch: &mut J::Scratch) -> u8 {
        flags(hood, hood.len == 0 || self.0.is_free(particle, hood, scratch))
    }
}

#[inline(always)]
pub(crate) fn flags(hood: &Neighbourhood, free: bool) -> u8 {
    u8::from(free) * FREE + u8::from(hood.len == 0) * ISOLATED + u8::from(hood.coincident > 0) * COINCIDENT
}

/// Refuses what every method refuses.
pub(crate) fn check(method: &dyn SurfaceDetection, scene: &Scene<'_>) -> Result<(), SurfaceError> {
    let dimension = scene.grid.dimension();
    if let Some(supported) = method.only_dimension()
        && supported != dimension
    {
        return Err(SurfaceError::Dimension { method: method.name(), dimension, supported });
    }
    scene.validate(method.name(), method.reach(scene.spacing))
}
