//! Every file that VTK wrote for `tools/vtk_fixtures.py`, compared with the numbers that went into it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fieldstone_io::vtk::{VtkData, read_vtk, read_vtk_mesh, read_vtk_particles};
use fieldstone_io::{DataArray, Values};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/vtk")
}

/// Files and the names of what they hold.
fn index() -> Vec<(PathBuf, String)> {
    let text = std::fs::read_to_string(folder().join("index.txt")).unwrap();
    let pairs = text.lines().map(|l| l.split_once(' ').unwrap());
    pairs.map(|(file, of)| (folder().join(file), of.to_owned())).collect()
}

/// Components and numbers by name.
type Expected = BTreeMap<String, (usize, Vec<String>)>;

fn expected(of: &str) -> Expected {
    let text = std::fs::read_to_string(folder().join(format!("{of}.expected"))).unwrap();
    let line = |l: &str| {
        let mut words = l.split(' ').map(str::to_owned);
        let (name, components) = (words.next().unwrap(), words.next().unwrap().parse().unwrap());
        (name, (components, words.filter(|w| !w.is_empty()).collect()))
    };
    text.lines().map(line).collect()
}

fn floats(words: &[String]) -> Vec<f64> {
    words.iter().map(|w| w.parse().unwrap()).collect()
}

/// Integers bit by bit, floats as near as VTK's text files have them: six digits in the legacy ones.
fn assert_values(array: &DataArray, components: usize, words: &[String], relative: f64, place: &str) {
    assert_eq!(array.components, components, "{place}");
    if let Values::I64(found) = &array.values {
        let wanted: Vec<i64> = words.iter().map(|w| w.parse().unwrap()).collect();
        assert_eq!(found, &wanted, "{place}");
        return;
    }
    assert_close(&array.values.to_f64(), &floats(words), relative, place);
}

fn assert_close(found: &[f64], wanted: &[f64], relative: f64, place: &str) {
    assert_eq!(found.len(), wanted.len(), "{place}");
    for (k, (a, b)) in found.iter().zip(wanted).enumerate() {
        assert!((a - b).abs() <= relative * b.abs(), "{place}, number {k}: {a} instead of {b}");
    }
}

fn compare(file: &Path, data: &VtkData, expected: &Expected) -> usize {
    let relative = if file.extension().is_some_and(|e| e == "vtk") { 5e-6 } else { 0.0 };
    let mut compared = 0;
    for (name, (components, words)) in expected {
        let place = format!("{}, {name}", file.display());
        let column = |arrays: &[DataArray], name: &str| {
            let spaced = name.replace('_', " ");
            let array = arrays.iter().find(|a| a.name == name || a.name == spaced);
            let array = array.unwrap_or_else(|| panic!("{place}: no such column"));
            assert_values(array, *components, words, relative, &place);
        };
        let image = || data.image.as_ref().unwrap();
        match name.split_once('.').unwrap_or((name, "")) {
            ("points", _) => assert_close(data.points.as_flattened(), &floats(words), relative, &place),
            ("image", "origin") => assert_close(&image().origin, &floats(words), relative, &place),
            ("image", "spacing") => assert_close(&image().spacing, &floats(words), relative, &place),
            ("image", _) => assert_close(&image().cells.map(|n| n as f64), &floats(words), 0.0, &place),
            ("cells", "types") => {
                let found: Vec<f64> = data.cells.types().iter().map(|&t| t.into()).collect();
                assert_close(&found, &floats(words), 0.0, &place);
            }
            ("cells", part) => {
                let (mut corners, mut ends) = (Vec::new(), Vec::new());
                for (cell, &kind) in data.cells.types().iter().enumerate() {
                    let mut own: Vec<f64> = data.cells.corners(cell).iter().map(|&c| c.into()).collect();
                    if kind == 42 {
                        own.sort_by(f64::total_cmp);
                    }
                    corners.extend(own);
                    ends.push(corners.len() as f64);
                }
                let found = if part == "ends" { ends } else { corners };
                assert_close(&found, &floats(words), 0.0, &place);
            }
            ("point", column_name) => column(&data.point_data, column_name),
            ("cell", column_name) => column(&data.cell_data, column_name),
            ("field", column_name) => column(&data.field_data, column_name),
            ("volumes", _) => {
                let mesh = read_vtk_mesh(file).unwrap_or_else(|e| panic!("{e}"));
                assert_close(mesh.cell_volumes(), &floats(words), 1e-13, &place);
            }
            _ => panic!("{place}: unknown kind of line"),
        }
        compared += 1;
    }
    compared
}

#[test]
fn every_file_that_vtk_wrote_gives_the_numbers_that_went_into_it() {
    let files = index();
    let mut compared = 0;
    for (file, of) in &files {
        let data = read_vtk(file).unwrap_or_else(|e| panic!("{e}"));
        compared += compare(file, &data, &expected(of));
    }
    assert!(files.len() > 80 && compared > 1000, "only {} files and {compared} columns", files.len());
}

#[test]
fn the_index_names_every_fixture_in_the_folder() {
    let mut listed: Vec<PathBuf> = index().into_iter().map(|(file, _)| file).collect();
    let found = std::fs::read_dir(folder()).unwrap().map(|e| e.unwrap().path());
    let mut found: Vec<PathBuf> =
        found.filter(|p| p.extension().is_some_and(|e| e != "txt" && e != "expected")).collect();
    listed.sort();
    found.sort();
    assert_eq!(listed, found);
}

