//! The program as users run it: every option and every output, read back by the readers.

#![allow(clippy::unwrap_used)]

mod support;

use std::f64::consts::PI;
use std::process::{Command, Stdio};

use fieldstone::fields::{SolidFractionOptions, solid_fraction};
use fieldstone::geometry::{CornerOrder, ElementKind, Orientation, PROMISE, Polyhedron};
use fieldstone::io::openfoam::{InternalValues, read_internal_field};
use fieldstone::io::{CsvTable, ParticleOptions, read_frame, read_mesh, vtk};
use fieldstone_testing::data;
use support::Folder;
use support::cases::{column, json, one_ball, small_case};

fn ball(r: f64) -> f64 {
    4.0 / 3.0 * PI * r * r * r
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-13 * a.abs().max(b.abs())
}

/// A folder with the demo's mesh `bed` and packing `packed.dump.gz`.
fn bed() -> Folder {
    let folder = Folder::new();
    folder.copy(&data("bed_twist"), "bed");
    folder.copy(&data("packed-cylinder/packed.dump.gz"), "packed.dump.gz");
    folder
}

fn total(field: &[f64]) -> f64 {
    field.iter().sum()
}

const FIELDS: [&str; 5] = ["solid_fraction", "void_fraction", "solid_volume", "cell_volume", "particle_count"];

#[test]
fn vtu_csv_and_openfoam_fields_hold_the_same_numbers_as_the_library_gives() {
    let folder = small_case();
    for out in ["out.vtu", "out.csv", "case/0"] {
        folder.succeeds(&format!("fraction --mesh case --particles balls.csv --out {out}"));
    }
    folder.succeeds("fraction --mesh case --particles balls.csv --out case/0.5 --binary");

    let mesh = read_mesh(&folder.path("case")).unwrap();
    let balls = read_frame(&folder.path("balls.csv"), &ParticleOptions::default(), -1).unwrap();
    let expected = solid_fraction(&mesh, &balls, &SolidFractionOptions::default()).unwrap();
    let by_name = |name| match name {
        "solid_fraction" => expected.solid_fraction.clone(),
        "void_fraction" => expected.void_fraction.clone(),
        "solid_volume" => expected.solid_volume.clone(),
        "cell_volume" => mesh.cell_volumes().to_vec(),
        _ => column(&folder, "out.vtu", "particle_count"),
    };
    let table = CsvTable::read(&folder.path("out.csv")).unwrap();
    for name in FIELDS {
        assert_eq!(column(&folder, "out.vtu", name), by_name(name), "{name}");
        assert_eq!(table.column(name).unwrap(), by_name(name), "{name}");
    }
    assert_eq!(total(&by_name("particle_count")), 5.0, "the sixth ball is outside");
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let centres: Vec<f64> = (0..mesh.cell_count()).map(|cell| mesh.cell_centre(cell)[k]).collect();
        assert_eq!(table.column(axis).unwrap(), centres);
    }
    for (foam, name) in
        [("alpha.solids", "solid_fraction"), ("voidfraction", "void_fraction"), ("solidVolume", "solid_volume")]
    {
        for time in ["0", "0.5"] {
            let field = read_internal_field(&folder.path(&format!("case/{time}/{foam}"))).unwrap();
            assert!(matches!(field.internal, InternalValues::Nonuniform(_)));
            assert_eq!(field.values(19).unwrap(), by_name(name), "{time}/{foam}");
        }
    }
    let text = std::fs::read_to_string(folder.path("case/0/solidVolume")).unwrap();
    assert!(text.contains("dimensions      [0 3 0 0 0 0 0]") && text.contains("location    \"0\""), "{text}");
    for patch in ["inlet", "sides", "front", "back", "outlet"] {
        assert!(text.contains(patch), "{patch}");
    }
}

#[test]
fn empty_cells_are_written_as_zero_and_not_as_minus_zero() {
    let folder = small_case();
    folder.write("one.csv", "x,y,z,radius\n0.1,0.15,0.2,0.05\n");
    folder.succeeds("fraction --mesh case --particles one.csv --out out.csv");
    let table = CsvTable::read(&folder.path("out.csv")).unwrap();
    let fractions = table.column("solid_fraction").unwrap();
    assert!(fractions.contains(&0.0));
    assert!(fractions.iter().all(|f| f.is_sign_positive()));
}

