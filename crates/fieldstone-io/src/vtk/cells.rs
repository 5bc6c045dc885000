//! Cells as files list them, checked and appended to a [`VtkCells`].

use super::data::VtkCells;
use super::fault::{Fault, Parsed};
use crate::Position;

/// VTK's code of a general polyhedron.
pub(super) const POLYHEDRON: u8 = 42;

/// Arrays that describe the faces of polyhedra.
#[derive(Debug)]
pub(super) enum Faces {
    /// `faces` (face count, then corner count and corners of each face) and `faceoffsets` (end of each
    /// cell's part; −1 for other cells): up to VTK 9.3.
    Stream { faces: Vec<i64>, ends: Vec<i64> },
    /// Since VTK 9.4: faces listed like cells, and for each cell the numbers of its faces.
    Lists { corners: Vec<i64>, face_ends: Vec<i64>, cell_faces: Vec<i64>, cell_ends: Vec<i64> },
}

/// Cells of one piece.
#[derive(Debug)]
pub(super) struct RawCells {
    pub types: Vec<u8>,
    pub connectivity: Vec<i64>,
    /// End of each cell in `connectivity`.
    pub ends: Vec<i64>,
    pub faces: Option<Faces>,
}

/// Numbers of the points that a piece's cells may name.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointRange {
    pub first: usize,
    pub count: usize,
}

impl PointRange {
    fn corner(self, cell: usize, point: i64, position: Position) -> Parsed<u32> {
        match usize::try_from(point) {
            Ok(p) if p < self.count => Ok((self.first + p) as u32),
            _ => Err(Fault::damaged(
                position,
                format!("cell {cell} names point {point}, but there are {} points", self.count),
            )),
        }
    }

    fn corners(self, cell: usize, points: &[i64], position: Position) -> Parsed<Vec<u32>> {
        points.iter().map(|&p| self.corner(cell, p, position)).collect()
    }
}

/// The part of `list` that ends at `end` and starts where the one before ended.
fn part<'a>(
    list: &'a [i64],
    start: &mut usize,
    end: i64,
    what: &str,
    index: usize,
    position: Position,
) -> Parsed<&'a [i64]> {
    let stop = usize::try_from(end).ok().filter(|&e| e >= *start && e <= list.len());
    let Some(stop) = stop else {
        return Err(Fault::damaged(
            position,
            format!("{what} {index} ends at {end}; that lies outside {}..={}", *start, list.len()),
        ));
    };
    let part = &list[*start..stop];
    *start = stop;
    Ok(part)
}

impl RawCells {
    /// Checks the cells and appends them.
    pub fn append_to(&self, cells: &mut VtkCells, points: PointRange, position: Position) -> Parsed<()> {
        if self.types.len() != self.ends.len() {
            return Err(Fault::damaged(
                position,
                format!("there are {} cell types, but {} cell offsets", self.types.len(), self.ends.len()),
            ));
        }
        let lists = match &self.faces {
            Some(Faces::Lists { corners, face_ends, .. }) => faces_by_number(corners, face_ends, position)?,
            _ => Vec::new(),
        };
        let (mut at, mut stream_at, mut list_at) = (0, 0, 0);
        for (cell, (&kind, &end)) in self.types.iter().zip(&self.ends).enumerate() {
            let corners = part(&self.connectivity, &mut at, end, "cell", cell, position)?;
            cells.push(kind, points.corners(cell, corners, position)?);
            let missing = || Fault::damaged(position, format!("cell {cell} is a polyhedron without faces"));
            match &self.faces {
                _ if kind != POLYHEDRON => {
                    // Cells of other types have an empty part, which must be passed all the same.
                    if let Some(Faces::Lists { cell_faces, cell_ends, .. }) = &self.faces {
                        let end = *cell_ends.get(cell).ok_or_else(missing)?;
                        part(cell_faces, &mut list_at, end, "polyhedron", cell, position)?;
                    }
                }
                Some(Faces::Stream { faces, ends }) => {
                    let end = *ends.get(cell).ok_or_else(missing)?;
                    let stream = part(faces, &mut stream_at, end, "polyhedron", cell, position)?;
                    push_stream(cells, stream, cell, points, position)?;
                }
                Some(Faces::Lists { cell_faces, cell_ends, .. }) => {
                    let end = *cell_ends.get(cell).ok_or_else(missing)?;
                    let numbers = part(cell_faces, &mut list_at, end, "polyhedron", cell, position)?;
                    if numbers.is_empty() {
                        return Err(missing());
                    }
                    for &face in numbers {
                        let found = usize::try_from(face).ok().and_then(|f| lists.get(f));
                        let corners = found.ok_or_else(|| {
                            let text = format!("cell {cell} names face {face}, but there are {}", lists.len());
                            Fault::damaged(position, text)
                        })?;
                        cells.push_face(points.corners(cell, corners, position)?);
                    }
                }
                None => return Err(missing()),
            }
        }
        Ok(())
    }
}

