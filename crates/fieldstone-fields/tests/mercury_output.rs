//! MercuryCG's own output for the last frame of its box, to the digits that it prints.
#![allow(clippy::unwrap_used)]

mod support;

use fieldstone_fields::{CoarseGraining, CoarseGrainingOptions, Fields, Function, Kernel, KernelShape};
use fieldstone_mesh::{Coordinates, Grid};

fn fields(kernel: Kernel, coordinates: &str, cells: usize) -> Option<(Grid, Fields)> {
    let case = support::mercury_box()?;
    let coordinates: Coordinates = coordinates.parse().unwrap();
    let grid = Grid::resolving([0.0; 3], [11.2, 11.2, 13.2], [cells; 3], coordinates).unwrap();
    let options = CoarseGrainingOptions {
        function: Function::Kernel(kernel),
        particle_density: case.density,
        ..CoarseGrainingOptions::default()
    };
    let mut grains = CoarseGraining::new(&grid, options).unwrap();
    grains.accumulate(&case.particles, Some(&case.contacts), 1.0).unwrap();
    let fields = grains.finish().unwrap();
    Some((grid, fields))
}

/// Largest excess over the printed digits in each of the 29 columns, in units of what is allowed.
fn compare(grid: &Grid, fields: &Fields, theirs: &[Vec<f64>]) -> Vec<f64> {
    let n = grid.cells();
    assert_eq!(theirs.len(), n.iter().product::<usize>());
    let columns = theirs[0].len();
    assert_eq!(columns, 29);
    let mut worst = vec![0.0f64; columns];
    let most: Vec<f64> = (0..columns).map(|c| theirs.iter().map(|r| r[c].abs()).fold(0.0, f64::max)).collect();
    for (row, numbers) in theirs.iter().enumerate() {
        // Their rows have z fastest.
        let cell = grid.cell_at([row / (n[1] * n[2]), row / n[2] % n[1], row % n[2]]);
        let ours: Vec<f64> = fields.fields.iter().flat_map(|f| f.cell(cell).to_vec()).collect();
        for c in 0..columns {
            let allowed = 5e-6 * ours[c].abs() + 1e-10 * most[c];
            worst[c] = worst[c].max((ours[c] - numbers[c]).abs() / allowed);
        }
    }
    worst
}

#[test]
fn lucy_on_twenty_cubed_points_is_reproduced_in_all_columns() {
    let Some((grid, fields)) = fields(Kernel::new(KernelShape::Lucy, 1.0, None).unwrap(), "XYZ", 20) else { return };
    let path = fieldstone_testing::extended("mercury-box/box1000.Lucy.n20.stat.gz").unwrap();
    let worst = compare(&grid, &fields, &support::stat(&path, 3));
    println!("{worst:.3?}");
    assert!(worst.iter().all(|&w| w <= 1.0), "{worst:?}");
}

#[test]
fn averages_over_the_whole_box_are_reproduced_in_all_columns() {
    let Some((grid, fields)) = fields(Kernel::new(KernelShape::Lucy, 1.0, None).unwrap(), "O", 1) else { return };
    let path = fieldstone_testing::extended("mercury-box/box1000.O.stat").unwrap();
    let worst = compare(&grid, &fields, &support::stat(&path, 0));
    println!("{worst:.3?}");
    assert!(worst.iter().all(|&w| w <= 1.0), "{worst:?}");
}

#[test]
fn gauss_is_reproduced_but_for_the_contact_stress_which_is_cut_off_by_another_shape_there() {
    let Some((grid, fields)) = fields(Kernel::new(KernelShape::Gauss, 0.5, None).unwrap(), "XYZ", 20) else { return };
    let path = fieldstone_testing::extended("mercury-box/box1000.Gauss.n20.stat.gz").unwrap();
    let theirs = support::stat(&path, 3);
    let worst = compare(&grid, &fields, &theirs);
    println!("{worst:.3?}");
    for (column, &w) in worst.iter().enumerate() {
        let is_contact_stress = (11..20).contains(&column);
        assert!(is_contact_stress || w <= 1.0, "column {column}: {w}");
    }
    // Their Gaussian is cut off by a cylinder around the branch: up to some per cent of the maximum apart.
    let stress = fields.get("contact_stress").unwrap();
    let most = theirs.iter().map(|r| r[19].abs()).fold(0.0, f64::max);
    let n = grid.cells();
    let apart = (theirs.iter().enumerate())
        .map(|(row, r)| {
            let cell = grid.cell_at([row / (n[1] * n[2]), row / n[2] % n[1], row % n[2]]);
            (stress.cell(cell)[8] - r[19]).abs()
        })
        .fold(0.0, f64::max);
    println!("contact stress zz apart by {:.4} of its maximum", apart / most);
    assert!(apart < 0.02 * most);
}
