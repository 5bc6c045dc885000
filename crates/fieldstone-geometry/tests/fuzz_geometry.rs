//! Adversarial pairs by the million: nearly tangent, tiny edges, slivers, centres on corners, edges and faces, lattices.
//!
//! By default 2,000; `FIELDSTONE_FUZZ_PAIRS=1000000` or `FIELDSTONE_FUZZ_SECONDS=600` for a night, with
//! `FIELDSTONE_FUZZ_SEED` for other ones:
//!
//!     FIELDSTONE_FUZZ_SECONDS=600 cargo test --release -p fieldstone-geometry --test fuzz_geometry -- --nocapture
//!
//! Every find is printed with the numbers that reproduce it, and becomes a named test below.

#![allow(clippy::unwrap_used)]

mod common;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use common::invariants::{Report, check};
use common::{Point, Random, Shape, beside_an_edge, between, cross, dot, generic_corners, size_of, sub};
use fieldstone_geometry::decomposition::{self, DecompositionElement};
use fieldstone_geometry::{
    Ball, ElementKind, Orientation, PROMISE, Polyhedron, Precision, fast_overlap_volume, overlap_in, overlap_volume,
};

/// Shapes, from harmless to nasty.
fn shape(random: &mut Random) -> (&'static str, Shape) {
    let kind = ElementKind::STANDARD[random.below(4)];
    let generic = |random: &mut Random| generic_corners(kind, random);
    let (name, corners) = match random.below(6) {
        0 => ("generic", generic(random)),
        1 => {
            // Whole numbers: planes, edges and spheres meet exactly.
            let mut corners = Vec::new();
            for _ in 0..4 {
                corners.push([0; 3].map(|_| random.whole(-3, 3)));
            }
            return ("lattice tetrahedron", tetrahedron(corners));
        }
        2 => {
            let unit = common::unit_corners(kind);
            let steps = [0; 3].map(|_| random.whole(1, 4) * 0.5);
            ("unit shape, stretched", unit.iter().map(|p| [0, 1, 2].map(|k| p[k] * steps[k])).collect())
        }
        3 => {
            // A power of two keeps the faces as planar as they were.
            let flat = 2f64.powi(-(random.whole(1, 30) as i32));
            let axis = random.below(3);
            let mut corners = generic(random);
            for p in &mut corners {
                p[axis] *= flat;
            }
            ("sliver", corners)
        }
        4 => {
            // Two corners nearly in one point.
            let mut corners = generic_corners(ElementKind::Tetrahedron, random);
            let tiny = 10f64.powf(random.uniform(-12.0, -1.0));
            let d = random.direction();
            corners[1] = [0, 1, 2].map(|k| corners[0][k] + tiny * d[k]);
            return ("tiny edge", tetrahedron(corners));
        }
        _ => {
            // Four nearly coplanar points of a tetrahedron.
            let mut corners = generic_corners(ElementKind::Tetrahedron, random);
            let (s, t) = (random.uniform(0.0, 1.0), random.uniform(0.0, 1.0));
            let height = 10f64.powf(random.uniform(-12.0, -1.0));
            let on = between(between(corners[0], corners[1], s), corners[2], t);
            corners[3] = between(on, corners[3], height);
            return ("flat tetrahedron", tetrahedron(corners));
        }
    };
    (name, Shape::of(kind, &corners))
}

fn tetrahedron(mut corners: Vec<Point>) -> Shape {
    let [a, b, c] = [1, 2, 3].map(|k| sub(corners[k], corners[0]));
    if dot(cross(a, b), c) < 0.0 {
        corners.swap(1, 2);
    }
    Shape::of(ElementKind::Tetrahedron, &corners)
}

/// A centre, where it hurts.
fn centre(shape: &Shape, random: &mut Random) -> (&'static str, Point) {
    let corner = |random: &mut Random| shape.corners[random.below(shape.corners.len())];
    let size = size_of(&shape.corners);
    match random.below(7) {
        0 => ("at a corner", corner(random)),
        1 => {
            let face = &shape.faces[random.below(shape.faces.len())];
            let k = random.below(face.len());
            let t = [0.5, 0.25, random.uniform(-0.5, 1.5)][random.below(3)];
            ("on an edge's line", between(shape.corners[face[k]], shape.corners[face[(k + 1) % face.len()]], t))
        }
        2 => {
            let face = &shape.faces[random.below(shape.faces.len())];
            let (s, t) = (random.uniform(0.0, 1.0), random.uniform(0.0, 1.0));
            let on = between(shape.corners[face[0]], shape.corners[face[1]], s);
            ("on a face", between(on, shape.corners[face[2]], t))
        }
        3 => ("on a lattice", [0; 3].map(|_| 0.5 * random.whole(-8, 8))),
        4 => {
            let near = corner(random);
            let d = random.direction();
            let tiny = size * 10f64.powf(random.uniform(-16.0, -3.0));
            ("next to a corner", [0, 1, 2].map(|k| near[k] + tiny * d[k]))
        }
        5 => ("within ulps of an edge", beside_an_edge(&shape.corners, &shape.faces, size, random)),
        _ => {
            let (from, d) = (corner(random), random.direction());
            let far = size * random.log_uniform(1e-3, 30.0);
            ("anywhere", [0, 1, 2].map(|k| from[k] + far * d[k]))
        }
    }
}

