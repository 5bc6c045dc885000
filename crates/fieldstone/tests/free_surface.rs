//! `fieldstone detect`, `grid`, `surface` and `reproduce surface` as users run them.

#![allow(clippy::unwrap_used)]

mod support;

use std::fmt::Write;

use fieldstone::io::CsvTable;
use fieldstone::io::vtk::read_vtk;
use fieldstone::surface::TriangleMesh;
use support::Folder;

/// A block of 10 × 10 × 10 fluid particles 0.1 apart, floor at z = 0, with one layer of boundary (type 0) below it.
fn block() -> String {
    let mut text = String::from("x,y,z,type,mass,density,pressure\n");
    for k in -1..10 {
        for j in 0..10 {
            for i in 0..10 {
                let [x, y, z] = [i, j, k].map(|n| 0.1 * (f64::from(n) + 0.5));
                let kind = i32::from(k >= 0);
                let _ = writeln!(text, "{x},{y},{z},{kind},1,1000,{}", 5.0 - 3.0 * z + x);
            }
        }
    }
    text
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("block.csv", block());
    let fluid: String = block().lines().filter(|line| !line.contains(",0,1,1000,")).map(|l| format!("{l}\n")).collect();
    folder.write("fluid.csv", fluid);
    folder
}

fn json(folder: &Folder, file: &str) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(folder.path(file)).unwrap()).unwrap()
}

#[track_caller]
fn mentions(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "'{part}' is missing in:\n{message}");
    }
}

/// Free-surface particles of the block where nothing is below it, and where something is.
const BARE: usize = 1000 - 8 * 8 * 8;
const ON_FLOOR: usize = 1000 - 8 * 8 * 9;

#[test]
fn detected_particles_come_with_their_own_columns_and_the_computed_ones() {
    let folder = folder();
    let run = folder.succeeds("detect --particles fluid.csv --spacing 0.1 --exposure --out out.vtp --json out.json");
    insta::assert_snapshot!("detect_report", run.stdout);
    let found = read_vtk(&folder.path("out.vtp")).unwrap();
    let column = |name: &str| found.array(name).unwrap().values.to_f64();
    let free = column("free_surface");
    assert_eq!(free.iter().sum::<f64>() as usize, BARE);
    assert_eq!(column("pressure").len(), 1000);
    assert!(column("level").iter().zip(&free).all(|(level, free)| (*level == 0.0) == (*free == 1.0)));
    // The normal of a particle in the middle of the upper face, and its exposure.
    let top = found.points.iter().position(|p| p.iter().zip([0.45, 0.45, 0.95]).all(|(a, b)| (a - b).abs() < 1e-9));
    let top = top.unwrap();
    let normals = column("normal");
    assert!((normals[3 * top + 2] - 1.0).abs() < 1e-9, "{:?}", &normals[3 * top..3 * top + 3]);
    assert!(column("exposure").iter().zip(&free).all(|(cone, free)| (*cone > 45.0 + 1e-6) == (*free == 1.0)));
    let summary = json(&folder, "out.json");
    assert_eq!(summary["free_surface"], BARE);
    for key in ["particles", "isolated", "duplicates"] {
        assert!(summary[key].is_u64(), "{key}: {summary}");
    }
    assert!(summary["seconds"]["detect"].as_f64().unwrap() > 0.0);
}

#[test]
fn walls_and_boundary_particles_take_the_floor_out_of_the_surface() {
    let folder = folder();
    for (line, expected) in [
        ("--particles fluid.csv --wall 0,0,1,0", ON_FLOOR),
        ("--particles fluid.csv --wall 0,0,1,0 --wall 1,0,0,0 --wall -1,0,0,-1", 1000 - 8 * 10 * 9),
        ("--particles fluid.csv --periodic xy --box 0,1,0,1,0,5", 200),
    ] {
        folder.succeeds(&format!("detect {line} --spacing 0.1 --out out.csv --json out.json"));
        assert_eq!(json(&folder, "out.json")["free_surface"], expected, "{line}");
        let table = CsvTable::read(&folder.path("out.csv")).unwrap();
        assert_eq!(table.column("free_surface").unwrap().iter().sum::<f64>() as usize, expected);
    }
    folder.succeeds("detect --particles block.csv --boundary type=0 --spacing 0.1 --out out.csv --json out.json");
    let summary = json(&folder, "out.json");
    assert_eq!((summary["boundary"].as_u64(), summary["particles"].as_u64()), (Some(100), Some(1100)));
    assert_eq!(summary["free_surface"], ON_FLOOR);
}

