//! `polyMesh` folders: points, faces, owner, neighbour, boundary, cellZones.

use std::path::Path;

use fieldstone_mesh::{Mesh, MeshParts};

use crate::{IoError, Position};

use super::boundary::{BoundaryPatch, read_boundary, read_cell_zones};
use super::case_order::{case_order, renumber_cells};
use super::decomposed::join;
use super::list::{Complaint, ListStart, NO_LABEL};
use super::locate::{Located, MeshFolders, existing, locate, required};
use super::stream::Stream;

/// Reads an OpenFOAM mesh.
///
/// `path` is a case folder, its `constant`, a time folder, a `polyMesh` folder or a file in one of them, or a
/// `processorN` folder. Text and binary files of any label and scalar width are read, plain or `.gz`. A time
/// folder with points only takes its faces from the latest earlier time that has them, or from `constant`.
///
/// A case without a mesh of its own but with `processor0…N` is read as one mesh: `processor` patches turned back into
/// internal faces, patches and zones of one name joined. Pieces of cyclic patches (`processorCyclic`) are added to the
/// patch that they were cut from. Cells are in the order of the undecomposed case where every part has a
/// `cellProcAddressing`, else in that of the processors ([`has_case_order`](crate::openfoam::has_case_order) tells).
///
/// # Errors
/// [`IoError`] with file and line, or byte in binary files, for a missing or damaged file, counts that do not
/// fit each other, and labels out of range; [`IoError::Mesh`] where the lists make no valid mesh. The collated
/// format (`processorsN`) is refused.
///
/// ```no_run
/// let mesh = fieldstone_io::openfoam::read_poly_mesh("bed".as_ref())?;
/// println!("{} cells", mesh.cell_count());
/// # Ok::<(), fieldstone_io::IoError>(())
/// ```
pub fn read_poly_mesh(path: &Path) -> Result<Mesh, IoError> {
    let (raw, folder) = match locate(path)? {
        Located::Whole(folders) => (read_folders(&folders)?, folders.topology),
        Located::Decomposed(parts) => {
            let mut meshes = Vec::with_capacity(parts.len());
            for folders in &parts {
                meshes.push((read_folders(folders)?, folders.topology.clone()));
            }
            let order = case_order(&meshes)?;
            let mut whole = join(meshes)?;
            if let Some(order) = order {
                renumber_cells(&mut whole.parts, &order);
            }
            (whole, path.to_path_buf())
        }
    };
    let mut parts = raw.parts;
    parts.patches = raw.patches.into_iter().map(|p| p.patch).collect();
    Mesh::new(parts).map_err(|source| IoError::Mesh { path: folder, source })
}

/// Lists of one mesh; patches apart, with what joining needs to know of them.
#[derive(Debug, Default)]
pub(super) struct RawMesh {
    pub parts: MeshParts,
    pub patches: Vec<BoundaryPatch>,
    pub cells: usize,
}

