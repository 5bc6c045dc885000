//! Joins the parts of a decomposed case's cloud.

use std::path::{Path, PathBuf};

use fieldstone_particles::{Particles, Quantity};

use crate::{IoError, Position};

use super::lagrangian::read_cloud;
use super::locate::processors;

/// The parts of the cloud that `path` names: `CASE/TIME/lagrangian/CLOUD`, or a folder above it, which is only in the
/// `processorN` folders of the case, or the same with `processor*` after the case. In the order of N; empty where there are none.
pub(crate) fn parts_of_cloud(path: &Path) -> Vec<PathBuf> {
    if path.exists() {
        return Vec::new();
    }
    for case in path.ancestors().skip(1) {
        let below = path.strip_prefix(case).unwrap_or(path);
        let below = below.strip_prefix("processor*").unwrap_or(below);
        let case = if case.as_os_str().is_empty() { Path::new(".") } else { case };
        let parts = processors(case).into_iter().map(|(_, folder)| folder.join(below));
        // A processor without particles may have no cloud.
        let parts: Vec<PathBuf> = parts.filter(|part| may_hold_a_cloud(part)).collect();
        if !parts.is_empty() {
            return parts;
        }
    }
    Vec::new()
}

fn may_hold_a_cloud(folder: &Path) -> bool {
    let is_lagrangian = |path: &Path| path.file_name().is_some_and(|name| name == "lagrangian");
    folder.is_dir() && (folder.ancestors().any(is_lagrangian) || folder.join("lagrangian").is_dir())
}

/// Reads the parts of a cloud as one: the particles of the first part, then those of the second, and so on.
pub(crate) fn read_parts(parts: &[PathBuf]) -> Result<Particles, IoError> {
    let mut whole: Option<Particles> = None;
    for part in parts {
        let particles = read_cloud(part)?;
        whole = Some(match whole {
            // Of a part without particles columns may be missing.
            Some(before) if particles.is_empty() => before,
            Some(before) if !before.is_empty() => joined(&before, &particles, part)?,
            _ => particles,
        });
    }
    whole.ok_or_else(|| {
        IoError::content("processor0", Position::File, "no particle cloud was found here", "give the case's cloud")
    })
}

fn joined(before: &Particles, after: &Particles, part: &Path) -> Result<Particles, IoError> {
    let names = |particles: &Particles| -> Vec<String> {
        let radius = particles.radii().is_ok().then(|| "radius".into());
        radius.into_iter().chain(particles.quantities().iter().map(|quantity| quantity.name.clone())).collect()
    };
    let (there, here) = (names(before), names(after));
    if there != here {
        return Err(IoError::content(
            part,
            Position::File,
            format!("this part of the cloud has {}, and those before it {}", here.join(", "), there.join(", ")),
            "the files of a processor may be missing; copy them, or reconstruct the case (reconstructPar)",
        ));
    }
    let wrap = |source| IoError::Particles { path: part.into(), source };
    let mut whole = Particles::new([before.positions(), after.positions()].concat()).map_err(wrap)?;
    if let (Ok(a), Ok(b)) = (before.radii(), after.radii()) {
        whole = whole.with_radii([a, b].concat()).map_err(wrap)?;
    }
    for (a, b) in before.quantities().iter().zip(after.quantities()) {
        let data = [&a.data[..], &b.data[..]].concat();
        whole = whole.with_quantity(Quantity { name: a.name.clone(), components: a.components, data }).map_err(wrap)?;
    }
    Ok(whole.at(None, after.time().or(before.time())).with_source_names_of(before))
}
