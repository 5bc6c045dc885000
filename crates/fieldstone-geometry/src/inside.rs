//! Volumes from what of an element's edges is inside the ball: one ball at a time, or a register of them.

use std::f64::consts::PI;

use pulp::{Simd, WithSimd};

use crate::edge_frames::{EdgeFrames, MOST_PIECES};
use crate::lanes::{Lanes, PlacedBalls, Register, Single, sums_inside};
use crate::{Ball, PROMISE, Polyhedron};

/// Rounding error of the volume, in units of ε r³, beyond what [`crate::ErrorBound`] counts: angles at points as near as
/// 1/64 radius lose six bits, though hardly all at once.
const INSIDE_ROUNDING: f64 = 32.0;

/// Margin of decisions on squared distances, as in [`crate::overlap::placement`].
const MARGIN: f64 = 8.0 * f64::EPSILON;

/// What is found for one ball.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InsideVolume {
    pub volume: f64,
    /// Bound of its error; infinite where the volume is not to be trusted.
    pub error: f64,
    /// Whether the bound is as low as promised.
    pub promised: bool,
    /// Whether a formula was needed: apart, and all of the element, are plain to see.
    pub evaluated: bool,
}

/// What is found for each ball of a register.
struct Volumes<L: Lanes> {
    volume: L,
    error: L,
    promised: L::Mask,
    settled: L::Mask,
}

/// Volume of a ball in an element that has frames.
pub(crate) fn inside_volume(ball: &Ball, element: &Polyhedron, frames: &EdgeFrames) -> InsideVolume {
    pulp::Arch::new().dispatch(OneBall { ball, element, frames })
}

struct OneBall<'a> {
    ball: &'a Ball,
    element: &'a Polyhedron,
    frames: &'a EdgeFrames,
}

impl WithSimd for OneBall<'_> {
    type Output = InsideVolume;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> InsideVolume {
        if const { Register::<S>::FUSED } { self.volume::<true>() } else { self.volume::<false>() }
    }
}

impl OneBall<'_> {
    #[inline(always)]
    fn volume<const FUSED: bool>(&self) -> InsideVolume {
        let origin = self.element.origin().to_array();
        let c = self.ball.centre();
        let centre = [0, 1, 2].map(|k| Single::<FUSED>(c[k] - origin[k]));
        let found = volumes(self.element, self.frames, centre, Single(self.ball.radius()));
        InsideVolume {
            volume: found.volume.0,
            error: found.error.0,
            promised: found.promised,
            evaluated: !found.settled,
        }
    }
}

/// Most numbers in a register.
const WIDEST: usize = 8;

/// Volumes of many balls in an element that has frames: calls `found` with the index of each ball.
///
/// The same bits as [`inside_volume`] gives.
pub(crate) fn inside_volumes(
    balls: impl Iterator<Item = (usize, Ball)>,
    element: &Polyhedron,
    frames: &EdgeFrames,
    found: impl FnMut(usize, InsideVolume),
) {
    pulp::Arch::new().dispatch(ManyBalls { balls, element, frames, found });
}

struct ManyBalls<'a, I, F> {
    balls: I,
    element: &'a Polyhedron,
    frames: &'a EdgeFrames,
    found: F,
}

impl<I: Iterator<Item = (usize, Ball)>, F: FnMut(usize, InsideVolume)> WithSimd for ManyBalls<'_, I, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let origin = self.element.origin().to_array();
        let (mut indices, mut count) = ([0; WIDEST], 0);
        // x, y, z and the radius of a register's balls.
        let mut numbers = [[0.0; WIDEST]; 4];
        loop {
            let next = self.balls.next();
            if let Some((index, ball)) = next {
                let c = ball.centre();
                indices[count] = index;
                for k in 0..3 {
                    numbers[k][count] = c[k] - origin[k];
                }
                numbers[3][count] = ball.radius();
                count += 1;
            }
            if count == S::F64_LANES || next.is_none() && count > 0 {
                for row in &mut numbers {
                    let last = row[count - 1];
                    row[count..].fill(last);
                }
                let [x, y, z, r] = [0, 1, 2, 3].map(|k| Register::load(simd, &numbers[k]));
                let result = volumes(self.element, self.frames, [x, y, z], r);
                let mut out = [[0.0; WIDEST]; 4];
                result.volume.store(&mut out[0]);
                result.error.store(&mut out[1]);
                let as_number = |mask| Register::select(mask, r.like(1.0), r.like(0.0));
                as_number(result.promised).store(&mut out[2]);
                as_number(result.settled).store(&mut out[3]);
                for k in 0..count {
                    let (volume, error) = (out[0][k], out[1][k]);
                    let (promised, evaluated) = (out[2][k] != 0.0, out[3][k] == 0.0);
                    (self.found)(indices[k], InsideVolume { volume, error, promised, evaluated });
                }
                count = 0;
            }
            if next.is_none() {
                break;
            }
        }
    }
}

