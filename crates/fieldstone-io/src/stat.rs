//! MercuryCG's `.stat` files: coarse-grained fields as text.

use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

use fieldstone_mesh::{Coordinates, Grid};

use crate::lines::{LineReader, number, shown, text, words};
use crate::{AtomicFile, IoError, Position};

/// First line of a `.stat` file: which points the fields are at, and how they were made.
#[derive(Debug, Clone, PartialEq)]
pub struct StatHeader {
    /// Directions that are resolved; rows have coordinates along these only.
    pub coordinates: Coordinates,
    /// Lower corner of the region.
    pub low: [f64; 3],
    /// Upper corner of the region.
    pub high: [f64; 3],
    /// Time from which on frames were looked at.
    pub time_min: f64,
    /// Points along x, y and z; 1 along directions that are averaged.
    pub points: [usize; 3],
    /// Width of the coarse-graining function.
    pub width: f64,
    /// The function with its own numbers, as in `Lucy cutoff 1` or `Gauss width 0.5 cutoff 1.5`.
    pub function: String,
}

impl StatHeader {
    /// The grid whose cell centres are the points.
    ///
    /// # Errors
    /// [`fieldstone_mesh::MeshError`] for a region without extent.
    pub fn grid(&self) -> Result<Grid, fieldstone_mesh::MeshError> {
        Grid::resolving(self.low, self.high, self.points, self.coordinates)
    }

    fn line(&self) -> String {
        let three = |v: [f64; 3]| v.map(general).join(" ");
        let [nx, ny, nz] = self.points;
        format!(
            "CG<{}> min {} max {} timeMin {} n {nx} {ny} {nz} width {} {}",
            self.coordinates,
            three(self.low),
            three(self.high),
            general(self.time_min),
            general(self.width),
            self.function
        )
    }

    fn parse(line: &[u8]) -> Option<Self> {
        let line = std::str::from_utf8(line).ok()?;
        let (coordinates, rest) = line.strip_prefix("CG<")?.split_once('>')?;
        let words: Vec<&str> = rest.split_ascii_whitespace().collect();
        let after = |key: &str| words.iter().position(|word| *word == key).map(|at| at + 1);
        let value = |at: usize| words.get(at)?.parse::<f64>().ok();
        let three = |at: usize| Some([value(at)?, value(at + 1)?, value(at + 2)?]);
        let n = after("n")?;
        let count = |at: usize| words.get(at)?.parse::<usize>().ok().filter(|&n| n > 0);
        let width = after("width")?;
        Some(Self {
            coordinates: coordinates.parse().ok()?,
            low: three(after("min")?)?,
            high: three(after("max")?)?,
            time_min: value(after("timeMin")?)?,
            points: [count(n)?, count(n + 1)?, count(n + 2)?],
            width: value(width)?,
            function: words.get(width + 1..)?.join(" "),
        })
    }

    fn resolved(&self) -> Vec<usize> {
        (0..3).filter(|&k| self.coordinates.resolved()[k]).collect()
    }

    fn point_count(&self) -> Option<usize> {
        self.points.iter().try_fold(1usize, |n, &c| n.checked_mul(c))
    }

    /// Number of the grid's cell, x fastest, that row `row` of a block is about: rows have z fastest.
    fn cell_of_row(&self, row: usize) -> usize {
        let [nx, ny, nz] = self.points;
        let (i, j, k) = (row / (ny * nz), row / nz % ny, row % nz);
        i + nx * (j + ny * k)
    }
}

/// A field of a `.stat` file: its name and how many columns it has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatField {
    /// Name, as in `ContactStress`.
    pub name: String,
    /// Columns.
    pub components: usize,
}

/// The fields of one time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StatBlock {
    /// Time.
    pub time: f64,
    /// For each field its numbers, cell by cell with x fastest, components of a cell together.
    pub data: Vec<Vec<f64>>,
}

/// A `.stat` file: MercuryCG's output.
///
/// | line | content |
/// |---|---|
/// | 1 | `CG<XYZ> min … max … timeMin t n nx ny nz width w Lucy cutoff c` |
/// | 2 | `time x y z 5:VolumeFraction 6:Density 7-9:Momentum …`; averaged coordinates are left out |
/// | rows | time, coordinates, fields; x slowest, z fastest; one block after the other for each time |
#[derive(Debug, Clone, PartialEq)]
pub struct StatFile {
    /// First line.
    pub header: StatHeader,
    /// Fields in the order of their columns.
    pub fields: Vec<StatField>,
    /// Blocks in the order of the file.
    pub blocks: Vec<StatBlock>,
}

