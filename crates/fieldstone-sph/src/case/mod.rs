//! Flows described in TOML.

mod check;
mod covered;
mod fit;
mod flows;
mod keys;
mod locate;
mod masses;
mod motion;
mod placed;
mod prepared;
mod sections;
mod shipped;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use fieldstone_surface::{Method, SurfaceError, Wall};
use serde::{Deserialize, Serialize};

pub use fit::{BodyAtWall, FillBesideWall};
pub use motion::MotionSection;
pub use prepared::Prepared;
pub use sections::{
    AxisName, BodySection, CaseIntegrator, DirectionName, DomainSection, FillSection, FlowName, FluidSection,
    GaugeKind, GaugeSection, OutputSection, Pressure, PressureName, ShapeName, ShiftingSection, SlipName, TimeSection,
    WallKind, WallSection,
};
pub use shipped::{SHIPPED, ShippedCase};

use crate::{
    Body, Boundaries, ClosedSurface, Flow, FluidOptions, Integrator, MirrorWall, Motion, Shape, ShiftingOptions,
    SphError, TimeStepOptions, Viscosity,
};
use locate::{line_of, section_at};
use sections::{ShapeKeys, SurfaceKeys};

/// A case file: fluid, domain, what is filled, walls, bodies, output.
///
/// ```
/// use fieldstone_sph::Case;
/// let text = fieldstone_sph::SHIPPED.iter().find(|c| c.name == "hydrostatic").map(|c| c.text);
/// let case = Case::parse(text.unwrap_or_default(), "hydrostatic.toml")?;
/// let solver = case.solver()?;
/// assert_eq!(solver.state().len(), 40 * 20);
/// let error = Case::parse("spacing = 0.1\ncolour = 3\n", "my.toml").unwrap_err().to_string();
/// assert!(error.starts_with("my.toml:2: unknown field `colour`, expected one of `title`, `dimension`"), "{error}");
/// # Ok::<(), fieldstone_sph::SphError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// What the file says; may be changed, and is checked before anything is made of it. Messages then name the line where the file
    /// has, or would have, what is wrong.
    pub sections: Sections,
    text: String,
    file: String,
    /// Surfaces that fills and bodies name, read once.
    surfaces: Vec<(SurfaceKeys, Arc<ClosedSurface>)>,
    /// Motions by the names of their tables and the dimension, read once.
    motions: Vec<(String, usize, Motion)>,
    /// The sections that were checked last, and the flow that they make.
    checked: Option<Box<(Sections, Flow)>>,
}

/// The tables of a case file.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Sections {
    /// One line on what it is.
    #[serde(default)]
    pub title: String,
    /// 2 or 3.
    pub dimension: usize,
    /// Δx.
    pub spacing: f64,
    /// The domain.
    pub domain: DomainSection,
    /// The fluid.
    pub fluid: FluidSection,
    /// Time.
    pub time: TimeSection,
    /// Where there is fluid at the start.
    pub fill: Vec<FillSection>,
    /// Walls.
    #[serde(default)]
    pub wall: Vec<WallSection>,
    /// Bodies.
    #[serde(default)]
    pub body: Vec<BodySection>,
    /// Particle shifting.
    pub shifting: Option<ShiftingSection>,
    /// Series of particle files, gauges, checkpoints.
    #[serde(default)]
    pub output: OutputSection,
    /// Gauges.
    #[serde(default)]
    pub gauge: Vec<GaugeSection>,
}

