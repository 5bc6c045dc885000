//! The ball.

use thiserror::Error;

/// Why three coordinates and a radius make no ball.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum BallError {
    /// A coordinate of the centre is NaN, infinite or beyond 1e100.
    #[error("the ball's centre is ({}, {}, {}); coordinates must be finite, and at most 1e100 in size", .0[0], .0[1], .0[2])]
    Centre([f64; 3]),
    /// The radius is NaN, zero, negative, or so small or large that its volume would be no number.
    #[error("the ball's radius is {0}; it must be between 1e-100 and 1e100")]
    Radius(f64),
}

/// Coordinates and radii beyond this, or radii below its reciprocal, have cubes that are no numbers.
const LARGEST: f64 = 1e100;

/// A ball: centre and radius, in the user's unit of length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    centre: [f64; 3],
    radius: f64,
}

impl Ball {
    /// A ball with finite centre and positive radius, between 1e-100 and 1e100.
    ///
    /// # Errors
    /// [`BallError`] names the number that is out of range.
    ///
    /// ```
    /// use fieldstone_geometry::Ball;
    /// let ball = Ball::new([0.0; 3], 0.5)?;
    /// assert!((ball.volume() - std::f64::consts::PI / 6.0).abs() < 1e-15);
    /// assert!(Ball::new([0.0; 3], f64::NAN).is_err());
    /// # Ok::<(), fieldstone_geometry::BallError>(())
    /// ```
    pub fn new(centre: [f64; 3], radius: f64) -> Result<Self, BallError> {
        if !centre.iter().all(|x| x.abs() <= LARGEST) {
            return Err(BallError::Centre(centre));
        }
        if !(1.0 / LARGEST..=LARGEST).contains(&radius) {
            return Err(BallError::Radius(radius));
        }
        Ok(Self { centre, radius })
    }

    /// Centre.
    #[inline]
    pub fn centre(&self) -> [f64; 3] {
        self.centre
    }

    /// Radius.
    #[inline]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Volume, 4/3 π r³.
    #[inline]
    pub fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.radius.powi(3)
    }

    /// Area of the surface, 4 π r².
    #[inline]
    pub fn surface_area(&self) -> f64 {
        4.0 * std::f64::consts::PI * self.radius * self.radius
    }
}
