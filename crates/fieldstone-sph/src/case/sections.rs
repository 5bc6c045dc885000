use serde::{Deserialize, Serialize};

use super::MotionSection;
use super::keys::{finite, only, positive, vector};
use crate::{Shape, Slip};

pub(super) type Fault = (&'static str, String);

/// An axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum AxisName {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
}

/// An axis and which way along it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum DirectionName {
    /// Along x.
    #[default]
    #[serde(rename = "x")]
    X,
    /// Along y.
    #[serde(rename = "y")]
    Y,
    /// Along z.
    #[serde(rename = "z")]
    Z,
    /// Against x.
    #[serde(rename = "-x")]
    AgainstX,
    /// Against y.
    #[serde(rename = "-y")]
    AgainstY,
    /// Against z.
    #[serde(rename = "-z")]
    AgainstZ,
}

impl DirectionName {
    /// 0, 1 or 2.
    pub fn axis(self) -> usize {
        self as usize % 3
    }

    /// 1 along the axis, −1 against it.
    pub fn sign(self) -> f64 {
        if (self as usize) < 3 { 1.0 } else { -1.0 }
    }
}

/// `[domain]`
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DomainSection {
    /// Lower corner, 2 or 3 numbers.
    pub low: Vec<f64>,
    /// Upper corner.
    pub high: Vec<f64>,
    /// Periodic axes.
    #[serde(default)]
    pub periodic: Vec<AxisName>,
    /// Faces through which particles may leave: `x-`, `x+`, …
    #[serde(default)]
    pub open: Vec<String>,
}

/// `[fluid]`
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FluidSection {
    /// ρ₀.
    pub density: f64,
    /// c₀; the bound of Eq. 3 where absent.
    pub sound_speed: Option<f64>,
    /// U_max of Eq. 3 and of the shifting.
    pub expected_speed: f64,
    /// p_max of Eq. 3.
    #[serde(default)]
    pub expected_pressure: f64,
    /// μ.
    pub viscosity: Option<f64>,
    /// α.
    pub alpha: Option<f64>,
    /// δ.
    #[serde(default = "delta")]
    pub delta: f64,
    /// h/Δx.
    #[serde(default = "smoothing")]
    pub smoothing: f64,
    /// σ.
    #[serde(default)]
    pub surface_tension: f64,
    /// g, 2 or 3 numbers; none where absent.
    pub gravity: Option<Vec<f64>>,
    /// Against tensile instability.
    #[serde(default)]
    pub tensile_control: bool,
}

fn delta() -> f64 {
    0.1
}

fn smoothing() -> f64 {
    2.0
}

/// The integrators by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum CaseIntegrator {
    /// Predictor–corrector.
    #[default]
    Symplectic,
    /// Runge–Kutta of fourth order.
    Rk4,
}

/// `[time]`
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TimeSection {
    /// When the run ends.
    pub end: f64,
    /// CFL; 0.25.
    #[serde(default = "cfl")]
    pub cfl: f64,
    /// Factor of the viscous bound; 0.65 of the largest stable one.
    pub viscous: Option<f64>,
    /// Factor of the capillary bound; 0.25.
    #[serde(default = "cfl")]
    pub capillary: f64,
    /// Largest step.
    pub largest: Option<f64>,
    /// The integrator.
    #[serde(default)]
    pub integrator: CaseIntegrator,
}

fn cfl() -> f64 {
    0.25
}

/// Shapes by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ShapeName {
    /// `low`, `high`.
    Box,
    /// `centre`, `radius`, `length`, `axis`.
    Cylinder,
    /// `centre`, `radius`.
    Sphere,
    /// `file`, `scale`, `offset`.
    Stl,
}

fn point(key: &'static str, given: Option<&Vec<f64>>, dimension: usize) -> Result<[f64; 3], Fault> {
    match given {
        Some(p) => vector(key, p, dimension),
        None => Err(("shape", format!("this shape needs {key}"))),
    }
}

