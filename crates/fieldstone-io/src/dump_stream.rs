//! Headers and rows of LIGGGHTS and LAMMPS text dumps, of particles or of contacts.

use std::path::Path;

use fieldstone_particles::Domain;

use crate::IoError;
use crate::dump_box::{BoxFault, DumpBox};
use crate::line_blocks::LineBlock;
use crate::lines::{LineReader, integer, number, shown, skip_blanks, text, words};

/// What the rows of a dump are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DumpRows {
    /// `dump custom`, `dump atom`: `ITEM: ATOMS`.
    Atoms,
    /// `dump local`: `ITEM: ENTRIES`, or another label.
    Entries,
}

impl DumpRows {
    fn name(self) -> &'static str {
        match self {
            Self::Atoms => "atoms",
            Self::Entries => "entries",
        }
    }
}

/// What stands before the rows of a frame.
#[derive(Debug, Clone)]
pub(crate) struct DumpHead {
    pub(crate) count: u64,
    pub(crate) step: Option<i64>,
    pub(crate) time: Option<f64>,
    pub(crate) cell: Option<DumpBox>,
    /// The line that names the columns.
    pub(crate) column_line: Vec<u8>,
}

impl DumpHead {
    /// Names of the columns.
    pub(crate) fn names(&self) -> Vec<String> {
        words(&self.column_line).skip(2).map(text).collect()
    }
}

/// A dump, read section by section.
pub(crate) struct DumpStream {
    pub(crate) lines: LineReader,
    rows: DumpRows,
    /// Number of the current frame, from 0.
    pub(crate) frame: usize,
    pub(crate) units: Option<String>,
    pub(crate) warnings: Vec<String>,
}

impl DumpStream {
    pub(crate) fn open(path: &Path, rows: DumpRows) -> Result<Self, IoError> {
        Ok(Self { lines: LineReader::open(path)?, rows, frame: 0, units: None, warnings: Vec::new() })
    }

