//! Fig. 12: mean time per sphere over the radius, for six meshes.

use anyhow::Result;
use fieldstone::geometry::decomposition::{self, DecompositionElement};
use fieldstone::geometry::{Polyhedron, overlap_volume};
use fieldstone::io::AtomicFile;
use plotters::chart::SeriesLabelPosition;

use super::clock::thread_seconds;
use super::meshes::{Lattice, Split};
use super::plots::{Axis, COLOURS, Curve, Plot, draw};
use super::samples::{Trial, trials};
use super::{Settings, progress};

/// Radii, the range of the paper.
const RADII: [f64; 10] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

/// What is timed, one call per element: a single sphere has no batch to be evaluated in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Timed {
    /// The kernel.
    Kernel,
    /// Caps, wedges and cones.
    Decomposition,
}

impl Timed {
    pub const ALL: [Self; 2] = [Self::Kernel, Self::Decomposition];

    pub fn name(self) -> &'static str {
        match self {
            Self::Kernel => "kernel",
            Self::Decomposition => "decomposition",
        }
    }
}

/// The elements of a mesh, each kind in a list of its own: what one way does not need must not fill its caches.
pub(super) struct Elements {
    polyhedra: Vec<Polyhedron>,
    decomposed: Vec<DecompositionElement>,
}

/// Spheres per radius: the paper's 10,000 for `--full`.
fn samples(settings: &Settings) -> u32 {
    settings.schedule.at(0.1).min(10_000)
}

pub(super) fn run(settings: &Settings) -> Result<String> {
    let bar = progress((Split::ALL.len() * RADII.len()) as u64, "Fig. 12")?;
    let mut times = Vec::new();
    for split in Split::ALL {
        let elements = mesh_of_27_cells(split)?;
        for (index, &radius) in RADII.iter().enumerate() {
            let spheres = trials(index, radius, samples(settings))?;
            times.push((split, radius, Timed::ALL.map(|way| seconds_per_sphere(&spheres, &elements, way, 3))));
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    AtomicFile::write(&settings.folder.join("fig12.csv"), |out| {
        writeln!(out, "mesh,radius,method,samples,microseconds_per_sphere")?;
        for (split, radius, seconds) in &times {
            for (way, seconds) in Timed::ALL.iter().zip(seconds) {
                let (split, way, samples) = (split.name(), way.name(), samples(settings));
                writeln!(out, "{split},{radius},{way},{samples},{:.4}", 1e6 * seconds)?;
            }
        }
        Ok(())
    })?;
    let top = times.iter().flat_map(|t| t.2).fold(0.0, f64::max) * 1e6;
    let y = Axis { name: "time per sphere / µs", range: [0.0, 1.05 * top], logarithmic: false };
    let x = Axis { name: "radius / side of a cell", range: [0.0, 1.0], logarithmic: false };
    let plots: Vec<Plot> = Timed::ALL
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

    let columns = Timed::ALL.map(Timed::name).join(" | ");
    let mut text = format!(
        "## Time per sphere (Fig. 12)\n\n![Time per sphere over the radius](fig12.png)\n\nOne sphere with all elements of \
         the mesh of 27 cells, a call for each; mean over {} spheres (paper: 10,000), best of three runs; processor time of one thread, \
         elements built beforehand. In microseconds:\n\n| mesh | r | {columns} |\n|---|---|---|---|\n",
        samples(settings)
    );
    for (split, radius, seconds) in times.iter().filter(|t| [0.1, 0.3, 0.6, 1.0].contains(&t.1)) {
        let [kernel, other] = seconds.map(|s| 1e6 * s);
        text.push_str(&format!("| {} | {radius} | {kernel:.2} | {other:.2} |\n", split.name()));
    }
    Ok(text)
}

/// All elements of the smallest mesh; it holds every sphere up to radius 1.
pub(super) fn mesh_of_27_cells(split: Split) -> Result<Elements> {
    let lattice = Lattice::new(split, 0.0);
    let mut all = Elements { polyhedra: Vec::new(), decomposed: Vec::new() };
    let mut elements = Vec::new();
    for cell in lattice.cells_covering(1.5) {
        lattice.elements(cell, &mut elements)?;
        for element in elements.drain(..) {
            all.polyhedra.push(element.polyhedron);
            all.decomposed.push(element.decomposed);
        }
    }
    Ok(all)
}

/// Mean over the spheres, best of `runs`: what else the machine does only ever adds to a time.
pub(super) fn seconds_per_sphere(spheres: &[Trial], elements: &Elements, way: Timed, runs: u32) -> f64 {
    let Elements { polyhedra, decomposed } = elements;
    let once = || {
        let start = thread_seconds();
        let mut total = 0.0;
        for Trial { ball, .. } in spheres {
            total += match way {
                Timed::Kernel => polyhedra.iter().map(|e| overlap_volume(ball, e)).sum::<f64>(),
                Timed::Decomposition => decomposed.iter().map(|e| decomposition::overlap_volume(ball, e)).sum(),
            };
        }
        std::hint::black_box(total);
        (thread_seconds() - start) / spheres.len() as f64
    };
    (0..runs).map(|_| once()).fold(f64::INFINITY, f64::min)
}
