//! Which files a path given by the user stands for.

use std::path::{Path, PathBuf};

use crate::meshes::is_openfoam;
use crate::{IoError, Position};

/// Folders that hold the files of one mesh.
#[derive(Debug, Clone)]
pub(super) struct MeshFolders {
    /// Folder of `points`.
    pub points: PathBuf,
    /// Folder of `faces` and of everything that is numbered by faces and cells.
    pub topology: PathBuf,
}

/// What a path stands for.
#[derive(Debug)]
pub(super) enum Located {
    Whole(MeshFolders),
    /// One mesh per `processorN` folder, in the order of N.
    Decomposed(Vec<MeshFolders>),
}

/// The plain file, or the `.gz` beside it where there is no plain one.
pub(super) fn existing(folder: &Path, name: &str) -> Option<PathBuf> {
    [folder.join(name), folder.join(format!("{name}.gz"))].into_iter().find(|p| p.is_file())
}

/// A file that must exist.
pub(super) fn required(folder: &Path, name: &str) -> Result<PathBuf, IoError> {
    existing(folder, name).ok_or_else(|| {
        IoError::content(
            folder.join(name),
            Position::File,
            format!("there is neither '{name}' nor '{name}.gz' in this folder"),
            "a polyMesh folder needs points, faces, owner, neighbour and boundary; copy the missing file or write the mesh again",
        )
    })
}

/// Time that a time folder's name states.
pub(super) fn time_of(folder: &Path) -> Option<f64> {
    folder.file_name()?.to_str()?.parse().ok().filter(|t: &f64| t.is_finite())
}

/// Sub-folders with their names, sorted by name.
pub(super) fn folders(path: &Path) -> Result<Vec<(String, PathBuf)>, IoError> {
    let system = |source| IoError::System { path: path.into(), action: "read", source };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(path).map_err(system)? {
        let entry = entry.map_err(system)?;
        if entry.path().is_dir() {
            found.push((entry.file_name().to_string_lossy().into_owned(), entry.path()));
        }
    }
    found.sort();
    Ok(found)
}

/// The `processorN` folders of a case, in the order of N.
pub(super) fn processors(case: &Path) -> Vec<(usize, PathBuf)> {
    let folders = folders(case).unwrap_or_default();
    let number = |name: &str| name.strip_prefix("processor")?.parse().ok();
    let mut processors: Vec<(usize, PathBuf)> =
        folders.into_iter().filter_map(|(name, p)| Some((number(&name)?, p))).collect();
    processors.sort();
    processors
}

/// Finds the mesh that `path` stands for: a polyMesh folder or a file in it, a folder above it, or a case.
pub(super) fn locate(path: &Path) -> Result<Located, IoError> {
    let path = match path.parent() {
        Some(parent) if path.is_file() => parent,
        _ => path,
    };
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    if let Some(found) = mesh_below(path) {
        return Ok(Located::Whole(found));
    }
    let folders = folders(path)?;
    let processors = processors(path);
    if processors.is_empty() {
        let regions = regions(path);
        let remedy = if folders.iter().any(|(name, _)| name.starts_with("processors")) {
            "the case is decomposed in the collated format, which is not supported: reconstruct the mesh \
             (reconstructParMesh), or decompose with -fileHandler uncollated"
                .into()
        } else if !regions.is_empty() {
            format!(
                "there are meshes further down (of regions, or other cases); give one of them: {}",
                regions.join(", ")
            )
        } else {
            "give a case folder, its constant folder, a time folder that holds a polyMesh, a polyMesh folder, or a processorN \
             folder"
                .to_string()
        };
        return Err(IoError::content(path, Position::File, "no polyMesh was found here", remedy));
    }
    let mut meshes = Vec::with_capacity(processors.len());
    for (expected, (number, folder)) in processors.into_iter().enumerate() {
        let found = (number == expected).then(|| mesh_below(&folder)).flatten();
        meshes.push(found.ok_or_else(|| {
            IoError::content(
                path.join(format!("processor{expected}")),
                Position::File,
                "this part of the decomposed case has no mesh",
                "the parts must be numbered from 0 without a gap; decompose again or copy the missing part",
            )
        })?);
    }
    Ok(Located::Decomposed(meshes))
}

