//! Joins the parts of a decomposed case into one mesh.

use std::path::{Path, PathBuf};

use fieldstone_mesh::{MeshParts, Patch, Zone};

use crate::{IoError, Position};

use super::boundary::BoundaryPatch;
use super::poly_mesh::RawMesh;

/// Largest distance of two corners that are the same point, relative to the size of their face: OpenFOAM's
/// own tolerance for matching patches.
const MATCH_TOLERANCE: f64 = 1e-4;

/// Joins parts, each given with the folder it comes from.
pub(super) fn join(parts: Vec<(RawMesh, PathBuf)>) -> Result<RawMesh, IoError> {
    let first_point = starts(parts.iter().map(|(m, _)| m.parts.points.len()));
    let first_cell = starts(parts.iter().map(|(m, _)| m.cells));
    let points: Vec<[f64; 3]> = parts.iter().flat_map(|(m, _)| &m.parts.points).copied().collect();
    for (what, count) in [("points", points.len()), ("cells", first_cell[parts.len()])] {
        if count >= u32::MAX as usize {
            let source = fieldstone_mesh::MeshError::TooLarge { what, count };
            return Err(IoError::Mesh { path: parts[0].1.clone(), source });
        }
    }
    let corners = |part: usize, face: usize| {
        let shift = first_point[part] as u32;
        parts[part].0.parts.face(face).iter().map(move |&p| p + shift)
    };

    let mut whole = MeshParts::default();
    let mut same = SamePoints::new(points.len());
    for (part, (mesh, _)) in parts.iter().enumerate() {
        let shift = first_cell[part] as u32;
        for (face, &neighbour) in mesh.parts.neighbour.iter().enumerate() {
            whole.push_face(corners(part, face), mesh.parts.owner[face] + shift);
            whole.neighbour.push(neighbour + shift);
        }
    }
    for (part, (mesh, _)) in parts.iter().enumerate() {
        for own in mesh.patches.iter().filter(|p| p.patch.kind == "processor") {
            let (other, partner) = partner_of(&parts, part, own)?;
            if other < part {
                continue;
            }
            for k in 0..own.patch.count {
                let (face, face_there) = (own.patch.start + k, partner.start + k);
                let here: Vec<u32> = corners(part, face).collect();
                let there: Vec<u32> = corners(other, face_there).collect();
                let matched = match_corners(&points, &here, &there).ok_or_else(|| {
                    content(
                        &parts[part].1,
                        format!(
                            "face {k} of patch '{}' is not where face {k} of '{}' is in processor{other}",
                            own.patch.name, partner.name
                        ),
                        "the parts may come from different times or decompositions",
                    )
                })?;
                for (a, b) in here.iter().zip(matched) {
                    same.join(*a, b);
                }
                whole.push_face(here, mesh.parts.owner[face] + first_cell[part] as u32);
                whole.neighbour.push(parts[other].0.parts.owner[face_there] + first_cell[other] as u32);
            }
        }
    }

    let patches = join_boundary(&parts, whole.neighbour.len(), |part, face| {
        whole.push_face(corners(part, face), parts[part].0.parts.owner[face] + first_cell[part] as u32);
    });
    let mut zones: Vec<Zone> = Vec::new();
    for (part, (mesh, _)) in parts.iter().enumerate() {
        for zone in &mesh.parts.zones {
            let at = zones.iter().position(|z| z.name == zone.name).unwrap_or_else(|| {
                zones.push(Zone { name: zone.name.clone(), cells: Vec::new() });
                zones.len() - 1
            });
            zones[at].cells.extend(zone.cells.iter().map(|&c| c + first_cell[part] as u32));
        }
    }
    let (points, index) = same.compress(&points);
    for p in &mut whole.face_points {
        *p = index[*p as usize];
    }
    whole.points = points;
    whole.zones = zones;
    Ok(RawMesh { parts: whole, patches, cells: first_cell[parts.len()] })
}

fn content(folder: &Path, found: String, remedy: &str) -> IoError {
    IoError::content(folder.join("boundary"), Position::File, found, remedy)
}

/// Running sums from 0; one entry more than there are counts.
fn starts(counts: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut sums = vec![0];
    let mut sum = 0;
    for n in counts {
        sum += n;
        sums.push(sum);
    }
    sums
}

