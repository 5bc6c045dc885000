//! Whole meshes as solvers and mesh generators write them: nothing is lost between cells, and the two paths from a
//! ball to its volumes agree.

#![allow(clippy::unwrap_used)]

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use fieldstone::fields::{Method, NeumaierSum, SolidFractionOptions, Weights, solid_fraction};
use fieldstone::geometry::{Ball, CornerOrder, ElementKind, Orientation, Polyhedron, overlap, overlap_volume};
use fieldstone::io::vtk::{VtkArrays, VtkEncoding, write_vtu};
use fieldstone::io::{ParticleOptions, read_frame, read_mesh};
use fieldstone::mesh::{CellList, Cells, Grid, Mesh, Patch};
use fieldstone::particles::Particles;
use fieldstone_testing::{Random, data, extended};

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn total(terms: impl IntoIterator<Item = f64>) -> f64 {
    terms.into_iter().collect::<NeumaierSum>().value()
}

fn packing() -> Particles {
    read_frame(&data("packed-cylinder/packed.dump.gz"), &ParticleOptions::default(), -1).unwrap()
}

fn twisted_bed() -> Mesh {
    read_mesh(&data("bed_twist")).unwrap()
}

/// The meshes that are at hand, by name; at least those of the repository.
fn meshes() -> Vec<(&'static str, Mesh)> {
    let own = ["bed_twist", "openfoam/refined", "gmsh/box_v41_all.msh"].map(|name| (name, Some(data(name))));
    let others = ["openfoam/bed_ogrid", "openfoam/gmfoam", "gmsh/vessel_v41.msh"].map(|name| (name, extended(name)));
    own.into_iter().chain(others).filter_map(|(name, path)| Some((name, read_mesh(&path?).unwrap()))).collect()
}

/// OpenFOAM's own face centre and area vector (`primitiveMesh::makeFaceCentresAndAreas`).
fn openfoam_face(points: &[[f64; 3]]) -> ([f64; 3], [f64; 3]) {
    if let [a, b, c] = *points {
        return ([0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0), cross(sub(b, a), sub(c, a)).map(|x| 0.5 * x));
    }
    let estimate = [0, 1, 2].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64);
    let (mut sum_n, mut sum_a, mut sum_ac) = ([0.0; 3], 0.0, [0.0; 3]);
    for (i, &p) in points.iter().enumerate() {
        let next = points[(i + 1) % points.len()];
        let normal = cross(sub(next, p), sub(estimate, p));
        let area = norm(normal);
        sum_a += area;
        for k in 0..3 {
            sum_n[k] += normal[k];
            sum_ac[k] += area * (p[k] + next[k] + estimate[k]);
        }
    }
    (sum_ac.map(|x| x / 3.0 / sum_a), sum_n.map(|x| 0.5 * x))
}

/// OpenFOAM's own cell volumes (`primitiveMesh::makeCellCentresAndVols`): pyramids from the faces to the average of
/// the face centres.
fn openfoam_volumes(mesh: &Mesh) -> Vec<f64> {
    let parts = mesh.parts();
    let faces: Vec<([f64; 3], [f64; 3])> = (0..parts.owner.len())
        .map(|f| openfoam_face(&parts.face(f).iter().map(|&p| parts.points[p as usize]).collect::<Vec<_>>()))
        .collect();
    let volume = |cell| {
        let own: Vec<(usize, f64)> = mesh.signed_faces(cell).collect();
        let centre = [0, 1, 2].map(|k| own.iter().map(|&(f, _)| faces[f].0[k]).sum::<f64>() / own.len() as f64);
        own.iter().map(|&(f, sign)| sign * dot(faces[f].1, sub(faces[f].0, centre))).sum::<f64>() / 3.0
    };
    (0..mesh.cell_count()).map(volume).collect()
}

