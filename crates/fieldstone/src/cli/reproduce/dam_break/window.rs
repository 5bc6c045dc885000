//! Fig. 11: one layer of particles where the wave has run up the wall, by four methods.

use std::fmt::Write as _;
use std::path::Path;

use fieldstone::surface::Comparison;

use super::flow_run::{FlowRun, Frame};
use super::picture::{self, Panel, View};
use super::tables::{NAMES, label};

/// The right-hand part of the tank.
const WINDOW: [f64; 2] = [2.4, 3.2];

pub(super) fn section(flow: &FlowRun, folder: &Path) -> anyhow::Result<String> {
    let mut text = String::from(
        "## Fig. 11: one layer in the right-hand window\n\nThe layer in the middle of the tank, x from 2.4 m to the wall. \
         Misses + false positives there:\n\n| time | Haque | Marrone | Wang |\n|---|---|---|---|\n",
    );
    let mut pictures = String::new();
    for time in [1.45, 1.8] {
        let Frame { solver, .. } = flow.frame(time)?;
        let (reference, others) = label(&solver)?;
        let view = View::middle_layer(&solver, WINDOW);
        let seen: Vec<usize> = (0..reference.len()).filter(|&i| view.sees(solver.state().x[i])).collect();
        let among = |labels: &[bool]| -> Vec<bool> { seen.iter().map(|&i| labels[i]).collect() };
        let _ = write!(text, "| {time} s |");
        for labels in &others {
            let c = Comparison::new(&among(&reference), &among(labels))?;
            let _ = write!(text, " {} + {} of {} |", c.misses, c.false_positives, c.reference);
        }
        text.push('\n');
        let mut panels: Vec<Panel<'_>> = (NAMES.iter().zip(&others))
            .map(|(name, labels)| Panel { title: format!("{name}, {time} s"), labels })
            .collect();
        panels.push(Panel { title: format!("exact, {time} s"), labels: &reference });
        let name = format!("fig11_{time:.2}s.png");
        picture::draw(&folder.join(&name), &solver, view, 2, &reference, &panels)?;
        let _ = writeln!(pictures, "![Window at {time} s]({name})");
    }
    Ok(format!("{text}\n{pictures}\n"))
}
