//! All methods through one suite: what each must hold, and what the approximations get wrong.

#![allow(clippy::unwrap_used)]

use fieldstone_fields::{
    Field, FieldsError, Method, SolidFractionOptions, Weights, count_centres, field_at_particles, solid_fraction,
};
use fieldstone_geometry::{CornerOrder, ElementKind};
use fieldstone_mesh::{CellList, Grid, Mesh};
use fieldstone_particles::{Domain, Particles};
use proptest::prelude::*;

const CONSERVING: [Method; 7] = [
    Method::Kernel,
    Method::Decomposition,
    Method::Centre,
    Method::Cube,
    Method::Divided,
    Method::Sampled(64),
    Method::MonteCarlo(50),
];

/// A warped mesh of n³ hexahedra on the unit cube.
fn warped(n: usize) -> Mesh {
    let at = |i: usize| i as f64 / n as f64;
    let wave = |x: f64| 0.08 * (std::f64::consts::PI * x).sin();
    let mut points = Vec::new();
    for k in 0..=n {
        for j in 0..=n {
            for i in 0..=n {
                let [x, y, z] = [at(i), at(j), at(k)];
                let bump = wave(x) * wave(y) * wave(z) * 150.0;
                points.push([x + bump * (y - 0.5), y - bump * (x - 0.4), z + bump * (x - 0.5) * (y - 0.3)]);
            }
        }
    }
    let p = |i: usize, j: usize, k: usize| (i + (n + 1) * (j + (n + 1) * k)) as u32;
    let mut cells = CellList::new();
    for cell in 0..n * n * n {
        let [i, j, k] = [cell % n, cell / n % n, cell / n / n];
        let corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
            .map(|[a, b, c]| p(i + a, j + b, k + c));
        cells.push(ElementKind::Hexahedron, CornerOrder::Vtk, &corners).unwrap();
    }
    Mesh::from_cells(points, cells).unwrap()
}

fn cloud(n: usize, radius: f64, seed: u64) -> Particles {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let positions = (0..n).map(|_| [0; 3].map(|_| radius + (1.0 - 2.0 * radius) * next())).collect();
    Particles::new(positions).unwrap().with_uniform_radius(radius).unwrap()
}

#[test]
fn every_method_but_the_smoothed_one_places_all_of_a_volume_that_is_inside() {
    let mesh = warped(4);
    assert!(mesh.warped_faces() > 20);
    let particles = cloud(60, 0.11, 4);
    for method in CONSERVING {
        let options = SolidFractionOptions { method, ..Default::default() };
        // A cube of equal volume may stick out of the mesh where the ball does not.
        let ledger = solid_fraction(&mesh, &particles, &options).unwrap().ledger;
        let total = ledger.binned_volume + ledger.clipped_volume;
        assert!((total / ledger.particle_volume - 1.0).abs() < 1e-12, "{method}");
        if method != Method::Cube {
            assert!((ledger.binned_volume / ledger.particle_volume - 1.0).abs() < 1e-12, "{method}");
        }
    }
}

#[test]
fn every_conserving_method_places_balls_on_the_faces_edges_and_corners_of_a_periodic_box_once() {
    let domain = Domain::new([0.0; 3], [1.0; 3], [true; 3]).unwrap();
    let (mesh, grid) = (warped(4), Grid::new([0.0; 3], [1.0; 3], [4; 3]).unwrap());
    let places =
        [[0.0, 0.5, 0.5], [0.3, 1.0, 0.6], [0.25, 0.0, 1.0], [0.0, 0.0, 0.7], [0.0; 3], [1.0; 3], [0.5, 0.25, 0.75]];
    for (at, radius) in places.into_iter().flat_map(|at| [0.1, 0.4].map(|r| (at, r))) {
        for turns in [[0.0; 3], [-1.0, 2.0, 1.0]] {
            let at = std::array::from_fn(|k| at[k] + turns[k]);
            let one = Particles::new(vec![at]).unwrap().with_uniform_radius(radius).unwrap();
            for method in CONSERVING {
                let build = [
                    Weights::build(&mesh, &one, method, Some(&domain)).unwrap(),
                    Weights::build(&grid, &one, method, Some(&domain)).unwrap(),
                ];
                for (weights, cells) in build.iter().zip(["mesh", "grid"]) {
                    let share = weights.volumes().iter().sum::<f64>() / weights.particle_volumes()[0];
                    assert!((share - 1.0).abs() < 1e-12, "{method} on a {cells}, radius {radius} at {at:?}: {share}");
                }
            }
        }
    }
}

