//! Level set, density field and iso-surface against bodies whose volume is known.
#![allow(clippy::unwrap_used)]

mod common;

use std::f64::consts::PI;

use common::block;
use fieldstone_particles::Domain;
use fieldstone_surface::{
    Column, Exact, LevelSetOptions, NodeField, Nodes, PeriodicFaces, Support, SurfaceDistance, SurfaceOptions,
    Surroundings, Topology, TriangleMesh, Wall, Walls, density_field, detect_surface, interpolate, iso_surface,
    level_set,
};
use fieldstone_testing::Random;

/// Lattice points of unit spacing for which `inside` holds, around an irregular centre.
fn body(half_widths: [f64; 3], inside: impl Fn([f64; 3]) -> bool) -> Vec<[f64; 3]> {
    let n = half_widths.map(|w| w.ceil() as i64 + 1);
    let mut points = Vec::new();
    for k in -n[2]..=n[2] {
        for j in -n[1]..=n[1] {
            for i in -n[0]..=n[0] {
                let p = [i as f64 + 0.31, j as f64 + 0.17, k as f64 + 0.43];
                if inside(p) {
                    points.push(p);
                }
            }
        }
    }
    points
}

fn length(p: [f64; 3]) -> f64 {
    p.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[derive(Clone, Copy, Debug)]
enum Way {
    LevelSet(SurfaceDistance),
    Density,
}

const WAYS: [Way; 3] = [Way::LevelSet(SurfaceDistance::Blended), Way::LevelSet(SurfaceDistance::Nearest), Way::Density];

fn field(particles: &[[f64; 3]], surroundings: &Surroundings, cell: f64, way: Way) -> NodeField {
    let nodes = Nodes::around(particles, 1.5, cell).unwrap();
    match way {
        Way::Density => density_field(particles, surroundings, &nodes, 1.25, PeriodicFaces::End).unwrap(),
        Way::LevelSet(distance) => {
            let found = detect_surface(particles, &Exact::default(), surroundings, &SurfaceOptions::LABELS).unwrap();
            let options = LevelSetOptions { distance, ..LevelSetOptions::default() };
            level_set(particles, surroundings, &found.detection, &nodes, &options).unwrap()
        }
    }
}

fn surface(particles: &[[f64; 3]], way: Way) -> (TriangleMesh, Topology) {
    let mesh = iso_surface(&field(particles, &Surroundings::new(1.0), 0.5, way), Walls::Closed);
    let topology = mesh.topology().unwrap();
    assert!(topology.is_closed() && topology.is_manifold(), "{way:?}: {topology:?}");
    (mesh, topology)
}

#[test]
fn volumes_of_sphere_and_torus_converge_with_the_spacing() {
    println!("body       R/dx  particles  way                     volume/exact-1  volume/particles-1   area/exact-1");
    for (name, euler) in [("sphere", 2), ("torus", 0)] {
        for way in WAYS {
            let mut errors = Vec::new();
            for radius in [6.0, 12.0] {
                let (particles, volume, area) = if name == "sphere" {
                    let ball = body([radius; 3], |p| length(p) < radius);
                    (ball, 4.0 / 3.0 * PI * radius.powi(3), 4.0 * PI * radius * radius)
                } else {
                    let (major, minor) = (1.5 * radius, 0.6 * radius);
                    let ring = |p: [f64; 3]| (p[0].hypot(p[1]) - major).hypot(p[2]) < minor;
                    let torus = body([major + minor, major + minor, minor], ring);
                    (torus, 2.0 * PI * PI * major * minor * minor, 4.0 * PI * PI * major * minor)
                };
                let (mesh, topology) = surface(&particles, way);
                // Jumps of the nearest particle leave crumbs beside the surface.
                if !matches!(way, Way::LevelSet(SurfaceDistance::Nearest)) {
                    assert_eq!((topology.components, topology.euler_characteristic), (1, euler), "{name} {way:?}");
                }
                let of_exact = mesh.volume() / volume - 1.0;
                let of_particles = mesh.volume() / particles.len() as f64 - 1.0;
                let of_area = mesh.area() / area - 1.0;
                println!(
                    "{name:<8} {radius:>6} {:>10}  {:<22} {of_exact:>15.5} {of_particles:>19.5} {of_area:>14.5}",
                    particles.len(),
                    format!("{way:?}")
                );
                errors.push(of_exact.abs());
            }
            // Second order where the field is smooth; jumps of the nearest particle leave first order.
            let (limit, ratio) = match way {
                Way::Density => (0.012, 0.33),
                Way::LevelSet(SurfaceDistance::Blended) => (0.03, 0.6),
                Way::LevelSet(SurfaceDistance::Nearest) => (0.06, 0.75),
            };
            assert!(errors[1] < limit, "{name} {way:?}: {errors:?}");
            assert!(errors[1] < ratio * errors[0] + 0.001, "{name} {way:?}: {errors:?}");
        }
    }
}

#[test]
fn two_touching_drops_are_closed_and_manifold_whatever_their_gap() {
    for way in WAYS {
        for gap in [-0.8, -0.3, 0.0, 0.4, 1.0, 3.0] {
            let radius = 5.0;
            let centre = radius + 0.5 * gap;
            let particles =
                body([centre + radius, radius, radius], |[x, y, z]| length([x.abs() - centre, y, z]) < radius);
            let (mesh, topology) = surface(&particles, way);
            if !matches!(way, Way::LevelSet(SurfaceDistance::Nearest)) {
                let parts = if gap < 0.0 { Some(1) } else { (gap > 2.5).then_some(2) };
                assert!(parts.is_none_or(|parts| parts == topology.components), "{way:?} {gap}: {topology:?}");
            }
            let limit = if matches!(way, Way::Density) { 0.07 } else { 0.15 };
            assert!((mesh.volume() / particles.len() as f64 - 1.0).abs() < limit, "{way:?} {gap}: {}", mesh.volume());
        }
    }
}

#[test]
fn spray_threads_and_sheets_of_one_layer_keep_their_volume_roughly() {
    let lone = vec![[0.2, 0.4, 0.1], [9.0, 1.0, 1.0]];
    let sheet: Vec<[f64; 3]> = (0..400).map(|i| [f64::from(i % 20), f64::from(i / 20), 0.37]).collect();
    let thread: Vec<[f64; 3]> = (0..40).map(|i| [f64::from(i), 0.2, 0.7]).collect();
    for (name, particles, parts, tolerance) in
        [("drops", lone, 2, 0.25), ("sheet", sheet, 1, 0.25), ("thread", thread, 1, 0.25)]
    {
        let mesh = iso_surface(
            &field(&particles, &Surroundings::new(1.0), 0.25, Way::LevelSet(SurfaceDistance::Blended)),
            Walls::Closed,
        );
        let topology = mesh.topology().unwrap();
        assert!(topology.is_closed() && topology.is_manifold(), "{name}: {topology:?}");
        let share = mesh.volume() / particles.len() as f64;
        println!("{name}: {share} {}", topology.components);
        assert_eq!(topology.components, parts, "{name}");
        assert!((share - 1.0).abs() < tolerance, "{name}: {share}");
    }
}

#[test]
fn a_disordered_block_between_walls_is_cut_off_at_them() {
    let particles = block([10, 9, 8], 0.2, 7);
    let walls = vec![
        Wall::new([0.0, 0.0, 1.0], 0.0).unwrap(),
        Wall::new([1.0, 0.0, 0.0], 0.0).unwrap(),
        Wall::new([-1.0, 0.0, 0.0], -10.0).unwrap(),
    ];
    let surroundings = Surroundings { walls, ..Surroundings::new(1.0) };
    for way in WAYS {
        let field = field(&particles, &surroundings, 0.5, way);
        let closed = iso_surface(&field, Walls::Closed);
        let topology = closed.topology().unwrap();
        assert!(topology.is_closed() && topology.is_manifold(), "{way:?}: {topology:?}");
        let [low, high] = [f64::min, f64::max]
            .map(|f| closed.points.iter().copied().reduce(|a, b| std::array::from_fn(|k| f(a[k], b[k]))).unwrap());
        assert!(low[2] > -0.01 && low[0] > -0.01 && high[0] < 10.01, "{way:?}: {low:?} {high:?}");
        assert!((closed.volume() / 720.0 - 1.0).abs() < 0.05, "{way:?}: {}", closed.volume());

        let open = iso_surface(&field, Walls::Open);
        let topology = open.topology().unwrap();
        assert!(!topology.is_closed() && topology.is_manifold() && topology.open_edges > 0, "{way:?}");
        // The floor and two sides are gone.
        let gone = closed.area() - open.area();
        assert!((gone / (90.0 + 2.0 * 72.0) - 1.0).abs() < 0.1, "{way:?}: {gone}");
    }
}

#[test]
fn a_fluid_that_fills_a_periodic_box_sideways_is_closed_at_the_box() {
    let particles = block([6, 6, 10], 0.1, 3);
    let domain = Domain::new([0.0; 3], [6.0, 6.0, 20.0], [true, true, false]).unwrap();
    let surroundings = Surroundings { domain: Some(domain), ..Surroundings::new(1.0) };
    for way in WAYS {
        let field = field(&particles, &surroundings, 0.5, way);
        let closed = iso_surface(&field, Walls::Closed);
        let topology = closed.topology().unwrap();
        assert!(topology.is_closed() && topology.is_manifold(), "{way:?}: {topology:?}");
        assert!((closed.volume() / 360.0 - 1.0).abs() < 0.05, "{way:?}: {}", closed.volume());
        let open = iso_surface(&field, Walls::Open);
        // Top and bottom, and along their edges no more than a strip one cell wide.
        assert!((open.area() - 72.0).abs() < 0.5 * 48.0, "{way:?}: {}", open.area());
    }
}

#[test]
fn nodes_on_walls_hold_fluid_and_periodic_faces_let_it_pass_where_asked_to() {
    let particles = block([6, 6, 6], 0.0, 3);
    let surroundings = Surroundings {
        domain: Some(Domain::new([0.0; 3], [6.0, 6.0, 20.0], [false, true, false]).unwrap()),
        // Of no short binary fraction: nodes are on this wall to rounding.
        walls: vec![Wall::new([0.3, 0.0, 0.1], 0.03).unwrap(), Wall::new([0.0, 0.0, 1.0], 0.0).unwrap()],
        ..Surroundings::new(1.0)
    };
    let found = detect_surface(&particles, &Exact::default(), &surroundings, &SurfaceOptions::LABELS).unwrap();
    // Three columns of nodes from the floor down to −1, at y = −1, 0, …, 7.
    let nodes = Nodes::new([2.1, -1.0, -1.0], [1.0; 3], [1, 9, 4]).unwrap();
    for (periodic_faces, expected) in [
        (PeriodicFaces::Pass, [true; 9]),
        (PeriodicFaces::End, {
            // With an end there the faces themselves are on the surface.
            [false, true, true, true, true, true, true, true, false]
        }),
    ] {
        let options = LevelSetOptions { periodic_faces, ..LevelSetOptions::default() };
        let level = level_set(&particles, &surroundings, &found.detection, &nodes, &options).unwrap();
        let density = density_field(&particles, &surroundings, &nodes, 1.25, periodic_faces).unwrap();
        for (way, field) in [("level set", level), ("density", density)] {
            for (j, expected) in expected.into_iter().enumerate() {
                let column: Vec<bool> = (0..4).map(|k| field.holds_fluid(nodes.node_at([0, j, k]))).collect();
                assert_eq!(column, [false, expected, expected, expected], "{way} {periodic_faces:?} {j}");
            }
        }
    }
    let slanted = Nodes::new([0.1, 3.0, 0.0], [1.0; 3], [1; 3]).unwrap();
    let field = density_field(&particles, &surroundings, &slanted, 1.25, PeriodicFaces::Pass).unwrap();
    assert!(field.holds_fluid(0), "{:e}", field.values[0] - field.surface_value);
}

#[test]
fn boundary_particles_end_the_fluid_half_way_to_them() {
    // Three layers of boundary below a block.
    let particles = block([8, 8, 11], 0.0, 1);
    let candidates = particles.iter().map(|p| p[2] > 3.0).collect();
    let surroundings = Surroundings { candidates: Some(candidates), ..Surroundings::new(1.0) };
    for way in WAYS {
        let mesh = iso_surface(&field(&particles, &surroundings, 0.5, way), Walls::Closed);
        let topology = mesh.topology().unwrap();
        assert!(topology.is_closed() && topology.is_manifold(), "{way:?}: {topology:?}");
        let floor = mesh.points.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
        assert!((floor - 3.0).abs() < 0.3, "{way:?}: {floor}");
        assert!((mesh.volume() / 512.0 - 1.0).abs() < 0.06, "{way:?}: {}", mesh.volume());
    }
}

#[test]
fn moving_least_squares_are_exact_for_linear_fields_in_disorder_and_fall_back_in_sheets() {
    let particles = block([9, 9, 9], 0.4, 11);
    let linear = |p: [f64; 3]| 3.0 - 2.0 * p[0] + 0.5 * p[1] + p[2];
    let data: Vec<f64> = particles.iter().map(|&p| linear(p)).collect();
    let columns = [Column { components: 1, data: &data }];
    let mut random = Random(5);
    let points: Vec<[f64; 3]> = (0..500).map(|_| random.point(0.0, 9.0)).collect();
    let found = interpolate(&particles, &Surroundings::new(1.0), &columns, &points, 1.5).unwrap();
    for ((point, value), support) in points.iter().zip(&found.values[0]).zip(&found.support) {
        assert_eq!(*support, Support::Linear);
        assert!((value - linear(*point)).abs() < 1e-10, "{point:?}: {value}");
    }

    let sheet: Vec<[f64; 3]> = (0..100).map(|i| [f64::from(i % 10), f64::from(i / 10), 0.0]).collect();
    let constant = vec![7.0; 200];
    let columns = [Column { components: 2, data: &constant }];
    let points = [[4.3, 4.8, 0.2], [4.0, 4.0, 50.0]];
    let found = interpolate(&sheet, &Surroundings::new(1.0), &columns, &points, 1.5).unwrap();
    assert_eq!(found.support, [Support::Shepard, Support::None]);
    assert!(found.values[0][..2].iter().all(|v| (v - 7.0).abs() < 1e-13) && found.values[0][2..] == [0.0; 2]);
}

#[test]
fn moving_least_squares_are_exact_for_linear_fields_up_to_walls() {
    let particles = block([8, 8, 8], 0.3, 3);
    let pressure: Vec<f64> = particles.iter().map(|p| 9.81 * (8.0 - p[2]) + p[0]).collect();
    // A stagnation flow: nothing may go through the floor.
    let velocity: Vec<f64> = particles.iter().flat_map(|p| [0.5 * p[0], 0.5 * p[1], -p[2]]).collect();
    let columns = [Column { components: 1, data: &pressure }, Column { components: 3, data: &velocity }];
    let walls = [([0.0, 0.0, 1.0], 0.0), ([1.0, 0.0, 0.0], 0.0), ([-1.0, 0.0, 0.0], -8.0)];
    let walls = walls.map(|(normal, offset)| Wall::new(normal, offset).unwrap()).to_vec();
    let surroundings = Surroundings { walls, ..Surroundings::new(1.0) };
    // On the floor, on its edges with two walls, half a spacing above it and two.
    let points = [[4.2, 3.9, 0.0], [0.0, 4.0, 0.0], [8.0, 4.0, 0.0], [4.0, 4.0, 0.5], [4.0, 4.0, 2.0]];
    let found = interpolate(&particles, &surroundings, &columns, &points, 1.5).unwrap();
    assert_eq!(found.support, [Support::Linear; 5]);
    for (n, [x, y, z]) in points.into_iter().enumerate() {
        assert!((found.values[0][n] - (9.81 * (8.0 - z) + x)).abs() < 1e-10, "{n}: {}", found.values[0][n]);
        for (value, expected) in found.values[1][3 * n..3 * n + 3].iter().zip([0.5 * x, 0.5 * y, -z]) {
            assert!((value - expected).abs() < 1e-11, "{n}: {value}");
        }
    }
}

#[test]
fn fields_and_surfaces_do_not_depend_on_the_number_of_threads() {
    let particles = block([8, 7, 6], 0.3, 5);
    for way in WAYS {
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| field(&particles, &Surroundings::new(1.0), 0.5, way))
        });
        assert!(one == three && iso_surface(&one, Walls::Closed) == iso_surface(&three, Walls::Closed));
    }
}

