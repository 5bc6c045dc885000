//! What crosses faces closes the balance of every cell.
#![allow(clippy::unwrap_used)]

mod support;

use fieldstone_fields::{FieldsError, contact_traction, solid_flux};
use fieldstone_geometry::{Ball, CornerOrder, Orientation, Polyhedron, overlap};
use fieldstone_mesh::{Cells, Faces, Grid, Mesh};
use fieldstone_particles::{Domain, Particles};
use support::Case;

fn grid_of(case: &Case, cells: [usize; 3]) -> Grid {
    Grid::new(case.domain.low(), case.domain.high(), cells).unwrap()
}

#[test]
fn contact_tractions_close_the_momentum_balance_of_every_cell() {
    for case in support::cases() {
        for cells in [[1; 3], [7, 9, 11], [40, 40, 60]] {
            let grid = grid_of(&case, cells);
            let traction = contact_traction(&grid, &case.particles, &case.contacts, Some(&case.domain)).unwrap();
            println!("| {} | {cells:?} | momentum | {:.1e} |", case.name, traction.balance_residual);
            assert!(traction.balance_residual < 1e-12, "{} {cells:?}", case.name);
            // Something does cross.
            assert!(traction.forces.iter().flatten().any(|f| *f != 0.0));
        }
    }
}

#[test]
fn solid_fluxes_are_the_rate_at_which_the_overlap_of_each_cell_grows() {
    for case in support::cases() {
        let grid = grid_of(&case, [7, 9, 11]);
        let flux = solid_flux(&grid, &case.particles, Some(&case.domain)).unwrap();
        // The gradient of the overlap with each cell as a polyhedron of its own.
        let velocity = &case.particles.quantity("velocity").unwrap().data;
        let mut rates = vec![0.0; grid.cell_count()];
        let mut scale = vec![0.0; grid.cell_count()];
        for (i, &at) in case.particles.positions().iter().enumerate() {
            let r = case.particles.radii().unwrap()[i];
            for centre in case.domain.images(at, r) {
                let ball = Ball::new(centre, r).unwrap();
                grid.for_each_candidate(centre.map(|x| x - r), centre.map(|x| x + r), &mut |cell| {
                    let (low, high) = grid.cell_bounds(cell as usize);
                    let overlap = overlap(&ball, &Polyhedron::cuboid(low, high).unwrap());
                    for k in 0..3 {
                        rates[cell as usize] += overlap.gradient[k] * velocity[3 * i + k];
                        scale[cell as usize] += r * r * velocity[3 * i + k].abs();
                    }
                });
            }
        }
        let worst = (0..grid.cell_count())
            .map(|c| (flux.rates[c] - rates[c]).abs() / scale[c].max(f64::MIN_POSITIVE))
            .fold(0.0, f64::max);
        println!("| {} | mass | {worst:.1e} |", case.name);
        assert!(worst < 1e-12, "{}: {worst:e}", case.name);
    }
}

fn gmfoam() -> Option<Mesh> {
    let folder = fieldstone_testing::extended("openfoam/gmfoam")?;
    Some(fieldstone_io::read_mesh(&folder).unwrap())
}

