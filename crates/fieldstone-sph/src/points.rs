//! Fluid particles, the ghosts of bodies and images, in this order, with what the sums need of each.

use fieldstone_particles::{Image, ParticlesError};
use rayon::prelude::*;

use crate::cells::Cells;
use crate::ghosts::Ghosts;
use crate::neighbour_list::{CELLS_PER_REACH, NeighbourList};
use crate::spatial_order::spatial_order;
use crate::state::State;
use crate::{Boundaries, FluidOptions, Pose, Slip, SphError};

/// x, y, z, V, ρ, u, v, w of a point: one cache line.
pub(crate) type Carrier = [f64; 8];

/// Points per task when columns are filled.
const FILL: usize = 4096;

/// Ghosts of all bodies.
#[derive(Debug, Default)]
pub(crate) struct BodyGhosts {
    pub(crate) x: Vec<[f64; 3]>,
    pub(crate) volume: Vec<f64>,
    pub(crate) body: Vec<u32>,
    pub(crate) no_slip: Vec<bool>,
    /// Interpolated from the fluid in each stage.
    pub(crate) state: Vec<BodyState>,
    /// Of each body, at the time for which the ghosts were placed last.
    pub(crate) pose: Vec<Pose>,
    /// Ghosts without displacement; empty where no body moves.
    resting: Vec<[f64; 3]>,
    /// Unit vectors out of the body; empty where no body moves.
    outward: Vec<[f64; 3]>,
    /// Displacement of each body when the lists were built.
    listed: Vec<[f64; 3]>,
}

impl BodyGhosts {
    fn new(fluid: &FluidOptions, boundaries: &Boundaries) -> Self {
        let mut ghosts = Self::default();
        for (index, body) in boundaries.bodies.iter().enumerate() {
            let (mut points, volume) = body.ghosts(fluid);
            // What an earlier body covers has its ghosts: twice as many would push the fluid twice.
            let earlier = &boundaries.bodies[..index];
            points.retain(|&x| !earlier.iter().any(|b| b.moves_with(body) && b.shape.contains(x, fluid.dimension)));
            let points: Vec<_> = spatial_order(&points).into_iter().map(|i| points[i as usize]).collect();
            let count = ghosts.x.len() + points.len();
            ghosts.volume.resize(count, volume);
            ghosts.body.resize(count, index as u32);
            ghosts.no_slip.resize(count, body.slip == Slip::No);
            ghosts.x.extend(points);
        }
        let dry = BodyState { density: fluid.density, ..BodyState::default() };
        ghosts.state.resize(ghosts.x.len(), dry);
        ghosts.pose.resize(boundaries.bodies.len(), Pose::default());
        ghosts.listed.resize(boundaries.bodies.len(), [0.0; 3]);
        if boundaries.bodies.iter().any(|b| b.motion.is_some()) {
            ghosts.resting.clone_from(&ghosts.x);
            let outward =
                |(x, body): (&[f64; 3], &u32)| boundaries.bodies[*body as usize].shape.way_out(*x, fluid.dimension);
            ghosts.outward = ghosts.x.par_iter().zip(&ghosts.body).map(outward).collect();
        }
        ghosts.place(boundaries, 0.0);
        ghosts
    }

    /// Moves the ghosts to where their bodies are at a time: from where they rest, so that nothing adds up.
    pub(crate) fn place(&mut self, boundaries: &Boundaries, time: f64) {
        if self.resting.is_empty() {
            return;
        }
        for (pose, body) in self.pose.iter_mut().zip(&boundaries.bodies) {
            *pose = body.pose(time);
        }
        for ((x, resting), body) in self.x.iter_mut().zip(&self.resting).zip(&self.body) {
            let moved = self.pose[*body as usize].displacement;
            *x = std::array::from_fn(|k| resting[k] + moved[k]);
        }
    }

    /// Pose of the body that a ghost belongs to.
    pub(crate) fn pose_of(&self, ghost: usize) -> &Pose {
        &self.pose[self.body[ghost] as usize]
    }