#[test]
fn a_grid_gives_vti_and_csv_with_x_fastest() {
    let folder = small_case();
    for out in ["out.vti", "out.csv"] {
        let grid = "--grid -0.2,1.4,0,1.2,-0.1,1.1 --cells 8,6,4";
        folder.succeeds(&format!("fraction {grid} --particles balls.csv --out {out} --json {out}.json"));
    }
    let image = vtk::read_vtk(&folder.path("out.vti")).unwrap().image.unwrap();
    assert_eq!(image.cells, [8, 6, 4]);
    assert_eq!(image.origin, [-0.2, 0.0, -0.1]);
    let table = CsvTable::read(&folder.path("out.csv")).unwrap();
    for name in FIELDS {
        assert_eq!(table.column(name).unwrap(), column(&folder, "out.vti", name), "{name}");
    }
    let [x, y, z] = ["x", "y", "z"].map(|axis| table.column(axis).unwrap());
    assert!(near(x[1] - x[0], 0.2) && y[1] == y[0] && near(y[8] - y[0], 0.2) && near(z[48] - z[0], 0.3));
    let inside = ball(0.25) + ball(0.1) + ball(0.12) + ball(0.2) + ball(0.1);
    assert!(near(json(&folder, "out.vti.json")["binned_volume"].as_f64().unwrap(), inside));
}

#[test]
fn every_method_runs_and_accounts_for_all_volume() {
    let folder = small_case();
    let volumes = |method: &str| {
        let out = format!("{}.csv", method.replace(':', "-"));
        let line = format!("fraction --mesh case --particles balls.csv --method {method} --out {out} --json s.json");
        folder.succeeds(&line);
        let summary = json(&folder, "s.json");
        let number = |key: &str| summary[key].as_f64().unwrap();
        let parts = number("binned_volume") + number("clipped_volume");
        // Averaging fractions over cells of unequal volume, as published, does not conserve volume.
        if method != "centre-smoothed" {
            assert!(near(parts, number("particle_volume")), "{method}: {parts}");
        }
        CsvTable::read(&folder.path(&out)).unwrap().column("solid_volume").unwrap()
    };
    let kernel = volumes("kernel");
    for exact in ["decomposition", "kernel-f64"] {
        for (a, b) in volumes(exact).iter().zip(&kernel) {
            assert!((a - b).abs() < 1e-12, "{exact}: {a} {b}");
        }
    }
    for method in ["centre", "centre-smoothed", "cube", "divided", "sampled:200", "monte-carlo:200"] {
        let apart = volumes(method).iter().zip(&kernel).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart > 1e-6, "{method} is exact?");
        assert!(apart < 2.0 * ball(0.25), "{method} is off by {apart}");
    }
}

#[test]
fn the_summary_has_the_documented_keys_in_their_order() {
    let folder = small_case();
    let run = folder.succeeds("fraction --mesh case --particles balls.csv --out out.vtu --json s.json");
    let text = std::fs::read_to_string(folder.path("s.json")).unwrap();
    let keys: Vec<&str> = text.split('"').skip(1).step_by(2).collect();
    let expected = [
        "particles",
        "cells",
        "mesh_volume",
        "particle_volume",
        "binned_volume",
        "clipped_volume",
        "max_solid_fraction",
        "max_written_fraction",
        "cells_above_one",
        "inverted_cells",
        "seconds",
        "read",
        "search",
        "overlap",
        "write",
        "overlaps",
        "beyond_f64",
    ];
    assert_eq!(keys, expected);
    let summary = json(&folder, "s.json");
    assert_eq!(summary["particles"], 6);
    assert_eq!(summary["cells"], 19);
    assert_eq!(summary["inverted_cells"], 0);
    assert!(near(summary["mesh_volume"].as_f64().unwrap(), 1.05));
    assert!(summary["seconds"]["overlap"].as_f64().unwrap() > 0.0);
    // The same numbers are printed.
    for key in ["mesh_volume", "binned_volume", "max_solid_fraction"] {
        let name = key.replace('_', " ");
        let line = run.stdout.lines().find(|line| line.starts_with(&name)).unwrap();
        let printed = line[name.len()..].split_whitespace().next().unwrap();
        assert!(near(summary[key].as_f64().unwrap(), printed.parse().unwrap()), "{key}: {line}");
    }
}

#[test]
fn radius_diameter_and_frame_choose_the_balls() {
    let folder = small_case();
    folder.write("frames.xyz", "1\nfirst\nA 0.5 0.5 0.5\n2\nlast\nA 0.4 0.5 0.5\nA 0.6 0.5 0.5\n");
    let volume = |options: &str| {
        folder.succeeds(&format!("fraction --mesh case --particles frames.xyz --out o.csv --json s.json {options}"));
        json(&folder, "s.json")["binned_volume"].as_f64().unwrap()
    };
    assert!(near(volume("--radius 0.2"), 2.0 * ball(0.2)), "the last frame by default");
    assert!(near(volume("--diameter 0.2 --frame 0"), ball(0.1)));
    assert!(near(volume("--radius 0.2 --frame 1"), 2.0 * ball(0.2)));
    assert!(near(volume("--radius 0.2 --frame -2"), ball(0.2)));
    let message = folder.fails("fraction --mesh case --particles frames.xyz --out o.vtu --radius 0.2 --frame 2");
    assert!(message.contains("frame 2 was asked for, but the file holds 2"), "{message}");
    let message = folder.fails("fraction --mesh case --particles frames.xyz --out o.vtu");
    assert!(message.contains("frames.xyz: the particles have no radius; give one"), "{message}");
}

