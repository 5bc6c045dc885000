//! Columns by the names that a user may write: standard ones, and those of the source.

use std::borrow::Cow;

use crate::{Particles, ParticlesError, Quantity};

/// What the source calls a column: one name for all of it, or one for each of its components.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SourceNames {
    /// Name of a quantity, or `id`, `type`, `radius` or `diameter`.
    pub(crate) column: String,
    pub(crate) names: Vec<String>,
}

/// What a name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Target {
    /// The quantity of this place among all.
    Whole(usize),
    /// A component of it, from 0.
    Component(usize, usize),
    Ids,
    Types,
    Radii,
    /// Twice the radii: what a source has that states diameters.
    Diameters,
}

impl Particles {
    /// The same particles with what the source calls one of their columns: a quantity, `id`, `type`, `radius`, or
    /// `diameter` where the radii are halves of what stands there.
    ///
    /// One name is that of the whole column, as many as it has components are theirs: `vx vy vz` of `velocity`. They are
    /// no part of the particles: sets that differ in nothing else are equal. A column that is replaced loses them.
    ///
    /// ```
    /// use fieldstone_particles::{Particles, Quantity};
    /// let velocity = Quantity { name: "velocity".into(), components: 3, data: vec![1.0, 2.0, 3.0] };
    /// let one = Particles::new(vec![[0.0; 3]])?.with_quantity(velocity)?.with_source_names("velocity", &["vx", "vy", "vz"]);
    /// assert_eq!(one.column("vy")?.data, [2.0]);
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    #[must_use]
    pub fn with_source_names<S: AsRef<str>>(mut self, column: &str, names: &[S]) -> Self {
        self.forget_source_names(column);
        let names: Vec<String> = names.iter().map(|name| name.as_ref().to_owned()).collect();
        if names.as_slice() != [column] {
            self.source_names.push(SourceNames { column: column.into(), names });
        }
        self
    }

    /// What the source calls a column, where it has other names for it or names for its components.
    pub fn source_names(&self, column: &str) -> &[String] {
        self.source_names.iter().find(|known| known.column == column).map_or(&[], |known| &known.names)
    }

    /// The same particles with the source's names of another set that has the same columns.
    #[must_use]
    pub fn with_source_names_of(mut self, other: &Self) -> Self {
        self.source_names.clone_from(&other.source_names);
        self
    }

    pub(crate) fn forget_source_names(&mut self, column: &str) {
        self.source_names.retain(|known| known.column != column);
    }

