//! Elements the decomposition takes, with what does not depend on the ball worked out once.

use glam::DVec3;
use thiserror::Error;

use crate::ElementKind;
use crate::double_double::cross_of_differences;

/// Largest distance of a corner from its face's plane, in units of the element's size, for a face to count as planar.
///
/// Caps use the plane, wedges the edges (Sec. 4.5): what a corner is off its plane by goes into the volume as an error
/// of about that size times the face's area.
pub const PLANARITY_TOLERANCE: f64 = 1e-10;

/// Coordinates beyond it would overflow in a volume.
const LARGEST_COORDINATE: f64 = 1e100;

/// Volume below which an element counts as flat, in units of the cube of its size.
const FLATNESS_TOLERANCE: f64 = 64.0 * f64::EPSILON;

/// Why corners do not make an element this method can take.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DecompositionElementError {
    /// A coordinate is infinite, not a number, or so large that volumes overflow.
    #[error(
        "corner {corner} of the {kind} is at {at:?}; every coordinate must be a number within ±{LARGEST_COORDINATE:e}"
    )]
    NotFinite {
        /// Shape asked for.
        kind: ElementKind,
        /// Which corner.
        corner: usize,
        /// Its coordinates.
        at: [f64; 3],
    },
    /// Two corners that an edge joins are the same point, so the edge has no direction.
    #[error(
        "corners {first} and {second} of the {kind} coincide at {at:?}; give distinct corners or a simpler element"
    )]
    CoincidentCorners {
        /// Shape asked for.
        kind: ElementKind,
        /// One end of the edge.
        first: usize,
        /// The other end.
        second: usize,
        /// Where both are.
        at: [f64; 3],
    },
    /// The corners lie in a plane, or so nearly that the sign of the volume is rounding noise.
    #[error("the {kind} has volume {volume:e}, nothing beside its size of {size:e}; give corners that span a volume")]
    ZeroVolume {
        /// Shape asked for.
        kind: ElementKind,
        /// Signed volume as computed.
        volume: f64,
        /// Largest extent along an axis.
        size: f64,
    },
    /// The corners are listed in the order that turns the element inside out.
    #[error("the {kind} is inside out (volume {volume:e}); list its corners in the order ElementKind::mirrored gives")]
    Inverted {
        /// Shape asked for.
        kind: ElementKind,
        /// Signed volume.
        volume: f64,
    },
    /// Four corners of a face do not lie in a plane.
    #[error(
        "face {face} of the {kind} is warped by {warp:e} of the element's size, more than {PLANARITY_TOLERANCE:e}; \
         subdivide the element into tetrahedra"
    )]
    WarpedFace {
        /// Shape asked for.
        kind: ElementKind,
        /// Which face, numbered as in [`ElementKind::faces`].
        face: usize,
        /// Largest distance of a corner from the plane over the element's size.
        warp: f64,
    },
    /// A corner lies on the outer side of a face: the sums over edges and vertices hold for convex elements.
    #[error("corner {corner} of the {kind} lies outside its face {face}; subdivide the element into convex ones")]
    NotConvex {
        /// Shape asked for.
        kind: ElementKind,
        /// Which face.
        face: usize,
        /// The corner beyond it.
        corner: usize,
    },
}

/// A face: its plane.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Face {
    /// Unit normal, outward.
    pub normal: DVec3,
    /// Mean of the corners, a point of the plane.
    pub centre: DVec3,
}

/// An edge between two faces.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Edge {
    pub vertices: [u8; 2],
    pub faces: [u8; 2],
    /// Unit vector from the first vertex to the second.
    pub direction: DVec3,
    pub length: f64,
    /// In the plane of each face: unit vector at right angles to the edge, away from the face.
    pub outward: [DVec3; 2],
}

/// A vertex, where three edges and three faces meet.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Vertex {
    /// Edges, such that their directions out of the vertex form a right-handed triple.
    pub edges: [u8; 3],
    /// The face opposite each edge, i.e. the one that holds the two others.
    pub faces: [u8; 3],
    /// Determinant of the three edges' directions out of the vertex, positive.
    pub determinant: f64,
}

