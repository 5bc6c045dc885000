//! The fields by name: components, units and formulas.

use std::fmt;
use std::str::FromStr;

use crate::FieldsError;

macro_rules! fields {
    ($($variant:ident $name:literal [$($component:literal)*] $unit:literal $formula:literal;)*) => {
        /// A field that coarse graining can compute.
        ///
        /// The formulas are those of [`FieldName::formula`]; the chapter on coarse graining derives them.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum FieldName {
            $(#[doc = concat!("`", $name, "`: ", $formula)] $variant,)*
        }

        impl FieldName {
            /// All of them, in the order of the documentation.
            pub const ALL: &'static [FieldName] = &[$(FieldName::$variant),*];

            /// Name in files and on the command line.
            pub fn name(self) -> &'static str {
                match self { $(FieldName::$variant => $name),* }
            }

            /// Names of the components; one empty name for a scalar.
            pub fn components(self) -> &'static [&'static str] {
                match self { $(FieldName::$variant => &[$($component),*]),* }
            }

            /// Unit, in terms of the user's units.
            pub fn unit(self) -> &'static str {
                match self { $(FieldName::$variant => $unit),* }
            }

            /// Formula in one line: compression positive, φ the weight of a particle, ψ that of a contact.
            pub fn formula(self) -> &'static str {
                match self { $(FieldName::$variant => $formula),* }
            }
        }
    };
}

fields! {
    VolumeFraction "volume_fraction" [""] "1" "ν = Σ V φ";
    Density "density" [""] "mass/length³" "ρ = Σ m φ";
    Momentum "momentum" ["x" "y" "z"] "mass/(length² time)" "j = Σ m v φ";
    MomentumFlux "momentum_flux" ["xx" "xy" "xz" "yy" "yz" "zz"] "pressure" "k = Σ m v⊗v φ";
    ContactStress "contact_stress" ["xx" "xy" "xz" "yx" "yy" "yz" "zx" "zy" "zz"] "pressure" "σᶜ = Σ f⊗b ψ, or −Σ φ Σ f⊗l";
    BoundaryForceDensity "boundary_force_density" ["x" "y" "z"] "force/length³" "IFD = Σ f φ(r − c) over contacts with walls";
    ParticleSize "particle_size" ["0" "1" "2" "3" "4" "5"] "length^(k − 3)" "Σ Rᵏ φ, k = 0…5";
    ContactForceDensity "contact_force_density" ["x" "y" "z"] "force/length³" "j^f = Σ φ Σ f";
    Velocity "velocity" ["x" "y" "z"] "length/time" "u = j/ρ";
    KineticStress "kinetic_stress" ["xx" "xy" "xz" "yy" "yz" "zz"] "pressure" "σᵏ = k − ρ u⊗u";
    GranularTemperature "granular_temperature" [""] "length²/time²" "T = tr σᵏ/(3 ρ)";
    TotalStress "total_stress" ["xx" "xy" "xz" "yx" "yy" "yz" "zx" "zy" "zz"] "pressure" "σ = σᶜ + σᵏ";
    Pressure "pressure" [""] "pressure" "p = tr σ/3";
    KineticEnergyDensity "kinetic_energy_density" [""] "pressure" "Σ ½ m v² φ";
    KineticEnergyFlux "kinetic_energy_flux" ["x" "y" "z"] "power/length²" "Σ ½ m v² v φ";
    ContactEnergyFlux "contact_energy_flux" ["x" "y" "z"] "power/length²" "Σ ½ f·(v_P + v_I) b ψ";
    AngularMomentum "angular_momentum" ["x" "y" "z"] "mass/(length time)" "Σ (r × m v + I ω) φ, about the origin, I = ⅖ m R²";
    SpinDensity "spin_density" ["x" "y" "z"] "mass/(length time)" "Σ I ω φ";
    AngularVelocity "angular_velocity" ["x" "y" "z"] "1/time" "Σ I ω φ / Σ I φ";
    MomentumWithSpin "momentum_with_spin" ["x" "y" "z"] "mass/(length² time)" "Σ m/V ∫ v + ω × (x − r) dx over the part in the cell";
    Fabric "fabric" ["xx" "xy" "xz" "yy" "yz" "zz"] "1" "F = Σ φ V Σ n⊗n";
    CoordinationNumber "coordination_number" [""] "1" "Z = Σ φ C / Σ φ";
    CoupleStress "couple_stress" ["xx" "xy" "xz" "yx" "yy" "yz" "zx" "zy" "zz"] "force/length" "Σ ½(T_P − T_I)⊗b ψ, or −Σ φ Σ T⊗l, T = l × f";
    MeanRadius "mean_radius" [""] "length" "Σ R φ / Σ φ";
    Displacement "displacement" ["x" "y" "z"] "length" "d = Σ m (r′ − r) φ / Σ m φ";
    DisplacementGradient "displacement_gradient" ["xx" "xy" "xz" "yx" "yy" "yz" "zx" "zy" "zz"] "1" "∂d_i/∂x_j of the best affine fit to the cell's particles";
    StrainIncrement "strain_increment" ["xx" "xy" "xz" "yy" "yz" "zz"] "1" "symmetric part of the displacement gradient";
}

