//! What every writer of surfaces refuses.

use std::path::Path;

use crate::{DataArray, IoError, Position};

pub(crate) fn check(
    path: &Path,
    points: &[[f64; 3]],
    triangles: &[[u32; 3]],
    normals: &[[f64; 3]],
    columns: &[DataArray],
) -> Result<(), IoError> {
    let count = points.len();
    let refused = |found: String, remedy: &str| Err(IoError::content(path, Position::File, found, remedy));
    if let Some(bad) = triangles.iter().position(|t| t.iter().any(|&p| p as usize >= count)) {
        let found = format!("triangle {bad} names points {:?}, but there are {count}", triangles[bad]);
        return refused(found, "give all points; nothing was written");
    }
    if !normals.is_empty() && normals.len() != count {
        let found = format!("there are {} normals for {count} points", normals.len());
        return refused(found, "give one for each point, or none; nothing was written");
    }
    if let Some(bad) = columns.iter().find(|c| c.components == 0 || c.values.len() != count * c.components) {
        let found = format!("column '{}' has {} numbers for {count} points", bad.name, bad.values.len());
        return refused(found, "give one row for each point; nothing was written");
    }
    Ok(())
}
