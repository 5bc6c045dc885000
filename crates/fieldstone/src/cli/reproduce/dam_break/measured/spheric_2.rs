//! A dam break against a low box: SPHERIC test 2, Kleefsman et al. (2005).

use std::fmt::Write as _;
use std::path::Path;

use plotters::chart::SeriesLabelPosition;

use super::super::flow_run::FlowRun;
use super::data::{Curved, arrival, column, gauge, mean, rows};
use super::{clipped, computed, measured, percent};
use crate::cli::reproduce::plots::{Axis, COLOURS, Plot, draw};

/// Pressure that tells the arrival at the box.
const ARRIVED: f64 = 2000.0;
/// The first plateau of the pressure on the box, after the impact.
const PLATEAU: [f64; 2] = [0.6, 1.1];
/// Water level that tells the arrival at a height gauge.
const WET: f64 = 0.03;

pub(super) fn section(flow: &FlowRun, slice: &FlowRun, folder: &Path, data: &Path) -> anyhow::Result<String> {
    let experiment = rows(&data.join("spheric_test2_kleefsman.dat.gz"), 13)?;
    // Columns: time, P1 to P8, H1 to H4.
    let pair = |name: &str, index: usize| -> anyhow::Result<(Curved, Curved)> {
        Ok((gauge(flow, name)?, column(&experiment, index)))
    };
    let (p1, p3) = (pair("P1", 1)?, pair("P3", 3)?);
    let (h1, h2, h4) = (pair("H1", 9)?, pair("H2", 10)?, pair("H4", 12)?);
    let thin = [("P1", &p1.1, ARRIVED), ("P3", &p3.1, ARRIVED), ("H1", &h1.1, WET), ("H2", &h2.1, WET)];
    let spacing = |flow: &FlowRun| flow.case.sections.spacing;
    let mut text = format!(
        "## A low box\n\n![Pressures and levels](spheric_2.png)\n\nSPHERIC test 2, one half of the flow, Δx = {} m. P1 \
         and P3 are 21 and 101 mm above the floor on the side that the wave hits, H4 stands in the column, H1 and H2 0.504 \
         and 1 m before it. Until it meets the box the flow is the same across the tank: \"slice\" is two-dimensional, Δx = {} m, \
         and can have a tongue as thin as measured:\n\n| | computed | measured | error |\n|---|---|---|---|\n",
        spacing(flow),
        spacing(slice),
    );
    let mut row = |name: &str, unit: &str, ours: Option<f64>, theirs: Option<f64>| {
        let (a, b) = (ours.unwrap_or(f64::NAN), theirs.unwrap_or(f64::NAN));
        let _ = writeln!(text, "| {name} | {a:.4} {unit} | {b:.4} {unit} | {} |", percent(a / b - 1.0));
    };
    for (name, theirs, level) in thin {
        let what = if level == WET { "30 mm" } else { "2 kPa" };
        row(
            &format!("{name}, arrival ({what}), slice"),
            "s",
            arrival(&gauge(slice, name)?, level),
            arrival(theirs, level),
        );
    }
    for (name, (ours, theirs)) in [("P1", &p1), ("P3", &p3)] {
        row(&format!("{name}, arrival (2 kPa)"), "s", arrival(ours, ARRIVED), arrival(theirs, ARRIVED));
        let kilo = |curve: &Curved| mean(curve, PLATEAU[0], PLATEAU[1]).map(|p| 1e-3 * p);
        row(&format!("{name}, mean from 0.6 to 1.1 s"), "kPa", kilo(ours), kilo(theirs));
    }
    for (name, (ours, theirs)) in [("H1", &h1), ("H2", &h2)] {
        row(&format!("{name}, arrival (30 mm)"), "s", arrival(ours, WET), arrival(theirs, WET));
    }
    row("H4, mean from 0 to 1.1 s", "m", mean(&h4.0, 0.0, 1.1), mean(&h4.1, 0.0, 1.1));
    let axis = |name: &'static str, high: f64| Axis { name, range: [0.0, high], logarithmic: false };
    let plot = |title: &str, y: Axis, shown: &[(&str, &(Curved, Curved))]| Plot {
        title: title.into(),
        x: axis("time, s", 1.2),
        y,
        curves: (shown.iter().enumerate())
            .flat_map(|(k, (name, (ours, theirs)))| {
                let mut line = computed(&format!("{name} computed"), ours);
                line.colour = COLOURS[k];
                [line, measured(&format!("{name} measured"), theirs, COLOURS[k])]
            })
            .collect(),
        legend: Some(SeriesLabelPosition::UpperRight),
    };
    let plots = [
        plot("Pressure on the box", axis("Pa", 14_000.0), &[("P1", &p1), ("P3", &p3)]),
        plot("Water level", axis("m", 0.6), &[("H1", &h1), ("H2", &h2), ("H4", &h4)]),
    ];
    draw(&folder.join("spheric_2.png"), &plots.map(clipped))?;
    Ok(text + "\n")
}
