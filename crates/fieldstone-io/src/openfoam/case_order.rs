//! The order of cells in the case that a decomposed one was cut from.

use std::path::{Path, PathBuf};

use fieldstone_mesh::MeshParts;

use crate::meshes::is_openfoam;
use crate::{IoError, Position};

use super::list::{Complaint, NO_LABEL};
use super::locate::{Located, existing, locate};
use super::poly_mesh::RawMesh;
use super::stream::Stream;

/// Written by decomposePar beside each part's mesh: the number of each of its cells in the whole case.
const FILE: &str = "cellProcAddressing";

/// Whether the cells of the mesh at `path` are in the order of its case, as fields in time folders are: true for whole
/// meshes and those of other formats, and for decomposed ones where every part has a `cellProcAddressing`.
///
/// # Errors
/// As [`super::read_poly_mesh`] where no mesh is found.
///
/// ```no_run
/// if !fieldstone_io::openfoam::has_case_order("bed".as_ref())? {
///     println!("cells are in the order of the processors");
/// }
/// # Ok::<(), fieldstone_io::IoError>(())
/// ```
pub fn has_case_order(path: &Path) -> Result<bool, IoError> {
    if !is_openfoam(path) {
        return Ok(true);
    }
    Ok(match locate(path)? {
        Located::Whole(_) => true,
        Located::Decomposed(parts) => parts.iter().all(|part| existing(&part.topology, FILE).is_some()),
    })
}

/// Number in the whole case of each cell of the parts, one part after the other; none where a part does not say.
pub(super) fn case_order(parts: &[(RawMesh, PathBuf)]) -> Result<Option<Vec<u32>>, IoError> {
    let Some(files) = parts.iter().map(|(_, folder)| existing(folder, FILE)).collect::<Option<Vec<PathBuf>>>() else {
        return Ok(None);
    };
    let total: usize = parts.iter().map(|(mesh, _)| mesh.cells).sum();
    let mut order: Vec<u32> = Vec::with_capacity(total);
    let mut taken = vec![false; total];
    let remedy = "decompose the case again, or remove the file to have cells in the order of the processors";
    for ((mesh, _), file) in parts.iter().zip(&files) {
        let found = Stream::open(file)?.each("cells of the whole case", mesh.cells, |cell, whole: u32| {
            let place = taken.get_mut(whole as usize).filter(|_| whole != NO_LABEL);
            let found = match place {
                Some(taken) if !*taken => {
                    *taken = true;
                    order.push(whole);
                    return Ok(());
                }
                Some(_) => format!("cell {cell} is cell {whole} of the whole case, which another cell is already"),
                None => format!(
                    "cell {cell} is cell {} of the whole case, but the parts have {total} cells, from 0",
                    if whole == NO_LABEL { "-1".into() } else { whole.to_string() }
                ),
            };
            Err(Complaint { found, remedy: remedy.into() })
        })?;
        if found != mesh.cells {
            let found = format!("{FILE} has {found} entries, but this part has {} cells", mesh.cells);
            return Err(IoError::content(file, Position::File, found, remedy));
        }
    }
    Ok(Some(order))
}

/// Gives each cell its new number.
pub(super) fn renumber_cells(parts: &mut MeshParts, number: &[u32]) {
    for cell in parts.owner.iter_mut().chain(&mut parts.neighbour) {
        *cell = number[*cell as usize];
    }
    for cell in parts.zones.iter_mut().flat_map(|zone| &mut zone.cells) {
        *cell = number[*cell as usize];
    }
    // A face points from the cell with the smaller number to the other, as in every case that OpenFOAM writes.
    for face in 0..parts.neighbour.len() {
        if parts.owner[face] > parts.neighbour[face] {
            std::mem::swap(&mut parts.owner[face], &mut parts.neighbour[face]);
            let start = if face == 0 { 0 } else { parts.face_ends[face - 1] };
            parts.face_points[start + 1..parts.face_ends[face]].reverse();
        }
    }
    parts.zones.iter_mut().for_each(|zone| zone.cells.sort_unstable());
}
