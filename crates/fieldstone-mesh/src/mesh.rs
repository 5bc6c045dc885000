//! The polyhedral mesh: points, faces, owner and neighbour.

use fieldstone_geometry::ElementKind;
use glam::{DVec3, Vec3Swizzles};
use rayon::prelude::*;

use crate::cell_tree::CellTree;
use crate::surface::Surface;
use crate::{CellList, MeshError, from_cells, shape};

/// A volume of less than this of its terms is computed in more digits than `f64` has.
pub(crate) const CANCELLED: f64 = 1e-3;

/// A named, contiguous range of boundary faces.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patch {
    /// Name, as in OpenFOAM's `boundary` file.
    pub name: String,
    /// OpenFOAM's type: `patch`, `wall`, `cyclic`, `processor`, `empty`, …
    pub kind: String,
    /// First face.
    pub start: usize,
    /// Number of faces.
    pub count: usize,
}

/// A named set of cells (cell zone, physical group).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Zone {
    /// Name.
    pub name: String,
    /// Cells, from 0.
    pub cells: Vec<u32>,
}

/// What a mesh is made of: OpenFOAM's lists. Checked by [`Mesh::new`].
///
/// Faces `0..neighbour.len()` lie between two cells; the others are on the boundary. The corners of a face
/// are listed so that its normal (right-hand rule) points out of its owner.
#[derive(Debug, Clone, Default)]
pub struct MeshParts {
    /// Coordinates.
    pub points: Vec<[f64; 3]>,
    /// End of each face's corners in `face_points`; one entry per face.
    pub face_ends: Vec<usize>,
    /// Corners of all faces.
    pub face_points: Vec<u32>,
    /// Owner cell of each face.
    pub owner: Vec<u32>,
    /// Neighbour cell of each internal face.
    pub neighbour: Vec<u32>,
    /// Boundary patches; may be empty.
    pub patches: Vec<Patch>,
    /// Cell zones; may be empty.
    pub zones: Vec<Zone>,
}

impl MeshParts {
    /// Corners of a face.
    pub fn face(&self, face: usize) -> &[u32] {
        let start = if face == 0 { 0 } else { self.face_ends[face - 1] };
        &self.face_points[start..self.face_ends[face]]
    }

    /// Number of cells that the faces name.
    pub fn cell_count(&self) -> usize {
        self.owner.iter().chain(&self.neighbour).max().map_or(0, |&c| c as usize + 1)
    }
}

/// A polyhedral mesh: checked, with every face split once into planar pieces, and a search tree over its cells.
///
/// Cells may be concave, have any number of faces, and faces any number of corners, planar or not.
#[derive(Debug, Clone)]
pub struct Mesh {
    parts: MeshParts,
    pub(crate) surface: Surface,
    cell_face_ends: Vec<usize>,
    cell_faces: Vec<u32>,
    cell_vertex_ends: Vec<usize>,
    /// Distinct points and face centroids of each cell.
    cell_vertices: Vec<u32>,
    kinds: Vec<ElementKind>,
    corner_ends: Vec<usize>,
    /// Corners of standard cells in CGNS order.
    corners: Vec<u32>,
    volumes: Vec<f64>,
    pub(crate) centres: Vec<DVec3>,
    convex: Vec<bool>,
    inverted: Vec<u32>,
    inverted_elements: usize,
    pub(crate) bounds: Vec<[DVec3; 2]>,
    pub(crate) tree: CellTree,
}

impl Mesh {
    /// Builds a mesh from OpenFOAM's lists.
    ///
    /// Cells that are tetrahedra, pyramids, wedges or hexahedra are recognised. A cell whose faces all point
    /// inwards is taken with its absolute volume and listed in [`Mesh::inverted_cells`].
    ///
    /// # Errors
    /// Lists of unequal lengths, labels out of range, coordinates that are not finite, faces with less than three
    /// corners, cells with a hole or without volume: see [`MeshError`].
    pub fn new(parts: MeshParts) -> Result<Self, MeshError> {
        check(&parts)?;
        let cells = parts.cell_count();
        let (cell_face_ends, cell_faces) = faces_of_cells(&parts, cells);
        check_closed(&parts, &cell_face_ends, &cell_faces)?;
        let (kinds, corner_ends, corners) = shape::recognise(&parts, &cell_face_ends, &cell_faces);
        Self::assemble(parts, cell_face_ends, cell_faces, kinds, corner_ends, corners, 0)
    }

