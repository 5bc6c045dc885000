//! How often 64-bit floats are not enough on real packings and meshes.

#![allow(clippy::unwrap_used)]

use fieldstone::fields::{Method, Weights};
use fieldstone::io::openfoam::read_poly_mesh;
use fieldstone::io::{ParticleOptions, read_frame};
use fieldstone::mesh::Mesh;
use fieldstone_testing::{data, extended};

#[test]
fn a_packing_in_cells_of_like_size_needs_more_digits_in_less_than_one_overlap_of_a_thousand() {
    let dump = data("packed-cylinder/packed.dump.gz");
    let particles = read_frame(&dump, &ParticleOptions::default(), -1).unwrap();
    let mut meshes: Vec<(&str, Mesh)> = vec![("bed_twist", read_poly_mesh(&data("bed_twist")).unwrap())];
    if let Some(path) = extended("openfoam/gmfoam") {
        meshes.push(("gmfoam", read_poly_mesh(&path).unwrap()));
    }
    for (name, mesh) in meshes {
        let counts = Weights::build(&mesh, &particles, Method::Kernel, None).unwrap().path_counts();
        println!("{name}: {} of {} overlaps beyond 64 bits", counts.beyond_f64, counts.evaluated);
        assert!(counts.evaluated > 10_000, "{name}: {counts:?}");
        assert!((counts.beyond_f64 as f64) < 1e-3 * counts.evaluated as f64, "{name}: {counts:?}");
        let fast = Weights::build(&mesh, &particles, Method::KernelF64, None).unwrap();
        assert_eq!(fast.path_counts().beyond_f64, 0);
    }
}
