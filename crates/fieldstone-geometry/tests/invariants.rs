//! What must hold for every pair: ranges, additivity, monotony, symmetry, scaling, derivatives.

#![allow(clippy::unwrap_used)]

mod common;

use common::invariants::{Report, allowed, check, relabelled};
use common::{Point, Random, Shape, generic_corners, size_of};
use fieldstone_geometry::decomposition::{
    hexahedron_to_2_wedges, hexahedron_to_5_tetrahedra, hexahedron_to_6_tetrahedra, hexahedron_to_24_tetrahedra,
    wedge_to_3_tetrahedra,
};
use fieldstone_geometry::{Ball, ElementKind, overlap, overlap_volume};
use proptest::prelude::*;

fn kind() -> impl Strategy<Value = ElementKind> {
    proptest::sample::select(ElementKind::STANDARD.to_vec())
}

/// A centre in and around an element of size about 1, and a radius from far smaller to larger.
fn placement() -> impl Strategy<Value = (Point, f64)> {
    (proptest::array::uniform3(-1.5..1.5f64), (-3.0..0.7f64).prop_map(|x| 10f64.powf(x)))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4_000, failure_persistence: None, max_global_rejects: 100_000, ..ProptestConfig::default() })]

    #[test]
    fn generic_pairs_keep_all_invariants(kind in kind(), seed: u64, (centre, r) in placement()) {
        let mut random = Random(seed);
        let shape = Shape::of(kind, &generic_corners(kind, &mut random));
        check(&shape, centre, r, &mut random, &mut Report::default()).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn pairs_on_a_small_lattice_keep_all_invariants(
        corners in proptest::array::uniform4(proptest::array::uniform3(-2..=2i8)),
        centre in proptest::array::uniform3(-3..=3i8),
        half_steps in 1..=8u8,
        seed: u64,
    ) {
        let mut corners = corners.map(|p| p.map(f64::from)).to_vec();
        let edges = [1, 2, 3].map(|k| common::sub(corners[k], corners[0]));
        let det = common::dot(common::cross(edges[0], edges[1]), edges[2]);
        prop_assume!(det != 0.0);
        if det < 0.0 {
            corners.swap(1, 2);
        }
        let shape = Shape::of(ElementKind::Tetrahedron, &corners);
        let r = 0.5 * f64::from(half_steps);
        check(&shape, centre.map(f64::from), r, &mut Random(seed), &mut Report::default()).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn warped_hexahedra_keep_all_invariants_but_the_cut(seed: u64, (centre, r) in placement()) {
        let mut random = Random(seed);
        let corners: Vec<Point> = common::unit_corners(ElementKind::Hexahedron)
            .iter()
            .map(|p| p.map(|x| x - 0.5 + random.uniform(-0.15, 0.15)))
            .collect();
        // As the triangles that it is made of, so that a plane cuts what is really there.
        let warped = common::element(ElementKind::Hexahedron, &corners);
        let shape = fanned(&Shape::of(ElementKind::Hexahedron, &corners));
        let ball = Ball::new(centre, r).unwrap();
        let fanned = shape.build();
        let (a, b) = (overlap(&ball, &warped).volume, overlap(&ball, &fanned).volume);
        prop_assert!((a - b).abs() <= allowed(&ball, &warped) + allowed(&ball, &fanned), "{a} {b}");
        check(&shape.clone(), centre, r, &mut random, &mut Report::default()).map_err(TestCaseError::fail)?;
    }

    #[test]
    fn any_scale_from_a_nanometre_to_a_gigametre_gives_the_scaled_volume(
        kind in kind(), seed: u64, (centre, r) in placement(), decades in -9..=9i32,
    ) {
        let corners = generic_corners(kind, &mut Random(seed));
        let scale = 10f64.powi(decades);
        let element = Shape::of(kind, &corners).build();
        let scaled = Shape::of(kind, &corners).map(|p| p.map(|x| x * scale)).build();
        let small = Ball::new(centre, r).unwrap();
        let large = Ball::new(centre.map(|x| x * scale), r * scale).unwrap();
        let (a, b) = (overlap(&small, &element), overlap(&large, &scaled));
        // The scaled coordinates are rounded: by ε of the largest, over the surface between the two bodies.
        let surface = small.surface_area().min(element.face_areas().iter().sum());
        let rounding = 16.0 * f64::EPSILON * (1.5 + r) * surface + 2.0 * allowed(&small, &element);
        prop_assert!((b.volume / scale.powi(3) - a.volume).abs() <= rounding, "{} {}", b.volume / scale.powi(3), a.volume);
        prop_assert!((b.sphere_area / scale.powi(2) - a.sphere_area).abs() <= 1e-5 * r * r);
    }

    #[test]
    fn a_million_element_sizes_from_the_origin_only_the_rounding_of_the_input_is_lost(
        seed: u64, (centre, r) in placement(), offset in proptest::array::uniform3(-1e6..1e6f64),
    ) {
        // Corners and centre are rounded when they are moved away; moving them back is exact, so both pairs are the
        // same to the last bit and so must be the volume, to rounding. A tetrahedron: no face can become warped.
        let corners = generic_corners(ElementKind::Tetrahedron, &mut Random(seed));
        let away = |p: Point| [0, 1, 2].map(|k| p[k] + offset[k]);
        let back = |p: Point| [0, 1, 2].map(|k| p[k] - offset[k]);
        let far = Shape::of(ElementKind::Tetrahedron, &corners).map(away);
        let near = far.map(back);
        prop_assert_eq!(&near.map(away).corners, &far.corners);
        let far_centre = away(centre);
        let (far_ball, near_ball) = (Ball::new(far_centre, r).unwrap(), Ball::new(back(far_centre), r).unwrap());
        let (far, near) = (far.build(), near.build());
        let (a, b) = (overlap(&far_ball, &far), overlap(&near_ball, &near));
        let volume = allowed(&near_ball, &near) + allowed(&far_ball, &far);
        prop_assert!((a.volume - b.volume).abs() <= volume, "{} {}", a.volume, b.volume);
        let surface = near_ball.surface_area().min(near.face_areas().iter().sum());
        for k in 0..3 {
            prop_assert!((a.gradient[k] - b.gradient[k]).abs() <= 1e-12 * surface);
        }
    }

    #[test]
    fn signed_permutations_turn_the_gradient_and_leave_the_areas(kind in kind(), seed: u64, (centre, r) in placement()) {
        let mut random = Random(seed);
        let shape = Shape::of(kind, &generic_corners(kind, &mut random));
        let (turned, moved) = relabelled(&shape, centre, &mut random);
        let a = overlap(&Ball::new(centre, r).unwrap(), &shape.build());
        let b = overlap(&Ball::new(moved, r).unwrap(), &turned.build());
        let scale = 1e-12 * r * r * (1.0 + 1.0 / r);
        let sorted = |mut v: Vec<f64>| { v.sort_by(f64::total_cmp); v };
        let magnitudes = |g: [f64; 3]| sorted(g.iter().map(|x| x.abs()).collect());
        for (x, y) in magnitudes(a.gradient).iter().zip(magnitudes(b.gradient)) {
            prop_assert!((x - y).abs() <= scale, "{:?} {:?}", a.gradient, b.gradient);
        }
        for (x, y) in sorted(a.face_areas).iter().zip(sorted(b.face_areas)) {
            prop_assert!((x - y).abs() <= scale, "{x} {y}");
        }
        prop_assert!((a.sphere_area - b.sphere_area).abs() <= 10.0 * scale);
    }

    #[test]
    fn an_element_around_the_whole_ball_feels_no_force_and_sees_the_whole_sphere(kind in kind(), seed: u64, share in 0.01..0.999f64) {
        let corners = generic_corners(kind, &mut Random(seed));
        let shape = Shape::of(kind, &corners);
        let middle = [0, 1, 2].map(|k| corners.iter().map(|c| c[k]).sum::<f64>() / corners.len() as f64);
        let nearest = shape.faces.iter()
            .map(|f| common::dot(common::invariants::normal(&shape, f), common::sub(corners[f[0]], middle)))
            .fold(f64::INFINITY, f64::min);
        let ball = Ball::new(middle, share * nearest).unwrap();
        let found = overlap(&ball, &shape.build());
        prop_assert_eq!(found.gradient, [0.0; 3]);
        prop_assert!((found.sphere_area / ball.surface_area() - 1.0).abs() < 1e-13);
        prop_assert_eq!(found.volume, ball.volume());
        prop_assert!(found.face_areas.iter().all(|&a| a == 0.0));
    }

    #[test]
    fn all_subdivisions_of_a_hexahedron_share_the_ball_without_rest(seed: u64, (centre, r) in placement()) {
        let corners = generic_corners(ElementKind::Hexahedron, &mut Random(seed));
        let corners: [Point; 8] = corners.try_into().unwrap();
        let ball = Ball::new(centre, r).unwrap();
        let whole = common::element(ElementKind::Hexahedron, &corners);
        let expected = overlap(&ball, &whole);
        let wedges = hexahedron_to_2_wedges(&corners);
        let partitions: [Vec<Vec<Point>>; 5] = [
            hexahedron_to_5_tetrahedra(&corners).iter().map(|t| t.to_vec()).collect(),
            hexahedron_to_6_tetrahedra(&corners).iter().map(|t| t.to_vec()).collect(),
            hexahedron_to_24_tetrahedra(&corners).iter().map(|t| t.to_vec()).collect(),
            wedges.iter().map(|t| t.to_vec()).collect(),
            wedges.iter().flat_map(|w| wedge_to_3_tetrahedra(w).map(|t| t.to_vec())).collect(),
        ];
        for parts in partitions {
            let kind = if parts[0].len() == 4 { ElementKind::Tetrahedron } else { ElementKind::Wedge };
            let (mut volume, mut area) = (0.0, 0.0);
            let mut tolerance = allowed(&ball, &whole) + 1e-15;
            for part in &parts {
                let part = common::element(kind, part);
                let found = overlap(&ball, &part);
                volume += found.volume;
                area += found.sphere_area;
                tolerance += allowed(&ball, &part);
            }
            prop_assert!((volume - expected.volume).abs() <= tolerance, "{} parts: {volume} {}", parts.len(), expected.volume);
            prop_assert!((area - expected.sphere_area).abs() <= 1e-7 * r * r, "{} parts: {area}", parts.len());
        }
    }
}

/// The shape with each face fanned around its centroid.
fn fanned(shape: &Shape) -> Shape {
    let mut fanned = Shape { corners: shape.corners.clone(), faces: Vec::new() };
    for face in &shape.faces {
        let ring: Vec<Point> = face.iter().map(|&k| shape.corners[k]).collect();
        let apex = fanned.corners.len();
        fanned.corners.push(fieldstone_geometry::polygon_centroid(&ring));
        fanned.faces.extend((0..face.len()).map(|k| vec![face[k], face[(k + 1) % face.len()], apex]));
    }
    fanned
}

#[test]
fn splitting_by_planes_again_and_again_keeps_the_sum() {
    let mut random = Random(21);
    for kind in ElementKind::STANDARD {
        let shape = Shape::of(kind, &generic_corners(kind, &mut random));
        let ball = Ball::new(shape.corners[1], 0.4 * size_of(&shape.corners)).unwrap();
        let whole = overlap_volume(&ball, &shape.build());
        let mut parts = vec![shape];
        for _ in 0..40 {
            let k = random.below(parts.len());
            let (n, part) = (random.direction(), parts[k].clone());
            let middle = [0, 1, 2].map(|i| part.corners.iter().map(|c| c[i]).sum::<f64>() / part.corners.len() as f64);
            if let Some([a, b]) = part.split(n, common::dot(n, middle), 1e-3) {
                parts[k] = a;
                parts.push(b);
            }
        }
        assert!(parts.len() > 15, "{} parts", parts.len());
        let sum: f64 = parts.iter().map(|p| overlap_volume(&ball, &p.build())).sum();
        assert!((sum - whole).abs() < 1e-13, "{kind}, {} parts: {sum} for {whole}", parts.len());
    }
}

#[test]
fn a_grid_of_cells_shares_a_ball_without_rest() {
    let mut random = Random(22);
    for _ in 0..20 {
        let r = random.uniform(0.2, 0.95);
        let room = 1.0 - r;
        let centre = random.point(-room, room);
        let ball = Ball::new(centre, r).unwrap();
        let n = 4 + random.below(5);
        let mut sum = 0.0;
        for i in 0..n * n * n {
            let at = |k: usize| 2.0 * k as f64 / n as f64 - 1.0;
            let index = [i % n, i / n % n, i / n / n];
            let cell = Shape::cuboid(index.map(at), index.map(|k| at(k + 1))).build();
            sum += overlap_volume(&ball, &cell);
        }
        assert!((sum / ball.volume() - 1.0).abs() < 4e-15, "{n}³ cells: {:e}", sum / ball.volume() - 1.0);
    }
}
