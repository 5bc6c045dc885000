//! Overlap of a ball with a polyhedron: one evaluation gives volume, areas and gradient.

use glam::DVec3;

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
}

/// How a ball lies to a polyhedron, where that is cheap to tell.
enum Placement {
    /// They have no point in common, or touch only.
    Apart,
    /// All of the polyhedron is in the ball.
    AllOfPolyhedron,
    /// The kernel has to look.
    Unknown,
}

/// Volume of the part of `ball` inside `polyhedron`.
///
/// $$ 3 V = \sum_f \left( d_f A_f + \Omega_f \right) $$
///
/// over the faces, see [`face_terms`]. Apart: exactly 0. One inside the other: exactly the smaller volume.
///
/// Accuracy (measured against 60 digits, see the crate's documentation): a few 1e-16 r³ absolute, so at best a
/// relative error of the order of 1e-15 where ball and element are of like size; [`error_estimate`] tells
/// where the ratio of sizes or a flat element spoils that.
///
/// Cost: two `atan2` per edge and face outside the ball. No allocation for up to 32 corners.
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
    match placement(ball, polyhedron) {
        Placement::Apart => 0.0,
        Placement::AllOfPolyhedron => polyhedron.volume(),
        Placement::Unknown => finish_volume(ball, polyhedron.volume(), &sum_pieces(ball, polyhedron, |_, _| ())),
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
/// Accuracy and cost as [`overlap_volume`], plus one allocation for the face areas.
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
    let mut face_areas = vec![0.0; polyhedron.face_areas().len()];
    match placement(ball, polyhedron) {
        Placement::Apart => Overlap { face_areas, ..Overlap::default() },
        Placement::AllOfPolyhedron => {
            Overlap { volume: polyhedron.volume(), face_areas: polyhedron.face_areas().to_vec(), ..Overlap::default() }
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
            Overlap { volume, sphere_area, gradient: (-r2 * sums.area_normal).to_array(), face_areas }
        }
    }
}

/// Estimate of the absolute error of [`overlap_volume`] in `f64`, from the sizes involved.
///
/// $$ \varepsilon \left( 8 r^3 + 4 \sum_f A_f \, \rho_f \, \kappa_f \right) + \delta V $$
///
/// with $\rho_f$ the distance of the farthest corner of a cut piece from the centre, $A_f \le \min(\pi r^2,
/// \text{area})$ $\kappa_f$ the piece's squared diameter over twice its area, and $\delta V$ the rounding of the element's own volume. An estimate, not a bound: on the reference
/// cases it is above the error except for rare cases within a small factor. Where it exceeds what you need —
/// typically for balls more than 1,000 times larger than the element — `f64` is not enough.
///
/// ```
/// use fieldstone_geometry::{Ball, Polyhedron, error_estimate};
/// let cube = Polyhedron::cuboid([0.0; 3], [1.0; 3])?;
/// assert!(error_estimate(&Ball::new([0.0; 3], 1.0)?, &cube) < 1e-13);
/// assert!(error_estimate(&Ball::new([1e5, 0.0, 0.0], 1e5)?, &cube) > 0.1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn error_estimate(ball: &Ball, polyhedron: &Polyhedron) -> f64 {
    let centre = DVec3::from(ball.centre());
    let r = ball.radius();
    let vertices = polyhedron.vertices();
    let (low, high) = polyhedron.low_high();
    // Whether the ball reaches the element is itself known only to the rounding of the distances.
    let rounding = 8.0 * f64::EPSILON * (r + centre.abs().max(low.abs()).max(high.abs()).max_element());
    if (centre - centre.clamp(low, high)).length() > r + rounding {
        return 0.0;
    }
    if vertices.iter().all(|&v| (v - centre).length() < r - rounding) {
        return polyhedron.volume_error();
    }
    let mut sum = 8.0 * r.powi(3);
    for (piece, corners) in polyhedron.rings() {
        let at = |k: u32| vertices[k as usize];
        if piece.normal.dot(at(corners[0]) - centre).abs() > r + rounding {
            continue;
        }
        let reach = corners.iter().map(|&k| (at(k) - centre).length()).fold(0.0, f64::max);
        let diameter = corners.iter().map(|&k| (at(k) - at(corners[0])).length()).fold(0.0, f64::max);
        let twice_area = corners[1..]
            .windows(2)
            .map(|p| (at(p[0]) - at(corners[0])).cross(at(p[1]) - at(corners[0])))
            .sum::<DVec3>()
            .length();
        let cut = (std::f64::consts::PI * r * r).min(0.5 * twice_area);
        sum += 4.0 * cut * reach * (diameter * diameter / twice_area).max(1.0);
    }
    f64::EPSILON * sum + polyhedron.volume_error()
}

fn placement(ball: &Ball, polyhedron: &Polyhedron) -> Placement {
    let centre = DVec3::from(ball.centre());
    let r2 = ball.radius() * ball.radius();
    let (low, high) = polyhedron.low_high();
    if (centre - centre.clamp(low, high)).length_squared() >= r2 {
        return Placement::Apart;
    }
    // Cheaper than the corners: no corner can be inside where the far corner of the box is not, or is.
    let far = (centre - low).abs().max((high - centre).abs());
    if far.length_squared() <= r2 || polyhedron.vertices().iter().all(|&v| (v - centre).length_squared() <= r2) {
        return Placement::AllOfPolyhedron;
    }
    Placement::Unknown
}

/// Corners of an element, or of a piece, on the stack up to this many.
const ON_STACK: usize = 32;

fn sum_pieces(ball: &Ball, polyhedron: &Polyhedron, mut face_area: impl FnMut(usize, f64)) -> Sums {
    let centre = DVec3::from(ball.centre());
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
    for (to, &from) in shifted.iter_mut().zip(vertices) {
        let v = (from - centre) * scale;
        *to = Vector::new(v.x, v.y, v.z);
    }

    let mut ring_stack = [zero; ON_STACK];
    let mut ring_heap = Vec::new();
    let mut sums = Sums { volume3: 0.0, solid_angle: 0.0, area_normal: DVec3::ZERO, touched: false };
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
#[inline]
pub fn volume_from_terms(ball: &Ball, element_volume: f64, volume3: f64, solid_angle: f64, touched: bool) -> f64 {
    if !touched {
        let inside = solid_angle > 2.0 * std::f64::consts::PI;
        return if inside { ball.volume().min(element_volume) } else { 0.0 };
    }
    (volume3 / 3.0 * ball.radius().powi(3)).clamp(0.0, ball.volume().min(element_volume))
}
