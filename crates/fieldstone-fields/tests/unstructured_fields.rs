//! Coarse graining on a polyhedral mesh: a vessel of tetrahedra and prisms with spheres poured into it.
#![allow(clippy::unwrap_used)]

mod support;

use fieldstone_fields::{
    CoarseGraining, CoarseGrainingOptions, ContactForm, FieldName, Fields, Function, Kernel, KernelShape, Method,
};
use fieldstone_mesh::Mesh;
use support::Case;

fn setting() -> Option<(Mesh, Case)> {
    let folder = fieldstone_testing::extended("openfoam/gmfoam")?;
    Some((fieldstone_io::read_mesh(&folder).unwrap(), support::packed_cylinder()?))
}

fn run(mesh: &Mesh, case: &Case, function: Function, form: Option<ContactForm>, conserve: bool) -> Fields {
    let options = CoarseGrainingOptions {
        function,
        contact_form: form,
        conserve,
        fields: FieldName::parse_list("standard,velocity,pressure,fabric,coordination_number").unwrap(),
        particle_density: case.density,
        ..CoarseGrainingOptions::default()
    };
    let mut grains = CoarseGraining::new(mesh, options).unwrap();
    grains.accumulate(&case.particles, Some(&case.contacts), 1.0).unwrap();
    grains.finish().unwrap()
}

#[test]
fn exact_weights_conserve_on_polyhedra_and_what_is_outside_is_in_the_ledger() {
    let Some((mesh, case)) = setting() else { return };
    let l = run(&mesh, &case, Function::Overlap(Method::Kernel), None, false).ledger;
    let error = (l.mass_in - l.mass_binned - l.mass_clipped) / l.mass_in;
    println!("| packed-cylinder on gmfoam | mass {error:.1e}, clipped {:.2e} |", l.mass_clipped / l.mass_in);
    assert!(error.abs() < 1e-12, "{error:e}");
    assert!(l.mass_clipped < 0.02 * l.mass_in, "{l:?}");
    // Stress: what of the particles is outside takes its share along, no more.
    let scale = l.stress_sum_contacts.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
    for (a, b) in l.stress_sum_fields.iter().zip(l.stress_sum_contacts) {
        assert!((a - b).abs() < 0.02 * scale);
    }
}

#[test]
fn branches_cut_by_polyhedra_are_whole_where_the_mesh_holds_them() {
    let Some((mesh, case)) = setting() else { return };
    // Only contacts whose two particles lie well inside the vessel.
    let x = case.particles.positions();
    let inside = |p: [f64; 3]| p[0].hypot(p[1]) < 0.045 && p[2] > 0.004;
    let mut contacts = fieldstone_particles::Contacts::new();
    for c in case.contacts.iter() {
        let a = x[c.particle as usize];
        if inside(a) && inside(std::array::from_fn(|k| a[k] + c.branch[k])) {
            contacts.push(x.len(), c).unwrap();
        }
    }
    let (low, high) = fieldstone_mesh::Cells::bounds(&mesh);
    println!("mesh {low:?} {high:?}, {} of {} contacts", contacts.len(), case.contacts.len());
    assert!(contacts.len() > 1000);
    let held = Case { contacts, ..case };
    let l = run(&mesh, &held, Function::Overlap(Method::Kernel), Some(ContactForm::BranchInCell), false).ledger;
    let scale: f64 = (held.contacts.iter())
        .map(|c| c.force.iter().chain(&c.branch).fold(0.0, |m: f64, x| m.max(x.abs())).powi(2))
        .sum();
    let worst = (l.stress_sum_fields.iter().zip(l.stress_sum_contacts)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("| packed-cylinder on gmfoam | branch in cell | {:.1e} |", worst / scale);
    assert!(worst < 1e-12 * scale, "{worst:e} {scale:e}");
}

#[test]
fn kernels_at_the_centres_of_polyhedra_conserve_mass_when_told_to() {
    let Some((mesh, case)) = setting() else { return };
    let kernel = Function::Kernel(Kernel::new(KernelShape::Lucy, 0.006, None).unwrap());
    let plain = run(&mesh, &case, kernel, None, false).ledger;
    let scaled = run(&mesh, &case, kernel, None, true).ledger;
    println!("| packed-cylinder on gmfoam | lucy | {:.3} of the mass |", plain.mass_binned / plain.mass_in);
    assert!((plain.mass_binned / plain.mass_in - 1.0).abs() > 1e-3);
    assert!((scaled.mass_in - scaled.mass_binned - scaled.mass_clipped).abs() < 1e-12 * scaled.mass_in);
    assert!(scaled.mass_clipped.abs() < 1e-9 * scaled.mass_in);
}
