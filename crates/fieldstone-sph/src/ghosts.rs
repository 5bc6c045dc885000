//! Mirror and periodic images of fluid particles.

use glam::{DMat3, DVec3};

use crate::{Boundaries, Slip};

/// How an image follows its particle: x' = A x + b + s with a reflection (A, b) and a periodic shift s.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Transform {
    pub(crate) matrix: DMat3,
    offset: DVec3,
    shift: DVec3,
    /// What the velocity becomes in the viscous term: A for free slip, −1 for each wall without slip.
    viscous: DMat3,
    /// Whether a wall has mirrored it; periodic shifts do not.
    pub(crate) mirrored: bool,
    /// ρ₀ g/c₀², the density gradient of a fluid at rest.
    rest: DVec3,
}

impl Transform {
    #[inline(always)]
    pub(crate) fn position(&self, x: [f64; 3]) -> [f64; 3] {
        let x = DVec3::from_array(x);
        (self.matrix * x + self.offset + self.shift).to_array()
    }

    #[inline(always)]
    pub(crate) fn velocity(&self, u: [f64; 3]) -> [f64; 3] {
        (self.matrix * DVec3::from_array(u)).to_array()
    }

    #[inline(always)]
    pub(crate) fn viscous_velocity(&self, u: [f64; 3]) -> [f64; 3] {
        (self.viscous * DVec3::from_array(u)).to_array()
    }

    /// Density whose pressure is p_i + ρ₀ g·(x' − x); a periodic shift changes nothing.
    #[inline(always)]
    pub(crate) fn density(&self, x: [f64; 3], density: f64) -> f64 {
        let x = DVec3::from_array(x);
        density + self.rest.dot(self.matrix * x + self.offset - x)
    }

    /// Density gradient of the field that the images continue.
    #[inline(always)]
    pub(crate) fn gradient(&self, gradient: [f64; 3]) -> [f64; 3] {
        // Reflections are symmetric and commute where walls are at right angles, so Aᵀ = A.
        (self.matrix * (DVec3::from_array(gradient) - self.rest) + self.rest).to_array()
    }
}

/// One step of making images: a mirror plane, or a shift along a periodic axis.
#[derive(Debug, Clone, Copy)]
enum Operation {
    Mirror { wall: usize },
    Shift { axis: usize, length: f64 },
}

/// Which particles have images, and how those follow them.
#[derive(Debug, Clone)]
pub(crate) struct Ghosts {
    operations: Vec<Operation>,
    transforms: Vec<Transform>,
    /// Transform that a transform becomes by an operation, once it has occurred.
    products: Vec<Vec<Option<u16>>>,
    /// Source and transform of each image.
    pub(crate) images: Vec<(u32, u16)>,
    /// Where they were made.
    pub(crate) positions: Vec<[f64; 3]>,
}

impl Ghosts {
    pub(crate) fn new(boundaries: &Boundaries, dimension: usize, rest: [f64; 3]) -> Self {
        let mut operations: Vec<Operation> =
            (0..boundaries.walls.len()).map(|wall| Operation::Mirror { wall }).collect();
        for axis in (0..dimension).filter(|&k| boundaries.periodic[k]) {
            let length = boundaries.high[axis] - boundaries.low[axis];
            operations.push(Operation::Shift { axis, length });
            operations.push(Operation::Shift { axis, length: -length });
        }
        let identity = Transform {
            matrix: DMat3::IDENTITY,
            offset: DVec3::ZERO,
            shift: DVec3::ZERO,
            viscous: DMat3::IDENTITY,
            mirrored: false,
            rest: DVec3::from_array(rest),
        };
        let products = vec![vec![None; operations.len()]];
        Self { operations, transforms: vec![identity], products, images: Vec::new(), positions: Vec::new() }
    }

    pub(crate) fn transform(&self, index: u16) -> &Transform {
        &self.transforms[index as usize]
    }

    pub(crate) fn position_of(&self, image: usize, x: &[[f64; 3]]) -> [f64; 3] {
        let (source, transform) = self.images[image];
        self.transforms[transform as usize].position(x[source as usize])
    }

    /// Makes the images of all particles within `reach` of a boundary.
    ///
    /// Images are mirrored at the other walls in turn: double images behind edges, triple ones behind corners.
    pub(crate) fn rebuild(&mut self, x: &[[f64; 3]], boundaries: &Boundaries, reach: f64) {
        self.images.clear();
        self.positions.clear();
        let mut previous = 0;
        for operation in 0..self.operations.len() {
            // Both shifts along an axis act on what was there before the first of them.
            let second = matches!(self.operations[operation], Operation::Shift { length, .. } if length < 0.0);
            let before = if second { previous } else { self.images.len() };
            previous = before;
            for (source, &at) in x.iter().enumerate() {
                if self.is_near(operation, at, boundaries, reach) {
                    self.push(source as u32, 0, operation, boundaries, x);
                }
            }
            for image in 0..before {
                if self.is_near(operation, self.positions[image], boundaries, reach) {
                    let (source, transform) = self.images[image];
                    self.push(source, transform, operation, boundaries, x);
                }
            }
        }
    }

