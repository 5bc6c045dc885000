//! What lies exactly on faces, edges and corners of cells counts once: points, branches and clouds of sample points, on grids,
//! meshes and round cells, periodic or not.

#![allow(clippy::unwrap_used)]

use fieldstone_fields::{
    CoarseGraining, CoarseGrainingOptions, ContactForm, FieldName, Fields, Method, Weights, contact_traction,
    count_centres,
};
use fieldstone_geometry::{CornerOrder, ElementKind};
use fieldstone_mesh::{CellList, Cells, CylinderGrid, Faces, Grid, Mesh};
use fieldstone_particles::{Contact, Contacts, Domain, Particles, Partner};

/// Lower ends and lengths of boxes: sums of powers of two, and others, whose images are on faces up to rounding only.
const BOXES: [(f64, f64); 4] = [(0.0, 1.0), (-0.5, 1.0), (0.1, 0.3), (1e3 + 0.1, 0.7)];

/// In a cell, on the plane between two, and on both ends, as fractions of a side.
const PLACES: [f64; 4] = [0.3, 0.5, 0.0, 1.0];

const CLOUDS: [Method; 5] =
    [Method::Divided, Method::Sampled(8), Method::Sampled(20), Method::Sampled(64), Method::MonteCarlo(50)];

/// 2³ cubes with corners moved by `place`.
fn mesh_of_cubes(place: impl Fn([f64; 3]) -> [f64; 3]) -> Mesh {
    let points = (0..27).map(|p| place([p % 3, p / 3 % 3, p / 9].map(|i| 0.5 * f64::from(i)))).collect();
    let mut cells = CellList::new();
    for at in (0..27u32).filter(|p| p % 3 < 2 && p / 3 % 3 < 2 && p / 9 < 2) {
        let corners = [0, 1, 4, 3, 9, 10, 13, 12].map(|step| at + step);
        cells.push(ElementKind::Hexahedron, CornerOrder::Vtk, &corners).unwrap();
    }
    Mesh::from_cells(points, cells).unwrap()
}

/// All combinations of three of the places: in cells, on faces, on edges and at corners.
fn combinations(places: &[f64]) -> Vec<[f64; 3]> {
    let n = places.len();
    (0..n * n * n).map(|i| [i % n, i / n % n, i / n / n].map(|k| places[k])).collect()
}

/// The particles' part of a matrix row: one ball of that radius counts as one centre and as one volume, by every method.
fn assert_counted_once<C: Cells>(cells: &C, at: [f64; 3], radius: f64, domain: Option<&Domain>, case: &str) {
    let one = Particles::new(vec![at]).unwrap().with_uniform_radius(radius).unwrap();
    let count: u32 = count_centres(cells, &one, domain).unwrap().iter().sum();
    assert_eq!(count, 1, "{case}: centre of {at:?}");
    for method in CLOUDS.into_iter().chain([Method::Centre]) {
        let weights = Weights::build(cells, &one, method, domain).unwrap();
        let placed: f64 = weights.volumes().iter().sum();
        let volume = weights.particle_volumes()[0];
        assert!((placed / volume - 1.0).abs() < 1e-12, "{case}: {method} at {at:?}: {} of the ball", placed / volume);
    }
}

/// Contact stress of one branch with a force, by the length in each cell.
fn branch_fields<C: Cells>(cells: &C, at: [f64; 3], branch: [f64; 3], domain: Option<&Domain>) -> Fields {
    let one = Particles::new(vec![at]).unwrap().with_uniform_radius(1e-3).unwrap();
    let mut contacts = Contacts::new();
    let force = [1.0, -2.0, -5.0];
    contacts.push(1, Contact { particle: 0, partner: Partner::Wall(0), force, arm: branch, branch }).unwrap();
    let options = CoarseGrainingOptions {
        contact_form: Some(ContactForm::BranchInCell),
        fields: vec![FieldName::ContactStress],
        domain: domain.copied(),
        particle_density: Some(1.0),
        ..CoarseGrainingOptions::default()
    };
    let mut grains = CoarseGraining::new(cells, options).unwrap();
    grains.accumulate(&one, Some(&contacts), 1.0).unwrap();
    grains.finish().unwrap()
}

/// The branch's part of a matrix row: Σ σ V over cells is Σ f ⊗ l over contacts.
fn assert_stress_once<C: Cells>(cells: &C, at: [f64; 3], branch: [f64; 3], domain: Option<&Domain>, case: &str) {
    let ledger = branch_fields(cells, at, branch, domain).ledger;
    let (contacts, fields) = (ledger.stress_sum_contacts, ledger.stress_sum_fields);
    let length = branch.into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    for k in 0..9 {
        assert!(
            (fields[k] - contacts[k]).abs() < 1e-9 * length,
            "{case}: branch {branch:?} from {at:?}: {fields:?} of {contacts:?}"
        );
    }
}

