use std::collections::BTreeMap;
use std::fmt;

use crate::SphError;
use crate::triangle_tree::TriangleTree;

/// Cells of the lattice of corners along the largest extent: 2³⁸.
///
/// Products of three coordinates then fit into 128 bits.
const CELLS: f64 = (1u64 << 38) as f64;

/// Cosine between a ray and the outward normal where it leaves the solid, above which the faces at both its ends count
/// as the two sides of a plate: they make an angle below 30°.
const OPPOSITE: f64 = 0.866;

/// A solid bounded by a closed surface of triangles.
///
/// A point is inside where the surface winds around it,
///
/// $$ w(x) = \frac1{4\pi}\sum_t \Omega_t(x) = \sum_{t\text{ crossed by a ray from } x}\operatorname{sign}(n_t\cdot e) \ne 0 $$
///
/// so parts may overlap, and a part inside another with its normals inwards is a cavity. The winding number of a
/// closed surface is a whole number that any ray tells; here the ray along +x.
///
/// | symbol | meaning |
/// |---|---|
/// | Ω_t | solid angle of a triangle, seen from x |
/// | n_t | its normal |
/// | e | direction of the ray |
///
/// Corners are moved to a lattice of 2⁻³⁸ of the largest extent, and whether a ray crosses a triangle is decided in
/// whole numbers, with ties broken by moving the point by the same infinitesimal vector for all triangles: rays
/// through edges and corners, and points on the surface, are no special cases. Inside and outside can therefore be wrong
/// only within 4·10⁻¹² of the extent from the surface. Cost: about log n per point in a tree of n triangles, more where
/// many are crossed.
///
/// ```
/// use fieldstone_sph::ClosedSurface;
/// let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
/// let tetrahedron = ClosedSurface::new(corners.clone(), faces.clone())?;
/// assert!((tetrahedron.volume() - 1.0 / 6.0).abs() < 1e-11);
/// assert!((tetrahedron.depth([0.1, 0.2, 0.3]) - 0.1).abs() < 1e-11);
/// assert!(tetrahedron.depth([0.5, 0.5, 0.5]) < 0.0);
/// let error = ClosedSurface::new(corners, faces[..3].to_vec()).unwrap_err().to_string();
/// assert!(error.starts_with("the surface is not closed: 3 edges"), "{error}");
/// # Ok::<(), fieldstone_sph::SphError>(())
/// ```
#[derive(Clone, PartialEq)]
pub struct ClosedSurface {
    /// Lower corner of the bounding box, and a cell of the lattice.
    origin: [f64; 3],
    cell: f64,
    high: [f64; 3],
    volume: f64,
    tree: TriangleTree,
}

impl fmt::Debug for ClosedSurface {
    /// Short: without its triangles.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ClosedSurface")
            .field("origin", &self.origin)
            .field("cell", &self.cell)
            .field("triangles", &self.tree.triangles().len())
            .finish_non_exhaustive()
    }
}

impl ClosedSurface {
    /// A solid from points and triangles whose corners run counter-clockwise, seen from outside.
    ///
    /// Triangles all the other way round make the same solid.
    ///
    /// # Errors
    /// [`SphError::NoSolid`]: no triangle, a corner that does not exist or is not finite, no volume, or edges that are
    /// not shared by as many triangles in one direction as in the other: their number, and the first of them.
    pub fn new(points: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Result<Self, SphError> {
        let fault = |message: String| Err(SphError::NoSolid { message });
        if triangles.is_empty() {
            return fault("the surface has no triangles".into());
        }
        if let Some(bad) = points.iter().find(|p| p.iter().any(|x| !x.is_finite())) {
            return fault(format!("a corner is at {bad:?}; it must be finite"));
        }
        if let Some(bad) = triangles.iter().find(|t| t.iter().any(|&p| p as usize >= points.len())) {
            return fault(format!("a triangle names points {bad:?}, but there are {}", points.len()));
        }
        let (open, first) = open_edges(&triangles);
        if let Some(edge) = first {
            let [a, b] = edge.map(|p| points[p as usize]);
            let count = if open == 1 { "1 edge is".into() } else { format!("{open} edges are") };
            return fault(format!(
                "the surface is not closed: {count} not shared by two triangles of the same orientation, the first from \
                 {a:?} to {b:?}; close the holes and turn the triangles to one side in the program that made it"
            ));
        }
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &p in triangles.iter().flatten() {
            for k in 0..3 {
                low[k] = low[k].min(points[p as usize][k]);
                high[k] = high[k].max(points[p as usize][k]);
            }
        }
        let extent = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        let cell = extent / CELLS;
        if !(cell > 0.0 && extent.is_finite()) {
            return fault(format!("the surface lies between {low:?} and {high:?}; it must have a finite volume"));
        }
        let placed =
            |p: u32| -> [i64; 3] { std::array::from_fn(|k| ((points[p as usize][k] - low[k]) / cell).round() as i64) };
        let tree = TriangleTree::new(triangles.iter().map(|t| t.map(placed)).collect());
        let volume = tree.volume().abs() * cell.powi(3);
        if volume < 1e-12 * extent.powi(3) {
            return fault(format!("the surface encloses a volume of {volume:e}; it must be a solid"));
        }
        Ok(Self { origin: low, cell, high, volume, tree })
    }

    /// The box around it.
    pub fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        (self.origin, self.high)
    }

