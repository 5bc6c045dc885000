//! PLY and classic .bgeo files, written here byte by byte, and SPH frames that others wrote.

#![allow(clippy::unwrap_used)]

use std::path::PathBuf;

use fieldstone_io::{FrameReader, IoError, ParticleOptions, open_particles, read_bgeo, read_frame, read_ply};
use fieldstone_particles::Particles;
use fieldstone_testing::extended;

fn file(name: &str, content: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    (folder, path)
}

fn ply(content: &[u8]) -> Result<Particles, IoError> {
    let (_folder, path) = file("a.ply", content);
    read_ply(&path)
}

const PROPERTIES: &str = "comment two points\nelement camera 1\nproperty uchar kind\nelement vertex 2\nproperty double x\n\
    property float y\nproperty short z\nproperty uint id\nproperty float radius\nproperty float vx\nproperty float vy\n\
    property float vz\nproperty int8 level\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n";

fn assert_two(particles: &Particles) {
    assert_eq!(particles.positions(), [[0.1, 2.5, -3.0], [1e-300, -0.25, 32_767.0]]);
    assert_eq!(particles.ids().unwrap(), [4_294_967_295, 7]);
    assert_eq!(particles.radii().unwrap(), [0.5, 0.25]);
    assert_eq!(particles.quantity("velocity").unwrap().data, [1.0, 2.0, 3.0, -1.0, -2.0, -3.0]);
    assert_eq!(particles.quantity("level").unwrap().data, [-128.0, 127.0]);
}

/// The numbers of the two points, in one byte order or the other.
fn records(big: bool) -> Vec<u8> {
    let mut all = vec![9];
    let mut put = |bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        if big {
            bytes.reverse();
        }
        all.extend(bytes);
    };
    let points = [
        (0.1f64, 2.5f32, -3i16, u32::MAX, 0.5f32, [1.0f32, 2.0, 3.0], -128i8),
        (1e-300, -0.25, 32_767, 7, 0.25, [-1.0, -2.0, -3.0], 127),
    ];
    for (x, y, z, id, radius, v, level) in points {
        put(&x.to_le_bytes());
        put(&y.to_le_bytes());
        put(&z.to_le_bytes());
        put(&id.to_le_bytes());
        put(&radius.to_le_bytes());
        v.iter().for_each(|c| put(&c.to_le_bytes()));
        put(&level.to_le_bytes());
    }
    all
}

#[test]
fn ply_points_are_the_same_in_text_and_in_either_byte_order() {
    let text = format!(
        "ply\nformat ascii 1.0\n{PROPERTIES}9\n0.1 2.5 -3 4294967295 0.5 1 2 3 -128\n1e-300 -0.25 32767 7 0.25 -1 -2 -3 127\n"
    );
    assert_two(&ply(text.as_bytes()).unwrap());
    for (name, big) in [("binary_little_endian", false), ("binary_big_endian", true)] {
        let mut content = format!("ply\nformat {name} 1.0\n{PROPERTIES}").into_bytes();
        content.extend(records(big));
        assert_two(&ply(&content).unwrap());
        let (_folder, path) = file("points", &content);
        assert_two(&read_frame(&path, &ParticleOptions::default(), 0).unwrap());
        content.pop();
        let error = ply(&content).unwrap_err().to_string();
        assert!(error.contains("the file ends after 1 of the 2 vertices"), "{error}");
    }
}

#[test]
fn blank_lines_of_a_ply_text_are_no_rows_wherever_they_stand() {
    let head = "ply\nformat ascii 1.0\nelement camera 2\nproperty float k\nelement mark 1\n\
        element vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    for rows in ["7\n8\n1 2 3\n4 5 6\n", "\n7\n \n8\n\n1 2 3\n\r\n4 5 6\n\n"] {
        let found = ply(format!("{head}{rows}").as_bytes()).unwrap();
        assert_eq!(found.positions(), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "{rows:?}");
    }
    let error = ply(format!("{head}7\n\n\n8\n").as_bytes()).unwrap_err().to_string();
    assert!(error.contains("the file ends after 0 of the 2 vertices"), "{error}");
}

