//! What of a polyhedron does not depend on the ball: planes, edges, and where each edge lies in each of its planes.

use glam::DVec3;

use crate::polyhedron::Piece;

/// Most planar pieces of a polyhedron that [`crate::inside`] takes on: a hexahedron has 24 if all its faces are warped.
pub(crate) const MOST_PIECES: usize = 32;

/// Most edges: one bit each.
const MOST_EDGES: usize = 64;

/// Most corners of a piece: products of as many complex numbers do not underflow.
const MOST_CORNERS: usize = 16;

/// The plane of a planar piece.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    /// Outward unit normal.
    pub normal: [f64; 3],
    /// Distance of the plane from the origin along the normal.
    pub offset: f64,
    /// See [`crate::flatness`].
    pub flatness: f64,
    /// See [`crate::warp_bound`].
    pub warp: f64,
    /// A bit for each of its edges.
    pub edges: u64,
}

/// An edge between two pieces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edge {
    /// Unit vector along it.
    pub along: [f64; 3],
    /// Its two corners, `along` from the first to the second.
    pub ends: [[f64; 3]; 2],
    /// Its length.
    pub length: f64,
    /// Where it lies in the planes of its pieces.
    pub sides: [Side; 2],
    /// Unit normal of the first piece.
    pub normal: [f64; 3],
    /// Normal and outward vector of the second piece in terms of those of the first.
    pub rotation: [[f64; 2]; 2],
}

/// An edge as a side of one piece.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    /// Unit vector in the piece's plane, perpendicular to the edge, out of the piece.
    pub outward: [f64; 3],
    /// Distance of the edge's line from the origin along `outward`.
    pub offset: f64,
    /// The piece.
    pub piece: u32,
}

/// Planes and edges of a polyhedron, relative to its origin.
///
/// The length of an edge, its part inside the ball and the distances of that part's ends are the same for both of its pieces.
/// Where solids touch along an edge, more than two pieces have it in common: it is then listed once for every two of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct EdgeFrames {
    pub planes: Vec<Plane>,
    /// The planes again, four at a time: the components of minus their normals, and their offsets. Infinitely far where there
    /// is none.
    pub blocks: Vec<[[f64; 4]; 4]>,
    /// Lower and upper corner of the box around it, padded with 0.
    pub bounds: [[f64; 4]; 2],
    /// Radius, squared, of the smallest ball that the box's diagonal fits in: no smaller one holds the polyhedron.
    pub least_radius2: f64,
    pub edges: Vec<Edge>,
    /// The largest flatness of a piece.
    pub flatness: f64,
    /// Whether the polyhedron is convex, and no two adjacent pieces are nearly in one plane. The foot on a piece in reach is then on
    /// its side of every edge to a piece out of reach, unless the ball is apart.
    pub sharp: bool,
}

/// Cosine between the normals of adjacent pieces above which an edge is not sharp.
const NEARLY_FLAT: f64 = 0.999;

impl EdgeFrames {
    /// The frames of pieces with their corners, indices into `vertices`; `None` where a piece is not convex, has too
    /// many corners, or there are too many pieces or edges.
    pub fn new<'a>(
        vertices: &[DVec3],
        convex: bool,
        rings: impl Iterator<Item = (&'a Piece, &'a [u32])>,
    ) -> Option<Self> {
        let mut this = Self { sharp: convex, ..Self::default() };
        // (lower corner, higher corner, piece, whether the piece runs from the lower to the higher)
        let mut uses: Vec<(u32, u32, u32, bool)> = Vec::new();
        for (index, (piece, corners)) in rings.enumerate() {
            let at = |k: usize| vertices[corners[k % corners.len()] as usize];
            let turns_left = |k| (at(k + 1) - at(k)).cross(at(k + 2) - at(k + 1)).dot(piece.normal) > 0.0;
            if index == MOST_PIECES || corners.len() > MOST_CORNERS || !(0..corners.len()).all(turns_left) {
                return None;
            }
            this.flatness = this.flatness.max(piece.flatness);
            this.planes.push(Plane {
                normal: piece.normal.to_array(),
                offset: piece.normal.dot(at(0)),
                flatness: piece.flatness,
                warp: piece.warp,
                edges: 0,
            });
            for (k, &a) in corners.iter().enumerate() {
                let b = corners[(k + 1) % corners.len()];
                uses.push((a.min(b), a.max(b), index as u32, a < b));
            }
        }
        uses.sort_unstable();
        if !uses.len().is_multiple_of(2) || uses.len() > 2 * MOST_EDGES {
            return None;
        }
        for pair in uses.chunks_exact(2) {
            let ends = |k: usize| (pair[k].0, pair[k].1);
            // Next to a piece without area, which has been left out.
            if ends(0) != ends(1) {
                return None;
            }
            let (from, to) = (vertices[ends(0).0 as usize], vertices[ends(0).1 as usize]);
            let length = (to - from).length();
            let along = (to - from) / length;
            let sides = [0, 1].map(|k| {
                let (_, _, piece, forward) = pair[k];
                let normal = DVec3::from(this.planes[piece as usize].normal);
                let outward = if forward { along.cross(normal) } else { normal.cross(along) };
                Side { outward: outward.to_array(), offset: outward.dot(from), piece }
            });
            for side in &sides {
                this.planes[side.piece as usize].edges |= 1 << this.edges.len();
            }
            let axes = |side: &Side| [DVec3::from(this.planes[side.piece as usize].normal), DVec3::from(side.outward)];
            let first = axes(&sides[0]);
            this.sharp &= first[0].dot(axes(&sides[1])[0]).abs() < NEARLY_FLAT;
            this.edges.push(Edge {
                along: along.to_array(),
                ends: [from.to_array(), to.to_array()],
                length,
                normal: first[0].to_array(),
                rotation: axes(&sides[1]).map(|axis| first.map(|other| axis.dot(other))),
                sides,
            });
        }
        this.blocks = this.planes.chunks(4).map(block).collect();
        let low = vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        this.bounds = [low, high].map(|corner| [corner.x, corner.y, corner.z, 0.0]);
        this.least_radius2 = 0.25 * (high - low).length_squared();
        Some(this)
    }
}

/// Up to four planes, see [`EdgeFrames::blocks`].
fn block(planes: &[Plane]) -> [[f64; 4]; 4] {
    let mut rows = [[0.0; 4], [0.0; 4], [0.0; 4], [f64::INFINITY; 4]];
    for (k, plane) in planes.iter().enumerate() {
        for (row, component) in rows.iter_mut().zip(plane.normal) {
            row[k] = -component;
        }
        rows[3][k] = plane.offset;
    }
    rows
}
