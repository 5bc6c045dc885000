//! Writes surfaces of triangles as STL.

use std::path::Path;

use crate::surface_check::check;
use crate::{AtomicFile, IoError, Position};

/// Writes a surface as binary STL: each triangle with its own corners, in 32-bit floats.
///
/// Corners closer than the seven digits of these floats become one, so small triangles far from the origin may collapse:
/// move the surface to the origin, or use another format.
///
/// # Errors
/// [`IoError::Content`] where a triangle names a point that does not exist, or there are 2³² or more; [`IoError::System`].
///
/// ```
/// use fieldstone_io::write_stl;
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("triangle.stl");
/// write_stl(&path, &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0]], &[[0, 1, 2]])?;
/// assert_eq!(std::fs::metadata(&path)?.len(), 84 + 50);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_stl(path: &Path, points: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<(), IoError> {
    check(path, points, triangles, &[], &[])?;
    let Ok(count) = u32::try_from(triangles.len()) else {
        let found = format!("{} triangles are more than the format can count", triangles.len());
        return Err(IoError::content(path, Position::File, found, "write .ply or .vtp; nothing was written"));
    };
    AtomicFile::write(path, |out| {
        // A header that begins with "solid" would look like the text variant.
        let mut header = [b' '; 80];
        header[..10].copy_from_slice(b"fieldstone");
        out.write_all(&header)?;
        out.write_all(&count.to_le_bytes())?;
        let mut record = [0u8; 50];
        for triangle in triangles {
            let [a, b, c] = triangle.map(|p| points[p as usize]);
            let [u, v]: [[f64; 3]; 2] = [b, c].map(|p| std::array::from_fn(|k| p[k] - a[k]));
            let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
            let normal = normal.map(|n| if length > 0.0 { n / length } else { 0.0 });
            for (bytes, x) in record.chunks_exact_mut(4).zip([normal, a, b, c].as_flattened()) {
                bytes.copy_from_slice(&(*x as f32).to_le_bytes());
            }
            out.write_all(&record)?;
        }
        Ok(())
    })
}