#[test]
fn parcel_weights_multiply_volumes_by_a_number_or_a_column() {
    let folder = small_case();
    let volumes = |options: &str| {
        folder.succeeds(&format!("fraction --mesh case --particles balls.csv --out o.csv {options}"));
        CsvTable::read(&folder.path("o.csv")).unwrap().column("solid_volume").unwrap()
    };
    let plain = volumes("");
    let tripled = volumes("--parcel-weight 3");
    assert!(plain.iter().zip(&tripled).all(|(a, b)| near(3.0 * a, *b)));
    let weighted = total(&volumes("--parcel-weight weight"));
    // The fifth ball reaches 0.05 below the bottom: a cap of that height is outside.
    let fifth = ball(0.1) - PI * 0.05f64.powi(2) / 3.0 * (3.0 * 0.1 - 0.05);
    assert!(near(weighted, ball(0.25) + 2.0 * ball(0.1) + 3.0 * ball(0.12) + 4.0 * ball(0.2) + 5.0 * fifth));
    let message = folder.fails("fraction --mesh case --particles balls.csv --out p.csv --parcel-weight w");
    assert!(message.contains("--parcel-weight w: balls.csv: there is no column 'w'"), "{message}");
    assert!(message.contains("have: weight"), "{message}");
}

#[test]
fn more_solid_than_there_is_room_for_is_told_with_what_may_have_made_it() {
    let folder = Folder::new();
    folder.write("balls.csv", "x,y,z,radius\n0.5,0.5,0.5,0.4\n0.5,0.5,0.5,0.4\n");
    let warning = |cells: u32, options: &str| {
        let line = format!("fraction --grid 0,1,0,1,0,1 --cells {cells},{cells},{cells} --particles balls.csv");
        folder.succeeds(&format!("{line} --out o.vti {options}")).stderr
    };
    // Two balls in one place fill the cells within them twice.
    assert_eq!(warning(8, ""), "warning: solid fractions above 1 come from particles that overlap each other\n");
    let message = warning(1, "--parcel-weight 1e9");
    assert!(message.contains("check --parcel-weight 1000000000") && !message.contains("overlap"), "{message}");
    let message = warning(1, "--parcel-weight 2");
    assert!(message.contains("up to 1.072") && message.contains("check --parcel-weight 2;"), "{message}");
    assert!(message.contains("overlap"), "{message}");
    folder.write("balls.csv", "x,y,z\n0.5,0.5,0.5\n0.4,0.5,0.5\n0.5,0.6,0.5\n");
    let message = warning(2, "--radius 3");
    assert!(message.contains("up to 3.000") && message.contains("check --radius 3 and its unit"), "{message}");
    assert!(!message.contains("overlap"), "{message}");
    folder.write("balls.csv", "x,y,z,radius\n0.5,0.5,0.5,9\n0.4,0.5,0.5,9\n0.5,0.6,0.5,9\n");
    assert!(warning(2, "").contains("check the unit of the file's radii"));
}

#[test]
fn smoothing_conserves_volume_the_cap_bounds_and_both_keep_the_plain_field() {
    let folder = small_case();
    let run = |options: &str| {
        folder.succeeds(&format!("fraction --mesh case --particles balls.csv --out o.vtu {options}"));
    };
    run("");
    let plain = column(&folder, "o.vtu", "solid_fraction");
    assert!(vtk::read_vtk(&folder.path("o.vtu")).unwrap().array("solid_fraction_unsmoothed").is_none());
    let cells = column(&folder, "o.vtu", "cell_volume");
    let solid = |field: &[f64]| field.iter().zip(&cells).map(|(f, v)| f * v).sum::<f64>();

    run("--smooth 0.3");
    let smooth = column(&folder, "o.vtu", "solid_fraction");
    assert_eq!(column(&folder, "o.vtu", "solid_fraction_unsmoothed"), plain);
    assert!(near(solid(&smooth), solid(&plain)));
    let highest = |field: &[f64]| field.iter().copied().fold(0.0, f64::max);
    assert!(highest(&smooth) < 0.9 * highest(&plain), "{} {}", highest(&smooth), highest(&plain));

    run("--cap 0.3");
    assert_eq!(column(&folder, "o.vtu", "solid_fraction_uncapped"), plain);
    // Nothing was smoothed, so nothing is called unsmoothed.
    assert!(vtk::read_vtk(&folder.path("o.vtu")).unwrap().array("solid_fraction_unsmoothed").is_none());
    assert_eq!(column(&folder, "o.vtu", "solid_fraction"), plain.iter().map(|f| f.min(0.3)).collect::<Vec<_>>());
    let void = column(&folder, "o.vtu", "void_fraction");
    assert_eq!(void, plain.iter().map(|f| 1.0 - f.min(0.3)).collect::<Vec<_>>());

    folder.succeeds("fraction --mesh case --particles balls.csv --out case/0 --cap 0.3");
    let kept = read_internal_field(&folder.path("case/0/alpha.solids.uncapped")).unwrap();
    assert_eq!(kept.values(19).unwrap(), plain);
}

