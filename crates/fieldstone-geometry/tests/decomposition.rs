//! The decomposition method from outside: 60-digit cases, closed forms, splits, spheres through vertices.

#![allow(clippy::unwrap_used, reason = "a test that cannot build its input has failed")]

use std::collections::BTreeMap;
use std::f64::consts::PI;

use fieldstone_geometry::decomposition::{
    DecompositionElement, DecompositionElementError, HexahedronCorners, WedgeCorners, hexahedron_to_2_wedges,
    hexahedron_to_5_tetrahedra, hexahedron_to_6_tetrahedra, hexahedron_to_20_tetrahedra, hexahedron_to_24_tetrahedra,
    overlap_sphere_area, overlap_volume, tetrahedron_to_4_tetrahedra, wedge_to_3_tetrahedra,
};
use fieldstone_geometry::double_double::two_sum;
use fieldstone_geometry::{Ball, ElementKind, Polyhedron, cap_volume};
use fieldstone_testing::Random;

const CUBE: HexahedronCorners =
    [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.], [0., 0., 1.], [1., 0., 1.], [1., 1., 1.], [0., 1., 1.]];

const WEDGE: WedgeCorners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 0., 1.], [0., 1., 1.]];

fn ball(centre: [f64; 3], radius: f64) -> Ball {
    Ball::new(centre, radius).unwrap()
}

fn cube_overlap(centre: [f64; 3], radius: f64) -> f64 {
    overlap_volume(&ball(centre, radius), &DecompositionElement::hexahedron(CUBE).unwrap())
}

/// An affine map keeps faces planar; its determinant is bounded below.
struct Affine([[f64; 3]; 3]);

impl Affine {
    fn random(random: &mut Random) -> Self {
        let mut rows = [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
        for row in &mut rows {
            for entry in row {
                *entry += random.uniform(-0.25, 0.25);
            }
        }
        Self(rows)
    }

    fn apply<const N: usize>(&self, points: &[[f64; 3]; N]) -> [[f64; 3]; N] {
        points.map(|p| self.0.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2]))
    }
}

#[test]
fn ball_at_a_corner_edge_and_face_is_cut_to_an_eighth_a_quarter_and_a_half() {
    let whole = ball([0.; 3], 0.3).volume();
    for (centre, share) in [
        ([0., 0., 0.], 0.125),
        ([1., 1., 1.], 0.125),
        ([1., 0., 1.], 0.125),
        ([0., 0., 0.5], 0.25),
        ([1., 0.4, 1.], 0.25),
        ([0.5, 0.5, 0.], 0.5),
        ([0.4, 1., 0.6], 0.5),
        ([0.5, 0.5, 0.5], 1.0),
        ([0.3, 0.7, 0.5], 1.0),
    ] {
        assert!((cube_overlap(centre, 0.3) - share * whole).abs() < 1e-15, "{centre:?}");
        let cube = DecompositionElement::hexahedron(CUBE).unwrap();
        let area = overlap_sphere_area(&ball(centre, 0.3), &cube);
        assert!((area - share * 4.0 * PI * 0.09).abs() < 4e-15, "{centre:?}");
    }
}

#[test]
fn one_face_or_two_opposite_ones_cut_caps() {
    assert!((cube_overlap([0.5, 0.5, -0.1], 0.3) - cap_volume(0.3, 0.1)).abs() < 1e-15);
    assert!((cube_overlap([0.5, 0.5, 0.2], 0.3) - (ball([0.; 3], 0.3).volume() - cap_volume(0.3, 0.2))).abs() < 1e-15);
    // All six faces, no vertex, no edge: caps only.
    let expected = ball([0.; 3], 0.6).volume() - 6.0 * cap_volume(0.6, 0.5);
    assert!((cube_overlap([0.5; 3], 0.6) - expected).abs() < 2e-15);
}

#[test]
fn ball_that_crosses_all_twelve_edges_between_their_vertices_has_no_cones() {
    // Caps less the wedges of two planes at distance 1/2 at right angles, r = 0.8: against the crate's other method.
    let expected = fieldstone_geometry::overlap_volume(&ball([0.5; 3], 0.8), &Polyhedron::hexahedron(CUBE).unwrap());
    assert!((cube_overlap([0.5; 3], 0.8) - expected).abs() < 4e-15);
}