/// The folders of a case's regions that have a mesh, or of cases in this folder; the first of very many.
fn regions(case: &Path) -> Vec<String> {
    let inside = [case.join("constant"), case.to_path_buf()].into_iter().flat_map(|p| folders(&p).unwrap_or_default());
    inside.filter(|(_, p)| mesh_below(p).is_some()).map(|(_, p)| p.display().to_string()).take(10).collect()
}

/// The mesh that OpenFOAM reads fields of a time folder on, as a path for [`super::read_poly_mesh`]: that of the latest time up
/// to the folder's own which has points, else the one in `constant`. None where the case has no mesh.
///
/// The time folder itself need not exist.
///
/// ```no_run
/// let mesh = fieldstone_io::openfoam::mesh_of_time("stirrer/0.5".as_ref());
/// println!("{mesh:?}");
/// ```
pub fn mesh_of_time(time_folder: &Path) -> Option<PathBuf> {
    let time = time_of(time_folder)?;
    let case = time_folder.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let moved = folders(case).unwrap_or_default().into_iter().filter_map(|(_, p)| Some((time_of(&p)?, p)));
    let moved = moved.filter(|(t, p)| *t <= time && existing(&p.join("polyMesh"), "points").is_some());
    let latest = moved.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, p)| p);
    latest.or_else(|| existing(&case.join("constant/polyMesh"), "points").map(|_| case.into()))
}

/// Whether two paths stand for the same files of a mesh.
///
/// ```no_run
/// use fieldstone_io::openfoam::is_same_mesh;
/// assert!(is_same_mesh("bed".as_ref(), "bed/constant/polyMesh".as_ref()));
/// ```
pub fn is_same_mesh(a: &Path, b: &Path) -> bool {
    let files = |path: &Path| match locate(path) {
        Ok(Located::Whole(found)) if is_openfoam(path) => {
            Some([found.points.canonicalize().ok()?, found.topology.canonicalize().ok()?])
        }
        _ => None,
    };
    let (a, b) = (files(a), files(b));
    a.is_some() && a == b
}

/// The mesh in `path`, `path/polyMesh` or `path/constant/polyMesh`, the first that has any of the files.
fn mesh_below(path: &Path) -> Option<MeshFolders> {
    let folder = [path.to_path_buf(), path.join("polyMesh"), path.join("constant/polyMesh")]
        .into_iter()
        .find(|f| ["points", "faces", "owner"].iter().any(|name| existing(f, name).is_some()))?;
    Some(MeshFolders { points: instance_with(&folder, "points"), topology: instance_with(&folder, "faces") })
}

/// The folder that holds `name` at the time of `folder`: a moving mesh writes points only, and its faces are those
/// of an earlier time or of `constant`.
fn instance_with(folder: &Path, name: &str) -> PathBuf {
    let missing = || folder.to_path_buf();
    if existing(folder, name).is_some() {
        return missing();
    }
    let above = folder.canonicalize().unwrap_or_else(|_| missing());
    let Some((time, case)) = above.parent().and_then(|t| Some((time_of(t)?, t.parent()?))) else {
        return missing();
    };
    let mut earlier: Vec<(f64, PathBuf)> = folders(case)
        .unwrap_or_default()
        .into_iter()
        .filter_map(|(_, p)| Some((time_of(&p).filter(|&t| t < time)?, p.join("polyMesh"))))
        .collect();
    earlier.sort_by(|a, b| b.0.total_cmp(&a.0));
    earlier
        .into_iter()
        .map(|(_, p)| p)
        .chain([case.join("constant/polyMesh")])
        .find(|p| existing(p, name).is_some())
        .unwrap_or_else(missing)
}
