//! The identities that coarse-grained fields obey, on a small packing and, where they are there, on real ones.
#![allow(clippy::unwrap_used)]

mod support;

use fieldstone_fields::{
    CoarseGraining, CoarseGrainingOptions, ContactForm, FieldName, Fields, Function, Kernel, KernelShape, Method,
    Selection,
};
use fieldstone_mesh::{Cells, Grid};
use fieldstone_particles::{Contacts, Domain, Particles, Partner};
use support::{Case, cases};

fn periodic_cases() -> impl Iterator<Item = Case> {
    cases().into_iter().filter(|case| case.domain.periodic()[0])
}

#[test]
fn every_identity_has_a_packing_to_hold_on_whatever_files_there_are() {
    assert_eq!(cases()[0].name, "sheared-layer");
    assert_eq!(periodic_cases().next().unwrap().name, "sheared-layer");
}

fn largest_radius(case: &Case) -> f64 {
    case.particles.radii().unwrap().iter().copied().fold(0.0, f64::max)
}

/// A grid around everything that is not periodic, with margin for what sticks out.
fn grid_around(case: &Case, cells: [usize; 3], margin: f64) -> Grid {
    let periodic = case.domain.periodic();
    let (low, high) = (case.domain.low(), case.domain.high());
    let pad = |k: usize| if periodic[k] { 0.0 } else { margin };
    Grid::new(std::array::from_fn(|k| low[k] - pad(k)), std::array::from_fn(|k| high[k] + pad(k)), cells).unwrap()
}

fn options(case: &Case, function: Function) -> CoarseGrainingOptions {
    CoarseGrainingOptions {
        function,
        fields: FieldName::parse_list("all").unwrap(),
        domain: Some(case.domain),
        particle_density: case.density,
        ..CoarseGrainingOptions::default()
    }
}

fn run<C: Cells>(cells: &C, options: CoarseGrainingOptions, particles: &Particles, contacts: &Contacts) -> Fields {
    let mut grains = CoarseGraining::new(cells, options).unwrap();
    grains.accumulate(particles, Some(contacts), 1.0).unwrap();
    grains.finish().unwrap()
}

fn integral<C: Cells>(cells: &C, fields: &Fields, name: &str) -> Vec<f64> {
    let field = fields.get(name).unwrap();
    let mut sum = vec![0.0; field.components.len()];
    for c in 0..cells.cell_count() {
        field.cell(c).iter().zip(&mut sum).for_each(|(x, s)| *s += x * cells.cell_volume(c));
    }
    sum
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn size(a: &[f64]) -> f64 {
    a.iter().map(|x| x.abs()).fold(0.0, f64::max)
}

fn gauss(width: f64) -> Function {
    Function::Kernel(Kernel::new(KernelShape::Gauss, width, None).unwrap())
}

fn lucy(width: f64) -> Function {
    Function::Kernel(Kernel::new(KernelShape::Lucy, width, None).unwrap())
}

#[test]
fn exact_weights_conserve_volume_mass_momentum_force_and_stress() {
    for case in cases() {
        let grid = grid_around(&case, [11, 9, 13], 2.5 * largest_radius(&case));
        for form in [ContactForm::ParticleCentred, ContactForm::BranchInCell] {
            let mut options = options(&case, Function::Overlap(Method::Kernel));
            options.contact_form = Some(form);
            let fields = run(&grid, options, &case.particles, &case.contacts);
            let ledger = fields.ledger;
            let volume: f64 =
                case.particles.radii().unwrap().iter().map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3)).sum();
            let nu = integral(&grid, &fields, "volume_fraction")[0] / volume - 1.0;
            let mass = ledger.mass_binned / ledger.mass_in - 1.0;
            let momentum = apart(&ledger.momentum_binned, &ledger.momentum_in) / size(&ledger.momentum_in);
            let stress =
                apart(&ledger.stress_sum_fields, &ledger.stress_sum_contacts) / size(&ledger.stress_sum_contacts);
            let walls: Vec<_> = case.contacts.iter().filter(|c| matches!(c.partner, Partner::Wall(_))).collect();
            let total: Vec<f64> = (0..3).map(|k| walls.iter().map(|c| c.force[k]).sum()).collect();
            let boundary = apart(&integral(&grid, &fields, "boundary_force_density"), &total) / size(&total);
            let contact = apart(&integral(&grid, &fields, "contact_force_density"), &total) / size(&total);
            println!(
                "| {} | {form:?} | {nu:.1e} | {mass:.1e} | {momentum:.1e} | {stress:.1e} | {boundary:.1e} | {contact:.1e} |",
                case.name
            );
            assert_eq!(ledger.mass_clipped, 0.0);
            for error in [nu, mass, momentum, stress, boundary, contact] {
                assert!(error.abs() < 1e-12, "{} {form:?}: {error:e}", case.name);
            }
        }
    }
}

