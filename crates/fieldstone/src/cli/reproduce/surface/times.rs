//! Fig. 13: time of a detection over the number of particles.

use std::path::Path;

use anyhow::{Result, anyhow};
use fieldstone::io::AtomicFile;
use fieldstone::surface::{Detection, Method, ScanningCone, SurfaceDetection, Surroundings};
use plotters::chart::SeriesLabelPosition;

use super::super::clock;
use super::super::plots::{Axis, COLOURS, Curve, Plot, draw};
use super::super::progress;
use crate::cli::reproduce::random::SplitMix;

const METHODS: [Method; 6] =
    [Method::Exact, Method::Wang, Method::Marrone, Method::SemiGeometrical, Method::Geometrical, Method::Haque];
/// Disorder of the particles, over the spacing: the paper times a lattice.
const NOISES: [f64; 2] = [0.0, 0.3];
/// Seconds for 10⁶ particles, from the paper's text, on an Intel Core i5-3470.
const PAPER: [(&str, f64); 4] = [("Haque", 139.79), ("Marrone", 4.04), ("Wang", 0.65), ("semi-geometrical", 3.34)];

pub(super) fn run(folder: &Path, full: bool) -> Result<String> {
    let sides: &[usize] = if full { &[22, 32, 46, 68, 100] } else { &[22, 32, 46] };
    // The slow ones take minutes for a million particles, and are as long each time.
    let repeats = |method: Method, particles: usize| match (full, is_slow(method)) {
        (true, true) if particles > 20_000 => 1,
        (true, _) => 10,
        (false, true) if particles > 40_000 => 0,
        (false, true) => 1,
        (false, false) => 3,
    };
    let bar = progress((NOISES.len() * sides.len() * METHODS.len()) as u64, "Fig. 13")?;
    let mut table = String::from("noise,particles,method,detections,mean_seconds,microseconds_per_particle\n");
    let mut curves = vec![vec![Vec::new(); METHODS.len()]; NOISES.len()];
    let mut text = format!(
        "## Time over the number of particles (Fig. 13)\n\n![Times](fig13.png)\n\nProcessor time of one thread, neighbour \
         search included, the mean of {} (slow methods: {}). Microseconds per particle:\n\n| particles | disorder |",
        if full { "ten detections" } else { "three detections" },
        if full { "one beyond 20,000 particles" } else { "one, up to 40,000 particles" }
    );
    METHODS.iter().for_each(|method| text += &format!(" {method} |"));
    text += &format!("\n|---|---|{}\n", "---|".repeat(METHODS.len()));
    for (n, noise) in NOISES.iter().enumerate() {
        for &side in sides {
            let positions = block(side, *noise);
            text += &format!("| {} | {noise} Δx |", positions.len());
            for (m, method) in METHODS.iter().enumerate() {
                let count = repeats(*method, positions.len());
                let detection = method.with_cone(ScanningCone::default())?;
                let mut total = 0.0;
                for _ in 0..count {
                    total += seconds_of(detection.as_ref(), &positions, &Surroundings::new(1.0))?.0;
                }
                bar.inc(1);
                if count == 0 {
                    text += " - |";
                    continue;
                }
                let mean = total / f64::from(count);
                let micro = 1e6 * mean / positions.len() as f64;
                text += &format!(" {micro:.2} |");
                table += &format!("{noise},{},{method},{count},{mean:.6},{micro:.4}\n", positions.len());
                curves[n][m].push((positions.len() as f64, mean.max(1e-6)));
            }
            text.push('\n');
        }
    }
    bar.finish_and_clear();
    AtomicFile::write(&folder.join("fig13.csv"), |out| out.write_all(table.as_bytes()))?;
    draw(&folder.join("fig13.png"), &plots(&curves, sides))?;
    text += "\nThe paper's times for 10⁶ particles on its machine (Intel Core i5-3470), which compare roughly: ";
    text += &PAPER.map(|(name, seconds)| format!("{name} {seconds} s")).join(", ");
    text += ".\n";
    Ok(text)
}

fn is_slow(method: Method) -> bool {
    matches!(method, Method::Geometrical | Method::Haque | Method::SemiGeometrical)
}

fn plots(curves: &[Vec<Vec<(f64, f64)>>], sides: &[usize]) -> Vec<Plot> {
    let (first, last) = (sides[0].pow(3) as f64, sides[sides.len() - 1].pow(3) as f64);
    let all = || curves.iter().flatten().flatten().map(|p| p.1);
    let range = [0.5 * all().fold(f64::INFINITY, f64::min), 2.0 * all().fold(0.0, f64::max)];
    let one = |(noise, curves): (&f64, &Vec<Vec<(f64, f64)>>)| Plot {
        title: if *noise == 0.0 { "Lattice".into() } else { format!("Moved by up to {noise} Δx") },
        x: Axis { name: "particles", range: [0.9 * first, 1.1 * last], logarithmic: true },
        y: Axis { name: "seconds", range, logarithmic: true },
        curves: METHODS
            .iter()
            .zip(curves)
            .zip(COLOURS)
            .map(|((method, points), colour)| Curve {
                name: method.to_string(),
                points: points.clone(),
                colour,
                dashed: false,
            })
            .collect(),
        legend: Some(SeriesLabelPosition::LowerRight),
    };
    NOISES.iter().zip(curves).map(one).collect()
}

/// A cube of a unit lattice, each coordinate moved at random by up to `noise`; the same in every run.
pub(super) fn block(side: usize, noise: f64) -> Vec<[f64; 3]> {
    let mut random = SplitMix::new(1);
    let mut positions = Vec::with_capacity(side.pow(3));
    for i in 0..side.pow(3) {
        let lattice = [i % side, i / side % side, i / (side * side)];
        positions.push(lattice.map(|k| k as f64 + noise * (2.0 * random.uniform() - 1.0)));
    }
    positions
}

/// Processor time of one detection on one thread, neighbour search included, and its labels.
pub(super) fn seconds_of(
    method: &dyn SurfaceDetection,
    positions: &[[f64; 3]],
    surroundings: &Surroundings,
) -> Result<(f64, Detection)> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        let start = clock::thread_seconds();
        let named = |e| anyhow!("{}: {e}", method.name());
        let grid = surroundings.grid(positions, method.reach(surroundings.spacing)).map_err(named)?;
        let detection = method.detect(&surroundings.scene(&grid)).map_err(named)?;
        Ok((clock::thread_seconds() - start, detection))
    })
}
