use crate::columns::SourceNames;
use crate::{Domain, ParticlesError};

/// A named column of numbers, one row per particle.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Name as the source spells it, or a standard one: `mass`, `density`, `velocity`, `force`,
    /// `angular_velocity`.
    pub name: String,
    /// Numbers per particle: 1 scalar, 3 vector, 6 symmetric tensor, 9 tensor.
    pub components: usize,
    /// `components` numbers per particle, particle by particle.
    pub data: Vec<f64>,
}

/// Particles as a structure of arrays: positions, radii, ids, types and named columns.
///
/// | column | shape | unit |
/// |---|---|---|
/// | positions | N × 3 | length |
/// | radii, where known | N | length |
/// | ids, types, where known | N | – |
/// | quantities | N × components | the source's |
///
/// Built by [`Particles::new`], which refuses positions that are not finite; every column added later is
/// checked for its length.
#[derive(Debug, Clone, Default)]
pub struct Particles {
    positions: Vec<[f64; 3]>,
    radii: Option<Vec<f64>>,
    ids: Option<Vec<i64>>,
    types: Option<Vec<i64>>,
    pub(crate) quantities: Vec<Quantity>,
    domain: Option<Domain>,
    step: Option<i64>,
    time: Option<f64>,
    pub(crate) source_names: Vec<SourceNames>,
}

/// Sets are equal where everything is but the names that their sources have for columns.
impl PartialEq for Particles {
    fn eq(&self, other: &Self) -> bool {
        let Self { positions, radii, ids, types, quantities, domain, step, time, source_names: _ } = self;
        (positions, radii, ids, types) == (&other.positions, &other.radii, &other.ids, &other.types)
            && (quantities, domain, step, time) == (&other.quantities, &other.domain, &other.step, &other.time)
    }
}

impl Particles {
    /// A set of particles at `positions`, without any other column.
    ///
    /// # Errors
    /// [`ParticlesError::NotFinite`] names the first position that holds NaN or infinity.
    ///
    /// ```
    /// use fieldstone_particles::Particles;
    /// let two = Particles::new(vec![[0.0; 3], [1.0, 0.0, 0.0]])?.with_uniform_radius(0.5)?;
    /// assert_eq!(two.radii()?, [0.5, 0.5]);
    /// assert!(Particles::new(vec![[f64::NAN, 0.0, 0.0]]).is_err());
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    pub fn new(positions: Vec<[f64; 3]>) -> Result<Self, ParticlesError> {
        for (index, p) in positions.iter().enumerate() {
            for (axis, &value) in p.iter().enumerate() {
                if !value.is_finite() {
                    return Err(ParticlesError::NotFinite { index, what: ["x", "y", "z"][axis].into(), value });
                }
            }
        }
        Ok(Self { positions, ..Self::default() })
    }

    /// The same particles with one radius each.
    ///
    /// # Errors
    /// A wrong count, a radius that is not finite, zero or negative.
    pub fn with_radii(mut self, radii: Vec<f64>) -> Result<Self, ParticlesError> {
        self.check_length("radius", radii.len(), 1)?;
        for (index, &value) in radii.iter().enumerate() {
            if !value.is_finite() {
                return Err(ParticlesError::NotFinite { index, what: "radius".into(), value });
            }
            if value <= 0.0 {
                return Err(ParticlesError::Radius { index, value });
            }
        }
        self.radii = Some(radii);
        self.forget_source_names("radius");
        self.forget_source_names("diameter");
        Ok(self)
    }

    /// The same particles, all of one radius.
    ///
    /// # Errors
    /// As [`Particles::with_radii`].
    pub fn with_uniform_radius(self, radius: f64) -> Result<Self, ParticlesError> {
        let n = self.len();
        self.with_radii(vec![radius; n])
    }

    /// The same particles with their ids.
    ///
    /// # Errors
    /// [`ParticlesError::ColumnLength`].
    pub fn with_ids(mut self, ids: Vec<i64>) -> Result<Self, ParticlesError> {
        self.check_length("id", ids.len(), 1)?;
        self.ids = Some(ids);
        self.forget_source_names("id");
        Ok(self)
    }

