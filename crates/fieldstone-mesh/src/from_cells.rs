//! From cells listed by corners to faces shared by cells.

use std::collections::HashMap;

use fieldstone_geometry::ElementKind;
use glam::DVec3;

use crate::alone::stand_alone;
use crate::mesh::{CANCELLED, cross_terms};
use crate::rings::{is_rotation, simple_loops};
use crate::shape::standard_corners;
use crate::{CellList, MeshError, MeshParts, Patch};

/// Cells with shared faces.
pub(crate) struct Shared {
    pub parts: MeshParts,
    pub kinds: Vec<ElementKind>,
    pub corner_ends: Vec<usize>,
    pub corners: Vec<u32>,
    pub inverted: usize,
}

/// Where a face was met: the cell, and where its corners start in the list of all corners.
#[derive(Clone, Copy)]
struct Side {
    cell: u32,
    start: usize,
    len: usize,
}

struct Met {
    first: Side,
    second: Option<Side>,
}

pub(crate) fn share_faces(points: Vec<[f64; 3]>, cells: CellList) -> Result<Shared, MeshError> {
    if cells.is_empty() {
        return Err(MeshError::Empty);
    }
    let mut corners: Vec<u32> = Vec::new();
    let mut corner_ends = Vec::with_capacity(cells.len());
    let mut rings: Vec<u32> = Vec::new();
    let mut met: Vec<Met> = Vec::new();
    let mut index: HashMap<Box<[u32]>, u32> = HashMap::with_capacity(3 * cells.len());
    let mut inverted = 0;
    let mut kinds = Vec::with_capacity(cells.len());

    for cell in 0..cells.len() {
        let entries = cells.entries_of(cell);
        let mut kind = cells.kinds[cell];
        let cell_rings = if kind == ElementKind::Polyhedron {
            polyhedron_rings(&points, cell, entries)?
        } else {
            check_points(&points, cell, entries)?;
            let mut own = entries.to_vec();
            if is_inside_out(&points, &rings_of(kind, &own)) {
                own = kind.mirrored().iter().map(|&k| entries[k]).collect();
                inverted += usize::from(kind != ElementKind::Wedge);
            }
            let mut rings = rings_of(kind, &own);
            if (1..own.len()).any(|k| own[..k].contains(&own[k])) {
                rings = without_repeats(&rings);
                if rings.len() < 4 {
                    return Err(MeshError::Collapsed { cell, kind, corners: entries.to_vec() });
                }
                (kind, own) = standard_corners(&rings).unwrap_or((ElementKind::Polyhedron, Vec::new()));
            }
            corners.extend_from_slice(&own);
            rings
        };
        kinds.push(kind);
        corner_ends.push(corners.len());
        for ring in cell_rings {
            let mut key = ring.clone();
            key.sort_unstable();
            let side = Side { cell: cell as u32, start: rings.len(), len: ring.len() };
            rings.extend_from_slice(&ring);
            match index.get(key.as_slice()) {
                None => {
                    index.insert(key.into_boxed_slice(), met.len() as u32);
                    met.push(Met { first: side, second: None });
                }
                Some(&at) => {
                    let face = &mut met[at as usize];
                    if let Some(second) = face.second {
                        let cells = [face.first.cell, second.cell, side.cell].map(|c| c as usize);
                        return Err(MeshError::SharedFace { cells, corners: key });
                    }
                    face.second = Some(side);
                }
            }
        }
    }

    // Internal faces first, each side in the order of the cells, so that the result does not depend on hashing.
    let mut parts = MeshParts { points, ..MeshParts::default() };
    for internal in [true, false] {
        for face in met.iter().filter(|f| f.second.is_some() == internal) {
            parts.face_points.extend_from_slice(&rings[face.first.start..face.first.start + face.first.len]);
            parts.face_ends.push(parts.face_points.len());
            parts.owner.push(face.first.cell);
            parts.neighbour.extend(face.second.map(|side| side.cell));
        }
    }
    let start = parts.neighbour.len();
    let count = parts.owner.len() - start;
    parts.patches.push(Patch { name: "boundary".into(), kind: "patch".into(), start, count });
    Ok(Shared { parts, kinds, corner_ends, corners, inverted })
}

fn check_points(points: &[[f64; 3]], cell: usize, corners: &[u32]) -> Result<(), MeshError> {
    match corners.iter().find(|&&p| p as usize >= points.len()) {
        Some(&point) => Err(MeshError::CellPointOutOfRange { cell, point: point as usize, points: points.len() }),
        None => Ok(()),
    }
}

