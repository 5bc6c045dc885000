//! The bounds of the errors of volumes in `f64`, in meshes from inside and from outside and in grids, against more digits.
//!
//! The long run: `FIELDSTONE_PAIRS=200000 cargo test --release -p fieldstone-mesh --lib error_bounds -- --nocapture`.

use fieldstone_geometry::{
    Ball, CornerOrder, ElementKind, PROMISE, Polyhedron, Precision, certified_overlap, overlap_in,
};
use fieldstone_testing::{Random, pairs};

use crate::ball_overlap::Way;
use crate::grid::ROUNDING;
use crate::{CellList, Cells, Grid, Mesh};

/// Pairs of each kind tried by default; `FIELDSTONE_PAIRS` asks for more.
fn count() -> u64 {
    std::env::var("FIELDSTONE_PAIRS").ok().and_then(|n| n.parse().ok()).unwrap_or(20_000)
}

/// A mesh of one cell; `None` for corners that enclose no volume.
fn cell(random: &mut Random) -> Option<Mesh> {
    let (kind, corners) = pairs::element(random);
    let mut list = CellList::new();
    let labels: Vec<u32> = (0..corners.len() as u32).collect();
    list.push(ElementKind::STANDARD[kind], CornerOrder::Cgns, &labels).ok()?;
    Mesh::from_cells(corners, list).ok()
}

/// Error over bound of the volume from inside and from outside, and of the sphere area, where what is taken keeps the promise.
fn errors_over_bounds(mesh: &Mesh, ball: &Ball) -> [Option<f64>; 4] {
    // What the bound is for is the mesh's own cell, with its rounded centroids.
    let Ok(alone) = mesh.polyhedron_of_pieces(0) else { return [None; 4] };
    let certain = match certified_overlap(ball, &alone) {
        found if found.precision == Precision::F64 => overlap_in(ball, &alone, Precision::DoubleDouble),
        found => found,
    };
    let surface: f64 = alone.face_areas().iter().sum();
    let allowed = [ball.volume().min(mesh.cell_volumes()[0]), ball.surface_area().min(surface)].map(|x| PROMISE * x);
    let exact = [certain.overlap.volume, certain.overlap.sphere_area];
    let uncertain = [certain.volume_error, certain.sphere_area_error];
    let mut ratios = [None; 4];
    for (k, way) in [Way::Inside, Way::Outside].into_iter().enumerate() {
        let mut scratch = mesh.fast_scratch();
        scratch.next_ball();
        // With its sphere area, a cell inside the ball is evaluated face by face.
        let Ok(found) = mesh.cell_in_f64(ball, 0, way, &mut scratch, false) else { continue };
        let Some(bounds) = found.errors else { continue };
        for (quantity, value) in [found.volume, found.sphere_area].into_iter().enumerate() {
            // An area is taken with its volume only: whether the centre is in the cell, that tells for both.
            if bounds[0] <= allowed[0] && bounds[quantity] <= allowed[quantity] {
                let error = (value - exact[quantity]).abs() - uncertain[quantity];
                ratios[2 * quantity + k] = Some(error / bounds[quantity]);
            }
        }
    }
    ratios
}

/// The largest of [`errors_over_bounds`], with balls by `ball` from a cell's corners and bounds.
fn largest(ball: impl Fn(&Mesh, &mut Random) -> ([f64; 3], f64)) -> [f64; 4] {
    let (mut compared, mut worst) = ([0u64; 4], [0.0f64; 4]);
    for seed in 0..count() {
        let random = &mut Random(seed);
        let Some(mesh) = cell(random) else { continue };
        let (centre, radius) = ball(&mesh, random);
        let Ok(ball) = Ball::new(centre, radius) else { continue };
        for (k, ratio) in errors_over_bounds(&mesh, &ball).into_iter().enumerate() {
            compared[k] += u64::from(ratio.is_some());
            worst[k] = worst[k].max(ratio.unwrap_or(0.0));
        }
    }
    println!("{compared:?} volumes from inside and outside, areas likewise; largest error / bound {worst:.3?}");
    assert!(compared.iter().all(|&n| n > count() / 20));
    worst
}

#[test]
fn the_bounds_of_accepted_volumes_and_areas_enclose_five_times_their_errors() {
    let worst = largest(|mesh, random| pairs::ball(&mesh.parts().points, mesh.cell_bounds(0), random));
    assert!(worst.iter().all(|&ratio| ratio <= 0.2), "{worst:?}");
}

