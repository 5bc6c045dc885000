//! The `FoamFile` dictionary that opens every file.

use crate::IoError;

use super::stream::Stream;

/// How the numbers of a file are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Encoding {
    pub binary: bool,
    pub big_endian: bool,
    /// Bytes of a label: 4 or 8.
    pub label: usize,
    /// Bytes of a scalar: 4 or 8.
    pub scalar: usize,
}

impl Default for Encoding {
    /// Text; and the widths that binary files without an `arch` entry (before OpenFOAM 2.3) have.
    fn default() -> Self {
        Self { binary: false, big_endian: false, label: 4, scalar: 8 }
    }
}

/// What a header says that readers need.
#[derive(Debug, Clone, Default)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub class: String,
}

impl Header {
    /// Reads the header at the stream's start.
    pub(super) fn read(stream: &mut Stream) -> Result<Self, IoError> {
        let not_foam = |s: &Stream, found: String| {
            s.error(
                format!("the file starts with {found} instead of a FoamFile header"),
                "give a file that OpenFOAM wrote; files without a header do not say whether they are text or binary",
            )
        };
        match stream.word() {
            Ok(w) if w == "FoamFile" => {}
            Ok(w) => return Err(not_foam(stream, format!("'{}'", w.chars().take(40).collect::<String>()))),
            Err(_) => return Err(not_foam(stream, stream.describe_next())),
        }
        stream.expect(b'{', "the FoamFile header")?;
        let mut header = Self::default();
        while !stream.accept(b'}') {
            let key = stream.word()?;
            if stream.peek() == Some(b'{') {
                stream.skip_value()?;
                continue;
            }
            match key.as_str() {
                "format" => {
                    let format = stream.word()?;
                    header.encoding.binary = match format.as_str() {
                        "ascii" => false,
                        "binary" => true,
                        other => {
                            return Err(stream.error(
                                format!("the header says 'format {other}'"),
                                "readable formats are ascii and binary; convert with foamFormatConvert",
                            ));
                        }
                    };
                }
                "class" => header.class = stream.word_or_string()?,
                "arch" => {
                    let arch = stream.word_or_string()?;
                    header.read_arch(&arch, stream)?;
                }
                _ => {}
            }
            stream.skip_value()?;
        }
        Ok(header)
    }

    /// Reads e.g. `LSB;label=32;scalar=64`.
    fn read_arch(&mut self, arch: &str, stream: &Stream) -> Result<(), IoError> {
        for part in arch.split(';').map(str::trim).filter(|p| !p.is_empty()) {
            match part {
                "LSB" => self.encoding.big_endian = false,
                "MSB" => self.encoding.big_endian = true,
                "label=32" => self.encoding.label = 4,
                "label=64" => self.encoding.label = 8,
                "scalar=32" => self.encoding.scalar = 4,
                "scalar=64" => self.encoding.scalar = 8,
                _ => {
                    return Err(stream.error(
                        format!("the header's arch entry holds '{part}'"),
                        "expected LSB or MSB, label=32 or label=64, scalar=32 or scalar=64",
                    ));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(text: &str) -> Result<Header, IoError> {
        Stream::from_bytes("case/file", text.as_bytes().to_vec()).map(|s| s.header().clone())
    }

    #[test]
    fn widths_and_byte_order_come_from_the_arch_entry() {
        let h = header("/* banner { */ FoamFile { version 2.0; format binary; arch \"MSB;label=64;scalar=32\"; class vectorField; }").unwrap();
        assert_eq!(h.encoding, Encoding { binary: true, big_endian: true, label: 8, scalar: 4 });
        assert_eq!(h.class, "vectorField");
    }

    #[test]
    fn a_nested_dictionary_in_the_header_is_passed_over() {
        let h = header("FoamFile\n{ meta { names (a b); } note \"a; b }\"; class labelList; }").unwrap();
        assert_eq!(h.class, "labelList");
        assert!(!h.encoding.binary);
    }

    #[test]
    fn a_file_without_header_is_refused_with_its_first_word() {
        let e = header("// comment\nsolid wall\n").unwrap_err().to_string();
        assert!(e.starts_with("case/file:2: the file starts with 'solid' instead of a FoamFile header"), "{e}");
    }

    #[test]
    fn an_unfinished_header_is_refused() {
        for text in ["", "FoamFile", "FoamFile {", "FoamFile { format ascii", "FoamFile { format ascii; note \"x"] {
            assert!(header(text).is_err(), "{text}");
        }
    }
}
