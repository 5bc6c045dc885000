//! OpenFOAM meshes: real ones, the same ones stored in other ways, and broken ones.

#![allow(clippy::unwrap_used)]

use std::collections::HashMap;
use std::fs;
use std::io::Write;
use std::path::Path;

use fieldstone_geometry::ElementKind;
use fieldstone_io::openfoam::{has_case_order, is_same_mesh, mesh_of_time, read_poly_mesh};
use fieldstone_mesh::{Mesh, MeshParts};
use fieldstone_testing::{data, extended, read_text};

/// Counts in the `note` entry of a file's header: `nPoints:6825  nCells:6144 …`.
fn noted_counts(owner: &Path) -> HashMap<String, usize> {
    let text = String::from_utf8_lossy(&fs::read(owner).unwrap()).into_owned();
    let note = text.lines().find_map(|l| l.trim().strip_prefix("note")).expect("owner has a note");
    note.trim_matches(|c: char| c.is_whitespace() || c == '"' || c == ';')
        .split_whitespace()
        .map(|entry| entry.split_once(':').unwrap())
        .map(|(name, count)| (name.to_owned(), count.parse().unwrap()))
        .collect()
}

fn assert_same_bits(a: &MeshParts, b: &MeshParts) {
    let bits = |m: &MeshParts| m.points.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(a), bits(b));
    assert_same_topology(a, b);
}

fn assert_same_topology(a: &MeshParts, b: &MeshParts) {
    assert_eq!(a.face_ends, b.face_ends);
    assert_eq!(a.face_points, b.face_points);
    assert_eq!(a.owner, b.owner);
    assert_eq!(a.neighbour, b.neighbour);
    assert_eq!(a.patches, b.patches);
    assert_eq!(a.zones, b.zones);
}

#[test]
fn real_meshes_have_the_counts_that_their_headers_note() {
    for name in ["bed_ogrid", "bed_twist", "bed_twist_bin", "gmfoam"] {
        let Some(case) = extended(&format!("openfoam/{name}")) else { return };
        let mesh = read_poly_mesh(&case).unwrap();
        let noted = noted_counts(&case.join("constant/polyMesh/owner"));
        assert_eq!(mesh.parts().points.len(), noted["nPoints"], "{name}");
        assert_eq!(mesh.cell_count(), noted["nCells"], "{name}");
        assert_eq!(mesh.parts().owner.len(), noted["nFaces"], "{name}");
        assert_eq!(mesh.parts().neighbour.len(), noted["nInternalFaces"], "{name}");
        let on_patches: usize = mesh.parts().patches.iter().map(|p| p.count).sum();
        assert_eq!(on_patches, noted["nFaces"] - noted["nInternalFaces"], "{name}");
        assert!(mesh.inverted_cells().is_empty(), "{name}");
    }
}