/// A surface in a file, as a fill or body names it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SurfaceKeys {
    pub(super) file: String,
    pub(super) scale: f64,
    pub(super) offset: [f64; 3],
}

/// What a fill and a body say of their shape.
pub(super) struct ShapeKeys<'a> {
    name: ShapeName,
    low: Option<&'a Vec<f64>>,
    high: Option<&'a Vec<f64>>,
    centre: Option<&'a Vec<f64>>,
    radius: Option<f64>,
    length: Option<f64>,
    axis: Option<AxisName>,
    file: Option<&'a String>,
    scale: Option<f64>,
    offset: Option<&'a Vec<f64>>,
}

/// The keys of a shape in a section that has all of them.
macro_rules! shape_keys {
    ($section:expr) => {
        ShapeKeys {
            name: $section.shape,
            low: $section.low.as_ref(),
            high: $section.high.as_ref(),
            centre: $section.centre.as_ref(),
            radius: $section.radius,
            length: $section.length,
            axis: $section.axis,
            file: $section.file.as_ref(),
            scale: $section.scale,
            offset: $section.offset.as_ref(),
        }
    };
}

impl ShapeKeys<'_> {
    /// Refuses keys of other shapes.
    pub(super) fn check(&self) -> Result<(), Fault> {
        let (kind, takes): (_, &[&str]) = match self.name {
            ShapeName::Box => ("shape = \"box\"", &["low", "high"]),
            ShapeName::Cylinder => ("shape = \"cylinder\"", &["centre", "radius", "length", "axis"]),
            ShapeName::Sphere => ("shape = \"sphere\"", &["centre", "radius"]),
            ShapeName::Stl => ("shape = \"stl\"", &["file", "scale", "offset"]),
        };
        let keys = [
            ("low", self.low.is_some()),
            ("high", self.high.is_some()),
            ("centre", self.centre.is_some()),
            ("radius", self.radius.is_some()),
            ("length", self.length.is_some()),
            ("axis", self.axis.is_some()),
            ("file", self.file.is_some()),
            ("scale", self.scale.is_some()),
            ("offset", self.offset.is_some()),
        ];
        only(kind, takes, &keys)
    }

    /// The surface's file, where the shape is one.
    pub(super) fn surface(&self) -> Result<Option<SurfaceKeys>, Fault> {
        if self.name != ShapeName::Stl {
            return Ok(None);
        }
        let file = self.file.ok_or_else(|| ("shape", "this shape needs file".to_string()))?.clone();
        let scale = if self.scale.is_some() { positive("shape", "scale", self.scale)? } else { 1.0 };
        let offset = if self.offset.is_some() { point("offset", self.offset, 3)? } else { [0.0; 3] };
        Ok(Some(SurfaceKeys { file, scale, offset }))
    }

    /// A shape that is no surface.
    pub(super) fn plain(&self, dimension: usize) -> Result<Shape, Fault> {
        let centre = || point("centre", self.centre, dimension);
        let radius = || positive("shape", "radius", self.radius);
        Ok(match self.name {
            ShapeName::Stl => return Err(("shape", "this shape is a surface".into())),
            ShapeName::Box => {
                let (low, high) = (point("low", self.low, dimension)?, point("high", self.high, dimension)?);
                if (0..dimension).any(|k| low[k] >= high[k]) {
                    let (low, high) = (&low[..dimension], &high[..dimension]);
                    return Err(("high", format!("high is {high:?}; it must be above low, {low:?}, along every axis")));
                }
                Shape::Box { low, high }
            }
            ShapeName::Sphere => Shape::Sphere { centre: centre()?, radius: radius()? },
            ShapeName::Cylinder => Shape::Cylinder {
                centre: centre()?,
                radius: radius()?,
                length: positive("shape", "length", self.length)?,
                axis: self.axis.ok_or_else(|| ("shape", "this shape needs axis".to_string()))? as usize,
            },
        })
    }
}

