//! VTK's legacy files, versions 2 to 5.1, text and binary.

use std::io::BufRead;

use super::cells::{POLYHEDRON, PointRange, RawCells, push_legacy_polyhedron};
use super::data::{VtkCells, VtkData, VtkImage, VtkKind, points};
use super::fault::{Fault, Parsed};
use super::legacy_input::LegacyInput;
use super::scalar::{Scalar, whole_numbers};
use super::xml_reader::{note, polygon_type};
use crate::{DataArray, Position};

/// First bytes of every legacy file.
pub(super) const MAGIC: &[u8] = b"# vtk DataFile";

/// Cells of one keyword: corners one after the other, and where each cell ends.
#[derive(Default)]
struct Lists {
    connectivity: Vec<i64>,
    ends: Vec<i64>,
}

/// What attributes read at the moment belong to.
#[derive(Clone, Copy, PartialEq)]
enum Location {
    Geometry,
    Points(usize),
    Cells(usize),
}

struct Reader<R> {
    input: LegacyInput<R>,
    /// Cells are OFFSETS and CONNECTIVITY (5.x), not interleaved with their corner counts.
    split_cells: bool,
    data: VtkData,
    /// VERTICES, LINES, POLYGONS, TRIANGLE_STRIPS: cell data have this order, whatever the file's is.
    sections: [Lists; 4],
    cells: Lists,
    types: Vec<u8>,
}

/// Reads a whole file.
pub(super) fn read(stream: impl BufRead) -> Parsed<VtkData> {
    let mut input = LegacyInput::new(stream);
    let first = input.line()?.unwrap_or_default();
    let version = first.strip_prefix("# vtk DataFile Version").map(str::trim).and_then(|v| v.split('.').next());
    let Some(major) = version.and_then(|v| v.parse::<u32>().ok()) else {
        return Err(input.fault("the first line is not '# vtk DataFile Version x.y'"));
    };
    if !(2..=5).contains(&major) {
        return Err(Fault::new(
            Position::Line(1),
            format!("version {major} of the legacy format"),
            "versions 2 to 5 are readable: convert the file with ParaView or pyvista",
        ));
    }
    let _title = input.line()?;
    let encoding = input.expect("ASCII or BINARY")?;
    let binary = match encoding.first().map(|w| w.to_ascii_uppercase()).as_deref() {
        Some("ASCII") => false,
        Some("BINARY") => true,
        _ => return Err(input.fault(format!("'{}' stands where ASCII or BINARY should", encoding.join(" ")))),
    };
    let dataset = input.expect("DATASET")?;
    let kind = match dataset.get(1).map(|w| w.to_ascii_uppercase()).as_deref() {
        Some("POLYDATA") => VtkKind::PolyData,
        Some("UNSTRUCTURED_GRID") => VtkKind::UnstructuredGrid,
        Some("STRUCTURED_POINTS") => VtkKind::ImageData,
        _ => {
            return Err(Fault::new(
                input.position(),
                format!("'{}' is no readable data set", dataset.join(" ")),
                "POLYDATA, UNSTRUCTURED_GRID and STRUCTURED_POINTS are readable; convert it with ParaView or pyvista",
            ));
        }
    };
    input.binary = binary;
    let reader = Reader {
        input,
        split_cells: major >= 5,
        data: VtkData::new(kind),
        sections: Default::default(),
        cells: Lists::default(),
        types: Vec::new(),
    };
    reader.run()
}

impl<R: BufRead> Reader<R> {
    fn run(mut self) -> Parsed<VtkData> {
        let mut at = Location::Geometry;
        if self.data.kind == VtkKind::ImageData {
            self.data.image = Some(VtkImage::aligned([0.0; 3], [1.0; 3], [0; 3]));
        }
        while let Some(line) = self.input.filled_line()? {
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            let keyword = words[0].to_ascii_uppercase();
            match keyword.as_str() {
                "POINT_DATA" | "CELL_DATA" => {
                    if at == Location::Geometry {
                        self.finish_cells()?;
                    }
                    at = self.location(&keyword, &words)?;
                }
                "FIELD" => self.field(&words, at)?,
                "METADATA" => self.skip_metadata()?,
                _ if at == Location::Geometry => self.geometry(&keyword, &words)?,
                _ => self.attribute(&keyword, &words, at)?,
            }
        }
        if at == Location::Geometry {
            self.finish_cells()?;
        }
        self.data.find_time();
        Ok(self.data)
    }

