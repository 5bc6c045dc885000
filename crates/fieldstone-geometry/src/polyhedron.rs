//! Closed polyhedra, checked when they are built.

use std::cmp::Ordering;

use glam::DVec3;
use thiserror::Error;

use crate::double_double::{DoubleDouble, two_sum};
use crate::edge_frames::EdgeFrames;
use crate::polygon::{flatness, is_exactly_planar, polygon_centroid, polygon_warp, warp_bound};
use crate::precision::Wide;
use crate::{CornerOrder, ElementKind, Real, Vector};

/// Largest warp of a face, over the size of the element, that still counts as planar.
///
/// Corners that were computed in `f64` are off their plane by a few units of the last digit; a face beyond that
/// is triangulated, so the volume is exact for the coordinates given.
pub const PLANARITY: f64 = 1e-14;

/// A sum that keeps more than this of its terms is right to the last digit of an `f64` when computed in 106 bits.
const ROUNDED_ONCE: f64 = 1e-12;

/// Why corners and faces make no polyhedron.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ElementError {
    /// A wrong number of corners for the kind.
    #[error("a {kind} has {expected} corners, but {found} are given")]
    CornerCount {
        /// The kind.
        kind: ElementKind,
        /// Corners given.
        found: usize,
        /// Corners needed.
        expected: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("corner {corner} is at ({}, {}, {}); coordinates must be finite", at[0], at[1], at[2])]
    NotFinite {
        /// Index of the corner.
        corner: usize,
        /// Its coordinates.
        at: [f64; 3],
    },
    /// Two corners are the same point, so an edge has no direction.
    #[error("corners {first} and {second} coincide at ({}, {}, {}); give distinct corners, or the kind of element that is left when they are merged", at[0], at[1], at[2])]
    CoincidentCorners {
        /// Index of one corner.
        first: usize,
        /// Index of the other.
        second: usize,
        /// Where they are.
        at: [f64; 3],
    },
    /// A face names a corner that does not exist, has less than three, or one twice.
    #[error("face {face} has corners {corners:?}; it needs at least three different ones below {count}")]
    BadFace {
        /// Index of the face.
        face: usize,
        /// Its corners.
        corners: Vec<usize>,
        /// Corners of the polyhedron.
        count: usize,
    },
    /// The faces do not close the polyhedron, or are wound inconsistently.
    #[error("the edge from corner {} to corner {} is met {forward} times forward and {backward} times backward; in a closed polyhedron with consistent faces both are equal", edge[0], edge[1])]
    NotClosed {
        /// Ends of the edge.
        edge: [usize; 2],
        /// Faces that run through it in this direction.
        forward: usize,
        /// Faces that run through it in the other.
        backward: usize,
    },
    /// The polyhedron encloses no volume.
    #[error("the {kind} encloses no volume (computed: {volume:e}, size {size:e})")]
    NoVolume {
        /// The kind.
        kind: ElementKind,
        /// Computed volume.
        volume: f64,
        /// Largest extent.
        size: f64,
    },
    /// The volume is negative, and the caller wants that refused.
    #[error(
        "the {kind} is inside out (volume {volume:e}); list its corners in the order of its kind, or allow the orientation to be fixed"
    )]
    Inverted {
        /// The kind.
        kind: ElementKind,
        /// Computed volume.
        volume: f64,
    },
}

/// What to do with an element whose faces all point inwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Orientation {
    /// Turn it inside out; [`Polyhedron::was_inverted`] says so.
    #[default]
    Fix,
    /// Refuse it with [`ElementError::Inverted`].
    Refuse,
}

/// A planar part of a face: the whole face, or one triangle of a warped one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Piece {
    /// Outward unit normal.
    pub normal: DVec3,
    /// The face that it belongs to.
    pub face: u32,
    /// End of its corners in `Polyhedron::piece_corners`.
    pub end: u32,
    /// How its normal magnifies rounding, see [`flatness`].
    pub flatness: f64,
    /// Largest distance of a corner from the plane, rounding included; 0 where the corners lie in one plane exactly.
    pub warp: f64,
    /// Centroid, around which the piece is fanned in more digits than `f64` where it is not exactly planar.
    pub apex: DVec3,
}

