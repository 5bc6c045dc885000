//! Two methods that share no formula agree on random pairs: the kernel's sums over edges, and caps, wedges and cones.
//!
//! Radii are 0.1 to 5 times the edge of the cube with the element's volume. 100,000 pairs per kind;
//! `FIELDSTONE_PAIRS=1000000` for more. The worst are printed with `--nocapture`.

#![allow(clippy::unwrap_used)]

mod common;

use common::{Random, beside_an_edge, dot, element, generic_corners, size_of, sub};
use fieldstone_geometry::decomposition::{self, DecompositionElement};
use fieldstone_geometry::{Ball, ElementKind, Polyhedron, overlap};

const LIMIT: f64 = 1e-10;

/// What the decomposition promises, of the ball's volume.
const OF_BALL: f64 = 5e-15;

fn both(kind: ElementKind, corners: &[[f64; 3]]) -> (Polyhedron, DecompositionElement) {
    let other = match kind {
        ElementKind::Tetrahedron => DecompositionElement::tetrahedron(corners.try_into().unwrap()),
        ElementKind::Wedge => DecompositionElement::wedge(corners.try_into().unwrap()),
        _ => DecompositionElement::hexahedron(corners.try_into().unwrap()),
    };
    (element(kind, corners), other.unwrap())
}

/// How many pairs are drawn.
fn pairs() -> usize {
    std::env::var("FIELDSTONE_PAIRS").map_or(100_000, |n| n.parse().unwrap())
}

fn agree(kind: ElementKind, seed: u64) {
    let pairs = pairs();
    let mut random = Random(seed);
    let (mut partial, mut worst, mut worst_area, mut worst_at) = (0, 0.0f64, 0.0f64, String::new());
    let mut drawn = 0;
    while drawn < pairs {
        let corners = generic_corners(kind, &mut random);
        let (polyhedron, decomposed) = both(kind, &corners);
        let size = polyhedron.volume().cbrt();
        // An element is used a few times: the balls are what differs most.
        for _ in 0..10.min(pairs - drawn) {
            drawn += 1;
            let r = size * random.log_uniform(0.1, 5.0);
            // A point of the element, and a centre such that the sphere is near that point.
            let weights: Vec<f64> = corners.iter().map(|_| random.uniform(0.0, 1.0)).collect();
            let total: f64 = weights.iter().sum();
            let at = [0, 1, 2].map(|k| corners.iter().zip(&weights).map(|(p, w)| p[k] * w / total).sum::<f64>());
            let direction = random.direction();
            let reach = r * random.uniform(0.6, 1.1);
            let centre = [0, 1, 2].map(|k| at[k] + reach * direction[k]);

            let ball = Ball::new(centre, r).unwrap();
            let smaller = ball.volume().min(polyhedron.volume());
            let ours = overlap(&ball, &polyhedron);
            let theirs = decomposition::overlap_volume(&ball, &decomposed);
            let their_area = decomposition::overlap_sphere_area(&ball, &decomposed);
            partial += usize::from(ours.volume > 1e-9 * smaller && ours.volume < (1.0 - 1e-9) * smaller);
            let error = (ours.volume - theirs).abs() / smaller;
            worst_area = worst_area.max((ours.sphere_area - their_area).abs() / ball.surface_area());
            if error > worst {
                worst = error;
                worst_at = format!("corners {corners:?}, centre {centre:?}, radius {r:?}");
            }
            assert!(error.is_finite(), "corners {corners:?}, centre {centre:?}, radius {r:?}");
        }
    }
    println!(
        "{kind}: {drawn} pairs, {partial} partial, volumes within {worst:.1e} min(V), areas within {worst_area:.1e} 4πr²"
    );
    assert!(partial * 3 > drawn, "only {partial} of {drawn} pairs overlap in part");
    assert!(worst <= LIMIT, "{kind}: {worst:e} of min(V) at {worst_at}");
    assert!(worst_area <= LIMIT, "{kind}: sphere areas differ by {worst_area:e}");
}

#[test]
fn kernel_and_decomposition_agree_on_random_tetrahedra() {
    agree(ElementKind::Tetrahedron, 1);
}

#[test]
fn kernel_and_decomposition_agree_on_random_wedges() {
    agree(ElementKind::Wedge, 2);
}

#[test]
fn kernel_and_decomposition_agree_on_random_hexahedra() {
    agree(ElementKind::Hexahedron, 3);
}

/// As [`agree`] for centres within ulps of an edge or a corner, as far off as rounding puts what is meant to be on it.
fn agree_at_edges(kind: ElementKind, seed: u64) {
    let pairs = pairs();
    let mut random = Random(seed);
    let (mut worst, mut worst_area, mut worst_at) = (0.0f64, 0.0f64, String::new());
    let mut drawn = 0;
    while drawn < pairs {
        let corners = generic_corners(kind, &mut random);
        let (polyhedron, decomposed) = both(kind, &corners);
        let size = polyhedron.volume().cbrt();
        for _ in 0..10.min(pairs - drawn) {
            drawn += 1;
            let r = size * random.log_uniform(0.1, 5.0);
            let centre = beside_an_edge(&corners, kind.faces(), r, &mut random);
            let ball = Ball::new(centre, r).unwrap();
            let ours = overlap(&ball, &polyhedron);
            // Distances of planes are rounded as the corners' coordinates are, which small balls notice.
            let allowed = OF_BALL + f64::EPSILON * size_of(&corners) / r;
            let volume = ours.volume - decomposition::overlap_volume(&ball, &decomposed);
            let volume = volume.abs() / ball.volume() / allowed;
            let area = ours.sphere_area - decomposition::overlap_sphere_area(&ball, &decomposed);
            worst_area = worst_area.max(area.abs() / ball.surface_area() / allowed);
            assert!(volume.is_finite() && area.is_finite(), "corners {corners:?}, centre {centre:?}, radius {r:?}");
            if volume > worst {
                worst = volume;
                worst_at = format!("corners {corners:?}, centre {centre:?}, radius {r:?}");
            }
        }
    }
    println!("{kind}: {drawn} pairs, volumes within {worst:.2} of what is allowed, areas within {worst_area:.2}");
    assert!(worst <= 1.0, "{kind}: {worst} of what is allowed at {worst_at}");
    assert!(worst_area <= 1.0, "{kind}: sphere areas differ by {worst_area} of what is allowed");
}

#[test]
fn kernel_and_decomposition_agree_within_ulps_of_edges_and_corners() {
    agree_at_edges(ElementKind::Tetrahedron, 5);
    agree_at_edges(ElementKind::Wedge, 6);
    agree_at_edges(ElementKind::Hexahedron, 7);
}

#[test]
fn random_elements_have_no_two_parallel_faces_and_differ_from_each_other() {
    let mut random = Random(4);
    let a = generic_corners(ElementKind::Hexahedron, &mut random);
    let b = generic_corners(ElementKind::Hexahedron, &mut random);
    assert!(size_of(&[a[6], b[6]]) > 1e-3);
    let normal = |c: &[[f64; 3]], f: &[usize]| common::cross(sub(c[f[1]], c[f[0]]), sub(c[f[2]], c[f[0]]));
    let faces = ElementKind::Hexahedron.faces();
    let (n, m) = (normal(&a, faces[1]), normal(&a, faces[3]));
    let c = common::cross(n, m);
    assert!(dot(c, c) > 1e-6 * dot(n, n) * dot(m, m));
}
