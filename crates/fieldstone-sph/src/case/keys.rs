//! What is asked of the keys of a section: that they go with its kind, and numbers in their range.

use super::sections::Fault;

/// Refuses the first key that is given and does not go with `kind`, such as `shape = "box"`.
pub(super) fn only(kind: &str, takes: &[&str], keys: &[(&'static str, bool)]) -> Result<(), Fault> {
    match keys.iter().find(|(key, given)| *given && !takes.contains(key)) {
        None => Ok(()),
        Some((key, _)) => Err((key, format!("{key} does not go with {kind}, which takes {}", takes.join(", ")))),
    }
}

/// A vector with as many finite numbers as there are dimensions.
pub(super) fn vector(key: &'static str, given: &[f64], dimension: usize) -> Result<[f64; 3], Fault> {
    if given.len() != dimension || given.iter().any(|x| !x.is_finite()) {
        return Err((key, format!("{key} is {given:?}; give {dimension} finite numbers")));
    }
    Ok(std::array::from_fn(|k| given.get(k).copied().unwrap_or(0.0)))
}

/// A number above 0 that `owner` needs: a shape, a flow, or the section itself.
pub(super) fn positive(owner: &'static str, key: &'static str, given: Option<f64>) -> Result<f64, Fault> {
    match given {
        Some(x) if x > 0.0 && x.is_finite() => Ok(x),
        Some(x) => Err((key, format!("{key} is {x}; it must be finite and above 0"))),
        None => Err((owner, format!("this {owner} needs {key}"))),
    }
}

/// A finite number that `owner` needs.
pub(super) fn finite(owner: &'static str, key: &'static str, given: Option<f64>) -> Result<f64, Fault> {
    match given {
        Some(x) if x.is_finite() => Ok(x),
        Some(x) => Err((key, format!("{key} is {x}; it must be finite"))),
        None => Err((owner, format!("this {owner} needs {key}"))),
    }
}