/// A closed polyhedron with everything precomputed that does not depend on the ball.
///
/// Faces that are not planar are fanned into triangles around their area-weighted centroid
/// ([`crate::polygon_centroid`]), so that two elements with a common face share one surface and volumes equal
/// OpenFOAM's. Non-convex polyhedra and corners of any valence are fine.
///
/// ```
/// use fieldstone_geometry::Polyhedron;
/// let tet = Polyhedron::tetrahedron([[0.; 3], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]])?;
/// assert!((tet.volume() - 1.0 / 6.0).abs() < 1e-16);
/// # Ok::<(), fieldstone_geometry::ElementError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Polyhedron {
    kind: ElementKind,
    /// What has been taken from all coordinates, without rounding.
    origin: DVec3,
    /// Corners, then the centroids that warped faces are fanned around; relative to the origin.
    vertices: Vec<DVec3>,
    corner_count: usize,
    pub(crate) pieces: Vec<Piece>,
    pub(crate) piece_corners: Vec<u32>,
    /// For the quick way of evaluating it, where that is possible.
    frames: Option<EdgeFrames>,
    face_areas: Vec<f64>,
    volume: f64,
    low: DVec3,
    high: DVec3,
    convex: bool,
    inverted: bool,
}

impl Polyhedron {
    /// A tetrahedron.
    ///
    /// # Errors
    /// As [`Polyhedron::element`].
    pub fn tetrahedron(corners: [[f64; 3]; 4]) -> Result<Self, ElementError> {
        Self::element(ElementKind::Tetrahedron, CornerOrder::Vtk, &corners, Orientation::Fix)
    }

    /// A pyramid: four corners of the base, then the apex.
    ///
    /// # Errors
    /// As [`Polyhedron::element`].
    pub fn pyramid(corners: [[f64; 3]; 5]) -> Result<Self, ElementError> {
        Self::element(ElementKind::Pyramid, CornerOrder::Vtk, &corners, Orientation::Fix)
    }

    /// A wedge: three corners of one triangle, then the three that face them, in either winding.
    ///
    /// # Errors
    /// As [`Polyhedron::element`].
    pub fn wedge(corners: [[f64; 3]; 6]) -> Result<Self, ElementError> {
        Self::element(ElementKind::Wedge, CornerOrder::Vtk, &corners, Orientation::Fix)
    }

    /// A hexahedron: four corners of the bottom, then the four above them.
    ///
    /// # Errors
    /// As [`Polyhedron::element`].
    pub fn hexahedron(corners: [[f64; 3]; 8]) -> Result<Self, ElementError> {
        Self::element(ElementKind::Hexahedron, CornerOrder::Vtk, &corners, Orientation::Fix)
    }

    /// The axis-parallel box between two corners, as a hexahedron.
    ///
    /// # Errors
    /// As [`Polyhedron::element`].
    pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> Result<Self, ElementError> {
        let corner = |x: usize, y: usize, z: usize| [[low[0], high[0]][x], [low[1], high[1]][y], [low[2], high[2]][z]];
        Self::hexahedron([
            corner(0, 0, 0),
            corner(1, 0, 0),
            corner(1, 1, 0),
            corner(0, 1, 0),
            corner(0, 0, 1),
            corner(1, 0, 1),
            corner(1, 1, 1),
            corner(0, 1, 1),
        ])
    }

    /// An element of a standard kind from its corners.
    ///
    /// # Errors
    /// A wrong number of corners; numbers that are not finite; coincident corners; no volume; an element inside
    /// out where `orientation` refuses it.
    pub fn element(
        kind: ElementKind,
        order: CornerOrder,
        corners: &[[f64; 3]],
        orientation: Orientation,
    ) -> Result<Self, ElementError> {
        let expected = kind.corner_count().unwrap_or(0);
        if corners.len() != expected || expected == 0 {
            return Err(ElementError::CornerCount { kind, found: corners.len(), expected });
        }
        let cgns: Vec<[f64; 3]> = kind.to_cgns(order).iter().map(|&k| corners[k]).collect();
        let faces: Vec<&[usize]> = kind.faces().to_vec();
        Self::build(kind, &cgns, &faces, orientation)
    }

