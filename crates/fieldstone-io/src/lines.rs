//! Text files line by line or block by block, and the numbers in a line.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use memchr::{memchr, memchr_iter, memmem};

use crate::line_blocks::LineBlock;
use crate::{IoError, Position, source};

/// A line longer than this is no line of numbers: without a bound, a binary file would be read whole.
const LONGEST_LINE: u64 = 1 << 24;
/// Bytes of a block of lines: some tasks for each thread.
const BLOCK: u64 = 1 << 22;

/// Lines of a text file, compressed or not, with their numbers.
pub(crate) struct LineReader {
    path: PathBuf,
    stream: BufReader<Box<dyn Read + Send>>,
    /// Whole lines that have been read and not yet been taken: from `at` on.
    ahead: Vec<u8>,
    at: usize,
    /// Memory of a block, to be used again.
    spare: Vec<u8>,
    line: Vec<u8>,
    number: u64,
    complete: bool,
    again: bool,
}

impl LineReader {
    pub(crate) fn open(path: &Path) -> Result<Self, IoError> {
        let stream = source::open(path)?;
        Ok(Self {
            path: path.into(),
            stream,
            ahead: Vec::new(),
            at: 0,
            spare: Vec::new(),
            line: Vec::new(),
            number: 0,
            complete: true,
            again: false,
        })
    }

    /// Goes to the next line; `false` at the end of the file, where the current line is empty.
    pub(crate) fn advance(&mut self) -> Result<bool, IoError> {
        if std::mem::take(&mut self.again) {
            return Ok(true);
        }
        self.line.clear();
        let length = if self.at < self.ahead.len() {
            let rest = &self.ahead[self.at..];
            let end = memchr(b'\n', rest).map_or(rest.len(), |end| end + 1);
            self.line.extend_from_slice(&rest[..end]);
            self.at += end;
            end as u64
        } else {
            let read = self.stream.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut self.line);
            read.map_err(|source| IoError::System { path: self.path.clone(), action: "read", source })? as u64
        };
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

    /// Takes the next lines as a block: some megabytes, at most `most` lines, and none from the first on that begins
    /// with `stop` (where that is not empty). Empty at the end of the file.
    ///
    /// The current line is then the last of the block, without its content.
    pub(crate) fn take_lines(&mut self, most: u64, stop: &[u8]) -> Result<LineBlock, IoError> {
        debug_assert!(!self.again, "the current line would be lost");
        self.line.clear();
        if self.at == self.ahead.len() {
            self.read_ahead()?;
        }
        let rest = &self.ahead[self.at..];
        let most = usize::try_from(most).unwrap_or(usize::MAX);
        let end = match most.checked_sub(1) {
            Some(last) => memchr_iter(b'\n', rest).nth(last).map_or(rest.len(), |end| end + 1),
            None => 0,
        };
        let end = if stop.is_empty() { end } else { first_line_with(&rest[..end], stop).unwrap_or(end) };
        let mut spare = std::mem::take(&mut self.spare);
        spare.clear();
        let bytes = if self.at == 0 && end == rest.len() {
            std::mem::replace(&mut self.ahead, spare)
        } else {
            spare.extend_from_slice(&rest[..end]);
            self.at += end;
            spare
        };
        let block = LineBlock::new(bytes, self.number + 1);
        if !block.is_empty() {
            self.number += block.len();
            self.complete = block.complete();
        }
        Ok(block)
    }

    /// Gives the memory of a block back.
    pub(crate) fn reuse(&mut self, block: LineBlock) {
        self.spare = block.into_bytes();
    }

    /// Reads a block of whole lines.
    fn read_ahead(&mut self) -> Result<(), IoError> {
        self.ahead.clear();
        self.at = 0;
        let stream = self.stream.by_ref();
        let read = (stream.take(BLOCK).read_to_end(&mut self.ahead)).and_then(|read| match self.ahead.last() {
            // A block that is full ends within a line, most likely.
            Some(&last) if read as u64 == BLOCK && last != b'\n' => {
                stream.take(LONGEST_LINE).read_until(b'\n', &mut self.ahead)
            }
            _ => Ok(0),
        });
        let rest = read.map_err(|source| IoError::System { path: self.path.clone(), action: "read", source })?;
        if rest as u64 == LONGEST_LINE && self.ahead.last() != Some(&b'\n') {
            self.number += 1 + memchr_iter(b'\n', &self.ahead).count() as u64;
            return Err(self.error("the line is longer than 16 MiB", "this is no text file of particles"));
        }
        Ok(())
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

/// Where the first line begins that starts with `prefix`, blanks before it not counted.
fn first_line_with(lines: &[u8], prefix: &[u8]) -> Option<usize> {
    memmem::find_iter(lines, prefix).find_map(|at| {
        let start = memchr::memrchr(b'\n', &lines[..at]).map_or(0, |end| end + 1);
        lines[start..at].iter().all(u8::is_ascii_whitespace).then_some(start)
    })
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
    use crate::line_blocks::Lines;

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
    fn lines_taken_one_by_one_and_in_blocks_are_the_lines_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lines");
        // Some blocks, of frames that begin with a comment.
        let mut text = String::new();
        for frame in 0..40usize {
            text += &format!("  # frame {frame}\n");
            for row in 0..frame * 997 % 8000 {
                text += &format!("{row} {}\n", "1.25 ".repeat(row % 17));
            }
        }
        std::fs::write(&path, &text).unwrap();
        let mut lines = LineReader::open(&path).unwrap();
        let mut found = Vec::new();
        while lines.advance().unwrap() {
            assert_eq!(lines.number(), found.len() as u64 + 1);
            assert!(lines.line().starts_with(b"  #"));
            found.push(lines.line().to_vec());
            // Now few lines, now all.
            let most = if found.len() % 2 == 0 { 13 } else { u64::MAX };
            loop {
                let block = lines.take_lines(most, b"#").unwrap();
                if block.is_empty() {
                    break;
                }
                assert!(block.len() <= most);
                let whole =
                    |part: Lines<'_>| Ok::<_, IoError>(part.map(|line| line.bytes.to_vec()).collect::<Vec<_>>());
                block.parse(whole).unwrap().into_iter().for_each(|part| found.extend(part));
                lines.reuse(block);
            }
        }
        assert_eq!(found, text.lines().map(|line| line.as_bytes().to_vec()).collect::<Vec<_>>());
    }

    #[test]
    fn a_line_without_end_is_refused_in_blocks_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("binary");
        std::fs::write(&path, [b"1\n".as_slice(), &vec![b'x'; 24 << 20]].concat()).unwrap();
        let mut lines = LineReader::open(&path).unwrap();
        let error = lines.take_lines(u64::MAX, b"").unwrap_err().to_string();
        assert!(error.contains("binary:2") && error.contains("longer than 16 MiB"), "{error}");
    }

    #[test]
    fn a_long_or_odd_word_is_shortened_and_escaped_in_messages() {
        assert_eq!(shown(b"a\tb\x00"), "a\\tb\\0");
        assert_eq!(shown(&[b'x'; 100]).chars().count(), 41);
    }
}
