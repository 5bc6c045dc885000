//! Periodic images that reach a set of cells.

use fieldstone_particles::{Contact, Domain};

use crate::FieldsError;

/// Copies of the box that may reach the cells: with more of them the units must be wrong, and no run would end.
const MOST_COPIES: f64 = 1e5;

/// Radius over the length of a periodic box beyond which units must be wrong, and images too many to count.
const MOST_IMAGES: f64 = 20.0;

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

    /// Refuses a box that is so much smaller than the cells, and what is within `reach` of them, that its copies are too
    /// many to go through.
    pub fn check(&self, reach: f64) -> Result<(), FieldsError> {
        let extent = |k: usize| self.high[k] - self.low[k] + 2.0 * reach;
        let along = |k: usize| self.vectors[k].map_or(1.0, |vector| extent(k) / vector[k] + 1.0);
        let copies = (0..3).map(along).product();
        if copies <= MOST_COPIES { Ok(()) } else { Err(FieldsError::BoxCopies { copies }) }
    }

    /// As [`Periods::check`] for balls of these radii; one that dwarfs the box is named.
    pub fn check_balls(&self, radii: &[f64]) -> Result<(), FieldsError> {
        let length = (0..3).filter_map(|k| self.vectors[k].map(|vector| vector[k])).fold(f64::INFINITY, f64::min);
        if let Some(particle) = radii.iter().position(|&r| r > MOST_IMAGES * length) {
            return Err(FieldsError::RadiusBox { particle, radius: radii[particle], length });
        }
        self.check(radii.iter().copied().fold(0.0, f64::max))
    }

    /// Calls `visit` with every image of a point that lies in the cells' box, in a fixed order.
    ///
    /// Of two images on opposite faces of that box, which are one place of the periodic space, the lower one counts:
    /// cells that span the period see every point once. Along directions that are not periodic nothing is left out.
    pub fn for_each_point(&self, at: [f64; 3], visit: impl FnMut([f64; 3])) {
        let mut images = vec![at];
        for axis in (0..3).rev() {
            let Some(vector) = self.vectors[axis] else { continue };
            let (low, high) = (self.low[axis], self.high[axis]);
            let mut next = Vec::with_capacity(images.len());
            for image in &images {
                // Rounding must not put a point on both faces, or on none.
                let turns = |bound: f64| {
                    let turns = (bound - image[axis]) / vector[axis];
                    let whole = turns.round();
                    let rounding = 1e-12 + 8.0 * f64::EPSILON * bound.abs().max(image[axis].abs()) / vector[axis];
                    let on_face = (turns - whole).abs() < rounding;
                    (if on_face { whole } else { turns }).ceil() as i64
                };
                next.extend((turns(low)..turns(high)).map(|m| {
                    let mut moved: [f64; 3] = std::array::from_fn(|k| image[k] + m as f64 * vector[k]);
                    moved[axis] = moved[axis].clamp(low, high);
                    moved
                }));
            }
            images = next;
        }
        images.into_iter().for_each(visit);
    }

    /// Calls `visit` with every image of a ball that may reach cells; without a radius, of its centre that lies in them.
    pub fn for_each_image(&self, at: [f64; 3], radius: Option<f64>, mut visit: impl FnMut([f64; 3])) {
        let Some(r) = radius else { return self.for_each_point(at, visit) };
        self.for_each(at.map(|x| x - r), at.map(|x| x + r), |shift| {
            visit(std::array::from_fn(|k| at[k] + shift[k]));
        });
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

/// The longest extent of a branch along an axis: its images reach half of it beyond their middles.
pub(crate) fn longest_branch(contacts: impl Iterator<Item = Contact>) -> f64 {
    contacts.flat_map(|contact| contact.branch).fold(0.0, |longest, x| longest.max(x.abs()))
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

    #[test]
    fn a_point_on_a_face_of_cells_as_wide_as_the_period_has_one_image_in_them() {
        // Widths and offsets that are no sums of powers of two: the images are on the faces up to rounding only.
        for (low, period) in [(0.0, 1.0), (-0.5, 1.0), (0.1, 0.3), (1e3 + 0.1, 0.7)] {
            let domain = Domain::new([low; 3], [low + period; 3], [true; 3]).unwrap();
            for turns in -2..3 {
                let start = low + 0.3 * period;
                let cells = ([start; 3], [start + period; 3]);
                let periods = Periods::new(Some(&domain), [false; 3], cells);
                let mut found = Vec::new();
                periods.for_each_point([start + f64::from(turns) * period; 3], |at| found.push(at));
                assert_eq!(found.len(), 1, "{low} {period} {turns}: {found:?}");
                assert!((found[0][0] - start).abs() < 1e-12, "{low} {period} {turns}: {found:?}");
            }
        }
    }
}