#[test]
fn what_walls_clip_is_in_the_ledger() {
    for case in [Some(support::sheared_layer()), support::mercury_box()].into_iter().flatten() {
        // Only the lower half of the box.
        let [x, y, z] = case.domain.high();
        let grid = Grid::new([0.0; 3], [x, y, 0.4 * z], [5, 6, 4]).unwrap();
        let fields = run(&grid, options(&case, Function::Overlap(Method::Kernel)), &case.particles, &case.contacts);
        let l = fields.ledger;
        assert!(l.mass_clipped > 0.2 * l.mass_in, "{}", case.name);
        assert!((l.mass_in - l.mass_binned - l.mass_clipped).abs() < 1e-12 * l.mass_in, "{}: {l:?}", case.name);
    }
}

#[test]
fn two_species_add_up_to_the_mixture() {
    for case in cases() {
        let n = case.particles.len();
        // Every third particle is of the second species.
        let types = (0..n as i64).map(|i| 1 + i64::from(i % 3 == 0)).collect();
        let particles = case.particles.clone().with_types(types).unwrap();
        let r = largest_radius(&case);
        let grid = grid_around(&case, [6, 7, 8], 2.5 * r);
        for (name, function, form) in [
            ("exact", Function::Overlap(Method::Kernel), ContactForm::ParticleCentred),
            ("exact, branch in cell", Function::Overlap(Method::Kernel), ContactForm::BranchInCell),
            ("lucy", lucy(2.0 * r), ContactForm::LineIntegral),
        ] {
            let of = |types: Option<Vec<i64>>| {
                let mut options = options(&case, function);
                options.contact_form = Some(form);
                options.selection = Selection { types, ..Selection::default() };
                options.fields = FieldName::parse_list("standard,contact_force_density").unwrap();
                run(&grid, options, &particles, &case.contacts)
            };
            let (one, other, both) = (of(Some(vec![1])), of(Some(vec![2])), of(None));
            let (mut linear, mut stress, mut boundary) = (0.0f64, 0.0f64, 0.0f64);
            for (k, field) in both.fields.iter().enumerate() {
                let sum: Vec<f64> = one.fields[k].data.iter().zip(&other.fields[k].data).map(|(a, b)| a + b).collect();
                let error = apart(&sum, &field.data) / size(&field.data);
                match field.name.as_str() {
                    "contact_stress" => stress = stress.max(error),
                    "boundary_force_density" => boundary = boundary.max(error),
                    _ => linear = linear.max(error),
                }
            }
            println!("| {} | {name} | {linear:.1e} | {stress:.1e} | {boundary:.1e} |", case.name);
            assert!(linear < 1e-12, "{} {name}: {linear:e}", case.name);
            // Along two arms instead of one branch: the same line as far as the dump's digits tell.
            let digits = if form == ContactForm::ParticleCentred { 1e-12 } else { 1e-6 };
            assert!(stress < digits, "{} {name}: {stress:e}", case.name);
            // At the centres of two particles opposite forces do not cancel cell by cell; at one contact point they do.
            assert!(form == ContactForm::ParticleCentred || boundary < 1e-6, "{} {name}: {boundary:e}", case.name);
        }
    }
}

#[test]
fn the_mass_that_sampled_kernels_see_is_measured() {
    for case in cases() {
        let r = largest_radius(&case);
        for (name, function) in
            [("gauss, w = r", gauss(r)), ("lucy, w = 2 r", lucy(2.0 * r)), ("lucy, w = 0.7 r", lucy(0.7 * r))]
        {
            let (low, high) = (case.domain.low(), case.domain.high());
            let cells: [usize; 3] = std::array::from_fn(|k| ((high[k] - low[k]) / (1.5 * r)).ceil() as usize);
            let l = run(&grid_around(&case, cells, 6.0 * r), options(&case, function), &case.particles, &case.contacts)
                .ledger;
            let kept = l.mass_binned / l.mass_in;
            println!("| {} | {name} | {kept:.4} of the mass |", case.name);
            assert!((l.mass_in - l.mass_binned - l.mass_clipped).abs() < 1e-11 * l.mass_in);
            assert!((0.2..2.0).contains(&kept) && (kept - 1.0).abs() > 1e-6, "{kept}");
        }
    }
}

