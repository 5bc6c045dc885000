//! Bodies and fills bounded by triangles, against the same solids as shapes.
#![allow(clippy::unwrap_used)]

mod common;

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use fieldstone_io::write_stl;
use fieldstone_sph::{Body, Boundaries, Case, ClosedSurface, Flow, FluidOptions, SHIPPED, Shape, Slip, Solver, State};

type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

fn cuboid(low: [f64; 3], high: [f64; 3]) -> Triangles {
    let points = (0..8).map(|n| std::array::from_fn(|k| if n >> k & 1 == 1 { high[k] } else { low[k] })).collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (points, faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// A sphere of `rings` rings of triangles between its poles, twice as many along each; poles and equator lie on it.
fn ball(centre: [f64; 3], radius: f64, rings: u32) -> Triangles {
    let around = 2 * rings;
    let mut points = vec![];
    for ring in 1..rings {
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(rings);
        for n in 0..around {
            let angle = std::f64::consts::TAU * f64::from(n) / f64::from(around);
            let unit = [polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos()];
            points.push(std::array::from_fn(|k| centre[k] + radius * unit[k]));
        }
    }
    let (top, bottom) = (points.len() as u32, points.len() as u32 + 1);
    points.push([centre[0], centre[1], centre[2] + radius]);
    points.push([centre[0], centre[1], centre[2] - radius]);
    let mut triangles = vec![];
    for n in 0..around {
        let next = (n + 1) % around;
        triangles.push([top, n, next]);
        for ring in 0..rings - 2 {
            let (a, b) = (ring * around + n, ring * around + next);
            triangles.extend([[a, a + around, b + around], [a, b + around, b]]);
        }
        let last = (rings - 2) * around;
        triangles.push([bottom, last + next, last + n]);
    }
    (points, triangles)
}

/// ASCII, with all digits.
fn text((points, triangles): &Triangles) -> String {
    let mut text = String::from("solid test\n");
    for triangle in triangles {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        for p in triangle.map(|p| points[p as usize]) {
            writeln!(text, "vertex {} {} {}", p[0], p[1], p[2]).unwrap();
        }
        text.push_str("endloop\nendfacet\n");
    }
    text + "endsolid test\n"
}

fn shipped(name: &str, spacing: f64) -> String {
    let text = SHIPPED.iter().find(|c| c.name == name).unwrap().text;
    text.lines()
        .map(|l| if l.starts_with("spacing") { format!("spacing = {spacing}\n") } else { format!("{l}\n") })
        .collect()
}

fn bits(solver: &Solver) -> Vec<u64> {
    let state = solver.state();
    let numbers = state.x.iter().chain(&state.u).flatten().chain(&state.density);
    numbers.map(|x| x.to_bits()).chain(state.id.iter().map(|&id| u64::from(id))).collect()
}

#[test]
fn a_box_of_triangles_is_the_same_body_to_the_bit_as_the_box_moving_or_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.toml");
    std::fs::write(folder.path().join("column.stl"), text(&cuboid([0.9, 0.24, -0.18], [1.02, 0.36, 0.45]))).unwrap();
    let keys = "shape = \"box\"\nlow = [0.9, 0.24, -0.09]\nhigh = [1.02, 0.36, 0.45]";
    let resting = shipped("obstacle", 0.03);
    assert!(resting.contains(keys));
    // Next to the water, so that its ghosts act from the first step.
    let moving = format!("{keys}\nmotion = [[0, 0, 0, 0], [0.1, -0.05, 0, 0]]");
    for (body, steps) in [(keys.to_string(), 3), (moving, 6)] {
        let deep = resting.replace(keys, &body).replace("high = [0.4, 0.6, 0.3]", "high = [0.9, 0.6, 0.3]");
        let deep = deep.replace("low = [0.9, 0.24, -0.09]", "low = [0.9, 0.24, -0.18]");
        let triangles = deep.replace(
            "shape = \"box\"\nlow = [0.9, 0.24, -0.18]\nhigh = [1.02, 0.36, 0.45]",
            "shape = \"stl\"\nfile = \"column.stl\"",
        );
        assert!(triangles.contains("column.stl"));
        let mut found = Vec::new();
        for text in [deep, triangles] {
            std::fs::write(&path, text).unwrap();
            let mut solver = Case::read(&path).unwrap().solver().unwrap();
            common::alone(|| (0..steps).for_each(|_| assert!(solver.step().unwrap() > 0.0)));
            let force = solver.boundary_forces().unwrap().bodies[0];
            assert!(force[0].abs() > 1.0, "{force:?}");
            found.push((solver.ghost_count(), force.map(f64::to_bits), bits(&solver)));
        }
        assert!(found[0] == found[1]);
    }
}

#[test]
fn a_column_of_triangles_starts_with_the_free_surface_of_the_box() {
    let folder = tempfile::tempdir().unwrap();
    // In millimetres, beside its place, binary.
    let (points, triangles) = cuboid([-600.0, -150.0, 10.0], [600.0, 150.0, 610.0]);
    write_stl(&folder.path().join("column.stl"), &points, &triangles).unwrap();
    let box_text = shipped("dam-break", 0.02);
    let keys = "shape = \"box\"\nlow = [0.0, 0.0, 0.0]\nhigh = [1.2, 0.3, 0.6]";
    assert!(box_text.contains(keys));
    let stl = "shape = \"stl\"\nfile = \"column.stl\"\nscale = 0.001\noffset = [0.6, 0.15, -0.01]";
    let path = folder.path().join("case.toml");
    std::fs::write(&path, box_text.replace(keys, stl)).unwrap();
    let solver = Case::read(&path).unwrap().solver().unwrap();
    let free = solver.regions().iter().filter(|&&r| r == 0).count();
    assert_eq!((solver.state().len(), free), (60 * 15 * 30, 60 * 15 + 29 * 15));
    let expected = Case::parse(&box_text, "box.toml").unwrap().state().unwrap();
    let off = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max);
    assert!(solver.state().x.iter().zip(&expected.x).all(|(a, b)| off(a, b) < 1e-12));
    assert!(solver.state().density.iter().zip(&expected.density).all(|(a, b)| (a - b).abs() < 1e-9));
}