fn distance_to_triangle(p: [f64; 3], [a, b, c]: [[f64; 3]; 3]) -> f64 {
    let to_segment = |a: [f64; 3], b: [f64; 3]| {
        let (ab, ap) = (sub(b, a), sub(p, a));
        let t = (dot(ap, ab) / dot(ab, ab)).clamp(0.0, 1.0);
        norm(sub(ap, ab.map(|x| t * x)))
    };
    let n = cross(sub(b, a), sub(c, a));
    let above = |a: [f64; 3], b: [f64; 3]| dot(cross(sub(b, a), sub(p, a)), n) >= 0.0;
    if norm(n) > 0.0 && above(a, b) && above(b, c) && above(c, a) {
        return dot(sub(p, a), n).abs() / norm(n);
    }
    to_segment(a, b).min(to_segment(b, c)).min(to_segment(c, a))
}

/// The mesh's outer surface, each face fanned around its centroid.
fn boundary(mesh: &Mesh) -> Vec<[[f64; 3]; 3]> {
    let parts = mesh.parts();
    let mut triangles = Vec::new();
    for face in parts.neighbour.len()..parts.owner.len() {
        let ring: Vec<[f64; 3]> = parts.face(face).iter().map(|&p| parts.points[p as usize]).collect();
        let (centre, _) = openfoam_face(&ring);
        triangles.extend((0..ring.len()).map(|k| [ring[k], ring[(k + 1) % ring.len()], centre]));
    }
    triangles
}

fn depth(surface: &[[[f64; 3]; 3]], point: [f64; 3]) -> f64 {
    surface.iter().map(|&t| distance_to_triangle(point, t)).fold(f64::INFINITY, f64::min)
}

/// Balls inside a mesh, from 0.05 cells to the largest that fits; the first is the largest of them.
fn balls_inside(mesh: &Mesh, count: usize, seed: u64) -> Vec<Ball> {
    let surface = boundary(mesh);
    let (low, high) = mesh.bounds();
    let mut random = Random(seed);
    let mut scratch = mesh.scratch();
    let mut places = Vec::new();
    while places.len() < count {
        let point = [0, 1, 2].map(|k| random.uniform(low[k], high[k]));
        if let Some(cell) = mesh.locate(point, &mut scratch) {
            places.push((point, depth(&surface, point), mesh.cell_volumes()[cell as usize].cbrt()));
        }
    }
    places.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut balls = Vec::new();
    for (rank, &(point, depth, size)) in places.iter().enumerate() {
        // A hair less than what fits: the distance is rounded, too.
        let largest = depth * (1.0 - 1e-12);
        let smallest = 0.05 * size;
        if largest > smallest {
            // The deepest points get the largest ball, every eighth point the smallest, the others any size between.
            let share = match rank {
                _ if rank < count / 8 => 1.0,
                _ if rank % 8 == 0 => 0.0,
                _ => random.unit(),
            };
            balls.push(Ball::new(point, smallest * (largest / smallest).powf(share)).unwrap());
        }
    }
    balls
}

fn polyhedra(mesh: &Mesh) -> Vec<Polyhedron> {
    (0..mesh.cell_count()).map(|cell| mesh.polyhedron(cell).unwrap()).collect()
}

fn candidates<C: Cells>(cells: &C, ball: &Ball) -> Vec<u32> {
    let (c, r) = (ball.centre(), ball.radius());
    let mut found = Vec::new();
    cells.for_each_candidate(c.map(|x| x - r), c.map(|x| x + r), &mut |cell| found.push(cell));
    found
}

#[test]
fn balls_inside_real_meshes_are_shared_out_without_loss_by_the_per_element_path() {
    println!("| mesh | cells | balls | r / cell size | worst error of the sum |");
    println!("|---|---|---|---|---|");
    let mut failures = String::new();
    for (name, mesh) in meshes() {
        let elements = polyhedra(&mesh);
        let balls = balls_inside(&mesh, 64, 7);
        assert!(balls.len() > 40, "{name}: only {} balls fit", balls.len());
        let (mut worst, mut range) = (0.0f64, [f64::INFINITY, 0.0f64]);
        for ball in &balls {
            let pieces = candidates(&mesh, ball).into_iter().map(|cell| overlap_volume(ball, &elements[cell as usize]));
            worst = worst.max((total(pieces) / ball.volume() - 1.0).abs());
            let home = mesh.locate(ball.centre(), &mut mesh.scratch()).unwrap() as usize;
            let ratio = ball.radius() / mesh.cell_volumes()[home].cbrt();
            range = [range[0].min(ratio), range[1].max(ratio)];
        }
        let [from, to] = range;
        println!("| {name} | {} | {} | {from:.3} to {to:.2} | {worst:.1e} |", mesh.cell_count(), balls.len());
        if worst > 1e-13 {
            let _ = write!(failures, " {name}: {worst:e}");
        }
    }
    assert!(failures.is_empty(), "{failures}");
}

