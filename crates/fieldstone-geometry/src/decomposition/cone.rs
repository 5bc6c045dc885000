//! What three faces cut out of the ball beyond the vertex where they meet (Eq. 1, Fig. 5, Sec. 4.4).

use glam::DVec3;

use super::element::{Edge, Face, Vertex};
use super::general_wedge::{EPSILON, WedgePlanes, unit_general_wedge};
use super::part::Part;
use crate::double_double::cross_of_differences;

/// A vertex inside the unit ball and what is known of its surroundings.
pub(crate) struct Cone<'a> {
    pub vertex: &'a Vertex,
    /// The vertex, seen from the ball's centre.
    pub point: DVec3,
    pub edges: &'a [Edge],
    pub faces: &'a [Face],
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
    /// * two vanish: the cone is the wedge of the third edge, already known, provided that this edge leads out of the
    ///   ball, so that its extension crosses it; else the third $\vec y_j$ is next to nothing too, if above the
    ///   threshold by chance, and so is the cone;
    /// * the $\vec y_j$ differ by orders of magnitude, so that the base plane's normal, the cross product of their
    ///   differences, cancels: it is formed in double-double.
    pub fn part(&self) -> Part {
        let reach = self.reach;
        let collapsed = reach.map(|s| s <= EPSILON);
        if let Some(third) = [0, 1, 2].into_iter().find(|i| collapsed[(i + 1) % 3] && collapsed[(i + 2) % 3]) {
            let edge = usize::from(self.vertex.edges[third]);
            let leaves = self.point.dot(self.inward(third)) > 0.0;
            return if leaves { self.wedges[edge] } else { Part::default() };
        }
        let y = [0, 1, 2].map(|j| self.inward(j) * -reach[j]);
        // The edges are right-handed, so their extensions, turned round, are left-handed: y0 → y2 → y1 runs
        // counter-clockwise seen from outside the cone, and this normal points away from the vertex.
        let Some(base) = cross_of_differences([y[2], y[0]], [y[1], y[0]]).try_normalize() else {
            return Part::default();
        };
        let tetrahedron = reach[0] * reach[1] * reach[2] * self.vertex.determinant / 6.0;
        let base_distance = base.dot(self.point + (y[0] + y[1] + y[2]) / 3.0);
        let mut part = Part { triple_volume: 3.0 * tetrahedron, area: 0.0 } + Part::cap(base_distance);
        for i in 0..3 {
            let (from, to) = (y[(i + 1) % 3], y[(i + 2) % 3]);
            let chord = to - from;
            let length = chord.length();
            if length == 0.0 {
                continue;
            }
            let along = chord / length;
            let side = self.faces[usize::from(self.vertex.faces[i])].normal;
            // Both ends are on the sphere, so the middle is the foot of the perpendicular from the centre.
            let middle = self.point + 0.5 * (from + to);
            let planes = WedgePlanes::new(middle, [base, -side], [base.cross(along), side.cross(along)]);
            part -= unit_general_wedge(&planes, 0.5 * length);
        }
        part
    }

    /// Direction of one of the vertex's edges, out of the vertex.
    #[inline(always)]
    fn inward(&self, which: usize) -> DVec3 {
        let edge = &self.edges[usize::from(self.vertex.edges[which])];
        if edge.vertices[0] == self.index { edge.direction } else { -edge.direction }
    }
}
