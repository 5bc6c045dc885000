//! `.pvd` files: lists of files over time.

use std::path::{Path, PathBuf};

use quick_xml::escape::escape;

use super::fault::Fault;
use super::xml_tree::parse;
use crate::{AtomicFile, IoError, Position, source};

/// Writes a `.pvd`, which ParaView opens as one data set over time.
///
/// Each step is its time and its file; files are named relative to the `.pvd`'s folder.
///
/// # Errors
/// [`IoError::Content`] for a time that is not finite; [`IoError::System`].
///
/// ```
/// use fieldstone_io::vtk::{read_pvd, write_pvd};
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("run.pvd");
/// write_pvd(&path, &[(0.0, "run_0.vtu".into()), (0.1, "run_1.vtu".into())])?;
/// assert_eq!(read_pvd(&path)?[1], (0.1, folder.path().join("run_1.vtu")));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_pvd(path: &Path, steps: &[(f64, PathBuf)]) -> Result<(), IoError> {
    if let Some((time, file)) = steps.iter().find(|(time, _)| !time.is_finite()) {
        let found = format!("the time of {} is {time}", file.display());
        return Err(IoError::content(path, Position::File, found, "give finite times; nothing was written"));
    }
    AtomicFile::write(path, |out| {
        out.write_all(b"<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n")?;
        for (time, file) in steps {
            // ParaView wants forward slashes on every system.
            let name = file.to_string_lossy().replace('\\', "/");
            writeln!(out, "<DataSet timestep=\"{time:?}\" group=\"\" part=\"0\" file=\"{}\"/>", escape(name))?;
        }
        out.write_all(b"</Collection>\n</VTKFile>\n")
    })
}

/// Reads a `.pvd`: times and files in the order of the list, the files' paths completed by the `.pvd`'s folder.
///
/// # Errors
/// [`IoError::Content`] where the file is no collection or a step has no time or file; [`IoError::System`].
pub fn read_pvd(path: &Path) -> Result<Vec<(f64, PathBuf)>, IoError> {
    let bytes = source::read_all(path)?;
    let (root, _) = parse(&bytes).map_err(|fault| fault.in_file(path))?;
    let fault = |found: &str| Fault::new(Position::File, found, "give a .pvd that lists files over time").in_file(path);
    let collection = root.child("Collection").ok_or_else(|| fault("there is no <Collection>"))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let step = |element: &super::xml_tree::Element<'_>| {
        let time = element.attribute("timestep").and_then(|t| t.trim().parse().ok());
        let (Some(time), Some(file)) = (time, element.attribute("file")) else {
            return Err(fault("a <DataSet> has no timestep or no file"));
        };
        Ok((time, folder.join(file)))
    };
    collection.all("DataSet").map(step).collect()
}
