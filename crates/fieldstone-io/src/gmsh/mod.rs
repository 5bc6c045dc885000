//! Gmsh meshes: MSH 2 and 4.1, text and binary.

mod elements;
mod input;
mod v2;
mod v4;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use fieldstone_geometry::CornerOrder;
use fieldstone_mesh::{CellList, Mesh, Zone};

use crate::{IoError, source};

use input::Input;

/// Reads the volume elements of a Gmsh mesh.
///
/// Tetrahedra, hexahedra, prisms and pyramids become cells; points, lines and faces beside them are passed over, and
/// nodes that no cell uses are kept. Physical groups of volumes become zones, called as the file calls them, or
/// `physical_N` where it gives no name. Byte order and width of binary files are those that the file states; sections
/// that do not describe the mesh are passed over.
///
/// # Errors
/// [`IoError`] with line, or byte in binary files: a version other than 2.0–2.2 and 4.1, a damaged section, elements of
/// second or higher order, no volume element at all; [`IoError::Mesh`] where the elements make no valid mesh.
///
/// ```
/// let folder = tempfile::tempdir().unwrap();
/// let file = folder.path().join("one.msh");
/// std::fs::write(&file, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n\
///     $Nodes\n4\n10 0 0 0\n20 1 0 0\n30 0 1 0\n40 0 0 1\n$EndNodes\n\
///     $Elements\n1\n1 4 2 7 1 10 20 30 40\n$EndElements\n").unwrap();
/// let mesh = fieldstone_io::read_gmsh(&file)?;
/// assert_eq!(mesh.cell_count(), 1);
/// assert!((mesh.cell_volumes()[0] - 1.0 / 6.0).abs() < 1e-15);
/// assert_eq!(mesh.parts().zones[0].name, "physical_7");
/// # Ok::<(), fieldstone_io::IoError>(())
/// ```
pub fn read_gmsh(path: &Path) -> Result<Mesh, IoError> {
    let mut input = Input::new(path, source::read_all(path)?);
    let version = read_format(&mut input)?;
    let mut content = Content::default();
    while let Some(section) = input.next_section()? {
        match (section.as_str(), version) {
            ("PhysicalNames", _) => read_physical_names(&mut input, &mut content.names)?,
            ("Nodes", Version::V2) => v2::read_nodes(&mut input, &mut content)?,
            ("Nodes", Version::V4) => v4::read_nodes(&mut input, &mut content)?,
            ("Elements", Version::V2) => v2::read_elements(&mut input, &mut content)?,
            ("Elements", Version::V4) => v4::read_elements(&mut input, &mut content)?,
            ("Entities", Version::V4) => v4::read_entities(&mut input, false, &mut content)?,
            ("PartitionedEntities", Version::V4) => v4::read_entities(&mut input, true, &mut content)?,
            _ => {
                input.skip_section(&section)?;
                continue;
            }
        }
        input.end_section(&section)?;
    }
    if content.cells.is_empty() {
        return Err(input.error(
            "the file has no tetrahedron, hexahedron, prism or pyramid",
            "mesh in three dimensions (gmsh -3), and save the volumes: put them in a physical group or set Mesh.SaveAll=1",
        ));
    }
    let zones = content.zones();
    let mesh = Mesh::from_cells(content.points, content.cells)
        .map_err(|source| IoError::Mesh { path: path.into(), source })?;
    Ok(mesh.with_zones(zones))
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Version {
    V2,
    V4,
}

/// What has been read so far.
#[derive(Debug, Default)]
struct Content {
    points: Vec<[f64; 3]>,
    /// Node tag to index in `points`.
    nodes: HashMap<i64, u32>,
    cells: CellList,
    /// Physical groups of each volume entity (4.1).
    groups_of_entity: HashMap<i64, Vec<i64>>,
    /// Cells of each physical group of volumes.
    groups: BTreeMap<i64, Vec<u32>>,
    /// Names of the physical groups of volumes.
    names: HashMap<i64, String>,
}

impl Content {
    fn add_node(&mut self, input: &Input, tag: i64, at: [f64; 3]) -> Result<(), IoError> {
        if at.iter().any(|x| !x.is_finite()) {
            return Err(input.error(
                format!("node {tag} is at ({} {} {})", at[0], at[1], at[2]),
                "coordinates must be finite numbers: mesh again",
            ));
        }
        if self.points.len() >= u32::MAX as usize - 1 {
            let source = fieldstone_mesh::MeshError::TooLarge { what: "nodes", count: self.points.len() + 1 };
            return Err(IoError::Mesh { path: input.path().into(), source });
        }
        if self.nodes.insert(tag, self.points.len() as u32).is_some() {
            return Err(input.error(
                format!("node {tag} is listed twice"),
                "node numbers must be unique: save the mesh again, after Mesh > Renumber where files were merged",
            ));
        }
        self.points.push(at);
        Ok(())
    }

    /// Adds a volume element; `tags` are its node tags in Gmsh's order, which is that of CGNS.
    fn add_cell(
        &mut self,
        input: &Input,
        kind: fieldstone_geometry::ElementKind,
        element: i64,
        tags: &[i64],
    ) -> Result<(), IoError> {
        let mut corners = [0; 8];
        for (corner, tag) in corners.iter_mut().zip(tags) {
            *corner = *self.nodes.get(tag).ok_or_else(|| {
                input.error(
                    format!("element {element} names node {tag}, which is not among the {} nodes", self.points.len()),
                    "the file is damaged, or its $Nodes section stands behind $Elements; save the mesh again",
                )
            })?;
        }
        self.cells
            .push(kind, CornerOrder::Cgns, &corners[..tags.len()])
            .map_err(|source| IoError::Mesh { path: input.path().into(), source })
    }

    fn zones(&mut self) -> Vec<Zone> {
        let names = &self.names;
        let name = |tag| names.get(&tag).cloned().unwrap_or_else(|| format!("physical_{tag}"));
        std::mem::take(&mut self.groups).into_iter().map(|(tag, cells)| Zone { name: name(tag), cells }).collect()
    }
}

/// Reads `$MeshFormat`, which must come before all but comments, and sets number widths and byte order.
fn read_format(input: &mut Input) -> Result<Version, IoError> {
    let mut section = input.next_section()?;
    while section.as_deref() == Some("Comments") {
        input.skip_section("Comments")?;
        section = input.next_section()?;
    }
    if section.as_deref() != Some("MeshFormat") {
        return Err(input.error_at(
            0,
            "the file does not begin with $MeshFormat",
            "give a mesh that Gmsh saved as 'Version 4 ASCII/Binary' or 'Version 2 ASCII/Binary'",
        ));
    }
    let start = input.start();
    let (number, binary, width) = (input.real()?, input.integer()?, input.integer()?);
    let version = if (2.0..3.0).contains(&number) {
        Version::V2
    } else if number == 4.1 {
        Version::V4
    } else {
        return Err(input.error_at(
            start,
            format!("the mesh is stored in version {number}"),
            "versions 2.0 to 2.2 and 4.1 can be read: save it with gmsh -save -format msh41",
        ));
    };
    let widths: &[i64] = if version == Version::V2 { &[8] } else { &[4, 8] };
    if !widths.contains(&width) || !(0..=1).contains(&binary) {
        return Err(input.error_at(
            start,
            format!("the format line says file type {binary} and data size {width}"),
            "the file type must be 0 (text) or 1 (binary), and the data size that of a double, 8",
        ));
    }
    if binary == 1 {
        input.start_binary(width as usize)?;
    }
    input.end_section("MeshFormat")?;
    Ok(version)
}

/// `$PhysicalNames`, which is text in binary files too.
fn read_physical_names(input: &mut Input, names: &mut HashMap<i64, String>) -> Result<(), IoError> {
    let binary = input.set_text();
    let count = input.count("physical names")?;
    for _ in 0..count {
        let (dimension, tag) = (input.integer()?, input.integer()?);
        let name = input.quoted()?;
        if dimension == 3 {
            names.insert(tag, name);
        }
    }
    input.restore(binary);
    Ok(())
}
