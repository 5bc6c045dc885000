//! Files with bytes flipped, cut out, repeated or cut off: a reader may refuse them, never panic or hang.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use fieldstone_io::openfoam::{read_cloud, read_internal_field, read_poly_mesh};
use fieldstone_io::read_gmsh;
use fieldstone_testing::{Random, data, extended};

/// Damages a file's content at up to three places, each in one of six ways.
fn damage(original: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = original.to_vec();
    for _ in 0..1 + random.below(3) {
        let n = bytes.len();
        let at = random.below(n);
        let end = (at + 1 + random.below(16)).min(n);
        match random.below(6) {
            0 if n > 0 => bytes[at] ^= 1 << random.below(8),
            1 if n > 0 => bytes[at] = b"0123456789-(){};$\" \n.e"[random.below(22)],
            2 => drop(bytes.drain(at..end)),
            3 => bytes.truncate(at),
            4 => {
                let copy = bytes[at..end].to_vec();
                bytes.splice(at..at, copy);
            }
            _ => drop(bytes.splice(at..at, b"999999999999".iter().copied().take(1 + random.below(12)))),
        }
    }
    bytes
}

/// Reads damaged versions of `file`; returns how many were refused.
fn torture(file: &Path, times: usize, read: impl Fn() -> bool) -> usize {
    let original = fs::read(file).unwrap();
    assert!(read(), "{} cannot be read even undamaged", file.display());
    let mut random = Random(original.len() as u64);
    let mut refused = 0;
    for _ in 0..times {
        fs::write(file, damage(&original, &mut random)).unwrap();
        let start = Instant::now();
        refused += usize::from(!read());
        assert!(start.elapsed() < Duration::from_secs(20), "{} took too long", file.display());
    }
    fs::write(file, original).unwrap();
    // Wrong counts must not have been trusted with memory; said by Linux only.
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    if let Some(line) = status.lines().find(|l| l.starts_with("VmHWM:")) {
        let kilobytes: usize = line.split_whitespace().nth(1).unwrap().parse().unwrap();
        assert!(kilobytes < 1_000_000, "{}: {kilobytes} kB of memory were used", file.display());
    }
    refused
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
fn damaged_openfoam_meshes_are_read_or_refused() {
    let mut cases = vec![(data("openfoam/decomposed/whole"), 300)];
    cases.extend(extended("openfoam/bed_twist_bin").map(|p| (p, 25)));
    cases.extend(extended("openfoam/gmfoam").map(|p| (p, 10)));
    let folder = tempfile::tempdir().unwrap();
    for (source, times) in cases {
        let case = folder.path().join("case");
        copy(&source, &case);
        for name in ["points", "faces", "owner", "neighbour", "boundary", "cellZones"] {
            let file = case.join("constant/polyMesh").join(name);
            if file.exists() {
                let refused = torture(&file, times, || read_poly_mesh(&case).is_ok());
                assert!(refused > 0, "no damage to {name} was noticed");
            }
        }
        fs::remove_dir_all(case).unwrap();
    }
}

#[test]
fn damaged_parts_of_a_decomposed_case_are_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    copy(&data("openfoam/decomposed"), folder.path());
    for name in ["points", "faces", "owner", "boundary"] {
        let file = folder.path().join("processor2/constant/polyMesh").join(name);
        assert!(torture(&file, 300, || read_poly_mesh(folder.path()).is_ok()) > 0, "{name}");
    }
}

#[test]
fn damaged_clouds_and_fields_are_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    copy(&data("openfoam/cloud"), folder.path());
    for kind in ["text", "binary"] {
        let time = folder.path().join(kind).join("0.02");
        for name in ["positions", "d", "U", "rho", "nParticle"] {
            let file = time.join("lagrangian/kinematicCloud").join(name);
            assert!(torture(&file, 300, || read_cloud(&time).is_ok()) > 0, "{name}");
        }
        for name in ["U", "rho"] {
            let file = time.join(name);
            assert!(torture(&file, 300, || read_internal_field(&file).is_ok()) > 0, "{name}");
        }
    }
}

#[test]
fn damaged_gmsh_files_are_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut sources: Vec<(PathBuf, usize)> = ["v22", "v22_bin", "v41", "v41_bin", "v41_partitioned", "v41_parametric"]
        .iter()
        .map(|name| (data(&format!("gmsh/box_{name}.msh")), 500))
        .collect();
    sources.extend(
        ["vessel_v22.msh", "vessel_v41_bin.msh"].iter().filter_map(|n| Some((extended(&format!("gmsh/{n}"))?, 40))),
    );
    for (source, times) in sources {
        let file = folder.path().join("a.msh");
        fs::write(&file, fs::read(&source).unwrap()).unwrap();
        assert!(torture(&file, times, || read_gmsh(&file).is_ok()) > times / 4, "{}", source.display());
    }
}