/// Initial pressure of a fill.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(untagged, expecting = "pressure is neither a number nor \"hydrostatic\" nor \"flow\"; give one of these")]
pub enum Pressure {
    /// The same everywhere.
    Uniform(f64),
    /// By name.
    Named(PressureName),
}

/// Initial pressures by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PressureName {
    /// ρ₀ |g| times the depth, along gravity, below the fill's top or its `surface`; gravity along periodic axes left out.
    Hydrostatic,
    /// That of the fill's flow.
    Flow,
}

/// Initial velocities by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FlowName {
    /// `velocity`, or rest.
    #[default]
    Uniform,
    /// Rigid rotation with `rate` about the fill's middle, in the plane of x and y.
    Rotation,
    /// (−A x, A y) with `rate` A about the fill's middle.
    Strain,
    /// The vortices of Taylor and Green with `speed` and `wavelength`.
    TaylorGreen,
    /// A standing wave of amplitude `amplitude` and `wavelength`, at the moment of its flat surface.
    StandingWave,
}

/// `[[fill]]`
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FillSection {
    /// Its shape.
    pub shape: ShapeName,
    /// Of a box.
    pub low: Option<Vec<f64>>,
    /// Of a box.
    pub high: Option<Vec<f64>>,
    /// Of a cylinder or sphere.
    pub centre: Option<Vec<f64>>,
    /// Of a cylinder or sphere.
    pub radius: Option<f64>,
    /// Of a cylinder.
    pub length: Option<f64>,
    /// Of a cylinder.
    pub axis: Option<AxisName>,
    /// Of a surface: name of its file, from the case's folder.
    pub file: Option<String>,
    /// Of a surface: factor of its coordinates, above 0; 1.
    pub scale: Option<f64>,
    /// Of a surface: added after scaling; 0.
    pub offset: Option<Vec<f64>>,
    /// Initial flow.
    #[serde(default)]
    pub flow: FlowName,
    /// Of a uniform flow.
    pub velocity: Option<Vec<f64>>,
    /// Of a rotation or strain.
    pub rate: Option<f64>,
    /// Of Taylor and Green's vortices.
    pub speed: Option<f64>,
    /// Of vortices and waves.
    pub wavelength: Option<f64>,
    /// Of a wave.
    pub amplitude: Option<f64>,
    /// Initial pressure; 0.
    #[serde(default = "no_pressure")]
    pub pressure: Pressure,
    /// Of a hydrostatic pressure: level of the water at rest, its height along −g; the fill's top.
    pub surface: Option<f64>,
}

fn no_pressure() -> Pressure {
    Pressure::Uniform(0.0)
}

impl FillSection {
    pub(super) fn keys(&self) -> ShapeKeys<'_> {
        shape_keys!(self)
    }

    pub(super) fn check_flow(&self, dimension: usize) -> Result<(), Fault> {
        let (kind, takes): (_, &[&str]) = match self.flow {
            FlowName::Uniform => ("a uniform flow", &["velocity"]),
            FlowName::Rotation => ("flow = \"rotation\"", &["rate"]),
            FlowName::Strain => ("flow = \"strain\"", &["rate"]),
            FlowName::TaylorGreen => ("flow = \"taylor-green\"", &["speed", "wavelength"]),
            FlowName::StandingWave => ("flow = \"standing-wave\"", &["amplitude", "wavelength"]),
        };
        let keys = [
            ("velocity", self.velocity.is_some()),
            ("rate", self.rate.is_some()),
            ("speed", self.speed.is_some()),
            ("wavelength", self.wavelength.is_some()),
            ("amplitude", self.amplitude.is_some()),
        ];
        only(kind, takes, &keys)?;
        if let Pressure::Uniform(pressure) = self.pressure {
            finite("fill", "pressure", Some(pressure))?;
        }
        if let Some(surface) = self.surface {
            if self.pressure != Pressure::Named(PressureName::Hydrostatic) {
                return Err((
                    "surface",
                    "surface goes with pressure = \"hydrostatic\" only; remove one of them".into(),
                ));
            }
            finite("fill", "surface", Some(surface))?;
        }
        match self.flow {
            FlowName::Uniform => match &self.velocity {
                Some(velocity) => vector("velocity", velocity, dimension).map(|_| ()),
                None => Ok(()),
            },
            FlowName::Rotation | FlowName::Strain => finite("flow", "rate", self.rate).map(|_| ()),
            FlowName::TaylorGreen => {
                finite("flow", "speed", self.speed)?;
                positive("flow", "wavelength", self.wavelength).map(|_| ())
            }
            FlowName::StandingWave => {
                finite("flow", "amplitude", self.amplitude)?;
                positive("flow", "wavelength", self.wavelength).map(|_| ())
            }
        }
    }
}