    /// A general polyhedron from corners and faces; each face lists its corners counter-clockwise seen from
    /// outside (all of them clockwise will do too: see [`Orientation`]).
    ///
    /// # Errors
    /// As [`Polyhedron::element`]; also faces that do not close the polyhedron or are wound inconsistently.
    pub fn from_faces<F: AsRef<[usize]>>(
        corners: &[[f64; 3]],
        faces: &[F],
        orientation: Orientation,
    ) -> Result<Self, ElementError> {
        let faces: Vec<&[usize]> = faces.iter().map(AsRef::as_ref).collect();
        check_closed(corners.len(), &faces)?;
        Self::build(ElementKind::Polyhedron, corners, &faces, orientation)
    }

    fn build(
        kind: ElementKind,
        corners: &[[f64; 3]],
        faces: &[&[usize]],
        orientation: Orientation,
    ) -> Result<Self, ElementError> {
        for (corner, &at) in corners.iter().enumerate() {
            if at.iter().any(|x| !x.is_finite()) {
                return Err(ElementError::NotFinite { corner, at });
            }
        }
        if let Some([first, second]) = coincident(corners) {
            return Err(ElementError::CoincidentCorners { first, second, at: corners[second] });
        }
        let (origin, positions) = localised(corners);
        let low = positions.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = positions.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let size = (high - low).max_element();

        let mut this = Self {
            kind,
            corner_count: corners.len(),
            origin,
            vertices: positions,
            pieces: Vec::with_capacity(faces.len()),
            piece_corners: Vec::new(),
            frames: None,
            face_areas: vec![0.0; faces.len()],
            volume: 0.0,
            low,
            high,
            convex: true,
            inverted: false,
        };
        for (face, ring) in faces.iter().enumerate() {
            this.push_face(face, ring, size);
        }
        let volume = this.signed_volume();
        // Below a few units of the last digit of the cube around it, nothing is left of a volume but rounding.
        if volume.abs() <= 4.0 * f64::EPSILON * f64::EPSILON * size.powi(3) || !volume.is_finite() {
            return Err(ElementError::NoVolume { kind, volume, size });
        }
        this.volume = volume.abs();
        if volume < 0.0 {
            if orientation == Orientation::Refuse {
                return Err(ElementError::Inverted { kind, volume });
            }
            this.invert();
        }
        this.convex = this.is_convex_within(1e-12 * size);
        this.frames = EdgeFrames::new(&this.vertices, this.convex, this.rings());
        Ok(this)
    }

    fn push_face(&mut self, face: usize, ring: &[usize], size: f64) {
        let points: Vec<[f64; 3]> = ring.iter().map(|&k| self.vertices[k].to_array()).collect();
        if polygon_warp(&points) <= PLANARITY * size || is_exactly_planar(&points) {
            let corners: Vec<u32> = ring.iter().map(|&k| k as u32).collect();
            self.push_piece(face, &corners);
            return;
        }
        let apex = self.vertices.len() as u32;
        self.vertices.push(DVec3::from(polygon_centroid(&points)));
        for (k, &a) in ring.iter().enumerate() {
            self.push_piece(face, &[a as u32, ring[(k + 1) % ring.len()] as u32, apex]);
        }
    }

