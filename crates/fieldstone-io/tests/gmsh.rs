//! Gmsh meshes: real ones in every version and encoding, and broken ones.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fs;

use fieldstone_geometry::ElementKind;
use fieldstone_io::read_gmsh;
use fieldstone_mesh::Mesh;
use fieldstone_testing::{data, extended};

fn kinds(mesh: &Mesh) -> BTreeMap<ElementKind, usize> {
    let mut count = BTreeMap::new();
    (0..mesh.cell_count()).for_each(|c| *count.entry(mesh.cell_kind(c)).or_default() += 1);
    count
}

fn zones(mesh: &Mesh) -> Vec<(&str, usize)> {
    mesh.parts().zones.iter().map(|z| (z.name.as_str(), z.cells.len())).collect()
}

#[test]
fn the_vessel_is_the_same_mesh_in_all_its_files() {
    let mut first: Option<Mesh> = None;
    for name in ["vessel_v22.msh", "vessel_v41.msh", "vessel_v41_bin.msh"] {
        let Some(path) = extended(&format!("gmsh/{name}")) else { return };
        let mesh = read_gmsh(&path).unwrap();
        let expected = [(ElementKind::Tetrahedron, 7126), (ElementKind::Wedge, 3840)];
        assert_eq!(kinds(&mesh), BTreeMap::from(expected), "{name}");
        assert_eq!(zones(&mesh), [("core", 7126), ("boundary_layer", 3840)], "{name}");
        assert_eq!(mesh.parts().points.len(), 3661, "{name}");
        assert_eq!(mesh.parts().neighbour.len(), 22843, "{name}");
        if let Some(first) = &first {
            assert_eq!(mesh.parts().owner, first.parts().owner, "{name}");
            for (a, b) in mesh.cell_volumes().iter().zip(first.cell_volumes()) {
                assert!((a - b).abs() < 1e-12 * b.abs(), "{name}: {a} {b}");
            }
        }
        first.get_or_insert(mesh);
    }
}

#[test]
fn the_vessel_has_the_volumes_that_openfoam_gets_from_it() {
    let (Some(msh), Some(case)) = (extended("gmsh/vessel_v41.msh"), extended("openfoam/gmfoam")) else { return };
    let (gmsh, foam) = (read_gmsh(&msh).unwrap(), fieldstone_io::openfoam::read_poly_mesh(&case).unwrap());
    assert_eq!(gmsh.cell_count(), foam.cell_count());
    let sum = |m: &Mesh| m.cell_volumes().iter().sum::<f64>();
    assert!((sum(&gmsh) / sum(&foam) - 1.0).abs() < 1e-12);
}

#[test]
fn prisms_and_hexahedra_beside_lines_and_triangles_are_read_from_every_version() {
    let mut read = 0;
    for name in ["v22", "v22_bin", "v41", "v41_bin", "v41_all", "v41_parametric", "v41_partitioned"] {
        let mesh = read_gmsh(&data(&format!("gmsh/box_{name}.msh"))).unwrap_or_else(|e| panic!("{name}: {e}"));
        let expected = [(ElementKind::Wedge, 28), (ElementKind::Hexahedron, 8)];
        assert_eq!(kinds(&mesh), BTreeMap::from(expected), "{name}");
        let volume: f64 = mesh.cell_volumes().iter().sum();
        assert!((volume - 2.0).abs() < 1e-9, "{name}: {volume}");
        // Physical groups in the order of their numbers, 2, 4 and 9; they share cells.
        assert_eq!(zones(&mesh), [("all cells", 36), ("prisms", 28), ("hexahedra", 8)], "{name}");
        for zone in &mesh.parts().zones[1..] {
            let kind = if zone.name == "prisms" { ElementKind::Wedge } else { ElementKind::Hexahedron };
            assert!(zone.cells.iter().all(|&c| mesh.cell_kind(c as usize) == kind), "{name}");
        }
        assert_eq!((mesh.inverted_elements(), mesh.inverted_cells().len()), (0, 0), "{name}");
        read += 1;
    }
    assert_eq!(read, 7);
}

#[test]
fn elements_of_second_order_are_refused_with_the_remedy() {
    let e = read_gmsh(&data("gmsh/box_v41_order2.msh")).unwrap_err().to_string();
    assert!(e.contains("hexahedra with 27 nodes (type 12)") || e.contains("prisms with 18 nodes (type 13)"), "{e}");
    assert!(e.contains("Mesh.ElementOrder=1"), "{e}");
}

/// Each number of a little-endian file turned round; `widths` lists the bytes of each number in turn.
fn turned(bytes: &[u8], widths: &[usize]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut at = 0;
    for &w in widths {
        out.extend(bytes[at..at + w].iter().rev());
        at += w;
    }
    assert_eq!(at, bytes.len());
    out
}

