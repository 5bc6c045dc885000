//! VTK's XML files: `.vtu`, `.vtp` and `.vti`.

use super::blocks::{Codec, Compressor};
use super::cells::{Faces, PointRange, RawCells};
use super::data::{VtkData, VtkKind, points};
use super::fault::{Fault, Parsed};
use super::scalar::{Scalar, whole_numbers};
use super::symmetric_tensor;
use super::xml_image;
use super::xml_tree::{Appended, Element, parse};
use crate::{DataArray, Position, Values};

/// Turns the arrays of one file into numbers.
pub(super) struct Arrays<'a> {
    codec: Codec,
    appended: Option<Appended<'a>>,
}

/// Reads a whole file. Positions in faults are bytes, those inside the XML part are made lines.
pub(super) fn read(bytes: &[u8]) -> Parsed<VtkData> {
    read_bytes(bytes).map_err(|mut fault| {
        let xml_end = bytes.windows(13).position(|w| w == b"<AppendedData").unwrap_or(bytes.len());
        if let Position::Byte(at) = fault.position
            && (at as usize) <= xml_end
        {
            let lines = bytes[..at as usize].iter().filter(|&&b| b == b'\n').count();
            fault.position = Position::Line(lines as u64 + 1);
        }
        fault
    })
}

fn read_bytes(bytes: &[u8]) -> Parsed<VtkData> {
    let (root, appended) = parse(bytes)?;
    if root.name != "VTKFile" {
        return Err(root.fault(format!("the first element is <{}>, not <VTKFile>", root.name), "give a VTK file"));
    }
    let name = root.attribute("type").unwrap_or("");
    let kind = match name {
        "UnstructuredGrid" => VtkKind::UnstructuredGrid,
        "PolyData" => VtkKind::PolyData,
        "ImageData" => VtkKind::ImageData,
        _ => {
            let remedy = match name {
                "Collection" => "this is a list of files over time: give one of those that it names",
                _ if name.starts_with('P') => "this is a list of pieces: give the pieces that it names",
                _ => "UnstructuredGrid, PolyData and ImageData are readable; convert it with ParaView or pyvista",
            };
            return Err(root.fault(format!("the file holds '{name}'"), remedy));
        }
    };
    let arrays = Arrays { codec: codec(&root)?, appended };
    let set = root.child(name).ok_or_else(|| Fault::damaged(root.position(), format!("there is no <{name}>")))?;
    let mut data = VtkData::new(kind);
    if let Some(field) = set.child("FieldData").or_else(|| root.child("FieldData")) {
        data.field_data = arrays.collect(field, None, &mut data.skipped)?;
        data.find_time();
    }
    if kind == VtkKind::ImageData {
        xml_image::read(&arrays, set, &mut data)?;
        return Ok(data);
    }
    let (mut point_data, mut cell_data) = (Joined::default(), Joined::default());
    for piece in set.all("Piece") {
        let new = arrays.points(piece)?;
        let range = PointRange { first: data.points.len(), count: new.len() };
        if range.first + range.count >= u32::MAX as usize {
            return Err(piece.fault("more than 2³² points in all", "split the file"));
        }
        data.points.extend(new);
        let cells_before = data.cells.len();
        if kind == VtkKind::PolyData {
            arrays.polygons(piece, range, &mut data)?;
        } else {
            arrays.cells(piece, range, &mut data)?;
        }
        let cells = data.cells.len() - cells_before;
        point_data.add(arrays.columns(piece, "PointData", range.count, &mut data.skipped)?, range.count);
        cell_data.add(arrays.columns(piece, "CellData", cells, &mut data.skipped)?, cells);
    }
    data.point_data = point_data.finish(&mut data.skipped);
    data.cell_data = cell_data.finish(&mut data.skipped);
    Ok(data)
}

fn codec(root: &Element<'_>) -> Parsed<Codec> {
    let wide_header = match root.attribute("header_type") {
        None | Some("UInt32") => false,
        Some("UInt64") => true,
        Some(other) => return Err(root.fault(format!("header_type=\"{other}\""), "UInt32 and UInt64 are readable")),
    };
    let big_endian = match root.attribute("byte_order") {
        None | Some("LittleEndian") => false,
        Some("BigEndian") => true,
        Some(other) => {
            return Err(root.fault(format!("byte_order=\"{other}\""), "LittleEndian and BigEndian are readable"));
        }
    };
    let compressor = match root.attribute("compressor") {
        None | Some("") => Compressor::None,
        Some("vtkZLibDataCompressor") => Compressor::Zlib,
        Some("vtkLZ4DataCompressor") => Compressor::Lz4,
        Some("vtkLZMADataCompressor") => Compressor::Lzma,
        Some(other) => {
            return Err(root.fault(format!("compressor=\"{other}\""), "write the file with zlib, lz4 or lzma"));
        }
    };
    Ok(Codec { wide_header, big_endian, compressor })
}