    fn push_piece(&mut self, face: usize, corners: &[u32]) {
        let at = |k: u32| Vector::<DoubleDouble>::from_f64(self.vertices[k as usize].to_array());
        let origin = at(corners[0]);
        let zero = DoubleDouble::ZERO;
        let twice = corners[1..]
            .windows(2)
            .fold(Vector::new(zero, zero, zero), |sum, pair| sum + (at(pair[0]) - origin).cross(at(pair[1]) - origin));
        let length = twice.length();
        // A piece without area has no normal and contributes nothing: its two sides cancel.
        if length <= zero {
            return;
        }
        let normal = DVec3::new((twice.x / length).hi(), (twice.y / length).hi(), (twice.z / length).hi());
        self.face_areas[face] += 0.5 * length.hi();
        let points: Vec<[f64; 3]> = corners.iter().map(|&k| self.vertices[k as usize].to_array()).collect();
        self.piece_corners.extend_from_slice(corners);
        self.pieces.push(Piece {
            normal,
            face: face as u32,
            end: self.piece_corners.len() as u32,
            flatness: flatness(&points),
            warp: warp_bound(&points),
            apex: DVec3::from(polygon_centroid(&points)),
        });
    }

    fn invert(&mut self) {
        self.inverted = true;
        let mut start = 0;
        for piece in &mut self.pieces {
            piece.normal = -piece.normal;
            self.piece_corners[start..piece.end as usize].reverse();
            start = piece.end as usize;
        }
    }

    /// The volume, rounded once: from double-double, or from 256 bits where next to nothing is left of the terms.
    fn signed_volume(&self) -> f64 {
        let (volume, terms) = self.volume_and_terms::<DoubleDouble>();
        if volume.abs() > ROUNDED_ONCE * terms { volume } else { self.volume_and_terms::<Wide>().0 }
    }

    /// The volume as a sum of tetrahedra, and the sum of their magnitudes.
    fn volume_and_terms<R: Real>(&self) -> (f64, f64) {
        let at = |k: u32| Vector::<R>::from_f64(self.vertices[k as usize].to_array());
        let origin = at(0);
        let (mut sum, mut magnitude) = (R::from_f64(0.0), 0.0);
        for (piece, corners) in self.rings() {
            let ring: Vec<Vector<R>> = corners.iter().map(|&k| at(k) - origin).collect();
            let apex = if piece.warp == 0.0 { ring[0] } else { Vector::from_f64(piece.apex.to_array()) - origin };
            let size = |v: Vector<R>| v.x.to_f64().abs() + v.y.to_f64().abs() + v.z.to_f64().abs();
            for (k, &a) in ring.iter().enumerate() {
                let b = ring[(k + 1) % ring.len()];
                sum = sum + apex.dot(a.cross(b));
                // What rounding is relative to: the products, before they cancel.
                magnitude += size(apex) * size(a) * size(b);
            }
        }
        (sum.to_f64() / 6.0, magnitude)
    }

    fn is_convex_within(&self, tolerance: f64) -> bool {
        // Of thousands of vertices most are far behind a face: they are passed over by the box.
        let boxes: Vec<(DVec3, DVec3, &[DVec3])> = self
            .vertices
            .chunks(32)
            .map(|part| {
                let (low, high) = part.iter().fold((part[0], part[0]), |(a, b), &v| (a.min(v), b.max(v)));
                (0.5 * (low + high), 0.5 * (high - low), part)
            })
            .collect();
        self.rings().all(|(piece, corners)| {
            let origin = self.vertices[corners[0] as usize];
            boxes.iter().all(|&(middle, half, part)| {
                piece.normal.dot(middle - origin) + piece.normal.abs().dot(half) <= 0.5 * tolerance
                    || part.iter().all(|&v| piece.normal.dot(v - origin) <= tolerance)
            })
        })
    }

    /// Pieces with their corners.
    pub(crate) fn rings(&self) -> impl Iterator<Item = (&Piece, &[u32])> {
        let mut start = 0;
        self.pieces.iter().map(move |piece| {
            let corners = &self.piece_corners[start..piece.end as usize];
            start = piece.end as usize;
            (piece, corners)
        })
    }

    /// What [`crate::inside`] needs of it, where that can be used.
    #[inline]
    pub(crate) fn frames(&self) -> Option<&EdgeFrames> {
        self.frames.as_ref()
    }

