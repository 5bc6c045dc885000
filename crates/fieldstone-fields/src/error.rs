use fieldstone_geometry::BallError;
use fieldstone_particles::ParticlesError;
use thiserror::Error;

/// Why fields cannot be computed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FieldsError {
    /// The particles lack what the task needs.
    #[error(transparent)]
    Particles(#[from] ParticlesError),
    /// A particle is no ball.
    #[error("particle {particle}: {source}")]
    Ball {
        /// Index of the particle, from 0.
        particle: usize,
        /// The reason.
        source: BallError,
    },
    /// The volume of a particle, or the sum over all of them, is beyond 64-bit floats.
    #[error(
        "particle {particle} has radius {radius:e}; radii must be between 1e-100 and 1e100 for their volumes to be numbers"
    )]
    RadiusRange {
        /// Index of the particle, from 0.
        particle: usize,
        /// Its radius.
        radius: f64,
    },
    /// A cell cannot be decomposed.
    #[error("cell {cell}: {source}")]
    Decomposition {
        /// The cell.
        cell: usize,
        /// The reason.
        source: fieldstone_geometry::decomposition::DecompositionElementError,
    },
    /// A particle is much larger than the periodic box that it is to be repeated in.
    #[error(
        "particle {particle} has radius {radius}, but the periodic box is only {length} long; check units, or switch the images off (--periodic none)"
    )]
    RadiusBox {
        /// Index of the particle, from 0.
        particle: usize,
        /// Its radius.
        radius: f64,
        /// Shortest periodic length of the box.
        length: f64,
    },
    /// A method's name is not known.
    #[error(
        "there is no method '{0}'; choose one of kernel, kernel-f64, decomposition, centre, centre-smoothed, cube, divided, sampled:N, monte-carlo:N with N from 1 to 10000000"
    )]
    UnknownMethod(String),
    /// No particle reaches any cell.
    #[error("none of the {particles} particles lies in the mesh: the particles span ({}, {}, {}) to ({}, {}, {}), the mesh ({}, {}, {}) to ({}, {}, {}); check units and coordinate systems",
        particle_low[0], particle_low[1], particle_low[2], particle_high[0], particle_high[1], particle_high[2],
        mesh_low[0], mesh_low[1], mesh_low[2], mesh_high[0], mesh_high[1], mesh_high[2])]
    NothingInside {
        /// Number of particles.
        particles: usize,
        /// Lower corner of the particles' bounding box.
        particle_low: [f64; 3],
        /// Upper corner of the particles' bounding box.
        particle_high: [f64; 3],
        /// Lower corner of the mesh's bounding box.
        mesh_low: [f64; 3],
        /// Upper corner of the mesh's bounding box.
        mesh_high: [f64; 3],
    },
    /// A parcel weight is not usable.
    #[error("particle {particle} has parcel weight {value:?}; weights must be between 0 and 1e100")]
    ParcelWeight {
        /// Index of the particle, from 0.
        particle: usize,
        /// The weight.
        value: f64,
    },
    /// A list that goes with the particles or cells has another length.
    #[error("{found} values were given for {expected} {what}")]
    Length {
        /// What the values belong to.
        what: &'static str,
        /// Values given.
        found: usize,
        /// Values needed.
        expected: usize,
    },
    /// An option is out of range.
    #[error("{name} is {value}; it must be {allowed}")]
    Option {
        /// Name of the option.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The range.
        allowed: &'static str,
    },
    /// The smoothing length needs more steps than are sensible.
    #[error(
        "smoothing over {length} would take {steps} steps on this mesh, because its smallest cells are much smaller; give a length below {longest:.3e}"
    )]
    SmoothingLength {
        /// Length asked for.
        length: f64,
        /// Steps that it would take.
        steps: f64,
        /// Longest length that is accepted on this mesh.
        longest: f64,
    },
}
