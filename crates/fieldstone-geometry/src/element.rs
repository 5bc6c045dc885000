//! Element kinds, their faces, and the two orders in which corners are commonly listed.

/// Shape of a mesh element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ElementKind {
    /// Four corners, four triangles.
    Tetrahedron,
    /// Five corners: a quadrilateral and four triangles.
    Pyramid,
    /// Six corners: two triangles and three quadrilaterals.
    Wedge,
    /// Eight corners, six quadrilaterals.
    Hexahedron,
    /// Any closed polyhedron, given by its faces.
    Polyhedron,
}

/// Order in which a file or a caller lists the corners of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CornerOrder {
    /// VTK's: as [`CornerOrder::Cgns`] but the wedge's two triangles are wound the other way round.
    #[default]
    Vtk,
    /// CGNS's: bottom counter-clockwise seen from inside the element's top, then the top likewise.
    Cgns,
}

impl ElementKind {
    /// The four kinds with a fixed number of corners.
    pub const STANDARD: [Self; 4] = [Self::Tetrahedron, Self::Pyramid, Self::Wedge, Self::Hexahedron];

    /// Number of corners; `None` for a general polyhedron.
    pub fn corner_count(self) -> Option<usize> {
        match self {
            Self::Tetrahedron => Some(4),
            Self::Pyramid => Some(5),
            Self::Wedge => Some(6),
            Self::Hexahedron => Some(8),
            Self::Polyhedron => None,
        }
    }

    /// Corners of each face in CGNS numbering, counter-clockwise seen from outside; empty for a polyhedron.
    ///
    /// ```
    /// use fieldstone_geometry::ElementKind;
    /// assert_eq!(ElementKind::Hexahedron.faces().len(), 6);
    /// assert_eq!(ElementKind::Wedge.faces()[0], [2, 1, 0]);
    /// ```
    pub fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Self::Tetrahedron => &[&[2, 1, 0], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
            Self::Pyramid => &[&[3, 2, 1, 0], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]],
            Self::Wedge => &[&[2, 1, 0], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5], &[3, 4, 5]],
            Self::Hexahedron => {
                &[&[3, 2, 1, 0], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7], &[4, 5, 6, 7]]
            }
            Self::Polyhedron => &[],
        }
    }

    /// Position in CGNS order of each corner listed in `order`; its own inverse.
    pub fn to_cgns(self, order: CornerOrder) -> &'static [usize] {
        match (self, order) {
            (Self::Wedge, CornerOrder::Vtk) => &[0, 2, 1, 3, 5, 4],
            _ => &[0, 1, 2, 3, 4, 5, 6, 7][..self.corner_count().unwrap_or(0)],
        }
    }

    /// Corners in the order that mirrors the element, which turns a negative volume into a positive one.
    pub fn mirrored(self) -> &'static [usize] {
        match self {
            Self::Tetrahedron => &[0, 2, 1, 3],
            Self::Pyramid => &[0, 3, 2, 1, 4],
            Self::Wedge => &[0, 2, 1, 3, 5, 4],
            Self::Hexahedron => &[0, 3, 2, 1, 4, 7, 6, 5],
            Self::Polyhedron => &[],
        }
    }

    /// Lower-case name, as messages and files use it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tetrahedron => "tetrahedron",
            Self::Pyramid => "pyramid",
            Self::Wedge => "wedge",
            Self::Hexahedron => "hexahedron",
            Self::Polyhedron => "polyhedron",
        }
    }
}

impl std::fmt::Display for ElementKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