    /// Builds a mesh from cells listed by their corners: common faces are found and shared.
    ///
    /// Elements of negative volume are mirrored and counted in [`Mesh::inverted_elements`]; wedges are not, since
    /// both windings are in use. An element that repeats corners becomes what is left of it: a smaller element where that is
    /// one, else a polyhedron.
    ///
    /// # Errors
    /// As [`Mesh::new`]; also a face that more than two cells share, and a cell whose repeated corners leave nothing of it.
    pub fn from_cells(points: Vec<[f64; 3]>, cells: CellList) -> Result<Self, MeshError> {
        let shared = from_cells::share_faces(points, cells)?;
        check(&shared.parts)?;
        let (cell_face_ends, cell_faces) = faces_of_cells(&shared.parts, shared.kinds.len());
        check_closed(&shared.parts, &cell_face_ends, &cell_faces)?;
        Self::assemble(
            shared.parts,
            cell_face_ends,
            cell_faces,
            shared.kinds,
            shared.corner_ends,
            shared.corners,
            shared.inverted,
        )
    }

    fn assemble(
        parts: MeshParts,
        cell_face_ends: Vec<usize>,
        cell_faces: Vec<u32>,
        kinds: Vec<ElementKind>,
        corner_ends: Vec<usize>,
        corners: Vec<u32>,
        inverted_elements: usize,
    ) -> Result<Self, MeshError> {
        let surface = Surface::new(&parts);
        let cells = cell_face_ends.len();
        let mut this = Self {
            parts,
            surface,
            cell_face_ends,
            cell_faces,
            cell_vertex_ends: Vec::with_capacity(cells),
            cell_vertices: Vec::new(),
            kinds,
            corner_ends,
            corners,
            volumes: Vec::new(),
            centres: Vec::new(),
            convex: Vec::new(),
            inverted: Vec::new(),
            inverted_elements,
            bounds: Vec::new(),
            tree: CellTree::new(&[]),
        };
        let mut vertices = Vec::new();
        for cell in 0..cells {
            vertices.clear();
            for &face in this.cell_faces(cell) {
                for piece in this.surface.pieces(face as usize) {
                    vertices.extend_from_slice(this.surface.ring(piece));
                }
            }
            vertices.sort_unstable();
            vertices.dedup();
            this.cell_vertices.extend_from_slice(&vertices);
            this.cell_vertex_ends.push(this.cell_vertices.len());
        }
        let measured: Vec<(f64, DVec3, [DVec3; 2])> = (0..cells)
            .into_par_iter()
            .map(|cell| {
                let (volume, centre) = this.measure(cell);
                (volume, centre, this.box_around(cell))
            })
            .collect();
        for (cell, &(volume, centre, [low, high])) in measured.iter().enumerate() {
            let size = (high - low).max_element();
            // Above what a polyhedron of its own is refused for, whatever the two roundings: every cell that is taken can stand alone.
            if volume.abs() <= 8.0 * f64::EPSILON * f64::EPSILON * size.powi(3) || !volume.is_finite() {
                return Err(MeshError::NoVolume { cell, volume });
            }
            if volume < 0.0 {
                this.inverted.push(cell as u32);
            }
            this.volumes.push(volume.abs());
            this.centres.push(centre);
            this.bounds.push([low, high]);
        }
        this.convex = (0..cells).into_par_iter().map(|cell| this.is_convex_within(cell, 1e-12)).collect();
        this.tree = CellTree::new(&this.bounds);
        Ok(this)
    }

