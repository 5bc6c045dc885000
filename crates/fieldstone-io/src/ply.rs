//! Point clouds in the Stanford PLY format.

use std::path::Path;

use fieldstone_particles::Particles;

use crate::lines::{integer, number, shown, text, words};
use crate::point_columns::PointColumns;
use crate::{IoError, Position, source};

/// How numbers are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

/// Type of a number, by its width.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn of(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    fn width(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number in `bytes`, of which there are as many as the width.
    fn value(self, bytes: &[u8], encoding: Encoding) -> f64 {
        let mut all = [0; 8];
        for (slot, &byte) in all.iter_mut().zip(bytes) {
            *slot = byte;
        }
        if encoding == Encoding::Big {
            all[..self.width()].reverse();
        }
        let [a, b, c, d, ..] = all;
        match self {
            Self::I8 => f64::from(a as i8),
            Self::U8 => f64::from(a),
            Self::I16 => f64::from(i16::from_le_bytes([a, b])),
            Self::U16 => f64::from(u16::from_le_bytes([a, b])),
            Self::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Self::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::F64 => f64::from_le_bytes(all),
        }
    }
}

#[derive(Debug, Clone)]
struct Element {
    name: String,
    count: u64,
    properties: Vec<(String, Kind)>,
    /// Whether some property is a list.
    lists: bool,
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    /// Where the numbers begin, and the line there.
    end: usize,
    lines: u64,
}

/// Reads the vertices of a `.ply` file as particles: ASCII, binary of either byte order, compressed with gzip or not.
///
/// Scalar properties are named as in tables ([`crate::CsvReader`]): `x y z` positions, `radius` radii, `vx vy vz`
/// velocity, any other a quantity.
///
/// # Errors
/// [`IoError::Content`] for a file with faces, which is a surface; for list properties on vertices; where the file is
/// cut.
///
/// ```
/// use fieldstone_io::read_ply;
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("one.ply");
/// std::fs::write(&path, "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
///     property float density\nend_header\n1 2 3 998.5\n")?;
/// let one = read_ply(&path)?;
/// assert_eq!((one.positions()[0], one.quantity("density")?.data[0]), ([1.0, 2.0, 3.0], 998.5));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_ply(path: &Path) -> Result<Particles, IoError> {
    let content = source::read_all(path)?;
    let header = read_header(path, &content)?;
    let refused = |found: String, remedy: &str| Err(IoError::content(path, Position::File, found, remedy));
    if header.elements.iter().any(|e| ["face", "tristrips"].contains(&e.name.as_str()) && e.count > 0) {
        return refused("the file holds a surface of faces, not particles".into(), "give a point cloud");
    }
    let Some(index) = header.elements.iter().position(|element| element.name == "vertex") else {
        return refused("the file has no element 'vertex'".into(), "give a point cloud");
    };
    let vertices = &header.elements[index];
    if let Some(element) = header.elements[..=index].iter().find(|element| element.lists) {
        return refused(format!("element '{}' has a list property", element.name), "give points with scalars only");
    }
    let names = vertices.properties.iter().map(|(name, _)| name.clone()).collect();
    let mut columns = PointColumns::new(path, names, usize::try_from(vertices.count).unwrap_or(usize::MAX))?;
    let before = &header.elements[..index];
    match header.encoding {
        Encoding::Ascii => read_text(path, &content, &header, before, vertices, &mut columns)?,
        encoding => {
            let width = |element: &Element| element.properties.iter().map(|(_, kind)| kind.width() as u64).sum::<u64>();
            let skipped = before.iter().fold(0u64, |sum, e| sum.saturating_add(e.count.saturating_mul(width(e))));
            let mut at = header.end.saturating_add(usize::try_from(skipped).unwrap_or(usize::MAX));
            for index in 0..vertices.count {
                let record = at;
                for (column, (_, kind)) in vertices.properties.iter().enumerate() {
                    let Some(bytes) = content.get(at..at.saturating_add(kind.width())) else {
                        return Err(truncated(path, Position::Byte(content.len() as u64), index, vertices.count));
                    };
                    columns.row()[column] = kind.value(bytes, encoding);
                    at += kind.width();
                }
                columns.push(Position::Byte(record as u64))?;
            }
        }
    }
    columns.finish()
}

