//! Binary arrays of VTK XML files: length headers, compressed blocks, base64.
//!
//! An uncompressed array is its length in bytes, then the bytes. A compressed one is: number of blocks, bytes
//! in a whole block, bytes in the last block where that is not whole (else 0), compressed bytes of each block;
//! then the blocks. In base64 the header of a compressed array is encoded by itself, with its own padding,
//! and the blocks together after it; the length of an uncompressed one is encoded in one go with the data.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine;
use base64::alphabet;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

/// Decodes what any writer makes: padding may be missing.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Memory that the LZMA decoder may take: level 9 needs 65 MiB, a damaged header may ask for 4 GiB.
const LZMA_MEMORY: u64 = 128 << 20;

/// Compression of a file's binary arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compressor {
    None,
    Zlib,
    Lz4,
    Lzma,
}

/// How a file stores binary arrays.
#[derive(Debug, Clone, Copy)]
pub(super) struct Codec {
    /// Headers are 64 bits wide, else 32.
    pub wide_header: bool,
    pub big_endian: bool,
    pub compressor: Compressor,
}

/// Bytes that are taken group by group, as they were encoded.
trait Groups {
    /// The first `n` bytes, and whether the encoding ends right after them; consumes nothing.
    fn peek(&self, n: usize) -> Result<(Vec<u8>, bool), String>;
    /// The next `n` bytes, encoded together.
    fn group(&mut self, n: usize) -> Result<Cow<'_, [u8]>, String>;
}

struct Raw<'a>(&'a [u8]);

impl Groups for Raw<'_> {
    fn peek(&self, n: usize) -> Result<(Vec<u8>, bool), String> {
        let bytes = self.0.get(..n).ok_or_else(|| short(n, self.0.len()))?;
        Ok((bytes.to_vec(), true))
    }

    fn group(&mut self, n: usize) -> Result<Cow<'_, [u8]>, String> {
        let (head, rest) = self.0.split_at_checked(n).ok_or_else(|| short(n, self.0.len()))?;
        self.0 = rest;
        Ok(Cow::Borrowed(head))
    }
}

struct Base64<'a>(&'a [u8]);

impl Base64<'_> {
    /// The encoded characters of `n` bytes without white space, and where they end.
    fn characters(&self, n: usize) -> Result<(Cow<'_, [u8]>, usize), String> {
        let wanted = n.div_ceil(3).saturating_mul(4);
        if let Some(direct) = self.0.get(..wanted)
            && !direct.iter().any(u8::is_ascii_whitespace)
        {
            return Ok((Cow::Borrowed(direct), wanted));
        }
        // Some writers break lines, and some leave the padding out at the end.
        let mut kept = Vec::new();
        for (k, &byte) in self.0.iter().enumerate() {
            if !byte.is_ascii_whitespace() {
                kept.push(byte);
                if kept.len() == wanted {
                    return Ok((Cow::Owned(kept), k + 1));
                }
            }
        }
        if kept.len() < (n.saturating_mul(4)).div_ceil(3) {
            return Err(short(n, kept.len() / 4 * 3));
        }
        Ok((Cow::Owned(kept), self.0.len()))
    }

    fn decode(&self, n: usize) -> Result<(Vec<u8>, usize), String> {
        let (characters, end) = self.characters(n)?;
        let bytes = BASE64.decode(&characters[..]).map_err(|e| format!("this is no base64: {e}"))?;
        Ok((bytes, end))
    }
}

impl Groups for Base64<'_> {
    fn peek(&self, n: usize) -> Result<(Vec<u8>, bool), String> {
        let (characters, _) = self.characters(n)?;
        let ends = characters.ends_with(b"=");
        let mut bytes = self.decode(n)?.0;
        if bytes.len() < n {
            return Err(short(n, bytes.len()));
        }
        bytes.truncate(n);
        Ok((bytes, ends))
    }

    fn group(&mut self, n: usize) -> Result<Cow<'_, [u8]>, String> {
        let (mut bytes, end) = self.decode(n)?;
        if bytes.len() < n {
            return Err(short(n, bytes.len()));
        }
        bytes.truncate(n);
        self.0 = &self.0[end..];
        Ok(Cow::Owned(bytes))
    }
}

fn short(wanted: usize, available: usize) -> String {
    format!("{wanted} bytes are announced, but {available} follow")
}

impl Codec {
    /// The array that starts at `bytes`.
    pub fn read_raw(&self, bytes: &[u8]) -> Result<Vec<u8>, String> {
        self.read(Raw(bytes))
    }

    /// The array whose base64 text starts at `text`.
    pub fn read_base64(&self, text: &[u8]) -> Result<Vec<u8>, String> {
        self.read(Base64(text.trim_ascii_start()))
    }

    fn width(&self) -> usize {
        if self.wide_header { 8 } else { 4 }
    }

    fn number(&self, header: &[u8], index: usize) -> Result<usize, String> {
        let width = self.width();
        let mut word = [0; 8];
        let bytes = &header[index * width..(index + 1) * width];
        if self.big_endian {
            word[8 - width..].copy_from_slice(bytes);
            word.reverse();
        } else {
            word[..width].copy_from_slice(bytes);
        }
        usize::try_from(u64::from_le_bytes(word)).map_err(|_| "a length does not fit this computer".into())
    }

