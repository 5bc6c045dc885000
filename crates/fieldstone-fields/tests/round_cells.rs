//! Coarse graining on shells, rings and sectors.
#![allow(clippy::unwrap_used)]

mod support;

use fieldstone_fields::{
    CoarseGraining, CoarseGrainingOptions, ContactForm, FieldName, FieldsError, Function, Kernel, KernelShape, Method,
};
use fieldstone_mesh::{Cells, CylinderGrid, Grid};

#[test]
fn exact_weights_conserve_on_shells_rings_and_sectors() {
    let Some(case) = support::packed_cylinder() else { return };
    for cells in [[6, 1, 1], [6, 1, 9], [5, 8, 7]] {
        let grid = CylinderGrid::new(2, [0.0; 3], [0.0, 0.06], [-0.01, 0.2], cells).unwrap();
        for form in [ContactForm::ParticleCentred, ContactForm::BranchInCell] {
            let options = CoarseGrainingOptions {
                contact_form: Some(form),
                particle_density: case.density,
                ..CoarseGrainingOptions::default()
            };
            let mut grains = CoarseGraining::new(&grid, options).unwrap();
            grains.accumulate(&case.particles, Some(&case.contacts), 1.0).unwrap();
            let l = grains.finish().unwrap().ledger;
            let mass = (l.mass_binned / l.mass_in - 1.0).abs();
            let scale = l.stress_sum_contacts.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
            let stress = (0..9).map(|n| (l.stress_sum_fields[n] - l.stress_sum_contacts[n]).abs()).fold(0.0, f64::max);
            println!("| packed-cylinder on {cells:?} | {form:?} | mass {mass:.1e} | stress {:.1e} |", stress / scale);
            assert!(mass < 1e-12 && stress < 1e-12 * scale, "{cells:?} {form:?}: {mass:e} {:e}", stress / scale);
        }
    }
}

#[test]
fn a_kernel_on_a_ring_is_the_mean_around_it() {
    // One particle on the axis: the same on every point of the circle, so the ring has the kernel's value at its radius.
    let one = fieldstone_particles::Particles::new(vec![[0.0; 3]]).unwrap().with_uniform_radius(0.1).unwrap();
    let kernel = Kernel::new(KernelShape::Lucy, 1.0, None).unwrap();
    let options = CoarseGrainingOptions {
        function: Function::Kernel(kernel),
        fields: vec![FieldName::Density],
        particle_density: Some(1.0),
        ..CoarseGrainingOptions::default()
    };
    let mass = one.radii().unwrap()[0].powi(3) * 4.0 / 3.0 * std::f64::consts::PI;
    let rings = CylinderGrid::new(2, [0.0; 3], [0.0, 1.0], [-0.1, 0.1], [5, 1, 2]).unwrap();
    let mut grains = CoarseGraining::new(&rings, options.clone()).unwrap();
    grains.accumulate(&one, None, 1.0).unwrap();
    let density = grains.finish().unwrap().fields.remove(0);
    for i in 0..5 {
        let s = 0.2 * i as f64 + 0.1;
        let expected = mass * kernel.value(s * s + 0.05 * 0.05);
        assert!((density.cell(i)[0] - expected).abs() < 1e-15, "{i}");
    }
    // Averaged over the height as well: the kernel of two dimensions over the height.
    let shells = CylinderGrid::new(2, [0.0; 3], [0.0, 1.0], [-2.0, 3.0], [5, 1, 1]).unwrap();
    let mut grains = CoarseGraining::new(&shells, options).unwrap();
    grains.accumulate(&one, None, 1.0).unwrap();
    let density = grains.finish().unwrap().fields.remove(0);
    for i in 0..5 {
        let s = 0.2 * i as f64 + 0.1;
        let expected = mass * kernel.in_dimensions(2).unwrap().value(s * s) / 5.0;
        assert!((density.cell(i)[0] - expected).abs() < 1e-15, "{i}");
    }
    assert_eq!(shells.averaged(), [false, false, true]);
}