#[test]
fn the_tilt_of_a_box_is_told() {
    let folder = Folder::new();
    folder.write("tilted.dump", one_ball("xy xz yz pp pp pp\n0 1.25 0.25\n0 1 0\n0 1 0", "1 0.5 0.5 0.5 0.25"));
    let told = folder.succeeds("info tilted.dump").stdout;
    assert!(told.contains("tilted by          xy 0.25, xz 0, yz 0"), "{told}");
}

#[test]
fn volume_that_is_counted_twice_is_not_called_outside_the_mesh() {
    let folder = Folder::new();
    folder.write("box.dump", one_ball("pp pp pp\n0 1\n0 1\n0 1", "1 0.25 0.5 0.5 0.25"));
    let run =
        folder.succeeds("fraction --grid 0,2,0,1,0,1 --cells 4,2,2 --particles box.dump --periodic x --out o.vti");
    let line = run.stdout.lines().find(|line| line.starts_with("counted twice ")).unwrap();
    assert!(line.contains("(100.0000 %, in cells that overlap each other or repeat the periodic box)"), "{line}");
    assert!(!run.stdout.contains("outside the mesh"), "{}", run.stdout);
}

#[test]
fn with_smoothing_and_cap_the_field_before_each_is_kept_and_both_maxima_are_told() {
    let folder = small_case();
    let run = |options: &str| {
        let command = format!("fraction --mesh case --particles balls.csv --out o.vtu --json o.json {options}");
        folder.succeeds(&command).stdout
    };
    run("");
    let plain = column(&folder, "o.vtu", "solid_fraction");
    run("--smooth 0.3");
    let smooth = column(&folder, "o.vtu", "solid_fraction");
    let text = run("--smooth 0.3 --cap 0.05");
    assert_eq!(column(&folder, "o.vtu", "solid_fraction_uncapped"), smooth);
    assert_eq!(column(&folder, "o.vtu", "solid_fraction_unsmoothed"), plain);
    assert_eq!(column(&folder, "o.vtu", "solid_fraction"), smooth.iter().map(|f| f.min(0.05)).collect::<Vec<_>>());
    let highest = plain.iter().copied().fold(0.0, f64::max);
    assert!(text.contains(&format!("max solid fraction   {highest}\n  smoothed and capped 0.05\n")), "{text}");
    let json = std::fs::read_to_string(folder.path("o.json")).unwrap();
    assert!(json.contains("\"max_written_fraction\": 0.05"), "{json}");
}

#[test]
fn periodic_directions_are_those_of_the_file_or_those_given() {
    let folder = Folder::new();
    folder.write("corner.dump", one_ball("pp pp ff\n0 1\n0 1\n0 1", "1 0 0 0 0.25"));
    let share = |options: &str| {
        let grid = "--grid 0,1,0,1,0,1 --cells 4,4,4";
        let line = format!("fraction {grid} --particles corner.dump --out o.csv --json s.json {options}");
        let run = folder.succeeds(&line);
        (json(&folder, "s.json")["binned_volume"].as_f64().unwrap() / ball(0.25), run.stderr)
    };
    assert!(near(share("").0, 0.5), "x and y by default");
    assert!(near(share("--periodic none").0, 0.125));
    assert!(near(share("--periodic x").0, 0.25));
    assert!(near(share("--periodic zyx").0, 1.0));
    // A grid that reaches beyond the box would see the images of balls that it holds already.
    let line = "fraction --grid -1,1,0,1,0,1 --cells 4,4,4 --particles corner.dump --out o.csv";
    let warning = folder.succeeds(line).stderr;
    assert!(warning.contains("the box is periodic along xy, but the cells reach beyond it along x"), "{warning}");
    assert!(warning.contains("one period (0 to 1 along x), or --periodic xy for images in all cells"), "{warning}");

    folder.write("boxless.csv", "x,y,z,r\n0.5,0.5,0.5,0.1\n");
    let line = "fraction --grid 0,1,0,1,0,1 --cells 4,4,4 --particles boxless.csv --out p.csv --periodic x";
    let message = folder.fails(line);
    assert!(
        message.contains("boxless.csv: --periodic: the particle file states no box; give it with --box"),
        "{message}"
    );
}

