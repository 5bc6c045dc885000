use std::collections::HashMap;

use glam::DVec3;

use crate::SurfaceError;

/// A surface of triangles, wound so that their normals point out of the fluid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TriangleMesh {
    /// Corners.
    pub points: Vec<[f64; 3]>,
    /// Three corners each.
    pub triangles: Vec<[u32; 3]>,
    /// Outward unit normal at each corner.
    pub normals: Vec<[f64; 3]>,
}

/// How the triangles of a [`TriangleMesh`] hang together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Topology {
    /// Edges of a single triangle: the rim of a hole.
    pub open_edges: usize,
    /// Edges of more than two triangles.
    pub branching_edges: usize,
    /// Edges that two triangles pass in the same direction: one of them is wound the wrong way.
    pub turned_edges: usize,
    /// Corners around which the triangles do not form a single fan.
    pub pinched_points: usize,
    /// Triangles that name a corner twice.
    pub collapsed_triangles: usize,
    /// Connected parts.
    pub components: usize,
    /// Corners − edges + triangles: 2 for each part like a sphere, 0 for each like a torus.
    pub euler_characteristic: i64,
}

impl Topology {
    /// Whether the surface is watertight: every edge has exactly two triangles, wound alike.
    pub fn is_closed(&self) -> bool {
        self.open_edges == 0 && self.branching_edges == 0 && self.turned_edges == 0 && self.collapsed_triangles == 0
    }

    /// Whether every point of the surface has a neighbourhood like a disc, or like half of one at a rim.
    pub fn is_manifold(&self) -> bool {
        self.branching_edges == 0 && self.pinched_points == 0 && self.collapsed_triangles == 0
    }
}

impl TriangleMesh {
    /// Volume that a closed surface encloses; cavities count negative.
    ///
    /// $$ V = \tfrac16 \sum_t a_t \cdot (b_t \times c_t) $$
    ///
    /// Corners are taken relative to the first one, so that distance from the origin costs no digits.
    pub fn volume(&self) -> f64 {
        self.corners().map(|[a, b, c]| a.dot(b.cross(c))).sum::<f64>() / 6.0
    }

    /// Area of all triangles.
    pub fn area(&self) -> f64 {
        self.corners().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
    }

    fn corners(&self) -> impl Iterator<Item = [DVec3; 3]> {
        let origin = DVec3::from(self.points.first().copied().unwrap_or_default());
        self.triangles.iter().map(move |t| t.map(|p| DVec3::from(self.points[p as usize]) - origin))
    }