    fn read(&self, mut input: impl Groups) -> Result<Vec<u8>, String> {
        let width = self.width();
        let (start, ends) = input.peek(width)?;
        let first = self.number(&start, 0)?;
        if self.compressor == Compressor::None {
            let whole = first.checked_add(width).ok_or_else(|| short(first, 0))?;
            if ends {
                // The length stands by itself: always so in raw data, and in the base64 of some writers.
                input.group(width)?;
                return Ok(input.group(first)?.into_owned());
            }
            let mut bytes = input.group(whole)?.into_owned();
            bytes.drain(..width);
            return Ok(bytes);
        }
        if first == 0 {
            return Ok(Vec::new());
        }
        let entries = first.checked_add(3).and_then(|n| n.checked_mul(width)).ok_or_else(|| short(first, 0))?;
        let header = input.group(entries)?.into_owned();
        let (block, last) = (self.number(&header, 1)?, self.number(&header, 2)?);
        let mut sizes = Vec::with_capacity(first);
        let mut total = 0_usize;
        for k in 0..first {
            let size = self.number(&header, 3 + k)?;
            total = total.checked_add(size).ok_or_else(|| short(size, 0))?;
            sizes.push(size);
        }
        let data = input.group(total)?;
        let mut out = Vec::new();
        let mut at = 0;
        for (k, &size) in sizes.iter().enumerate() {
            let expected = if k + 1 == first && last != 0 { last } else { block };
            self.decompress(&data[at..at + size], expected, &mut out)
                .map_err(|e| format!("compressed block {k} of {first}: {e}"))?;
            at += size;
        }
        Ok(out)
    }

    /// Appends the block's `expected` bytes. Memory grows with what is really decoded: a header is no proof.
    fn decompress(&self, block: &[u8], expected: usize, out: &mut Vec<u8>) -> Result<(), String> {
        let before = out.len();
        let limit = expected as u64;
        match self.compressor {
            Compressor::None => out.extend_from_slice(block),
            Compressor::Zlib => {
                let mut decoder = flate2::read::ZlibDecoder::new(block).take(limit);
                decoder.read_to_end(out).map_err(|e| format!("zlib: {e}"))?;
            }
            Compressor::Lz4 => {
                // One compressed byte stands for 255 at most.
                if expected / 255 > block.len() {
                    return Err(format!("lz4: {} bytes cannot hold {expected}", block.len()));
                }
                out.resize(before + expected, 0);
                let n = lz4_flex::block::decompress_into(block, &mut out[before..]).map_err(|e| format!("lz4: {e}"))?;
                out.truncate(before + n);
            }
            Compressor::Lzma => {
                let stream =
                    liblzma::stream::Stream::new_stream_decoder(LZMA_MEMORY, 0).map_err(|e| format!("lzma: {e}"))?;
                let mut decoder = liblzma::bufread::XzDecoder::new_stream(block, stream).take(limit);
                decoder.read_to_end(out).map_err(|e| format!("lzma: {e}"))?;
            }
        }
        let found = out.len() - before;
        if found == expected { Ok(()) } else { Err(format!("{found} bytes instead of {expected}")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Codec = Codec { wide_header: false, big_endian: false, compressor: Compressor::None };

    #[test]
    fn base64_is_read_in_one_go_or_with_the_length_encoded_by_itself() {
        // Length 3, then 1 2 3: together, and apart with padding between.
        assert_eq!(PLAIN.read_base64(b"AwAAAAECAw==").unwrap(), [1, 2, 3]);
        assert_eq!(PLAIN.read_base64(b"\n  AwAAAA==AQID  \n").unwrap(), [1, 2, 3]);
        assert_eq!(PLAIN.read_base64(b"AwAAA\n AECAw").unwrap(), [1, 2, 3]);
    }

    #[test]
    fn a_length_beyond_the_end_is_an_error_and_allocates_nothing() {
        let codec = Codec { wide_header: true, ..PLAIN };
        assert!(codec.read_raw(&[255; 16]).unwrap_err().contains("announced"));
        for compressor in [Compressor::Zlib, Compressor::Lz4, Compressor::Lzma] {
            let codec = Codec { compressor, ..codec };
            assert!(codec.read_raw(&[255; 64]).is_err());
            assert!(codec.read_base64(&[b'/'; 64]).is_err());
        }
    }

    #[test]
    fn a_compressed_array_of_no_block_is_empty() {
        let codec = Codec { compressor: Compressor::Zlib, ..PLAIN };
        assert_eq!(codec.read_raw(&[0; 4]).unwrap(), []);
        assert_eq!(codec.read_base64(b"AAAAAA==").unwrap(), []);
    }

    #[test]
    fn an_lz4_header_that_promises_too_much_is_refused_before_memory_is_taken() {
        let codec = Codec { compressor: Compressor::Lz4, ..PLAIN };
        let mut bytes = Vec::new();
        for n in [1_u32, 0xffff_fff0, 0, 4] {
            bytes.extend(n.to_le_bytes());
        }
        bytes.extend([0; 4]);
        assert!(codec.read_raw(&bytes).unwrap_err().contains("cannot hold"));
    }
}