#[test]
fn containment_is_exact_either_way() {
    assert_eq!(cube_overlap([0.5; 3], 0.9), 1.0);
    assert_eq!(cube_overlap([0.4, 0.5, 0.6], 0.25), ball([0.; 3], 0.25).volume());
    assert_eq!(cube_overlap([3., 0., 0.], 1.0), 0.0);
    // The boxes overlap, the bodies do not.
    assert_eq!(cube_overlap([1.5, 1.5, 1.5], 0.6), 0.0);
}

#[test]
fn sphere_through_a_vertex_gives_the_overlap_not_a_wedge_too_much() {
    assert!(cube_overlap([1.4, 1.3, 0.0], 0.5).abs() < 1e-15);
    let unit = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    let tetrahedron = DecompositionElement::tetrahedron(unit).unwrap();
    let found = overlap_volume(&ball([0., 0., 0.7], 0.3), &tetrahedron);
    let expected =
        fieldstone_geometry::overlap_volume(&ball([0., 0., 0.7], 0.3), &Polyhedron::tetrahedron(unit).unwrap());
    assert!((expected - 0.017_510).abs() < 1e-6);
    assert!((found - expected).abs() < 1e-15);
    let wedge = DecompositionElement::wedge(WEDGE).unwrap();
    assert!(overlap_volume(&ball([0.3, 1.4, 1.0], 0.5), &wedge).abs() < 1e-15);
}

#[test]
fn sphere_that_touches_an_edge_overlaps_nothing() {
    // Distances 0.3 and 0.4 from the edge x = 1, y = 1.
    assert!(cube_overlap([1.3, 1.4, 0.5], 0.5).abs() < 1e-15);
    assert!(cube_overlap([1.4, 1.3, 0.2], 0.5).abs() < 1e-15);
}

#[test]
fn spheres_with_small_rational_numbers_agree_with_the_edge_sum_wherever_they_touch() {
    // Centres on a grid of tenths and radii that are tenths too: spheres through vertices, along edges and on faces by
    // the thousand.
    let unit = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    let elements = [
        (DecompositionElement::tetrahedron(unit).unwrap(), Polyhedron::tetrahedron(unit).unwrap()),
        (DecompositionElement::wedge(WEDGE).unwrap(), Polyhedron::wedge(WEDGE).unwrap()),
        (DecompositionElement::hexahedron(CUBE).unwrap(), Polyhedron::hexahedron(CUBE).unwrap()),
    ];
    let (mut tried, mut touching, mut worst) = (0, 0, 0.0_f64);
    for (ours, other) in &elements {
        for (i, j, k) in (-4..=14).flat_map(|i| (-4..=14).flat_map(move |j| (-4..=14).map(move |k| (i, j, k)))) {
            let centre = [i, j, k].map(|n| f64::from(n) / 10.0);
            for radius in [0.3, 0.5, 0.7, 0.9, 1.0, 1.3] {
                let ball = ball(centre, radius);
                let error = overlap_volume(&ball, ours) - fieldstone_geometry::overlap_volume(&ball, other);
                tried += 1;
                touching += usize::from(other.corners().any(|v| {
                    let distance = (0..3).map(|axis| (v[axis] - centre[axis]).powi(2)).sum::<f64>().sqrt();
                    (distance - radius).abs() < 1e-14
                }));
                assert!(error.abs() < 2e-13, "{} at {centre:?}, r {radius}: off by {error:e}", ours.kind());
                worst = worst.max(error.abs());
            }
        }
    }
    println!("{tried} placements, {touching} through a vertex, worst difference {worst:.1e}");
    assert!(touching > 2500);
}

#[test]
fn the_volume_does_not_jump_when_the_sphere_passes_a_vertex() {
    let cube = DecompositionElement::hexahedron(CUBE).unwrap();
    let mut random = Random(7);
    for _ in 0..2000 {
        let centre = random.point(-0.8, 1.8);
        let corner = CUBE[(random.unit() * 8.0) as usize];
        let radius = (0..3).map(|axis| (corner[axis] - centre[axis]).powi(2)).sum::<f64>().sqrt();
        let volumes: Vec<f64> = [-1e-12, -1e-14, -1e-15, -2e-16, 0.0, 2e-16, 1e-15, 1e-14, 1e-12]
            .map(|step| overlap_volume(&ball(centre, radius * (1.0 + step)), &cube))
            .to_vec();
        for pair in volumes.windows(2) {
            assert!((pair[0] - pair[1]).abs() < 5e-11, "{centre:?} {radius}: {volumes:?}");
        }
        let at_rest = volumes[4];
        assert!((volumes[3] - at_rest).abs() < 5e-13 && (volumes[5] - at_rest).abs() < 5e-13, "{volumes:?}");
    }
}