/// A radius with which the sphere meets, or just misses, a corner, an edge or a face.
fn radius(shape: &Shape, centre: Point, random: &mut Random) -> (&'static str, f64) {
    let size = size_of(&shape.corners);
    let face = &shape.faces[random.below(shape.faces.len())];
    let a = shape.corners[face[0]];
    let b = shape.corners[face[1]];
    let to = |p: Point| size_of(&[p, centre]);
    let (name, exact) = match random.below(5) {
        0 => ("to a corner", to(a)),
        1 => {
            let e = sub(b, a);
            ("to an edge's line", to(between(a, b, dot(sub(centre, a), e) / dot(e, e))))
        }
        2 => ("to a face's plane", dot(common::invariants::normal(shape, face), sub(a, centre)).abs()),
        3 => ("on a lattice", 0.5 * random.whole(1, 12)),
        _ => ("any", size * random.log_uniform(1e-3, 30.0)),
    };
    let off = [0.0, f64::EPSILON, 4.0 * f64::EPSILON, 1e-12, 1e-9, 1e-5][random.below(6)];
    let sign = if random.below(2) == 0 { 1.0 } else { -1.0 };
    let r = exact * (1.0 + sign * off);
    // Far smaller balls see planes that f64 does not resolve.
    (name, if r > 1e-6 * size { r } else { size * random.log_uniform(1e-4, 1.0) })
}

/// The other exact method, on the shapes that it takes, to what it promises: 5e-15 of the ball, and what rounding of the
/// corners' coordinates is beside the radius.
fn decomposition_agrees(shape: &Shape, centre: Point, r: f64, report: &mut Report) -> Result<(), String> {
    let corners = &shape.corners;
    let element = match corners.len() {
        4 => DecompositionElement::tetrahedron(corners[..].try_into().unwrap()),
        6 => DecompositionElement::wedge(corners[..].try_into().unwrap()),
        8 => DecompositionElement::hexahedron(corners[..].try_into().unwrap()),
        _ => return Ok(()),
    };
    // Refused: flat beyond what the method takes.
    let Ok(element) = element else { return Ok(()) };
    let ball = Ball::new(centre, r).unwrap();
    let error = (decomposition::overlap_volume(&ball, &element) - overlap_volume(&ball, &shape.build())).abs();
    let allowed = (5e-15 + 4.0 * f64::EPSILON * size_of(corners) / r) * ball.volume();
    report.note("decomposition", error, allowed)
}

#[test]
fn adversarial_pairs_keep_all_invariants() {
    let from_environment = |name: &str| std::env::var(name).ok().map(|n| n.parse::<u64>().unwrap());
    let seconds = from_environment("FIELDSTONE_FUZZ_SECONDS").map(Duration::from_secs);
    let pairs = from_environment("FIELDSTONE_FUZZ_PAIRS").unwrap_or(if seconds.is_some() { u64::MAX } else { 2_000 });
    let seed = from_environment("FIELDSTONE_FUZZ_SEED").unwrap_or(1);
    let start = Instant::now();
    let mut seeds = Random(seed);
    let mut report = Report::default();
    let mut families = BTreeMap::<String, u64>::new();
    let (mut checked, mut refused, mut finds) = (0u64, 0u64, Vec::new());
    while checked < pairs && seconds.is_none_or(|s| start.elapsed() < s) {
        let seed = seeds.bits();
        let mut random = Random(seed);
        let (shape_name, shape) = shape(&mut random);
        // Coincident corners or no volume: not an element, and said so when it is built.
        if Polyhedron::from_faces(&shape.corners, &shape.faces, Orientation::Refuse).is_err() {
            refused += 1;
            continue;
        }
        let (centre_name, centre) = centre(&shape, &mut random);
        let (radius_name, r) = radius(&shape, centre, &mut random);
        checked += 1;
        *families.entry(shape_name.into()).or_default() += 1;
        let checks = check(&shape, centre, r, &mut random, &mut report);
        if let Err(why) = checks.and_then(|()| decomposition_agrees(&shape, centre, r, &mut report)) {
            finds.push((shape_name, why.split(':').next().unwrap_or_default().to_owned()));
            if finds.len() <= 20 {
                println!("{shape_name}, centre {centre_name}, radius {radius_name} (seed {seed}): {why}");
                println!("  corners {:?}\n  centre {centre:?}, radius {r:?}", shape.corners);
            }
        }
    }
    println!("{checked} pairs in {:.0} s, {refused} refused: {families:?}", start.elapsed().as_secs_f64());
    for (name, share) in &report.worst {
        println!("  {name}: at most {share:.2} of what rounding may do");
    }
    let mut kinds = BTreeMap::<_, u64>::new();
    for find in &finds {
        *kinds.entry(find).or_default() += 1;
    }
    assert!(finds.is_empty(), "{} of {checked} pairs break an invariant: {kinds:?}", finds.len());
    assert!(families.len() == 6 && checked > 100 && refused < checked, "{families:?}");
}

#[test]
fn the_bound_holds_for_a_tiny_ball_that_touches_a_large_element_at_a_corner() {
    let tetrahedron = Polyhedron::tetrahedron([
        [0.0, 0.0, 0.0],
        [0.0003763656885485777, -0.000838462619014298, 0.0003802681341039562],
        [0.991053945752711, -0.4986358897893379, 0.8935404119201269],
        [-0.5024370505282003, 0.695353145103214, 0.6715643860476179],
    ])
    .unwrap();
    let centre = [-2.978874539575587e-6, -8.686573311000575e-7, -2.082038315394669e-6];
    let ball = Ball::new(centre, 3.7367288673620697e-6).unwrap();
    let exact = overlap_in(&ball, &tetrahedron, Precision::Wide).overlap.volume;
    let (fast, bound) = fast_overlap_volume(&ball, &tetrahedron);
    assert!((fast - exact).abs() <= bound, "off by {:e}, bound {bound:e}", (fast - exact).abs());
    let error = (overlap_volume(&ball, &tetrahedron) - exact).abs() / ball.volume();
    assert!(error <= PROMISE, "off by {error:e} of the ball");
}