#[test]
fn neighbours_count_once_for_the_smoothed_method_however_their_common_face_is_split() {
    let points: Vec<[f64; 3]> = (0..12).map(|k| [k / 4, k & 1, (k / 2) & 1].map(f64::from)).collect();
    let ball = Particles::new(vec![[0.5; 3]]).unwrap().with_uniform_radius(0.3).unwrap();
    for common in [&[&[4, 5, 7, 6][..]][..], &[&[4, 5, 7], &[4, 7, 6]]] {
        let mut cells = CellList::new();
        for (a, b, end) in [(0, 4, [0, 2, 3, 1]), (4, 8, [8, 9, 11, 10])] {
            let sides = [
                [a, a + 1, b + 1, b],
                [a + 2, b + 2, b + 3, a + 3],
                [a, b, b + 2, a + 2],
                [a + 1, a + 3, b + 3, b + 1],
                end,
            ];
            cells.push_polyhedron(sides.iter().map(|ring| ring.as_slice()).chain(common.iter().copied()));
        }
        let mesh = Mesh::from_cells(points.clone(), cells).unwrap();
        let options = SolidFractionOptions { method: Method::CentreSmoothed, ..Default::default() };
        let fraction = solid_fraction(&mesh, &ball, &options).unwrap().solid_fraction;
        let half = 0.5 * 4.0 / 3.0 * std::f64::consts::PI * 0.027;
        assert!(fraction.iter().all(|f| (f - half).abs() < 1e-15), "{fraction:?}");
    }
}

#[test]
fn the_two_exact_methods_agree_cell_by_cell_on_warped_cells() {
    let mesh = warped(4);
    let particles = cloud(60, 0.11, 9);
    let kernel = Weights::build(&mesh, &particles, Method::Kernel, None).unwrap();
    let decomposition = Weights::build(&mesh, &particles, Method::Decomposition, None).unwrap();
    let ones = vec![1.0; 60];
    let [a, b] = [kernel, decomposition].map(|w| w.sum_over_particles(&ones).unwrap());
    for cell in 0..a.len() {
        assert!(
            (a[cell] - b[cell]).abs() < 1e-12 * mesh.cell_volumes()[cell],
            "cell {cell}: {} and {}",
            a[cell],
            b[cell]
        );
    }
}

#[test]
fn a_flat_tetrahedron_that_is_a_cell_is_refused_by_the_decomposition_and_not_left_out() {
    let mesh = |h: f64| {
        let points = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.2, h], [0.2, 0.2, -1.0]];
        let mut cells = CellList::new();
        cells.push(ElementKind::Tetrahedron, CornerOrder::Vtk, &[0, 2, 1, 4]).unwrap();
        cells.push(ElementKind::Tetrahedron, CornerOrder::Vtk, &[0, 1, 2, 3]).unwrap();
        Mesh::from_cells(points, cells).unwrap()
    };
    let one = Particles::new(vec![[0.25, 0.25, 0.0]]).unwrap().with_uniform_radius(0.1).unwrap();
    let build = |h, method| Weights::build(&mesh(h), &one, method, None);
    let refused = build(1e-14, Method::Decomposition);
    assert!(matches!(refused, Err(FieldsError::Decomposition { cell: 1, .. })), "{refused:?}");
    // The kernel takes it: a disc of the cell's height there.
    let height = 1e-14 * (1.0 - 0.05 / 0.8);
    let flat = build(1e-14, Method::Kernel).unwrap();
    assert_eq!(flat.row(0).0, [0, 1]);
    assert!((flat.row(0).1[1] / (std::f64::consts::PI * 0.01 * height) - 1.0).abs() < 0.2, "{:?}", flat.row(0));
    // Where it is not flat, both agree.
    let [a, b] = [Method::Kernel, Method::Decomposition].map(|method| build(1e-3, method).unwrap());
    assert!(a.row(0).1.iter().zip(b.row(0).1).all(|(a, b)| (a - b).abs() < 1e-15));
}