/// Ways to go from a place, as fractions of a side: along one axis, in a plane of two, and across all.
const WAYS: [[f64; 3]; 9] = [
    [0.4, 0.0, 0.0],
    [-0.25, 0.0, 0.0],
    [0.0, 0.4, 0.0],
    [0.0, 0.0, -0.25],
    [0.0, 0.0, 0.7],
    [0.0, 0.25, 0.25],
    [-0.3, 0.2, 0.0],
    [0.1, 0.2, -0.3],
    // A way along a face that rounding has tilted.
    [0.4, 1e-17, -1e-17],
];

fn every_row_of_cells_that_span_a_box<C: Cells>(cells: &C, low: f64, length: f64, name: &str) {
    let domain = Domain::new([low; 3], [low + length; 3], [true; 3]).unwrap();
    for place in combinations(&PLACES) {
        for turns in [0.0, -1.0, 2.0] {
            let at = place.map(|f| low + f * length + turns * length);
            let case = format!("{name} from {low}, periodic over {length}");
            // A radius of half a period: the cloud itself is on faces, as its centre is.
            for radius in [0.1, 0.5] {
                assert_counted_once(cells, at, radius * length, Some(&domain), &case);
            }
            for way in WAYS {
                assert_stress_once(cells, at, way.map(|w| w * length), Some(&domain), &case);
            }
        }
        let at = place.map(|f| if f == 1.0 { low + length } else { low + f * length });
        let case = format!("{name} from {low} over {length}");
        if place.iter().all(|f| [0.3, 0.5].contains(f)) {
            assert_counted_once(cells, at, 0.2 * length, None, &case);
        } else {
            let one = Particles::new(vec![at]).unwrap();
            assert_eq!(count_centres(cells, &one, None).unwrap().iter().sum::<u32>(), 1, "{case}: {at:?}");
        }
        for way in WAYS.into_iter().filter(|way| (0..3).all(|k| (0.0..=1.0).contains(&(place[k] + way[k])))) {
            assert_stress_once(cells, at, way.map(|w| w * length), None, &case);
        }
    }
}

#[test]
fn in_grids_everything_on_faces_edges_and_corners_counts_once() {
    for (low, length) in BOXES {
        let grid = Grid::new([low; 3], [low + length; 3], [2; 3]).unwrap();
        every_row_of_cells_that_span_a_box(&grid, low, length, "grid");
        let one_cell = Grid::new([low; 3], [low + length; 3], [1; 3]).unwrap();
        every_row_of_cells_that_span_a_box(&one_cell, low, length, "one cell");
    }
}

#[test]
fn in_meshes_everything_on_faces_edges_and_corners_counts_once() {
    for (low, length) in BOXES {
        let mesh = mesh_of_cubes(|p| p.map(|x| if x == 1.0 { low + length } else { low + x * length }));
        every_row_of_cells_that_span_a_box(&mesh, low, length, "mesh");
    }
}

#[test]
fn in_round_cells_everything_on_faces_edges_and_corners_counts_once() {
    for (low, length) in BOXES {
        for layers in [1, 2] {
            let grid = CylinderGrid::new(2, [0.0; 3], [0.0, length], [low, low + length], [2, 4, layers]).unwrap();
            let wide = 10.0 * length;
            let domain = Domain::new([-wide, -wide, low], [wide, wide, low + length], [false, false, true]).unwrap();
            // On the axis, on the half-planes, on the inner cylinder, and off all of them.
            for [x, y] in [[0.0, 0.0], [0.3, 0.0], [0.0, 0.5], [0.5, 0.0], [-0.5, 0.0], [0.1, 0.2]] {
                for z in PLACES {
                    let at = [x * length, y * length, if z == 1.0 { low + length } else { low + z * length }];
                    for turns in [0.0, -1.0, 2.0] {
                        let at = [at[0], at[1], at[2] + turns * length];
                        let case = format!("{layers} layers from {low}, periodic over {length}");
                        assert_counted_once(&grid, at, 0.2 * length, Some(&domain), &case);
                        for way in WAYS {
                            assert_stress_once(&grid, at, way.map(|w| w * length), Some(&domain), &case);
                        }
                    }
                    let case = format!("{layers} layers from {low} over {length}");
                    if [0.3, 0.5].contains(&z) {
                        assert_counted_once(&grid, at, 0.2 * length, None, &case);
                    }
                    for way in WAYS.into_iter().filter(|way| (0.0..=1.0).contains(&(z + way[2]))) {
                        assert_stress_once(&grid, at, way.map(|w| w * length), None, &case);
                    }
                }
            }
        }
    }
}

