//! MercuryDPM's `.restart` files: what `.data` and `.fstat` leave out.

use std::path::{Path, PathBuf};

use fieldstone_particles::{Domain, Particles, ParticlesError, Quantity};

use crate::lines::{LineReader, integer, number, shown, text, words};
use crate::{IoError, Position};

/// A species of a MercuryDPM simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct MercurySpecies {
    /// Number that particles refer to.
    pub id: i64,
    /// Class: `LinearViscoelasticSpecies` and the like.
    pub kind: String,
    /// Mass density of its particles.
    pub density: f64,
    /// Line of the file, from 1.
    pub line: u64,
}

/// A wall of a MercuryDPM simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct MercuryWall {
    /// Number that contacts refer to; −1 − id in `.fstat`.
    pub id: i64,
    /// Class: `InfiniteWall` and the like.
    pub kind: String,
    /// Species.
    pub species: i64,
    /// A point of it.
    pub position: [f64; 3],
}

/// What a `.restart` file states.
#[derive(Debug, Clone, PartialEq)]
pub struct MercuryRestart {
    /// The file.
    pub path: PathBuf,
    /// Time at which it was written.
    pub time: Option<f64>,
    /// Acceleration of gravity.
    pub gravity: Option<[f64; 3]>,
    /// Species in the file's order.
    pub species: Vec<MercurySpecies>,
    /// Walls in the file's order.
    pub walls: Vec<MercuryWall>,
    /// The box with its periodic directions.
    pub domain: Option<Domain>,
    /// Particles: radii, ids, types (species), `velocity`, `angular_velocity`, `force`, `torque`, `density` and `mass`.
    pub particles: Particles,
    /// What was left out, one sentence each.
    pub warnings: Vec<String>,
}

impl MercuryRestart {
    /// The particles of a `.data` frame of the same run with what only the restart file knows: `density` by species,
    /// `mass` $= \tfrac{4}{3}\pi R^3 \rho$, and the box with its periodic directions.
    ///
    /// # Errors
    /// [`IoError::Content`] where a particle's species is not among those of the restart file, or its density is not above 0;
    /// [`IoError::Particles`] where the particles have no radius.
    pub fn complete(&self, particles: Particles) -> Result<Particles, IoError> {
        let unfit = |source| IoError::Particles { path: self.path.clone(), source };
        let types = particles.types().map_or_else(|| vec![0; particles.len()], <[i64]>::to_vec);
        let densities = self.densities(&types)?;
        let volume = |r: f64| 4.0 / 3.0 * std::f64::consts::PI * (r * r * r);
        let masses =
            particles.radii().map_err(unfit)?.iter().zip(&densities).map(|(&r, density)| density * volume(r)).collect();
        let particles = particles
            .with_quantity(Quantity { name: "density".into(), components: 1, data: densities })
            .and_then(|all| all.with_quantity(Quantity { name: "mass".into(), components: 1, data: masses }))
            .map_err(unfit)?;
        Ok(match self.domain {
            Some(domain) => particles.with_domain(domain),
            None => particles,
        })
    }

    fn densities(&self, types: &[i64]) -> Result<Vec<f64>, IoError> {
        let density = |(index, &kind): (usize, &i64)| {
            let Some(species) = self.species.iter().find(|species| species.id == kind) else {
                let known: Vec<String> = self.species.iter().map(|species| species.id.to_string()).collect();
                let known = if known.is_empty() { "none".into() } else { known.join(", ") };
                let found =
                    format!("particle {index} is of species {kind}, which the file does not have; it has {known}");
                let remedy = "give the .restart file of the same run as the particles";
                return Err(IoError::content(&self.path, Position::File, found, remedy));
            };
            if species.density > 0.0 {
                return Ok(species.density);
            }
            let found = format!(
                "species {kind}, of which particle {index} is, has density {}; densities must be above 0",
                species.density
            );
            Err(IoError::content(&self.path, Position::Line(species.line), found, "correct the density in this line"))
        };
        types.iter().enumerate().map(density).collect()
    }
}

/// The words of a line: class first, then names that are followed by their numbers.
struct Entry<'a> {
    words: Vec<&'a [u8]>,
    /// Line of the file, from 1.
    line: u64,
}

impl<'a> Entry<'a> {
    fn new(lines: &'a LineReader) -> Self {
        Self { words: words(lines.line()).collect(), line: lines.number() }
    }

    fn kind(&self) -> String {
        self.words.first().map(|word| text(word)).unwrap_or_default()
    }

