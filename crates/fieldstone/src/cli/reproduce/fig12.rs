//! Fig. 12: mean time per sphere over the radius, for six meshes.

use anyhow::Result;
use fieldstone::geometry::{decomposition, fast_overlap_volume, overlap_volume};
use fieldstone::io::AtomicFile;
use plotters::chart::SeriesLabelPosition;

use super::clock::thread_seconds;
use super::meshes::{Element, Lattice, Split};
use super::misses::Way;
use super::plots::{Axis, COLOURS, Curve, Plot, draw};
use super::samples::{Trial, trials};
use super::{Settings, progress};

/// Radii, the range of the paper.
const RADII: [f64; 10] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

/// Spheres per radius: ten times those of the error's smallest radii, which makes the paper's 10,000 by default.
fn samples(settings: &Settings) -> u32 {
    settings.schedule.at(0.1).saturating_mul(10).min(100_000)
}

pub(super) fn run(settings: &Settings) -> Result<String> {
    let bar = progress((Split::ALL.len() * RADII.len()) as u64, "Fig. 12")?;
    let mut times = Vec::new();
    for split in Split::ALL {
        let elements = mesh_of_27_cells(split)?;
        for (index, &radius) in RADII.iter().enumerate() {
            let spheres = trials(index, radius, samples(settings))?;
            times.push((split, radius, Way::ALL.map(|way| seconds_per_sphere(&spheres, &elements, way))));
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    AtomicFile::write(&settings.folder.join("fig12.csv"), |out| {
        writeln!(out, "mesh,radius,method,samples,microseconds_per_sphere")?;
        for (split, radius, seconds) in &times {
            for (way, seconds) in Way::ALL.iter().zip(seconds) {
                let (split, way, samples) = (split.name(), way.name(), samples(settings));
                writeln!(out, "{split},{radius},{way},{samples},{:.4}", 1e6 * seconds)?;
            }
        }
        Ok(())
    })?;
    let top = times.iter().flat_map(|t| t.2).fold(0.0, f64::max) * 1e6;
    let y = Axis { name: "time per sphere / µs", range: [0.0, 1.05 * top], logarithmic: false };
    let x = Axis { name: "radius / side of a cell", range: [0.0, 1.0], logarithmic: false };
    let plots: Vec<Plot> = [Way::Promised, Way::Decomposition]
        .into_iter()
        .map(|way| Plot {
            title: way.name().into(),
            x,
            y,
            curves: Split::ALL
                .iter()
                .zip(COLOURS)
                .map(|(&split, colour)| Curve {
                    name: split.name().into(),
                    points: times.iter().filter(|t| t.0 == split).map(|t| (t.1, 1e6 * t.2[way as usize])).collect(),
                    colour,
                    dashed: false,
                })
                .collect(),
            legend: Some(SeriesLabelPosition::UpperLeft),
        })
        .collect();
    draw(&settings.folder.join("fig12.png"), &plots)?;

    let mut text = format!(
        "## Time per sphere (Fig. 12)\n\n![Time per sphere over the radius](fig12.png)\n\nOne sphere with all elements of \
         the mesh of 27 cells, mean over {} spheres, processor time of one thread, elements built beforehand; each \
         element is a call of its own. In microseconds:\n\n| mesh | r | kernel with promise | kernel in f64 | \
         decomposition |\n|---|---|---|---|---|\n",
        samples(settings)
    );
    for (split, radius, seconds) in times.iter().filter(|t| [0.1, 0.3, 0.6, 1.0].contains(&t.1)) {
        let [fast, promised, other] = seconds.map(|s| 1e6 * s);
        text.push_str(&format!("| {} | {radius} | {promised:.2} | {fast:.2} | {other:.2} |\n", split.name()));
    }
    Ok(text)
}

/// All elements of the smallest mesh; it holds every sphere up to radius 1.
pub(super) fn mesh_of_27_cells(split: Split) -> Result<Vec<Element>> {
    let lattice = Lattice::new(split, 0.0);
    let (mut all, mut elements) = (Vec::new(), Vec::new());
    for cell in lattice.cells_covering(1.5) {
        lattice.elements(cell, &mut elements)?;
        all.append(&mut elements);
    }
    Ok(all)
}

/// Mean over the spheres; the smaller one of two runs, the first of which warms the caches.
pub(super) fn seconds_per_sphere(spheres: &[Trial], elements: &[Element], way: Way) -> f64 {
    let once = || {
        let start = thread_seconds();
        let mut total = 0.0;
        for Trial { ball, .. } in spheres {
            total += match way {
                Way::Fast => elements.iter().map(|e| fast_overlap_volume(ball, &e.polyhedron).0).sum::<f64>(),
                Way::Promised => elements.iter().map(|e| overlap_volume(ball, &e.polyhedron)).sum(),
                Way::Decomposition => elements.iter().map(|e| decomposition::overlap_volume(ball, &e.decomposed)).sum(),
            };
        }
        std::hint::black_box(total);
        (thread_seconds() - start) / spheres.len() as f64
    };
    once().min(once())
}
