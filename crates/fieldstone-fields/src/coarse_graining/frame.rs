//! One frame made ready: masses, velocities and what else the fields need, or why there are none.

use std::borrow::Cow;
use std::f64::consts::PI;

use fieldstone_particles::{Contact, Contacts, Particles, Partner, Quantity};
use rayon::prelude::*;

use super::layout::{Column, Layout};
use super::options::{CoarseGrainingOptions, QuantityKind, Selection};
use crate::FieldsError;
use crate::checks::{check_finite, check_partners, check_radii, column};

/// Columns of one number per particle each.
type Scalars<'a> = Vec<Cow<'a, Quantity>>;

/// Columns of a particle set that fields are made of.
pub(super) struct Frame<'a> {
    pub positions: &'a [[f64; 3]],
    pub radii: &'a [f64],
    pub volumes: Vec<f64>,
    pub masses: Vec<f64>,
    pub velocities: Option<&'a [f64]>,
    pub spins: Option<&'a [f64]>,
    pub displacements: Option<&'a [f64]>,
    /// Columns of each of the user's quantities.
    pub user: Vec<(QuantityKind, Scalars<'a>)>,
    parcels: Option<Vec<f64>>,
    pub selected: Vec<bool>,
}

impl<'a> Frame<'a> {
    pub fn new(
        particles: &'a Particles,
        options: &CoarseGrainingOptions,
        layout: &Layout,
    ) -> Result<Self, FieldsError> {
        use Column::*;
        let radii = particles.radii()?;
        check_radii(radii)?;
        let volumes: Vec<f64> = radii.par_iter().map(|r| 4.0 / 3.0 * PI * r * r * r).collect();
        let vector = |name: &'static str, needed: bool| -> Result<Option<&'a [f64]>, FieldsError> {
            match column(particles, name, 3) {
                Ok(data) => Ok(Some(data)),
                Err(reason) if needed => Err(reason),
                Err(_) => Ok(None),
            }
        };
        let moves = [Momentum, MomentumFlux, KineticEnergy, KineticEnergyFlux, ContactEnergy, AngularMomentum];
        let spins = [Spin, SpinMomentum];
        let travels = [MassDisplacement, MassDisplacementPosition];
        let user = (options.quantities.iter())
            .map(|quantity| {
                let one = |column: &String| {
                    let found = particles.column(column)?;
                    if found.components != 1 {
                        let (name, found) = (column.clone(), found.components);
                        return Err(FieldsError::Components { name, found, expected: 1 });
                    }
                    check_finite(column, &found.data, 1)?;
                    Ok(found)
                };
                Ok((quantity.kind, quantity.columns.iter().map(one).collect::<Result<Scalars<'a>, FieldsError>>()?))
            })
            .collect::<Result<Vec<_>, FieldsError>>()?;
        Ok(Self {
            positions: particles.positions(),
            radii,
            masses: masses(particles, &volumes, options.particle_density)?,
            volumes,
            velocities: vector("velocity", layout.any(&moves))?,
            spins: vector("angular_velocity", layout.any(&spins))?,
            displacements: vector("displacement", layout.any(&travels))?,
            user,
            parcels: options.parcel_weight.as_ref().map(|weight| weight.of(particles)).transpose()?,
            selected: select(particles, radii, &options.selection)?,
        })
    }

    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// How many particles this one stands for.
    pub fn parcel(&self, particle: usize) -> f64 {
        self.parcels.as_ref().map_or(1.0, |weights| weights[particle])
    }

    pub fn velocity(&self, particle: usize) -> [f64; 3] {
        vector_of(self.velocities, particle)
    }

    pub fn spin(&self, particle: usize) -> [f64; 3] {
        vector_of(self.spins, particle)
    }

    pub fn displacement(&self, particle: usize) -> [f64; 3] {
        vector_of(self.displacements, particle)
    }

    /// Moment of inertia of a solid sphere.
    pub fn inertia(&self, particle: usize) -> f64 {
        0.4 * self.masses[particle] * self.radii[particle] * self.radii[particle]
    }

    /// The contacts as the selected particles see them: pairs among them, and boundary contacts of one of them.
    ///
    /// A partner that is not selected is a boundary, and its opposite side is nobody's.
    pub fn side(&self, contact: Contact) -> Option<Contact> {
        let selected = |particle: u32| self.selected[particle as usize];
        match contact.partner {
            Partner::Wall(_) => selected(contact.particle).then_some(contact),
            Partner::Particle(other) => match (selected(contact.particle), selected(other)) {
                (true, true) => Some(contact),
                (true, false) => {
                    Some(Contact { partner: Partner::Wall(i64::from(other)), branch: contact.arm, ..contact })
                }
                (false, true) => Some(Contact {
                    particle: other,
                    partner: Partner::Wall(i64::from(contact.particle)),
                    force: contact.force.map(|f| -f),
                    arm: contact.partner_arm(),
                    branch: contact.partner_arm(),
                }),
                (false, false) => None,
            },
        }
    }

    /// All contacts as [`Frame::side`] sees them.
    pub fn sides(&self, contacts: &Contacts) -> Result<Vec<Contact>, FieldsError> {
        check_partners(contacts, self.len())?;
        Ok(contacts.iter().filter_map(|contact| self.side(contact)).collect())
    }
}

fn vector_of(column: Option<&[f64]>, particle: usize) -> [f64; 3] {
    column.map_or([0.0; 3], |v| [v[3 * particle], v[3 * particle + 1], v[3 * particle + 2]])
}

/// Mass of each particle: by the density of all where one is given, else by the particle's own mass or density.
fn masses(particles: &Particles, volumes: &[f64], density: Option<f64>) -> Result<Vec<f64>, FieldsError> {
    if let Some(density) = density {
        return Ok(volumes.iter().map(|v| v * density).collect());
    }
    let has = |name: &str| particles.quantity(name).is_ok();
    // A column that is there and cannot be used is no reason to look for another one.
    let Some(name) = ["mass", "density"].into_iter().find(|name| has(name)) else {
        let names: Vec<&str> = particles.quantities().iter().map(|q| q.name.as_str()).collect();
        let available = if names.is_empty() { "no other columns".into() } else { names.join(", ") };
        return Err(FieldsError::NoMass { available });
    };
    let values = column(particles, name, 1)?;
    if let Some(particle) = values.iter().position(|x| *x <= 0.0) {
        return Err(FieldsError::Mass { particle, column: name, value: values[particle] });
    }
    let masses: Vec<f64> = match name {
        "mass" => values.to_vec(),
        _ => volumes.iter().zip(values).map(|(v, d)| v * d).collect(),
    };
    // Products of numbers that are positive and finite may be neither.
    match masses.iter().position(|m| !(m.is_finite() && *m > 0.0)) {
        None => Ok(masses),
        Some(particle) => Err(FieldsError::Mass { particle, column: name, value: values[particle] }),
    }
}

fn select(particles: &Particles, radii: &[f64], selection: &Selection) -> Result<Vec<bool>, FieldsError> {
    let mut selected = vec![true; particles.len()];
    if let Some(wanted) = &selection.types {
        let types = particles.types().ok_or(FieldsError::NoTypes)?;
        selected.iter_mut().zip(types).for_each(|(s, t)| *s &= wanted.contains(t));
    }
    if let Some([least, most]) = selection.radii {
        selected.iter_mut().zip(radii).for_each(|(s, r)| *s &= (least..=most).contains(r));
    }
    if let Some([low, high]) = selection.region {
        let inside = |p: &[f64; 3]| (0..3).all(|k| p[k] >= low[k] && p[k] <= high[k]);
        selected.iter_mut().zip(particles.positions()).for_each(|(s, p)| *s &= inside(p));
    }
    Ok(selected)
}