    /// Shape of the element.
    pub fn kind(&self) -> ElementKind {
        self.kind
    }

    /// Corners, in CGNS order for standard kinds.
    pub fn corners(&self) -> impl ExactSizeIterator<Item = [f64; 3]> + '_ {
        self.vertices[..self.corner_count].iter().map(|&v| (self.origin + v).to_array())
    }

    /// What has been taken from the coordinates of [`Polyhedron::vertices`] and [`Polyhedron::low_high`].
    pub(crate) fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Corners and the centroids of warped faces, relative to the origin.
    pub(crate) fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Volume.
    #[inline]
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Area of each face, in the order of [`ElementKind::faces`] or of the faces given.
    pub fn face_areas(&self) -> &[f64] {
        &self.face_areas
    }

    /// Lower and upper corner of the axis-parallel box around it.
    #[inline]
    pub fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        ((self.origin + self.low).to_array(), (self.origin + self.high).to_array())
    }

    /// The box around it, relative to the origin.
    pub(crate) fn low_high(&self) -> (DVec3, DVec3) {
        (self.low, self.high)
    }

    /// Whether it is convex, up to 1e-12 of its size.
    #[inline]
    pub fn is_convex(&self) -> bool {
        self.convex
    }

    /// Whether it was given inside out and has been turned.
    pub fn was_inverted(&self) -> bool {
        self.inverted
    }

    /// Whether some face is warped, so that it has been triangulated.
    pub fn has_warped_faces(&self) -> bool {
        self.vertices.len() > self.corner_count
    }
}

/// The first corner that is where an earlier one is, after that one; by sorting, since a polyhedron may have thousands.
fn coincident(corners: &[[f64; 3]]) -> Option<[usize; 2]> {
    let compare = |a: &usize, b: &usize| {
        let mut axes = corners[*a].iter().zip(&corners[*b]).map(|(x, y)| x.partial_cmp(y).unwrap_or(Ordering::Equal));
        axes.find(|order| order.is_ne()).unwrap_or(Ordering::Equal).then(a.cmp(b))
    };
    let mut order: Vec<usize> = (0..corners.len()).collect();
    order.sort_unstable_by(compare);
    let pairs = order.windows(2).filter(|pair| corners[pair[0]] == corners[pair[1]]);
    pairs.map(|pair| [pair[0], pair[1]]).min_by_key(|pair| pair[1])
}

/// Corners relative to the first one along each axis where this loses nothing, and what has been taken away.
///
/// Far from the origin of the coordinates the centroids of warped faces would otherwise be rounded to what little the
/// coordinates resolve, and with them the volume.
fn localised(corners: &[[f64; 3]]) -> (DVec3, Vec<DVec3>) {
    let first = corners.first().copied().unwrap_or_default();
    // Each axis by itself: a mesh may be far away along one of them only.
    let exact = |k: usize| corners.iter().all(|p| two_sum(p[k], -first[k]).1 == 0.0);
    let origin = DVec3::from([0, 1, 2].map(|k| if exact(k) { first[k] } else { 0.0 }));
    (origin, corners.iter().map(|&p| DVec3::from(p) - origin).collect())
}

fn check_closed(count: usize, faces: &[&[usize]]) -> Result<(), ElementError> {
    let mut edges = std::collections::BTreeMap::<[usize; 2], [usize; 2]>::new();
    for (face, ring) in faces.iter().enumerate() {
        let distinct = ring.iter().collect::<std::collections::BTreeSet<_>>().len();
        if ring.len() < 3 || distinct < ring.len() || ring.iter().any(|&k| k >= count) {
            return Err(ElementError::BadFace { face, corners: ring.to_vec(), count });
        }
        for (k, &a) in ring.iter().enumerate() {
            let b = ring[(k + 1) % ring.len()];
            edges.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
        }
    }
    match edges.into_iter().find(|(_, [forward, backward])| forward != backward) {
        Some((edge, [forward, backward])) => Err(ElementError::NotClosed { edge, forward, backward }),
        None => Ok(()),
    }
}
