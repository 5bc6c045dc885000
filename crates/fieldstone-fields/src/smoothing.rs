//! Smoothing that keeps the total.

use fieldstone_mesh::Cells;

use crate::FieldsError;
use crate::weights::check_length;

/// Steps beyond which a smoothing length is refused.
const MOST_STEPS: f64 = 20_000.0;

/// Spreads an amount per cell by diffusion over a Gaussian of standard deviation `length`, without loss.
///
/// $$ V_c \frac{\partial \varepsilon_c}{\partial t} = \sum_f \frac{A_f}{d_f} (\varepsilon_n - \varepsilon_c),
///    \qquad t = \tfrac12 \ell^2 $$
///
/// | symbol | meaning |
/// |---|---|
/// | ε | amount per volume of a cell |
/// | A, d | area of the common face, distance of the centres |
/// | ℓ | `length` |
///
/// What leaves a cell through a face enters its neighbour; nothing crosses the boundary; values never leave the
/// range of the input. Explicit steps at half the stability limit. On skewed meshes the flux neglects the
/// direction along the face. Source: `capecelatro2013` use the same equation on structured meshes.
///
/// # Errors
/// One amount per cell is needed; a length that is not finite, negative, or so long that it takes more than
/// 20,000 steps.
///
/// ```
/// use fieldstone_fields::smooth_conservatively;
/// use fieldstone_mesh::Grid;
/// let row = Grid::new([0.0; 3], [9.0, 1.0, 1.0], [9, 1, 1])?;
/// let mut amount = vec![0.0; 9];
/// amount[4] = 1.0;
/// let smooth = smooth_conservatively(&row, &amount, 1.0)?;
/// assert!((smooth.iter().sum::<f64>() - 1.0).abs() < 1e-15);
/// assert!(smooth[4] > 0.35 && smooth[4] < 0.45);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn smooth_conservatively<C: Cells>(cells: &C, amount: &[f64], length: f64) -> Result<Vec<f64>, FieldsError> {
    let count = cells.cell_count();
    check_length("cells", amount.len(), count)?;
    if !(length >= 0.0 && length.is_finite()) {
        return Err(FieldsError::Option {
            name: "the smoothing length",
            value: length,
            allowed: "finite and not negative",
        });
    }
    let mut links: Vec<(u32, u32, f64)> = Vec::new();
    let mut longest_step = f64::INFINITY;
    for cell in 0..count {
        let mut sum = 0.0;
        cells.for_each_neighbour(cell, &mut |other, conductance| {
            sum += conductance;
            if (cell as u32) < other {
                links.push((cell as u32, other, conductance));
            }
        });
        if sum > 0.0 {
            longest_step = longest_step.min(0.5 * cells.cell_volume(cell) / sum);
        }
    }
    let mut amount = amount.to_vec();
    if length == 0.0 || links.is_empty() {
        return Ok(amount);
    }
    let duration = 0.5 * length * length;
    let steps = (duration / longest_step).ceil().max(1.0);
    if steps > MOST_STEPS {
        let longest = (2.0 * MOST_STEPS * longest_step).sqrt();
        return Err(FieldsError::SmoothingLength { length, steps, longest });
    }
    let step = duration / steps;
    let volumes: Vec<f64> = (0..count).map(|cell| cells.cell_volume(cell)).collect();
    let mut gain = vec![0.0; count];
    for _ in 0..steps as usize {
        gain.fill(0.0);
        for &(a, b, conductance) in &links {
            let (a, b) = (a as usize, b as usize);
            let flow = step * conductance * (amount[b] / volumes[b] - amount[a] / volumes[a]);
            gain[a] += flow;
            gain[b] -= flow;
        }
        amount.iter_mut().zip(&gain).for_each(|(x, g)| *x += g);
    }
    Ok(amount)
}

#[cfg(test)]
mod tests {
    use fieldstone_mesh::Grid;

    use super::*;

    #[test]
    fn a_point_becomes_a_gaussian_of_the_given_width() {
        let grid = Grid::new([0.0; 3], [41.0, 1.0, 1.0], [41, 1, 1]).unwrap();
        let mut amount = vec![0.0; 41];
        amount[20] = 1.0;
        let smooth = smooth_conservatively(&grid, &amount, 3.0).unwrap();
        let variance: f64 = smooth.iter().enumerate().map(|(i, a)| a * (i as f64 - 20.0).powi(2)).sum();
        assert!((variance - 9.0).abs() < 0.01, "{variance}");
    }

    #[test]
    fn nothing_is_lost_and_nothing_overshoots_on_cells_of_unequal_size() {
        let grid = Grid::new([0.0; 3], [3.0, 1.0, 5.0], [5, 4, 3]).unwrap();
        let amount: Vec<f64> = (0..60).map(|i| f64::from(i * i % 7)).collect();
        let smooth = smooth_conservatively(&grid, &amount, 2.0).unwrap();
        assert!((smooth.iter().sum::<f64>() / amount.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        assert!(smooth.iter().all(|&x| (0.0..=6.0).contains(&x)));
    }

    #[test]
    fn a_length_that_would_take_forever_is_refused_with_the_longest_that_does_not() {
        let grid = Grid::new([0.0; 3], [1.0, 1.0, 1e-4], [2, 2, 2]).unwrap();
        let error = smooth_conservatively(&grid, &[1.0; 8], 1.0).unwrap_err();
        assert!(matches!(error, FieldsError::SmoothingLength { longest, .. } if longest < 1.0), "{error}");
        assert!(smooth_conservatively(&grid, &[1.0; 8], f64::NAN).is_err());
    }
}
