//! The certified path against sixty digits.

#![allow(clippy::unwrap_used)]

use fieldstone_geometry::{Ball, CornerOrder, ElementKind, Orientation, Polyhedron, certified_overlap, error_estimate};
use std::collections::BTreeMap;

#[test]
fn figures() {
    let mut table = BTreeMap::<String, (usize, f64, f64, f64, [usize; 3], Vec<f64>)>::new();
    for (kind, file) in [
        (ElementKind::Tetrahedron, "tet.csv.gz"),
        (ElementKind::Wedge, "wedge.csv.gz"),
        (ElementKind::Hexahedron, "hex.csv.gz"),
    ] {
        let text = fieldstone_testing::read_text(&fieldstone_testing::data("overlap-cases").join(file));
        let corners = kind.corner_count().unwrap();
        for line in text.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let n: Vec<f64> = cells[1..].iter().map(|c| c.parse().unwrap()).collect();
            let points: Vec<[f64; 3]> = n[4..4 + 3 * corners].chunks(3).map(|p| [p[0], p[1], p[2]]).collect();
            let rest = &n[4 + 3 * corners..];
            let ball = Ball::new([n[0], n[1], n[2]], n[3]).unwrap();
            let element = Polyhedron::element(kind, CornerOrder::Cgns, &points, Orientation::Refuse).unwrap();
            let result = certified_overlap(&ball, &element);
            let smaller = ball.volume().min(element.volume());
            let error = (result.overlap.volume - rest[0]).abs();
            let e = table.entry(cells[0].into()).or_default();
            e.0 += 1;
            e.1 = e.1.max(error / smaller);
            e.2 = e.2.max(result.volume_error / smaller);
            e.3 = e.3.max(error / result.volume_error.max(1e-300));
            e.4[result.precision as usize] += 1;
            if error > 0.0 {
                e.5.push(result.volume_error / error.max(1e-17 * smaller));
            }
            let mut worst: f64 = 0.0;
            for (k, a) in result.overlap.face_areas.iter().enumerate() {
                let m = element.face_areas()[k].min(ball.surface_area());
                worst = worst.max((a - rest[2 + k]).abs() / m);
            }
            worst = worst.max(
                (result.overlap.sphere_area - rest[1]).abs()
                    / ball.surface_area().min(element.face_areas().iter().sum()),
            );
            if error / smaller > 1e-12 || error > result.volume_error || worst > 1e-12 {
                println!(
                    "{} {kind} r {:e} V {:e} el {:e} error {:e} bound {:e} {:?} area {worst:e}",
                    cells[0],
                    ball.radius(),
                    rest[0],
                    element.volume(),
                    error / smaller,
                    result.volume_error / smaller,
                    result.precision
                );
            }
            let _ = error_estimate(&ball, &element);
        }
    }
    for (f, mut e) in table {
        e.5.sort_by(f64::total_cmp);
        println!(
            "{f}: {} error {:.1e} bound {:.1e} ratio {:.1e} {:?} median {:.1e}",
            e.0,
            e.1,
            e.2,
            e.3,
            e.4,
            e.5.get(e.5.len() / 2).copied().unwrap_or(0.0)
        );
    }
}