    /// Acceleration of a ghost's body across the nearest face: along a face the fluid does not follow.
    pub(crate) fn acceleration_across(&self, ghost: usize) -> [f64; 3] {
        let Some(outward) = self.outward.get(ghost) else { return [0.0; 3] };
        let acceleration = self.pose_of(ghost).acceleration;
        let across: f64 = (0..3).map(|k| acceleration[k] * outward[k]).sum();
        outward.map(|n| across * n)
    }

    /// Farthest that a body has moved since the lists were built.
    pub(crate) fn moved(&self) -> f64 {
        let square = |(pose, listed): (&Pose, &[f64; 3])| {
            (0..3).map(|k| (pose.displacement[k] - listed[k]).powi(2)).sum::<f64>()
        };
        self.pose.iter().zip(&self.listed).map(square).fold(0.0, f64::max).sqrt()
    }
}

/// What a body's ghost takes over from the fluid.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct BodyState {
    pub(crate) density: f64,
    /// Of the fluid nearby.
    pub(crate) velocity: [f64; 3],
    pub(crate) gradient: [f64; 3],
    pub(crate) wet: bool,
}

/// What a point is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Fluid(usize),
    Body(usize),
    /// Index of the image.
    Image(usize),
}

/// The points and the lists of neighbours.
#[derive(Debug)]
pub(crate) struct Points {
    reach: f64,
    cells: Cells,
    pub(crate) ghosts: Ghosts,
    pub(crate) bodies: BodyGhosts,
    /// Lists of fluid particles and of the bodies' ghosts.
    pub(crate) fluid_list: NeighbourList,
    pub(crate) body_list: NeighbourList,
    pub(crate) carriers: Vec<Carrier>,
    /// ⟨∇ρ⟩ of Eq. 6.
    pub(crate) gradients: Vec<[f64; 4]>,
    /// Velocity in the viscous term and whether the point takes part in it; filled where walls or bodies need it.
    pub(crate) viscous: Vec<[f64; 4]>,
    pub(crate) needs_viscous: bool,
    /// Whether a point is a ghost of a wall or a body; images through periodic faces are fluid.
    solid: Vec<bool>,
    /// Fluid particles with such neighbours.
    pub(crate) beside: Vec<u32>,
    fluid_count: usize,
    positions: Vec<[f64; 3]>,
}

impl Points {
    pub(crate) fn new(fluid: &FluidOptions, boundaries: &Boundaries, reach: f64) -> Result<Self, SphError> {
        let rest = fluid.gravity.map(|g| fluid.density * g / (fluid.sound_speed * fluid.sound_speed));
        let bodies = BodyGhosts::new(fluid, boundaries);
        let needs_viscous = !bodies.x.is_empty() || boundaries.walls.iter().any(|w| w.slip == Slip::No);
        Ok(Self {
            reach,
            cells: Cells::default(),
            ghosts: Ghosts::new(boundaries, fluid.dimension, rest),
            bodies,
            fluid_list: NeighbourList::default(),
            body_list: NeighbourList::default(),
            carriers: Vec::new(),
            gradients: Vec::new(),
            viscous: Vec::new(),
            needs_viscous,
            solid: Vec::new(),
            beside: Vec::new(),
            fluid_count: 0,
            positions: Vec::new(),
        })
    }

    /// The point that a body's ghost is.
    pub(crate) fn point_of_body(&self, ghost: usize) -> usize {
        self.fluid_count + ghost
    }

