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
    /// The cells, or the reach of particles, kernels and branches around them, are so much larger than the periodic box
    /// that its copies there are too many to go through.
    #[error(
        "{copies:.1e} copies of the periodic box are within reach of the cells, and at most 1e5 are gone through; check units (and the width of a kernel), or switch the images off (--periodic none)"
    )]
    BoxCopies {
        /// Copies within reach of the cells.
        copies: f64,
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
    /// A kernel's name is not known.
    #[error("there is no kernel '{0}'; choose one of gauss, lucy, heaviside, linear")]
    UnknownKernel(String),
    /// A field's name is not known.
    #[error("there is no field '{name}'; choose standard, binning, all, or a list of: {known}")]
    UnknownField {
        /// Name asked for.
        name: String,
        /// Names that there are.
        known: String,
    },
    /// Two fields would have the same name, or one has none.
    #[error("the name '{0}' of a quantity is empty or that of another field; give each its own name")]
    DuplicateField(String),
    /// Options that do not go together.
    #[error("{what}")]
    Combination {
        /// What does not go together, and what to choose.
        what: &'static str,
    },
    /// A column has another number of components than its meaning needs.
    #[error("column '{name}' has {found} components per particle; {expected} are needed")]
    Components {
        /// Name of the column.
        name: String,
        /// Components found.
        found: usize,
        /// Components needed.
        expected: usize,
    },
    /// Neither masses nor densities are known.
    #[error(
        "the particles have neither a column 'mass' nor 'density' (they have: {available}); give a density for all of them (--density)"
    )]
    NoMass {
        /// Columns that there are.
        available: String,
    },
    /// A mass is not usable.
    #[error(
        "particle {particle}: the column '{column}' holds {value:?}; masses must be positive and finite: correct the file, or give a density for all particles (--density)"
    )]
    Mass {
        /// Index of the particle, from 0.
        particle: usize,
        /// The column that the mass comes from.
        column: &'static str,
        /// What it holds.
        value: f64,
    },
    /// Particles are to be selected by type, but have none.
    #[error("the particles have no types to select by; give a file with a type or species column")]
    NoTypes,
    /// A range ends before it begins.
    #[error("{name} from {low} to {high}: nothing lies between; give the smaller number first")]
    Reversed {
        /// What the range is of.
        name: &'static str,
        /// Where it begins.
        low: f64,
        /// Where it ends.
        high: f64,
    },
    /// Fields of contacts were asked for without contacts.
    #[error("field '{0}' needs contacts; give a file of them (--contacts), or leave the field out")]
    NoContacts(&'static str),
    /// No frame was given, or none with a weight.
    #[error("no frame was given, or all of them have weight 0; add a frame with a weight above 0")]
    NoFrames,
}
