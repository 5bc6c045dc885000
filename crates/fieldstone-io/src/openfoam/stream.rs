//! Words, numbers and dictionaries of one OpenFOAM file; lists are in `list`.

use std::path::{Path, PathBuf};

use crate::{IoError, Position, source};

use super::header::{Encoding, Header};

/// A file's content and the place reached in it.
///
/// Nothing here trusts a count: memory grows with what the file really holds.
#[derive(Debug)]
pub(super) struct Stream {
    path: PathBuf,
    pub(super) bytes: Vec<u8>,
    pub(super) at: usize,
    /// Start of the first raw list: behind it, lines mean nothing and places are given in bytes.
    pub(super) raw_from: Option<usize>,
    header: Header,
}

impl Stream {
    /// Opens a file and reads its header.
    pub(super) fn open(path: &Path) -> Result<Self, IoError> {
        Self::from_bytes(path, source::read_all(path)?)
    }

    /// Takes a file's content and reads its header.
    pub(super) fn from_bytes(path: impl Into<PathBuf>, bytes: Vec<u8>) -> Result<Self, IoError> {
        let mut stream = Self { path: path.into(), bytes, at: 0, raw_from: None, header: Header::default() };
        stream.header = Header::read(&mut stream)?;
        Ok(stream)
    }

    pub(super) fn header(&self) -> &Header {
        &self.header
    }

    pub(super) fn encoding(&self) -> Encoding {
        self.header.encoding
    }

