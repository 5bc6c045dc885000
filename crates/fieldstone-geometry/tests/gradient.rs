//! Gradient and sphere area against finite differences of an independent volume in 38 digits.
//!
//! `data/gradient-cases/cases.csv` is written by `tools/gradient_cases.py`, which says how.

#![allow(clippy::unwrap_used)]

mod common;

use std::collections::BTreeMap;

use common::element;
use fieldstone_geometry::{Ball, ElementKind, overlap};

#[test]
fn gradient_and_sphere_area_equal_finite_differences_in_many_digits() {
    let text = fieldstone_testing::read_text(&fieldstone_testing::data("gradient-cases/cases.csv"));
    let mut worst = BTreeMap::<String, (usize, f64, f64, f64)>::new();
    let mut count = 0;
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let kind = match cells[1] {
            "tet" => ElementKind::Tetrahedron,
            "pyramid" => ElementKind::Pyramid,
            "wedge" => ElementKind::Wedge,
            "hex" => ElementKind::Hexahedron,
            other => panic!("unknown kind {other}"),
        };
        let number = |k: usize| cells[k].parse::<f64>().unwrap();
        let corners: Vec<[f64; 3]> = (0..kind.corner_count().unwrap())
            .map(|k| [number(6 + 3 * k), number(7 + 3 * k), number(8 + 3 * k)])
            .collect();
        let polyhedron = element(kind, &corners);
        let ball = Ball::new([number(2), number(3), number(4)], number(5)).unwrap();
        let result = overlap(&ball, &polyhedron);

        // Scales: of the volume, the smaller body; of the areas, the smaller surface.
        let surface = ball.surface_area().min(polyhedron.face_areas().iter().sum());
        let volume = (result.volume - number(30)).abs() / ball.volume().min(polyhedron.volume());
        let gradient = (0..3).map(|k| (result.gradient[k] - number(31 + k)).abs()).fold(0.0, f64::max) / surface;
        let area = (result.sphere_area - number(34)).abs() / surface;
        let name = if cells[0].starts_with("generic") { "generic" } else { cells[0] };
        let w = worst.entry(name.into()).or_default();
        *w = (w.0 + 1, w.1.max(volume), w.2.max(gradient), w.3.max(area));
        assert!(volume <= 1e-12, "{kind} {}: volume off by {volume:e}", cells[0]);
        assert!(gradient <= 1e-12, "{kind} {}: gradient off by {gradient:e}", cells[0]);
        assert!(area <= 1e-12, "{kind} {}: sphere area off by {area:e}", cells[0]);
        count += 1;
    }
    println!(
        "| placement | cases | volume / min(V) | gradient / surface | sphere area / surface |\n|---|---|---|---|---|"
    );
    for (name, (n, volume, gradient, area)) in worst {
        println!("| {name} | {n} | {volume:.1e} | {gradient:.1e} | {area:.1e} |");
    }
    assert!(count >= 60, "only {count} cases");
}
