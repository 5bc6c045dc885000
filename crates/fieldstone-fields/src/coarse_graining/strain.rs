//! Displacements between frames, and their gradient in a cell.

use std::collections::HashMap;

use fieldstone_particles::{Particles, Quantity};

use crate::FieldsError;

/// Gradient of the affine map that fits the displacements in a cell best, from sums over its particles.
///
/// $$ G = \Bigl(\sum w\,(d - \bar d)\otimes(r - \bar r)\Bigr) \Bigl(\sum w\,(r - \bar r)\otimes(r - \bar r)\Bigr)^{-1} $$
///
/// with w the mass in the cell. Exact for affine displacements. Zero where the particles of the cell do not span
/// three directions.
///
/// Source: `falk1998`, Eqs. 2.12–2.14.
pub(super) fn displacement_gradient(
    mass: f64,
    position: [f64; 3],
    position2: [f64; 6],
    displacement: [f64; 3],
    displacement_position: [f64; 9],
) -> [f64; 9] {
    if mass <= 0.0 {
        return [0.0; 9];
    }
    let r = position.map(|x| x / mass);
    let x = |a: usize, b: usize| {
        let (low, high) = (a.min(b), a.max(b));
        position2[[0, 3, 5][low] + (high - low)] - mass * r[a] * r[b]
    };
    let y = |a: usize, b: usize| displacement_position[3 * a + b] - displacement[a] * r[b];
    let m: [[f64; 3]; 3] = std::array::from_fn(|a| std::array::from_fn(|b| x(a, b)));
    let cofactor = |a: usize, b: usize| {
        let (p, q) = ((a + 1) % 3, (a + 2) % 3);
        let (s, t) = ((b + 1) % 3, (b + 2) % 3);
        m[p][s] * m[q][t] - m[p][t] * m[q][s]
    };
    let determinant: f64 = (0..3).map(|b| m[0][b] * cofactor(0, b)).sum();
    let trace = m[0][0] + m[1][1] + m[2][2];
    // Flat or lone groups of particles: what is left of the determinant is rounding.
    if determinant <= 1e-9 * (trace / 3.0).powi(3) {
        return [0.0; 9];
    }
    std::array::from_fn(|n| (0..3).map(|k| y(n / 3, k) * cofactor(n % 3, k)).sum::<f64>() / determinant)
}

/// `before` with a column `displacement`: how far each particle has moved by the frame `after`.
///
/// Particles are matched by id where both frames have ids, else by their place in the list. Through periodic boundaries
/// the nearest image counts, so frames must be less than half a box apart. Particles that are gone by `after` are left
/// out.
///
/// # Errors
/// [`FieldsError::Length`] where there are no ids and the frames differ in their number of particles.
///
/// ```
/// use fieldstone_fields::displacements;
/// use fieldstone_particles::Particles;
/// let before = Particles::new(vec![[0.0; 3], [1.0, 0.0, 0.0]])?.with_ids(vec![7, 3])?;
/// let after = Particles::new(vec![[1.5, 0.0, 0.0], [0.25, 0.0, 0.0]])?.with_ids(vec![3, 7])?;
/// assert_eq!(displacements(&before, &after)?.quantity("displacement")?.data, [0.25, 0.0, 0.0, 0.5, 0.0, 0.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn displacements(before: &Particles, after: &Particles) -> Result<Particles, FieldsError> {
    let partner: Vec<Option<usize>> = match (before.ids(), after.ids()) {
        (Some(old), Some(new)) => {
            let places: HashMap<i64, usize> = new.iter().enumerate().map(|(k, &id)| (id, k)).collect();
            old.iter().map(|id| places.get(id).copied()).collect()
        }
        _ => {
            crate::checks::check_length("particles", after.len(), before.len())?;
            (0..before.len()).map(Some).collect()
        }
    };
    let domain = after.domain().or(before.domain());
    let kept: Vec<(usize, usize)> = partner.iter().enumerate().filter_map(|(k, p)| Some((k, (*p)?))).collect();
    let rows = |data: &[f64], n: usize| -> Vec<f64> {
        kept.iter().flat_map(|&(k, _)| data[k * n..(k + 1) * n].iter().copied()).collect()
    };
    let moved = kept
        .iter()
        .flat_map(|&(old, new)| {
            let (a, b) = (before.positions()[old], after.positions()[new]);
            let d = std::array::from_fn(|k| b[k] - a[k]);
            domain.map_or(d, |domain| domain.minimum_image(d))
        })
        .collect();
    let mut result = Particles::new(kept.iter().map(|&(k, _)| before.positions()[k]).collect())?;
    if let Ok(radii) = before.radii() {
        result = result.with_radii(rows(radii, 1))?;
    }
    if let Some(ids) = before.ids() {
        result = result.with_ids(kept.iter().map(|&(k, _)| ids[k]).collect())?;
    }
    if let Some(types) = before.types() {
        result = result.with_types(kept.iter().map(|&(k, _)| types[k]).collect())?;
    }
    for q in before.quantities() {
        let data = rows(&q.data, q.components);
        result = result.with_quantity(Quantity { name: q.name.clone(), components: q.components, data })?;
    }
    if let Some(domain) = before.domain() {
        result = result.with_domain(*domain);
    }
    result = result.at(before.step(), before.time()).with_source_names_of(before);
    Ok(result.with_quantity(Quantity { name: "displacement".into(), components: 3, data: moved })?)
}