    /// Makes images anew and lists the neighbours of all.
    pub(crate) fn list_neighbours(&mut self, x: &[[f64; 3]], boundaries: &Boundaries) -> Result<(), SphError> {
        self.fluid_count = x.len();
        self.ghosts.rebuild(x, boundaries, self.reach * (1.0 + 1e-9));
        self.positions.clear();
        self.positions.extend_from_slice(x);
        self.positions.extend_from_slice(&self.bodies.x);
        self.positions.extend_from_slice(&self.ghosts.positions);
        if u32::try_from(self.positions.len()).is_err() {
            return Err(ParticlesError::TooMany { count: self.positions.len() }.into());
        }
        self.cells.rebuild(&self.positions, self.reach / CELLS_PER_REACH);
        let (fluid, bodies) = (self.fluid_count, self.bodies.x.len());
        self.fluid_list.rebuild(&self.cells, &self.positions, 0, fluid, self.reach);
        self.body_list.rebuild(&self.cells, &self.positions, fluid, bodies, self.reach);
        for (listed, pose) in self.bodies.listed.iter_mut().zip(&self.bodies.pose) {
            *listed = pose.displacement;
        }
        let mut solid = std::mem::take(&mut self.solid);
        self.fill(&mut solid, |kind| match kind {
            Kind::Fluid(_) => false,
            Kind::Body(_) => true,
            Kind::Image(image) => self.ghosts.transform(self.ghosts.images[image].1).mirrored,
        });
        self.solid = solid;
        let touched = |&i: &u32| self.fluid_list.of(i as usize).iter().any(|&j| self.solid[j as usize]);
        self.beside = (0..fluid as u32).into_par_iter().filter(touched).collect();
        Ok(())
    }

    /// Number of points.
    fn len(&self) -> usize {
        self.fluid_count + self.bodies.x.len() + self.ghosts.images.len()
    }

    /// Whether a point is a ghost of a wall or a body.
    #[inline(always)]
    pub(crate) fn is_solid(&self, point: usize) -> bool {
        self.solid[point]
    }

    #[inline(always)]
    pub(crate) fn kind(&self, point: usize) -> Kind {
        let (fluid, bodies) = (self.fluid_count, self.bodies.x.len());
        if point < fluid {
            Kind::Fluid(point)
        } else if point < fluid + bodies {
            Kind::Body(point - fluid)
        } else {
            Kind::Image(point - fluid - bodies)
        }
    }

    /// Fills a column, one entry per point.
    fn fill<T: Send + Default + Clone>(&self, column: &mut Vec<T>, value: impl Fn(Kind) -> T + Sync) {
        column.resize(self.len(), T::default());
        column.par_chunks_mut(FILL).enumerate().for_each(|(chunk, out)| {
            for (k, out) in out.iter_mut().enumerate() {
                *out = value(self.kind(chunk * FILL + k));
            }
        });
    }

    /// Carriers of all points for a state.
    pub(crate) fn fill_carriers(&mut self, state: &State, mass: f64) {
        let mut carriers = std::mem::take(&mut self.carriers);
        let carrier = |x: [f64; 3], volume, density, u: [f64; 3]| [x[0], x[1], x[2], volume, density, u[0], u[1], u[2]];
        self.fill(&mut carriers, |kind| match kind {
            Kind::Fluid(i) => carrier(state.x[i], mass / state.density[i], state.density[i], state.u[i]),
            Kind::Body(b) => {
                let BodyState { density, wet, .. } = self.bodies.state[b];
                let volume = if wet { self.bodies.volume[b] } else { 0.0 };
                carrier(self.bodies.x[b], volume, density, self.bodies.pose_of(b).velocity)
            }
            Kind::Image(image) => {
                let (source, transform) = self.ghosts.images[image];
                let (i, transform) = (source as usize, self.ghosts.transform(transform));
                let density = transform.density(state.x[i], state.density[i]);
                carrier(transform.position(state.x[i]), mass / density, density, transform.velocity(state.u[i]))
            }
        });
        self.carriers = carriers;
        if self.needs_viscous {
            let mut viscous = std::mem::take(&mut self.viscous);
            let entry = |u: [f64; 3], weight| [u[0], u[1], u[2], weight];
            self.fill(&mut viscous, |kind| match kind {
                Kind::Fluid(i) => entry(state.u[i], 1.0),
                Kind::Body(b) => {
                    // The velocity follows with the interpolation.
                    entry([0.0; 3], f64::from(u8::from(self.bodies.no_slip[b])))
                }
                Kind::Image(image) => {
                    let (source, transform) = self.ghosts.images[image];
                    entry(self.ghosts.transform(transform).viscous_velocity(state.u[source as usize]), 1.0)
                }
            });
            self.viscous = viscous;
        }
    }

