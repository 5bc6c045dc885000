//! Gmsh's element types.

use fieldstone_geometry::ElementKind;

use crate::IoError;

use super::input::Input;

/// What is done with an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Use {
    /// It becomes a cell.
    Cell(ElementKind),
    /// It is no volume and is passed over; its number of nodes.
    Skip(usize),
}

impl Use {
    pub(super) fn nodes(self) -> usize {
        match self {
            Self::Cell(kind) => kind.corner_count().unwrap_or(0),
            Self::Skip(nodes) => nodes,
        }
    }
}

/// What to do with elements of a type by its number.
pub(super) fn use_of(kind: i64, input: &Input, at: usize) -> Result<Use, IoError> {
    // Number of nodes of the types without volume: points, lines, triangles, quadrangles of the orders 1 to 5.
    let skip = match kind {
        4 => return Ok(Use::Cell(ElementKind::Tetrahedron)),
        5 => return Ok(Use::Cell(ElementKind::Hexahedron)),
        6 => return Ok(Use::Cell(ElementKind::Wedge)),
        7 => return Ok(Use::Cell(ElementKind::Pyramid)),
        15 => 1,
        1 => 2,
        8 => 3,
        26 => 4,
        27 => 5,
        28 => 6,
        2 => 3,
        9 => 6,
        20 => 9,
        21 => 10,
        22 => 12,
        23 | 24 => 15,
        25 => 21,
        3 => 4,
        16 => 8,
        10 => 9,
        36 => 16,
        37 => 25,
        38 => 36,
        _ => {
            let name = match kind {
                11 => "tetrahedra with 10 nodes",
                12 => "hexahedra with 27 nodes",
                13 => "prisms with 18 nodes",
                14 => "pyramids with 14 nodes",
                17 => "hexahedra with 20 nodes",
                18 => "prisms with 15 nodes",
                19 => "pyramids with 13 nodes",
                29..=31 => "tetrahedra of third or higher order",
                92..=98 => "hexahedra of third or higher order",
                _ => "elements that are neither of first order nor known here",
            };
            return Err(input.error_at(
                at,
                format!("the mesh has {name} (type {kind}), whose faces are curved"),
                "only first-order cells can be read: mesh with Mesh.ElementOrder=1, or gmsh -order 1",
            ));
        }
    };
    Ok(Use::Skip(skip))
}