    fn unknown(&self, words: &[&str]) -> Fault {
        self.input.fault(format!("'{}' is no keyword of the format here", words.join(" ")))
    }

    fn count(&self, words: &[&str], index: usize) -> Parsed<usize> {
        let word = words.get(index).copied().unwrap_or("");
        word.parse().map_err(|_| self.input.fault(format!("'{word}' in '{}' is no count", words.join(" "))))
    }

    fn scalar(&self, words: &[&str], index: usize) -> Parsed<Scalar> {
        let name = words.get(index).copied().unwrap_or("");
        Scalar::from_legacy(name).ok_or_else(|| {
            let found = format!("'{name}' in '{}' is no type of number", words.join(" "));
            Fault::new(
                self.input.position(),
                found,
                "char, short, int, long (also unsigned), float and double are readable",
            )
        })
    }

    fn product(&self, a: usize, b: usize) -> Parsed<usize> {
        a.checked_mul(b).ok_or_else(|| self.input.fault(format!("{a} × {b} numbers are more than any file holds")))
    }

    /// Whole numbers, as cells need them.
    fn integers(&mut self, scalar: Scalar, count: usize) -> Parsed<Vec<i64>> {
        let values = self.input.numbers(scalar, count)?;
        whole_numbers(&values).ok_or_else(|| self.input.fault("fractions in a list of cells"))
    }

    fn geometry(&mut self, keyword: &str, words: &[&str]) -> Parsed<()> {
        let section = ["VERTICES", "LINES", "POLYGONS", "TRIANGLE_STRIPS"].iter().position(|&k| k == keyword);
        match (keyword, self.data.kind) {
            ("POINTS", VtkKind::PolyData | VtkKind::UnstructuredGrid) => {
                let (count, scalar) = (self.count(words, 1)?, self.scalar(words, 2)?);
                let position = self.input.position();
                let count = self.product(count, 3)?;
                self.data.points = points(&self.input.numbers(scalar, count)?, position)?;
            }
            ("CELLS", VtkKind::UnstructuredGrid) => self.cells = self.lists(words)?,
            ("CELL_TYPES", VtkKind::UnstructuredGrid) => {
                let count = self.count(words, 1)?;
                let types = self.integers(Scalar::I32, count)?;
                let types: Option<Vec<u8>> = types.into_iter().map(|t| u8::try_from(t).ok()).collect();
                self.types = types.ok_or_else(|| self.input.fault("a cell type is not within 0…255"))?;
            }
            ("DIMENSIONS" | "ORIGIN" | "SPACING" | "ASPECT_RATIO", VtkKind::ImageData) => self.image(keyword, words)?,
            (_, VtkKind::PolyData) if section.is_some() => {
                let lists = self.lists(words)?;
                self.sections[section.unwrap_or(0)] = lists;
            }
            _ => return Err(self.unknown(words)),
        }
        Ok(())
    }

    fn image(&mut self, keyword: &str, words: &[&str]) -> Parsed<()> {
        let numbers: Option<Vec<f64>> = words[1..].iter().map(|w| w.parse().ok()).collect();
        let numbers: Option<[f64; 3]> = numbers.and_then(|v| v.try_into().ok());
        let (Some(numbers), Some(image)) = (numbers, &mut self.data.image) else { return Err(self.unknown(words)) };
        match keyword {
            "ORIGIN" => image.origin = numbers,
            "DIMENSIONS" => {
                // Bounds that keep the product of the counts within 64 bits.
                if numbers.iter().any(|&n| !(1.0..=f64::from(1 << 20)).contains(&n)) {
                    return Err(self.unknown(words));
                }
                image.cells = numbers.map(|n| n as usize - 1);
            }
            _ => image.spacing = numbers,
        }
        Ok(())
    }

