//! Fig. 13: how long the methods take on the first ten steps of the dam break.

use std::fmt::Write as _;
use std::path::Path;

use fieldstone::io::AtomicFile;
use fieldstone::surface::{Exact, Haque, Marrone, SemiGeometrical, SurfaceDetection, Wang};
use plotters::chart::SeriesLabelPosition;

use super::flow_run::Flows;
use super::tables::{case, dam_break_name};
use crate::cli::reproduce::clock;
use crate::cli::reproduce::plots::{Axis, COLOURS, Curve, Plot, draw};
use crate::cli::reproduce::progress;

/// Steps of each flow that are timed, as in the paper.
const STEPS: u64 = 10;
/// Spacings over that asked for.
const SPACINGS: [f64; 4] = [2.0, 1.5, 1.25, 1.0];

/// Seconds for 10⁶ particles that the paper states, on its machine (Intel Core i5-3470), by the names below.
const PAPER: [Option<f64>; 5] = [None, Some(3.34), Some(0.65), Some(4.04), Some(139.79)];

pub(super) fn section(flows: &Flows, folder: &Path, spacing: f64, slab: bool) -> anyhow::Result<String> {
    let methods: [(&str, Box<dyn SurfaceDetection + Send + Sync>); 5] = [
        ("exact", Box::new(Exact::default())),
        ("semi-geometrical", Box::new(SemiGeometrical::default())),
        ("Wang", Box::new(Wang::default())),
        ("Marrone", Box::new(Marrone::default())),
        ("Haque", Box::new(Haque::default())),
    ];
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let bar = progress(STEPS * SPACINGS.len() as u64, "Fig. 13")?;
    let mut table = String::from("spacing,particles,method,mean_seconds\n");
    let mut curves: Vec<Vec<(f64, f64)>> = vec![Vec::new(); methods.len()];
    for factor in SPACINGS {
        let mut case = case(dam_break_name(slab), factor * spacing)?;
        flows.changes.apply(&mut case);
        let mut solver = case.solver()?;
        let mut seconds = vec![0.0; methods.len()];
        for _ in 0..STEPS {
            solver.step()?;
            for ((_, method), sum) in methods.iter().zip(&mut seconds) {
                let took = one_thread.install(|| {
                    let start = clock::thread_seconds();
                    solver.labels(method.as_ref()).map(|_| clock::thread_seconds() - start)
                })?;
                *sum += took / STEPS as f64;
            }
            bar.inc(1);
        }
        let particles = solver.state().len();
        for (((name, _), mean), curve) in methods.iter().zip(&seconds).zip(&mut curves) {
            let _ = writeln!(table, "{},{particles},{name},{mean:.6}", case.sections.spacing);
            curve.push((particles as f64, mean.max(1e-6)));
        }
    }
    bar.finish_and_clear();
    AtomicFile::write(&folder.join("fig13.csv"), |out| out.write_all(table.as_bytes()))?;
    let all = || curves.iter().flatten();
    let ends = |values: &dyn Fn(&(f64, f64)) -> f64| {
        [all().map(values).fold(f64::INFINITY, f64::min), all().map(values).fold(0.0, f64::max)]
    };
    let ([few, many], [fast, slow]) = (ends(&|p| p.0), ends(&|p| p.1));
    let plot = Plot {
        title: "Mean of the first ten steps".into(),
        x: Axis { name: "particles", range: [0.9 * few, 1.1 * many], logarithmic: true },
        y: Axis { name: "seconds", range: [0.5 * fast, 2.0 * slow], logarithmic: true },
        curves: (methods.iter().zip(&curves).zip(COLOURS))
            .map(|(((name, _), points), colour)| Curve {
                name: (*name).into(),
                points: points.clone(),
                colour,
                dashed: false,
            })
            .collect(),
        legend: Some(SeriesLabelPosition::UpperLeft),
    };
    draw(&folder.join("fig13.png"), &[plot])?;
    let mut text = String::from(
        "## Fig. 13: time of a detection\n\n![Times](fig13.png)\n\nProcessor time of one thread, images at the walls and \
         neighbour search included, the mean of the flow's first ten steps. Microseconds per particle (the paper states \
         seconds for 10⁶ particles, so the same unit, on an Intel Core i5-3470):\n\n| particles |",
    );
    methods.iter().for_each(|(name, _)| text += &format!(" {name} |"));
    text += &format!("\n|---|{}\n", "---|".repeat(methods.len()));
    for k in 0..SPACINGS.len() {
        text += &format!("| {} |", curves[0][k].0);
        curves.iter().for_each(|curve| text += &format!(" {:.2} |", 1e6 * curve[k].1 / curve[k].0));
        text.push('\n');
    }
    text += "| the paper, 10⁶ |";
    PAPER.iter().for_each(|p| text += &p.map_or(" – |".into(), |p| format!(" {p} |")));
    Ok(text + "\n\n")
}