    /// Enclosed volume; what parts share counts as often as they do.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Number of triangles, without those that have no area.
    pub fn len(&self) -> usize {
        self.tree.triangles().len()
    }

    /// Whether there is no triangle: never.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Origin and cell of the lattice that corners are on, and a checksum of all triangles there, whatever their order.
    pub(crate) fn fingerprint(&self) -> ([f64; 3], f64, u64) {
        let of_triangle = |triangle: &[[i64; 3]; 3]| {
            let mut hasher = crc32fast::Hasher::new();
            triangle.as_flattened().iter().for_each(|x| hasher.update(&x.to_le_bytes()));
            u64::from(hasher.finalize())
        };
        let sum = self.tree.triangles().iter().map(of_triangle).fold(0, u64::wrapping_add);
        (self.origin, self.cell, sum)
    }

    fn on_lattice(&self, x: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| (x[k] - self.origin[k]) / self.cell)
    }

    /// Whether a point is inside.
    pub fn contains(&self, x: [f64; 3]) -> bool {
        let inside = |k: usize| x[k] >= self.origin[k] && x[k] <= self.high[k];
        (0..3).all(inside) && self.tree.winding(self.on_lattice(x).map(|x| x.round() as i64)) != 0
    }

    /// Distance from the surface.
    pub fn distance(&self, x: [f64; 3]) -> f64 {
        self.cell * self.tree.distance(self.on_lattice(x))
    }

    /// Distance into the solid from its surface; negative outside.
    pub fn depth(&self, x: [f64; 3]) -> f64 {
        let distance = self.distance(x);
        if self.contains(x) { distance } else { -distance }
    }

    /// Where the solid is a plate, or a wedge below 30°, thinner than `needed`: its least thickness, and where.
    ///
    /// Rays go inwards at right angles from points of every triangle, at most `needed`/2 apart; where one leaves through
    /// a face that is within 30° of parallel to its own, its length is a thickness. Edges and corners of more than 30° are
    /// no plates.
    pub fn thinner_than(&self, needed: f64) -> Option<(f64, [f64; 3])> {
        let found = self.tree.thinnest(needed / self.cell, OPPOSITE, self.tree.volume() < 0.0);
        found
            .map(|(thickness, at)| (thickness * self.cell, std::array::from_fn(|k| self.origin[k] + self.cell * at[k])))
    }
}

/// Edges that do not occur as often in one direction as in the other: their number, and the first.
fn open_edges(triangles: &[[u32; 3]]) -> (usize, Option<[u32; 2]>) {
    // Uses in the direction of rising numbers less those in the other, and where first.
    let mut edges: BTreeMap<[u32; 2], (i64, usize)> = BTreeMap::new();
    for (index, [a, b, c]) in triangles.iter().enumerate() {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            if p == q {
                continue;
            }
            let entry = edges.entry([*p.min(q), *p.max(q)]).or_insert((0, index));
            entry.0 += if p < q { 1 } else { -1 };
        }
    }
    let open = || edges.iter().filter(|(_, (uses, _))| *uses != 0);
    (open().count(), open().min_by_key(|(edge, (_, index))| (*index, **edge)).map(|(edge, _)| *edge))
}

#[cfg(test)]
mod tests {
    use super::*;

    type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

