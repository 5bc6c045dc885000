//! Bodies at periodic faces: the fluid repeats itself there, bodies do not.

use crate::{Body, Boundaries, FluidOptions, Shape, SphError};

impl Boundaries {
    /// Refuses bodies of which the fluid would miss a part across a periodic face, from the start up to a time.
    ///
    /// A body's copy, a period farther, is missed where it is within the kernel's reach of the domain, unless the body itself reaches
    /// through the domain and beyond both faces by as much, or the copy is given as a body, too.
    ///
    /// # Errors
    /// [`SphError::CutBody`].
    pub(crate) fn check_repeats(&self, fluid: &FluidOptions, until: f64) -> Result<(), SphError> {
        let reach = fluid.kernel().reach();
        // A distance of exactly the reach may come rounded.
        let rounding = 1e-6 * fluid.spacing;
        for (index, body) in self.bodies.iter().enumerate() {
            for axis in (0..fluid.dimension).filter(|&k| self.periodic[k]) {
                let (low, high) = (self.low[axis], self.high[axis]);
                let period = high - low;
                let (bottom, top) = body.shape.bounds();
                let moved = body.motion.as_ref().map_or([0.0; 2], |motion| motion.range(axis, until));
                let (first, last) = (bottom[axis] + moved[0], top[axis] + moved[1]);
                let is_felt =
                    |shift: f64| first + shift < high + reach - rounding && last + shift > low - reach + rounding;
                let goes_through = bottom[axis] + moved[1] <= low - reach + rounding
                    && top[axis] + moved[0] >= high + reach - rounding;
                if !is_felt(0.0) || goes_through {
                    continue;
                }
                for shift in [period, -period] {
                    let is_copy = |other: &Body| is_shifted(body, other, axis, shift, rounding);
                    if is_felt(shift) && !self.bodies.iter().any(is_copy) {
                        let axis = ['x', 'y', 'z'][axis];
                        return Err(SphError::CutBody { body: index, axis, first, last, low, high, reach, shift });
                    }
                }
            }
        }
        Ok(())
    }
}

/// Whether one body is the other, shifted along an axis: of the same kind, and the box around it says where.
fn is_shifted(body: &Body, other: &Body, axis: usize, shift: f64, rounding: f64) -> bool {
    let same_kind = std::mem::discriminant::<Shape>(&body.shape) == std::mem::discriminant(&other.shape);
    let (low, high) = body.shape.bounds();
    let (other_low, other_high) = other.shape.bounds();
    let is_there = |k: usize| {
        let by = if k == axis { shift } else { 0.0 };
        (other_low[k] - low[k] - by).abs() <= rounding && (other_high[k] - high[k] - by).abs() <= rounding
    };
    same_kind && (0..3).all(is_there) && body.moves_with(other) && body.slip == other.slip
}
