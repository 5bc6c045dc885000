//! Overlap of a ball with a polyhedron: one evaluation gives volume, areas and gradient.

use glam::DVec3;

use crate::certified::{self, CertifiedOverlap, PROMISE, Precision, Wanted, certified_overlap};
use crate::inside::inside_volume;
use crate::{Ball, Polyhedron, Vector, face_terms};

/// Everything that one evaluation of the kernel gives.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Overlap {
    /// Volume of ball ∩ polyhedron.
    pub volume: f64,
    /// Area of the sphere inside the polyhedron; also the derivative of the volume with respect to the radius.
    pub sphere_area: f64,
    /// Derivative of the volume with respect to the ball's centre, $-\sum_f n_f A_f$.
    pub gradient: [f64; 3],
    /// Area of each face inside the ball, in the polyhedron's order of faces.
    pub face_areas: Vec<f64>,
}

/// Sums over the pieces, in units of the ball's radius.
struct Sums {
    volume3: f64,
    solid_angle: f64,
    area_normal: DVec3,
    touched: bool,
    bound: ErrorBound,
}

/// A-priori bound of the rounding errors of [`overlap`], gathered while the faces are summed.
///
/// In units of the ball's radius, with ε the distance from 1 to the next `f64`:
///
/// | error of | bound |
/// |---|---|
/// | volume | $\varepsilon \left( 8 + 4 \rho \sum_f (1 + A_f \kappa_f) \right) + \sum_f A_f w_f$ |
/// | area of a face | $\varepsilon \left( 8 + 8 \rho \sum_f \kappa_f \right) + 8 \sum_f w_f$ |
/// | area of the sphere | four times as much |
///
/// with ρ the distance of the farthest corner from the centre, $A_f$ the face's area inside the ball, κ its flatness
/// ([`flatness`](crate::flatness)), w its warp ([`warp_bound`](crate::warp_bound)); sums are over the faces
/// whose planes cut the ball: also one of which nothing is inside has a solid angle with an error of its distance.
///
/// Volumes from the edges inside the ball add $8 \varepsilon \kappa / \delta$, with the largest flatness κ of a face, and δ the distance,
/// in radii, of a corner from the centre's foot on a face; then twice what ε multiplies. Meshes, which do not measure edges from
/// their nearer corner, add $8 \varepsilon \rho / \delta$ instead, with δ also the distance of the centre from an edge inside the ball.
///
/// The constants are not derived operation by operation: they are twice the largest error, or more, seen against more digits
/// over six million random and adversarial pairs. `tests/bounds.rs` asserts that for the first 20,000 of them, or as many as
/// `FIELDSTONE_PAIRS` asks for; at its head is the command for all.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ErrorBound {
    reach: f64,
    sensitivity: f64,
    warped_area: f64,
    flatness: f64,
    warp: f64,
}

impl ErrorBound {
    /// For a polyhedron whose farthest corner is `reach` radii from the centre.
    #[inline]
    pub fn new(reach: f64) -> Self {
        Self { reach, ..Self::default() }
    }

    /// Takes account of a face whose plane cuts the ball: its area inside, its flatness, its warp in radii.
    #[inline]
    pub fn add(&mut self, area: f64, flatness: f64, warp: f64) {
        self.sensitivity += area * flatness + 1.0;
        self.warped_area += area * warp;
        self.flatness += flatness;
        self.warp += warp;
    }

    /// Bound of the error of the volume of a ball of this radius.
    #[inline]
    pub fn volume(&self, radius: f64) -> f64 {
        let relative = f64::EPSILON * (8.0 + 4.0 * self.reach * self.sensitivity) + self.warped_area;
        relative * (radius * radius * radius)
    }

    /// Bound of the error of the area of each face inside the ball.
    #[inline]
    pub fn area(&self, radius: f64) -> f64 {
        let relative = f64::EPSILON * (8.0 + 8.0 * self.reach * self.flatness) + 8.0 * self.warp;
        relative * (radius * radius)
    }

    /// Bound of the error of the area of the sphere inside, a sum of solid angles over all faces.
    #[inline]
    pub fn sphere_area(&self, radius: f64) -> f64 {
        4.0 * self.area(radius)
    }
}

/// How a ball lies to a polyhedron, where that is cheap to tell.
pub(crate) enum Placement {
    /// They have no point in common, or touch only.
    Apart,
    /// All of the polyhedron is in the ball.
    AllOfPolyhedron,
    /// The kernel has to look.
    Unknown,
}