#[test]
fn a_tilted_box_is_wrapped_along_its_edges() {
    for case in [Some(support::sheared_layer()), support::lammps_pack()].into_iter().flatten() {
        // The same periodic packing, told as a box whose second edge is tilted by whole first edges: the same lattice.
        let (low, lengths) = (case.domain.low(), case.domain.lengths());
        let tilted = Domain::triclinic(low, lengths, [lengths[0], 0.0, 0.0], case.domain.periodic()).unwrap();
        let grid = grid_around(&case, [8, 7, 9], 1.0);
        for function in [Function::Overlap(Method::Kernel), lucy(0.8)] {
            let a = run(&grid, options(&case, function), &case.particles, &case.contacts);
            let b = run(
                &grid,
                CoarseGrainingOptions { domain: Some(tilted), ..options(&case, function) },
                &case.particles,
                &case.contacts,
            );
            for (a, b) in a.fields.iter().zip(&b.fields).filter(|(a, _)| a.name != "couple_stress") {
                assert!(apart(&a.data, &b.data) <= 1e-12 * size(&a.data), "{} {}", case.name, a.name);
            }
        }
    }
}

#[test]
fn sampled_kernels_do_not_conserve_mass_unless_told_to() {
    for case in [Some(support::sheared_layer()), support::mercury_box()].into_iter().flatten() {
        let grid = grid_around(&case, [12, 12, 14], 4.0);
        let plain = options(&case, lucy(0.5));
        let l = run(&grid, plain.clone(), &case.particles, &case.contacts).ledger;
        assert!((l.mass_binned / l.mass_in - 1.0).abs() > 1e-3, "{}: {l:?}", case.name);
        assert!((l.mass_in - l.mass_binned - l.mass_clipped).abs() < 1e-11 * l.mass_in, "{}: {l:?}", case.name);
        let l = run(&grid, CoarseGrainingOptions { conserve: true, ..plain }, &case.particles, &case.contacts).ledger;
        assert!((l.mass_binned / l.mass_in - 1.0).abs() < 1e-12, "{}: {l:?}", case.name);
        assert!(apart(&l.momentum_binned, &l.momentum_in) < 1e-12 * l.mass_in, "{}: {l:?}", case.name);
    }
}

/// Σ F_i φ(r − r_i) + ∇·σᶜ − IFD at cell centres, ∇· by central differences, over the largest of the three.
fn force_balance_at_points(case: &Case, kernel: Kernel, at: [f64; 3], step: f64) -> f64 {
    let one = |centre: [f64; 3]| {
        // One cell whose centre is the point, as small as that matters to nobody.
        let half = 1e-3 * kernel.width();
        Grid::new(centre.map(|x| x - half), centre.map(|x| x + half), [1; 3]).unwrap()
    };
    let fields =
        |centre: [f64; 3]| run(&one(centre), options(case, Function::Kernel(kernel)), &case.particles, &case.contacts);
    let here = fields(at);
    let force = here.get("contact_force_density").unwrap().cell(0).to_vec();
    let boundary = here.get("boundary_force_density").unwrap().cell(0).to_vec();
    let mut divergence = [0.0; 3];
    for axis in 0..3 {
        // Fourth order.
        for (offset, factor) in [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)] {
            let mut there = at;
            there[axis] += offset * step;
            let fields = fields(there);
            let s = fields.get("contact_stress").unwrap().cell(0);
            (0..3).for_each(|k| divergence[k] += factor * s[3 * k + axis] / step);
        }
    }
    let residual: Vec<f64> = (0..3).map(|k| force[k] + divergence[k] - boundary[k]).collect();
    size(&residual) / size(&force).max(size(&divergence)).max(size(&boundary))
}

#[test]
fn forces_balance_the_divergence_of_the_stress_at_points_inside_and_near_walls() {
    for case in cases() {
        let r = largest_radius(&case);
        let (low, high) = (case.domain.low(), case.domain.high());
        // A Gaussian of long reach is smooth enough for differences; so is Lucy's kernel to its own order.
        for (name, kernel, step, allowed) in [
            ("gauss, cut off at 7 w", Kernel::new(KernelShape::Gauss, r, Some(7.0 * r)).unwrap(), 0.01, 2e-7),
            ("lucy", Kernel::new(KernelShape::Lucy, 3.0 * r, None).unwrap(), 0.002, 2e-6),
        ] {
            let mut worst = 0.0f64;
            for at in [[0.4, 0.6, 0.08], [0.02, 0.3, 0.1]] {
                let at =
                    std::array::from_fn(|k| low[k].max(if k == 2 { 0.0 } else { low[k] }) + at[k] * (high[k] - low[k]));
                worst = worst.max(force_balance_at_points(&case, kernel, at, step * kernel.width()));
            }
            println!("| {} | {name} | {worst:.1e} |", case.name);
            assert!(worst < allowed, "{} {name}: {worst:e}", case.name);
        }
    }
}

