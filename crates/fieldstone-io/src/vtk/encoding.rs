//! How writers store arrays: text or bytes, compressed or not.

use std::fmt::Write as _;
use std::io::{Read, Write};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rayon::prelude::*;

use crate::Values;

/// Where a written file keeps its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VtkFormat {
    /// As text in each array, with as many digits as a number needs to be read back unchanged.
    Ascii,
    /// As base64 in each array.
    Inline,
    /// As base64 behind all arrays: what VTK and ParaView write unless told otherwise.
    #[default]
    AppendedBase64,
    /// As bytes behind all arrays: a quarter smaller than base64, but no valid XML.
    AppendedRaw,
}

/// Compression of a written file's numbers; text is never compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VtkCompression {
    /// None.
    None,
    /// zlib: read by everything.
    #[default]
    Zlib,
    /// LZ4: faster and larger; not read by meshio.
    Lz4,
    /// LZMA: slower and smaller.
    Lzma,
}

/// Order of a wedge's corners.
///
/// VTK 9.7 turned the wedge round: its first triangle, which used to be wound outwards, is wound inwards, as in
/// CGNS, Gmsh and most other formats. A file says nothing of it, so each side of the change finds negative
/// volumes in the other's wedges. Our readers take either.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VtkWedges {
    /// For VTK 9.7 and newer.
    #[default]
    SinceVtk97,
    /// For VTK up to 9.6, and for meshio.
    BeforeVtk97,
}

/// How a VTK file is written.
///
/// The default, appended base64 with zlib, is opened by VTK, ParaView, pyvista and meshio.
///
/// ```
/// use fieldstone_io::vtk::{VtkCompression, VtkEncoding, VtkFormat};
/// assert_eq!(VtkEncoding::default().compression, VtkCompression::Zlib);
/// assert_eq!(VtkEncoding::TEXT.format, VtkFormat::Ascii);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct VtkEncoding {
    /// Where the numbers are.
    pub format: VtkFormat,
    /// How they are compressed.
    pub compression: VtkCompression,
    /// How the corners of wedges are listed.
    pub wedges: VtkWedges,
}

impl VtkEncoding {
    /// Text, for the eye and for version control.
    pub const TEXT: Self =
        Self { format: VtkFormat::Ascii, compression: VtkCompression::None, wedges: VtkWedges::SinceVtk97 };

    /// The attribute that names the compressor; empty where there is none.
    pub(super) fn compressor_attribute(self) -> &'static str {
        match self.compression {
            _ if self.format == VtkFormat::Ascii => "",
            VtkCompression::None => "",
            VtkCompression::Zlib => " compressor=\"vtkZLibDataCompressor\"",
            VtkCompression::Lz4 => " compressor=\"vtkLZ4DataCompressor\"",
            VtkCompression::Lzma => " compressor=\"vtkLZMADataCompressor\"",
        }
    }
}

/// Bytes in a compressed block: small enough for caches, large enough to compress well.
const BLOCK: usize = 1 << 18;