    pub(crate) fn warn(&mut self, warning: String) {
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// Reads up to the line that names the columns and stays there; `None` at the end of the file. The box is parsed
    /// only where somebody wants it.
    pub(crate) fn head(&mut self, with_box: bool) -> Result<Option<DumpHead>, IoError> {
        let (mut count, mut step, mut time, mut cell) = (None, None, None, None);
        let mut label = self.rows.name().to_ascii_uppercase().into_bytes();
        let mut begun = false;
        loop {
            if !self.lines.advance()? {
                if begun {
                    let found = format!("the file ends within the header of frame {}", self.frame);
                    return Err(self.lines.error(found, "the file is cut, or still being written"));
                }
                return Ok(None);
            }
            let line = self.lines.line();
            if skip_blanks(line, 0) == line.len() {
                continue;
            }
            let Some(item) = line.strip_prefix(b"ITEM:") else {
                let found = format!("'{}' stands where an 'ITEM:' line is expected", shown(line));
                let remedy = if self.frame > 0 {
                    format!("the frame before has more rows than its number of {} says", self.rows.name())
                } else {
                    "this is no LIGGGHTS or LAMMPS text dump".into()
                };
                return Err(self.lines.error(found, remedy));
            };
            begun = true;
            let item: Vec<&[u8]> = words(item).take(3).collect();
            match item.as_slice() {
                [b"TIMESTEP", ..] => step = Some(self.value("a time step", integer)?),
                [b"UNITS", ..] => self.units = Some(self.value("a unit style", |word| Some(text(word)))?),
                [b"TIME", ..] => time = Some(self.value("a time", number)?),
                [b"NUMBER", b"OF", what] => {
                    self.check_kind(what)?;
                    // `dump_modify label` gives entries another name.
                    label = what.to_vec();
                    let what = format!("a number of {}", self.rows.name());
                    count = Some(self.value(&what, |w| u64::try_from(integer(w)?).ok())?);
                }
                [b"BOX", b"BOUNDS", ..] if with_box => cell = Some(DumpBox::read(&mut self.lines)?),
                [b"BOX", b"BOUNDS", ..] => {
                    for _ in 0..3 {
                        self.lines.advance()?;
                    }
                }
                [what, ..] if *what == label || *what == b"ATOMS" || *what == b"ENTRIES" => {
                    self.check_kind(what)?;
                    let Some(count) = count else {
                        let found = format!(
                            "the rows begin, but no 'ITEM: NUMBER OF {}' came before them",
                            self.rows.name().to_ascii_uppercase()
                        );
                        return Err(self.lines.error(found, "write the file again"));
                    };
                    let column_line = self.lines.line().to_vec();
                    return Ok(Some(DumpHead { count, step, time, cell, column_line }));
                }
                _ => {
                    let warning = format!("passed over '{}', which is not known in dumps", shown(self.lines.line()));
                    self.warn(warning);
                    self.pass_over_section()?;
                }
            }
        }
    }

    /// The box with its periodic directions; `None`, with a warning, where it is turned.
    pub(crate) fn domain(&mut self, cell: &DumpBox) -> Result<Option<Domain>, IoError> {
        if !cell.flagged() {
            self.warn("the file does not say which directions are periodic: none is taken to be".into());
        }
        match cell.domain() {
            Ok(domain) => Ok(Some(domain)),
            Err(BoxFault::Turned { periodic }) => {
                let mut warning =
                    "the box's edges do not start along x and in the plane of x and y, as they do in restricted \
                     triclinic boxes: read without a box"
                        .to_string();
                if periodic {
                    warning.push_str("; particles at a periodic boundary are not continued on the other side");
                }
                self.warn(warning);
                Ok(None)
            }
            Err(BoxFault::Empty(reason)) => Err(self.lines.error(reason, "the box is wrong: write the file again")),
        }
    }

    /// Refuses contacts given as particles, and the other way round.
    fn check_kind(&self, label: &[u8]) -> Result<(), IoError> {
        match (self.rows, label == b"ATOMS") {
            (DumpRows::Atoms, false) => {
                let found = "this is a dump local (contacts or other entries), not particles";
                Err(self.lines.error(found, "give a dump custom with positions as the particles"))
            }
            (DumpRows::Entries, true) => {
                let found = "this is a dump of particles, not of contacts";
                Err(self.lines.error(found, "give a dump local of pairs or walls as the contacts"))
            }
            _ => Ok(()),
        }
    }

    fn pass_over_section(&mut self) -> Result<(), IoError> {
        while self.lines.advance()? {
            if self.lines.line().starts_with(b"ITEM:") {
                self.lines.stay();
                break;
            }
        }
        Ok(())
    }

    /// The single word in the next line.
    fn value<T>(&mut self, what: &str, parse: impl Fn(&[u8]) -> Option<T>) -> Result<T, IoError> {
        if !self.lines.advance()? {
            let found = format!("the file ends where {what} is expected");
            return Err(self.lines.error(found, "the file is cut, or still being written"));
        }
        let mut found = words(self.lines.line());
        match (found.next().and_then(parse), found.next()) {
            (Some(value), None) => Ok(value),
            _ => {
                let found = format!("'{}' stands where {what} is expected", shown(self.lines.line()));
                Err(self.lines.error(found, "write the file again"))
            }
        }
    }

    /// Passes over the rows of a frame.
    pub(crate) fn pass_rows(&mut self, count: u64) -> Result<(), IoError> {
        let mut index = 0;
        while index < count {
            let block = self.take_rows(index, count)?;
            index += block.len();
            self.lines.reuse(block);
        }
        self.frame += 1;
        Ok(())
    }

    /// Takes rows of a frame from row `index` of `count` on: at least one.
    pub(crate) fn take_rows(&mut self, index: u64, count: u64) -> Result<LineBlock, IoError> {
        // No column begins with a capital I that a number could be confused with: only a new section does.
        let block = self.lines.take_lines(count - index, b"ITEM:")?;
        if !block.is_empty() {
            return Ok(block);
        }
        if !self.lines.advance()? {
            return Err(self.truncated(index, count));
        }
        let (frame, rows) = (self.frame, self.rows.name());
        let found = format!("frame {frame} has {index} rows, but its number of {rows} is {count}");
        Err(self.lines.error(found, "the program that wrote it was stopped: remove the incomplete frame"))
    }

    pub(crate) fn truncated(&self, index: u64, count: u64) -> IoError {
        let found = format!("the file ends after {index} of the {count} {} of frame {}", self.rows.name(), self.frame);
        self.lines.error(found, "the file is cut, or still being written; earlier frames can be read")
    }
}
