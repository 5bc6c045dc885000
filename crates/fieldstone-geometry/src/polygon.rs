//! Area vector, centroid and planarity of a polygon that may be warped.

use glam::DVec3;

use crate::double_double::DoubleDouble;
use crate::precision::Wide;
use crate::{Real, Vector};

/// Area vector of a closed polygon: half the sum of the cross products of its corners about their mean.
///
/// Its length is the area where the polygon is planar; its direction is the mean normal, counter-clockwise.
///
/// ```
/// use fieldstone_geometry::polygon_area_vector;
/// let area = polygon_area_vector(&[[0.0; 3], [2.0, 0.0, 0.0], [2.0, 3.0, 0.0], [0.0, 3.0, 0.0]]);
/// assert_eq!(area, [0.0, 0.0, 6.0]);
/// ```
pub fn polygon_area_vector(corners: &[[f64; 3]]) -> [f64; 3] {
    let mean = mean(corners);
    let mut area = DVec3::ZERO;
    for_each_side(corners, |a, b| area += (a - mean).cross(b - mean));
    (0.5 * area).to_array()
}

/// The area-weighted centroid of a polygon, as OpenFOAM defines the centre of a face.
///
/// The polygon is fanned around the mean of its corners; the centroid is the mean of the triangles' centroids,
/// weighted by the triangles' (unsigned) areas. A triangle's centroid is the mean of its corners.
///
/// For a polyhedron whose warped faces are fanned around this point, the volume equals the one that OpenFOAM
/// computes, because all triangles of a fan share their apex.
///
/// ```
/// use fieldstone_geometry::polygon_centroid;
/// // A trapezium with parallel sides of 4 and 2, and a height of 2.
/// let [x, y, z] = polygon_centroid(&[[0.0; 3], [4.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]]);
/// assert!((x - 14.0 / 9.0).abs() < 1e-15 && (y - 8.0 / 9.0).abs() < 1e-15 && z == 0.0);
/// ```
pub fn polygon_centroid(corners: &[[f64; 3]]) -> [f64; 3] {
    let mean = mean(corners);
    if corners.len() == 3 {
        return mean.to_array();
    }
    let mut total = 0.0;
    let mut weighted = DVec3::ZERO;
    for_each_side(corners, |a, b| {
        let area = (b - a).cross(mean - a).length();
        total += area;
        weighted += area * ((a - mean) + (b - mean));
    });
    if total > 0.0 { (mean + weighted / (3.0 * total)).to_array() } else { mean.to_array() }
}

/// Largest distance of a corner from the plane through the centroid normal to the area vector.
///
/// 0 for a triangle; infinity for a polygon without area, which has no plane.
///
/// ```
/// use fieldstone_geometry::polygon_warp;
/// // A saddle: corners in turn above and below the plane.
/// let saddle = [[0.0, 0.0, 0.125], [1.0, 0.0, -0.125], [1.0, 1.0, 0.125], [0.0, 1.0, -0.125]];
/// assert_eq!(polygon_warp(&saddle), 0.125);
/// ```
pub fn polygon_warp(corners: &[[f64; 3]]) -> f64 {
    if corners.len() == 3 {
        return 0.0;
    }
    let Some(normal) = DVec3::from(polygon_area_vector(corners)).try_normalize() else { return f64::INFINITY };
    // Relative to a corner: far from the origin the centroid itself would be rounded to what the coordinates resolve.
    let first = DVec3::from(corners[0]);
    let near: Vec<[f64; 3]> = corners.iter().map(|&p| (DVec3::from(p) - first).to_array()).collect();
    let centroid = DVec3::from(polygon_centroid(&near));
    near.iter().map(|&p| normal.dot(DVec3::from(p) - centroid).abs()).fold(0.0, f64::max)
}

/// How a planar polygon magnifies rounding: the square of its extent from the first corner over twice its area, at least 1.
///
/// The unit normal of a polygon with this flatness, computed from rounded corners, is off by about flatness × ε.
///
/// ```
/// use fieldstone_geometry::flatness;
/// let rectangle = |a: f64, b: f64| [[0.0; 3], [a, 0.0, 0.0], [a, b, 0.0], [0.0, b, 0.0]];
/// assert!((flatness(&rectangle(1.0, 1.0)) - 1.0).abs() < 1e-15);
/// // (10² + 1²) / (2 · 10)
/// assert!((flatness(&rectangle(10.0, 1.0)) - 5.05).abs() < 1e-14);
/// ```
pub fn flatness(corners: &[[f64; 3]]) -> f64 {
    let twice_area = 2.0 * DVec3::from(polygon_area_vector(corners)).length();
    // Finite, so that a face of which nothing is inside adds nothing to a bound, however flat it is.
    (extent(corners).powi(2) / twice_area).clamp(1.0, 1e18)
}

