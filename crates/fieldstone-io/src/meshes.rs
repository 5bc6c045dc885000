//! Which reader a mesh needs, and whether a file holds a mesh or particles.

use std::io::Read;
use std::path::Path;

use fieldstone_mesh::Mesh;

use crate::{IoError, gmsh, openfoam, source, vtk};

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// A mesh with volume cells.
    Mesh,
    /// Particles.
    Particles,
}

enum Format {
    OpenFoam,
    Gmsh,
    Vtk,
    /// None that holds a mesh; with what it looks like.
    Unknown(&'static str),
}

/// Whether a path stands for an OpenFOAM mesh if for any: folders, and files of a mesh's folder.
pub(crate) fn is_openfoam(path: &Path) -> bool {
    let in_poly_mesh = path.parent().is_some_and(|p| p.file_name().is_some_and(|n| n == "polyMesh"));
    // ParaView's empty marker file stands for the case that it lies in.
    let marker = path.extension().is_some_and(|e| e == "foam");
    path.is_dir() || in_poly_mesh || marker
}

fn format_of(path: &Path) -> Result<Format, IoError> {
    if is_openfoam(path) {
        return Ok(Format::OpenFoam);
    }
    let mut start = Vec::new();
    source::open(path)?.take(512).read_to_end(&mut start).map_err(|source| IoError::System {
        path: path.into(),
        action: "read",
        source,
    })?;
    let start = start.trim_ascii_start();
    let begins = |text: &str| start.starts_with(text.as_bytes());
    if begins("$MeshFormat") || begins("$Comments") {
        return Ok(Format::Gmsh);
    }
    if begins("# vtk DataFile") || begins("<VTKFile") || begins("<?xml") {
        return Ok(Format::Vtk);
    }
    Ok(Format::Unknown(match start {
        [] => "the file is empty",
        _ if begins("ITEM:") => "this is a LIGGGHTS or LAMMPS dump of particles, not a mesh",
        _ if begins("solid") || begins("ply") => "this is a surface (STL, PLY), not a mesh of volume cells",
        _ if begins("FoamFile") || begins("/*") => "this is an OpenFOAM file outside of a polyMesh folder",
        _ => "the content is not that of a mesh",
    }))
}

/// Reads a mesh, deciding on the format by content: an OpenFOAM case, `constant`, `polyMesh` or `processorN` folder (or a
/// file in `polyMesh`), Gmsh 2.0 to 2.2 and 4.1, VTK `.vtu` and legacy `.vtk`.
///
/// # Errors
/// [`IoError::UnknownFormat`] where the content is none of these; else the reader's own.
pub fn read_mesh(path: &Path) -> Result<Mesh, IoError> {
    match format_of(path)? {
        Format::OpenFoam => openfoam::read_poly_mesh(path),
        Format::Gmsh => gmsh::read_gmsh(path),
        Format::Vtk => vtk::read_vtk_mesh(path),
        Format::Unknown(found) => Err(IoError::UnknownFormat {
            path: path.into(),
            found: found.into(),
            readable: "OpenFOAM polyMesh folders, Gmsh .msh 2.0 to 2.2 and 4.1, VTK .vtu and .vtk".into(),
        }),
    }
}

/// Whether a file holds a mesh or particles; a VTK file with volume cells is a mesh, one without is particles.
///
/// # Errors
/// [`IoError`] where the file cannot be read.
pub fn file_kind(path: &Path) -> Result<FileKind, IoError> {
    if !openfoam::parts_of_cloud(path).is_empty() {
        return Ok(FileKind::Particles);
    }
    let mesh = match format_of(path)? {
        Format::OpenFoam => !path.ancestors().any(|p| p.file_name().is_some_and(|n| n == "lagrangian")),
        Format::Gmsh => true,
        Format::Vtk => vtk::read_vtk(path)?.has_volume_cells(),
        Format::Unknown(_) => false,
    };
    Ok(if mesh { FileKind::Mesh } else { FileKind::Particles })
}