pub(super) fn read_folders(folders: &MeshFolders) -> Result<RawMesh, IoError> {
    let points = read_points(&required(&folders.points, "points")?)?;
    let topology = &folders.topology;
    let (face_ends, face_points) = read_faces(&required(topology, "faces")?, points.len())?;
    let faces = face_ends.len();

    let owner_path = required(topology, "owner")?;
    let owner = read_cells(&owner_path, "owner", faces, false)?;
    let neighbour_path = required(topology, "neighbour")?;
    let neighbour = read_cells(&neighbour_path, "neighbour", faces, true)?;
    if owner.len() != faces {
        return Err(wrong_length(&owner_path, "owner", owner.len(), faces));
    }
    if neighbour.len() > faces {
        return Err(wrong_length(&neighbour_path, "neighbour", neighbour.len(), faces));
    }
    let top = owner.iter().chain(&neighbour).filter(|&&c| c != NO_LABEL).max();
    let cells = top.map_or(0, |&c| c as usize + 1);

    let mut parts = MeshParts { points, face_ends, face_points, owner, neighbour, ..MeshParts::default() };
    let position = internal_faces_first(&mut parts);
    let internal = parts.neighbour.len();

    let boundary_path = required(topology, "boundary")?;
    let patches = match position {
        None => read_boundary(&boundary_path, faces, internal)?,
        Some(position) => {
            let mut patches = read_boundary(&boundary_path, faces, 0)?;
            for p in &mut patches {
                let p = &mut p.patch;
                // Boundary faces keep their order among themselves, so that a patch stays in one piece.
                let moved = position.get(p.start).map_or(faces, |&k| k as usize);
                if p.count > 0 && (p.start..p.start + p.count).any(|f| (position[f] as usize) < internal) {
                    return Err(IoError::content(
                        &boundary_path,
                        Position::File,
                        format!("patch '{}' holds faces that lie between two cells", p.name),
                        "the boundary and neighbour files may come from different meshes",
                    ));
                }
                p.start = moved.max(internal);
            }
            patches
        }
    };
    parts.zones = match existing(topology, "cellZones") {
        Some(path) => read_cell_zones(&path, cells)?,
        None => Vec::new(),
    };
    Ok(RawMesh { parts, patches, cells })
}

fn wrong_length(path: &Path, name: &str, found: usize, faces: usize) -> IoError {
    IoError::content(
        path,
        Position::File,
        format!("{name} has {found} entries, but the mesh has {faces} faces"),
        format!("the {name} and faces files may come from different meshes"),
    )
}

fn read_points(path: &Path) -> Result<Vec<[f64; 3]>, IoError> {
    let mut points = Vec::new();
    Stream::open(path)?.each("points", 1, |k, p: [f64; 3]| {
        if p.iter().any(|x| !x.is_finite()) {
            return Err(Complaint {
                found: format!("point {k} is ({} {} {})", p[0], p[1], p[2]),
                remedy: "coordinates must be finite numbers: the mesh motion may have failed".into(),
            });
        }
        points.push(p);
        Ok(())
    })?;
    Ok(points)
}

/// Corner ends and corners of all faces.
fn read_faces(path: &Path, points: usize) -> Result<(Vec<usize>, Vec<u32>), IoError> {
    let mut stream = Stream::open(path)?;
    let check = |face: usize, point: u32| {
        if (point as usize) < points {
            return Ok(point);
        }
        let point = if point == NO_LABEL { "-1".into() } else { point.to_string() };
        Err(Complaint {
            found: format!("face {face} names point {point}, but the mesh has {points} points"),
            remedy: "the points and faces files may come from different time steps".into(),
        })
    };
    let too_few = |face: usize, corners: usize| Complaint {
        found: format!("face {face} has {corners} corners"),
        remedy: "a face needs at least three corners: correct the mesh, or write it again".into(),
    };
    let (mut ends, mut corners) = (Vec::new(), Vec::new());

    if is_compact(&mut stream)? {
        // Start of each face's corners in the second list, and one number more: the end of the last.
        let mut last = None;
        stream.each("face offsets", 1, |k, offset: u32| {
            match last {
                None if offset != 0 => {
                    return Err(Complaint {
                        found: format!("the first face offset is {offset}"),
                        remedy: "it must be 0: the file is damaged".into(),
                    });
                }
                None => {}
                Some(last) if offset == NO_LABEL || offset < last => {
                    return Err(Complaint {
                        found: format!("face offset {k} falls from {last} to {offset}"),
                        remedy: "offsets must rise: the file is damaged".into(),
                    });
                }
                Some(last) if offset - last < 3 => return Err(too_few(k - 1, (offset - last) as usize)),
                Some(_) => ends.push(offset as usize),
            }
            last = Some(offset);
            Ok(())
        })?;
        let mut face = 0;
        stream.each("face corners", 0, |k, point: u32| {
            face += usize::from(ends.get(face).is_some_and(|&end| k >= end));
            corners.push(check(face, point)?);
            Ok(())
        })?;
        let expected = ends.last().copied().unwrap_or(0);
        if corners.len() != expected {
            return Err(stream.error(
                format!("the faces have {expected} corners by their offsets, but {} are listed", corners.len()),
                "the file is damaged; write the mesh again",
            ));
        }
        return Ok((ends, corners));
    }

    let count = match stream.list_start("faces", false)? {
        ListStart::Empty => return Ok((ends, corners)),
        ListStart::Entries(count) => count,
        ListStart::Raw(_) | ListStart::Uniform(_) => return Err(stream.unexpected("a list of faces")),
    };
    while stream.more_entries("faces", ends.len(), count)? {
        let (start, face) = (stream.at, ends.len());
        let found = stream.each("corners of a face", 0, |_, point: u32| {
            corners.push(check(face, point)?);
            Ok(())
        })?;
        if found < 3 {
            let complaint = too_few(face, found);
            return Err(stream.error_at(start, complaint.found, complaint.remedy));
        }
        ends.push(corners.len());
    }
    Ok((ends, corners))
}

