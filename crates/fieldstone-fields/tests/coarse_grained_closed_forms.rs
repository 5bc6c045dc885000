//! Every field against what is known of it.
#![allow(clippy::unwrap_used)]

use std::f64::consts::PI;

use fieldstone_fields::{
    CoarseGraining, CoarseGrainingOptions, ContactForm, FieldName, Fields, FieldsError, Function, Kernel, KernelShape,
    MeanVelocity, Method, QuantityKind, Selection, SignConvention, UserQuantity, displacements, gaussian_time_weights,
};
use fieldstone_mesh::{Cells, Grid};
use fieldstone_particles::{Contact, Contacts, Domain, Particles, Partner, Quantity};

const EXACT: Function = Function::Overlap(Method::Kernel);
const DENSITY: f64 = 2.5;

fn vectors(name: &str, data: &[[f64; 3]]) -> Quantity {
    Quantity { name: name.into(), components: 3, data: data.iter().flatten().copied().collect() }
}

/// Two balls of radius 1/2 and 1 that touch at (1, 1, 1) and move and spin, in a box of 4 × 2 × 2.
fn two() -> Particles {
    Particles::new(vec![[0.5, 1.0, 1.0], [2.0, 1.0, 1.0]])
        .unwrap()
        .with_radii(vec![0.5, 1.0])
        .unwrap()
        .with_types(vec![1, 2])
        .unwrap()
        .with_quantity(vectors("velocity", &[[1.0, 2.0, -1.0], [-0.5, 0.25, 3.0]]))
        .unwrap()
        .with_quantity(vectors("angular_velocity", &[[0.0, 0.0, 2.0], [1.0, -1.0, 0.5]]))
        .unwrap()
}

const FORCE: [f64; 3] = [-3.0, 0.5, 0.25];
const WALL: [f64; 3] = [0.0, 0.5, 7.0];

/// The contact of the two, and the floor under the second.
fn touching() -> Contacts {
    let mut contacts = Contacts::new();
    let (arm, branch) = ([0.5, 0.0, 0.0], [1.5, 0.0, 0.0]);
    contacts.push(2, Contact { particle: 0, partner: Partner::Particle(1), force: FORCE, arm, branch }).unwrap();
    let arm = [0.0, 0.0, -1.0];
    contacts.push(2, Contact { particle: 1, partner: Partner::Wall(0), force: WALL, arm, branch: arm }).unwrap();
    contacts
}

fn whole() -> Grid {
    Grid::new([0.0; 3], [4.0, 2.0, 2.0], [1; 3]).unwrap()
}

fn all(function: Function) -> CoarseGrainingOptions {
    CoarseGrainingOptions {
        function,
        fields: FieldName::parse_list("all").unwrap(),
        particle_density: Some(DENSITY),
        ..CoarseGrainingOptions::default()
    }
}

/// What needs no spins.
fn some(function: Function) -> CoarseGrainingOptions {
    let fields = FieldName::parse_list("standard,velocity,granular_temperature").unwrap();
    CoarseGrainingOptions { fields, ..all(function) }
}

fn run<C: Cells>(cells: &C, options: CoarseGrainingOptions, particles: &Particles, contacts: &Contacts) -> Fields {
    let mut grains = CoarseGraining::new(cells, options).unwrap();
    grains.accumulate(particles, Some(contacts), 1.0).unwrap();
    grains.finish().unwrap()
}

fn assert_field(fields: &Fields, name: &str, cell: usize, expected: &[f64]) {
    let found = fields.get(name).unwrap().cell(cell);
    assert_eq!(found.len(), expected.len(), "{name}");
    let scale = expected.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 2e-14 * scale, "{name}: {found:?}, not {expected:?}");
    }
}

