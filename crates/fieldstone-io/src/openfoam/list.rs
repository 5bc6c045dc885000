//! Lists: `N(…)`, `N{value}`, `(…)`, and raw bytes in binary files.

use crate::IoError;

use super::header::Encoding;
use super::stream::Stream;

/// The label −1 that stands for "no cell".
pub(super) const NO_LABEL: u32 = u32::MAX;

/// What is wrong with a list's entry, and what to do; the reader adds the place.
#[derive(Debug)]
pub(super) struct Complaint {
    pub found: String,
    pub remedy: String,
}

/// An entry of a list.
pub(super) trait Item: Sized + Copy {
    /// Plural, as messages say it.
    const NAME: &'static str;
    fn from_text(stream: &mut Stream) -> Result<Self, IoError>;
    fn size(encoding: &Encoding) -> usize;
    /// From exactly [`Item::size`] bytes.
    fn from_bytes(bytes: &[u8], encoding: &Encoding) -> Result<Self, Complaint>;
}

fn label(value: i64) -> Result<u32, Complaint> {
    match u32::try_from(value) {
        Ok(v) if v != NO_LABEL => Ok(v),
        _ if value == -1 => Ok(NO_LABEL),
        _ => Err(Complaint {
            found: format!("the label {value} is out of range"),
            remedy: format!(
                "labels run from 0 to {}; the file is damaged, or its width of labels is not what the header says",
                NO_LABEL - 1
            ),
        }),
    }
}

impl Item for u32 {
    const NAME: &'static str = "labels";

    fn from_text(stream: &mut Stream) -> Result<Self, IoError> {
        stream.skip_blank();
        let start = stream.at;
        let value = stream.integer()?;
        label(value).map_err(|c| stream.error_at(start, c.found, c.remedy))
    }

    fn size(encoding: &Encoding) -> usize {
        encoding.label
    }

    fn from_bytes(bytes: &[u8], encoding: &Encoding) -> Result<Self, Complaint> {
        let mut wide = [0; 8];
        wide[..bytes.len()].copy_from_slice(bytes);
        if encoding.big_endian {
            wide[..bytes.len()].reverse();
        }
        let value = i64::from_le_bytes(wide);
        label(if bytes.len() == 4 { (value as i32).into() } else { value })
    }
}

fn scalar(bytes: &[u8], encoding: &Encoding) -> f64 {
    let mut wide = [0; 8];
    wide[..bytes.len()].copy_from_slice(bytes);
    if encoding.big_endian {
        wide[..bytes.len()].reverse();
    }
    let bits = u64::from_le_bytes(wide);
    if bytes.len() == 4 { f32::from_bits(bits as u32).into() } else { f64::from_bits(bits) }
}

impl Item for f64 {
    const NAME: &'static str = "scalars";

    fn from_text(stream: &mut Stream) -> Result<Self, IoError> {
        stream.scalar()
    }

    fn size(encoding: &Encoding) -> usize {
        encoding.scalar
    }

    fn from_bytes(bytes: &[u8], encoding: &Encoding) -> Result<Self, Complaint> {
        Ok(scalar(bytes, encoding))
    }
}

impl<const N: usize> Item for [f64; N] {
    const NAME: &'static str = if N == 3 { "vectors" } else { "tensors" };

    fn from_text(stream: &mut Stream) -> Result<Self, IoError> {
        let place = if N == 3 { "a vector" } else { "a tensor" };
        stream.expect(b'(', place)?;
        let mut value = [0.0; N];
        for v in &mut value {
            *v = stream.scalar()?;
        }
        stream.expect(b')', place)?;
        Ok(value)
    }

    fn size(encoding: &Encoding) -> usize {
        N * encoding.scalar
    }

    fn from_bytes(bytes: &[u8], encoding: &Encoding) -> Result<Self, Complaint> {
        let mut value = [0.0; N];
        for (v, b) in value.iter_mut().zip(bytes.chunks_exact(encoding.scalar)) {
            *v = scalar(b, encoding);
        }
        Ok(value)
    }
}

/// The part of a list in front of its entries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ListStart {
    /// `N(`, or `(` without a count; entries follow up to `)`.
    Entries(Option<usize>),
    /// `N(` in a binary file; raw bytes follow.
    Raw(usize),
    /// `N{`; one value for all follows, then `}`.
    Uniform(usize),
    /// `0`, with nothing between parentheses or no parentheses at all.
    Empty,
}