#[test]
fn a_box_can_be_given_where_the_file_states_none_or_another() {
    let folder = Folder::new();
    folder.write("boxless.csv", "x,y,z,r\n0,0,0,0.25\n");
    folder.write("other.dump", one_ball("pp pp pp\n0 2\n0 2\n0 2", "1 0 0 0 0.25"));
    for particles in ["boxless.csv", "other.dump"] {
        let line = format!("fraction --grid 0,1,0,1,0,1 --cells 4 --particles {particles} --out o.csv --json s.json");
        for (options, share) in [("--periodic xyz", 1.0), ("--periodic xz", 0.5), ("--periodic none", 0.125)] {
            folder.succeeds(&format!("{line} --box 0,1,0,1,0,1 {options}"));
            let found = json(&folder, "s.json")["binned_volume"].as_f64().unwrap() / ball(0.25);
            assert!(near(found, share), "{particles} {options}: {found}");
        }
        let message = folder.fails(&format!("{line} --box 0,1,0,1,0,1"));
        assert!(message.contains("--box: say along which axes the box is periodic"), "{message}");
        let message = folder.fails(&format!("{line} --box 0,1,0,1,1,1 --periodic x"));
        assert!(message.contains("--box: "), "{message}");
        let wrong = folder.fieldstone(&format!("{line} --box 0,1,0,1 --periodic x"));
        assert!(wrong.code == Some(2) && wrong.stderr.contains("4 numbers were found; give 6"), "{}", wrong.stderr);
    }
}

#[test]
fn one_number_of_cells_holds_along_all_three_directions() {
    let folder = Folder::new();
    folder.write("one.csv", "x,y,z,r\n0.5,0.5,0.5,0.4\n");
    let table = |cells: &str| {
        folder.succeeds(&format!("fraction --grid 0,1,0,1,0,2 --cells {cells} --particles one.csv --out o.csv"));
        std::fs::read_to_string(folder.path("o.csv")).unwrap()
    };
    assert_eq!(table("5"), table("5,5,5"));
    assert_eq!(table("5").lines().count(), 126);
    let wrong = |cells: &str| {
        let grid = format!("fraction --grid 0,1,0,1,0,2 --cells {cells}");
        folder.fieldstone(&format!("{grid} --particles one.csv --out o.csv")).stderr
    };
    assert!(wrong("5,5").contains("2 numbers were found; give 3, separated by commas, as in 20,20,40 or 20"));
    assert!(wrong("five").contains("'five' stands where a number is expected"), "{}", wrong("five"));
    assert!(wrong("0").contains("--cells"), "{}", wrong("0"));
}

#[test]
fn smoothing_passes_the_periodic_boundary_of_a_grid_and_a_warning_says_where_it_does_not() {
    let folder = Folder::new();
    folder.write("one.dump", one_ball("pp pp ff\n0 10\n0 1\n0 1", "1 0.5 0.5 0.5 0.3"));
    let smooth = |options: &str| {
        let run = folder.succeeds(&format!("fraction --particles one.dump --smooth 1 --out o.csv {options}"));
        let table = CsvTable::read(&folder.path("o.csv")).unwrap();
        (["x", "solid_fraction"].map(|name| table.column(name).unwrap()), run.stderr)
    };
    let ([x, periodic], said) = smooth("--grid 0,10,0,1,0,1 --cells 10,1,1");
    assert_eq!((x[1], x[9], said.as_str()), (1.5, 9.5, ""));
    assert!(periodic[1] > 0.0 && (periodic[1] / periodic[9] - 1.0).abs() < 1e-12, "{periodic:?}");
    let ([_, alone], _) = smooth("--grid 0,10,0,1,0,1 --cells 10,1,1 --periodic none");
    assert!(alone[9] < 1e-3 * alone[1], "{alone:?}");
    // A grid over a part of the box ends there in any case.
    assert_eq!(smooth("--grid 0,5,0,1,0,1 --cells 5,1,1").1, "");
    // One and a half periods have ends that are none for the particles, as a mesh has.
    let warning = smooth("--grid 0,15,0,1,0,1 --cells 15,1,1 --periodic xy").1;
    let said = "--smooth does not pass the periodic boundary along x: it does where --grid spans whole periods of an";
    assert!(warning.contains(said), "{warning}");
    folder.write("cube.dump", one_ball("pp pp pp\n0 1\n0 1\n0 1", "1 0.5 0.5 0.5 0.3"));
    folder.write("cube.vtk", UNIT_CUBE);
    let warning = folder.succeeds("fraction --mesh cube.vtk --particles cube.dump --smooth 0.1 --out m.csv").stderr;
    assert!(warning.contains("--smooth does not pass the periodic boundary along xyz:"), "{warning}");
    assert_eq!(folder.succeeds("fraction --mesh cube.vtk --particles cube.dump --out m.csv").stderr, "");
}

/// A mesh of one cell.
const UNIT_CUBE: &str = "# vtk DataFile Version 2.0\ncube\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n\
    0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1\nCELLS 1 9\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n12\n";

