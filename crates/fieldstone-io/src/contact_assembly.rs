//! Contacts resolved against the particles of their frame: indices instead of ids, vectors instead of positions.

use std::path::Path;

use fieldstone_particles::{Contact, Contacts, Particles, ParticlesError, Partner};
use rayon::prelude::*;

use crate::{IoError, Position};

/// Rows that one task places, as a power of two.
const PART: u32 = 12;

/// Mirrored lines whose forces agree to this part of the force are one contact seen from its two sides.
const MIRRORED: f64 = 1e-6;

/// Pairs are listed twice where at most one in so many has no line from its other side.
const LACKING: usize = 10;

/// What was found, and the remedy: an error that does not know its file and line yet.
pub(crate) type Refusal = (String, String);

/// Where the bodies of a contact touch.
struct Placed {
    arm: [f64; 3],
    branch: [f64; 3],
    /// Whether the branch leads to the partner or an image of it.
    on_lattice: bool,
}

/// What a source says of where two bodies touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Touch {
    /// Nothing: the spheres' radii decide.
    Spheres,
    /// By how much the spheres overlap.
    Overlap(f64),
    /// The point, in whichever periodic image.
    Point([f64; 3]),
    /// From the particle's centre to the point, and to about the partner's centre.
    Vectors { arm: [f64; 3], branch: [f64; 3] },
}

/// A contact as its source states it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row {
    pub(crate) particle: u32,
    pub(crate) partner: Partner,
    pub(crate) force: [f64; 3],
    /// The normal part of the force, where the source tells it apart.
    pub(crate) normal_force: Option<[f64; 3]>,
    pub(crate) touch: Touch,
    /// Line in the file, from 1.
    pub(crate) line: u64,
}

/// Rows of one frame, to become [`Contacts`].
pub(crate) struct ContactAssembly<'a> {
    particles: &'a Particles,
    path: &'a Path,
    /// In the order of the file, in as many lists as they were read in.
    rows: Vec<Vec<Row>>,
}

/// Contacts of some rows.
#[derive(Default)]
struct Part {
    /// Each with the line that it comes from.
    contacts: Vec<(Contact, u64)>,
    distant: usize,
    oblique: usize,
    unaligned: usize,
    /// What is wrong with the row after the contacts.
    failure: Option<IoError>,
}

impl<'a> ContactAssembly<'a> {
    pub(crate) fn new(particles: &'a Particles, path: &'a Path) -> Self {
        Self { particles, path, rows: Vec::new() }
    }

    pub(crate) fn push(&mut self, row: Row) {
        match self.rows.last_mut() {
            Some(rows) => rows.push(row),
            None => self.rows.push(vec![row]),
        }
    }

    /// Adds rows that were read in several lists.
    pub(crate) fn append(&mut self, rows: Vec<Vec<Row>>) {
        self.rows.extend(rows);
    }

    /// The contacts, and what the user should know about them.
    pub(crate) fn finish(self) -> Result<(Contacts, Vec<String>), IoError> {
        let rows: Vec<&[Row]> = self.rows.iter().flat_map(|rows| rows.chunks(1 << PART)).collect();
        let (mirrored, mut warnings) = mirrored(&rows);
        let parts: Vec<Part> =
            rows.par_iter().zip(mirrored).map(|(rows, mirrored)| self.part(rows, &mirrored)).collect();
        let mut contacts = Contacts::new();
        let (mut distant, mut oblique, mut unaligned) = (0usize, 0usize, 0usize);
        for part in parts {
            for (contact, line) in part.contacts {
                contacts.push(self.particles.len(), contact).map_err(|e| self.at_line(line, self.refusal(e)))?;
            }
            part.failure.map_or(Ok(()), Err)?;
            distant += part.distant;
            oblique += part.oblique;
            unaligned += part.unaligned;
        }
        let total = contacts.len();
        if distant > 0 {
            warnings.push(format!(
                "{distant} of {total} contact points are more than 1.5 radii from the particle's centre: are these the \
                 contacts of the same frame, and the right columns?"
            ));
        }
        if oblique > 0 {
            warnings.push(format!(
                "{oblique} of {total} normal forces are not along the line of centres: are these the right columns?"
            ));
        }
        if unaligned > 0 {
            warnings.push(format!(
                "{unaligned} of {total} contacts have a normal that leads neither to the partner nor to an image of it: \
                 are these the contacts of the same frame?"
            ));
        }
        Ok((contacts, warnings))
    }