/// The patch on the other side of a `processor` patch, and the part that has it.
fn partner_of<'a>(
    parts: &'a [(RawMesh, PathBuf)],
    part: usize,
    own: &BoundaryPatch,
) -> Result<(usize, &'a Patch), IoError> {
    let name = &own.patch.name;
    let remedy = "decompose the case again, or copy all of its parts from the same time";
    let Some(other) = own.neighbour_processor.filter(|&n| n < parts.len() && n != part) else {
        let found = match own.neighbour_processor {
            Some(n) => format!("patch '{name}' leads to processor {n}, but there are {} parts", parts.len()),
            None => format!("patch '{name}' does not say which processor it leads to (neighbProcNo)"),
        };
        return Err(content(&parts[part].1, found, remedy));
    };
    let partner = parts[other]
        .0
        .patches
        .iter()
        .find(|p| p.patch.kind == "processor" && p.neighbour_processor == Some(part))
        .ok_or_else(|| {
            content(
                &parts[part].1,
                format!("patch '{name}' leads to processor{other}, which has no patch that leads back"),
                remedy,
            )
        })?;
    if partner.patch.count != own.patch.count {
        let found = format!(
            "patch '{name}' has {} faces, but its other side in processor{other} has {}",
            own.patch.count, partner.patch.count
        );
        return Err(content(&parts[part].1, found, remedy));
    }
    Ok((other, &partner.patch))
}

/// Corners of `there` in the order of `here`: wound the other way round, beginning at the corner that fits.
fn match_corners(points: &[[f64; 3]], here: &[u32], there: &[u32]) -> Option<Vec<u32>> {
    let n = here.len();
    if there.len() != n {
        return None;
    }
    let at = |p: u32| points[p as usize];
    let distance = |a: u32, b: u32| at(a).iter().zip(at(b)).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt();
    let size = here.iter().map(|&p| distance(here[0], p)).fold(0.0, f64::max);
    (0..n)
        .map(|turn| (0..n).map(|k| there[(turn + n - k) % n]).collect::<Vec<_>>())
        .find(|turned| here.iter().zip(turned).all(|(&a, &b)| distance(a, b) <= MATCH_TOLERANCE * size))
}

/// Calls `push` for each face that stays on the boundary, patch by patch; the first of them becomes face `start`.
fn join_boundary(
    parts: &[(RawMesh, PathBuf)],
    mut start: usize,
    mut push: impl FnMut(usize, usize),
) -> Vec<BoundaryPatch> {
    let mut patches: Vec<BoundaryPatch> = Vec::new();
    let mut pieces: Vec<Vec<(usize, usize, usize)>> = Vec::new();
    let mut loose = Vec::new();
    for (part, (mesh, _)) in parts.iter().enumerate() {
        let mut covered = vec![false; mesh.parts.owner.len()];
        for p in &mesh.patches {
            covered[p.patch.start..p.patch.start + p.patch.count].fill(true);
            if p.patch.kind == "processor" {
                continue;
            }
            let name = p.refer_patch.as_ref().unwrap_or(&p.patch.name);
            let at = patches.iter().position(|q| q.patch.name == *name).unwrap_or_else(|| {
                let patch = Patch { name: name.clone(), kind: p.patch.kind.clone(), start: 0, count: 0 };
                patches.push(BoundaryPatch { patch, neighbour_processor: None, refer_patch: None });
                pieces.push(Vec::new());
                patches.len() - 1
            });
            pieces[at].push((part, p.patch.start, p.patch.count));
        }
        let internal = mesh.parts.neighbour.len();
        loose.extend((internal..covered.len()).filter(|&f| !covered[f]).map(|f| (part, f)));
    }
    for (patch, pieces) in patches.iter_mut().zip(pieces) {
        patch.patch.start = start;
        for (part, first, count) in pieces {
            (first..first + count).for_each(|face| push(part, face));
            patch.patch.count += count;
        }
        start += patch.patch.count;
    }
    for (part, face) in loose {
        push(part, face);
    }
    patches
}

/// Points that are one and the same, as a forest of indices.
struct SamePoints(Vec<u32>);

impl SamePoints {
    fn new(points: usize) -> Self {
        Self((0..points as u32).collect())
    }

    fn root(&mut self, mut p: u32) -> u32 {
        while self.0[p as usize] != p {
            let above = self.0[p as usize];
            self.0[p as usize] = self.0[above as usize];
            p = above;
        }
        p
    }

    /// The smaller index becomes the root, so that the result does not depend on the order of calls.
    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }

    /// The points without repetition, and the new index of each old one.
    fn compress(mut self, points: &[[f64; 3]]) -> (Vec<[f64; 3]>, Vec<u32>) {
        let mut kept = Vec::new();
        let mut index = vec![0; points.len()];
        for p in 0..points.len() as u32 {
            let root = self.root(p);
            if root == p {
                index[p as usize] = kept.len() as u32;
                kept.push(points[p as usize]);
            } else {
                index[p as usize] = index[root as usize];
            }
        }
        (kept, index)
    }
}

/// Appending faces one by one.
trait PushFace {
    fn push_face(&mut self, corners: impl IntoIterator<Item = u32>, owner: u32);
}

impl PushFace for MeshParts {
    fn push_face(&mut self, corners: impl IntoIterator<Item = u32>, owner: u32) {
        self.face_points.extend(corners);
        self.face_ends.push(self.face_points.len());
        self.owner.push(owner);
    }
}