    /// Eight corners and twelve triangles, outwards.
    fn cuboid(low: [f64; 3], high: [f64; 3]) -> Triangles {
        let points = (0..8).map(|n| std::array::from_fn(|k| if n >> k & 1 == 1 { high[k] } else { low[k] })).collect();
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        (points, faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
    }

    fn joined(parts: &[Triangles]) -> ClosedSurface {
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for (p, t) in parts {
            let first = points.len() as u32;
            points.extend_from_slice(p);
            triangles.extend(t.iter().map(|t| t.map(|n| n + first)));
        }
        ClosedSurface::new(points, triangles).unwrap()
    }

    #[test]
    fn rays_through_corners_edges_and_diagonals_decide_as_a_box_does() {
        let surface = joined(&[cuboid([0.0; 3], [1.0; 3])]);
        assert!((surface.volume() - 1.0).abs() < 1e-10);
        // All on a lattice that runs through every corner, edge and diagonal of the faces.
        for n in 0..9 * 9 * 9 {
            let x = [n % 9, n / 9 % 9, n / 81].map(|c| -0.5 + 0.25 * f64::from(c));
            let depth = x.iter().map(|&c| c.min(1.0 - c)).fold(f64::INFINITY, f64::min);
            if depth != 0.0 {
                assert_eq!(surface.contains(x), depth > 0.0, "{x:?}");
            }
            if depth >= 0.0 {
                assert!((surface.distance(x) - depth).abs() < 1e-11, "{x:?}");
            }
        }
    }

    #[test]
    fn parts_may_overlap_and_a_part_turned_inside_out_is_a_cavity() {
        let both = joined(&[cuboid([0.0; 3], [1.0; 3]), cuboid([0.5; 3], [1.5; 3])]);
        let inside = [[0.25; 3], [0.75; 3], [1.25; 3]];
        assert!(inside.iter().all(|&x| both.contains(x)) && !both.contains([1.25, 0.25, 0.25]));
        let mut hole = cuboid([0.25; 3], [0.75; 3]);
        hole.1.iter_mut().for_each(|t| t.swap(0, 1));
        let hollow = joined(&[cuboid([0.0; 3], [1.0; 3]), hole]);
        assert!((hollow.volume() - 0.875).abs() < 1e-10);
        assert!(hollow.contains([0.125; 3]) && !hollow.contains([0.5; 3]));
        assert!((hollow.depth([0.125, 0.5, 0.5]) - 0.125).abs() < 1e-10);
        // The other way round altogether it is the same solid.
        let (points, mut triangles) = cuboid([0.0; 3], [1.0; 3]);
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let turned = ClosedSurface::new(points, triangles).unwrap();
        assert!(turned.contains([0.5; 3]) && !turned.contains([0.5, 0.5, 1.5]) && turned.volume() > 0.999);
        assert!(turned.thinner_than(0.99).is_none());
        assert!((turned.thinner_than(1.01).unwrap().0 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_no_solid_is_refused_with_the_number_of_open_edges_and_the_first() {
        let (points, triangles) = cuboid([0.0; 3], [2.0, 1.0, 1.0]);
        let error = |points: &[[f64; 3]], triangles: &[[u32; 3]]| {
            ClosedSurface::new(points.to_vec(), triangles.to_vec()).unwrap_err().to_string()
        };
        let open = error(&points, &triangles[1..]);
        assert!(
            open.contains("3 edges are not shared") && open.contains("from [0.0, 0.0, 0.0] to [2.0, 1.0, 0.0]"),
            "{open}"
        );
        let mut turned = triangles.clone();
        turned[4].swap(0, 1);
        assert!(error(&points, &turned).contains("3 edges are not shared"));
        let flat: Vec<[f64; 3]> = points.iter().map(|p| [p[0], p[1], 0.0]).collect();
        assert!(error(&flat, &triangles).contains("it must be a solid"));
        assert!(error(&points, &[]).contains("no triangles"));
        assert!(error(&points[..7], &triangles).contains("but there are 7"));
        let mut broken = points.clone();
        broken[0][2] = f64::NAN;
        assert!(error(&broken, &triangles).contains("it must be finite"));
    }

    #[test]
    fn plates_are_thin_and_sharp_edges_of_a_tetrahedron_are_not() {
        let plate = joined(&[cuboid([0.0; 3], [1.0, 1.0, 0.1])]);
        let (thickness, at) = plate.thinner_than(0.11).unwrap();
        assert!((thickness - 0.1).abs() < 1e-9 && (at[2] < 1e-9 || at[2] > 0.1 - 1e-9), "{thickness} {at:?}");
        assert!(plate.thinner_than(0.1 * (1.0 - 1e-9)).is_none());
        let corners = vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let tetrahedron = ClosedSurface::new(corners, vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]).unwrap();
        assert!(tetrahedron.thinner_than(0.2).is_none());
        // A thick block with a fin that most triangles of the block know nothing of.
        let fin = joined(&[cuboid([0.0; 3], [1.0; 3]), cuboid([0.45, 0.45, 0.5], [0.55, 1.0 - 0.45, 2.0])]);
        assert!(fin.thinner_than(0.2).is_some());
    }
}
