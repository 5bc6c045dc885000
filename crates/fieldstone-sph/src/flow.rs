//! What a flow is, but for its state.

use fieldstone_surface::Method;

use crate::error::check;
use crate::{Boundaries, FluidOptions, Parameter, ShiftingOptions, SphError, TimeStepOptions};

/// Everything that a flow is, but for its state.
#[derive(Debug, Clone, PartialEq)]
pub struct Flow {
    /// The fluid.
    pub fluid: FluidOptions,
    /// What is around it.
    pub boundaries: Boundaries,
    /// How time advances.
    pub time_step: TimeStepOptions,
    /// Particle shifting; needs a detection.
    pub shifting: Option<ShiftingOptions>,
    /// Free-surface detection in every step; shifting and tensile control need it.
    pub detection: Option<Method>,
    /// Margin of the neighbour lists over the spacing: lists last until a particle has moved half of it.
    pub skin: f64,
}

impl Flow {
    /// A flow without shifting or detection.
    pub fn new(fluid: FluidOptions, boundaries: Boundaries) -> Self {
        let skin = if fluid.dimension == 2 { 0.3 } else { 0.15 };
        Self { fluid, boundaries, time_step: TimeStepOptions::default(), shifting: None, detection: None, skin }
    }

    /// Checks every option.
    ///
    /// # Errors
    /// [`SphError::Option`], [`SphError::SoundSpeed`], [`SphError::ViscousStep`], [`SphError::TooNarrow`], [`SphError::ThinBody`],
    /// [`SphError::CutBody`], [`SphError::Overlapping`].
    pub fn validate(&self) -> Result<(), SphError> {
        self.fluid.validate()?;
        self.time_step.validate(&self.fluid)?;
        check(Parameter::ListMargin, self.skin, self.skin > 0.0 && self.skin <= 2.0, "above 0, at most 2")?;
        self.boundaries.validate(&self.fluid, self.fluid.kernel().reach() + self.skin * self.fluid.spacing)?;
        if let Some(shifting) = &self.shifting {
            shifting.validate()?;
            let mach = shifting.mach_number(&self.fluid);
            check(
                Parameter::ExpectedMach,
                mach,
                shifting.mach.is_some() || mach > 0.0,
                "above 0, or nothing is shifted: give mach, or an expected_speed above 0",
            )?;
        }
        Ok(())
    }
}