    /// Gradients of all points from those of the fluid particles.
    pub(crate) fn fill_gradients(&mut self, fluid: &[[f64; 4]]) {
        let mut gradients = std::mem::take(&mut self.gradients);
        let entry = |g: [f64; 3]| [g[0], g[1], g[2], 0.0];
        self.fill(&mut gradients, |kind| match kind {
            Kind::Fluid(i) => fluid[i],
            Kind::Body(b) => entry(self.bodies.state[b].gradient),
            Kind::Image(image) => {
                let (source, transform) = self.ghosts.images[image];
                let [x, y, z, _] = fluid[source as usize];
                entry(self.ghosts.transform(transform).gradient([x, y, z]))
            }
        });
        self.gradients = gradients;
    }

    /// Columns for shifting in place of the carriers: x, y, z, V, and 0 on the free surface or infinity elsewhere.
    pub(crate) fn fill_shifting(&mut self, state: &State, mass: f64, free: &[u8]) {
        let mut carriers = std::mem::take(&mut self.carriers);
        let carrier = |x: [f64; 3], volume, free: bool| {
            [x[0], x[1], x[2], volume, if free { 0.0 } else { f64::INFINITY }, 0.0, 0.0, 0.0]
        };
        self.fill(&mut carriers, |kind| match kind {
            Kind::Fluid(i) => carrier(state.x[i], mass / state.density[i], free[i] != 0),
            Kind::Body(b) => {
                let wet = self.bodies.state[b].wet;
                carrier(self.bodies.x[b], if wet { self.bodies.volume[b] } else { 0.0 }, false)
            }
            Kind::Image(image) => {
                let (source, transform) = self.ghosts.images[image];
                let (i, transform) = (source as usize, self.ghosts.transform(transform));
                let density = transform.density(state.x[i], state.density[i]);
                carrier(transform.position(state.x[i]), mass / density, free[i] != 0)
            }
        });
        self.carriers = carriers;
    }

    /// Images at the present positions, for a search of another reach.
    pub(crate) fn images_of(&self, x: &[[f64; 3]], images: &mut Vec<Image>) {
        images.clear();
        let ghosts = &self.ghosts;
        images.extend(
            (0..ghosts.images.len()).map(|i| Image { source: ghosts.images[i].0, position: ghosts.position_of(i, x) }),
        );
    }

    /// Bytes of columns and lists.
    pub(crate) fn bytes(&self) -> usize {
        let points = self.len();
        let columns = 64 + 32 + if self.needs_viscous { 32 } else { 0 };
        points * (columns + 24) + self.cells.bytes() + self.fluid_list.bytes() + self.body_list.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Body, Shape};

    #[test]
    fn ghosts_belong_to_their_own_body_however_many_there_are() {
        let fluid = FluidOptions::new(2, 0.1, 1.0, 0.0);
        let mut boundaries = Boundaries::new([-4.0; 3], [4.0; 3], 0.1);
        // Without an inside, so that none of them has ghosts or covers another's.
        let nothing = Shape::Box { low: [0.0; 3], high: [-1.0; 3] };
        boundaries.bodies = vec![Body::new(nothing, Slip::Free); 1 << 16];
        boundaries.bodies.push(Body::new(Shape::Sphere { centre: [0.0; 3], radius: 1.0 }, Slip::No));
        let ghosts = BodyGhosts::new(&fluid, &boundaries);
        assert!(!ghosts.body.is_empty() && ghosts.body.iter().all(|&body| body == 1 << 16));
    }
}
