//! Tables of numbers as text: CSV with its usual dialects, `# x y z` files, YADE's text export.

use std::path::Path;

use fieldstone_particles::Particles;

use crate::assembly::{Assembly, Row};
use crate::column_names::Dialect;
use crate::columns::{Columns, non_spherical};
use crate::lines::{LineReader, number, shown, skip_blanks, words};
use crate::units::{self, Unit};
use crate::{FrameReader, IoError, ParticleOptions, Position};

/// What stands between the fields of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Separator {
    /// `,`
    Comma,
    /// `;`
    Semicolon,
    /// One tab.
    Tab,
    /// Any number of blanks and tabs.
    Blanks,
}

impl Separator {
    /// The text to write between two fields.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Comma => ",",
            Self::Semicolon => ";",
            Self::Tab => "\t",
            Self::Blanks => " ",
        }
    }

    fn of_names(line: &[u8]) -> Self {
        // A name in quotes may hold any of them.
        let mut quoted = false;
        let open: Vec<u8> = line
            .iter()
            .copied()
            .filter(|&b| {
                quoted ^= b == b'"';
                !quoted
            })
            .collect();
        let candidates = [(b';', Self::Semicolon), (b',', Self::Comma), (b'\t', Self::Tab)];
        candidates.into_iter().find(|(byte, _)| open.contains(byte)).map_or(Self::Blanks, |(_, separator)| separator)
    }

    fn of_numbers(line: &[u8]) -> Self {
        match Self::of_names(line) {
            Self::Tab => Self::Blanks,
            other => other,
        }
    }
}

/// Fields of a line, without their quotes and outer blanks.
pub(crate) struct Fields<'a> {
    rest: Option<&'a [u8]>,
    separator: Separator,
}

pub(crate) fn fields(line: &[u8], separator: Separator) -> Fields<'_> {
    let rest = (separator != Separator::Blanks || skip_blanks(line, 0) < line.len()).then_some(line);
    Fields { rest, separator }
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let line = self.rest?;
        let start = skip_blanks_but(line, self.separator);
        let (field, after) = if line.get(start) == Some(&b'"') {
            // A doubled quote inside is part of the text; the numbers and names read here have none.
            let mut close = start + 1;
            while close < line.len() && (line[close] != b'"' || line.get(close + 1) == Some(&b'"')) {
                close += if line[close] == b'"' { 2 } else { 1 };
            }
            let close = close.min(line.len());
            (&line[start + 1..close], (close + 1).min(line.len()))
        } else {
            let end = start + self.end_of_field(&line[start..]);
            (line[start..end].trim_ascii_end(), end)
        };
        let after = after + self.end_of_field(&line[after..]);
        self.rest = match self.separator {
            Separator::Blanks => {
                let next = skip_blanks(line, after);
                (next < line.len()).then(|| &line[next..])
            }
            _ => (after < line.len()).then(|| &line[after + 1..]),
        };
        Some(field)
    }
}

impl Fields<'_> {
    fn end_of_field(&self, rest: &[u8]) -> usize {
        let ends = |b: &u8| match self.separator {
            Separator::Blanks => b.is_ascii_whitespace(),
            separator => *b == separator.as_str().as_bytes()[0],
        };
        rest.iter().position(ends).unwrap_or(rest.len())
    }
}

fn skip_blanks_but(line: &[u8], separator: Separator) -> usize {
    line.iter()
        .position(|&b| !b.is_ascii_whitespace() || (separator == Separator::Tab && b == b'\t'))
        .unwrap_or(line.len())
}

/// Names of the columns, wherever the file states them.
pub(crate) struct Header {
    pub(crate) names: Vec<String>,
    pub(crate) separator: Separator,
    /// Whether the file has no names, so that its columns are what most files without names hold.
    unnamed: bool,
    text: String,
}

