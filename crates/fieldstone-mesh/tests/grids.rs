//! Grids against the general kernel, cell by cell, and against closed forms.

#![allow(clippy::unwrap_used)]

use fieldstone_geometry::{Ball, PROMISE, Polyhedron, corner_volume, fast_overlap_volume, overlap_volume};
use fieldstone_mesh::{Cells, Grid, MeshError};
use proptest::prelude::*;

fn volumes(grid: &Grid, ball: &Ball) -> Vec<(u32, f64)> {
    let mut out = Vec::new();
    // Without the promise: balls of 20 cells would take minutes of 106-bit arithmetic.
    grid.overlap_ball(ball, &mut grid.fast_scratch(), &mut out);
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn every_cell_agrees_with_the_kernel_on_the_same_box(
        centre in prop::array::uniform3(-0.5f64..4.5),
        radius in 0.05f64..3.0,
        cells in prop::array::uniform3(1usize..5),
    ) {
        let grid = Grid::new([0.0; 3], [4.0, 3.0, 2.0], cells).unwrap();
        let ball = Ball::new(centre, radius).unwrap();
        let mut found = vec![0.0; grid.cell_count()];
        for (cell, volume) in volumes(&grid, &ball) {
            found[cell as usize] = volume;
        }
        for (cell, &volume) in found.iter().enumerate() {
            let (low, high) = grid.cell_bounds(cell);
            let exact = overlap_volume(&ball, &Polyhedron::cuboid(low, high).unwrap());
            // What the closed form is taken for, and the kernel's own promise.
            let limit = 48.0 * f64::EPSILON * radius.powi(3) + PROMISE * exact;
            prop_assert!((volume - exact).abs() <= limit, "cell {cell}: {volume} against {exact}");
        }
    }

    #[test]
    fn the_volume_below_a_corner_agrees_with_the_kernel(a in -1.2f64..1.2, b in -1.2f64..1.2, c in -1.2f64..1.2) {
        let ball = Ball::new([0.0; 3], 1.0).unwrap();
        let exact = overlap_volume(&ball, &Polyhedron::cuboid([-2.0; 3], [a, b, c]).unwrap());
        prop_assert!((corner_volume([a, b, c]) - exact).abs() < 4e-15);
    }

    #[test]
    fn a_grid_that_holds_the_ball_holds_all_of_its_volume(
        centre in prop::array::uniform3(-0.5f64..0.5),
        radius in 0.05f64..20.0,
    ) {
        let half = radius.ceil() + 1.0;
        let n = (2.0 * half) as usize;
        let grid = Grid::new([-half; 3], [half; 3], [n; 3]).unwrap();
        let ball = Ball::new(centre, radius).unwrap();
        let mut sum = 0.0;
        let mut carry = 0.0;
        for (_, v) in volumes(&grid, &ball) {
            let y = v - carry;
            let t = sum + y;
            carry = (t - sum) - y;
            sum = t;
        }
        prop_assert!((sum / ball.volume() - 1.0).abs() < 1e-13, "{:e}", sum / ball.volume() - 1.0);
    }
}

#[test]
fn corners_on_the_sphere_and_on_the_axes_are_exact() {
    let ball = 4.0 / 3.0 * std::f64::consts::PI;
    // Exactly on the sphere: (2/7, 3/7, 6/7) and its mirror images; the kernel sees the same corner.
    let unit = Ball::new([0.0; 3], 1.0).unwrap();
    for signs in 0..8 {
        let p: [f64; 3] =
            std::array::from_fn(|k| [2.0, 3.0, 6.0][k] / 7.0 * if signs >> k & 1 == 1 { -1.0 } else { 1.0 });
        let exact = overlap_volume(&unit, &Polyhedron::cuboid([-2.0; 3], p).unwrap());
        assert!((corner_volume(p) - exact).abs() < 2e-15, "{p:?}: {} against {exact}", corner_volume(p));
    }
    for (p, parts) in [([0.0, 0.0, 0.0], 8.0), ([0.0, 0.0, 1.0], 4.0), ([1.0, 0.0, 1.0], 2.0), ([1.0, 1.0, 1.0], 1.0)] {
        assert!((corner_volume(p) - ball / parts).abs() < 1e-15);
    }
    assert_eq!(corner_volume([-1.0, 5.0, 5.0]), 0.0);
}

