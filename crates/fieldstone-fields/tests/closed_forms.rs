//! Solid fractions that are known in closed form.

#![allow(clippy::unwrap_used)]

use std::f64::consts::PI;

use fieldstone_fields::{FieldsError, Method, SolidFractionOptions, Weights, count_centres, solid_fraction};
use fieldstone_geometry::cap_volume;
use fieldstone_mesh::Grid;
use fieldstone_particles::{Domain, Particles};

const EXACT: [Method; 2] = [Method::Kernel, Method::Decomposition];

/// A periodic cubic cell of side `a` with balls at the given fractions of it.
fn packing(basis: &[[f64; 3]], radius: f64, a: f64) -> (Particles, Domain) {
    let domain = Domain::new([0.0; 3], [a; 3], [true; 3]).unwrap();
    let positions = basis.iter().map(|p| p.map(|x| x * a)).collect();
    let particles = Particles::new(positions).unwrap().with_uniform_radius(radius).unwrap();
    (particles.with_domain(domain), domain)
}

#[test]
fn cubic_packings_have_their_textbook_densities_wherever_the_lattice_starts() {
    let sc: &[[f64; 3]] = &[[0.0; 3]];
    let bcc: &[[f64; 3]] = &[[0.0; 3], [0.5; 3]];
    let fcc: &[[f64; 3]] = &[[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];
    for (basis, radius, density) in [
        (sc, 0.5, PI / 6.0),
        (bcc, 3f64.sqrt() / 4.0, 3f64.sqrt() * PI / 8.0),
        (fcc, 2f64.sqrt() / 4.0, PI / (3.0 * 2f64.sqrt())),
    ] {
        for shift in [[0.0; 3], [0.13, 0.57, 0.91]] {
            let basis: Vec<[f64; 3]> = basis.iter().map(|p| [0, 1, 2].map(|k| (p[k] + shift[k]).fract())).collect();
            for a in [1e-9, 1.0, 1e9] {
                let (particles, domain) = packing(&basis, radius * a, a);
                for method in EXACT {
                    // The whole cell at once, and in 5 × 4 × 3 parts.
                    for n in [[1, 1, 1], [5, 4, 3]] {
                        let grid = Grid::new([0.0; 3], [a; 3], n).unwrap();
                        let options = SolidFractionOptions { method, domain: Some(domain), ..Default::default() };
                        let result = solid_fraction(&grid, &particles, &options).unwrap();
                        let mean = result.solid_fraction.iter().sum::<f64>() / result.solid_fraction.len() as f64;
                        assert!((mean / density - 1.0).abs() < 1e-13, "{method} {a:e}: {mean} for {density}");
                        assert!((result.ledger.clipped_volume / result.ledger.particle_volume).abs() < 1e-13);
                    }
                }
            }
        }
    }
}

#[test]
fn slabs_hold_the_differences_of_caps() {
    let grid = Grid::new([-1.0, -1.0, -1.0], [1.0, 1.0, 1.0], [1, 1, 16]).unwrap();
    let (z, r) = (0.07, 0.83);
    let one = Particles::new(vec![[0.1, -0.1, z]]).unwrap().with_uniform_radius(r).unwrap();
    for method in EXACT {
        let weights = Weights::build(&grid, &one, method, None).unwrap();
        for cell in 0..16 {
            let [low, high] = [cell, cell + 1].map(|k| (grid.plane(2, k) - z).clamp(-r, r));
            let slab = cap_volume(r, low) - cap_volume(r, high);
            let (cells, volumes) = weights.row(0);
            let found = cells.iter().position(|&c| c as usize == cell).map_or(0.0, |at| volumes[at]);
            assert!((found - slab).abs() < 2e-15, "{method}, slab {cell}: {found} for {slab}");
        }
    }
}

#[test]
fn a_ball_on_a_corner_of_eight_cells_gives_each_an_eighth() {
    for offset in [0.0, 1e6] {
        let grid = Grid::new([offset; 3], [offset + 2.0; 3], [2; 3]).unwrap();
        let one = Particles::new(vec![[offset + 1.0; 3]]).unwrap().with_uniform_radius(0.5).unwrap();
        for method in EXACT {
            let weights = Weights::build(&grid, &one, method, None).unwrap();
            assert_eq!(weights.row(0).0.len(), 8);
            for v in weights.row(0).1 {
                assert!((v * 8.0 / weights.particle_volumes()[0] - 1.0).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn exact_methods_are_smooth_where_a_ball_crosses_a_face_and_centre_is_not() {
    let grid = Grid::new([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1]).unwrap();
    let radius = 0.3;
    let left = |x: f64, method| {
        let one = Particles::new(vec![[x, 0.5, 0.5]]).unwrap().with_uniform_radius(radius).unwrap();
        let weights = Weights::build(&grid, &one, method, None).unwrap();
        weights.sum_over_particles(&[1.0]).unwrap()[0]
    };
    let step = 1e-4;
    // The volume changes no faster than by the disc that moves through the face.
    let limit = PI * radius * radius * step * 1.000_001;
    let jump = |method| -> f64 {
        let positions = (0..8000).map(|k| 0.6 + f64::from(k) * step);
        positions.map(|x| (left(x + step, method) - left(x, method)).abs()).fold(0.0, f64::max)
    };
    for method in EXACT {
        assert!(jump(method) <= limit, "{method} jumps by {}", jump(method));
    }
    assert!(jump(Method::Centre) > 0.9 * 4.0 / 3.0 * PI * radius.powi(3));
}

#[test]
fn moving_everything_through_a_periodic_box_changes_nothing() {
    let domain = Domain::new([0.0; 3], [1.0, 2.0, 1.0], [true, true, false]).unwrap();
    let positions: Vec<[f64; 3]> = (0..40)
        .map(|i| [0, 1, 2].map(|k| (f64::from(i * (k + 3) * 7919 % 1000) / 1000.0) * [1.0, 2.0, 1.0][k as usize]))
        .collect();
    let field = |shift: [f64; 2]| {
        let moved = positions.iter().map(|p| [p[0] + shift[0], p[1] + shift[1], p[2]]).collect();
        let particles = Particles::new(moved).unwrap().with_uniform_radius(0.13).unwrap();
        // The grid moves along by whole cells, so cells are matched by their indices.
        let grid = Grid::new([0.0; 3], [1.0, 2.0, 1.0], [4, 8, 4]).unwrap();
        let options = SolidFractionOptions { domain: Some(domain), ..Default::default() };
        (solid_fraction(&grid, &particles, &options).unwrap().solid_fraction, grid)
    };
    let (still, grid) = field([0.0, 0.0]);
    for (i, j) in [(1, 0), (3, 5), (-7, 11)] {
        let (moved, _) = field([f64::from(i) * 0.25, f64::from(j) * 0.25]);
        for (cell, value) in still.iter().enumerate() {
            let [a, b, c] = grid.indices(cell);
            let to = [(a as i32 + i).rem_euclid(4) as usize, (b as i32 + j).rem_euclid(8) as usize, c];
            assert!((moved[grid.cell_at(to)] - value).abs() < 1e-13);
        }
    }
}

#[test]
fn a_box_sheared_by_whole_edges_gives_the_weights_of_the_upright_one() {
    // The edges (1, 0, 0) and (1, 1, 0) span the same lattice as the axes do.
    let particles = Particles::new(vec![[0.05, 0.5, 0.95], [0.4, 0.02, 0.5], [0.97, 0.99, 0.01]]).unwrap();
    let particles = particles.with_radii(vec![0.2, 0.3, 0.1]).unwrap();
    let upright = Domain::new([0.0; 3], [1.0; 3], [true; 3]).unwrap();
    let sheared = Domain::triclinic([0.0; 3], [1.0; 3], [1.0, 0.0, 0.0], [true; 3]).unwrap();
    // A grid in the part that both boxes share, where the images of both are complete.
    let grid = Grid::new([0.5, 0.0, 0.0], [1.0, 0.5, 1.0], [3, 4, 5]).unwrap();
    let sum = |domain| {
        let options = SolidFractionOptions { domain: Some(domain), ..SolidFractionOptions::default() };
        solid_fraction(&grid, &particles, &options).unwrap().solid_fraction
    };
    for (cell, (a, b)) in sum(upright).iter().zip(sum(sheared)).enumerate() {
        assert!((a - b).abs() < 1e-13, "cell {cell}: {a} and {b}");
    }
}

/// A ball of radius 0.1 in a periodic unit box.
fn one_ball(at: [f64; 3]) -> (Particles, Domain) {
    let domain = Domain::new([0.0; 3], [1.0; 3], [true; 3]).unwrap();
    (Particles::new(vec![at]).unwrap().with_uniform_radius(0.1).unwrap(), domain)
}

#[test]
fn cells_that_are_not_aligned_with_the_periodic_box_lose_nothing_in_any_method() {
    let grid = Grid::new([-0.5, -0.5, 0.0], [0.5, 0.5, 1.0], [10, 10, 10]).unwrap();
    for y in [0.40, 0.45, 0.50, 0.55, 0.60, 0.95] {
        let (one, domain) = one_ball([0.95, y, 0.5]);
        for method in [Method::Kernel, Method::KernelF64, Method::Decomposition, Method::Cube, Method::Centre] {
            let weights = Weights::build(&grid, &one, method, Some(&domain)).unwrap();
            let share = weights.volumes().iter().sum::<f64>() / (4.0 / 3.0 * PI * 0.001);
            assert!((share - 1.0).abs() < 1e-12, "{method} at {y}: {share}");
        }
    }
}

#[test]
fn cells_of_several_periods_hold_every_image() {
    // Two and a half periods along x: images at −0.8 and 0.2, and one at 1.2 that the end of the cells halves.
    let (one, domain) = one_ball([0.2, 0.5, 0.5]);
    let grid = Grid::new([-1.3, 0.0, 0.0], [1.2, 1.0, 1.0], [25, 1, 1]).unwrap();
    let weights = Weights::build(&grid, &one, Method::Kernel, Some(&domain)).unwrap();
    let share = weights.volumes().iter().sum::<f64>() / (4.0 / 3.0 * PI * 0.001);
    assert!((share - 2.5).abs() < 1e-12, "{share}");
    assert!((weights.outside()[0] / weights.particle_volumes()[0] + 1.5).abs() < 1e-12);
}

#[test]
fn centres_are_counted_where_their_images_lie() {
    let (one, domain) = one_ball([0.95, 0.95, 0.5]);
    let grid = Grid::new([-0.5, -0.5, 0.0], [0.5, 0.5, 1.0], [2, 2, 1]).unwrap();
    assert_eq!(count_centres(&grid, &one, Some(&domain)).unwrap(), [1, 0, 0, 0]);

    // In a tilted box the grid 0…1 in all directions is one period, too, and holds each of three balls once.
    let tilted = Domain::triclinic([0.0; 3], [1.0; 3], [0.3, 0.1, 0.2], [true; 3]).unwrap();
    let three = Particles::new(vec![[0.5; 3], [1.2, 0.9, 0.6], [0.15, 1.1, 0.95]]).unwrap();
    let unit = Grid::new([0.0; 3], [1.0; 3], [1, 1, 1]).unwrap();
    assert_eq!(count_centres(&unit, &three, Some(&tilted)).unwrap(), [3]);

    // Two periods hold it twice, and on the face of the box it is still one particle.
    let double = Grid::new([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1]).unwrap();
    assert_eq!(count_centres(&double, &one, Some(&domain)).unwrap(), [1, 1]);
    for face in [0.0, 1.0, 3.0] {
        let (one, domain) = one_ball([face, 0.5, 0.5]);
        let grid = Grid::new([0.0; 3], [1.0; 3], [4, 1, 1]).unwrap();
        assert_eq!(count_centres(&grid, &one, Some(&domain)).unwrap(), [1, 0, 0, 0]);
        let weights = Weights::build(&grid, &one, Method::Centre, Some(&domain)).unwrap();
        assert_eq!((weights.cells(), weights.outside()), (&[0][..], &[0.0][..]));
    }
}

#[test]
fn a_periodic_box_much_smaller_than_the_cells_is_refused_instead_of_going_on_for_ever() {
    let domain = Domain::new([0.0; 3], [1e-3; 3], [true; 3]).unwrap();
    let one = Particles::new(vec![[5e-4; 3]]).unwrap().with_uniform_radius(1e-4).unwrap();
    let grid = Grid::new([0.0; 3], [1.0; 3], [1, 1, 1]).unwrap();
    let error = Weights::build(&grid, &one, Method::Kernel, Some(&domain)).unwrap_err();
    assert!(
        matches!(error, FieldsError::BoxCopies { copies } if (copies / 1001.2f64.powi(3) - 1.0).abs() < 1e-9),
        "{error}"
    );
    let error = count_centres(&grid, &one, Some(&domain)).unwrap_err();
    assert!(matches!(error, FieldsError::BoxCopies { .. }), "{error}");
}
