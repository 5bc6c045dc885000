//! A case that is checked and laid out, once for all that is asked of it.

use super::Case;
use crate::{Flow, Shape, Solver, SphError, State};

/// A case's flow and the particles that it begins with: what a run starts from, and what a first look at a case tells of.
///
/// ```
/// # use fieldstone_sph::SHIPPED;
/// let case = SHIPPED.iter().find(|case| case.name == "hydrostatic").expect("a shipped case").at_spacing(None)?;
/// let prepared = case.prepare()?;
/// assert_eq!((prepared.flow().fluid.spacing, prepared.state().len()), (0.025, 40 * 20));
/// let mut solver = prepared.solver()?;
/// assert!(solver.step()? > 0.0);
/// # Ok::<(), fieldstone_sph::SphError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Prepared<'a> {
    pub(crate) case: &'a Case,
    pub(crate) flow: Flow,
    pub(crate) state: State,
}

impl Prepared<'_> {
    /// Fluid, boundaries and options.
    pub fn flow(&self) -> &Flow {
        &self.flow
    }

    /// The particles at the start.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// A solver at time 0.
    ///
    /// # Errors
    /// As [`Solver::new`], but for what the case was checked for already.
    pub fn solver(self) -> Result<Solver, SphError> {
        Solver::of_checked(self.flow, self.state)
    }
}

impl Case {
    /// Checks the case and lays out its particles.
    ///
    /// # Errors
    /// As [`flow`](Self::flow) and [`state`](Self::state).
    pub fn prepare(&self) -> Result<Prepared<'_>, SphError> {
        let flow = self.flow()?;
        let state = self.laid_out(&flow)?;
        Ok(Prepared { case: self, flow, state })
    }

    /// The particles at the start: each fill's lattice, without what lies in bodies or behind walls.
    ///
    /// # Errors
    /// [`SphError::Case`]: two fills overlap, a fill leaves the domain, nothing is filled, a fill begins with a pressure or speed
    /// for which the fluid would be too compressible, or a gauge of pressure is in a body or behind a wall.
    pub fn state(&self) -> Result<State, SphError> {
        Ok(self.prepare()?.state)
    }

    /// A solver at time 0.
    ///
    /// # Errors
    /// As [`flow`](Self::flow) and [`state`](Self::state).
    pub fn solver(&self) -> Result<Solver, SphError> {
        self.prepare()?.solver()
    }

    fn laid_out(&self, flow: &Flow) -> Result<State, SphError> {
        let s = &self.sections;
        let mut state = State::default();
        let mut shapes: Vec<Shape> = Vec::new();
        for (nth, fill) in s.fill.iter().enumerate() {
            let shape = self.shape("fill", nth, &fill.keys())?;
            let (points, _) = shape.lattice(s.spacing, s.dimension);
            let bounds = shape.bounds();
            self.check_gravity(nth, bounds, flow)?;
            let levelling = flow.boundaries.levelling(flow.fluid.gravity);
            let before = state.len();
            for x in points {
                if flow.boundaries.bodies.iter().any(|b| b.contains(x, 0.0, s.dimension)) {
                    continue;
                }
                if (0..s.dimension).any(|k| x[k] < flow.boundaries.low[k] || x[k] > flow.boundaries.high[k]) {
                    let message = format!("the fill leaves the domain at {x:?}; enlarge one or shrink the other");
                    return Err(self.fault("fill", nth, "shape", message));
                }
                if flow.boundaries.walls.iter().any(|w| w.plane.distance(x) < 0.0) {
                    continue;
                }
                if let Some(other) = shapes.iter().position(|s2| s2.contains(x, s.dimension)) {
                    let message = format!("this fill overlaps fill {other} at {x:?}; move one of them");
                    return Err(self.fault("fill", nth, "shape", message));
                }
                let (velocity, pressure) = fill.initial(x, bounds, self.up(), &flow.fluid, levelling);
                state.x.push(x);
                state.u.push(velocity);
                state.density.push(flow.fluid.density_at(pressure));
            }
            self.check_start(nth, &flow.fluid, &state, before)?;
            shapes.push(shape);
        }
        if state.x.is_empty() {
            let message = "nothing is filled: the shapes are smaller than the spacing, or all in bodies or behind walls; a \
                           wall's normal points into the fluid";
            return Err(self.fault("fill", 0, "shape", message));
        }
        // Where all lies behind a wall, that is what is wrong, not a gauge there.
        self.check_gauges_in_fluid(flow)?;
        state.id = (0..state.x.len() as u32).collect();
        Ok(state)
    }
}