/// Numbers on their way into a file.
#[derive(Debug, Clone, Copy)]
pub(super) enum Column<'a> {
    F64(&'a [f64]),
    F32(&'a [f32]),
    I64(&'a [i64]),
    U8(&'a [u8]),
}

impl<'a> From<&'a Values> for Column<'a> {
    fn from(values: &'a Values) -> Self {
        match values {
            Values::F64(v) => Self::F64(v),
            Values::F32(v) => Self::F32(v),
            Values::I64(v) => Self::I64(v),
            Values::U8(v) => Self::U8(v),
        }
    }
}

impl Column<'_> {
    pub fn type_name(self) -> &'static str {
        match self {
            Self::F64(_) => "Float64",
            Self::F32(_) => "Float32",
            Self::I64(_) => "Int64",
            Self::U8(_) => "UInt8",
        }
    }

    pub fn len(self) -> usize {
        match self {
            Self::F64(v) => v.len(),
            Self::F32(v) => v.len(),
            Self::I64(v) => v.len(),
            Self::U8(v) => v.len(),
        }
    }

    fn width(self) -> usize {
        match self {
            Self::F64(_) | Self::I64(_) => 8,
            Self::F32(_) => 4,
            Self::U8(_) => 1,
        }
    }

    /// Appends the little-endian bytes of the numbers `from..to`.
    fn bytes(self, from: usize, to: usize, out: &mut Vec<u8>) {
        match self {
            Self::F64(v) => append(v[from..to].iter().map(|x| x.to_le_bytes()), out),
            Self::F32(v) => append(v[from..to].iter().map(|x| x.to_le_bytes()), out),
            Self::I64(v) => append(v[from..to].iter().map(|x| x.to_le_bytes()), out),
            Self::U8(v) => out.extend_from_slice(&v[from..to]),
        }
    }

    /// Length of [`Column::write_raw`].
    pub fn raw_length(self) -> usize {
        8 + self.len() * self.width()
    }

    /// Writes length and data, without compression, and without a copy of them all.
    pub fn write_raw(self, out: &mut dyn Write) -> std::io::Result<()> {
        out.write_all(&((self.len() * self.width()) as u64).to_le_bytes())?;
        let step = BLOCK / self.width();
        let mut plain = Vec::with_capacity(BLOCK);
        for from in (0..self.len()).step_by(step) {
            plain.clear();
            self.bytes(from, (from + step).min(self.len()), &mut plain);
            out.write_all(&plain)?;
        }
        Ok(())
    }

    /// The numbers as text, `components` to a line; shortest forms that are read back unchanged.
    pub fn text(self, components: usize, out: &mut String) {
        let line = if components > 1 { components } else { 10 };
        for k in 0..self.len() {
            // Writing into a string cannot fail.
            let _ = match self {
                // VTK knows nan and inf in small letters only.
                Self::F64(v) if v[k].is_nan() => write!(out, "nan"),
                Self::F32(v) if v[k].is_nan() => write!(out, "nan"),
                Self::F64(v) => write!(out, "{:?}", v[k]),
                Self::F32(v) => write!(out, "{:?}", v[k]),
                Self::I64(v) => write!(out, "{}", v[k]),
                Self::U8(v) => write!(out, "{}", v[k]),
            };
            out.push(if (k + 1) % line == 0 || k + 1 == self.len() { '\n' } else { ' ' });
        }
    }

    /// Length header and data, compressed and, where asked for, in base64: pieces that follow each other.
    ///
    /// Blocks are compressed in parallel. Each is of a fixed size and by itself, so the bytes are the same for any number
    /// of threads.
    pub fn encode(self, compression: VtkCompression, base64: bool) -> std::io::Result<Vec<Vec<u8>>> {
        let size = self.len() * self.width();
        let mut header: Vec<u8> = Vec::new();
        let mut data = Vec::new();
        if compression == VtkCompression::None {
            header.extend((size as u64).to_le_bytes());
            // In one go with the data: base64 has no padding between the two.
            self.bytes(0, self.len(), &mut header);
        } else {
            let step = BLOCK / self.width();
            let starts: Vec<usize> = (0..self.len()).step_by(step).collect();
            let last = size % BLOCK;
            for number in [starts.len(), if starts.is_empty() { 0 } else { BLOCK }, last] {
                header.extend((number as u64).to_le_bytes());
            }
            data = starts
                .par_iter()
                .map_init(Vec::new, |plain, &from| {
                    plain.clear();
                    self.bytes(from, (from + step).min(self.len()), plain);
                    compress(plain, compression)
                })
                .collect::<std::io::Result<Vec<_>>>()?;
            data.iter().for_each(|block| header.extend((block.len() as u64).to_le_bytes()));
        }
        if base64 {
            return Ok(vec![STANDARD.encode(header).into_bytes(), STANDARD.encode(data.concat()).into_bytes()]);
        }
        data.insert(0, header);
        Ok(data)
    }
}

/// Appends the bytes of numbers of N bytes.
fn append<const N: usize>(numbers: impl ExactSizeIterator<Item = [u8; N]>, out: &mut Vec<u8>) {
    let start = out.len();
    // Into room that is there already: byte by byte this would be slower than the disk.
    out.resize(start + N * numbers.len(), 0);
    out[start..].as_chunks_mut().0.iter_mut().zip(numbers).for_each(|(to, number)| *to = number);
}

fn compress(block: &[u8], compression: VtkCompression) -> std::io::Result<Vec<u8>> {
    let mut out = Vec::new();
    match compression {
        VtkCompression::None => out.extend_from_slice(block),
        VtkCompression::Zlib => {
            // Level 4: on floating-point fields, higher ones cost time and save next to nothing.
            flate2::read::ZlibEncoder::new(block, flate2::Compression::new(4)).read_to_end(&mut out)?;
        }
        VtkCompression::Lz4 => out = lz4_flex::block::compress(block),
        VtkCompression::Lzma => {
            liblzma::read::XzEncoder::new(block, 5).read_to_end(&mut out)?;
        }
    }
    Ok(out)
}
