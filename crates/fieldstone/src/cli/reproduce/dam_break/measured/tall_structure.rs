//! Force of a dam break on a tall structure, and speed before it: Yeh and Petroff.

use std::fmt::Write as _;
use std::path::Path;

use fieldstone::particles::Particles;
use fieldstone::sph::FluidOptions;
use plotters::chart::SeriesLabelPosition;

use super::super::flow_run::FlowRun;
use super::data::{Curved, arrival, gauge, mean, pairs, relative_rms};
use super::{clipped, computed, measured, percent};
use crate::cli::reproduce::plots::{Axis, COLOURS, Plot, draw};

/// The probe: 146 mm before the structure's centre, 26 mm above the floor, in the plane of symmetry.
const PROBE: [f64; 3] = [0.814, 0.0, 0.026];
/// Force that tells the arrival, newtons.
const ARRIVED: f64 = 10.0;

pub(super) fn section(flow: &FlowRun, folder: &Path, data: &Path) -> anyhow::Result<String> {
    let fluid = flow.case.flow()?.fluid;
    // Half of the flow is computed.
    let force: Curved = gauge(flow, "force_x")?.into_iter().map(|(t, f)| (t, 2.0 * f)).collect();
    let mut speed: Curved = Vec::new();
    for (time, particles) in flow.series()? {
        if let Some(u) = speed_at(&particles, &fluid, PROBE)? {
            speed.push((time, u));
        }
    }
    // The probe's record begins when the water reaches it: 0 is the arrival in the experiment, and here, too.
    let start = speed.first().map_or(f64::NAN, |p| p.0);
    let speed: Curved = speed.into_iter().map(|(t, u)| (t - start, u)).collect();
    let (forces, speeds) = (
        pairs(&data.join("pysph_yeh_and_petroff_force_data.txt"))?,
        pairs(&data.join("pysph_yeh_and_petroff_v_data.txt"))?,
    );
    let spacing = flow.case.sections.spacing;
    let mut text = format!(
        "## A tall structure\n\n![Force and speed](tall_structure.png)\n\nYeh and Petroff's dam break on a wet bed of 10 mm, \
         one half of the flow, Δx = {spacing} m. The speed's time counts from the arrival at the probe, as its measurement \
         does:\n\n| | computed | measured | error |\n|---|---|---|---|\n"
    );
    let mut row = |name: &str, unit: &str, ours: Option<f64>, theirs: Option<f64>| {
        let (a, b) = (ours.unwrap_or(f64::NAN), theirs.unwrap_or(f64::NAN));
        let _ = writeln!(text, "| {name} | {a:.3} {unit} | {b:.3} {unit} | {} |", percent(a / b - 1.0));
    };
    row("force, arrival (10 N)", "s", arrival(&force, ARRIVED), arrival(&forces, ARRIVED));
    let largest = |curve: &Curved| Some(curve.iter().map(|p| p.1).fold(0.0, f64::max));
    row("force, largest", "N", largest(&force), largest(&forces));
    row("force, mean from 0.35 to 0.5 s", "N", mean(&force, 0.35, 0.5), mean(&forces, 0.35, 0.5));
    row("force, mean from 0.5 to 0.9 s", "N", mean(&force, 0.5, 0.9), mean(&forces, 0.5, 0.9));
    row("speed, mean from 0.05 to 0.5 s", "m/s", mean(&speed, 0.05, 0.5), mean(&speeds, 0.05, 0.5));
    let early: Curved = speeds.iter().copied().filter(|p| p.0 <= 0.5).collect();
    let rms = relative_rms(&speed, &early).unwrap_or(f64::NAN);
    let _ = writeln!(text, "\nSpeed up to 0.5 s after the arrival: root mean square error {:.1} %.", 100.0 * rms);
    let plots = [
        Plot {
            title: "Force on the structure".into(),
            x: Axis { name: "time, s", range: [0.0, 1.0], logarithmic: false },
            y: Axis { name: "N", range: [-5.0, 50.0], logarithmic: false },
            curves: vec![computed("computed", &force), measured("Yeh and Petroff", &forces, COLOURS[1])],
            legend: Some(SeriesLabelPosition::UpperLeft),
        },
        Plot {
            title: "Speed before it".into(),
            x: Axis { name: "time since the arrival, s", range: [0.0, 0.8], logarithmic: false },
            y: Axis { name: "m/s", range: [0.0, 3.0], logarithmic: false },
            curves: vec![computed("computed", &speed), measured("Yeh and Petroff", &speeds, COLOURS[1])],
            legend: Some(SeriesLabelPosition::UpperRight),
        },
    ];
    draw(&folder.join("tall_structure.png"), &plots.map(clipped))?;
    Ok(text + "\n")
}

/// Mean velocity along x, weighted by the kernel; `None` where the kernel's volume is less than a fifth full.
fn speed_at(particles: &Particles, fluid: &FluidOptions, at: [f64; 3]) -> anyhow::Result<Option<f64>> {
    let (velocity, density) = (particles.quantity("velocity")?, particles.quantity("density")?);
    let kernel = fluid.kernel();
    let (mut sum, mut weight) = (0.0, 0.0);
    for ((x, u), density) in particles.positions().iter().zip(velocity.data.chunks_exact(3)).zip(&density.data) {
        // What is mirrored in the plane of symmetry moves alike.
        for mirrored in [x[1], -x[1]] {
            let squared = (x[0] - at[0]).powi(2) + (mirrored - at[1]).powi(2) + (x[2] - at[2]).powi(2);
            if squared < kernel.reach() * kernel.reach() {
                let w = kernel.value_at_square(squared) * fluid.particle_mass() / density;
                sum += w * u[0];
                weight += w;
            }
        }
    }
    Ok((weight > 0.2).then(|| sum / weight))
}
