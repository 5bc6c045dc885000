//! Whether the sections of a case make sense, before anything is made of them.

use super::flows::top_level;
use super::keys::{positive, vector};
use super::{Case, FlowName, GaugeKind, WallKind};
use crate::{Flow, FluidOptions, SphError, State, gauge_columns, sound_speed_bound};

/// Most particles of a case: their numbers have 32 bits, and their positions alone take 6 GB.
const MOST_PARTICLES: f64 = (1u64 << 28) as f64;

/// Speed of a body over that of sound beyond which what it meets is compressed by a quarter and more.
const FASTEST_BODY: f64 = 0.25;

impl Case {
    /// Checks what one section says, and what sections say of each other: the flow that they make.
    pub(super) fn check(&self) -> Result<Flow, SphError> {
        let s = &self.sections;
        if !matches!(s.dimension, 2 | 3) {
            return Err(self.fault("", 0, "dimension", format!("the dimension is {}; it must be 2 or 3", s.dimension)));
        }
        if !(s.spacing > 0.0 && s.spacing.is_finite()) {
            let message = format!("the spacing is {}; it must be finite and above 0", s.spacing);
            return Err(self.fault("", 0, "spacing", message));
        }
        for (section, key, value) in [
            ("time", "end", s.time.end),
            ("output", "every", s.output.every.unwrap_or(1.0)),
            ("output", "gauges_every", s.output.gauges_every.unwrap_or(1.0)),
            ("output", "checkpoint_every", s.output.checkpoint_every),
        ] {
            positive(section, key, Some(value)).map_err(|(key, message)| self.fault(section, 0, key, message))?;
        }
        if s.fluid.viscosity.is_some() && s.fluid.alpha.is_some() {
            return Err(self.fault("fluid", 0, "alpha", "both viscosity and alpha are given; give one of them"));
        }
        self.check_domain()?;
        for (nth, fill) in s.fill.iter().enumerate() {
            fill.check_flow(s.dimension).map_err(|(key, message)| self.fault("fill", nth, key, message))?;
        }
        for (section, nth, keys) in self.shapes() {
            keys.check().map_err(|(key, message)| self.fault(section, nth, key, message))?;
        }
        for (nth, wall) in s.wall.iter().enumerate() {
            let given = [wall.point.is_some(), wall.normal.is_some()];
            if given != [wall.kind == WallKind::Plane; 2] {
                let message = "a plane needs point and normal, a tank has neither";
                return Err(self.fault("wall", nth, "kind", message));
            }
        }
        for (nth, gauge) in s.gauge.iter().enumerate() {
            gauge
                .check(s.body.len(), &s.domain.low, &s.domain.high)
                .map_err(|(key, message)| self.fault("gauge", nth, key, message))?;
            let way = gauge.axis.unwrap_or_default().axis();
            if gauge.kind == GaugeKind::Front && s.domain.periodic.iter().any(|&axis| axis as usize == way) {
                let message = "along a periodic axis there is no front: what leaves comes in again; give another axis";
                return Err(self.fault("gauge", nth, "axis", message));
            }
            let taken = gauge_columns(&s.gauge[..nth], true);
            let of_flow = gauge_columns(&[], true).len();
            let own = gauge_columns(std::slice::from_ref(gauge), true).split_off(of_flow);
            let is_no_name = |c: char| matches!(c, ',' | '"') || c.is_control();
            let message = if gauge.name.trim().is_empty() || gauge.name.contains(is_no_name) {
                format!(
                    "the name {:?} is empty, or holds a comma, a quote or a control character; give another",
                    gauge.name
                )
            } else if own.iter().any(|name| taken.contains(name)) {
                format!("the name '{}' is taken; give another", gauge.name)
            } else {
                continue;
            };
            return Err(self.fault("gauge", nth, "name", message));
        }
        self.check_size()?;
        let flow = self.assembled()?;
        self.check_motions(&flow)?;
        // The lattice of the start would be torn where it meets its own image.
        for &axis in &s.domain.periodic {
            let length = s.domain.high[axis as usize] - s.domain.low[axis as usize];
            let layers = length / s.spacing;
            if (layers - layers.round()).abs() > 1e-6 * layers {
                let message = format!(
                    "the periodic length {length} is {layers:.3} spacings of {}; it must be a whole number of them, as {} is",
                    s.spacing,
                    layers.round() * s.spacing
                );
                return Err(self.fault("domain", 0, "high", message));
            }
        }
        Ok(flow)
    }

