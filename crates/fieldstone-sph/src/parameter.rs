use std::fmt;

/// A number that describes a flow and has a range: what [`SphError::Option`](crate::SphError::Option) is about.
///
/// Shown as messages name it:
///
/// ```
/// use fieldstone_sph::{FluidOptions, Parameter, SphError};
/// let mut fluid = FluidOptions::new(3, 0.1, 1.0, 0.0);
/// fluid.delta = -1.0;
/// let error = fluid.validate().unwrap_err();
/// assert!(matches!(error, SphError::Option { parameter: Parameter::Delta, .. }));
/// assert_eq!(error.to_string(), "δ is -1; it must be finite and at least 0");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// d.
    Dimension,
    /// Δx.
    Spacing,
    /// h/Δx.
    Smoothing,
    /// ρ₀.
    Density,
    /// Volume of every particle at rest.
    ParticleVolume,
    /// c₀.
    SoundSpeed,
    /// μ.
    Viscosity,
    /// α.
    Alpha,
    /// δ.
    Delta,
    /// σ.
    SurfaceTension,
    /// U_max.
    ExpectedSpeed,
    /// p_max.
    ExpectedPressure,
    /// A component of g.
    Gravity,
    /// That along z, in two dimensions.
    GravityAlongZ,
    /// CFL.
    Cfl,
    /// C_ν.
    ViscousFactor,
    /// C_σ.
    CapillaryFactor,
    /// The largest step allowed.
    LargestStep,
    /// Margin of the neighbour lists over the spacing.
    ListMargin,
    /// Length of the domain along an axis.
    DomainEdge,
    /// Component of a wall's normal along a periodic axis.
    NormalAlongPeriod,
    /// Cosine between the normals of two walls.
    CosineOfWalls,
    /// k_CFL.
    ShiftingCfl,
    /// R.
    ShiftingR,
    /// n.
    ShiftingN,
    /// f.
    ShiftingFactor,
    /// Ma as it is given.
    ShiftingMach,
    /// Ma from the expected speed.
    ExpectedMach,
    /// Largest shift per step over the spacing.
    ShiftingCap,
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Dimension => "the dimension",
            Self::Spacing => "the spacing",
            Self::Smoothing => "h/Δx",
            Self::Density => "the density",
            Self::ParticleVolume => "the particles' volume",
            Self::SoundSpeed => "the speed of sound",
            Self::Viscosity => "the viscosity",
            Self::Alpha => "α",
            Self::Delta => "δ",
            Self::SurfaceTension => "the surface tension",
            Self::ExpectedSpeed => "the expected speed",
            Self::ExpectedPressure => "the expected pressure",
            Self::Gravity => "gravity",
            Self::GravityAlongZ => "gravity along z",
            Self::Cfl => "the CFL number",
            Self::ViscousFactor => "the viscous factor of the time step",
            Self::CapillaryFactor => "the capillary factor of the time step",
            Self::LargestStep => "the largest time step",
            Self::ListMargin => "the lists' margin over the spacing",
            Self::DomainEdge => "an edge of the domain",
            Self::NormalAlongPeriod => "a wall's normal along a periodic axis",
            Self::CosineOfWalls => "the cosine between two walls",
            Self::ShiftingCfl => "k_CFL of the shifting",
            Self::ShiftingR => "R of the shifting",
            Self::ShiftingN => "n of the shifting",
            Self::ShiftingFactor => "the factor of the shifting",
            Self::ShiftingMach => "the Mach number of the shifting",
            Self::ExpectedMach => "the Mach number of the shifting, expected speed over speed of sound,",
            Self::ShiftingCap => "the largest shift over the spacing",
        })
    }
}
