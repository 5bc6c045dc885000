//! The neighbour search against brute force.
#![allow(clippy::unwrap_used)]

use fieldstone_particles::{Domain, Image, NeighbourGrid, NeighbourOptions, ParticlesError};
use fieldstone_testing::Random;
use proptest::prelude::*;

/// Neighbours of a point by trying every particle and every image: (source, displacement) sorted.
fn brute_force(
    positions: &[[f64; 3]],
    at: [f64; 3],
    radius: f64,
    options: &NeighbourOptions,
) -> Vec<(usize, [i64; 3])> {
    let flat = |p: [f64; 3]| if options.dimension == 2 { [p[0], p[1], 0.0] } else { p };
    let wrap = |p: [f64; 3]| flat(options.domain.map_or(p, |d| d.wrap(p)));
    let at = wrap(at);
    let mut shifts = vec![[0.0; 3]];
    if let Some(domain) = options.domain {
        for axis in 0..options.dimension {
            if domain.periodic()[axis] {
                shifts = shifts
                    .iter()
                    .flat_map(|&s| {
                        (-5..=5).map(move |m| {
                            let mut s = s;
                            s[axis] += f64::from(m) * domain.lengths()[axis];
                            s
                        })
                    })
                    .collect();
            }
        }
    }
    let mut found = Vec::new();
    for (j, &p) in positions.iter().enumerate() {
        let p = wrap(p);
        for s in &shifts {
            let d: [f64; 3] = std::array::from_fn(|k| (p[k] + s[k]) - at[k]);
            if d.iter().map(|d| d * d).sum::<f64>() <= radius * radius {
                found.push((j, rounded(d)));
            }
        }
    }
    found.sort_unstable();
    found
}

fn rounded(d: [f64; 3]) -> [i64; 3] {
    d.map(|x| (x * 1e9).round() as i64)
}

fn within(grid: &NeighbourGrid, at: [f64; 3], radius: f64) -> Vec<(usize, [i64; 3])> {
    let mut found = Vec::new();
    grid.for_each_within(at, radius, |j, d, squared| {
        assert_eq!(squared, d.iter().map(|d| d * d).sum::<f64>());
        found.push((j, rounded(d)));
    })
    .unwrap();
    found.sort_unstable();
    found
}

/// Coordinates on a coarse raster as often as not, so that points coincide and lie on cell boundaries.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![(-12i32..12).prop_map(|i| f64::from(i) * 0.25 + 0.01), -3.0f64..3.0, Just(1e7), Just(-4e12)]
}

fn particles() -> impl Strategy<Value = Vec<[f64; 3]>> {
    prop::collection::vec([coordinate(), coordinate(), coordinate()], 0..60)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn points_within_a_radius_are_those_of_brute_force(
        positions in particles(),
        reach in 0.3f64..2.0,
        fraction in 0.0f64..1.0,
        dimension in 2usize..=3,
    ) {
        let options = NeighbourOptions { dimension, ..NeighbourOptions::new(reach) };
        let grid = NeighbourGrid::build(&positions, options).unwrap();
        for &at in &positions {
            for radius in [reach, fraction * reach] {
                prop_assert_eq!(within(&grid, at, radius), brute_force(&positions, at, radius, &options));
            }
        }
        prop_assert!(grid.cell_count() <= 8 * positions.len() + 1024);
    }

    #[test]
    fn periodic_images_are_those_of_brute_force(
        positions in prop::collection::vec([-3.0f64..3.0, -3.0f64..3.0, -3.0f64..3.0], 0..25),
        reach in 0.3f64..2.5,
        periodic in any::<[bool; 3]>(),
        dimension in 2usize..=3,
    ) {
        let domain = Domain::new([-1.0, -0.5, -0.75], [1.0, 0.75, 0.5], periodic).unwrap();
        let options = NeighbourOptions { reach, dimension, domain: Some(domain) };
        let grid = NeighbourGrid::build(&positions, options).unwrap();
        for &at in &positions {
            prop_assert_eq!(within(&grid, at, reach), brute_force(&positions, at, reach, &options));
        }
    }

    #[test]
    fn the_ranges_around_a_cell_hold_every_neighbour_once(positions in particles(), reach in 0.3f64..2.0) {
        let grid = NeighbourGrid::build(&positions, NeighbourOptions::new(reach)).unwrap();
        let [x, y, z] = grid.sorted_positions();
        let mut points_seen = 0;
        for cell in 0..grid.cell_count() {
            let home = grid.cell(cell);
            points_seen += home.len();
            let mut candidates = Vec::new();
            grid.for_each_range_around(cell, |range| candidates.extend(range));
            let count = candidates.len();
            candidates.sort_unstable();
            candidates.dedup();
            prop_assert_eq!(count, candidates.len());
            for i in home {
                let near = |&&j: &&usize| {
                    let d = [x[j] - x[i], y[j] - y[i], z[j] - z[i]];
                    d.iter().map(|d| d * d).sum::<f64>() <= reach * reach
                };
                let found = candidates.iter().filter(near).count();
                let expected = within(&grid, [x[i], y[i], z[i]], reach).len();
                prop_assert_eq!(found, expected);
            }
        }
        prop_assert_eq!(points_seen, positions.len());
    }
}

