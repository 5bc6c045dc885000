//! The result: fields, and where everything went.

use super::options::{ContactForm, Function, SignConvention};

/// One field on the cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Name ([`super::FieldName::name`], or the user's).
    pub name: String,
    /// Names of the components; one empty name for a scalar.
    pub components: Vec<String>,
    /// Unit, in terms of the user's units.
    pub unit: String,
    /// One number per component for each cell, cell by cell. NaN never occurs: where a mean is of nothing it is 0.
    pub data: Vec<f64>,
}

impl Field {
    /// The numbers of one cell.
    pub fn cell(&self, cell: usize) -> &[f64] {
        let n = self.components.len();
        &self.data[cell * n..(cell + 1) * n]
    }
}

/// Names of so many components that nothing else is known of: the axes where they make a vector or a square tensor, else
/// numbers from 0, and one empty name for a scalar. Programs differ in the order of a symmetric tensor's six.
///
/// ```
/// use fieldstone_fields::component_names;
/// assert_eq!(component_names(3), ["x", "y", "z"]);
/// assert_eq!(component_names(6), ["0", "1", "2", "3", "4", "5"]);
/// ```
pub fn component_names(count: usize) -> Vec<String> {
    let axes: &[&str] = match count {
        1 => &[""],
        3 => &["x", "y", "z"],
        9 => &["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"],
        _ => return (0..count).map(|k| k.to_string()).collect(),
    };
    axes.iter().map(|name| (*name).into()).collect()
}

/// Fields of a frame, or averaged over several.
#[derive(Debug, Clone, PartialEq)]
pub struct Fields {
    /// The fields asked for, in that order, then the user's quantities.
    pub fields: Vec<Field>,
    /// Sign of the stresses in them.
    pub sign: SignConvention,
    /// How cells saw particles.
    pub function: Function,
    /// How contacts were spread.
    pub contact_form: ContactForm,
    /// What came in and what was placed.
    pub ledger: CoarseGrainingLedger,
}

impl Fields {
    /// The field called `name`.
    pub fn get(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|f| f.name == name)
    }
}

/// What came in, what was placed in cells, and what is left: means over the frames, weighted as they were.
///
/// For exact overlaps `mass_in = mass_binned + mass_clipped` to rounding, and `mass_clipped` is found from the particles'
/// own rows, not from the difference. Point-sampled kernels conserve nothing: there, `mass_clipped` is what the samples
/// of the particles miss, negative where they see too much.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CoarseGrainingLedger {
    /// Frames accumulated.
    pub frames: usize,
    /// Particles selected in the last frame.
    pub particles: usize,
    /// Contacts of selected particles in the last frame; each pair once.
    pub contacts: usize,
    /// Σ m.
    pub mass_in: f64,
    /// Σ ρ V_c.
    pub mass_binned: f64,
    /// Σ m of what lies outside all cells.
    pub mass_clipped: f64,
    /// Σ m v; zero without velocities.
    pub momentum_in: [f64; 3],
    /// Σ j V_c; zero unless the momentum is among the sums.
    pub momentum_binned: [f64; 3],
    /// Σ f ⊗ l over all contacts, with the sign of the stresses.
    pub stress_sum_contacts: [f64; 9],
    /// Σ σ V_c; zero unless the contact stress is among the sums.
    pub stress_sum_fields: [f64; 9],
    /// Σ |f| |l| over all contacts: the size of what the two sums add up, which may cancel.
    pub stress_scale: f64,
}
