//! Weights of frames in time.

use crate::FieldsError;

/// Weights of frames for a Gaussian mean about the time `at`.
///
/// $$ w_t = e^{-(t - t_0)^2 / (2 s^2)}, \qquad |t - t_0| \le \text{reach} $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | `times` | time of each frame | time |
/// | `at` | t₀, the time that the mean is for | time |
/// | `width` | s, standard deviation | time |
/// | `reach` | cut-off, 3 s unless given | time |
///
/// They need not add up to 1: [`crate::CoarseGraining::finish`] divides by their sum. Weights of frames that are evenly
/// spaced approximate the integral over time; for uneven ones multiply by the spacing.
///
/// # Errors
/// [`FieldsError::Option`] for a width or reach that is not positive and finite.
///
/// ```
/// let weights = fieldstone_fields::gaussian_time_weights(&[0.0, 1.0, 2.0, 9.0], 1.0, 1.0, None)?;
/// assert_eq!(weights[1], 1.0);
/// assert_eq!(weights[0], weights[2]);
/// assert_eq!(weights[3], 0.0);
/// # Ok::<(), fieldstone_fields::FieldsError>(())
/// ```
pub fn gaussian_time_weights(times: &[f64], at: f64, width: f64, reach: Option<f64>) -> Result<Vec<f64>, FieldsError> {
    let reach = reach.unwrap_or(3.0 * width);
    for (name, value) in [("the width in time", width), ("the cut-off in time", reach)] {
        if !(value > 0.0 && value.is_finite()) {
            return Err(FieldsError::Option { name, value, allowed: "positive and finite" });
        }
    }
    let weight = |&t: &f64| {
        let q = (t - at) / width;
        if (t - at).abs() <= reach { (-0.5 * q * q).exp() } else { 0.0 }
    };
    Ok(times.iter().map(weight).collect())
}
