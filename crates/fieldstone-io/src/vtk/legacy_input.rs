//! Lines, words and big-endian numbers of a legacy VTK file, read from front to back.

use std::io::{BufRead, Read};

use super::fault::{DAMAGED, Fault, Parsed};
use super::scalar::{Scalar, word};
use crate::{Position, Values};

/// Longest keyword line, and longest number in a text file.
const LINE: u64 = 1 << 14;
const WORD: usize = 128;

/// Room taken before numbers arrive: a count in a damaged file is no reason to allocate.
const FIRST_ROOM: usize = 1 << 16;

/// The stream and how far it is read.
pub(super) struct LegacyInput<R> {
    stream: R,
    line: u64,
    byte: u64,
    /// Numbers are big-endian bytes, not text.
    pub binary: bool,
}

impl<R: BufRead> LegacyInput<R> {
    pub fn new(stream: R) -> Self {
        Self { stream, line: 0, byte: 0, binary: false }
    }

    /// The place read last: a line of a text file, a byte of a binary one.
    pub fn position(&self) -> Position {
        if self.binary { Position::Byte(self.byte) } else { Position::Line(self.line.max(1)) }
    }

    pub fn fault(&self, found: impl Into<String>) -> Fault {
        Fault::damaged(self.position(), found)
    }

    fn system(&self, error: &std::io::Error) -> Fault {
        Fault::new(self.position(), format!("reading stopped: {error}"), DAMAGED)
    }

    /// The next line without its end; `None` at the end of the file.
    pub fn line(&mut self) -> Parsed<Option<String>> {
        let mut bytes = Vec::new();
        let read = self.stream.by_ref().take(LINE).read_until(b'\n', &mut bytes);
        let count = read.map_err(|e| self.system(&e))? as u64;
        if count == 0 {
            return Ok(None);
        }
        self.byte += count;
        self.line += 1;
        if count == LINE && !bytes.ends_with(b"\n") {
            return Err(self.fault(format!("a line of more than {LINE} bytes stands where a keyword should")));
        }
        Ok(Some(String::from_utf8_lossy(bytes.trim_ascii()).into_owned()))
    }

    /// The next line that is not blank.
    pub fn filled_line(&mut self) -> Parsed<Option<String>> {
        loop {
            match self.line()? {
                Some(line) if line.is_empty() => {}
                other => return Ok(other),
            }
        }
    }

    /// The next filled line's words; `what` should stand there.
    pub fn expect(&mut self, what: &str) -> Parsed<Vec<String>> {
        let line = self.filled_line()?.ok_or_else(|| self.fault(format!("the file ends before {what}")))?;
        Ok(line.split_ascii_whitespace().map(str::to_owned).collect())
    }

    /// `count` numbers, written as text or bytes.
    pub fn numbers(&mut self, scalar: Scalar, count: usize) -> Parsed<Values> {
        if self.binary {
            let size = count
                .checked_mul(scalar.size())
                .ok_or_else(|| self.fault(format!("{count} numbers are more than any file holds")))?;
            return Ok(scalar.decode(&self.bytes(size)?, true));
        }
        // Words are kept in one buffer with their ends: no allocation per number.
        let (mut text, mut ends) = (Vec::with_capacity(count.min(FIRST_ROOM) * 8), Vec::new());
        // First word of each line, to name the line of a word that is no number.
        let mut lines: Vec<(usize, u64)> = Vec::new();
        for k in 0..count {
            self.word(&mut text)?;
            let empty = text.len() == ends.last().copied().unwrap_or(0);
            if empty {
                return Err(self.fault(format!("the file ends after {k} of {count} numbers")));
            }
            ends.push(text.len());
            if lines.last().is_none_or(|&(_, line)| line != self.line) {
                lines.push((k, self.line));
            }
        }
        let starts = std::iter::once(0).chain(ends.iter().copied());
        let words = starts.zip(&ends).map(|(a, &b)| &text[a..b]);
        scalar.parse(words).map_err(|(k, bad)| {
            let line = lines.iter().rev().find(|&&(first, _)| first <= k).map_or(self.line, |&(_, line)| line);
            // The end of the word's own line is not read yet.
            let position = Position::Line(line + 1);
            Fault::damaged(position, format!("'{bad}' (number {k} of {count}) is no number of its type"))
        })
    }

