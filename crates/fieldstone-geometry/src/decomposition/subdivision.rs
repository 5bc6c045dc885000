//! Hexahedra and wedges as several simpler elements (Sec. 4.5, and the meshes of Fig. 10).
//!
//! Corners are in CGNS order ([`ElementKind::faces`](crate::ElementKind::faces) shows it) and every part is oriented
//! as its parent. Sub-volumes add up to the element with planar faces; warped quadrilaterals are replaced by the
//! triangles named, which two neighbours share only if they choose the same diagonals: of these splits only the one into
//! 24 tetrahedra looks alike from both sides of any face.

/// Corners of a tetrahedron.
pub type TetrahedronCorners = [[f64; 3]; 4];
/// Corners of a wedge.
pub type WedgeCorners = [[f64; 3]; 6];
/// Corners of a hexahedron.
pub type HexahedronCorners = [[f64; 3]; 8];

fn pick<const N: usize, const M: usize>(corners: &[[f64; 3]], parts: [[usize; M]; N]) -> [[[f64; 3]; M]; N] {
    parts.map(|part| part.map(|corner| corners[corner]))
}

fn mean(corners: &[[f64; 3]]) -> [f64; 3] {
    let share = 1.0 / corners.len() as f64;
    [0, 1, 2].map(|axis| corners.iter().map(|c| c[axis] * share).sum())
}

/// Three tetrahedra that fill a wedge, without new corners.
///
/// The quadrilaterals are cut along the diagonals 0–4, 1–5 and 0–5.
///
/// Source: `strobl2016`, Sec. 4.5; `dompierre1999`.
pub fn wedge_to_3_tetrahedra(wedge: &WedgeCorners) -> [TetrahedronCorners; 3] {
    pick(wedge, [[0, 1, 2, 5], [0, 1, 5, 4], [0, 4, 5, 3]])
}

/// Two wedges that fill a hexahedron, cut along the plane of corners 0, 2, 4 and 6.
///
/// Source: `strobl2016`, Sec. 5.1.
pub fn hexahedron_to_2_wedges(hexahedron: &HexahedronCorners) -> [WedgeCorners; 2] {
    pick(hexahedron, [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]])
}

/// Five tetrahedra that fill a hexahedron: one at each of corners 1, 3, 4, 6, and the one that is left.
///
/// Source: `strobl2016`, Sec. 4.5 and 5.1; `dompierre1999`.
///
/// ```
/// use fieldstone_geometry::decomposition::{DecompositionElement, hexahedron_to_5_tetrahedra};
/// let cube = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.],
///             [0., 0., 1.], [1., 0., 1.], [1., 1., 1.], [0., 1., 1.]];
/// let mut total = 0.0;
/// for corners in hexahedron_to_5_tetrahedra(&cube) {
///     total += DecompositionElement::tetrahedron(corners)?.volume();
/// }
/// assert!((total - 1.0).abs() < 1e-15);
/// # Ok::<(), fieldstone_geometry::decomposition::DecompositionElementError>(())
/// ```
pub fn hexahedron_to_5_tetrahedra(hexahedron: &HexahedronCorners) -> [TetrahedronCorners; 5] {
    pick(hexahedron, [[0, 1, 2, 5], [0, 2, 3, 7], [0, 5, 7, 4], [2, 7, 5, 6], [0, 2, 7, 5]])
}

/// Six tetrahedra that fill a hexahedron, all around the diagonal from corner 0 to corner 6.
///
/// Source: `strobl2016`, Sec. 4.5 and 5.1; `dompierre1999`.
pub fn hexahedron_to_6_tetrahedra(hexahedron: &HexahedronCorners) -> [TetrahedronCorners; 6] {
    pick(hexahedron, [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]])
}

/// Four tetrahedra that fill a tetrahedron: its centroid with each of its faces.
///
/// Source: `strobl2016`, Sec. 5.1 ("splitting each tetrahedron into four smaller tetrahedra").
pub fn tetrahedron_to_4_tetrahedra(tetrahedron: &TetrahedronCorners) -> [TetrahedronCorners; 4] {
    let centroid = mean(tetrahedron);
    // A corner moved to the centroid leaves the orientation as it was.
    [0, 1, 2, 3].map(|moved| {
        let mut part = *tetrahedron;
        part[moved] = centroid;
        part
    })
}

/// Twenty tetrahedra that fill a hexahedron: the five of [`hexahedron_to_5_tetrahedra`], each split around its
/// centroid.
///
/// Source: `strobl2016`, Sec. 5.1.
pub fn hexahedron_to_20_tetrahedra(hexahedron: &HexahedronCorners) -> [TetrahedronCorners; 20] {
    let mut parts = [TetrahedronCorners::default(); 20];
    for (i, tetrahedron) in hexahedron_to_5_tetrahedra(hexahedron).iter().enumerate() {
        parts[4 * i..4 * i + 4].copy_from_slice(&tetrahedron_to_4_tetrahedra(tetrahedron));
    }
    parts
}

/// Twenty-four tetrahedra that fill a hexahedron: its centre, a face's centre, and an edge of that face.
///
/// Symmetric, and a warped face shared by two hexahedra is cut alike on both sides. The paper gets a mesh of 24 by
/// splitting each of the six tetrahedra of [`hexahedron_to_6_tetrahedra`] into four; for that, use
/// [`tetrahedron_to_4_tetrahedra`].
///
/// Source: `strobl2016`, Sec. 4.5 and Fig. 10 (the number).
pub fn hexahedron_to_24_tetrahedra(hexahedron: &HexahedronCorners) -> [TetrahedronCorners; 24] {
    let centre = mean(hexahedron);
    let mut parts = [TetrahedronCorners::default(); 24];
    for (i, face) in crate::ElementKind::Hexahedron.faces().iter().enumerate() {
        let corners = [0, 1, 2, 3].map(|k| hexahedron[face[k]]);
        let face_centre = mean(&corners);
        for k in 0..4 {
            // The face runs counter-clockwise seen from outside; the centre looks at it from inside.
            parts[4 * i + k] = [corners[(k + 1) % 4], corners[k], face_centre, centre];
        }
    }
    parts
}