#[test]
fn tables_of_overlaps_agree_with_sixty_digits_and_carry_all_columns_through() {
    let kinds = [ElementKind::Tetrahedron, ElementKind::Wedge, ElementKind::Hexahedron];
    for ((element, faces), kind) in [("tet", 4), ("wedge", 5), ("hex", 6)].into_iter().zip(kinds) {
        let folder = Folder::new();
        folder.copy(&data(&format!("overlap-cases/{element}.csv.gz")), "in.csv.gz");
        let line = format!("overlap --element {element} --cases in.csv.gz --order cgns --bound --out out.csv");
        let run = folder.succeeds(&line);
        assert!(run.stdout.contains("cases                400"), "{}", run.stdout);
        let beyond = run.stdout.lines().find_map(|line| line.strip_prefix("beyond 64 bits ")).unwrap();
        assert!(beyond.trim().parse::<usize>().unwrap() > 50, "huge balls need more digits: {}", run.stdout);

        let given = CsvTable::read(&folder.path("in.csv.gz")).unwrap();
        let found = CsvTable::read(&folder.path("out.csv")).unwrap();
        let mut names = given.names().to_vec();
        names.extend(["volume".into(), "sphere_area".into()]);
        names.extend((0..faces).map(|f| format!("f{f}_area")));
        names.extend(["gradient_x", "gradient_y", "gradient_z", "volume_error"].map(String::from));
        assert_eq!(found.names(), names);
        assert_eq!(found.len(), 400);
        for ((line, after), (_, before)) in found.rows().zip(given.rows()) {
            assert!(after.starts_with(before.trim_end()), "line {line} is not as it was");
        }

        let of = |name: &str| found.column(name).unwrap();
        let (radius, volume, exact, bound) = (of("r"), of("volume"), of("vol_exact"), of("volume_error"));
        let mut areas = vec![(of("sphere_area"), of("area_exact_sphere"))];
        areas.extend((0..faces).map(|f| (of(&format!("f{f}_area")), of(&format!("area_exact_f{f}")))));
        let corners: Vec<[Vec<f64>; 3]> =
            (0..kind.corner_count().unwrap()).map(|k| ["x", "y", "z"].map(|axis| of(&format!("{axis}{k}")))).collect();
        let (mut worst, mut worst_area) = (0.0f64, 0.0f64);
        for row in 0..400 {
            // The table's own numbers are rounded, too: in their last digit, and when they are read.
            let rounding = 1e-15 * exact[row] + 1e-18 * ball(radius[row]).min(1.0);
            let apart = (volume[row] - exact[row]).abs();
            assert!(apart <= bound[row] + rounding, "{element} row {row}: {apart:e} beyond {:e}", bound[row]);
            let points: Vec<[f64; 3]> =
                (0..kind.corner_count().unwrap()).map(|k| corners[k].each_ref().map(|axis| axis[row])).collect();
            let element = Polyhedron::element(kind, CornerOrder::Cgns, &points, Orientation::Refuse).unwrap();
            worst = worst.max(bound[row] / ball(radius[row]).min(element.volume()));
            for (ours, exact) in &areas {
                worst_area = worst_area.max((ours[row] - exact[row]).abs() / (radius[row] * radius[row]).min(1.0));
            }
        }
        println!("{element}: bound of the volumes' errors {worst:.1e}, areas' errors {worst_area:.1e}");
        assert!(worst <= PROMISE && worst_area < 1e-11, "{element}: {worst:e} {worst_area:e}");
    }
    let folder = Folder::new();
    folder.copy(&data("overlap-cases/tet.csv.gz"), "in.csv.gz");
    let message = folder.fails("overlap --element tet --cases in.csv.gz --out o.csv --bound --method cube");
    assert!(message.contains("--bound goes with --method kernel"), "{message}");
}

#[test]
fn corners_are_taken_in_vtk_order_by_default_and_in_cgns_order_where_asked_for() {
    let folder = Folder::new();
    // A prism whose first triangle lies at z = 0, wound inwards (CGNS) or outwards, and a unit square pyramid; a ball
    // on the first corner sees an eighth or, between two slanted faces, less.
    let header = |corners: usize| {
        let names = (0..corners).map(|k| format!("x{k},y{k},z{k}")).collect::<Vec<_>>().join(",");
        format!("note,cx,cy,cz,r,{names}\n")
    };
    let inward = "0,0,0,1,0,0,0,1,0,0,0,1,1,0,1,0,1,1";
    let outward = "0,0,0,0,1,0,1,0,0,0,0,1,0,1,1,1,0,1";
    folder.write("wedge.csv", format!("{}a,0,0,0,0.3,{inward}\nb,0,0,0,0.3,{outward}\n", header(6)));
    let pyramid = "0,0,0,1,0,0,1,1,0,0,1,0,0.5,0.5,1";
    folder.write("pyramid.csv", format!("{}whole,0.5,0.5,0.5,2,{pyramid}\nhalf,0.5,0.5,0,0.1,{pyramid}\n", header(5)));
    for order in ["", "--order cgns", "--order vtk"] {
        folder.succeeds(&format!("overlap --element wedge --cases wedge.csv --out w.csv {order}"));
        let volumes = CsvTable::read(&folder.path("w.csv")).unwrap().column("volume").unwrap();
        assert!(volumes.iter().all(|v| near(*v, ball(0.3) / 8.0)), "{volumes:?}");
        folder.succeeds(&format!("overlap --element pyramid --cases pyramid.csv --out p.csv {order}"));
        let volumes = CsvTable::read(&folder.path("p.csv")).unwrap().column("volume").unwrap();
        assert!(near(volumes[0], 1.0 / 3.0) && near(volumes[1], ball(0.1) / 2.0), "{volumes:?}");
    }
    // One of the two windings is inside out in each order; that is mended above and can be refused.
    for (order, line) in [("cgns", 3), ("vtk", 2)] {
        let message = folder.fails(&format!(
            "overlap --element wedge --cases wedge.csv --out x.csv --order {order} --orientation refuse"
        ));
        assert!(message.contains(&format!("wedge.csv:{line}: the wedge is inside out")), "{message}");
    }
}