#[test]
fn hexahedron_and_wedge_agree_with_their_splits_on_random_pairs() {
    let mut random = Random(2016);
    let (mut partial, mut worst) = (0, [0.0_f64; 6]);
    for _ in 0..20_000 {
        let map = Affine::random(&mut random);
        let (hexahedron, wedge) = (map.apply(&CUBE), map.apply(&WEDGE));
        let radius = 10f64.powf(random.uniform(-1.0, 0.5));
        let ball = ball(random.point(-0.5, 1.5), radius);
        let tolerance = 4e-14 * (1.0 + ball.volume());
        let tetrahedra = |corners: &[[[f64; 3]; 4]]| -> f64 {
            corners.iter().map(|&t| overlap_volume(&ball, &DecompositionElement::tetrahedron(t).unwrap())).sum()
        };
        let element = DecompositionElement::hexahedron(hexahedron).unwrap();
        let whole = overlap_volume(&ball, &element);
        let wedges = hexahedron_to_2_wedges(&hexahedron)
            .iter()
            .map(|&w| overlap_volume(&ball, &DecompositionElement::wedge(w).unwrap()))
            .sum();
        let sums: [f64; 5] = [
            wedges,
            tetrahedra(&hexahedron_to_5_tetrahedra(&hexahedron)),
            tetrahedra(&hexahedron_to_6_tetrahedra(&hexahedron)),
            tetrahedra(&hexahedron_to_20_tetrahedra(&hexahedron)),
            tetrahedra(&hexahedron_to_24_tetrahedra(&hexahedron)),
        ];
        for (sum, worst) in sums.iter().zip(&mut worst) {
            assert!((sum - whole).abs() < tolerance, "{hexahedron:?} {ball:?}: {whole} against {sums:?}");
            *worst = worst.max((sum - whole).abs() / (1.0 + ball.volume()));
        }
        let whole_wedge = overlap_volume(&ball, &DecompositionElement::wedge(wedge).unwrap());
        let sum = tetrahedra(&wedge_to_3_tetrahedra(&wedge));
        assert!((sum - whole_wedge).abs() < tolerance, "{wedge:?} {ball:?}: {whole_wedge} against {sum}");
        worst[5] = worst[5].max((sum - whole_wedge).abs() / (1.0 + ball.volume()));
        // Each of the 61 parts is a pair of its own: over 10⁶ pairs in all, of which this counts the whole ones.
        partial += usize::from(whole > 0.0 && whole < ball.volume().min(element.volume()));
    }
    println!(
        "{partial} partial; worst over 1 + V_ball for 2, 5, 6, 20, 24 parts and 3 of a wedge: {:?}",
        worst.map(|w| format!("{w:.1e}"))
    );
    assert!(partial > 8_000);
}

#[test]
fn splits_are_oriented_and_fill_their_parent() {
    let volume = |t: &[[[f64; 3]; 4]]| -> f64 {
        t.iter().map(|&t| DecompositionElement::tetrahedron(t).unwrap().volume()).sum()
    };
    assert!((volume(&hexahedron_to_5_tetrahedra(&CUBE)) - 1.0).abs() < 1e-15);
    assert!((volume(&hexahedron_to_6_tetrahedra(&CUBE)) - 1.0).abs() < 1e-15);
    assert!((volume(&hexahedron_to_20_tetrahedra(&CUBE)) - 1.0).abs() < 1e-15);
    assert!((volume(&hexahedron_to_24_tetrahedra(&CUBE)) - 1.0).abs() < 1e-15);
    assert!((volume(&wedge_to_3_tetrahedra(&WEDGE)) - 0.5).abs() < 1e-15);
    let one = hexahedron_to_5_tetrahedra(&CUBE)[0];
    assert!((volume(&tetrahedron_to_4_tetrahedra(&one)) - volume(&[one])).abs() < 1e-16);
    let wedges = hexahedron_to_2_wedges(&CUBE);
    assert!(wedges.iter().all(|&w| (DecompositionElement::wedge(w).unwrap().volume() - 0.5).abs() < 1e-16));
}

