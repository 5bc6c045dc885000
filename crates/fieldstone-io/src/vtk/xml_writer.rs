//! The frame of VTK's XML files: header, pieces, arrays, appended data.

use std::fmt::Write as _;
use std::path::Path;

use quick_xml::escape::escape;

use super::encoding::{Column, VtkCompression, VtkEncoding, VtkFormat};
use super::symmetric_tensor;
use crate::{AtomicFile, DataArray, IoError, Position};

/// Columns that go into a VTK file beside the geometry.
///
/// ```
/// use fieldstone_io::{DataArray, vtk::VtkArrays};
/// let fraction = [DataArray::scalar("solid_fraction", vec![0.6, 0.58])];
/// let arrays = VtkArrays { cells: &fraction, time: Some(0.5), ..VtkArrays::default() };
/// assert_eq!(arrays.cells.len(), 1);
/// ```
#[derive(Debug, Clone, Copy, Default)]
pub struct VtkArrays<'a> {
    /// Columns on points.
    pub points: &'a [DataArray],
    /// Columns on cells.
    pub cells: &'a [DataArray],
    /// Time, written as the field data `TimeValue`.
    pub time: Option<f64>,
    /// Texts by name, written as field data: how the data were made, say.
    ///
    /// They are arrays of bytes, which every reader of VTK's files has numbers for; meshio refuses files with strings. The
    /// bytes are ASCII: other characters are written as TOML and JSON escape them, `\u03c1`.
    pub texts: &'a [(&'a str, &'a str)],
    /// Names of the components of columns, by the column's name; columns that are not listed have none.
    ///
    /// Symmetric tensors of the components xx xy xz yy yz zz are written in VTK's order, xx yy zz xy yz xz, and read back
    /// in that of memory.
    pub component_names: &'a [(&'a str, &'a [String])],
}

/// A piece of the appended data.
enum Appended<'a> {
    /// Encoded already.
    Bytes(Vec<u8>),
    /// To be written as it is.
    Raw(Column<'a>),
}

/// A file under construction: offsets of appended arrays must be known before they are written.
pub(super) struct XmlFile<'a> {
    path: &'a Path,
    encoding: VtkEncoding,
    text: String,
    appended: Vec<Appended<'a>>,
    /// Length of what has been appended.
    length: usize,
    kind: &'static str,
}