#[test]
fn a_ball_of_triangles_is_the_sphere_but_for_what_lies_between_facets_and_sphere() {
    let (centre, radius) = ([0.3, -0.2, 1.1], 0.5);
    let sphere = Shape::Sphere { centre, radius };
    let (points, triangles) = ball(centre, radius, 8);
    let surface = ClosedSurface::new(points, triangles).unwrap();
    // Facets lie inside the sphere by the rise of two arcs of 22.5°, along and across.
    let sagitta = 2.0 * radius * (1.0 - (std::f64::consts::PI / 16.0).cos());
    let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    assert!(surface.volume() < volume && surface.volume() > volume * (1.0 - 4.0 * sagitta / radius));
    let facets = Shape::Surface(Arc::new(surface));
    for n in 0..4096 {
        let x: [f64; 3] = std::array::from_fn(|k| centre[k] - 0.7 + 0.0931 * f64::from(n >> (4 * k) & 15));
        let (a, b) = (facets.depth(x, 3), sphere.depth(x, 3));
        assert!(a <= b + 1e-9 && a > b - sagitta, "{x:?}: {a} {b}");
    }
    let (expected, cell) = sphere.lattice(0.05, 3);
    let (found, other) = facets.lattice(0.05, 3);
    assert!((cell / other - 1.0).abs() < 1e-9, "{cell} {other}");
    let in_doubt = expected.iter().filter(|&&x| sphere.depth(x, 3) < sagitta).count();
    assert!(in_doubt > 0 && found.len() <= expected.len() && found.len() + in_doubt >= expected.len());
    let near = |x: &[f64; 3], y: &[f64; 3]| (0..3).all(|k| (x[k] - y[k]).abs() < 1e-9);
    assert!(found.iter().all(|x| expected.iter().any(|y| near(x, y))));
    println!("ball: {} of {} particles, {in_doubt} between", found.len(), expected.len());
}

