//! Surfaces in STL: both variants, and what is wrong with damaged ones.
#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use fieldstone_io::{read_stl, write_stl};

fn file(folder: &tempfile::TempDir, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join("surface.stl");
    std::fs::write(&path, bytes).unwrap();
    path
}

const TEXT: &str = "solid two\n  facet normal 0 0 1\n    outer loop\n      vertex 0 0 0\n      vertex 1e0 -0.0 0\n      \
    vertex 0 +.5 0\n    endloop\n  endfacet\n\n  FACET normal 0 0 1\n    outer loop\n      VERTEX 0 0 -0\n      \
    vertex 0 0.5 0\n      vertex 0 0 2\n    endloop\n  endfacet\nendsolid two\n";

#[test]
fn text_and_binary_give_the_same_points_and_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let (points, triangles) = read_stl(&file(&folder, TEXT)).unwrap();
    assert_eq!(points, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 2.0]]);
    assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
    let path = folder.path().join("binary.stl");
    write_stl(&path, &points, &triangles).unwrap();
    assert_eq!(read_stl(&path).unwrap(), (points, triangles));
    // Some programs begin binary files with the word of the text variant.
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[..5].copy_from_slice(b"solid");
    assert_eq!(read_stl(&file(&folder, bytes)).unwrap().1.len(), 2);
}

#[test]
fn what_is_no_whole_surface_is_refused_with_its_place() {
    let folder = tempfile::tempdir().unwrap();
    for (text, expected) in [
        (TEXT.replace("1e0", "one"), ":5: 'one' is no coordinate"),
        (TEXT.replace("vertex 1e0 -0.0 0\n", "vertex 1e0 -0.0\n"), ":5: '' is no coordinate"),
        (TEXT.replace("      vertex 0 0 2\n", ""), ":14: a triangle has 2 corners; it must have 3"),
        (TEXT.replace("0 0 2", "0 0 inf"), ":15: a corner has the coordinate inf; it must be finite"),
        (TEXT.replace("  endfacet\n\n", "  end\n"), ":8: 'end' is no word of an STL file"),
        (TEXT.replace("endsolid two\n", ""), ": the file ends without 'endsolid'"),
        ("ply\n".into(), ": the file does not begin with 'solid' and is too short to be binary"),
        (String::new(), ": the file does not begin with 'solid'"),
    ] {
        let error = read_stl(&file(&folder, &text)).unwrap_err().to_string();
        assert!(error.contains(&format!("surface.stl{expected}")), "{error}\ninstead of {expected}");
    }
    let path = folder.path().join("binary.stl");
    write_stl(&path, &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.0]], &[[0, 1, 2]]).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    let error = read_stl(&file(&folder, &bytes)).unwrap_err().to_string();
    assert!(error.contains("surface.stl: byte 84: a corner has the coordinate NaN"), "{error}");
    for length in 0..bytes.len() {
        assert!(read_stl(&file(&folder, &bytes[..length])).is_err(), "{length}");
    }
}