/// Reads a `.stat` file, compressed or not.
///
/// # Errors
/// [`crate::IoError::Content`] with the line where the content stops making sense; [`crate::IoError::System`].
///
/// ```
/// use fieldstone_io::read_stat;
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("mean.stat");
/// std::fs::write(&path, "CG<Z> min 0 0 0 max 1 1 4 timeMin 0 n 1 1 2 width 1 Lucy cutoff 1\n\
///     time z 3:VolumeFraction 4-6:Momentum \n2.5 1 0.5 1 2 3\n2.5 3 0.25 4 5 6\n")?;
/// let file = read_stat(&path)?;
/// assert_eq!(file.fields[1].name, "Momentum");
/// assert_eq!(file.blocks[0].data[1], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_stat(path: &Path) -> Result<StatFile, IoError> {
    const REMEDY: &str = "give a .stat file as MercuryCG or fieldstone fields writes it";
    let mut lines = LineReader::open(path)?;
    lines.advance()?;
    let header = StatHeader::parse(lines.line()).ok_or_else(|| {
        let found = format!("'{}' stands where the header CG<XYZ> min … max … n … is expected", shown(lines.line()));
        lines.error(found, REMEDY)
    })?;
    let resolved = header.resolved();
    let first = 1 + resolved.len();
    lines.advance()?;
    let fields = words(lines.line()).skip(first).map(field_of).collect::<Option<Vec<StatField>>>();
    let fields = fields.filter(|fields| !fields.is_empty()).ok_or_else(|| {
        lines.error("the second line does not name columns, as in 'time x y z 5:VolumeFraction'", REMEDY)
    })?;
    let width = first + fields.iter().map(|field| field.components).sum::<usize>();
    let points = header.point_count().filter(|&n| n < u32::MAX as usize);
    let points = points.ok_or_else(|| lines.error("the header states too many points", REMEDY))?;
    let mut blocks: Vec<StatBlock> = Vec::new();
    let mut row = 0;
    while lines.advance()? {
        if lines.line().trim_ascii().is_empty() {
            continue;
        }
        let numbers: Option<Vec<f64>> = words(lines.line()).map(number).collect();
        let numbers = numbers.filter(|numbers| numbers.len() == width).ok_or_else(|| {
            let found = format!("the row '{}' has not the {width} numbers that line 2 names", shown(lines.line()));
            lines.error(found, "the file is cut, or still being written; write it again")
        })?;
        if row == 0 {
            // Memory is taken as rows come: a header may promise more than there is.
            let data = fields.iter().map(|_| Vec::new()).collect();
            blocks.push(StatBlock { time: numbers[0], data });
        }
        let Some(block) = blocks.last_mut() else { continue };
        let mut at = first;
        for (field, data) in fields.iter().zip(&mut block.data) {
            data.extend_from_slice(&numbers[at..at + field.components]);
            at += field.components;
        }
        row = (row + 1) % points;
        if row == 0 {
            reorder(&header, &fields, block);
        }
    }
    if row != 0 {
        let found = format!("the file ends after {row} of the {points} rows of a block");
        return Err(lines.error(found, "the file is cut, or still being written; write it again"));
    }
    Ok(StatFile { header, fields, blocks })
}

/// `5:VolumeFraction` or `7-9:Momentum`.
fn field_of(word: &[u8]) -> Option<StatField> {
    let word = text(word);
    let (range, name) = word.split_once(':')?;
    let components = match range.split_once('-') {
        None => range.parse::<usize>().ok().map(|_| 1)?,
        Some((from, to)) => {
            let (from, to): (usize, usize) = (from.parse().ok()?, to.parse().ok()?);
            to.checked_sub(from)?.checked_add(1).filter(|&n| n < 1000)?
        }
    };
    Some(StatField { name: name.into(), components })
}

/// From the order of rows to that of cells.
fn reorder(header: &StatHeader, fields: &[StatField], block: &mut StatBlock) {
    for (field, data) in fields.iter().zip(&mut block.data) {
        let n = field.components;
        let mut sorted = vec![0.0; data.len()];
        for (row, numbers) in data.chunks_exact(n).enumerate() {
            let cell = header.cell_of_row(row);
            sorted[cell * n..(cell + 1) * n].copy_from_slice(numbers);
        }
        *data = sorted;
    }
}

/// A `.stat` file under construction: block after block; it appears when [`StatWriter::finish`] is called.
///
/// Numbers have MercuryCG's six digits.
///
/// ```
/// use fieldstone_io::{StatField, StatHeader, StatWriter, read_stat};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("density.stat");
/// let header = StatHeader {
///     coordinates: "Z".parse()?,
///     low: [0.0; 3],
///     high: [1.0, 1.0, 4.0],
///     time_min: 0.0,
///     points: [1, 1, 2],
///     width: 1.0,
///     function: "Lucy cutoff 1".into(),
/// };
/// let fields = vec![StatField { name: "Density".into(), components: 1 }];
/// let mut writer = StatWriter::create(&path, header, fields)?;
/// writer.block(2.5, &[&[1.0 / 3.0, 1e-7]])?;
/// writer.finish()?;
/// let text = std::fs::read_to_string(&path)?;
/// assert!(text.ends_with("time z 3:Density \n2.5 1 0.333333\n2.5 3 1e-07\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct StatWriter {
    file: AtomicFile,
    path: PathBuf,
    header: StatHeader,
    fields: Vec<StatField>,
}

