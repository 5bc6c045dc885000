//! Units behind the names of columns: `Pos.x [m]`.

/// What stands in brackets behind a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unit<'a> {
    /// None, or nothing that is known as one: `c_st[1]`, `T [degC]`.
    None,
    /// One of SI, or none at all: `[m]`, `[kg/m^3]`, `[-]`.
    Coherent,
    /// A multiple of one of SI: `[mm]`, `[g/cm3]`.
    Scaled(&'a str),
}

/// Units of SI without factors between them.
const COHERENT: [&str; 14] = ["m", "s", "kg", "N", "Pa", "J", "W", "Hz", "rad", "sr", "K", "mol", "A", "V"];

/// Others that have no prefix or the same letters as one that has.
const SCALED: [&str; 16] =
    ["g", "min", "h", "hr", "l", "L", "in", "inch", "ft", "bar", "mbar", "atm", "psi", "deg", "°", "rpm"];

/// Decimal prefixes; `u` stands for micro.
const PREFIXES: [&str; 13] = ["da", "k", "M", "G", "h", "d", "c", "m", "u", "µ", "μ", "n", "p"];

/// The name without the unit behind it, and that unit.
pub(crate) fn split(name: &str) -> (&str, Unit<'_>) {
    let parts = name.trim_end().strip_suffix(']').and_then(|rest| rest.rsplit_once('['));
    let Some((bare, text)) = parts.map(|(bare, text)| (bare.trim_end(), text.trim())) else {
        return (name, Unit::None);
    };
    match unit(text) {
        // A name of nothing but brackets, and a number of a component, are no units.
        _ if bare.is_empty() || text.bytes().all(|b| b.is_ascii_digit()) => (name, Unit::None),
        Unit::None => (name, Unit::None),
        unit => (bare, unit),
    }
}

/// A product of units with exponents, such as `kg/m^3`, `m.s-1` or `1/s`.
fn unit(text: &str) -> Unit<'_> {
    if text == "-" {
        return Unit::Coherent;
    }
    let mut found = Unit::None;
    for factor in text.split(['/', '*', '·', '.', ' ']).filter(|factor| !factor.is_empty()) {
        let symbol = factor.trim_end_matches(|c: char| c.is_ascii_digit() || "²³⁻¹".contains(c));
        let symbol = symbol.trim_end_matches(['-', '+', '^', '(', ')']);
        let prefixed = || {
            PREFIXES.iter().any(|p| symbol.strip_prefix(p).is_some_and(|rest| rest == "g" || COHERENT.contains(&rest)))
        };
        match symbol {
            "" => found = if found == Unit::None { Unit::Coherent } else { found },
            known if COHERENT.contains(&known) => found = if found == Unit::None { Unit::Coherent } else { found },
            known if SCALED.contains(&known) || prefixed() => found = Unit::Scaled(text),
            _ => return Unit::None,
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_si_are_taken_off_and_multiples_of_them_are_known() {
        for text in
            ["m", "m/s", "kg/m^3", "kg/m3", "kg.m-3", "kg m^-3", "kg·m⁻³", "1/s", "-", "rad/s", "Pa", "N*m", "m²"]
        {
            let name = format!("a [{text}]");
            assert_eq!(split(&name), ("a", Unit::Coherent), "{text}");
        }
        for text in
            ["mm", "cm", "µm", "um", "km", "g", "mg", "g/cm^3", "mm/s", "kPa", "MPa", "ms", "min", "deg", "N/mm2"]
        {
            let name = format!("a[{text}]");
            assert_eq!(split(&name), ("a", Unit::Scaled(text)), "{text}");
        }
    }

    #[test]
    fn components_and_what_is_not_known_stay_parts_of_names() {
        for name in ["c_st[1]", "f_a[12]", "v[x]", "q [w]", "T [degC]", "a", "[m]", " [m]", "a[]", "a]", "a[m", "a [1]"]
        {
            assert_eq!(split(name), (name, Unit::None), "{name}");
        }
    }
}