/// Friction by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SlipName {
    /// None.
    #[default]
    Free,
    /// The flow sticks.
    No,
}

impl From<SlipName> for Slip {
    fn from(name: SlipName) -> Self {
        match name {
            SlipName::Free => Self::Free,
            SlipName::No => Self::No,
        }
    }
}

/// Kinds of walls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum WallKind {
    /// All faces of the domain that are neither open nor periodic.
    Tank,
    /// `point` and `normal`, which points into the fluid.
    Plane,
}

/// `[[wall]]`
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct WallSection {
    /// Which kind.
    pub kind: WallKind,
    /// Friction.
    #[serde(default)]
    pub slip: SlipName,
    /// Of a plane.
    pub point: Option<Vec<f64>>,
    /// Of a plane.
    pub normal: Option<Vec<f64>>,
}

/// `[[body]]`
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct BodySection {
    /// Its shape.
    pub shape: ShapeName,
    /// Of a box.
    pub low: Option<Vec<f64>>,
    /// Of a box.
    pub high: Option<Vec<f64>>,
    /// Of a cylinder or sphere.
    pub centre: Option<Vec<f64>>,
    /// Of a cylinder or sphere.
    pub radius: Option<f64>,
    /// Of a cylinder.
    pub length: Option<f64>,
    /// Of a cylinder.
    pub axis: Option<AxisName>,
    /// Of a surface: name of its file, from the case's folder.
    pub file: Option<String>,
    /// Of a surface: factor of its coordinates, above 0; 1.
    pub scale: Option<f64>,
    /// Of a surface: added after scaling; 0.
    pub offset: Option<Vec<f64>>,
    /// Friction.
    #[serde(default)]
    pub slip: SlipName,
    /// How it moves; at rest where absent.
    pub motion: Option<MotionSection>,
}

impl BodySection {
    pub(super) fn keys(&self) -> ShapeKeys<'_> {
        shape_keys!(self)
    }
}

/// `[shifting]`
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ShiftingSection {
    /// Off: detection only.
    pub enabled: bool,
    /// Detection method.
    pub detection: String,
    /// k_CFL; the CFL number where absent, since the shift is one per step.
    pub k_cfl: Option<f64>,
    /// R.
    pub r: f64,
    /// n.
    pub n: i32,
    /// The factor of h².
    pub factor: f64,
    /// Ma.
    pub mach: Option<f64>,
    /// Largest shift over the spacing.
    pub cap: f64,
    /// Whether the nearest free-surface particle counts near the surface.
    pub nearest_counts: bool,
}

impl Default for ShiftingSection {
    fn default() -> Self {
        let crate::ShiftingOptions { k_cfl: _, r, n, factor, mach, cap, nearest_counts } =
            crate::ShiftingOptions::default();
        Self { enabled: true, detection: "exact".into(), k_cfl: None, r, n, factor, mach, cap, nearest_counts }
    }
}

