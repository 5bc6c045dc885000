//! Tables of numbers, written so that they read back to the same bits.

use std::io::Write;
use std::path::{Path, PathBuf};

use fieldstone_particles::Particles;

use crate::csv::fields;
use crate::{AtomicFile, CsvTable, IoError, Position, Separator};

/// A table under construction; it appears under its name when [`CsvWriter::finish`] is called.
///
/// Numbers get the fewest digits that read back to the same bits; whole numbers come without a point.
///
/// ```
/// use fieldstone_io::{CsvTable, CsvWriter};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("volumes.csv");
/// let mut writer = CsvWriter::create(&path, &["cell", "volume"])?;
/// writer.row(&[0.0, 1e-9 / 3.0])?;
/// writer.finish()?;
/// assert_eq!(std::fs::read_to_string(&path)?, "cell,volume\n0,3.3333333333333337e-10\n");
/// assert_eq!(CsvTable::read(&path)?.column("volume")?, [1e-9 / 3.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct CsvWriter {
    file: AtomicFile,
    path: PathBuf,
    separator: Separator,
    /// How many are named.
    columns: usize,
}

impl CsvWriter {
    /// Starts a table with columns of these names, separated by commas.
    ///
    /// # Errors
    /// [`IoError::System`] where the folder cannot be written to.
    pub fn create(path: &Path, names: &[&str]) -> Result<Self, IoError> {
        Self::create_with_comment(path, "", names)
    }

    /// Starts a table with lines of comment, each after `# `, above the names of the columns.
    ///
    /// Lines that begin with `#` themselves get one more: the text comes back where the first `#` of each line is taken off.
    ///
    /// # Errors
    /// As [`CsvWriter::create`].
    pub fn create_with_comment(path: &Path, comment: &str, names: &[&str]) -> Result<Self, IoError> {
        let (file, separator) = (AtomicFile::create(path)?, Separator::Comma);
        let mut writer = Self { file, path: path.into(), separator, columns: names.len() };
        for line in comment.lines() {
            let sign = if line.starts_with('#') { "#" } else { "# " };
            writer.line(format!("{sign}{line}").trim_end())?;
        }
        writer.line(&names.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(","))?;
        Ok(writer)
    }

    /// Starts a table with the columns of `table` and more columns after them, in its separator.
    ///
    /// # Errors
    /// As [`CsvWriter::create`].
    pub fn extending(path: &Path, table: &CsvTable, names: &[&str]) -> Result<Self, IoError> {
        let separator = table.separator();
        let (file, own) = (AtomicFile::create(path)?, table.names().len());
        let mut writer = Self { file, path: path.into(), separator, columns: own + names.len() };
        let mut header = of_columns(table.header(), separator, own).to_string();
        for name in names {
            header.push_str(separator.as_str());
            header.push_str(&quoted(name));
        }
        writer.line(&header)?;
        Ok(writer)
    }

    /// Writes a row.
    ///
    /// # Errors
    /// [`IoError::System`]
    pub fn row(&mut self, numbers: &[f64]) -> Result<(), IoError> {
        self.write(None, numbers)
    }

    /// Writes a row of text as it is, such as one of [`CsvTable::rows`], and numbers after it.
    ///
    /// A separator at its end is left out where it stands behind the last column; empty last columns stay.
    ///
    /// # Errors
    /// [`IoError::System`]
    pub fn row_extending(&mut self, text: &str, numbers: &[f64]) -> Result<(), IoError> {
        let own = self.columns.saturating_sub(numbers.len());
        self.write(Some(of_columns(text, self.separator, own)), numbers)
    }

    fn write(&mut self, text: Option<&str>, numbers: &[f64]) -> Result<(), IoError> {
        let separator = self.separator.as_str();
        let mut body = || {
            self.file.write_all(text.unwrap_or_default().as_bytes())?;
            for (index, &value) in numbers.iter().enumerate() {
                if index > 0 || text.is_some() {
                    self.file.write_all(separator.as_bytes())?;
                }
                write_number(&mut self.file, value)?;
            }
            self.file.write_all(b"\n")
        };
        body().map_err(|source| IoError::System { path: self.path.clone(), action: "write", source })
    }

