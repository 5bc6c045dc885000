//! What is suspicious about a case before it runs, and about a run after it.

use fieldstone::sph::{FluidOptions, Prepared, RunFolder, sound_speed_bound};

use super::report;

/// Warns of what a case should rather not begin with.
pub(super) fn before(prepared: &Prepared) -> anyhow::Result<()> {
    of_uneven_fills(&prepared.excess_of_fills()?);
    of_covered_fills(&prepared.covered_fills()?);
    let dimension = prepared.flow().fluid.dimension;
    for off in prepared.fills_off_walls()? {
        report::warn(&format!(
            "the outermost particles of fill {} are {:.3e} from wall {} (normal {:?}), not half a cell, {:.3e}: they begin pressed against \
             it, or fall against it; let the fill end at the wall, or a cell and more before it",
            off.fill,
            off.distance,
            off.wall,
            &off.normal[..dimension],
            off.half_cell
        ));
    }
    for at in prepared.bodies_at_walls() {
        report::warn(&format!(
            "body {} stands on wall {} (normal {:?}) and reaches {:.3e} beyond it: bodies are not mirrored, and the fluid leaks between \
             both; let it reach {:.3e} (2h) beyond, or more",
            at.body,
            at.wall,
            &at.normal[..dimension],
            at.beyond,
            at.needed
        ));
    }
    Ok(())
}

/// Excess of a fill's particles over their cells from which on the pressure is too far off to keep silent.
const UNEVEN: f64 = 0.005;

fn of_uneven_fills(excess: &[f64]) {
    for (nth, &excess) in excess.iter().enumerate().filter(|(_, excess)| excess.abs() > UNEVEN) {
        report::warn(&format!(
            "the particles of fill {nth} are {:.1} % too {} for the lattice it is divided into, and the pressure in it errs: give all \
             fills lengths of a whole number of spacings, or another spacing",
            100.0 * excess.abs(),
            if excess > 0.0 { "heavy" } else { "light" },
        ));
    }
}

fn of_covered_fills(covered: &[(usize, usize)]) {
    for (nth, above) in covered {
        report::warn(&format!(
            "fill {nth} is hydrostatic from its own top on, but fill {above} lies upon it: the pressure begins without its weight; \
             give fill {nth} surface, the level of the water at rest above it"
        ));
    }
}

/// Warns of files of a run that its checkpoint does not make anew.
pub(super) fn of_lost_files(files: &RunFolder) -> anyhow::Result<()> {
    if !files.gauges().exists() {
        report::warn(&format!(
            "{} is gone; another begins at the checkpoint, without the rows before it",
            files.gauges().display()
        ));
    }
    let missing = files.missing_frames()?;
    if let Some(first) = missing.first() {
        report::warn(&format!(
            "{}: {} of the files that it lists {} gone, the first is {}; the run goes on without",
            files.series().display(),
            missing.len(),
            if missing.len() == 1 { "is" } else { "are" },
            first.display()
        ));
    }
    Ok(())
}

/// Energy that nothing explains, over the kinetic one, from which on a run was unstable: it is some percent in flows that are not.
const UNEXPLAINED: f64 = 0.5;

/// What to say of a run that was too fast because its steps were too long: a greater speed of sound would not help it.
pub(super) fn unstable(speed: f64, residual: f64, kinetic: f64) -> Option<String> {
    (residual > UNEXPLAINED * kinetic && kinetic > 0.0).then(|| {
        format!(
            "particles were as fast as {speed:.4}, and the energy has grown by {residual:.3e} that nothing explains (residual in gauges.csv), \
             with a kinetic energy of {kinetic:.3e}: the time steps were too long; lessen cfl, or give a largest step, in [time] and start \
             anew before anything else is changed"
        )
    })
}

/// By how much the speed of sound that speeds and pressures ask for may be above the given one.
const SLACK: f64 = 1.1;

/// Speed over that of sound from which the density varies by some percent, whatever was expected.
const TOO_FAST: f64 = 0.25;

/// What to say of a flow whose largest speed or pressure breaks the bound of Eq. 3, and what to write into the case.
pub(super) fn too_compressible(fluid: &FluidOptions, speed: f64, pressure: f64) -> Option<String> {
    let given = fluid.sound_speed;
    let (by_speed, by_pressure) =
        (sound_speed_bound(fluid.density, speed, 0.0), sound_speed_bound(fluid.density, 0.0, pressure));
    let needed = by_speed.max(by_pressure);
    if needed <= SLACK * given {
        return None;
    }
    let (mut found, mut keys) = (Vec::new(), Vec::new());
    if by_speed > SLACK * given {
        found.push(format!("particles were as fast as {speed:.4}"));
        keys.push(format!("expected_speed = {speed:.3}"));
    }
    if by_pressure > SLACK * given {
        found.push(format!("the pressure rose to {pressure:.0}"));
        keys.push(format!("expected_pressure = {pressure:.0}"));
    }
    let effect = if speed > TOO_FAST * given {
        "the fluid was compressible"
    } else {
        "the density varies by more than 1 %, unless a few drops that splash are all it is about"
    };
    Some(format!(
        "{}, which asks for a speed of sound of {needed:.3} (Eq. 3), with a speed of sound of {given}: {effect}; write {} into [fluid], \
         and leave out sound_speed or raise it to the bound",
        found.join(", and "),
        keys.join(" and "),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energy_from_nowhere_is_the_time_steps_fault() {
        let told = unstable(6.2, 3.0, 4.0).unwrap();
        assert!(told.contains("time steps were too long; lessen cfl") && !told.contains("expected_speed"), "{told}");
        // A fast flow whose energy is accounted for, also where it has lost some.
        assert_eq!((unstable(6.2, 0.1, 4.0), unstable(6.2, -3.0, 4.0), unstable(0.0, 0.0, 0.0)), (None, None, None));
    }
}