#[test]
fn a_crowd_of_particles_on_the_surface_makes_no_hole_below_it() {
    // What fell onto the surface stays there, so many that the particles beside and below it see more fluid above.
    let mut particles = block([12, 12, 12], 0.0, 1);
    let top = particles.iter().map(|p| p[2]).fold(f64::MIN, f64::max);
    let crowd = block([6, 6, 3], 0.0, 1);
    particles
        .extend(crowd.iter().map(|p| [6.0 + 0.15 * (p[0] - 3.0), 6.0 + 0.15 * (p[1] - 3.0), top + 0.6 + 0.15 * p[2]]));
    let field = field(&particles, &Surroundings::new(1.0), 0.5, Way::LevelSet(SurfaceDistance::Blended));
    let deep = (0..field.nodes.len()).filter(|&n| {
        let [x, y, z] = field.nodes.position(n);
        (2.0..10.0).contains(&x) && (2.0..10.0).contains(&y) && (2.0..top - 1.5).contains(&z)
    });
    let deep: Vec<f64> = deep.map(|n| field.values[n]).collect();
    let shallowest = deep.iter().copied().fold(f64::MAX, f64::min);
    assert!(deep.len() > 1000 && shallowest > 0.05, "{} {shallowest}", deep.len());
}

#[test]
fn normals_of_a_sphere_point_outwards() {
    let particles = body([9.0; 3], |p| length(p) < 9.0);
    for way in [Way::LevelSet(SurfaceDistance::Blended), Way::Density] {
        let (mesh, _) = surface(&particles, way);
        let mean: f64 = mesh
            .points
            .iter()
            .zip(&mesh.normals)
            .map(|(p, n)| (0..3).map(|k| p[k] * n[k]).sum::<f64>() / length(*p))
            .sum::<f64>()
            / mesh.points.len() as f64;
        assert!(mean > 0.96, "{way:?}: {mean}");
    }
}

