//! How many particles each parcel stands for.

use std::fmt;
use std::str::FromStr;

use fieldstone_particles::Particles;

use crate::{FieldsError, checks};

/// How many real particles each simulated one, a parcel, stands for.
#[derive(Debug, Clone, PartialEq)]
pub enum ParcelWeight {
    /// The same number for all.
    Uniform(f64),
    /// A column of the particles, such as OpenFOAM's `nParticle`, by any name that [`Particles::column`] takes.
    Column(String),
}

impl ParcelWeight {
    /// The weight of each of the particles.
    ///
    /// # Errors
    /// A column that the particles do not have, or that has several numbers per particle; [`FieldsError::ParcelWeight`]
    /// names the first weight that is not between 0 and 1e100.
    ///
    /// ```
    /// use fieldstone_fields::ParcelWeight;
    /// use fieldstone_particles::{Particles, Quantity};
    /// let two = Particles::new(vec![[0.0; 3], [1.0; 3]])?
    ///     .with_quantity(Quantity { name: "nParticle".into(), components: 1, data: vec![1.0, 250.0] })?;
    /// assert_eq!("nparticle".parse::<ParcelWeight>()?.of(&two)?, [1.0, 250.0]);
    /// assert_eq!("3".parse::<ParcelWeight>()?.of(&two)?, [3.0, 3.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(&self, particles: &Particles) -> Result<Vec<f64>, FieldsError> {
        let weights = match self {
            Self::Uniform(weight) => vec![*weight; particles.len()],
            Self::Column(name) => {
                let found = particles.column(name)?;
                if found.components != 1 {
                    let (name, found) = (name.clone(), found.components);
                    return Err(FieldsError::Components { name, found, expected: 1 });
                }
                found.into_owned().data
            }
        };
        checks::check_parcel_weights(&weights)?;
        Ok(weights)
    }
}

impl fmt::Display for ParcelWeight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Uniform(weight) => weight.fmt(f),
            Self::Column(name) => name.fmt(f),
        }
    }
}

impl FromStr for ParcelWeight {
    type Err = FieldsError;

    /// A number, or else the name of a column.
    fn from_str(text: &str) -> Result<Self, FieldsError> {
        match text.parse::<f64>() {
            Ok(weight) if weight > 0.0 && weight.is_finite() => Ok(Self::Uniform(weight)),
            Ok(value) => {
                Err(FieldsError::Option { name: "the parcel weight", value, allowed: "a finite number above 0" })
            }
            Err(_) => Ok(Self::Column(text.into())),
        }
    }
}