#[test]
fn balls_of_up_to_twenty_cells_are_shared_out_without_loss_on_cartesian_grids() {
    let mut random = Random(11);
    for (low, high, cells) in [
        ([0.0; 3], [1.0; 3], [44, 44, 44]),
        ([-0.05, -0.05, 0.0], [0.05, 0.05, 0.13], [42, 45, 50]),
        ([1e3, -2e3, 5.0], [1e3 + 50.0, -2e3 + 60.0, 75.0], [50, 50, 50]),
    ] {
        let grid = Grid::new(low, high, cells).unwrap();
        let size = grid.spacing().into_iter().fold(0.0, f64::max);
        let fit = (0..3).map(|k| 0.5 * (high[k] - low[k])).fold(f64::INFINITY, f64::min);
        let largest = fit.min(20.0 * size);
        let mut scratch = grid.scratch();
        let (mut by_element, mut by_grid, mut apart) = (0.0f64, 0.0f64, 0.0f64);
        for k in 0..20 {
            let r = if k < 2 { largest } else { 0.05 * size * (largest / (0.05 * size)).powf(random.unit()) };
            let centre = [0, 1, 2].map(|k| random.uniform(low[k] + r, high[k] - r));
            let ball = Ball::new(centre, r).unwrap();
            let mut found = Vec::new();
            grid.overlap_ball(&ball, &mut scratch, &mut found);
            by_grid = by_grid.max((total(found.iter().map(|f| f.1)) / ball.volume() - 1.0).abs());
            let mut pieces = Vec::new();
            for cell in candidates(&grid, &ball) {
                let (a, b) = grid.cell_bounds(cell as usize);
                let volume = overlap_volume(&ball, &Polyhedron::cuboid(a, b).unwrap());
                let other = found.binary_search_by_key(&cell, |f| f.0).map_or(0.0, |at| found[at].1);
                apart = apart.max((volume - other).abs() / r.powi(3));
                pieces.push(volume);
            }
            by_element = by_element.max((total(pieces) / ball.volume() - 1.0).abs());
        }
        println!(
            "grid {cells:?}: Σ by elements {by_element:.1e}, by the closed form {by_grid:.1e}, apart {apart:.1e} r³"
        );
        assert!(by_element < 1e-13 && by_grid < 1e-13, "{cells:?}: {by_element:e} {by_grid:e}");
        assert!(apart < 1e-13, "{cells:?}: {apart:e}");
    }
}

#[test]
fn cell_volumes_are_openfoams_own() {
    for (name, mesh) in meshes() {
        let worst = |volumes: &mut dyn Iterator<Item = f64>| {
            volumes.zip(mesh.cell_volumes()).map(|(other, ours)| (ours / other.abs() - 1.0).abs()).fold(0.0, f64::max)
        };
        let foam = worst(&mut openfoam_volumes(&mesh).into_iter());
        let alone = worst(&mut polyhedra(&mesh).iter().map(Polyhedron::volume));
        println!("{name}: apart from OpenFOAM {foam:.1e}, from the cells as polyhedra {alone:.1e}");
        assert!(foam < 1e-12, "{name}: {foam:e}");
        assert!(alone < 1e-12, "{name}: {alone:e}");
    }
}

/// What a comparison of the two paths found.
#[derive(Default)]
struct Comparison {
    /// Pairs of ball and cell that cut each other.
    cut: usize,
    /// Worst difference of volumes, relative to the smaller of ball and cell.
    volume: f64,
    /// Worst differences of the sphere's area and of face areas, relative to the sphere's whole area.
    sphere: f64,
    faces: f64,
}