    /// The cells behind `KEYWORD a b`.
    fn lists(&mut self, words: &[&str]) -> Parsed<Lists> {
        let (a, b) = (self.count(words, 1)?, self.count(words, 2)?);
        if self.split_cells {
            let offsets = self.part("OFFSETS", a)?;
            let connectivity = self.part("CONNECTIVITY", b)?;
            // The first offset is where the first cell starts.
            if offsets.first().is_some_and(|&o| o != 0) {
                return Err(self.input.fault(format!("the first cell starts at {}, not at 0", offsets[0])));
            }
            return Ok(Lists { connectivity, ends: offsets.into_iter().skip(1).collect() });
        }
        let numbers = self.integers(Scalar::I32, b)?;
        let mut lists = Lists::default();
        let mut rest = &numbers[..];
        for cell in 0..a {
            let found = rest.split_first().and_then(|(&n, after)| after.split_at_checked(usize::try_from(n).ok()?));
            let Some((corners, after)) = found else {
                let text = format!("cell {cell} of {a} does not fit into the {b} numbers of '{}'", words.join(" "));
                return Err(self.input.fault(text));
            };
            lists.connectivity.extend_from_slice(corners);
            lists.ends.push(lists.connectivity.len() as i64);
            rest = after;
        }
        Ok(lists)
    }

    fn part(&mut self, name: &str, count: usize) -> Parsed<Vec<i64>> {
        let words = self.input.expect(name)?;
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        if !words[0].eq_ignore_ascii_case(name) {
            return Err(self.input.fault(format!("'{}' stands where {name} should", words.join(" "))));
        }
        let scalar = self.scalar(&words, 1)?;
        self.integers(scalar, count)
    }

    /// Puts the cells together once the geometry is complete.
    fn finish_cells(&mut self) -> Parsed<()> {
        let position = self.input.position();
        let range = PointRange { first: 0, count: self.data.points.len() };
        let mut cells = VtkCells::default();
        for (k, lists) in std::mem::take(&mut self.sections).into_iter().enumerate() {
            let name = ["Verts", "Lines", "Polys", "Strips"][k];
            let starts = std::iter::once(0).chain(lists.ends.iter().copied());
            let types = starts.zip(&lists.ends).map(|(a, &b)| polygon_type(name, b.saturating_sub(a))).collect();
            let raw = RawCells { types, connectivity: lists.connectivity, ends: lists.ends, faces: None };
            raw.append_to(&mut cells, range, position)?;
        }
        let lists = std::mem::take(&mut self.cells);
        let raw = RawCells {
            types: std::mem::take(&mut self.types),
            connectivity: lists.connectivity,
            ends: lists.ends,
            faces: None,
        };
        if raw.types.contains(&POLYHEDRON) && raw.types.len() == raw.ends.len() {
            // A polyhedron's corners are its faces here: cell by cell.
            let mut start = 0;
            for (&kind, &end) in raw.types.iter().zip(&raw.ends) {
                let stream = usize::try_from(end).ok().and_then(|e| raw.connectivity.get(start..e));
                let Some(stream) = stream else {
                    return Err(self.input.fault(format!("cell {} ends at {end}, outside its list", cells.len())));
                };
                if kind == POLYHEDRON {
                    push_legacy_polyhedron(&mut cells, stream, range, position)?;
                } else {
                    let ends = vec![stream.len() as i64];
                    let one = RawCells { types: vec![kind], connectivity: stream.to_vec(), ends, faces: None };
                    one.append_to(&mut cells, range, position)?;
                }
                start += stream.len();
            }
        } else {
            raw.append_to(&mut cells, range, position)?;
        }
        self.data.cells = cells;
        Ok(())
    }

    fn location(&self, keyword: &str, words: &[&str]) -> Parsed<Location> {
        let count = self.count(words, 1)?;
        let (location, available) = if keyword == "POINT_DATA" {
            (Location::Points(count), self.data.point_count())
        } else {
            (Location::Cells(count), self.data.cell_count())
        };
        if count == available {
            return Ok(location);
        }
        Err(self.input.fault(format!("'{}', but the file has {available} of them", words.join(" "))))
    }

