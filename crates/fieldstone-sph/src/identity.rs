//! What a checkpoint is compared by: a checksum of the numbers that describe a flow, which names in the program do not touch.
//!
//! Another list of numbers, or another order, is another format of checkpoints: it raises their version.

use crc32fast::Hasher;

use crate::{Body, Boundaries, Flow, FluidOptions, MirrorWall, Shape, ShiftingOptions, Slip, Viscosity};

impl Flow {
    /// A checksum of what must not change on a restart: all but the time step, k_CFL and what sections of output say.
    ///
    /// The time step may: a run that breaks is told to lessen it. So may k_CFL, which goes with it, as the shift is one per step.
    pub(crate) fn identity(&self) -> u32 {
        let mut numbers = Numbers(Hasher::new());
        // Named one by one, here and below, so that none that is added is forgotten.
        let Self { fluid, boundaries, time_step: _, shifting, detection, skin } = self;
        numbers.fluid(fluid);
        numbers.boundaries(boundaries);
        numbers.flag(shifting.is_some());
        if let Some(ShiftingOptions { k_cfl: _, r, n, factor, mach, cap, nearest_counts }) = shifting {
            numbers.reals(&[*r, f64::from(*n), *factor]);
            numbers.optional(*mach);
            numbers.real(*cap);
            numbers.flag(*nearest_counts);
        }
        let method = detection.map_or(String::new(), |method| method.to_string());
        numbers.count(method.len());
        numbers.0.update(method.as_bytes());
        numbers.real(*skin);
        numbers.0.finalize()
    }
}

struct Numbers(Hasher);

impl Numbers {
    fn real(&mut self, x: f64) {
        self.0.update(&x.to_le_bytes());
    }

    fn reals(&mut self, all: &[f64]) {
        all.iter().for_each(|&x| self.real(x));
    }

    fn count(&mut self, n: usize) {
        self.0.update(&(n as u64).to_le_bytes());
    }

    fn flag(&mut self, is: bool) {
        self.0.update(&[u8::from(is)]);
    }

    fn optional(&mut self, x: Option<f64>) {
        self.flag(x.is_some());
        self.real(x.unwrap_or(0.0));
    }

    fn fluid(&mut self, fluid: &FluidOptions) {
        let FluidOptions {
            dimension,
            spacing,
            smoothing,
            density,
            sound_speed,
            viscosity,
            delta,
            gravity,
            surface_tension,
            expected_speed,
            expected_pressure,
            particle_volume,
            tensile_control,
        } = fluid;
        self.count(*dimension);
        self.reals(&[*spacing, *smoothing, *density, *sound_speed]);
        let (is_alpha, viscosity) = match *viscosity {
            Viscosity::Dynamic(mu) => (false, mu),
            Viscosity::Alpha(alpha) => (true, alpha),
        };
        self.flag(is_alpha);
        self.reals(&[viscosity, *delta]);
        self.reals(gravity);
        self.reals(&[*surface_tension, *expected_speed, *expected_pressure]);
        self.optional(*particle_volume);
        self.flag(*tensile_control);
    }

    fn boundaries(&mut self, boundaries: &Boundaries) {
        let Boundaries { low, high, periodic, open, walls, bodies, padding } = boundaries;
        self.reals(low);
        self.reals(high);
        periodic.iter().chain(open.as_flattened()).for_each(|&is| self.flag(is));
        self.count(walls.len());
        for MirrorWall { plane, slip } in walls {
            self.reals(&plane.normal());
            self.real(plane.offset());
            self.flag(*slip == Slip::No);
        }
        self.count(bodies.len());
        bodies.iter().for_each(|body| self.body(body));
        self.real(*padding);
    }

    fn body(&mut self, body: &Body) {
        let Body { shape, slip, motion } = body;
        match shape {
            Shape::Box { low, high } => {
                self.count(0);
                self.reals(low);
                self.reals(high);
            }
            Shape::Cylinder { centre, radius, length, axis } => {
                self.count(1);
                self.reals(centre);
                self.reals(&[*radius, *length]);
                self.count(*axis);
            }
            Shape::Sphere { centre, radius } => {
                self.count(2);
                self.reals(centre);
                self.real(*radius);
            }
            Shape::Surface(surface) => {
                self.count(3);
                self.count(surface.len());
                let (origin, cell, triangles) = surface.fingerprint();
                self.reals(&origin);
                self.real(cell);
                self.0.update(&triangles.to_le_bytes());
            }
        }
        self.flag(*slip == Slip::No);
        let rows = motion.as_ref().map_or(0, |motion| motion.rows().count());
        self.count(rows);
        for (time, displacement) in motion.iter().flat_map(|motion| motion.rows()) {
            self.real(time);
            self.reals(&displacement);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Motion;
    use fieldstone_surface::{Method, Wall};

    fn flow() -> Flow {
        let fluid = FluidOptions::new(3, 0.1, 1.0, 0.0);
        let mut boundaries = Boundaries::new([0.0; 3], [2.0; 3], 0.1);
        boundaries.walls.push(MirrorWall { plane: Wall::new([0.0, 0.0, 1.0], 0.0).unwrap(), slip: Slip::Free });
        let motion = Motion::new(&[(0.0, [0.0; 3]), (1.0, [0.5, 0.0, 0.0])]).unwrap();
        let ball = Body::new(Shape::Sphere { centre: [1.0; 3], radius: 0.5 }, Slip::No);
        boundaries.bodies.push(Body { motion: Some(motion), ..ball });
        let mut flow = Flow::new(fluid, boundaries);
        flow.shifting = Some(ShiftingOptions::default());
        flow
    }

    #[test]
    fn checkpoints_of_this_version_know_their_flow_by_this_checksum() {
        // Another checksum makes strangers of all checkpoints of the version: raise that with it.
        assert_eq!((crate::checkpoint::VERSION, flow().identity()), (7, 2_514_838_982));
    }

    #[test]
    fn all_but_the_time_step_and_k_cfl_is_part_of_what_a_flow_is() {
        let start = flow().identity();
        let changes: [fn(&mut Flow); 12] = [
            |flow| flow.fluid.delta = 0.2,
            |flow| flow.fluid.viscosity = Viscosity::Dynamic(0.02),
            |flow| flow.fluid.particle_volume = Some(1e-3),
            |flow| flow.fluid.tensile_control = true,
            |flow| flow.boundaries.periodic[0] = true,
            |flow| flow.boundaries.walls[0].slip = Slip::No,
            |flow| flow.boundaries.bodies[0].shape = Shape::Sphere { centre: [1.0; 3], radius: 0.51 },
            |flow| flow.boundaries.bodies[0].motion = None,
            |flow| flow.shifting = None,
            |flow| flow.shifting.iter_mut().for_each(|shifting| shifting.mach = Some(0.1)),
            |flow| flow.detection = Some(Method::Wang),
            |flow| flow.skin = 0.2,
        ];
        for (nth, change) in changes.iter().enumerate() {
            let mut other = flow();
            change(&mut other);
            assert_ne!(other.identity(), start, "change {nth}");
        }
        let mut same = flow();
        same.time_step.cfl = 0.1;
        same.shifting.iter_mut().for_each(|shifting| shifting.k_cfl = 0.1);
        assert_eq!(same.identity(), start);
    }
}