impl Comparison {
    /// The face-once path for `by_mesh` against each cell alone for `alone`; the two balls differ only where the
    /// comparison itself is on trial.
    fn add(&mut self, mesh: &Mesh, elements: &[Polyhedron], by_mesh: &Ball, alone: &Ball) {
        let mut scratch = mesh.scratch();
        let (mut all, mut areas, mut volumes) = (Vec::new(), Vec::new(), Vec::new());
        mesh.overlap_ball_areas(by_mesh, &mut scratch, &mut all, &mut areas);
        mesh.overlap_ball(by_mesh, &mut scratch, &mut volumes);
        let whole_sphere = alone.surface_area();
        for cell in candidates(mesh, by_mesh) {
            let at = cell as usize;
            let expected = overlap(alone, &elements[at]);
            let smaller = mesh.cell_volumes()[at].min(alone.volume());
            let volume = volumes.binary_search_by_key(&cell, |v| v.0).map_or(0.0, |k| volumes[k].1);
            let found = all.binary_search_by_key(&cell, |f| f.cell).map(|k| all[k]);
            let (other, sphere) = found.map_or((0.0, 0.0), |f| (f.volume, f.sphere_area));
            for volume in [volume, other] {
                self.volume = self.volume.max((volume - expected.volume).abs() / smaller);
            }
            self.sphere = self.sphere.max((sphere - expected.sphere_area).abs() / whole_sphere);
            if found.is_ok() {
                for (face, area) in mesh.cell_faces(at).iter().zip(&expected.face_areas) {
                    let by_mesh = areas.binary_search_by_key(face, |a| a.0).map_or(0.0, |k| areas[k].1);
                    self.faces = self.faces.max((by_mesh - area).abs() / whole_sphere);
                }
            }
            self.cut += usize::from(expected.sphere_area > 0.0 && expected.sphere_area < whole_sphere);
        }
    }
}

#[test]
fn the_face_once_path_equals_the_per_element_path_cell_by_cell() {
    let meshes = meshes();
    // The large meshes share the hundred thousand pairs.
    let large = meshes.iter().filter(|(_, mesh)| mesh.cell_count() > 1000).count();
    let wanted = 100_000 / large + 1;
    let mut pairs = 0;
    for (name, mesh) in &meshes {
        let elements = polyhedra(mesh);
        let mut seen = Comparison::default();
        let mut random = Random(3);
        let (low, high) = mesh.bounds();
        for round in 0.. {
            for ball in balls_inside(mesh, 100, round) {
                seen.add(mesh, &elements, &ball, &ball);
                // Another of the same size that may stick out of the mesh.
                let centre = [0, 1, 2].map(|k| random.uniform(low[k], high[k]));
                let stray = Ball::new(centre, ball.radius()).unwrap();
                seen.add(mesh, &elements, &stray, &stray);
            }
            if seen.cut >= wanted || mesh.cell_count() <= 1000 {
                break;
            }
        }
        pairs += seen.cut;
        println!(
            "{name}: {} cut cells, apart by {:.1e} min(V), sphere {:.1e}, faces {:.1e} of 4πr²",
            seen.cut, seen.volume, seen.sphere, seen.faces
        );
        // Each of the two promises 1e-12 of the exact value.
        assert!(seen.volume < 2e-12 && seen.sphere < 2e-12 && seen.faces < 2e-12, "{name}");
    }
    println!("{pairs} pairs in all");
    assert!(pairs >= 100_000, "{pairs} pairs");
}

#[test]
fn the_comparison_of_the_two_paths_notices_one_part_in_a_billion() {
    let mesh = twisted_bed();
    let elements = polyhedra(&mesh);
    let ball = &balls_inside(&mesh, 64, 5)[0];
    let grown = Ball::new(ball.centre(), ball.radius() * (1.0 + 1e-9)).unwrap();
    let mut seen = Comparison::default();
    seen.add(&mesh, &elements, ball, &grown);
    println!("grown ball: apart by {:.1e} min(V), faces {:.1e}", seen.volume, seen.faces);
    assert!(seen.volume > 1e-10 && seen.faces > 1e-11, "{:e} {:e}", seen.volume, seen.faces);

    // One point moved by a billionth of a cell changes the terms of the faces around it, and nothing else.
    let cell = mesh.locate(ball.centre(), &mut mesh.scratch()).unwrap() as usize;
    let point = mesh.parts().face(mesh.cell_faces(cell)[0] as usize)[0] as usize;
    let at = mesh.parts().points[point];
    let size = mesh.cell_volumes()[cell].cbrt();
    let mut parts = mesh.parts().clone();
    parts.points[point] = at.map(|x| x + 1e-9 * size);
    let moved = Mesh::new(parts).unwrap();
    let around = Ball::new(at, 0.6 * size).unwrap();
    let (mut same, mut other) = (Comparison::default(), Comparison::default());
    same.add(&mesh, &elements, &around, &around);
    other.add(&moved, &elements, &around, &around);
    println!("moved point: apart by {:.1e} min(V)", other.volume);
    assert!(same.volume < 2e-12, "{:e}", same.volume);
    assert!(other.volume > 1e-10, "{:e}", other.volume);
}

