//! Overlaps with a certain bound of their error, in as many digits as the task needs.

use glam::DVec3;

use crate::double_double::DoubleDouble;
use crate::precision::{Tracked, Wide};
use crate::{Ball, FaceTerms, Overlap, Polyhedron, Real, Vector, face_terms, fast_overlap};

/// Error that results are promised to stay below, relative to the smaller of the two volumes (areas: of sphere and
/// face).
///
/// Of elements with less than 1e-20 of the volume of a cube of their size, which only the rounding of their corners keeps apart from
/// nothing, not even 256 bits promise that; their bounds still hold.
pub const PROMISE: f64 = 1e-12;

/// Arithmetic that a result was computed in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Precision {
    /// 64-bit floats.
    F64,
    /// Pairs of them, 106 bits ([`DoubleDouble`]).
    DoubleDouble,
    /// 256 bits ([`Wide`]).
    Wide,
}

/// An overlap with bounds of its errors.
#[derive(Debug, Clone, PartialEq)]
pub struct CertifiedOverlap {
    /// Volume, areas and gradient.
    pub overlap: Overlap,
    /// Bound of the error of the volume.
    pub volume_error: f64,
    /// Bound of the error of the sphere area.
    pub sphere_area_error: f64,
    /// Bound of the error of each face area.
    pub face_area_errors: Vec<f64>,
    /// Arithmetic that was needed.
    pub precision: Precision,
}

/// What the promise has to hold for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wanted {
    Volume,
    Everything,
}

/// Overlap with bounds of its errors, in the first precision that keeps the promise.
///
/// The bounds hold for the result against the exact overlap of the ball with the polyhedron whose corners are the
/// numbers given, faces that are not exactly planar being fanned around [`crate::polygon_centroid`] (as computed). They are
/// below [`PROMISE`] times the smaller volume (for areas: the smaller of the whole sphere and the whole face) for any
/// size ratio from 1e-6 to 1e6 and flatness down to 1e-6.
///
/// In `f64` the bound is [`ErrorBound`](crate::ErrorBound), whose constants are set by experience; beyond, it comes from running error analysis
/// ([`Tracked`]), with what the branches not taken would have given.
///
/// The gradient has no bound of its own: it errs by no more than the sum of the face areas' bounds. Beyond the ranges named,
/// the result of 256 bits is returned with whatever bound it has.
///
/// Cost: that of [`fast_overlap`] where `f64` is enough; some 50 times as much in double-double, 1,000 times in 256 bits.
///
/// ```
/// use fieldstone_geometry::{Ball, Polyhedron, Precision, certified_overlap};
/// let cube = Polyhedron::cuboid([0.0; 3], [1.0; 3])?;
/// // A ball a million times larger, whose surface passes through the middle of the cube.
/// let huge = certified_overlap(&Ball::new([0.5, 0.5, -1e6 + 0.5], 1e6)?, &cube);
/// assert!(huge.precision > Precision::F64 && huge.volume_error < 1e-12);
/// assert!((huge.overlap.volume - (0.5 - 1e-6 / 12.0)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn certified_overlap(ball: &Ball, polyhedron: &Polyhedron) -> CertifiedOverlap {
    let fast = fast_overlap(ball, polyhedron);
    if fast.keeps_promise(ball, polyhedron, Wanted::Everything) {
        return fast;
    }
    beyond_f64(ball, polyhedron, Wanted::Everything)
}