impl Stream {
    /// Reads the start of a list; `raw` says whether entries of its kind are stored as bytes in a binary file.
    pub(super) fn list_start(&mut self, what: &str, raw: bool) -> Result<ListStart, IoError> {
        if self.accept(b'(') {
            return Ok(ListStart::Entries(None));
        }
        if !self.peek().is_some_and(|b| b.is_ascii_digit() || b == b'-') {
            return Err(self.unexpected(&format!("the number of {what}")));
        }
        let count = self.count(&format!("the number of {what}"))?;
        match self.peek() {
            Some(b'(') => {
                self.at += 1;
                if count == 0 {
                    self.expect(b')', "an empty list")?;
                    return Ok(ListStart::Empty);
                }
                Ok(if raw && self.encoding().binary { ListStart::Raw(count) } else { ListStart::Entries(Some(count)) })
            }
            Some(b'{') => {
                self.at += 1;
                Ok(ListStart::Uniform(count))
            }
            _ if count == 0 => Ok(ListStart::Empty),
            _ => Err(self.unexpected(&format!("'(' behind the number of {what}"))),
        }
    }

    /// Whether another entry follows in a text list of which `read` entries are read; consumes the closing `)`.
    pub(super) fn more_entries(&mut self, what: &str, read: usize, count: Option<usize>) -> Result<bool, IoError> {
        let closed = self.peek() == Some(b')');
        match count {
            Some(n) if closed && read < n => Err(self.error(
                format!("the list of {what} announces {n} entries but holds {read}"),
                "correct the count, or write the file again: entries are missing",
            )),
            Some(n) if !closed && read == n && !self.rest().is_empty() => Err(self.error(
                format!("the list of {what} announces {n} entries but holds more"),
                "correct the count, or write the file again",
            )),
            _ if self.rest().is_empty() => Err(self.error(
                match count {
                    Some(n) => format!("the file ends after {read} of {n} entries in the list of {what}"),
                    None => format!("the file ends after {read} entries in the list of {what}"),
                },
                "the file is cut off; copy or write it again",
            )),
            _ => {
                self.at += usize::from(closed);
                Ok(!closed)
            }
        }
    }

    /// Passes over `count` raw entries of `size` bytes and the `)` behind them; returns where they begin.
    pub(super) fn raw_block(&mut self, count: usize, size: usize, what: &str) -> Result<usize, IoError> {
        let start = self.at;
        self.raw_from.get_or_insert(start);
        let available = self.rest().len();
        let Some(length) = count.checked_mul(size).filter(|&n| n < available) else {
            return Err(self.error(
                format!("the list of {what} announces {count} entries of {size} bytes, but {available} bytes are left"),
                "the file is cut off, its count is wrong, or the header's arch entry states other widths than were written",
            ));
        };
        self.at += length;
        if self.rest().first() != Some(&b')') {
            return Err(
                self.unexpected(&format!("')' behind {count} raw entries of {size} bytes in the list of {what}"))
            );
        }
        self.at += 1;
        Ok(start)
    }

    /// Hands each entry of a list to `take`, with its index; returns how many there were.
    ///
    /// A list `N{value}` costs no bytes, so that its `N` proves nothing: above `uniform_limit` it is refused.
    pub(super) fn each<T: Item>(
        &mut self,
        what: &str,
        uniform_limit: usize,
        mut take: impl FnMut(usize, T) -> Result<(), Complaint>,
    ) -> Result<usize, IoError> {
        match self.list_start(what, true)? {
            ListStart::Empty => Ok(0),
            ListStart::Raw(count) => {
                let encoding = self.encoding();
                let size = T::size(&encoding);
                let start = self.raw_block(count, size, what)?;
                for (k, bytes) in self.bytes[start..start + count * size].chunks_exact(size).enumerate() {
                    T::from_bytes(bytes, &encoding)
                        .and_then(|item| take(k, item))
                        .map_err(|c| self.error_at(start + k * size, c.found, c.remedy))?;
                }
                Ok(count)
            }
            ListStart::Uniform(count) => {
                let start = self.at;
                let item = T::from_text(self)?;
                self.expect(b'}', "a uniform list")?;
                if count > uniform_limit {
                    return Err(self.error_at(
                        start,
                        format!("the list of {what} states one value for {count} {}, but at most {uniform_limit} make sense here", T::NAME),
                        "the files may come from different meshes, or the count is damaged",
                    ));
                }
                for k in 0..count {
                    take(k, item).map_err(|c| self.error_at(start, c.found, c.remedy))?;
                }
                Ok(count)
            }
            ListStart::Entries(count) => {
                let mut read = 0;
                while self.more_entries(what, read, count)? {
                    let start = self.at;
                    let item = T::from_text(self)?;
                    take(read, item).map_err(|c| self.error_at(start, c.found, c.remedy))?;
                    read += 1;
                }
                Ok(read)
            }
        }
    }