impl Header {
    /// Reads up to the first row of numbers, at which `lines` is made to stay.
    pub(crate) fn read(lines: &mut LineReader) -> Result<Self, IoError> {
        let mut comments: Vec<Vec<u8>> = Vec::new();
        loop {
            if !lines.advance()? {
                let found = "there is neither a header row nor a row of numbers";
                return Err(lines.error(found, "the first row has to name the columns, as in: x,y,z,radius"));
            }
            let line = lines.line().trim_ascii();
            if let Some(comment) = line.strip_prefix(b"#") {
                // Only the last comments can name columns; a file of nothing but comments is not collected.
                if comments.len() == 64 {
                    comments.remove(0);
                }
                comments.push(comment.trim_ascii().to_vec());
            } else if !line.is_empty() {
                break;
            }
        }
        let line = lines.line();
        if let Some(named) = Self::named(line) {
            return Ok(named);
        }
        let separator = Separator::of_numbers(line);
        let first: Vec<&[u8]> = fields(line, separator).collect();
        let columns = first.len();
        let numeric = first.iter().all(|field| number(field).is_some());
        let mut commented: Vec<Vec<String>> = comments.iter().rev().map(|comment| names_in(comment)).collect();
        commented.retain(|names| names.len() == columns && names.iter().all(|name| number(name.as_bytes()).is_none()));
        // A sentence may happen to have as many words as there are columns: names that make coordinates go first.
        let best = commented.iter().position(|names| Columns::new(names.clone(), Dialect::Table).is_ok());
        let commented = best.map(|index| commented.swap_remove(index)).or_else(|| commented.into_iter().next());
        let stated = comments.iter().rev().find_map(|comment| yade_names(comment, columns));
        let assumed = match columns {
            3 | 4 if numeric => Some(["x", "y", "z", "r"].iter().take(columns).map(ToString::to_string).collect()),
            _ => None,
        };
        let stated = commented.or(stated);
        let unnamed = stated.is_none();
        let Some(names) = stated.or(assumed) else {
            let found = format!("a row of {columns} columns begins the file, without names for them");
            return Err(lines.error(found, "put a header row before it, as in: x,y,z,radius"));
        };
        lines.stay();
        let text = names.join(separator.as_str());
        Ok(Self { names, separator, unnamed, text })
    }
}

impl Header {
    /// The names in a line that holds no numbers.
    fn named(line: &[u8]) -> Option<Self> {
        let separator = Separator::of_names(line);
        if !fields(line, separator).all(|field| number(field).is_none()) {
            return None;
        }
        let mut names: Vec<String> = fields(line, separator).map(unquoted).collect();
        while names.last().is_some_and(String::is_empty) {
            names.pop();
        }
        for (index, name) in names.iter_mut().enumerate() {
            if name.is_empty() {
                *name = format!("column_{}", index + 1);
            }
        }
        let text = String::from_utf8_lossy(line).into_owned();
        Some(Self { names, separator, unnamed: false, text })
    }
}

fn names_in(line: &[u8]) -> Vec<String> {
    fields(line, Separator::of_names(line)).map(unquoted).collect()
}

fn unquoted(name: &[u8]) -> String {
    String::from_utf8_lossy(name).replace("\"\"", "\"")
}

/// Columns that a line like `format x_y_z_r_matId` names; `attrs` stands for any number more.
fn yade_names(comment: &[u8], columns: usize) -> Option<Vec<String>> {
    let word = words(comment).last()?;
    let word = std::str::from_utf8(word).ok()?;
    let mut names: Vec<String> = word.strip_prefix("x_y_z").map(|_| word)?.split('_').map(Into::into).collect();
    if names.last().is_some_and(|name| name == "attrs") {
        names.pop();
        let known = names.len();
        names.extend((known..columns).map(|k| format!("attr_{}", k + 1 - known)));
    }
    (names.len() == columns).then_some(names)
}

/// A table of text whose columns are read as numbers when asked for, and whose rows can be passed on unchanged.
///
/// The columns are named by the first row that is no comment, or by the last comment before the first row of
/// numbers. Separators are commas, semicolons, tabs or blanks, decided by that line. Comments (`#`) and empty
/// lines are left out.
///
/// ```
/// use fieldstone_io::CsvTable;
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("balls.csv");
/// std::fs::write(&path, "cx,cy,cz,r,note\n0,0,1.5,0.25,first\n1,0,2.5,0.5,second\n")?;
/// let table = CsvTable::read(&path)?;
/// assert_eq!(table.column("cz")?, [1.5, 2.5]);
/// assert_eq!(table.rows().last(), Some((3, "1,0,2.5,0.5,second")));
/// assert!(table.column("note").is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct CsvTable {
    path: std::path::PathBuf,
    names: Vec<String>,
    header: String,
    separator: Separator,
    text: String,
    /// End of each row in `text`, and its line in the file.
    rows: Vec<(usize, u64)>,
}