#[test]
fn the_binary_mesh_is_the_text_mesh_up_to_the_digits_written() {
    let (Some(text), Some(binary)) = (extended("openfoam/bed_twist"), extended("openfoam/bed_twist_bin")) else {
        return;
    };
    let (text, binary) = (read_poly_mesh(&text).unwrap(), read_poly_mesh(&binary).unwrap());
    assert_same_topology(text.parts(), binary.parts());
    for (a, b) in text.parts().points.iter().flatten().zip(binary.parts().points.iter().flatten()) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

#[test]
fn every_folder_and_file_of_a_case_leads_to_its_mesh() {
    let case = data("openfoam/decomposed/whole");
    let expected = read_poly_mesh(&case).unwrap();
    for below in ["constant", "constant/polyMesh", "constant/polyMesh/faces"] {
        assert_same_bits(read_poly_mesh(&case.join(below)).unwrap().parts(), expected.parts());
    }
    let patch = &expected.parts().patches[1];
    assert_eq!((patch.name.as_str(), patch.kind.as_str(), patch.start, patch.count), ("sides", "wall", 24, 12));
    assert_eq!(expected.parts().zones[0].name, "left");
    assert_eq!(expected.parts().zones[0].cells, (0..12).collect::<Vec<u32>>());
}

#[test]
fn a_gzipped_mesh_is_read_and_cell_zones_may_be_missing() {
    let case = data("bed_twist");
    let mesh = read_poly_mesh(&case).unwrap();
    assert_eq!(mesh.cell_count(), 6144);
    assert!(mesh.parts().zones.is_empty());
    let volume: f64 = mesh.cell_volumes().iter().sum();
    assert!(volume > 1e-3 && volume < 2e-3, "{volume}");
}

#[test]
fn a_mesh_with_hanging_nodes_has_the_cells_and_the_volume_that_check_mesh_reports() {
    let mesh = read_poly_mesh(&data("openfoam/refined")).unwrap();
    assert_eq!((mesh.parts().points.len(), mesh.cell_count()), (55, 19));
    let polyhedra = (0..19).filter(|&c| mesh.cell_kind(c) == ElementKind::Polyhedron).count();
    assert_eq!(polyhedra, 6);
    let volume: f64 = mesh.cell_volumes().iter().sum();
    assert!((volume - 1.05).abs() < 1e-14, "{volume}");
}

#[test]
fn a_compressed_file_that_is_cut_off_is_refused() {
    let case = tempfile::tempdir().unwrap();
    copy(&data("openfoam/refined"), case.path());
    let faces = case.path().join("constant/polyMesh/faces.gz");
    let bytes = fs::read(&faces).unwrap();
    fs::write(&faces, &bytes[..bytes.len() / 2]).unwrap();
    let e = read_poly_mesh(case.path()).unwrap_err().to_string();
    assert!(e.contains("faces.gz: cannot read"), "{e}");
}

#[test]
fn zones_hold_the_cells_that_gmsh_put_there() {
    let Some(case) = extended("openfoam/gmfoam") else { return };
    let mesh = read_poly_mesh(&case).unwrap();
    let zones = &mesh.parts().zones;
    assert_eq!(
        zones.iter().map(|z| (z.name.as_str(), z.cells.len())).collect::<Vec<_>>(),
        [("core", 7126), ("boundary_layer", 3840)]
    );
    let text = read_text(&case.join("constant/polyMesh/cellZones"));
    let last = text.lines().rev().find_map(|l| l.trim().parse::<u32>().ok()).unwrap();
    assert_eq!(zones[1].cells.last(), Some(&last));
}

// ---- The same mesh stored in other ways ----

#[derive(Clone, Copy)]
struct Style {
    binary: bool,
    big_endian: bool,
    label: usize,
    compact: bool,
    gzip: bool,
}

const TEXT: Style = Style { binary: false, big_endian: false, label: 4, compact: false, gzip: false };

struct Encoder {
    style: Style,
    out: Vec<u8>,
}

impl Encoder {
    fn new(style: Style, class: &str) -> Self {
        let (format, order) =
            (if style.binary { "binary" } else { "ascii" }, if style.big_endian { "MSB" } else { "LSB" });
        let arch = format!("{order};label={};scalar=64", 8 * style.label);
        let head = format!("FoamFile\n{{\n format {format};\n arch \"{arch}\";\n class {class};\n}}\n// * * //\n\n");
        Self { style, out: head.into_bytes() }
    }

    fn raw(&mut self, mut little_endian: Vec<u8>) {
        if self.style.big_endian {
            little_endian.reverse();
        }
        self.out.extend(little_endian);
    }

    fn labels(&mut self, labels: impl ExactSizeIterator<Item = i64>) {
        write!(self.out, "{}\n(", labels.len()).unwrap();
        for v in labels {
            if self.style.binary {
                self.raw(v.to_le_bytes()[..self.style.label].to_vec());
            } else {
                writeln!(self.out, "{v}").unwrap();
            }
        }
        self.out.extend(b")\n");
    }

    fn points(&mut self, points: &[[f64; 3]]) {
        write!(self.out, "{}\n(", points.len()).unwrap();
        for p in points {
            if self.style.binary {
                p.iter().for_each(|x| self.raw(x.to_le_bytes().to_vec()));
            } else {
                writeln!(self.out, "({:?} {:?} {:?})", p[0], p[1], p[2]).unwrap();
            }
        }
        self.out.extend(b")\n");
    }

    fn store(self, folder: &Path, name: &str) {
        if self.style.gzip {
            let file = fs::File::create(folder.join(format!("{name}.gz"))).unwrap();
            let mut gz = flate2::write::GzEncoder::new(file, flate2::Compression::fast());
            gz.write_all(&self.out).unwrap();
            gz.finish().unwrap();
        } else {
            fs::write(folder.join(name), self.out).unwrap();
        }
    }
}

fn store(mesh: &MeshParts, folder: &Path, style: Style) {
    let mut e = Encoder::new(style, "vectorField");
    e.points(&mesh.points);
    e.store(folder, "points");
    let mut e = Encoder::new(style, if style.compact { "faceCompactList" } else { "faceList" });
    if style.compact {
        let offsets: Vec<i64> = [0].into_iter().chain(mesh.face_ends.iter().map(|&n| n as i64)).collect();
        e.labels(offsets.into_iter());
        e.labels(mesh.face_points.iter().map(|&p| p.into()));
    } else {
        writeln!(e.out, "{}\n(", mesh.owner.len()).unwrap();
        for f in 0..mesh.owner.len() {
            e.labels(mesh.face(f).iter().map(|&p| p.into()));
        }
        e.out.extend(b")\n");
    }
    e.store(folder, "faces");
    for (name, list) in [("owner", &mesh.owner), ("neighbour", &mesh.neighbour)] {
        let mut e = Encoder::new(style, "labelList");
        e.labels(list.iter().map(|&c| c.into()));
        e.store(folder, name);
    }
    let mut e = Encoder::new(style, "polyBoundaryMesh");
    writeln!(e.out, "{}\n(", mesh.patches.len()).unwrap();
    for p in &mesh.patches {
        let text = format!("{} {{ type {}; nFaces {}; startFace {}; }}", p.name, p.kind, p.count, p.start);
        writeln!(e.out, "{text}").unwrap();
    }
    e.out.extend(b")\n");
    e.store(folder, "boundary");
    let mut e = Encoder::new(style, "regIOobject");
    writeln!(e.out, "{}\n(", mesh.zones.len()).unwrap();
    for z in &mesh.zones {
        write!(e.out, "{}\n{{\n type cellZone;\ncellLabels List<label> ", z.name).unwrap();
        e.labels(z.cells.iter().map(|&c| c.into()));
        e.out.extend(b";\n}\n");
    }
    e.out.extend(b")\n");
    e.store(folder, "cellZones");
}

#[test]
fn the_same_mesh_in_every_encoding_is_read_with_the_same_bits() {
    let mut sources = vec![data("openfoam/decomposed/whole"), data("bed_twist")];
    sources.extend(extended("openfoam/gmfoam"));
    for source in sources {
        let mesh = read_poly_mesh(&source).unwrap();
        let mut styles = 0;
        for binary in [false, true] {
            for (big_endian, label) in [(false, 4), (false, 8), (true, 4), (true, 8)] {
                for (compact, gzip) in [(false, false), (true, false), (true, true)] {
                    if !binary && (big_endian || label == 8) {
                        continue;
                    }
                    let folder = tempfile::tempdir().unwrap();
                    store(mesh.parts(), folder.path(), Style { binary, big_endian, label, compact, gzip });
                    let again = read_poly_mesh(folder.path()).unwrap();
                    assert_same_bits(again.parts(), mesh.parts());
                    styles += 1;
                }
            }
        }
        assert_eq!(styles, 15);
    }
}

#[test]
fn neighbours_of_minus_one_mark_the_boundary() {
    let mesh = read_poly_mesh(&data("openfoam/decomposed/whole")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    store(mesh.parts(), folder.path(), TEXT);
    let mut e = Encoder::new(TEXT, "labelList");
    let boundary = mesh.parts().owner.len() - mesh.parts().neighbour.len();
    let full: Vec<i64> =
        mesh.parts().neighbour.iter().map(|&c| c.into()).chain(std::iter::repeat_n(-1, boundary)).collect();
    e.labels(full.into_iter());
    e.store(folder.path(), "neighbour");
    assert_same_bits(read_poly_mesh(folder.path()).unwrap().parts(), mesh.parts());
}

#[test]
fn internal_faces_behind_the_boundary_are_brought_to_the_front_and_patches_follow() {
    let mesh = read_poly_mesh(&data("openfoam/decomposed/whole")).unwrap();
    let (p, folder) = (mesh.parts(), tempfile::tempdir().unwrap());
    let internal = p.neighbour.len();
    let order: Vec<usize> = (internal..p.owner.len()).chain(0..internal).collect();
    let mut turned = MeshParts { points: p.points.clone(), zones: p.zones.clone(), ..MeshParts::default() };
    for &f in &order {
        turned.face_points.extend_from_slice(p.face(f));
        turned.face_ends.push(turned.face_points.len());
        turned.owner.push(p.owner[f]);
    }
    turned.patches = p.patches.clone();
    turned.patches.iter_mut().for_each(|q| q.start -= internal);
    store(&turned, folder.path(), TEXT);
    let mut e = Encoder::new(TEXT, "labelList");
    let full: Vec<i64> = order.iter().map(|&f| p.neighbour.get(f).map_or(-1, |&c| c.into())).collect();
    e.labels(full.into_iter());
    e.store(folder.path(), "neighbour");
    assert_same_bits(read_poly_mesh(folder.path()).unwrap().parts(), p);
}

#[test]
fn a_time_folder_with_points_only_takes_its_faces_from_constant() {
    let source = data("openfoam/decomposed/whole");
    let mesh = read_poly_mesh(&source).unwrap();
    let case = tempfile::tempdir().unwrap();
    for folder in ["constant/polyMesh", "0.5/polyMesh", "2/polyMesh"] {
        fs::create_dir_all(case.path().join(folder)).unwrap();
    }
    store(mesh.parts(), &case.path().join("constant/polyMesh"), TEXT);
    let mut moved = mesh.parts().clone();
    moved.points.iter_mut().for_each(|p| p[2] *= 2.0);
    let mut e = Encoder::new(TEXT, "vectorField");
    e.points(&moved.points);
    e.store(&case.path().join("0.5/polyMesh"), "points");
    assert_same_bits(read_poly_mesh(&case.path().join("0.5")).unwrap().parts(), &moved);
    assert_same_bits(read_poly_mesh(case.path()).unwrap().parts(), mesh.parts());
}

// ---- Decomposed cases ----

fn cells_by_centre(mesh: &Mesh) -> Vec<([i64; 3], f64)> {
    let mut cells: Vec<([i64; 3], f64)> = (0..mesh.cell_count())
        .map(|c| {
            let (low, high) = mesh.cell_bounds(c);
            let key = std::array::from_fn(|k| ((low[k] + high[k]) * 1e6).round() as i64);
            (key, mesh.cell_volumes()[c])
        })
        .collect();
    cells.sort_by_key(|c| c.0);
    cells
}

#[test]
fn a_decomposed_case_is_joined_into_the_mesh_that_it_was_cut_from() {
    let case = data("openfoam/decomposed");
    let (whole, joined) = (read_poly_mesh(&case.join("whole")).unwrap(), read_poly_mesh(&case).unwrap());
    let (w, j) = (whole.parts(), joined.parts());
    assert_eq!(j.points.len(), w.points.len());
    assert_eq!(j.owner.len(), w.owner.len());
    assert_eq!(j.neighbour.len(), w.neighbour.len());
    let patches = |m: &MeshParts| {
        m.patches.iter().map(|p| (p.name.clone(), p.kind.clone(), p.start, p.count)).collect::<Vec<_>>()
    };
    assert_eq!(patches(j), patches(w));
    assert_eq!(j.zones[0].name, "left");
    assert_eq!(j.zones[0].cells.len(), 12);
    for (a, b) in cells_by_centre(&joined).iter().zip(cells_by_centre(&whole)) {
        assert_eq!(a.0, b.0);
        assert!((a.1 - b.1).abs() < 1e-15);
    }
    // Without the list of its cells' numbers in one of the parts, cells follow the processors.
    let copied = tempfile::tempdir().unwrap();
    copy(&case, copied.path());
    assert!(has_case_order(copied.path()).unwrap());
    fs::remove_file(copied.path().join("processor1/constant/polyMesh/cellProcAddressing")).unwrap();
    assert!(!has_case_order(copied.path()).unwrap());
    let joined = read_poly_mesh(copied.path()).unwrap();
    let part: Vec<usize> = (0..4)
        .flat_map(|p| {
            let text = read_text(&case.join(format!("processor{p}/constant/polyMesh/cellProcAddressing")));
            let list = text.rsplit_once(')').unwrap().0.rsplit_once('(').unwrap().1.to_owned();
            list.split_whitespace().map(|c| c.parse().unwrap()).collect::<Vec<usize>>()
        })
        .collect();
    assert_eq!(part.len(), 12);
    for (cell, &original) in part.iter().enumerate() {
        assert_eq!(joined.cell_bounds(cell), whole.cell_bounds(original));
    }
}

#[test]
fn cells_of_a_decomposed_case_are_in_the_order_of_the_case_that_it_was_cut_from() {
    let case = data("openfoam/decomposed");
    let (whole, joined) = (read_poly_mesh(&case.join("whole")).unwrap(), read_poly_mesh(&case).unwrap());
    for cell in 0..12 {
        assert_eq!(joined.cell_bounds(cell), whole.cell_bounds(cell), "cell {cell}");
    }
    // Zones too, and faces point from the smaller number to the larger.
    assert_eq!(joined.parts().zones, whole.parts().zones);
    let j = joined.parts();
    assert!(j.owner.iter().zip(&j.neighbour).all(|(owner, neighbour)| owner < neighbour));
    assert!(joined.inverted_cells().is_empty());
}

#[test]
fn the_mesh_of_a_time_is_the_latest_that_moved_up_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let case = folder.path();
    assert_eq!(mesh_of_time(&case.join("1")), None);
    copy(&data("openfoam/decomposed/whole"), case);
    fs::create_dir_all(case.join("0.5/polyMesh")).unwrap();
    fs::copy(case.join("constant/polyMesh/points"), case.join("0.5/polyMesh/points")).unwrap();
    assert_eq!(mesh_of_time(&case.join("0")), Some(case.into()));
    for time in ["0.5", "0.50", "10"] {
        assert_eq!(mesh_of_time(&case.join(time)), Some(case.join("0.5")));
    }
    assert!(is_same_mesh(case, &case.join("constant/polyMesh/faces")));
    // The points are other ones.
    assert!(!is_same_mesh(case, &case.join("0.5")));
    // A file beside the case's folders is no part of it.
    fs::write(case.join("other.msh"), "").unwrap();
    assert!(!is_same_mesh(case, &case.join("other.msh")));
}

#[test]
fn numbers_of_cells_that_do_not_fit_the_parts_are_refused() {
    let case = tempfile::tempdir().unwrap();
    copy(&data("openfoam/decomposed"), case.path());
    let file = case.path().join("processor1/constant/polyMesh/cellProcAddressing");
    let plain = fs::read_to_string(&file).unwrap();
    let refused = |list: &str| {
        fs::write(&file, plain.replace("3(2 4 5)", list)).unwrap();
        read_poly_mesh(case.path()).unwrap_err().to_string()
    };
    for (list, found) in [
        ("3(2 4 12)", "cell 2 is cell 12 of the whole case, but the parts have 12 cells"),
        ("3(2 4 3)", "cell 2 is cell 3 of the whole case, which another cell is already"),
        ("2(2 4)", "cellProcAddressing has 2 entries, but this part has 3 cells"),
    ] {
        let e = refused(list);
        assert!(e.contains("processor1") && e.contains(found) && e.contains("remove the file"), "{e}");
    }
}

#[test]
fn the_regions_of_a_case_are_named_where_it_has_no_mesh_of_its_own() {
    let case = tempfile::tempdir().unwrap();
    for region in ["air", "steel"] {
        copy(&data("openfoam/decomposed/whole/constant"), &case.path().join("constant").join(region));
    }
    let e = read_poly_mesh(case.path()).unwrap_err().to_string();
    assert!(e.contains("constant/air, ") && e.contains("constant/steel"), "{e}");
    assert_eq!(read_poly_mesh(&case.path().join("constant/air")).unwrap().cell_count(), 12);
}

#[test]
fn one_part_of_a_decomposed_case_keeps_its_processor_patches() {
    let mesh = read_poly_mesh(&data("openfoam/decomposed/processor1")).unwrap();
    assert_eq!(mesh.cell_count(), 3);
    assert!(mesh.parts().patches.iter().any(|p| p.kind == "processor" && p.name == "procBoundary1to0"));
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::write(target, fs::read(entry.path()).unwrap()).unwrap();
        }
    }
}