    /// Whatever stands behind POINT_DATA and CELL_DATA, apart from FIELD.
    fn attribute(&mut self, keyword: &str, words: &[&str], at: Location) -> Parsed<()> {
        let (Location::Points(count) | Location::Cells(count)) = at else { return Err(self.unknown(words)) };
        let name = decoded(words.get(1).copied().unwrap_or(""));
        let fixed = match keyword {
            "SCALARS" => {
                let components = if words.len() > 3 { self.count(words, 3)?.max(1) } else { 1 };
                let line = self.input.expect("LOOKUP_TABLE")?;
                if !line[0].eq_ignore_ascii_case("LOOKUP_TABLE") {
                    return Err(self.input.fault(format!("'{}' stands where LOOKUP_TABLE should", line.join(" "))));
                }
                components
            }
            "VECTORS" | "NORMALS" => 3,
            "TENSORS" => 9,
            "TENSORS6" => 6,
            "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => 1,
            "TEXTURE_COORDINATES" => self.count(words, 2)?,
            "COLOR_SCALARS" => {
                let components = self.count(words, 2)?;
                let scalar = if self.input.binary { Scalar::U8 } else { Scalar::F32 };
                return self.column(name, scalar, components, count, at);
            }
            "LOOKUP_TABLE" => {
                // Colours, four to an entry.
                let count = self.product(self.count(words, 2)?, 4)?;
                let scalar = if self.input.binary { Scalar::U8 } else { Scalar::F32 };
                return self.input.numbers(scalar, count).map(|_| ());
            }
            _ => return Err(self.unknown(words)),
        };
        let scalar = self.scalar(words, if keyword == "TEXTURE_COORDINATES" { 3 } else { 2 });
        self.column(name, scalar?, fixed, count, at)
    }

    fn column(&mut self, name: String, scalar: Scalar, components: usize, count: usize, at: Location) -> Parsed<()> {
        let total = self.product(components, count)?;
        let values = self.input.numbers(scalar, total).map_err(|e| e.in_array(&name))?;
        self.store(DataArray { name, components, values }, at);
        Ok(())
    }

    fn store(&mut self, array: DataArray, at: Location) {
        match at {
            Location::Geometry => self.data.field_data.push(array),
            Location::Points(_) => self.data.point_data.push(array),
            Location::Cells(_) => self.data.cell_data.push(array),
        }
    }

    /// `FIELD name n`, then n arrays.
    fn field(&mut self, words: &[&str], at: Location) -> Parsed<()> {
        let count = self.count(words, 2)?;
        let mut read = 0;
        while read < count {
            let line = self.input.expect("an array of FIELD")?;
            let words: Vec<&str> = line.iter().map(String::as_str).collect();
            match words[0] {
                "METADATA" if words.len() == 1 => {
                    self.skip_metadata()?;
                    continue;
                }
                "NULL_ARRAY" if words.len() == 1 => {
                    read += 1;
                    continue;
                }
                _ => {}
            }
            read += 1;
            let (components, tuples) = (self.count(&words, 1)?, self.count(&words, 2)?);
            let total = self.product(components, tuples)?;
            let name = decoded(words[0]);
            match words.get(3).map(|w| w.to_ascii_lowercase()).as_deref() {
                Some("string" | "utf8_string") => {
                    self.input.skip_strings(total)?;
                    note(&mut self.data.skipped, &name);
                }
                Some("bit") => {
                    if self.input.binary {
                        self.input.skip_bytes(total.div_ceil(8))?;
                    } else {
                        self.input.numbers(Scalar::U8, total)?;
                    }
                    note(&mut self.data.skipped, &name);
                }
                _ => {
                    let scalar = self.scalar(&words, 3)?;
                    let values = self.input.numbers(scalar, total).map_err(|e| e.in_array(&name))?;
                    match at {
                        Location::Points(n) | Location::Cells(n) if n != tuples => {
                            if tuples > 0 {
                                return Err(self.input.fault(format!("array '{name}' is for {tuples}, not for {n}")));
                            }
                            note(&mut self.data.skipped, &name);
                        }
                        _ => self.store(DataArray { name, components, values }, at),
                    }
                }
            }
        }
        Ok(())
    }