    /// What is wrong with a contact, in the names that the user knows: ids, not places in a list.
    fn refusal(&self, error: ParticlesError) -> Refusal {
        match (error, self.particles.ids()) {
            (ParticlesError::SelfContact { particle, .. }, ids) => {
                let id = ids.and_then(|ids| ids.get(particle as usize)).map_or(i64::from(particle), |&id| id);
                let found = format!("the contact is of particle {id} with itself");
                (found, "check which columns hold the two particles; else correct the row".into())
            }
            (error, _) => (error.to_string(), "correct the row, or write the file again".into()),
        }
    }

    fn at_line(&self, line: u64, (found, remedy): Refusal) -> IoError {
        IoError::content(self.path, Position::Line(line), found, remedy)
    }

    /// The contacts of those rows that are not mirrored, up to the first that is wrong.
    fn part(&self, rows: &[Row], mirrored: &[bool]) -> Part {
        let mut part = Part { contacts: Vec::with_capacity(rows.len()), ..Part::default() };
        for (row, _) in rows.iter().zip(mirrored).filter(|(_, mirrored)| !**mirrored) {
            let Placed { arm, branch, on_lattice } = match self.place(row) {
                Ok(placed) => placed,
                Err(refusal) => {
                    part.failure = Some(self.at_line(row.line, refusal));
                    break;
                }
            };
            part.unaligned += usize::from(!on_lattice);
            if let Ok(radii) = self.particles.radii() {
                part.distant += usize::from(length(arm) > 1.5 * radii[row.particle as usize]);
            }
            if let (Some(normal), Partner::Particle(_)) = (row.normal_force, row.partner) {
                part.oblique += usize::from(length(cross(normal, branch)) > 1e-3 * length(normal) * length(branch));
            }
            let contact = Contact { particle: row.particle, partner: row.partner, force: row.force, arm, branch };
            part.contacts.push((contact, row.line));
        }
        part
    }

    fn place(&self, row: &Row) -> Result<Placed, Refusal> {
        let positions = self.particles.positions();
        let nearest = |v: [f64; 3]| self.particles.domain().map_or(v, |domain| domain.minimum_image(v));
        // A point half a box away, where a particle touches its own image, stays on the side that the source says.
        let to_point = |point: [f64; 3], centre: [f64; 3]| {
            let (stated, shortest) = (difference(point, centre), nearest(difference(point, centre)));
            if length(stated) <= length(shortest) * (1.0 + 1e-9) { stated } else { shortest }
        };
        let centre = positions[row.particle as usize];
        let partner = match row.partner {
            Partner::Particle(partner) => partner as usize,
            Partner::Wall(_) => {
                let arm = match row.touch {
                    Touch::Point(point) => to_point(point, centre),
                    Touch::Vectors { arm, .. } => arm,
                    Touch::Spheres | Touch::Overlap(_) => {
                        let found = "a contact with a wall has no contact point".to_string();
                        return Err((found, "write the contact point of wall contacts (columns point)".into()));
                    }
                };
                return Ok(Placed { arm, branch: arm, on_lattice: true });
            }
        };
        let apart = difference(positions[partner], centre);
        let radii = self.particles.radii().ok().map(|radii| [radii[row.particle as usize], radii[partner]]);
        match row.touch {
            Touch::Point(point) => {
                let arm = to_point(point, centre);
                // The image of the partner that lies beyond the contact point. In a box of a few diameters it need
                // not be the one nearest to the particle.
                let factor = radii.map_or(2.0, |[own, other]| 1.0 + other / own);
                let beyond = arm.map(|a| factor * a);
                let rest = nearest(difference(apart, beyond));
                Ok(Placed { arm, branch: sum(beyond, rest), on_lattice: true })
            }
            Touch::Vectors { arm, branch } => {
                let rest = nearest(difference(apart, branch));
                let reach = length(branch);
                if length(rest) < 1e-3 * reach {
                    return Ok(Placed { arm, branch: sum(branch, rest), on_lattice: true });
                }
                // The source does not say which directions are periodic, but lengths of the box may tell.
                let on_lattice = self.particles.domain().is_some_and(|domain| {
                    let all = domain.with_periodic([true; 3]);
                    length(all.minimum_image(rest)) < 1e-3 * reach
                });
                Ok(Placed { arm, branch, on_lattice })
            }
            Touch::Overlap(_) | Touch::Spheres => {
                let branch = nearest(apart);
                let distance = length(branch);
                if distance == 0.0 {
                    let found =
                        "the centres of the two particles coincide, so the contact has no direction".to_string();
                    return Err((found, "check which columns hold the two particles".into()));
                }
                let along = match (row.touch, radii) {
                    (Touch::Overlap(overlap), Some([own, _])) => own - 0.5 * overlap,
                    (_, Some([own, other])) => 0.5 * (distance + own - other),
                    (_, None) => 0.5 * distance,
                };
                Ok(Placed { arm: branch.map(|b| along * (b / distance)), branch, on_lattice: true })
            }
        }
    }
}