#[test]
fn a_mesh_shares_out_the_whole_ball() {
    // The paper's validation: the sum over a mesh that covers the ball. The limits are a few times the worst seen.
    let mut random = Random(5);
    for (radius, balls, limit) in [(0.05, 200, 3e-15), (0.3, 200, 5e-15), (1.0, 100, 1e-14), (3.0, 20, 6e-14)] {
        let reach = f64::ceil(radius + 0.5) as i32;
        let axis = || (-reach..=reach).map(|n| f64::from(n) - 0.5);
        let corners = axis().flat_map(|x| axis().flat_map(move |y| axis().map(move |z| [x, y, z])));
        let cells: Vec<DecompositionElement> = corners
            .map(|at| CUBE.map(|c| [c[0] + at[0], c[1] + at[1], c[2] + at[2]]))
            .map(|cell| DecompositionElement::hexahedron(cell).unwrap())
            .collect();
        let mut worst = 0.0_f64;
        for _ in 0..balls {
            let ball = ball(random.point(-0.5, 0.5), radius);
            // Neumaier's sum: the sum's own rounding is not what is looked at.
            let (mut sum, mut rest) = (0.0, 0.0);
            for cell in &cells {
                let (total, error) = two_sum(sum, overlap_volume(&ball, cell));
                (sum, rest) = (total, rest + error);
            }
            worst = worst.max(((sum + rest) / ball.volume() - 1.0).abs());
        }
        println!("r {radius}: {worst:.1e}");
        assert!(worst < limit, "r {radius}: {worst:e}");
    }
}

#[test]
fn sphere_area_is_the_derivative_of_the_volume() {
    let mut random = Random(11);
    let step = 1e-5;
    for _ in 0..500 {
        let corners = Affine::random(&mut random).apply(&CUBE);
        let element = DecompositionElement::hexahedron(corners).unwrap();
        let (centre, radius) = (random.point(-0.3, 1.3), random.uniform(0.2, 1.2));
        let volume = |r: f64| overlap_volume(&ball(centre, r), &element);
        // The second derivative jumps where the sphere meets a vertex or edge, hence the tolerance of a step's order.
        let slope = (volume(radius + step) - volume(radius - step)) / (2.0 * step);
        let area = overlap_sphere_area(&ball(centre, radius), &element);
        assert!((slope - area).abs() < 3e-4, "{corners:?} {centre:?} {radius}: {slope} against {area}");
    }
}

#[test]
fn elements_that_the_method_cannot_take_are_refused_with_the_reason() {
    use DecompositionElementError as E;
    let with = |corner: usize, at: [f64; 3]| {
        let mut corners = CUBE;
        corners[corner] = at;
        DecompositionElement::hexahedron(corners).unwrap_err()
    };
    let error = with(6, [1.0, f64::NAN, 1.0]);
    assert!(matches!(error, E::NotFinite { corner: 6, .. }), "{error}");
    let error = with(1, [0.0; 3]);
    assert!(matches!(error, E::CoincidentCorners { first: 0, second: 1, .. }), "{error}");
    let error = with(6, [1.1, 1.0, 1.0]);
    assert!(matches!(error, E::WarpedFace { .. }), "{error}");
    assert!(error.to_string().contains("subdivide the element into tetrahedra"));

    let mirrored = ElementKind::Hexahedron.mirrored();
    let inside_out = std::array::from_fn(|i| CUBE[mirrored[i]]);
    let error = DecompositionElement::hexahedron(inside_out).unwrap_err();
    assert!(matches!(error, E::Inverted { volume, .. } if volume == -1.0), "{error}");

    let flat = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0.3, 0.3, 0.]];
    let error = DecompositionElement::tetrahedron(flat).unwrap_err();
    assert!(matches!(error, E::ZeroVolume { .. }), "{error}");

    // A prism over a quadrilateral with a corner that points inwards.
    let dart = |z: f64| [[0., 0., z], [1., 0., z], [0.2, 0.2, z], [0., 1., z]];
    let ([a, b, c, d], [e, f, g, h]) = (dart(0.), dart(1.));
    let error = DecompositionElement::hexahedron([a, b, c, d, e, f, g, h]).unwrap_err();
    assert!(matches!(error, E::NotConvex { .. }), "{error}");
}

#[test]
fn planarity_is_judged_in_units_of_the_element() {
    for scale in [1e-9, 1e-6, 1.0, 1e3, 1e9] {
        let rotated = CUBE.map(|[x, y, z]| [0.6 * x - 0.8 * y, 0.8 * x + 0.6 * y, z].map(|v| v * scale));
        let element = DecompositionElement::hexahedron(rotated).unwrap();
        assert!((element.volume() / scale.powi(3) - 1.0).abs() < 1e-14);
        let mut bent = rotated;
        bent[6][2] += 0.1 * scale;
        let error = DecompositionElement::hexahedron(bent).unwrap_err();
        assert!(matches!(error, DecompositionElementError::WarpedFace { .. }), "scale {scale}: {error}");
    }
}