    /// Signed volume and centroid, with faces fanned around their centroids as OpenFOAM does.
    ///
    /// The volume is as exact as the promise needs it, in flat cells too: it is what a ball around the cell has in common with it.
    fn measure(&self, cell: usize) -> (f64, DVec3) {
        let [low, high] = self.box_around(cell);
        let origin = 0.5 * (low + high);
        let (mut three_volumes, mut weighted, mut terms) = (0.0, DVec3::ZERO, 0.0);
        for (face, sign) in self.signed_faces(cell) {
            // All triangles of a fan share the centroid, so it is the one point of a warped face to measure by. Of a planar
            // one any point will do, and a corner is not rounded.
            let pieces = self.surface.pieces(face);
            let to_face = self.surface.centroids[face] - origin;
            let on_face = match pieces.len() {
                1 => self.surface.vertices[self.surface.ring(pieces.start)[0] as usize] - origin,
                _ => to_face,
            };
            let pyramid = sign * self.surface.area_vectors[face].dot(on_face);
            three_volumes += pyramid;
            terms += self.area_terms(face).dot(on_face.abs());
            // The centroid of a pyramid is three quarters of the way from its apex to that of its base.
            weighted += 0.75 * pyramid * to_face;
        }
        let volume = three_volumes / 3.0;
        let centre = origin + weighted / three_volumes;
        if three_volumes.abs() > CANCELLED * terms {
            return (volume, centre);
        }
        // Next to nothing is left of the terms, so that the centroid is not known either, except that it is in the box.
        let centre = if centre.is_finite() { centre.clamp(low, high) } else { origin };
        match self.polyhedron_of_pieces(cell) {
            Ok(alone) if alone.was_inverted() => (-alone.volume(), centre),
            Ok(alone) => (alone.volume(), centre),
            // What cannot stand alone encloses nothing.
            Err(_) => (0.0, centre),
        }
    }

    /// Sum of the magnitudes of the products that a face's area vector is made of, along each axis.
    fn area_terms(&self, face: usize) -> DVec3 {
        let ring = self.parts.face(face);
        let from_centroid = |k: u32| self.surface.vertices[k as usize] - self.surface.centroids[face];
        let mut terms = DVec3::ZERO;
        let mut a = from_centroid(ring[ring.len() - 1]);
        for &k in ring {
            let b = from_centroid(k);
            terms += cross_terms(a, b);
            a = b;
        }
        0.5 * terms
    }

    fn box_around(&self, cell: usize) -> [DVec3; 2] {
        self.box_of(self.cell_vertices(cell))
    }

