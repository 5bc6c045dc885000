use fieldstone_particles::Image;

use crate::SurfaceError;

/// A plane wall, behind which particles see their mirror images.
///
/// The fluid is where `normal · x > offset`. Particles beyond the wall are not mirrored: their images would lie inside
/// the fluid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    normal: [f64; 3],
    offset: f64,
}

impl Wall {
    /// The plane `normal · x = offset`; `normal` points into the fluid and need not be of unit length.
    ///
    /// # Errors
    /// [`SurfaceError::Option`] where `normal` has no length or a number is not finite.
    pub fn new(normal: [f64; 3], offset: f64) -> Result<Self, SurfaceError> {
        let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return Err(SurfaceError::Option {
                name: "the length of the wall's normal",
                value: length,
                allowed: "finite and above 0",
            });
        }
        if !offset.is_finite() {
            return Err(SurfaceError::Option { name: "the wall's offset", value: offset, allowed: "finite" });
        }
        Ok(Self { normal: normal.map(|n| n / length), offset: offset / length })
    }

    /// Unit normal, into the fluid.
    pub fn normal(&self) -> [f64; 3] {
        self.normal
    }

    /// Distance of the plane from the origin along the normal.
    pub fn offset(&self) -> f64 {
        self.offset
    }

    /// Distance of a point from the plane, positive in the fluid.
    pub fn distance(&self, x: [f64; 3]) -> f64 {
        (0..3).map(|k| self.normal[k] * x[k]).sum::<f64>() - self.offset
    }

    /// The mirror image of a point.
    pub fn mirror(&self, x: [f64; 3]) -> [f64; 3] {
        let distance = self.distance(x);
        std::array::from_fn(|k| x[k] - 2.0 * distance * self.normal[k])
    }
}

/// Mirror images of all particles within `reach` of walls, for
/// [`NeighbourGrid::build_with_images`](fieldstone_particles::NeighbourGrid::build_with_images).
///
/// Images are mirrored at the other walls in turn, so edges get double and corners triple images. That is exact for
/// walls at right angles; of two facing walls closer than `reach` only the first images are made.
///
/// ```
/// use fieldstone_surface::{Wall, wall_images};
/// let corner = [Wall::new([1.0, 0.0, 0.0], 0.0)?, Wall::new([0.0, 0.0, 2.0], 0.0)?];
/// let images: Vec<_> = wall_images(&[[0.5, 3.0, 0.25]], &corner, 1.0).iter().map(|i| i.position).collect();
/// assert_eq!(images, [[-0.5, 3.0, 0.25], [0.5, 3.0, -0.25], [-0.5, 3.0, -0.25]]);
/// # Ok::<(), fieldstone_surface::SurfaceError>(())
/// ```
pub fn wall_images(positions: &[[f64; 3]], walls: &[Wall], reach: f64) -> Vec<Image> {
    let mut images: Vec<Image> = Vec::new();
    // An image on the very edge of the reach must not be lost to rounding.
    let padded = reach * (1.0 + 1e-9);
    for wall in walls {
        let near = |x: [f64; 3]| {
            let distance = wall.distance(x);
            // A particle in the plane is its own image.
            distance > 0.0 && distance <= padded
        };
        let before = images.len();
        for (source, &x) in positions.iter().enumerate() {
            if near(x) {
                images.push(Image { source: source as u32, position: wall.mirror(x) });
            }
        }
        for image in 0..before {
            let Image { source, position } = images[image];
            if near(position) {
                images.push(Image { source, position: wall.mirror(position) });
            }
        }
    }
    images
}
