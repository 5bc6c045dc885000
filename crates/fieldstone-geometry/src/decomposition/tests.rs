//! Tests that need the inside of the method: the printed rules beside the corrected ones, and numerical integration.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec3};

use super::element::DecompositionElement;
use super::general_wedge::{EPSILON, WedgePlanes, unit_general_wedge};
use super::intersect_primitives::Intersections;
use super::regularized_wedge::half_chord;
use super::{general_wedge_volume, regularized_wedge_volume};

fn unit_cube() -> DecompositionElement {
    DecompositionElement::hexahedron([
        [0., 0., 0.],
        [1., 0., 0.],
        [1., 1., 0.],
        [0., 1., 0.],
        [0., 0., 1.],
        [1., 0., 1.],
        [1., 1., 1.],
        [0., 1., 1.],
    ])
    .unwrap()
}

fn intersections(element: &DecompositionElement, centre: [f64; 3], radius: f64) -> Intersections {
    let centre = DVec3::from(centre);
    let mut found = Intersections::of_vertices(element, centre, 1.0 / radius);
    found.planes(element, centre, 1.0 / radius);
    found.edges_and_faces(element, 1.0 / radius);
    found
}

/// Lines 1–24 of Algorithm 2 as printed: marked vertices and edges.
fn printed_algorithm_2(element: &DecompositionElement, centre: [f64; 3], radius: f64) -> (u8, u16) {
    const EPSILON: f64 = 1e-15;
    let point = |v: u8| (element.points()[usize::from(v)] - DVec3::from(centre)) / radius;
    let (mut vertices, mut edges) = (0_u8, 0_u16);
    for (index, edge) in element.edges().iter().enumerate() {
        let [p0, p1] = edge.vertices.map(point);
        let along = p1 - p0;
        // |p0 + t along|² = 1
        let (a, b, c) = (along.length_squared(), p0.dot(along), p0.length_squared() - 1.0);
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            continue;
        }
        let [i0, i1] = [-1.0, 1.0].map(|sign| (-b + sign * discriminant.sqrt()) / a);
        if i0 > 1.0 - EPSILON || i1 < EPSILON || (i0 > 0.0 && i1 < 1.0 && i1 - i0 < EPSILON) {
            continue;
        }
        if i0 < 0.0 && i1 > 1.0 {
            vertices |= 1 << edge.vertices[0] | 1 << edge.vertices[1];
        } else {
            // A tie goes to the vertex with the lower number.
            let [v0, v1] = edge.vertices;
            let (distance0, distance1) = (p0.length(), p1.length());
            let first = distance0 < distance1 || (distance0 == distance1 && v0 < v1);
            vertices |= 1 << if first { v0 } else { v1 };
        }
        edges |= 1 << index;
    }
    for (index, vertex) in element.vertices().iter().enumerate() {
        if vertex.edges.iter().any(|&e| edges >> e & 1 == 0) {
            vertices &= !(1 << index);
        }
    }
    (vertices, edges)
}

#[test]
fn algorithm_2_as_printed_marks_7_vertices_that_are_outside_the_ball() {
    let cube = unit_cube();
    let (centre, radius) = ([0.5; 3], 0.8);
    let (printed, printed_edges) = printed_algorithm_2(&cube, centre, radius);
    assert_eq!((printed.count_ones(), printed_edges.count_ones()), (7, 12));

    let found = intersections(&cube, centre, radius);
    assert_eq!((found.vertices, found.edges.count_ones(), found.faces.count_ones()), (0, 12, 6));
}

#[test]
fn where_each_cut_edge_has_a_vertex_in_the_ball_both_rules_agree() {
    let cube = unit_cube();
    for (centre, radius) in [([0.1, 0.2, 0.3], 0.5), ([0.9, 0.9, 0.8], 0.35), ([0.5, 0.1, 0.0], 0.6)] {
        let found = intersections(&cube, centre, radius);
        assert_ne!(found.vertices, 0);
        assert_eq!((found.vertices, found.edges), printed_algorithm_2(&cube, centre, radius));
    }
}

