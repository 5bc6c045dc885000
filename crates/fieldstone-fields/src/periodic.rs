//! Periodic images that reach a set of cells.

use fieldstone_particles::Domain;

/// The shifts by whole periods that bring something into a box of interest.
///
/// Unlike [`Domain::images`] the box is that of the cells, which need not lie in the domain: a grid that has been moved
/// along with the particles sees the same images.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Periods {
    /// Period along x, y, z where images are wanted; lower triangular for a tilted box.
    vectors: [Option<[f64; 3]>; 3],
    low: [f64; 3],
    high: [f64; 3],
}

impl Periods {
    /// Along directions marked in `once` everything counts once, wherever it is.
    pub fn new(domain: Option<&Domain>, once: [bool; 3], (low, high): ([f64; 3], [f64; 3])) -> Self {
        let vectors = std::array::from_fn(|k| Some(domain.filter(|d| d.periodic()[k] && !once[k])?.cell_vectors()[k]));
        Self { vectors, low, high }
    }

    pub fn any(&self) -> bool {
        self.vectors.iter().any(Option::is_some)
    }

    /// Calls `visit` with every shift that brings the box `low`…`high` to meet the cells' box, in a fixed order.
    ///
    /// Along directions that are not periodic nothing is left out: what lies outside is found to be so by those who
    /// weigh it.
    pub fn for_each(&self, low: [f64; 3], high: [f64; 3], mut visit: impl FnMut([f64; 3])) {
        if !self.any() {
            return visit([0.0; 3]);
        }
        // A tilted period changes the coordinates before its own: from the last axis to the first.
        let mut shifts = vec![[0.0; 3]];
        for axis in (0..3).rev() {
            let Some(vector) = self.vectors[axis] else { continue };
            let mut next = Vec::with_capacity(shifts.len());
            for shift in &shifts {
                let first = ((self.low[axis] - high[axis] - shift[axis]) / vector[axis]).ceil() as i64;
                let last = ((self.high[axis] - low[axis] - shift[axis]) / vector[axis]).floor() as i64;
                next.extend((first..=last).map(|m| {
                    let shifted: [f64; 3] = std::array::from_fn(|k| shift[k] + m as f64 * vector[k]);
                    shifted
                }));
            }
            shifts = next;
        }
        shifts.into_iter().for_each(visit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_reach_the_cells_wherever_the_particle_and_the_cells_are() {
        let domain = Domain::new([0.0; 3], [1.0, 2.0, 1.0], [true, true, false]).unwrap();
        let periods = Periods::new(Some(&domain), [false; 3], ([10.25, 0.0, 0.0], [11.25, 2.0, 1.0]));
        let mut found = Vec::new();
        periods.for_each([0.1, 0.9, 0.0], [0.3, 1.1, 0.2], |shift| found.push(shift));
        assert_eq!(found, [[10.0, 0.0, 0.0], [11.0, 0.0, 0.0]]);
    }
}
