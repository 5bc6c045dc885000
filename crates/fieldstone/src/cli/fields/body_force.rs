//! The weight of what the cells hold.

use fieldstone::fields::{Field, Fields};

/// ρ g of every density there is: that of all, and those of species.
pub(super) fn body_forces(fields: &Fields, g: [f64; 3]) -> Vec<Field> {
    let force = |density: &Field| {
        let of = density.name.strip_prefix("density").filter(|of| of.is_empty() || of.starts_with("_species_"))?;
        Some(Field {
            name: format!("body_force_density{of}"),
            components: ["x", "y", "z"].map(String::from).into(),
            unit: "force/length³".into(),
            data: density.data.iter().flat_map(|rho| g.map(|g| rho * g)).collect(),
        })
    };
    fields.fields.iter().filter_map(force).collect()
}
