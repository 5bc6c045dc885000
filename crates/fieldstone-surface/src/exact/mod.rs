//! The geometrical criterion, exactly, at a hundredth of the cost.

mod cover_table;
mod decide;

use std::sync::Arc;

use crate::detection::{Judge, check, flags};
use crate::neighbourhood::Neighbourhood;
use crate::scan::{Visitor, scan};
use crate::sun::SectorJudge;
use crate::{Detection, ScanningCone, Scene, SurfaceDetection, SurfaceError};

pub(crate) use cover_table::{CoverTable, Square, root_squares};
pub(crate) use decide::UnitDirections;
use decide::{DecideScratch, Decision};

/// The fast exact method: the labels of [`Geometrical`](crate::Geometrical), decided by masks and branch and bound.
///
/// $$ i \in F \iff \exists\, m:\ \max_j m \cdot z_j < \cos\theta, \qquad 0 < d_{ij} \le R $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | z_j | unit direction to neighbour j | – |
/// | θ, R | [`ScanningCone`] | rad, length |
///
/// 1. The sphere is divided into squares. A table over directions tells which squares lie within θ of every
///    direction in a cell; a neighbour's squares are one look-up. Where those of all neighbours are all squares, the
///    particle is an inner one.
/// 2. Else the direction away from the neighbours is tried: where no neighbour is within θ, the particle is free.
/// 3. Else the squares left are divided until one neighbour covers all corners of a square (then it covers the
///    square, since a cap below 90° is convex) or a square's centre is uncovered.
/// 4. What is undecided at the last division (a tie, nearly) is decided by the arcs of all circles.
///
/// Every step is rigorous, so the labels are exact but for ties of [`TIE`](crate::TIE). A particle's uncovered
/// direction, its *witness*, mostly still holds a time step later: see [`WitnessCache`].
///
/// Cost: 0.5 to 2 µs per particle, neighbours included. In two dimensions this is the method of
/// [`Sun`](crate::Sun), which is exact and fast already.
///
/// Source: criterion `liu2022`, Sec. 3.1; interval analysis for the same purpose `sandim2020`.
///
/// ```
/// use fieldstone_particles::{NeighbourGrid, NeighbourOptions};
/// use fieldstone_surface::{Exact, Scene, SurfaceDetection};
/// let cube: Vec<[f64; 3]> =
///     (0..1000).map(|i| [f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100)]).collect();
/// let method = Exact::default();
/// let grid = NeighbourGrid::build(&cube, NeighbourOptions::new(method.reach(1.0)))?;
/// assert_eq!(method.detect(&Scene::new(&grid, 1.0))?.free_surface(), 1000 - 8 * 8 * 8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Exact {
    cone: ScanningCone,
    table: Arc<CoverTable>,
}

/// Where each particle was found uncovered, to try first the next time.
///
/// Belongs to one order of particles; after reordering or removing particles call [`clear`](Self::clear). Any content
/// gives the same labels, it only costs time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WitnessCache {
    witnesses: Vec<[f32; 3]>,
    sorted: Vec<(u8, [f32; 3])>,
}

impl WitnessCache {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.witnesses.clear();
    }

    /// An uncovered direction of a particle that was found on the free surface; `None` for inner particles, for
    /// isolated ones, and in two dimensions.
    pub fn witness(&self, particle: usize) -> Option<[f32; 3]> {
        self.witnesses.get(particle).copied().filter(|w| *w != [0.0; 3])
    }
}

impl Default for Exact {
    /// The paper's cone.
    fn default() -> Self {
        let cone = ScanningCone::default();
        Self { cone, table: Arc::new(CoverTable::new(cone.cap_angle())) }
    }
}

impl Exact {
    /// The method with another cone; prepares the table of squares (some milliseconds), so keep it.
    ///
    /// # Errors
    /// [`SurfaceError::Option`].
    pub fn new(cone: ScanningCone) -> Result<Self, SurfaceError> {
        cone.validate()?;
        Ok(Self { cone, table: Arc::new(CoverTable::new(cone.cap_angle())) })
    }

    /// The scanning cone.
    pub fn cone(&self) -> ScanningCone {
        self.cone
    }

    /// As [`label`](SurfaceDetection::label), with the witnesses of the last time step.
    ///
    /// # Errors
    /// As [`label`](SurfaceDetection::label).
    pub fn label_with(
        &self,
        scene: &Scene<'_>,
        cache: &mut WitnessCache,
        detection: &mut Detection,
    ) -> Result<(), SurfaceError> {
        check(self, scene)?;
        if scene.grid.dimension() == 2 {
            return self.label(scene, detection);
        }
        cache.witnesses.resize(scene.grid.len(), [0.0; 3]);
        let visitor = CachedVisitor { judge: self.judge(), witnesses: &cache.witnesses };
        scan(scene, self.reach(scene.spacing), &visitor, &mut cache.sorted);
        for (witness, &rank) in cache.witnesses.iter_mut().zip(scene.grid.ranks()) {
            *witness = cache.sorted[rank as usize].1;
        }
        detection.fill_from(scene, |sorted| cache.sorted[sorted].0);
        Ok(())
    }

    /// The same method with another radius of the sphere over the spacing; shares the table.
    pub(crate) fn with_radius(&self, radius: f64) -> Self {
        Self { cone: ScanningCone { radius, ..self.cone }, table: Arc::clone(&self.table) }
    }

    fn judge(&self) -> ConeJudge<'_> {
        ConeJudge { table: &self.table }
    }
}

impl Exact {
    pub(crate) const NAME: &'static str = "exact";
}

impl SurfaceDetection for Exact {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn reach(&self, spacing: f64) -> f64 {
        self.cone.radius * spacing
    }

    fn label(&self, scene: &Scene<'_>, detection: &mut Detection) -> Result<(), SurfaceError> {
        check(self, scene)?;
        let radius = self.reach(scene.spacing);
        if scene.grid.dimension() == 2 {
            detection.fill(scene, radius, &SectorJudge::new(&self.cone));
        } else {
            detection.fill(scene, radius, &self.judge());
        }
        Ok(())
    }
}

struct ConeJudge<'a> {
    table: &'a CoverTable,
}

impl Judge for ConeJudge<'_> {
    type Scratch = DecideScratch;

    #[inline(always)]
    fn is_free(&self, _: usize, hood: &Neighbourhood, scratch: &mut DecideScratch) -> bool {
        matches!(decide::decide(self.table, hood, None, scratch), Decision::Free(_))
    }
}

struct CachedVisitor<'a> {
    judge: ConeJudge<'a>,
    witnesses: &'a [[f32; 3]],
}

impl Visitor for CachedVisitor<'_> {
    type Scratch = DecideScratch;
    type Output = (u8, [f32; 3]);

    #[inline(always)]
    fn visit(&self, particle: usize, hood: &Neighbourhood, scratch: &mut DecideScratch) -> Self::Output {
        if hood.len == 0 {
            return (flags(hood, true), [0.0; 3]);
        }
        let known = self.witnesses[particle];
        let known = (known != [0.0; 3]).then(|| known.map(f64::from));
        match decide::decide(self.judge.table, hood, known, scratch) {
            Decision::Free(witness) => (flags(hood, true), witness.map(|w| w as f32)),
            Decision::Inner => (flags(hood, false), [0.0; 3]),
        }
    }
}
