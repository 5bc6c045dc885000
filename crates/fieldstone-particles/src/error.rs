use thiserror::Error;

/// Why a particle set or a box cannot be built or used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ParticlesError {
    /// A column has another number of entries than there are particles.
    #[error(
        "column '{name}' has {found} values for {expected} particles; every column needs {components} per particle"
    )]
    ColumnLength {
        /// Name of the column.
        name: String,
        /// Values in the column.
        found: usize,
        /// Particles in the set.
        expected: usize,
        /// Components per particle.
        components: usize,
    },
    /// A position, radius or other number is NaN or infinite.
    #[error("particle {index} has {what} = {value}; only finite numbers are accepted")]
    NotFinite {
        /// Index of the particle in the set, from 0.
        index: usize,
        /// Which number it is.
        what: String,
        /// The number found.
        value: f64,
    },
    /// A radius is zero or negative.
    #[error("particle {index} has radius {value}; radii must be above 0")]
    Radius {
        /// Index of the particle in the set, from 0.
        index: usize,
        /// The radius found.
        value: f64,
    },
    /// The set has no radii but the task needs them.
    #[error(
        "the particles have no radius; give one for all of them (--radius or --diameter), or a file with a radius or diameter column"
    )]
    NoRadius,
    /// A column that the caller names does not exist.
    #[error("there is no column '{name}'; {}", listed(.available))]
    NoColumn {
        /// Name asked for.
        name: String,
        /// Names that exist, separated by commas.
        available: String,
    },
    /// A name that is spelt like no column, and like several in other letter case.
    #[error("'{name}' may be any of the columns {candidates}; write the one that is meant as it stands there")]
    AmbiguousColumn {
        /// Name asked for.
        name: String,
        /// Names that differ from it in letter case only, separated by commas.
        candidates: String,
    },
    /// A box has no extent in some direction.
    #[error("the box runs from {low} to {high} along {axis}; the upper bound must be above the lower one")]
    EmptyBox {
        /// Axis name, `x`, `y` or `z`.
        axis: char,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// A tilt factor of a box is NaN or infinite.
    #[error("the box has tilt {name} = {value}; only finite numbers are accepted")]
    Tilt {
        /// Which factor: `xy`, `xz` or `yz`.
        name: &'static str,
        /// The number found.
        value: f64,
    },
    /// A contact names a particle that the set does not have.
    #[error(
        "contact {index} names particle {particle}, but there are {particle_count}; give the contacts of the same frame"
    )]
    UnknownParticle {
        /// Index of the contact, from 0.
        index: usize,
        /// Particle index named.
        particle: u32,
        /// Particles in the set.
        particle_count: usize,
    },
    /// Both particles of a contact are the same one, and no periodic image lies between them.
    #[error("contact {index} is of particle {particle} with itself; check which columns hold the two particles")]
    SelfContact {
        /// Index of the contact, from 0.
        index: usize,
        /// The particle.
        particle: u32,
    },
    /// A force or vector of a contact is NaN or infinite.
    #[error("contact {index} has {what} {value}; only finite numbers are accepted")]
    ContactNotFinite {
        /// Index of the contact, from 0.
        index: usize,
        /// Which vector it is.
        what: &'static str,
        /// The number found.
        value: f64,
    },
    /// The reach of a neighbour search is no length.
    #[error("the reach of the neighbour search is {value}; it must be finite and above 0")]
    Reach {
        /// The reach given.
        value: f64,
    },
    /// A number of dimensions other than 2 and 3.
    #[error("{value} dimensions are not supported; choose 2 or 3")]
    Dimension {
        /// The number given.
        value: usize,
    },
    /// The reach of a neighbour search spans a periodic box several times.
    #[error(
        "the neighbour search reaches {reach}, but the periodic box is only {length} long along {axis}; at most 4 box lengths are allowed: check the units"
    )]
    ReachBeyondBox {
        /// The reach given.
        reach: f64,
        /// Axis name, `x`, `y` or `z`.
        axis: char,
        /// Length of the box.
        length: f64,
    },
    /// Neighbours are asked for farther away than the search was built for.
    #[error(
        "neighbours within {radius} are asked for, but the search was built for {reach}; build it for the largest radius"
    )]
    BeyondReach {
        /// The radius asked for.
        radius: f64,
        /// The reach of the search.
        reach: f64,
    },
    /// An index beyond the last particle.
    #[error("there is no particle {index}: there are {particle_count}, counted from 0")]
    UnknownIndex {
        /// The index.
        index: usize,
        /// Particles in the set.
        particle_count: usize,
    },
    /// More points than an index of 32 bits can tell apart.
    #[error(
        "{count} points, periodic and mirror images included, are too many for one neighbour search (at most 4294967294)"
    )]
    TooMany {
        /// Points.
        count: usize,
    },
}

/// The columns that there are, as part of a sentence.
fn listed(available: &str) -> String {
    match available {
        "" => "the particles have no columns that could be named".into(),
        _ => format!("the particles have: {available}"),
    }
}
