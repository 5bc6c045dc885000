//! Which vertices, edges and faces of an element the ball meets (Algorithm 2).
//!
//! # Correction
//!
//! Line 13 as printed marks the vertex closest to the centre also where *both* intersections lie inside the edge,
//! i.e. where neither vertex is in the ball: a ball of radius 0.8 around the centre of a unit cube then gets 7 marked
//! vertices, or 8, as ties are broken (the consistency pass cannot remove them, since all twelve edges are marked), where the true number is 0.
//! The rule meant, and used here, is: the first vertex is marked iff $i_0 < 0$, the second iff $i_1 > 1$.
//!
//! # One decision per vertex
//!
//! "If a vertex is marked, so have to be all edges and faces at this vertex": the paper restores this by a pass that
//! removes vertices with an unmarked edge. The pass leaves the *other* edges of such a vertex marked, though; where the
//! sphere's surface runs through a vertex, these edges' wedges are then added and never taken off (a ball that
//! touches a cube's corner at (1, 1, 0) from (1.4, 1.3, 0) gets −0.48 instead of 0). Here the sign of
//! $i_0 \cdot i_1 = (|\vec v_0|^2 - r^2) / \ell^2$ and its like for the second vertex is decided *once per vertex* and
//! shared by the three edges: a marked vertex has all its edges marked and, unmarked, forces none. Only edges
//! with both vertices outside are tested for the foot point, $0 < -m_0$, $0 < m_1$, $h^2 < r^2$, where $m_0$ and $m_1$
//! are the vertices' positions along the edge from the foot and $h$ is the distance of the line. The terms of
//! Eq. 2 change continuously when a vertex is moved across the sphere, so it does not matter which way rounding decides.
//! That the consistency pass has nothing left to do is asserted in debug builds.

use glam::DVec3;

use super::element::DecompositionElement;

/// What the ball meets, one bit each, and the lengths found on the way; the ball is the unit ball at the origin.
#[derive(Debug, Clone)]
pub(crate) struct Intersections {
    /// Vertices inside the ball.
    pub vertices: u8,
    /// Edges that enter the ball.
    pub edges: u16,
    /// Faces whose polygon meets the ball.
    pub faces: u8,
    /// The vertices, seen from the ball's centre.
    pub points: [DVec3; 8],
    /// $1 - |\vec v|^2$ for each vertex.
    pub depth: [f64; 8],
    /// Signed distance of each face's plane from the centre.
    pub distance: [f64; 6],
    /// For each edge, the positions of its vertices along the line, from the foot point.
    pub position: [[f64; 2]; 12],
}

impl Intersections {
    /// The vertices only: enough to see that the element lies inside the ball.
    #[inline]
    pub fn of_vertices(element: &DecompositionElement, centre: DVec3, inverse_radius: f64) -> Self {
        let mut found = Self {
            vertices: 0,
            edges: 0,
            faces: 0,
            points: [DVec3::ZERO; 8],
            depth: [0.0; 8],
            distance: [0.0; 6],
            position: [[0.0; 2]; 12],
        };
        for (index, &point) in element.points().iter().enumerate() {
            let point = (point - centre) * inverse_radius;
            let depth = 1.0 - point.length_squared();
            found.points[index] = point;
            found.depth[index] = depth;
            found.vertices |= u8::from(depth > 0.0) << index;
        }
        found
    }

    /// Distances of the planes; false where the whole ball lies on the outer side of one of them.
    #[inline]
    pub fn planes(&mut self, element: &DecompositionElement, centre: DVec3, inverse_radius: f64) -> bool {
        let mut nearest = f64::INFINITY;
        for (index, face) in element.faces().iter().enumerate() {
            let distance = face.normal.dot(face.centre - centre) * inverse_radius;
            self.distance[index] = distance;
            nearest = nearest.min(distance);
        }
        nearest > -1.0
    }

    /// Algorithm 2 from line 3: edges, then the faces that no edge marks.
    #[inline]
    pub fn edges_and_faces(&mut self, element: &DecompositionElement, inverse_radius: f64) {
        // Faces whose foot point lies outside one of their edges: the disc, if any, meets the polygon through an edge.
        let mut foot_outside = 0_u8;
        for (index, edge) in element.edges().iter().enumerate() {
            let [v0, v1] = edge.vertices.map(usize::from);
            let [f0, f1] = edge.faces.map(usize::from);
            let point = self.points[v0];
            let in_plane = [point.dot(edge.outward[0]), point.dot(edge.outward[1])];
            foot_outside |= u8::from(in_plane[0] <= 0.0) << f0 | u8::from(in_plane[1] <= 0.0) << f1;
            let m0 = point.dot(edge.direction);
            let m1 = m0 + edge.length * inverse_radius;
            // The plane's distance and the one within it are the legs of the triangle with the line's distance.
            let distance_squared = self.distance[f0] * self.distance[f0] + in_plane[0] * in_plane[0];
            let vertex_inside = self.vertices >> v0 & 1 != 0 || self.vertices >> v1 & 1 != 0;
            self.position[index] = [m0, m1];
            if vertex_inside || (m0 < 0.0 && m1 > 0.0 && distance_squared < 1.0) {
                self.edges |= 1 << index;
                self.faces |= 1 << f0 | 1 << f1;
            }
        }
        self.debug_assert_consistent(element);
        for (index, distance) in self.distance[..element.faces().len()].iter().enumerate() {
            let meets_inside = distance.abs() < 1.0 && foot_outside >> index & 1 == 0;
            self.faces |= u8::from(meets_inside) << index;
        }
    }

    /// The consistency pass of lines 19–24, which by construction finds nothing.
    fn debug_assert_consistent(&self, element: &DecompositionElement) {
        debug_assert!(
            element.vertices().iter().enumerate().all(|(index, vertex)| {
                self.vertices >> index & 1 == 0 || vertex.edges.iter().all(|&e| self.edges >> e & 1 != 0)
            }),
            "a marked vertex has an unmarked edge"
        );
    }
}