fn faces_by_number<'a>(corners: &'a [i64], ends: &[i64], position: Position) -> Parsed<Vec<&'a [i64]>> {
    let mut at = 0;
    ends.iter().enumerate().map(|(f, &end)| part(corners, &mut at, end, "face", f, position)).collect()
}

/// Appends the faces in `stream` (face count, then corner count and corners of each) to the last cell.
fn push_stream(
    cells: &mut VtkCells,
    stream: &[i64],
    cell: usize,
    points: PointRange,
    position: Position,
) -> Parsed<()> {
    let broken = || Fault::damaged(position, format!("the face list of polyhedron {cell} contradicts itself"));
    let (&count, mut rest) = stream.split_first().ok_or_else(broken)?;
    for _ in 0..count {
        let (&corners, after) = rest.split_first().ok_or_else(broken)?;
        let corners = usize::try_from(corners).map_err(|_| broken())?;
        let (face, after) = after.split_at_checked(corners).ok_or_else(broken)?;
        cells.push_face(points.corners(cell, face, position)?);
        rest = after;
    }
    if rest.is_empty() && count > 0 { Ok(()) } else { Err(broken()) }
}

/// Appends a polyhedron that is given by its face stream in place of its corners, as legacy files do.
pub(super) fn push_legacy_polyhedron(
    cells: &mut VtkCells,
    stream: &[i64],
    points: PointRange,
    position: Position,
) -> Parsed<()> {
    let cell = cells.len();
    let mut corners = Vec::new();
    let mut at = 1;
    while let Some(&count) = stream.get(at) {
        let end = usize::try_from(count).ok().and_then(|n| n.checked_add(at + 1)).unwrap_or(stream.len());
        for &point in stream.get(at + 1..end).unwrap_or_default() {
            corners.push(points.corner(cell, point, position)?);
        }
        at = end.max(at + 1);
    }
    corners.sort_unstable();
    corners.dedup();
    cells.push(POLYHEDRON, corners);
    push_stream(cells, stream, cell, points, position)
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: PointRange = PointRange { first: 10, count: 8 };

    fn read(raw: RawCells) -> Parsed<VtkCells> {
        let mut cells = VtkCells::default();
        raw.append_to(&mut cells, POINTS, Position::File)?;
        Ok(cells)
    }

    fn polyhedron_and_triangle(faces: Option<Faces>) -> RawCells {
        RawCells {
            types: vec![5, 42, 5],
            connectivity: vec![0, 1, 2, 0, 1, 2, 3, 4, 5, 6],
            ends: vec![3, 7, 10],
            faces,
        }
    }

    #[test]
    fn both_layouts_of_polyhedron_faces_give_the_same_cells() {
        let old =
            Faces::Stream { faces: vec![4, 3, 0, 2, 1, 3, 0, 1, 3, 3, 1, 2, 3, 3, 2, 0, 3], ends: vec![-1, 17, -1] };
        let new = Faces::Lists {
            corners: vec![0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3],
            face_ends: vec![3, 6, 9, 12],
            cell_faces: vec![0, 1, 2, 3],
            cell_ends: vec![0, 4, 4],
        };
        let old = read(polyhedron_and_triangle(Some(old))).unwrap();
        assert_eq!(old, read(polyhedron_and_triangle(Some(new))).unwrap());
        assert_eq!(old.faces(1).nth(3).unwrap(), [12, 10, 13]);
    }

    #[test]
    fn a_polyhedron_without_faces_is_refused() {
        assert!(read(polyhedron_and_triangle(None)).unwrap_err().found.contains("without faces"));
    }

    #[test]
    fn a_polyhedron_with_an_empty_list_of_faces_is_refused() {
        let faces =
            Faces::Lists { corners: vec![0, 2, 1], face_ends: vec![3], cell_faces: vec![], cell_ends: vec![0, 0, 0] };
        let found = read(polyhedron_and_triangle(Some(faces))).unwrap_err().found;
        assert_eq!(found, "cell 1 is a polyhedron without faces");
    }

    #[test]
    fn offsets_that_fall_or_leave_the_list_are_refused_with_the_cell() {
        for ends in [vec![3, 2, 10], vec![3, 7, 11], vec![-1, 7, 10]] {
            let raw = RawCells { ends, ..polyhedron_and_triangle(None) };
            assert!(read(RawCells { types: vec![5; 3], ..raw }).unwrap_err().found.contains("ends at"));
        }
    }

    #[test]
    fn a_corner_beyond_the_points_is_refused_with_the_cell() {
        let raw = RawCells { types: vec![5], connectivity: vec![0, 1, 8], ends: vec![3], faces: None };
        assert!(read(raw).unwrap_err().found.contains("cell 0 names point 8"));
    }

    #[test]
    fn a_face_stream_with_a_count_too_many_is_refused() {
        let mut cells = VtkCells::default();
        for stream in [&[5, 3, 0, 2, 1][..], &[1, 3, 0, 2, 1, 3], &[1, -3, 0], &[i64::MAX], &[]] {
            assert!(push_legacy_polyhedron(&mut cells, stream, POINTS, Position::File).is_err(), "{stream:?}");
        }
    }
}
