//! OpenFOAM: polyhedral meshes, fields on cells, particle clouds.
//!
//! All files share one syntax: a `FoamFile` header that states format and number widths, comments as in C++,
//! lists `N(…)`, `N{value}` or raw bytes between parentheses, dictionaries in braces. Plain files and `.gz`
//! beside or instead of them are read alike.

mod boundary;
mod case_order;
mod decomposed;
mod decomposed_cloud;
mod fields;
mod header;
mod lagrangian;
mod list;
mod locate;
mod poly_mesh;
mod stream;

pub use case_order::has_case_order;
pub(crate) use decomposed_cloud::{parts_of_cloud, read_parts};
pub use fields::{
    Dimensions, FieldEncoding, InternalField, InternalValues, VolField, read_internal_field, write_vol_field,
};
pub use lagrangian::read_cloud;
pub use locate::{is_same_mesh, mesh_of_time};
pub use poly_mesh::read_poly_mesh;