impl CsvTable {
    /// Reads the whole table, compressed or not.
    ///
    /// # Errors
    /// [`IoError::System`]; [`IoError::Content`] where columns have no names, or a row has more or fewer of them.
    pub fn read(path: &Path) -> Result<Self, IoError> {
        let mut lines = LineReader::open(path)?;
        let Header { names, separator, text: header, .. } = Header::read(&mut lines)?;
        let mut table = Self { path: path.into(), names, header, separator, text: String::new(), rows: Vec::new() };
        while lines.advance()? {
            let line = lines.line().trim_ascii();
            if line.is_empty() || line.starts_with(b"#") {
                continue;
            }
            let found = fields(lines.line(), separator).count();
            let trailing = found == table.names.len() + 1 && fields(lines.line(), separator).last() == Some(b"");
            if found != table.names.len() && !trailing {
                let found = format!("the row has {found} columns, but {} are named", table.names.len());
                return Err(lines.error(found, "correct the row, or write the file again"));
            }
            table.text.push_str(&String::from_utf8_lossy(lines.line()));
            table.rows.push((table.text.len(), lines.number()));
        }
        Ok(table)
    }

    /// Names of the columns, as the file spells them.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The header row, as the file has it; where the names stand in a comment, made from them.
    pub fn header(&self) -> &str {
        &self.header
    }

    /// What stands between fields.
    pub fn separator(&self) -> Separator {
        self.separator
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The rows as the file has them, each after the number of its line, from 1.
    pub fn rows(&self) -> impl Iterator<Item = (u64, &str)> {
        let mut start = 0;
        self.rows.iter().map(move |&(end, line)| (line, &self.text[std::mem::replace(&mut start, end)..end]))
    }

    /// Whether a column is called `name`, whatever the letter case.
    pub fn has(&self, name: &str) -> bool {
        self.index(name).is_some()
    }

    fn index(&self, name: &str) -> Option<usize> {
        let exact = self.names.iter().position(|n| n == name);
        exact.or_else(|| self.names.iter().position(|n| n.eq_ignore_ascii_case(name)))
    }

    /// The numbers of a column; an exact name goes before one of other letter case.
    ///
    /// # Errors
    /// [`IoError::Content`] where there is no such column, it being told which there are, and where a field is no
    /// number, with its line.
    pub fn column(&self, name: &str) -> Result<Vec<f64>, IoError> {
        let Some(column) = self.index(name) else {
            let found = format!("there is no column '{name}'; the columns are {}", self.names.join(" "));
            let remedy = "rename a column in the header row";
            return Err(IoError::content(&self.path, Position::File, found, remedy));
        };
        self.rows()
            .map(|(line, row)| {
                let field = fields(row.as_bytes(), self.separator).nth(column).unwrap_or_default();
                number(field).ok_or_else(|| {
                    let found = format!("column '{name}' holds '{}', which is no number", shown(field));
                    let remedy = "correct the row; decimal commas are not read";
                    IoError::content(&self.path, Position::Line(line), found, remedy)
                })
            })
            .collect()
    }
}

/// Reads particles from a table of text: one frame.
///
/// Letter case does not matter. Positions are `x y z`, `px py pz`, `Points:0 …`, `position_x …`, `pos_x …` or `Pos.x …`;
/// radii are `radius`, `radii`, `r` or `rad`, else half of `diameter`, `d` or `diam`; `id`, and `type` or `matId`. `vx vy
/// vz` and the like become vectors as in [`crate::DumpReader`], and so do `name:0 name:1 …` and `name_x name_y
/// name_z` and `name.x name.y name.z`. A unit of SI behind a name is left away (`x [m]`), a multiple of one is refused
/// (`Diameter [mm]`) or, where the column is a quantity of its own name, stays in it. Lines before the names that make no
/// coordinates are passed over. Without any names, three columns of numbers are positions and a fourth is the radius, with a
/// warning. An empty field is NaN where it is neither position, size, id nor type.
///
/// ```
/// use fieldstone_io::{CsvReader, FrameReader};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("balls.csv");
/// std::fs::write(&path, "X;Y;Z;Diam\n0;0;1;0.5\n")?;
/// let particles = CsvReader::open(&path)?.next_frame()?.expect("one frame");
/// assert_eq!(particles.radii()?, [0.25]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct CsvReader {
    lines: LineReader,
    options: ParticleOptions,
    warnings: Vec<String>,
    done: bool,
}

impl CsvReader {
    /// Opens a table of spheres.
    ///
    /// # Errors
    /// [`IoError::System`] where the file cannot be opened.
    pub fn open(path: &Path) -> Result<Self, IoError> {
        Self::open_with(path, &ParticleOptions::default())
    }

    /// Opens a table, with options.
    ///
    /// # Errors
    /// As [`CsvReader::open`].
    pub fn open_with(path: &Path, options: &ParticleOptions) -> Result<Self, IoError> {
        Ok(Self { lines: LineReader::open(path)?, options: *options, warnings: Vec::new(), done: false })
    }