#[test]
fn a_missing_part_of_a_decomposed_case_is_named() {
    let case = tempfile::tempdir().unwrap();
    copy(&data("openfoam/decomposed"), case.path());
    fs::remove_dir_all(case.path().join("processor1")).unwrap();
    let e = read_poly_mesh(case.path()).unwrap_err().to_string();
    assert!(e.contains("processor1: this part of the decomposed case has no mesh"), "{e}");
}

#[test]
fn parts_that_do_not_touch_where_their_patches_say_are_refused() {
    let case = tempfile::tempdir().unwrap();
    copy(&data("openfoam/decomposed"), case.path());
    let points = case.path().join("processor1/constant/polyMesh/points");
    let text = fs::read_to_string(&points).unwrap().replace(" 0.5 ", " 0.55 ");
    fs::write(&points, text).unwrap();
    let e = read_poly_mesh(case.path()).unwrap_err().to_string();
    assert!(e.contains("of patch 'procBoundary") && e.contains("processor1"), "{e}");
}

#[test]
fn the_collated_format_is_refused_with_the_way_out() {
    let case = tempfile::tempdir().unwrap();
    fs::create_dir_all(case.path().join("processors4/constant")).unwrap();
    let e = read_poly_mesh(case.path()).unwrap_err().to_string();
    assert!(e.contains("collated") && e.contains("reconstructParMesh"), "{e}");
}

