//! Tables 1 to 3 with Fig. 10, 14 and 15: four methods on the flows of three dam breaks.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{anyhow, bail};
use fieldstone::io::AtomicFile;
use fieldstone::sph::{Case, SHIPPED, Solver};
use fieldstone::surface::{Comparison, Exact, Haque, Marrone, SurfaceDetection, Wang};

use super::flow_run::{FlowRun, Flows, Frame};
use super::picture::{self, Panel, View};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Table {
    DamBreak,
    TwoColumns,
    Obstacle,
}

/// The paper's TP, and M of Haque, Marrone and Wang, at a time.
struct Printed {
    time: f64,
    reference: usize,
    accuracy: [f64; 3],
}

/// Times of the dam break that some figure shows.
const DAM_BREAK_TIMES: [f64; 5] = [0.52, 0.6, 1.42, 1.45, 1.8];

/// The dam break of Table 1, which several figures look at, with the times of the tables and others.
pub(super) fn dam_break(flows: &Flows, spacing: f64, slab: bool, others: &[f64]) -> anyhow::Result<FlowRun> {
    let name = dam_break_name(slab);
    let times = [&DAM_BREAK_TIMES, others].concat();
    flows.run(name, case(name, spacing)?, &times, &tenths(&times))
}

/// Every 0.1 s before the last of the times.
pub(super) fn tenths(times: &[f64]) -> Vec<f64> {
    let end = times.iter().copied().fold(0.0, f64::max);
    (1..).map(|k| f64::from(k) / 10.0).take_while(|t| *t < end).collect()
}

pub(super) fn dam_break_name(slab: bool) -> &'static str {
    if slab { "dam-break-slab" } else { "dam-break" }
}

/// A shipped case at another spacing.
pub(super) fn case(name: &str, spacing: f64) -> anyhow::Result<Case> {
    let Some(shipped) = SHIPPED.iter().find(|c| c.name == name) else { bail!("no case {name}") };
    shipped.at_spacing(Some(spacing)).map_err(|e| anyhow!("--spacing: {e}"))
}

impl Table {
    fn printed(self) -> [Printed; 3] {
        let rows = match self {
            Self::DamBreak => [
                (0.6, 10_440, [0.701, 0.842, 0.842]),
                (1.45, 13_380, [0.663, 0.717, 0.724]),
                (1.8, 19_380, [0.721, 0.780, 0.766]),
            ],
            Self::TwoColumns => [
                (0.0, 16_882, [1.0, 1.0, 1.0]),
                (0.4, 17_274, [0.948, 0.959, 0.962]),
                (0.8, 38_281, [0.610, 0.686, 0.681]),
            ],
            Self::Obstacle => [
                (0.0, 16_680, [1.0, 1.0, 1.0]),
                (0.4, 37_647, [0.676, 0.733, 0.738]),
                (0.7, 71_173, [0.657, 0.633, 0.670]),
            ],
        };
        rows.map(|(time, reference, accuracy)| Printed { time, reference, accuracy })
    }

