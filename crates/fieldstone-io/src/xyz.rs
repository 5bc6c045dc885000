//! XYZ files, plain and extended.

use std::path::Path;

use fieldstone_particles::{Domain, Particles};

use crate::assembly::{Assembly, Row};
use crate::column_names::Dialect;
use crate::columns::Columns;
use crate::frames::unless_failed;
use crate::lines::{LineReader, integer, number, shown, skip_blanks, text, words};
use crate::{FrameReader, IoError};

/// Reads the particles of an XYZ file, frame by frame, compressed or not.
///
/// A frame is a line with the number of particles, a line of comment, and rows `name x y z`, or `name x y z
/// radius`. Names that are integers are types; others are passed over, with a warning. Where the comment says `Properties=species:S:1:pos:R:3:…`, it
/// decides on the columns; `Lattice="…"`, `Origin="…"` and `pbc="…"` then give the box, orthogonal or
/// triclinic with its first vector along x and its second in the plane of x and y, `Time=` the time.
///
/// ```
/// use fieldstone_io::{FrameReader, XyzReader};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("two.xyz");
/// std::fs::write(&path, "2\nLattice=\"4 0 0 0 4 0 0 0 4\" Properties=species:S:1:pos:R:3:radius:R:1\n\
///     A 0 0 1 0.5\nA 1 0 1 0.25\n")?;
/// let particles = XyzReader::open(&path)?.next_frame()?.expect("one frame");
/// assert_eq!(particles.radii()?, [0.5, 0.25]);
/// assert_eq!(particles.domain().map(|d| d.high()), Some([4.0; 3]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct XyzReader {
    lines: LineReader,
    frame: usize,
    warnings: Vec<String>,
    failed: bool,
}

impl XyzReader {
    /// Opens an XYZ file.
    ///
    /// # Errors
    /// [`IoError::System`] where the file cannot be opened.
    pub fn open(path: &Path) -> Result<Self, IoError> {
        Ok(Self { lines: LineReader::open(path)?, frame: 0, warnings: Vec::new(), failed: false })
    }

