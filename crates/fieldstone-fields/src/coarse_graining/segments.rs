//! The fraction of a branch that lies in each cell.

use fieldstone_geometry::ElementKind;
use fieldstone_mesh::Cells;
use rayon::prelude::*;

/// Cells as signed convex parts, each a set of planes: what a segment is clipped by.
pub(super) struct Segments<'a, C: Cells> {
    cells: &'a C,
    /// Signed parts of each cell; none where the cells clip segments themselves.
    parts: Vec<Vec<(f64, Planes)>>,
}

/// Planes (outward normal, offset) of a convex part.
type Planes = Vec<([f64; 3], f64)>;

impl<'a, C: Cells> Segments<'a, C> {
    pub fn new(cells: &'a C) -> Self {
        let clips = cells.clip_segment([0.0; 3], [0.0; 3], &mut |_, _| ());
        let parts = if clips {
            Vec::new()
        } else {
            (0..cells.cell_count())
                .into_par_iter()
                .map(|cell| {
                    let mut parts = Vec::new();
                    cells.for_each_element(cell, &mut |sign, kind, corners| parts.push((sign, planes(kind, corners))));
                    parts
                })
                .collect()
        };
        Self { cells, parts }
    }

    pub fn locate(&self, at: [f64; 3], scratch: &mut C::Scratch) -> Option<u32> {
        self.cells.locate(at, scratch)
    }

    /// Calls `emit` with the cells that the segment passes and the fraction of its length in each.
    ///
    /// A point (a segment of no length) is all in the cell that holds it.
    pub fn fractions(
        &self,
        start: [f64; 3],
        along: [f64; 3],
        scratch: &mut C::Scratch,
        mut emit: impl FnMut(u32, f64),
    ) {
        if along == [0.0; 3] {
            if let Some(cell) = self.cells.locate(start, scratch) {
                emit(cell, 1.0);
            }
            return;
        }
        let low: [f64; 3] = std::array::from_fn(|k| start[k] + along[k].min(0.0));
        let high: [f64; 3] = std::array::from_fn(|k| start[k] + along[k].max(0.0));
        if self.cells.clip_segment(start, along, &mut emit) {
            return;
        }
        self.cells.for_each_candidate(low, high, &mut |cell| {
            let fraction: f64 =
                self.parts[cell as usize].iter().map(|(sign, planes)| sign * clip(planes, start, along)).sum();
            if fraction > 0.0 {
                emit(cell, fraction);
            }
        });
    }
}

/// Fraction of the segment behind all planes.
fn clip(planes: &Planes, start: [f64; 3], along: [f64; 3]) -> f64 {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for &(normal, offset) in planes {
        let (height, rate) = (dot(normal, start) - offset, dot(normal, along));
        if rate == 0.0 {
            if height > 0.0 {
                return 0.0;
            }
            continue;
        }
        let t = -height / rate;
        if rate > 0.0 {
            to = to.min(t);
        } else {
            from = from.max(t);
        }
    }
    (to - from).max(0.0)
}

/// Planes of a convex element in CGNS order.
fn planes(kind: ElementKind, corners: &[[f64; 3]]) -> Planes {
    let faces: &[&[usize]] = match kind {
        ElementKind::Tetrahedron => &[&[0, 1, 2], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
        ElementKind::Pyramid => &[&[0, 1, 2, 3], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]],
        ElementKind::Wedge => &[&[0, 1, 2], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]],
        _ => &[&[0, 1, 2, 3], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]],
    };
    let middle: [f64; 3] =
        std::array::from_fn(|k| corners.iter().map(|c| c[k]).sum::<f64>() / corners.len().max(1) as f64);
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    faces
        .iter()
        .map(|face| {
            // Half the cross product of the diagonals is the area vector; of a triangle that of two sides.
            let (p, q) = if face.len() == 4 {
                (minus(corners[face[2]], corners[face[0]]), minus(corners[face[3]], corners[face[1]]))
            } else {
                (minus(corners[face[1]], corners[face[0]]), minus(corners[face[2]], corners[face[0]]))
            };
            let n = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
            let at = corners[face[0]];
            let towards = minus(middle, at);
            let inward = n[0] * towards[0] + n[1] * towards[1] + n[2] * towards[2] > 0.0;
            let n = if inward { n.map(|x| -x) } else { n };
            (n, n[0] * at[0] + n[1] * at[1] + n[2] * at[2])
        })
        .collect()
}