#[test]
fn the_comparison_tells_misses_from_false_positives() {
    let folder = folder();
    let methods = "geometrical,semi,haque,marrone,wang";
    let run = folder.succeeds(&format!(
        "detect --particles fluid.csv --spacing 0.1 --compare {methods} --out out.vtp --json out.json"
    ));
    mentions(&run.stdout, &["TP", "EP", "misses", "false positives", "haque"]);
    let summary = json(&folder, "out.json");
    let rows = summary["comparison"].as_array().unwrap();
    assert_eq!(rows.len(), 5);
    // On a lattice all methods agree.
    assert!(rows.iter().all(|row| row["reference"] == BARE && row["misses"] == 0 && row["false_positives"] == 0));
    // A cone twice as wide as the paper's misses the rest.
    folder.succeeds(
        "detect --particles fluid.csv --spacing 0.1 --theta 80 --compare haque --out out.vtp --json out.json",
    );
    let wide = json(&folder, "out.json");
    let row = &wide["comparison"][0];
    let count = |key: &str| row[key].as_u64().unwrap();
    assert_eq!(count("reference") - count("misses") + count("false_positives"), count("free_surface"));
}

#[test]
fn a_sequence_gives_one_file_per_frame_and_a_table() {
    let folder = folder();
    for (number, source) in [(9, "fluid.csv"), (10, "block.csv")] {
        folder.copy(&folder.path(source), &format!("part_{number}.csv"));
    }
    let run = folder.succeeds("detect --particles part_{}.csv --spacing 0.1 --out found_{}.vtp --json all.json");
    mentions(&run.stdout, &["found_0.vtp from part_9.csv\n", "found_1.vtp from part_10.csv\n"]);
    let all = json(&folder, "all.json");
    assert_eq!((all[0]["file"].as_str(), all[0]["particles"].as_u64()), (Some("part_9.csv"), Some(1000)));
    assert_eq!(all[1]["particles"], 1100);
    assert!(folder.path("found_1.vtp").is_file());
    // Without {} the last frame of all files, as --help says.
    folder.succeeds("detect --particles part_{}.csv --spacing 0.1 --out found.vtp --json found.json");
    assert_eq!(json(&folder, "found.json")["file"], "part_10.csv");
    folder.succeeds("detect --particles part_{}.csv --frames 1 --spacing 0.1 --out one.vtp --json one.json");
    assert_eq!(json(&folder, "one.json")["particles"], 1100);
}

#[test]
fn a_pvd_gives_its_frames_with_their_times() {
    let folder = folder();
    for k in 0..2 {
        folder.succeeds(&format!("detect --particles fluid.csv --spacing 0.1 --labels-only --out part_{k}.vtp"));
    }
    // In the order of the list, not of the names.
    let list = [(0.5, "part_1.vtp".into()), (0.75, "part_0.vtp".into())];
    fieldstone::io::vtk::write_pvd(&folder.path("run.pvd"), &list).unwrap();
    folder.succeeds("detect --particles run.pvd --spacing 0.1 --out out_{}.vtp --json out.json");
    let time = |name: &str| read_vtk(&folder.path(name)).unwrap().time;
    assert_eq!([time("out_0.vtp"), time("out_1.vtp")], [Some(0.5), Some(0.75)]);
    assert_eq!(json(&folder, "out.json")[1]["file"].as_str().map(|file| file.ends_with("part_0.vtp")), Some(true));
    folder.succeeds("grid --particles run.pvd --spacing 0.1 --out last.vti");
    assert_eq!(time("last.vti"), Some(0.75));
    folder.succeeds("surface --particles run.pvd --spacing 0.1 --frames 0 --out first.vtp");
    assert_eq!(time("first.vtp"), Some(0.5));
    fieldstone::io::vtk::write_pvd(&folder.path("empty.pvd"), &[]).unwrap();
    let message = folder.fails("detect --particles empty.pvd --spacing 0.1 --out out.vtp");
    mentions(&message, &["empty.pvd: the .pvd lists no file"]);
}

