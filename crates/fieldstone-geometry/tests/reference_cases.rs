//! The kernel against 1,200 values in 60 digits, family by family: in `f64` alone, and with as many digits as it takes.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use fieldstone_geometry::{
    Ball, CertifiedOverlap, CornerOrder, ElementKind, Orientation, PROMISE, Polyhedron, certified_overlap,
    fast_overlap, fast_overlap_volume, overlap, overlap_volume,
};

struct Case {
    family: String,
    ball: Ball,
    element: Polyhedron,
    volume: f64,
    sphere_area: f64,
    face_areas: Vec<f64>,
}

impl Case {
    fn smaller_volume(&self) -> f64 {
        self.ball.volume().min(self.element.volume())
    }

    /// Errors of volume, sphere area and worst face area over what each is measured against; bound over error.
    fn errors(&self, result: &CertifiedOverlap) -> [f64; 3] {
        let sphere = self.ball.surface_area();
        let whole: f64 = self.element.face_areas().iter().sum();
        let faces = result.overlap.face_areas.iter().zip(&self.face_areas).zip(self.element.face_areas());
        [
            (result.overlap.volume - self.volume).abs() / self.smaller_volume(),
            (result.overlap.sphere_area - self.sphere_area).abs() / sphere.min(whole),
            faces.map(|((a, b), face)| (a - b).abs() / face.min(sphere)).fold(0.0, f64::max),
        ]
    }
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
struct Family {
    count: usize,
    size_ratio: f64,
    worst: [f64; 3],
    enclosed: f64,
    ratios: Vec<f64>,
    precisions: [usize; 3],
}

/// Prints a table as it stands in the validation report, and returns it for assertions.
fn table(compute: impl Fn(&Case) -> CertifiedOverlap) -> BTreeMap<String, Family> {
    let mut table = BTreeMap::<String, Family>::new();
    for case in all_cases() {
        let result = compute(&case);
        let errors = case.errors(&result);
        let family = table.entry(case.family.clone()).or_default();
        family.count += 1;
        let (low, high) = case.element.bounds();
        let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        family.size_ratio = family.size_ratio.max(case.ball.radius() / size);
        for (worst, error) in family.worst.iter_mut().zip(errors) {
            *worst = worst.max(error);
        }
        // The reference has some twenty digits of its own.
        let error = (result.overlap.volume - case.volume).abs() - 1e-18 * case.smaller_volume();
        if error > 0.0 {
            family.enclosed = family.enclosed.max(error / result.volume_error);
            family.ratios.push(result.volume_error / error);
        }
        family.precisions[result.precision as usize] += 1;
    }
    println!(
        "| family | cases | largest r/L | volume | sphere area | face areas | largest error / bound | median bound / error | f64, 106, 256 bits |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (name, family) in &mut table {
        family.ratios.sort_by(f64::total_cmp);
        println!(
            "| {name} | {} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:?} |",
            family.count,
            family.size_ratio,
            family.worst[0],
            family.worst[1],
            family.worst[2],
            family.enclosed,
            family.ratios.get(family.ratios.len() / 2).copied().unwrap_or(f64::NAN),
            family.precisions,
        );
    }
    table
}

#[test]
fn every_case_keeps_the_promise_and_is_enclosed_by_its_bound() {
    let table = table(|case| {
        let result = certified_overlap(&case.ball, &case.element);
        assert_eq!(result.overlap, overlap(&case.ball, &case.element));
        let volume = overlap_volume(&case.ball, &case.element);
        assert!((volume - case.volume).abs() <= PROMISE * case.smaller_volume());
        assert!(result.volume_error <= PROMISE * case.smaller_volume());
        result
    });
    let mut ratios = Vec::new();
    for (name, family) in table {
        assert!(family.worst.iter().all(|&e| e <= PROMISE), "{name}: {:?}", family.worst);
        assert!(family.enclosed <= 1.0, "{name}: an error {} times its bound", family.enclosed);
        ratios.extend(family.ratios);
    }
    ratios.sort_by(f64::total_cmp);
    let median = ratios[ratios.len() / 2];
    assert!(median <= 1e3, "the bound is idle: its median is {median} times the error");
}

#[test]
fn f64_alone_errs_within_its_bound_and_by_no_more_than_each_family_allows() {
    // Flat elements and tiny balls lose digits in f64, huge balls all of them, and the bound says so.
    for (name, family) in table(|case| fast_overlap(&case.ball, &case.element)) {
        let limit = match name.as_str() {
            "centre_on_vertex" => 1e-14,
            "generic" | "tangent_vertex" => 1e-11,
            "sliver" => 5e-6,
            tiny if tiny.starts_with("tiny") => 3e-11,
            huge => {
                assert!(huge.starts_with("huge"), "unknown family {huge}");
                assert_eq!(family.precisions, [family.count, 0, 0]);
                1.0 + 1e-9
            }
        };
        assert!(family.worst[0] <= limit, "{name}: volume off by {:e} of min(V)", family.worst[0]);
        assert!(family.enclosed <= 1.0, "{name}: an error {} times its bound", family.enclosed);
    }
}

#[test]
fn powers_of_two_and_signed_permutations_of_the_axes_change_nothing_but_the_scale() {
    for case in all_cases().iter().step_by(7) {
        let reference = overlap_volume(&case.ball, &case.element);
        for (power, axes, signs) in
            [(-30, [1, 2, 0], [1.0, -1.0, 1.0]), (30, [2, 1, 0], [-1.0, -1.0, -1.0]), (7, [0, 2, 1], [1.0; 3])]
        {
            let scale = 2f64.powi(power);
            let turn = |p: [f64; 3]| [0, 1, 2].map(|k| p[axes[k]] * signs[k] * scale);
            let corners: Vec<[f64; 3]> = case.element.corners().map(turn).collect();
            let element =
                Polyhedron::element(case.element.kind(), CornerOrder::Cgns, &corners, Orientation::Fix).unwrap();
            let ball = Ball::new(turn(case.ball.centre()), case.ball.radius() * scale).unwrap();
            let volume = overlap_volume(&ball, &element) / scale.powi(3);
            assert!(
                (volume - case.volume).abs() <= PROMISE * case.smaller_volume(),
                "{}: {volume} for {reference}",
                case.family
            );
        }
    }
}

#[test]
fn huge_balls_are_finite_and_flagged_in_f64() {
    let huge: Vec<Case> = all_cases().into_iter().filter(|c| c.family.starts_with("huge")).collect();
    assert_eq!(huge.len(), 150);
    let mut flagged = 0;
    for case in &huge {
        let (volume, bound) = fast_overlap_volume(&case.ball, &case.element);
        assert!((0.0..=case.element.volume()).contains(&volume) && bound.is_finite());
        flagged += usize::from(bound > 1e-6 * case.element.volume());
    }
    assert!(flagged > 100, "{flagged} of 150 flagged: the bound says nothing");
}

#[test]
fn small_rational_placements_on_which_decompositions_fail_are_right() {
    // The sphere passes exactly through corners: true values are 0, or known in closed form.
    let cube = Polyhedron::cuboid([0.0; 3], [1.0; 3]).unwrap();
    assert!(overlap_volume(&Ball::new([1.4, 1.3, 0.0], 0.5).unwrap(), &cube) < 1e-16);
    let wedge = Polyhedron::wedge([[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 0., 1.], [0., 1., 1.]]);
    assert!(overlap_volume(&Ball::new([0.3, 1.4, 1.0], 0.5).unwrap(), &wedge.unwrap()) < 1e-16);
    let tet = Polyhedron::tetrahedron([[0.; 3], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]]).unwrap();
    let found = overlap_volume(&Ball::new([0.0, 0.0, 0.7], 0.3).unwrap(), &tet);
    assert!((found - 0.017510).abs() < 1e-6, "{found}");
}

