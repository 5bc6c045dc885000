use fieldstone_particles::ParticlesError;
use thiserror::Error;

/// Why free-surface particles cannot be detected.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SurfaceError {
    /// The particles, the box or the neighbour search.
    #[error(transparent)]
    Particles(#[from] ParticlesError),
    /// A parameter is outside its range.
    #[error("{name} is {value}; it must be {allowed}")]
    Option {
        /// What the parameter is.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The values that are accepted.
        allowed: &'static str,
    },
    /// A column has another length than there are particles.
    #[error("{name} has {found} entries for {expected} particles; one per particle is needed")]
    Length {
        /// Which column.
        name: &'static str,
        /// Its entries.
        found: usize,
        /// Particles.
        expected: usize,
    },
    /// A volume is negative or not a number.
    #[error("particle {particle} has volume {value}; m/ρ must be finite and above 0")]
    Volume {
        /// Index of the particle, from 0.
        particle: usize,
        /// The volume found.
        value: f64,
    },
    /// The method exists in the other number of dimensions only.
    #[error(
        "the {method} method exists in {supported} dimensions only, not in {dimension}; choose another method or dimension"
    )]
    Dimension {
        /// Name of the method.
        method: &'static str,
        /// Dimensions asked for.
        dimension: usize,
        /// Dimensions it exists in.
        supported: usize,
    },
    /// No method has this name.
    #[error("'{name}' is no detection method; choose one of {known}")]
    UnknownMethod {
        /// Name asked for.
        name: String,
        /// Names that there are.
        known: String,
    },
    /// The neighbour search was built for a smaller radius than the method looks at.
    #[error(
        "the {method} method looks at neighbours within {needed}, but the neighbour search reaches {reach}; build it for that"
    )]
    Reach {
        /// Name of the method.
        method: &'static str,
        /// Radius that the method needs.
        needed: f64,
        /// Reach of the neighbour search.
        reach: f64,
    },
}