#[test]
fn a_ball_that_passes_an_edge_within_rounding_has_no_area_in_the_cell() {
    // A cube turned by 45° about z, so that the box around it says nothing near its edge at (1, 0, z).
    let around = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    let points = [-1.0, 1.0].into_iter().flat_map(|z| around.map(|[x, y]| [x, y, z])).collect();
    let mut cells = CellList::new();
    cells.push(ElementKind::Hexahedron, CornerOrder::Vtk, &[0, 1, 2, 3, 4, 5, 6, 7]).unwrap();
    let mesh = Mesh::from_cells(points, cells).unwrap();
    let mut random = Random(9);
    let mut doubtful = 0;
    for _ in 0..300 {
        let r = 10f64.powf(random.uniform(1.0, 4.0));
        let angle = random.uniform(-0.7, 0.7);
        // From just apart to cutting by a hair, in units of what rounding can tell.
        let gap = random.uniform(-4.0, 20.0) * f64::EPSILON * r;
        let centre = [1.0 + (r + gap) * angle.cos(), (r + gap) * angle.sin(), random.uniform(-0.5, 0.5)];
        let ball = Ball::new(centre, r).unwrap();
        let (mut found, mut areas) = (Vec::new(), Vec::new());
        mesh.overlap_ball_areas(&ball, &mut mesh.scratch(), &mut found, &mut areas);
        doubtful += found.len();
        assert!(found.iter().all(|f| f.sphere_area < 1e-3), "{ball:?}: {found:?}");
    }
    println!("{doubtful} of 300 balls have some volume in the cell");
    assert!(doubtful > 0 && doubtful < 300, "{doubtful}");
}

/// All cells as one: the polyhedron that the outer faces of a mesh enclose.
fn hull(mesh: &Mesh) -> Polyhedron {
    let parts = mesh.parts();
    let outer = parts.neighbour.len()..parts.owner.len();
    let faces: Vec<Vec<usize>> = outer.map(|f| parts.face(f).iter().map(|&p| p as usize).collect()).collect();
    let mut used: Vec<usize> = faces.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let points: Vec<[f64; 3]> = used.iter().map(|&p| parts.points[p]).collect();
    let faces: Vec<Vec<usize>> =
        faces.iter().map(|f| f.iter().map(|p| used.binary_search(p).unwrap()).collect()).collect();
    Polyhedron::from_faces(&points, &faces, Orientation::Refuse).unwrap()
}

