//! Meshes built in the test: shared faces, shapes, the face-once path against the per-element path.

#![allow(clippy::unwrap_used)]

use fieldstone_geometry::{Ball, CornerOrder, ElementKind, Orientation, PROMISE, Polyhedron, overlap, overlap_volume};
use fieldstone_mesh::{CellList, Cells, Grid, Mesh, MeshError, MeshParts};
use fieldstone_testing::Random;
use proptest::prelude::*;

/// n³ hexahedra on the unit cube, their inner points moved by up to `jitter` cells.
fn hexahedra(n: usize, jitter: f64, seed: u64) -> Mesh {
    let mut random = Random(seed);
    let mut noise = || random.uniform(-1.0, 1.0) * jitter / n as f64;
    let mut points = Vec::new();
    for k in 0..=n {
        for j in 0..=n {
            for i in 0..=n {
                let inner = [i, j, k].iter().all(|&x| x > 0 && x < n);
                let at = [i, j, k].map(|x| x as f64 / n as f64);
                points.push(if inner { at.map(|x| x + noise()) } else { at });
            }
        }
    }
    let mut cells = CellList::new();
    let p = |i: usize, j: usize, k: usize| (i + (n + 1) * (j + (n + 1) * k)) as u32;
    for k in 0..n {
        for j in 0..n {
            for i in 0..n {
                let corners = [
                    p(i, j, k),
                    p(i + 1, j, k),
                    p(i + 1, j + 1, k),
                    p(i, j + 1, k),
                    p(i, j, k + 1),
                    p(i + 1, j, k + 1),
                    p(i + 1, j + 1, k + 1),
                    p(i, j + 1, k + 1),
                ];
                cells.push(ElementKind::Hexahedron, CornerOrder::Vtk, &corners).unwrap();
            }
        }
    }
    Mesh::from_cells(points, cells).unwrap()
}

/// One of each standard element, stacked into a conforming mesh: cube, pyramid on top, wedge beside, tetrahedron.
fn mixed() -> Mesh {
    let points = vec![
        [0., 0., 0.],
        [1., 0., 0.],
        [1., 1., 0.],
        [0., 1., 0.],
        [0., 0., 1.],
        [1., 0., 1.],
        [1., 1., 1.],
        [0., 1., 1.],
        [0.5, 0.5, 2.],
        [2., 0., 0.],
        [2., 1., 0.],
        [1.0, 0.5, 2.5],
    ];
    let mut cells = CellList::new();
    cells.push(ElementKind::Hexahedron, CornerOrder::Vtk, &[0, 1, 2, 3, 4, 5, 6, 7]).unwrap();
    cells.push(ElementKind::Pyramid, CornerOrder::Vtk, &[4, 5, 6, 7, 8]).unwrap();
    cells.push(ElementKind::Wedge, CornerOrder::Cgns, &[1, 9, 5, 2, 10, 6]).unwrap();
    cells.push(ElementKind::Tetrahedron, CornerOrder::Vtk, &[5, 6, 8, 11]).unwrap();
    Mesh::from_cells(points, cells).unwrap()
}

#[test]
fn faces_are_shared_and_volumes_add_up() {
    let mesh = hexahedra(4, 0.0, 1);
    assert_eq!(mesh.parts().neighbour.len(), 3 * 4 * 4 * 3);
    assert_eq!(mesh.parts().owner.len() - mesh.parts().neighbour.len(), 6 * 16);
    assert!(mesh.cell_volumes().iter().all(|v| (v * 64.0 - 1.0).abs() < 1e-14));
    assert_eq!((mesh.warped_faces(), mesh.concave_cells()), (0, 0));

    let warped = hexahedra(4, 0.3, 1);
    assert!((warped.cell_volumes().iter().sum::<f64>() - 1.0).abs() < 1e-14);
    assert!(warped.warped_faces() > 50 && warped.concave_cells() > 10);
}

