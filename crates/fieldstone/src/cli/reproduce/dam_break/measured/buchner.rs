//! Pressure of a dam break on a wall: Buchner (2002).

use std::fmt::Write as _;
use std::path::Path;

use plotters::chart::SeriesLabelPosition;

use super::super::flow_run::FlowRun;
use super::data::{Curved, arrival, gauge, mean, pairs};
use super::{clipped, computed, measured, percent};
use crate::cli::reproduce::plots::{Axis, COLOURS, Curve, Plot, draw};

/// √(g/H) and ρgH of the case.
const TIME: f64 = 4.043_513_323_831_146;
const PRESSURE: f64 = 5886.0;
/// H, metres.
const HEIGHT: f64 = 0.6;
/// Where the strips' middles lie on the disc, over its radius.
const STRIPS: [f64; 6] = [-5.0 / 6.0, -0.5, -1.0 / 6.0, 1.0 / 6.0, 0.5, 5.0 / 6.0];
/// p/ρgH that tells the arrival, and a later point of the rise.
const ARRIVED: f64 = 0.05;
const RISEN: f64 = 0.2;
/// Time t √(g/H) up to which the measured pressure is noise, of up to 0.16 ρgH.
const NOISE: f64 = 2.0;
/// Times t √(g/H) of the first plateau, after the impact and before the water falls back.
const PLATEAU: [f64; 2] = [3.0, 5.0];

pub(super) fn section(flow: &FlowRun, folder: &Path, data: &Path) -> anyhow::Result<String> {
    let mut gauges = Vec::new();
    for k in 1..=STRIPS.len() {
        gauges.push(gauge(flow, &format!("p{k}"))?);
    }
    let chords = STRIPS.map(|s| (1.0 - s * s).sqrt());
    let whole: f64 = chords.iter().sum();
    let pressure: Curved = (0..gauges[0].len())
        .map(|row| {
            let sum: f64 = gauges.iter().zip(chords).map(|(gauge, chord)| chord * gauge[row].1).sum();
            (gauges[0][row].0 * TIME, sum / whole / PRESSURE)
        })
        .collect();
    // Where other computations in two dimensions take it, at the disc's lower edge.
    let low: Curved = gauges[0].iter().map(|&(t, p)| (t * TIME, p / PRESSURE)).collect();
    let experiment = pairs(&data.join("buchner2002_pressure.txt"))?;
    let after_noise: Curved = experiment.iter().copied().filter(|p| p.0 > NOISE).collect();
    let resolution = HEIGHT / flow.case.sections.spacing;
    let mut text = format!(
        "## Pressure on a wall\n\n![Pressure](buchner.png)\n\nBuchner's dam break, H/Δx = {resolution:.0}, in two dimensions. The gauge \
         was a disc 90 mm wide with its centre 160 mm above the floor; \"lower edge\" is a point 122.5 mm (0.2 H) above it, \
         where other computations in two dimensions read the pressure. Times are t √(g/H), pressures p/ρgH; the first \
         plateau is the mean from 3 to 5:\n\n| | computed | measured | error |\n|---|---|---|---|\n",
    );
    for (name, curve) in [("lower edge", &low), ("disc", &pressure)] {
        let values = [
            ("arrival (0.05)", arrival(curve, ARRIVED), arrival(&after_noise, ARRIVED)),
            ("rise to 0.2", arrival(curve, RISEN), arrival(&after_noise, RISEN)),
            ("first plateau", mean(curve, PLATEAU[0], PLATEAU[1]), mean(&experiment, PLATEAU[0], PLATEAU[1])),
        ];
        for (what, ours, theirs) in values {
            let (a, b) = (ours.unwrap_or(f64::NAN), theirs.unwrap_or(f64::NAN));
            let _ = writeln!(text, "| {name}, {what} | {a:.3} | {b:.3} | {} |", percent(a / b - 1.0));
        }
    }
    let plot = Plot {
        title: "Pressure 160 mm above the floor".into(),
        x: Axis { name: "t √(g/H)", range: [2.0, 7.4], logarithmic: false },
        y: Axis { name: "p/ρgH", range: [-0.2, 1.4], logarithmic: false },
        curves: vec![
            computed("computed, lower edge", &low),
            Curve { colour: COLOURS[2], ..computed("computed, disc", &pressure) },
            measured("Buchner", &experiment, COLOURS[1]),
        ],
        legend: Some(SeriesLabelPosition::UpperLeft),
    };
    draw(&folder.join("buchner.png"), &[clipped(plot)])?;
    Ok(text + "\n")
}
