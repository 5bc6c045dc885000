//! Names of fields as other programs have them, and formulas in the letters that they read.

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

/// A formula in ASCII, with the letters' names: `rho = sum m phi`.
pub(super) fn ascii(formula: &str) -> String {
    let mut all = String::with_capacity(formula.len());
    for c in formula.chars() {
        let word = match c {
            'ν' => "nu",
            'ρ' => "rho",
            'σ' => "sigma",
            'φ' => "phi",
            'ψ' => "psi",
            'ω' => "omega",
            'Σ' => "sum",
            '∫' => "integral",
            '∂' => "d",
            '⊗' => "(x)",
            '×' => " x ",
            '·' => ".",
            '−' => "-",
            '…' => "...",
            '½' => "1/2",
            '⅖' => "2/5",
            '²' => "^2",
            '³' => "^3",
            'ᵏ' => "^k",
            'ᶜ' => "^c",
            '′' => "'",
            _ => {
                all.push(c);
                continue;
            }
        };
        let beside_a_letter = all.chars().next_back().is_some_and(char::is_alphanumeric) && word.len() > 1;
        if beside_a_letter && word.starts_with(char::is_alphabetic) {
            all.push(' ');
        }
        all.push_str(word);
    }
    all.replace("  ", " ")
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

    #[test]
    fn every_formula_and_unit_has_a_form_in_ascii() {
        for field in fieldstone::fields::FieldName::ALL {
            let line = ascii(&format!("{}, in {}", field.formula(), field.unit()));
            assert!(line.is_ascii(), "{line}");
        }
        assert_eq!(ascii("σᵏ = k − ρ u⊗u"), "sigma^k = k - rho u(x)u");
    }
}
