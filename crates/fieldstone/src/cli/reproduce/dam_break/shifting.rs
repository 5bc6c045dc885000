//! Fig. 18: the same dam break with shifting by Wang's and by the exact detection.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::anyhow;
use fieldstone::io::AtomicFile;
use fieldstone::particles::NeighbourGrid;
use fieldstone::particles::NeighbourOptions;
use fieldstone::sph::Solver;
use fieldstone::surface::{Exact, Wang};
use plotters::chart::SeriesLabelPosition;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::flow_run::{FlowRun, Flows};
use super::middle_slice::{MiddleSlice, Segment, surroundings};
use super::picture::View;
use super::tables::{case, dam_break, dam_break_name, tenths};
use crate::cli::reproduce::plots::{Axis, COLOURS, Curve, Plot, draw, save};

/// When the paper looks.
const TIMES: [f64; 2] = [2.24, 2.97];
const NAMES: [&str; 2] = ["exact", "Wang"];
const LINES: [RGBColor; 2] = [BLACK, RGBColor(220, 30, 30)];

/// Counts of one flow at one time.
struct Counts {
    time: f64,
    /// Free-surface particles by the exact and by Wang's detection.
    by: [usize; 2],
    /// Particles closer than a spacing to a free-surface particle of the exact detection, itself included.
    layer: usize,
}

pub(super) fn section(flows: &Flows, folder: &Path, spacing: f64, slab: bool) -> anyhow::Result<String> {
    let exact = dam_break(flows, spacing, slab, &TIMES)?;
    let name = dam_break_name(slab);
    let mut case = case(name, spacing)?;
    if let Some(shifting) = &mut case.sections.shifting {
        shifting.detection = "wang".into();
    }
    let wang = flows.run(&format!("{name}-wang"), case, &TIMES, &tenths(&TIMES))?;
    let runs = [exact, wang];
    let mut counts: [Vec<Counts>; 2] = [Vec::new(), Vec::new()];
    for (run, counts) in runs.iter().zip(&mut counts) {
        let mut times = [tenths(&TIMES), TIMES.to_vec()].concat();
        times.sort_unstable_by(f64::total_cmp);
        for time in times.into_iter().filter(|&t| run.has_frame(t)) {
            counts.push(count(run, time)?);
        }
    }
    let mut table = String::from("shifting_by,time,free_surface_exact,free_surface_wang,within_a_spacing\n");
    for (name, counts) in NAMES.iter().zip(&counts) {
        for Counts { time, by, layer } in counts {
            let _ = writeln!(table, "{name},{time},{},{},{layer}", by[0], by[1]);
        }
    }
    AtomicFile::write(&folder.join("fig18.csv"), |out| out.write_all(table.as_bytes()))?;
    plot(&folder.join("fig18_layer.png"), &counts)?;

    let mut text = format!(
        "## Fig. 18: shifting by Wang's and by the exact detection\n\nThe dam break computed twice, Δx = {spacing}, {}; the \
         detection that its shifting uses is all that differs. Particles in the surface layer: free surface by the exact / by Wang's detection \
         / closer than Δx to the free surface.\n\n| time | exact in the shifting | Wang in the shifting | layer, Wang over \
         exact |\n|---|---|---|---|\n",
        runs[0].settings(),
    );
    let mut pictures = String::from("![Surface layer](fig18_layer.png)\n");
    for time in [0.5, 1.0, 1.5, 2.0, 2.24, 2.5, 2.97] {
        let at = |counts: &[Counts]| counts.iter().position(|c| (c.time - time).abs() < 0.02);
        if let (Some(a), Some(b)) = (at(&counts[0]), at(&counts[1])) {
            let (a, b) = (&counts[0][a], &counts[1][b]);
            let _ = write!(text, "| {time} s | {} / {} / {} |", a.by[0], a.by[1], a.layer);
            let _ =
                writeln!(text, " {} / {} / {} | {:.3} |", b.by[0], b.by[1], b.layer, b.layer as f64 / a.layer as f64);
        }
    }
    for time in TIMES {
        let name = format!("fig18_{time:.2}s.png");
        picture(&folder.join(&name), &runs, time)?;
        let _ = writeln!(pictures, "![Surfaces at {time} s]({name})");
    }
    Ok(format!("{text}\n{pictures}\n"))
}

fn count(run: &FlowRun, time: f64) -> anyhow::Result<Counts> {
    let frame = run.frame(time)?;
    let solver = &frame.solver;
    let exact = solver.labels(&Exact::default())?;
    let wang = solver.labels(&Wang::default())?;
    let number = |labels: &[bool]| labels.iter().filter(|&&l| l).count();
    Ok(Counts { time: frame.time, by: [number(&exact), number(&wang)], layer: within_a_spacing(solver, &exact)? })
}