impl Arrays<'_> {
    /// The numbers of one `<DataArray>`.
    pub fn values(&self, element: &Element<'_>) -> Parsed<Values> {
        let type_name = element.attribute("type").unwrap_or("");
        let Some(scalar) = Scalar::from_xml(type_name) else {
            let remedy = "Int8 to UInt64, Float32 and Float64 are readable";
            return Err(element.fault(format!("numbers of type \"{type_name}\""), remedy));
        };
        let damaged = |found: String| Fault::damaged(element.position(), found);
        let bytes = match element.attribute("format").unwrap_or("ascii") {
            "ascii" => {
                let words = element.text.as_bytes().split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
                return scalar
                    .parse(words)
                    .map_err(|(k, word)| damaged(format!("'{word}' (number {k}) is no {type_name}")));
            }
            "binary" => {
                if element.text.trim_ascii().is_empty() {
                    return Ok(scalar.empty());
                }
                self.codec.read_base64(element.text.as_bytes()).map_err(damaged)?
            }
            "appended" => {
                let appended = self.appended.ok_or_else(|| damaged("there are no appended data".into()))?;
                let offset = element.count("offset", 0)?;
                let Some(from) = appended.bytes.get(offset..) else {
                    return Err(damaged(format!(
                        "offset {offset} lies beyond the {} appended bytes",
                        appended.bytes.len()
                    )));
                };
                let read = if appended.base64 { self.codec.read_base64(from) } else { self.codec.read_raw(from) };
                read.map_err(|found| Fault::damaged(Position::Byte(appended.at + offset as u64), found))?
            }
            other => {
                return Err(element.fault(format!("format=\"{other}\""), "ascii, binary and appended are readable"));
            }
        };
        if bytes.len() % scalar.size() != 0 {
            return Err(damaged(format!("{} bytes are no whole number of {type_name}", bytes.len())));
        }
        Ok(scalar.decode(&bytes, self.codec.big_endian))
    }

    /// The whole numbers of the array called `name`; `None` where there is no such array.
    fn integers(&self, parent: &Element<'_>, name: &str) -> Parsed<Option<Vec<i64>>> {
        let Some(element) = parent.all("DataArray").find(|e| e.attribute("Name") == Some(name)) else {
            return Ok(None);
        };
        let values = self.values(element).map_err(|e| e.in_array(name))?;
        let whole =
            whole_numbers(&values).ok_or_else(|| Fault::damaged(element.position(), "fractions in a list of numbers"));
        whole.map(Some).map_err(|e| e.in_array(name))
    }

    fn needed(&self, parent: &Element<'_>, name: &str) -> Parsed<Vec<i64>> {
        self.integers(parent, name)?
            .ok_or_else(|| Fault::damaged(parent.position(), format!("<{}> has no array '{name}'", parent.name)))
    }

    /// All arrays of numbers below `parent`, for `tuples` points or cells where that is known.
    pub fn collect(
        &self,
        parent: &Element<'_>,
        tuples: Option<usize>,
        skipped: &mut Vec<String>,
    ) -> Parsed<Vec<DataArray>> {
        let mut all = Vec::new();
        for element in &parent.children {
            let name = element.attribute("Name").unwrap_or("").to_owned();
            let known = element.attribute("type").is_some_and(|t| !matches!(t, "String" | "Bit"));
            if element.name != "DataArray" || !known {
                if matches!(element.name.as_str(), "Array" | "DataArray") {
                    note(skipped, &name);
                }
                continue;
            }
            let components = element.count("NumberOfComponents", 1)?.max(1);
            let values = self.values(element).map_err(|e| e.in_array(&name))?;
            let expected = tuples.map(|n| n.saturating_mul(components));
            if expected.is_some_and(|n| n != values.len()) || values.len() % components != 0 {
                let found = format!(
                    "{} numbers, but {} are needed ({components} for each of {})",
                    values.len(),
                    expected.unwrap_or(components),
                    tuples.unwrap_or(1)
                );
                return Err(Fault::damaged(element.position(), found).in_array(&name));
            }
            let names: Vec<&str> =
                (0..components.min(6)).filter_map(|k| element.attribute(&format!("ComponentName{k}"))).collect();
            let symmetric = components == 6 && symmetric_tensor::is_in_file_order(&names);
            let values = if symmetric { symmetric_tensor::values_from_file(values) } else { values };
            all.push(DataArray { name, components, values });
        }
        Ok(all)
    }

    /// The columns below the piece's child `name`.
    pub fn columns(
        &self,
        piece: &Element<'_>,
        name: &str,
        tuples: usize,
        skipped: &mut Vec<String>,
    ) -> Parsed<Vec<DataArray>> {
        piece.child(name).map_or(Ok(Vec::new()), |parent| self.collect(parent, Some(tuples), skipped))
    }

    fn points(&self, piece: &Element<'_>) -> Parsed<Vec<[f64; 3]>> {
        let count = piece.count("NumberOfPoints", 0)?;
        let array = piece.child("Points").and_then(|p| p.child("DataArray"));
        let found = match array {
            Some(array) => {
                let values = self.values(array).map_err(|e| e.in_array("Points"))?;
                points(&values, array.position())?
            }
            None => Vec::new(),
        };
        if found.len() != count {
            let text = format!("NumberOfPoints=\"{count}\", but there are coordinates of {}", found.len());
            return Err(Fault::damaged(array.unwrap_or(piece).position(), text));
        }
        Ok(found)
    }

    fn cells(&self, piece: &Element<'_>, range: PointRange, data: &mut VtkData) -> Parsed<()> {
        let count = piece.count("NumberOfCells", 0)?;
        let Some(element) = piece.child("Cells").filter(|_| count > 0) else {
            return if count == 0 { Ok(()) } else { Err(Fault::damaged(piece.position(), "there is no <Cells>")) };
        };
        let types: Option<Vec<u8>> = self.needed(element, "types")?.into_iter().map(|t| u8::try_from(t).ok()).collect();
        let raw = RawCells {
            types: types.ok_or_else(|| Fault::damaged(element.position(), "a cell type is not within 0…255"))?,
            connectivity: self.needed(element, "connectivity")?,
            ends: self.needed(element, "offsets")?,
            faces: self.faces(element)?,
        };
        if raw.types.len() != count {
            let text = format!("NumberOfCells=\"{count}\", but there are types of {}", raw.types.len());
            return Err(Fault::damaged(element.position(), text));
        }
        raw.append_to(&mut data.cells, range, element.position())
    }

    fn faces(&self, cells: &Element<'_>) -> Parsed<Option<Faces>> {
        if let Some(corners) = self.integers(cells, "face_connectivity")? {
            return Ok(Some(Faces::Lists {
                corners,
                face_ends: self.needed(cells, "face_offsets")?,
                cell_faces: self.needed(cells, "polyhedron_to_faces")?,
                cell_ends: self.needed(cells, "polyhedron_offsets")?,
            }));
        }
        let Some(faces) = self.integers(cells, "faces")? else { return Ok(None) };
        Ok(Some(Faces::Stream { faces, ends: self.needed(cells, "faceoffsets")? }))
    }

    /// Vertices, lines, polygons and strips of a `.vtp`, in the order that its cell data have.
    fn polygons(&self, piece: &Element<'_>, range: PointRange, data: &mut VtkData) -> Parsed<()> {
        for name in ["Verts", "Lines", "Polys", "Strips"] {
            let Some(element) = piece.child(name) else { continue };
            let Some(connectivity) = self.integers(element, "connectivity")? else { continue };
            let ends = self.needed(element, "offsets")?;
            let starts = std::iter::once(0).chain(ends.iter().copied());
            let types = starts.zip(&ends).map(|(a, &b)| polygon_type(name, b.saturating_sub(a))).collect();
            let raw = RawCells { types, connectivity, ends, faces: None };
            raw.append_to(&mut data.cells, range, element.position())?;
        }
        Ok(())
    }
}