    fn line(&mut self, line: &str) -> Result<(), IoError> {
        writeln!(self.file, "{line}").map_err(|source| IoError::System {
            path: self.path.clone(),
            action: "write",
            source,
        })
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// [`IoError::System`]
    pub fn finish(self) -> Result<(), IoError> {
        self.file.commit()
    }
}

/// A line without the separators and blanks behind its last column, which would make empty columns before the new ones.
fn of_columns(line: &str, separator: Separator, columns: usize) -> &str {
    // A tab at the end may stand before an empty field.
    let bare = |line: &str| {
        line.trim_end_matches(|c: char| c.is_ascii_whitespace() && (separator, c) != (Separator::Tab, '\t')).len()
    };
    let mut line = &line[..bare(line)];
    while fields(line.as_bytes(), separator).count() > columns
        && let Some(shorter) = line.strip_suffix(separator.as_str())
    {
        line = &shorter[..bare(shorter)];
    }
    line
}

fn quoted(name: &str) -> String {
    if name.contains([',', ';', '\t', ' ', '"', '\n', '\r']) || name.starts_with('#') || name.is_empty() {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.into()
    }
}

/// Writes a number as tables have it: the shortest text that reads back to the same bits, with an exponent where that is shorter.
///
/// # Errors
/// Those of `out`.
///
/// ```
/// let mut out = Vec::new();
/// for value in [2.0, 0.1, 1e-300] {
///     fieldstone_io::write_number(&mut out, value)?;
///     out.push(b' ');
/// }
/// assert_eq!(out, b"2 0.1 1e-300 ");
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_number(out: &mut impl Write, value: f64) -> std::io::Result<()> {
    // `Display` never uses an exponent, `Debug` does where it is shorter to read but keeps `.0` on whole numbers.
    if value.fract() == 0.0 && value.abs() < 1e15 && (value != 0.0 || value.is_sign_positive()) {
        write!(out, "{}", value as i64)
    } else {
        write!(out, "{value:?}")
    }
}

/// Writes columns of one length as a table.
///
/// # Errors
/// [`IoError::Content`] where the columns differ in length; [`IoError::System`].
pub fn write_csv(path: &Path, columns: &[(&str, &[f64])]) -> Result<(), IoError> {
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let rows = columns.first().map_or(0, |(_, data)| data.len());
    if let Some((name, data)) = columns.iter().find(|(_, data)| data.len() != rows) {
        let found = format!("column '{name}' has {} rows, but '{}' has {rows}", data.len(), names[0]);
        return Err(IoError::content(path, Position::File, found, "give columns of one length; nothing was written"));
    }
    let mut writer = CsvWriter::create(path, &names)?;
    let mut row = vec![0.0; columns.len()];
    for index in 0..rows {
        for (slot, (_, data)) in row.iter_mut().zip(columns) {
            *slot = data[index];
        }
        writer.row(&row)?;
    }
    writer.finish()
}

/// Writes particles as a table that [`crate::CsvReader`] reads back to the same bits.
///
/// Columns are `id`, `type` (where known), `x`, `y`, `z`, `radius` (where known) and each quantity: a scalar under
/// its name, components that the source numbers as it has them (`c_w[1] c_w[2]`), another vector as `name_x name_y name_z`,
/// others as `name:0 name:1 …`. The box, the step and the time have
/// no place in a table and are left out.
///
/// # Errors
/// [`IoError::System`].
pub fn write_particles_csv(path: &Path, particles: &Particles) -> Result<(), IoError> {
    write_particles_csv_named(path, particles, &[])
}

/// As [`write_particles_csv`], with names for the components of some quantities: `stress_xx stress_xy …`.
///
/// # Errors
/// [`IoError::System`].
pub fn write_particles_csv_named(
    path: &Path,
    particles: &Particles,
    component_names: &[(&str, &[String])],
) -> Result<(), IoError> {
    let mut names: Vec<String> = Vec::new();
    names.extend(particles.ids().map(|_| "id".into()));
    names.extend(particles.types().map(|_| "type".into()));
    names.extend(["x", "y", "z"].map(String::from));
    let radii = particles.radii().ok();
    names.extend(radii.map(|_| "radius".into()));
    for quantity in particles.quantities() {
        let name = &quantity.name;
        let own = component_names.iter().find(|(of, list)| of == name && list.len() == quantity.components);
        match quantity.components {
            n if n > 1 && own.is_some() => {
                names.extend(own.into_iter().flat_map(|(_, list)| *list).map(|part| format!("{name}_{part}")));
            }
            1 => names.push(name.clone()),
            n if is_numbered(name, n, particles.source_names(name)) => {
                names.extend_from_slice(particles.source_names(name));
            }
            3 => names.extend(["x", "y", "z"].map(|axis| format!("{name}_{axis}"))),
            n => names.extend((0..n).map(|k| format!("{name}:{k}"))),
        }
    }
    let header = names.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(",");
    AtomicFile::write(path, |out| {
        let mut out = out;
        writeln!(out, "{header}")?;
        for (index, position) in particles.positions().iter().enumerate() {
            // Ids do not pass through a float, which would round those above 2⁵³.
            for column in [particles.ids(), particles.types()].into_iter().flatten() {
                write!(out, "{},", column[index])?;
            }
            let vectors = particles
                .quantities()
                .iter()
                .flat_map(|q| &q.data[index * q.components..(index + 1) * q.components])
                .copied();
            let row = position.iter().copied().chain(radii.map(|r| r[index])).chain(vectors);
            for (column, value) in row.enumerate() {
                if column > 0 {
                    out.write_all(b",")?;
                }
                write_number(&mut out, value)?;
            }
            out.write_all(b"\n")?;
        }
        Ok(())
    })
}

/// Whether these are `name[1]` to `name[count]`, which read back as the same quantity.
fn is_numbered(name: &str, count: usize, names: &[String]) -> bool {
    names.len() == count && (1..).zip(names).all(|(k, own)| *own == format!("{name}[{k}]"))
}