    /// The same particles with their types (species).
    ///
    /// # Errors
    /// [`ParticlesError::ColumnLength`].
    pub fn with_types(mut self, types: Vec<i64>) -> Result<Self, ParticlesError> {
        self.check_length("type", types.len(), 1)?;
        self.types = Some(types);
        self.forget_source_names("type");
        Ok(self)
    }

    /// The same particles with one more column; a column of the same name is replaced.
    ///
    /// # Errors
    /// [`ParticlesError::ColumnLength`].
    pub fn with_quantity(mut self, quantity: Quantity) -> Result<Self, ParticlesError> {
        self.check_length(&quantity.name, quantity.data.len(), quantity.components)?;
        self.quantities.retain(|q| q.name != quantity.name);
        self.forget_source_names(&quantity.name);
        self.quantities.push(quantity);
        Ok(self)
    }

    /// The same particles in a box.
    #[must_use]
    pub fn with_domain(mut self, domain: Domain) -> Self {
        self.domain = Some(domain);
        self
    }

    /// The same particles, marked with the time step and the time that the source states.
    #[must_use]
    pub fn at(mut self, step: Option<i64>, time: Option<f64>) -> Self {
        self.step = step;
        self.time = time;
        self
    }

    fn check_length(&self, name: &str, found: usize, components: usize) -> Result<(), ParticlesError> {
        if found == self.len() * components {
            return Ok(());
        }
        Err(ParticlesError::ColumnLength { name: name.into(), found, expected: self.len(), components })
    }

    /// Number of particles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is no particle at all.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Centres, one per particle.
    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// Radii, one per particle.
    ///
    /// # Errors
    /// [`ParticlesError::NoRadius`] where the source had none and none was given.
    pub fn radii(&self) -> Result<&[f64], ParticlesError> {
        self.radii.as_deref().ok_or(ParticlesError::NoRadius)
    }

    /// Ids, where the source has them.
    pub fn ids(&self) -> Option<&[i64]> {
        self.ids.as_deref()
    }

    /// Types (species), where the source has them.
    pub fn types(&self) -> Option<&[i64]> {
        self.types.as_deref()
    }

    /// All named columns, in the source's order.
    pub fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    /// The quantity called `name`, exactly; what a user writes goes through [`Particles::column`].
    ///
    /// # Errors
    /// [`ParticlesError::NoColumn`] lists the names that exist.
    pub fn quantity(&self, name: &str) -> Result<&Quantity, ParticlesError> {
        let missing = || ParticlesError::NoColumn { name: name.into(), available: self.column_names() };
        self.quantity_named(name).ok_or_else(missing)
    }

    /// The box, where the source states one.
    pub fn domain(&self) -> Option<&Domain> {
        self.domain.as_ref()
    }

    /// Time step, where the source states one.
    pub fn step(&self) -> Option<i64> {
        self.step
    }

    /// Time, where the source states one.
    pub fn time(&self) -> Option<f64> {
        self.time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_of_the_wrong_length_is_refused_with_its_name() {
        let p = Particles::new(vec![[0.0; 3]; 3]).unwrap();
        let e = p.with_quantity(Quantity { name: "velocity".into(), components: 3, data: vec![0.0; 8] }).unwrap_err();
        assert!(e.to_string().contains("'velocity' has 8 values for 3 particles"), "{e}");
    }

    #[test]
    fn negative_zero_and_nan_radii_are_refused_with_the_particle() {
        let p = Particles::new(vec![[0.0; 3]; 2]).unwrap();
        for bad in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
            let e = p.clone().with_radii(vec![1.0, bad]).unwrap_err();
            assert!(e.to_string().starts_with("particle 1 has radius"), "{e}");
        }
    }

    #[test]
    fn a_missing_column_names_those_that_exist() {
        let p = Particles::new(vec![]).unwrap();
        let p = p.with_quantity(Quantity { name: "mass".into(), components: 1, data: vec![] }).unwrap();
        assert!(p.quantity("weight").unwrap_err().to_string().contains("have: mass"));
    }
}