#[test]
fn a_stray_particle_that_makes_the_grid_too_large_is_named_with_the_bounds() {
    let folder = folder();
    folder.write("far.csv", folder_text(&folder, "fluid.csv") + "1e7,0,0,1,1,1000,5\n");
    for (command, out) in [("grid", "o.vti"), ("surface", "o.vtp")] {
        let message = folder.fails(&format!("{command} --particles far.csv --spacing 0.1 --out {out}"));
        mentions(
            &message,
            &[
                "far.csv: --cell, --spacing",
                "reach from (0.05, 0, 0",
                "to (10000000, ",
                "the particle at (10000000, 0, 0)",
            ],
        );
        assert!(!folder.path(out).exists());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_grid_beyond_the_memory_limit_of_the_shell_is_refused_before_it_is_made() {
    let folder = folder();
    folder.write("far.csv", folder_text(&folder, "fluid.csv") + "1e5,0,0,1,1,1000,5\n");
    let program = env!("CARGO_BIN_EXE_fieldstone");
    for (command, out) in [("grid", "o.vti"), ("surface --cell 1", "o.vtp")] {
        let line = format!(
            "ulimit -v 4000000; cd '{}'; '{program}' {command} --particles far.csv --spacing 0.1 --out {out}",
            folder.path("").display()
        );
        let run = std::process::Command::new("sh").args(["-c", &line]).output().unwrap();
        assert_eq!(run.status.code(), Some(1), "{run:?}");
        mentions(
            &String::from_utf8_lossy(&run.stderr),
            &["GB are free", "the particle at (100000, 0, 0)", "leave it out"],
        );
        assert!(!folder.path(out).exists());
    }
}

fn folder_text(folder: &Folder, name: &str) -> String {
    std::fs::read_to_string(folder.path(name)).unwrap()
}

#[test]
fn frames_worked_on_together_give_the_same_files_and_the_first_bad_one_is_named() {
    let folder = folder();
    for number in 0..7 {
        let source = if number % 2 == 0 { "fluid.csv" } else { "block.csv" };
        folder.copy(&folder.path(source), &format!("part_{number}.csv"));
    }
    let detect = "detect --particles part_{}.csv --spacing 0.1 --out";
    folder.succeeds(&format!("{detect} one_{{}}.vtp --threads 1"));
    folder.succeeds(&format!("{detect} three_{{}}.vtp --threads 3"));
    for number in 0..7 {
        let [one, three] = ["one", "three"].map(|n| std::fs::read(folder.path(&format!("{n}_{number}.vtp"))).unwrap());
        assert!(one == three, "frame {number}");
    }
    for number in [3, 5] {
        folder.write(&format!("part_{number}.csv"), format!("x,y,z\n{number},nan,0\n"));
    }
    // What came before it stays: each of these files is whole.
    let run = folder.fieldstone(&format!("{detect} bad_{{}}.vtp --threads 4"));
    assert_eq!(run.code, Some(1));
    mentions(&run.stderr, &["part_3.csv:2", "NaN"]);
    assert!(folder.path("bad_2.vtp").is_file() && !folder.path("bad_3.vtp").exists());
}

#[test]
fn a_frame_that_the_flow_has_left_is_a_result_without_particles() {
    let folder = Folder::new();
    let frame = |step: usize, rows: &str| {
        let count = rows.lines().count();
        format!(
            "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id x y z\n{rows}"
        )
    };
    folder
        .write("leave.dump", frame(0, "1 0.5 0.5 0.5\n2 0.6 0.5 0.5\n") + &frame(1, "") + &frame(2, "2 0.6 0.5 0.5\n"));
    let run = folder.succeeds("detect --particles leave.dump --spacing 0.1 --out lv_{}.vtp --json lv.json");
    mentions(&run.stderr, &["warning: leave.dump: frame 1 holds no particle"]);
    let counts: Vec<_> =
        json(&folder, "lv.json").as_array().unwrap().iter().map(|f| f["free_surface"].clone()).collect();
    assert_eq!(counts, [2, 0, 1]);
    assert_eq!(read_vtk(&folder.path("lv_1.vtp")).unwrap().points.len(), 0);
    let run = folder.fieldstone("detect --particles leave.dump --frames 1 --out lv.vtp");
    assert_eq!(run.code, Some(1));
    mentions(&run.stderr, &["error: leave.dump: frame 1 holds no particle to estimate a spacing from; give --spacing"]);
}

#[test]
fn the_spacing_is_estimated_and_an_implausible_one_is_warned_of() {
    let folder = folder();
    let run = folder.succeeds("detect --particles fluid.csv --out out.vtp --json out.json");
    mentions(&run.stderr, &["warning: fluid.csv: spacing 0.", "estimated; give --spacing"]);
    assert_eq!(json(&folder, "out.json")["free_surface"], BARE);
    let run = folder.succeeds("detect --particles fluid.csv --spacing 1 --method exact --labels-only --out out.vtp");
    mentions(&run.stderr, &["nearest neighbours are typically 1.000e-1 apart, but the spacing is 1"]);
    let run = folder.succeeds("detect --particles fluid.csv --spacing 0.01 --labels-only --out out.vtp");
    mentions(&run.stderr, &["the spacing 0.01 is too small"]);
}

#[test]
fn particles_behind_a_wall_are_refused_with_the_remedy() {
    let folder = folder();
    // All of the block is behind the first; 200 of its 1000 particles are below the second's plane, at 0.05 and 0.15.
    for (wall, parts) in [
        ("0,0,-1,0", &["--wall 0,0,-1,0: fluid.csv: 1000 of 1000 particles", "turn it (--wall 0,0,1,0)"][..]),
        ("0,0,2,0.4", &["--wall 0,0,1,0.2: fluid.csv: 200 of 1000 particles", "move the plane", "--boundary"]),
    ] {
        for (command, out) in [("detect", "vtp"), ("surface", "ply"), ("grid", "vti")] {
            let line = format!("{command} --particles fluid.csv --spacing 0.1 --wall {wall} --out out.{out}");
            mentions(&folder.fails(&line), parts);
        }
    }
}

#[test]
fn particles_in_another_plane_are_refused_in_two_dimensions() {
    let folder = Folder::new();
    let sheet = |row: fn(f64, f64) -> String| -> String {
        let rows = (0..100).map(|k| row(0.1 * f64::from(k % 10), 0.1 * f64::from(k / 10)));
        std::iter::once("x,y,z\n".to_owned()).chain(rows).collect()
    };
    folder.write("xz.csv", sheet(|a, b| format!("{a},0,{b}\n")));
    folder.write("xy.csv", sheet(|a, b| format!("{a},{b},0.5\n")));
    folder.write("tilted.csv", sheet(|a, b| format!("{a},{b},{a}\n")));
    let common = "--dimension 2 --spacing 0.1 --out out.csv --json out.json";
    folder.succeeds(&format!("detect --particles xy.csv {common}"));
    assert_eq!(json(&folder, "out.json")["free_surface"], 36);
    let message = folder.fails(&format!("detect --particles xz.csv {common}"));
    mentions(&message, &["xz.csv", "z runs from 0 to 0.9", "swap the columns y and z", "--dimension 3"]);
    let message = folder.fails(&format!("detect --particles tilted.csv {common}"));
    mentions(&message, &["tilted.csv", "z runs from 0 to 0.9", "use --dimension 3"]);
}

#[test]
fn columns_with_values_that_are_no_numbers_are_refused_and_counted() {
    let folder = folder();
    let fluid = std::fs::read_to_string(folder.path("fluid.csv")).unwrap();
    let lines = fluid.lines().enumerate();
    // Line 0 has the names: this is particle 500.
    let damaged = lines.map(|(n, line)| match (n, line.rsplit_once(',')) {
        (501, Some((rest, _))) => format!("{rest},nan\n"),
        _ => format!("{line}\n"),
    });
    folder.write("nan.csv", damaged.collect::<String>());
    let common = "--particles nan.csv --spacing 0.1";
    for (line, option) in [
        (format!("grid {common} --out out.vti"), "--fields"),
        (format!("grid {common} --fields mass --conserve pressure --out out.vti"), "--conserve"),
        (format!("surface {common} --fields pressure --out out.ply"), "--fields"),
    ] {
        mentions(
            &folder.fails(&line),
            &[&format!("{option} pressure: nan.csv: particle 500 (from 0) has the value NaN")],
        );
    }
    folder.succeeds(&format!("grid {common} --fields mass --conserve mass --out out.vti"));
    folder.succeeds(&format!("surface {common} --out out.ply"));
    let info = folder.succeeds("info nan.csv").stdout;
    mentions(&info, &["mass, 1 to 1\n", ", 1 NaN\n"]);
}

#[test]
fn a_spacing_of_another_unit_makes_no_surface() {
    let folder = folder();
    for spacing in ["100", "0.0001"] {
        for (command, out) in [("surface", "ply"), ("grid", "vti")] {
            let run =
                folder.fieldstone(&format!("{command} --particles fluid.csv --spacing {spacing} --out out.{out}"));
            assert_eq!(run.code, Some(1));
            // The block's spacing is 0.1; in ten layers even inner particles lack some neighbours.
            let message = run.stderr;
            mentions(&message, &[&format!("--spacing {spacing}: fluid.csv"), "apart", "unit"]);
            let measured = message.split("give --spacing ").nth(1).unwrap().split(',').next().unwrap();
            assert!((measured.parse::<f64>().unwrap() / 0.1 - 1.0).abs() < 0.02, "{message}");
        }
    }
    assert!(!folder.path("out.ply").exists() && !folder.path("out.vti").exists());
}

#[test]
fn bad_arguments_and_files_are_refused_with_the_remedy() {
    let folder = folder();
    folder.write("nan.csv", "x,y,z\n0,0,0\n1,nan,0\n");
    folder.write("two.csv", "x,y,z\n0,0,0\n1,0,0\n");
    let base = "detect --particles fluid.csv --spacing 0.1";
    for (line, parts) in [
        (format!("{base} --out out.txt"), &["--out out.txt", ".vtp or .csv"][..]),
        (format!("{base} --method sun --out out.vtp"), &["--method sun", "3 dimensions", "--dimension"]),
        (format!("{base} --theta 95 --out out.vtp"), &["--theta", "95", "below 90"]),
        (format!("{base} --boundary kind=1 --out out.vtp"), &["--boundary kind", "fluid.csv", "pressure"]),
        (format!("{base} --periodic x --out out.vtp"), &["--periodic", "--box"]),
        (format!("{base} --frames 7 --out out.vtp"), &["the only frame, 0, is not in the range 7"]),
        ("detect --particles nan.csv --spacing 1 --out out.vtp".into(), &["nan.csv"]),
        ("detect --particles two.csv --out out.vtp".into(), &["two.csv: 2 particles are too few", "--spacing"]),
        ("surface --particles fluid.csv --spacing 0.1 --out out.stp".into(), &[".vtp, .ply, .obj or .stl"]),
        ("surface --particles fluid.csv --spacing 0.1 --fields pressure --out out.stl".into(), &["--fields", ".ply"]),
        ("surface --particles fluid.csv --spacing 0.1 --fields speed --out out.ply".into(), &["speed", "pressure"]),
        ("grid --particles fluid.csv --spacing 0.1 --slice y=9 --out out.vti".into(), &["--slice", "9"]),
        ("grid --particles fluid.csv --spacing 0.1 --out out.vtu".into(), &["use .vti"]),
        ("grid --particles fluid.csv --spacing 0.1 --cell 1e-9 --out out.vti".into(), &["--cell"]),
    ] {
        mentions(&folder.fails(&line), parts);
    }
}

#[test]
fn surfaces_are_watertight_in_every_format_and_carry_fields() {
    let folder = folder();
    let common = "surface --particles fluid.csv --spacing 0.1";
    for from in ["level-set", "density"] {
        for out in ["out.vtp", "out.ply", "out.obj", "out.stl"] {
            folder.succeeds(&format!("{common} --from {from} --out {out} --json out.json"));
            let summary = json(&folder, "out.json");
            assert_eq!(
                (&summary["closed"], &summary["manifold"], &summary["parts"]),
                (&true.into(), &true.into(), &1.into())
            );
            let volume = summary["volume"].as_f64().unwrap();
            assert!((volume - 1.0).abs() < 0.06, "{from}: {volume}");
        }
    }
    let run = folder.succeeds(&format!("{common} --fields pressure --out out.vtp"));
    mentions(&run.stdout, &["watertight           yes", "manifold             yes", "particle volume      1"]);
    let found = read_vtk(&folder.path("out.vtp")).unwrap();
    let triangles = (0..found.cells.len()).map(|c| found.cells.corners(c).try_into().unwrap()).collect();
    let mesh = TriangleMesh { points: found.points.clone(), triangles, normals: Vec::new() };
    assert!(mesh.topology().unwrap().is_closed());
    // The field is linear, which moving least squares give back.
    for (p, value) in found.points.iter().zip(found.array("pressure").unwrap().values.to_f64()) {
        assert!((value - (5.0 - 3.0 * p[2] + p[0])).abs() < 1e-9, "{p:?}: {value}");
    }
    assert_eq!(found.array("Normals").unwrap().components, 3);
    folder.succeeds(&format!("{common} --fields pressure --out out.ply"));
    let bytes = std::fs::read(folder.path("out.ply")).unwrap();
    let header = String::from_utf8_lossy(&bytes[..bytes.len().min(400)]).into_owned();
    mentions(
        &header,
        &[&format!("element vertex {}\n", mesh.points.len()), "property double nz\nproperty double pressure\n"],
    );
}

#[test]
fn an_open_surface_ends_at_the_wall() {
    let folder = folder();
    let common = "surface --particles fluid.csv --spacing 0.1 --wall 0,0,1,0 --out out.ply --json out.json";
    folder.succeeds(common);
    let closed = json(&folder, "out.json");
    folder.succeeds(&format!("{common} --at-walls open"));
    let open = json(&folder, "out.json");
    assert!(closed["closed"] == true && open["closed"] == false && open["manifold"] == true);
    assert!(open["volume"].is_null() && open["open_edges"].as_u64().unwrap() > 0);
    let floor = closed["area"].as_f64().unwrap() - open["area"].as_f64().unwrap();
    assert!((floor - 1.0).abs() < 0.15, "{floor}");
}

#[test]
fn gridded_fields_are_linear_and_shared_out_amounts_keep_their_total() {
    let folder = folder();
    let run =
        folder.succeeds("grid --particles fluid.csv --spacing 0.1 --conserve mass,pressure --cell 1.5 --out out.vti");
    let found = read_vtk(&folder.path("out.vti")).unwrap();
    let image = found.image.as_ref().unwrap();
    let [nx, ny, _] = image.cells.map(|n| n + 1);
    let column = |name: &str| found.array(name).unwrap().values.to_f64();
    let (pressure, support, level) = (column("pressure"), column("support"), column("level_set"));
    let mut inside = 0;
    for node in 0..image.point_count() {
        let at = [node % nx, node / nx % ny, node / (nx * ny)];
        let p: [f64; 3] = std::array::from_fn(|k| image.origin[k] + image.spacing[k] * at[k] as f64);
        if support[node] == 2.0 {
            inside += 1;
            assert!((pressure[node] - (5.0 - 3.0 * p[2] + p[0])).abs() < 1e-9);
        } else {
            assert!(pressure[node] == 0.0 && level[node] <= -0.125);
        }
    }
    assert!(inside > 200);
    let total = |values: &[f64]| values.iter().sum::<f64>();
    assert!((total(&column("mass_total")) / 1000.0 - 1.0).abs() < 1e-13);
    let table = CsvTable::read(&folder.path("fluid.csv")).unwrap();
    let amount = total(&table.column("pressure").unwrap());
    assert!((total(&column("pressure_total")) / amount - 1.0).abs() < 1e-13);
    mentions(&run.stdout, &["mass of particles", "mass of cells        1000"]);

    folder.succeeds("grid --particles fluid.csv --spacing 0.1 --fields pressure --slice z=0.5 --out out.vti");
    let slice = read_vtk(&folder.path("out.vti")).unwrap();
    assert_eq!((slice.image.as_ref().unwrap().cells[2], slice.image.as_ref().unwrap().origin[2]), (0, 0.5));
    assert!(slice.array("pressure").unwrap().values.to_f64().iter().any(|p| *p > 0.0));
}

#[test]
fn shared_out_amounts_that_leave_through_a_periodic_face_come_in_at_the_opposite_one() {
    let folder = Folder::new();
    // A line of particles 0.1 apart through a box that is periodic along x, the first one on its face.
    let mut text = String::from("ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n10\nITEM: BOX BOUNDS pp ff ff\n");
    text.push_str("0 1\n0 1\n0 1\nITEM: ATOMS id x y z mass\n");
    for k in 0..10 {
        let _ = writeln!(text, "{} {} 0.5 0.5 3", k + 1, 0.1 * f64::from(k));
    }
    folder.write("line.dump", text);
    folder.succeeds("grid --particles line.dump --spacing 0.1 --conserve mass --cell 2 --out out.vti");
    let found = read_vtk(&folder.path("out.vti")).unwrap();
    let image = found.image.as_ref().unwrap();
    assert_eq!((image.cells[0], image.origin[0]), (5, 0.0));
    assert!((image.spacing[0] - 0.2).abs() < 1e-15);
    // Each cell holds one particle wholly and a half of one on each of its faces.
    let mut along = [0.0; 5];
    for (cell, mass) in found.array("mass_total").unwrap().values.to_f64().iter().enumerate() {
        along[cell % 5] += mass;
    }
    assert!(along.iter().all(|mass| (mass - 6.0).abs() < 1e-12), "{along:?}");
}

#[test]
fn gridded_pressure_reaches_its_walls_and_periodic_faces_and_an_empty_plane_is_warned_of() {
    let folder = folder();
    // The floor's nodes are at multiples of the spacing, as walls of most cases.
    let base = "grid --particles fluid.csv --spacing 0.1 --fields pressure --wall 0,0,1,0 --wall 1,0,0,0 --periodic y \
                --box 0,1,0,1,0,2 --out out.vti";
    for from in ["level-set", "density"] {
        for (slice, least, beyond) in
            [("z=0", 100, false), ("y=0", 100, false), ("y=1", 100, false), ("z=0", 100, true)]
        {
            let beyond = if beyond { "--beyond-surface" } else { "" };
            let run = folder.succeeds(&format!("{base} --from {from} --slice {slice} {beyond}"));
            assert!(!run.stderr.contains("no fluid"), "{}", run.stderr);
            let found = read_vtk(&folder.path("out.vti")).unwrap();
            let image = found.image.as_ref().unwrap();
            let [nx, ny, _] = image.cells.map(|n| n + 1);
            let column = |name: &str| found.array(name).unwrap().values.to_f64();
            let (pressure, support) = (column("pressure"), column("support"));
            let mut linear = 0;
            for node in (0..image.point_count()).filter(|&n| support[n] == 2.0) {
                let at = [node % nx, node / nx % ny, node / (nx * ny)];
                let p: [f64; 3] = std::array::from_fn(|k| image.origin[k] + image.spacing[k] * at[k] as f64);
                linear += usize::from(p[0] > -1e-9 && p[2] > -1e-9);
                assert!((pressure[node] - (5.0 - 3.0 * p[2] + p[0])).abs() < 1e-9, "{slice} {p:?}: {}", pressure[node]);
            }
            assert!(linear >= least, "{from} {slice}: {linear}");
        }
    }
    let run = folder.succeeds(&base.replace("--out", "--slice z=1.1 --out"));
    mentions(&run.stderr, &["warning: fluid.csv: --slice z=1.1", "no fluid", "another position", "--beyond-surface"]);
    // A box full of fluid has fluid at every node that is shared out to.
    folder.succeeds(
        "grid --particles fluid.csv --spacing 0.1 --conserve mass --cell 1.3 --periodic xyz --box 0,1,0,1,0,1 --out out.vti",
    );
    let support = read_vtk(&folder.path("out.vti")).unwrap().array("support").unwrap().values.to_f64();
    assert!(support.len() == 729 && support.iter().all(|&how| how == 2.0));
}

#[test]
fn a_flow_in_the_plane_is_gridded_in_one_layer_and_has_no_surface() {
    let folder = Folder::new();
    let mut text = String::from("x,y,z,pressure\n");
    for k in 0..200 {
        let [x, y] = [k % 20, k / 20].map(|n| 0.05 * (f64::from(n) + 0.5));
        let _ = writeln!(text, "{x},{y},0.7,{}", 4.0 - 8.0 * y + x);
    }
    folder.write("flat.csv", text);
    let base = "grid --particles flat.csv --spacing 0.05 --dimension 2 --wall 0,1,0,0 --wall 1,0,0,0 --out out.vti";
    // From wall to surface 21 × 11 nodes; the level set rounds off the free corner.
    for (from, least) in [("level-set", 230), ("density", 190)] {
        let run = folder.succeeds(&format!("{base} --from {from}"));
        assert!(run.stderr.is_empty(), "{}", run.stderr);
        let found = read_vtk(&folder.path("out.vti")).unwrap();
        let image = found.image.as_ref().unwrap();
        assert_eq!((image.cells[2], image.origin[2]), (0, 0.7));
        let column = |name: &str| found.array(name).unwrap().values.to_f64();
        let (pressure, support) = (column("pressure"), column("support"));
        let nx = image.cells[0] + 1;
        for node in 0..image.point_count() {
            let [x, y] = [(0, node % nx), (1, node / nx)].map(|(k, n)| image.origin[k] + image.spacing[k] * n as f64);
            let expected = if support[node] == 2.0 { 4.0 - 8.0 * y + x } else { 0.0 };
            assert!((pressure[node] - expected).abs() < 1e-9, "{x} {y}: {}", pressure[node]);
        }
        let linear = support.iter().filter(|&&how| how == 2.0).count();
        assert!(linear >= least && linear <= 231, "{from}: {linear}");
    }
    let run = folder.succeeds(&format!("{base} --slice y=0"));
    mentions(&run.stdout, &[" × 1 × 1\n", "linear               21\n"]);
    mentions(&folder.fails(&format!("{base} --slice z=0.7")), &["--slice z=0.7", "--dimension 2", "x=… or y=…"]);
    mentions(&folder.fails(&format!("{base} --conserve pressure")), &["--conserve pressure", "three dimensions"]);
    for dimension in [2, 3] {
        let surface = format!("surface --particles flat.csv --spacing 0.05 --dimension {dimension} --out out.ply");
        mentions(
            &folder.fails(&surface),
            &["three", "fieldstone grid --dimension 2", "fieldstone detect --dimension 2"],
        );
    }
    assert!(!folder.path("out.ply").exists() && !folder.succeeds("surface --help").stdout.contains("--dimension"));
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let folder = folder();
    for (command, out) in
        [("detect --exposure", "vtp"), ("surface --fields pressure", "ply"), ("grid --conserve mass", "vti")]
    {
        for threads in [1, 3] {
            let rest = format!("--particles block.csv --boundary type=0 --spacing 0.1 --threads {threads}");
            folder.succeeds(&format!("{command} {rest} --out {threads}.{out}"));
        }
        let [one, three] = [1, 3].map(|threads| std::fs::read(folder.path(&format!("{threads}.{out}"))).unwrap());
        assert!(one == three, "{command}");
    }
}

#[test]
fn numbered_results_never_take_the_name_of_an_input() {
    let folder = folder();
    folder.succeeds("detect --particles fluid.csv --spacing 0.1 --labels-only --out f_1.vtp");
    for number in [2, 3] {
        folder.copy(&folder.path("f_1.vtp"), &format!("f_{number}.vtp"));
    }
    let parts = ["f_{}.vtp", "could overwrite", "another file of this run", "choose another name"];
    for command in ["detect", "surface"] {
        let line = format!("{command} --particles f_{{}}.vtp --spacing 0.1 --out f_{{}}.vtp");
        mentions(&folder.fails(&line), &parts);
        let line = format!("{command} --particles f_{{}}.vtp --spacing 0.1 --out s_{{}}.vtp --json s_2.vtp");
        mentions(&folder.fails(&line), &["s_{}.vtp", "could overwrite s_2.vtp"]);
    }
    // Leading zeros make another name.
    folder.copy(&folder.path("f_1.vtp"), "g_01.vtp");
    folder.succeeds("detect --particles g_01.vtp --spacing 0.1 --out g_{}.vtp");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path("fluid.csv"), folder.path("h_0.csv")).unwrap();
        mentions(
            &folder.fails("detect --particles fluid.csv --spacing 0.1 --out h_{}.csv"),
            &["overwrite another file of this run"],
        );
        std::fs::rename(folder.path("h_0.csv"), folder.path("h_7.csv")).unwrap();
        mentions(
            &folder.fails("detect --particles fluid.csv --spacing 0.1 --out h_{}.csv"),
            &["could overwrite fluid.csv"],
        );
    }
}

