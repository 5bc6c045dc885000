//! Points in Houdini's classic binary geometry format (`.bgeo`, version 5).

use std::path::Path;

use fieldstone_particles::Particles;

use crate::lines::text;
use crate::point_columns::PointColumns;
use crate::{IoError, Position, source};

/// The content with a place in it; all numbers are big-endian.
struct Bytes<'a> {
    path: &'a Path,
    content: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    fn take(&mut self, length: usize) -> Result<&'a [u8], IoError> {
        let found = self.content.get(self.at..).and_then(|rest| rest.get(..length));
        let found =
            found.ok_or_else(|| self.error("the file ends too early".into(), "the file is cut: copy it again"))?;
        self.at += length;
        Ok(found)
    }

    fn word(&mut self) -> Result<[u8; 4], IoError> {
        let mut word = [0; 4];
        word.copy_from_slice(self.take(4)?);
        Ok(word)
    }

    fn integer(&mut self) -> Result<i32, IoError> {
        Ok(i32::from_be_bytes(self.word()?))
    }

    fn short(&mut self) -> Result<usize, IoError> {
        let bytes = self.take(2)?;
        Ok(usize::from(u16::from_be_bytes([bytes[0], bytes[1]])))
    }

    fn string(&mut self) -> Result<String, IoError> {
        let length = self.short()?;
        Ok(text(self.take(length)?))
    }

    fn error(&self, found: String, remedy: &str) -> IoError {
        IoError::content(self.path, Position::Byte(self.at as u64), found, remedy)
    }
}

/// Most numbers per point.
const MOST_NUMBERS: usize = 4096;

/// What the components of an attribute are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Float,
    Integer,
    /// Indices into a list of strings, which are passed over.
    Text,
}

/// Reads the points of a `.bgeo` file as particles, compressed with gzip or not.
///
/// This is the binary format of Houdini up to version 11 (`BgeoV`, version 5), which Partio, SPlisHSPlasH and splashsurf
/// write; Houdini's later `.bgeo` is another format. Attributes of one or several numbers become quantities, `v` and
/// `velocity` the velocity, `id` the ids, and `pscale` or `radius` the radii. Texts, groups and primitives are passed over.
///
/// # Errors
/// [`IoError::Content`] for another version, an unknown kind of attribute, or where the file is cut.
pub fn read_bgeo(path: &Path) -> Result<Particles, IoError> {
    let content = source::read_all(path)?;
    let mut bytes = Bytes { path, content: &content, at: 0 };
    if bytes.take(5)? != b"BgeoV" {
        return Err(IoError::content(path, Position::File, "this is no classic .bgeo file", "it begins with BgeoV"));
    }
    let version = bytes.integer()?;
    if version != 5 {
        return Err(bytes.error(format!("the version is {version}"), "only version 5 is read"));
    }
    let mut counts = [0i32; 8];
    for count in &mut counts {
        *count = bytes.integer()?;
    }
    let [points, _, _, _, attributes, _, _, _] = counts;
    let Some((points, attributes)) = u32::try_from(points).ok().zip(u32::try_from(attributes).ok()) else {
        return Err(bytes.error("the header has a negative number of points".into(), "the file is damaged"));
    };
    let mut names: Vec<String> = ["x", "y", "z"].map(String::from).to_vec();
    let mut kinds = vec![Kind::Float; 3];
    for _ in 0..attributes {
        let name = bytes.string()?;
        let size = bytes.short()?;
        let code = bytes.integer()?;
        // A damaged size must not make columns by the million: an attribute of text takes none in the header.
        if kinds.len() + size > MOST_NUMBERS {
            let found = format!("the attributes up to '{name}' have {} numbers per point", kinds.len() + size);
            return Err(bytes.error(found, "at most 4096 are read; the file may be damaged"));
        }
        let kind = match code {
            0 | 5 => Kind::Float,
            1 => Kind::Integer,
            4 => Kind::Text,
            _ => {
                let found = format!("attribute '{name}' is of kind {code}");
                return Err(bytes.error(found, "numbers (0, 1, 5) and indexed texts (4) are read"));
            }
        };
        if kind == Kind::Text {
            for _ in 0..bytes.integer()? {
                bytes.string()?;
            }
        } else {
            // Default values.
            bytes.take(4 * size)?;
        }
        let base = match name.as_str() {
            "pscale" if size == 1 => "radius",
            other => other,
        };
        kinds.extend(std::iter::repeat_n(kind, size));
        match size {
            1 => names.push(base.into()),
            _ => names.extend((0..size).map(|k| format!("{base}:{k}"))),
        }
    }
    // Texts are indices that mean nothing without their list.
    let kept: Vec<Option<usize>> = kinds
        .iter()
        .scan(0, |next, &kind| {
            let column = (kind != Kind::Text).then_some(*next);
            *next += usize::from(column.is_some());
            Some(column)
        })
        .collect();
    let kept_names = names.into_iter().zip(&kept).filter(|(_, column)| column.is_some()).map(|(name, _)| name);
    let mut columns = PointColumns::new(path, kept_names.collect(), points as usize)?;
    for _ in 0..points {
        let start = Position::Byte(bytes.at as u64);
        for (index, (kind, column)) in kinds.iter().zip(&kept).enumerate() {
            if index == 3 {
                // The homogeneous coordinate.
                bytes.word()?;
            }
            let word = bytes.word()?;
            let value = match kind {
                Kind::Float => f64::from(f32::from_be_bytes(word)),
                Kind::Integer | Kind::Text => f64::from(i32::from_be_bytes(word)),
            };
            if let Some(column) = column {
                columns.row()[*column] = value;
            }
        }
        if kinds.len() == 3 {
            bytes.word()?;
        }
        columns.push(start)?;
    }
    columns.finish()
}