/// The faces of a polyhedron, turned outwards if all of them point inwards.
fn polyhedron_rings(points: &[[f64; 3]], cell: usize, entries: &[u32]) -> Result<Vec<Vec<u32>>, MeshError> {
    let (mut rings, mut face) = (Vec::new(), 0);
    let mut rest = entries;
    while let Some((&count, tail)) = rest.split_first() {
        let (ring, tail) = tail.split_at((count as usize).min(tail.len()));
        check_points(points, cell, ring)?;
        if ring.len() < 3 {
            return Err(MeshError::BadCellFace { cell, face, corners: ring.to_vec() });
        }
        rings.push(ring.to_vec());
        face += 1;
        rest = tail;
    }
    if rings.is_empty() {
        return Err(MeshError::NoFaces { cell });
    }
    if rings.iter().any(|ring| simple_loops(ring) != [&ring[..]]) {
        rings = without_repeats(&rings);
        if rings.len() < 4 {
            return Err(MeshError::Collapsed { cell, kind: ElementKind::Polyhedron, corners: entries.to_vec() });
        }
    }
    make_consistent(&mut rings);
    if is_inside_out(points, &rings) {
        rings.iter_mut().for_each(|ring| ring.reverse());
    }
    Ok(rings)
}

/// Turns faces so that neighbours run through their common edge in opposite directions, starting from the first.
///
/// Some writers list the faces of a polyhedron in any winding; readers of VTK files must not rely on it.
fn make_consistent(rings: &mut [Vec<u32>]) {
    // Sorted, so that the faces at an edge are side by side: a cell may have thousands.
    let mut edges: Vec<([u32; 2], usize, bool)> = Vec::new();
    for (face, ring) in rings.iter().enumerate() {
        edges.extend(edges_of(ring).map(|[a, b]| ([a.min(b), a.max(b)], face, a < b)));
    }
    edges.sort_unstable();
    // Of each face, whether it is to be turned, once that is known.
    let mut turned: Vec<Option<bool>> = vec![None; rings.len()];
    let mut waiting = Vec::new();
    if let Some(first) = turned.first_mut() {
        *first = Some(false);
        waiting.push((0, false));
    }
    let mut met: Vec<(usize, bool)> = Vec::new();
    while let Some((at, turned_at)) = waiting.pop() {
        met.clear();
        for [a, b] in edges_of(&rings[at]) {
            let edge = [a.min(b), a.max(b)];
            let start = edges.partition_point(|e| e.0 < edge);
            for &(_, other, forward) in edges[start..].iter().take_while(|e| e.0 == edge) {
                if turned[other].is_none() {
                    met.push((other, forward == ((a < b) != turned_at)));
                }
            }
        }
        met.sort_unstable();
        for faces in met.chunk_by(|a, b| a.0 == b.0) {
            let (other, turn) = (faces[0].0, faces.iter().all(|&(_, same)| same));
            turned[other] = Some(turn);
            waiting.push((other, turn));
        }
    }
    for (ring, turn) in rings.iter_mut().zip(turned) {
        if turn == Some(true) {
            ring.reverse();
        }
    }
}

fn edges_of(ring: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    ring.iter().enumerate().map(|(k, &a)| [a, ring[(k + 1) % ring.len()]])
}

/// What is left of a cell's faces where corners are repeated: rings of different corners, without those that lie on each other.
///
/// Naming a corner twice is the usual way to write a prism or a pyramid as a hexahedron.
fn without_repeats(rings: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let mut left: Vec<Vec<u32>> = Vec::with_capacity(rings.len());
    for ring in rings.iter().flat_map(|ring| simple_loops(ring)) {
        let mut back = ring.clone();
        back.reverse();
        // Two faces that have closed on each other enclose nothing.
        match left.iter().position(|other| is_rotation(other, &back)) {
            Some(at) => drop(left.remove(at)),
            None => left.push(ring),
        }
    }
    left
}

fn rings_of(kind: ElementKind, corners: &[u32]) -> Vec<Vec<u32>> {
    kind.faces().iter().map(|face| face.iter().map(|&k| corners[k]).collect()).collect()
}

/// Whether faces enclose a negative volume; of a flat cell rounded terms do not tell.
fn is_inside_out(points: &[[f64; 3]], rings: &[Vec<u32>]) -> bool {
    let Some(&origin) = rings.first().and_then(|ring| ring.first()) else { return false };
    let at = |k: u32| DVec3::from(points[k as usize]) - DVec3::from(points[origin as usize]);
    let (mut six_volumes, mut terms) = (0.0, 0.0);
    for ring in rings {
        let first = at(ring[0]);
        for pair in ring[1..].windows(2) {
            let (a, b) = (at(pair[0]), at(pair[1]));
            six_volumes += first.dot(a.cross(b));
            terms += first.abs().dot(cross_terms(a, b));
        }
    }
    if six_volumes.abs() > CANCELLED * terms {
        return six_volumes < 0.0;
    }
    stand_alone(rings.iter().cloned(), |label| points[label as usize]).is_ok_and(|alone| alone.was_inverted())
}