#[test]
fn coordinates_offset_by_a_million_sizes_keep_the_volume_of_what_the_rounded_corners_enclose() {
    // The rounded corners less the offset are exact numbers: the same element near the origin is the truth.
    let offset = [3e6, -7e6, 1.1e6];
    for case in all_cases().iter().filter(|c| c.family == "generic" || c.family == "sliver").step_by(3) {
        let far: Vec<[f64; 3]> = case.element.corners().map(|p| [0, 1, 2].map(|k| p[k] + offset[k])).collect();
        let centre = [0, 1, 2].map(|k| case.ball.centre()[k] + offset[k]);
        let near: Vec<[f64; 3]> = far.iter().map(|p| [0, 1, 2].map(|k| p[k] - offset[k])).collect();
        let build = |corners: &[[f64; 3]]| {
            Polyhedron::element(case.element.kind(), CornerOrder::Cgns, corners, Orientation::Fix)
        };
        let (Ok(far), Ok(near)) = (build(&far), build(&near)) else { continue };
        let r = case.ball.radius();
        let far_ball = Ball::new(centre, r).unwrap();
        let near_ball = Ball::new([0, 1, 2].map(|k| centre[k] - offset[k]), r).unwrap();
        let smaller = near_ball.volume().min(near.volume());
        let (a, b) = (overlap_volume(&far_ball, &far), overlap_volume(&near_ball, &near));
        assert!((a - b).abs() <= 2.0 * PROMISE * smaller, "{}: {a:e} and {b:e}", case.family);
        assert!((far.volume() - near.volume()).abs() <= 4e-15 * near.volume());
    }
}