    /// Refuses gauges of pressure where there is none at the start, nor will be: in bodies and behind walls they would read 0.
    pub(super) fn check_gauges_in_fluid(&self, flow: &Flow) -> Result<(), SphError> {
        let Flow { fluid, boundaries, .. } = flow;
        // On a face is not beyond it, rounded or not.
        let rounding = 1e-6 * fluid.spacing;
        for (nth, gauge) in self.sections.gauge.iter().enumerate().filter(|(_, g)| g.kind == GaugeKind::Pressure) {
            let at = gauge.place();
            let body = boundaries.bodies.iter().position(|body| body.depth(at, 0.0, fluid.dimension) > rounding);
            let wall = boundaries.walls.iter().position(|wall| wall.plane.distance(at) < -rounding);
            let place = match (body, wall) {
                (Some(body), _) => format!("inside body {body}"),
                (None, Some(wall)) => format!("behind wall {}", self.section_of_wall(wall)),
                (None, None) => continue,
            };
            let at = &at[..fluid.dimension];
            let message = format!(
                "at is {at:?}, {place}, where there is no pressure to measure; put it on the face, or before it"
            );
            return Err(self.fault("gauge", nth, "at", message));
        }
        Ok(())
    }

    fn check_domain(&self) -> Result<(), SphError> {
        let s = &self.sections;
        let (low, high) = (&s.domain.low, &s.domain.high);
        for (key, corner) in [("low", low), ("high", high)] {
            vector(key, corner, s.dimension).map_err(|(key, message)| self.fault("domain", 0, key, message))?;
        }
        if low.iter().zip(high).any(|(low, high)| low >= high) {
            let message = format!("high is {high:?}; it must be above low, {low:?}, along every axis");
            return Err(self.fault("domain", 0, "high", message));
        }
        for (nth, &axis) in s.domain.periodic.iter().enumerate() {
            let name = ["x", "y", "z"][axis as usize];
            let message = if axis as usize >= s.dimension {
                format!("there is no {name} in two dimensions; give x or y")
            } else if s.domain.periodic[..nth].contains(&axis) {
                format!("{name} is listed twice; list it once")
            } else if s.domain.open.iter().any(|face| face.starts_with(name)) {
                format!("{name} is periodic and has an open face; what leaves comes in again or is removed, not both")
            } else {
                continue;
            };
            return Err(self.fault("domain", 0, "periodic", message));
        }
        Ok(())
    }

    /// Whether gravity lets a fill begin as it says: with a wave, or below a level.
    pub(super) fn check_gravity(&self, nth: usize, bounds: ([f64; 3], [f64; 3]), flow: &Flow) -> Result<(), SphError> {
        let (fill, gravity) = (&self.sections.fill[nth], flow.fluid.gravity);
        let levelling = flow.boundaries.levelling(gravity);
        let up = self.up();
        let downwards = gravity[up] < 0.0 && (0..up).all(|k| gravity[k] == 0.0);
        if fill.flow == FlowName::StandingWave && !downwards {
            let message = format!(
                "a standing wave needs gravity along minus {}, it is {:?}; turn the case, or take another flow",
                ["x", "y", "z"][up],
                &gravity[..=up]
            );
            return Err(self.fault("fill", nth, "flow", message));
        }
        let Some(surface) = fill.surface else { return Ok(()) };
        if levelling == [0.0; 3] {
            let message = "without gravity there is no level, and along a periodic axis it does not count; remove surface, or give \
                           gravity";
            return Err(self.fault("fill", nth, "surface", message));
        }
        let top = top_level(bounds, levelling);
        let extent = (0..3).map(|k| bounds.1[k] - bounds.0[k]).fold(0.0, f64::max);
        // A level at the top may come rounded.
        if surface < top - 1e-9 * extent {
            let message = format!(
                "surface is {surface}; it must be at least the fill's top, {top}, or the pressure were negative above it"
            );
            return Err(self.fault("fill", nth, "surface", message));
        }
        Ok(())
    }