// ---- Broken meshes ----

const HEAD: &str = "FoamFile { version 2.0; format ascii; class x; }\n";

/// A unit tetrahedron.
const TETRAHEDRON: [(&str, &str); 5] = [
    ("points", "4\n(\n(0 0 0)\n(1 0 0)\n(0 1 0)\n(0 0 1)\n)\n"),
    ("faces", "4\n(\n3(2 1 0)\n3(0 1 3)\n3(1 2 3)\n3(2 0 3)\n)\n"),
    ("owner", "4{0}\n"),
    ("neighbour", "0()\n"),
    ("boundary", "1(walls { type wall; nFaces 4; startFace 0; })\n"),
];

/// Error of the tetrahedron with one file replaced, or left out where `content` is empty.
fn refusal(name: &str, content: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    for (file, original) in TETRAHEDRON {
        let content = if file == name { content } else { original };
        if !content.is_empty() {
            fs::write(folder.path().join(file), format!("{HEAD}{content}")).unwrap();
        }
    }
    if !TETRAHEDRON.iter().any(|(file, _)| *file == name) {
        fs::write(folder.path().join(name), format!("{HEAD}{content}")).unwrap();
    }
    let message = read_poly_mesh(folder.path()).expect_err("a broken mesh").to_string();
    assert!(message.contains('\n'), "no remedy: {message}");
    message.rsplit('/').next().filter(|m| m.starts_with(name)).unwrap_or(&message).to_owned()
}