#[test]
fn standard_elements_are_recognised_from_faces_alone() {
    let mesh = mixed();
    assert!((mesh.cell_volumes()[2] - 0.5).abs() < 1e-15);
    let again = Mesh::new(mesh.parts().clone()).unwrap();
    for cell in 0..4 {
        assert_eq!(again.cell_kind(cell), ElementKind::STANDARD[[3, 1, 2, 0][cell]]);
        // Whatever corner comes first, the element named is the same one.
        let corners: Vec<[f64; 3]> =
            again.cell_corners(cell).unwrap().iter().map(|&k| again.parts().points[k as usize]).collect();
        let element = Polyhedron::element(again.cell_kind(cell), CornerOrder::Cgns, &corners, Orientation::Refuse);
        assert!((element.unwrap().volume() - mesh.cell_volumes()[cell]).abs() < 1e-15);
    }
}

#[test]
fn wedges_of_either_winding_and_inverted_elements_are_taken_and_counted() {
    let points = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 0., 1.], [0., 1., 1.]];
    for order in [CornerOrder::Vtk, CornerOrder::Cgns] {
        let mut cells = CellList::new();
        cells.push(ElementKind::Wedge, order, &[0, 1, 2, 3, 4, 5]).unwrap();
        let mesh = Mesh::from_cells(points.clone(), cells).unwrap();
        assert_eq!((mesh.cell_volumes()[0], mesh.inverted_elements()), (0.5, 0));
    }
    let mut cells = CellList::new();
    cells.push(ElementKind::Tetrahedron, CornerOrder::Vtk, &[0, 2, 1, 3]).unwrap();
    let mesh = Mesh::from_cells(points, cells).unwrap();
    assert_eq!(mesh.inverted_elements(), 1);
    assert!(mesh.inverted_cells().is_empty());
}

