//! What is written is read back unchanged, in every encoding.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::{Path, PathBuf};

use fieldstone_io::vtk::{
    VtkArrays, VtkCompression, VtkEncoding, VtkFormat, VtkImage, VtkKind, VtkWedges, read_pvd, read_vtk, read_vtk_mesh,
    read_vtk_particles, write_pvd, write_vti, write_vtp_particles, write_vtp_surface, write_vtu,
};
use fieldstone_io::{DataArray, Values};
use fieldstone_mesh::{Grid, Mesh};
use fieldstone_particles::{Particles, Quantity};

fn encodings() -> Vec<VtkEncoding> {
    let formats = [VtkFormat::Ascii, VtkFormat::Inline, VtkFormat::AppendedBase64, VtkFormat::AppendedRaw];
    let compressions = [VtkCompression::None, VtkCompression::Zlib, VtkCompression::Lz4, VtkCompression::Lzma];
    let with = |format| move |compression| VtkEncoding { format, compression, ..VtkEncoding::default() };
    formats.into_iter().flat_map(|format| compressions.into_iter().map(with(format))).collect()
}

fn mesh(name: &str) -> Mesh {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/vtk");
    read_vtk_mesh(&folder.join(name)).unwrap()
}

fn target() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out");
    (folder, path)
}

/// Numbers that are easily lost: no number at all, signs of zero, both ends of the range.
fn awkward(n: usize) -> Vec<f64> {
    let list = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, 5e-324, f64::MAX, 0.1, 1.0 / 3.0, -1e22];
    (0..n).map(|k| list[k % list.len()]).collect()
}

fn bits(values: &Values) -> Vec<u64> {
    values.to_f64().into_iter().map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() }).collect()
}

#[test]
fn a_mesh_of_all_kinds_of_cells_comes_back_with_its_cells_in_order() {
    let mesh = mesh("mixed_f64_raw_zlib_uint64.vtu");
    for encoding in encodings() {
        for wedges in [VtkWedges::SinceVtk97, VtkWedges::BeforeVtk97] {
            let (_folder, path) = target();
            write_vtu(&path, &mesh, VtkArrays::default(), VtkEncoding { wedges, ..encoding }).unwrap();
            let back = read_vtk_mesh(&path).unwrap();
            assert_eq!(back.parts().points, mesh.parts().points);
            assert_eq!(back.cell_volumes(), mesh.cell_volumes(), "{encoding:?} {wedges:?}");
            for cell in 0..mesh.cell_count() {
                assert_eq!(back.cell_kind(cell), mesh.cell_kind(cell));
                assert_eq!(back.cell_corners(cell), mesh.cell_corners(cell), "{wedges:?}");
            }
            assert_eq!(back.inverted_cells(), mesh.inverted_cells());
        }
    }
}

#[test]
fn wedges_are_listed_as_cgns_does_since_vtk_9_7_and_the_other_way_round_before() {
    let mesh = mesh("plain_f64_raw_zlib_uint64.vtu");
    let (_folder, path) = target();
    let last = |wedges| {
        write_vtu(&path, &mesh, VtkArrays::default(), VtkEncoding { wedges, ..VtkEncoding::TEXT }).unwrap();
        let data = read_vtk(&path).unwrap();
        data.cells.corners(data.cells.len() - 1).to_vec()
    };
    let since = last(VtkWedges::SinceVtk97);
    assert_eq!(Some(&since[..]), mesh.cell_corners(mesh.cell_count() - 1));
    let before = last(VtkWedges::BeforeVtk97);
    assert_eq!(before, [0, 2, 1, 3, 5, 4].map(|k| since[k]));
}

#[test]
fn every_number_comes_back_bit_by_bit_in_every_encoding() {
    let grid = VtkImage::aligned([0.1, -0.2, 1e-300], [1e-3, 0.3, 7.0], [3, 2, 2]);
    let narrow: Vec<f32> = awkward(12).into_iter().map(|x| x as f32).collect();
    let cells = [
        DataArray::scalar("a <b> & \"c\" 'd' µ", awkward(12)),
        DataArray::floats("velocity", 3, awkward(36)),
        DataArray { name: "narrow".into(), components: 1, values: Values::F32(narrow) },
        DataArray { name: "bytes".into(), components: 2, values: Values::U8((0..24).map(|k| k * 11).collect()) },
        DataArray::integers("whole", (0..12).map(|k| if k < 6 { i64::MIN + k } else { i64::MAX - k }).collect()),
    ];
    let points = [DataArray::scalar("p", awkward(36))];
    for encoding in encodings() {
        let (_folder, path) = target();
        let arrays = VtkArrays { points: &points, cells: &cells, time: Some(0.1), ..VtkArrays::default() };
        write_vti(&path, &grid, arrays, encoding).unwrap();
        let back = read_vtk(&path).unwrap();
        assert_eq!(back.image.as_ref(), Some(&grid));
        assert_eq!(back.time, Some(0.1));
        assert_eq!(back.cell_data.len(), cells.len());
        for (a, b) in back.cell_data.iter().chain(&back.point_data).zip(cells.iter().chain(&points)) {
            assert_eq!((&a.name, a.components), (&b.name, b.components));
            assert_eq!(bits(&a.values), bits(&b.values), "{encoding:?}, {}", a.name);
            assert_eq!(std::mem::discriminant(&a.values), std::mem::discriminant(&b.values));
        }
        assert_eq!(back.cell_data[4], cells[4], "integers beyond 2⁵³");
    }
}