    fn box_of(&self, vertices: &[u32]) -> [DVec3; 2] {
        vertices.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], &k| {
            let v = self.surface.vertices[k as usize];
            [low.min(v), high.max(v)]
        })
    }

    fn is_convex_within(&self, cell: usize, tolerance: f64) -> bool {
        let [low, high] = self.bounds[cell];
        let limit = tolerance * (high - low).max_element();
        let outward = self.orientation(cell);
        // Of a cell with thousands of vertices most are far behind a face: they are passed over by the box.
        let boxes: Vec<(DVec3, DVec3, &[u32])> = self
            .cell_vertices(cell)
            .chunks(32)
            .map(|part| {
                let [low, high] = self.box_of(part);
                (0.5 * (low + high), 0.5 * (high - low), part)
            })
            .collect();
        self.signed_faces(cell).all(|(face, sign)| {
            self.surface.pieces(face).all(|piece| {
                let height = |point| outward * sign * self.surface.height(piece, point);
                let normal = self.surface.normal(piece).abs();
                boxes.iter().all(|&(middle, half, part)| {
                    height(middle) + normal.dot(half) <= 0.5 * limit
                        || part.iter().all(|&k| height(self.surface.vertices[k as usize]) <= limit)
                })
            })
        })
    }

    /// Points, faces, owner, neighbour, patches and zones.
    pub fn parts(&self) -> &MeshParts {
        &self.parts
    }

    /// The same mesh with other named sets of cells.
    #[must_use]
    pub fn with_zones(mut self, zones: Vec<Zone>) -> Self {
        self.parts.zones = zones;
        self
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cell_face_ends.len()
    }

    /// Volume of each cell; equal to OpenFOAM's, warped faces included.
    pub fn cell_volumes(&self) -> &[f64] {
        &self.volumes
    }

    /// Centroid of a cell, as OpenFOAM computes it.
    pub fn cell_centre(&self, cell: usize) -> [f64; 3] {
        self.centres[cell].to_array()
    }

    /// Shape of a cell.
    pub fn cell_kind(&self, cell: usize) -> ElementKind {
        self.kinds[cell]
    }

    /// Corners of a standard cell in CGNS order; `None` for a polyhedron.
    pub fn cell_corners(&self, cell: usize) -> Option<&[u32]> {
        let start = if cell == 0 { 0 } else { self.corner_ends[cell - 1] };
        let corners = &self.corners[start..self.corner_ends[cell]];
        (!corners.is_empty()).then_some(corners)
    }

    /// Faces of a cell.
    pub fn cell_faces(&self, cell: usize) -> &[u32] {
        let start = if cell == 0 { 0 } else { self.cell_face_ends[cell - 1] };
        &self.cell_faces[start..self.cell_face_ends[cell]]
    }

    /// Faces of a cell, each with +1 where its normal points out of the cell and −1 where into it.
    pub fn signed_faces(&self, cell: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.cell_faces(cell).iter().map(move |&face| {
            let owned = self.parts.owner[face as usize] as usize == cell;
            (face as usize, if owned { 1.0 } else { -1.0 })
        })
    }

    /// Points of the cell and centroids of its warped faces, as indices into the surface's vertices.
    pub(crate) fn cell_vertices(&self, cell: usize) -> &[u32] {
        let start = if cell == 0 { 0 } else { self.cell_vertex_ends[cell - 1] };
        &self.cell_vertices[start..self.cell_vertex_ends[cell]]
    }

    /// Whether a cell is convex, up to 1e-12 of its size, with its warped faces triangulated.
    pub fn is_convex(&self, cell: usize) -> bool {
        self.convex[cell]
    }

    /// Number of cells that are not convex.
    pub fn concave_cells(&self) -> usize {
        self.convex.iter().filter(|&&c| !c).count()
    }

    /// Number of faces that are not planar.
    pub fn warped_faces(&self) -> usize {
        self.surface.warped_faces
    }

    /// Cells whose faces point inwards.
    pub fn inverted_cells(&self) -> &[u32] {
        &self.inverted
    }

    /// Elements that were given inside out and have been mirrored (see [`Mesh::from_cells`]).
    pub fn inverted_elements(&self) -> usize {
        self.inverted_elements
    }

    /// +1, or −1 for an inverted cell.
    pub(crate) fn orientation(&self, cell: usize) -> f64 {
        if self.inverted.is_empty() || self.inverted.binary_search(&(cell as u32)).is_err() { 1.0 } else { -1.0 }
    }

    /// Lower and upper corner of the box around a cell.
    pub fn cell_bounds(&self, cell: usize) -> ([f64; 3], [f64; 3]) {
        let [low, high] = self.bounds[cell];
        (low.to_array(), high.to_array())
    }
}

/// The cross product with the magnitudes of its products added up.
pub(crate) fn cross_terms(a: DVec3, b: DVec3) -> DVec3 {
    let (a, b) = (a.abs(), b.abs());
    a.yzx() * b.zxy() + a.zxy() * b.yzx()
}