#[test]
fn ply_surfaces_lists_and_damaged_headers_are_refused() {
    let head = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    for (content, expected) in [
        (format!("{head}element face 1\nproperty list uchar int i\nend_header\n0 0 0\n1 0\n"), "a surface of faces"),
        (format!("{head}property list uchar int i\nend_header\n0 0 0 0\n"), "has a list property"),
        (format!("{head}end_header\n0 0\n"), ":8: the row has 2 numbers; 3 are expected"),
        (format!("{head}end_header\n0 0 nan\n"), ":8: "),
        (format!("{head}end_header\n"), "the file ends after 0 of the 1 vertices"),
        (head.to_string(), "no end_header"),
        (head.replace("property float x\n", "") + "end_header\n0 0\n", "no complete set of coordinates"),
        (head.replace("float x", "quad x") + "end_header\n", "unknown type"),
        (head.replace("vertex 1", "vertex -1") + "end_header\n", "not a whole number"),
        (head.replace("vertex", "vertices") + "end_header\n0 0 0\n", "no element 'vertex'"),
    ] {
        let error = ply(content.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
    let huge = b"ply\nformat binary_little_endian 1.0\nelement camera 18446744073709551615\nproperty double k\n\
        element vertex 9999999999999999\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    assert!(ply(huge).is_err());
}

/// A file of two points with attributes of each kind.
fn bgeo() -> Vec<u8> {
    let mut all = b"BgeoV".to_vec();
    let int = |all: &mut Vec<u8>, value: i32| all.extend(value.to_be_bytes());
    let float = |all: &mut Vec<u8>, value: f32| all.extend(value.to_be_bytes());
    for value in [5, 2, 0, 0, 0, 4, 0, 0, 0] {
        int(&mut all, value);
    }
    let name = |all: &mut Vec<u8>, text: &str| {
        all.extend((text.len() as u16).to_be_bytes());
        all.extend(text.bytes());
    };
    for (text, size, kind) in [("id", 1u16, 1), ("label", 1, 4), ("v", 3, 5), ("pscale", 1, 0)] {
        name(&mut all, text);
        all.extend(size.to_be_bytes());
        int(&mut all, kind);
        if kind == 4 {
            int(&mut all, 1);
            name(&mut all, "water");
        } else {
            (0..size).for_each(|_| int(&mut all, 0));
        }
    }
    for (point, id) in [(1.0, 12), (2.0, -3)] {
        for value in [point, 10.0 * point, 100.0 * point, 1.0] {
            float(&mut all, value);
        }
        int(&mut all, id);
        int(&mut all, 0);
        for value in [0.5, 0.25, -point] {
            float(&mut all, value);
        }
        float(&mut all, 0.125);
    }
    all.extend([0x00, 0xff]);
    all
}

#[test]
fn bgeo_points_have_their_ids_radii_and_velocities() {
    let (_folder, path) = file("a.bgeo", &bgeo());
    let particles = read_frame(&path, &ParticleOptions::default(), 0).unwrap();
    assert_eq!(particles, read_bgeo(&path).unwrap());
    assert_eq!(particles.positions(), [[1.0, 10.0, 100.0], [2.0, 20.0, 200.0]]);
    assert_eq!(particles.ids().unwrap(), [12, -3]);
    assert_eq!(particles.radii().unwrap(), [0.125; 2]);
    assert_eq!(particles.quantity("velocity").unwrap().data, [0.5, 0.25, -1.0, 0.5, 0.25, -2.0]);
    assert!(particles.quantity("label").is_err());
}

#[test]
fn damaged_bgeo_files_end_in_an_error() {
    let whole = bgeo();
    for length in 0..whole.len() - 2 {
        let (_folder, path) = file("a.bgeo", &whole[..length]);
        assert!(read_bgeo(&path).is_err(), "cut after {length}");
    }
    for (at, byte, expected) in [(8, 4, "version is 4"), (9, 0xff, "negative number"), (50, 9, "is of kind 9")] {
        let mut damaged = whole.clone();
        damaged[at] = byte;
        let (_folder, path) = file("a.bgeo", &damaged);
        let error = read_bgeo(&path).unwrap_err().to_string();
        assert!(error.contains(expected), "{at}: {error}");
    }
}

#[test]
fn every_sph_frame_is_read_with_its_quantities() {
    for (name, count, columns) in [
        ("cube_8_particles.vtk", 8, ""),
        ("dam_break_frame_23_24389_particles.bgeo", 24_389, ""),
        ("dam_break_frame_9_6859_particles.bgeo", 6_859, "density:1 velocity:3"),
        ("double_dam_break_frame_26_4732_particles.vtk", 4_732, "velocity:3"),
        ("fluid_250_particles.vtu", 250, "velocity:3 pressure:1 density:1 index:1"),
        ("free_particles_125_particles.vtk", 125, ""),
    ] {
        let Some(path) = extended(&format!("sph-frames/{name}")) else { return };
        let mut reader: Box<dyn FrameReader + Send> = open_particles(&path, &ParticleOptions::default()).unwrap();
        let particles = reader.next_frame().unwrap().unwrap();
        let found: Vec<_> = particles.quantities().iter().map(|q| format!("{}:{}", q.name, q.components)).collect();
        println!(
            "{name}: {} ids {} radii {} {found:?}",
            particles.len(),
            particles.ids().is_some(),
            particles.radii().is_ok()
        );
        assert_eq!((particles.len(), found.join(" ").as_str()), (count, columns), "{name}");
        assert!(particles.radii().is_err(), "positions without radii are fine");
        assert!(reader.next_frame().unwrap().is_none());
    }
}