#[test]
fn overlap_by_other_methods_gives_the_volume_only() {
    let folder = Folder::new();
    folder.write("tet.csv", "cx,cy,cz,r,x0,y0,z0,x1,y1,z1,x2,y2,z2,x3,y3,z3\n0,0,0,0.5,0,0,0,1,0,0,0,1,0,0,0,1\n");
    let volume = |method: &str| {
        folder.succeeds(&format!("overlap --element tet --cases tet.csv --out o.csv --method {method}"));
        let table = CsvTable::read(&folder.path("o.csv")).unwrap();
        assert!(!table.has("sphere_area"));
        table.column("volume").unwrap()[0]
    };
    assert!(near(volume("decomposition"), ball(0.5) / 8.0));
    assert!(near(volume("kernel-f64"), ball(0.5) / 8.0));
    assert!(near(volume("centre"), ball(0.5)));
    for (method, tolerance) in [("cube", 0.5), ("divided", 1.5), ("sampled:1000", 0.4), ("monte-carlo:1000", 0.2)] {
        let error = (volume(method) / (ball(0.5) / 8.0) - 1.0).abs();
        assert!(error < tolerance, "{method}: {error}");
    }
}

#[test]
fn info_tells_what_is_in_each_kind_of_file() {
    let folder = small_case();
    folder.succeeds("fraction --mesh case --particles balls.csv --out result.vtu");
    folder.succeeds("fraction --grid 0,1,0,1,0,1 --cells 2,3,4 --particles balls.csv --out result.vti");
    folder.copy(&data("gmsh/box_v41_bin.msh"), "box.msh");
    folder.copy(&data("packed-cylinder/packed.dump.gz"), "packed.dump.gz");
    folder.copy(&data("openfoam/cloud/text"), "cloud");
    for (file, expected) in [
        (
            "case",
            vec!["cells                19", "  polyhedron         6", "patch                inlet (patch, 7 faces)"],
        ),
        ("case/constant/polyMesh", vec!["cells                19", "mesh volume          1.0499999999999998"]),
        ("box.msh", vec!["cells", "zone", "mesh volume"]),
        ("result.vtu", vec!["cells                19", "cell column          solid_fraction, 0 to "]),
        ("result.vti", vec!["regular grid         2 × 3 × 4", "cell column          particle_count, 0 to "]),
        ("balls.csv", vec!["particles            6 in", "radius               0.1 smallest, 0.25 largest"]),
        ("packed.dump.gz", vec!["frames               1", "step                 160000", "(3 numbers)"]),
        ("cloud/0.02/lagrangian/kinematicCloud", vec!["particles            5 in"]),
    ] {
        let run = folder.succeeds(&format!("info {file}"));
        for text in expected {
            assert!(run.stdout.contains(text), "info {file} lacks '{text}':\n{}", run.stdout);
        }
    }
}

#[test]
fn the_demo_leaves_a_field_a_picture_and_two_summaries() {
    let folder = Folder::new();
    let run = folder.succeeds("demo results");
    assert!(run.stdout.contains("method") && run.stdout.contains("results in results"), "{}", run.stdout);
    let mut names: Vec<String> =
        folder.files().iter().map(|f| f.0.file_name().unwrap().display().to_string()).collect();
    names.sort();
    assert_eq!(names, ["results", "solid_fraction.png", "solid_fraction.vtu", "summary.json", "summary.txt"]);
    assert!(std::fs::read(folder.path("results/solid_fraction.png")).unwrap().starts_with(b"\x89PNG\r\n\x1a\n"));
    let fraction = column(&folder, "results/solid_fraction.vtu", "solid_fraction");
    assert_eq!(fraction.len(), 6144);
    let summary = json(&folder, "results/summary.json");
    assert_eq!(summary["particles"], 2400);
    let highest = fraction.iter().copied().fold(0.0, f64::max);
    assert!(near(summary["max_solid_fraction"].as_f64().unwrap(), highest));
    assert!(highest > 0.7 && highest < 1.0, "{highest}");
}

#[test]
fn one_thread_and_two_give_the_same_bytes() {
    let folder = bed();
    for threads in [1, 2] {
        let line = format!("fraction --mesh bed --particles packed.dump.gz --out {threads}.vtu --threads {threads}");
        folder.succeeds(&line);
        folder.copy(&data("overlap-cases/hex.csv.gz"), "hex.csv.gz");
        folder.succeeds(&format!("overlap --element hex --cases hex.csv.gz --out {threads}.csv --threads {threads}"));
    }
    for kind in ["vtu", "csv"] {
        let [one, two] = [1, 2].map(|n| std::fs::read(folder.path(&format!("{n}.{kind}"))).unwrap());
        assert!(one == two, "{kind}: other bytes");
    }
}