#[test]
fn a_single_cell_with_a_uniform_owner_list_is_a_mesh() {
    let folder = tempfile::tempdir().unwrap();
    for (file, content) in TETRAHEDRON {
        fs::write(folder.path().join(file), format!("{HEAD}{content}")).unwrap();
    }
    let mesh = read_poly_mesh(folder.path()).unwrap();
    assert!((mesh.cell_volumes()[0] - 1.0 / 6.0).abs() < 1e-16);
}

#[test]
fn a_point_out_of_range_is_named_with_its_line() {
    let e = refusal("faces", "4\n(\n3(2 1 0)\n3(0 1 3)\n3(1 8 3)\n3(2 0 3)\n)\n");
    assert!(e.starts_with("faces:6: face 2 names point 8, but the mesh has 4 points\n  the points and faces"), "{e}");
}

#[test]
fn a_face_with_two_corners_is_named_with_its_line() {
    let e = refusal("faces", "4\n(\n3(2 1 0)\n2(0 1)\n3(1 2 3)\n3(2 0 3)\n)\n");
    assert!(e.starts_with("faces:5: face 1 has 2 corners\n"), "{e}");
}

#[test]
fn a_coordinate_that_is_no_number_is_named_with_its_line() {
    let e = refusal("points", "4\n(\n(0 0 0)\n(1 nan 0)\n(0 1 0)\n(0 0 1)\n)\n");
    assert!(e.starts_with("points:5: point 1 is (1 NaN 0)\n"), "{e}");
    let e = refusal("points", "4\n(\n(0 0 0)\n(1 zero 0)\n(0 1 0)\n(0 0 1)\n)\n");
    assert!(e.starts_with("points:5: expected a number, found 'zero'\n"), "{e}");
}