/// Upper bound of the distance of the corners from a common plane: 0 exactly where they lie in one, else
/// [`polygon_warp`] and what rounding may have hidden.
///
/// ```
/// use fieldstone_geometry::warp_bound;
/// assert_eq!(warp_bound(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]), 0.0);
/// let saddle = [[0.0, 0.0, 0.125], [1.0, 0.0, -0.125], [1.0, 1.0, 0.125], [0.0, 1.0, -0.125]];
/// let bound = warp_bound(&saddle);
/// assert!(bound > 0.125 && bound < 0.125 + 1e-14);
/// ```
pub fn warp_bound(corners: &[[f64; 3]]) -> f64 {
    if is_exactly_planar(corners) { 0.0 } else { polygon_warp(corners) + 8.0 * f64::EPSILON * extent(corners) }
}

/// Whether the corners lie in one plane, decided without rounding for coordinates of like magnitude.
///
/// ```
/// use fieldstone_geometry::is_exactly_planar;
/// // In the plane x + y + z = 1, then with one coordinate moved by its last bit.
/// let mut corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.5, 0.75, 0.75], [0.25, 0.25, 0.5]];
/// assert!(is_exactly_planar(&corners));
/// corners[3][2] = f64::next_up(0.5);
/// assert!(!is_exactly_planar(&corners));
/// ```
pub fn is_exactly_planar(corners: &[[f64; 3]]) -> bool {
    let [first, _, _, ..] = corners else { return true };
    if corners.len() == 3 || (0..3).any(|k| corners.iter().all(|p| p[k] == first[k])) {
        return true;
    }
    // Double-double tells most polygons that are off by a rounding; only what it finds at zero needs every bit.
    let (largest, size) = off_plane::<DoubleDouble>(corners);
    largest <= 1e-28 * size && off_plane::<Wide>(corners).0 == 0.0
}

/// Largest of the corners' heights over the mean plane, times twice the area; and the size of its terms.
fn off_plane<R: Real>(corners: &[[f64; 3]]) -> (f64, f64) {
    let first = Vector::<R>::from_f64(corners[0]);
    let at: Vec<Vector<R>> = corners.iter().map(|&p| Vector::from_f64(p) - first).collect();
    let zero = R::from_f64(0.0);
    let normal = at[1..].windows(2).fold(Vector::new(zero, zero, zero), |n, p| n + p[0].cross(p[1]));
    let largest = at.iter().map(|&v| normal.dot(v).to_f64().abs()).fold(0.0, f64::max);
    (largest, extent(corners) * normal.length().to_f64().max(extent(corners).powi(2)))
}

/// Largest distance of a corner from the first.
fn extent(corners: &[[f64; 3]]) -> f64 {
    let Some(&first) = corners.first() else { return 0.0 };
    corners.iter().map(|&p| (DVec3::from(p) - DVec3::from(first)).length()).fold(0.0, f64::max)
}

fn mean(corners: &[[f64; 3]]) -> DVec3 {
    // Relative to the first corner: far from the origin the plain sum would lose digits.
    let Some(&first) = corners.first() else { return DVec3::ZERO };
    let first = DVec3::from(first);
    let offset: DVec3 = corners.iter().map(|&p| DVec3::from(p) - first).sum();
    first + offset / corners.len() as f64
}

fn for_each_side(corners: &[[f64; 3]], mut visit: impl FnMut(DVec3, DVec3)) {
    for (k, &a) in corners.iter().enumerate() {
        let b = corners[(k + 1) % corners.len()];
        visit(DVec3::from(a), DVec3::from(b));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centroid_of_a_planar_polygon_is_its_centre_of_area() {
        // An L shape is not convex about its vertex mean, but this trapezium is.
        let c = polygon_centroid(&[[0.0; 3], [4.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]]);
        // Centre of area of a right trapezium with parallel sides 4 and 2, height 2.
        assert!((c[0] - 14.0 / 9.0).abs() < 1e-15 && (c[1] - 8.0 / 9.0).abs() < 1e-15, "{c:?}");
    }

    #[test]
    fn a_lifted_corner_is_the_warp() {
        assert_eq!(polygon_warp(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]), 0.0);
        let w = polygon_warp(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.1], [0.0, 1.0, 0.0]]);
        assert!(w > 0.02 && w < 0.05, "{w}");
    }

    #[test]
    fn planarity_is_decided_to_the_last_bit() {
        // In the plane x + y + z = 1, exactly; then with one coordinate moved by its last bit.
        let mut quad = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.5, 0.75, 0.75], [0.25, 0.25, 0.5]];
        assert!(is_exactly_planar(&quad));
        assert_eq!(warp_bound(&quad), 0.0);
        quad[3][2] = 0.5_f64.next_up();
        assert!(!is_exactly_planar(&quad));
        assert!(warp_bound(&quad) > 0.0);
        // In the plane 3x = y with coordinates of 53 bits and an offset: products need more than 106 bits.
        let x = 1.0 + f64::EPSILON;
        assert!(is_exactly_planar(&[[0.0, 0.0, 0.1], [0.25, 0.75, 0.3], [0.5, 1.5, x], [0.125, 0.375, -x]]));
    }

    #[test]
    fn a_polygon_without_area_has_no_plane() {
        assert_eq!(polygon_warp(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]]), f64::INFINITY);
    }
}
