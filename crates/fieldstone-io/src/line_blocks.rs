//! Blocks of whole lines, parsed on several threads.

use std::path::Path;

use memchr::{memchr, memchr_iter, memrchr};
use rayon::prelude::*;

use crate::{IoError, Position};

/// Bytes that one task parses: enough to be worth a task, few enough for a nearby cache.
const PART: usize = 1 << 17;

/// Lines of a file that follow each other.
#[derive(Debug, Default)]
pub(crate) struct LineBlock {
    bytes: Vec<u8>,
    /// Number of the first line, from 1.
    first: u64,
    count: u64,
}

/// One line of a block.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line<'a> {
    /// The line without its end.
    pub(crate) bytes: &'a [u8],
    /// Where it stands.
    pub(crate) place: LinePlace,
}

/// Where a line stands, without its content.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinePlace {
    /// Its number, from 1.
    pub(crate) number: u64,
    /// Whether it has a line end: the last one of a file that was cut has none.
    pub(crate) complete: bool,
}

impl LinePlace {
    /// An error at this line.
    pub(crate) fn error(self, path: &Path, found: impl Into<String>, remedy: impl Into<String>) -> IoError {
        IoError::content(path, Position::Line(self.number), found, remedy)
    }
}

/// Some lines of a block, one after the other.
#[derive(Debug, Clone)]
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    number: u64,
    left: usize,
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    #[inline]
    fn next(&mut self) -> Option<Line<'a>> {
        if self.rest.is_empty() {
            return None;
        }
        let end = memchr(b'\n', self.rest);
        let (line, rest) = match end {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &self.rest[..0]),
        };
        let bare = line.iter().rposition(|&b| b != b'\r').map_or(0, |last| last + 1);
        let place = LinePlace { number: self.number, complete: end.is_some() };
        let line = Line { bytes: &line[..bare], place };
        self.rest = rest;
        self.number += 1;
        self.left = self.left.saturating_sub(1);
        Some(line)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left, Some(self.left))
    }
}

impl LineBlock {
    /// The lines in `bytes`, of which the first has this number.
    pub(crate) fn new(bytes: Vec<u8>, first: u64) -> Self {
        let unfinished = bytes.last().is_some_and(|&b| b != b'\n');
        let count = memchr_iter(b'\n', &bytes).count() as u64 + u64::from(unfinished);
        Self { bytes, first, count }
    }

    /// Number of lines.
    pub(crate) fn len(&self) -> u64 {
        self.count
    }

    /// Whether there is no line: the file ends, or what the lines were taken up to comes next.
    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether the last line has a line end.
    pub(crate) fn complete(&self) -> bool {
        self.bytes.last().is_none_or(|&b| b == b'\n')
    }

    /// The memory, to be used again.
    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// The first line.
    pub(crate) fn first_line(&self) -> Option<Line<'_>> {
        Lines { rest: &self.bytes, number: self.first, left: 1 }.next()
    }

    /// The last line.
    pub(crate) fn last_line(&self) -> Option<Line<'_>> {
        let number = self.first + self.count.checked_sub(1)?;
        let before_end = self.bytes.strip_suffix(b"\n").unwrap_or(&self.bytes);
        let start = memrchr(b'\n', before_end).map_or(0, |end| end + 1);
        Lines { rest: &self.bytes[start..], number, left: 1 }.next()
    }

    /// What `parse` makes of parts of the block, in their order; where parts fail, the error of the first of them.
    ///
    /// # Errors
    /// Those of `parse`: the same one for any number of threads.
    pub(crate) fn parse<T: Send, E: Send>(
        &self,
        parse: impl Fn(Lines<'_>) -> Result<T, E> + Sync + Send,
    ) -> Result<Vec<T>, E> {
        let mut parts = Vec::with_capacity(self.bytes.len() / PART + 1);
        let mut rest = &self.bytes[..];
        while !rest.is_empty() {
            let from = rest.len().min(PART);
            let end = memchr(b'\n', &rest[from..]).map_or(rest.len(), |end| from + end + 1);
            let (part, more) = rest.split_at(end);
            parts.push(part);
            rest = more;
        }
        let counts: Vec<usize> = parts.par_iter().map(|part| memchr_iter(b'\n', part).count()).collect();
        let mut number = self.first;
        let lines: Vec<Lines<'_>> = (parts.iter().zip(&counts))
            .map(|(part, &count)| {
                let lines = Lines { rest: part, number, left: count };
                number += count as u64;
                lines
            })
            .collect();
        // Collected before it is looked at: which of two errors comes first must not depend on the threads.
        lines.into_par_iter().map(parse).collect::<Vec<_>>().into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_numbered_and_in_order_however_the_block_is_cut_into_parts() {
        // Lines of very different lengths, some longer than a part, the last without an end.
        let mut text = String::new();
        for k in 0..3000usize {
            text += &format!("{k} {}{}", "x".repeat(k * k % 700), if k % 3 == 0 { "\r\n" } else { "\n" });
        }
        text += &"y".repeat(3 * PART);
        text += "\nlast";
        let block = LineBlock::new(text.clone().into_bytes(), 5);
        let parts = block
            .parse(|lines| {
                Ok::<_, IoError>(
                    lines.map(|l| (l.place.number, l.place.complete, l.bytes.to_vec())).collect::<Vec<_>>(),
                )
            })
            .unwrap();
        assert!(parts.len() > 4, "{}", parts.len());
        let found: Vec<(u64, bool, Vec<u8>)> = parts.into_iter().flatten().collect();
        let expected: Vec<(u64, bool, Vec<u8>)> = text
            .lines()
            .enumerate()
            .map(|(k, line)| (k as u64 + 5, line != "last", line.as_bytes().to_vec()))
            .collect();
        assert_eq!(found, expected);
        assert_eq!(block.len(), found.len() as u64);
        assert!(!block.complete());
    }

    #[test]
    fn of_several_faults_the_first_in_the_file_is_reported() {
        let mut text = "1\n".repeat(PART);
        text += "bad\n";
        text += &"1\n".repeat(PART);
        text += "worse\n";
        let block = LineBlock::new(text.into_bytes(), 1);
        let error = block
            .parse(|mut lines| match lines.find(|line| line.bytes != b"1") {
                Some(line) => Err(line.place.error(Path::new("numbers"), "a word", "give numbers")),
                None => Ok(()),
            })
            .unwrap_err();
        assert!(error.to_string().starts_with(&format!("numbers:{}", PART + 1)), "{error}");
    }
}