/// A tetrahedron, wedge or hexahedron, with the planes, edges and corners the decomposition works on.
///
/// Corners in CGNS order ([`ElementKind::faces`] shows it), faces planar to [`PLANARITY_TOLERANCE`], convex. Build it
/// once per mesh element and use it for every ball: about 2 kB, no heap memory.
///
/// Source: `strobl2016`, Sec. 3 ("planar faces and vertices formed by exactly three intersecting faces").
///
/// ```
/// use fieldstone_geometry::decomposition::DecompositionElement;
/// let unit = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
/// let element = DecompositionElement::tetrahedron(unit)?;
/// assert!((element.volume() - 1.0 / 6.0).abs() < 1e-16);
/// # Ok::<(), fieldstone_geometry::decomposition::DecompositionElementError>(())
/// ```
#[derive(Debug, Clone)]
pub struct DecompositionElement {
    kind: ElementKind,
    volume: f64,
    pub(crate) lower: DVec3,
    pub(crate) upper: DVec3,
    points: [DVec3; 8],
    faces: [Face; 6],
    edges: [Edge; 12],
    vertices: [Vertex; 8],
    pub(crate) counts: Counts,
}

/// How many of each the arrays hold.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Counts {
    pub vertices: u8,
    pub edges: u8,
    pub faces: u8,
}

impl DecompositionElement {
    /// From four corners, the fourth on the side from which the first three run counter-clockwise.
    ///
    /// # Errors
    /// See [`DecompositionElementError`]: non-finite, coincident or coplanar corners, inverted order.
    pub fn tetrahedron(corners: [[f64; 3]; 4]) -> Result<Self, DecompositionElementError> {
        Self::build(ElementKind::Tetrahedron, &corners)
    }

    /// From six corners in CGNS order: a triangle, counter-clockwise seen from the other, then the other likewise.
    ///
    /// # Errors
    /// See [`DecompositionElementError`]: those of the tetrahedron, warped faces, corners that are not convex.
    pub fn wedge(corners: [[f64; 3]; 6]) -> Result<Self, DecompositionElementError> {
        Self::build(ElementKind::Wedge, &corners)
    }

    /// From eight corners in CGNS order: a quadrilateral, counter-clockwise seen from the opposite one, then that one.
    ///
    /// # Errors
    /// See [`DecompositionElementError`]: those of the tetrahedron, warped faces, corners that are not convex.
    pub fn hexahedron(corners: [[f64; 3]; 8]) -> Result<Self, DecompositionElementError> {
        Self::build(ElementKind::Hexahedron, &corners)
    }

    /// Its shape.
    pub fn kind(&self) -> ElementKind {
        self.kind
    }

    /// Its volume, positive.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Lower and upper corner of its bounding box.
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        [self.lower.to_array(), self.upper.to_array()]
    }

    pub(crate) fn points(&self) -> &[DVec3] {
        &self.points[..self.counts.vertices as usize]
    }

    pub(crate) fn faces(&self) -> &[Face] {
        &self.faces[..self.counts.faces as usize]
    }

    pub(crate) fn edges(&self) -> &[Edge] {
        &self.edges[..self.counts.edges as usize]
    }

    pub(crate) fn vertices(&self) -> &[Vertex] {
        &self.vertices[..self.counts.vertices as usize]
    }

    fn build(kind: ElementKind, corners: &[[f64; 3]]) -> Result<Self, DecompositionElementError> {
        use DecompositionElementError as E;
        let mut points = [DVec3::ZERO; 8];
        for (corner, &at) in corners.iter().enumerate() {
            points[corner] = DVec3::from(at);
            if at.iter().any(|x| !x.is_finite() || x.abs() > LARGEST_COORDINATE) {
                return Err(E::NotFinite { kind, corner, at });
            }
        }
        let points_in_use = &points[..corners.len()];
        let lower = points_in_use.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let upper = points_in_use.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let size = (upper - lower).max_element();

        let (edges, edge_count) = edges(kind, &points)?;
        let volume = signed_volume(kind, &points);
        if volume.abs() <= FLATNESS_TOLERANCE * size * size * size {
            return Err(E::ZeroVolume { kind, volume, size });
        }
        if volume < 0.0 {
            return Err(E::Inverted { kind, volume });
        }
        let (mut edges, mut faces) = (edges, [Face::default(); 6]);
        for (index, corners_of_face) in kind.faces().iter().enumerate() {
            faces[index] = plane(corners_of_face, &points);
            let Face { normal, centre } = faces[index];
            let warp = corners_of_face.iter().map(|&v| normal.dot(points[v] - centre).abs()).fold(0.0, f64::max) / size;
            if warp > PLANARITY_TOLERANCE {
                return Err(E::WarpedFace { kind, face: index, warp });
            }
            // The other corners lie inside by more than rounding, or the vertices' cones would turn over.
            for (corner, &point) in points_in_use.iter().enumerate() {
                if normal.dot(point - centre) > PLANARITY_TOLERANCE * size {
                    return Err(E::NotConvex { kind, face: index, corner });
                }
            }
        }
        for edge in &mut edges[..edge_count] {
            // The first face runs along the edge's direction, the second against it.
            edge.outward[0] = edge.direction.cross(faces[edge.faces[0] as usize].normal).normalize_or_zero();
            edge.outward[1] = faces[edge.faces[1] as usize].normal.cross(edge.direction).normalize_or_zero();
        }
        let vertices = vertices(&edges[..edge_count], corners.len());
        let counts = Counts { vertices: corners.len() as u8, edges: edge_count as u8, faces: kind.faces().len() as u8 };
        Ok(Self { kind, volume, lower, upper, points, faces, edges, vertices, counts })
    }
}

