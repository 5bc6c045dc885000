//! Tables of nothing but numbers.

use std::path::Path;

use crate::IoError;
use crate::lines::{LineReader, number, shown};

/// Rows of numbers with their lines in the file, compressed or not.
///
/// Between numbers stand commas, semicolons or blanks, `#` begins a comment, and before the first row there is at most one line of
/// names. Rows may differ in length.
///
/// # Errors
/// [`IoError::System`]; [`IoError::Content`] with the line where a word is no number.
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("gate.csv");
/// std::fs::write(&path, "t; x\n# at rest\n0; 0\n1.5; 0.25 # and stops\n")?;
/// assert_eq!(fieldstone_io::read_number_rows(&path)?, [(3, vec![0.0, 0.0]), (4, vec![1.5, 0.25])]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_number_rows(path: &Path) -> Result<Vec<(u64, Vec<f64>)>, IoError> {
    let mut lines = LineReader::open(path)?;
    let mut rows = Vec::new();
    let mut named = false;
    while lines.advance()? {
        let line = lines.line().split(|&b| b == b'#').next().unwrap_or_default();
        let is_between = |b: &u8| matches!(b, b',' | b';') || b.is_ascii_whitespace();
        let words = || line.split(is_between).filter(|word| !word.is_empty());
        if words().next().is_none() {
            continue;
        }
        if rows.is_empty() && !named && words().all(|word| number(word).is_none()) {
            named = true;
            continue;
        }
        let of_word = |word: &[u8]| {
            number(word).ok_or_else(|| {
                let remedy = "give rows of numbers, after one line of names at most; decimal commas are not read";
                lines.error(format!("'{}' is no number", shown(word)), remedy)
            })
        };
        rows.push((lines.number(), words().map(of_word).collect::<Result<_, _>>()?));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn byte_order_marks_line_ends_and_gzip_change_no_number() {
        let folder = tempfile::tempdir().unwrap();
        let plain = b"0 1\n2 3\n".to_vec();
        let marked = b"\xef\xbb\xbf0, 1\r\n2, 3\r\n".to_vec();
        let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        gzip.write_all(&marked).unwrap();
        for (name, content) in [("plain", plain), ("marked", marked), ("gzip", gzip.finish().unwrap())] {
            let path = folder.path().join(name);
            std::fs::write(&path, content).unwrap();
            assert_eq!(read_number_rows(&path).unwrap(), [(1, vec![0.0, 1.0]), (2, vec![2.0, 3.0])], "{name}");
        }
    }
}