#[test]
fn points_on_common_faces_belong_to_the_upper_cell_and_the_last_face_to_the_last_cell() {
    let grid = Grid::new([0.0; 3], [1.0; 3], [10, 10, 10]).unwrap();
    let s = &mut grid.scratch();
    for i in 0..10 {
        assert_eq!(grid.locate([grid.plane(0, i), 0.05, 0.05], s), Some(i as u32), "plane {i}");
    }
    assert_eq!(grid.locate([1.0, 1.0, 1.0], s), Some(999));
    assert_eq!(grid.locate([1.0 + 1e-12, 0.5, 0.5], s), None);
    assert_eq!(grid.locate([f64::NAN, 0.5, 0.5], s), None);
}

#[test]
fn a_box_is_shared_out_completely() {
    let grid = Grid::new([0.0; 3], [1.0; 3], [7, 3, 5]).unwrap();
    let mut out = Vec::new();
    grid.overlap_cuboid([0.1, 0.2, 0.3], [0.9, 0.55, 1.4], &mut grid.scratch(), &mut out);
    let sum: f64 = out.iter().map(|p| p.1).sum();
    assert!((sum - 0.8 * 0.35 * 0.7).abs() < 1e-15);
}

#[test]
fn grids_whose_planes_fall_together_are_refused_and_those_that_just_do_not_are_taken() {
    // Coordinates near 1e16 are even numbers.
    let along = |low: f64, high: f64, cells| Grid::new([0.0, low, 0.0], [1.0, high, 1.0], [1, cells, 1]);
    let error = along(1e16, 1e16 + 4.0, 10).unwrap_err();
    assert!(matches!(error, MeshError::GridPlanes { axis: 'y', plane: 0, at: 1e16, cells: 10 }), "{error:?}");
    assert!(error.to_string().contains("fewer cells"));
    assert!(along(-1e16 - 4.0, -1e16, 3).is_err());
    for (low, high, cells) in [(1e16, 1e16 + 4.0, 2), (1e16, 1e16 + 4000.0, 700), (-1e-300, 1e-300, 1000)] {
        let grid = along(low, high, cells).unwrap();
        assert!((0..cells).all(|cell| grid.plane(1, cell) < grid.plane(1, cell + 1)));
    }
    // The smallest numbers there are have as few digits.
    assert!(along(0.0, f64::from_bits(5), 10).is_err());
}

#[test]
fn impossible_grids_are_refused() {
    assert!(Grid::new([0.0; 3], [1.0, 1.0, 0.0], [1; 3]).unwrap_err().to_string().contains("along z"));
    assert!(Grid::new([0.0; 3], [1.0; 3], [1, 0, 1]).is_err());
    assert!(Grid::new([0.0; 3], [f64::INFINITY; 3], [1; 3]).is_err());
    assert!(Grid::new([0.0; 3], [1.0; 3], [usize::MAX, 2, 2]).is_err());
}