/// Overlap with bounds of its errors in the arithmetic named, whether or not that keeps the promise.
///
/// ```
/// use fieldstone_geometry::{Ball, Polyhedron, Precision, overlap_in};
/// let cube = Polyhedron::cuboid([0.0; 3], [1.0; 3])?;
/// let ball = Ball::new([0.3, 0.2, 0.9], 0.7)?;
/// let [rough, fine] = [Precision::F64, Precision::DoubleDouble].map(|p| overlap_in(&ball, &cube, p));
/// assert!((rough.overlap.volume - fine.overlap.volume).abs() <= rough.volume_error);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn overlap_in(ball: &Ball, polyhedron: &Polyhedron, precision: Precision) -> CertifiedOverlap {
    match precision {
        Precision::F64 => fast_overlap(ball, polyhedron),
        Precision::DoubleDouble => evaluate::<Tracked<DoubleDouble>>(ball, polyhedron, precision),
        Precision::Wide => evaluate::<Tracked<Wide>>(ball, polyhedron, precision),
    }
}

/// The overlap in double-double, and in 256 bits where that is not enough.
pub(crate) fn beyond_f64(ball: &Ball, polyhedron: &Polyhedron, wanted: Wanted) -> CertifiedOverlap {
    let double = overlap_in(ball, polyhedron, Precision::DoubleDouble);
    if double.keeps_promise(ball, polyhedron, wanted) {
        return double;
    }
    overlap_in(ball, polyhedron, Precision::Wide)
}

impl CertifiedOverlap {
    fn keeps_promise(&self, ball: &Ball, polyhedron: &Polyhedron, wanted: Wanted) -> bool {
        let volume = self.volume_error <= PROMISE * ball.volume().min(polyhedron.volume());
        if wanted == Wanted::Volume || !volume {
            return volume;
        }
        let sphere = ball.surface_area();
        let whole: f64 = polyhedron.face_areas().iter().sum();
        let faces = self.face_area_errors.iter().zip(polyhedron.face_areas());
        self.sphere_area_error <= PROMISE * sphere.min(whole)
            && faces.into_iter().all(|(error, face)| *error <= PROMISE * sphere.min(*face))
    }
}

impl Polyhedron {
    /// Calls `visit` with the face, the corners and the unit normal of every part of the surface that is planar exactly, in
    /// the arithmetic R, moved and scaled so that the ball is the unit ball around the origin.
    ///
    /// Parts without area are left out; where rounding hides whether there is any, the normal's error is infinite.
    pub(crate) fn for_each_planar_ring<R: Real>(
        &self,
        centre: &Vector<R>,
        radius: R,
        mut visit: impl FnMut(usize, &[Vector<R>], Vector<R>),
    ) {
        let centre = *centre - Vector::from_f64(self.origin().to_array());
        let shifted = |v: DVec3| {
            let v = Vector::from_f64(v.to_array()) - centre;
            Vector::new(v.x / radius, v.y / radius, v.z / radius)
        };
        let mut visit_unless_flat = |face: usize, corners: &[DVec3], ring: &[Vector<R>]| {
            if let Some(normal) = unit_normal::<R>(corners) {
                visit(face, ring, normal);
            }
        };
        let vertices = self.vertices();
        for (piece, corners) in self.rings() {
            let corners: Vec<DVec3> = corners.iter().map(|&k| vertices[k as usize]).collect();
            let ring: Vec<Vector<R>> = corners.iter().map(|&v| shifted(v)).collect();
            let face = piece.face as usize;
            if piece.warp == 0.0 {
                visit_unless_flat(face, &corners, &ring);
            } else {
                let apex = shifted(piece.apex);
                for (k, &a) in ring.iter().enumerate() {
                    let next = (k + 1) % ring.len();
                    visit_unless_flat(face, &[corners[k], corners[next], piece.apex], &[a, ring[next], apex]);
                }
            }
        }
    }
}

/// Unit normal of a planar polygon; `None` without area.
///
/// From the corners as given, whose products 256 bits hold unless their exponents are far apart: moved to a ball and divided by its
/// radius, three points of one line are so no more, and whatever rounding makes of their normal.
fn unit_normal<R: Real>(corners: &[DVec3]) -> Option<Vector<R>> {
    let area = area_vector::<R>(corners);
    let length = area.length();
    if length.to_f64() > 2.0 * length.error() {
        return Some(Vector::new(area.x / length, area.y / length, area.z / length));
    }
    let exact = area_vector::<Wide>(corners);
    let unknown = R::from_f64(0.0).with_error(f64::INFINITY);
    (exact.length().to_f64() > 0.0).then(|| Vector::new(unknown, unknown, unknown))
}