fn truncated(path: &Path, position: Position, index: u64, count: u64) -> IoError {
    let found = format!("the file ends after {index} of the {count} vertices");
    IoError::content(path, position, found, "the file is cut: copy it again, or write it again")
}

fn read_text(
    path: &Path,
    content: &[u8],
    header: &Header,
    before: &[Element],
    vertices: &Element,
    columns: &mut PointColumns,
) -> Result<(), IoError> {
    // Elements without properties have blank rows, if any.
    let rows_of = |element: &Element| if element.properties.is_empty() { 0 } else { element.count };
    let skipped = before.iter().fold(0u64, |sum, element| sum.saturating_add(rows_of(element)));
    let lines = content[header.end..].split(|&b| b == b'\n').zip(header.lines + 1..);
    let mut rows = lines.filter(|(line, _)| !line.trim_ascii().is_empty());
    for _ in 0..skipped {
        if rows.next().is_none() {
            return Err(truncated(path, Position::File, 0, vertices.count));
        }
    }
    for index in 0..vertices.count {
        let Some((line, at)) = rows.next() else {
            return Err(truncated(path, Position::File, index, vertices.count));
        };
        let wrong = |found: String| {
            IoError::content(path, Position::Line(at), found, "correct the row, or write the file again")
        };
        let mut found = 0;
        for word in words(line) {
            if let Some(slot) = columns.row().get_mut(found) {
                *slot = number(word).ok_or_else(|| wrong(format!("'{}' is no number", shown(word))))?;
            }
            found += 1;
        }
        if found != vertices.properties.len() {
            return Err(wrong(format!("the row has {found} numbers; {} are expected", vertices.properties.len())));
        }
        columns.push(Position::Line(at))?;
    }
    Ok(())
}

fn read_header(path: &Path, content: &[u8]) -> Result<Header, IoError> {
    let mut header = Header { encoding: Encoding::Ascii, elements: Vec::new(), end: 0, lines: 0 };
    let mut encoding = None;
    loop {
        let rest = &content[header.end..];
        let wrong = |found: &str| {
            let position = Position::Line(header.lines + 1);
            IoError::content(path, position, found, "this is no PLY file, or its header is damaged")
        };
        let Some(length) = rest.iter().take(1 << 12).position(|&b| b == b'\n') else {
            return Err(wrong("the header has no end_header"));
        };
        let line = rest[..length].trim_ascii();
        let parts: Vec<&[u8]> = words(line).collect();
        match parts.as_slice() {
            [b"ply"] if header.lines == 0 => {}
            _ if header.lines == 0 => return Err(wrong("the first line is not 'ply'")),
            [b"format", b"ascii", ..] => encoding = Some(Encoding::Ascii),
            [b"format", b"binary_little_endian", ..] => encoding = Some(Encoding::Little),
            [b"format", b"binary_big_endian", ..] => encoding = Some(Encoding::Big),
            [b"comment" | b"obj_info", ..] | [] => {}
            [b"element", name, count] => {
                let count = integer(count).and_then(|count| u64::try_from(count).ok());
                let count = count.ok_or_else(|| wrong("an element's number is not a whole number"))?;
                header.elements.push(Element { name: text(name), count, properties: Vec::new(), lists: false });
            }
            [b"property", b"list", ..] => match header.elements.last_mut() {
                Some(element) => element.lists = true,
                None => return Err(wrong("a property stands before any element")),
            },
            [b"property", kind, name] => match (Kind::of(kind), header.elements.last_mut()) {
                (Some(kind), Some(element)) => element.properties.push((text(name), kind)),
                (None, _) => return Err(wrong("a property has an unknown type")),
                (_, None) => return Err(wrong("a property stands before any element")),
            },
            [b"end_header"] => {
                header.encoding = encoding.ok_or_else(|| wrong("the header does not state its format"))?;
                header.end += length + 1;
                header.lines += 1;
                return Ok(header);
            }
            _ => return Err(wrong(&format!("'{}' is not known in headers", shown(line)))),
        }
        header.end += length + 1;
        header.lines += 1;
    }
}
