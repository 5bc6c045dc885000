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
///
/// Opposite faces of that box are one place of the periodic space where the cells span the period. What lies exactly on
/// them is decided here alone, by one rule: along periodic directions the box is closed below and open above, and what
/// rounding has put beside a face is on it. Points are counted by [`Periods::turns`], segments and their ends are moved
/// off the faces by [`Periods::above_face`]. Along directions that are not periodic the box is closed, as
/// [`fieldstone_mesh::Cells::locate`] is.
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
    /// Cells that span the period see every point once. Along directions that are not periodic nothing is left out.
    pub fn for_each_point(&self, at: [f64; 3], mut visit: impl FnMut([f64; 3])) {
        self.for_each_centre(at, |at, _| visit(at));
    }

    /// As [`Periods::for_each_point`], with the periods by which each image is moved.
    fn for_each_centre(&self, at: [f64; 3], mut visit: impl FnMut([f64; 3], [i64; 3])) {
        if !self.any() {
            return visit(at, [0; 3]);
        }
        let mut images = vec![(at, [0; 3])];
        for axis in (0..3).rev().filter(|&k| self.vectors[k].is_some()) {
            let mut next = Vec::with_capacity(images.len());
            for &(image, turns) in &images {
                next.extend(self.turns(axis, image[axis]).map(|m| {
                    let mut turns: [i64; 3] = turns;
                    turns[axis] = m;
                    (self.moved(axis, image, m), turns)
                }));
            }
            images = next;
        }
        images.into_iter().for_each(|(at, turns)| visit(at, turns));
    }

    /// Calls `visit` with every image of a ball that may reach cells; without a radius, of its centre that lies in them.
    pub fn for_each_image(&self, at: [f64; 3], radius: Option<f64>, mut visit: impl FnMut(Image<'_>)) {
        let image = |centre, turns| Image { periods: self, original: at, turns, centre };
        match radius {
            None => self.for_each_centre(at, |centre, turns| visit(image(centre, turns))),
            Some(r) => self.for_each_copy(at.map(|x| x - r), at.map(|x| x + r), |shift, turns| {
                visit(image(std::array::from_fn(|k| at[k] + shift[k]), turns));
            }),
        }
    }

    /// Calls `visit` with every image of a segment that may reach cells: its start, and the way to its end.
    ///
    /// One that lies in a face of the cells' box across a periodic direction is moved off it, and lies in the box once.
    pub fn for_each_segment(&self, start: [f64; 3], along: [f64; 3], mut visit: impl FnMut([f64; 3], [f64; 3])) {
        let low = std::array::from_fn(|k| start[k] + along[k].min(0.0));
        let high = std::array::from_fn(|k| start[k] + along[k].max(0.0));
        self.for_each(low, high, |shift| {
            let mut from: [f64; 3] = std::array::from_fn(|k| start[k] + shift[k]);
            let mut along = along;
            for axis in 0..3 {
                let ends = [from[axis], from[axis] + along[axis]].map(|x| self.above_face(axis, x));
                if let [Some(x), Some(y)] = ends
                    && x == y
                {
                    (from[axis], along[axis]) = (x, 0.0);
                }
            }
            visit(from, along);
        });
    }

    /// A point off the faces of the cells' box that are periodic: above them, so that one of two images is in the box.
    pub fn off_faces(&self, at: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| self.above_face(k, at[k]).unwrap_or(at[k]))
    }

    /// The coordinate just above the face that `x` is on, where the direction is periodic and `x` is on one.
    ///
    /// Both of two images on opposite faces are moved, by the same: the lower one into the box, the upper one out of it.
    fn above_face(&self, axis: usize, x: f64) -> Option<f64> {
        let period = self.vectors[axis]?[axis];
        let on = |bound: f64| (x - bound).abs() < rounding(period, bound, x);
        let bound = [self.low[axis], self.high[axis]].into_iter().find(|&bound| on(bound))?;
        // Far enough that meshes, which decide by solid angles near their faces, see on which side it is.
        Some(bound + 4.0 * rounding(period.max(self.high[axis] - self.low[axis]), bound, x))
    }

    /// Numbers of periods that bring a coordinate into the cells' box, closed below and open above.
    ///
    /// Rounding puts it neither on both faces nor on none: cells that span n periods get n images of every point.
    fn turns(&self, axis: usize, x: f64) -> std::ops::Range<i64> {
        let Some(vector) = self.vectors[axis] else { return 0..1 };
        let (low, high, period) = (self.low[axis], self.high[axis], vector[axis]);
        let turns = |bound: f64| {
            let turns = (bound - x) / period;
            let whole = turns.round();
            let on_face = (turns - whole).abs() < rounding(period, bound, x) / period;
            (if on_face { whole } else { turns }).ceil() as i64
        };
        let first = turns(low);
        let periods = (high - low) / period;
        let whole = periods.round();
        if (periods - whole).abs() < rounding(period, low, high) / period {
            return first..first.saturating_add(whole as i64);
        }
        first..turns(high)
    }

    /// A point that is in the cells' box along `axis` when it is moved by `turns` periods, moved.
    fn moved(&self, axis: usize, at: [f64; 3], turns: i64) -> [f64; 3] {
        let Some(vector) = self.vectors[axis] else { return at };
        let mut moved: [f64; 3] = std::array::from_fn(|k| at[k] + turns as f64 * vector[k]);
        moved[axis] = moved[axis].clamp(self.low[axis], self.high[axis]);
        moved
    }

    /// Calls `visit` with every shift that brings the box `low`…`high` to meet the cells' box, in a fixed order.
    ///
    /// Along directions that are not periodic nothing is left out: what lies outside is found to be so by those who
    /// weigh it.
    pub fn for_each(&self, low: [f64; 3], high: [f64; 3], mut visit: impl FnMut([f64; 3])) {
        self.for_each_copy(low, high, |shift, _| visit(shift));
    }

    /// As [`Periods::for_each`], with the numbers of periods of each shift.
    fn for_each_copy(&self, low: [f64; 3], high: [f64; 3], mut visit: impl FnMut([f64; 3], [i64; 3])) {
        if !self.any() {
            return visit([0.0; 3], [0; 3]);
        }
        // A tilted period changes the coordinates before its own: from the last axis to the first.
        let mut shifts = vec![([0.0; 3], [0; 3])];
        for axis in (0..3).rev() {
            let Some(vector) = self.vectors[axis] else { continue };
            let period = vector[axis];
            let mut next = Vec::with_capacity(shifts.len());
            for &(shift, turns) in &shifts {
                // What touches the cells' box within rounding meets it: it may lie on a face.
                let below = self.low[axis] - high[axis] - shift[axis];
                let above = self.high[axis] - low[axis] - shift[axis];
                let first = ((below - rounding(period, self.low[axis], high[axis])) / period).ceil() as i64;
                let last = ((above + rounding(period, self.high[axis], low[axis])) / period).floor() as i64;
                next.extend((first..=last).map(|m| {
                    let mut turns: [i64; 3] = turns;
                    turns[axis] = m;
                    let shifted: [f64; 3] = std::array::from_fn(|k| shift[k] + m as f64 * vector[k]);
                    (shifted, turns)
                }));
            }
            shifts = next;
        }
        shifts.into_iter().for_each(|(shift, turns)| visit(shift, turns));
    }
}

/// Distance within which rounding cannot tell a coordinate from a face of the cells' box.
fn rounding(period: f64, bound: f64, x: f64) -> f64 {
    1e-12 * period + 8.0 * f64::EPSILON * bound.abs().max(x.abs())
}

/// A ball moved by whole periods.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Image<'a> {
    periods: &'a Periods,
    turns: [i64; 3],
    /// Where the ball itself is.
    pub original: [f64; 3],
    /// Where it is moved to.
    pub centre: [f64; 3],
}

impl Image<'_> {
    /// A point moved as the ball is, where that brings it into the cells' box.
    ///
    /// Over all images of the ball the point is given as often as [`Periods::for_each_point`] visits it.
    pub fn of(&self, mut at: [f64; 3]) -> Option<[f64; 3]> {
        for axis in (0..3).rev() {
            if !self.periods.turns(axis, at[axis]).contains(&self.turns[axis]) {
                return None;
            }
            at = self.periods.moved(axis, at, self.turns[axis]);
        }
        Some(at)
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