    /// Checks how the triangles hang together.
    ///
    /// Cost: a few passes over the triangles, with a table of edges.
    ///
    /// # Errors
    /// [`SurfaceError::Length`] where a triangle names a point that does not exist.
    ///
    /// ```
    /// use fieldstone_surface::TriangleMesh;
    /// let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let tetrahedron = TriangleMesh { points, triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], normals: vec![] };
    /// let found = tetrahedron.topology()?;
    /// assert!(found.is_closed() && found.is_manifold() && found.euler_characteristic == 2);
    /// assert!((tetrahedron.volume() - 1.0 / 6.0).abs() < 1e-16);
    /// # Ok::<(), fieldstone_surface::SurfaceError>(())
    /// ```
    pub fn topology(&self) -> Result<Topology, SurfaceError> {
        let count = self.points.len();
        if let Some(&bad) = self.triangles.as_flattened().iter().find(|p| **p as usize >= count) {
            return Err(SurfaceError::Length {
                name: "the table of corners",
                found: count,
                expected: bad as usize + 1,
            });
        }
        let mut found = Topology::default();
        // For each edge, by its smaller corner first: passes forwards and backwards.
        let mut edges: HashMap<(u32, u32), (u32, u32)> = HashMap::with_capacity(3 * self.triangles.len() / 2);
        for &[a, b, c] in &self.triangles {
            found.collapsed_triangles += usize::from(a == b || b == c || c == a);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let passes = edges.entry((from.min(to), from.max(to))).or_default();
                if from < to { passes.0 += 1 } else { passes.1 += 1 }
            }
        }
        for &(forwards, backwards) in edges.values() {
            match forwards + backwards {
                1 => found.open_edges += 1,
                2 => found.turned_edges += usize::from(forwards != 1),
                _ => found.branching_edges += 1,
            }
        }
        let mut used = vec![false; count];
        self.triangles.as_flattened().iter().for_each(|&p| used[p as usize] = true);
        let corners = used.iter().filter(|used| **used).count();
        found.euler_characteristic = corners as i64 - edges.len() as i64 + self.triangles.len() as i64;
        found.pinched_points = self.pinched_points();
        found.components = self.components(&used);
        Ok(found)
    }

    /// Corners whose triangles, joined along common edges, fall into more than one part.
    fn pinched_points(&self) -> usize {
        let mut starts = vec![0u32; self.points.len() + 1];
        self.triangles.as_flattened().iter().for_each(|&p| starts[p as usize + 1] += 1);
        for p in 0..self.points.len() {
            starts[p + 1] += starts[p];
        }
        let mut around = vec![0u32; 3 * self.triangles.len()];
        let mut next = starts.clone();
        for (t, triangle) in self.triangles.iter().enumerate() {
            for &p in triangle {
                around[next[p as usize] as usize] = t as u32;
                next[p as usize] += 1;
            }
        }
        let mut links: Vec<[u32; 2]> = Vec::new();
        let mut pinched = 0;
        for p in 0..self.points.len() {
            links.clear();
            for &t in &around[starts[p] as usize..starts[p + 1] as usize] {
                let mut others = self.triangles[t as usize].iter().copied().filter(|&q| q as usize != p);
                if let (Some(a), Some(b)) = (others.next(), others.next()) {
                    links.push([a, b]);
                }
            }
            // Grow one fan from the first triangle; a handful of triangles, so plainly.
            let Some(mut fan) = links.pop().map(Vec::from) else { continue };
            while let Some(at) = links.iter().position(|link| link.iter().any(|q| fan.contains(q))) {
                fan.extend(links.swap_remove(at));
            }
            pinched += usize::from(!links.is_empty());
        }
        pinched
    }

    fn components(&self, used: &[bool]) -> usize {
        let mut parent: Vec<u32> = (0..self.points.len() as u32).collect();
        fn root(parent: &mut [u32], mut p: u32) -> u32 {
            while parent[p as usize] != p {
                parent[p as usize] = parent[parent[p as usize] as usize];
                p = parent[p as usize];
            }
            p
        }
        for &[a, b, c] in &self.triangles {
            let to = root(&mut parent, a);
            for p in [b, c] {
                let from = root(&mut parent, p);
                parent[from as usize] = to;
            }
        }
        (0..self.points.len()).filter(|&p| used[p] && parent[p] as usize == p).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron(offset: u32) -> Vec<[u32; 3]> {
        [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|t| t.map(|p| p + offset)).to_vec()
    }

    fn mesh(count: usize, triangles: Vec<[u32; 3]>) -> TriangleMesh {
        TriangleMesh { points: vec![[0.0; 3]; count], triangles, normals: Vec::new() }
    }

    #[test]
    fn a_missing_triangle_leaves_three_open_edges() {
        let found = mesh(4, tetrahedron(0)[1..].to_vec()).topology().unwrap();
        assert_eq!((found.open_edges, found.is_closed(), found.is_manifold()), (3, false, true));
    }

    #[test]
    fn a_turned_triangle_is_found() {
        let mut triangles = tetrahedron(0);
        triangles[2].swap(0, 1);
        let found = mesh(4, triangles).topology().unwrap();
        assert_eq!((found.turned_edges, found.is_closed()), (3, false));
    }

    #[test]
    fn two_bodies_that_touch_in_a_corner_are_pinched_there() {
        let second = tetrahedron(3).into_iter();
        let found = mesh(7, tetrahedron(0).into_iter().chain(second).collect()).topology().unwrap();
        assert!(found.is_closed() && !found.is_manifold());
        assert_eq!((found.pinched_points, found.components), (1, 1));
    }

    #[test]
    fn two_bodies_that_share_an_edge_branch_there() {
        let second = tetrahedron(4).into_iter().map(|t| t.map(|p| if p < 6 { p - 4 } else { p }));
        let found = mesh(8, tetrahedron(0).into_iter().chain(second).collect()).topology().unwrap();
        assert_eq!((found.branching_edges, found.is_manifold()), (1, false));
    }

    #[test]
    fn a_corner_that_does_not_exist_is_an_error() {
        assert!(mesh(3, tetrahedron(0)).topology().is_err());
    }
}