fn outer(a: [f64; 3], b: [f64; 3]) -> [f64; 9] {
    std::array::from_fn(|k| a[k / 3] * b[k % 3])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

const VOLUMES: [f64; 2] = [PI / 6.0, 4.0 * PI / 3.0];
const V: [[f64; 3]; 2] = [[1.0, 2.0, -1.0], [-0.5, 0.25, 3.0]];

#[test]
fn fields_of_one_cell_around_all_are_the_sums_over_its_volume() {
    for form in [ContactForm::ParticleCentred, ContactForm::BranchInCell] {
        let options = CoarseGrainingOptions { contact_form: Some(form), ..all(EXACT) };
        let fields = run(&whole(), options, &two(), &touching());
        let over = |sums: &[f64]| sums.iter().map(|s| s / 16.0).collect::<Vec<_>>();
        let m = VOLUMES.map(|v| DENSITY * v);
        let sum = |f: &dyn Fn(usize) -> Vec<f64>| -> Vec<f64> {
            f(0).iter().zip(f(1)).map(|(a, b)| (a + b) / 16.0).collect()
        };
        let flux = |i: usize| {
            let v = V[i];
            [v[0] * v[0], v[0] * v[1], v[0] * v[2], v[1] * v[1], v[1] * v[2], v[2] * v[2]].map(|x| m[i] * x).to_vec()
        };
        assert_field(&fields, "volume_fraction", 0, &over(&[VOLUMES[0] + VOLUMES[1]]));
        let rho = (m[0] + m[1]) / 16.0;
        assert_field(&fields, "density", 0, &[rho]);
        let j = sum(&|i| V[i].map(|v| m[i] * v).to_vec());
        assert_field(&fields, "momentum", 0, &j);
        let k = sum(&flux);
        assert_field(&fields, "momentum_flux", 0, &k);
        let u: Vec<f64> = j.iter().map(|j| j / rho).collect();
        assert_field(&fields, "velocity", 0, &u);
        let uu = [u[0] * u[0], u[0] * u[1], u[0] * u[2], u[1] * u[1], u[1] * u[2], u[2] * u[2]];
        let kinetic: Vec<f64> = (0..6).map(|n| k[n] - rho * uu[n]).collect();
        assert_field(&fields, "kinetic_stress", 0, &kinetic);
        let trace = kinetic[0] + kinetic[3] + kinetic[5];
        assert_field(&fields, "granular_temperature", 0, &[trace / (3.0 * rho)]);
        // Compression positive: minus f ⊗ branch, f ⊗ arm at the wall.
        let (a, b) = (outer(FORCE, [1.5, 0.0, 0.0]), outer(WALL, [0.0, 0.0, -1.0]));
        let stress: Vec<f64> = (0..9).map(|n| -(a[n] + b[n]) / 16.0).collect();
        assert_field(&fields, "contact_stress", 0, &stress);
        let full = [0, 1, 2, 1, 3, 4, 2, 4, 5].map(|n: usize| kinetic[n]);
        let total: Vec<f64> = (0..9).map(|n| stress[n] + full[n]).collect();
        assert_field(&fields, "total_stress", 0, &total);
        assert_field(&fields, "pressure", 0, &[(total[0] + total[4] + total[8]) / 3.0]);
        assert_field(&fields, "boundary_force_density", 0, &over(&WALL));
        assert_field(&fields, "contact_force_density", 0, &over(&WALL));
        let size: Vec<f64> = (0..6).map(|k| (0.5f64.powi(k) + 1.0) / 16.0).collect();
        assert_field(&fields, "particle_size", 0, &size);
        assert_field(&fields, "mean_radius", 0, &[0.75]);
        assert_field(&fields, "coordination_number", 0, &[1.5]);
        let energy: Vec<f64> = (0..2).map(|i| 0.5 * m[i] * dot(V[i], V[i])).collect();
        assert_field(&fields, "kinetic_energy_density", 0, &[(energy[0] + energy[1]) / 16.0]);
        assert_field(&fields, "kinetic_energy_flux", 0, &sum(&|i| V[i].map(|v| energy[i] * v).to_vec()));
        // Each contact counts with both its particles' volumes, the wall's with one.
        let fabric = [VOLUMES[0] + VOLUMES[1], 0.0, 0.0, 0.0, 0.0, VOLUMES[1]];
        assert_field(&fields, "fabric", 0, &over(&fabric));
        let inertia = [0.4 * m[0] * 0.25, 0.4 * m[1]];
        let omega = [[0.0, 0.0, 2.0], [1.0, -1.0, 0.5]];
        let spin = sum(&|i| omega[i].map(|w| inertia[i] * w).to_vec());
        assert_field(&fields, "spin_density", 0, &spin);
        let inertias = (inertia[0] + inertia[1]) / 16.0;
        assert_field(&fields, "angular_velocity", 0, &spin.iter().map(|s| s / inertias).collect::<Vec<_>>());
        let centres = [[0.5, 1.0, 1.0], [2.0, 1.0, 1.0]];
        let orbital = sum(&|i| cross(centres[i], V[i]).map(|l| m[i] * l).to_vec());
        assert_field(&fields, "angular_momentum", 0, &(0..3).map(|k| orbital[k] + spin[k]).collect::<Vec<_>>());
        // Energy and torque go along the branch in one form, along each arm in the other.
        let (wall_arm, wall_power) = ([0.0, 0.0, -1.0], dot(WALL, V[1]));
        let wall_torque = outer(cross(wall_arm, WALL), wall_arm);
        let (arms, minus) = ([[0.5, 0.0, 0.0], [-1.0, 0.0, 0.0]], FORCE.map(|f| -f));
        let forces = [FORCE, minus];
        let (energy, couple): ([f64; 3], [f64; 9]) = if form == ContactForm::ParticleCentred {
            let couples = [0, 1].map(|i| outer(cross(arms[i], forces[i]), arms[i]));
            (
                std::array::from_fn(|k| -(0..2).map(|i| dot(forces[i], V[i]) * arms[i][k]).sum::<f64>()),
                std::array::from_fn(|n| -(couples[0][n] + couples[1][n])),
            )
        } else {
            let branch = [1.5, 0.0, 0.0];
            let power = 0.5 * (dot(FORCE, V[0]) + dot(FORCE, V[1]));
            let torques = [0, 1].map(|i| cross(arms[i], forces[i]));
            let half = std::array::from_fn(|k| 0.5 * (torques[0][k] - torques[1][k]));
            (branch.map(|b| -power * b), outer(half, branch).map(|x| -x))
        };
        let energy: Vec<f64> = (0..3).map(|k| (energy[k] - wall_power * wall_arm[k]) / 16.0).collect();
        assert_field(&fields, "contact_energy_flux", 0, &energy);
        let couple: Vec<f64> = (0..9).map(|n| (couple[n] - wall_torque[n]) / 16.0).collect();
        assert_field(&fields, "couple_stress", 0, &couple);
    }
}

#[test]
fn the_other_sign_of_stress_is_the_negative_of_all_three_stresses_and_the_pressure() {
    let compression = run(&whole(), all(EXACT), &two(), &touching());
    let options = CoarseGrainingOptions { sign: SignConvention::TensionPositive, ..all(EXACT) };
    let tension = run(&whole(), options, &two(), &touching());
    for name in ["contact_stress", "kinetic_stress", "total_stress", "pressure", "couple_stress"] {
        let expected: Vec<f64> = compression.get(name).unwrap().data.iter().map(|s| -s).collect();
        assert_field(&tension, name, 0, &expected);
    }
    assert_eq!(tension.get("density"), compression.get("density"));
}

#[test]
fn walls_can_be_left_out_of_the_contact_force_density() {
    let options = CoarseGrainingOptions { walls_in_contact_force: false, ..all(EXACT) };
    assert_field(&run(&whole(), options, &two(), &touching()), "contact_force_density", 0, &[0.0; 3]);
}

#[test]
fn a_branch_is_shared_among_cells_by_its_length_in_each() {
    // Planes at x = 1 and 2: the branch from 0.5 to 2 has a third in the first cell, the rest in the second.
    let grid = Grid::new([0.0; 3], [4.0, 2.0, 2.0], [4, 1, 1]).unwrap();
    let options = CoarseGrainingOptions { contact_form: Some(ContactForm::BranchInCell), ..all(EXACT) };
    let fields = run(&grid, options, &two(), &touching());
    let stress = fields.get("contact_stress").unwrap();
    for (cell, share) in [(0, 1.0 / 3.0), (1, 2.0 / 3.0), (3, 0.0)] {
        assert!((stress.cell(cell)[0] - 4.5 * share / 4.0).abs() < 1e-15, "{cell}");
    }
    // The wall's contact point lies on a corner of cells 1 and 2 and belongs to the upper one, as points do.
    assert_eq!(fields.get("boundary_force_density").unwrap().cell(2)[2], 7.0 / 4.0);
}

#[test]
fn kernels_at_a_centre_and_along_a_branch_have_their_closed_forms() {
    let lucy = Kernel::new(KernelShape::Lucy, 1.0, None).unwrap();
    let one = Particles::new(vec![[0.0; 3], [1.0, 0.0, 0.0]])
        .unwrap()
        .with_uniform_radius(0.5)
        .unwrap()
        .with_quantity(vectors("velocity", &[[0.0; 3]; 2]))
        .unwrap();
    let mut contacts = Contacts::new();
    let (arm, branch) = ([0.5, 0.0, 0.0], [1.0, 0.0, 0.0]);
    contacts
        .push(2, Contact { particle: 0, partner: Partner::Particle(1), force: [-1.0, 0.0, 0.0], arm, branch })
        .unwrap();
    let at = |x: f64| Grid::new([x - 0.1, -0.1, -0.1], [x + 0.1, 0.1, 0.1], [1; 3]).unwrap();
    let top = 105.0 / (16.0 * PI);
    let fields = run(&at(0.0), some(Function::Kernel(lucy)), &one, &contacts);
    assert_field(&fields, "volume_fraction", 0, &[PI / 6.0 * top]);
    // ∫₀¹ 1 − 6s² + 8s³ − 3s⁴ ds = 2/5.
    assert!((fields.get("contact_stress").unwrap().cell(0)[0] - 0.4 * top).abs() < 1e-15);
    // Half way, 2 ∫₀^½: 2 (1/2 − 1/4 + 1/8 − 3/160).
    let fields = run(&at(0.5), some(Function::Kernel(lucy)), &one, &contacts);
    assert!((fields.get("contact_stress").unwrap().cell(0)[0] - 0.7125 * top).abs() < 1e-14);
}

#[test]
fn a_kernel_is_integrated_over_averaged_directions() {
    let gauss = Kernel::new(KernelShape::Gauss, 0.4, None).unwrap();
    let fine = Grid::new([-2.0, -3.0, -3.0], [6.0, 5.0, 5.0], [8, 80, 80]).unwrap();
    let coarse = Grid::resolving([-2.0, -3.0, -3.0], [6.0, 5.0, 5.0], [8; 3], "X".parse().unwrap()).unwrap();
    let resolved = run(&fine, all(Function::Kernel(gauss)), &two(), &touching());
    let averaged = run(&coarse, all(Function::Kernel(gauss)), &two(), &touching());
    assert_eq!(coarse.cell_count(), 8);
    // A Gaussian cut off in three dimensions is not one cut off in one: some 1e-2 of its tails apart.
    for name in ["density", "contact_stress", "boundary_force_density"] {
        let (a, b) = (averaged.get(name).unwrap(), resolved.get(name).unwrap());
        let n = a.components.len();
        let largest = a.data.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for i in 0..8 {
            for k in 0..n {
                let mean = (0..6400).map(|row| b.cell(i + 8 * row)[k]).sum::<f64>() / 6400.0;
                assert!((a.cell(i)[k] - mean).abs() < 0.02 * largest, "{name} {i} {k}: {} {mean}", a.cell(i)[k]);
            }
        }
    }
}

#[test]
fn a_particle_between_all_samples_goes_to_the_cell_of_its_centre_through_any_periodic_face() {
    let domain = Domain::new([0.0; 3], [10.0; 3], [true; 3]).unwrap();
    let grid = Grid::new([0.0; 3], [10.0; 3], [5; 3]).unwrap();
    // Samples are 2 apart, and the kernel ends before the nearest one.
    let lucy = Function::Kernel(Kernel::new(KernelShape::Lucy, 0.2, None).unwrap());
    let fields = FieldName::parse_list("density,angular_momentum").unwrap();
    let options = CoarseGrainingOptions { fields, domain: Some(domain), conserve: true, ..all(lucy) };
    let near_faces = [5.2, 9.95, 0.05, 10.0, 0.0, 10.05, -0.05];
    let mut centres: Vec<[f64; 3]> = Vec::new();
    for axis in 0..3 {
        centres.extend(near_faces.map(|x| std::array::from_fn(|k| if k == axis { x } else { 5.2 })));
    }
    centres.extend(near_faces.map(|x| [x; 3]));
    for at in centres {
        let v = [1.0, -2.0, 0.5];
        let ball = Particles::new(vec![at]).unwrap().with_uniform_radius(0.5).unwrap();
        let ball = ball.with_quantity(vectors("velocity", &[v])).unwrap();
        let ball = ball.with_quantity(vectors("angular_velocity", &[[0.0; 3]])).unwrap();
        let found = run(&grid, options.clone(), &ball, &Contacts::new());
        let ledger = found.ledger;
        assert!((ledger.mass_binned / ledger.mass_in - 1.0).abs() < 1e-14, "{at:?}: {ledger:?}");
        assert_eq!(ledger.mass_clipped, 0.0, "{at:?}");
        let image = at.map(|x| x.rem_euclid(10.0));
        let home = (0..3).map(|k| (image[k] / 2.0) as usize * [1, 5, 25][k]).sum();
        let density = DENSITY * VOLUMES[0] / 8.0;
        assert_field(&found, "density", home, &[density]);
        // Each image counts where it is.
        assert_field(&found, "angular_momentum", home, &cross(image, v).map(|x| density * x));
    }
}

#[test]
fn species_add_up_to_the_mixture_and_their_boundary_forces_cancel_but_for_the_walls() {
    let grid = Grid::new([-1.0; 3], [5.0, 3.0, 3.0], [6, 5, 5]).unwrap();
    let lucy = Function::Kernel(Kernel::new(KernelShape::Lucy, 1.5, None).unwrap());
    for (function, form) in [(EXACT, None), (EXACT, Some(ContactForm::BranchInCell)), (lucy, None)] {
        let options = CoarseGrainingOptions { contact_form: form, ..all(function) };
        let of = |types: Option<Vec<i64>>| {
            let selection = Selection { types, ..Selection::default() };
            run(&grid, CoarseGrainingOptions { selection, ..options.clone() }, &two(), &touching())
        };
        let (one, other, both) = (of(Some(vec![1])), of(Some(vec![2])), of(None));
        for name in [
            "density",
            "momentum",
            "momentum_flux",
            "contact_stress",
            "boundary_force_density",
            "contact_force_density",
        ] {
            let (a, b, sum) = (one.get(name).unwrap(), other.get(name).unwrap(), both.get(name).unwrap());
            let largest = sum.data.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            // Forces at the centres of the particles cancel in sum, not cell by cell.
            if name == "boundary_force_density" && one.contact_form == ContactForm::ParticleCentred {
                for k in 0..3 {
                    let total = |f: &[f64]| f.iter().skip(k).step_by(3).sum::<f64>();
                    assert!((total(&a.data) + total(&b.data) - total(&sum.data)).abs() < 1e-12 * largest);
                }
                continue;
            }
            for k in 0..sum.data.len() {
                assert!((a.data[k] + b.data[k] - sum.data[k]).abs() < 1e-13 * largest, "{name} {k} {function:?}");
            }
        }
        // Each of them has a boundary: the other.
        assert!(one.get("boundary_force_density").unwrap().data.iter().any(|f| *f != 0.0));
        assert_eq!((one.ledger.contacts, other.ledger.contacts, both.ledger.contacts), (1, 2, 2));
    }
}

#[test]
fn a_spinning_ball_cut_in_half_carries_momentum_in_its_halves() {
    // About z, ω = 2: the half at x > 0 moves with +y. ∫ x dV of half a ball is π r⁴/4.
    let one = Particles::new(vec![[0.0; 3]])
        .unwrap()
        .with_uniform_radius(1.0)
        .unwrap()
        .with_quantity(vectors("velocity", &[[0.0, 0.0, 1.0]]))
        .unwrap()
        .with_quantity(vectors("angular_velocity", &[[0.0, 0.0, 2.0]]))
        .unwrap();
    let grid = Grid::new([-1.0; 3], [1.0; 3], [2, 1, 1]).unwrap();
    let options = CoarseGrainingOptions { fields: vec![FieldName::MomentumWithSpin], ..all(EXACT) };
    let fields = run(&grid, options, &one, &Contacts::new());
    let (volume, half) = (4.0, 2.0 * PI / 3.0);
    for (cell, sign) in [(0, -1.0), (1, 1.0)] {
        let expected = [0.0, sign * DENSITY * 2.0 * PI / 4.0 / volume, DENSITY * half / volume];
        assert_field(&fields, "momentum_with_spin", cell, &expected);
    }
    let options = CoarseGrainingOptions {
        fields: vec![FieldName::MomentumWithSpin],
        ..all(Function::Kernel(Kernel::new(KernelShape::Lucy, 1.0, None).unwrap()))
    };
    assert!(matches!(CoarseGraining::new(&grid, options), Err(FieldsError::Combination { .. })));
}

#[test]
fn an_affine_displacement_has_its_gradient_in_every_cell_also_through_a_periodic_boundary() {
    let domain = Domain::new([0.0; 3], [4.0; 3], [true, true, true]).unwrap();
    let mut seed = 3u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let at: Vec<[f64; 3]> = (0..300).map(|_| std::array::from_fn(|_| 4.0 * random())).collect();
    // A shift of all through the boundary: the nearest image is 0.3 away, not 3.7.
    let shift = [0.3, -0.2, 0.1];
    let before = Particles::new(at.clone()).unwrap().with_uniform_radius(0.3).unwrap().with_domain(domain);
    let moved = at.iter().map(|p| domain.wrap(std::array::from_fn(|k| p[k] + shift[k]))).collect();
    let after = Particles::new(moved).unwrap().with_domain(domain);
    let fields = vec![FieldName::Displacement, FieldName::DisplacementGradient, FieldName::StrainIncrement];
    let grid = Grid::new([0.0; 3], [4.0; 3], [2; 3]).unwrap();
    let options = CoarseGrainingOptions { fields: fields.clone(), domain: Some(domain), ..all(EXACT) };
    let rigid = run(&grid, options, &displacements(&before, &after).unwrap(), &Contacts::new());
    for cell in 0..8 {
        let found = rigid.get("displacement").unwrap().cell(cell);
        assert!(found.iter().zip(shift).all(|(d, s)| (d - s).abs() < 1e-13), "{found:?}");
        assert!(rigid.get("strain_increment").unwrap().cell(cell).iter().all(|e| e.abs() < 1e-12));
    }
    let g = [0.01, 0.02, -0.005, 0.0, -0.03, 0.004, 0.007, 0.0, 0.02];
    let moved = at.iter().map(|p| std::array::from_fn(|a| p[a] + (0..3).map(|b| g[3 * a + b] * p[b]).sum::<f64>()));
    let after = Particles::new(moved.collect()).unwrap();
    let before = Particles::new(at).unwrap().with_uniform_radius(0.3).unwrap();
    for function in [EXACT, Function::Kernel(Kernel::new(KernelShape::Gauss, 0.5, None).unwrap())] {
        let options = CoarseGrainingOptions { fields: fields.clone(), ..all(function) };
        let affine = run(&grid, options, &displacements(&before, &after).unwrap(), &Contacts::new());
        for cell in 0..8 {
            let found = affine.get("displacement_gradient").unwrap().cell(cell);
            for n in 0..9 {
                assert!((found[n] - g[n]).abs() < 1e-12, "{function:?} {cell} {n}: {}", found[n]);
            }
            let strain = affine.get("strain_increment").unwrap().cell(cell);
            assert!((strain[1] - 0.5 * (g[1] + g[3])).abs() < 1e-12 && (strain[5] - g[8]).abs() < 1e-12);
        }
    }
}

#[test]
fn only_linear_sums_are_averaged_over_frames() {
    // One ball that goes up in the first frame and down in the second: no mean velocity, but a temperature.
    let frame = |v: f64| {
        Particles::new(vec![[0.5; 3]])
            .unwrap()
            .with_uniform_radius(0.5)
            .unwrap()
            .with_quantity(vectors("velocity", &[[0.0, 0.0, v]]))
            .unwrap()
    };
    let grid = Grid::new([0.0; 3], [1.0; 3], [1; 3]).unwrap();
    let average = |mean_velocity| {
        let mut grains = CoarseGraining::new(&grid, CoarseGrainingOptions { mean_velocity, ..some(EXACT) }).unwrap();
        grains.accumulate(&frame(2.0), Some(&Contacts::new()), 3.0).unwrap();
        grains.accumulate(&frame(-2.0), Some(&Contacts::new()), 1.0).unwrap();
        grains.finish().unwrap()
    };
    let window = average(MeanVelocity::Window);
    assert_field(&window, "velocity", 0, &[0.0, 0.0, 1.0]);
    // ⟨v²⟩ − ⟨v⟩² = 4 − 1, a third of it.
    assert_field(&window, "granular_temperature", 0, &[1.0]);
    assert_field(&window, "volume_fraction", 0, &[PI / 6.0]);
    assert_eq!(window.ledger.frames, 2);
    assert!((window.ledger.mass_in - DENSITY * PI / 6.0).abs() < 1e-15);
    // About each frame's own mean nothing fluctuates.
    let by_frame = average(MeanVelocity::Frame);
    assert_field(&by_frame, "granular_temperature", 0, &[0.0]);
    assert_field(&by_frame, "velocity", 0, &[0.0, 0.0, 1.0]);
    let none = CoarseGraining::new(&grid, some(EXACT)).unwrap().finish();
    assert_eq!(none.unwrap_err(), FieldsError::NoFrames);
}

#[test]
fn a_gaussian_mean_in_time_of_a_linear_motion_is_the_middle_frame() {
    let times: Vec<f64> = (0..21).map(|k| f64::from(k) * 0.1).collect();
    let weights = gaussian_time_weights(&times, 1.0, 0.2, None).unwrap();
    let grid = Grid::new([0.0; 3], [1.0; 3], [1; 3]).unwrap();
    let mut grains = CoarseGraining::new(&grid, some(EXACT)).unwrap();
    for (t, w) in times.iter().zip(weights) {
        let frame = Particles::new(vec![[0.5; 3]])
            .unwrap()
            .with_uniform_radius(0.5)
            .unwrap()
            .with_quantity(vectors("velocity", &[[*t, 0.0, 0.0]]))
            .unwrap();
        grains.accumulate(&frame, Some(&Contacts::new()), w).unwrap();
    }
    assert_field(&grains.finish().unwrap(), "velocity", 0, &[1.0, 0.0, 0.0]);
}

#[test]
fn mass_and_momentum_of_ballistic_particles_obey_their_continuity_equations() {
    // ∂ρ/∂t + ∇·j = 0 and ∂j/∂t + ∇·k = ρ g at a point, frames closely spaced, no contacts.
    let g = [0.3, 0.0, -9.81];
    let mut seed = 11u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let (x, v): (Vec<[f64; 3]>, Vec<[f64; 3]>) =
        (0..200).map(|_| (std::array::from_fn(|_| 4.0 * random()), std::array::from_fn(|_| 2.0 * random()))).unzip();
    let frame = |t: f64| {
        let at = |i: usize| std::array::from_fn(|k| x[i][k] + t * v[i][k] + 0.5 * t * t * g[k]);
        let now: Vec<[f64; 3]> = v.iter().map(|v| std::array::from_fn(|k| v[k] + t * g[k])).collect();
        Particles::new((0..200).map(at).collect())
            .unwrap()
            .with_uniform_radius(0.2)
            .unwrap()
            .with_quantity(vectors("velocity", &now))
            .unwrap()
    };
    let kernel = Kernel::new(KernelShape::Gauss, 0.8, Some(6.4)).unwrap();
    let fields = |t: f64, at: [f64; 3]| {
        let cell = Grid::new(at.map(|x| x - 0.1), at.map(|x| x + 0.1), [1; 3]).unwrap();
        let options = CoarseGrainingOptions {
            fields: FieldName::parse_list("density,momentum,momentum_flux").unwrap(),
            ..all(Function::Kernel(kernel))
        };
        let mut grains = CoarseGraining::new(&cell, options).unwrap();
        grains.accumulate(&frame(t), None, 1.0).unwrap();
        let fields = grains.finish().unwrap();
        ["density", "momentum", "momentum_flux"]
            .iter()
            .flat_map(|n| fields.get(n).unwrap().data.clone())
            .collect::<Vec<_>>()
    };
    let (at, h) = ([0.2, -0.1, 0.3], 0.004);
    let stencil = [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];
    let here = fields(0.0, at);
    let mut mass = 0.0;
    let mut momentum: [f64; 3] = std::array::from_fn(|k| -here[0] * g[k]);
    for (offset, factor) in stencil {
        let later = fields(offset * h, at);
        mass += factor * later[0] / h;
        (0..3).for_each(|k| momentum[k] += factor * later[1 + k] / h);
        for axis in 0..3 {
            let mut there = at;
            there[axis] += offset * h;
            let f = fields(0.0, there);
            mass += factor * f[1 + axis] / h;
            let flux = [4, 5, 6, 5, 7, 8, 6, 8, 9].map(|n: usize| f[n]);
            (0..3).for_each(|k| momentum[k] += factor * flux[3 * k + axis] / h);
        }
    }
    println!("| ballistic | mass {:.1e} | momentum {:.1e} |", mass / here[0], momentum[2] / (here[0] * 9.81));
    assert!(mass.abs() < 2e-8 * here[0], "{mass:e}");
    assert!(momentum.iter().all(|m| m.abs() < 2e-8 * here[0] * 9.81), "{momentum:?}");
}

#[test]
fn any_column_becomes_a_sum_or_a_mean() {
    let particles =
        two().with_quantity(Quantity { name: "temperature".into(), components: 1, data: vec![300.0, 400.0] }).unwrap();
    let quantity =
        |name: &str, columns: &[&str], kind| UserQuantity::of_columns(name, columns, kind, &particles).unwrap();
    let options = CoarseGrainingOptions {
        fields: vec![],
        quantities: vec![
            quantity("heat", &["temperature"], QuantityKind::Sum),
            quantity("by_mass", &["temperature", "velocity[3]"], QuantityKind::MassMean),
            quantity("by_volume", &["velocity"], QuantityKind::VolumeMean),
        ],
        ..all(EXACT)
    };
    let fields = run(&whole(), options.clone(), &particles, &Contacts::new());
    assert_field(&fields, "heat", 0, &[700.0 / 16.0]);
    let mean = |a: f64, b: f64| (a + 8.0 * b) / 9.0;
    assert_field(&fields, "by_mass", 0, &[mean(300.0, 400.0), mean(-1.0, 3.0)]);
    assert_field(&fields, "by_volume", 0, &[mean(1.0, -0.5), mean(2.0, 0.25), mean(-1.0, 3.0)]);
    assert_eq!(fields.get("by_volume").unwrap().components, ["x", "y", "z"]);
    assert_eq!(fields.get("by_mass").unwrap().components, ["0", "1"]);
    let twice = CoarseGrainingOptions { fields: vec![FieldName::Density], ..options };
    let named_alike =
        CoarseGrainingOptions { quantities: vec![quantity("density", &["temperature"], QuantityKind::Sum)], ..twice };
    assert!(matches!(CoarseGraining::new(&whole(), named_alike), Err(FieldsError::DuplicateField(_))));
}

#[test]
fn what_is_missing_is_said() {
    let grid = whole();
    let refused = |options: CoarseGrainingOptions, particles: &Particles, contacts: Option<&Contacts>| {
        CoarseGraining::new(&grid, options)
            .and_then(|mut grains| grains.accumulate(particles, contacts, 1.0))
            .unwrap_err()
            .to_string()
    };
    let bare = Particles::new(vec![[1.0; 3]]).unwrap().with_uniform_radius(0.5).unwrap();
    let without_density = CoarseGrainingOptions { particle_density: None, ..all(EXACT) };
    assert!(refused(without_density.clone(), &bare, Some(&Contacts::new())).contains("'mass' nor 'density'"));
    assert!(refused(all(EXACT), &bare, Some(&Contacts::new())).contains("velocity"));
    assert!(refused(all(EXACT), &two(), None).contains("'contact_stress' needs contacts"));
    assert!(refused(all(EXACT), &bare, Some(&touching())).contains("velocity"));
    let alone = bare.clone().with_quantity(vectors("velocity", &[[0.0; 3]])).unwrap();
    assert!(refused(some(EXACT), &alone, Some(&touching())).contains("names particle 1, but there are 1"));
    assert!(refused(without_density.clone(), &bare, Some(&Contacts::new())).contains("(they have: no other columns)"));
    for (name, value, said) in [
        ("mass", -1.0, "particle 0: the column 'mass' holds -1.0"),
        ("density", 0.0, "particle 0: the column 'density' holds 0.0"),
        ("mass", f64::NAN, "particle 0 has mass = NaN"),
        ("density", f64::INFINITY, "particle 0 has density = inf"),
        ("density", 1e-320, "particle 0: the column 'density' holds 1e-320"),
    ] {
        let one = bare.clone().with_quantity(Quantity { name: name.into(), components: 1, data: vec![value] }).unwrap();
        // Its volume of 4e-9 times the smallest of the densities is 0.
        let one = one.with_uniform_radius(1e-3).unwrap();
        let message = refused(without_density.clone(), &one, Some(&Contacts::new()));
        assert!(message.contains(said), "{message}");
    }
    let line = CoarseGrainingOptions { contact_form: Some(ContactForm::LineIntegral), ..all(EXACT) };
    assert!(refused(line, &two(), None).contains("need a kernel"));
    let typed =
        CoarseGrainingOptions { selection: Selection { types: Some(vec![1]), ..Selection::default() }, ..some(EXACT) };
    assert!(refused(typed, &alone, Some(&Contacts::new())).contains("no types"));
}

#[test]
fn a_density_for_all_particles_stands_in_place_of_their_own_masses() {
    let own = |name: &str| {
        let column = Quantity { name: name.into(), components: 1, data: vec![100.0, 200.0] };
        run(&whole(), some(EXACT), &two().with_quantity(column).unwrap(), &touching())
    };
    let volumes = 4.0 / 3.0 * PI * (0.125 + 1.0);
    for name in ["mass", "density"] {
        assert_field(&own(name), "density", 0, &[DENSITY * volumes / 16.0]);
    }
}

#[test]
fn what_reaches_too_far_around_a_periodic_box_is_refused() {
    let grid = Grid::new([0.0; 3], [1.0; 3], [2; 3]).unwrap();
    let domain = Domain::new([0.0; 3], [1.0; 3], [true; 3]).unwrap();
    let one = |radius: f64| {
        let one = Particles::new(vec![[0.5; 3]]).unwrap().with_uniform_radius(radius).unwrap();
        one.with_quantity(vectors("velocity", &[[0.0; 3]])).unwrap()
    };
    let refused = |options: CoarseGrainingOptions, radius: f64, contacts: &Contacts| {
        let options = CoarseGrainingOptions { domain: Some(domain), ..options };
        CoarseGraining::new(&grid, options).unwrap().accumulate(&one(radius), Some(contacts), 1.0).unwrap_err()
    };
    let none = Contacts::new();
    let error = refused(some(EXACT), 2000.0, &none);
    assert!(matches!(error, FieldsError::RadiusBox { particle: 0, radius: 2000.0, length: 1.0 }), "{error}");
    let gauss = Function::Kernel(Kernel::new(KernelShape::Gauss, 300.0, None).unwrap());
    let error = refused(some(gauss), 0.1, &none);
    let copies = 1802f64.powi(3);
    assert!(
        matches!(error, FieldsError::BoxCopies { copies: found } if (found / copies - 1.0).abs() < 1e-12),
        "{error}"
    );
    // A branch of many periods, with either form that follows it.
    let mut far = Contacts::new();
    let branch = [1e5, 1e5, 1e5];
    let contact = Contact { particle: 0, partner: Partner::Wall(0), force: [1.0; 3], arm: branch, branch };
    far.push(1, contact).unwrap();
    let lucy = Function::Kernel(Kernel::new(KernelShape::Lucy, 0.5, None).unwrap());
    let in_cell = CoarseGrainingOptions { contact_form: Some(ContactForm::BranchInCell), ..some(EXACT) };
    for options in [in_cell, some(lucy)] {
        let error = refused(options, 0.1, &far);
        assert!(matches!(error, FieldsError::BoxCopies { .. }), "{error}");
    }
}

#[test]
fn a_ball_inside_the_cells_is_not_clipped_where_its_volume_is_averaged_over_neighbours() {
    // Cells at the boundary have fewer neighbours, so the sum over cells is not the ball's volume.
    let grid = Grid::new([0.0; 3], [4.0; 3], [4; 3]).unwrap();
    let method = Function::Overlap(Method::CentreSmoothed);
    let options = CoarseGrainingOptions { fields: vec![FieldName::Density], ..all(method) };
    let at = |x: f64| Particles::new(vec![[x, 0.5, 0.5]]).unwrap().with_uniform_radius(0.4).unwrap();
    let ledger = run(&grid, options.clone(), &at(0.5), &Contacts::new()).ledger;
    assert!((ledger.mass_binned / ledger.mass_in - 1.0).abs() > 0.05, "{ledger:?}");
    assert_eq!(ledger.mass_clipped, 0.0);
    let mut grains = CoarseGraining::new(&grid, options).unwrap();
    grains.accumulate(&at(-0.1), Some(&Contacts::new()), 1.0).unwrap();
    let ledger = grains.finish().unwrap().ledger;
    assert_eq!(ledger.mass_clipped, ledger.mass_in);
}

#[test]
fn fields_have_the_same_bits_for_any_number_of_threads() {
    let grid = Grid::new([-1.0; 3], [5.0, 3.0, 3.0], [30, 20, 20]).unwrap();
    let gauss = Function::Kernel(Kernel::new(KernelShape::Gauss, 0.4, None).unwrap());
    for function in [EXACT, gauss] {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(&grid, all(function), &two(), &touching()))
        };
        let one = with(1);
        assert_eq!(with(2), one);
        assert_eq!(with(5), one);
    }
}
