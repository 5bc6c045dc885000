//! What three faces cut out of the ball beyond the vertex where they meet (Eq. 1, Fig. 5, Sec. 4.4).

use glam::DVec3;

use super::element::{Edge, Face, Vertex};
use super::general_wedge::{EPSILON, WedgePlanes, unit_general_wedge};
use super::part::Part;
use crate::double_double::DoubleDouble;

/// A vertex inside the unit ball and what is known of its surroundings.
pub(crate) struct Cone<'a> {
    pub vertex: &'a Vertex,
    /// The vertex, seen from the ball's centre.
    pub point: DVec3,
    pub edges: &'a [Edge],
    pub faces: &'a [Face],
    /// Signed distance of each face's plane from the centre.
    pub plane_distance: &'a [f64; 6],
    /// For each of the vertex's edges: its length *outside* the element, from the vertex to the sphere.
    pub reach: [f64; 3],
    /// Wedge of each of the element's edges.
    pub wedges: &'a [Part; 12],
    /// Which of the element's vertices this is.
    pub index: u8,
}

impl Cone<'_> {
    /// Eq. 1, $V_\mathrm{cone} = V_\mathrm{tetra} + V_\mathrm{cap} - \sum_\mathrm{sides} V_\mathrm{wedge}$.
    ///
    /// The cone is bounded by the extensions of the three edges beyond the vertex; they reach the sphere at
    /// $\vec v + \vec y_j$. Everything is computed from the $\vec y_j$, which keep their relative accuracy however
    /// close to the sphere the vertex is. Three terms can degenerate:
    ///
    /// * all three $\vec y_j$ vanish: the cone is nothing;
    /// * two vanish: the cone is the wedge of the third edge, already known;
    /// * the $\vec y_j$ differ by orders of magnitude, so that the base plane's normal, the cross product of their
    ///   differences, cancels: it is formed in [`DoubleDouble`].
    pub fn part(&self) -> Part {
        let reach = self.reach;
        let collapsed = reach.map(|s| s <= EPSILON);
        match collapsed {
            [true, true, true] => return Part::default(),
            [true, true, false] => return self.wedges[usize::from(self.vertex.edges[2])],
            [true, false, true] => return self.wedges[usize::from(self.vertex.edges[1])],
            [false, true, true] => return self.wedges[usize::from(self.vertex.edges[0])],
            _ => {}
        }
        let y = [0, 1, 2].map(|j| {
            let edge = &self.edges[usize::from(self.vertex.edges[j])];
            let into_element = if edge.vertices[0] == self.index { edge.direction } else { -edge.direction };
            into_element * -reach[j]
        });
        // The edges are right-handed, so their extensions, turned round, are left-handed: y0 → y2 → y1 runs
        // counter-clockwise seen from outside the cone, and this normal points away from the vertex.
        let Some(base) = base_normal(y) else {
            return Part::default();
        };
        let tetrahedron = reach[0] * reach[1] * reach[2] * self.vertex.determinant / 6.0;
        let base_distance = base.dot(self.point + (y[0] + y[1] + y[2]) / 3.0);
        let mut part = Part { volume: tetrahedron, area: 0.0 } + Part::cap(base_distance);
        for i in 0..3 {
            let (from, to) = (y[(i + 1) % 3], y[(i + 2) % 3]);
            let chord = to - from;
            let length = chord.length();
            if length == 0.0 {
                continue;
            }
            let along = chord / length;
            let face = usize::from(self.vertex.faces[i]);
            let side = self.faces[face].normal;
            // Both ends are on the sphere, so the middle is the foot of the perpendicular from the centre.
            let middle = self.point + 0.5 * (from + to);
            let planes = WedgePlanes {
                s: [middle.dot(base), -self.plane_distance[face]],
                c: [middle.dot(base.cross(along)), middle.dot(side.cross(along))],
                normals: [base, -side],
            };
            part -= unit_general_wedge(&planes, 0.5 * length);
        }
        part
    }
}

/// Unit normal of the plane through three points, exact but for the last rounding.
///
/// `None` where the points lie on a line: there is then no cone.
fn base_normal(y: [DVec3; 3]) -> Option<DVec3> {
    let difference = |a: DVec3, b: DVec3| {
        [
            DoubleDouble::from_difference(a.x, b.x),
            DoubleDouble::from_difference(a.y, b.y),
            DoubleDouble::from_difference(a.z, b.z),
        ]
    };
    let (a, b) = (difference(y[2], y[0]), difference(y[1], y[0]));
    let component = |i: usize, j: usize| f64::from(a[i] * b[j] - a[j] * b[i]);
    DVec3::new(component(1, 2), component(2, 0), component(0, 1)).try_normalize()
}