/// Volume of the part of `ball` inside `polyhedron`, to 1e-12 of the smaller of the two volumes.
///
/// $$ 3 V = \sum_f \left( d_f A_f + \Omega_f \right) $$
///
/// over the faces, see [`face_terms`]; evaluated from the edges inside the ball, and as written only where the centre is
/// near one of them. Apart: exactly 0. One inside the other: exactly the smaller volume.
///
/// Accuracy: the error is below [`crate::PROMISE`] · min(V_ball, V_polyhedron) for size ratios from 1e-6 to 1e6, flat elements,
/// tangency and surfaces through corners. Computed in `f64`; where the bound of the error ([`ErrorBound`]) exceeds the
/// promise, again in more digits ([`crate::certified_overlap`]).
///
/// Cost: some 150 operations per edge inside the ball, an arc tangent per face with such an edge, and one more. No allocation.
/// Many balls in one element: [`crate::OverlapBatch`] takes about a third of the time.
///
/// Source: derived here; compare `strobl2016`, Eq. 2, for the same volume by decomposition.
///
/// ```
/// use fieldstone_geometry::{Ball, Polyhedron, overlap_volume};
/// let cube = Polyhedron::cuboid([0.0; 3], [1.0; 3])?;
/// let ball = Ball::new([0.0; 3], 0.5)?;
/// // One of the eight cubes around the centre takes one eighth.
/// assert!((overlap_volume(&ball, &cube) - ball.volume() / 8.0).abs() < 1e-16);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn overlap_volume(ball: &Ball, polyhedron: &Polyhedron) -> f64 {
    volume_and_path(ball, polyhedron).0
}

/// The volume, and whether it took more digits than `f64` has.
pub(crate) fn volume_and_path(ball: &Ball, polyhedron: &Polyhedron) -> (f64, bool) {
    let (volume, _, promised) = in_f64(ball, polyhedron);
    if promised {
        return (volume, false);
    }
    (certified::beyond_f64(ball, polyhedron, Wanted::Volume).overlap.volume, true)
}

/// The volume in `f64` alone, with a bound of its error.
///
/// For callers who know that ball and element are of like size, or who would rather have a rough number at once.
///
/// ```
/// use fieldstone_geometry::{Ball, Polyhedron, fast_overlap_volume};
/// let cube = Polyhedron::cuboid([0.0; 3], [1.0; 3])?;
/// let (_, error) = fast_overlap_volume(&Ball::new([0.2; 3], 1.0)?, &cube);
/// assert!(error < 1e-13);
/// let (_, error) = fast_overlap_volume(&Ball::new([1e5, 0.0, 0.0], 1e5)?, &cube);
/// assert!(error > 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fast_overlap_volume(ball: &Ball, polyhedron: &Polyhedron) -> (f64, f64) {
    let (volume, error, _) = in_f64(ball, polyhedron);
    (volume, error)
}

/// The volume in `f64`, a bound of its error, and whether that is as low as promised.
#[inline]
fn in_f64(ball: &Ball, polyhedron: &Polyhedron) -> (f64, f64, bool) {
    if let Some(frames) = polyhedron.frames() {
        let found = inside_volume(ball, polyhedron, frames);
        // Of a ball larger than the element the faces' terms are better: their rounding cancels between neighbours.
        if found.promised || found.error.is_finite() && ball.volume() <= polyhedron.volume() {
            return (found.volume, found.error, found.promised);
        }
    }
    let (volume, error) = volume_from_outside(ball, polyhedron);
    (volume, error, error <= PROMISE * ball.volume().min(polyhedron.volume()))
}

/// The volume by [`face_terms`], for any ball and polyhedron, with a bound of its error.
// Apart: its room on the stack would be made for every call.
#[inline(never)]
fn volume_from_outside(ball: &Ball, polyhedron: &Polyhedron) -> (f64, f64) {
    match placement(ball, polyhedron) {
        Placement::Apart => (0.0, 0.0),
        Placement::AllOfPolyhedron => (polyhedron.volume(), 2.0 * f64::EPSILON * polyhedron.volume()),
        Placement::Unknown => {
            let sums = sum_pieces(ball, polyhedron, |_, _| ());
            let volume = finish_volume(ball, polyhedron.volume(), &sums);
            (volume, sums.bound.volume(ball.radius()))
        }
    }
}

