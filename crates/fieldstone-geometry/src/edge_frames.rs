//! What of a polyhedron does not depend on the ball: planes, edges, and where each edge lies in each of its planes.

use glam::DVec3;

use crate::polyhedron::Piece;

/// Most planar pieces of a polyhedron that [`crate::inside`] takes on: a hexahedron has 24 if all its faces are warped.
pub(crate) const MOST_PIECES: usize = 32;

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
}

/// An edge with its pieces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edge {
    /// Unit vector along it.
    pub along: [f64; 3],
    /// Where it starts: its first corner along `along`.
    pub start: f64,
    /// Its length.
    pub length: f64,
    /// End of its sides in `EdgeFrames::sides`.
    pub end: u32,
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

/// Planes, edges and sides of a polyhedron, relative to its origin.
///
/// An edge belongs to two pieces (to more where solids touch along it). Its length, its part inside the ball and the
/// distances of that part's ends are the same for all of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct EdgeFrames {
    pub planes: Vec<Plane>,
    pub edges: Vec<Edge>,
    pub sides: Vec<Side>,
}

impl EdgeFrames {
    /// The frames of pieces with their corners, indices into `vertices`; `None` where a piece is not convex, has too
    /// many corners, or there are too many pieces.
    pub fn new<'a>(vertices: &[DVec3], rings: impl Iterator<Item = (&'a Piece, &'a [u32])>) -> Option<Self> {
        let mut this = Self::default();
        // (lower corner, higher corner, piece, whether the piece runs from the lower to the higher)
        let mut uses: Vec<(u32, u32, u32, bool)> = Vec::new();
        for (index, (piece, corners)) in rings.enumerate() {
            let at = |k: usize| vertices[corners[k % corners.len()] as usize];
            let turns_left = |k| (at(k + 1) - at(k)).cross(at(k + 2) - at(k + 1)).dot(piece.normal) > 0.0;
            if index == MOST_PIECES || corners.len() > MOST_CORNERS || !(0..corners.len()).all(turns_left) {
                return None;
            }
            this.planes.push(Plane {
                normal: piece.normal.to_array(),
                offset: piece.normal.dot(at(0)),
                flatness: piece.flatness,
                warp: piece.warp,
            });
            for (k, &a) in corners.iter().enumerate() {
                let b = corners[(k + 1) % corners.len()];
                uses.push((a.min(b), a.max(b), index as u32, a < b));
            }
        }
        uses.sort_unstable();
        for edge in uses.chunk_by(|p, q| (p.0, p.1) == (q.0, q.1)) {
            let (from, to) = (vertices[edge[0].0 as usize], vertices[edge[0].1 as usize]);
            let length = (to - from).length();
            let along = (to - from) / length;
            for &(_, _, piece, forward) in edge {
                let normal = DVec3::from(this.planes[piece as usize].normal);
                let outward = if forward { along.cross(normal) } else { normal.cross(along) };
                this.sides.push(Side { outward: outward.to_array(), offset: outward.dot(from), piece });
            }
            let (start, end) = (along.dot(from), this.sides.len() as u32);
            this.edges.push(Edge { along: along.to_array(), start, length, end });
        }
        Some(this)
    }
}
