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
        let mut found = Vec::new();
        let mut cuts = vec![0.0, 1.0];
        let mut in_face = false;
        self.cells.for_each_candidate(low, high, &mut |cell| {
            let mut fraction = 0.0;
            for (sign, planes) in &self.parts[cell as usize] {
                let clipped = clip(planes, start, along);
                fraction += sign * (clipped.to - clipped.from).max(0.0);
                if clipped.to > clipped.from {
                    in_face |= clipped.in_face;
                    cuts.extend([clipped.from, clipped.to]);
                }
            }
            found.push((cell, fraction));
        });
        if in_face {
            return self.fractions_by_middles(cuts, start, along, scratch, emit);
        }
        found.into_iter().filter(|&(_, fraction)| fraction > 0.0).for_each(|(cell, fraction)| emit(cell, fraction));
    }

    /// As [`Segments::fractions`] where the segment lies in a face or along an edge: parts on both sides have it, and each
    /// piece between two cuts goes to the one cell that is found at its middle.
    fn fractions_by_middles(
        &self,
        mut cuts: Vec<f64>,
        start: [f64; 3],
        along: [f64; 3],
        scratch: &mut C::Scratch,
        mut emit: impl FnMut(u32, f64),
    ) {
        cuts.sort_by(f64::total_cmp);
        for piece in cuts.windows(2).filter(|piece| piece[1] > piece[0]) {
            let middle = 0.5 * (piece[0] + piece[1]);
            let at = std::array::from_fn(|k| start[k] + middle * along[k]);
            if let Some(cell) = self.cells.locate(at, scratch) {
                emit(cell, piece[1] - piece[0]);
            }
        }
    }
}

/// The part of a segment that is behind all planes, as fractions of its length.
struct Clipped {
    from: f64,
    to: f64,
    /// Whether it lies in one of the planes, or so near that both cells beside it round where they cut.
    in_face: bool,
}

/// Distance from a plane, relative to coordinates, below which the quotient that says where it is crossed has few digits left.
const NEAR: f64 = 1e-9;

fn clip(planes: &Planes, start: [f64; 3], along: [f64; 3]) -> Clipped {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let largest = |v: [f64; 3]| v.into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let size = largest(start) + largest(along);
    let mut clipped = Clipped { from: 0.0, to: 1.0, in_face: false };
    for &(normal, offset) in planes {
        let (height, rate) = (dot(normal, start) - offset, dot(normal, along));
        let (scale, farther) = (largest(normal) * size + offset.abs(), height.abs().max((height + rate).abs()));
        clipped.in_face |= farther <= NEAR * scale;
        // Rounding of both products; neighbours round the same plane differently.
        if farther <= 16.0 * f64::EPSILON * scale {
            continue;
        }
        if rate == 0.0 {
            if height > 0.0 {
                clipped.to = clipped.from;
                return clipped;
            }
            continue;
        }
        let t = -height / rate;
        if rate > 0.0 {
            clipped.to = clipped.to.min(t);
        } else {
            clipped.from = clipped.from.max(t);
        }
    }
    clipped
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