/// Volume, sphere area, gradient and face areas of ball ∩ polyhedron, in one evaluation.
///
/// | result | formula |
/// |---|---|
/// | volume | $\tfrac13 \sum_f (d_f A_f + \Omega_f)\, r^3$ |
/// | sphere area $= \partial V/\partial r$ | $r^2 \sum_f \Omega_f$ |
/// | gradient $\partial V/\partial c$ | $-r^2 \sum_f n_f A_f$ |
/// | face areas | $r^2 A_f$ |
///
/// Accuracy and cost as [`overlap_volume`], the areas' errors relative to the smaller of sphere and face; one
/// allocation for the face areas.
///
/// ```
/// use fieldstone_geometry::{Ball, Polyhedron, overlap};
/// let cube = Polyhedron::cuboid([0.0; 3], [1.0; 3])?;
/// let result = overlap(&Ball::new([0.5, 0.5, 0.0], 0.25)?, &cube);
/// // The bottom face cuts the ball in half: its disc is the only face area, and moving up gains volume.
/// let disc = std::f64::consts::PI / 16.0;
/// assert!((result.face_areas[0] - disc).abs() < 1e-16);
/// assert!((result.gradient[2] - disc).abs() < 1e-16);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn overlap(ball: &Ball, polyhedron: &Polyhedron) -> Overlap {
    certified_overlap(ball, polyhedron).overlap
}

/// Everything in `f64` alone, with bounds of the errors.
///
/// ```
/// use fieldstone_geometry::{Ball, Polyhedron, fast_overlap};
/// let cube = Polyhedron::cuboid([0.0; 3], [1.0; 3])?;
/// let ball = Ball::new([0.5, 0.5, 0.0], 0.25)?;
/// let found = fast_overlap(&ball, &cube);
/// // The bottom face cuts the ball in half.
/// assert!((found.overlap.volume - 0.5 * ball.volume()).abs() <= found.volume_error);
/// assert!(found.volume_error < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn fast_overlap(ball: &Ball, polyhedron: &Polyhedron) -> CertifiedOverlap {
    let mut face_areas = vec![0.0; polyhedron.face_areas().len()];
    let certified = |overlap: Overlap, volume_error: f64, area_error: f64, sphere_error: f64| CertifiedOverlap {
        face_area_errors: vec![area_error; overlap.face_areas.len()],
        overlap,
        volume_error,
        sphere_area_error: sphere_error,
        precision: Precision::F64,
    };
    match placement(ball, polyhedron) {
        Placement::Apart => certified(Overlap { face_areas, ..Overlap::default() }, 0.0, 0.0, 0.0),
        Placement::AllOfPolyhedron => {
            let volume = polyhedron.volume();
            let face_areas = polyhedron.face_areas().to_vec();
            let largest = face_areas.iter().copied().fold(0.0, f64::max);
            let overlap = Overlap { volume, face_areas, ..Overlap::default() };
            certified(overlap, 2.0 * f64::EPSILON * volume, 2.0 * f64::EPSILON * largest, 0.0)
        }
        Placement::Unknown => {
            let r2 = ball.radius() * ball.radius();
            let sums = sum_pieces(ball, polyhedron, |face, area| face_areas[face] += r2 * area);
            for (area, &whole) in face_areas.iter_mut().zip(polyhedron.face_areas()) {
                *area = area.clamp(0.0, whole);
            }
            let volume = finish_volume(ball, polyhedron.volume(), &sums);
            let sphere_area = if sums.touched {
                (r2 * sums.solid_angle).clamp(0.0, ball.surface_area())
            } else if volume > 0.0 {
                ball.surface_area()
            } else {
                0.0
            };
            let gradient = (-r2 * sums.area_normal).to_array();
            let area_error = sums.bound.area(ball.radius());
            let overlap = Overlap { volume, sphere_area, gradient, face_areas };
            certified(overlap, sums.bound.volume(ball.radius()), area_error, sums.bound.sphere_area(ball.radius()))
        }
    }
}

pub(crate) fn placement(ball: &Ball, polyhedron: &Polyhedron) -> Placement {
    // Distances are known to their rounding only, and a huge ball holds a small element or not within that: what is
    // not clear by this margin is left to the kernel.
    const MARGIN: f64 = 8.0 * f64::EPSILON;
    let centre = DVec3::from(ball.centre()) - polyhedron.origin();
    let r2 = ball.radius() * ball.radius();
    let (low, high) = polyhedron.low_high();
    if (centre - centre.clamp(low, high)).length_squared() >= r2 * (1.0 + MARGIN) {
        return Placement::Apart;
    }
    // Cheaper than the corners: all of them are inside where the far corner of the box is.
    let surely = r2 * (1.0 - MARGIN);
    let far = (centre - low).abs().max((high - centre).abs());
    if far.length_squared() <= surely || polyhedron.vertices().iter().all(|&v| (v - centre).length_squared() <= surely)
    {
        return Placement::AllOfPolyhedron;
    }
    Placement::Unknown
}

