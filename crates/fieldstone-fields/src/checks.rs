//! What every computation demands of particles, their columns and their contacts.

use fieldstone_particles::{Contacts, Particles, ParticlesError, Partner};

use crate::FieldsError;

pub(crate) fn check_length(what: &'static str, found: usize, expected: usize) -> Result<(), FieldsError> {
    if found == expected { Ok(()) } else { Err(FieldsError::Length { what, found, expected }) }
}

/// Refuses radii whose volumes are no numbers: the cube of a smaller one is 0, that of a larger one or a sum of them
/// infinite.
///
/// All are looked at before anything is computed, so that it is always the first one that is named.
pub(crate) fn check_radii(radii: &[f64]) -> Result<(), FieldsError> {
    match radii.iter().position(|r| !(1e-100..=1e100).contains(r)) {
        Some(particle) => Err(FieldsError::RadiusRange { particle, radius: radii[particle] }),
        None => Ok(()),
    }
}

/// Refuses numbers of particles that are none.
pub(crate) fn check_parcel_weights(weights: &[f64]) -> Result<(), FieldsError> {
    match weights.iter().position(|w| !(0.0..=1e100).contains(w)) {
        Some(particle) => Err(FieldsError::ParcelWeight { particle, value: weights[particle] }),
        None => Ok(()),
    }
}

/// Refuses contacts of particles that there are not.
pub(crate) fn check_partners(contacts: &Contacts, particle_count: usize) -> Result<(), FieldsError> {
    for (index, contact) in contacts.iter().enumerate() {
        let other = match contact.partner {
            Partner::Particle(other) => other,
            Partner::Wall(_) => contact.particle,
        };
        let particle = contact.particle.max(other);
        if particle as usize >= particle_count {
            return Err(ParticlesError::UnknownParticle { index, particle, particle_count }.into());
        }
    }
    Ok(())
}

/// A column of as many components, all of them finite.
pub(crate) fn column<'a>(particles: &'a Particles, name: &str, components: usize) -> Result<&'a [f64], FieldsError> {
    let found = particles.quantity(name)?;
    if found.components != components {
        return Err(FieldsError::Components { name: name.into(), found: found.components, expected: components });
    }
    check_finite(name, &found.data, components)?;
    Ok(&found.data)
}

pub(crate) fn check_finite(name: &str, data: &[f64], components: usize) -> Result<(), FieldsError> {
    match data.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(at) => {
            let (index, what, value) = (at / components, name.into(), data[at]);
            Err(ParticlesError::NotFinite { index, what, value }.into())
        }
    }
}