#[test]
fn a_sphere_through_a_vertex_marks_the_vertex_with_all_its_edges_or_not_at_all() {
    let cube = unit_cube();
    for nudge in -20..=20 {
        // (0.4, 0.3) from the corner (1, 1, 0): all three of its edges lead away from the ball.
        let radius = 0.5 + f64::from(nudge) * f64::EPSILON / 4.0;
        let found = intersections(&cube, [1.4, 1.3, 0.0], radius);
        let expected = if found.vertices == 0 { (0, 0) } else { (3, 3) };
        assert_eq!((found.edges.count_ones(), found.faces.count_ones()), expected);
    }
}

#[test]
fn vertices_have_right_handed_edges_and_opposite_faces() {
    let cube = unit_cube();
    for (index, vertex) in cube.vertices().iter().enumerate() {
        assert!((vertex.determinant - 1.0).abs() < 1e-15);
        for i in 0..3 {
            let opposite = cube.edges()[usize::from(vertex.edges[i])];
            let into_element =
                if usize::from(opposite.vertices[0]) == index { opposite.direction } else { -opposite.direction };
            let normal = cube.faces()[usize::from(vertex.faces[i])].normal;
            assert!((normal.dot(into_element) + 1.0).abs() < 1e-15);
        }
    }
}

/// Ball's volume per unit angle around a line at distance `d`, in the direction `angle` from the outward one:
/// $\int 2 \rho \sqrt{1 - |x|^2}\,\mathrm d\rho$ along the ray from the line.
fn volume_per_angle(d: f64, angle: f64) -> f64 {
    let (foot, across) = (d * angle.cos(), d * angle.sin());
    let (q_squared, b) = (1.0 - across * across, (1.0 - d * d).sqrt());
    let segment = 0.5 * (q_squared * (FRAC_PI_2 - (foot / q_squared.sqrt()).asin()) - foot * b);
    2.0 * (b * b * b / 3.0 - foot * segment)
}