/// Which rows are the mirror image of an earlier one, and what the user should know about them.
///
/// Some programs list each pair once, others twice, once from either side. A row (j, i) with the opposite force of
/// an earlier row (i, j) is the same contact. Where nearly every pair has rows of both kinds, the file lists pairs twice
/// even if some forces do not mirror each other, and the user is told by how much. Where some lack the other row, the
/// user is told how many.
///
/// Rows are given in parts of 2^[`PART`], but for shorter ones.
fn mirrored(rows: &[&[Row]]) -> (Vec<Vec<bool>>, Vec<String>) {
    // The rows of each pair, in their order in the file.
    let mut pairs: Vec<([u32; 2], u64)> = (rows.par_iter().enumerate())
        .flat_map_iter(|(part, rows)| {
            let key = move |(k, row): (usize, &Row)| Some((pair_of(row)?.0, (part << PART | k) as u64));
            rows.iter().enumerate().filter_map(key)
        })
        .collect();
    pairs.par_sort_unstable();
    let row = |at: u64| &rows[(at >> PART) as usize][(at & ((1 << PART) - 1)) as usize];
    let side = |at: u64| pair_of(row(at)).is_some_and(|(_, swapped)| swapped);
    let groups: Vec<&[([u32; 2], u64)]> = pairs.chunk_by(|a, b| a.0 == b.0).collect();
    let distinct = |group: &&&[([u32; 2], u64)]| group[0].0[0] != group[0].0[1];
    let both = |group: &[([u32; 2], u64)]| {
        let swapped = group.iter().filter(|(_, at)| side(*at)).count();
        swapped > 0 && swapped < group.len()
    };
    let all = groups.par_iter().filter(|group| distinct(group)).count();
    let from_both = groups.par_iter().filter(|group| distinct(group) && both(group)).count();
    let from_one = all - from_both;
    // A file that was cut lacks the other side of a few.
    let listed_twice = all > 0 && from_one <= all / LACKING;
    // Of each pair the rows that mirror an earlier one, and by how much they do not.
    let found: Vec<(u64, f64)> = groups
        .par_iter()
        .flat_map_iter(|group| {
            let own_image = group[0].0[0] == group[0].0[1];
            let mut free: Vec<u64> = Vec::new();
            let mut found = Vec::new();
            for &(_, at) in *group {
                let opposite = |other: &u64| own_image || side(*other) != side(at);
                let closest = (free.iter().enumerate())
                    .filter(|(_, other)| opposite(other))
                    .map(|(k, &other)| (mismatch(row(at), row(other)), k))
                    .min_by(|a, b| a.0.total_cmp(&b.0));
                match closest {
                    Some((mismatch, k)) if mismatch <= MIRRORED || (listed_twice && !own_image) => {
                        free.remove(k);
                        found.push((at, mismatch));
                    }
                    _ => free.push(at),
                }
            }
            found
        })
        .collect();
    let mut mirrored: Vec<Vec<bool>> = rows.iter().map(|rows| vec![false; rows.len()]).collect();
    let (mut different, mut largest) = (0usize, 0.0f64);
    for &(at, mismatch) in &found {
        mirrored[(at >> PART) as usize][(at & ((1 << PART) - 1)) as usize] = true;
        different += usize::from(mismatch > MIRRORED);
        largest = largest.max(mismatch);
    }
    let mut warnings = Vec::new();
    if !found.is_empty() {
        warnings.push(if listed_twice {
            "pairs are listed twice, once from either side: each is taken once".into()
        } else {
            format!("{} pairs are listed from both sides with mirrored forces: each is taken once", found.len())
        });
        if from_one > 0 && from_both > 0 {
            warnings.push(format!(
                "{from_one} of {all} pairs are listed from one side only: where the program lists every pair from both, the \
                 file is cut or damaged, and contacts may be missing; write it again, or leave this frame out"
            ));
        }
    }
    if different > 0 {
        warnings.push(format!(
            "the two lines of {different} pairs do not mirror each other, by up to {largest:.1e} of the force: the \
             first is taken"
        ));
    }
    (mirrored, warnings)
}

/// How far two forces are from being opposite, as a part of the larger.
fn mismatch(a: &Row, b: &Row) -> f64 {
    let scale = length(a.force).max(length(b.force));
    if scale == 0.0 { 0.0 } else { length(sum(a.force, b.force)) / scale }
}

/// The two particles of a pair in rising order, and whether the row has them the other way round.
fn pair_of(row: &Row) -> Option<([u32; 2], bool)> {
    let Partner::Particle(partner) = row.partner else { return None };
    let (low, high) = (row.particle.min(partner), row.particle.max(partner));
    Some(([low, high], row.particle > partner))
}

fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] + b[k])
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn cross(u: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

pub(crate) fn length([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}
