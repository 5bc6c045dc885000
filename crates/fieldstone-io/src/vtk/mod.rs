//! VTK files: XML (`.vtu`, `.vtp`, `.vti`) and legacy (`.vtk`), read; XML, written.
//!
//! [`read_vtk`] reads whatever a file holds; [`read_vtk_mesh`] and [`read_vtk_particles`] make a mesh or
//! particles of it. All encodings that VTK writes are readable: text, base64 and raw; without compression,
//! zlib, lz4 and lzma; both header widths; both byte orders; polyhedra in the layouts before and since VTK 9.4.
//!
//! [`write_vtu`], [`write_vti`], [`write_vtp_particles`], [`write_vtp_surface`] and [`write_vtp_polygons`] write what VTK,
//! ParaView, pyvista and meshio open; [`write_pvd`] lists such files over time.

mod blocks;
mod cells;
mod data;
mod encoding;
mod fault;
mod legacy_input;
mod legacy_reader;
mod mesh;
mod particles;
mod scalar;
mod series;
mod symmetric_tensor;
mod write_mesh;
mod write_polydata;
mod xml_image;
mod xml_reader;
mod xml_tree;
mod xml_writer;

use std::io::{BufRead, Read};
use std::path::Path;

pub use data::{VtkCells, VtkData, VtkImage, VtkKind, VtkLocation, VtkSummary};
pub use encoding::{VtkCompression, VtkEncoding, VtkFormat, VtkWedges};
pub use mesh::{VtkMesh, read_vtk_mesh};
pub use particles::read_vtk_particles;
pub use series::{read_pvd, write_pvd};
pub use write_mesh::{write_vti, write_vtu};
pub use write_polydata::{
    write_vtp_particles, write_vtp_particles_named, write_vtp_particles_with, write_vtp_polygons, write_vtp_surface,
};
pub use xml_writer::VtkArrays;

use crate::{IoError, source};

/// Reads a VTK file, XML or legacy, gzip-compressed or not.
///
/// # Errors
/// [`IoError::System`] where the file cannot be read, [`IoError::UnknownFormat`] where it is no VTK file,
/// [`IoError::Content`] with the line or byte where the content contradicts itself or is not supported.
///
/// ```
/// use fieldstone_io::vtk::read_vtk;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("two.vtk");
/// std::fs::write(&path, "# vtk DataFile Version 4.2\ntwo points\nASCII\nDATASET POLYDATA\n\
///     POINTS 2 double\n0 0 0 1 2 3\nPOINT_DATA 2\nSCALARS radius double\nLOOKUP_TABLE default\n0.5 0.25\n")?;
/// let data = read_vtk(&path)?;
/// assert_eq!(data.points[1], [1.0, 2.0, 3.0]);
/// assert_eq!(data.summaries()[0].ranges[0], Some([0.25, 0.5]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_vtk(path: &Path) -> Result<VtkData, IoError> {
    let system = |source| IoError::System { path: path.into(), action: "read", source };
    let mut stream = source::open(path)?;
    let start = stream.fill_buf().map_err(system)?;
    let parsed = if start.starts_with(legacy_reader::MAGIC) {
        legacy_reader::read(stream)
    } else if start.iter().take(1024).any(|&b| b == b'<') {
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).map_err(system)?;
        xml_reader::read(&bytes)
    } else {
        let found = format!("the file starts with '{}'", scalar::word(start).escape_debug());
        let readable = "VTK XML (.vtu, .vtp, .vti) and VTK legacy (.vtk)".into();
        return Err(IoError::UnknownFormat { path: path.into(), found, readable });
    };
    let mut data = parsed.map_err(|fault| fault.in_file(path))?;
    data.path = path.into();
    Ok(data)
}