#[test]
fn frames_that_are_not_there_are_told_with_those_that_are() {
    let folder = folder();
    for number in ["0010", "0020", "0030"] {
        folder.copy(&folder.path("fluid.csv"), &format!("Part_{number}.csv"));
    }
    let detect = "detect --particles Part_{}.csv --spacing 0.1 --out lab_{}.csv --labels-only";
    mentions(
        &folder.fails(&format!("{detect} --frames 10")),
        &["none of the 3 frames, 0 to 2, is in the range 10", "0 is in Part_0010.csv", "--frames"],
    );
    mentions(&folder.fails(&format!("{detect} --frames 3:1")), &["range 3:1, which ends before it begins"]);
    // Results bear the count of the frame, and the account says of which file they are.
    let account = folder.succeeds(detect).stdout;
    let lines = ["lab_0.csv from Part_0010.csv", "lab_1.csv from Part_0020.csv", "lab_2.csv from Part_0030.csv"];
    mentions(&account, &[&format!("written to           {}\n", lines.join(&format!("\n{:21}", "")))]);
    mentions(&folder.succeeds("detect --help").stdout, &["Part_0010 and Part_0020 the first is frame 0"]);
}

#[test]
fn the_figures_agree_with_the_paper() {
    let folder = folder();
    folder.succeeds("reproduce surface out --only fig6,fig7,fig8");
    for name in ["fig7", "fig8"] {
        let text = std::fs::read_to_string(folder.path(&format!("out/{name}.csv"))).unwrap();
        assert!(text.lines().count() >= 7);
        for line in text.lines().skip(1) {
            let words: Vec<&str> = line.split(',').collect();
            assert_eq!(words[2], words[3], "{line}");
        }
        let picture = std::fs::read(folder.path(&format!("out/{name}.png"))).unwrap();
        assert!(picture.starts_with(b"\x89PNG") && picture.len() > 10_000);
    }
    let angles = CsvTable::read(&folder.path("out/eq31.csv")).unwrap();
    for ((limit, inner), free) in angles
        .column("smallest_angle")
        .unwrap()
        .iter()
        .zip(angles.column("inner_at").unwrap())
        .zip(angles.column("free_at").unwrap())
    {
        assert!((limit - inner).abs() < 1e-4 && (free - limit).abs() < 1e-4 && inner < free);
    }
    let page = std::fs::read_to_string(folder.path("out/index.md")).unwrap();
    mentions(&page, &["the same digits", "6 of 6", "9 of 9"]);
}

