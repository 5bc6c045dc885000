//! The particles that rows of contacts name, by id or by position.

use std::collections::HashMap;
use std::path::Path;

use fieldstone_particles::{Particles, Partner};

use crate::contact_assembly::{Refusal, Row, Touch, length};
use crate::contact_columns::{ContactValues, ResolvedColumns};
use crate::{IoError, Position};

/// Turns the values of rows into contacts of particles that are known by id or by position.
pub(crate) struct Resolver<'a> {
    particles: Finder<'a>,
    path: &'a Path,
}

enum Finder<'a> {
    Ids(IdLookup),
    Positions(PositionLookup<'a>),
}

impl<'a> Resolver<'a> {
    pub(crate) fn new(particles: &'a Particles, columns: &ResolvedColumns, path: &'a Path) -> Result<Self, IoError> {
        let particles = if columns.by_id() {
            Finder::Ids(IdLookup::new(particles, path)?)
        } else {
            Finder::Positions(PositionLookup::new(particles))
        };
        Ok(Self { particles, path })
    }

    /// The contact; `None` for a wall that exerts no force.
    pub(crate) fn row(&self, values: &ContactValues, line: u64) -> Result<Option<Row>, IoError> {
        let at_line = |(found, remedy): Refusal| IoError::content(self.path, Position::Line(line), found, remedy);
        let [first, second, wall] = values.ids;
        let second = second.filter(|&id| id >= 0).map(Ok).or(match (second, values.position2) {
            (None, Some(position)) => Some(Err(position)),
            _ => None,
        });
        if second.is_none() && values.force == [0.0; 3] {
            return Ok(None);
        }
        let find = |id: Result<i64, [f64; 3]>| match (&self.particles, id) {
            (Finder::Ids(ids), Ok(id)) => ids.index(id),
            (Finder::Positions(positions), Err(position)) => positions.index(position),
            _ => Err((
                "one particle is given by id, the other by position".into(),
                "give both the same way (id1 and id2, or position1 and position2)".into(),
            )),
        };
        let particle = find(first.ok_or(values.position1)).map_err(at_line)?;
        let partner = match second {
            Some(second) => Partner::Particle(find(second).map_err(at_line)?),
            None => Partner::Wall(wall.or(values.ids[1]).unwrap_or(-1)),
        };
        let touch = match (values.point, values.overlap) {
            (Some(point), _) => Touch::Point(point),
            (None, Some(overlap)) => Touch::Overlap(overlap),
            (None, None) => Touch::Spheres,
        };
        Ok(Some(Row { particle, partner, force: values.force, normal_force: values.normal, touch, line }))
    }
}

/// Index of the particle at a position.
struct PositionLookup<'a> {
    particles: &'a Particles,
    /// Wrapped positions, sorted by x.
    sorted: Vec<([f64; 3], u32)>,
    tolerance: f64,
}

impl<'a> PositionLookup<'a> {
    fn new(particles: &'a Particles) -> Self {
        let wrap = |p: [f64; 3]| particles.domain().map_or(p, |domain| domain.wrap(p));
        let mut sorted: Vec<_> = particles.positions().iter().zip(0..).map(|(&p, index)| (wrap(p), index)).collect();
        sorted.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        // Far below any distance of two particles, far above what printing with six digits takes off.
        let tolerance = match particles.radii() {
            Ok(radii) => 1e-3 * radii.iter().copied().fold(f64::INFINITY, f64::min),
            Err(_) => {
                let extent = |k: usize| {
                    let all = particles.positions().iter().map(|p| p[k]);
                    all.clone().fold(f64::NEG_INFINITY, f64::max) - all.fold(f64::INFINITY, f64::min)
                };
                1e-5 * (0..3).map(extent).fold(0.0, f64::max)
            }
        };
        Self { particles, sorted, tolerance }
    }

    fn index(&self, position: [f64; 3]) -> Result<u32, Refusal> {
        let domain = self.particles.domain();
        let at = domain.map_or(position, |domain| domain.wrap(position));
        // Beside a periodic face the particle may have been wrapped to the other side.
        let images = match domain {
            Some(domain) => domain.images(at, self.tolerance).collect(),
            None => vec![at],
        };
        let mut closest: Option<(f64, u32)> = None;
        for image in images {
            let from = self.sorted.partition_point(|(p, _)| p[0] < image[0] - self.tolerance);
            for &(p, index) in self.sorted[from..].iter().take_while(|(p, _)| p[0] <= image[0] + self.tolerance) {
                let distance = length(std::array::from_fn(|k| p[k] - image[k]));
                if distance <= self.tolerance && closest.is_none_or(|(least, _)| distance < least) {
                    closest = Some((distance, index));
                }
            }
        }
        closest.map(|(_, index)| index).ok_or_else(|| {
            let [x, y, z] = position;
            let found = format!("no particle has its centre at ({x}, {y}, {z}) or within {:.1e} of it", self.tolerance);
            (found, "give particles and contacts of the same frame".into())
        })
    }
}

/// Index of each particle by its id.
struct IdLookup {
    indices: HashMap<i64, u32>,
}

impl IdLookup {
    /// # Errors
    /// Two particles of the same id; a set without ids.
    fn new(particles: &Particles, path: &Path) -> Result<Self, IoError> {
        let Some(ids) = particles.ids() else {
            let found = "the contacts name particles by id, but the particles have no ids";
            return Err(IoError::content(path, Position::File, found, "write the particles with an id column"));
        };
        let mut indices = HashMap::with_capacity(ids.len());
        for (index, &id) in ids.iter().enumerate() {
            if indices.insert(id, index as u32).is_some() {
                let found = format!("two particles have the id {id}, so it is open which of them a contact names");
                return Err(IoError::content(path, Position::File, found, "give particles of one frame only"));
            }
        }
        Ok(Self { indices })
    }

    /// Index of the particle `id`.
    ///
    /// # Errors
    /// What was found, and the remedy.
    fn index(&self, id: i64) -> Result<u32, Refusal> {
        self.indices.get(&id).copied().ok_or_else(|| {
            let found = format!("the contact names particle {id}, which is not among the {}", self.indices.len());
            (found, "give particles and contacts of the same frame, and all particles that are in contact".into())
        })
    }
}
