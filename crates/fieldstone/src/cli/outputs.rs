//! Where results may go, looked at before any work is done.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use fieldstone::io::{AtomicFile, openfoam};
use fieldstone::mesh::{Cells, Mesh};
use serde::Serialize;

use super::report;

/// Checks that a file can be written as `path`, which the user gave as `option`, and is none of the run's other files.
pub(crate) fn check(option: &str, path: &Path, others: &[&Path]) -> anyhow::Result<()> {
    let shown = path.display();
    if is_standard(path) {
        bail!(
            "{option} -: this would be a file of that name; give one (./- for this), or /dev/stdout for standard output"
        );
    }
    // Commands that number their results ask with a number in its place.
    if path.file_name().is_some_and(|name| name.to_string_lossy().contains("{}")) {
        bail!("{option} {shown}: this is one file, and {{}} in its name would stay as it is; leave it out");
    }
    check_folder(option, path)?;
    if path.is_dir() {
        bail!("{option} {shown}: this is a folder; give the name of a file");
    }
    if others.iter().any(|other| is_same(path, other)) {
        bail!("{option} {shown}: this would overwrite another file of this run; choose another name");
    }
    Ok(())
}

/// Whether a name stands for standard output.
fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Checks that a summary can be written to `path`, which is standard output where that is `-`.
pub(crate) fn check_json(path: &Path, others: &[&Path]) -> anyhow::Result<()> {
    if is_standard(path) { Ok(()) } else { check("--json", path, others) }
}

/// Writes a summary as JSON: to a file, or for `-` to standard output, where [`report_beside`] then writes nothing.
pub(crate) fn write_json(path: &Path, summary: &impl Serialize) -> anyhow::Result<()> {
    let text = serde_json::to_string_pretty(summary)?;
    if is_standard(path) {
        return report::print(&format!("{text}\n"));
    }
    Ok(AtomicFile::write(path, |file| writeln!(file, "{text}"))?)
}

/// Prints the report of a run: to standard output, or to standard error where the summary has that for itself.
pub(crate) fn report_beside(json: Option<&Path>, text: &str) -> anyhow::Result<()> {
    match json {
        Some(path) if is_standard(path) => report::note(text),
        _ => report::print(text)?,
    }
    Ok(())
}

/// Names that a run makes up as it goes on: a number between two parts that are given.
#[derive(Debug, Clone)]
pub(crate) struct NumberedNames {
    folder: PathBuf,
    before: String,
    after: String,
}

impl NumberedNames {
    /// The names `before`, a number and `after`, beside `path`.
    pub fn beside(path: &Path, before: &str, after: &str) -> Self {
        Self { folder: parent(path).into(), before: before.into(), after: after.into() }
    }

    /// Checks that none of these names is that of another file of the run.
    ///
    /// Which numbers there will be is not known before everything has been read, and by then the first files are written:
    /// every number counts.
    pub fn check(&self, option: &str, path: &Path, others: &[&Path]) -> anyhow::Result<()> {
        // Files that are there by such a name may be links to the others.
        let listed = std::fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let there: Vec<PathBuf> = listed.map(|entry| entry.path()).filter(|path| self.has_name_of(path)).collect();
        let folder = self.folder.canonicalize().ok();
        let hit = |other: &&&Path| {
            let beside = folder.is_some() && parent(other).canonicalize().ok() == folder;
            beside && self.has_name_of(other) || there.iter().any(|path| is_same(path, other))
        };
        match others.iter().find(hit) {
            Some(other) => bail!(
                "{option} {}: the files {}NUMBER{} that this makes could overwrite {}, another file of this run; choose \
                 another name",
                path.display(),
                self.before,
                self.after,
                other.display()
            ),
            None => Ok(()),
        }
    }

    fn has_name_of(&self, path: &Path) -> bool {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let number = name.strip_prefix(self.before.as_str()).and_then(|rest| rest.strip_suffix(self.after.as_str()));
        // Numbers are written without leading zeros.
        number.is_some_and(|number| number.parse::<usize>().is_ok_and(|n| n.to_string() == number))
    }
}

/// Checks that the folder around `path` exists and can be written to.
pub(crate) fn check_folder(option: &str, path: &Path) -> anyhow::Result<()> {
    let shown = path.display();
    let folder = parent(path);
    match std::fs::metadata(folder) {
        Ok(found) if found.is_dir() => {}
        Ok(_) => bail!("{option} {shown}: {} is a file, not a folder; choose another place", folder.display()),
        Err(_) => bail!("{option} {shown}: the folder {} does not exist; make it first", folder.display()),
    }
    // Devices and pipes are written to directly and need no place beside them.
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return Ok(());
    }
    if let Err(error) = tempfile::tempfile_in(folder) {
        bail!("{option} {shown}: cannot write into the folder {}: {error}; choose another place", folder.display());
    }
    Ok(())
}

/// Largest distance between the centres of a cell in two files of one mesh, in cube roots of its volume: text of six
/// digits stays below it.
const SAME_CENTRE: f64 = 1e-3;

/// Refuses results on `mesh`, read from `source`, for a time folder of a case that has another mesh; warns where the cells
/// are not in the order of their case.
pub(crate) fn check_mesh_of_case(option: &str, path: &Path, mesh: &Mesh, source: &Path) -> anyhow::Result<()> {
    let shown = path.display();
    if openfoam::has_case_order(source).is_ok_and(|known| !known) {
        report::warn(&format!(
            "{}: without cellProcAddressing in every processor folder cells are in the order of the processors, and so are \
             the results in {shown}: they do not fit the reconstructed case",
            source.display()
        ));
    }
    let Some(own) = openfoam::mesh_of_time(path) else { return Ok(()) };
    if openfoam::is_same_mesh(&own, source) {
        return Ok(());
    }
    let (own, given) = (own.as_path(), source.display());
    let theirs = openfoam::read_poly_mesh(own).with_context(|| format!("{option} {shown}: the case's mesh"))?;
    let own = own.display();
    let remedy = format!("give --mesh {own}, or write a .vtu");
    if theirs.cell_count() != mesh.cell_count() {
        bail!(
            "{option} {shown}: the mesh of this time, {own}, has {} cells, and {given} has {}: {remedy}",
            theirs.cell_count(),
            mesh.cell_count()
        );
    }
    for cell in 0..mesh.cell_count() {
        let (a, b) = (theirs.cell_centre(cell), mesh.cell_centre(cell));
        let apart = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt();
        if apart > SAME_CENTRE * theirs.cell_volume(cell).cbrt() {
            bail!(
                "{option} {shown}: cell {cell} is at ({}, {}, {}) in the mesh of this time, {own}, and at ({}, {}, {}) in \
                 {given}: {remedy}",
                a[0],
                a[1],
                a[2],
                b[0],
                b[1],
                b[2]
            );
        }
    }
    Ok(())
}

/// Whether two names lead to one file, or would if it existed.
fn is_same(a: &Path, b: &Path) -> bool {
    let resolved = |path: &Path| -> Option<PathBuf> {
        path.canonicalize().ok().or_else(|| Some(parent(path).canonicalize().ok()?.join(path.file_name()?)))
    };
    let (a, b) = (resolved(a), resolved(b));
    a.is_some() && a == b
}

fn parent(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
