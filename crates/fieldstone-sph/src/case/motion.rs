use std::path::Path;

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

/// Reads a table of time and displacement: numbers between commas, semicolons or blanks, `#` before comments, and at
/// most one line of names before the first row.
///
/// # Errors
/// [`SphError::Case`] with the line of the table.
pub(super) fn read_table(path: &Path, dimension: usize) -> Result<Motion, SphError> {
    let file = path.display().to_string();
    let fault = |line: usize, message: String| SphError::Case { file: file.clone(), line, message };
    let text = std::fs::read_to_string(path)
        .map_err(|e| fault(1, format!("cannot be read: {e}; the name counts from the folder of the case")))?;
    let (mut rows, mut lines) = (Vec::new(), Vec::new());
    let mut named = false;
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let words: Vec<&str> =
            line.split(|c: char| matches!(c, ',' | ';') || c.is_whitespace()).filter(|w| !w.is_empty()).collect();
        if rows.is_empty() && !named && words.iter().all(|word| word.parse::<f64>().is_err()) {
            named = true;
            continue;
        }
        let number = |word: &&str| {
            word.parse::<f64>()
                .map_err(|_| fault(index + 1, format!("'{word}' is no number; give time and displacement")))
        };
        let numbers = words.iter().map(number).collect::<Result<Vec<f64>, SphError>>()?;
        rows.push(split(&numbers, dimension).map_err(|e| fault(index + 1, e))?);
        lines.push(index + 1);
    }
    Motion::new(&rows).map_err(|error| match error {
        SphError::Motion { row, message } => fault(lines.get(row - 1).copied().unwrap_or(1), message),
        other => other,
    })
}