#[test]
fn in_the_plane_areas_are_those_of_the_particles_and_least_squares_are_exact() {
    let flat = Surroundings { dimension: 2, ..Surroundings::new(1.0) };
    let area = |particles: &[[f64; 3]], way: Way| {
        let nodes = Nodes::around(particles, 1.5, 0.125).unwrap().slice(2, 0.0).unwrap();
        let field = match way {
            Way::Density => density_field(particles, &flat, &nodes, 1.25, PeriodicFaces::End).unwrap(),
            Way::LevelSet(distance) => {
                let found = detect_surface(particles, &Exact::default(), &flat, &SurfaceOptions::LABELS).unwrap();
                let options = LevelSetOptions { distance, ..LevelSetOptions::default() };
                level_set(particles, &flat, &found.detection, &nodes, &options).unwrap()
            }
        };
        (0..nodes.len()).filter(|&n| field.holds_fluid(n)).count() as f64 / 64.0
    };
    let plane = |points: Vec<[f64; 3]>| -> Vec<[f64; 3]> { points.into_iter().map(|[x, y, _]| [x, y, 0.0]).collect() };
    let disc = plane(body([12.0, 12.0, 0.0], |[x, y, z]| x.hypot(y) < 12.0 && (0.0..1.0).contains(&z)));
    assert!((440..470).contains(&disc.len()));
    let blended = Way::LevelSet(SurfaceDistance::Blended);
    for way in [blended, Way::Density] {
        let found = area(&disc, way) / disc.len() as f64;
        println!("disc {way:?} {found}");
        assert!((found - 1.0).abs() < 0.04, "{way:?}: {found}");
    }
    let lone = vec![[0.2, 0.4, 0.0], [9.0, 1.0, 0.0], [0.3, 7.0, 0.0]];
    let line: Vec<[f64; 3]> = (0..40).map(|i| [f64::from(i), 0.2, 0.0]).collect();
    for (name, particles) in [("drops", lone), ("line", line)] {
        let found = area(&particles, blended) / particles.len() as f64;
        println!("{name} {found}");
        assert!((found - 1.0).abs() < 0.15, "{name}: {found}");
    }

    let particles = plane(block([9, 9, 1], 0.4, 11));
    let linear = |p: [f64; 3]| 3.0 - 2.0 * p[0] + 0.5 * p[1];
    let data: Vec<f64> = particles.iter().map(|&p| linear(p)).collect();
    let mut random = Random(5);
    let points: Vec<[f64; 3]> = (0..200).map(|_| [random.uniform(0.0, 9.0), random.uniform(0.0, 9.0), 0.0]).collect();
    let found = interpolate(&particles, &flat, &[Column { components: 1, data: &data }], &points, 1.5).unwrap();
    for ((point, value), support) in points.iter().zip(&found.values[0]).zip(&found.support) {
        assert_eq!(*support, Support::Linear);
        assert!((value - linear(*point)).abs() < 1e-10, "{point:?}: {value}");
    }
    let row: Vec<[f64; 3]> = (0..10).map(|i| [f64::from(i), 0.0, 0.0]).collect();
    let column = Column { components: 1, data: &[7.0; 10] };
    let found = interpolate(&row, &flat, &[column], &[[4.3, 0.4, 0.0]], 1.5).unwrap();
    assert!(found.support == [Support::Shepard] && (found.values[0][0] - 7.0).abs() < 1e-13);
}

