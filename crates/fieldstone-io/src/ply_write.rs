//! Writes surfaces of triangles as PLY.

use std::path::Path;

use crate::surface_check::check;
use crate::{AtomicFile, DataArray, IoError};

/// Writes a surface as binary PLY: corners, their normals where given, and columns on corners as properties.
///
/// Properties are doubles; a column of several numbers gets `name_0`, `name_1`, …
///
/// # Errors
/// [`IoError::Content`] where a triangle names a point that does not exist or a column has not one row per point;
/// [`IoError::System`].
///
/// ```
/// use fieldstone_io::write_ply;
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("triangle.ply");
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// write_ply(&path, &points, &[[0, 1, 2]], &[], &[])?;
/// let bytes = std::fs::read(&path)?;
/// // After the header three corners of 24 bytes and a triangle of 13.
/// assert!(bytes[..bytes.len() - 85].ends_with(b"property list uchar uint vertex_indices\nend_header\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_ply(
    path: &Path,
    points: &[[f64; 3]],
    triangles: &[[u32; 3]],
    normals: &[[f64; 3]],
    columns: &[DataArray],
) -> Result<(), IoError> {
    check(path, points, triangles, normals, columns)?;
    let columns: Vec<(&DataArray, Vec<f64>)> = columns.iter().map(|c| (c, c.values.to_f64())).collect();
    let mut header = format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", points.len());
    let mut names: Vec<String> = ["x", "y", "z"].map(String::from).to_vec();
    if !normals.is_empty() {
        names.extend(["nx", "ny", "nz"].map(String::from));
    }
    for (column, _) in &columns {
        // Blanks separate words in the header.
        let name = column.name.replace(char::is_whitespace, "_");
        match column.components {
            1 => names.push(name),
            n => names.extend((0..n).map(|k| format!("{name}_{k}"))),
        }
    }
    names.iter().for_each(|name| header += &format!("property double {name}\n"));
    header += &format!("element face {}\nproperty list uchar uint vertex_indices\nend_header\n", triangles.len());
    AtomicFile::write(path, |out| {
        out.write_all(header.as_bytes())?;
        let mut row = Vec::new();
        for (index, point) in points.iter().enumerate() {
            row.clear();
            let mut push = |x: &f64| row.extend_from_slice(&x.to_le_bytes());
            point.iter().for_each(&mut push);
            normals.get(index).into_iter().flatten().for_each(&mut push);
            for (column, data) in &columns {
                data[index * column.components..(index + 1) * column.components].iter().for_each(&mut push);
            }
            out.write_all(&row)?;
        }
        for triangle in triangles {
            row.clear();
            row.push(3);
            triangle.iter().for_each(|p| row.extend_from_slice(&p.to_le_bytes()));
            out.write_all(&row)?;
        }
        Ok(())
    })
}