/// Corners of an element, or of a piece, on the stack up to this many.
const ON_STACK: usize = 32;

fn sum_pieces(ball: &Ball, polyhedron: &Polyhedron, mut face_area: impl FnMut(usize, f64)) -> Sums {
    let centre = DVec3::from(ball.centre()) - polyhedron.origin();
    let scale = 1.0 / ball.radius();
    let zero = Vector::new(0.0, 0.0, 0.0);

    let vertices = polyhedron.vertices();
    let mut stack = [zero; ON_STACK];
    let mut heap = Vec::new();
    let shifted: &mut [Vector<f64>] = if vertices.len() <= ON_STACK {
        &mut stack[..vertices.len()]
    } else {
        heap.resize(vertices.len(), zero);
        &mut heap
    };
    let mut farthest: f64 = 0.0;
    for (to, &from) in shifted.iter_mut().zip(vertices) {
        let v = (from - centre) * scale;
        farthest = farthest.max(v.length_squared());
        *to = Vector::new(v.x, v.y, v.z);
    }

    let mut ring_stack = [zero; ON_STACK];
    let mut ring_heap = Vec::new();
    let mut sums = Sums {
        volume3: 0.0,
        solid_angle: 0.0,
        area_normal: DVec3::ZERO,
        touched: false,
        bound: ErrorBound::new(farthest.sqrt()),
    };
    for (piece, corners) in polyhedron.rings() {
        let ring: &mut [Vector<f64>] = if corners.len() <= ON_STACK {
            &mut ring_stack[..corners.len()]
        } else {
            ring_heap.resize(corners.len(), zero);
            &mut ring_heap
        };
        for (to, &k) in ring.iter_mut().zip(corners) {
            *to = shifted[k as usize];
        }
        let n = piece.normal;
        let terms = face_terms(Vector::new(n.x, n.y, n.z), ring);
        sums.volume3 += terms.distance * terms.area + terms.solid_angle;
        sums.solid_angle += terms.solid_angle;
        if terms.distance.abs() < 1.0 {
            sums.bound.add(terms.area.abs(), piece.flatness, piece.warp * scale);
        }
        if terms.area != 0.0 {
            sums.touched = true;
            sums.area_normal += terms.area * n;
            face_area(piece.face as usize, terms.area);
        }
    }
    sums
}

fn finish_volume(ball: &Ball, element_volume: f64, sums: &Sums) -> f64 {
    volume_from_terms(ball, element_volume, sums.volume3, sums.solid_angle, sums.touched)
}

/// The volume from the sums of [`face_terms`] over a closed surface, in units of the ball's radius.
///
/// `volume3` is $\sum (d_f A_f + \Omega_f)$, `solid_angle` $\sum \Omega_f$; `touched` says whether any face area is not 0.
/// Where no face meets the ball the solid angle is 0 or 4π, and the result exactly 0 or the ball's volume.
///
/// ```
/// use std::f64::consts::PI;
/// use fieldstone_geometry::{Ball, volume_from_terms};
/// let ball = Ball::new([0.0; 3], 2.0)?;
/// // A large element that cuts the ball through its centre: no distance, and the solid angle of half the sphere.
/// let half = volume_from_terms(&ball, 1e3, 2.0 * PI, 2.0 * PI, true);
/// assert!((half - 0.5 * ball.volume()).abs() < 1e-14);
/// // No face meets the ball: 4π with the element around it, 0 without.
/// assert_eq!(volume_from_terms(&ball, 1e3, 4.0 * PI, 4.0 * PI, false), ball.volume());
/// assert_eq!(volume_from_terms(&ball, 1e3, 0.0, 0.0, false), 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[inline]
pub fn volume_from_terms(ball: &Ball, element_volume: f64, volume3: f64, solid_angle: f64, touched: bool) -> f64 {
    if !touched {
        let inside = solid_angle > 2.0 * std::f64::consts::PI;
        return if inside { ball.volume().min(element_volume) } else { 0.0 };
    }
    (volume3 / 3.0 * ball.radius().powi(3)).clamp(0.0, ball.volume().min(element_volume))
}