#[test]
fn both_balances_hold_on_an_unstructured_mesh() {
    let (Some(mesh), Some(case)) = (gmfoam(), support::packed_cylinder()) else { return };
    let traction = contact_traction(&mesh, &case.particles, &case.contacts, None).unwrap();
    println!("| packed-cylinder on gmfoam | momentum | {:.1e} |", traction.balance_residual);
    assert!(traction.balance_residual < 1e-12);
    let flux = solid_flux(&mesh, &case.particles, None).unwrap();
    // Against the gradients of the overlaps with each cell's own parts.
    let velocity = &case.particles.quantity("velocity").unwrap().data;
    let parts: Vec<Vec<(f64, Polyhedron)>> = (0..mesh.cell_count())
        .map(|cell| {
            let mut parts = Vec::new();
            mesh.for_each_element(cell, &mut |sign, kind, corners| {
                let element = Polyhedron::element(kind, CornerOrder::Cgns, corners, Orientation::Fix);
                parts.extend(element.ok().map(|element| (sign, element)));
            });
            parts
        })
        .collect();
    let (mut rates, mut scale) = (vec![0.0; mesh.cell_count()], vec![0.0; mesh.cell_count()]);
    for (i, &at) in case.particles.positions().iter().enumerate() {
        let r = case.particles.radii().unwrap()[i];
        let ball = Ball::new(at, r).unwrap();
        mesh.for_each_candidate(at.map(|x| x - r), at.map(|x| x + r), &mut |cell| {
            for (sign, part) in &parts[cell as usize] {
                let gradient = overlap(&ball, part).gradient;
                for k in 0..3 {
                    rates[cell as usize] += sign * gradient[k] * velocity[3 * i + k];
                    scale[cell as usize] += r * r * velocity[3 * i + k].abs();
                }
            }
        });
    }
    let worst = (0..mesh.cell_count())
        .map(|c| (flux.rates[c] - rates[c]).abs() / scale[c].max(f64::MIN_POSITIVE))
        .fold(0.0, f64::max);
    println!("| packed-cylinder on gmfoam | mass | {worst:.1e} |");
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
fn a_periodic_box_much_smaller_than_the_cells_is_refused_at_faces_too() {
    let domain = Domain::new([0.0; 3], [1e-3; 3], [true; 3]).unwrap();
    let grid = Grid::new([0.0; 3], [1.0; 3], [1; 3]).unwrap();
    let velocity = fieldstone_particles::Quantity { name: "velocity".into(), components: 3, data: vec![1.0; 6] };
    let two = Particles::new(vec![[2e-4; 3], [4e-4, 2e-4, 2e-4]]).unwrap().with_quantity(velocity).unwrap();
    let mut contacts = fieldstone_particles::Contacts::new();
    let partner = fieldstone_particles::Partner::Particle(1);
    let (arm, branch) = ([1e-4, 0.0, 0.0], [2e-4, 0.0, 0.0]);
    contacts
        .push(2, fieldstone_particles::Contact { particle: 0, partner, force: [-1.0, 0.0, 0.0], arm, branch })
        .unwrap();
    let error = contact_traction(&grid, &two, &contacts, Some(&domain)).unwrap_err();
    assert!(matches!(error, FieldsError::BoxCopies { .. }), "{error}");
    let balls = two.clone().with_uniform_radius(1e-4).unwrap();
    let error = solid_flux(&grid, &balls, Some(&domain)).unwrap_err();
    assert!(matches!(error, FieldsError::BoxCopies { .. }), "{error}");
    let giants = two.with_uniform_radius(2.0).unwrap();
    let error = solid_flux(&grid, &giants, Some(&domain)).unwrap_err();
    assert!(matches!(error, FieldsError::RadiusBox { particle: 0, .. }), "{error}");
}

#[test]
fn a_velocity_that_is_not_finite_is_named_and_does_not_become_a_flux() {
    let grid = Grid::new([0.0; 3], [1.0; 3], [2; 3]).unwrap();
    let data = vec![1.0, 0.0, 0.0, 0.0, f64::NAN, 0.0];
    let velocity = fieldstone_particles::Quantity { name: "velocity".into(), components: 3, data };
    let two = Particles::new(vec![[0.3; 3], [0.7; 3]]).unwrap().with_uniform_radius(0.1).unwrap();
    let message = solid_flux(&grid, &two.with_quantity(velocity).unwrap(), None).unwrap_err().to_string();
    assert!(message.contains("particle 1 has velocity = NaN"), "{message}");
}

#[test]
fn a_lattice_with_its_centres_on_faces_is_balanced_as_well() {
    // Spacing 0.1, which no binary fraction is; cells of the same size, planes through all centres.
    let n = 6;
    let at = |k: usize| 0.1 * k as f64;
    let positions: Vec<[f64; 3]> = (0..n * n * n).map(|p| [p % n, p / n % n, p / (n * n)].map(at)).collect();
    let mut contacts = fieldstone_particles::Contacts::new();
    for p in 0..n * n * n {
        for (axis, step) in [1, n, n * n].into_iter().enumerate() {
            if p / step % n + 1 < n {
                let branch: [f64; 3] = std::array::from_fn(|k| positions[p + step][k] - positions[p][k]);
                let force = [0.3 + axis as f64, (p as f64).sin(), (p as f64).cos()];
                let partner = fieldstone_particles::Partner::Particle((p + step) as u32);
                let arm = branch.map(|b| 0.5 * b);
                let contact = fieldstone_particles::Contact { particle: p as u32, partner, force, arm, branch };
                contacts.push(positions.len(), contact).unwrap();
            }
        }
    }
    let particles = Particles::new(positions).unwrap();
    for high in [at(n), 0.55] {
        let grid = Grid::new([0.0; 3], [high; 3], [n; 3]).unwrap();
        let traction = contact_traction(&grid, &particles, &contacts, None).unwrap();
        assert!(traction.balance_residual < 1e-14, "{}", traction.balance_residual);
    }
}

#[test]
fn a_wall_pushes_through_the_boundary_of_the_cells_and_periodic_faces_carry_what_leaves() {
    let domain = Domain::new([0.0; 3], [2.0, 1.0, 1.0], [true, false, false]).unwrap();
    let grid = Grid::new([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1]).unwrap();
    let particles = Particles::new(vec![[0.5; 3], [1.5, 0.5, 0.5]]).unwrap();
    let mut contacts = fieldstone_particles::Contacts::new();
    let through = fieldstone_particles::Contact {
        particle: 1,
        partner: fieldstone_particles::Partner::Particle(0),
        force: [-3.0, 0.0, 0.0],
        arm: [0.5, 0.0, 0.0],
        branch: [1.0, 0.0, 0.0],
    };
    contacts.push(2, through).unwrap();
    let arm = [0.0, 0.0, -0.51];
    let wall = fieldstone_particles::Contact {
        particle: 0,
        partner: fieldstone_particles::Partner::Wall(0),
        force: [0.0, 0.0, 4.0],
        arm,
        branch: arm,
    };
    contacts.push(2, wall).unwrap();
    let traction = contact_traction(&grid, &particles, &contacts, Some(&domain)).unwrap();
    for end in [0, 2] {
        assert_eq!(traction.forces[grid.face_at(0, [end, 0, 0])], [3.0, 0.0, 0.0]);
    }
    assert_eq!(traction.forces[grid.face_at(2, [0, 0, 0])], [0.0, 0.0, 4.0]);
    assert_eq!(traction.balance_residual, 0.0);
    assert_eq!(grid.face_sides(grid.face_at(2, [0, 0, 0])), [None, Some(0)]);
}
