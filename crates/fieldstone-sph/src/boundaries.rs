use fieldstone_surface::Wall;

use crate::body::Body;
use crate::error::check;
use crate::{FluidOptions, Parameter, SphError};

/// What a wall does to the flow along it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slip {
    /// The flow slides: no friction.
    Free,
    /// The flow sticks: ghosts reverse the tangential velocity in the viscous term.
    No,
}

/// A plane that mirrors the fluid; the fluid is where `normal · x > offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MirrorWall {
    /// The plane.
    pub plane: Wall,
    /// Friction.
    pub slip: Slip,
}

/// Everything around the fluid.
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | `low`, `high` | the domain, a box | length |
/// | `periodic` | directions in which the domain repeats itself | – |
/// | `open` | lower and upper faces through which particles may leave; they are removed and counted | – |
/// | `walls` | mirror planes, at right angles to each other where they meet | – |
/// | `bodies` | solid bodies, at rest or in a prescribed motion, made of ghost particles; not repeated by a period | – |
///
/// A particle beyond a face that is neither periodic nor open, by more than `padding`, stops the run.
#[derive(Debug, Clone, PartialEq)]
pub struct Boundaries {
    /// Lower corner.
    pub low: [f64; 3],
    /// Upper corner.
    pub high: [f64; 3],
    /// Periodic directions.
    pub periodic: [bool; 3],
    /// Open faces: lower and upper, per axis.
    pub open: [[bool; 2]; 3],
    /// Mirror planes.
    pub walls: Vec<MirrorWall>,
    /// Bodies.
    pub bodies: Vec<Body>,
    /// How far beyond the domain a particle may go before the run stops.
    pub padding: f64,
}

impl Boundaries {
    /// A domain without walls or bodies, closed on all sides; particles may go one spacing beyond it.
    pub fn new(low: [f64; 3], high: [f64; 3], spacing: f64) -> Self {
        Self {
            low,
            high,
            periodic: [false; 3],
            open: [[false; 2]; 3],
            walls: Vec::new(),
            bodies: Vec::new(),
            padding: spacing,
        }
    }

    /// The part of gravity that pressure at rest and levels hang on: none of it along periodic axes, where it drives a flow and what is
    /// at one end is at the other, too.
    pub(crate) fn levelling(&self, gravity: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| if self.periodic[k] { 0.0 } else { gravity[k] })
    }

    /// Checks the domain, and that no two boundaries are closer than `reach`.
    ///
    /// # Errors
    /// [`SphError::Option`], [`SphError::TooNarrow`], [`SphError::SameSide`], [`SphError::ThinBody`],
    /// [`SphError::CutBody`], [`SphError::Overlapping`].
    pub fn validate(&self, fluid: &FluidOptions, reach: f64) -> Result<(), SphError> {
        for axis in 0..fluid.dimension {
            let length = self.high[axis] - self.low[axis];
            check(Parameter::DomainEdge, length, length > 0.0 && length.is_finite(), "finite and above 0")?;
            if self.periodic[axis] && length < reach {
                let what = format!("the periodic faces along {}", ['x', 'y', 'z'][axis]);
                return Err(SphError::TooNarrow { what, distance: length, reach });
            }
        }
        for (a, first) in self.walls.iter().enumerate() {
            for axis in (0..fluid.dimension).filter(|&k| self.periodic[k]) {
                // Its images by a period would be other walls.
                let part = first.plane.normal()[axis];
                check(Parameter::NormalAlongPeriod, part, part.abs() < 1e-9, "0: such walls do not repeat")?;
            }
            for (b, second) in self.walls.iter().enumerate().skip(a + 1) {
                let (n, m) = (first.plane.normal(), second.plane.normal());
                let cosine: f64 = (0..3).map(|k| n[k] * m[k]).sum();
                let distance = -first.plane.offset() - second.plane.offset();
                if cosine < -1.0 + 1e-9 && distance < reach {
                    return Err(SphError::TooNarrow { what: format!("walls {a} and {b}"), distance, reach });
                }
                if cosine > 1.0 - 1e-9 {
                    return Err(SphError::SameSide { first: a, second: b });
                }
                let square = cosine.abs() < 1e-9 || cosine.abs() > 1.0 - 1e-9;
                // Mirror images close up around an edge for right angles only.
                check(Parameter::CosineOfWalls, cosine, square, "0, 1 or −1: mirror walls meet at right angles")?;
            }
        }
        self.bodies.iter().enumerate().try_for_each(|(index, body)| body.validate(index, fluid))?;
        self.check_repeats(fluid, 0.0)?;
        for (second, body) in self.bodies.iter().enumerate() {
            for (first, other) in self.bodies[..second].iter().enumerate().filter(|(_, b)| !b.moves_with(body)) {
                if let Some(at) = other.common_place(body, fluid) {
                    return Err(SphError::Overlapping { first, second, at });
                }
            }
        }
        Ok(())
    }
}
