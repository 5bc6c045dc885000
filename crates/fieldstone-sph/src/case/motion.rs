use std::path::Path;

use fieldstone_io::read_number_rows;
use serde::{Deserialize, Serialize};

use crate::{Motion, SphError};

/// `motion` of a `[[body]]`: a table in a file beside the case, or its rows.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(
    untagged,
    expecting = "motion is neither the name of a table's file nor rows of time and displacement, [[t, x, y], …]"
)]
pub enum MotionSection {
    /// Name of the file, from the case's folder.
    File(String),
    /// Rows of time and displacement.
    Rows(Vec<Vec<f64>>),
}

/// Time and displacement of a row; z is 0 in two dimensions.
fn split(numbers: &[f64], dimension: usize) -> Result<(f64, [f64; 3]), String> {
    match numbers {
        [time, rest @ ..] if rest.len() == dimension => {
            Ok((*time, std::array::from_fn(|k| rest.get(k).copied().unwrap_or(0.0))))
        }
        _ => Err(format!(
            "{} numbers were found; give {}: the time and a displacement along {}",
            numbers.len(),
            dimension + 1,
            if dimension == 2 { "x and y" } else { "x, y and z" }
        )),
    }
}

impl MotionSection {
    /// The motion of rows that stand in the case itself.
    pub(super) fn of_rows(rows: &[Vec<f64>], dimension: usize) -> Result<Motion, String> {
        let rows: Result<Vec<_>, String> = rows
            .iter()
            .enumerate()
            .map(|(n, row)| split(row, dimension).map_err(|e| format!("row {} of the motion: {e}", n + 1)))
            .collect();
        Motion::new(&rows?).map_err(|e| e.to_string())
    }
}

/// Reads a table of time and displacement, as [`read_number_rows`] does.
///
/// # Errors
/// [`SphError::Io`], [`SphError::Case`] with the line of the table.
pub(super) fn read_table(path: &Path, dimension: usize) -> Result<Motion, SphError> {
    let fault =
        |line: u64, message: String| SphError::Case { file: path.display().to_string(), line: line as usize, message };
    let table = read_number_rows(path)?;
    let row = |(line, numbers): &(u64, Vec<f64>)| split(numbers, dimension).map_err(|e| fault(*line, e));
    let rows = table.iter().map(row).collect::<Result<Vec<_>, SphError>>()?;
    Motion::new(&rows).map_err(|error| match error {
        SphError::Motion { row, message } => fault(table.get(row - 1).map_or(1, |(line, _)| *line), message),
        other => other,
    })
}