#[test]
fn every_bit_of_the_packing_in_the_twisted_bed_is_binned_or_clipped() {
    let (mesh, packing) = (twisted_bed(), packing());
    let result = solid_fraction(&mesh, &packing, &SolidFractionOptions::default()).unwrap();
    let all = total(packing.radii().unwrap().iter().map(|r| 4.0 / 3.0 * PI * r * r * r));
    let binned = total(result.solid_volume.iter().copied());
    let clipped = result.ledger.clipped_volume;
    let error = ((binned + clipped) / all - 1.0).abs();
    println!("binned {binned:e} + clipped {clipped:e} of {all:e}: off by {error:.1e}");
    assert!(error < 1e-12, "{error:e}");
    assert_eq!(result.ledger.binned_volume, binned);

    // What is clipped is more than a remainder: the outer faces, as one polyhedron, leave out the same of each ball.
    let hull = hull(&mesh);
    assert!((hull.volume() / total(mesh.cell_volumes().iter().copied()) - 1.0).abs() < 1e-12);
    let weights = Weights::build(&mesh, &packing, Method::Kernel, None).unwrap();
    let surface = boundary(&mesh);
    let (mut at_wall, mut inside, mut protruding, mut within) = (0.0f64, 0.0f64, 0, 0);
    let mut scratch = mesh.scratch();
    for (i, (&centre, &r)) in packing.positions().iter().zip(packing.radii().unwrap()).enumerate() {
        let ball = Ball::new(centre, r).unwrap();
        let placed = total(weights.row(i).1.iter().copied());
        if depth(&surface, centre) < r {
            protruding += 1;
            at_wall = at_wall.max((overlap_volume(&ball, &hull) - placed).abs() / ball.volume());
        } else if mesh.locate(centre, &mut scratch).is_some() {
            within += 1;
            inside = inside.max((placed / ball.volume() - 1.0).abs());
        } else {
            assert_eq!(placed, 0.0, "ball {i} is outside");
        }
    }
    println!("{protruding} balls stick out: off by {at_wall:.1e}; {within} are inside: off by {inside:.1e}");
    assert!(protruding > 100 && within > 1000, "{protruding} {within}");
    assert!(inside < 1e-13, "{inside:e}");
    assert!(at_wall < 1e-12, "{at_wall:e}");
}

/// Largest difference of two fields, relative to the largest value.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

fn volumes_in(mesh: &Mesh, packing: &Particles) -> Vec<f64> {
    solid_fraction(mesh, packing, &SolidFractionOptions::default()).unwrap().solid_volume
}

#[test]
fn the_text_and_binary_files_of_one_mesh_give_fields_that_differ_by_the_text_s_rounding_only() {
    let Some(binary) = extended("openfoam/bed_twist_bin") else { return };
    let (text, binary) = (twisted_bed(), read_mesh(&binary).unwrap());
    let (a, b) = (&text.parts().points, &binary.parts().points);
    let points = apart(a.as_flattened(), b.as_flattened());
    println!("points apart by {points:.1e}");
    assert_eq!(text.parts().face_points, binary.parts().face_points);
    let packing = packing();
    let fields = apart(&volumes_in(&text, &packing), &volumes_in(&binary, &packing));
    println!("fields apart by {fields:.1e}");
    // The text has 16 or 17 digits, so nearly all of every number.
    assert!(points < 1e-15, "{points:e}");
    assert!(fields < 1e-12, "{fields:e}");
}

#[test]
fn gmsh_files_of_one_mesh_in_three_encodings_give_the_same_field() {
    let names = ["vessel_v22.msh", "vessel_v41.msh", "vessel_v41_bin.msh"].map(|n| extended(&format!("gmsh/{n}")));
    let [Some(a), Some(b), Some(c)] = names else { return };
    let [a, b, c] = [a, b, c].map(|path| read_mesh(&path).unwrap());
    let packing = packing();
    let reference = volumes_in(&a, &packing);
    assert!(total(reference.iter().copied()) > 1e-4);
    for other in [b, c] {
        let points = apart(a.parts().points.as_flattened(), other.parts().points.as_flattened());
        let fields = apart(&reference, &volumes_in(&other, &packing));
        println!("points apart by {points:.1e}, fields by {fields:.1e}");
        assert!(points < 1e-15, "{points:e}");
        assert!(fields < 1e-12, "{fields:e}");
    }
}

/// How a polyMesh is written for the next test.
#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    Gzip,
    Binary,
}