#[test]
fn a_truncated_file_is_named_with_what_it_holds() {
    let e = refusal("points", "4\n(\n(0 0 0)\n(1 0 0)\n");
    assert!(e.starts_with("points:6: the file ends after 2 of 4 entries in the list of points\n"), "{e}");
}

#[test]
fn a_wrong_count_is_named_with_the_right_one() {
    let e = refusal("owner", "5(0 0 0 0)\n");
    assert!(e.starts_with("owner:2: the list of owner cells announces 5 entries but holds 4\n"), "{e}");
    let e = refusal("owner", "3(0 0 0)\n");
    assert!(e.starts_with("owner: owner has 3 entries, but the mesh has 4 faces\n"), "{e}");
    let e = refusal("neighbour", "5{1}\n");
    assert!(e.contains("one value for 5 labels"), "{e}");
}

#[test]
fn a_missing_owner_file_is_named() {
    let e = refusal("owner", "");
    assert!(e.starts_with("owner: there is neither 'owner' nor 'owner.gz' in this folder\n"), "{e}");
}

#[test]
fn a_cell_number_beyond_what_the_faces_can_bound_is_refused() {
    let e = refusal("owner", "4(0 0 4000000000 0)\n");
    assert!(e.starts_with("owner:2: face 2 has owner 4000000000, but 4 faces can bound no more than 8 cells\n"), "{e}");
}

