//! Meshes from VTK cells.

use std::collections::BTreeMap;
use std::path::Path;

use fieldstone_geometry::{CornerOrder, ElementKind};
use fieldstone_mesh::{CellList, Mesh};

use super::cells::POLYHEDRON;
use super::data::{VtkData, VtkKind};
use super::fault::{DAMAGED, Fault};
use super::read_vtk;
use crate::{IoError, Position, Values};

/// A mesh, and how its cells relate to those of the file.
#[derive(Debug, Clone)]
pub struct VtkMesh {
    /// The mesh of the three-dimensional cells.
    pub mesh: Mesh,
    /// For each cell of the mesh its number in the file, from 0: picks cell data.
    pub file_cells: Vec<u32>,
    /// Cells passed over: how many of each VTK type of fewer dimensions. Ghost copies count under their type.
    pub ignored: BTreeMap<u8, usize>,
}

/// Reads the mesh in a `.vtu` or legacy unstructured-grid file.
///
/// Vertices, lines and polygons beside the cells are passed over, and so are ghost cells that a parallel
/// program marked in `vtkGhostType`. Pieces of a parallel file are joined as they are: cells on both sides of
/// a joint share faces only where they share points.
///
/// # Errors
/// Those of [`read_vtk`]; [`IoError::Content`] where there is no three-dimensional cell, or one of higher
/// order or of a type that is not supported; [`IoError::Mesh`] where the cells make no mesh.
pub fn read_vtk_mesh(path: &Path) -> Result<Mesh, IoError> {
    Ok(read_vtk(path)?.to_mesh()?.mesh)
}

/// What to do with a cell of some type.
#[derive(Debug, PartialEq)]
enum Role {
    Ignored,
    Standard(ElementKind),
    Voxel,
    Prism(usize),
    Polyhedron,
    Curved(&'static str),
    Unknown,
}

fn role(kind: u8) -> Role {
    match kind {
        // Empty, vertices, lines, polygons; their quadratic, Lagrange and Bézier relatives.
        0..=9 | 21..=23 | 28 | 30 | 31 | 34..=36 | 60..=63 | 68..=70 | 75..=77 => Role::Ignored,
        10 => Role::Standard(ElementKind::Tetrahedron),
        11 => Role::Voxel,
        12 => Role::Standard(ElementKind::Hexahedron),
        13 => Role::Standard(ElementKind::Wedge),
        14 => Role::Standard(ElementKind::Pyramid),
        15 => Role::Prism(5),
        16 => Role::Prism(6),
        POLYHEDRON => Role::Polyhedron,
        24 => Role::Curved("quadratic tetrahedron"),
        25 => Role::Curved("quadratic hexahedron"),
        26 => Role::Curved("quadratic wedge"),
        27 => Role::Curved("quadratic pyramid"),
        29 | 33 => Role::Curved("triquadratic hexahedron"),
        32 => Role::Curved("biquadratic wedge"),
        37 => Role::Curved("triquadratic pyramid"),
        64..=66 | 71..=74 | 78..=81 => Role::Curved("higher-order cell"),
        _ => Role::Unknown,
    }
}

impl VtkData {
    /// The mesh of the file's three-dimensional cells.
    ///
    /// # Errors
    /// As [`read_vtk_mesh`].
    pub fn to_mesh(&self) -> Result<VtkMesh, IoError> {
        let fault = |found: String, remedy| Fault::new(Position::File, found, remedy).in_file(&self.path);
        if self.kind == VtkKind::ImageData {
            return Err(fault(
                "the file holds a regular grid, not a mesh of cells".into(),
                "give the grid's bounds and counts (--grid and --cells), or convert it to an unstructured grid",
            ));
        }
        let ghosts = self.duplicates(&self.cell_data);
        let mut list = CellList::new();
        let mut file_cells = Vec::new();
        let mut ignored = BTreeMap::new();
        for (cell, &kind) in self.cells.types().iter().enumerate() {
            let corners = self.cells.corners(cell);
            let role = if ghosts.get(cell) == Some(&true) { Role::Ignored } else { role(kind) };
            let wrong_count = |wanted: usize| {
                fault(format!("cell {cell} (type {kind}) has {} corners, not {wanted}", corners.len()), DAMAGED)
            };
            match role {
                Role::Ignored => {
                    *ignored.entry(kind).or_insert(0) += 1;
                    continue;
                }
                Role::Standard(kind) => {
                    if kind.corner_count() != Some(corners.len()) {
                        return Err(wrong_count(kind.corner_count().unwrap_or(0)));
                    }
                    list.push(kind, CornerOrder::Vtk, corners).map_err(|e| self.no_mesh(e))?;
                }
                Role::Voxel => {
                    let &[a, b, c, d, e, f, g, h] = corners else { return Err(wrong_count(8)) };
                    // A voxel counts along x, then y, then z; a hexahedron goes round.
                    let round = [a, b, d, c, e, f, h, g];
                    list.push(ElementKind::Hexahedron, CornerOrder::Vtk, &round).map_err(|e| self.no_mesh(e))?;
                }
                Role::Prism(n) => {
                    if corners.len() != 2 * n {
                        return Err(wrong_count(2 * n));
                    }
                    let faces = prism_faces(corners, n);
                    list.push_polyhedron(faces.iter().map(Vec::as_slice));
                }
                Role::Polyhedron => list.push_polyhedron(self.cells.faces(cell)),
                Role::Curved(name) => {
                    return Err(fault(
                        format!("cell {cell} is a {name} (type {kind}), whose faces are curved"),
                        "write the mesh with linear cells; in ParaView: Tessellate",
                    ));
                }
                Role::Unknown => {
                    return Err(fault(
                        format!("cell {cell} has type {kind}, which is not supported"),
                        "tetrahedra, hexahedra, voxels, wedges, pyramids, prisms and polyhedra are",
                    ));
                }
            }
            file_cells.push(cell as u32);
        }
        if list.is_empty() {
            let count = self.cells.len();
            let found = format!("none of the {count} cells is three-dimensional{}", types_found(&ignored));
            return Err(fault(found, "give a volume mesh: tetrahedra, hexahedra, wedges, pyramids, polyhedra"));
        }
        let mesh = Mesh::from_cells(self.points.clone(), list).map_err(|e| self.no_mesh(e))?;
        Ok(VtkMesh { mesh, file_cells, ignored })
    }

