//! Sections and numbers of a Gmsh file, text or binary alike.

use std::path::{Path, PathBuf};

use crate::{IoError, Position};

/// How numbers are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Binary {
    big_endian: bool,
    /// Bytes of a `size_t`.
    size: usize,
}

/// A file's content and the place reached in it.
#[derive(Debug)]
pub(super) struct Input {
    path: PathBuf,
    bytes: Vec<u8>,
    pub at: usize,
    binary: Option<Binary>,
    /// Whether the file has raw numbers, so that lines mean nothing.
    raw: bool,
}

impl Input {
    pub(super) fn new(path: &Path, bytes: Vec<u8>) -> Self {
        Self { path: path.into(), bytes, at: 0, binary: None, raw: false }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn is_binary(&self) -> bool {
        self.binary.is_some()
    }

    fn rest(&self) -> &[u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    /// An error at the place reached.
    pub(super) fn error(&self, found: impl Into<String>, remedy: impl Into<String>) -> IoError {
        self.error_at(self.at, found, remedy)
    }

    pub(super) fn error_at(&self, at: usize, found: impl Into<String>, remedy: impl Into<String>) -> IoError {
        let position = if self.raw {
            Position::Byte(at as u64)
        } else {
            let before = &self.bytes[..at.min(self.bytes.len())];
            Position::Line(1 + before.iter().filter(|&&b| b == b'\n').count() as u64)
        };
        IoError::content(&self.path, position, found, remedy)
    }

    /// The place of the next number; in text, behind the white space in front of it.
    pub(super) fn start(&mut self) -> usize {
        if self.binary.is_none() {
            let rest = self.rest();
            self.at += rest.len() - rest.trim_ascii_start().len();
        }
        self.at
    }

    fn unexpected(&self, expected: &str) -> IoError {
        let rest = self.rest().trim_ascii_start();
        let token = rest.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        if rest.is_empty() {
            return self.error(
                format!("expected {expected}, found the end of the file"),
                "the file is cut off; copy or save it again",
            );
        }
        let token = token[..token.len().min(40)].escape_ascii().to_string();
        self.error(format!("expected {expected}, found '{token}'"), "the file is damaged; save the mesh again")
    }

    /// Moves behind the next `$Name` line and returns the name; `None` at the end of the file.
    pub(super) fn next_section(&mut self) -> Result<Option<String>, IoError> {
        let rest = self.rest();
        self.at += rest.len() - rest.trim_ascii_start().len();
        if self.rest().is_empty() {
            return Ok(None);
        }
        let start = self.at;
        let line = self.line();
        let name = line.strip_prefix(b"$").and_then(|n| std::str::from_utf8(n).ok()).map(str::to_owned);
        match name {
            Some(name) if !name.is_empty() && !name.starts_with("End") => Ok(Some(name)),
            _ => {
                self.at = start;
                Err(self.unexpected("the start of a section, '$Name'"))
            }
        }
    }

    /// The rest of the line without the white space around it; consumed with its end.
    fn line(&mut self) -> &[u8] {
        let start = self.at;
        let rest = &self.bytes[start.min(self.bytes.len())..];
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        rest[..length].trim_ascii()
    }

    /// Consumes the `$EndName` line that must come next.
    pub(super) fn end_section(&mut self, name: &str) -> Result<(), IoError> {
        let start = self.at;
        let rest = self.rest();
        self.at += rest.len() - rest.trim_ascii_start().len();
        let end = format!("$End{name}");
        if self.line() == end.as_bytes() {
            return Ok(());
        }
        self.at = start;
        Err(self.unexpected(&format!("{end} behind the entries that the section announces")))
    }

    /// Moves behind the `$EndName` line, wherever it is.
    pub(super) fn skip_section(&mut self, name: &str) -> Result<(), IoError> {
        let end = format!("$End{name}");
        match self.rest().windows(end.len()).position(|w| w == end.as_bytes()) {
            Some(found) => {
                self.at += found;
                self.line();
                Ok(())
            }
            None => {
                Err(self.error(format!("section ${name} has no {end}"), "the file is cut off; copy or save it again"))
            }
        }
    }

    /// Reads the number 1 behind the format line of a binary file, which tells the byte order, and switches to binary.
    pub(super) fn start_binary(&mut self, size: usize) -> Result<(), IoError> {
        self.line();
        let big_endian = match self.rest().get(..4) {
            Some([1, 0, 0, 0]) => false,
            Some([0, 0, 0, 1]) => true,
            _ => {
                return Err(self.error(
                    "the number 1 that tells the byte order of a binary file is missing",
                    "the file is damaged, perhaps by a transfer in text mode; copy or save it again",
                ));
            }
        };
        self.raw = true;
        self.at += 4;
        self.binary = Some(Binary { big_endian, size });
        Ok(())
    }

    /// Reads numbers as text from here on; returns what [`Input::restore`] takes.
    pub(super) fn set_text(&mut self) -> Option<Binary> {
        self.binary.take()
    }

    pub(super) fn restore(&mut self, binary: Option<Binary>) {
        self.binary = binary;
    }

    /// Passes over the rest of a text line; where raw numbers follow, they start behind it.
    pub(super) fn end_line(&mut self) {
        self.line();
    }

    fn raw<const N: usize>(&mut self) -> Result<[u8; N], IoError> {
        let Some(bytes) = self.rest().first_chunk::<N>() else {
            return Err(self.error("the file ends within a number", "the file is cut off; copy or save it again"));
        };
        let mut bytes = *bytes;
        self.at += N;
        if self.binary.is_some_and(|b| b.big_endian) {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn token(&mut self) -> &[u8] {
        self.start();
        let rest = self.rest();
        &rest[..rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len())]
    }

    fn text_integer(&mut self) -> Result<i64, IoError> {
        let token = self.token();
        let length = token.len();
        match std::str::from_utf8(token).ok().and_then(|t| t.parse().ok()) {
            Some(value) => {
                self.at += length;
                Ok(value)
            }
            None => Err(self.unexpected("a whole number")),
        }
    }

    /// A C `int`.
    pub(super) fn integer(&mut self) -> Result<i64, IoError> {
        match self.binary {
            Some(_) => Ok(i32::from_le_bytes(self.raw()?).into()),
            None => self.text_integer(),
        }
    }

    /// A C `size_t`.
    pub(super) fn size(&mut self) -> Result<i64, IoError> {
        match self.binary {
            Some(Binary { size: 4, .. }) => Ok(u32::from_le_bytes(self.raw()?).into()),
            // Above 2⁶³ it is no size but damage, and stays negative.
            Some(_) => Ok(i64::from_le_bytes(self.raw()?)),
            None => self.text_integer(),
        }
    }

    /// A C `double`.
    pub(super) fn real(&mut self) -> Result<f64, IoError> {
        if self.binary.is_some() {
            return Ok(f64::from_le_bytes(self.raw()?));
        }
        let token = self.token();
        let length = token.len();
        match fast_float2::parse(token) {
            Ok(value) => {
                self.at += length;
                Ok(value)
            }
            Err(_) => Err(self.unexpected("a number")),
        }
    }

    /// A number of things, each of which takes at least one byte of the file.
    fn checked_count(&self, start: usize, value: i64, what: &str) -> Result<usize, IoError> {
        let available = self.rest().len();
        usize::try_from(value).ok().filter(|&n| n <= available).ok_or_else(|| {
            self.error_at(
                start,
                format!("the file announces {value} {what}, but {available} bytes are left"),
                "the file is cut off or its count is damaged; copy or save it again",
            )
        })
    }

    /// A count stored as `int`.
    pub(super) fn count(&mut self, what: &str) -> Result<usize, IoError> {
        let start = self.start();
        let value = self.integer()?;
        self.checked_count(start, value, what)
    }

    /// A count stored as `size_t`.
    pub(super) fn size_count(&mut self, what: &str) -> Result<usize, IoError> {
        let start = self.start();
        let value = self.size()?;
        self.checked_count(start, value, what)
    }

    /// A name in quotation marks.
    pub(super) fn quoted(&mut self) -> Result<String, IoError> {
        let start = self.at;
        let line = self.line();
        match line.strip_prefix(b"\"").and_then(|n| n.strip_suffix(b"\"")) {
            Some(name) => Ok(String::from_utf8_lossy(name).into_owned()),
            None => {
                self.at = start;
                Err(self.unexpected("a name in quotation marks"))
            }
        }
    }
}