#[test]
fn a_ball_as_wide_as_its_periodic_cell_fills_as_much_of_it_as_its_volume_wherever_it_is() {
    let grid = Grid::new([0.0; 3], [1.0; 3], [1; 3]).unwrap();
    let domain = Domain::new([0.0; 3], [1.0; 3], [true; 3]).unwrap();
    for at in [[0.0; 3], [0.5; 3], [0.0, 0.5, 1.0]] {
        let one = Particles::new(vec![at]).unwrap().with_uniform_radius(0.5).unwrap();
        for method in CLOUDS {
            let weights = Weights::build(&grid, &one, method, Some(&domain)).unwrap();
            let fraction: f64 = weights.volumes().iter().sum();
            assert!((fraction - std::f64::consts::PI / 6.0).abs() < 1e-14, "{method} at {at:?}: {fraction}");
        }
    }
}

/// Row-major turn by angles that no coordinate is a sum of powers of two after.
fn turned(p: [f64; 3]) -> [f64; 3] {
    let ((a, b), (c, d)) = (0.7f64.sin_cos(), 1.1f64.sin_cos());
    let [x, y, z] = p;
    let [x, y] = [b * x - a * y, a * x + b * y];
    [x + 3.0, d * y - c * z - 1.0, c * y + d * z + 0.2]
}

#[test]
fn branches_in_the_faces_of_a_turned_mesh_count_once() {
    let mesh = mesh_of_cubes(turned);
    for place in combinations(&PLACES) {
        for way in WAYS.into_iter().filter(|way| (0..3).all(|k| (0.0..=1.0).contains(&(place[k] + way[k])))) {
            let (start, end) = (turned(place), turned(std::array::from_fn(|k| place[k] + way[k])));
            let branch = std::array::from_fn(|k| end[k] - start[k]);
            assert_stress_once(&mesh, start, branch, None, &format!("turned mesh at {place:?}"));
            if !place.iter().all(|f| [0.3, 0.5].contains(f)) {
                continue;
            }
            // Inside the mesh also a little off, and across the face at a glancing angle.
            for tilt in [1e-16, -1e-14, 1e-12, 1e-10] {
                let branch: [f64; 3] = std::array::from_fn(|k| branch[k] + tilt * (k as f64 - 0.7));
                assert_stress_once(&mesh, start, branch, None, &format!("turned mesh at {place:?}, tilted by {tilt}"));
            }
        }
    }
}

/// Share of a branch's length in each cell.
fn shares<C: Cells>(cells: &C, at: [f64; 3], branch: [f64; 3]) -> Vec<f64> {
    let fields = branch_fields(cells, at, branch, None);
    let whole = fields.ledger.stress_sum_contacts;
    let k = (0..9).max_by(|&a, &b| whole[a].abs().total_cmp(&whole[b].abs())).unwrap();
    let stress = fields.get("contact_stress").unwrap();
    (0..cells.cell_count()).map(|cell| stress.cell(cell)[k] * cells.cell_volume(cell) / whole[k]).collect()
}

#[test]
fn a_branch_in_a_common_face_belongs_to_the_cell_that_its_middle_is_found_in() {
    let mesh = mesh_of_cubes(|p| p.map(|x| 2.0 * x));
    for (at, branch) in [
        // In the face between two cells, along the edge of four, in the outer face and along an outer edge.
        ([1.0, 0.3, 0.5], [0.0, 0.4, 0.0]),
        ([1.0, 1.0, 0.1], [0.0, 0.0, 0.8]),
        ([2.0, 0.3, 0.5], [0.0, 0.4, 0.0]),
        ([2.0, 2.0, 1.1], [0.0, 0.0, 0.8]),
        ([1.9, 1.1, 1.0], [-0.7, 0.8, 0.0]),
    ] {
        let middle = std::array::from_fn(|k| at[k] + 0.5 * branch[k]);
        let cell = mesh.locate(middle, &mut mesh.scratch()).unwrap() as usize;
        for (k, share) in shares(&mesh, at, branch).into_iter().enumerate() {
            assert!((share - f64::from(u8::from(k == cell))).abs() < 1e-14, "{at:?}: {share} in cell {k}");
        }
    }
}