#[test]
fn the_bounds_hold_for_small_balls_near_edges_where_angles_lose_digits() {
    let worst = largest(|mesh, random| {
        let corners = &mesh.parts().points;
        let [a, b] = [0, 1].map(|_| corners[random.below(corners.len())]);
        let along = 0.5 + 0.5 * random.uniform(-1.0, 1.0);
        let radius = 10f64.powf(4.0 * random.uniform(-1.0, 1.0) - 2.0);
        let (off, direction) = (radius * 10f64.powf(0.75 * random.uniform(-1.0, 1.0) - 1.0), random.point(-1.0, 1.0));
        ([0, 1, 2].map(|k| a[k] + along * (b[k] - a[k]) + off * direction[k]), radius)
    });
    assert!(worst.iter().all(|&ratio| ratio <= 0.2), "{worst:?}");
}

#[test]
fn an_area_whose_bound_exceeds_the_promise_takes_more_digits_though_the_volume_does_not() {
    let (mut volumes, mut areas) = (0, 0);
    for seed in 0..count() / 4 {
        let random = &mut Random(seed);
        let Some(mesh) = cell(random) else { continue };
        let (centre, radius) = pairs::ball(&mesh.parts().points, mesh.cell_bounds(0), random);
        let Ok(ball) = Ball::new(centre, radius) else { continue };
        let (mut fast, mut promised) = (mesh.fast_scratch(), mesh.scratch());
        let (mut found, mut faces) = (Vec::new(), Vec::new());
        mesh.overlap_ball(&ball, &mut promised, &mut Vec::new());
        let beyond = mesh.path_counts(&promised).beyond_f64;
        mesh.overlap_ball_areas(&ball, &mut promised, &mut found, &mut faces);
        let with_areas = mesh.path_counts(&promised).beyond_f64 - beyond;
        volumes += beyond;
        areas += with_areas;
        if with_areas > 0 || found.is_empty() {
            continue;
        }
        fast.next_ball();
        let [_, error] = match mesh.cell_in_f64(&ball, 0, Way::Inside, &mut fast, false) {
            Ok(found) => found.errors.unwrap_or_default(),
            Err(_) => continue,
        };
        let surface: f64 = mesh.polyhedron_of_pieces(0).unwrap().face_areas().iter().sum();
        let allowed = (1.0 + 1e-9) * PROMISE * surface.min(ball.surface_area());
        assert!(error <= allowed, "seed {seed}: {error:e} of {allowed:e}");
    }
    println!("beyond 64 bits: {volumes} volumes, {areas} volumes with areas");
    assert!(areas > volumes);
}

#[test]
fn the_rounding_of_the_closed_form_in_grids_is_half_of_what_it_is_taken_for() {
    let (mut compared, mut worst) = (0u64, 0.0f64);
    for seed in 0..count() / 4 {
        let random = &mut Random(seed);
        let cells = [0; 3].map(|_| 1 + random.below(4));
        let grid = Grid::new([0.0; 3], [4.0, 3.0, 2.0], cells).unwrap();
        let (mut centre, radius) = (random.point(-0.5, 4.5), random.uniform(0.05, 3.0));
        for (k, x) in centre.iter_mut().enumerate() {
            let plane = grid.plane(k, random.below(cells[k] + 1));
            match random.below(8) {
                0 => *x = plane,
                1 => *x = plane + radius * 10f64.powf(random.uniform(-9.0, 0.0)),
                _ => (),
            }
        }
        let ball = Ball::new(centre, radius).unwrap();
        let mut found = Vec::new();
        grid.overlap_ball(&ball, &mut grid.fast_scratch(), &mut found);
        for (cell, volume) in found {
            let (low, high) = grid.cell_bounds(cell as usize);
            let certain = overlap_in(&ball, &Polyhedron::cuboid(low, high).unwrap(), Precision::DoubleDouble);
            let error = (volume - certain.overlap.volume).abs() - certain.volume_error;
            worst = worst.max(error / (ROUNDING * radius.powi(3)));
            compared += 1;
        }
    }
    println!("{compared} cells; largest error / bound {worst:.3}");
    assert!(compared > count() && worst > 0.1 && worst <= 0.5, "{worst} of {compared}");
}