#[test]
fn patches_outside_the_boundary_or_over_each_other_are_refused() {
    let e = refusal("boundary", "1(walls { type wall; nFaces 4; startFace 1; })\n");
    assert!(e.contains("patch 'walls' has 4 faces from face 1 on, but the boundary is faces 0 to 4"), "{e}");
    let two = "2(a { type wall; nFaces 3; startFace 0; } b { type wall; nFaces 2; startFace 2; })\n";
    assert!(refusal("boundary", two).contains("patches 'a' and 'b' share face 2"));
    let e = refusal("boundary", "1(a { type wall; nFaces 99999999999999999; startFace 9223372036854775807; })\n");
    assert!(e.contains("patch 'a' has 99999999999999999 faces"), "{e}");
}

#[test]
fn a_zone_with_a_cell_that_does_not_exist_is_refused_with_its_name() {
    let e = refusal("cellZones", "1(core { type cellZone; cellLabels List<label> 1(3); })\n");
    assert!(e.starts_with("cellZones:2: zone 'core' names cell 3, but the mesh has 1 cells\n"), "{e}");
}

#[test]
fn a_hole_in_a_cell_is_reported_by_the_mesh() {
    let folder = tempfile::tempdir().unwrap();
    for (file, content) in TETRAHEDRON {
        let content = match file {
            "faces" => "3(3(2 1 0) 3(0 1 3) 3(1 2 3))",
            "owner" => "3(0 0 0)",
            "boundary" => "0()",
            _ => content,
        };
        fs::write(folder.path().join(file), format!("{HEAD}{content}")).unwrap();
    }
    let e = read_poly_mesh(folder.path()).unwrap_err();
    assert!(matches!(e, fieldstone_io::IoError::Mesh { .. }), "{e}");
}

#[test]
fn a_folder_without_mesh_and_a_path_that_does_not_exist_are_named() {
    let folder = tempfile::tempdir().unwrap();
    assert!(read_poly_mesh(folder.path()).unwrap_err().to_string().contains("no polyMesh was found here"));
    let e = read_poly_mesh(&folder.path().join("nowhere")).unwrap_err().to_string();
    assert!(e.contains("nowhere: cannot read"), "{e}");
}