impl<'a> XmlFile<'a> {
    /// Starts a file of data set `kind`; `attributes` belong to its element.
    pub fn new(
        path: &'a Path,
        encoding: VtkEncoding,
        kind: &'static str,
        attributes: &str,
        arrays: &VtkArrays<'_>,
    ) -> Result<Self, IoError> {
        let text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\"{}>\n<{kind}{attributes}>\n",
            encoding.compressor_attribute()
        );
        let mut file = Self { path, encoding, text, appended: Vec::new(), length: 0, kind };
        if arrays.time.is_some() || !arrays.texts.is_empty() {
            file.open("FieldData", "");
            if let Some(time) = arrays.time {
                file.numbers("TimeValue", " NumberOfTuples=\"1\"", 1, Column::F64(&[time]), |_| None)?;
            }
            for (name, content) in arrays.texts {
                file.text(name, content);
            }
            file.close("FieldData");
        }
        Ok(file)
    }

    pub fn open(&mut self, name: &str, attributes: &str) {
        let _ = writeln!(self.text, "<{name}{attributes}>");
    }

    pub fn close(&mut self, name: &str) {
        let _ = writeln!(self.text, "</{name}>");
    }

    /// Adds a text as the codes of its bytes.
    fn text(&mut self, name: &str, content: &str) {
        let (name, content) = (escape(name), ascii(content));
        let count = content.len();
        let _ = writeln!(
            self.text,
            "<DataArray type=\"UInt8\" Name=\"{name}\" NumberOfTuples=\"{count}\" format=\"ascii\">"
        );
        for (k, byte) in content.bytes().enumerate() {
            let _ = write!(self.text, "{}{byte}", if k % 32 == 0 && k > 0 { "\n" } else { " " });
        }
        self.text.push_str("\n</DataArray>\n");
    }

    /// Adds an array.
    pub fn array(&mut self, name: &str, components: usize, column: Column<'a>) -> Result<(), IoError> {
        self.numbers(name, &format!(" NumberOfComponents=\"{components}\""), components, column, Some)
    }

    /// Adds an array; `keep` gives it back where it lives as long as the file does, and need not be copied.
    fn numbers<'c>(
        &mut self,
        name: &str,
        shape: &str,
        components: usize,
        column: Column<'c>,
        keep: impl Fn(Column<'c>) -> Option<Column<'a>>,
    ) -> Result<(), IoError> {
        let system = |source| IoError::System { path: self.path.into(), action: "write", source };
        let _ = write!(self.text, "<DataArray type=\"{}\" Name=\"{}\"{shape}", column.type_name(), escape(name));
        let compression = self.encoding.compression;
        match self.encoding.format {
            VtkFormat::Ascii => {
                self.text.push_str(" format=\"ascii\">\n");
                column.text(components, &mut self.text);
                self.text.push_str("</DataArray>\n");
            }
            VtkFormat::Inline => {
                self.text.push_str(" format=\"binary\">\n");
                for piece in column.encode(compression, true).map_err(system)? {
                    self.text.push_str(&String::from_utf8_lossy(&piece));
                }
                self.text.push_str("\n</DataArray>\n");
            }
            VtkFormat::AppendedBase64 | VtkFormat::AppendedRaw => {
                let _ = writeln!(self.text, " format=\"appended\" offset=\"{}\"/>", self.length);
                let base64 = self.encoding.format == VtkFormat::AppendedBase64;
                let plain = !base64 && compression == VtkCompression::None;
                if let Some(column) = keep(column).filter(|_| plain) {
                    self.length += column.raw_length();
                    self.appended.push(Appended::Raw(column));
                } else {
                    for piece in column.encode(compression, base64).map_err(system)? {
                        self.length += piece.len();
                        self.appended.push(Appended::Bytes(piece));
                    }
                }
            }
        }
        Ok(())
    }

    /// Adds `PointData` or `CellData`, each column checked to have `tuples` rows.
    pub fn columns(
        &mut self,
        element: &str,
        arrays: &'a [DataArray],
        tuples: usize,
        component_names: &[(&str, &[String])],
    ) -> Result<(), IoError> {
        self.open(element, "");
        for array in arrays {
            let column = Column::from(&array.values);
            if array.components == 0 || column.len() != tuples.saturating_mul(array.components) {
                let found = format!(
                    "column '{}' has {} numbers; {tuples} rows of {} are needed in {element}",
                    array.name,
                    column.len(),
                    array.components
                );
                return Err(IoError::content(
                    self.path,
                    Position::File,
                    found,
                    "give one row for each; nothing was written",
                ));
            }
            let mut shape = format!(" NumberOfComponents=\"{}\"", array.components);
            let names =
                component_names.iter().find(|(name, _)| *name == array.name).map_or(&[][..], |(_, names)| *names);
            let mut names: Vec<&str> = names.iter().map(String::as_str).collect();
            let symmetric =
                names.first_chunk().filter(|_| symmetric_tensor::is_symmetric(&names)).map(symmetric_tensor::to_file);
            if let Some(in_file) = symmetric {
                names = in_file.into();
            }
            for (k, name) in names.iter().enumerate().filter(|_| names.len() == array.components) {
                let _ = write!(shape, " ComponentName{k}=\"{}\"", escape(*name));
            }
            if symmetric.is_some() && array.components == 6 {
                let values = symmetric_tensor::values_to_file(&array.values);
                self.numbers(&array.name, &shape, array.components, Column::from(&values), |_| None)?;
            } else {
                self.numbers(&array.name, &shape, array.components, column, Some)?;
            }
        }
        self.close(element);
        Ok(())
    }

    /// Completes the file and gives it its name.
    pub fn finish(mut self) -> Result<(), IoError> {
        self.close(self.kind);
        let base64 = match self.encoding.format {
            VtkFormat::AppendedBase64 => Some("base64"),
            VtkFormat::AppendedRaw => Some("raw"),
            VtkFormat::Ascii | VtkFormat::Inline => None,
        };
        AtomicFile::write(self.path, |out| {
            out.write_all(self.text.as_bytes())?;
            if let Some(encoding) = base64 {
                write!(out, "<AppendedData encoding=\"{encoding}\">\n_")?;
                for piece in &self.appended {
                    match piece {
                        Appended::Bytes(bytes) => out.write_all(bytes)?,
                        Appended::Raw(column) => column.write_raw(out)?,
                    }
                }
                out.write_all(b"\n</AppendedData>\n")?;
            }
            out.write_all(b"</VTKFile>\n")
        })
    }
}

/// The text with all but ASCII escaped.
fn ascii(text: &str) -> String {
    let mut all = String::with_capacity(text.len());
    for c in text.chars() {
        match u32::from(c) {
            0..0x80 => all.push(c),
            code @ ..0x1_0000 => {
                let _ = write!(all, "\\u{code:04x}");
            }
            code => {
                let _ = write!(all, "\\U{code:08x}");
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_text_in_a_vtk_file_is_ascii() {
        assert_eq!(ascii("a = \"größe\" # ρ = 1 𝜌"), "a = \"gr\\u00f6\\u00dfe\" # \\u03c1 = 1 \\U0001d70c");
        let arrays = VtkArrays { texts: &[("made", "Σ m φ")], ..VtkArrays::default() };
        let file = XmlFile::new(Path::new("x"), VtkEncoding::TEXT, "PolyData", "", &arrays).unwrap();
        let text = file.text.split("format=\"ascii\">").nth(1).unwrap().split('<').next().unwrap();
        let codes: Vec<u32> = text.split_ascii_whitespace().map(|code| code.parse().unwrap()).collect();
        assert!(codes.len() > 1 && codes.iter().all(|&code| code < 128), "{codes:?}");
    }
}
