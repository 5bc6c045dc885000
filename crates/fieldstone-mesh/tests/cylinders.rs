//! Cylindrical grids: volumes, overlaps, points and segments.
#![allow(clippy::unwrap_used)]

use std::f64::consts::PI;

use fieldstone_geometry::Ball;
use fieldstone_mesh::{Cells, CylinderGrid};
use fieldstone_testing::Random;
use proptest::prelude::*;

fn overlaps(grid: &CylinderGrid, ball: &Ball) -> Vec<f64> {
    let mut pairs = Vec::new();
    grid.overlap_ball(ball, &mut grid.scratch(), &mut pairs);
    let mut volumes = vec![0.0; grid.cell_count()];
    pairs.iter().for_each(|&(c, v)| volumes[c as usize] += v);
    volumes
}

#[test]
fn cells_fill_the_cylinder_and_hold_their_own_centres() {
    let grid = CylinderGrid::new(0, [1.0, 2.0, 3.0], [0.5, 2.0], [-1.0, 4.0], [3, 5, 4]).unwrap();
    let total: f64 = (0..grid.cell_count()).map(|c| grid.cell_volume(c)).sum();
    assert!((total - PI * (4.0 - 0.25) * 5.0).abs() < 1e-12);
    for cell in 0..grid.cell_count() {
        assert_eq!(grid.locate(grid.cell_centre(cell), &mut grid.scratch()), Some(cell as u32));
    }
    assert_eq!(grid.locate([1.0, 2.0, 3.0], &mut grid.scratch()), None, "on the axis, within the inner radius");
}

#[test]
fn overlaps_agree_with_counting_points() {
    let grid = CylinderGrid::new(2, [0.1, -0.2, 0.3], [0.0, 1.5], [-0.7, 0.9], [3, 4, 2]).unwrap();
    for (centre, r) in [([0.4, 0.1, 0.2], 0.6), ([0.1, -0.2, 0.3], 0.5), ([1.2, 0.9, 0.4], 0.7)] {
        let ball = Ball::new(centre, r).unwrap();
        let exact = overlaps(&grid, &ball);
        let n = 160;
        let h = 2.0 * r / f64::from(n);
        let mut counted = vec![0.0; grid.cell_count()];
        for at in 0..n * n * n {
            let d = [at % n, at / n % n, at / (n * n)].map(|k| -r + (f64::from(k) + 0.5) * h);
            if d.iter().map(|x| x * x).sum::<f64>() < r * r
                && let Some(c) = grid.locate(std::array::from_fn(|k| centre[k] + d[k]), &mut grid.scratch())
            {
                counted[c as usize] += h * h * h;
            }
        }
        for (a, b) in exact.iter().zip(&counted) {
            assert!((a - b).abs() < 2e-3 * ball.volume(), "{a} {b}");
        }
    }
}

#[test]
fn grids_that_make_no_sense_are_refused() {
    for (axis, radii, heights, cells) in [
        (3, [0.0, 1.0], [0.0, 1.0], [1; 3]),
        (2, [-0.1, 1.0], [0.0, 1.0], [1; 3]),
        (2, [0.0, 1.0], [1.0, 1.0], [1; 3]),
        (2, [0.0, f64::NAN], [0.0, 1.0], [1; 3]),
        (2, [0.0, 1.0], [0.0, 1.0], [1, 0, 1]),
    ] {
        assert!(CylinderGrid::new(axis, [0.0; 3], radii, heights, cells).is_err());
    }
}