#[test]
fn a_big_endian_file_is_read_like_a_little_endian_one() {
    let mut nodes = Vec::new();
    for (tag, at) in [(3_i32, [0.0_f64; 3]), (5, [1.0, 0.0, 0.0]), (70, [0.0, 1.0, 0.0]), (900, [0.0, 0.0, 1.0])] {
        nodes.extend(tag.to_le_bytes());
        at.iter().for_each(|x| nodes.extend(x.to_le_bytes()));
    }
    let elements: Vec<u8> =
        [15, 1, 2, 1, 0, 1, 3, 4, 1, 2, 2, 6, 1, 3, 5, 70, 900].iter().flat_map(|v: &i32| v.to_le_bytes()).collect();
    for big in [false, true] {
        let turn = |bytes: &[u8], widths: &[usize]| if big { turned(bytes, widths) } else { bytes.to_vec() };
        let mut file = b"$MeshFormat\n2.2 1 8\n".to_vec();
        file.extend(turn(&1_i32.to_le_bytes(), &[4]));
        file.extend(b"\n$EndMeshFormat\n$Nodes\n4\n");
        file.extend(turn(&nodes, &[4, 8, 8, 8].repeat(4)));
        file.extend(b"\n$EndNodes\n$Elements\n2\n");
        file.extend(turn(&elements, &[4; 17]));
        file.extend(b"\n$EndElements\n");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.msh");
        fs::write(&path, file).unwrap();
        let mesh = read_gmsh(&path).unwrap();
        assert!((mesh.cell_volumes()[0] - 1.0 / 6.0).abs() < 1e-15);
        assert_eq!(zones(&mesh), [("physical_6", 1)]);
    }
}

fn text(content: &str) -> Result<Mesh, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.msh");
    fs::write(&path, content).unwrap();
    read_gmsh(&path).map_err(|e| e.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

const FORMAT: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const NODES: &str = "$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 1 1 0\n40 0 1 0\n55 0.5 0.5 1\n7 9 9 9\n$EndNodes\n";

#[test]
fn orphan_nodes_are_kept_node_numbers_may_have_gaps_and_unknown_sections_are_passed_over() {
    let mesh = text(&format!(
        "$Comments\nby hand\n$EndComments\n{FORMAT}$Comments\n$Nodes is not here\n$EndComments\n{NODES}\
         $Elements\n3\n8 15 2 0 1 7\n9 2 2 0 1 1 2 3\n11 7 2 0 1 1 2 3 40 55\n$EndElements\n\
         $NodeData\n1\n\"T\"\n$EndNodeData\n"
    ))
    .unwrap();
    assert_eq!(mesh.parts().points.len(), 6);
    assert_eq!(kinds(&mesh), BTreeMap::from([(ElementKind::Pyramid, 1)]));
    assert!((mesh.cell_volumes()[0] - 1.0 / 3.0).abs() < 1e-15);
    assert!(mesh.parts().zones.is_empty());
}

#[test]
fn broken_files_say_where_and_what() {
    let cell = |line: &str| format!("{FORMAT}{NODES}$Elements\n1\n{line}\n$EndElements\n");
    let refusal = |content: &str| text(content).unwrap_err();
    let e = refusal(&cell("1 4 2 0 1 1 2 3 99"));
    assert!(e.starts_with("a.msh:15: element 1 names node 99, which is not among the 6 nodes\n"), "{e}");
    let e = refusal(&cell("1 4 2 0 1 1 2 3"));
    assert!(e.starts_with("a.msh:16: expected a whole number, found '$EndElements'"), "{e}");
    let e = refusal(&cell("1 11 2 0 1 1 2 3 40 55 7 1 2 3 40"));
    assert!(e.starts_with("a.msh:15: the mesh has tetrahedra with 10 nodes (type 11)"), "{e}");
    let e = refusal(&cell("1 2 2 0 1 1 2 3"));
    assert!(e.contains("no tetrahedron, hexahedron, prism or pyramid"), "{e}");
    let e = refusal(&format!("{FORMAT}$Nodes\n2\n1 0 0 0\n1 1 1 1\n$EndNodes\n"));
    assert!(e.starts_with("a.msh:7: node 1 is listed twice"), "{e}");
    let e = refusal(&format!("{FORMAT}$Nodes\n1\n1 0 nan 0\n$EndNodes\n"));
    assert!(e.starts_with("a.msh:6: node 1 is at (0 NaN 0)"), "{e}");
    let e = refusal(&format!("{FORMAT}$Nodes\n9000000000\n1 0 0 0\n$EndNodes\n"));
    assert!(e.starts_with("a.msh:5: the file announces 9000000000 nodes, but"), "{e}");
    let e = refusal(&format!("{FORMAT}$Nodes\n1\n1 0 0 0\n2 0 0 1\n$EndNodes\n"));
    assert!(e.contains("expected $EndNodes behind the entries that the section announces, found '2'"), "{e}");
    let e = refusal(&format!("{FORMAT}$Comments\nno end"));
    assert!(e.contains("section $Comments has no $EndComments"), "{e}");
    let e = refusal(
        "solid wall
",
    );
    assert!(e.starts_with("a.msh:1: expected the start of a section, '$Name', found 'solid'"), "{e}");
    let e = refusal("$MeshFormat\n4 0 8\n$EndMeshFormat\n");
    assert!(e.starts_with("a.msh:2: the mesh is stored in version 4\n") && e.contains("-format msh41"), "{e}");
    let e = refusal("$MeshFormat\n4.1 1 8\n\n$EndMeshFormat\n");
    assert!(e.contains("the number 1 that tells the byte order"), "{e}");
    let e = refusal("");
    assert!(e.starts_with("a.msh:1: the file does not begin with $MeshFormat\n"), "{e}");
}
