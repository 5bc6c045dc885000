use crate::ParticlesError;

/// The simulation box: bounds, and which directions are periodic.
///
/// A box is `low ≤ x < high` in each direction. In a periodic direction a position outside is wrapped by
/// whole box lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Domain {
    low: [f64; 3],
    high: [f64; 3],
    periodic: [bool; 3],
}

impl Domain {
    /// A box from `low` to `high`, periodic in the directions marked.
    ///
    /// # Errors
    /// [`ParticlesError::EmptyBox`] where an upper bound is not above the lower one (NaN included).
    pub fn new(low: [f64; 3], high: [f64; 3], periodic: [bool; 3]) -> Result<Self, ParticlesError> {
        for axis in 0..3 {
            let extent = high[axis] - low[axis];
            if extent.is_nan() || extent <= 0.0 || extent.is_infinite() {
                return Err(ParticlesError::EmptyBox { axis: ['x', 'y', 'z'][axis], low: low[axis], high: high[axis] });
            }
        }
        Ok(Self { low, high, periodic })
    }

    /// Lower corner.
    pub fn low(&self) -> [f64; 3] {
        self.low
    }

    /// Upper corner.
    pub fn high(&self) -> [f64; 3] {
        self.high
    }

    /// Which directions are periodic.
    pub fn periodic(&self) -> [bool; 3] {
        self.periodic
    }

    /// The same box with other periodic directions.
    #[must_use]
    pub fn with_periodic(mut self, periodic: [bool; 3]) -> Self {
        self.periodic = periodic;
        self
    }

    /// Edge lengths.
    pub fn lengths(&self) -> [f64; 3] {
        std::array::from_fn(|k| self.high[k] - self.low[k])
    }

    /// `position` moved into the box by whole box lengths along the periodic directions.
    ///
    /// ```
    /// use fieldstone_particles::Domain;
    /// let unit = Domain::new([0.0; 3], [1.0; 3], [true, false, false])?;
    /// assert_eq!(unit.wrap([-0.25, 2.0, 0.5]), [0.75, 2.0, 0.5]);
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    pub fn wrap(&self, position: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| {
            let x = position[k];
            if !self.periodic[k] || (x >= self.low[k] && x < self.high[k]) {
                return x;
            }
            let length = self.high[k] - self.low[k];
            let wrapped = x - length * ((x - self.low[k]) / length).floor();
            // Rounding may land a tiny negative offset exactly on the upper bound, which belongs to the next box.
            if wrapped >= self.high[k] { self.low[k] } else { wrapped }
        })
    }

    /// Centres of all periodic images of a ball that reach into the box, the wrapped original first.
    ///
    /// A ball whose radius exceeds the box reaches in through several images per direction: all are listed.
    ///
    /// ```
    /// use fieldstone_particles::Domain;
    /// let unit = Domain::new([0.0; 3], [1.0; 3], [true, true, false])?;
    /// let centres: Vec<_> = unit.images([0.1, 0.5, 0.0], 0.2).collect();
    /// assert_eq!(centres, [[0.1, 0.5, 0.0], [1.1, 0.5, 0.0]]);
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    pub fn images(&self, centre: [f64; 3], radius: f64) -> Images {
        let origin = self.wrap(centre);
        let lengths = self.lengths();
        let mut range = [[0i64; 2]; 3];
        for k in 0..3 {
            if self.periodic[k] {
                // Image m reaches in where origin + m L + r > low and origin + m L − r < high.
                range[k][0] = ((self.low[k] - origin[k] - radius) / lengths[k]).floor() as i64 + 1;
                range[k][1] = ((self.high[k] - origin[k] + radius) / lengths[k]).ceil() as i64 - 1;
            }
        }
        Images { origin, lengths, range, next: None, done: false }
    }
}

/// Iterator over the centres that [`Domain::images`] lists.
#[derive(Debug, Clone)]
pub struct Images {
    origin: [f64; 3],
    lengths: [f64; 3],
    range: [[i64; 2]; 3],
    next: Option<[i64; 3]>,
    done: bool,
}

impl Iterator for Images {
    type Item = [f64; 3];

    fn next(&mut self) -> Option<[f64; 3]> {
        if self.done {
            return None;
        }
        let Some(mut cell) = self.next else {
            self.next = Some([self.range[0][0], self.range[1][0], self.range[2][0]]);
            return Some(self.origin);
        };
        loop {
            let current = cell;
            let mut axis = 0;
            loop {
                if axis == 3 {
                    self.done = true;
                    break;
                }
                cell[axis] += 1;
                if cell[axis] <= self.range[axis][1] {
                    break;
                }
                cell[axis] = self.range[axis][0];
                axis += 1;
            }
            self.next = Some(cell);
            if current != [0; 3] {
                return Some(std::array::from_fn(|k| self.origin[k] + current[k] as f64 * self.lengths[k]));
            }
            if self.done {
                return None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(periodic: [bool; 3]) -> Domain {
        Domain::new([-1.0; 3], [1.0; 3], periodic).unwrap()
    }

    #[test]
    fn a_ball_at_a_corner_of_a_periodic_box_has_eight_images() {
        let found: Vec<_> = cube([true; 3]).images([0.95; 3], 0.1).collect();
        assert_eq!(found.len(), 8);
        assert_eq!(found[0], [0.95; 3]);
        assert!(found.contains(&[-1.05, 0.95, -1.05]));
    }

    #[test]
    fn a_ball_larger_than_the_box_reaches_in_from_every_image_within_its_radius() {
        let found: Vec<_> = cube([true, false, false]).images([0.0; 3], 5.5).collect();
        // Images at −6 … 6 in steps of 2 reach into (−1, 1).
        assert_eq!(found.len(), 7);
    }

    #[test]
    fn without_periodic_directions_there_is_only_the_ball_itself() {
        assert_eq!(cube([false; 3]).images([3.0, 0.0, 0.0], 1.0).collect::<Vec<_>>(), [[3.0, 0.0, 0.0]]);
    }

    #[test]
    fn wrapping_a_tiny_negative_offset_stays_inside() {
        let d = Domain::new([0.0; 3], [1.0; 3], [true; 3]).unwrap();
        let w = d.wrap([-1e-18, 7.5, -3.25]);
        assert_eq!(w, [0.0, 0.5, 0.75]);
    }
}