    /// The word after `key`.
    fn word(&self, key: &str) -> Option<&'a [u8]> {
        let at = self.words.iter().position(|word| *word == key.as_bytes())?;
        self.words.get(at + 1).copied()
    }

    fn numbers<const N: usize>(&self, key: &str) -> Option<[f64; N]> {
        let at = self.words.iter().position(|word| *word == key.as_bytes())?;
        let mut found = [0.0; N];
        for (slot, word) in found.iter_mut().zip(self.words.get(at + 1..=at + N)?) {
            *slot = number(word).filter(|value| value.is_finite())?;
        }
        Some(found)
    }
}

/// Reads a MercuryDPM `.restart` file.
///
/// Periodic boundaries along an axis become periodic directions of the box, with their own bounds; others are named
/// among the warnings. A particle of no inverse mass (a fixed one) gets its mass from its species' density.
///
/// # Errors
/// [`IoError::System`]; [`IoError::Content`] where the file is none, is cut, or a particle is no sphere.
pub fn read_restart(path: &Path) -> Result<MercuryRestart, IoError> {
    let mut lines = LineReader::open(path)?;
    let mut restart = MercuryRestart {
        path: path.into(),
        time: None,
        gravity: None,
        species: Vec::new(),
        walls: Vec::new(),
        domain: None,
        particles: Particles::default(),
        warnings: Vec::new(),
    };
    let mut bounds = None;
    let mut periodic = [None; 3];
    let mut seen_particles = false;
    while lines.advance()? {
        let entry = Entry::new(&lines);
        if lines.number() == 1 && entry.words.first() != Some(&&b"MercuryDPM"[..]) {
            return Err(lines.error("this is no MercuryDPM .restart file", "its first word has to be MercuryDPM"));
        }
        if let (Some([x0]), Some([x1]), Some([y0]), Some([y1]), Some([z0]), Some([z1])) = (
            entry.numbers("xMin"),
            entry.numbers("xMax"),
            entry.numbers("yMin"),
            entry.numbers("yMax"),
            entry.numbers("zMin"),
            entry.numbers("zMax"),
        ) {
            bounds = Some(([x0, y0, z0], [x1, y1, z1]));
        }
        if entry.words.first() == Some(&&b"timeStep"[..]) {
            restart.time = entry.numbers("time").map(|[time]| time);
        }
        restart.gravity = restart.gravity.or_else(|| entry.numbers("gravity"));
        let [section, count] = entry.words.as_slice() else { continue };
        let Some(count) = integer(count).and_then(|count| u64::try_from(count).ok()) else { continue };
        match *section {
            b"Species" => restart.species = section_of(&mut lines, count, "density", species)?,
            b"Walls" => restart.walls = section_of(&mut lines, count, "indSpecies", wall)?,
            b"Boundaries" => {
                for boundary in section_of(&mut lines, count, "", boundary)? {
                    match boundary {
                        Boundary::Periodic { axis, from, to } => periodic[axis] = Some((from, to)),
                        Boundary::Other(kind) => restart.warnings.push(format!("boundary {kind} is passed over")),
                    }
                }
            }
            b"Particles" => {
                let rows = section_of(&mut lines, count, "radius", particle)?;
                seen_particles = true;
                restart.particles = build(path, rows, &restart)?;
            }
            _ => {}
        }
    }
    if !seen_particles {
        return Err(lines.error("the file ends before its particles", "the file is cut, or still being written"));
    }
    if let Some((mut low, mut high)) = bounds {
        for (axis, (from, to)) in periodic.iter().enumerate().filter_map(|(axis, b)| Some((axis, (*b)?))) {
            (low[axis], high[axis]) = (from, to);
        }
        restart.domain = Domain::new(low, high, periodic.map(|b| b.is_some())).ok();
    }
    if let Some(domain) = restart.domain {
        restart.particles = restart.particles.with_domain(domain);
    }
    restart.particles = restart.particles.at(None, restart.time);
    Ok(restart)
}

/// The `count` entries of a section that have the word `key`.
fn section_of<T>(
    lines: &mut LineReader,
    count: u64,
    key: &str,
    parse: impl Fn(&Entry) -> Result<T, String>,
) -> Result<Vec<T>, IoError> {
    let mut found = Vec::new();
    let mut seen = 0;
    while seen < count {
        if !lines.advance()? {
            let message = format!("the file ends after {seen} of {count} entries of a section");
            return Err(lines.error(message, "the file is cut, or still being written"));
        }
        let entry = Entry::new(lines);
        // Mixed species follow their species without being counted, and large objects take several lines.
        if !key.is_empty() && entry.word(key).is_none() {
            if entry.words.len() == 2 && integer(entry.words[1]).is_some() {
                let message = format!("'{}' stands where entry {seen} of {count} is expected", shown(lines.line()));
                return Err(lines.error(message, "the section is incomplete: write the file again"));
            }
            continue;
        }
        found.push(parse(&entry).map_err(|reason| lines.error(reason, "correct the line, or write the file again"))?);
        seen += 1;
    }
    Ok(found)
}

