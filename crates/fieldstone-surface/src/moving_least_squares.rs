use glam::{DMat4, DVec4};
use rayon::prelude::*;

use crate::density_field::checked_volumes;
use crate::kernel::{Kernel, Smoothing};
use crate::{SurfaceError, Surroundings, WendlandC2};

/// How the values at a point were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Support {
    /// No particle within the kernel: the value is 0.
    None = 0,
    /// A weighted mean, exact for constants only: the neighbours do not span space.
    Shepard = 1,
    /// Moving least squares, exact for linear fields.
    Linear = 2,
}

/// Values of particle quantities at points.
#[derive(Debug, Clone, PartialEq)]
pub struct Interpolated {
    /// For each quantity, its components at each point, point by point.
    pub values: Vec<Vec<f64>>,
    /// How each point got its values.
    pub support: Vec<Support>,
}

/// A column on particles that is to be interpolated.
#[derive(Debug, Clone, Copy)]
pub struct Column<'a> {
    /// Numbers per particle.
    pub components: usize,
    /// `components` numbers for each particle.
    pub data: &'a [f64],
}

/// Squared pivots of the moment matrix, scaled to a unit diagonal, below which it counts as singular.
const SINGULAR: f64 = 1e-3;

/// Interpolates particle quantities to points by moving least squares of first order.
///
/// $$ f(x) = e_0^T A^{-1} \sum_j V_j W_j\, p_j f_j, \qquad A = \sum_j V_j W_j\, p_j p_j^T, \qquad
///    p_j = (1, (x_j - x)/h) $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | f_j | a quantity of fluid particle j; boundary particles do not count | the quantity's |
/// | W_j | Wendland C2 at \|x − x_j\| with h = `smoothing_length` Δx; 1.5 is a good choice | length^−d |
/// | A | moment matrix, 4 × 4, in two dimensions 3 × 3 | – |
///
/// Exact for linear fields wherever the neighbours span space, up to the surface and half a spacing beyond. Where A is
/// singular (fewer than four neighbours, a sheet, a line; in the plane fewer than three, a line) Shepard's mean Σ V W f / Σ V W takes its place, and
/// [`Interpolated::support`] tells where. Periodic images count. Mirror images do not: with the values of their particles
/// a field's slope would vanish at walls, hydrostatic pressure's too. So linear fields are exact up to walls, from the
/// particles before them.
///
/// Source: `liu2022`, Sec. 4.3; A as in Belytschko's moving least squares.
///
/// # Errors
/// A column of the wrong length; a smoothing length outside 0.5 to 20; as [`Surroundings::grid`].
///
/// ```
/// use fieldstone_surface::{Column, Surroundings, interpolate};
/// let block: Vec<[f64; 3]> = (0..1000).map(|i| [i % 10, i / 10 % 10, i / 100].map(f64::from)).collect();
/// let linear: Vec<f64> = block.iter().map(|p| 1.0 + 2.0 * p[0] - p[2]).collect();
/// let columns = [Column { components: 1, data: &linear }];
/// let found = interpolate(&block, &Surroundings::new(1.0), &columns, &[[0.2, 4.4, 9.3]], 1.5)?;
/// assert!((found.values[0][0] - (1.0 + 0.4 - 9.3)).abs() < 1e-12);
/// # Ok::<(), fieldstone_surface::SurfaceError>(())
/// ```
pub fn interpolate(
    positions: &[[f64; 3]],
    surroundings: &Surroundings,
    columns: &[Column<'_>],
    points: &[[f64; 3]],
    smoothing_length: f64,
) -> Result<Interpolated, SurfaceError> {
    let (spacing, dimension) = (surroundings.spacing, surroundings.dimension);
    let uniform = spacing.powi(dimension as i32);
    let smoothing = Smoothing { kernel: Kernel::WendlandC2, length: smoothing_length };
    smoothing.validate()?;
    for column in columns {
        let expected = positions.len() * column.components;
        if column.components == 0 || column.data.len() != expected {
            return Err(SurfaceError::Length { name: "a column", found: column.data.len(), expected });
        }
    }
    let volumes = checked_volumes(positions, surroundings)?;
    let candidates = surroundings.candidates.as_deref();
    let reach = smoothing.support() * spacing;
    let grid = surroundings.grid_between(&[], positions, reach)?;
    let h = smoothing_length * spacing;
    let kernel = WendlandC2::new(h, dimension);
    let width: usize = columns.iter().map(|c| c.components).sum();

    let at_point = |point: &[f64; 3]| -> (Vec<f64>, Support) {
        let mut neighbours: Vec<(usize, f64, DVec4)> = Vec::new();
        let mut moments = DMat4::ZERO;
        // The reach is the grid's own.
        let _ = grid.for_each_within(*point, reach, |particle, [x, y, z], squared| {
            let weight = volumes.map_or(uniform, |v| v[particle]) * kernel.value_at_square(squared);
            if weight > 0.0 && candidates.is_none_or(|c| c[particle]) {
                let p = DVec4::new(1.0, x / h, y / h, z / h);
                moments +=
                    DMat4::from_cols(p * (weight * p.x), p * (weight * p.y), p * (weight * p.z), p * (weight * p.w));
                neighbours.push((particle, weight, p));
            }
        });
        let mut values = vec![0.0; width];
        let total = moments.x_axis.x;
        if neighbours.is_empty() || total <= 0.0 {
            return (values, Support::None);
        }
        if dimension == 2 {
            // There is no slope along z: a row of its own keeps the other three apart.
            moments.w_axis.w = 1.0;
        }
        let solved = first_column_of_inverse(&moments);
        let coefficients = solved.unwrap_or(DVec4::new(1.0 / total, 0.0, 0.0, 0.0));
        for &(particle, weight, p) in &neighbours {
            let share = weight * coefficients.dot(p);
            let mut at = 0;
            for column in columns {
                for value in &column.data[particle * column.components..(particle + 1) * column.components] {
                    values[at] += share * value;
                    at += 1;
                }
            }
        }
        (values, if solved.is_some() { Support::Linear } else { Support::Shepard })
    };
    let rows: Vec<(Vec<f64>, Support)> = points.par_iter().map(at_point).collect();
    let mut start = 0;
    let mut values = Vec::with_capacity(columns.len());
    for column in columns {
        let range = start..start + column.components;
        values.push(rows.iter().flat_map(|(row, _)| &row[range.clone()]).copied().collect());
        start = range.end;
    }
    Ok(Interpolated { values, support: rows.iter().map(|row| row.1).collect() })
}

/// A⁻¹ e₀ by Cholesky's method on the matrix scaled to a unit diagonal; `None` where it is singular.
fn first_column_of_inverse(matrix: &DMat4) -> Option<DVec4> {
    let a = matrix.to_cols_array_2d();
    let scale: [f64; 4] = std::array::from_fn(|k| if a[k][k] > 0.0 { 1.0 / a[k][k].sqrt() } else { 0.0 });
    if scale.contains(&0.0) {
        return None;
    }
    let mut lower = [[0.0; 4]; 4];
    for i in 0..4 {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
            let left = a[i][j] * scale[i] * scale[j] - sum;
            if i == j {
                if left < SINGULAR {
                    return None;
                }
                lower[i][i] = left.sqrt();
            } else {
                lower[i][j] = left / lower[j][j];
            }
        }
    }
    let mut x = [0.0; 4];
    for i in 0..4 {
        let right = if i == 0 { scale[0] } else { 0.0 };
        x[i] = (right - (0..i).map(|k| lower[i][k] * x[k]).sum::<f64>()) / lower[i][i];
    }
    for i in (0..4).rev() {
        x[i] = (x[i] - (i + 1..4).map(|k| lower[k][i] * x[k]).sum::<f64>()) / lower[i][i];
    }
    Some(DVec4::from_array(std::array::from_fn(|k| x[k] * scale[k])))
}
