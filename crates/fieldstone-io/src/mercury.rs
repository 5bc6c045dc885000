//! MercuryDPM's `.data` files in three dimensions.

use std::path::Path;

use fieldstone_particles::{Domain, Particles};

use crate::assembly::Assembly;
use crate::column_names::Dialect;
use crate::columns::Columns;
use crate::frames::unless_failed;
use crate::lines::{LineReader, integer, number, shown, skip_blanks, words};
use crate::{FrameReader, IoError};

const NAMES: [&str; 14] = [
    "x",
    "y",
    "z",
    "vx",
    "vy",
    "vz",
    "radius",
    "orientation:0",
    "orientation:1",
    "orientation:2",
    "omegax",
    "omegay",
    "omegaz",
    "info",
];

/// Reads the particles of a MercuryDPM `.data` file, frame by frame, compressed or not.
///
/// A frame is a line `N t xmin ymin zmin xmax ymax zmax` and N rows of 14 numbers: position, velocity, radius,
/// three angles, angular velocity, and the species, which becomes the type where it is an integer (a program may
/// put another number there: it is then the quantity `info`). The box is taken from the header. The file does
/// not say which of its directions are periodic: none is taken to be. Densities are only in the `.restart` file.
pub struct MercuryReader {
    lines: LineReader,
    frame: usize,
    warnings: Vec<String>,
    failed: bool,
}

impl MercuryReader {
    /// Opens a `.data` file.
    ///
    /// # Errors
    /// [`IoError::System`] where the file cannot be opened.
    pub fn open(path: &Path) -> Result<Self, IoError> {
        Ok(Self { lines: LineReader::open(path)?, frame: 0, warnings: Vec::new(), failed: false })
    }

    /// Number of particles and the seven numbers after it, from the next frame's header.
    fn head(&mut self) -> Result<Option<(u64, [f64; 7])>, IoError> {
        loop {
            if !self.lines.advance()? {
                return Ok(None);
            }
            if skip_blanks(self.lines.line(), 0) < self.lines.line().len() {
                break;
            }
        }
        let line = self.lines.line();
        let count = words(line).next().and_then(integer).and_then(|count| u64::try_from(count).ok());
        let rest: Option<Vec<f64>> = words(line).skip(1).map(number).collect();
        match (count, rest.as_deref()) {
            (Some(count), Some(&[a, b, c, d, e, f, g])) => Ok(Some((count, [a, b, c, d, e, f, g]))),
            (Some(_), Some([_, _, _, _, _])) => {
                let found = "the header has 6 numbers: the simulation is two-dimensional";
                Err(self.lines.error(found, "only three-dimensional .data files are read"))
            }
            _ => {
                let found = format!(
                    "'{}' stands where the header of frame {} is expected: N t xmin ymin zmin xmax ymax zmax",
                    shown(line),
                    self.frame
                );
                let remedy = "the frame before has more rows than its header says, or this is no MercuryDPM .data file";
                Err(self.lines.error(found, remedy))
            }
        }
    }

    fn truncated(&self, index: u64, count: u64) -> IoError {
        let found = format!("the file ends after {index} of the {count} particles of frame {}", self.frame);
        self.lines.error(found, "the file is cut, or still being written; earlier frames can be read")
    }

    fn read_frame(&mut self) -> Result<Option<Particles>, IoError> {
        let Some((count, [time, box_ @ ..])) = self.head()? else { return Ok(None) };
        let mut columns = Columns::new(NAMES.map(String::from).to_vec(), Dialect::Table)
            .map_err(|missing| self.lines.error(missing, "the names above are complete"))?;
        let domain = Domain::new([box_[0], box_[1], box_[2]], [box_[3], box_[4], box_[5]], [false; 3]);
        let warning = "the header's box is empty in some direction: read without a box".to_string();
        if domain.is_err() && !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
        let mut assembly = Assembly::new(&columns, usize::try_from(count).unwrap_or(usize::MAX));
        let mut left = count;
        while left > 0 {
            let block = self.lines.take_lines(left, b"")?;
            if block.is_empty() {
                return Err(self.truncated(count - left, count));
            }
            let first = self.lines.number() + 1 - block.len();
            let parts = block.parse(|lines| Assembly::of_lines(&columns, lines, |p| p)).map_err(|(line, fault)| {
                if !line.complete {
                    return self.truncated(count - left + (line.number - first), count);
                }
                let (found, remedy) = fault.describe(&columns);
                line.error(self.lines.path(), found, remedy)
            })?;
            parts.into_iter().for_each(|part| assembly.append(part));
            left -= block.len();
            self.lines.reuse(block);
        }
        assembly.integers_to_types(&mut columns, "info");
        let particles = assembly
            .finish(&columns)
            .map_err(|source| IoError::Particles { path: self.lines.path().into(), source })?
            .at(None, Some(time));
        self.frame += 1;
        Ok(Some(match domain {
            Ok(domain) => particles.with_domain(domain),
            Err(_) => particles,
        }))
    }

    fn pass_frame(&mut self) -> Result<bool, IoError> {
        let Some((count, _)) = self.head()? else { return Ok(false) };
        let mut left = count;
        while left > 0 {
            let block = self.lines.take_lines(left, b"")?;
            if block.is_empty() {
                return Err(self.truncated(count - left, count));
            }
            left -= block.len();
            // Half a row at the end of a cut file is none, as where the rows are read.
            if !block.complete() && block.last_line().is_some_and(|line| words(line.bytes).count() < NAMES.len()) {
                return Err(self.truncated(count - left - 1, count));
            }
            self.lines.reuse(block);
        }
        self.frame += 1;
        Ok(true)
    }
}

impl FrameReader for MercuryReader {
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