#[test]
fn no_particle_and_one_particle_have_no_neighbour() {
    let empty = NeighbourGrid::build(&[], NeighbourOptions::new(1.0)).unwrap();
    assert!(empty.is_empty() && within(&empty, [0.0; 3], 1.0).is_empty());
    let one = NeighbourGrid::build(&[[1.0; 3]], NeighbourOptions::new(1.0)).unwrap();
    one.for_each_neighbour(0, 1.0, |_, _, _| panic!("a particle is not its own neighbour")).unwrap();
    assert_eq!(within(&one, [1.0; 3], 0.0).len(), 1);
}

#[test]
fn a_particle_sees_its_own_images_in_a_box_shorter_than_the_reach() {
    let domain = Domain::new([0.0; 3], [1.0; 3], [true, false, false]).unwrap();
    let options = NeighbourOptions { domain: Some(domain), ..NeighbourOptions::new(2.5) };
    let grid = NeighbourGrid::build(&[[0.3; 3]], options).unwrap();
    let mut seen = Vec::new();
    grid.for_each_neighbour(0, 2.5, |j, d, _| seen.push((j, d[0].round() as i32))).unwrap();
    seen.sort_unstable();
    assert_eq!(seen, [(0, -2), (0, -1), (0, 1), (0, 2)]);
}

#[test]
fn coincident_particles_are_neighbours_at_distance_zero() {
    let grid = NeighbourGrid::build(&[[0.5; 3]; 7], NeighbourOptions::new(0.1)).unwrap();
    let mut count = 0;
    grid.for_each_neighbour(3, 0.1, |j, _, squared| {
        assert!(j != 3 && squared == 0.0);
        count += 1;
    })
    .unwrap();
    assert_eq!(count, 6);
}

#[test]
fn given_images_come_under_their_source_and_get_periodic_images_too() {
    let domain = Domain::new([0.0; 3], [1.0; 3], [false, true, false]).unwrap();
    let options = NeighbourOptions { domain: Some(domain), ..NeighbourOptions::new(0.3) };
    let images = [Image { source: 0, position: [-0.1, 0.05, 0.5] }];
    let grid = NeighbourGrid::build_with_images(&[[0.1, 0.05, 0.5], [0.1, 0.95, 0.5]], &images, options).unwrap();
    let mut seen = Vec::new();
    grid.for_each_neighbour(1, 0.3, |j, d, _| seen.push((j, rounded(d)))).unwrap();
    seen.sort_unstable();
    assert_eq!(seen, [(0, rounded([-0.2, 0.1, 0.0])), (0, rounded([0.0, 0.1, 0.0]))]);
    assert!(grid.is_image(grid.point_count() - 1) || (0..grid.point_count()).any(|s| grid.is_image(s)));
}