#[test]
fn a_branch_that_leaves_a_common_face_for_the_inside_of_a_cell_is_shared_by_length() {
    // Two cubes beside each other, and on top of both a slab whose lower side has their two faces.
    let points: Vec<[f64; 3]> = (0..18).map(|p| [f64::from(p % 3), f64::from(p / 3 % 3), f64::from(p / 9)]).collect();
    let mut cells = CellList::new();
    for left in [0, 1] {
        let corners = [0, 1, 4, 3, 9, 10, 13, 12].map(|step| left + step);
        cells.push(ElementKind::Hexahedron, CornerOrder::Vtk, &corners).unwrap();
    }
    let below = [[3, 4, 13, 12], [4, 5, 14, 13]];
    let (front, back): (&[u32], &[u32]) = (&[3, 6, 7, 8, 5, 4], &[12, 13, 14, 17, 16, 15]);
    let (top, left, right): (&[u32], &[u32], &[u32]) = (&[6, 15, 16, 17, 8, 7], &[3, 12, 15, 6], &[5, 8, 17, 14]);
    cells.push_polyhedron([&below[0][..], &below[1][..], front, back, top, left, right]);
    let mesh = Mesh::from_cells(points, cells).unwrap();
    assert!((mesh.cell_volume(2) - 2.0).abs() < 1e-14);
    for (from, way) in [(0.4, 0.8), (1.2, -0.8)] {
        let shares = shares(&mesh, [1.0, from, 0.5], [0.0, way, 0.0]);
        assert!((shares[0] - 0.75).abs() < 1e-14 && shares[1] == 0.0, "{shares:?}");
        assert!((shares[2] - 0.25).abs() < 1e-14, "{shares:?}");
    }
}

#[test]
fn forces_along_a_periodic_face_pass_the_faces_across_it_once_and_every_balance_closes() {
    let domain = Domain::new([0.0; 3], [1.0; 3], [true, true, false]).unwrap();
    let grid = Grid::new([0.0; 3], [1.0; 3], [2, 2, 1]).unwrap();
    let mesh = mesh_of_cubes(|p| p);
    for x in [0.0, 1.0, 0.25] {
        let two = Particles::new(vec![[x, 0.3, 0.3], [x, 0.7, 0.3]]).unwrap().with_uniform_radius(0.2).unwrap();
        let mut contacts = Contacts::new();
        let (force, arm, branch) = ([0.0, -5.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.4, 0.0]);
        contacts.push(2, Contact { particle: 0, partner: Partner::Particle(1), force, arm, branch }).unwrap();
        across(&grid, &two, &contacts, &domain, x);
        across(&mesh, &two, &contacts, &domain, x);
    }

    fn across<C: Faces>(cells: &C, two: &Particles, contacts: &Contacts, domain: &Domain, x: f64) {
        let traction = contact_traction(cells, two, contacts, Some(domain)).unwrap();
        // Through the faces whose normal is along ±y.
        let along_y = |face: usize| cells.face_vector(face)[1];
        let across = (0..cells.face_count()).filter(|&face| along_y(face).abs() > 0.1);
        let passed: f64 = across.map(|face| traction.forces[face][1] * along_y(face).signum()).sum();
        assert!((passed - 5.0).abs() < 1e-14, "at x = {x}: {passed}");
        assert!(traction.balance_residual < 1e-14, "at x = {x}: {}", traction.balance_residual);
        let net: f64 = traction.residuals.iter().map(|r| r[1].abs()).sum();
        assert!(net < 1e-13, "at x = {x}: {net}");
    }
}

#[test]
fn a_centre_on_a_periodic_face_hands_on_the_same_force_through_both_images_of_the_face() {
    let domain = Domain::new([0.0; 3], [1.0; 3], [true, false, false]).unwrap();
    let grid = Grid::new([0.0; 3], [1.0; 3], [2, 1, 1]).unwrap();
    // Pushed by 3 from the left and by 5 from the right.
    let positions = vec![[0.0, 0.5, 0.5], [0.2, 0.5, 0.5], [0.8, 0.5, 0.5]];
    let three = Particles::new(positions).unwrap().with_uniform_radius(0.1).unwrap();
    let mut contacts = Contacts::new();
    for (partner, f, b) in [(1, -5.0, 0.2), (2, 3.0, -0.2)] {
        let (force, arm, branch) = ([f, 0.0, 0.0], [0.5 * b, 0.0, 0.0], [b, 0.0, 0.0]);
        contacts.push(3, Contact { particle: 0, partner: Partner::Particle(partner), force, arm, branch }).unwrap();
    }
    let traction = contact_traction(&grid, &three, &contacts, Some(&domain)).unwrap();
    let [low, high] = [0, 2].map(|i| traction.forces[grid.face_at(0, [i, 0, 0])]);
    assert_eq!(low, high);
    assert!(traction.balance_residual < 1e-15, "{}", traction.balance_residual);
}
