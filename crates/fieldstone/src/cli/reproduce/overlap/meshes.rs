//! The meshes of Sec. 5.1: a lattice of unit cells, sheared or not, each cell split into elements.

use anyhow::Context;
use fieldstone::geometry::decomposition::{
    DecompositionElement, HexahedronCorners, hexahedron_to_2_wedges, hexahedron_to_5_tetrahedra,
    hexahedron_to_6_tetrahedra, hexahedron_to_20_tetrahedra, tetrahedron_to_4_tetrahedra,
};
use fieldstone::geometry::{CornerOrder, ElementKind, Orientation, Polyhedron};

/// What each hexahedron is split into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Split {
    Hexahedra,
    Wedges,
    Tetrahedra5,
    Tetrahedra6,
    Tetrahedra20,
    Tetrahedra24,
}

impl Split {
    pub const ALL: [Self; 6] =
        [Self::Hexahedra, Self::Wedges, Self::Tetrahedra5, Self::Tetrahedra6, Self::Tetrahedra20, Self::Tetrahedra24];

    /// Name in tables and legends.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hexahedra => "hexahedra",
            Self::Wedges => "2 wedges",
            Self::Tetrahedra5 => "5 tetrahedra",
            Self::Tetrahedra6 => "6 tetrahedra",
            Self::Tetrahedra20 => "20 tetrahedra",
            Self::Tetrahedra24 => "24 tetrahedra",
        }
    }

    /// Elements per cell.
    pub fn count(self) -> usize {
        match self {
            Self::Hexahedra => 1,
            Self::Wedges => 2,
            Self::Tetrahedra5 => 5,
            Self::Tetrahedra6 => 6,
            Self::Tetrahedra20 => 20,
            Self::Tetrahedra24 => 24,
        }
    }

    /// Calls `visit` with kind and corners (CGNS order) of each element of a cell.
    fn for_each(
        self,
        cell: &HexahedronCorners,
        mut visit: impl FnMut(ElementKind, &[[f64; 3]]) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let mut tetrahedra = |list: &[[[f64; 3]; 4]]| list.iter().try_for_each(|t| visit(ElementKind::Tetrahedron, t));
        match self {
            Self::Tetrahedra5 => tetrahedra(&hexahedron_to_5_tetrahedra(cell)),
            Self::Tetrahedra6 => tetrahedra(&hexahedron_to_6_tetrahedra(cell)),
            Self::Tetrahedra20 => tetrahedra(&hexahedron_to_20_tetrahedra(cell)),
            // As in the paper: each of the six split around its centroid.
            Self::Tetrahedra24 => {
                hexahedron_to_6_tetrahedra(cell).iter().try_for_each(|t| tetrahedra(&tetrahedron_to_4_tetrahedra(t)))
            }
            Self::Hexahedra => visit(ElementKind::Hexahedron, cell),
            Self::Wedges => hexahedron_to_2_wedges(cell).iter().try_for_each(|w| visit(ElementKind::Wedge, w)),
        }
    }
}

/// An element as both methods take it.
pub(super) struct Element {
    pub polyhedron: Polyhedron,
    pub decomposed: DecompositionElement,
}

/// The infinite lattice of unit cells, one of them around the origin, sheared along x in proportion to y.
///
/// Neighbouring cells get their common corners from the same formula, so the elements leave no gap however the shear
/// rounds, and all faces stay planar to the last bit: a corner's shift depends on its y alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice {
    pub split: Split,
    tangent: f64,
}

impl Lattice {
    /// `angle` in degrees from the y axis, 0 for none.
    pub fn new(split: Split, angle: f64) -> Self {
        // tan 45° is exactly 1; in radians it would not be.
        let tangent = if angle == 45.0 { 1.0 } else { angle.to_radians().tan() };
        Self { split, tangent }
    }

    /// Indices of cells that cover $[-b, b]^3$, row by row; those of the paper where there is no shear.
    pub fn cells_covering(&self, b: f64) -> impl Iterator<Item = [i32; 3]> + use<> {
        let n = (b - 0.5).ceil().max(1.0) as i32;
        let tangent = self.tangent;
        (-n..=n).flat_map(move |k| {
            (-n..=n).flat_map(move |j| {
                let shifts = [f64::from(j) - 0.5, f64::from(j) + 0.5].map(|y| tangent * y);
                let first = -n - shifts[1].ceil() as i32;
                let last = n - shifts[0].floor() as i32;
                (first..=last).map(move |i| [i, j, k])
            })
        })
    }

    /// The eight corners of a cell, in CGNS order.
    pub fn corners(&self, cell: [i32; 3]) -> HexahedronCorners {
        const ORDER: [[i32; 3]; 8] =
            [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
        ORDER.map(|at| {
            let [x, y, z] = std::array::from_fn(|axis| f64::from(cell[axis] + at[axis]) - 0.5);
            [x + self.tangent * y, y, z]
        })
    }

    /// The elements of a cell, at their place.
    pub fn elements(&self, cell: [i32; 3], out: &mut Vec<Element>) -> anyhow::Result<()> {
        out.clear();
        let place = || format!("cell {cell:?} of the mesh of {}", self.split.name());
        self.split
            .for_each(&self.corners(cell), |kind, corners| {
                let at = |k: usize| corners[k];
                let decomposed = match kind {
                    ElementKind::Hexahedron => DecompositionElement::hexahedron(std::array::from_fn(at)),
                    ElementKind::Wedge => DecompositionElement::wedge(std::array::from_fn(at)),
                    _ => DecompositionElement::tetrahedron(std::array::from_fn(at)),
                }?;
                let polyhedron = Polyhedron::element(kind, CornerOrder::Cgns, corners, Orientation::Refuse)?;
                out.push(Element { polyhedron, decomposed });
                Ok(())
            })
            .with_context(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_elements_fill_each_cell_and_the_cells_the_box() {
        for angle in [0.0, 45.0, 80.0] {
            for split in Split::ALL {
                let lattice = Lattice::new(split, angle);
                let mut elements = Vec::new();
                for cell in [[0, 0, 0], [3, -2, 1], [-20, 19, 7]] {
                    lattice.elements(cell, &mut elements).unwrap();
                    assert_eq!(elements.len(), split.count());
                    let total: f64 = elements.iter().map(|e| e.polyhedron.volume()).sum();
                    assert!((total - 1.0).abs() < 2e-13, "{} {angle}: {total}", split.name());
                }
            }
        }
        assert_eq!(Lattice::new(Split::Hexahedra, 0.0).cells_covering(0.55).count(), 27);
        assert_eq!(Lattice::new(Split::Hexahedra, 0.0).cells_covering(20.5).count(), 68_921);
    }

    #[test]
    fn a_sheared_mesh_reaches_as_far_as_it_promises() {
        let (lattice, b) = (Lattice::new(Split::Hexahedra, 70.0), 2.3);
        let cells: Vec<_> = lattice.cells_covering(b).collect();
        for corner in 0..8 {
            let at: [f64; 3] = [0, 1, 2].map(|k| if corner >> k & 1 == 0 { -b } else { b });
            let j = at[1].round();
            let i = (at[0] - lattice.tangent * at[1]).round();
            assert!(cells.contains(&[i as i32, j as i32, at[2].round() as i32]), "{at:?}");
        }
    }
}
