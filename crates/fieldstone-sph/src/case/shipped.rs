/// A case that comes with the crate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShippedCase {
    /// Its name.
    pub name: &'static str,
    /// The file.
    pub text: &'static str,
}

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
];
