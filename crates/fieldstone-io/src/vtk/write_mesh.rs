//! Writes meshes (`.vtu`) and regular grids (`.vti`).

use std::path::Path;

use fieldstone_geometry::{CornerOrder, ElementKind};
use fieldstone_mesh::{Grid, Mesh};

use super::cells::POLYHEDRON;
use super::data::VtkImage;
use super::encoding::{Column, VtkEncoding, VtkWedges};
use super::xml_writer::{VtkArrays, XmlFile};
use crate::IoError;

/// Lists of a `.vtu`, polyhedra in the layout that all versions of VTK read.
#[derive(Debug, Default, PartialEq)]
struct UnstructuredGrid {
    connectivity: Vec<i64>,
    offsets: Vec<i64>,
    types: Vec<u8>,
    /// Face count, then corner count and corners of each face, of all polyhedra.
    faces: Vec<i64>,
    /// End of each cell's part of `faces`; −1 for other cells.
    faceoffsets: Vec<i64>,
}

impl UnstructuredGrid {
    fn new(mesh: &Mesh, wedges: VtkWedges) -> Self {
        let order = match wedges {
            VtkWedges::SinceVtk97 => CornerOrder::Cgns,
            VtkWedges::BeforeVtk97 => CornerOrder::Vtk,
        };
        let mut grid = Self::default();
        let mut points = Vec::new();
        for cell in 0..mesh.cell_count() {
            let kind = mesh.cell_kind(cell);
            match (type_code(kind), mesh.cell_corners(cell)) {
                (Some(code), Some(corners)) => {
                    // The permutation is its own inverse.
                    grid.connectivity.extend(kind.to_cgns(order).iter().map(|&k| i64::from(corners[k])));
                    grid.types.push(code);
                    grid.faceoffsets.push(-1);
                }
                _ => {
                    points.clear();
                    grid.push_faces(mesh, cell, &mut points);
                    points.sort_unstable();
                    points.dedup();
                    grid.connectivity.extend(points.iter().map(|&p| i64::from(p)));
                    grid.types.push(POLYHEDRON);
                    grid.faceoffsets.push(grid.faces.len() as i64);
                }
            }
            grid.offsets.push(grid.connectivity.len() as i64);
        }
        grid
    }

    fn push_faces(&mut self, mesh: &Mesh, cell: usize, points: &mut Vec<u32>) {
        self.faces.push(mesh.cell_faces(cell).len() as i64);
        for (face, sign) in mesh.signed_faces(cell) {
            let corners = mesh.parts().face(face);
            points.extend_from_slice(corners);
            self.faces.push(corners.len() as i64);
            // Every cell's faces are wound outwards.
            if sign > 0.0 {
                self.faces.extend(corners.iter().map(|&p| i64::from(p)));
            } else {
                self.faces.extend(corners.iter().rev().map(|&p| i64::from(p)));
            }
        }
    }
}

fn type_code(kind: ElementKind) -> Option<u8> {
    match kind {
        ElementKind::Tetrahedron => Some(10),
        ElementKind::Hexahedron => Some(12),
        ElementKind::Wedge => Some(13),
        ElementKind::Pyramid => Some(14),
        ElementKind::Polyhedron => None,
    }
}

/// Writes a mesh with columns on its points and cells as `.vtu`.
///
/// Tetrahedra, pyramids, wedges and hexahedra get their VTK type, other cells are written as polyhedra.
/// Cells keep their order. The file appears whole or not at all.
///
/// # Errors
/// [`IoError::Content`] where a column has not one row per point or cell; [`IoError::System`].
///
/// ```
/// use fieldstone_geometry::{CornerOrder, ElementKind};
/// use fieldstone_io::DataArray;
/// use fieldstone_io::vtk::{VtkArrays, VtkEncoding, read_vtk, write_vtu};
/// use fieldstone_mesh::{CellList, Mesh};
/// let mut cells = CellList::new();
/// cells.push(ElementKind::Tetrahedron, CornerOrder::Vtk, &[0, 1, 2, 3])?;
/// let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let mesh = Mesh::from_cells(points, cells)?;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("one.vtu");
/// let fraction = [DataArray::scalar("fraction", vec![0.25])];
/// write_vtu(&path, &mesh, VtkArrays { cells: &fraction, ..Default::default() }, VtkEncoding::default())?;
/// let back = read_vtk(&path)?;
/// assert_eq!(back.cells.types(), [10]);
/// assert_eq!(back.cell_data, fraction);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_vtu(path: &Path, mesh: &Mesh, arrays: VtkArrays<'_>, encoding: VtkEncoding) -> Result<(), IoError> {
    let grid = UnstructuredGrid::new(mesh, encoding.wedges);
    let points = &mesh.parts().points;
    let mut file = XmlFile::new(path, encoding, "UnstructuredGrid", "", &arrays)?;
    file.open("Piece", &format!(" NumberOfPoints=\"{}\" NumberOfCells=\"{}\"", points.len(), grid.types.len()));
    file.columns("PointData", arrays.points, points.len(), &[])?;
    file.columns("CellData", arrays.cells, grid.types.len(), arrays.component_names)?;
    file.open("Points", "");
    file.array("Points", 3, Column::F64(points.as_flattened()))?;
    file.close("Points");
    file.open("Cells", "");
    file.array("connectivity", 1, Column::I64(&grid.connectivity))?;
    file.array("offsets", 1, Column::I64(&grid.offsets))?;
    file.array("types", 1, Column::U8(&grid.types))?;
    if !grid.faces.is_empty() {
        file.array("faces", 1, Column::I64(&grid.faces))?;
        file.array("faceoffsets", 1, Column::I64(&grid.faceoffsets))?;
    }
    file.close("Cells");
    file.close("Piece");
    file.finish()
}

impl From<&Grid> for VtkImage {
    fn from(grid: &Grid) -> Self {
        Self::aligned(grid.low(), grid.spacing(), grid.cells())
    }
}

/// Writes a regular grid with columns on its points and cells as `.vti`; x runs fastest.
///
/// # Errors
/// As [`write_vtu`].
///
/// ```
/// use fieldstone_io::DataArray;
/// use fieldstone_io::vtk::{VtkArrays, VtkEncoding, VtkImage, read_vtk, write_vti};
/// let grid = VtkImage::aligned([-1.0, 0.0, 0.0], [0.5, 0.5, 1.0], [2, 1, 1]);
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("grid.vti");
/// let fraction = [DataArray::scalar("fraction", vec![0.25, 0.5])];
/// write_vti(&path, &grid, VtkArrays { cells: &fraction, ..Default::default() }, VtkEncoding::default())?;
/// assert_eq!(read_vtk(&path)?.image, Some(grid));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_vti(path: &Path, grid: &VtkImage, arrays: VtkArrays<'_>, encoding: VtkEncoding) -> Result<(), IoError> {
    let [nx, ny, nz] = grid.cells;
    let extent = format!("0 {nx} 0 {ny} 0 {nz}");
    let words = |numbers: &[f64]| numbers.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(" ");
    let attributes = format!(
        " WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\" Direction=\"{}\"",
        words(&grid.origin),
        words(&grid.spacing),
        words(grid.direction.as_flattened())
    );
    let mut file = XmlFile::new(path, encoding, "ImageData", &attributes, &arrays)?;
    file.open("Piece", &format!(" Extent=\"{extent}\""));
    file.columns("PointData", arrays.points, grid.point_count(), &[])?;
    file.columns("CellData", arrays.cells, grid.cell_count(), arrays.component_names)?;
    file.close("Piece");
    file.finish()
}
