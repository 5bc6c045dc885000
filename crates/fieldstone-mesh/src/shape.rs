//! Which cells of a face-based mesh are tetrahedra, pyramids, wedges or hexahedra.

use fieldstone_geometry::ElementKind;

use crate::MeshParts;
use crate::rings::is_rotation;

/// Kinds of all cells, and the corners of the standard ones in CGNS order (ends and entries).
pub(crate) fn recognise(
    parts: &MeshParts,
    face_ends: &[usize],
    cell_faces: &[u32],
) -> (Vec<ElementKind>, Vec<usize>, Vec<u32>) {
    let mut kinds = Vec::with_capacity(face_ends.len());
    let mut ends = Vec::with_capacity(face_ends.len());
    let mut corners = Vec::new();
    let mut start = 0;
    for (cell, &end) in face_ends.iter().enumerate() {
        let rings: Vec<Vec<u32>> = cell_faces[start..end]
            .iter()
            .map(|&face| {
                let mut ring = parts.face(face as usize).to_vec();
                if parts.owner[face as usize] as usize != cell {
                    ring.reverse();
                }
                ring
            })
            .collect();
        start = end;
        match standard_corners(&rings) {
            Some((kind, own)) => {
                kinds.push(kind);
                corners.extend_from_slice(&own);
            }
            None => kinds.push(ElementKind::Polyhedron),
        }
        ends.push(corners.len());
    }
    (kinds, ends, corners)
}

/// Kind and corners from outward faces; `None` where they form no standard element.
pub(crate) fn standard_corners(rings: &[Vec<u32>]) -> Option<(ElementKind, Vec<u32>)> {
    let triangles = rings.iter().filter(|r| r.len() == 3).count();
    let quads = rings.iter().filter(|r| r.len() == 4).count();
    if triangles + quads != rings.len() {
        return None;
    }
    let kind = match (triangles, quads) {
        (4, 0) => ElementKind::Tetrahedron,
        (4, 1) => ElementKind::Pyramid,
        (2, 3) => ElementKind::Wedge,
        (0, 6) => ElementKind::Hexahedron,
        _ => return None,
    };
    // The bottom, seen from inside, and above each of its corners the one that an edge leads to.
    let sides = if kind == ElementKind::Pyramid { 4 } else { kind.faces()[0].len() };
    let mut corners: Vec<u32> = rings.iter().find(|r| r.len() == sides)?.iter().rev().copied().collect();
    for k in 0..if matches!(kind, ElementKind::Tetrahedron | ElementKind::Pyramid) { 1 } else { sides } {
        let above = edge_off(rings, corners[k], &corners[..sides])?;
        corners.push(above);
    }
    // The guess holds only if it names exactly the faces that are there.
    let found = kind.faces().iter().all(|face| {
        let ring: Vec<u32> = face.iter().map(|&k| corners[k]).collect();
        rings.iter().any(|r| r.len() == ring.len() && is_rotation(r, &ring))
    });
    found.then_some((kind, corners))
}

/// The corner joined to `from` by an edge that is not one of the bottom's corners.
fn edge_off(rings: &[Vec<u32>], from: u32, bottom: &[u32]) -> Option<u32> {
    rings.iter().find_map(|ring| {
        let at = ring.iter().position(|&p| p == from)?;
        let next = ring[(at + 1) % ring.len()];
        (!bottom.contains(&next)).then_some(next)
    })
}
