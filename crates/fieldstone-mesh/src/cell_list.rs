//! Meshes given cell by cell (Gmsh, VTK), before faces are shared.

use fieldstone_geometry::{CornerOrder, ElementKind};

use crate::MeshError;

/// Cells listed one after the other, each by its corners, as Gmsh and VTK store them.
///
/// Turned into a mesh of shared faces by [`crate::Mesh::from_cells`].
///
/// ```
/// use fieldstone_geometry::{CornerOrder, ElementKind};
/// use fieldstone_mesh::{CellList, Mesh};
/// let mut cells = CellList::new();
/// cells.push(ElementKind::Tetrahedron, CornerOrder::Vtk, &[0, 1, 2, 3])?;
/// let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let mesh = Mesh::from_cells(points, cells)?;
/// assert!((mesh.cell_volumes()[0] - 1.0 / 6.0).abs() < 1e-15);
/// # Ok::<(), fieldstone_mesh::MeshError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct CellList {
    pub(crate) kinds: Vec<ElementKind>,
    /// End of each cell's entries in `entries`.
    pub(crate) ends: Vec<usize>,
    /// Standard cells: corners in CGNS order. Polyhedra: for each face its corner count and its corners.
    pub(crate) entries: Vec<u32>,
}

impl CellList {
    /// An empty list.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.kinds.len()
    }

    /// Whether there is no cell.
    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// Appends an element with a fixed number of corners. Either winding will do, and corners may be repeated, as in a prism
    /// that is written as a hexahedron: see [`crate::Mesh::from_cells`].
    ///
    /// # Errors
    /// [`MeshError::CornerCount`] for a wrong number of corners, and for [`ElementKind::Polyhedron`].
    pub fn push(&mut self, kind: ElementKind, order: CornerOrder, corners: &[u32]) -> Result<(), MeshError> {
        let expected = kind.corner_count().unwrap_or(0);
        if corners.len() != expected || expected == 0 {
            return Err(MeshError::CornerCount { cell: self.len(), kind, found: corners.len(), expected });
        }
        self.entries.extend(kind.to_cgns(order).iter().map(|&k| corners[k]));
        self.kinds.push(kind);
        self.ends.push(self.entries.len());
        Ok(())
    }

    /// Appends a polyhedron given by its faces, each a list of corners wound outwards (all inwards will do too).
    ///
    /// One without faces is refused with [`MeshError::NoFaces`] by [`crate::Mesh::from_cells`], as are faces of less than
    /// three corners.
    pub fn push_polyhedron<'a>(&mut self, faces: impl IntoIterator<Item = &'a [u32]>) {
        for face in faces {
            self.entries.push(face.len() as u32);
            self.entries.extend_from_slice(face);
        }
        self.kinds.push(ElementKind::Polyhedron);
        self.ends.push(self.entries.len());
    }

    pub(crate) fn entries_of(&self, cell: usize) -> &[u32] {
        let start = if cell == 0 { 0 } else { self.ends[cell - 1] };
        &self.entries[start..self.ends[cell]]
    }
}