    /// Bytes that are left.
    pub(super) fn rest(&self) -> &[u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    /// An error at the next token.
    pub(super) fn error(&self, found: impl Into<String>, remedy: impl Into<String>) -> IoError {
        self.error_at(self.at, found, remedy)
    }

    /// An error at byte `at`, given as a line where lines have a meaning.
    pub(super) fn error_at(&self, at: usize, found: impl Into<String>, remedy: impl Into<String>) -> IoError {
        let position = if self.raw_from.is_some_and(|raw| at >= raw) {
            Position::Byte(at as u64)
        } else {
            let before = &self.bytes[..at.min(self.bytes.len())];
            Position::Line(1 + before.iter().filter(|&&b| b == b'\n').count() as u64)
        };
        IoError::content(&self.path, position, found, remedy)
    }

    /// The error for a token that does not belong where it stands.
    pub(super) fn unexpected(&self, expected: &str) -> IoError {
        let remedy = if self.rest().is_empty() {
            "the file is cut off; copy or write it again"
        } else {
            "the file is damaged, or written in a way that is not supported"
        };
        self.error(format!("expected {expected}, found {}", self.describe_next()), remedy)
    }

    /// The next token as messages show it.
    pub(super) fn describe_next(&self) -> String {
        let rest = self.rest();
        if rest.is_empty() {
            return "the end of the file".into();
        }
        let end = rest.iter().position(|&b| is_delimiter(b)).unwrap_or(rest.len()).clamp(1, 40);
        format!("'{}'", rest[..end.min(rest.len())].escape_ascii())
    }

    /// Moves to the next byte that is neither white space nor comment.
    pub(super) fn skip_blank(&mut self) {
        loop {
            let rest = self.rest();
            let blank = rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
            let comment = &rest[blank..];
            let length = if comment.starts_with(b"//") {
                comment.iter().position(|&b| b == b'\n').unwrap_or(comment.len())
            } else if comment.starts_with(b"/*") {
                // An unfinished comment swallows the rest, and the reader then meets the end of the file.
                comment.windows(2).skip(2).position(|w| w == b"*/").map_or(comment.len(), |p| p + 4)
            } else {
                0
            };
            self.at += blank + length;
            if length == 0 {
                return;
            }
        }
    }

    /// The next byte that is neither white space nor comment, not consumed.
    pub(super) fn peek(&mut self) -> Option<u8> {
        self.skip_blank();
        self.rest().first().copied()
    }

    /// Consumes the punctuation mark if it is next.
    pub(super) fn accept(&mut self, mark: u8) -> bool {
        let found = self.peek() == Some(mark);
        self.at += usize::from(found);
        found
    }

    /// Consumes the punctuation mark that must come next.
    pub(super) fn expect(&mut self, mark: u8, place: &str) -> Result<(), IoError> {
        if self.accept(mark) {
            return Ok(());
        }
        Err(self.unexpected(&format!("'{}' in {place}", char::from(mark))))
    }

    /// A word, such as `internalField`, `List<scalar>` or `div(phi,U)`.
    pub(super) fn word(&mut self) -> Result<String, IoError> {
        self.skip_blank();
        let rest = self.rest();
        let mut depth = 0_u32;
        let end = rest
            .iter()
            .enumerate()
            .position(|(k, &b)| match b {
                b'(' if k > 0 => {
                    depth += 1;
                    false
                }
                b')' if depth > 0 => {
                    depth -= 1;
                    false
                }
                b'/' => matches!(rest.get(k + 1), Some(b'/' | b'*')),
                b'(' | b')' | b'{' | b'}' | b'[' | b']' | b';' | b'"' => true,
                _ => b.is_ascii_whitespace(),
            })
            .unwrap_or(rest.len());
        match std::str::from_utf8(&rest[..end]) {
            Ok(word) if !word.is_empty() => {
                let word = word.to_owned();
                self.at += end;
                Ok(word)
            }
            _ => Err(self.unexpected("a word")),
        }
    }

    /// A word, or the content of a quoted string.
    pub(super) fn word_or_string(&mut self) -> Result<String, IoError> {
        if self.peek() != Some(b'"') {
            return self.word();
        }
        let start = self.at + 1;
        self.skip_string()?;
        Ok(String::from_utf8_lossy(&self.bytes[start..self.at - 1]).into_owned())
    }

    /// Passes over a quoted string.
    fn skip_string(&mut self) -> Result<(), IoError> {
        let mut escaped = false;
        let end = self.rest().iter().skip(1).position(|&b| {
            let closes = b == b'"' && !escaped;
            escaped = b == b'\\' && !escaped;
            closes
        });
        match end {
            Some(end) => {
                self.at += end + 2;
                Ok(())
            }
            None => Err(self.error(
                "a quoted string is not closed",
                "add the missing '\"', or copy the file again if it is cut off",
            )),
        }
    }

    /// Bytes of the number that comes next; may be empty or no number.
    fn number_token(&mut self) -> &[u8] {
        self.skip_blank();
        let rest = self.rest();
        let end = rest.iter().position(|&b| is_delimiter(b)).unwrap_or(rest.len());
        &rest[..end]
    }

    /// A whole number.
    pub(super) fn integer(&mut self) -> Result<i64, IoError> {
        let token = self.number_token();
        let length = token.len();
        match std::str::from_utf8(token).ok().and_then(|t| t.parse().ok()) {
            Some(value) => {
                self.at += length;
                Ok(value)
            }
            None => Err(self.unexpected("a whole number")),
        }
    }

    /// A number that counts something.
    pub(super) fn count(&mut self, what: &str) -> Result<usize, IoError> {
        self.skip_blank();
        let start = self.at;
        let value = self.integer()?;
        usize::try_from(value).map_err(|_| {
            self.error_at(start, format!("{what} is {value}"), "a count must not be negative: the file is damaged")
        })
    }

    /// A floating-point number; NaN and infinities included.
    pub(super) fn scalar(&mut self) -> Result<f64, IoError> {
        let token = self.number_token();
        let length = token.len();
        match fast_float2::parse::<f64, _>(token) {
            Ok(value) => {
                self.at += length;
                Ok(value)
            }
            Err(_) => Err(self.unexpected("a number")),
        }
    }

    /// Passes over a dictionary entry's value: up to its `;`, or over a whole sub-dictionary.
    pub(super) fn skip_value(&mut self) -> Result<(), IoError> {
        let dictionary = self.peek() == Some(b'{');
        let mut depth = 0_usize;
        loop {
            match self.peek() {
                None => return Err(self.unexpected("';' or '}' at the end of an entry")),
                Some(b';') if depth == 0 => {
                    self.at += 1;
                    return Ok(());
                }
                Some(b'"') => self.skip_string()?,
                Some(b'(' | b'{' | b'[') => {
                    depth += 1;
                    self.at += 1;
                }
                Some(b')' | b'}' | b']') if depth == 0 => return Err(self.unexpected("';' at the end of an entry")),
                Some(close @ (b')' | b'}' | b']')) => {
                    depth -= 1;
                    self.at += 1;
                    if depth == 0 && dictionary && close == b'}' {
                        return Ok(());
                    }
                }
                Some(_) => self.skip_token()?,
            }
        }
    }

    /// Passes over a word or number, and over the raw list that a word like `List<label>` announces.
    fn skip_token(&mut self) -> Result<(), IoError> {
        let e = self.header.encoding;
        let token = self.number_token();
        let length = token.len().max(1);
        let item = match token {
            b"List<label>" => e.label,
            b"List<scalar>" => e.scalar,
            b"List<vector>" => 3 * e.scalar,
            b"List<symmTensor>" => 6 * e.scalar,
            b"List<tensor>" => 9 * e.scalar,
            b"List<bool>" => 1,
            _ => 0,
        };
        self.at += length;
        if e.binary && item > 0 && self.peek().is_some_and(|b| b.is_ascii_digit()) {
            let count = self.count("the length of a list")?;
            if count > 0 && self.accept(b'(') {
                self.raw_block(count, item, "a list")?;
            }
        }
        Ok(())
    }
}

/// Whether a byte ends a number.
fn is_delimiter(b: u8) -> bool {
    b.is_ascii_whitespace() || matches!(b, b'(' | b')' | b'{' | b'}' | b'[' | b']' | b';' | b'"' | b',' | b'/')
}
