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
    #[error("there is no column '{name}'; the particles have: {available}")]
    NoColumn {
        /// Name asked for.
        name: String,
        /// Names that exist, separated by commas.
        available: String,
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
}
