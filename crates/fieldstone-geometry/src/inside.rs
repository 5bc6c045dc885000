//! Volumes from what of an element's edges is inside the ball: one ball at a time, or a register of them.

use std::f64::consts::PI;

use pulp::{NullaryFnOnce, Scalar, Simd, WithSimd};

use crate::edge_frames::{EdgeFrames, MOST_PIECES};
#[cfg(target_arch = "x86_64")]
use crate::lanes::Single;
use crate::lanes::{Lanes, OneNumber, PlacedBalls, Register, sums_inside};
use crate::{Ball, PROMISE, Polyhedron};

/// Rounding error of the volume in units of ε κ r³ / δ, beyond what [`crate::ErrorBound`] counts, with δ the distance of a corner
/// from the centre's foot, where angles lose 1/δ, and κ the largest flatness of a face.
const NEAR_ROUNDING: f64 = 8.0;

/// How near the foot may be to a corner, in radii. Nearer ones, some 0.1 % of all pairs, take the slow way.
const NEAR: f64 = 1.0 / 64.0;

/// Margin of decisions on squared distances, as in [`crate::overlap::placement`].
const MARGIN: f64 = 8.0 * f64::EPSILON;

const FEW: usize = 4;
const SOME: usize = 8;

/// Room for the pieces there are: powers of two, of which remainders cost nothing.
#[inline(always)]
fn room(frames: &EdgeFrames) -> usize {
    let pieces = frames.planes.len();
    if pieces <= FEW {
        FEW
    } else if pieces <= SOME {
        SOME
    } else {
        MOST_PIECES
    }
}

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
#[inline]
pub(crate) fn inside_volume(ball: &Ball, element: &Polyhedron, frames: &EdgeFrames) -> InsideVolume {
    match room(frames) {
        FEW => one_ball::<FEW>(ball, element, frames),
        SOME => one_ball::<SOME>(ball, element, frames),
        _ => one_ball::<MOST_PIECES>(ball, element, frames),
    }
}

#[inline]
fn one_ball<const N: usize>(ball: &Ball, element: &Polyhedron, frames: &EdgeFrames) -> InsideVolume {
    #[cfg(target_arch = "x86_64")]
    match pulp::Arch::new() {
        pulp::Arch::V4(simd) => {
            return simd.vectorize(OneBall::<_, N> { ball, element, frames, like: Single(*simd, 0.0) });
        }
        pulp::Arch::V3(simd) => {
            return simd.vectorize(OneBall::<_, N> { ball, element, frames, like: Single(simd, 0.0) });
        }
        _ => {}
    }
    OneBall::<_, N> { ball, element, frames, like: Register::splat(Scalar, 0.0) }.call()
}

struct OneBall<'a, L, const N: usize> {
    ball: &'a Ball,
    element: &'a Polyhedron,
    frames: &'a EdgeFrames,
    /// Says of what kind the numbers are.
    like: L,
}

impl<L: OneNumber, const N: usize> NullaryFnOnce for OneBall<'_, L, N> {
    type Output = InsideVolume;

    #[inline(always)]
    fn call(self) -> InsideVolume {
        let origin = self.element.origin().to_array();
        let c = self.ball.centre();
        let at = self.like;
        let centre = [at.like(c[0] - origin[0]), at.like(c[1] - origin[1]), at.like(c[2] - origin[2])];
        let found = volumes_of::<L, N>(self.element, self.frames, centre, at.like(self.ball.radius()));
        InsideVolume {
            volume: found.volume.number(),
            error: found.error.number(),
            promised: L::any(found.promised),
            evaluated: !L::any(found.settled),
        }
    }
}

/// Most numbers in a register.
const WIDEST: usize = 8;

/// Balls that are sorted together: enough to fill registers with balls of one kind, few enough to stay in the cache.
const CHUNK: usize = 512;

/// Kinds of balls by the planes that they reach, six to a kind.
const KINDS: usize = 64;

/// Working memory of [`inside_volumes`].
#[derive(Debug, Clone, Default)]
pub(crate) struct InsideScratch {
    /// x, y, z and the radius of each ball of a chunk, relative to the element's origin.
    columns: [Vec<f64>; 4],
    kinds: Vec<u8>,
    order: Vec<u32>,
}

/// Volumes of `count` balls in an element that has frames: calls `found` with the number of each ball, in any order.
///
/// Balls that reach the same planes share a register, so that a face or edge out of reach is passed over by all of them at once.
/// The same bits as [`inside_volume`] gives.
pub(crate) fn inside_volumes(
    count: usize,
    ball: impl Fn(usize) -> Ball,
    element: &Polyhedron,
    frames: &EdgeFrames,
    scratch: &mut InsideScratch,
    found: impl FnMut(usize, InsideVolume),
) {
    pulp::Arch::new().dispatch(ManyBalls { count, ball, element, frames, scratch, found });
}

