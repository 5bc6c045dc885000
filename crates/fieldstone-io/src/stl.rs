//! Reads surfaces of triangles from STL.

use std::collections::HashMap;
use std::path::Path;

use crate::lines::{number, shown, words};
use crate::{IoError, Position, source};

/// Bytes before the triangles of a binary file, and of each triangle.
const HEAD: usize = 84;
const RECORD: usize = 50;

/// Points and triangles of a surface.
type Surface = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// Reads a surface from an STL file: ASCII or binary, compressed with gzip or not.
///
/// Corners at exactly the same place become one point; their order within a triangle is kept, the normals of the file
/// are not read. Several solids in one text file make one surface.
///
/// # Errors
/// [`IoError::Content`] with line or byte: no STL, cut, a corner that is not three finite numbers, a triangle that has
/// not three corners; [`IoError::System`].
///
/// ```
/// use fieldstone_io::{read_stl, write_stl};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("two.stl");
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 2.0]];
/// write_stl(&path, &points, &[[0, 1, 2], [0, 2, 3]])?;
/// let (found, triangles) = read_stl(&path)?;
/// assert_eq!((found.as_slice(), triangles), (&points[..], vec![[0, 1, 2], [0, 2, 3]]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_stl(path: &Path) -> Result<Surface, IoError> {
    let content = source::read_all(path)?;
    let stated = content.get(HEAD - 4..HEAD).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let expected = stated.map(|n| HEAD as u64 + RECORD as u64 * u64::from(n));
    // Binary files may begin with "solid", too; their length tells.
    if expected == Some(content.len() as u64) {
        return read_binary(path, &content);
    }
    if words(&content).next().is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) {
        return read_text(path, &content);
    }
    let found = match (stated, expected) {
        (Some(stated), Some(expected)) => {
            format!("{stated} triangles would take {expected} bytes, but the file has {}", content.len())
        }
        _ => "the file does not begin with 'solid' and is too short to be binary".into(),
    };
    Err(IoError::content(path, Position::File, found, "give a whole STL file: copy it again, or write it again"))
}

/// Numbers the places of corners.
#[derive(Default)]
struct Corners {
    points: Vec<[f64; 3]>,
    numbers: HashMap<[u64; 3], u32>,
}

impl Corners {
    fn number(&mut self, corner: [f64; 3]) -> Option<u32> {
        // −0 and 0 are one place.
        let corner = corner.map(|x| x + 0.0);
        let next = u32::try_from(self.points.len()).ok()?;
        Some(*self.numbers.entry(corner.map(f64::to_bits)).or_insert_with(|| {
            self.points.push(corner);
            next
        }))
    }
}

fn refused(path: &Path, position: Position, found: impl Into<String>) -> IoError {
    IoError::content(path, position, found, "correct the triangle, or write the file again")
}

fn numbered(
    path: &Path,
    position: Position,
    corners: &mut Corners,
    triangle: &[[f64; 3]],
) -> Result<[u32; 3], IoError> {
    let &[a, b, c] = triangle else {
        return Err(refused(path, position, format!("a triangle has {} corners; it must have 3", triangle.len())));
    };
    let mut numbers = [0; 3];
    for (number, corner) in numbers.iter_mut().zip([a, b, c]) {
        if let Some(bad) = corner.iter().find(|x| !x.is_finite()) {
            return Err(refused(path, position, format!("a corner has the coordinate {bad}; it must be finite")));
        }
        *number = corners
            .number(corner)
            .ok_or_else(|| refused(path, position, "there are more than 2³² corners, more than can be numbered"))?;
    }
    Ok(numbers)
}

fn read_binary(path: &Path, content: &[u8]) -> Result<Surface, IoError> {
    let mut corners = Corners::default();
    let mut triangles = Vec::with_capacity((content.len() - HEAD) / RECORD);
    for (index, record) in content[HEAD..].chunks_exact(RECORD).enumerate() {
        let position = Position::Byte((HEAD + RECORD * index) as u64);
        let number =
            |at: usize| f64::from(f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]));
        // After the normal.
        let triangle: [[f64; 3]; 3] = std::array::from_fn(|c| std::array::from_fn(|k| number(12 + 12 * c + 4 * k)));
        triangles.push(numbered(path, position, &mut corners, &triangle)?);
    }
    Ok((corners.points, triangles))
}

fn read_text(path: &Path, content: &[u8]) -> Result<Surface, IoError> {
    let mut corners = Corners::default();
    let (mut triangles, mut triangle) = (Vec::new(), Vec::new());
    let mut ended = false;
    for (index, line) in content.split(|&b| b == b'\n').enumerate() {
        let position = Position::Line(index as u64 + 1);
        let mut words = words(line);
        let Some(word) = words.next() else { continue };
        ended = false;
        match word.to_ascii_lowercase().as_slice() {
            b"vertex" => {
                let mut corner = [0.0; 3];
                for x in &mut corner {
                    let word = words.next().unwrap_or_default();
                    *x = number(word)
                        .ok_or_else(|| refused(path, position, format!("'{}' is no coordinate", shown(word))))?;
                }
                triangle.push(corner);
            }
            b"endloop" => {
                triangles.push(numbered(path, position, &mut corners, &triangle)?);
                triangle.clear();
            }
            b"endsolid" => ended = true,
            b"solid" | b"facet" | b"outer" | b"endfacet" => {}
            other => {
                return Err(refused(path, position, format!("'{}' is no word of an STL file", shown(other))));
            }
        }
    }
    if !ended || !triangle.is_empty() {
        let found = "the file ends without 'endsolid'";
        return Err(IoError::content(path, Position::File, found, "the file is cut: copy it again, or write it again"));
    }
    Ok((corners.points, triangles))
}
