//! Which directions a grid resolves.

use std::fmt;
use std::str::FromStr;

use crate::MeshError;

/// The directions along which fields vary; along the others they are averages.
///
/// Written as MercuryCG does: `O` for none, `X`, `Y`, `Z`, `XY`, `XZ`, `YZ`, `XYZ`.
///
/// ```
/// use fieldstone_mesh::Coordinates;
/// let depth: Coordinates = "Z".parse()?;
/// assert_eq!(depth.resolved(), [false, false, true]);
/// assert_eq!(Coordinates::default().to_string(), "XYZ");
/// # Ok::<(), fieldstone_mesh::MeshError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coordinates([bool; 3]);

impl Coordinates {
    /// The marked directions resolved.
    pub fn new(resolved: [bool; 3]) -> Self {
        Self(resolved)
    }

    /// Whether each direction is resolved.
    pub fn resolved(self) -> [bool; 3] {
        self.0
    }
}

impl Default for Coordinates {
    fn default() -> Self {
        Self([true; 3])
    }
}

impl FromStr for Coordinates {
    type Err = MeshError;

    fn from_str(text: &str) -> Result<Self, MeshError> {
        let all = (0..8).map(|bits| Self([bits & 1 != 0, bits & 2 != 0, bits & 4 != 0]));
        let upper = text.to_ascii_uppercase();
        all.into_iter().find(|c| c.to_string() == upper).ok_or_else(|| MeshError::UnknownCoordinates(text.into()))
    }
}

impl fmt::Display for Coordinates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 == [false; 3] {
            return f.write_str("O");
        }
        ["X", "Y", "Z"].iter().zip(self.0).filter(|(_, resolved)| *resolved).try_for_each(|(name, _)| f.write_str(name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_set_of_directions_reads_back_its_own_name_and_others_are_refused() {
        for name in ["O", "X", "Y", "Z", "XY", "XZ", "YZ", "XYZ"] {
            assert_eq!(name.parse::<Coordinates>().unwrap().to_string(), name);
        }
        for bad in ["", "ZX", "XX", "OX", "R"] {
            assert!(bad.parse::<Coordinates>().is_err(), "{bad}");
        }
    }
}