    fn warn(&mut self, warning: String) {
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// Number of particles; afterwards the comment is the current line.
    fn head(&mut self) -> Result<Option<u64>, IoError> {
        loop {
            if !self.lines.advance()? {
                return Ok(None);
            }
            if skip_blanks(self.lines.line(), 0) < self.lines.line().len() {
                break;
            }
        }
        let line = self.lines.line().trim_ascii();
        let Some(count) = integer(line).and_then(|count| u64::try_from(count).ok()) else {
            let found =
                format!("'{}' stands where frame {}'s number of particles is expected", shown(line), self.frame);
            return Err(self.lines.error(found, "the frame before has more rows than its number says"));
        };
        if !self.lines.advance()? {
            return Err(self.lines.error("the file ends before the comment line", "the file is cut"));
        }
        Ok(Some(count))
    }

    fn truncated(&self, index: u64, count: u64) -> IoError {
        let found = format!("the file ends after {index} of the {count} particles of frame {}", self.frame);
        self.lines.error(found, "the file is cut, or still being written; earlier frames can be read")
    }

    /// The box of an extended header, where its vectors are a lower triangle.
    fn domain(&mut self, comment: &str) -> Option<Domain> {
        let numbers = |key| -> Option<Vec<f64>> {
            value(comment, key)?.split_ascii_whitespace().map(|word| number(word.as_bytes())).collect()
        };
        let Some(&[ax, ay, az, bx, by, bz, cx, cy, cz]) = numbers("Lattice").as_deref() else { return None };
        let origin = match numbers("Origin").as_deref() {
            Some(&[x, y, z]) => [x, y, z],
            _ => [0.0; 3],
        };
        // A lattice without the word is periodic by convention.
        let periodic = match value(comment, "pbc").map(|v| v.split_ascii_whitespace().collect::<Vec<_>>()).as_deref() {
            Some(&[x, y, z]) => [x, y, z].map(|flag| flag.starts_with(['T', 't', '1'])),
            _ => [true; 3],
        };
        if [ay, az, bz] == [0.0; 3]
            && let Ok(domain) = Domain::triclinic(origin, [ax, by, cz], [bx, cx, cy], periodic)
        {
            return Some(domain);
        }
        self.warn(
            "the lattice's first vector is not along x or its second not in the plane of x and y: read without a box"
                .into(),
        );
        None
    }

    fn read_frame(&mut self) -> Result<Option<Particles>, IoError> {
        let Some(count) = self.head()? else { return Ok(None) };
        let comment = text(self.lines.line());
        let domain = self.domain(&comment);
        let time = value(&comment, "Time").and_then(|time| number(time.as_bytes()));
        let step = comment.split_once("Timestep:").and_then(|(_, rest)| integer(words(rest.as_bytes()).next()?));
        let properties = match value(&comment, "Properties") {
            Some(properties) => Some(property_names(properties).ok_or_else(|| {
                let found = format!("Properties '{}' is no list of name:kind:count", shown(properties.as_bytes()));
                self.lines.error(found, "as in Properties=species:S:1:pos:R:3:radius:R:1")
            })?),
            None => None,
        };
        let mut layout: Option<(Columns, Assembly)> = None;
        let mut row = Row::default();
        for index in 0..count {
            if !self.lines.advance()? {
                return Err(self.truncated(index, count));
            }
            if layout.is_none() {
                layout = Some(self.layout(properties.as_deref(), count)?);
            }
            let Some((columns, assembly)) = &mut layout else { continue };
            let result =
                columns.read_words(self.lines.line(), &mut row).and_then(|()| assembly.push(columns, &row, |p| p));
            if let Err(fault) = result {
                if !self.lines.complete() {
                    return Err(self.truncated(index, count));
                }
                let (found, remedy) = fault.describe(columns);
                return Err(self.lines.error(found, remedy));
            }
        }
        self.frame += 1;
        let particles = match layout {
            Some((columns, assembly)) => assembly.finish(&columns),
            None => Particles::new(Vec::new()),
        };
        let particles =
            particles.map_err(|source| IoError::Particles { path: self.lines.path().into(), source })?.at(step, time);
        Ok(Some(match domain {
            Some(domain) => particles.with_domain(domain),
            None => particles,
        }))
    }

    /// The columns' meaning, from the comment's list or from the first row.
    fn layout(&mut self, properties: Option<&[String]>, count: u64) -> Result<(Columns, Assembly), IoError> {
        let first: Vec<Vec<u8>> = words(self.lines.line()).map(<[u8]>::to_vec).collect();
        let names = match (properties, first.len()) {
            (Some(names), _) => names.to_vec(),
            (None, 4 | 5) => {
                let label = if integer(&first[0]).is_some() { "type" } else { "species" };
                [label, "x", "y", "z", "radius"][..first.len()].iter().map(ToString::to_string).collect()
            }
            (None, found) => {
                if !self.lines.complete() {
                    return Err(self.truncated(0, count));
                }
                let found = format!("the row has {found} columns; 'name x y z' or 'name x y z radius' is expected");
                return Err(self.lines.error(found, "name other columns by Properties= in the comment line"));
            }
        };
        let mut columns = Columns::new(names, Dialect::Table)
            .map_err(|missing| self.lines.error(missing, "Properties needs pos:R:3"))?;
        for name in columns.pass_over_text(first.iter().map(Vec::as_slice)) {
            let label = ["species", "type", "element"].iter().any(|label| name.eq_ignore_ascii_case(label));
            let remedy =
                if label { ": types are numbers; to tell species apart, write numbers in place of names" } else { "" };
            self.warn(format!("column '{name}' holds text and is passed over{remedy}"));
        }
        let assembly = Assembly::new(&columns, usize::try_from(count).unwrap_or(usize::MAX));
        Ok((columns, assembly))
    }

    fn pass_frame(&mut self) -> Result<bool, IoError> {
        let Some(count) = self.head()? else { return Ok(false) };
        for index in 0..count {
            if !self.lines.advance()? {
                return Err(self.truncated(index, count));
            }
        }
        self.frame += 1;
        Ok(true)
    }
}

/// The value of `key=value` or `key="several words"` in a comment, whatever the letter case of the key.
fn value<'a>(comment: &'a str, key: &str) -> Option<&'a str> {
    let mut rest = comment;
    while let Some(at) = rest.find('=') {
        let name = rest[..at].trim_end().rsplit(|c: char| c.is_whitespace() || c == '"').next().unwrap_or_default();
        let after = rest[at + 1..].trim_start();
        let (found, next) = match after.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"').unwrap_or((quoted, "")),
            None => after.split_once(char::is_whitespace).unwrap_or((after, "")),
        };
        if name.eq_ignore_ascii_case(key) {
            return Some(found);
        }
        rest = next;
    }
    None
}

/// Names of the columns that a list `name:kind:count:…` describes.
fn property_names(list: &str) -> Option<Vec<String>> {
    let parts: Vec<&str> = list.split(':').collect();
    let mut names = Vec::new();
    for property in parts.chunks(3) {
        let &[name, kind, count] = property else { return None };
        let count: usize = count.parse().ok()?;
        if !["S", "R", "I", "L"].contains(&kind) || !(1..=1000).contains(&count) {
            return None;
        }
        let vector = match (name.to_ascii_lowercase().as_str(), count) {
            ("pos" | "position", 3) => Some(["x", "y", "z"]),
            ("velo" | "vel" | "velocity" | "velocities", 3) => Some(["vx", "vy", "vz"]),
            ("force" | "forces", 3) => Some(["fx", "fy", "fz"]),
            _ => None,
        };
        match vector {
            Some(vector) => names.extend(vector.map(String::from)),
            None if count == 1 => names.push(name.into()),
            None => names.extend((0..count).map(|k| format!("{name}:{k}"))),
        }
    }
    Some(names)
}

impl FrameReader for XyzReader {
    fn next_frame(&mut self) -> Result<Option<Particles>, IoError> {
        unless_failed(self, |reader| &mut reader.failed, Self::read_frame)
    }

    fn skip_frame(&mut self) -> Result<bool, IoError> {
        unless_failed(self, |reader| &mut reader.failed, Self::pass_frame)
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_beside_quoted_values_that_hold_an_equals_sign() {
        let comment = r#"note="a=b c" Lattice = "1 0 0" Time=2.5"#;
        assert_eq!(value(comment, "time"), Some("2.5"));
        assert_eq!(value(comment, "Lattice"), Some("1 0 0"));
        assert_eq!(value(comment, "b"), None);
    }

    #[test]
    fn a_property_list_that_would_make_millions_of_columns_is_refused() {
        assert_eq!(property_names("pos:R:3:x:R:99999999"), None);
        assert_eq!(property_names("pos:R"), None);
    }
}