#[test]
fn approximations_converge_to_the_exact_weights_or_keep_their_known_error() {
    let grid = Grid::new([0.0; 3], [1.0; 3], [4; 3]).unwrap();
    let particles = cloud(40, 0.15, 2);
    let ones = vec![1.0; 40];
    let field = |method| Weights::build(&grid, &particles, method, None).unwrap().sum_over_particles(&ones).unwrap();
    let exact = field(Method::Kernel);
    let error = |method| {
        let other = field(method);
        exact.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) * 64.0
    };
    let ranked = [Method::Sampled(20_000), Method::Sampled(200), Method::Divided, Method::Centre].map(error);
    assert!(ranked.windows(2).all(|w| w[0] < w[1]), "{ranked:?}");
    assert!(ranked[0] < 0.05 && ranked[3] > 0.5, "{ranked:?}");
    assert!(error(Method::MonteCarlo(20_000)) < 0.05);
}

#[test]
fn a_cube_is_off_by_cap_less_slab_as_a_ball_crosses_a_face_which_is_3_6_percent_at_most() {
    let grid = Grid::new([0.0; 3], [4.0, 2.0, 2.0], [2, 1, 1]).unwrap();
    let r = 0.9;
    let volume = 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
    // Half the side of the cube of equal volume, over the radius.
    let half = 0.5 * (4.0 / 3.0 * std::f64::consts::PI).cbrt();
    let mut worst = 0.0f64;
    for k in 0..=400 {
        // Distance of the centre from the face, over the radius.
        let t = f64::from(k) / 400.0;
        let one = Particles::new(vec![[2.0 + t * r, 1.0, 1.0]]).unwrap().with_uniform_radius(r).unwrap();
        let beyond = |m| Weights::build(&grid, &one, m, None).unwrap().sum_over_particles(&[1.0]).unwrap()[0] / volume;
        let (cap, slab) = ((1.0 - t).powi(2) * (2.0 + t) / 4.0, (0.5 - 0.5 * t / half).max(0.0));
        let [ball, cube] = [Method::Kernel, Method::Cube].map(beyond);
        assert!((ball - cap).abs() < 1e-14 && (cube - slab).abs() < 1e-14, "{t}: {ball} {cap}, {cube} {slab}");
        worst = worst.max((ball - cube).abs());
    }
    // The derivative of cap − slab, ¾ t² − ¾ + 1 / (2 half), is 0 at this distance.
    let extreme = (1.0 - 2.0 / (3.0 * half)).sqrt();
    let largest = 0.5 * extreme.powi(3);
    assert!((worst - largest).abs() < 1e-6 && (largest - 0.036).abs() < 1e-4, "{worst} {largest}");
}

#[test]
fn particles_outside_are_clipped_or_refused_with_both_boxes() {
    let grid = Grid::new([0.0; 3], [1.0; 3], [2; 3]).unwrap();
    let half_out = Particles::new(vec![[0.0, 0.5, 0.5]]).unwrap().with_uniform_radius(0.2).unwrap();
    let ledger = solid_fraction(&grid, &half_out, &SolidFractionOptions::default()).unwrap().ledger;
    assert!((ledger.clipped_volume / ledger.particle_volume - 0.5).abs() < 1e-15);
    assert!((ledger.binned_volume + ledger.clipped_volume - ledger.particle_volume).abs() < 1e-17);

    let out = Particles::new(vec![[500.0, 0.0, 0.0]]).unwrap().with_uniform_radius(0.2).unwrap();
    let error = solid_fraction(&grid, &out, &SolidFractionOptions::default()).unwrap_err();
    assert!(matches!(error, FieldsError::NothingInside { particles: 1, .. }));
    assert!(error.to_string().contains("500") && error.to_string().contains("check units"));
}