    /// Eq. 3 for what the particles of a fill, from `first` on, begin with: more than was expected may be known by then.
    pub(super) fn check_start(
        &self,
        nth: usize,
        fluid: &FluidOptions,
        state: &State,
        first: usize,
    ) -> Result<(), SphError> {
        let pressures = state.density[first..].iter().map(|&density| fluid.pressure(density));
        let (lowest, highest) =
            pressures.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let vacuum = -fluid.density * fluid.sound_speed * fluid.sound_speed;
        if lowest <= vacuum {
            let message = format!("the fill begins with a pressure of {lowest}; it must be above −ρ₀c₀² = {vacuum}");
            return Err(self.fault("fill", nth, "pressure", message));
        }
        let square = |u: &[f64; 3]| u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
        let speed = state.u[first..].iter().map(square).fold(0.0, f64::max).sqrt();
        let speed_key = if self.sections.fill[nth].velocity.is_some() { "velocity" } else { "flow" };
        for (key, what, value, needed) in [
            ("pressure", "a pressure", highest, sound_speed_bound(fluid.density, 0.0, highest)),
            (speed_key, "a speed", speed, sound_speed_bound(fluid.density, speed, 0.0)),
        ] {
            if needed > fluid.sound_speed * (1.0 + 1e-9) {
                let message = format!(
                    "the fill begins with {what} of {value:.6}, for which the speed of sound, {}, must be at least {needed:.6} \
                     (Eq. 3); raise expected_{}",
                    fluid.sound_speed,
                    if key == "pressure" { key } else { "speed" }
                );
                return Err(self.fault("fill", nth, key, message));
            }
        }
        Ok(())
    }

    /// Refuses tables of motion that are too fast for the fluid, units that do not fit, or that lead to a periodic face.
    fn check_motions(&self, flow: &Flow) -> Result<(), SphError> {
        flow.boundaries.check_repeats(&flow.fluid, self.sections.time.end).map_err(|e| self.placed(e))?;
        for (nth, body) in flow.boundaries.bodies.iter().enumerate() {
            let Some(motion) = &body.motion else { continue };
            let (speed, _) = motion.largest(0.0, self.sections.time.end);
            let sound_speed = flow.fluid.sound_speed;
            if speed > FASTEST_BODY * sound_speed {
                let message = format!(
                    "the body moves as fast as {speed:.6}; that must be at most a quarter of the speed of sound, {sound_speed}, and \
                     a tenth is better (Eq. 3): raise expected_speed, or look at the table's units"
                );
                return Err(self.fault("body", nth, "motion", message));
            }
        }
        Ok(())
    }

    /// Before any lattice is made: a spacing in the wrong unit would take all memory.
    fn check_size(&self) -> Result<(), SphError> {
        let s = &self.sections;
        let mut particles = 0.0;
        for (section, nth, keys) in self.shapes() {
            let (low, high) = self.shape(section, nth, &keys)?.bounds();
            particles += (0..s.dimension).map(|k| ((high[k] - low[k]) / s.spacing).max(1.0)).product::<f64>();
        }
        if particles <= MOST_PARTICLES {
            return Ok(());
        }
        let message = format!(
            "a spacing of {} makes about {particles:.1e} particles, at most {MOST_PARTICLES:.1e} are possible; enlarge it",
            s.spacing
        );
        Err(self.fault("", 0, "spacing", message))
    }
}