    /// The line that names the columns, and what they mean.
    ///
    /// Programs put lines of other names and numbers before it: the time and the count of particles, say. They are passed
    /// over where they make no coordinates.
    fn columns(&mut self) -> Result<(Header, Columns), IoError> {
        let lines = &mut self.lines;
        let settle = |header: Header, lines: &LineReader| {
            let columns = columns_with_units(&header.names).map_err(|(found, remedy)| lines.error(found, remedy))?;
            Ok((header, columns))
        };
        let error = match Header::read(lines).and_then(|header| settle(header, lines)) {
            Ok(found) => return Ok(found),
            Err(error) => error,
        };
        for _ in 0..PREAMBLE {
            if !lines.advance()? {
                break;
            }
            let Some(header) = Header::named(lines.line()) else { continue };
            let bare: Vec<String> = header.names.iter().map(|name| units::split(name).0.to_owned()).collect();
            if Columns::new(bare, Dialect::Table).is_ok() {
                return settle(header, lines);
            }
        }
        Err(error)
    }

    fn read(&mut self) -> Result<Particles, IoError> {
        let (header, mut columns) = self.columns()?;
        let lines = &mut self.lines;
        if !self.options.allow_non_spherical
            && let Some((found, remedy)) = non_spherical(&header.names)
        {
            return Err(lines.error(found, remedy));
        }
        if header.unnamed {
            let taken = if header.names.len() == 3 { "x y z" } else { "x y z radius" };
            self.warnings.push(format!(
                "there is no line of names: the columns are taken as {taken}; if they are others, put a line before them, as in: \
                 id,x,y,z"
            ));
        }
        let mut assembly = None;
        let mut row = Row::default();
        while lines.advance()? {
            let line = lines.line();
            if skip_blanks(line, 0) == line.len() || line.trim_ascii_start().starts_with(b"#") {
                continue;
            }
            if assembly.is_none() {
                for name in columns.pass_over_text(fields(line, header.separator)) {
                    self.warnings.push(format!("column '{name}' holds text and is passed over"));
                }
            }
            let assembly = assembly.get_or_insert_with(|| Assembly::new(&columns, 0));
            columns
                .read_fields(fields(line, header.separator), &mut row)
                .and_then(|()| assembly.push(&columns, &row, |p| p))
                .map_err(|fault| {
                    let (found, remedy) = fault.describe(&columns);
                    lines.error(found, remedy)
                })?;
        }
        let assembly = assembly.unwrap_or_else(|| Assembly::new(&columns, 0));
        assembly.finish(&columns).map_err(|source| IoError::Particles { path: lines.path().into(), source })
    }
}

/// Lines before the one that names the columns.
const PREAMBLE: usize = 16;

/// What columns mean, with their units taken off; what was found and a remedy where there are no coordinates, or where a
/// column would be read as a length, mass, … in another unit than the one beside it.
fn columns_with_units(names: &[String]) -> Result<Columns, (String, String)> {
    let missing = |missing: String| (missing, "name the coordinates x, y and z in the header row".to_owned());
    let split: Vec<(&str, Unit)> = names.iter().map(|name| units::split(name)).collect();
    let bare = split.iter().map(|(bare, _)| (*bare).to_owned()).collect();
    let columns = Columns::new(bare, Dialect::Table).map_err(missing)?;
    let mut scaled = split.iter().enumerate().filter_map(|(column, (_, unit))| match unit {
        Unit::Scaled(unit) => Some((column, *unit)),
        _ => None,
    });
    if let Some((column, unit)) = scaled.clone().find(|&(column, _)| columns.has_meaning(column)) {
        let found = format!(
            "column {} '{}' is in {unit}, which is no unit of SI but a multiple of one; numbers are read as they stand",
            column + 1,
            names[column]
        );
        let remedy = "write the column in SI units, or all of them in units that fit together, which then stay out of the header";
        return Err((found, remedy.into()));
    }
    if scaled.next().is_none() {
        return Ok(columns);
    }
    // A quantity of its own name keeps a unit that is not SI, so that nobody takes it for another.
    let keep = |(name, (bare, unit)): (&String, (&str, Unit))| match unit {
        Unit::Scaled(_) => name.clone(),
        _ => bare.to_owned(),
    };
    Columns::new(names.iter().zip(split).map(keep).collect(), Dialect::Table).map_err(missing)
}

impl FrameReader for CsvReader {
    fn next_frame(&mut self) -> Result<Option<Particles>, IoError> {
        if std::mem::replace(&mut self.done, true) {
            return Ok(None);
        }
        self.read().map(Some)
    }

    fn skip_frame(&mut self) -> Result<bool, IoError> {
        Ok(!std::mem::replace(&mut self.done, true))
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}