/// With room for as many pieces as there are, or a little more.
#[inline(always)]
fn volumes<L: Lanes>(element: &Polyhedron, frames: &EdgeFrames, centre: [L; 3], radius: L) -> Volumes<L> {
    match frames.planes.len() {
        ..=4 => volumes_of::<L, 4>(element, frames, centre, radius),
        5..=6 => volumes_of::<L, 6>(element, frames, centre, radius),
        _ => volumes_of::<L, MOST_PIECES>(element, frames, centre, radius),
    }
}

#[inline(always)]
fn volumes_of<L: Lanes, const N: usize>(
    element: &Polyhedron,
    frames: &EdgeFrames,
    centre: [L; 3],
    radius: L,
) -> Volumes<L> {
    let (zero, one) = (radius.like(0.0), radius.like(1.0));
    let whole = radius.like(element.volume());
    let r2 = radius * radius;
    let (low, high) = element.low_high();
    let (low, high) = (low.to_array(), high.to_array());
    let (mut near2, mut far2) = (zero, zero);
    for k in 0..3 {
        let (to_low, to_high) = (centre[k] - radius.like(low[k]), radius.like(high[k]) - centre[k]);
        let gap = (-to_low).max(-to_high).max(zero);
        near2 = gap.mul_add(gap, near2);
        let far = to_low.abs().max(to_high.abs());
        far2 = far.mul_add(far, far2);
    }
    let apart = !near2.less(r2 * radius.like(1.0 + MARGIN));
    let surely = r2 * radius.like(1.0 - MARGIN);
    // Where the far corner of the box is inside, all corners are; else they are looked at where they fit at all.
    let mut covered = !surely.less(far2);
    let diagonal2 = radius.like(0.25 * (0..3).map(|k| (high[k] - low[k]).powi(2)).sum::<f64>());
    let perhaps = !covered & !r2.less(diagonal2);
    if L::any(perhaps) {
        let mut all = perhaps;
        for v in element.vertices() {
            let v = v.to_array();
            let [x, y, z] = [0, 1, 2].map(|k| radius.like(v[k]) - centre[k]);
            let distance2 = z.mul_add(z, y.mul_add(y, x * x));
            all = all & !surely.less(distance2);
        }
        covered = covered | all;
    }
    let settled = apart | covered;
    let mut result = Volumes {
        volume: L::select(covered, whole, zero),
        error: L::select(covered, whole * radius.like(2.0 * f64::EPSILON), zero),
        promised: settled,
        settled,
    };
    if !L::any(!settled) {
        return result;
    }
    let scale = one / radius;
    let balls = PlacedBalls { centre: centre.map(|x| x * scale), scale };
    let sums = sums_inside::<L, N>(frames, element.is_convex(), &balls);
    let r3 = r2 * radius;
    let ball_volume = r3 * radius.like(4.0 / 3.0 * PI);
    let smaller = ball_volume.min(whole);
    let volume = (sums.volume3 * radius.like(1.0 / 3.0) * r3).max(zero).min(smaller);
    let untouched = L::select(sums.centre_inside, smaller, zero);
    let volume = L::select(sums.touched, volume, untouched);
    let volume = L::select(sums.apart, zero, volume);
    let reach = far2.sqrt() * scale;
    let sensitivity = (radius.like(4.0) * reach).mul_add(sums.sensitivity, radius.like(8.0 + INSIDE_ROUNDING));
    let error = radius.like(f64::EPSILON).mul_add(sensitivity, sums.warped_area) * r3;
    let error = L::select(sums.apart, zero, error);
    let error = L::select(sums.doubtful & !sums.apart, radius.like(f64::INFINITY), error);
    result.volume = L::select(settled, result.volume, volume);
    result.error = L::select(settled, result.error, error);
    result.promised = settled | !(radius.like(PROMISE) * smaller).less(error);
    result
}
