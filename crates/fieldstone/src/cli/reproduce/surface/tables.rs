//! Methods beside each other on frames, in the layout of Tables 1 to 3.

use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow};
use fieldstone::io::{AtomicFile, ParticleOptions, read_frame};
use fieldstone::surface::{Comparison, Method, ScanningCone, Surroundings};

use super::times::{block, seconds_of};

const METHODS: [Method; 6] =
    [Method::Haque, Method::Marrone, Method::Wang, Method::SemiGeometrical, Method::Geometrical, Method::Exact];

struct Frame {
    name: String,
    positions: Vec<[f64; 3]>,
    spacing: f64,
}

pub(super) fn run(folder: &Path, files: &[PathBuf], spacings: &[f64]) -> Result<String> {
    let mut frames = Vec::new();
    for (index, file) in files.iter().enumerate() {
        let particles = read_frame(file, &ParticleOptions { allow_non_spherical: true }, -1)?;
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let spacing = spacings[index.min(spacings.len() - 1)];
        frames.push(Frame { name, positions: particles.positions().to_vec(), spacing });
    }
    if frames.is_empty() {
        for noise in [0.0, 0.1, 0.3, 0.5, 0.8] {
            let name = format!("lattice, moved by up to {noise} Δx");
            frames.push(Frame { name, positions: block(20, noise), spacing: 1.0 });
        }
    }
    let mut table = String::from("frame,particles,method,TP,EP,M,misses,false_positives,seconds\n");
    let mut text = String::from(
        "## Methods beside each other (layout of Tables 1 to 3)\n\nTP / EP / M: free-surface particles of the geometrical \
         criterion, misidentified ones (misses + false positives), and accuracy (Eq. 32).\n\n| frame | particles |",
    );
    METHODS.iter().for_each(|method| text += &format!(" {method} |"));
    text += &format!("\n|---|---|{}\n", "---|".repeat(METHODS.len()));
    for Frame { name, positions, spacing } in &frames {
        let surroundings = Surroundings::new(*spacing);
        let placed = |e: anyhow::Error| anyhow!("{name}: {e}");
        let mut found = Vec::new();
        for method in METHODS {
            let method = method.with_cone(ScanningCone::default())?;
            found.push(seconds_of(method.as_ref(), positions, &surroundings).map_err(placed)?);
        }
        let reference = found[METHODS.len() - 1].1.labels();
        text += &format!("| {name} | {} |", positions.len());
        for (method, (seconds, detection)) in METHODS.iter().zip(&found) {
            let c = Comparison::new(&reference, &detection.labels())?;
            let accuracy = c.accuracy().map_or("-".into(), |m| format!("{m:.3}"));
            text += &format!(
                " {} / {} ({} + {}) / {accuracy} |",
                c.reference,
                c.misidentified(),
                c.misses,
                c.false_positives
            );
            table += &format!(
                "\"{name}\",{},{method},{},{},{accuracy},{},{},{seconds:.4}\n",
                positions.len(),
                c.reference,
                c.misidentified(),
                c.misses,
                c.false_positives
            );
        }
        text.push('\n');
    }
    AtomicFile::write(&folder.join("tables.csv"), |out| out.write_all(table.as_bytes()))?;
    text +=
        "\nThe exact method is the reference; the geometrical one, the published algorithm, must have no difference.\n";
    Ok(text)
}
