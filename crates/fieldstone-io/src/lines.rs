//! Text files line by line, and the numbers in a line.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use crate::{IoError, Position, source};

/// A line longer than this is no line of numbers: without a bound, a binary file would be read whole.
const LONGEST_LINE: u64 = 1 << 24;

/// Lines of a text file, compressed or not, with their numbers.
pub(crate) struct LineReader {
    path: PathBuf,
    stream: BufReader<Box<dyn Read + Send>>,
    line: Vec<u8>,
    number: u64,
    complete: bool,
    again: bool,
}

impl LineReader {
    pub(crate) fn open(path: &Path) -> Result<Self, IoError> {
        let stream = source::open(path)?;
        Ok(Self { path: path.into(), stream, line: Vec::new(), number: 0, complete: true, again: false })
    }

    /// Goes to the next line; `false` at the end of the file, where the current line is empty.
    pub(crate) fn advance(&mut self) -> Result<bool, IoError> {
        if std::mem::take(&mut self.again) {
            return Ok(true);
        }
        self.line.clear();
        let read = self.stream.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut self.line);
        let length = read.map_err(|source| IoError::System { path: self.path.clone(), action: "read", source })? as u64;
        if length == 0 {
            return Ok(false);
        }
        self.number += 1;
        self.complete = self.line.last() == Some(&b'\n');
        if !self.complete && length == LONGEST_LINE {
            return Err(self.error("the line is longer than 16 MiB", "this is no text file of particles"));
        }
        while matches!(self.line.last(), Some(b'\n' | b'\r')) {
            self.line.pop();
        }
        if self.number == 1 && self.line.starts_with(b"\xef\xbb\xbf") {
            self.line.drain(..3);
        }
        Ok(true)
    }

    /// Makes the next [`LineReader::advance`] stay where it is.
    pub(crate) fn stay(&mut self) {
        self.again = true;
    }

    /// The current line without its end.
    pub(crate) fn line(&self) -> &[u8] {
        &self.line
    }

    /// Number of the current line, from 1.
    pub(crate) fn number(&self) -> u64 {
        self.number
    }

    /// Whether the current line has a line end: the last one of a file that was cut has none.
    pub(crate) fn complete(&self) -> bool {
        self.complete
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// An error at the current line.
    pub(crate) fn error(&self, found: impl Into<String>, remedy: impl Into<String>) -> IoError {
        // An empty file has no line to point at.
        let position = if self.number == 0 { Position::File } else { Position::Line(self.number) };
        IoError::content(&self.path, position, found, remedy)
    }
}

/// Index of the first byte at or after `at` that is no blank.
#[inline]
pub(crate) fn skip_blanks(line: &[u8], mut at: usize) -> usize {
    while at < line.len() && line[at].is_ascii_whitespace() {
        at += 1;
    }
    at
}

/// Words of a line.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// A word as text for names and messages.
pub(crate) fn text(word: &[u8]) -> String {
    String::from_utf8_lossy(word).into_owned()
}

/// A word as text that is safe to print: shortened, with control characters escaped.
pub(crate) fn shown(word: &[u8]) -> String {
    let mut all = String::from_utf8_lossy(word).chars().flat_map(char::escape_debug).collect::<String>();
    if let Some((cut, _)) = all.char_indices().nth(40) {
        all.truncate(cut);
        all.push('…');
    }
    all
}

/// The whole word as a number; `nan` and `inf` count as numbers.
#[inline]
pub(crate) fn number(word: &[u8]) -> Option<f64> {
    fast_float2::parse(word).ok()
}

/// The whole word as an integer. Some writers print ids through a float format, so `12.0` and `1e3` are
/// integers too, up to 2⁵³ where floats stop telling integers apart.
#[inline]
pub(crate) fn integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    if !digits.is_empty() && digits.len() <= 18 && digits.iter().all(u8::is_ascii_digit) {
        let size = digits.iter().fold(0i64, |sum, digit| 10 * sum + i64::from(digit - b'0'));
        return Some(if negative { -size } else { size });
    }
    if let Some(exact) = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok()) {
        return Some(exact);
    }
    let value = number(word)?;
    (value.fract() == 0.0 && value.abs() <= 9_007_199_254_740_992.0).then_some(value as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_exact_up_to_the_last_of_64_bits() {
        assert_eq!(integer(b"9223372036854775807"), Some(i64::MAX));
        assert_eq!(integer(b"-9223372036854775808"), Some(i64::MIN));
        assert_eq!(integer(b"9223372036854775808"), None);
        assert_eq!(integer(b"-12"), Some(-12));
        assert_eq!(integer(b"+7"), Some(7));
    }

    #[test]
    fn integers_printed_as_floats_are_integers_and_other_floats_are_not() {
        assert_eq!(integer(b"12.0"), Some(12));
        assert_eq!(integer(b"1e3"), Some(1000));
        for bad in ["", "-", "1.5", "nan", "inf", "1e300", "one", "1x"] {
            assert_eq!(integer(bad.as_bytes()), None, "{bad}");
        }
    }

    #[test]
    fn a_long_or_odd_word_is_shortened_and_escaped_in_messages() {
        assert_eq!(shown(b"a\tb\x00"), "a\\tb\\0");
        assert_eq!(shown(&[b'x'; 100]).chars().count(), 41);
    }
}