    /// The column, or component of one, that a user calls `name`.
    ///
    /// | name | is |
    /// |---|---|
    /// | `velocity` | a quantity by its own name |
    /// | `Vel`, `vx`, `c_st[1]` | a quantity, or a component of one, as the source spells it |
    /// | `velocity[1]` | a component by its number, from 1, as dumps number their columns |
    /// | `id`, `type`, `radius` | what particles have beside quantities, as numbers |
    ///
    /// A name that is spelt so goes before one of other letter case. A component comes as a scalar of the name that the
    /// list of an error has for it.
    ///
    /// Cost: whole quantities are borrowed, everything else is copied.
    ///
    /// # Errors
    /// [`ParticlesError::NoColumn`] lists the names that there are; [`ParticlesError::AmbiguousColumn`] where only the
    /// letter case would tell several apart.
    ///
    /// ```
    /// use fieldstone_particles::{Particles, Quantity};
    /// let stress = Quantity { name: "stress".into(), components: 6, data: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0] };
    /// let one = Particles::new(vec![[0.0; 3]])?.with_types(vec![7])?.with_quantity(stress)?;
    /// assert_eq!(one.column("stress[6]")?.data, [6.0]);
    /// assert_eq!(one.column("Type")?.data, [7.0]);
    /// let message = one.column("stress[0]").unwrap_err().to_string();
    /// assert!(message.ends_with("the particles have: stress (stress[1] … stress[6]), type"));
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    pub fn column(&self, name: &str) -> Result<Cow<'_, Quantity>, ParticlesError> {
        let targets = self.targets();
        let mut found = targets.iter().filter(|(known, _)| known == name).take(1).collect::<Vec<_>>();
        if found.is_empty() {
            found = targets.iter().filter(|(known, _)| known.eq_ignore_ascii_case(name)).collect();
            found.dedup_by_key(|(_, target)| *target);
        }
        match found.as_slice() {
            [(known, target)] => Ok(self.column_of(*target, known)),
            [] => Err(ParticlesError::NoColumn { name: name.into(), available: self.column_names() }),
            several => {
                let mut candidates: Vec<&str> = several.iter().map(|(known, _)| known.as_str()).collect();
                candidates.dedup();
                Err(ParticlesError::AmbiguousColumn { name: name.into(), candidates: candidates.join(", ") })
            }
        }
    }

    /// The names that [`Particles::column`] takes, separated by commas, those of components and of the source in brackets.
    pub fn column_names(&self) -> String {
        let with = |name: &str, others: String| {
            if others.is_empty() { name.to_owned() } else { format!("{name} ({others})") }
        };
        let mut all: Vec<String> = Vec::new();
        for q in &self.quantities {
            let own = self.source_names(&q.name);
            let others = match (q.components, own) {
                (1, _) => own.join(", "),
                (n, own) if own.len() == n && n <= 3 => own.join(", "),
                (n, [first, .., last]) if own.len() == n => format!("{first} … {last}"),
                (n, own) => {
                    let numbered = format!("{0}[1] … {0}[{n}]", q.name);
                    own.iter().cloned().chain([numbered]).collect::<Vec<_>>().join(", ")
                }
            };
            all.push(with(&q.name, others));
        }
        let beside = [("id", self.ids().is_some()), ("type", self.types().is_some()), ("radius", self.radii().is_ok())];
        for (name, _) in beside.iter().filter(|(name, there)| *there && self.quantity_named(name).is_none()) {
            all.push(with(name, self.source_names(name).join(", ")));
            if *name == "radius" {
                all.extend(self.source_names("diameter").first().map(|own| with("diameter", own.clone())));
            }
        }
        all.join(", ")
    }

    pub(crate) fn quantity_named(&self, name: &str) -> Option<&Quantity> {
        self.quantities.iter().find(|q| q.name == name)
    }

    /// Everything that a name may stand for; of names that are the same, the first counts.
    fn targets(&self) -> Vec<(String, Target)> {
        // A quantity's own name goes before what another column of the source is called.
        let mut all: Vec<(String, Target)> =
            self.quantities.iter().enumerate().map(|(index, q)| (q.name.clone(), Target::Whole(index))).collect();
        let beside = [
            ("id", Target::Ids, self.ids().is_some()),
            ("type", Target::Types, self.types().is_some()),
            ("radius", Target::Radii, self.radii().is_ok()),
        ];
        for (name, target, _) in beside.into_iter().filter(|&(.., there)| there) {
            all.push((name.into(), target));
            all.extend(self.source_names(name).iter().map(|own| (own.clone(), target)));
        }
        if self.radii().is_ok()
            && let [own] = self.source_names("diameter")
        {
            all.extend([own.as_str(), "diameter"].map(|name| (name.into(), Target::Diameters)));
        }
        for (index, q) in self.quantities.iter().enumerate() {
            let own = self.source_names(&q.name);
            let by_component = own.len() == q.components && q.components > 1;
            for (k, name) in own.iter().enumerate() {
                let target = if by_component { Target::Component(index, k) } else { Target::Whole(index) };
                all.push((name.clone(), target));
            }
            if q.components > 1 {
                for array in std::iter::once(&q.name).chain(own.iter().filter(|_| !by_component)) {
                    all.extend((0..q.components).map(|k| (format!("{array}[{}]", k + 1), Target::Component(index, k))));
                }
            }
        }
        all
    }

    /// The numbers, under the standard name where they are a whole column and under `known` where they are a part of one.
    fn column_of(&self, target: Target, known: &str) -> Cow<'_, Quantity> {
        let scalar = |name: &str, data: Vec<f64>| Cow::Owned(Quantity { name: name.into(), components: 1, data });
        let radii = self.radii().unwrap_or_default();
        match target {
            Target::Whole(index) => Cow::Borrowed(&self.quantities[index]),
            Target::Component(index, k) => {
                let quantity = &self.quantities[index];
                scalar(known, quantity.data.chunks_exact(quantity.components).map(|row| row[k]).collect())
            }
            Target::Ids => scalar("id", self.ids().unwrap_or_default().iter().map(|&id| id as f64).collect()),
            Target::Types => scalar("type", self.types().unwrap_or_default().iter().map(|&t| t as f64).collect()),
            Target::Radii => scalar("radius", radii.to_vec()),
            Target::Diameters => scalar("diameter", radii.iter().map(|r| 2.0 * r).collect()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scalar(name: &str, value: f64) -> Quantity {
        Quantity { name: name.into(), components: 1, data: vec![value] }
    }

    fn one() -> Particles {
        Particles::new(vec![[0.0; 3]]).unwrap()
    }

    #[test]
    fn a_component_is_found_by_the_sources_name_and_never_by_a_neighbours() {
        let data = vec![10.0, 20.0, 30.0, 40.0];
        let p = one().with_quantity(Quantity { name: "c_w".into(), components: 4, data }).unwrap();
        let p = p.with_source_names("c_w", &["c_w[1]", "c_w[2]", "c_w[3]", "c_w[4]"]);
        for (k, value) in [10.0, 20.0, 30.0, 40.0].into_iter().enumerate() {
            let name = format!("c_w[{}]", k + 1);
            let found = p.column(&name).unwrap();
            assert_eq!((found.name.as_str(), found.components, &found.data[..]), (name.as_str(), 1, &[value][..]));
        }
        for name in ["c_w[0]", "c_w[5]", "c_w[", "c_w[-1]"] {
            let message = p.column(name).unwrap_err().to_string();
            assert!(message.ends_with("the particles have: c_w (c_w[1] … c_w[4])"), "{message}");
        }
    }

    #[test]
    fn columns_are_found_in_any_letter_case_unless_that_would_be_a_guess() {
        let p = one().with_quantity(scalar("mass", 2.0)).unwrap().with_source_names("mass", &["Mass"]);
        for name in ["mass", "Mass", "MASS"] {
            assert_eq!(p.column(name).unwrap().data, [2.0], "{name}");
        }
        // Numbers that are none are equal to nothing, and still one column.
        let p = one().with_quantity(scalar("mass", f64::NAN)).unwrap().with_source_names("mass", &["Mass"]);
        assert!(p.column("MASS").unwrap().data[0].is_nan());
        let p = one().with_quantity(scalar("u", 1.0)).unwrap().with_quantity(scalar("U", 2.0)).unwrap();
        assert_eq!((p.column("u").unwrap().data[0], p.column("U").unwrap().data[0]), (1.0, 2.0));
        let p = p.with_quantity(scalar("Wave", 3.0)).unwrap().with_quantity(scalar("WAVE", 4.0)).unwrap();
        let message = p.column("wave").unwrap_err().to_string();
        assert!(message.contains("'wave'") && message.contains("Wave, WAVE"), "{message}");
    }

    #[test]
    fn a_diameter_is_twice_the_radius_and_is_gone_where_another_radius_is_given() {
        let p = one().with_radii(vec![0.25]).unwrap().with_source_names("diameter", &["d"]);
        assert_eq!((p.column("d").unwrap().data[0], p.column("radius").unwrap().data[0]), (0.5, 0.25));
        assert_eq!(p.column_names(), "radius, diameter (d)");
        let p = p.with_uniform_radius(3.0).unwrap();
        assert!(p.column("d").is_err() && p.column("radius").unwrap().data == [3.0]);
    }

    #[test]
    fn a_quantity_goes_before_what_the_source_calls_another_one() {
        let p = one().with_quantity(scalar("density", 1.0)).unwrap().with_source_names("density", &["rho"]);
        let p = p.with_quantity(scalar("rho", 2.0)).unwrap();
        assert_eq!((p.column("rho").unwrap().data[0], p.column("density").unwrap().data[0]), (2.0, 1.0));
        // A column that is replaced is no longer the source's.
        let p = p.with_quantity(scalar("density", 3.0)).unwrap();
        assert!(p.source_names("density").is_empty());
    }
}