#[test]
fn four_dimensions_and_wrong_lengths_are_refused() {
    let particles = block([3, 3, 3], 0.0, 1);
    let nodes = Nodes::around(&particles, 1.0, 0.5).unwrap();
    let four = Surroundings { dimension: 4, ..Surroundings::new(1.0) };
    let refused = density_field(&particles, &four, &nodes, 1.25, PeriodicFaces::End).unwrap_err().to_string();
    assert!(refused.contains("dimensions is 4; it must be 2 or 3"), "{refused}");
    let short = Surroundings { volumes: Some(vec![1.0; 5]), ..Surroundings::new(1.0) };
    assert!(
        density_field(&particles, &short, &nodes, 1.25, PeriodicFaces::End)
            .unwrap_err()
            .to_string()
            .contains("5 entries for 27")
    );
    let columns = [Column { components: 2, data: &[1.0; 27] }];
    let refused = interpolate(&particles, &Surroundings::new(1.0), &columns, &[[0.0; 3]], 1.5).unwrap_err();
    assert!(refused.to_string().contains("27 entries for 54"), "{refused}");
    assert!(Nodes::around(&[], 1.0, 0.5).is_err() && Nodes::around(&particles, 1.0, 1e-9).is_err());
    assert!(nodes.slice(1, 99.0).is_err());
}
