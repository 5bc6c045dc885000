//! Boxes of any tilt against a brute search over their lattice, and against the orthogonal case.

#![allow(clippy::unwrap_used)]

use fieldstone_particles::Domain;
use proptest::prelude::*;

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn add(u: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| u[k] + v[k])
}

/// Whole combinations of the periodic edges with coefficients up to `most`.
fn lattice(domain: &Domain, most: i32) -> Vec<[f64; 3]> {
    let edges = domain.cell_vectors();
    let range = |k: usize| if domain.periodic()[k] { -most..=most } else { 0..=0 };
    let mut all = Vec::new();
    for a in range(0) {
        for b in range(1) {
            for c in range(2) {
                let n = [a, b, c].map(f64::from);
                all.push(std::array::from_fn(|k| (0..3).map(|e| n[e] * edges[e][k]).sum()));
            }
        }
    }
    all
}

fn boxes() -> impl Strategy<Value = Domain> {
    (
        prop::array::uniform3(-2.0..2.0f64),
        prop::array::uniform3(0.5..2.0f64),
        prop::array::uniform3(-2.5..2.5f64),
        any::<[bool; 3]>(),
    )
        .prop_map(|(low, lengths, tilt, periodic)| Domain::triclinic(low, lengths, tilt, periodic).unwrap())
}

proptest! {
    #[test]
    fn the_minimum_image_is_the_shortest_that_a_search_finds(domain in boxes(), v in prop::array::uniform3(-3.0..3.0f64)) {
        let found = domain.minimum_image(v);
        let shortest = lattice(&domain, 9).into_iter().map(|shift| length(add(v, shift))).fold(f64::INFINITY, f64::min);
        prop_assert!(length(found) <= shortest * (1.0 + 1e-12), "{found:?} is longer than {shortest}");
        // It is one of the images: what was added is a lattice vector.
        let moved = domain.fractions(add(domain.low(), std::array::from_fn(|k| found[k] - v[k])));
        for k in 0..3 {
            let whole = if domain.periodic()[k] { moved[k].round() } else { 0.0 };
            prop_assert!((moved[k] - whole).abs() < 1e-11, "{moved:?}");
        }
    }

    #[test]
    fn wrapping_moves_by_whole_edges_into_the_box(domain in boxes(), at in prop::array::uniform3(-9.0..9.0f64)) {
        let wrapped = domain.wrap(at);
        let (before, after) = (domain.fractions(at), domain.fractions(wrapped));
        for k in 0..3 {
            if domain.periodic()[k] {
                prop_assert!(after[k] > -1e-12 && after[k] < 1.0 + 1e-12, "{after:?}");
                prop_assert!((before[k] - after[k] - (before[k] - after[k]).round()).abs() < 1e-11);
            } else {
                prop_assert!((before[k] - after[k]).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn every_image_that_reaches_into_the_box_is_listed_once(
        domain in boxes(), at in prop::array::uniform3(-3.0..3.0f64), radius in 0.05..1.5f64,
    ) {
        let centre = domain.wrap(at);
        let images: Vec<_> = domain.images(at, radius).collect();
        prop_assert_eq!(images[0], centre);
        let same = |u: [f64; 3], v: [f64; 3]| (0..3).all(|k| (u[k] - v[k]).abs() < 1e-10);
        for (i, &image) in images.iter().enumerate() {
            prop_assert!(!images[..i].iter().any(|&other| same(other, image)), "{image:?} twice");
        }
        // Points of the box that a ball around an image holds: that image must be among those listed.
        for step in 0..64 {
            let fraction = [0, 1, 2].map(|k| (f64::from(step >> (2 * k) & 3)) / 3.0);
            let edges = domain.cell_vectors();
            let point: [f64; 3] =
                std::array::from_fn(|k| domain.low()[k] + (0..3).map(|e| fraction[e] * edges[e][k]).sum::<f64>());
            for shift in lattice(&domain, 5) {
                let image = add(centre, shift);
                if length(std::array::from_fn(|k| image[k] - point[k])) < radius {
                    prop_assert!(images.iter().any(|&listed| same(listed, image)), "{image:?} is missing");
                }
            }
        }
    }

    #[test]
    fn heights_and_volume_are_those_of_the_parallelepiped(domain in boxes()) {
        let [a, b, c] = domain.cell_vectors();
        let cross = |u: [f64; 3], v: [f64; 3]|
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let faces = [cross(b, c), cross(c, a), cross(a, b)].map(length);
        for (height, face) in domain.heights().iter().zip(faces) {
            prop_assert!((height * face / domain.volume() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_box_without_tilt_is_the_orthogonal_one(
        low in prop::array::uniform3(-2.0..2.0f64),
        lengths in prop::array::uniform3(0.5..2.0f64),
        periodic in any::<[bool; 3]>(),
        at in prop::array::uniform3(-9.0..9.0f64),
        radius in 0.05..1.5f64,
    ) {
        let tilted = Domain::triclinic(low, lengths, [0.0, -0.0, 0.0], periodic).unwrap();
        let upright = Domain::new(low, add(low, lengths), periodic).unwrap();
        prop_assert_eq!(tilted, upright);
        let found: Vec<_> = tilted.images(at, radius).collect();
        // The formula of the orthogonal case, bit for bit.
        let origin = upright.wrap(at);
        for image in &found {
            for k in 0..3 {
                let steps = ((image[k] - origin[k]) / upright.lengths()[k]).round();
                prop_assert_eq!(image[k].to_bits(), (origin[k] + steps * upright.lengths()[k]).to_bits());
            }
        }
    }
}

#[test]
fn an_extreme_tilt_still_gives_the_shortest_vector_soon() {
    // The edges (1e6, 1, 0) and (1, 0, 0) span the lattice of whole numbers.
    let domain = Domain::triclinic([0.0; 3], [1.0; 3], [1e6, -3e5, 7e5], [true; 3]).unwrap();
    let found = domain.minimum_image([0.25, 41.5, -17.25]);
    assert!((length(found) - length([0.25, 0.5, 0.25])).abs() < 1e-9, "{found:?}");
}

#[test]
fn a_tilt_that_is_no_number_is_refused_by_name() {
    let error = Domain::triclinic([0.0; 3], [1.0; 3], [0.0, f64::NAN, 0.0], [true; 3]).unwrap_err();
    assert!(error.to_string().contains("tilt xz = NaN"), "{error}");
}

#[test]
fn a_box_far_from_the_origin_wraps_to_a_few_units_in_the_last_place() {
    let domain = Domain::triclinic([1e6; 3], [1.0; 3], [0.25, 0.5, -0.25], [true; 3]).unwrap();
    let wrapped = domain.wrap([1e6 - 0.125, 1e6 + 0.5, 1e6 + 3.5]);
    let fractions = domain.fractions(wrapped);
    assert!(fractions.iter().all(|f| (-1e-9..1.0 + 1e-9).contains(f)), "{fractions:?}");
}