/// Edges in the order in which the faces first run along them.
fn edges(kind: ElementKind, points: &[DVec3; 8]) -> Result<([Edge; 12], usize), DecompositionElementError> {
    let mut edges = [Edge::default(); 12];
    let mut count = 0;
    for (face, corners) in kind.faces().iter().enumerate() {
        for (i, &from) in corners.iter().enumerate() {
            let to = corners[(i + 1) % corners.len()];
            if let Some(known) = edges[..count].iter_mut().find(|e| e.vertices == [to as u8, from as u8]) {
                known.faces[1] = face as u8;
                continue;
            }
            let along = points[to] - points[from];
            let length = along.length();
            if length == 0.0 {
                let (first, second) = (from.min(to), from.max(to));
                let at = points[from].to_array();
                return Err(DecompositionElementError::CoincidentCorners { kind, first, second, at });
            }
            edges[count] = Edge {
                vertices: [from as u8, to as u8],
                faces: [face as u8, 0],
                direction: along / length,
                length,
                outward: [DVec3::ZERO; 2],
            };
            count += 1;
        }
    }
    Ok((edges, count))
}

/// Plane of a face: the area vector's direction, through the mean of the corners.
fn plane(corners: &[usize], points: &[DVec3; 8]) -> Face {
    let centre = corners.iter().map(|&v| points[v]).sum::<DVec3>() / corners.len() as f64;
    // Half the cross product of the diagonals is a quadrilateral's area vector. A needle's sides are nearly parallel,
    // hence the extended precision.
    let (a, b) = match *corners {
        [a, b, c] => ([points[b], points[a]], [points[c], points[a]]),
        _ => ([points[corners[2]], points[corners[0]]], [points[corners[3]], points[corners[1]]]),
    };
    Face { normal: cross_of_differences(a, b).normalize_or_zero(), centre }
}

/// Sum of the tetrahedra from corner 0 to each triangle of each face's fan.
fn signed_volume(kind: ElementKind, points: &[DVec3; 8]) -> f64 {
    let mut six_volumes = 0.0;
    for corners in kind.faces() {
        let [a, b] = [points[corners[0]] - points[0], points[corners[1]] - points[0]];
        let mut previous = b;
        for &corner in &corners[2..] {
            let next = points[corner] - points[0];
            six_volumes += a.cross(previous).dot(next);
            previous = next;
        }
    }
    six_volumes / 6.0
}

fn vertices(edges: &[Edge], count: usize) -> [Vertex; 8] {
    let mut vertices = [Vertex::default(); 8];
    for (index, vertex) in vertices[..count].iter_mut().enumerate() {
        let mut out = [DVec3::ZERO; 3];
        let mut found = 0;
        for (number, edge) in edges.iter().enumerate() {
            if let Some(end) = edge.vertices.iter().position(|&v| usize::from(v) == index) {
                vertex.edges[found] = number as u8;
                out[found] = if end == 0 { edge.direction } else { -edge.direction };
                found += 1;
            }
        }
        vertex.determinant = out[0].cross(out[1]).dot(out[2]);
        if vertex.determinant < 0.0 {
            vertex.edges.swap(1, 2);
            vertex.determinant = -vertex.determinant;
        }
        for i in 0..3 {
            let [j, k] = [vertex.edges[(i + 1) % 3], vertex.edges[(i + 2) % 3]].map(|e| edges[usize::from(e)].faces);
            vertex.faces[i] = if k.contains(&j[0]) { j[0] } else { j[1] };
        }
    }
    vertices
}