struct ManyBalls<'a, B, F> {
    count: usize,
    ball: B,
    element: &'a Polyhedron,
    frames: &'a EdgeFrames,
    scratch: &'a mut InsideScratch,
    found: F,
}

impl<B: Fn(usize) -> Ball, F: FnMut(usize, InsideVolume)> WithSimd for ManyBalls<'_, B, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let mut first = 0;
        while first < self.count {
            let count = CHUNK.min(self.count - first);
            self.load(first, count);
            self.sort(simd, count);
            for start in (0..count).step_by(S::F64_LANES) {
                self.evaluate(simd, first, start, count);
            }
            first += count;
        }
    }
}

impl<B: Fn(usize) -> Ball, F: FnMut(usize, InsideVolume)> ManyBalls<'_, B, F> {
    #[inline(always)]
    fn load(&mut self, first: usize, count: usize) {
        let origin = self.element.origin().to_array();
        // The last register reads on to its end.
        self.scratch.columns.iter_mut().for_each(|column| column.resize(count + WIDEST, 0.0));
        for k in 0..count {
            let ball = (self.ball)(first + k);
            let c = ball.centre();
            for axis in 0..3 {
                self.scratch.columns[axis][k] = c[axis] - origin[axis];
            }
            self.scratch.columns[3][k] = ball.radius();
        }
    }

    /// The order by kind, by counting.
    #[inline(always)]
    fn sort<S: Simd>(&mut self, simd: S, count: usize) {
        let InsideScratch { columns, kinds, order } = &mut *self.scratch;
        kinds.resize(count + WIDEST, 0);
        let mut ends = [0u32; KINDS];
        for start in (0..count).step_by(S::F64_LANES) {
            let (x, y) = (Register::load(simd, &columns[0][start..]), Register::load(simd, &columns[1][start..]));
            let (z, r) = (Register::load(simd, &columns[2][start..]), Register::load(simd, &columns[3][start..]));
            let mut bits = r.like(0.0);
            for (k, plane) in self.frames.planes.iter().enumerate() {
                let n = plane.normal;
                let distance = r.like(n[0]).mul_add(x, r.like(-plane.offset));
                let distance = r.like(n[2]).mul_add(z, r.like(n[1]).mul_add(y, distance));
                let bit = r.like(f64::from(1u32 << (k % 6)));
                bits = bits + Register::select(distance.abs().less(r), bit, r.like(0.0));
            }
            let mut numbers = [0.0; WIDEST];
            bits.store(&mut numbers);
            for k in 0..S::F64_LANES.min(count - start) {
                let kind = numbers[k] as u32 as u8 & (KINDS - 1) as u8;
                kinds[start + k] = kind;
                ends[kind as usize] += 1;
            }
        }
        let mut sum = 0;
        for end in &mut ends {
            // First the start of the kind, which becomes its end as it fills.
            (*end, sum) = (sum, sum + *end);
        }
        order.resize(count, 0);
        for (k, &kind) in kinds[..count].iter().enumerate() {
            let at = &mut ends[kind as usize];
            order[*at as usize] = k as u32;
            *at += 1;
        }
    }

    /// Evaluates a register of balls, from `start` on in the order.
    #[inline(always)]
    fn evaluate<S: Simd>(&mut self, simd: S, first: usize, start: usize, count: usize) {
        let end = count.min(start + S::F64_LANES);
        let balls = &self.scratch.order[start..end];
        let mut numbers = [[0.0; WIDEST]; 4];
        for k in 0..S::F64_LANES {
            // A register that is not full repeats its last ball.
            let ball = balls[k.min(balls.len() - 1)] as usize;
            for (row, column) in numbers.iter_mut().zip(&self.scratch.columns) {
                row[k] = column[ball];
            }
        }
        let [x, y, z, r] = &numbers;
        let centre = [Register::load(simd, x), Register::load(simd, y), Register::load(simd, z)];
        let r = Register::load(simd, r);
        let result = volumes(self.element, self.frames, centre, r);
        let (zero, one) = (r.like(0.0), r.like(1.0));
        let mut out = [[0.0; WIDEST]; 4];
        result.volume.store(&mut out[0]);
        result.error.store(&mut out[1]);
        Register::select(result.promised, one, zero).store(&mut out[2]);
        Register::select(result.settled, zero, one).store(&mut out[3]);
        for (k, &ball) in balls.iter().enumerate() {
            let (promised, evaluated) = (out[2][k] != 0.0, out[3][k] != 0.0);
            let found = InsideVolume { volume: out[0][k], error: out[1][k], promised, evaluated };
            (self.found)(first + ball as usize, found);
        }
    }
}

