//! The kernel against 1,200 values in 60 digits, family by family.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use fieldstone_geometry::{
    Ball, CornerOrder, ElementKind, Orientation, Polyhedron, error_estimate, overlap, overlap_volume,
};

struct Case {
    family: String,
    ball: Ball,
    element: Polyhedron,
    volume: f64,
    sphere_area: f64,
    face_areas: Vec<f64>,
}

fn cases(kind: ElementKind, file: &str) -> Vec<Case> {
    let text = fieldstone_testing::read_text(&fieldstone_testing::data("overlap-cases").join(file));
    let corners = kind.corner_count().unwrap();
    let cases: Vec<Case> = text
        .lines()
        .skip(1)
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let n: Vec<f64> = cells[1..].iter().map(|c| c.parse().unwrap()).collect();
            let points: Vec<[f64; 3]> = n[4..4 + 3 * corners].chunks(3).map(|p| [p[0], p[1], p[2]]).collect();
            let rest = &n[4 + 3 * corners..];
            Case {
                family: cells[0].into(),
                ball: Ball::new([n[0], n[1], n[2]], n[3]).unwrap(),
                element: Polyhedron::element(kind, CornerOrder::Cgns, &points, Orientation::Refuse).unwrap(),
                volume: rest[0],
                sphere_area: rest[1],
                face_areas: rest[2..].to_vec(),
            }
        })
        .collect();
    assert_eq!(cases.len(), 400, "{file}");
    cases
}

fn all_cases() -> Vec<Case> {
    let mut all = cases(ElementKind::Tetrahedron, "tet.csv.gz");
    all.extend(cases(ElementKind::Wedge, "wedge.csv.gz"));
    all.extend(cases(ElementKind::Hexahedron, "hex.csv.gz"));
    all
}

#[derive(Default)]
struct Worst {
    count: usize,
    volume: f64,
    sphere: f64,
    faces: f64,
    size_ratio: f64,
    estimate: f64,
}

#[test]
fn volume_and_areas_agree_with_sixty_digits() {
    let mut table = BTreeMap::<String, Worst>::new();
    for case in all_cases() {
        let result = overlap(&case.ball, &case.element);
        assert_eq!(result.volume, overlap_volume(&case.ball, &case.element));
        let smaller = case.ball.volume().min(case.element.volume());
        let w = table.entry(case.family.clone()).or_default();
        w.count += 1;
        let error = (result.volume - case.volume).abs() / smaller;
        w.volume = w.volume.max(error);
        w.sphere = w.sphere.max((result.sphere_area - case.sphere_area).abs() / case.ball.surface_area());
        for ((a, b), whole) in result.face_areas.iter().zip(&case.face_areas).zip(case.element.face_areas()) {
            let disc = std::f64::consts::PI * case.ball.radius().powi(2);
            w.faces = w.faces.max((a - b).abs() / whole.min(disc));
        }
        let (low, high) = case.element.bounds();
        let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        w.size_ratio = w.size_ratio.max(case.ball.radius() / size);
        if error > 1e-15 {
            w.estimate =
                w.estimate.max((result.volume - case.volume).abs() / error_estimate(&case.ball, &case.element));
        }
    }
    println!(
        "| family | cases | largest r/L | volume / min(V) | sphere area / 4πr² | face area / min | error / estimate |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (family, w) in &table {
        println!(
            "| {family} | {} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} |",
            w.count, w.size_ratio, w.volume, w.sphere, w.faces, w.estimate
        );
    }
    // What f64 alone gives: flat elements and tiny balls lose digits, huge balls all of them (and say so).
    for (family, w) in &table {
        let limit = match family.as_str() {
            "centre_on_vertex" => 1e-14,
            "generic" | "tangent_vertex" => 1e-11,
            "sliver" => 5e-6,
            tiny if tiny.starts_with("tiny") => 3e-11,
            huge => {
                assert!(huge.starts_with("huge"), "unknown family {huge}");
                1.0
            }
        };
        assert!(w.volume <= limit, "{family}: volume off by {:e} of min(V)", w.volume);
        assert!(w.sphere <= limit && w.faces <= limit, "{family}: areas off by {:e}, {:e}", w.sphere, w.faces);
        assert!(w.estimate <= 1.0, "{family}: an error {} times the estimate", w.estimate);
    }
}

#[test]
fn huge_balls_are_finite_and_flagged_by_the_estimate() {
    let huge: Vec<Case> = all_cases().into_iter().filter(|c| c.family.starts_with("huge")).collect();
    assert_eq!(huge.len(), 150);
    let mut flagged = 0;
    for case in &huge {
        let result = overlap(&case.ball, &case.element);
        let numbers = [result.volume, result.sphere_area].into_iter().chain(result.face_areas).chain(result.gradient);
        assert!(numbers.into_iter().all(f64::is_finite));
        assert!((0.0..=case.element.volume()).contains(&result.volume));
        let limit = 1e-6 * case.element.volume();
        let estimate = error_estimate(&case.ball, &case.element);
        assert!(estimate > limit || (result.volume - case.volume).abs() <= limit, "an unflagged error");
        flagged += usize::from(estimate > limit);
    }
    assert!(flagged > 100, "{flagged} of 150 flagged: the estimate says nothing");
}

#[test]
fn small_rational_placements_on_which_decompositions_fail_are_right() {
    // The sphere passes exactly through corners: true values are 0, or known in closed form.
    let cube = Polyhedron::cuboid([0.0; 3], [1.0; 3]).unwrap();
    assert!(overlap_volume(&Ball::new([1.4, 1.3, 0.0], 0.5).unwrap(), &cube) < 1e-16);
    let wedge = Polyhedron::wedge([[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 0., 1.], [0., 1., 1.]]);
    assert!(overlap_volume(&Ball::new([0.3, 1.4, 1.0], 0.5).unwrap(), &wedge.unwrap()) < 1e-17);
    let tet = Polyhedron::tetrahedron([[0.; 3], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]]).unwrap();
    let found = overlap_volume(&Ball::new([0.0, 0.0, 0.7], 0.3).unwrap(), &tet);
    assert!((found - 0.017510).abs() < 1e-6, "{found}");
}
