use fieldstone_io::IoError;
use fieldstone_particles::ParticlesError;
use fieldstone_surface::SurfaceError;
use thiserror::Error;

use crate::Parameter;

/// Why a flow cannot be set up, or why a run had to stop.
#[derive(Debug, Error)]
pub enum SphError {
    /// A parameter is outside its range.
    #[error("{parameter} is {value}; it must be {allowed}")]
    Option {
        /// Which one.
        parameter: Parameter,
        /// Its value.
        value: f64,
        /// The values that are accepted.
        allowed: &'static str,
    },
    /// The viscous factor of the time step lets the fastest decay of velocities grow instead.
    #[error(
        "the viscous factor of the time step is {given}; it must be at most {limit:.4}, beyond which differences between neighbours grow with this integrator and kernel: leave it out for {default:.4}, or lessen it"
    )]
    ViscousStep {
        /// The factor given.
        given: f64,
        /// The largest stable one, on the lattice.
        limit: f64,
        /// What it is where it is left out.
        default: f64,
    },
    /// Eq. 3: the speed of sound is too small for the expected flow, so the fluid would be compressible.
    #[error(
        "the speed of sound is {given}; for {cause} it must be at least {needed:.6} (Eq. 3: 10 max(√(p/ρ), U)); raise it, or the expected value is wrong"
    )]
    SoundSpeed {
        /// The speed given.
        given: f64,
        /// The lower bound.
        needed: f64,
        /// Which expected value demands it.
        cause: String,
    },
    /// Two columns of a particle set differ in length.
    #[error("{name} has {found} entries for {expected} particles; one per particle is needed")]
    Length {
        /// Which column.
        name: &'static str,
        /// Its entries.
        found: usize,
        /// Particles.
        expected: usize,
    },
    /// Two walls, or two periodic faces, are closer than the kernel reaches.
    #[error(
        "{what} are {distance:.6} apart, but the kernel with the neighbour list's margin reaches {reach:.6}; move them apart or lessen the spacing"
    )]
    TooNarrow {
        /// Which boundaries.
        what: String,
        /// Their distance.
        distance: f64,
        /// Reach of the kernel, with the margin of the neighbour list.
        reach: f64,
    },
    /// Two mirror walls bound the fluid on the same side: each would mirror what the other has mirrored.
    #[error(
        "walls {first} and {second} face the same way; one mirror wall may bound the fluid on a side: list the planes one by one instead of a tank and a plane"
    )]
    SameSide {
        /// Index of a wall, from 0; a tank counts as one for each of its sides.
        first: usize,
        /// Index of the other.
        second: usize,
    },
    /// A body is too thin for its ghost particles: fluid on one side would feel fluid on the other.
    #[error(
        "body {body} is {thickness:.6} thick along {axis}; it must be at least 4 spacings, {needed:.6}, or the fluid on one side feels the other"
    )]
    ThinBody {
        /// Index of the body, from 0.
        body: usize,
        /// Its least extent.
        thickness: f64,
        /// Along which axis.
        axis: char,
        /// What is needed.
        needed: f64,
    },
    /// A body at a periodic face that neither goes through the domain nor is given on both sides of the face.
    #[error(
        "body {body} reaches from {first} to {last} along {axis}, which is periodic from {low} to {high}, and bodies are not repeated: the fluid would miss what is across the face; keep it {reach} (the kernel's reach, 2h) away from both faces, let it go beyond both by as much, or give it a second time, shifted by {shift}"
    )]
    CutBody {
        /// Index of the body, from 0.
        body: usize,
        /// Which axis.
        axis: char,
        /// Where it begins, with its displacements.
        first: f64,
        /// Where it ends.
        last: f64,
        /// The lower face.
        low: f64,
        /// The upper face.
        high: f64,
        /// The kernel's reach.
        reach: f64,
        /// Where another would have to be.
        shift: f64,
    },
    /// Two bodies that do not move alike share a place at time 0: both would push the fluid there.
    #[error(
        "bodies {first} and {second} overlap at {at:?} and do not move alike; only bodies at rest, or with the same motion, may overlap: move one of them"
    )]
    Overlapping {
        /// Index of a body, from 0.
        first: usize,
        /// Index of the other.
        second: usize,
        /// A place in both.
        at: [f64; 3],
    },
    /// A surface of triangles bounds no solid.
    #[error("{message}")]
    NoSolid {
        /// What is wrong and what to do.
        message: String,
    },
    /// A body bounded by triangles is somewhere too thin for its ghost particles.
    #[error(
        "body {body} is a plate or a sharp wedge {thickness:.6} thick at {at:?}, without its displacement; it must be at least 4 spacings, {needed:.6}, or the fluid on one side feels the other: lessen the spacing or thicken the body"
    )]
    ThinSurface {
        /// Index of the body, from 0.
        body: usize,
        /// Its thickness there.
        thickness: f64,
        /// Where on its surface.
        at: [f64; 3],
        /// What is needed.
        needed: f64,
    },
    /// A table of a body's motion is none.
    #[error("row {row} of the motion: {message}")]
    Motion {
        /// Row of the table, from 1.
        row: usize,
        /// What is wrong and what is possible.
        message: String,
    },
    /// A particle's state is not a number any more, or its density is not positive.
    #[error(
        "step {step}, time {time:.6}: particle {id} at {position:?} has {what}; lessen the time step (cfl), or look at the flow before that"
    )]
    Broken {
        /// Number of the step that ended so.
        step: u64,
        /// Time after it.
        time: f64,
        /// Number of the particle, from 0.
        id: u32,
        /// Where it is.
        position: [f64; 3],
        /// What is wrong.
        what: String,
    },
    /// A particle has left the domain where there is no opening.
    #[error(
        "step {step}, time {time:.6}: particle {id} has left the domain at {position:?} with velocity {velocity:?}; {remedy}"
    )]
    Lost {
        /// Number of the step.
        step: u64,
        /// Time after it.
        time: f64,
        /// Number of the particle, from 0.
        id: u32,
        /// Where it is.
        position: [f64; 3],
        /// Its velocity.
        velocity: [f64; 3],
        /// What to do, by the face that it has passed.
        remedy: &'static str,
    },
    /// A case file, or a file that it names, does not say what it must.
    #[error("{file}:{line}: {message}")]
    Case {
        /// Name of the file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong and what is possible.
        message: String,
    },
    /// A checkpoint is damaged or belongs to another case.
    #[error("{file}: {message}")]
    Checkpoint {
        /// The file.
        file: String,
        /// What is wrong and what to do.
        message: String,
    },
    /// The particles, or the neighbour search.
    #[error(transparent)]
    Particles(#[from] ParticlesError),
    /// The free-surface detection.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A file.
    #[error(transparent)]
    Io(#[from] IoError),
}

pub(crate) fn check(parameter: Parameter, value: f64, ok: bool, allowed: &'static str) -> Result<(), SphError> {
    if ok { Ok(()) } else { Err(SphError::Option { parameter, value, allowed }) }
}
