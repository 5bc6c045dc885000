//! Writes particles, surfaces and other polygons (`.vtp`).

use std::path::Path;

use fieldstone_particles::Particles;

use super::encoding::{Column, VtkEncoding};
use super::xml_writer::{VtkArrays, XmlFile};
use crate::{DataArray, IoError, Position};

/// Cells of a `.vtp`: vertices or polygons.
struct Cells<'a> {
    element: &'static str,
    connectivity: &'a [i64],
    /// End of each cell's part of `connectivity`.
    ends: &'a [i64],
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

/// As [`write_vtp_particles`], with names for the components of quantities: see [`VtkArrays::component_names`].
///
/// # Errors
/// [`IoError::System`].
pub fn write_vtp_particles_named(
    path: &Path,
    particles: &Particles,
    component_names: &[(&str, &[String])],
    encoding: VtkEncoding,
) -> Result<(), IoError> {
    write_columns(path, particles, &[], component_names, encoding)
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
    write_columns(path, particles, computed, &[], encoding)
}

fn write_columns(
    path: &Path,
    particles: &Particles,
    computed: &[DataArray],
    component_names: &[(&str, &[String])],
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
    let arrays = VtkArrays { points: &columns, time: particles.time(), component_names, ..VtkArrays::default() };
    let connectivity: Vec<i64> = (0..particles.len() as i64).collect();
    let ends: Vec<i64> = (1..=particles.len() as i64).collect();
    let cells = Cells { element: "Verts", connectivity: &connectivity, ends: &ends };
    write(path, particles.positions(), cells, arrays, encoding)
}

/// Writes a surface of triangles with columns on points and triangles as `.vtp`.
///
/// # Errors
/// As [`write_vtp_polygons`].
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
    let connectivity = triangles.as_flattened();
    let ends: Vec<usize> = (1..=triangles.len()).map(|k| 3 * k).collect();
    write_vtp_polygons(path, points, connectivity, &ends, arrays, encoding)
}

/// Writes polygons with columns on points and polygons as `.vtp`: the faces of a mesh, say.
///
/// `corners` lists the points of all polygons one after the other, and `ends` where each polygon's list ends.
///
/// # Errors
/// [`IoError::Content`] where a polygon names a point that does not exist, the lists do not fit each other, or a column has
/// not one row per point or polygon; [`IoError::System`].
///
/// ```
/// use fieldstone_io::DataArray;
/// use fieldstone_io::vtk::{VtkArrays, VtkEncoding, read_vtk, write_vtp_polygons};
/// // A square and a triangle beside it.
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0]];
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("two.vtp");
/// let area = [DataArray::scalar("area", vec![1.0, 0.5])];
/// let arrays = VtkArrays { cells: &area, ..VtkArrays::default() };
/// write_vtp_polygons(&path, &points, &[0, 1, 2, 3, 1, 4, 2], &[4, 7], arrays, VtkEncoding::default())?;
/// let back = read_vtk(&path)?;
/// assert_eq!(back.cells.types(), [9, 5]);
/// assert_eq!(back.cell_data, area);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_vtp_polygons(
    path: &Path,
    points: &[[f64; 3]],
    corners: &[u32],
    ends: &[usize],
    arrays: VtkArrays<'_>,
    encoding: VtkEncoding,
) -> Result<(), IoError> {
    let refuse = |found: String, remedy: &str| {
        Err(IoError::content(path, Position::File, found, format!("{remedy}; nothing was written")))
    };
    if let Some(bad) = corners.iter().position(|&p| p as usize >= points.len()) {
        let polygon = ends.partition_point(|&end| end <= bad);
        let found = format!("polygon {polygon} names point {}, but there are {}", corners[bad], points.len());
        return refuse(found, "give all points");
    }
    if !ends.is_sorted() || ends.last().copied().unwrap_or(0) != corners.len() {
        let found = format!("the ends of the polygons do not rise to the number of their corners, {}", corners.len());
        return refuse(found, "give the end of every polygon's list");
    }
    let connectivity: Vec<i64> = corners.iter().map(|&p| p.into()).collect();
    let ends: Vec<i64> = ends.iter().map(|&end| end as i64).collect();
    write(path, points, Cells { element: "Polys", connectivity: &connectivity, ends: &ends }, arrays, encoding)
}

fn write(
    path: &Path,
    points: &[[f64; 3]],
    cells: Cells<'_>,
    arrays: VtkArrays<'_>,
    encoding: VtkEncoding,
) -> Result<(), IoError> {
    let count = cells.ends.len();
    let mut attributes = format!(" NumberOfPoints=\"{}\"", points.len());
    for element in ["Verts", "Lines", "Strips", "Polys"] {
        let own = if element == cells.element { count } else { 0 };
        attributes += &format!(" NumberOf{element}=\"{own}\"");
    }
    let mut file = XmlFile::new(path, encoding, "PolyData", "", &arrays)?;
    file.open("Piece", &attributes);
    file.columns("PointData", arrays.points, points.len(), arrays.component_names)?;
    file.columns("CellData", arrays.cells, count, arrays.component_names)?;
    file.open("Points", "");
    file.array("Points", 3, Column::F64(points.as_flattened()))?;
    file.close("Points");
    file.open(cells.element, "");
    file.array("connectivity", 1, Column::I64(cells.connectivity))?;
    file.array("offsets", 1, Column::I64(cells.ends))?;
    file.close(cells.element);
    file.close("Piece");
    file.finish()
}