/// VTK's cell type of a vertex, line, polygon or strip with so many corners.
pub(super) fn polygon_type(section: &str, corners: i64) -> u8 {
    match (section, corners) {
        ("Verts", 1) => 1,
        ("Verts", _) => 2,
        ("Lines", 2) => 3,
        ("Lines", _) => 4,
        ("Polys", 3) => 5,
        ("Polys", 4) => 9,
        ("Polys", _) => 7,
        _ => 6,
    }
}

pub(super) fn note(skipped: &mut Vec<String>, name: &str) {
    if !skipped.iter().any(|s| s == name) {
        skipped.push(name.to_owned());
    }
}

/// Columns of several pieces, one after the other.
#[derive(Default)]
struct Joined {
    columns: Vec<DataArray>,
    dropped: Vec<String>,
    started: bool,
}

impl Joined {
    /// Adds a piece's columns. A column that not all pieces have cannot be completed: it is dropped.
    fn add(&mut self, columns: Vec<DataArray>, tuples: usize) {
        // A piece without points often lists no columns; of a file without points, the names are worth keeping.
        if tuples == 0 {
            if !self.started && self.columns.is_empty() {
                self.columns = columns;
            }
            return;
        }
        if !self.started {
            self.started = true;
            self.columns = columns;
            return;
        }
        for column in &columns {
            if !self.columns.iter().any(|c| c.name == column.name) {
                note(&mut self.dropped, &column.name);
            }
        }
        let mut new = columns;
        self.columns.retain_mut(|column| {
            let found = new.iter().position(|n| n.name == column.name && n.components == column.components);
            match found {
                Some(k) => join(&mut column.values, new.swap_remove(k).values),
                None => note(&mut self.dropped, &column.name),
            }
            found.is_some()
        });
    }

    fn finish(self, skipped: &mut Vec<String>) -> Vec<DataArray> {
        for name in &self.dropped {
            note(skipped, name);
        }
        self.columns
    }
}

/// Appends numbers of the same type; of different types, both become floats.
pub(super) fn join(values: &mut Values, more: Values) {
    match (&mut *values, more) {
        (Values::F64(a), Values::F64(b)) => a.extend(b),
        (Values::F32(a), Values::F32(b)) => a.extend(b),
        (Values::I64(a), Values::I64(b)) => a.extend(b),
        (Values::U8(a), Values::U8(b)) => a.extend(b),
        (a, b) => {
            let mut all = a.to_f64();
            all.extend(b.to_f64());
            *a = Values::F64(all);
        }
    }
}