/// `[output]`
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutputSection {
    /// Time between particle files; a fiftieth of the run.
    pub every: Option<f64>,
    /// Time between rows of the gauges' table; a five-hundredth of the run.
    pub gauges_every: Option<f64>,
    /// Wall-clock seconds between checkpoints.
    pub checkpoint_every: f64,
}

impl Default for OutputSection {
    fn default() -> Self {
        Self { every: None, gauges_every: None, checkpoint_every: 300.0 }
    }
}

/// Kinds of gauges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GaugeKind {
    /// Mean pressure, by the kernel, of the fluid around `at`; 0 where it is dry.
    Pressure,
    /// Highest particle in the column of half-width Δx over `at`, against gravity, and half a spacing.
    Level,
    /// Farthest particle along `axis`, or against it, that has others within 1.5 Δx, and half a spacing.
    Front,
    /// Force on `body`: one column per axis.
    Force,
}

/// `[[gauge]]`
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GaugeSection {
    /// Name of its column.
    pub name: String,
    /// Which kind.
    pub kind: GaugeKind,
    /// Where, of a pressure or level.
    pub at: Option<Vec<f64>>,
    /// Of a front: which way it runs; x.
    pub axis: Option<DirectionName>,
    /// Of a force: index of the body; 0.
    pub body: Option<usize>,
}

impl GaugeSection {
    /// Where it is; the origin for gauges without a place.
    pub fn place(&self) -> [f64; 3] {
        let at = self.at.as_deref().unwrap_or_default();
        std::array::from_fn(|k| at.get(k).copied().unwrap_or(0.0))
    }

    /// What it measures, in words: what a run that goes on has it compared by.
    pub(crate) fn measured(&self) -> String {
        let at = self.at.as_deref().unwrap_or_default();
        match self.kind {
            GaugeKind::Pressure => format!("the pressure at {at:?}"),
            GaugeKind::Level => format!("the level at {at:?}"),
            GaugeKind::Front => {
                let way = self.axis.unwrap_or_default();
                format!("the front along {}{}", if way.sign() < 0.0 { "-" } else { "" }, ["x", "y", "z"][way.axis()])
            }
            GaugeKind::Force => format!("the force on body {}", self.body.unwrap_or(0)),
        }
    }

    pub(super) fn check(&self, bodies: usize, low: &[f64], high: &[f64]) -> Result<(), Fault> {
        let (kind, takes): (_, &[&str]) = match self.kind {
            GaugeKind::Pressure => ("kind = \"pressure\"", &["at"]),
            GaugeKind::Level => ("kind = \"level\"", &["at"]),
            GaugeKind::Front => ("kind = \"front\"", &["axis"]),
            GaugeKind::Force => ("kind = \"force\"", &["body"]),
        };
        let keys = [("at", self.at.is_some()), ("axis", self.axis.is_some()), ("body", self.body.is_some())];
        only(kind, takes, &keys)?;
        let dimension = low.len();
        match self.kind {
            GaugeKind::Pressure | GaugeKind::Level => {
                let Some(at) = &self.at else { return Err(("kind", "this gauge needs at".into())) };
                let at = vector("at", at, dimension)?;
                if (0..dimension).any(|k| at[k] < low[k] || at[k] > high[k]) {
                    let at = &at[..dimension];
                    return Err(("at", format!("at is {at:?}; it must be in the domain, from {low:?} to {high:?}")));
                }
                Ok(())
            }
            GaugeKind::Front if self.axis.unwrap_or_default().axis() < dimension => Ok(()),
            GaugeKind::Front => Err(("axis", "there is no z in two dimensions; give x, y, -x or -y".into())),
            GaugeKind::Force if self.body.unwrap_or(0) < bodies => Ok(()),
            GaugeKind::Force => {
                Err(("body", format!("there are {bodies} bodies, numbered from 0; name one of them, or add one")))
            }
        }
    }
}