impl FieldName {
    /// MercuryCG's 29 columns.
    pub fn standard() -> Vec<Self> {
        use FieldName::*;
        vec![VolumeFraction, Density, Momentum, MomentumFlux, ContactStress, BoundaryForceDensity, ParticleSize]
    }

    /// The fields of MercuryCG's page on exact overlap, with the contact force density.
    pub fn binning() -> Vec<Self> {
        use FieldName::*;
        vec![VolumeFraction, Density, Momentum, Velocity, ContactForceDensity, ContactStress]
    }

    /// Fields for a list: `standard`, `binning`, `all`, or names separated by commas.
    ///
    /// `all` leaves out what needs a second frame (displacements) or exact overlaps (`momentum_with_spin`).
    ///
    /// # Errors
    /// [`FieldsError::UnknownField`] for a name that there is not.
    ///
    /// ```
    /// use fieldstone_fields::FieldName;
    /// let standard = FieldName::parse_list("standard")?;
    /// assert_eq!(standard.iter().map(|f| f.components().len()).sum::<usize>(), 29);
    /// assert_eq!(FieldName::parse_list("velocity, density")?.len(), 2);
    /// # Ok::<(), fieldstone_fields::FieldsError>(())
    /// ```
    pub fn parse_list(text: &str) -> Result<Vec<Self>, FieldsError> {
        let mut list: Vec<Self> = Vec::new();
        for part in text.split(',').map(str::trim) {
            let more = match part {
                "standard" => Self::standard(),
                "binning" => Self::binning(),
                "all" => Self::ALL
                    .iter()
                    .copied()
                    .filter(|f| !f.needs_displacement() && *f != Self::MomentumWithSpin)
                    .collect(),
                name => vec![name.parse()?],
            };
            for field in more {
                if !list.contains(&field) {
                    list.push(field);
                }
            }
        }
        Ok(list)
    }

    /// Whether the particles need a `displacement` column (see [`crate::displacements`]).
    pub fn needs_displacement(self) -> bool {
        matches!(self, Self::Displacement | Self::DisplacementGradient | Self::StrainIncrement)
    }

    /// Whether contacts are needed.
    pub fn needs_contacts(self) -> bool {
        use FieldName::*;
        matches!(
            self,
            ContactStress
                | BoundaryForceDensity
                | ContactForceDensity
                | TotalStress
                | Pressure
                | ContactEnergyFlux
                | Fabric
                | CoordinationNumber
                | CoupleStress
        )
    }
}

impl FromStr for FieldName {
    type Err = FieldsError;

    fn from_str(text: &str) -> Result<Self, FieldsError> {
        Self::ALL.iter().copied().find(|f| f.name() == text).ok_or_else(|| FieldsError::UnknownField {
            name: text.into(),
            known: Self::ALL.iter().map(|f| f.name()).collect::<Vec<_>>().join(", "),
        })
    }
}

impl fmt::Display for FieldName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_reads_back_its_own_name_and_an_unknown_one_is_answered_with_the_list() {
        for &field in FieldName::ALL {
            assert_eq!(field.name().parse::<FieldName>().unwrap(), field);
            assert!(!field.components().is_empty() && !field.formula().is_empty());
        }
        let message = FieldName::parse_list("density,stress").unwrap_err().to_string();
        assert!(message.contains("'stress'") && message.contains("contact_stress"), "{message}");
    }
}
