//! What must hold of particles before their free surface, or fields of them, mean anything.

use anyhow::bail;
use fieldstone::particles::Quantity;
use fieldstone::surface::Wall;

use super::report::{self, number};

/// Share of the fluid that may lie behind a wall: solvers let a few particles through, a wall set wrongly has many.
const LEAKED: f64 = 0.01;

/// Extent of z, over that of x and y, beyond which particles are not two-dimensional in x and y.
const FLAT: f64 = 1e-3;

/// The commands that read flows in the plane, as a remedy.
pub(super) const COMMANDS_IN_PLANE: &str = "of a flow in the plane fieldstone grid --dimension 2 gives the level set and \
    the fields, fieldstone detect --dimension 2 the free-surface particles";

/// How many times the particles' own distance a spacing may be: more is another unit.
const TOO_WIDE: f64 = 10.0;

/// The same for a spacing that is too small: particles may be spray, far apart.
const TOO_NARROW: f64 = 0.01;

/// Refuses particles that spread along z, which two dimensions do not look at.
pub(super) fn in_plane(positions: &[[f64; 3]], file: &str) -> anyhow::Result<()> {
    let [x, y, z] = [0, 1, 2].map(|k| {
        let low = positions.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
        let high = positions.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max);
        [low, high]
    });
    let extent = |[low, high]: [f64; 2]| high - low;
    let plane = extent(x).max(extent(y));
    if extent(z) > FLAT * plane {
        let spread = format!(
            "--dimension 2: {file}: z runs from {} to {}, but two dimensions are x and y",
            number(z[0]),
            number(z[1])
        );
        for (name, axis) in [("y", y), ("x", x)] {
            if extent(axis) <= FLAT * plane.max(extent(z)) {
                bail!(
                    "{spread}; {name} does not vary: swap the columns {name} and z of the file, or use --dimension 3"
                );
            }
        }
        bail!("{spread}; use --dimension 3, or project the particles");
    }
    Ok(())
}

/// Refuses particles of a flow in the plane, of which a surface in three dimensions would say nothing.
pub(super) fn not_in_plane(positions: &[[f64; 3]], file: &str) -> anyhow::Result<()> {
    // So few are spray, wherever they lie.
    if positions.len() <= 3 {
        return Ok(());
    }
    let first = positions[0];
    for (k, name) in [(2, "z"), (1, "y"), (0, "x")] {
        if positions.iter().all(|p| p[k] == first[k]) {
            let swap =
                if k == 2 { String::new() } else { format!(", with the columns {name} and z of the file swapped") };
            bail!(
                "{file}: all particles have {name} = {}, and a surface has three dimensions; {COMMANDS_IN_PLANE}{swap}",
                number(first[k])
            );
        }
    }
    Ok(())
}

/// Refuses walls with much of the fluid behind them, and warns of those with a little.
pub(super) fn before_walls(
    positions: &[[f64; 3]],
    fluid: Option<&[bool]>,
    walls: &[Wall],
    spacing: f64,
    file: &str,
) -> anyhow::Result<()> {
    let is_fluid = |k: usize| fluid.is_none_or(|f| f[k]);
    let all = (0..positions.len()).filter(|&k| is_fluid(k)).count();
    for wall in walls {
        let name = |sign: f64| {
            let [x, y, z] = wall.normal().map(|n| number(sign * n + 0.0));
            format!("--wall {x},{y},{z},{}", number(sign * wall.offset() + 0.0))
        };
        let (mut behind, mut farthest) = (0usize, 0.0f64);
        for (k, &at) in positions.iter().enumerate() {
            let depth = -wall.distance(at);
            // A particle in the plane may be a rounding behind it.
            if is_fluid(k) && depth > 1e-6 * spacing {
                behind += 1;
                farthest = farthest.max(depth);
            }
        }
        if behind == 0 {
            continue;
        }
        let found = format!(
            "{}: {file}: {behind} of {all} particles lie behind the wall, by up to {}",
            name(1.0),
            number(farthest)
        );
        if 2 * behind > all {
            bail!("{found}; its normal must point into the fluid: turn it ({}), or move the plane", name(-1.0));
        }
        if behind as f64 > LEAKED * all as f64 {
            bail!("{found}; it cuts through the fluid: move the plane, or mark what is behind it with --boundary");
        }
        report::warn(&format!("{found}; they have no mirror image"));
    }
    Ok(())
}