#[test]
fn parcel_weights_multiply_and_bad_ones_are_refused() {
    let grid = Grid::new([0.0; 3], [1.0; 3], [1; 3]).unwrap();
    let two = Particles::new(vec![[0.3; 3], [0.7; 3]]).unwrap().with_uniform_radius(0.1).unwrap();
    let with = |w: Vec<f64>| SolidFractionOptions { parcel_weights: Some(w), ..Default::default() };
    let plain = solid_fraction(&grid, &two, &SolidFractionOptions::default()).unwrap();
    let weighted = solid_fraction(&grid, &two, &with(vec![3.0, 5.0])).unwrap();
    assert!((weighted.solid_volume[0] / plain.solid_volume[0] - 4.0).abs() < 1e-14);
    assert!((weighted.ledger.particle_volume / plain.ledger.particle_volume - 4.0).abs() < 1e-14);
    for bad in [vec![1.0, -1.0], vec![1.0, f64::NAN]] {
        assert!(matches!(solid_fraction(&grid, &two, &with(bad)), Err(FieldsError::ParcelWeight { particle: 1, .. })));
    }
    assert!(matches!(solid_fraction(&grid, &two, &with(vec![1.0])), Err(FieldsError::Length { .. })));
}

#[test]
fn cap_and_smoothing_keep_the_plain_field_beside_theirs() {
    let grid = Grid::new([0.0; 3], [1.0; 3], [4; 3]).unwrap();
    let particles = cloud(80, 0.12, 6);
    let plain = solid_fraction(&grid, &particles, &SolidFractionOptions::default()).unwrap();
    assert!(plain.unsmoothed.is_none() && plain.uncapped.is_none());
    let options = SolidFractionOptions { smoothing_length: 0.3, cap: Some(0.6), ..Default::default() };
    let result = solid_fraction(&grid, &particles, &options).unwrap();
    assert_eq!(result.unsmoothed.as_ref(), Some(&plain.solid_fraction));
    assert!(result.solid_fraction.iter().all(|&f| f <= 0.6));
    let smooth = SolidFractionOptions { cap: None, ..options };
    let smooth = solid_fraction(&grid, &particles, &smooth).unwrap();
    assert_eq!(result.uncapped.as_ref(), Some(&smooth.solid_fraction));
    assert!(smooth.uncapped.is_none());
    assert_eq!(result.ledger, plain.ledger);
    assert!(solid_fraction(&grid, &particles, &SolidFractionOptions { cap: Some(0.0), ..Default::default() }).is_err());
}

#[test]
fn centres_are_counted_once_even_on_common_faces() {
    let grid = Grid::new([0.0; 3], [1.0; 3], [2; 3]).unwrap();
    let points = vec![[0.5; 3], [0.5, 0.2, 0.2], [0.0; 3], [1.0; 3], [2.0; 3]];
    let particles = Particles::new(points).unwrap();
    assert_eq!(count_centres(&grid, &particles, None).unwrap().iter().sum::<u32>(), 4);
}

#[test]
fn the_transpose_hands_back_what_cells_hold() {
    let mesh = warped(3);
    let particles = cloud(30, 0.1, 8);
    let weights = Weights::build(&mesh, &particles, Method::Kernel, None).unwrap();
    // A force density per cell, given to particles: the sums over volumes agree.
    let density: Vec<f64> = (0..27).map(|c| f64::from(c * 7 % 5) - 2.0).collect();
    let force =
        Field { name: "force".into(), components: vec!["x".into()], unit: "N/m3".into(), data: density.clone() };
    let on_particles = field_at_particles(&weights, &force).unwrap();
    let solid = weights.sum_over_particles(&vec![1.0; 30]).unwrap();
    let from_cells: f64 = solid.iter().zip(&density).map(|(v, f)| v * f).sum();
    let from_particles: f64 = on_particles.iter().zip(weights.particle_volumes()).map(|(q, v)| q * v).sum();
    assert!((from_cells - from_particles).abs() < 1e-15);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mesh = warped(5);
    let particles = cloud(1000, 0.06, 3);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solid_fraction(&mesh, &particles, &SolidFractionOptions::default()).unwrap())
    };
    let one = run(1);
    for threads in [2, 3, 8] {
        assert_eq!(run(threads), one);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]

    #[test]
    fn order_of_particles_changes_only_the_order_of_rows(seed: u64) {
        let mesh = warped(3);
        let particles = cloud(50, 0.1, seed);
        let mut reversed = particles.positions().to_vec();
        reversed.reverse();
        let other = Particles::new(reversed).unwrap().with_uniform_radius(0.1).unwrap();
        let a = Weights::build(&mesh, &particles, Method::Kernel, None).unwrap();
        let b = Weights::build(&mesh, &other, Method::Kernel, None).unwrap();
        for i in 0..50 {
            prop_assert_eq!(a.row(i), b.row(49 - i));
        }
    }
}
