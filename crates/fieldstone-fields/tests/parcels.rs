//! Parcels that stand for many particles: the fields are those of the particles.

#![allow(clippy::unwrap_used)]

use fieldstone_fields::{
    CoarseGraining, CoarseGrainingOptions, FieldName, Fields, FieldsError, Function, Kernel, KernelShape, Method,
    ParcelWeight, QuantityKind, UserQuantity,
};
use fieldstone_mesh::Grid;
use fieldstone_particles::{Contacts, Particles, Quantity};

const WEIGHTS: [usize; 5] = [3, 1, 4, 1, 5];
const MASSES: [f64; 5] = [1.0, 8.0, 3.0, 2.0, 4.0];
const VELOCITIES: [[f64; 3]; 5] =
    [[1.0, 2.0, -1.0], [-0.5, 0.25, 3.0], [0.0, 1.0, 0.5], [2.0, 0.0, 0.0], [0.5, -1.0, 1.0]];

/// Five particles, each so many times; all of them reach across z = 1, and no plane holds four of them.
fn particles(times: [usize; 5]) -> Particles {
    let all: Vec<usize> = (0..5).flat_map(|k| std::iter::repeat_n(k, times[k])).collect();
    let vector = |name: &str, rows: [[f64; 3]; 5]| Quantity {
        name: name.into(),
        components: 3,
        data: all.iter().flat_map(|&k| rows[k]).collect(),
    };
    let scalar = |name: &str, values: [f64; 5]| Quantity {
        name: name.into(),
        components: 1,
        data: all.iter().map(|&k| values[k]).collect(),
    };
    let centres = [[0.5, 0.5, 0.875], [1.5, 0.5, 0.75], [1.0, 0.25, 1.125], [0.375, 0.75, 1.25], [1.75, 0.875, 1.0]];
    let spins = [[2.0, 0.0, 1.0], [0.0, 4.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.0, 3.0], [1.0, 0.5, 0.25]];
    let moves = [[0.5, 0.0, 0.25], [0.0, 0.125, 0.0], [0.25, 0.5, -0.5], [0.125, 0.0, 0.0], [0.0, -0.25, 0.5]];
    Particles::new(all.iter().map(|&k| centres[k]).collect())
        .unwrap()
        .with_radii(all.iter().map(|&k| [0.25, 0.5, 0.375, 0.4375, 0.3125][k]).collect())
        .unwrap()
        .with_quantity(scalar("mass", MASSES))
        .unwrap()
        .with_quantity(scalar("temperature", [300.0, 400.0, 250.0, 350.0, 275.0]))
        .unwrap()
        .with_quantity(vector("velocity", VELOCITIES))
        .unwrap()
        .with_quantity(vector("angular_velocity", spins))
        .unwrap()
        .with_quantity(vector("displacement", moves))
        .unwrap()
}

fn fields(function: Function, particles: &Particles, parcel_weight: Option<ParcelWeight>) -> Fields {
    let grid = Grid::new([0.0; 3], [2.0, 1.0, 2.0], [1, 1, 2]).unwrap();
    let exact = matches!(function, Function::Overlap(_));
    let names = FieldName::ALL.iter().copied();
    let user = |name: &str, kind| UserQuantity { name: name.into(), columns: vec!["temperature".into()], kind };
    let options = CoarseGrainingOptions {
        function,
        fields: names.filter(|f| !f.needs_contacts() && (exact || *f != FieldName::MomentumWithSpin)).collect(),
        quantities: vec![
            user("heat", QuantityKind::Sum),
            user("by_mass", QuantityKind::MassMean),
            user("by_volume", QuantityKind::VolumeMean),
        ],
        parcel_weight,
        ..CoarseGrainingOptions::default()
    };
    let mut grains = CoarseGraining::new(&grid, options).unwrap();
    grains.accumulate(particles, None, 1.0).unwrap();
    grains.finish().unwrap()
}

#[test]
fn a_parcel_counts_in_every_field_as_the_particles_that_it_stands_for() {
    let counts = Quantity { name: "nParticle".into(), components: 1, data: WEIGHTS.map(|n| n as f64).to_vec() };
    let parcels = particles([1; 5]).with_quantity(counts).unwrap();
    let gauss = Function::Kernel(Kernel::new(KernelShape::Gauss, 1.0, None).unwrap());
    for function in [Function::Overlap(Method::Kernel), gauss] {
        let real = fields(function, &particles(WEIGHTS), None);
        let found = fields(function, &parcels, Some(ParcelWeight::Column("nParticle".into())));
        assert_eq!(real.fields.len(), found.fields.len());
        for (real, found) in real.fields.iter().zip(&found.fields) {
            let size = real.data.iter().fold(0.0f64, |size, x| size.max(x.abs()));
            assert!(size > 0.0, "{} is nowhere", real.name);
            for (a, b) in real.data.iter().zip(&found.data) {
                assert!((a - b).abs() <= 1e-13 * size, "{}: {a} and {b}", real.name);
            }
        }
        let close = |a: f64, b: f64| (a - b).abs() < 1e-13 * real.ledger.mass_in;
        let sum = |of: &dyn Fn(usize) -> f64| (0..5).map(|k| WEIGHTS[k] as f64 * MASSES[k] * of(k)).sum::<f64>();
        assert_eq!(found.ledger.mass_in, sum(&|_| 1.0));
        assert_eq!(found.ledger.momentum_in, [0, 1, 2].map(|axis| sum(&|k| VELOCITIES[k][axis])));
        assert!(close(found.ledger.mass_binned, real.ledger.mass_binned));
        assert!(close(found.ledger.mass_clipped, real.ledger.mass_clipped) && real.ledger.mass_clipped != 0.0);
    }
}

#[test]
fn parcels_with_contacts_and_weights_that_are_none_are_refused() {
    let grid = Grid::new([0.0; 3], [2.0; 3], [1; 3]).unwrap();
    let refused = |weight: ParcelWeight, contacts: Option<&Contacts>| {
        let fields = vec![FieldName::Density];
        let options = CoarseGrainingOptions { fields, parcel_weight: Some(weight), ..CoarseGrainingOptions::default() };
        CoarseGraining::new(&grid, options).unwrap().accumulate(&particles([1; 5]), contacts, 1.0).unwrap_err()
    };
    let message = refused(ParcelWeight::Uniform(2.0), Some(&Contacts::new())).to_string();
    assert!(message.contains("leave out the contacts, or the parcel weights"), "{message}");
    let message = refused(ParcelWeight::Column("nParticle".into()), None).to_string();
    assert!(message.contains("there is no column 'nParticle'"), "{message}");
    assert!(matches!(refused(ParcelWeight::Uniform(-1.0), None), FieldsError::ParcelWeight { particle: 0, .. }));
    let vector = refused(ParcelWeight::Column("velocity".into()), None);
    assert!(matches!(vector, FieldsError::Components { found: 3, expected: 1, .. }));
    for bad in ["0", "-1", "inf", "nan"] {
        assert!(bad.parse::<ParcelWeight>().is_err(), "{bad}");
    }
}