impl Case {
    /// Reads a case file.
    ///
    /// # Errors
    /// [`SphError::Case`] with the line.
    pub fn read(path: &Path) -> Result<Self, SphError> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path).map_err(|e| {
            let remedy = if path.as_os_str() == "-" {
                "for standard input give /dev/stdin"
            } else {
                "`fieldstone sph new` writes a case to start from"
            };
            let message = format!("cannot be read: {e}; {remedy}");
            SphError::Case { file: file.clone(), line: 1, message }
        })?;
        Self::parse(&text, &file)
    }

    /// Parses the text of a case file; `file` is its name in messages, and files that it names are looked for beside it.
    ///
    /// # Errors
    /// [`SphError::Case`] with the line: an unknown key, a value of the wrong kind or out of range.
    pub fn parse(text: &str, file: &str) -> Result<Self, SphError> {
        let sections: Sections = toml::from_str(text).map_err(|e| {
            let start = e.span().map_or(0, |span| span.start.min(text.len()));
            let line = text.as_bytes()[..start].iter().filter(|&&b| b == b'\n').count() + 1;
            let mut message = e.message().trim_end().replace('\n', " ");
            message = message.replace("expected usize", "expected a whole number from 0");
            let freely =
                ["mass", "inertia", "density", "velocity", "floating"].map(|key| format!("unknown field `{key}`"));
            if section_at(text, line) == Some("body") && freely.iter().any(|start| message.starts_with(start)) {
                message.push_str("; bodies rest or follow their motion's table: floating bodies are out of scope");
            }
            SphError::Case { file: file.into(), line, message }
        })?;
        let (surfaces, motions) = (Vec::new(), Vec::new());
        let mut case = Self { sections, text: text.into(), file: file.into(), surfaces, motions, checked: None };
        case.read_and_check()?;
        Ok(case)
    }

    /// The text it was parsed from; what was changed in the sections since, but for the spacing, is not in it.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The sections as they are now, as a case file: what was left out in the text stands there with its value.
    ///
    /// # Errors
    /// [`SphError::Case`] where TOML cannot say what a section holds; names and numbers, which are all they hold, it can.
    ///
    /// ```
    /// # use fieldstone_sph::{Case, SHIPPED};
    /// let mut case = SHIPPED[0].at_spacing(None)?;
    /// case.sections.time.end = 0.25;
    /// assert_eq!(Case::parse(&case.to_toml()?, "case.toml")?.sections, case.sections);
    /// # Ok::<(), fieldstone_sph::SphError>(())
    /// ```
    pub fn to_toml(&self) -> Result<String, SphError> {
        toml::to_string(&self.sections)
            .map_err(|e| self.fault("", 0, "", format!("the case cannot be written as TOML: {e}")))
    }

    /// The same case at another spacing, with its [`sections`](Self::sections) as they are now and the [`text`](Self::text) that it
    /// was parsed from.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn with_spacing(&self, spacing: f64) -> Result<Self, SphError> {
        let is_key =
            |line: &str| line.trim_start().strip_prefix("spacing").is_some_and(|l| l.trim_start().starts_with('='));
        let lines = self
            .text
            .lines()
            .map(|line| if is_key(line) { format!("spacing = {spacing}\n") } else { format!("{line}\n") });
        let mut case = Self { text: lines.collect(), ..self.clone() };
        case.sections.spacing = spacing;
        case.read_and_check()?;
        // The text has to say what the sections do.
        if toml::from_str::<Sections>(&case.text).is_ok_and(|said| said.spacing.to_bits() == spacing.to_bits()) {
            return Ok(case);
        }
        Err(self.fault("", 0, "spacing", "the spacing cannot be changed here; give it as a line `spacing = …`"))
    }

    fn fault(&self, section: &str, nth: usize, key: &str, message: impl Into<String>) -> SphError {
        let line = line_of(&self.text, section, nth, key);
        SphError::Case { file: self.file.clone(), line, message: message.into() }
    }

    /// Up: the last axis.
    fn up(&self) -> usize {
        self.sections.dimension - 1
    }

    /// Fluid, boundaries and options, checked; files that the case names are those that were read with it.
    ///
    /// # Errors
    /// [`SphError::Case`] with the line of what does not fit.
    pub fn flow(&self) -> Result<Flow, SphError> {
        match self.checked.as_deref() {
            Some((sections, flow)) if *sections == self.sections => Ok(flow.clone()),
            _ => self.check(),
        }
    }

    /// Reads the files that the sections name, and keeps the flow that they make.
    fn read_and_check(&mut self) -> Result<(), SphError> {
        self.read_surfaces()?;
        let flow = self.check()?;
        let bodies = self.sections.body.iter().zip(&flow.boundaries.bodies);
        let read = bodies.filter_map(|(section, body)| match (&section.motion, &body.motion) {
            (Some(MotionSection::File(name)), Some(motion)) => {
                Some((name.clone(), self.sections.dimension, motion.clone()))
            }
            _ => None,
        });
        self.motions = read.collect();
        self.checked = Some(Box::new((self.sections.clone(), flow)));
        Ok(())
    }

    /// What the sections say as a flow, which is checked by itself.
    fn assembled(&self) -> Result<Flow, SphError> {
        let s = &self.sections;
        let f = &s.fluid;
        for (key, value) in [("expected_speed", f.expected_speed), ("expected_pressure", f.expected_pressure)] {
            if !(value >= 0.0 && value.is_finite()) {
                let message = format!("{key} is {value}; it must be finite and at least 0");
                return Err(self.fault("fluid", 0, key, message));
            }
        }
        let mut fluid = FluidOptions::new(s.dimension, s.spacing, f.expected_speed, f.expected_pressure);
        fluid.density = f.density;
        fluid.sound_speed =
            f.sound_speed.unwrap_or_else(|| crate::sound_speed_bound(f.density, f.expected_speed, f.expected_pressure));
        fluid.smoothing = f.smoothing;
        fluid.viscosity = match (f.viscosity, f.alpha) {
            (Some(mu), _) => Viscosity::Dynamic(mu),
            (None, alpha) => Viscosity::Alpha(alpha.unwrap_or(0.02)),
        };
        fluid.delta = f.delta;
        fluid.surface_tension = f.surface_tension;
        fluid.tensile_control = f.tensile_control;
        fluid.particle_volume = self.particle_volume()?;
        let gravity = f.gravity.as_deref();
        fluid.gravity = std::array::from_fn(|k| gravity.and_then(|g| g.get(k)).copied().unwrap_or(0.0));
        if let Some(found) = gravity.map(<[f64]>::len).filter(|&found| found != s.dimension) {
            let message = format!("{found} numbers were found; give {}", s.dimension);
            return Err(self.fault("fluid", 0, "gravity", message));
        }
        let mut flow = Flow::new(fluid, self.boundaries()?);
        flow.time_step = TimeStepOptions {
            integrator: match s.time.integrator {
                CaseIntegrator::Symplectic => Integrator::Symplectic,
                CaseIntegrator::Rk4 => Integrator::RungeKutta4,
            },
            cfl: s.time.cfl,
            viscous: s.time.viscous,
            capillary: s.time.capillary,
            largest: s.time.largest.unwrap_or(f64::INFINITY),
        };
        if let Some(shifting) = &s.shifting {
            let method: Method = shifting
                .detection
                .parse()
                .map_err(|e: SurfaceError| self.fault("shifting", 0, "detection", e.to_string()))?;
            if !method.supports(s.dimension) {
                let message = format!("the {method} method does not exist in {} dimensions", s.dimension);
                return Err(self.fault("shifting", 0, "detection", message));
            }
            flow.detection = Some(method);
            let options = ShiftingOptions {
                k_cfl: shifting.k_cfl.unwrap_or(s.time.cfl),
                r: shifting.r,
                n: shifting.n,
                factor: shifting.factor,
                mach: shifting.mach,
                cap: shifting.cap,
                nearest_counts: shifting.nearest_counts,
            };
            // What is switched off is right, too, before it is switched on.
            options.validate().map_err(|e| self.placed(e))?;
            flow.shifting = shifting.enabled.then_some(options);
        }
        flow.validate().map_err(|e| self.placed(e))?;
        Ok(flow)
    }

    /// Normals and offsets of the mirror walls that a section stands for: of a tank those of all faces but open and periodic ones.
    fn planes_of(&self, wall: &WallSection) -> Vec<([f64; 3], f64)> {
        let Sections { domain, dimension, .. } = &self.sections;
        if let (Some(point), Some(normal)) = (&wall.point, &wall.normal) {
            let offset = point.iter().zip(normal).map(|(p, n)| p * n).sum();
            return vec![(std::array::from_fn(|k| normal.get(k).copied().unwrap_or(0.0)), offset)];
        }
        let mut planes = Vec::new();
        for axis in 0..*dimension {
            for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                let face = format!("{}{}", ["x", "y", "z"][axis], ["-", "+"][side]);
                if domain.periodic.iter().any(|p| *p as usize == axis) || domain.open.contains(&face) {
                    continue;
                }
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                planes.push((normal, sign * if side == 0 { domain.low[axis] } else { domain.high[axis] }));
            }
        }
        planes
    }

    fn boundaries(&self) -> Result<Boundaries, SphError> {
        let s = &self.sections;
        let corner = |given: &[f64]| std::array::from_fn(|k| given.get(k).copied().unwrap_or(0.0));
        let (low, high): ([f64; 3], [f64; 3]) = (corner(&s.domain.low), corner(&s.domain.high));
        let mut boundaries = Boundaries::new(low, high, s.spacing);
        for axis in &s.domain.periodic {
            boundaries.periodic[*axis as usize] = true;
        }
        for face in &s.domain.open {
            let axis = ["x", "y", "z"].iter().position(|a| face.starts_with(a)).filter(|&a| a < s.dimension);
            let side = ["-", "+"].iter().position(|sign| face.len() == 2 && face.ends_with(sign));
            let (Some(axis), Some(side)) = (axis, side) else {
                let message = format!("'{face}' is no face; give x-, x+, y-, y+, z- or z+, as the dimension allows");
                return Err(self.fault("domain", 0, "open", message));
            };
            boundaries.open[axis][side] = true;
        }
        for (nth, wall) in s.wall.iter().enumerate() {
            if let (Some(point), Some(normal)) = (&wall.point, &wall.normal)
                && (point.len() != s.dimension || normal.len() != s.dimension)
            {
                let message = format!("point and normal must have {} numbers each", s.dimension);
                return Err(self.fault("wall", nth, "point", message));
            }
            for (normal, offset) in self.planes_of(wall) {
                let plane = Wall::new(normal, offset).map_err(|e| self.fault("wall", nth, "normal", e.to_string()))?;
                boundaries.walls.push(MirrorWall { plane, slip: wall.slip.into() });
            }
        }
        for (nth, body) in s.body.iter().enumerate() {
            let shape = self.shape("body", nth, &body.keys())?;
            boundaries.bodies.push(Body { motion: self.motion(nth)?, ..Body::new(shape, body.slip.into()) });
        }
        Ok(boundaries)
    }

    /// The shape of the nth fill or body.
    fn shape(&self, section: &str, nth: usize, keys: &ShapeKeys) -> Result<Shape, SphError> {
        let placed = |(key, message): (&str, String)| self.fault(section, nth, key, message);
        let Some(wanted) = keys.surface().map_err(placed)? else {
            return keys.plain(self.sections.dimension).map_err(placed);
        };
        let known = self.surfaces.iter().find(|(keys, _)| *keys == wanted).map(|(_, surface)| Arc::clone(surface));
        Ok(Shape::Surface(known.map_or_else(|| self.surface(section, nth, &wanted), Ok)?))
    }

    /// What fills and bodies say of their shapes, with section and number.
    fn shapes(&self) -> impl Iterator<Item = (&'static str, usize, ShapeKeys<'_>)> {
        let fills = self.sections.fill.iter().map(FillSection::keys).enumerate();
        let bodies = self.sections.body.iter().map(BodySection::keys).enumerate();
        fills.map(|(nth, keys)| ("fill", nth, keys)).chain(bodies.map(|(nth, keys)| ("body", nth, keys)))
    }

    /// Reads each surface once: flow and state ask for it again and again.
    fn read_surfaces(&mut self) -> Result<(), SphError> {
        let mut surfaces = self.surfaces.clone();
        for (section, nth, keys) in self.shapes() {
            let wanted = keys.surface().map_err(|(key, message)| self.fault(section, nth, key, message))?;
            if let Some(wanted) = wanted.filter(|wanted| surfaces.iter().all(|(keys, _)| keys != wanted)) {
                let surface = self.surface(section, nth, &wanted)?;
                surfaces.push((wanted, surface));
            }
        }
        self.surfaces = surfaces;
        Ok(())
    }

    fn surface(&self, section: &str, nth: usize, keys: &SurfaceKeys) -> Result<Arc<ClosedSurface>, SphError> {
        if self.sections.dimension == 2 {
            let message = "a surface bounds a solid in three dimensions only; take a box, cylinder or sphere";
            return Err(self.fault(section, nth, "shape", message));
        }
        let path = self.beside(&keys.file);
        let placed = |message: String| self.fault(section, nth, "file", message);
        let (mut points, triangles) = fieldstone_io::read_stl(&path).map_err(|e| placed(e.to_string()))?;
        for point in &mut points {
            *point = std::array::from_fn(|k| keys.scale * point[k] + keys.offset[k]);
        }
        let surface = ClosedSurface::new(points, triangles);
        surface.map(Arc::new).map_err(|e| placed(format!("{}: {e}", path.display())))
    }

    /// The motion of a body, from its rows or its file.
    fn motion(&self, nth: usize) -> Result<Option<Motion>, SphError> {
        let dimension = self.sections.dimension;
        match &self.sections.body[nth].motion {
            None => Ok(None),
            Some(MotionSection::File(name)) => {
                if let Some((.., known)) = self.motions.iter().find(|(n, d, _)| n == name && *d == dimension) {
                    return Ok(Some(known.clone()));
                }
                let path = self.beside(name);
                if !path.is_file() {
                    let message = format!("there is no file {}; give its path from the case's folder", path.display());
                    return Err(self.fault("body", nth, "motion", message));
                }
                motion::read_table(&path, dimension).map(Some)
            }
            Some(MotionSection::Rows(rows)) => MotionSection::of_rows(rows, dimension)
                .map(Some)
                .map_err(|message| self.fault("body", nth, "motion", message)),
        }
    }

    /// Path of a file that is named in the case: from the case's own folder.
    fn beside(&self, name: &str) -> PathBuf {
        Path::new(&self.file).parent().unwrap_or(Path::new("")).join(name)
    }
}