#[test]
fn shifting_particles_and_grid_through_periodic_boundaries_changes_nothing() {
    for case in periodic_cases() {
        let r = largest_radius(&case);
        let shift = {
            let l = case.domain.lengths();
            [0.37 * l[0], -0.81 * l[1], 0.0]
        };
        let grid = grid_around(&case, [8, 7, 9], 2.0 * r);
        let moved_grid = Grid::new(
            std::array::from_fn(|k| grid.low()[k] + shift[k]),
            std::array::from_fn(|k| grid.high()[k] + shift[k]),
            grid.cells(),
        )
        .unwrap();
        let positions = case
            .particles
            .positions()
            .iter()
            .map(|p| case.domain.wrap(std::array::from_fn(|k| p[k] + shift[k])))
            .collect();
        let mut moved =
            Particles::new(positions).unwrap().with_radii(case.particles.radii().unwrap().to_vec()).unwrap();
        for q in case.particles.quantities() {
            moved = moved.with_quantity(q.clone()).unwrap();
        }
        for (name, function, form) in [
            ("exact", Function::Overlap(Method::Kernel), None),
            ("exact, branch in cell", Function::Overlap(Method::Kernel), Some(ContactForm::BranchInCell)),
            ("lucy", lucy(1.7 * r), None),
            ("gauss", gauss(r), None),
        ] {
            let mut options = options(&case, function);
            options.contact_form = form;
            // About the origin, which does not move along.
            options.fields.retain(|f| *f != FieldName::AngularMomentum);
            let a = run(&grid, options.clone(), &case.particles, &case.contacts);
            let b = run(&moved_grid, options, &moved, &case.contacts);
            let mut worst = (0.0f64, "");
            for (a, b) in a.fields.iter().zip(&b.fields) {
                // What rounding leaves of zero is measured by the forces, not by itself.
                let error = apart(&a.data, &b.data) / size(&a.data).max(1e-30);
                if a.name == "couple_stress" {
                    continue;
                }
                if error > worst.0 {
                    worst = (error, &a.name);
                }
            }
            println!("| {} | {name} | {:.1e} ({}) |", case.name, worst.0, worst.1);
            assert!(worst.0 < 1e-12, "{} {name}: {worst:?}", case.name);
        }
    }
}

#[test]
fn nothing_is_halved_at_a_periodic_boundary() {
    // A chain of equal balls through the boundary: the stress is the same everywhere.
    let n = 8;
    let domain = Domain::new([0.0; 3], [n as f64, 1.0, 1.0], [true, false, false]).unwrap();
    let particles = Particles::new((0..n).map(|i| [i as f64 + 0.5, 0.5, 0.5]).collect())
        .unwrap()
        .with_uniform_radius(0.5)
        .unwrap()
        .with_quantity(fieldstone_particles::Quantity {
            name: "velocity".into(),
            components: 3,
            data: vec![0.0; 3 * n],
        })
        .unwrap();
    let mut contacts = Contacts::new();
    for i in 0..n {
        let contact = fieldstone_particles::Contact {
            particle: i as u32,
            partner: Partner::Particle(((i + 1) % n) as u32),
            force: [-3.0, 0.0, 0.0],
            arm: [0.5, 0.0, 0.0],
            branch: [1.0, 0.0, 0.0],
        };
        contacts.push(n, contact).unwrap();
    }
    let grid = Grid::new([0.0; 3], [n as f64, 1.0, 1.0], [n, 1, 1]).unwrap();
    for (function, form) in [
        (Function::Overlap(Method::Kernel), None),
        (Function::Overlap(Method::Kernel), Some(ContactForm::BranchInCell)),
        (lucy(1.3), None),
    ] {
        let options = CoarseGrainingOptions {
            function,
            contact_form: form,
            domain: Some(domain),
            particle_density: Some(1.0),
            ..CoarseGrainingOptions::default()
        };
        let fields = run(&grid, options, &particles, &contacts);
        let stress = fields.get("contact_stress").unwrap();
        let first = stress.cell(0)[0];
        assert!(first > 0.0);
        for c in 0..n {
            assert!((stress.cell(c)[0] - first).abs() < 1e-13 * first, "{function:?} {form:?} {c}");
        }
    }
}
