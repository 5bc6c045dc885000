//! Fig. 12: the exact detection with wider cones, which see less of concave surfaces.

use std::fmt::Write as _;
use std::path::Path;

use fieldstone::surface::{Comparison, Exact, Haque, ScanningCone};

use super::flow_run::{FlowRun, Frame};
use super::picture::{self, Panel, View};

/// Half-angles of the cone in degrees; the first is half of Haque's smallest visible angle (Eq. 31).
const ANGLES: [f64; 3] = [66.5, 56.0, 45.0];

pub(super) fn section(flow: &FlowRun, folder: &Path) -> anyhow::Result<String> {
    let mut text = String::from(
        "## Fig. 12: half-angle of the cone\n\nExact detection with θ = 66.5°, half of what Haque's method can see (Eq. 31), \
         56° and 45°, against 45°: misses + false positives / M. A wider cone cannot find more: there are no false \
         positives. \"Differs from Haque\" counts particles that 66.5° and Haque's method label differently.\n\n\
         | time | 66.5° | 56° | 45° | Haque | differs from Haque |\n|---|---|---|---|---|---|\n",
    );
    let mut pictures = String::new();
    for time in [0.6, 1.45, 1.8] {
        let Frame { solver, .. } = flow.frame(time)?;
        let by = |angle: f64| -> anyhow::Result<Vec<bool>> {
            let exact = Exact::new(ScanningCone { angle, ..ScanningCone::default() })?;
            Ok(solver.labels(&exact)?)
        };
        let labels = [by(ANGLES[0])?, by(ANGLES[1])?, by(ANGLES[2])?];
        let (reference, haque) = (&labels[2], solver.labels(&Haque::default())?);
        let _ = write!(text, "| {time} s |");
        for found in labels.iter().chain([&haque]) {
            let c = Comparison::new(reference, found)?;
            let m = c.accuracy().unwrap_or(f64::NAN);
            let _ = write!(text, " {} + {} / {m:.3} |", c.misses, c.false_positives);
        }
        let differ = labels[0].iter().zip(&haque).filter(|(a, b)| a != b).count();
        let _ = writeln!(text, " {differ} of {} |", haque.len());
        if time == 0.6 {
            continue;
        }
        let panels: Vec<Panel<'_>> = (ANGLES.iter().zip(&labels))
            .map(|(angle, labels)| Panel { title: format!("θ = {angle}°, {time} s"), labels })
            .collect();
        let name = format!("fig12_{time:.2}s.png");
        let view = View::whole(&solver, solver.flow().fluid.spacing);
        picture::draw(&folder.join(&name), &solver, view, 1, reference, &panels)?;
        let _ = writeln!(pictures, "![Cones at {time} s]({name})");
    }
    Ok(format!("{text}\n{pictures}\n"))
}