    /// Whether there is a three-dimensional cell, so that the file holds a mesh and not just points and surfaces.
    pub fn has_volume_cells(&self) -> bool {
        self.cells.types().iter().any(|&kind| !matches!(role(kind), Role::Ignored | Role::Unknown))
    }

    fn no_mesh(&self, source: fieldstone_mesh::MeshError) -> IoError {
        IoError::Mesh { path: self.path.clone(), source }
    }

    /// Which points or cells are copies of another process's, by bit 1 of `vtkGhostType`; empty where none is.
    pub(super) fn duplicates(&self, arrays: &[crate::DataArray]) -> Vec<bool> {
        match arrays.iter().find(|a| a.name == "vtkGhostType").map(|a| &a.values) {
            Some(Values::U8(marks)) if marks.iter().any(|m| m & 1 != 0) => marks.iter().map(|m| m & 1 != 0).collect(),
            _ => Vec::new(),
        }
    }
}

/// Faces of a prism: two polygons of `n` corners and the quadrilaterals between them, all wound one way.
fn prism_faces(corners: &[u32], n: usize) -> Vec<Vec<u32>> {
    let (low, high) = corners.split_at(n);
    let mut faces = vec![low.iter().rev().copied().collect::<Vec<u32>>(), high.to_vec()];
    faces.extend((0..n).map(|k| vec![low[k], low[(k + 1) % n], high[(k + 1) % n], high[k]]));
    faces
}

fn types_found(ignored: &BTreeMap<u8, usize>) -> String {
    let parts: Vec<String> = ignored.iter().map(|(kind, n)| format!("{n} of type {kind}")).collect();
    if parts.is_empty() { String::new() } else { format!(" ({})", parts.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DataArray;

    fn data(kind: u8, corners: &[u32]) -> VtkData {
        let mut d = VtkData::new(VtkKind::UnstructuredGrid);
        d.points = (0..12).map(|k| [f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)]).collect();
        d.cells.push(kind, corners.iter().copied());
        d
    }

    #[test]
    fn quadratic_cells_are_refused_by_name() {
        let e = data(24, &[0, 1, 2, 4, 3, 5, 6, 7, 8, 9]).to_mesh().unwrap_err();
        assert!(e.to_string().contains("quadratic tetrahedron"), "{e}");
    }

    #[test]
    fn a_file_with_surfaces_only_is_refused_and_says_what_it_has() {
        let e = data(5, &[0, 1, 2]).to_mesh().unwrap_err();
        assert!(e.to_string().contains("1 of type 5"), "{e}");
        assert!(!data(5, &[0, 1, 2]).has_volume_cells() && data(10, &[0, 1, 2, 3]).has_volume_cells());
        assert!(VtkData::new(VtkKind::PolyData).to_mesh().is_err());
    }

    #[test]
    fn ghost_cells_and_lower_dimensions_are_passed_over_and_counted() {
        let mut d = data(11, &[0, 1, 2, 3, 4, 5, 6, 7]);
        d.cells.push(9, [0, 1, 3, 2]);
        d.cells.push(12, [4, 5, 7, 6, 8, 9, 11, 10]);
        d.cell_data.push(DataArray { name: "vtkGhostType".into(), components: 1, values: Values::U8(vec![0, 0, 1]) });
        let m = d.to_mesh().unwrap();
        assert_eq!(m.file_cells, [0]);
        assert_eq!(m.ignored, BTreeMap::from([(9, 1), (12, 1)]));
    }

    #[test]
    fn a_cell_with_a_corner_too_few_is_refused() {
        for kind in [10, 11, 12, 13, 14, 15, 16] {
            assert!(data(kind, &[0, 1, 2]).to_mesh().unwrap_err().to_string().contains("has 3 corners"));
        }
    }
}