#[test]
fn a_kernel_far_narrower_than_the_rings_is_their_mean_too_and_takes_no_memory_for_their_points() {
    use std::f64::consts::{PI, TAU};
    // A circle takes some 2π s/(w/5) points: 10¹⁰ and more of them for each of the shells. What they sum up to is
    // the kernel's integral along a line, over the circle's length.
    let lucy = |w: f64| (Kernel::new(KernelShape::Lucy, w, None).unwrap(), 4.0 / (PI * w));
    // As good as constant up to its cut-off: a chord over a disc.
    let short = |c: f64| (Kernel::new(KernelShape::Gauss, 1e3 * c, Some(c)).unwrap(), 2.0 / (PI * c));
    for (shells, (kernel, along)) in
        [(5, lucy(1e-3)), (5, lucy(1e-6)), (200, lucy(1e-9)), (200, lucy(3e-11)), (5, short(1e-2)), (200, short(1e-8))]
    {
        // In the middle of the third shell from within, beside the direction in which points begin.
        let s = 2.5 * 2.0 / f64::from(shells);
        let at = [s * 0.8f64, s * 0.6, 0.3];
        let one = fieldstone_particles::Particles::new(vec![at]).unwrap().with_uniform_radius(0.1).unwrap();
        let options = CoarseGrainingOptions {
            function: Function::Kernel(kernel),
            fields: vec![FieldName::Density],
            particle_density: Some(1.0),
            ..CoarseGrainingOptions::default()
        };
        let grid = CylinderGrid::new(2, [0.0; 3], [0.0, 2.0], [0.0, 1.0], [shells as usize, 1, 1]).unwrap();
        let mut grains = CoarseGraining::new(&grid, options).unwrap();
        grains.accumulate(&one, None, 1.0).unwrap();
        let density = grains.finish().unwrap().fields.remove(0);
        let mass = 4.0 / 3.0 * PI * 0.1f64.powi(3);
        for cell in 0..shells as usize {
            let expected = if cell == 2 { mass * along / (TAU * s) } else { 0.0 };
            // A kernel with a jump is summed to a point at each end, of some ten.
            let allowed = if kernel.shape() == KernelShape::Gauss { 0.11 } else { 1e-3 };
            let found = density.cell(cell)[0];
            assert!((found - expected).abs() <= allowed * expected, "{kernel:?}, shell {cell}: {found} for {expected}");
        }
    }
}

#[test]
fn a_shell_that_holds_a_box_has_what_the_box_has() {
    let Some(case) = support::lammps_pack() else { return };
    let options = || CoarseGrainingOptions { particle_density: case.density, ..CoarseGrainingOptions::default() };
    let shell = CylinderGrid::new(2, [5.0, 5.0, 0.0], [0.0, 9.0], [-1.0, 20.0], [1; 3]).unwrap();
    let cube = Grid::new([-4.0, -4.0, -1.0], [14.0, 14.0, 20.0], [1; 3]).unwrap();
    let mut a = CoarseGraining::new(&shell, options()).unwrap();
    a.accumulate(&case.particles, Some(&case.contacts), 1.0).unwrap();
    let mut b = CoarseGraining::new(&cube, options()).unwrap();
    b.accumulate(&case.particles, Some(&case.contacts), 1.0).unwrap();
    let (a, b) = (a.finish().unwrap(), b.finish().unwrap());
    for (x, y) in a.fields.iter().zip(&b.fields) {
        for (x, y) in x.data.iter().zip(&y.data) {
            let (x, y) = (x * shell.cell_volume(0), y * cube.cell_volume(0));
            assert!((x - y).abs() < 1e-10 * y.abs().max(1.0), "{x} {y}");
        }
    }
}

#[test]
fn methods_that_need_planar_faces_are_refused_on_round_cells() {
    let grid = CylinderGrid::new(2, [0.0; 3], [0.0, 1.0], [0.0, 1.0], [2; 3]).unwrap();
    for method in [Method::Decomposition, Method::Cube] {
        let options = CoarseGrainingOptions { function: Function::Overlap(method), ..CoarseGrainingOptions::default() };
        assert!(matches!(CoarseGraining::new(&grid, options), Err(FieldsError::Combination { .. })));
    }
}