    fn is_near(&self, operation: usize, x: [f64; 3], boundaries: &Boundaries, reach: f64) -> bool {
        match self.operations[operation] {
            Operation::Mirror { wall } => boundaries.walls[wall].plane.distance(x) <= reach,
            Operation::Shift { axis, length } if length > 0.0 => x[axis] <= boundaries.low[axis] + reach,
            Operation::Shift { axis, .. } => x[axis] >= boundaries.high[axis] - reach,
        }
    }

    fn push(&mut self, source: u32, transform: u16, operation: usize, boundaries: &Boundaries, x: &[[f64; 3]]) {
        let product = self.product(transform, operation, boundaries);
        self.images.push((source, product));
        self.positions.push(self.transforms[product as usize].position(x[source as usize]));
    }

    fn product(&mut self, transform: u16, operation: usize, boundaries: &Boundaries) -> u16 {
        if let Some(known) = self.products[transform as usize][operation] {
            return known;
        }
        let mut product = self.transforms[transform as usize];
        match self.operations[operation] {
            Operation::Mirror { wall } => {
                let wall = &boundaries.walls[wall];
                let normal = DVec3::from_array(wall.plane.normal());
                let outer = DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
                let reflection = DMat3::IDENTITY - 2.0 * outer;
                product.mirrored = true;
                product.matrix = reflection * product.matrix;
                product.offset = reflection * product.offset + 2.0 * wall.plane.offset() * normal;
                product.shift = reflection * product.shift;
                product.viscous = match wall.slip {
                    Slip::Free => reflection * product.viscous,
                    Slip::No => -product.viscous,
                };
            }
            Operation::Shift { axis, length } => product.shift[axis] += length,
        }
        let index = self.transforms.len() as u16;
        self.transforms.push(product);
        self.products.push(vec![None; self.operations.len()]);
        self.products[transform as usize][operation] = Some(index);
        index
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MirrorWall;
    use fieldstone_surface::Wall;

    fn corner(slip: Slip) -> Boundaries {
        let mut boundaries = Boundaries::new([0.0; 3], [9.0; 3], 0.1);
        for axis in 0..3 {
            let mut normal = [0.0; 3];
            normal[axis] = 1.0;
            boundaries.walls.push(MirrorWall { plane: Wall::new(normal, 0.0).unwrap(), slip });
        }
        boundaries
    }

    #[test]
    fn a_particle_in_a_corner_has_seven_images_and_its_normal_velocity_is_reversed_in_each() {
        let boundaries = corner(Slip::Free);
        let mut ghosts = Ghosts::new(&boundaries, 3, [0.0; 3]);
        let x = [[0.1, 0.2, 0.3]];
        ghosts.rebuild(&x, &boundaries, 1.0);
        assert_eq!(ghosts.images.len(), 7);
        for image in 0..7 {
            let at = ghosts.position_of(image, &x);
            let u = ghosts.transform(ghosts.images[image].1).velocity([1.0, 2.0, 3.0]);
            for k in 0..3 {
                assert_eq!(at[k].abs(), x[0][k]);
                assert_eq!(u[k] < 0.0, at[k] < 0.0);
            }
        }
    }

    #[test]
    fn without_slip_the_viscous_velocity_is_reversed_once_per_wall() {
        let boundaries = corner(Slip::No);
        let mut ghosts = Ghosts::new(&boundaries, 3, [0.0; 3]);
        let x = [[0.1, 0.2, 0.3]];
        ghosts.rebuild(&x, &boundaries, 1.0);
        for image in 0..7 {
            let walls = ghosts.position_of(image, &x).iter().filter(|&&c| c < 0.0).count();
            let sign = if walls % 2 == 1 { -1.0 } else { 1.0 };
            let u = ghosts.transform(ghosts.images[image].1).viscous_velocity([1.0, 2.0, 3.0]);
            assert_eq!(u, [sign, 2.0 * sign, 3.0 * sign]);
        }
    }

    #[test]
    fn a_fluid_at_rest_continues_behind_the_floor() {
        let boundaries = corner(Slip::Free);
        let rest = [0.0, 0.0, -2.0];
        let mut ghosts = Ghosts::new(&boundaries, 3, rest);
        let x = [[5.0, 5.0, 0.25]];
        ghosts.rebuild(&x, &boundaries, 1.0);
        let transform = ghosts.transform(ghosts.images[0].1);
        assert_eq!(transform.density(x[0], 10.0), 11.0);
        assert_eq!(transform.gradient(rest), rest);
        assert_eq!(transform.gradient([3.0, 0.0, -2.0]), [3.0, 0.0, -2.0]);
    }

    #[test]
    fn periodic_images_are_made_in_all_directions_and_keep_the_density() {
        let mut boundaries = Boundaries::new([0.0; 3], [1.0; 3], 0.1);
        boundaries.periodic = [true; 3];
        let mut ghosts = Ghosts::new(&boundaries, 3, [0.0, 0.0, -2.0]);
        let x = [[0.5; 3]];
        ghosts.rebuild(&x, &boundaries, 0.6);
        assert_eq!(ghosts.images.len(), 26);
        let mut seen: Vec<[f64; 3]> = (0..26).map(|i| ghosts.position_of(i, &x)).collect();
        seen.sort_by(|a, b| a.partial_cmp(b).unwrap());
        seen.dedup();
        assert_eq!(seen.len(), 26);
        assert!((0..26).all(|i| ghosts.transform(ghosts.images[i].1).density(x[0], 7.0) == 7.0));
    }
}
