//! Cylindrical grids: volumes, overlaps, points and segments.
#![allow(clippy::unwrap_used)]

use std::f64::consts::PI;

use fieldstone_geometry::Ball;
use fieldstone_mesh::{Cells, CylinderGrid};
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