fn within_a_spacing(solver: &Solver, free: &[bool]) -> anyhow::Result<usize> {
    let spacing = solver.flow().fluid.spacing;
    let x = &solver.state().x;
    let surface: Vec<[f64; 3]> = x.iter().zip(free).filter(|(_, free)| **free).map(|(p, _)| *p).collect();
    let domain = surroundings(solver)?.domain;
    let grid = NeighbourGrid::build(&surface, NeighbourOptions { domain, ..NeighbourOptions::new(spacing) })?;
    let mut near = 0;
    for p in x {
        let mut found = false;
        grid.for_each_within(*p, spacing, |_, _, _| found = true)?;
        near += usize::from(found);
    }
    Ok(near)
}

fn plot(path: &Path, counts: &[Vec<Counts>; 2]) -> anyhow::Result<()> {
    let end = TIMES[1];
    let plot = |title: &str, value: &dyn Fn(&Counts) -> f64| {
        let most = counts.iter().flatten().map(value).fold(0.0, f64::max);
        Plot {
            title: title.into(),
            x: Axis { name: "time, s", range: [0.0, end], logarithmic: false },
            y: Axis { name: "particles", range: [0.0, 1.1 * most], logarithmic: false },
            curves: (NAMES.iter().zip(counts).zip(COLOURS))
                .map(|((name, counts), colour)| Curve {
                    name: format!("shifting by {name}"),
                    points: counts.iter().map(|c| (c.time, value(c))).collect(),
                    colour,
                    dashed: false,
                })
                .collect(),
            legend: Some(SeriesLabelPosition::LowerRight),
        }
    };
    draw(
        path,
        &[
            plot("Free surface by the exact detection", &|c| c.by[0] as f64),
            plot("Closer than Δx to it", &|c| c.layer as f64),
        ],
    )
}

const WIDTH: u32 = 860;
const TITLE: u32 = 34;

/// One layer of each flow with its surface, and both surfaces.
fn picture(path: &Path, runs: &[FlowRun; 2], time: f64) -> anyhow::Result<()> {
    let [exact, wang] = runs;
    let frames = [exact.frame(time)?, wang.frame(time)?];
    let mut lines: Vec<Vec<Segment>> = Vec::new();
    for frame in &frames {
        lines.push(MiddleSlice::new(&frame.solver, 0.25)?.line());
    }
    let (low, high) = (frames[0].solver.flow().boundaries.low, frames[0].solver.flow().boundaries.high);
    let top = lines.iter().flatten().flatten().map(|p| p[1]).fold(0.0, f64::max) + 0.02;
    let scale = f64::from(WIDTH) / (high[0] - low[0]);
    let height = (scale * top).ceil() as u32;
    let place = |x: f64, z: f64| ((scale * (x - low[0])) as i32, (TITLE + height) as i32 - 1 - (scale * z) as i32);
    save(path, (WIDTH, 3 * (height + TITLE)), |root| {
        let failed = |e: &dyn std::fmt::Display| anyhow!("cannot draw: {e}");
        let style = ("sans-serif", 22).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Top));
        let panels = root.split_evenly((3, 1));
        for k in 0..2 {
            let solver = &frames[k].solver;
            let view = View::middle_layer(solver, [low[0], high[0]]);
            let title = format!("{time} s, shifting by the {} detection: one layer and its surface", NAMES[k]);
            panels[k].draw_text(&title, &style, (8, 6)).map_err(|e| failed(&e))?;
            let radius = ((0.4 * scale * solver.flow().fluid.spacing).round() as i32).max(1);
            for p in solver.state().x.iter().filter(|p| view.sees(**p)) {
                let dot = Circle::new(place(p[0], p[2]), radius, RGBColor(150, 185, 225).filled());
                panels[k].draw(&dot).map_err(|e| failed(&e))?;
            }
        }
        panels[2].draw_text(&format!("{time} s: black exact, red Wang"), &style, (8, 6)).map_err(|e| failed(&e))?;
        for (k, line) in lines.iter().enumerate() {
            for [from, to] in line {
                let piece = PathElement::new([place(from[0], from[1]), place(to[0], to[1])], LINES[k]);
                panels[k].draw(&piece).map_err(|e| failed(&e))?;
                panels[2].draw(&piece).map_err(|e| failed(&e))?;
            }
        }
        Ok(())
    })
}
