//! Writes surfaces of triangles as Wavefront OBJ.

use std::path::Path;

use crate::surface_check::check;
use crate::{AtomicFile, IoError};

/// Writes a surface as OBJ, with normals where given; the format has no place for other columns.
///
/// Coordinates get the fewest digits that read back to the same bits.
///
/// # Errors
/// [`IoError::Content`] where a triangle names a point that does not exist; [`IoError::System`].
///
/// ```
/// use fieldstone_io::write_obj;
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("triangle.obj");
/// write_obj(&path, &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0]], &[[0, 1, 2]], &[])?;
/// assert_eq!(std::fs::read_to_string(&path)?, "v 0 0 0\nv 1 0 0\nv 0 0.5 0\nf 1 2 3\n");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_obj(
    path: &Path,
    points: &[[f64; 3]],
    triangles: &[[u32; 3]],
    normals: &[[f64; 3]],
) -> Result<(), IoError> {
    check(path, points, triangles, normals, &[])?;
    AtomicFile::write(path, |out| {
        points.iter().try_for_each(|[x, y, z]| writeln!(out, "v {x} {y} {z}"))?;
        normals.iter().try_for_each(|[x, y, z]| writeln!(out, "vn {x} {y} {z}"))?;
        for triangle in triangles {
            // Corners count from 1.
            let [a, b, c] = triangle.map(|p| u64::from(p) + 1);
            match normals {
                [] => writeln!(out, "f {a} {b} {c}")?,
                _ => writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?,
            }
        }
        Ok(())
    })
}