/// Abscissae and weights of Gauss–Legendre quadrature on −1…1, by Newton's method.
fn legendre(n: usize) -> Vec<[f64; 2]> {
    let node = |k: usize| {
        let mut x = (PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..20 {
            let (mut before, mut value) = (1.0, x);
            for m in 2..=n {
                (before, value) = (value, ((2 * m - 1) as f64 * x * value - (m - 1) as f64 * before) / m as f64);
            }
            slope = n as f64 * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        [x, 2.0 / ((1.0 - x * x) * slope * slope)]
    };
    (0..n).map(node).collect()
}

/// A ball's volume in a cell above its centre that only its upper side cuts: the height over a point of the plane is a
/// smooth function, integrated across the axis, not along it. `None` for other cells.
fn below_the_cap(grid: &CylinderGrid, cell: usize, d: f64, r: f64, rule: &[[f64; 2]]) -> Option<f64> {
    let [i, j, k] = grid.indices(cell);
    let (a, b) = (grid.radius(i), grid.radius(i + 1));
    let (from, to) = (grid.angle(j), grid.angle(j + 1));
    let (low, high) = (grid.height(k), grid.height(k + 1));
    let mut sum = 0.0;
    // The ends of the cell, too, must be well under the ball.
    for &[x, wx] in rule.iter().chain(&[[-1.0, 0.0], [1.0, 0.0]]) {
        for &[y, wy] in rule.iter().chain(&[[-1.0, 0.0], [1.0, 0.0], [0.0, 0.0]]) {
            let s = 0.5 * (a + b) + 0.5 * (b - a) * x;
            let angle = 0.5 * (from + to) + 0.5 * (to - from) * y;
            let top2 = r * r - (s * s + d * d - 2.0 * s * d * angle.cos());
            let top = (top2 > 0.04 * r * r).then(|| top2.sqrt()).filter(|top| *top > low && *top < high)?;
            sum += wx * wy * s * (top - low);
        }
    }
    Some(0.25 * (b - a) * (to - from) * sum)
}

#[test]
fn each_thin_cell_has_its_volume_to_the_digits_that_are_claimed() {
    let rule = legendre(32);
    let mut compared = 0;
    for (d, r) in [(0.0, 1.0), (0.3, 1.0), (1.0, 1.0), (2.0, 1.0), (2.0, 0.3), (0.5, 0.1)] {
        for cells in [[7, 5, 1], [40, 9, 3], [300, 6, 1], [50, 200, 2], [8, 6, 300], [1000, 1, 2]] {
            let grid = CylinderGrid::new(2, [0.0; 3], [0.0, 3.0], [0.0, r], cells).unwrap();
            let found = overlaps(&grid, &Ball::new([d, 0.0, 0.0], r).unwrap());
            for (cell, volume) in found.iter().enumerate() {
                if let Some(truth) = below_the_cap(&grid, cell, d, r, &rule) {
                    compared += 1;
                    let error = (volume - truth).abs() / r.powi(3);
                    assert!(error < 2e-13, "{d} {r} {cells:?} {:?}: {volume:e} {truth:e}", grid.indices(cell));
                }
            }
        }
    }
    assert!(compared > 5_000, "{compared}");
}

#[test]
fn a_small_cell_wholly_inside_a_ball_has_exactly_its_volume() {
    // 1e-15 of the ball, and less than what quadrature leaves of nothing.
    let grid = CylinderGrid::new(2, [0.0; 3], [0.3, 0.30001], [0.0, 1e-5], [1, 200_000, 1]).unwrap();
    let found = overlaps(&grid, &Ball::new([0.25, 0.1, 0.2], 1.0).unwrap());
    assert!((0..grid.cell_count()).all(|cell| found[cell] == grid.cell_volume(cell)));
    assert!((found.iter().sum::<f64>() / (PI * 0.60001 * 1e-5 * 1e-5) - 1.0).abs() < 1e-10);
}

fn neighbours(grid: &CylinderGrid, cell: usize) -> Vec<(u32, f64)> {
    let mut found = Vec::new();
    grid.for_each_neighbour(cell, &mut |other, area_over_distance| found.push((other, area_over_distance)));
    found
}

#[test]
fn two_sectors_share_two_faces_and_more_sectors_one_with_each_neighbour() {
    // Faces of 1 × 3, centres half a circle of radius 1.5 apart: 3 / 1.5π for each of the two.
    let two = CylinderGrid::new(2, [0.0; 3], [1.0, 2.0], [0.0, 3.0], [1, 2, 1]).unwrap();
    for cell in 0..2 {
        let found = neighbours(&two, cell);
        assert!(matches!(found[..], [(other, x)] if other as usize == 1 - cell && (x - 4.0 / PI).abs() < 1e-15));
    }
    let four = CylinderGrid::new(2, [0.0; 3], [1.0, 2.0], [0.0, 3.0], [1, 4, 1]).unwrap();
    assert_eq!(neighbours(&four, 0).iter().map(|&(other, _)| other).collect::<Vec<_>>(), [3, 1]);
    let one = CylinderGrid::new(2, [0.0; 3], [1.0, 2.0], [0.0, 3.0], [1, 1, 1]).unwrap();
    assert!(neighbours(&one, 0).is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_ball_inside_the_cylinder_is_shared_out_without_loss(
        s in 0.0..1.0f64, angle in 0.0..7.0f64, z in -0.5..0.5f64, r in 0.01..0.9f64,
        shells in 1..5usize, sectors in 1..7usize, layers in 1..4usize, axis in 0..3usize,
    ) {
        let grid = CylinderGrid::new(axis, [0.3, -0.1, 0.2], [0.0, 2.0], [-1.5, 1.5], [shells, sectors, layers]).unwrap();
        let mut centre = [0.3, -0.1, 0.2];
        centre[(axis + 1) % 3] += s * angle.cos();
        centre[(axis + 2) % 3] += s * angle.sin();
        centre[axis] += z;
        let ball = Ball::new(centre, r).unwrap();
        let total: f64 = overlaps(&grid, &ball).iter().sum();
        prop_assert!((total - ball.volume()).abs() < 1e-12 * ball.volume(), "{:e}", total / ball.volume() - 1.0);
    }

    #[test]
    fn the_parts_of_a_segment_make_the_whole(
        a in prop::array::uniform3(-1.0..1.0f64), b in prop::array::uniform3(-1.0..1.0f64),
        shells in 1..5usize, sectors in 1..7usize, layers in 1..4usize,
    ) {
        let grid = CylinderGrid::new(2, [0.05, 0.02, 0.0], [0.0, 2.0], [-1.5, 1.5], [shells, sectors, layers]).unwrap();
        let along = std::array::from_fn(|k| b[k] - a[k]);
        let mut total = 0.0;
        prop_assert!(grid.clip_segment(a, along, &mut |_, fraction| total += fraction));
        prop_assert!((total - 1.0).abs() < 1e-14);
    }
}

#[test]
fn the_points_of_rings_in_a_box_are_those_of_all_points_that_lie_in_it() {
    let mut random = Random(12);
    let (mut found_any, mut around_axis) = (0, 0);
    for axis in 0..3 {
        let origin = [0.3, -0.2, 0.1];
        for layers in [1, 3] {
            let grid = CylinderGrid::new(axis, origin, [0.2, 1.4], [-0.5, 1.0], [4, 1, layers]).unwrap();
            for _ in 0..400 {
                let (middle, half) = (random.point(-2.0, 2.0), random.point(0.0, 1.0));
                let scale = [1e-2, 0.3, 1.0][(random.unit() * 3.0) as usize];
                let spacing = random.uniform(0.01, 0.3);
                let low: [f64; 3] = std::array::from_fn(|k| middle[k] - scale * half[k]);
                let high: [f64; 3] = std::array::from_fn(|k| middle[k] + scale * half[k]);
                around_axis += usize::from((0..3).all(|k| k == axis || low[k] <= origin[k] && high[k] >= origin[k]));
                let mut expected = Vec::new();
                for k in 0..layers {
                    for i in 0..4 {
                        let s = 0.2 + 0.3 * (i as f64 + 0.5);
                        let count = (std::f64::consts::TAU * s / spacing).ceil().max(8.0) as usize;
                        for n in 0..count {
                            let angle = std::f64::consts::TAU * n as f64 / count as f64;
                            let mut p = origin;
                            p[axis] += -0.5 + 1.5 * (k as f64 + 0.5) / layers as f64;
                            p[(axis + 1) % 3] += s * angle.cos();
                            p[(axis + 2) % 3] += s * angle.sin();
                            if (0..3).all(|a| a == axis && layers == 1 || p[a] >= low[a] && p[a] <= high[a]) {
                                expected.push((i + 4 * k, count, p));
                            }
                        }
                    }
                }
                let mut found = Vec::new();
                grid.for_each_ring_point(low, high, spacing, |cell, share, p| found.push((cell as usize, share, p)));
                found_any += usize::from(!found.is_empty());
                assert_eq!(found.len(), expected.len(), "{low:?} to {high:?}, axis {axis}, {layers} layers");
                for (cell, count, p) in expected {
                    let near = |q: [f64; 3]| (0..3).all(|a| (p[a] - q[a]).abs() < 1e-14);
                    let same = |&&(c, share, q): &&(usize, f64, [f64; 3])| {
                        c == cell && near(q) && (share * count as f64 - 1.0).abs() < 1e-15
                    };
                    assert_eq!(found.iter().filter(same).count(), 1, "{p:?} of cell {cell}");
                }
            }
        }
    }
    assert!(found_any > 500 && around_axis > 50, "{found_any} boxes with points, {around_axis} around the axis");
}

#[test]
fn a_box_on_the_axis_asks_no_point_of_circles_that_are_wider_than_it() {
    let rings = CylinderGrid::new(2, [0.0; 3], [0.0, 2.0], [0.0, 1.0], [2, 1, 1]).unwrap();
    let mut points = 0;
    // Of some 10¹² points around the inner circle.
    rings.for_each_ring_point([-1e-11; 3], [1e-11, 1e-11, 1.0], 3e-12, |_, _, _| points += 1);
    assert_eq!(points, 0);
}