/// Twice the area of a planar polygon, along its normal.
fn area_vector<R: Real>(corners: &[DVec3]) -> Vector<R> {
    let at = |v: DVec3| Vector::<R>::from_f64(v.to_array());
    let first = at(corners[0]);
    let zero = R::from_f64(0.0);
    corners[1..]
        .windows(2)
        .fold(Vector::new(zero, zero, zero), |sum, pair| sum + (at(pair[0]) - first).cross(at(pair[1]) - first))
}

/// The kernel in any arithmetic that tracks its error.
pub(crate) fn evaluate<R: Real>(ball: &Ball, polyhedron: &Polyhedron, precision: Precision) -> CertifiedOverlap {
    let centre = Vector::<R>::from_f64(ball.centre());
    let radius = R::from_f64(ball.radius());
    let zero = R::from_f64(0.0);
    let faces = polyhedron.face_areas().len();
    let mut sums = Sums {
        volume3: zero,
        solid_angle: zero,
        areas: vec![zero; faces],
        area_normal: Vector::new(zero, zero, zero),
        touched: false,
    };
    polyhedron.for_each_planar_ring(&centre, radius, |face, ring, normal| sums.add(face, ring, normal));
    sums.finish(ball, polyhedron, radius, precision)
}

struct Sums<R> {
    volume3: R,
    solid_angle: R,
    areas: Vec<R>,
    area_normal: Vector<R>,
    touched: bool,
}

impl<R: Real> Sums<R> {
    fn add(&mut self, face: usize, ring: &[Vector<R>], normal: Vector<R>) {
        let FaceTerms { distance, area, solid_angle } = face_terms(normal, ring);
        self.volume3 = self.volume3 + distance * area + solid_angle;
        self.solid_angle = self.solid_angle + solid_angle;
        self.areas[face] = self.areas[face] + area;
        self.area_normal = self.area_normal + normal * area;
        self.touched |= area.to_f64() != 0.0 || area.error() > 0.0;
    }

    fn finish(self, ball: &Ball, polyhedron: &Polyhedron, radius: R, precision: Precision) -> CertifiedOverlap {
        let r2 = radius * radius;
        // One rounding to f64 at the end, and those of the limits that results are clamped to.
        let rounded = |x: R, limit: f64| {
            let value = x.to_f64();
            (value.clamp(0.0, limit), x.error() + 8.0 * f64::EPSILON * value.abs())
        };
        let smaller = ball.volume().min(polyhedron.volume());
        let (mut volume, mut volume_error) = rounded(self.volume3 * r2 * radius / R::from_f64(3.0), smaller);
        let (mut sphere_area, mut sphere_area_error) = rounded(self.solid_angle * r2, ball.surface_area());
        if !self.touched && self.solid_angle.error() < 1.0 {
            // No face meets the ball: all or nothing.
            let inside = self.solid_angle.to_f64() > 2.0 * std::f64::consts::PI;
            (volume, sphere_area) = if inside { (smaller, ball.surface_area()) } else { (0.0, 0.0) };
            volume_error = 8.0 * f64::EPSILON * volume;
            sphere_area_error = 8.0 * f64::EPSILON * sphere_area;
        }
        let (face_areas, face_area_errors) =
            self.areas.iter().zip(polyhedron.face_areas()).map(|(&area, &whole)| rounded(area * r2, whole)).unzip();
        let g = self.area_normal * -r2;
        CertifiedOverlap {
            overlap: Overlap { volume, sphere_area, gradient: [g.x.to_f64(), g.y.to_f64(), g.z.to_f64()], face_areas },
            volume_error,
            sphere_area_error,
            face_area_errors,
            precision,
        }
    }
}