    /// A list's entries.
    pub(super) fn list<T: Item>(&mut self, what: &str, uniform_limit: usize) -> Result<Vec<T>, IoError> {
        let mut items = Vec::new();
        self.each(what, uniform_limit, |_, item: T| {
            items.push(item);
            Ok(())
        })?;
        Ok(items)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stream(header: &str, body: &[u8]) -> Stream {
        let mut bytes = format!("FoamFile {{ {header} class x; }}\n").into_bytes();
        bytes.extend_from_slice(body);
        Stream::from_bytes("f", bytes).unwrap()
    }

    fn labels(body: &str) -> Result<Vec<u32>, String> {
        stream("format ascii;", body.as_bytes()).list("cells", 10).map_err(|e| e.to_string())
    }

    #[test]
    fn lists_are_read_in_every_text_form() {
        assert_eq!(labels("3(4 5 -1)").unwrap(), [4, 5, NO_LABEL]);
        assert_eq!(labels(" 3 // three\n ( 4 /* ( */ 5\n6 )").unwrap(), [4, 5, 6]);
        assert_eq!(labels("(7 8)").unwrap(), [7, 8]);
        assert_eq!(labels("4{9}").unwrap(), [9; 4]);
        assert_eq!(labels("0()").unwrap(), [0; 0]);
        assert_eq!(labels("0;").unwrap(), [0; 0]);
    }

    #[test]
    fn a_wrong_count_is_named_with_what_is_there() {
        assert!(labels("3(4 5)").unwrap_err().contains("announces 3 entries but holds 2"));
        assert!(labels("1(4 5)").unwrap_err().contains("announces 1 entries but holds more"));
        assert!(labels("3(4 5").unwrap_err().contains("ends after 2 of 3"));
        assert!(labels("-3(4 5)").unwrap_err().contains("is -3"));
        assert!(labels("99999999999999999999(4)").unwrap_err().contains("expected a whole number"));
    }

    #[test]
    fn a_huge_uniform_list_is_refused_before_memory_is_taken() {
        assert!(labels("4000000000000{1}").unwrap_err().contains("one value for 4000000000000 labels"));
    }

    #[test]
    fn a_huge_raw_count_is_refused_before_memory_is_taken() {
        for count in ["4000000000", "9223372036854775807"] {
            let mut s = stream("format binary;", format!("{count}(abcd)").as_bytes());
            let e = s.list::<u32>("cells", 0).unwrap_err().to_string();
            assert!(e.contains("but 5 bytes are left") && e.starts_with("f: byte "), "{e}");
        }
    }

    #[test]
    fn raw_numbers_have_the_width_and_byte_order_of_the_header() {
        let little = stream("format binary;", b"2(\x01\0\0\0\xff\xff\xff\xff)").list::<u32>("x", 0).unwrap();
        assert_eq!(little, [1, NO_LABEL]);
        let wide = "format binary; arch \"LSB;label=64;scalar=32\";";
        assert_eq!(stream(wide, b"1(\x02\x01\0\0\0\0\0\0)").list::<u32>("x", 0).unwrap(), [258]);
        assert_eq!(stream(wide, b"1(\0\0\xc0\x3f)").list::<f64>("x", 0).unwrap(), [1.5]);
        let big = "format binary; arch \"MSB;label=32;scalar=64\";";
        assert_eq!(stream(big, b"1(\0\0\x01\x02)").list::<u32>("x", 0).unwrap(), [258]);
        let mut body = b"1(".to_vec();
        for v in [1.5_f64, -2.0, 0.1] {
            body.extend(v.to_be_bytes());
        }
        body.push(b')');
        assert_eq!(stream(big, &body).list::<[f64; 3]>("x", 0).unwrap(), [[1.5, -2.0, 0.1]]);
    }

    #[test]
    fn raw_bytes_that_look_like_text_are_not_taken_for_it() {
        let mut s = stream("format binary;", b"1(\n//)) 1( ;}x)");
        assert_eq!(s.list::<u32>("x", 0).unwrap(), [u32::from_le_bytes(*b"\n//)")]);
        assert_eq!(s.list::<u32>("x", 0).unwrap(), [u32::from_le_bytes(*b" ;}x")]);
        let mut s = stream("format binary;", b"2(//()\n;\0\0) tail");
        assert_eq!(s.list::<u32>("x", 0).unwrap(), [u32::from_le_bytes(*b"//()"), u32::from_le_bytes(*b"\n;\0\0")]);
        assert_eq!(s.word().unwrap(), "tail");
    }

    #[test]
    fn an_entry_with_raw_bytes_is_passed_over_whole() {
        let mut s = stream("format binary;", b"a List<label> 1\n(;;}});b { c \"}\"; d (1 2); } e;");
        assert_eq!(s.word().unwrap(), "a");
        s.skip_value().unwrap();
        assert_eq!(s.word().unwrap(), "b");
        s.skip_value().unwrap();
        assert_eq!(s.word().unwrap(), "e");
    }
}
