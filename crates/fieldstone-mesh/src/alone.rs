//! A cell as a polyhedron of its own.

use std::collections::HashMap;

use fieldstone_geometry::{ElementError, Orientation, Polyhedron};

use crate::Mesh;
use crate::rings::simple_loops;

impl Mesh {
    /// A cell as a polyhedron of its own: the path that shares nothing with its neighbours.
    ///
    /// Points at the same place are one corner. A face that this leaves with less than three corners is not among those of the
    /// polyhedron; otherwise they are the cell's, in the order of [`Mesh::cell_faces`].
    ///
    /// # Errors
    /// [`ElementError::NoVolume`] where merging points leaves nothing of the cell.
    pub fn polyhedron(&self, cell: usize) -> Result<Polyhedron, ElementError> {
        let points = &self.parts().points;
        let rings = self.signed_faces(cell).map(|(face, sign)| outward(self.parts().face(face).to_vec(), sign));
        stand_alone(rings, |label| points[label as usize])
    }

    /// As [`Mesh::polyhedron`], from the very pieces that the mesh has: a warped face is fanned around the mesh's rounded
    /// centroid, whatever a polyhedron of its own would make of it.
    pub(crate) fn polyhedron_of_pieces(&self, cell: usize) -> Result<Polyhedron, ElementError> {
        let pieces = self
            .signed_faces(cell)
            .flat_map(|(face, sign)| self.closed_pieces(face).into_iter().map(move |ring| outward(ring, sign)));
        stand_alone(pieces, |label| self.surface.vertices[label as usize].to_array())
    }

    /// The pieces of a face with those that have no area: without them the pieces of a cell would not close it.
    fn closed_pieces(&self, face: usize) -> Vec<Vec<u32>> {
        let ring = self.parts().face(face);
        let last = self.surface.pieces(face).next().and_then(|piece| self.surface.ring(piece).last());
        match last {
            Some(&apex) if apex as usize >= self.parts().points.len() => {
                ring.iter().enumerate().map(|(k, &a)| vec![a, ring[(k + 1) % ring.len()], apex]).collect()
            }
            _ => vec![ring.to_vec()],
        }
    }
}

/// A polyhedron from rings of labels, those of points at one place being one corner.
pub(crate) fn stand_alone(
    rings: impl Iterator<Item = Vec<u32>>,
    point: impl Fn(u32) -> [f64; 3],
) -> Result<Polyhedron, ElementError> {
    let mut corners: Vec<[f64; 3]> = Vec::new();
    let mut numbers: HashMap<[u64; 3], usize> = HashMap::new();
    let mut faces: Vec<Vec<usize>> = Vec::new();
    for labels in rings {
        let ring: Vec<usize> = labels
            .iter()
            .map(|&label| {
                let at = point(label);
                // By value: adding 0 makes one zero of the two.
                *numbers.entry(at.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                    corners.push(at);
                    corners.len() - 1
                })
            })
            .collect();
        faces.extend(simple_loops(&ring));
    }
    Polyhedron::from_faces(&corners, &faces, Orientation::Fix)
}

/// A ring of a face as the cell on one of its sides runs through it.
fn outward(mut ring: Vec<u32>, sign: f64) -> Vec<u32> {
    if sign < 0.0 {
        ring.reverse();
    }
    ring
}