#[test]
fn one_outlier_stretches_neither_memory_nor_the_number_of_candidates() {
    let mut positions = Vec::new();
    for i in 0..20 {
        for j in 0..20 {
            for k in 0..20 {
                positions.push([f64::from(i), f64::from(j), f64::from(k)]);
            }
        }
    }
    let ordinary = NeighbourGrid::build(&positions, NeighbourOptions::new(2.5)).unwrap();
    positions.push([1e9, -1e12, 1e300]);
    let stretched = NeighbourGrid::build(&positions, NeighbourOptions::new(2.5)).unwrap();
    let candidates = |grid: &NeighbourGrid| {
        let mut count = 0;
        for cell in 0..grid.cell_count() {
            let home = grid.cell(cell).len();
            grid.for_each_range_around(cell, |range| count += home * range.len());
        }
        count
    };
    assert!(stretched.cell_count() <= 8 * positions.len() + 1024);
    assert!(candidates(&stretched) < 2 * candidates(&ordinary));
    assert_eq!(within(&stretched, [10.0; 3], 2.5).len(), 81);
}

#[test]
fn the_sorted_order_is_the_same_for_any_number_of_threads() {
    let mut random = Random(1);
    let positions: Vec<[f64; 3]> = (0..5000).map(|_| random.point(0.0, 16.0)).collect();
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| NeighbourGrid::build(&positions, NeighbourOptions::new(0.8)).unwrap().sources().to_vec())
    };
    assert_eq!(build(1), build(4));
}

#[test]
fn rebuilding_gives_the_same_as_building() {
    let positions =
        |t: f64| (0..300).map(|i| [(f64::from(i) * 0.37 + t) % 3.0, f64::from(i % 17), 0.0]).collect::<Vec<_>>();
    let mut grid = NeighbourGrid::build(&positions(0.0), NeighbourOptions::new(1.1)).unwrap();
    grid.rebuild(&positions(0.5)[..250], &[]).unwrap();
    let fresh = NeighbourGrid::build(&positions(0.5)[..250], NeighbourOptions::new(1.1)).unwrap();
    assert_eq!(grid.sources(), fresh.sources());
    assert_eq!(grid.ranks(), fresh.ranks());
    assert_eq!(grid.sorted_positions(), fresh.sorted_positions());
}

#[test]
fn bad_input_is_refused_with_its_place() {
    let bad = NeighbourGrid::build(&[[0.0; 3], [0.0, f64::NAN, 0.0]], NeighbourOptions::new(1.0)).unwrap_err();
    assert!(bad.to_string().starts_with("particle 1 has y = NaN"), "{bad}");
    assert!(matches!(NeighbourGrid::build(&[], NeighbourOptions::new(0.0)), Err(ParticlesError::Reach { .. })));
    let grid = NeighbourGrid::build(&[[0.0; 3]], NeighbourOptions::new(1.0)).unwrap();
    assert!(matches!(grid.for_each_within([0.0; 3], 1.5, |_, _, _| ()), Err(ParticlesError::BeyondReach { .. })));
    assert!(matches!(grid.for_each_neighbour(1, 1.0, |_, _, _| ()), Err(ParticlesError::UnknownIndex { .. })));
    let thin = Domain::new([0.0; 3], [1.0, 1.0, 0.01], [false, false, true]).unwrap();
    let options = NeighbourOptions { domain: Some(thin), ..NeighbourOptions::new(1.0) };
    assert!(matches!(NeighbourGrid::build(&[], options), Err(ParticlesError::ReachBeyondBox { axis: 'z', .. })));
    // In two dimensions z does not matter, not even where it is no number.
    let flat = NeighbourOptions { dimension: 2, ..NeighbourOptions::new(1.0) };
    assert!(NeighbourGrid::build(&[[0.0, 0.0, f64::NAN]], flat).is_ok());
}