    /// Passes over a METADATA block: it ends with a blank line.
    fn skip_metadata(&mut self) -> Parsed<()> {
        while self.input.line()?.is_some_and(|line| !line.is_empty()) {}
        Ok(())
    }
}

/// A name with its percent escapes resolved: VTK writes `a%20b` for `a b`.
fn decoded(name: &str) -> String {
    let bytes = name.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let escape = bytes.get(at + 1..at + 3).filter(|h| bytes[at] == b'%' && h.iter().all(u8::is_ascii_hexdigit));
        let code = escape.and_then(|h| std::str::from_utf8(h).ok()).and_then(|h| u8::from_str_radix(h, 16).ok());
        match code {
            Some(code) => {
                out.push(code);
                at += 3;
            }
            None => {
                out.push(bytes[at]);
                at += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Values;

    fn file(version: &str, body: &str) -> Parsed<VtkData> {
        read(format!("# vtk DataFile Version {version}\ntitle\nASCII\n{body}").as_bytes())
    }

    #[test]
    fn cell_data_order_is_vertices_lines_polygons_whatever_order_the_file_has() {
        let points = "DATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n";
        let d = file("3.0", &format!("{points}POLYGONS 1 4\n3 0 1 2\nVERTICES 1 2\n1 2\n")).unwrap();
        assert_eq!(d.cells.types(), [1, 5]);
        assert_eq!(d.cells.corners(0), [2]);
    }

    #[test]
    fn metadata_between_arrays_and_escaped_names_are_understood() {
        let d = file(
            "4.2",
            "DATASET POLYDATA\nPOINTS 1 double\n1 2 3\nMETADATA\nINFORMATION 1\nNAME X LOCATION Y\nDATA 2 0 1\n\n\
             POINT_DATA 1\nFIELD FieldData 2\na%20b 1 1 int\n7\nMETADATA\nCOMPONENT_NAMES\nu\n\nw 2 1 float\n1 2\n",
        )
        .unwrap();
        assert_eq!(d.point_data[0], DataArray::integers("a b", vec![7]));
        assert_eq!(d.point_data[1].values, Values::F32(vec![1.0, 2.0]));
    }

    #[test]
    fn structured_points_give_a_regular_grid() {
        let d = file("3.0", "DATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nORIGIN 1 0 0\nASPECT_RATIO 0.5 1 1\nCELL_DATA 2\nSCALARS s double\nLOOKUP_TABLE default\n4 5\n").unwrap();
        let image = d.image.unwrap();
        assert_eq!((image.cells, image.origin, image.spacing), ([2, 1, 1], [1.0, 0.0, 0.0], [0.5, 1.0, 1.0]));
        assert_eq!(d.cell_data[0].values, Values::F64(vec![4.0, 5.0]));
    }

    #[test]
    fn a_wrong_word_is_reported_with_its_line() {
        let e = file("4.2", "DATASET POLYDATA\nPOINTS 1 double\n1 2 x\n").unwrap_err();
        assert_eq!(e.position, Position::Line(6));
        assert!(e.found.contains("'x'"), "{}", e.found);
        let e = file("4.2", "DATASET POLYDATA\nPOINTS 1 double\n1 2 3\nNONSENSE 1\n").unwrap_err();
        assert!(e.found.contains("NONSENSE"));
    }

    #[test]
    fn interleaved_cells_that_overrun_their_count_are_refused() {
        let points = "DATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n";
        assert!(file("3.0", &format!("{points}POLYGONS 2 4\n3 0 1 2\n")).unwrap_err().found.contains("cell 1 of 2"));
        assert!(file("3.0", &format!("{points}POLYGONS 1 2\n-3 0\n")).is_err());
    }
}
