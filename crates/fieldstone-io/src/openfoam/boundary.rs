//! The `boundary` and `cellZones` files: dictionaries that name faces and cells.

use std::path::Path;

use fieldstone_mesh::{Patch, Zone};

use crate::IoError;

use super::list::Complaint;
use super::stream::Stream;

/// A patch with what decomposed cases say about it.
#[derive(Debug, Clone)]
pub(super) struct BoundaryPatch {
    pub patch: Patch,
    /// The part on the other side, for patches of kind `processor`.
    pub neighbour_processor: Option<usize>,
    /// The cyclic patch that a `processorCyclic` patch is a piece of.
    pub refer_patch: Option<String>,
}

/// Reads a list of named dictionaries, `N ( name { … } … )`.
fn named_dictionaries(
    stream: &mut Stream,
    what: &str,
    mut read: impl FnMut(&mut Stream, String) -> Result<(), IoError>,
) -> Result<(), IoError> {
    use super::list::ListStart::{Empty, Entries, Raw, Uniform};
    let count = match stream.list_start(what, false)? {
        Empty => return Ok(()),
        Entries(count) => count,
        Raw(_) | Uniform(_) => return Err(stream.unexpected(&format!("a list of {what}"))),
    };
    let mut done = 0;
    while stream.more_entries(what, done, count)? {
        let name = stream.word_or_string()?;
        stream.expect(b'{', "the description of a patch or zone")?;
        read(stream, name)?;
        done += 1;
    }
    Ok(())
}

/// Reads `boundary`; `faces` and `internal` are the mesh's counts of faces.
pub(super) fn read_boundary(path: &Path, faces: usize, internal: usize) -> Result<Vec<BoundaryPatch>, IoError> {
    let mut stream = Stream::open(path)?;
    let mut patches: Vec<BoundaryPatch> = Vec::new();
    named_dictionaries(&mut stream, "patches", |s, name| {
        let start_of_patch = s.at;
        let (mut kind, mut count, mut start) = (None, None, None);
        let (mut neighbour_processor, mut refer_patch) = (None, None);
        while !s.accept(b'}') {
            match s.word()?.as_str() {
                "type" => kind = Some(s.word()?),
                "nFaces" => count = Some(s.count("nFaces")?),
                "startFace" => start = Some(s.count("startFace")?),
                "neighbProcNo" => neighbour_processor = Some(s.count("neighbProcNo")?),
                "referPatch" => refer_patch = Some(s.word_or_string()?),
                _ => {}
            }
            s.skip_value()?;
        }
        let (Some(count), Some(start)) = (count, start) else {
            return Err(s.error_at(
                start_of_patch,
                format!("patch '{name}' lacks nFaces or startFace"),
                "every patch needs type, nFaces and startFace",
            ));
        };
        // An empty patch may state any start; it claims no face.
        let start = if count == 0 { start.clamp(internal, faces.max(internal)) } else { start };
        let end = start.checked_add(count);
        if start < internal || end.is_none_or(|end| end > faces) {
            return Err(s.error_at(
                start_of_patch,
                format!("patch '{name}' has {count} faces from face {start} on, but the boundary is faces {internal} to {faces}"),
                "the boundary and faces files may come from different meshes",
            ));
        }
        if let Some(p) = patches.iter().map(|p| &p.patch).find(|p| start < p.start + p.count && p.start < start + count)
        {
            return Err(s.error_at(
                start_of_patch,
                format!("patches '{}' and '{name}' share face {}", p.name, start.max(p.start)),
                "correct nFaces and startFace: a face belongs to one patch",
            ));
        }
        let patch = Patch { name, kind: kind.unwrap_or_else(|| "patch".into()), start, count };
        patches.push(BoundaryPatch { patch, neighbour_processor, refer_patch });
        Ok(())
    })?;
    Ok(patches)
}

/// Reads `cellZones`.
pub(super) fn read_cell_zones(path: &Path, cells: usize) -> Result<Vec<Zone>, IoError> {
    let mut stream = Stream::open(path)?;
    let mut zones = Vec::new();
    named_dictionaries(&mut stream, "cell zones", |s, name| {
        let mut zone = Zone { name, cells: Vec::new() };
        while !s.accept(b'}') {
            if s.word()? == "cellLabels" {
                // The list may be announced: `List<label>`, `nonuniform List<label>`.
                while s.peek().is_some_and(|b| b.is_ascii_alphabetic()) {
                    s.word()?;
                }
                s.each::<u32>("cells", 1, |_, cell| {
                    if cell as usize >= cells {
                        return Err(Complaint {
                            found: format!("zone '{}' names cell {cell}, but the mesh has {cells} cells", zone.name),
                            remedy: "the cellZones file may come from a different mesh; remove it to read the mesh without zones"
                                .into(),
                        });
                    }
                    zone.cells.push(cell);
                    Ok(())
                })?;
            }
            s.skip_value()?;
        }
        zones.push(zone);
        Ok(())
    })?;
    Ok(zones)
}
