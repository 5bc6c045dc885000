//! `fraction` on cases of OpenFOAM: which mesh a result belongs to, and in which order its cells are.

#![allow(clippy::unwrap_used)]

mod support;

use fieldstone::io::CsvTable;
use fieldstone::io::openfoam::read_internal_field;
use fieldstone_testing::data;
use support::Folder;
use support::cases::{BALLS, small_case};

/// Turns each face of a plain copy of the mesh the other way round.
fn turn_faces(text: &str) -> String {
    let line = |line: &str| match line.strip_suffix(')').and_then(|l| l.split_once('(')) {
        Some((count, corners)) if !count.is_empty() => {
            let corners: Vec<&str> = corners.split_whitespace().rev().collect();
            format!("{count}({})\n", corners.join(" "))
        }
        _ => format!("{line}\n"),
    };
    text.lines().map(line).collect()
}

#[test]
fn cells_that_are_inside_out_are_named() {
    let folder = Folder::new();
    folder.copy(&data("openfoam/decomposed/whole"), "case");
    folder.write("balls.csv", BALLS);
    let faces = folder.path("case/constant/polyMesh/faces");
    let turned = turn_faces(&std::fs::read_to_string(&faces).unwrap());
    std::fs::write(&faces, turned).unwrap();
    let run = folder.succeeds("fraction --mesh case --particles balls.csv --out o.vtu");
    let found = "case: 12 cells are inside out (cells 0, 1, 2, 3, 4, …, from 0)";
    assert!(run.stderr.contains(found) && run.stderr.contains("counted twice"), "{}", run.stderr);
}

#[test]
fn results_on_another_mesh_than_the_case_has_at_that_time_are_refused() {
    let folder = small_case();
    folder.copy(&data("openfoam/decomposed/whole"), "other");
    let message = folder.fails("fraction --mesh other --particles balls.csv --out case/8");
    for part in ["--out case/8", "case, has 19 cells, and other has 12", "give --mesh case"] {
        assert!(message.contains(part), "{message}");
    }
    assert!(!folder.path("case/8").exists());
    // The same mesh from another file fits.
    folder.succeeds("fraction --mesh case --particles balls.csv --out copy.vtu");
    folder.succeeds("fraction --mesh copy.vtu --particles balls.csv --out case/8");

    // From time 0.5 on its points have moved.
    let points = std::fs::read_to_string(folder.path("other/constant/polyMesh/points")).unwrap();
    folder.write("other/0.5/polyMesh/points", points.replace(" 0.5 ", " 0.55 "));
    folder.succeeds("fraction --mesh other --particles balls.csv --out other/0.25");
    for time in ["0.5", "0.75"] {
        let message = folder.fails(&format!("fraction --mesh other --particles balls.csv --out other/{time}"));
        for part in ["cell 0 is at (", "in the mesh of this time, other/0.5", "give --mesh other/0.5"] {
            assert!(message.contains(part), "{message}");
        }
        folder.succeeds(&format!("fraction --mesh other/0.5 --particles balls.csv --out other/{time}"));
    }
}

#[test]
fn results_of_a_decomposed_case_are_those_of_the_whole_one() {
    let folder = Folder::new();
    folder.copy(&data("openfoam/decomposed"), "case");
    folder.write("balls.csv", BALLS);
    folder.succeeds("fraction --mesh case/whole --particles balls.csv --out whole.csv");
    let run = folder.succeeds("fraction --mesh case --particles balls.csv --out case/1");
    assert!(!run.stderr.contains("cellProcAddressing"), "{}", run.stderr);
    let joined = read_internal_field(&folder.path("case/1/alpha.solids")).unwrap().values(12).unwrap();
    let whole = CsvTable::read(&folder.path("whole.csv")).unwrap().column("solid_fraction").unwrap();
    assert!(whole.iter().zip(&joined).all(|(a, b)| (a - b).abs() < 1e-14), "{whole:?} {joined:?}");
    std::fs::remove_file(folder.path("case/processor2/constant/polyMesh/cellProcAddressing")).unwrap();
    let run = folder.succeeds("fraction --mesh case --particles balls.csv --out case/2");
    assert!(run.stderr.contains("case: without cellProcAddressing") && run.stderr.contains("case/2"), "{}", run.stderr);
}

#[test]
fn outputs_that_openfoam_cannot_have_are_refused_with_the_reason() {
    let folder = small_case();
    let grid = "--grid 0,1,0,1,0,1 --cells 2,2,2";
    for (cells, out, found) in [
        (grid, "case/9", "--out case/9: OpenFOAM's fields need a mesh (--mesh); a grid is written as .vti or .csv"),
        (
            "--mesh case",
            "case/0/air",
            "--out case/0/air: results are not written into time folders of regions; use .vtu",
        ),
    ] {
        let message = folder.fails(&format!("fraction {cells} --particles balls.csv --out {out}"));
        assert!(message.contains(found), "{message}");
    }
}

#[test]
fn fields_of_an_earlier_run_that_stay_in_a_time_folder_are_named() {
    let folder = small_case();
    folder.succeeds("fraction --mesh case --particles balls.csv --cap 0.1 --out case/8");
    let again = folder.succeeds("fraction --mesh case --particles balls.csv --cap 0.1 --out case/8").stderr;
    assert!(!again.contains("earlier run"), "{again}");
    let plain = folder.succeeds("fraction --mesh case --particles balls.csv --out case/8").stderr;
    assert!(plain.contains("case/8/alpha.solids.uncapped: the file is of an earlier run"), "{plain}");
}