/// Refuses a column with numbers that are not finite, which would spread to all nodes near by.
pub(super) fn finite(option: &str, column: &Quantity, fluid: Option<&[bool]>, file: &str) -> anyhow::Result<()> {
    let width = column.components.max(1);
    let is_bad = |&k: &usize| !column.data[k].is_finite() && fluid.is_none_or(|f| f[k / width]);
    let mut bad = (0..column.data.len()).filter(is_bad);
    let Some(first) = bad.next() else { return Ok(()) };
    let component = if width == 1 { String::new() } else { format!(", component {}", first % width) };
    let others = match bad.count() {
        0 => String::new(),
        n => format!(", and {n} more of its numbers are not finite"),
    };
    bail!(
        "{option} {}: {file}: particle {} (from 0){component} has the value {}{others}; it would spread to everything near \
         by: repair the file, or leave the column out (--fields chooses)",
        column.name,
        first / width,
        column.data[first]
    )
}

/// Values of a column that are named.
const NAMED: usize = 8;

/// Which values occur in a column.
pub(super) fn values(column: &[f64]) -> String {
    let mut found = column.to_vec();
    found.sort_unstable_by(f64::total_cmp);
    found.dedup();
    match found.as_slice() {
        [] => "the column holds no value".into(),
        [one] => format!("all have {}", number(*one)),
        few if few.len() <= NAMED => {
            let named: Vec<String> = few.iter().map(|&x| number(x)).collect();
            format!("there are {}", named.join(", "))
        }
        [least, .., largest] => {
            format!("there are {} values from {} to {}", found.len(), number(*least), number(*largest))
        }
    }
}

/// Refuses a spacing that cannot be the particles': `measured` is their own distance.
pub(super) fn spacing(given: f64, measured: f64, file: &str) -> anyhow::Result<()> {
    let ratio = given / measured;
    if !(TOO_NARROW..=TOO_WIDE).contains(&ratio) {
        bail!(
            "--spacing {given}: {file}: the particles are some {measured:.3e} apart, by their number density; give \
             --spacing {measured:.3e}, or check its unit"
        );
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_with_few_particles_behind_it_is_let_pass_and_one_with_many_is_not() {
        let floor = [Wall::new([0.0, 0.0, 2.0], 0.0).unwrap()];
        let with_behind = |n: usize| -> Vec<[f64; 3]> {
            (0..1000).map(|k| [0.0, 0.0, if k < n { -0.5 } else { 0.1 * k as f64 }]).collect()
        };
        assert!(before_walls(&with_behind(10), None, &floor, 0.1, "f").is_ok());
        assert!(before_walls(&with_behind(11), None, &floor, 0.1, "f").is_err());
        let fluid: Vec<bool> = (0..1000).map(|k| k >= 11).collect();
        assert!(before_walls(&with_behind(11), Some(&fluid), &floor, 0.1, "f").is_ok(), "boundary may be behind");
        assert!(before_walls(&[[0.0, 0.0, -1e-9]], None, &floor, 0.1, "f").is_ok(), "in the plane to rounding");
    }

    #[test]
    fn the_first_number_that_is_not_finite_is_named() {
        let column = Quantity {
            name: "velocity".into(),
            components: 3,
            data: vec![0.0, 1.0, 2.0, 3.0, f64::INFINITY, f64::NAN],
        };
        let message = finite("--fields", &column, None, "f.csv").unwrap_err().to_string();
        assert!(
            message.starts_with("--fields velocity: f.csv: particle 1 (from 0), component 1 has the value inf, and 1")
        );
        assert!(finite("--fields", &column, Some(&[true, false]), "f.csv").is_ok());
    }
}