#[test]
fn integers_keep_their_type_and_floats_their_width() {
    let data = read_vtk(&folder().join("mixed_f32_raw_lz4_uint64.vtu")).unwrap();
    assert!(matches!(data.array("radius").unwrap().values, Values::F32(_)));
    assert!(matches!(data.array("uint8").unwrap().values, Values::U8(_)));
    assert!(matches!(data.array("uint64").unwrap().values, Values::I64(_)));
    let data = read_vtk(&folder().join("mixed_f64_raw_lzma_uint64.vtu")).unwrap();
    assert!(matches!(data.array("radius").unwrap().values, Values::F64(_)));
}

#[test]
fn points_become_particles_with_radius_id_velocity_and_time() {
    let particles = read_vtk_particles(&folder().join("surface_f64_raw_none_uint32.vtp")).unwrap();
    let wanted = expected("surface_f64");
    assert_eq!(particles.radii().unwrap(), floats(&wanted["point.radius"].1));
    assert_eq!(particles.quantity("velocity").unwrap().data, floats(&wanted["point.v"].1));
    assert_eq!(particles.ids().unwrap()[..2], [-5, -2]);
    assert_eq!(particles.time(), Some(0.125));
}

#[test]
fn the_points_of_a_mesh_of_volume_cells_are_not_taken_for_particles() {
    for name in ["mixed_f64_inline_zlib_uint32.vtu", "mixed_f64_51_binary.vtk"] {
        let error = read_vtk_particles(&folder().join(name)).unwrap_err();
        assert!(error.to_string().contains("mesh of volume cells"), "{error}");
    }
}

#[test]
fn texts_in_a_file_are_passed_over_and_named() {
    for name in ["attributes_42_text.vtk", "attributes_51_binary.vtk"] {
        let data = read_vtk(&folder().join(name)).unwrap();
        assert_eq!(data.skipped, ["names"]);
        assert_eq!(data.array("after_names").unwrap().values.to_f64(), [3.0, 4.0]);
    }
}

#[test]
fn a_grid_is_neither_a_mesh_nor_particles() {
    let file = folder().join("image_f64_ascii_none_uint32.vti");
    assert!(read_vtk_mesh(&file).unwrap_err().to_string().contains("regular grid"));
    assert!(read_vtk_particles(&file).unwrap_err().to_string().contains("regular grid"));
}

#[test]
fn a_surface_is_no_volume_mesh() {
    let message = read_vtk_mesh(&folder().join("surface_f64_ascii_none_uint32.vtp")).unwrap_err().to_string();
    assert!(message.contains("none of the 7 cells is three-dimensional"), "{message}");
}

#[test]
fn a_gzipped_file_is_read_like_the_plain_one() {
    use std::io::Write;
    let plain = std::fs::read(folder().join("surface_f64_raw_zlib_uint32.vtp")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("surface.vtp.gz");
    let mut gz = flate2::write::GzEncoder::new(std::fs::File::create(&path).unwrap(), flate2::Compression::fast());
    gz.write_all(&plain).unwrap();
    gz.finish().unwrap();
    compare(&path, &read_vtk(&path).unwrap(), &expected("surface_f64"));
}

#[test]
fn a_file_of_another_format_is_named_as_such() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vtu");
    for (content, part) in [
        ("ITEM: TIMESTEP\n0\n", "starts with 'ITEM: TIMESTEP"),
        ("", "starts with ''"),
        ("<html></html>", "not <VTKFile>"),
        ("<VTKFile type=\"PUnstructuredGrid\"/>", "give the pieces"),
        ("<VTKFile type=\"Collection\"/>", "list of files over time"),
        ("# vtk DataFile Version 1.0\n\n", "version 1"),
    ] {
        std::fs::write(&path, content).unwrap();
        let message = read_vtk(&path).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn files_of_other_programs_are_read() {
    let Some(folder) = fieldstone_testing::extended("sph-frames") else { return };
    for (name, count) in [
        ("cube_8_particles.vtk", 8),
        ("double_dam_break_frame_26_4732_particles.vtk", 4732),
        ("fluid_250_particles.vtu", 250),
        ("free_particles_125_particles.vtk", 125),
    ] {
        assert_eq!(read_vtk_particles(&folder.join(name)).unwrap_or_else(|e| panic!("{e}")).len(), count);
    }
}

#[test]
fn the_particles_of_a_real_chute_have_all_their_columns() {
    let Some(file) = fieldstone_testing::extended("liggghts-chute/part_26000.vtk.gz") else { return };
    let particles = read_vtk_particles(&file).unwrap();
    assert_eq!(particles.len(), 12092);
    let radii = particles.radii().unwrap();
    assert!(radii.iter().all(|r| (1e-4..1e-2).contains(r)));
    assert_eq!(particles.ids().unwrap().iter().max(), Some(&12092));
    for (name, components) in [("velocity", 3), ("force", 3), ("angular_velocity", 3), ("mass", 1)] {
        assert_eq!(particles.quantity(name).unwrap().components, components);
    }
}
