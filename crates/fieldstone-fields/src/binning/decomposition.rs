//! Exact overlap by the method of caps, wedges and cones.

use fieldstone_geometry::decomposition::{DecompositionElement, overlap_volume};
use fieldstone_geometry::{Ball, ElementKind};
use fieldstone_mesh::Cells;
use rayon::prelude::*;

use crate::FieldsError;

/// Every cell as a signed sum of elements that the method can take.
pub(super) struct Elements {
    ends: Vec<usize>,
    elements: Vec<(f64, DecompositionElement)>,
}

impl Elements {
    pub fn new<C: Cells>(cells: &C) -> Result<Self, FieldsError> {
        let per_cell: Vec<Vec<(f64, DecompositionElement)>> = (0..cells.cell_count())
            .into_par_iter()
            .map(|cell| {
                let mut parts = Vec::new();
                let (mut failure, mut flat) = (None, None);
                cells.for_each_element(cell, &mut |sign, kind, corners| match build(kind, corners) {
                    Err(source) if kind == ElementKind::Tetrahedron => flat = Some(source),
                    Err(source) => failure = Some(source),
                    Ok(element) => parts.push((sign, element)),
                });
                // A part of a cell that rounding has made flat holds nothing that would be missed; a cell that has no
                // other part would be missed as a whole.
                match failure.or(flat.filter(|_| parts.is_empty())) {
                    Some(source) => Err(FieldsError::Decomposition { cell, source }),
                    None => Ok(parts),
                }
            })
            .collect::<Result<_, _>>()?;
        let mut ends = Vec::with_capacity(per_cell.len());
        let mut elements = Vec::new();
        for parts in per_cell {
            elements.extend(parts);
            ends.push(elements.len());
        }
        Ok(Self { ends, elements })
    }

    pub fn bin<C: Cells>(&self, cells: &C, ball: &Ball, out: &mut Vec<(u32, f64)>) {
        let (centre, r) = (ball.centre(), ball.radius());
        cells.for_each_candidate(centre.map(|x| x - r), centre.map(|x| x + r), &mut |cell| {
            let at = cell as usize;
            let start = if at == 0 { 0 } else { self.ends[at - 1] };
            let parts = &self.elements[start..self.ends[at]];
            let volume: f64 = parts.iter().map(|(sign, element)| sign * overlap_volume(ball, element)).sum();
            if volume > 0.0 {
                out.push((cell, volume.min(cells.cell_volume(at))));
            }
        });
    }
}

fn build(
    kind: ElementKind,
    corners: &[[f64; 3]],
) -> Result<DecompositionElement, fieldstone_geometry::decomposition::DecompositionElementError> {
    let at = |k: usize| corners.get(k).copied().unwrap_or([f64::NAN; 3]);
    match kind {
        ElementKind::Wedge => DecompositionElement::wedge(std::array::from_fn(at)),
        ElementKind::Hexahedron => DecompositionElement::hexahedron(std::array::from_fn(at)),
        _ => DecompositionElement::tetrahedron(std::array::from_fn(at)),
    }
}