    /// The next `count` bytes.
    pub fn bytes(&mut self, count: usize) -> Parsed<Vec<u8>> {
        let mut bytes = Vec::with_capacity(count.min(FIRST_ROOM));
        let read = self.stream.by_ref().take(count as u64).read_to_end(&mut bytes);
        read.map_err(|e| self.system(&e))?;
        self.byte += bytes.len() as u64;
        if bytes.len() < count {
            return Err(self.fault(format!("the file ends after {} of {count} bytes", bytes.len())));
        }
        Ok(bytes)
    }

    /// Appends the next word to `text`; nothing at the end of the file. What ends the word stays unread.
    fn word(&mut self, text: &mut Vec<u8>) -> Parsed<()> {
        let start = text.len();
        loop {
            let buffer = match self.stream.fill_buf() {
                Ok(buffer) => buffer,
                Err(e) => return Err(self.system(&e)),
            };
            if buffer.is_empty() {
                return Ok(());
            }
            let blank = if text.len() > start {
                0
            } else {
                let n = buffer.iter().take_while(|b| b.is_ascii_whitespace()).count();
                self.line += buffer[..n].iter().filter(|&&b| b == b'\n').count() as u64;
                n
            };
            let rest = &buffer[blank..];
            let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
            text.extend_from_slice(&rest[..length.min(WORD)]);
            let ended = length < rest.len();
            self.stream.consume(blank + length);
            self.byte += (blank + length) as u64;
            if text.len() - start >= WORD {
                let shown = word(&text[start..]);
                return Err(self.fault(format!("'{shown}…' stands where a number should")));
            }
            if ended {
                return Ok(());
            }
        }
    }

    /// Passes over `count` texts: lines in text files, strings behind their packed length in binary ones.
    pub fn skip_strings(&mut self, count: usize) -> Parsed<()> {
        for _ in 0..count {
            if !self.binary {
                self.line()?.ok_or_else(|| self.fault("the file ends within a list of texts"))?;
                continue;
            }
            // The two upper bits of the first byte say how many bytes the length takes.
            let first = self.bytes(1)?[0];
            let more = match first >> 6 {
                3 => 0,
                2 => 1,
                1 => 3,
                _ => 7,
            };
            let length = self.bytes(more)?.iter().fold(u64::from(first & 0x3f), |n, &b| n << 8 | u64::from(b));
            let length = usize::try_from(length).map_err(|_| self.fault("a text is too long"))?;
            self.skip_bytes(length)?;
        }
        Ok(())
    }

    /// Passes over bytes without holding them.
    pub fn skip_bytes(&mut self, count: usize) -> Parsed<()> {
        let copied = std::io::copy(&mut self.stream.by_ref().take(count as u64), &mut std::io::sink());
        let copied = copied.map_err(|e| self.system(&e))?;
        self.byte += copied;
        if copied < count as u64 {
            return Err(self.fault(format!("the file ends after {copied} of {count} bytes")));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_may_run_across_buffer_ends_and_lines_are_counted() {
        let text: &[u8] = b"title\n1.25\n\n 2.5 -3e2\nNEXT\n";
        for capacity in 1..8 {
            let mut input = LegacyInput::new(std::io::BufReader::with_capacity(capacity, text));
            assert_eq!(input.line().unwrap().unwrap(), "title");
            assert_eq!(input.numbers(Scalar::F64, 3).unwrap(), Values::F64(vec![1.25, 2.5, -300.0]));
            assert_eq!(input.filled_line().unwrap().unwrap(), "NEXT");
            assert_eq!(input.position(), Position::Line(5));
        }
    }

    #[test]
    fn a_count_beyond_the_file_is_an_error_and_allocates_little() {
        for binary in [false, true] {
            let mut input = LegacyInput::new(&b"1 2 3 4"[..]);
            input.binary = binary;
            assert!(input.numbers(Scalar::F64, usize::MAX / 8).unwrap_err().found.contains("ends after"));
        }
    }

    #[test]
    fn binary_texts_are_passed_over_by_their_packed_length() {
        let mut file = b"\xc1x\xc2yy\x80\x46".to_vec();
        file.extend([b'z'; 0x46]);
        file.push(b'!');
        let mut input = LegacyInput::new(&file[..]);
        input.binary = true;
        input.skip_strings(3).unwrap();
        assert_eq!(input.bytes(1).unwrap(), b"!");
    }
}