#[inline(always)]
fn volumes<L: Lanes>(element: &Polyhedron, frames: &EdgeFrames, centre: [L; 3], radius: L) -> Volumes<L> {
    match room(frames) {
        FEW => volumes_of::<L, FEW>(element, frames, centre, radius),
        SOME => volumes_of::<L, SOME>(element, frames, centre, radius),
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
    let (near2, far2) = L::to_box(&centre, &frames.bounds);
    let apart = !near2.less(r2 * radius.like(1.0 + MARGIN));
    let surely = r2 * radius.like(1.0 - MARGIN);
    // Where the far corner of the box is inside, all corners are; else they are looked at where they fit at all.
    let mut covered = !surely.less(far2);
    let perhaps = !covered & !r2.less(radius.like(frames.least_radius2));
    if L::any(perhaps) {
        let mut all = perhaps;
        for v in element.vertices() {
            let v = v.to_array();
            let [x, y, z] =
                [radius.like(v[0]) - centre[0], radius.like(v[1]) - centre[1], radius.like(v[2]) - centre[2]];
            let distance2 = z.mul_add(z, y.mul_add(y, x * x));
            all = all & !surely.less(distance2);
            if !L::any(all) {
                break;
            }
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
    let reach = far2.sqrt() * scale;
    let resolution = radius.like(16.0 * f64::EPSILON * frames.flatness) * reach;
    let balls = PlacedBalls { centre, scale, resolution };
    let sums = sums_inside::<L, N>(frames, element.is_convex(), &balls);
    let r3 = r2 * radius;
    let ball_volume = r3 * radius.like(4.0 / 3.0 * PI);
    let smaller = ball_volume.min(whole);
    let volume = (sums.volume3 * radius.like(1.0 / 3.0) * r3).max(zero).min(smaller);
    let untouched = L::select(sums.centre_inside, smaller, zero);
    let volume = L::select(sums.touched, volume, untouched);
    let volume = L::select(sums.apart, zero, volume);
    let near = radius.like(NEAR_ROUNDING * frames.flatness) / sums.nearest2.sqrt() + radius.like(8.0);
    let sensitivity = (radius.like(4.0) * reach).mul_add(sums.sensitivity, near);
    // Twice: of six million pairs one came to within 0.3 % of the bound.
    let error = radius.like(2.0 * f64::EPSILON).mul_add(sensitivity, sums.warped_area) * r3;
    let error = L::select(sums.apart, zero, error);
    let doubtful = sums.nearest2.less(radius.like(NEAR * NEAR)) & !sums.apart;
    let error = L::select(doubtful, radius.like(f64::INFINITY), error);
    result.volume = L::select(settled, result.volume, volume);
    result.error = L::select(settled, result.error, error);
    result.promised = settled | !(radius.like(PROMISE) * smaller).less(error);
    result
}

#[cfg(test)]
mod tests {
    use fieldstone_testing::Random;

    use super::*;

    /// Balls of all sizes around a cube and a tetrahedron.
    fn pairs() -> Vec<(Ball, Polyhedron)> {
        let cube = Polyhedron::cuboid([0.0; 3], [1.0; 3]).expect("a cube");
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let tetrahedron = Polyhedron::tetrahedron(corners).expect("a tetrahedron");
        let mut random = Random(5);
        let ball = |_| {
            let radius = 10f64.powf(random.uniform(-2.0, 0.5));
            Ball::new(random.point(-0.3, 1.3), radius).expect("a finite centre")
        };
        let balls: Vec<Ball> = (0..5000).map(ball).collect();
        balls.iter().flat_map(|&ball| [(ball, cube.clone()), (ball, tetrahedron.clone())]).collect()
    }

    #[test]
    fn machines_without_registers_give_the_volume_within_the_bound() {
        let mut evaluated = 0;
        for (ball, element) in pairs() {
            let frames = element.frames().expect("few planar faces");
            let like = Register::splat(Scalar, 0.0);
            let plain = OneBall::<_, SOME> { ball: &ball, element: &element, frames, like }.call();
            let found = inside_volume(&ball, &element, frames);
            assert_eq!(plain.evaluated, found.evaluated);
            evaluated += usize::from(plain.evaluated);
            if plain.error.is_finite() {
                assert!((plain.volume - found.volume).abs() <= plain.error + found.error, "{ball:?}");
            }
        }
        assert!(evaluated > 2000, "{evaluated}");
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn registers_of_four_and_of_eight_numbers_give_the_same_bits() {
        let Some(simd) = pulp::x86::V3::try_new() else { return };
        for (ball, element) in pairs() {
            let frames = element.frames().expect("few planar faces");
            let four =
                simd.vectorize(OneBall::<_, SOME> { ball: &ball, element: &element, frames, like: Single(simd, 0.0) });
            let found = inside_volume(&ball, &element, frames);
            assert_eq!((four.volume, four.error, four.promised), (found.volume, found.error, found.promised));
        }
    }
}