#[test]
fn arrays_of_exactly_one_block_and_of_a_block_and_a_bit_come_back() {
    for (format, compression) in
        [(VtkFormat::AppendedRaw, VtkCompression::Lz4), (VtkFormat::Inline, VtkCompression::Zlib)]
    {
        for n in [1 << 15, (1 << 15) + 1, (1 << 16) - 1, 1 << 16] {
            let grid = VtkImage::aligned([0.0; 3], [1.0; 3], [n, 1, 1]);
            let numbers: Vec<f64> = (0..n).map(|k| (k as f64).sqrt()).collect();
            let cells = [DataArray::scalar("s", numbers)];
            let (_folder, path) = target();
            let encoding = VtkEncoding { format, compression, ..VtkEncoding::default() };
            write_vti(&path, &grid, VtkArrays { cells: &cells, ..VtkArrays::default() }, encoding).unwrap();
            assert!(read_vtk(&path).unwrap().cell_data == cells, "{n} numbers, {compression:?}");
        }
    }
}

#[test]
fn particles_come_back_with_all_columns_also_when_there_is_none() {
    for n in [0, 5] {
        let of = |components: usize| -> Vec<f64> { (0..n * components).map(|k| (k as f64 + 0.5).ln()).collect() };
        let quantity = |name: &str, components| Quantity { name: name.into(), components, data: of(components) };
        let particles = Particles::new(of(3).as_chunks::<3>().0.to_vec()).unwrap();
        let particles = particles.with_radii(vec![0.1; n]).unwrap().with_ids((0..n as i64).rev().collect()).unwrap();
        let particles = particles.with_types(vec![2; n]).unwrap().with_quantity(quantity("velocity", 3)).unwrap();
        let particles = particles.with_quantity(quantity("strain rate", 9)).unwrap().at(None, Some(12.5));
        for encoding in encodings() {
            let (_folder, path) = target();
            write_vtp_particles(&path, &particles, encoding).unwrap();
            assert_eq!(read_vtk_particles(&path).unwrap(), particles, "{encoding:?}");
        }
    }
}

#[test]
fn a_surface_comes_back_as_triangles_and_a_wrong_corner_is_refused() {
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.5]];
    let (_folder, path) = target();
    let cells = [DataArray::integers("patch", vec![4, 5])];
    let arrays = VtkArrays { cells: &cells, ..VtkArrays::default() };
    write_vtp_surface(&path, &points, &[[0, 1, 2], [1, 3, 2]], arrays, VtkEncoding::default()).unwrap();
    let back = read_vtk(&path).unwrap();
    assert_eq!((back.kind, back.points.len(), back.cells.types()), (VtkKind::PolyData, 4, &[5, 5][..]));
    assert_eq!(back.cells.corners(1), [1, 3, 2]);
    assert_eq!(back.cell_data, cells);
    let e = write_vtp_surface(&path, &points, &[[0, 1, 4]], VtkArrays::default(), VtkEncoding::default());
    assert!(e.unwrap_err().to_string().contains("polygon 0 names point 4, but there are 4"));
}

#[test]
fn a_column_of_the_wrong_length_is_refused_and_leaves_no_file() {
    let mesh = mesh("plain_f64_raw_zlib_uint64.vtu");
    let (folder, path) = target();
    let cells = [DataArray::scalar("fraction", vec![0.5; 3])];
    let arrays = VtkArrays { cells: &cells, ..VtkArrays::default() };
    let message = write_vtu(&path, &mesh, arrays, VtkEncoding::default()).unwrap_err().to_string();
    assert!(message.contains("column 'fraction' has 3 numbers; 11 rows of 1 are needed in CellData"), "{message}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_grid_is_written_with_its_bounds_and_a_flat_one_counts_its_cells() {
    let grid = Grid::new([-1.0, 0.0, 2.0], [1.0, 3.0, 4.0], [4, 3, 2]).unwrap();
    let image = VtkImage::from(&grid);
    assert_eq!((image.origin, image.spacing, image.cells), ([-1.0, 0.0, 2.0], [0.5, 1.0, 1.0], [4, 3, 2]));
    let flat = VtkImage::aligned([0.0; 3], [1.0; 3], [5, 4, 0]);
    assert_eq!((flat.cell_count(), flat.point_count()), (20, 30));
}

#[test]
fn the_default_encoding_is_valid_xml_throughout() {
    let (_folder, path) = target();
    let particles = Particles::new(vec![[0.1, 0.2, 0.3]; 50]).unwrap();
    write_vtp_particles(&path, &particles, VtkEncoding::default()).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let mut reader = quick_xml::Reader::from_str(&text);
    while reader.read_event().unwrap() != quick_xml::events::Event::Eof {}
    assert!(text.contains("encoding=\"base64\"") && text.contains("vtkZLibDataCompressor"));
}

#[test]
fn a_series_comes_back_with_its_times_and_paths_and_refuses_a_time_that_is_none() {
    let (folder, path) = target();
    let steps = [(0.0, PathBuf::from("a & b/step 0.vtu")), (1e-3, PathBuf::from("step 1.vtu"))];
    write_pvd(&path, &steps).unwrap();
    let back = read_pvd(&path).unwrap();
    assert_eq!(back, steps.clone().map(|(time, file)| (time, folder.path().join(file))));
    assert!(write_pvd(&path, &[(f64::NAN, "x.vtu".into())]).is_err());
    std::fs::write(&path, "<VTKFile type=\"PolyData\"></VTKFile>").unwrap();
    assert!(read_pvd(&path).unwrap_err().to_string().contains("no <Collection>"));
}
