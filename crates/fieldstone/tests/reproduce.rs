//! `fieldstone reproduce overlap`: the files it leaves, the errors it finds, and that threads change neither.

#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::Command;

use fieldstone::io::CsvTable;

fn reproduce(folder: &Path, arguments: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_fieldstone"))
        .args(["reproduce", "overlap"])
        .arg(folder)
        .args(arguments)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Rows of a table as text.
fn rows(path: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(String::from).collect()).collect()
}

const ERRORS: [&str; 7] = [
    "--only",
    "fig9,fig10,fig11,approximations",
    "--radii",
    "0.05,0.4728708045015879,2",
    "--samples",
    "40",
    "--threads",
];

#[test]
fn the_errors_stay_within_the_limits_and_do_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two] = ["1", "2"].map(|threads| {
        let to = folder.path().join(threads);
        reproduce(&to, &[&ERRORS[..], &[threads]].concat());
        to
    });
    for name in ["fig10.csv", "fig11.csv", "approximations.csv"] {
        assert_eq!(std::fs::read(one.join(name)).unwrap(), std::fs::read(two.join(name)).unwrap(), "{name}");
    }
    for name in ["fig9.png", "fig10.png", "fig11.png", "approximations.png"] {
        let picture = std::fs::read(one.join(name)).unwrap();
        assert!(picture.starts_with(b"\x89PNG") && picture.len() > 10_000, "{name}");
        assert_eq!(picture, std::fs::read(two.join(name)).unwrap(), "{name}");
    }

    // Mesh, radius, way.
    let fig10 = rows(&one.join("fig10.csv"));
    assert_eq!(fig10.len(), 6 * 3 * 3);
    for row in &fig10 {
        let [radius, worst] = [1, 4].map(|k| row[k].parse::<f64>().unwrap());
        let limit = if row[2] == "decomposition" { 1e-12 } else { 5e-15 };
        assert!(worst <= limit, "{row:?}");
        let samples = match (radius > 1.0, row[2].as_str()) {
            (false, _) => "40",
            (true, "kernel with promise") => "1",
            (true, _) => "4",
        };
        assert_eq!(row[3], samples, "{row:?}");
    }
    // An error of exactly 0 everywhere would be no measurement.
    assert!(fig10.iter().filter(|row| row[4].parse::<f64>().unwrap() > 0.0).count() > fig10.len() / 2);

    // Mesh, angle, radius, then number of spheres and worst error of the kernel and of the decomposition.
    let fig11 = rows(&one.join("fig11.csv"));
    assert_eq!(fig11.len(), 6 * 10 * 3);
    for row in &fig11 {
        let [angle, kernel, decomposition] = [1, 4, 6].map(|k| row[k].parse::<f64>().unwrap());
        let limit = if angle == 80.0 { 2e-14 } else { 5e-15 };
        assert!(kernel <= limit && decomposition <= 1e-11, "{row:?}");
        assert!(row[3].parse::<u32>().unwrap() > 0 && row[5].parse::<u32>().unwrap() > 0, "{row:?}");
    }

    let page = std::fs::read_to_string(one.join("index.md")).unwrap();
    for name in ["fig9.png", "fig10.png", "fig11.png", "approximations.png", "kernel with promise"] {
        assert!(page.contains(name), "{name}");
    }
    assert!(!page.contains("NaN") && !page.contains("inf "), "{page}");
    // What the paper's text has no number for, or a bound alone, gets neither a number nor a factor.
    let row = |start: &str| page.lines().find(|line| line.starts_with(start)).unwrap();
    let plateau = row("| plateau, r ≤ 0.2 | machine precision | ");
    assert_eq!(plateau.matches(" (40) |").count(), 3, "{plateau}");
    let all = row("| all radii | < 1e-11 | ");
    assert!(all.contains(" (81) | ") && all.matches(" (84) |").count() == 2, "{all}");
    assert!(!page.contains("times below"), "{page}");
}

#[test]
fn a_ball_that_crosses_a_cell_has_the_exact_share_in_it() {
    let folder = tempfile::tempdir().unwrap();
    reproduce(folder.path(), &["--only", "approximations"]);
    let table = CsvTable::read(&folder.path().join("approximations.csv")).unwrap();
    let [x, exact, centre] = ["x", "share_kernel", "share_centre"].map(|name| table.column(name).unwrap());
    // Symmetric about the cell's middle, as the path is; with its centre on the face, half of what is inside at x = 0.
    let last = x.len() - 1;
    assert!((0..=last).all(|k| (exact[k] - exact[last - k]).abs() < 1e-14));
    let at = |position: f64| exact[x.iter().position(|&x| x == position).unwrap()];
    assert!((at(0.5) - 0.5 * at(0.0)).abs() < 1e-14 && at(0.0) > 0.9 && at(1.0) == 0.0);
    assert!(centre.iter().all(|&share| share == 0.0 || share == 1.0));
}

#[test]
fn times_are_measured_for_every_mesh_and_radius() {
    let folder = tempfile::tempdir().unwrap();
    reproduce(folder.path(), &["--only", "fig12", "--samples", "1"]);
    let times = rows(&folder.path().join("fig12.csv"));
    assert_eq!(times.len(), 6 * 10 * 2);
    assert!(times.iter().all(|row| row[4].parse::<f64>().unwrap() > 0.0));
    assert!(folder.path().join("fig12.png").is_file());
}

#[test]
fn radii_out_of_range_and_unknown_figures_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, said) in [
        (&["--radii", "0.5,21"][..], "--radii: 21"),
        (&["--radii", "NaN"], "--radii: NaN"),
        (&["--only", "fig13"], "fig13"),
        (&["--samples", "0"], "--samples"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_fieldstone"))
            .args(["reproduce", "overlap"])
            .arg(folder.path())
            .args(arguments)
            .output()
            .unwrap();
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.contains(said), "{message}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
