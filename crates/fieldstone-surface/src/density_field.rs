use rayon::prelude::*;

use crate::fluid_region::FluidRegion;
use crate::kernel::{Kernel, Smoothing};
use crate::{NodeField, Nodes, PeriodicFaces, SurfaceError, Surroundings, WendlandC2};

/// The share of space that the particles' volumes fill, smoothed: 1 inside the fluid, 0 outside, ½ on the surface.
///
/// $$ C(x) = \sum_j V_j W(|x - x_j|, h) $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | V_j | m/ρ, or Δx^d ([`Surroundings::volumes`]) | length^d |
/// | W | Wendland C2 of d dimensions, 2 or 3 | length^−d |
/// | h | `smoothing_length` times Δx; 1.25 is a good choice | length |
///
/// The volume inside C = ½ is that of the particles up to O((h/R)²) at a surface of radius of curvature R: at a plane the
/// errors of both sides cancel. Needs no labels and no normals. Drops of a few particles and sheets thinner than about h
/// vanish: [`level_set`](crate::level_set) keeps them. Mirror images, boundary particles and periodic images count, and
/// where the fluid ends because of them the field is cut ([`NodeField::at_wall`]); whether it does at the faces of a
/// periodic box is for `periodic_faces` to say.
///
/// # Errors
/// A smoothing length outside 0.5 to 20; as [`Surroundings::grid`].
///
/// ```
/// use fieldstone_surface::{Nodes, PeriodicFaces, Surroundings, density_field};
/// // At a particle that is alone: Δx³ W(0) = 21/(16 π h³), here with Δx = 1 and h = 1.25.
/// let nodes = Nodes::new([0.0; 3], [1.0; 3], [2; 3])?;
/// let field = density_field(&[[0.0; 3]], &Surroundings::new(1.0), &nodes, 1.25, PeriodicFaces::End)?;
/// let expected = 21.0 / (16.0 * std::f64::consts::PI * 1.25f64.powi(3));
/// assert!((field.values[0] - expected).abs() < 1e-15);
/// # Ok::<(), fieldstone_surface::SurfaceError>(())
/// ```
pub fn density_field(
    positions: &[[f64; 3]],
    surroundings: &Surroundings,
    nodes: &Nodes,
    smoothing_length: f64,
    periodic_faces: PeriodicFaces,
) -> Result<NodeField, SurfaceError> {
    let (spacing, dimension) = (surroundings.spacing, surroundings.dimension);
    let uniform = spacing.powi(dimension as i32);
    let smoothing = Smoothing { kernel: Kernel::WendlandC2, length: smoothing_length };
    smoothing.validate()?;
    let volumes = checked_volumes(positions, surroundings)?;
    let reach = smoothing.support() * spacing;
    let points = surroundings.grid(positions, reach)?;
    let region = FluidRegion::new(surroundings, reach, periodic_faces);
    let kernel = WendlandC2::new(smoothing_length * spacing, dimension);
    let value = |node: usize| -> (f64, bool) {
        let at = nodes.position(node);
        let mut sum = 0.0;
        // The reach is the grid's own.
        let _ = points.for_each_within(at, reach, |particle, _, squared| {
            sum += volumes.map_or(uniform, |v| v[particle]) * kernel.value_at_square(squared);
        });
        if !region.has_limits() {
            return (sum, false);
        }
        // ½ at the limit, with about the slope of the field at a free surface.
        let limit = 0.5 + region.at(&points, at).limit / (2.0 * smoothing_length * spacing);
        (sum.min(limit), limit <= sum && limit <= 0.5)
    };
    let pairs: Vec<(f64, bool)> = (0..nodes.len()).into_par_iter().map(value).collect();
    let at_wall = if region.has_limits() { pairs.iter().map(|p| p.1).collect() } else { Vec::new() };
    Ok(NodeField {
        nodes: nodes.clone(),
        values: pairs.into_iter().map(|p| p.0).collect(),
        surface_value: 0.5,
        at_wall,
    })
}

pub(crate) fn checked_volumes<'a>(
    positions: &[[f64; 3]],
    surroundings: &'a Surroundings,
) -> Result<Option<&'a [f64]>, SurfaceError> {
    let volumes = surroundings.volumes.as_deref();
    if let Some(volumes) = volumes
        && volumes.len() != positions.len()
    {
        return Err(SurfaceError::Length { name: "the volume", found: volumes.len(), expected: positions.len() });
    }
    Ok(volumes)
}