/// Whether faces are stored as offsets and corners; what the class says of a text file need not be true.
fn is_compact(stream: &mut Stream) -> Result<bool, IoError> {
    if stream.header().class != "faceCompactList" {
        return Ok(false);
    }
    if stream.encoding().binary {
        return Ok(true);
    }
    let start = stream.at;
    let compact = match stream.list_start("faces", false)? {
        ListStart::Entries(_) => stream.integer().is_ok() && stream.peek() != Some(b'('),
        _ => true,
    };
    stream.at = start;
    Ok(compact)
}

/// Reads `owner` or `neighbour`.
fn read_cells(path: &Path, name: &str, faces: usize, may_be_none: bool) -> Result<Vec<u32>, IoError> {
    // Every cell has a face, and a face has at most two cells: an index above that would cost memory for nothing.
    let limit = faces.saturating_mul(2);
    let mut cells = Vec::new();
    Stream::open(path)?.each(&format!("{name} cells"), faces, |face, cell: u32| {
        if cell == NO_LABEL && !may_be_none {
            return Err(Complaint {
                found: format!("face {face} has owner -1"),
                remedy: "every face needs an owner cell; write the mesh again".into(),
            });
        }
        if cell != NO_LABEL && cell as usize >= limit {
            return Err(Complaint {
                found: format!("face {face} has {name} {cell}, but {faces} faces can bound no more than {limit} cells"),
                remedy: format!("the {name} and faces files may come from different meshes"),
            });
        }
        cells.push(cell);
        Ok(())
    })?;
    Ok(cells)
}

/// Brings the faces between two cells to the front and cuts `neighbour` behind them; returns the new index of each
/// face where any had to move.
///
/// Old meshes list −1 as the neighbour of boundary faces, which may then stand anywhere.
fn internal_faces_first(parts: &mut MeshParts) -> Option<Vec<u32>> {
    let is_internal = |parts: &MeshParts, f: usize| parts.neighbour.get(f).is_some_and(|&c| c != NO_LABEL);
    let faces = parts.owner.len();
    let internal = (0..faces).filter(|&f| is_internal(parts, f)).count();
    if (0..internal).all(|f| is_internal(parts, f)) {
        parts.neighbour.truncate(internal);
        return None;
    }
    let order: Vec<usize> =
        (0..faces).filter(|&f| is_internal(parts, f)).chain((0..faces).filter(|&f| !is_internal(parts, f))).collect();
    let mut position = vec![0; faces];
    let mut sorted = MeshParts::default();
    for (new, &old) in order.iter().enumerate() {
        position[old] = new as u32;
        sorted.face_points.extend_from_slice(parts.face(old));
        sorted.face_ends.push(sorted.face_points.len());
        sorted.owner.push(parts.owner[old]);
        if new < internal {
            sorted.neighbour.push(parts.neighbour[old]);
        }
    }
    parts.face_ends = sorted.face_ends;
    parts.face_points = sorted.face_points;
    parts.owner = sorted.owner;
    parts.neighbour = sorted.neighbour;
    Some(position)
}