#[test]
fn verbose_runs_show_where_the_time_went() {
    let run = small_case().succeeds("fraction --mesh case --particles balls.csv --out o.vtu -v");
    for phase in ["read", "search", "overlap", "write", "total"] {
        assert!(run.stdout.lines().any(|line| line.starts_with(phase)), "{phase}: {}", run.stdout);
    }
}

#[test]
fn blanks_and_umlauts_in_names_are_fine() {
    let folder = small_case();
    folder.copy(&folder.path("balls.csv"), "my folder/ein Häufchen.csv");
    let words = ["fraction", "--mesh", "case", "--particles", "my folder/ein Häufchen.csv", "-o", "my folder/ü.vtu"];
    let run = folder.run(words);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(column(&folder, "my folder/ü.vtu", "cell_volume").len(), 19);
}

#[test]
fn completions_and_man_pages_name_the_subcommands() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = folder.succeeds(&format!("completions {shell}")).stdout;
        assert!(script.contains("fraction") && script.contains("parcel-weight"), "{shell}");
    }
    std::fs::create_dir(folder.path("man")).unwrap();
    folder.succeeds("manual man");
    let page = std::fs::read_to_string(folder.path("man/fieldstone-fraction.1")).unwrap();
    assert!(page.contains("parcel") && page.contains("Examples"), "{page}");
    assert!(folder.path("man/fieldstone.1").is_file());
    assert!(folder.fails("manual nowhere").contains("nowhere: this folder does not exist; make it first"));
}

#[test]
fn exit_codes_are_0_for_success_1_for_failure_and_2_for_wrong_usage() {
    let folder = small_case();
    assert_eq!(folder.fieldstone("--help").code, Some(0));
    assert_eq!(folder.fieldstone("--version").code, Some(0));
    assert_eq!(folder.fieldstone("info nothing").code, Some(1));
    let fraction = "fraction --mesh case --particles balls.csv --out o.vtu";
    for wrong in [
        "",
        "frobnicate",
        "fraction",
        "fraction --mesh case --particles balls.csv",
        "fraction --particles balls.csv --out o.vtu",
        "fraction --grid 0,1,0,1,0,1 --particles balls.csv --out o.vti",
        "fraction --grid 0,1,0,1 --cells 1,1,1 --particles balls.csv --out o.vti",
        "fraction --grid 0,1,0,1,0,1 --cells 1,1,-1 --particles balls.csv --out o.vti",
        &format!("{fraction} --radius nan"),
        &format!("{fraction} --radius -1"),
        &format!("{fraction} --diameter 0"),
        &format!("{fraction} --radius 1 --diameter 2"),
        &format!("{fraction} --method magic"),
        &format!("{fraction} --method sampled:0"),
        &format!("{fraction} --cap 1.5"),
        &format!("{fraction} --smooth -1"),
        &format!("{fraction} --parcel-weight -1"),
        &format!("{fraction} --parcel-weight 0"),
        &format!("{fraction} --parcel-weight inf"),
        &format!("{fraction} --parcel-weight nan"),
        &format!("{fraction} --periodic w"),
        &format!("{fraction} --frame half"),
        &format!("{fraction} --threads 0"),
        &format!("{fraction} --threads 100000"),
        &format!("{fraction} --grid 0,1,0,1,0,1 --cells 1,1,1"),
        "overlap --element cone --cases balls.csv --out o.csv",
        "completions tcsh",
    ] {
        let run = folder.fieldstone(wrong);
        assert_eq!(run.code, Some(2), "fieldstone {wrong}\n{}{}", run.stdout, run.stderr);
        assert!(run.stderr.contains("Usage: ") || run.stderr.contains("--help"), "{wrong}: {}", run.stderr);
    }
    assert!(!folder.path("o.vtu").exists());
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_or_a_full_disk_is_no_panic() {
    let folder = small_case();
    let program = |words: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fieldstone"));
        command.args(words).current_dir(folder.path("")).stderr(Stdio::piped());
        command
    };
    for words in [&["info", "balls.csv"][..], &["completions", "bash"], &["info", "case"]] {
        // The reading end is closed before the program writes.
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = program(words).stdout(writer).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));

        let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") else { continue };
        let output = program(words).stdout(full).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1));
        assert!(message.starts_with("error: standard output: cannot write"), "{message}");
    }
}

#[test]
fn the_help_reads_well() {
    let folder = Folder::new();
    insta::assert_snapshot!("help", folder.succeeds("--help").stdout);
    insta::assert_snapshot!("help_fraction", folder.succeeds("fraction --help").stdout);
    insta::assert_snapshot!("help_overlap", folder.succeeds("overlap --help").stdout);
}