/// Writes the five files of a polyMesh folder, numbers to their last bit.
fn write_poly_mesh(folder: &Path, mesh: &Mesh, encoding: Encoding) {
    let parts = mesh.parts();
    let binary = encoding == Encoding::Binary;
    let header = |class: &str, object: &str| {
        let format = if binary { "binary" } else { "ascii" };
        format!(
            "FoamFile\n{{\n version 2.0;\n format {format};\n arch \"LSB;label=32;scalar=64\";\n \
             class {class};\n object {object};\n}}\n"
        )
        .into_bytes()
    };
    let list = |text: &mut dyn Iterator<Item = String>, raw: &mut dyn Iterator<Item = u8>, count: usize| {
        let mut out = format!("{count}\n(").into_bytes();
        if binary {
            out.extend(raw);
        } else {
            text.for_each(|line| out.extend(format!("\n{line}").into_bytes()));
        }
        out.extend(b")\n");
        out
    };
    let labels = |values: &[u32]| {
        let mut text = values.iter().map(u32::to_string);
        list(&mut text, &mut values.iter().flat_map(|v| v.to_le_bytes()), values.len())
    };
    let mut points = parts.points.iter().map(|p| format!("({:?} {:?} {:?})", p[0], p[1], p[2]));
    let mut raw = parts.points.as_flattened().iter().flat_map(|x| x.to_le_bytes());
    let points = list(&mut points, &mut raw, parts.points.len());
    let faces = if binary {
        let starts: Vec<u32> = std::iter::once(0).chain(parts.face_ends.iter().map(|&e| e as u32)).collect();
        [labels(&starts), labels(&parts.face_points)].concat()
    } else {
        let mut rings = (0..parts.face_ends.len()).map(|f| {
            let ring: Vec<String> = parts.face(f).iter().map(u32::to_string).collect();
            format!("{}({})", ring.len(), ring.join(" "))
        });
        list(&mut rings, &mut std::iter::empty(), parts.face_ends.len())
    };
    let mut patches = format!("{}\n(\n", parts.patches.len());
    for patch in &parts.patches {
        let Patch { name, kind, start, count } = patch;
        let _ = writeln!(patches, "{name} {{ type {kind}; nFaces {count}; startFace {start}; }}");
    }
    patches.push_str(")\n");
    let face_class = if binary { "faceCompactList" } else { "faceList" };
    let files = [
        ("points", header("vectorField", "points"), points),
        ("faces", header(face_class, "faces"), faces),
        ("owner", header("labelList", "owner"), labels(&parts.owner)),
        ("neighbour", header("labelList", "neighbour"), labels(&parts.neighbour)),
        ("boundary", header("polyBoundaryMesh", "boundary"), patches.into_bytes()),
    ];
    std::fs::create_dir_all(folder).unwrap();
    for (name, header, body) in files {
        let content = [header, body].concat();
        if encoding == Encoding::Gzip && name != "boundary" {
            let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
            gz.write_all(&content).unwrap();
            std::fs::write(folder.join(format!("{name}.gz")), gz.finish().unwrap()).unwrap();
        } else {
            std::fs::write(folder.join(name), content).unwrap();
        }
    }
}

#[test]
fn a_mesh_written_again_as_text_gzip_or_binary_gives_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let (mesh, packing) = (twisted_bed(), packing());
    let expected = volumes_in(&mesh, &packing);
    for (name, encoding) in [("text", Encoding::Text), ("gzip", Encoding::Gzip), ("binary", Encoding::Binary)] {
        let path = folder.path().join(name);
        write_poly_mesh(&path.join("constant/polyMesh"), &mesh, encoding);
        let again = read_mesh(&path).unwrap();
        assert_eq!(again.parts().patches, mesh.parts().patches);
        let bits = |field: &[f64]| field.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert!(bits(&volumes_in(&again, &packing)) == bits(&expected), "{name}: other bits");
    }
}

#[test]
fn a_mesh_written_as_vtu_and_read_back_gives_the_same_field() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.vtu");
    let mut seen = 0;
    for (name, mesh) in meshes() {
        write_vtu(&path, &mesh, VtkArrays::default(), VtkEncoding::default()).unwrap();
        let again = read_mesh(&path).unwrap();
        assert_eq!(again.parts().points, mesh.parts().points, "{name}");
        // Cells keep their order, faces do not: they are found anew, so sums run in another order.
        let volumes = apart(mesh.cell_volumes(), again.cell_volumes());
        assert!(volumes < 1e-13, "{name}: {volumes:e}");
        if mesh.cell_count() > 1000 {
            let packing = packing();
            let fields = apart(&volumes_in(&mesh, &packing), &volumes_in(&again, &packing));
            println!("{name}: volumes apart by {volumes:.1e}, fields by {fields:.1e}");
            assert!(fields < 1e-12, "{name}: {fields:e}");
            seen += 1;
        }
    }
    assert!(seen > 0);
}