#[test]
fn balls_much_larger_than_the_cells_keep_the_promise_and_only_cells_that_they_cut_are_counted() {
    let (mut cut, mut beyond) = (0, 0);
    for exponent in -2..=16 {
        // From 2 to 7e4 times the cells' size; through the middle of the grid, in a direction of no symmetry.
        let radius = 7.0 * 10f64.powf(f64::from(exponent) / 4.0);
        let grid = Grid::new([-1.0; 3], [1.0, 2.0, 1.5], [2, 3, 3]).unwrap();
        let ball = Ball::new([0.48, 0.6, 0.64].map(|x| x * radius), radius).unwrap();
        let mut scratch = grid.scratch();
        let mut found = Vec::new();
        grid.overlap_ball(&ball, &mut scratch, &mut found);
        let mut expected = (0, 0);
        for cell in 0..grid.cell_count() {
            let (low, high) = grid.cell_bounds(cell);
            let alone = Polyhedron::cuboid(low, high).unwrap();
            let exact = overlap_volume(&ball, &alone);
            let volume = found.iter().find(|f| f.0 as usize == cell).map_or(0.0, |f| f.1);
            assert!((volume - exact).abs() <= 2.0 * PROMISE * alone.volume(), "r {radius}: {volume} against {exact}");
            if exact > 0.0 && exact < alone.volume() {
                expected.0 += 1;
                let (_, error) = fast_overlap_volume(&ball, &alone);
                // Up to four cells and a half the closed form is enough.
                expected.1 += u64::from(radius > 4.5 && error > PROMISE * alone.volume());
            }
        }
        let counts = grid.path_counts(&scratch);
        assert_eq!((counts.evaluated, counts.beyond_f64), expected, "r {radius}");
        cut += counts.evaluated;
        beyond += counts.beyond_f64;
    }
    assert!(beyond > 50 && beyond < cut, "{beyond} of {cut}");
}

#[test]
fn a_segment_is_all_in_the_cells_that_it_lies_in_also_in_planes_and_at_the_upper_end() {
    let grid = Grid::new([0.0; 3], [1.0, 0.7, 0.3], [4, 3, 2]).unwrap();
    let share = |start: [f64; 3], along: [f64; 3]| {
        let mut found = Vec::new();
        assert!(grid.clip_segment(start, along, &mut |cell, share| found.push((cell, share))));
        found
    };
    // In the upper face, along an upper edge, and in the plane between cells: one cell each, that of the point.
    let s = &mut grid.scratch();
    for start in [[1.0, 0.1, 0.05], [0.6, 0.7, 0.05], [1.0, 0.55, 0.3], [0.5, 0.1, 0.05], [0.5, 0.1, grid.plane(2, 1)]]
    {
        for along in [[0.0, 0.05, 0.0], [0.0, -0.05, 0.0], [-1e-17, 0.05, 0.0], [-1e-17, 0.05, 1e-18]] {
            if start[1] + along[1] > 0.7 {
                continue;
            }
            let middle = std::array::from_fn(|k| start[k] + 0.5 * along[k]);
            assert_eq!(share(start, along), [(grid.locate(middle, s).unwrap(), 1.0)], "{start:?} {along:?}");
        }
    }
    assert_eq!(share([1.0 + 1e-15, 0.1, 0.05], [0.0, 0.05, 0.0]), [], "beyond the upper face");
    // Any other adds up to what is inside, whichever plane it starts or ends in, or misses by the last digit.
    for axis in 0..3 {
        for (i, j) in (0..=grid.cells()[axis]).flat_map(|i| (0..=grid.cells()[axis]).map(move |j| (i, j))) {
            let (a, b) = (grid.plane(axis, i), grid.plane(axis, j));
            let inside = |x: f64| x.clamp(grid.plane(axis, 0), grid.plane(axis, grid.cells()[axis]));
            for (a, b) in [(a, b), (a.next_up(), b), (a, b.next_down()), (a.next_up(), a.next_down()), (a, b + 0.1)] {
                if inside(a) == inside(b) {
                    continue;
                }
                let (mut start, mut along) = ([0.1; 3], [0.0; 3]);
                (start[axis], along[axis]) = (a, b - a);
                let sum: f64 = share(start, along).iter().map(|(_, share)| share).sum();
                // The length between neighbouring numbers has digits only where both are inside.
                let truth = if [a, b] == [inside(a), inside(b)] { 1.0 } else { (inside(b) - inside(a)) / (b - a) };
                if (b - a).abs() < 1e-12 && truth != 1.0 {
                    continue;
                }
                assert!((sum - truth).abs() < 1e-12, "{a} to {b} along {axis}: {sum}");
            }
        }
    }
}
