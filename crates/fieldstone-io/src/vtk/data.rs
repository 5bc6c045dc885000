//! What a VTK file holds, whichever dialect it is written in.

use std::path::PathBuf;

use super::fault::{Fault, Parsed};
use crate::{DataArray, Position, Values};

/// Cells of a file: type codes and corners.
///
/// Every corner names an existing point: readers check before they fill this.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VtkCells {
    types: Vec<u8>,
    ends: Vec<usize>,
    corners: Vec<u32>,
    /// Faces of polyhedra: corner count and corners of each; empty slices for other cells.
    face_stream: Vec<u32>,
    /// End of each cell's part of `face_stream`; shorter than `types` where no polyhedron follows.
    face_ends: Vec<usize>,
}

impl VtkCells {
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.types.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.types.is_empty()
    }

    /// VTK's code of each cell's type: 10 is a tetrahedron, 42 a polyhedron.
    pub fn types(&self) -> &[u8] {
        &self.types
    }

    /// Corners of cell `cell` in VTK's order; those of a polyhedron in no particular order.
    ///
    /// # Panics
    /// Where there is no such cell.
    pub fn corners(&self, cell: usize) -> &[u32] {
        let start = if cell == 0 { 0 } else { self.ends[cell - 1] };
        &self.corners[start..self.ends[cell]]
    }

    /// Faces of cell `cell`, each a list of corners; none where it is not a polyhedron.
    pub fn faces(&self, cell: usize) -> impl Iterator<Item = &[u32]> {
        let end_of = |k: usize| self.face_ends.get(k).copied().unwrap_or(self.face_stream.len());
        let start = if cell == 0 { 0 } else { end_of(cell - 1) };
        let mut rest = &self.face_stream[start..end_of(cell)];
        std::iter::from_fn(move || {
            let (&count, corners) = rest.split_first()?;
            let (face, after) = corners.split_at_checked(count as usize)?;
            rest = after;
            Some(face)
        })
    }

    pub(super) fn push(&mut self, kind: u8, corners: impl IntoIterator<Item = u32>) {
        self.types.push(kind);
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
        if !self.face_ends.is_empty() {
            self.face_ends.push(self.face_stream.len());
        }
    }

    /// Marks the last cell as the polyhedron with these faces, appended one by one.
    pub(super) fn push_face(&mut self, corners: impl IntoIterator<Item = u32>) {
        if self.face_ends.len() < self.types.len() {
            self.face_ends.resize(self.types.len(), self.face_stream.len());
        }
        let count_at = self.face_stream.len();
        self.face_stream.push(0);
        self.face_stream.extend(corners);
        self.face_stream[count_at] = (self.face_stream.len() - count_at - 1) as u32;
        if let Some(last) = self.face_ends.last_mut() {
            *last = self.face_stream.len();
        }
    }
}

/// A regular grid of points and boxes: VTK's image data and structured points.
#[derive(Debug, Clone, PartialEq)]
pub struct VtkImage {
    /// The grid's first point.
    pub origin: [f64; 3],
    /// Distance of neighbouring points along each of the grid's axes.
    pub spacing: [f64; 3],
    /// Cells along each axis; one less than points. 0 in a direction that the grid does not extend in.
    pub cells: [usize; 3],
    /// Axes of the grid, one row each of x, y, z: `position = origin + direction · (i, j, k) ∘ spacing`.
    pub direction: [[f64; 3]; 3],
}

impl VtkImage {
    /// Row-major identity: the grid's axes are x, y and z.
    pub const ALIGNED: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    /// A grid of boxes along x, y and z.
    ///
    /// ```
    /// use fieldstone_io::vtk::VtkImage;
    /// let grid = VtkImage::aligned([0.0; 3], [0.1, 0.1, 0.2], [10, 10, 5]);
    /// assert_eq!((grid.cell_count(), grid.point_count()), (500, 11 * 11 * 6));
    /// ```
    pub fn aligned(origin: [f64; 3], spacing: [f64; 3], cells: [usize; 3]) -> Self {
        Self { origin, spacing, cells, direction: Self::ALIGNED }
    }

    /// Number of cells; a direction without extent counts as one.
    pub fn cell_count(&self) -> usize {
        self.cells.iter().map(|&n| n.max(1)).product()
    }

    /// Number of points.
    pub fn point_count(&self) -> usize {
        self.cells.iter().map(|&n| n + 1).product()
    }
}

/// Which of VTK's data sets a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VtkKind {
    /// Points and cells of any type.
    UnstructuredGrid,
    /// Points, vertices, lines and polygons.
    PolyData,
    /// A regular grid.
    ImageData,
}

/// Content of a VTK file, several pieces joined in their order.
///
/// | field | shape |
/// |---|---|
/// | `points` | N; empty for a regular grid |
/// | `point_data` | N × components each |
/// | `cell_data` | cells × components each |
///
/// Integers of up to 64 bits keep their value; an array of unsigned numbers of which one does not fit 63 bits
/// is held as floats.
#[derive(Debug, Clone, PartialEq)]
pub struct VtkData {
    /// File that this was read from.
    pub path: PathBuf,
    /// Kind of data set.
    pub kind: VtkKind,
    /// Coordinates.
    pub points: Vec<[f64; 3]>,
    /// Cells; none for a regular grid.
    pub cells: VtkCells,
    /// The regular grid, where the file is one.
    pub image: Option<VtkImage>,
    /// Columns on points.
    pub point_data: Vec<DataArray>,
    /// Columns on cells.
    pub cell_data: Vec<DataArray>,
    /// Columns of the data set as a whole.
    pub field_data: Vec<DataArray>,
    /// Time, where field data named `TimeValue` or `TIME` states it.
    pub time: Option<f64>,
    /// Names of arrays that were passed over: texts, bits, and columns that not all pieces have.
    pub skipped: Vec<String>,
}