#[test]
fn an_inverted_cell_is_listed_and_still_measured() {
    let mut parts = mixed().parts().clone();
    // All faces of a lone tetrahedron, pointing inwards.
    parts.points = vec![[0.; 3], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    parts.face_points = vec![0, 1, 2, 3, 1, 0, 3, 2, 1, 3, 0, 2];
    parts.face_ends = vec![3, 6, 9, 12];
    parts.owner = vec![0; 4];
    parts.neighbour = vec![];
    parts.patches = vec![];
    let mesh = Mesh::new(parts).unwrap();
    assert_eq!(mesh.inverted_cells(), [0]);
    let ball = Ball::new([0.0; 3], 0.2).unwrap();
    let mut out = Vec::new();
    mesh.overlap_ball(&ball, &mut mesh.scratch(), &mut out);
    assert!((out[0].1 - ball.volume() / 8.0).abs() < 1e-16);
    assert_eq!(mesh.locate([0.1; 3], &mut mesh.scratch()), Some(0));
}

fn compare_with_elements(mesh: &Mesh, ball: &Ball) -> Result<(), TestCaseError> {
    let mut found = vec![0.0; mesh.cell_count()];
    let mut out = Vec::new();
    mesh.overlap_ball(ball, &mut mesh.scratch(), &mut out);
    prop_assert!(out.windows(2).all(|w| w[0].0 < w[1].0));
    for &(cell, volume) in &out {
        found[cell as usize] = volume;
    }
    for (cell, &volume) in found.iter().enumerate() {
        let exact = overlap_volume(ball, &mesh.polyhedron(cell).unwrap());
        let scale = ball.volume().max(mesh.cell_volumes()[cell]);
        prop_assert!((volume - exact).abs() <= 1e-14 * scale, "cell {cell}: {volume:e} against {exact:e}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn each_face_once_equals_each_element_alone(
        centre in prop::array::uniform3(-0.2f64..1.2),
        radius in 0.02f64..0.8,
        jitter in 0.0f64..0.45,
        seed: u64,
    ) {
        let ball = Ball::new(centre, radius).unwrap();
        compare_with_elements(&hexahedra(3, jitter, seed), &ball)?;
    }

    #[test]
    fn centres_on_or_next_to_faces_edges_and_corners_are_no_special_case(
        twelfths in prop::array::uniform3(0i32..=12),
        nudge in prop::array::uniform3(-1.0f64..1.0),
        size in prop::sample::select(vec![0.0, 1e-17, 1e-12, 1e-9, 1e-5, 2e-3, 5e-3]),
        radius in prop::sample::select(vec![0.05, 1.0 / 12.0, 0.25, 1.0 / 3.0, 0.5]),
        jitter in prop::sample::select(vec![0.0, 0.3]),
        seed: u64,
    ) {
        let centre = std::array::from_fn(|k| f64::from(twelfths[k]) / 12.0 + size * nudge[k]);
        compare_with_elements(&hexahedra(3, jitter, seed), &Ball::new(centre, radius).unwrap())?;
        // And next to corners, edge middles and face centres of cells that are bent.
        let bent = hexahedra(3, 0.3, seed);
        let corners: Vec<[f64; 3]> =
            bent.cell_corners(13).unwrap().iter().map(|&k| bent.parts().points[k as usize]).collect();
        for take in [1, 2, 4] {
            let mean: [f64; 3] =
                std::array::from_fn(|k| corners[..take].iter().map(|c| c[k]).sum::<f64>() / take as f64);
            let centre = std::array::from_fn(|k| mean[k] + size * nudge[k]);
            compare_with_elements(&bent, &Ball::new(centre, radius).unwrap())?;
        }
    }

    #[test]
    fn mixed_elements_agree_too(centre in prop::array::uniform3(-0.2f64..2.5), radius in 0.02f64..2.0) {
        compare_with_elements(&mixed(), &Ball::new(centre, radius).unwrap())?;
    }

    #[test]
    fn a_ball_in_the_mesh_is_shared_out_completely(
        offset in prop::array::uniform3(-1.0f64..1.0),
        radius in 0.01f64..0.5,
        seed: u64,
    ) {
        let centre = offset.map(|x| 0.5 + x * (0.5 - radius));
        let mesh = hexahedra(5, 0.4, seed);
        let ball = Ball::new(centre, radius).unwrap();
        let mut out = Vec::new();
        mesh.overlap_ball(&ball, &mut mesh.scratch(), &mut out);
        let sum: f64 = out.iter().map(|p| p.1).sum();
        prop_assert!((sum / ball.volume() - 1.0).abs() < 1e-13, "{:e}", sum / ball.volume() - 1.0);
    }

    #[test]
    fn every_point_of_the_domain_has_exactly_one_cell_that_holds_it(
        point in prop::array::uniform3(0.0f64..1.0),
        seed: u64,
    ) {
        let mesh = hexahedra(3, 0.45, seed);
        let cell = mesh.locate(point, &mut mesh.scratch()).unwrap() as usize;
        // A tiny ball around the point lies in that cell, unless a face is nearer than its radius.
        let ball = Ball::new(point, 1e-7).unwrap();
        let inside = overlap_volume(&ball, &mesh.polyhedron(cell).unwrap());
        prop_assert!(inside > 0.2 * ball.volume());
    }

    #[test]
    fn a_box_in_the_mesh_is_shared_out_completely(
        low in prop::array::uniform3(0.0f64..0.6),
        extent in prop::array::uniform3(0.01f64..0.4),
        seed: u64,
    ) {
        let mesh = hexahedra(4, 0.4, seed);
        let high: [f64; 3] = std::array::from_fn(|k| low[k] + extent[k]);
        let mut out = Vec::new();
        mesh.overlap_cuboid(low, high, &mut mesh.scratch(), &mut out);
        let sum: f64 = out.iter().map(|p| p.1).sum();
        let volume: f64 = extent.iter().product();
        prop_assert!((sum / volume - 1.0).abs() < 1e-11, "{:e}", sum / volume - 1.0);
    }
}

#[test]
fn face_areas_are_those_of_the_elements_and_listed_once() {
    let mesh = hexahedra(3, 0.3, 5);
    let ball = Ball::new([0.45, 0.52, 0.5], 0.3).unwrap();
    let (mut cells, mut faces) = (Vec::new(), Vec::new());
    mesh.overlap_ball_areas(&ball, &mut mesh.scratch(), &mut cells, &mut faces);
    assert!(faces.windows(2).all(|w| w[0].0 < w[1].0));
    for c in &cells {
        let cell = c.cell as usize;
        let alone = overlap(&ball, &mesh.polyhedron(cell).unwrap());
        assert!((alone.volume - c.volume).abs() < 1e-15 && (alone.sphere_area - c.sphere_area).abs() < 1e-14);
        for (k, &face) in mesh.cell_faces(cell).iter().enumerate() {
            let area = faces.iter().find(|f| f.0 == face).map_or(0.0, |f| f.1);
            assert!((area - alone.face_areas[k]).abs() < 1e-14, "cell {cell} face {face}");
        }
    }
    let sphere: f64 = cells.iter().map(|c| c.sphere_area).sum();
    assert!((sphere - ball.surface_area()).abs() < 1e-14);
}

#[test]
fn broken_meshes_are_refused_with_the_culprit() {
    let good = mixed().parts().clone();
    let broken = |change: &dyn Fn(&mut MeshParts)| {
        let mut parts = good.clone();
        change(&mut parts);
        Mesh::new(parts).unwrap_err()
    };
    assert!(matches!(broken(&|p| p.points[3][1] = f64::NAN), MeshError::PointNotFinite { point: 3, .. }));
    assert!(matches!(broken(&|p| p.face_points[5] = 99), MeshError::PointOutOfRange { point: 99, .. }));
    assert!(matches!(broken(&|p| p.owner.truncate(3)), MeshError::Count { .. }));
    assert!(matches!(broken(&|p| p.face_points[0] = p.face_points[1]), MeshError::BadFace { face: 0, .. }));
    assert!(matches!(broken(&|p| p.owner[0] = p.neighbour[0]), MeshError::BadCells { face: 0, .. }));
    // A face given to another cell leaves a hole in its own.
    assert!(matches!(broken(&|p| *p.owner.last_mut().unwrap() = 0), MeshError::OpenCell { .. }));
    assert!(matches!(Mesh::new(MeshParts::default()), Err(MeshError::Empty)));
    assert!(matches!(broken(&|p| p.points.iter_mut().for_each(|x| x[2] = 0.0)), MeshError::NoVolume { .. }));
}

#[test]
fn a_polyhedron_without_faces_is_refused_with_its_number() {
    let mut cells = CellList::new();
    cells.push(ElementKind::Tetrahedron, CornerOrder::Vtk, &[0, 1, 2, 3]).unwrap();
    cells.push_polyhedron([]);
    let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(Mesh::from_cells(points, cells).unwrap_err(), MeshError::NoFaces { cell: 1 });
}

#[test]
fn a_damaged_cell_label_asks_for_no_memory() {
    let whole = hexahedra(1, 0.0, 0).parts().clone();
    for label in [6, u32::MAX - 2] {
        let mut parts = whole.clone();
        parts.owner[3] = label;
        let error = Mesh::new(parts).unwrap_err();
        // Six faces with a cell on one side: six cells at the very most.
        assert_eq!(error, MeshError::CellOutOfRange { face: 3, cell: label as usize, most: 6 });
    }
}

#[test]
fn cells_keep_the_promise_for_balls_of_any_size_and_count_what_that_takes() {
    let mesh = hexahedra(3, 0.3, 11);
    let elements: Vec<_> = (0..27).map(|cell| mesh.polyhedron(cell).unwrap()).collect();
    let mut scratch = mesh.scratch();
    let mut compared = 0;
    for exponent in -5..=5 {
        let radius = 0.3 * 10f64.powi(exponent);
        // Surfaces that pass through the middle of the mesh, and tiny balls in and around its corners.
        for k in 0..12 {
            let direction = [[0.6, 0.64, 0.48], [-0.8, 0.6, 0.0], [0.0, 0.28, -0.96]][k % 3];
            let from = [[0.5; 3], [0.34, 0.33, 0.32], [0.4, 0.6, 0.5], [1.0 / 3.0, 0.7, 0.2]][k / 3];
            let reach = if exponent < 0 { 0.7 * radius } else { radius };
            let ball = Ball::new([0, 1, 2].map(|k| from[k] + reach * direction[k]), radius).unwrap();
            let mut out = Vec::new();
            mesh.overlap_ball(&ball, &mut scratch, &mut out);
            for (cell, element) in elements.iter().enumerate() {
                let found = out.iter().find(|p| p.0 as usize == cell).map_or(0.0, |p| p.1);
                let exact = overlap_volume(&ball, element);
                let smaller = ball.volume().min(element.volume());
                assert!(
                    (found - exact).abs() <= 2.0 * PROMISE * smaller,
                    "r {radius}, cell {cell}: {found:e}, {exact:e}"
                );
                compared += usize::from(exact > 0.0 && exact < smaller);
            }
        }
    }
    let counts = mesh.path_counts(&scratch);
    assert!(
        compared > 300 && counts.beyond_f64 > 100 && counts.beyond_f64 < counts.evaluated,
        "{compared}, {counts:?}"
    );
}

#[test]
fn points_at_one_place_are_one_corner_however_large_the_ball() {
    // A prism, once as a wedge, once as a hexahedron of which two edges have their ends at one place.
    let wedge = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let hexahedron: Vec<[f64; 3]> = [0, 1, 2, 2, 3, 4, 5, 5].map(|k: usize| wedge[k]).to_vec();
    let mesh = |kind, points: Vec<[f64; 3]>| {
        let mut cells = CellList::new();
        cells.push(kind, CornerOrder::Cgns, &(0..points.len() as u32).collect::<Vec<_>>()).unwrap();
        Mesh::from_cells(points, cells).unwrap()
    };
    let meshes = [mesh(ElementKind::Wedge, wedge.to_vec()), mesh(ElementKind::Hexahedron, hexahedron)];
    for radius in [1e4, 1e6] {
        let ball = Ball::new([0.3, 0.3, 0.5 - radius], radius).unwrap();
        let exact = overlap_volume(&ball, &meshes[0].polyhedron(0).unwrap());
        for mesh in &meshes {
            let mut scratch = mesh.scratch();
            let mut found = Vec::new();
            mesh.overlap_ball(&ball, &mut scratch, &mut found);
            assert!((found[0].1 - exact).abs() <= PROMISE * exact, "r {radius}: {} against {exact}", found[0].1);
            assert_eq!(mesh.path_counts(&scratch).beyond_f64, 1);
        }
    }
}

/// Two unit cubes side by side, the first one's common face as the rings given.
fn two_cubes(common: &[&[u32]]) -> Mesh {
    let points = (0..12).map(|k| [k / 4, k & 1, (k / 2) & 1].map(f64::from)).collect();
    // Corners 4 to 7 are the common ones.
    let side = |a: u32, b: u32| {
        vec![
            vec![a, a + 1, b + 1, b],
            vec![a + 2, b + 2, b + 3, a + 3],
            vec![a, b, b + 2, a + 2],
            vec![a + 1, a + 3, b + 3, b + 1],
        ]
    };
    let mut cells = CellList::new();
    for (a, b, end) in [(0, 4, [0, 2, 3, 1]), (4, 8, [8, 9, 11, 10])] {
        let mut faces = side(a, b);
        faces.push(end.to_vec());
        faces.extend(common.iter().map(|ring| ring.to_vec()));
        cells.push_polyhedron(faces.iter().map(Vec::as_slice));
    }
    Mesh::from_cells(points, cells).unwrap()
}

#[test]
fn cells_with_several_common_faces_meet_once_with_the_sum_of_their_areas() {
    for common in [&[&[4, 5, 7, 6][..]][..], &[&[4, 5, 7], &[4, 7, 6]]] {
        let mesh = two_cubes(common);
        assert_eq!(mesh.parts().neighbour.len(), common.len());
        for cell in 0..2u32 {
            let mut met = Vec::new();
            mesh.for_each_neighbour(cell as usize, &mut |other, area| met.push((other, area)));
            assert_eq!(met, [(1 - cell, 1.0)]);
        }
    }
}

#[test]
fn elements_that_repeat_corners_are_what_is_left_of_them() {
    let points: Vec<[f64; 3]> = vec![
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [1.0, 1.0, 1.0],
        [0.0, 1.0, 1.0],
    ];
    let one = |corners: [u32; 8]| {
        let mut cells = CellList::new();
        cells.push(ElementKind::Hexahedron, CornerOrder::Vtk, &corners).unwrap();
        Mesh::from_cells(points.clone(), cells)
    };
    // Either winding, whichever corners are the same.
    for (corners, kind, volume) in [
        ([0, 1, 2, 2, 4, 5, 6, 6], ElementKind::Wedge, 0.5),
        ([0, 1, 2, 0, 4, 5, 6, 4], ElementKind::Wedge, 0.5),
        ([4, 5, 6, 4, 0, 1, 2, 0], ElementKind::Wedge, 0.5),
        ([0, 1, 2, 3, 6, 6, 6, 6], ElementKind::Pyramid, 1.0 / 3.0),
        ([0, 1, 2, 2, 5, 5, 5, 5], ElementKind::Tetrahedron, 1.0 / 6.0),
        // One face is bent: half way between the cube without one tetrahedron and without two.
        ([0, 1, 2, 3, 4, 4, 6, 7], ElementKind::Polyhedron, 0.75),
    ] {
        let mesh = one(corners).unwrap();
        assert_eq!(mesh.cell_kind(0), kind, "{corners:?}");
        assert!((mesh.cell_volumes()[0] - volume).abs() < 1e-15, "{corners:?}: {}", mesh.cell_volumes()[0]);
        let (ball, mut found) = (Ball::new([0.5; 3], 5.0).unwrap(), Vec::new());
        mesh.overlap_ball(&ball, &mut mesh.scratch(), &mut found);
        assert_eq!(found, [(0, mesh.cell_volumes()[0])]);
        if let Some(corners) = mesh.cell_corners(0) {
            let corners: Vec<_> = corners.iter().map(|&k| points[k as usize]).collect();
            let element = Polyhedron::element(kind, CornerOrder::Cgns, &corners, Orientation::Refuse).unwrap();
            assert!((element.volume() - volume).abs() < 1e-15);
        }
    }
    for flat in [[0, 1, 2, 3, 0, 1, 2, 3], [0, 1, 1, 0, 4, 5, 5, 4], [7; 8]] {
        let error = one(flat).unwrap_err();
        assert!(matches!(&error, MeshError::Collapsed { cell: 0, kind: ElementKind::Hexahedron, .. }), "{error}");
    }

    // The face that the wedge keeps is shared with its neighbour; a polyhedron may repeat corners, too.
    let mut cells = CellList::new();
    cells.push(ElementKind::Hexahedron, CornerOrder::Vtk, &[0, 1, 2, 2, 4, 5, 6, 6]).unwrap();
    cells.push_polyhedron([&[0, 2, 2, 3][..], &[4, 7, 6], &[0, 4, 6, 2], &[2, 6, 7, 3], &[3, 7, 4, 0], &[0, 2, 0, 2]]);
    let mesh = Mesh::from_cells(points.clone(), cells).unwrap();
    assert_eq!((mesh.parts().neighbour.len(), mesh.cell_volumes()), (1, &[0.5, 0.5][..]));

    let mut cells = CellList::new();
    cells.push(ElementKind::Tetrahedron, CornerOrder::Vtk, &[0, 1, 2, 5]).unwrap();
    cells.push_polyhedron([&[0, 1, 2][..], &[0, 1]]);
    let error = Mesh::from_cells(points.clone(), cells).unwrap_err();
    assert_eq!(error, MeshError::BadCellFace { cell: 1, face: 1, corners: vec![0, 1] });
}

#[test]
fn a_point_on_a_common_face_is_in_the_first_cell_of_a_mesh_and_in_the_upper_one_of_a_grid() {
    let (mesh, grid) = (hexahedra(2, 0.0, 0), Grid::new([0.0; 3], [1.0; 3], [2; 3]).unwrap());
    for (point, first, upper) in [
        ([0.5, 0.2, 0.3], 0, 1),
        ([0.7, 0.5, 0.3], 1, 3),
        ([0.5, 0.5, 0.3], 0, 3),
        ([0.5; 3], 0, 7),
        // At the outer end both have one cell only.
        ([1.0, 0.2, 0.3], 1, 1),
        ([1.0; 3], 7, 7),
    ] {
        assert_eq!(mesh.locate(point, &mut mesh.scratch()), Some(first), "{point:?}");
        assert_eq!(grid.locate(point, &mut grid.scratch()), Some(upper), "{point:?}");
    }
}

#[test]
fn every_point_of_the_outer_faces_of_a_mesh_is_in_a_cell_there() {
    // The sign of the zero that is a corner's height over the face must not decide.
    let mesh = hexahedra(2, 0.0, 0);
    for axis in 0..3 {
        for end in [0.0, 1.0] {
            for (u, v) in (0..=12).flat_map(|i| (0..=12).map(move |j| (f64::from(i) / 12.0, f64::from(j) / 12.0))) {
                let mut point = [end; 3];
                (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (u, v);
                let cell = mesh.locate(point, &mut mesh.scratch());
                let first: usize = (0..3).map(|k| usize::from(point[k] > 0.5) << k).sum();
                assert_eq!(cell, Some(first as u32), "{point:?}");
            }
        }
    }
}

#[test]
fn a_cell_of_thousands_of_faces_in_any_winding_is_one_convex_cell() {
    // A ball of n × 2n quadrilaterals, wound at random.
    let sphere = |n: usize| {
        let mut points = vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
        let at = |i: usize, j: usize| match i {
            0 => 0,
            i if i == n => 1,
            i => (2 + (i - 1) * 2 * n + j % (2 * n)) as u32,
        };
        for i in 1..n {
            let (s, c) = (std::f64::consts::PI * i as f64 / n as f64).sin_cos();
            points.extend((0..2 * n).map(|j| {
                let (y, x) = (std::f64::consts::PI * j as f64 / n as f64).sin_cos();
                [s * x, s * y, c]
            }));
        }
        let mut faces = Vec::new();
        for i in 0..n {
            for j in 0..2 * n {
                let mut ring = vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                ring.dedup();
                ring.truncate(if ring[0] == ring[ring.len() - 1] { ring.len() - 1 } else { ring.len() });
                if (i * 7 + j * j) % 3 == 0 {
                    ring.reverse();
                }
                faces.push(ring);
            }
        }
        let mut cells = CellList::new();
        cells.push_polyhedron(faces.iter().map(Vec::as_slice));
        let start = std::time::Instant::now();
        let mesh = Mesh::from_cells(points, cells).unwrap();
        let built = start.elapsed().as_secs_f64();
        let alone = mesh.polyhedron(0).unwrap();
        let both = start.elapsed().as_secs_f64();
        println!("{} faces: mesh {built:.3} s, polyhedron {:.3} s", 2 * n * n, both - built);
        assert!(mesh.is_convex(0) && alone.is_convex() && mesh.inverted_cells().is_empty());
        assert!((alone.volume() / mesh.cell_volumes()[0] - 1.0).abs() < 1e-13);
        assert!((mesh.cell_volumes()[0] - 4.0 / 3.0 * std::f64::consts::PI).abs() < 30.0 / (n * n) as f64);
    };
    [8, 64, 128].into_iter().for_each(sphere);
}