fn needed<T>(value: Option<T>, what: &str) -> Result<T, String> {
    value.ok_or_else(|| format!("the entry has no valid '{what}'"))
}

fn species(entry: &Entry) -> Result<MercurySpecies, String> {
    let id = needed(entry.word("id").and_then(integer), "id")?;
    let [density] = needed(entry.numbers("density"), "density")?;
    Ok(MercurySpecies { id, kind: entry.kind(), density, line: entry.line })
}

fn wall(entry: &Entry) -> Result<MercuryWall, String> {
    Ok(MercuryWall {
        id: needed(entry.word("id").and_then(integer), "id")?,
        kind: entry.kind(),
        species: needed(entry.word("indSpecies").and_then(integer), "indSpecies")?,
        position: needed(entry.numbers("position"), "position")?,
    })
}

enum Boundary {
    Periodic { axis: usize, from: f64, to: f64 },
    Other(String),
}

fn boundary(entry: &Entry) -> Result<Boundary, String> {
    if entry.kind() != "PeriodicBoundary" {
        return Ok(Boundary::Other(entry.kind()));
    }
    let normal: [f64; 3] = needed(entry.numbers("normal"), "normal")?;
    let bound = |new, old| entry.numbers(new).or_else(|| entry.numbers(old)).map(|[distance]| distance);
    let from: f64 = needed(bound("distanceLeft", "pos_left"), "distanceLeft")?;
    let to: f64 = needed(bound("distanceRight", "pos_right"), "distanceRight")?;
    let along: Vec<usize> = (0..3).filter(|&axis| normal[axis] != 0.0).collect();
    match along.as_slice() {
        &[axis] => {
            // Distances are along the normal, which may point backwards.
            let (from, to) = (from * normal[axis].signum(), to * normal[axis].signum());
            Ok(Boundary::Periodic { axis, from: from.min(to), to: from.max(to) })
        }
        _ => Ok(Boundary::Other("PeriodicBoundary along no axis".into())),
    }
}

struct ParticleEntry {
    id: i64,
    species: i64,
    radius: f64,
    inverse_mass: Option<f64>,
    position: [f64; 3],
    /// Velocity, angular velocity, force, torque.
    vectors: [[f64; 3]; 4],
}

const VECTORS: [(&str, &str); 4] =
    [("velocity", "velocity"), ("angularVelocity", "angular_velocity"), ("force", "force"), ("torque", "torque")];

fn particle(entry: &Entry) -> Result<ParticleEntry, String> {
    let kind = entry.kind();
    if kind.starts_with("SuperQuadric") || kind.starts_with("Nonspherical") {
        return Err(format!("the particle is a {kind}, not a sphere"));
    }
    let mut vectors = [[0.0; 3]; 4];
    for (vector, (key, _)) in vectors.iter_mut().zip(VECTORS) {
        *vector = needed(entry.numbers(key), key)?;
    }
    Ok(ParticleEntry {
        id: needed(entry.word("id").and_then(integer), "id")?,
        species: needed(entry.word("indSpecies").and_then(integer), "indSpecies")?,
        radius: needed(entry.numbers("radius"), "radius").map(|[radius]| radius)?,
        inverse_mass: entry.numbers("invMass").map(|[value]| value),
        position: needed(entry.numbers("position"), "position")?,
        vectors,
    })
}

fn build(path: &Path, rows: Vec<ParticleEntry>, restart: &MercuryRestart) -> Result<Particles, IoError> {
    let wrong = |source: ParticlesError| IoError::Particles { path: path.into(), source };
    let types: Vec<i64> = rows.iter().map(|row| row.species).collect();
    let mut particles = Particles::new(rows.iter().map(|row| row.position).collect())
        .and_then(|p| p.with_radii(rows.iter().map(|row| row.radius).collect()))
        .and_then(|p| p.with_ids(rows.iter().map(|row| row.id).collect()))
        .and_then(|p| p.with_types(types))
        .map_err(wrong)?;
    for (k, (_, name)) in VECTORS.into_iter().enumerate() {
        let data = rows.iter().flat_map(|row| row.vectors[k]).collect();
        particles = particles.with_quantity(Quantity { name: name.into(), components: 3, data }).map_err(wrong)?;
    }
    particles = restart.complete(particles)?;
    let by_density = particles.quantity("mass").map_err(wrong)?.data.clone();
    let masses = rows.iter().zip(by_density).map(|(row, mass)| match row.inverse_mass {
        Some(inverse) if inverse > 0.0 => inverse.recip(),
        _ => mass,
    });
    let quantity = Quantity { name: "mass".into(), components: 1, data: masses.collect() };
    particles.with_quantity(quantity).map_err(wrong)
}