struct Case {
    family: String,
    ball: Ball,
    element: Result<DecompositionElement, DecompositionElementError>,
    volume: f64,
    area: f64,
    size: f64,
}

fn cases(kind: ElementKind, file: &str) -> Vec<Case> {
    let text = fieldstone_testing::read_text(&fieldstone_testing::data("overlap-cases").join(file));
    let corner_count = kind.corner_count().unwrap();
    let parse = |line: &str| {
        let mut fields = line.split(',');
        let family = fields.next().unwrap().to_owned();
        let numbers: Vec<f64> = fields.map(|f| f.parse().unwrap()).collect();
        let corners: Vec<[f64; 3]> = numbers[4..4 + 3 * corner_count].chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
        let element = match kind {
            ElementKind::Tetrahedron => DecompositionElement::tetrahedron(corners.clone().try_into().unwrap()),
            ElementKind::Wedge => DecompositionElement::wedge(corners.clone().try_into().unwrap()),
            _ => DecompositionElement::hexahedron(corners.clone().try_into().unwrap()),
        };
        let extent = |axis: usize| {
            let along = || corners.iter().map(|c| c[axis]);
            along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
        };
        let size = (0..3).map(extent).fold(0.0, f64::max);
        let ball = Ball::new([numbers[0], numbers[1], numbers[2]], numbers[3]).unwrap();
        let volume = numbers[4 + 3 * corner_count];
        Case { family, ball, element, volume, area: numbers[5 + 3 * corner_count], size }
    };
    text.lines().skip(1).map(parse).collect()
}

#[test]
fn sixty_digit_cases_hold_to_a_few_ulps_of_the_ball_in_every_family() {
    let mut asserted = 0;
    for (kind, name) in
        [(ElementKind::Tetrahedron, "tet"), (ElementKind::Wedge, "wedge"), (ElementKind::Hexahedron, "hex")]
    {
        let cases = cases(kind, &format!("{name}.csv.gz"));
        // Errors over min(V_ball, V_element), and over V_ball for what the method itself promises.
        let mut families: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
        for case in &cases {
            let element = case.element.as_ref().unwrap_or_else(|reason| panic!("{name} {}: {reason}", case.family));
            let found = overlap_volume(&case.ball, element);
            assert!(found.is_finite() && found >= 0.0);
            let ratio = case.ball.radius() / case.size;
            let smaller = case.ball.volume().min(element.volume());
            let error = (found - case.volume).abs();
            let mut family = case.family.clone();
            if family == "generic" {
                family += if ratio <= 10.0 { " r/L ≤ 10" } else { " r/L > 10" };
            }
            // What holds everywhere follows the ball; tiny balls lose what the coordinates leave of the distances.
            let of_ball = if family.starts_with("tiny") { 1e-10 } else { 5e-15 };
            let of_smaller = if case.family == "generic" && ratio <= 10.0 { 1e-10 } else { f64::INFINITY };
            let limit = (of_ball * case.ball.volume()).min(of_smaller * smaller);
            assert!(error <= limit, "{name} {family}, r/L {ratio}: {found} for {}", case.volume);
            asserted += 1;
            if case.family == "generic" && ratio <= 10.0 {
                let area = overlap_sphere_area(&case.ball, element);
                assert!((area - case.area).abs() <= 1e-12 * 4.0 * PI * case.ball.radius().powi(2), "{name} {family}");
            }
            families.entry(family).or_default().push((error / smaller, error / case.ball.volume()));
        }
        println!(
            "{name}\n{:<20}{:>6}{:>10}{:>10}{:>14}{:>14}",
            "family", "cases", "median", "worst", "worst/V_ball", "above 1e-10"
        );
        for (family, mut errors) in families {
            errors.sort_by(|a, b| a.0.total_cmp(&b.0));
            let worst = errors.last().unwrap().0;
            let of_ball = errors.iter().map(|e| e.1).fold(0.0, f64::max);
            let above = errors.iter().filter(|e| e.0 > 1e-10).count();
            println!(
                "{family:<20}{:>6}{:>10.1e}{worst:>10.1e}{of_ball:>14.1e}{above:>14}",
                errors.len(),
                errors[errors.len() / 2].0
            );
        }
    }
    assert_eq!(asserted, 1200);
}