#[test]
fn water_at_rest_presses_a_ball_of_triangles_up_with_the_force_on_the_sphere() {
    let mut fluid = FluidOptions::new(3, 0.05, 1.0, 9810.0);
    fluid.sound_speed = 40.0;
    let boundaries = Boundaries::new([0.0; 3], [1.0; 3], fluid.spacing);
    let tank = Shape::Box { low: [0.0; 3], high: [1.0; 3] };
    let (points, triangles) = ball([0.5; 3], 0.3, 16);
    let ball = Shape::Surface(Arc::new(ClosedSurface::new(points, triangles).unwrap()));
    let sphere = Shape::Sphere { centre: [0.5; 3], radius: 0.3 };
    let lift = [ball, sphere].map(|shape| {
        let (mut x, _) = tank.lattice(0.05, 3);
        x.retain(|&x| !shape.contains(x, 3));
        let density = x.iter().map(|x| fluid.density_at(9810.0 * (1.0 - x[2]))).collect();
        let state = State { u: vec![[0.0; 3]; x.len()], density, id: (0..x.len() as u32).collect(), x };
        let mut flow = Flow::new(fluid, boundaries.clone());
        flow.boundaries.bodies.push(Body::new(shape, Slip::Free));
        Solver::new(flow, state).unwrap().boundary_forces().unwrap().bodies[0]
    });
    let archimedes = 9810.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.027;
    println!("lift {lift:?} of {archimedes}");
    assert!((lift[0][2] / lift[1][2] - 1.0).abs() < 0.05 && (lift[0][2] / archimedes - 1.0).abs() < 0.002, "{lift:?}");
}

fn error(folder: &Path, body: &str) -> String {
    let path = folder.join("case.toml");
    let text = shipped("obstacle", 0.03);
    let start = text.find("[[body]]").unwrap();
    let end = text.find("[shifting]").unwrap();
    std::fs::write(&path, format!("{}[[body]]\n{body}\n\n{}", &text[..start], &text[end..])).unwrap();
    Case::read(&path).unwrap_err().to_string()
}

#[test]
fn what_bounds_no_solid_or_too_thin_a_one_is_refused_with_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, (points, triangles): &Triangles| {
        write_stl(&folder.path().join(name), points, triangles).unwrap();
    };
    let mut open = cuboid([0.0; 3], [0.25; 3]);
    open.1.pop();
    write("open.stl", &open);
    write("plate.stl", &cuboid([0.75, 0.0, -0.25], [0.875, 0.5, 0.5]));
    // Thick all along the axes, thin across.
    let (mut points, triangles) = cuboid([0.0; 3], [0.1, 1.0, 1.0]);
    for p in &mut points {
        *p = [0.5 + p[0] - 0.5 * p[1], 0.5 * p[1], p[2]];
    }
    write("slanted.stl", &(points, triangles));
    for (body, line, expected) in [
        ("shape = \"stl\"\nfile = \"open.stl\"", 33, "open.stl: the surface is not closed: 3 edges are not shared"),
        ("shape = \"stl\"\nfile = \"none.stl\"", 33, "none.stl: cannot open"),
        ("shape = \"stl\"\nfile = \"plate.stl\"\nscale = 0.5", 32, "thick along x; it must be at least 4 spacings"),
        ("shape = \"stl\"\nfile = \"slanted.stl\"", 32, "plate or a sharp wedge 0.070711 thick at"),
        ("shape = \"stl\"", 32, "this shape needs file"),
        ("shape = \"stl\"\nfile = \"plate.stl\"\nscale = -1.0", 34, "scale is -1; it must be finite and above 0"),
        ("shape = \"stl\"\nfile = \"plate.stl\"\noffset = [1]", 34, "offset is [1.0]; give 3 finite numbers"),
        ("shape = \"box\"\nfile = \"plate.stl\"", 33, "file does not go with shape = \"box\", which takes low, high"),
        ("shape = \"box\"\nmass = 3", 33, "unknown field `mass`, expected one of"),
        ("shape = \"box\"\nmass = 3", 33, "floating bodies are out of scope"),
    ] {
        let found = error(folder.path(), body);
        assert!(found.contains(expected), "{found}\ninstead of {expected}");
        assert!(found.contains(&format!("case.toml:{line}: ")), "{found}\ninstead of line {line}");
    }
}
