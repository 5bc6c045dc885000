//! Where in a case file stands what the solver refuses.

use super::Case;
use crate::{Parameter, SphError};

impl Case {
    /// Gives an error of the solver its line.
    pub(super) fn placed(&self, error: SphError) -> SphError {
        let (section, nth, key) = match &error {
            SphError::SoundSpeed { .. } => ("fluid", 0, "sound_speed"),
            SphError::ViscousStep { .. } => ("time", 0, "viscous"),
            SphError::ThinBody { body, .. } | SphError::ThinSurface { body, .. } => ("body", *body, "shape"),
            SphError::CutBody { body, .. } => ("body", *body, "shape"),
            SphError::Overlapping { second, .. } => ("body", *second, "shape"),
            SphError::TooNarrow { .. } => ("domain", 0, "high"),
            SphError::SameSide { second, .. } => ("wall", self.section_of_wall(*second), "kind"),
            SphError::Option { parameter, .. } => {
                let (section, key) = place_of(*parameter);
                (section, 0, key)
            }
            _ => return error,
        };
        self.fault(section, nth, key, error.to_string())
    }

    /// Number of the section that a mirror wall comes from.
    pub(super) fn section_of_wall(&self, wall: usize) -> usize {
        let walls = self.sections.wall.iter();
        let ends = walls.scan(0, |end, section| {
            *end += self.planes_of(section).len();
            Some(*end)
        });
        ends.take_while(|&end| end <= wall).count()
    }
}

/// Section and key that a parameter comes from.
fn place_of(parameter: Parameter) -> (&'static str, &'static str) {
    match parameter {
        Parameter::Dimension => ("", "dimension"),
        // Cases have no key for the lists' margin: it goes with the spacing, as the volume of particles does.
        Parameter::Spacing | Parameter::ParticleVolume | Parameter::ListMargin => ("", "spacing"),
        Parameter::Smoothing => ("fluid", "smoothing"),
        Parameter::Density => ("fluid", "density"),
        Parameter::SoundSpeed => ("fluid", "sound_speed"),
        Parameter::Viscosity => ("fluid", "viscosity"),
        Parameter::Alpha => ("fluid", "alpha"),
        Parameter::Delta => ("fluid", "delta"),
        Parameter::SurfaceTension => ("fluid", "surface_tension"),
        Parameter::ExpectedSpeed | Parameter::ExpectedMach => ("fluid", "expected_speed"),
        Parameter::ExpectedPressure => ("fluid", "expected_pressure"),
        Parameter::Gravity | Parameter::GravityAlongZ => ("fluid", "gravity"),
        Parameter::Cfl => ("time", "cfl"),
        Parameter::ViscousFactor => ("time", "viscous"),
        Parameter::CapillaryFactor => ("time", "capillary"),
        Parameter::LargestStep => ("time", "largest"),
        Parameter::DomainEdge => ("domain", "high"),
        Parameter::CosineOfWalls => ("wall", "kind"),
        Parameter::NormalAlongPeriod => ("wall", "normal"),
        Parameter::ShiftingCfl => ("shifting", "k_cfl"),
        Parameter::ShiftingR => ("shifting", "r"),
        Parameter::ShiftingN => ("shifting", "n"),
        Parameter::ShiftingFactor => ("shifting", "factor"),
        Parameter::ShiftingMach => ("shifting", "mach"),
        Parameter::ShiftingCap => ("shifting", "cap"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SHIPPED;

    #[test]
    fn what_has_no_key_of_its_own_is_placed_at_what_it_is_made_from() {
        let text = SHIPPED.iter().find(|case| case.name == "hydrostatic").unwrap().text;
        let case = Case::parse(&format!("{text}\n[shifting]\n"), "c.toml").unwrap();
        for (parameter, key) in [
            (Parameter::Dimension, "dimension"),
            (Parameter::Spacing, "spacing"),
            (Parameter::ParticleVolume, "spacing"),
            (Parameter::ListMargin, "spacing"),
            (Parameter::GravityAlongZ, "gravity"),
            (Parameter::ExpectedMach, "expected_speed"),
        ] {
            let error = case.placed(SphError::Option { parameter, value: 7.0, allowed: "another" }).to_string();
            let line = text.lines().position(|line| line.starts_with(key)).unwrap() + 1;
            assert_eq!(error, format!("c.toml:{line}: {parameter} is 7; it must be another"));
        }
    }
}