impl StatWriter {
    /// Starts a file.
    ///
    /// # Errors
    /// [`IoError::System`] where the folder cannot be written to.
    pub fn create(path: &Path, header: StatHeader, fields: Vec<StatField>) -> Result<Self, IoError> {
        let mut writer = Self { file: AtomicFile::create(path)?, path: path.into(), header, fields };
        let resolved = writer.header.resolved();
        let mut names = String::from("time ");
        for &axis in &resolved {
            let _ = write!(names, "{} ", ["x", "y", "z"][axis]);
        }
        let mut column = 2 + resolved.len();
        for field in &writer.fields {
            let _ = match field.components {
                1 => write!(names, "{column}:{} ", field.name),
                n => write!(names, "{column}-{}:{} ", column + n - 1, field.name),
            };
            column += field.components;
        }
        let lines = format!("{}\n{names}\n", writer.header.line());
        writer.put(&lines)?;
        Ok(writer)
    }

    fn put(&mut self, text: &str) -> Result<(), IoError> {
        self.file.write_all(text.as_bytes()).map_err(|source| IoError::System {
            path: self.path.clone(),
            action: "write",
            source,
        })
    }

    /// Writes the fields of one time: for each its numbers, cell by cell with x fastest.
    ///
    /// # Errors
    /// [`IoError::Content`] where there are more or fewer lists than fields, or numbers than points times components;
    /// [`IoError::System`].
    pub fn block(&mut self, time: f64, data: &[&[f64]]) -> Result<(), IoError> {
        let points: usize = self.header.points.iter().product();
        let refuse = |found: String| {
            let remedy = "give each field a number per point and component; nothing of this time was written";
            Err(IoError::content(&self.path, Position::File, found, remedy))
        };
        if data.len() != self.fields.len() {
            return refuse(format!("{} lists of numbers were given for {} fields", data.len(), self.fields.len()));
        }
        for (StatField { name, components }, data) in self.fields.iter().zip(data) {
            if data.len() != points * components {
                let found = data.len();
                return refuse(format!(
                    "field '{name}' of {points} points times {components} components has {found} numbers"
                ));
            }
        }
        let resolved = self.header.resolved();
        let (low, high, n) = (self.header.low, self.header.high, self.header.points);
        let centre = |axis: usize, at: usize| low[axis] + (high[axis] - low[axis]) * (at as f64 + 0.5) / n[axis] as f64;
        let time = general(time);
        let mut line = String::new();
        for row in 0..points {
            let at = [row / (n[1] * n[2]), row / n[2] % n[1], row % n[2]];
            let cell = self.header.cell_of_row(row);
            line.clear();
            line.push_str(&time);
            for &axis in &resolved {
                line.push(' ');
                line.push_str(&general(centre(axis, at[axis])));
            }
            for (field, data) in self.fields.iter().zip(data) {
                for &value in &data[cell * field.components..(cell + 1) * field.components] {
                    line.push(' ');
                    line.push_str(&general(value));
                }
            }
            line.push('\n');
            self.put(&line)?;
        }
        Ok(())
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// [`IoError::System`].
    pub fn finish(self) -> Result<(), IoError> {
        self.file.commit()
    }
}

/// A number as C's `%g` and C++'s streams print it: six digits, no trailing zeros, an exponent where it is shorter.
fn general(x: f64) -> String {
    if !x.is_finite() {
        return if x.is_nan() { "nan".into() } else { if x > 0.0 { "inf" } else { "-inf" }.into() };
    }
    if x == 0.0 {
        return if x.is_sign_negative() { "-0".into() } else { "0".into() };
    }
    let scientific = format!("{x:.5e}");
    let Some((mantissa, exponent)) = scientific.split_once('e') else { return scientific };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..6).contains(&exponent) {
        let fixed = format!("{x:.*}", (5 - exponent).max(0) as usize);
        return if fixed.contains('.') { trimmed(&fixed).into() } else { fixed };
    }
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{}e{sign}{:02}", trimmed(mantissa), exponent.abs())
}

fn trimmed(digits: &str) -> &str {
    digits.trim_end_matches('0').trim_end_matches('.')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_printed_as_c_plus_plus_streams_do() {
        for (x, expected) in [
            (0.0, "0"),
            (-0.0, "-0"),
            (10.0, "10"),
            (11.2, "11.2"),
            (0.3168179, "0.316818"),
            (8.936e-5, "8.936e-05"),
            (0.0001, "0.0001"),
            (0.00012345678, "0.000123457"),
            (999_999.4, "999999"),
            (999_999.5, "1e+06"),
            (1.5e6, "1.5e+06"),
            (-2.25e-100, "-2.25e-100"),
            (99_999.95, "99999.9"),
            (99_999.96, "100000"),
            (f64::NAN, "nan"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(general(x), expected);
        }
    }
}
