//! MercuryCG's names of fields.

/// The name of a field in a `.stat` file: `ContactStress` for `contact_stress`.
pub(crate) fn mercury_name(name: &str) -> String {
    if name == "boundary_force_density" {
        return "InteractionForce".into();
    }
    let capital = |word: &str| {
        let mut letters = word.chars();
        letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
    };
    name.split(['_', ' ']).map(capital).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_standard_fields_have_the_names_that_mercury_writes() {
        let names: Vec<String> =
            fieldstone::fields::FieldName::standard().iter().map(|field| mercury_name(field.name())).collect();
        let theirs = [
            "VolumeFraction",
            "Density",
            "Momentum",
            "MomentumFlux",
            "ContactStress",
            "InteractionForce",
            "ParticleSize",
        ];
        assert_eq!(names, theirs);
    }
}