/// What an array of a [`VtkData`] belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VtkLocation {
    /// Points.
    Point,
    /// Cells.
    Cell,
    /// The data set as a whole.
    Field,
}

/// Name, shape and range of an array.
#[derive(Debug, Clone, PartialEq)]
pub struct VtkSummary {
    /// What it belongs to.
    pub location: VtkLocation,
    /// Name.
    pub name: String,
    /// Numbers per point or cell.
    pub components: usize,
    /// Points or cells that it has numbers for.
    pub tuples: usize,
    /// Least and greatest number of each component, NaN left out; `None` where there is no number.
    pub ranges: Vec<Option<[f64; 2]>>,
    /// How many values are NaN, of all components.
    pub not_numbers: usize,
}

impl VtkData {
    pub(super) fn new(kind: VtkKind) -> Self {
        Self {
            path: PathBuf::new(),
            kind,
            points: Vec::new(),
            cells: VtkCells::default(),
            image: None,
            point_data: Vec::new(),
            cell_data: Vec::new(),
            field_data: Vec::new(),
            time: None,
            skipped: Vec::new(),
        }
    }

    /// Number of points, of a regular grid too.
    pub fn point_count(&self) -> usize {
        self.image.as_ref().map_or(self.points.len(), VtkImage::point_count)
    }

    /// Number of cells, of a regular grid too.
    pub fn cell_count(&self) -> usize {
        self.image.as_ref().map_or(self.cells.len(), VtkImage::cell_count)
    }

    /// The column called `name` on points, on cells, or of the data set: the first found in this order.
    pub fn array(&self, name: &str) -> Option<&DataArray> {
        self.point_data.iter().chain(&self.cell_data).chain(&self.field_data).find(|a| a.name == name)
    }

    /// Names, shapes and ranges of all arrays: points', cells', then the data set's.
    pub fn summaries(&self) -> Vec<VtkSummary> {
        let located = |location, arrays: &[DataArray]| -> Vec<VtkSummary> {
            arrays.iter().map(|a| summary(location, a)).collect()
        };
        let mut all = located(VtkLocation::Point, &self.point_data);
        all.extend(located(VtkLocation::Cell, &self.cell_data));
        all.extend(located(VtkLocation::Field, &self.field_data));
        all
    }

    /// Takes the time from field data: VTK writes `TimeValue`, VisIt `TIME`.
    pub(super) fn find_time(&mut self) {
        let stated = self.field_data.iter().find(|a| a.name == "TimeValue" || a.name == "TIME");
        self.time = stated.and_then(|a| a.values.to_f64().first().copied()).filter(|t| t.is_finite());
    }
}

fn summary(location: VtkLocation, array: &DataArray) -> VtkSummary {
    let components = array.components.max(1);
    let mut ranges: Vec<Option<[f64; 2]>> = vec![None; components];
    let mut not_numbers = 0;
    for (k, x) in array.values.to_f64().into_iter().enumerate() {
        if x.is_nan() {
            not_numbers += 1;
        } else {
            let range = ranges[k % components].get_or_insert([x, x]);
            *range = [range[0].min(x), range[1].max(x)];
        }
    }
    VtkSummary {
        location,
        name: array.name.clone(),
        components: array.components,
        tuples: array.values.len() / components,
        ranges,
        not_numbers,
    }
}

/// Coordinates from an array of three numbers per point.
pub(super) fn points(values: &Values, position: Position) -> Parsed<Vec<[f64; 3]>> {
    let flat = values.to_f64();
    let (points, rest) = flat.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(Fault::damaged(position, format!("{} coordinates are no multiple of 3", flat.len())));
    }
    if points.len() > u32::MAX as usize - 1 {
        return Err(Fault::new(position, format!("{} points", points.len()), "split the file: 2³² − 2 points at most"));
    }
    Ok(points.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_belong_to_their_polyhedron_also_between_other_cells() {
        let mut cells = VtkCells::default();
        cells.push(10, [0, 1, 2, 3]);
        cells.push(42, [0, 1, 2]);
        cells.push_face([0, 1, 2]);
        cells.push_face([3, 2, 1, 0]);
        cells.push(10, [4, 5, 6, 7]);
        cells.push(42, [9]);
        cells.push_face([9, 8, 7]);
        let counts: Vec<usize> = (0..4).map(|c| cells.faces(c).count()).collect();
        assert_eq!(counts, [0, 2, 0, 1]);
        assert_eq!(cells.faces(1).nth(1).unwrap(), [3, 2, 1, 0]);
        assert_eq!(cells.faces(3).next().unwrap(), [9, 8, 7]);
        assert_eq!(cells.corners(2), [4, 5, 6, 7]);
    }

    #[test]
    fn a_summary_leaves_nan_out_and_keeps_components_apart() {
        let s = summary(VtkLocation::Point, &DataArray::floats("v", 2, vec![1.0, f64::NAN, -3.0, f64::NAN]));
        assert_eq!((s.tuples, s.ranges), (2, vec![Some([-3.0, 1.0]), None]));
    }
}
