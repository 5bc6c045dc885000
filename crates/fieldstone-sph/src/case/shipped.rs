use super::Case;
use crate::SphError;

/// A case that comes with the crate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShippedCase {
    /// Its name.
    pub name: &'static str,
    /// The file.
    pub text: &'static str,
}

impl ShippedCase {
    /// The case, at another spacing if one is given.
    ///
    /// A slab keeps its nine layers: its width goes with the spacing.
    ///
    /// # Errors
    /// As [`Case::parse`].
    ///
    /// ```
    /// use fieldstone_sph::SHIPPED;
    /// let slab = SHIPPED.iter().find(|case| case.name == "dam-break-slab").expect("a shipped case");
    /// // 30 columns, 15 rows, 9 layers.
    /// assert_eq!(slab.at_spacing(Some(0.04))?.state()?.len(), 30 * 15 * 9);
    /// # Ok::<(), fieldstone_sph::SphError>(())
    /// ```
    pub fn at_spacing(&self, spacing: Option<f64>) -> Result<Case, SphError> {
        let case = Case::parse(self.text, self.name)?;
        let Some(spacing) = spacing else { return Ok(case) };
        if self.name != SLAB {
            return case.with_spacing(spacing);
        }
        let width = format!("{},", SLAB_LAYERS * spacing);
        // Both at once: neither the old width nor the new one goes with the other spacing.
        let text = self.text.replace(SLAB_WIDTH, &width).replace(SLAB_SPACING, &format!("spacing = {spacing}\n"));
        Case::parse(&text, self.name)
    }
}

/// The case whose width goes with its spacing: its width and spacing as they stand in its file, and its layers.
const SLAB: &str = "dam-break-slab";
const SLAB_WIDTH: &str = "0.18,";
const SLAB_SPACING: &str = "spacing = 0.02\n";
const SLAB_LAYERS: f64 = 9.0;

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        &[$(ShippedCase { name: $name, text: include_str!(concat!("../../cases/", $name, ".toml")) }),*]
    };
}

/// All cases that come with the crate.
pub const SHIPPED: &[ShippedCase] = shipped![
    "dam-break",
    "dam-break-slab",
    "double-dam-break",
    "obstacle",
    "column-1-2",
    "spheric-2",
    "hydrostatic",
    "drop",
    "taylor-green",
    "rotating-patch",
    "elliptic-drop",
    "standing-wave",
    "piston",
];