/// Simpson's rule.
fn integrate(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let steps = 2000;
    let h = (to - from) / f64::from(steps);
    let sum: f64 = (1..steps).map(|i| f(from + h * f64::from(i)) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
    (sum + f(from) + f(to)) * h / 3.0
}

#[test]
fn regularized_wedge_is_its_numerical_integral_for_all_angles() {
    for d in [0.0, 1e-9, 0.1, 0.5, 0.9, 0.99] {
        for i in 0..=24 {
            let alpha = PI * f64::from(i) / 24.0;
            let exact = integrate(0.0, alpha, |angle| volume_per_angle(d, angle));
            let found = regularized_wedge_volume(1.0, d, alpha);
            assert!((found - exact).abs() < 2e-11, "d {d} α {alpha}: {found} for {exact}");
            assert!((regularized_wedge_volume(3.0, 3.0 * d, alpha) - 27.0 * found).abs() < 1e-13);
        }
    }
}

#[test]
fn regularized_wedge_beyond_the_right_angle_is_what_equation_5_gives_with_two_argument_arc_tangents() {
    for (d, alpha) in [(0.2, 1.7), (0.5, 2.5), (0.8, 3.0), (0.99, 1.58)] {
        let (a, b, c) = (d * f64::sin(alpha), f64::sqrt(1.0 - d * d), d * f64::cos(alpha));
        let equation_5 =
            a * b * c / 3.0 + a * (a * a / 3.0 - 1.0) * b.atan2(c) + 2.0 / 3.0 * (b * alpha.sin()).atan2(alpha.cos());
        assert!((regularized_wedge_volume(1.0, d, alpha) - equation_5).abs() < 1e-15);
    }
}

#[test]
fn wedge_at_a_line_that_touches_or_misses_the_ball_is_nothing_or_a_whole_cap() {
    assert_eq!(regularized_wedge_volume(1.0, 1.0, 0.3), 0.0);
    assert_eq!(regularized_wedge_volume(1.0, 1.0 + 1e-15, 0.3), 0.0);
    let cap = crate::cap_volume(1.0, f64::sin(2.5));
    assert!((regularized_wedge_volume(1.0, 1.0, 2.5) - cap).abs() < 1e-15);
}

/// Separation vector, normals: the wedge between two rays, angles from the separation vector's direction.
fn wedge_between(d: f64, from: f64, to: f64, turn: DQuat) -> (DVec3, [DVec3; 2]) {
    let normals = [DVec3::new(-from.sin(), from.cos(), 0.0), DVec3::new(to.sin(), -to.cos(), 0.0)];
    (turn * DVec3::new(d, 0.0, 0.0), normals.map(|n| turn * n))
}

/// Algorithm 3 as printed, with Eq. 5 for `regularizedWedge` and $\vec c_i$ on the element's faces.
fn printed_algorithm_3(d: DVec3, normals: [DVec3; 2]) -> f64 {
    let [n0, n1] = normals;
    let angle = |a: DVec3, b: DVec3| a.cross(b).length().atan2(a.dot(b));
    let length = d.length();
    if length < EPSILON {
        return 2.0 / 3.0 * (PI - angle(n0, n1));
    }
    let (s0, s1) = (d.dot(n0), d.dot(n1));
    if s0.abs() < EPSILON || s1.abs() < EPSILON {
        return regularized_wedge_volume(1.0, length, PI - angle(n0, n1));
    }
    let towards = d / length;
    // A face's point lies opposite the half-plane that bounds the wedge.
    let line = n0.cross(n1).normalize();
    let d0 = line.cross(n0).dot(towards);
    let d1 = n1.cross(line).dot(towards);
    let (a0, a1) = (angle(n0, towards), angle(n1, towards));
    let wedge = |alpha| regularized_wedge_volume(1.0, length, alpha);
    if s0 >= 0.0 && s1 >= 0.0 {
        wedge(FRAC_PI_2 - a0.copysign(d0)) + wedge(FRAC_PI_2 - a1.copysign(d1))
    } else if s0 < 0.0 && s1 < 0.0 {
        let alpha = |a: f64, d: f64| FRAC_PI_2 + 1f64.copysign(d) * (a - PI);
        4.0 / 3.0 * PI - (wedge(alpha(a0, d0)) + wedge(alpha(a1, d1)))
    } else {
        let alpha = |a: f64, d: f64, s: f64| FRAC_PI_2 - 1f64.copysign(d * s) * (a - if s < 0.0 { PI } else { 0.0 });
        let (v0, v1) = (wedge(alpha(a0, d0, s0)), wedge(alpha(a1, d1, s1)));
        v0.max(v1) - v0.min(v1)
    }
}

fn general(d: DVec3, n: [DVec3; 2]) -> f64 {
    general_wedge_volume(1.0, d.to_array(), n[0].to_array(), n[1].to_array()).unwrap()
}

#[test]
fn each_case_of_algorithm_3_is_its_numerical_integral() {
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.3);
    let degrees = f64::to_radians;
    // Which case an interval of angles falls in: 7c holds 0°, 7b holds 180°, 7a neither.
    let cases: [(&str, &[(f64, f64)]); 3] = [
        ("7c", &[(-30., 40.), (-100., 20.), (-5., 170.), (-89., 89.)]),
        ("7b", &[(150., 220.), (100., 200.), (170., 340.), (91., 269.)]),
        ("7a", &[(10., 60.), (20., 150.), (100., 170.), (-70., -20.), (-160., -95.), (1., 179.)]),
    ];
    for (case, intervals) in cases {
        for &(from, to) in intervals {
            for d in [1e-6, 0.05, 0.4, 0.8, 0.97] {
                let (vector, normals) = wedge_between(d, degrees(from), degrees(to), turn);
                let signs = normals.map(|n| vector.dot(n) >= 0.0);
                let expected_signs = match case {
                    "7c" => signs == [true, true],
                    "7b" => signs == [false, false],
                    _ => signs[0] != signs[1],
                };
                assert!(expected_signs, "{case} {from} {to}");
                let exact = integrate(degrees(from), degrees(to), |angle| volume_per_angle(d, angle));
                let found = general(vector, normals);
                assert!((found - exact).abs() < 1e-10, "{case} d {d} {from}..{to}: {found} for {exact}");
                assert!((found - printed_algorithm_3(vector, normals)).abs() < 1e-10, "{case} d {d} {from}..{to}");
            }
        }
    }
}

#[test]
fn wedge_at_the_centre_is_its_share_of_the_full_turn() {
    for angle in [0.01, 1.0, FRAC_PI_2, 3.0] {
        for d in [0.0, 1e-17] {
            let (vector, normals) = wedge_between(d, 0.7, 0.7 + angle, DQuat::IDENTITY);
            assert!((general(vector, normals) - 2.0 / 3.0 * angle).abs() < 2e-15);
        }
    }
}