fn check(parts: &MeshParts) -> Result<(), MeshError> {
    let faces = parts.face_ends.len();
    let cells = parts.cell_count();
    if cells == 0 {
        return Err(MeshError::Empty);
    }
    // Tables are made for as many cells as the largest label says, so one damaged label could ask for any amount of memory.
    let sides = parts.owner.len() + parts.neighbour.len();
    if cells > sides {
        let named = |list: &[u32]| list.iter().position(|&c| c as usize + 1 == cells);
        let face = named(&parts.owner).or_else(|| named(&parts.neighbour)).unwrap_or_default();
        return Err(MeshError::CellOutOfRange { face, cell: cells - 1, most: sides });
    }
    // Centroids of warped faces are numbered behind the points.
    for (what, count) in [("points and faces", parts.points.len() + faces), ("corners", parts.face_points.len())] {
        if count >= u32::MAX as usize {
            return Err(MeshError::TooLarge { what, count });
        }
    }
    let expect = |what, found, expected| {
        if found == expected { Ok(()) } else { Err(MeshError::Count { what, found, expected }) }
    };
    expect("owners", parts.owner.len(), faces)?;
    expect("face corners", parts.face_points.len(), parts.face_ends.last().copied().unwrap_or(0))?;
    if parts.neighbour.len() > faces {
        return Err(MeshError::Count { what: "neighbours", found: parts.neighbour.len(), expected: faces });
    }
    if let Some(point) = parts.points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
        return Err(MeshError::PointNotFinite { point, at: parts.points[point] });
    }
    let mut start = 0;
    for (face, &end) in parts.face_ends.iter().enumerate() {
        if end < start {
            return Err(MeshError::Count { what: "face corners", found: end, expected: start });
        }
        let ring = &parts.face_points[start..end];
        start = end;
        if let Some(&point) = ring.iter().find(|&&p| p as usize >= parts.points.len()) {
            return Err(MeshError::PointOutOfRange { face, point: point as usize, points: parts.points.len() });
        }
        let repeated = ring.iter().enumerate().any(|(k, p)| ring[..k].contains(p));
        if ring.len() < 3 || repeated {
            return Err(MeshError::BadFace { face, corners: ring.to_vec() });
        }
    }
    for (face, (&neighbour, &owner)) in parts.neighbour.iter().zip(&parts.owner).enumerate() {
        if owner == neighbour {
            return Err(MeshError::BadCells { face, owner: owner as usize, neighbour: neighbour as usize, cells });
        }
    }
    for patch in &parts.patches {
        let end = patch.start.saturating_add(patch.count);
        if end > faces {
            return Err(MeshError::Count { what: "faces up to the last patch", found: end, expected: faces });
        }
    }
    for zone in &parts.zones {
        if let Some(&cell) = zone.cells.iter().find(|&&c| c as usize >= cells) {
            return Err(MeshError::Count {
                what: "cells up to the last of a zone",
                found: cell as usize + 1,
                expected: cells,
            });
        }
    }
    Ok(())
}

fn faces_of_cells(parts: &MeshParts, cells: usize) -> (Vec<usize>, Vec<u32>) {
    let mut ends = vec![0usize; cells];
    for &cell in parts.owner.iter().chain(&parts.neighbour) {
        ends[cell as usize] += 1;
    }
    let mut total = 0;
    for end in &mut ends {
        total += *end;
        *end = total - *end;
    }
    let mut faces = vec![0u32; total];
    for (face, &owner) in parts.owner.iter().enumerate() {
        for cell in [Some(owner), parts.neighbour.get(face).copied()].into_iter().flatten() {
            let next = &mut ends[cell as usize];
            faces[*next] = face as u32;
            *next += 1;
        }
    }
    (ends, faces)
}

/// Every edge of a cell must be run through once in each direction by its faces (or equally often where cells
/// touch themselves along an edge).
fn check_closed(parts: &MeshParts, ends: &[usize], cell_faces: &[u32]) -> Result<(), MeshError> {
    (0..ends.len()).into_par_iter().try_for_each(|cell| {
        let start = if cell == 0 { 0 } else { ends[cell - 1] };
        let mut edges: Vec<([u32; 2], i32)> = Vec::with_capacity(32);
        for &face in &cell_faces[start..ends[cell]] {
            let ring = parts.face(face as usize);
            let forward = if parts.owner[face as usize] as usize == cell { 1 } else { -1 };
            for (k, &a) in ring.iter().enumerate() {
                let b = ring[(k + 1) % ring.len()];
                edges.push(([a.min(b), a.max(b)], if a < b { forward } else { -forward }));
            }
        }
        edges.sort_unstable();
        match edges.chunk_by(|a, b| a.0 == b.0).find(|run| run.iter().map(|e| e.1).sum::<i32>() != 0) {
            Some(run) => Err(MeshError::OpenCell { cell, edge: run[0].0, faces: run.len() }),
            None if edges.is_empty() => Err(MeshError::NoVolume { cell, volume: 0.0 }),
            None => Ok(()),
        }
    })
}