#[test]
fn frames_of_the_user_are_compared_by_all_methods() {
    let folder = folder();
    folder.succeeds("reproduce surface out --only tables --frames fluid.csv,block.csv --spacing 0.1");
    let text = std::fs::read_to_string(folder.path("out/tables.csv")).unwrap();
    assert_eq!(text.lines().count(), 1 + 2 * 6);
    for line in text.lines().filter(|line| line.contains("geometrical") || line.contains("exact")) {
        assert!(line.contains(",0,1.000,0,0,"), "{line}");
    }
    let run =
        folder.fieldstone("reproduce surface out --only tables --frames fluid.csv,block.csv --spacing 0.1,0.1,0.2");
    assert_eq!(run.code, Some(1));
    mentions(&run.stderr, &["--spacing: 3 numbers for 2 frames"]);
}

#[test]
fn the_help_of_the_free_surface_commands_reads_well() {
    let folder = Folder::new();
    insta::assert_snapshot!("help_detect", folder.succeeds("detect --help").stdout);
    insta::assert_snapshot!("help_grid", folder.succeeds("grid --help").stdout);
    insta::assert_snapshot!("help_surface", folder.succeeds("surface --help").stdout);
}

#[test]
fn frames_of_a_run_have_the_mass_that_is_shared_out_and_with_its_walls_the_surface_of_the_solver() {
    let folder = Folder::new();
    folder.write(
        "tank.toml",
        "dimension = 3\nspacing = 0.1\n[domain]\nlow = [0, 0, 0]\nhigh = [0.8, 0.8, 1.2]\nopen = [\"z+\"]\n\
         [fluid]\ndensity = 1000.0\nexpected_speed = 2.0\nexpected_pressure = 8000.0\ngravity = [0, 0, -9.81]\n\
         [time]\nend = 0.001\n[[fill]]\nshape = \"box\"\nlow = [0, 0, 0]\nhigh = [0.8, 0.8, 0.6]\n\
         [[wall]]\nkind = \"tank\"\n[shifting]\ndetection = \"exact\"\n",
    );
    folder.succeeds("sph run tank.toml --out run");
    folder.succeeds("grid --particles run/particles.pvd --spacing 0.1 --conserve mass --out mass.vti");
    let mass: f64 =
        read_vtk(&folder.path("mass.vti")).unwrap().array("mass_total").unwrap().values.to_f64().iter().sum();
    assert!((mass / (1000.0 * 0.8 * 0.8 * 0.6) - 1.0).abs() < 1e-9, "{mass}");
    let walls = "--wall 1,0,0,0 --wall -1,0,0,-0.8 --wall 0,1,0,0 --wall 0,-1,0,-0.8 --wall 0,0,1,0";
    folder.succeeds(&format!("detect --particles run/particles.pvd --spacing 0.1 {walls} --frames 0 --out out.vtp"));
    let found = read_vtk(&folder.path("out.vtp")).unwrap();
    let column = |name: &str| found.array(name).unwrap().values.to_f64();
    let free = column("free_surface").iter().filter(|&&free| free == 1.0).count();
    assert_eq!(free, 64);
    assert_eq!(column("region").iter().filter(|&&region| region == 0.0).count(), free);
}
