//! Smoothing that keeps the total.

use fieldstone_mesh::Cells;
use fieldstone_particles::Domain;

use crate::FieldsError;
use crate::checks::check_length;

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
/// What leaves a cell through a face enters its neighbour; values never leave the range of the input. Nothing crosses the
/// boundary, but that of a `domain` in the directions that [`smoothed_through`] names: there the cells at one end of the
/// grid are neighbours of those at the other. Explicit steps at half the stability limit. On skewed meshes the flux neglects the
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
/// let smooth = smooth_conservatively(&row, &amount, 1.0, None)?;
/// assert!((smooth.iter().sum::<f64>() - 1.0).abs() < 1e-15);
/// assert!(smooth[4] > 0.35 && smooth[4] < 0.45);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn smooth_conservatively<C: Cells>(
    cells: &C,
    amount: &[f64],
    length: f64,
    domain: Option<&Domain>,
) -> Result<Vec<f64>, FieldsError> {
    let count = cells.cell_count();
    check_length("cells", amount.len(), count)?;
    if !(length >= 0.0 && length.is_finite()) {
        return Err(FieldsError::Option {
            name: "the smoothing length",
            value: length,
            allowed: "finite and not negative",
        });
    }
    let links = links(cells, smoothed_through(cells, domain));
    let mut conductances = vec![0.0; count];
    for &(a, b, conductance) in &links {
        conductances[a as usize] += conductance;
        conductances[b as usize] += conductance;
    }
    let longest_step = (conductances.iter().enumerate())
        .filter(|(_, sum)| **sum > 0.0)
        .map(|(cell, sum)| 0.5 * cells.cell_volume(cell) / sum)
        .fold(f64::INFINITY, f64::min);
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

/// Periodic directions through whose boundary [`smooth_conservatively`] passes: those along which the cells are an upright
/// grid that spans one period, or a whole number of them, and the period is not tilted.
pub fn smoothed_through<C: Cells>(cells: &C, domain: Option<&Domain>) -> [bool; 3] {
    let (Some(grid), Some(domain)) = (cells.as_grid(), domain) else { return [false; 3] };
    let (low, high) = (grid.low(), grid.high());
    std::array::from_fn(|k| {
        let vector = domain.cell_vectors()[k];
        let periods = (high[k] - low[k]) / vector[k];
        // The ends are differences of the numbers in a file.
        let whole = periods.round() >= 1.0 && (periods - periods.round()).abs() < 1e-9 * periods;
        domain.periodic()[k] && whole && (0..3).all(|other| other == k || vector[other] == 0.0)
    })
}

/// Neighbours, each pair once for every face that they share, with the face's area over the distance of the centres.
fn links<C: Cells>(cells: &C, through: [bool; 3]) -> Vec<(u32, u32, f64)> {
    let mut links = Vec::new();
    for cell in 0..cells.cell_count() {
        cells.for_each_neighbour(cell, &mut |other, conductance| {
            if (cell as u32) < other {
                links.push((cell as u32, other, conductance));
            }
        });
    }
    let Some(grid) = cells.as_grid() else { return links };
    let spacing = grid.spacing();
    for k in (0..3).filter(|&k| through[k]) {
        let conductance = spacing[(k + 1) % 3] * spacing[(k + 2) % 3] / spacing[k];
        for cell in 0..cells.cell_count() {
            let mut at = grid.indices(cell);
            // A cell that is its own neighbour has nothing to give to itself.
            if at[k] == 0 && grid.cells()[k] > 1 {
                at[k] = grid.cells()[k] - 1;
                links.push((cell as u32, grid.cell_at(at) as u32, conductance));
            }
        }
    }
    links
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
        let smooth = smooth_conservatively(&grid, &amount, 3.0, None).unwrap();
        let variance: f64 = smooth.iter().enumerate().map(|(i, a)| a * (i as f64 - 20.0).powi(2)).sum();
        assert!((variance - 9.0).abs() < 0.01, "{variance}");
    }

    #[test]
    fn nothing_is_lost_and_nothing_overshoots_on_cells_of_unequal_size() {
        let grid = Grid::new([0.0; 3], [3.0, 1.0, 5.0], [5, 4, 3]).unwrap();
        let amount: Vec<f64> = (0..60).map(|i| f64::from(i * i % 7)).collect();
        let smooth = smooth_conservatively(&grid, &amount, 2.0, None).unwrap();
        assert!((smooth.iter().sum::<f64>() / amount.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        assert!(smooth.iter().all(|&x| (0.0..=6.0).contains(&x)));
    }

    #[test]
    fn smoothing_passes_a_periodic_boundary_that_the_grid_spans_along_that_direction_alone() {
        let n = [6, 5, 4];
        let grid = Grid::new([1.0, 0.0, -2.0], [7.0, 10.0, 2.0], n).unwrap();
        for axis in 0..3 {
            let periodic = std::array::from_fn(|k| k == axis);
            let domain = Domain::new([0.0, -3.0, -2.0], [6.0, 7.0, 2.0], periodic).unwrap();
            assert_eq!(smoothed_through(&grid, Some(&domain)), periodic);
            // An amount in one corner, and the same moved on by two cells along the periodic direction: a shift.
            let at = |start: usize| {
                let mut amount = vec![0.0; grid.cell_count()];
                let mut corner = [0; 3];
                corner[axis] = start;
                amount[grid.cell_at(corner)] = 1.0;
                smooth_conservatively(&grid, &amount, 0.8, Some(&domain)).unwrap()
            };
            let (here, there) = (at(0), at(2));
            for (cell, amount) in here.iter().enumerate() {
                let mut moved = grid.indices(cell);
                moved[axis] = (moved[axis] + 2) % n[axis];
                assert!((amount - there[grid.cell_at(moved)]).abs() < 1e-15, "{axis} {cell}");
            }
            assert!((here.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn two_cells_that_span_a_period_meet_at_two_faces() {
        // ε' = 2 A/d/V (ε₂ − ε₁) for each of the two: the difference decays as exp(−4 t A/d/V), t = ℓ²/2, here in one step.
        let grid = Grid::new([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1]).unwrap();
        let domain = Domain::new([0.0; 3], [2.0, 1.0, 1.0], [true; 3]).unwrap();
        let length = 0.2;
        let smooth = smooth_conservatively(&grid, &[1.0, 0.0], length, Some(&domain)).unwrap();
        assert!((smooth[0] - smooth[1] - (1.0 - 2.0 * length * length)).abs() < 1e-15, "{smooth:?}");
    }

    #[test]
    fn cells_that_are_no_whole_periods_or_lie_across_a_tilt_have_ends() {
        let domain = Domain::new([0.0; 3], [2.0; 3], [true; 3]).unwrap();
        let through = |x: f64, domain: &Domain| {
            let grid = Grid::new([0.0; 3], [x, 2.0, 2.0], [4, 2, 2]).unwrap();
            smoothed_through(&grid, Some(domain))
        };
        assert_eq!(through(4.0, &domain), [true; 3]);
        assert_eq!(through(1.0, &domain), [false, true, true]);
        assert_eq!(through(3.0, &domain), [false, true, true]);
        let tilted = Domain::triclinic([0.0; 3], [2.0; 3], [0.5, 0.0, 0.0], [true; 3]).unwrap();
        assert_eq!(through(2.0, &tilted), [true, false, true]);
    }

    #[test]
    fn a_length_that_would_take_forever_is_refused_with_the_longest_that_does_not() {
        let grid = Grid::new([0.0; 3], [1.0, 1.0, 1e-4], [2, 2, 2]).unwrap();
        let error = smooth_conservatively(&grid, &[1.0; 8], 1.0, None).unwrap_err();
        assert!(matches!(error, FieldsError::SmoothingLength { longest, .. } if longest < 1.0), "{error}");
        assert!(smooth_conservatively(&grid, &[1.0; 8], f64::NAN, None).is_err());
    }
}