    fn title(self) -> &'static str {
        match self {
            Self::DamBreak => "Table 1, Fig. 10: dam break",
            Self::TwoColumns => "Table 2, Fig. 14: two columns at opposite corners",
            Self::Obstacle => "Table 3, Fig. 15: impact against an obstacle",
        }
    }

    fn file(self) -> &'static str {
        match self {
            Self::DamBreak => "table1",
            Self::TwoColumns => "table2",
            Self::Obstacle => "table3",
        }
    }

    fn flow(self, flows: &Flows, spacing: f64, slab: bool) -> anyhow::Result<FlowRun> {
        match self {
            Self::DamBreak => dam_break(flows, spacing, slab, &[]),
            Self::TwoColumns => {
                flows.run("double-dam-break", case("double-dam-break", 2.0 * spacing)?, &[0.0, 0.4, 0.8], &[])
            }
            Self::Obstacle => flows.run("obstacle", case("obstacle", 0.5 * spacing)?, &[0.0, 0.4, 0.7], &[]),
        }
    }

    /// Layers across the flow, where all are alike.
    fn layers(self, slab: bool, spacing: f64) -> Option<f64> {
        match self {
            Self::DamBreak if slab => Some(9.0),
            Self::DamBreak => Some((0.3 / spacing).round()),
            _ => None,
        }
    }

    /// Its section of the page.
    pub fn section(self, flows: &Flows, folder: &Path, spacing: f64, slab: bool) -> anyhow::Result<String> {
        let flow = self.flow(flows, spacing, slab)?;
        let layers = self.layers(slab, spacing);
        let spacing = flow.case.sections.spacing;
        let mut text = format!("## {}\n\n", self.title());
        let _ = writeln!(
            text,
            "Case `{}`, Δx = {spacing}, {} particles, {}. TP/EP (misses + false positives)/M:\n\n| time | {} | free surface \
             |\n|---|---|---|---|---|",
            flow.case.sections.title,
            flow.case.state()?.len(),
            flow.settings(),
            NAMES.join(" | "),
        );
        let mut pictures = String::new();
        let mut rows = String::from("spacing,time,method,tp,misses,false_positives,m,paper_m\n");
        for printed in &self.printed() {
            let Frame { solver, time } = flow.frame(printed.time)?;
            let (reference, others) = label(&solver)?;
            let picture = format!("{}_{:.2}s.png", self.file(), printed.time);
            draw(&folder.join(&picture), &solver, self, printed.time, &reference, &others)?;
            let mut line = format!("| {time:.3} s |");
            for ((name, labels), paper) in NAMES.iter().zip(&others).zip(printed.accuracy) {
                let c = Comparison::new(&reference, labels)?;
                let m = c.accuracy().unwrap_or(f64::NAN);
                let (tp, ep) = (c.reference, c.misidentified());
                let _ = write!(line, " {tp}/{ep} ({} + {})/{m:.3}, paper {paper:.3} |", c.misses, c.false_positives);
                let _ =
                    writeln!(rows, "{spacing},{time},{name},{tp},{},{},{m:.6},{paper}", c.misses, c.false_positives);
            }
            let tp = reference.iter().filter(|&&l| l).count();
            if let Some(layers) = layers {
                let (ours, paper) = (tp as f64 / layers, printed.reference as f64 / 30.0);
                let _ = write!(line, " {ours:.0} per layer, paper {paper:.0} |");
            } else {
                let _ = write!(line, " {tp}, paper {} |", printed.reference);
            }
            let _ = writeln!(text, "{line}");
            let _ = writeln!(pictures, "![at {:.2} s]({picture})", printed.time);
        }
        AtomicFile::write(&folder.join(self.file()).with_extension("csv"), |out| out.write_all(rows.as_bytes()))?;
        Ok(format!("{text}\n{pictures}\n"))
    }
}

pub(super) const NAMES: [&str; 3] = ["Haque", "Marrone", "Wang"];

/// Exact labels, and those of Haque, Marrone and Wang.
pub(super) fn label(solver: &Solver) -> anyhow::Result<(Vec<bool>, [Vec<bool>; 3])> {
    let by = |method: &dyn SurfaceDetection| solver.labels(method);
    Ok((by(&Exact::default())?, [by(&Haque::default())?, by(&Marrone::default())?, by(&Wang::default())?]))
}

fn draw(
    path: &Path,
    solver: &Solver,
    table: Table,
    time: f64,
    reference: &[bool],
    others: &[Vec<bool>; 3],
) -> anyhow::Result<()> {
    let mut panels: Vec<Panel<'_>> =
        NAMES.iter().zip(others).map(|(name, labels)| Panel { title: format!("{name}, {time} s"), labels }).collect();
    panels.push(Panel { title: format!("exact, {time} s"), labels: reference });
    // The nearest layer of a flow that hardly varies across; all of the others, the nearest ones last.
    let depth = if table == Table::DamBreak { solver.flow().fluid.spacing } else { f64::INFINITY };
    picture::draw(path, solver, View::whole(solver, depth), 2, reference, &panels)
}
