//! The figure of Sec. 5.2: 45,000 particles at a ratio of side to diameter of 1/0.6.

use anyhow::Result;
use fieldstone::io::AtomicFile;

use super::fig12::{Timed, mesh_of_27_cells, seconds_per_sphere};
use super::meshes::Split;
use super::samples::trials;
use super::{Settings, progress};

const PARTICLES: u32 = 45_000;
/// Side over diameter 1/0.6.
const RADIUS: f64 = 0.3;
/// The paper's numbers, for hexahedra on an Intel Core i7-4771: microseconds per sphere, and seconds for all.
const PAPER_MICROSECONDS: f64 = 5.8;
const PAPER_SECONDS: f64 = 0.3;

pub(super) fn run(settings: &Settings) -> Result<String> {
    let spheres = trials(0, RADIUS, PARTICLES)?;
    let bar = progress(Split::ALL.len() as u64, "Sec. 5.2")?;
    let mut times = Vec::new();
    for split in Split::ALL {
        let elements = mesh_of_27_cells(split)?;
        times.push((split, Timed::ALL.map(|way| seconds_per_sphere(&spheres, &elements, way, 2))));
        bar.inc(1);
    }
    bar.finish_and_clear();
    AtomicFile::write(&settings.folder.join("sec52.csv"), |out| {
        writeln!(out, "mesh,method,particles,microseconds_per_sphere,seconds")?;
        for (split, seconds) in &times {
            for (way, seconds) in Timed::ALL.iter().zip(seconds) {
                let (split, way, all) = (split.name(), way.name(), seconds * f64::from(PARTICLES));
                writeln!(out, "{split},{way},{PARTICLES},{:.4},{all:.4}", 1e6 * seconds)?;
            }
        }
        Ok(())
    })?;
    let mut text = format!(
        "## 45,000 particles (Sec. 5.2)\n\nRatio of side to diameter 1/0.6, one thread, each sphere with all elements of \
         its mesh; the paper's machine is an Intel Core i7-4771, so its times and these compare roughly.\n\n\
         | mesh | method | µs per sphere | s for {PARTICLES} |\n|---|---|---|---|\n\
         | hexahedra | paper | {PAPER_MICROSECONDS} | < {PAPER_SECONDS} |\n"
    );
    for (split, seconds) in &times {
        for way in Timed::ALL {
            let time = seconds[way as usize];
            let all = time * f64::from(PARTICLES);
            text.push_str(&format!("| {} | {} | {:.2} | {all:.3} |\n", split.name(), way.name(), 1e6 * time));
        }
    }
    let relation = |x: f64| if x < PAPER_MICROSECONDS { "below" } else { "above" };
    let [kernel, other] = times[0].1.map(|s| 1e6 * s);
    text.push_str(&format!(
        "\nWith hexahedra, the kernel takes {kernel:.2} µs per sphere ({} the paper's {PAPER_MICROSECONDS}), the decomposition \
         {other:.2} µs ({}).\n",
        relation(kernel),
        relation(other)
    ));
    Ok(text)
}
