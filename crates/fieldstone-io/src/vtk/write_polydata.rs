//! Writes particles and surfaces (`.vtp`).

use std::path::Path;

use fieldstone_particles::Particles;

use super::encoding::{Column, VtkEncoding};
use super::xml_writer::{VtkArrays, XmlFile};
use crate::{DataArray, IoError, Position};

/// Cells of a `.vtp`: vertices or triangles.
struct Cells<'a> {
    element: &'static str,
    connectivity: &'a [i64],
    corners: usize,
}

/// Writes particles as `.vtp`: a vertex each, with radius, id, type and all quantities as columns on points.
///
/// [`crate::vtk::read_vtk_particles`] gives the same particles back, apart from their box and step.
///
/// # Errors
/// [`IoError::System`] where the file cannot be written.
///
/// ```
/// use fieldstone_io::vtk::{VtkEncoding, read_vtk_particles, write_vtp_particles};
/// use fieldstone_particles::Particles;
/// let two = Particles::new(vec![[0.0; 3], [1.0, 0.1, 0.0]])?.with_radii(vec![0.5, 0.25])?;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("two.vtp");
/// write_vtp_particles(&path, &two, VtkEncoding::default())?;
/// assert_eq!(read_vtk_particles(&path)?, two);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_vtp_particles(path: &Path, particles: &Particles, encoding: VtkEncoding) -> Result<(), IoError> {
    write_vtp_particles_with(path, particles, &[], encoding)
}

/// As [`write_vtp_particles`], with more columns on the particles: those that were computed, integers among them.
///
/// A column of the particles that has the name of one of `computed` is left out.
///
/// # Errors
/// [`IoError::Content`] where a column has not one row per particle; [`IoError::System`].
pub fn write_vtp_particles_with(
    path: &Path,
    particles: &Particles,
    computed: &[DataArray],
    encoding: VtkEncoding,
) -> Result<(), IoError> {
    let mut columns = Vec::new();
    if let Ok(radii) = particles.radii() {
        columns.push(DataArray::scalar("radius", radii.to_vec()));
    }
    if let Some(ids) = particles.ids() {
        columns.push(DataArray::integers("id", ids.to_vec()));
    }
    if let Some(types) = particles.types() {
        columns.push(DataArray::integers("type", types.to_vec()));
    }
    for quantity in particles.quantities() {
        columns.push(DataArray::floats(&quantity.name, quantity.components, quantity.data.clone()));
    }
    columns.retain(|column| computed.iter().all(|other| other.name != column.name));
    columns.extend_from_slice(computed);
    let arrays = VtkArrays { points: &columns, time: particles.time(), ..VtkArrays::default() };
    let connectivity: Vec<i64> = (0..particles.len() as i64).collect();
    let cells = Cells { element: "Verts", connectivity: &connectivity, corners: 1 };
    write(path, particles.positions(), cells, arrays, encoding)
}

/// Writes a surface of triangles with columns on points and triangles as `.vtp`.
///
/// # Errors
/// [`IoError::Content`] where a triangle names a point that does not exist or a column has not one row per
/// point or triangle; [`IoError::System`].
///
/// ```
/// use fieldstone_io::vtk::{VtkArrays, VtkEncoding, read_vtk, write_vtp_surface};
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("triangle.vtp");
/// write_vtp_surface(&path, &points, &[[0, 1, 2]], VtkArrays::default(), VtkEncoding::default())?;
/// assert_eq!(read_vtk(&path)?.cells.types(), [5]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_vtp_surface(
    path: &Path,
    points: &[[f64; 3]],
    triangles: &[[u32; 3]],
    arrays: VtkArrays<'_>,
    encoding: VtkEncoding,
) -> Result<(), IoError> {
    if let Some(bad) = triangles.iter().position(|t| t.iter().any(|&p| p as usize >= points.len())) {
        let found = format!("triangle {bad} names points {:?}, but there are {}", triangles[bad], points.len());
        return Err(IoError::content(path, Position::File, found, "give all points; nothing was written"));
    }
    let connectivity: Vec<i64> = triangles.as_flattened().iter().map(|&p| p.into()).collect();
    let cells = Cells { element: "Polys", connectivity: &connectivity, corners: 3 };
    write(path, points, cells, arrays, encoding)
}

fn write(
    path: &Path,
    points: &[[f64; 3]],
    cells: Cells<'_>,
    arrays: VtkArrays<'_>,
    encoding: VtkEncoding,
) -> Result<(), IoError> {
    let count = cells.connectivity.len() / cells.corners;
    let ends: Vec<i64> = (1..=count as i64).map(|k| k * cells.corners as i64).collect();
    let mut attributes = format!(" NumberOfPoints=\"{}\"", points.len());
    for element in ["Verts", "Lines", "Strips", "Polys"] {
        let own = if element == cells.element { count } else { 0 };
        attributes += &format!(" NumberOf{element}=\"{own}\"");
    }
    let mut file = XmlFile::new(path, encoding, "PolyData", "", &arrays)?;
    file.open("Piece", &attributes);
    file.columns("PointData", arrays.points, points.len(), &[])?;
    file.columns("CellData", arrays.cells, count, arrays.component_names)?;
    file.open("Points", "");
    file.array("Points", 3, Column::F64(points.as_flattened()))?;
    file.close("Points");
    file.open(cells.element, "");
    file.array("connectivity", 1, Column::I64(cells.connectivity))?;
    file.array("offsets", 1, Column::I64(&ends))?;
    file.close(cells.element);
    file.close("Piece");
    file.finish()
}