#[test]
fn a_plane_through_the_centre_is_right_on_both_sides_where_the_printed_line_9_is_not() {
    for d in [0.1, 0.5, 0.9] {
        for angle in [0.2, 1.0, 2.0, 3.0] {
            // From the outward half-plane: s ≥ 0 for the other plane, and the printed call is right.
            let (vector, normals) = wedge_between(d, 0.0, angle, DQuat::IDENTITY);
            let exact = integrate(0.0, angle, |angle| volume_per_angle(d, angle));
            assert!((general(vector, normals) - exact).abs() < 1e-11);
            assert!((printed_algorithm_3(vector, normals) - exact).abs() < 1e-11);
            // From the inward half-plane: s < 0.
            let vector = DVec3::new(-d, 0.0, 0.0);
            let exact = integrate(0.0, angle, |angle| volume_per_angle(-d, angle));
            assert!(vector.dot(normals[1]) < 0.0);
            assert!((general(vector, normals) - exact).abs() < 1e-11);
            assert!((printed_algorithm_3(vector, normals) - exact).abs() > 1e-2);
        }
    }
}

#[test]
fn planes_at_an_angle_to_a_short_separation_vector_are_not_taken_to_lie_along_it() {
    for (from, to) in [(0.3, 1.9), (-0.4, 0.5), (2.8, 3.6), (-1.5, -0.2)] {
        for d in [1e-17, 5e-16, 9e-16, 2e-15, 1e-14] {
            let (vector, normals) = wedge_between(d, from, to, DQuat::IDENTITY);
            // A slice less half a disc, as thick as the plane's distance, at each plane.
            let exact = 2.0 / 3.0 * (to - from) - FRAC_PI_2 * (vector.dot(normals[0]) + vector.dot(normals[1]));
            let found = general(vector, normals);
            assert!((found - exact).abs() < 2e-15, "{d} {from}..{to}: {found} for {exact}");
        }
    }
}

#[test]
fn wedge_is_continuous_across_the_case_of_a_plane_through_the_centre() {
    for (from, to) in [(0.0, 1.2), (PI, PI + 1.2), (-1.2, 0.0), (0.0, 2.8), (PI - 2.8, PI)] {
        let volume = |nudge: f64| {
            let (vector, normals) = wedge_between(0.6, from + nudge, to + nudge, DQuat::IDENTITY);
            general(vector, normals)
        };
        for nudge in [1e-17, 1e-16, 3e-16, 1e-15, 1e-14, 1e-13] {
            assert!((volume(nudge) - volume(0.0)).abs() < 4.0 * nudge + 4e-15);
            assert!((volume(-nudge) - volume(0.0)).abs() < 4.0 * nudge + 4e-15);
        }
    }
}

#[test]
fn next_to_no_angle_between_the_planes_is_next_to_no_wedge_whatever_the_signs_of_the_distances() {
    // Both planes through the centre but for noise; half-planes outwards (c > 0) or inwards (c < 0).
    for noise in [[1e-15, 1e-15], [1e-15, -1e-15], [-1e-15, 1e-15], [-1e-15, -1e-15], [0.0, 2e-15], [1e-18, -1e-18]] {
        for c in [0.5, -0.5] {
            let planes = WedgePlanes { s: noise, c: [c, c], normals: [DVec3::Y, -DVec3::Y] };
            let thin = unit_general_wedge(&planes, half_chord(0.25));
            assert!(thin.triple_volume.abs() < 6e-14 && thin.area.abs() < 3e-14, "{noise:?} {c}: {thin:?}");
            let planes = WedgePlanes { s: noise, c: [c, -c], normals: [DVec3::Y, DVec3::Y] };
            let half = unit_general_wedge(&planes, half_chord(0.25));
            assert!((half.triple_volume - 2.0 * PI).abs() < 3e-14, "{noise:?} {c}: {half:?}");
        }
    }
}

#[test]
fn parallel_planes_have_no_wedge() {
    let n = [0.0, 0.0, 1.0];
    assert_eq!(general_wedge_volume(1.0, [0.0, 0.0, 0.5], n, n), None);
    assert_eq!(general_wedge_volume(1.0, [0.0, 0.0, 0.5], n, [0.0, 0.0, -1.0]), None);
}
