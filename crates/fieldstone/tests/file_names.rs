//! Names of files that stand for something else: patterns, lists, standard streams, options.

#![allow(clippy::unwrap_used)]

mod support;

use fieldstone_testing::data;
use support::Folder;
use support::cases::{MERCURY, mentions, mercury, small_case};

#[test]
fn fraction_takes_one_frame_of_a_pattern_or_a_list() {
    let folder = Folder::new();
    for k in 0..3 {
        folder.write(&format!("balls_{k}.csv"), format!("x,y,z,radius\n0.5,0.5,0.5,0.{}\n", k + 1));
    }
    let line = "fraction --grid 0,1,0,1,0,1 --cells 1 --json a.json --out a.vti";
    let volume = |arguments: &str| {
        folder.succeeds(&format!("{line} {arguments}"));
        let text = std::fs::read_to_string(folder.path("a.json")).unwrap();
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        json["particle_volume"].as_f64().unwrap()
    };
    let ball = |r: f64| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3);
    let near = |a: f64, b: f64| (a - b).abs() < 1e-14;
    // As everywhere, the last frame where none is asked for.
    assert!(near(volume("--particles balls_*.csv"), ball(0.3)));
    assert!(near(volume("--particles balls_{}.csv --frame 1"), ball(0.2)));
    let files: String = [2, 0].map(|k| format!("<DataSet timestep=\"{k}\" file=\"balls_{k}.csv\"/>")).concat();
    folder.write("run.pvd", format!("<VTKFile type=\"Collection\"><Collection>{files}</Collection></VTKFile>"));
    assert!(near(volume("--particles run.pvd --frame 0"), ball(0.3)));
    assert!(near(volume("--particles run.pvd"), ball(0.1)));
    let message = folder.fails(&format!("{line} --particles balls_*.csv --frame 3"));
    mentions(&message, &["--particles balls_*.csv: none of the 3 frames, 0 to 2, is in the range 3", "check --frame"]);
    let message = folder.fails("fraction --grid 0,1,0,1,0,1 --cells 1 --particles balls_*.csv --out balls_1.csv");
    mentions(&message, &["--out balls_1.csv: this would overwrite another file of this run"]);
}

#[test]
fn a_summary_for_standard_output_is_all_that_goes_there() {
    let folder = mercury();
    folder.write("block.csv", "x,y,z\n0,0,0\n1,0,0\n0,1,0\n0,0,1\n1,1,1\n1,1,0\n0,1,1\n1,0,1\n");
    let case = folder.succeeds("sph new hydrostatic --spacing 0.1").stdout;
    folder.write("case.toml", case);
    for (line, key, report) in [
        (format!("{MERCURY} --out a.vti"), "mass_in", "written to"),
        (
            "fraction --particles box.data --grid 0,2,0,1,0,1 --cells 1 --out a.vti".into(),
            "particle_volume",
            "written to",
        ),
        ("detect --particles block.csv --spacing 1 --out a.vtp".into(), "free_surface", "written to"),
        ("surface --particles block.csv --spacing 1 --out a.vtp".into(), "triangles", "written to"),
        ("sph check case.toml".into(), "fluid", "estimated time"),
    ] {
        let run = folder.succeeds(&format!("{line} --json -"));
        let json: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
        assert!(!json[key].is_null() && run.stderr.contains(report), "{line}: {}", run.stderr);
        assert!(!folder.path("-").exists(), "{line}");
    }
}

#[test]
fn a_dash_elsewhere_is_refused_with_what_standard_streams_are_called() {
    let folder = small_case();
    folder.write("far.csv", "cx,cy,cz,r,x0,y0,z0,x1,y1,z1,x2,y2,z2,x3,y3,z3\n9,9,9,1,0,0,0,1,0,0,0,1,0,0,0,1\n");
    mentions(&folder.fails("overlap --element tet --cases far.csv --out -"), &["--out -: ", "/dev/stdout"]);
    for line in ["info -", "fields --particles - --cells 1 --out a.vti", "detect --particles - --out a.vtp"] {
        mentions(&folder.fails(line), &["-: cannot open: there is no file of this name", "/dev/stdin"]);
    }
    mentions(&folder.fails("sph run - --out results"), &["for standard input give /dev/stdin"]);
}

#[test]
fn a_file_whose_name_begins_as_an_option_does_is_told_how_to_be_written() {
    let folder = Folder::new();
    folder.write("-neg.csv", "x,y,z,radius\n0,0,0,1\n");
    for line in ["info -neg.csv", "detect --particles -neg.csv --out a.vtp"] {
        let run = folder.fieldstone(line);
        assert_eq!(run.code, Some(2), "{}", run.stderr);
        mentions(&run.stderr, &["-neg.csv is taken for an option", "write ./-neg.csv"]);
    }
    folder.succeeds("info ./-neg.csv");
    let run = folder.fieldstone("info --no-such-option");
    assert!(run.code == Some(2) && run.stderr.contains("unexpected argument '--no-such-option'"), "{}", run.stderr);
}

#[test]
fn the_cloud_of_a_decomposed_case_is_read_processor_by_processor() {
    let folder = Folder::new();
    let cloud = data("openfoam/cloud/text/0.02/lagrangian/kinematicCloud");
    folder.copy(&cloud, "whole/0.02/lagrangian/kinematicCloud");
    for processor in [0, 1, 10] {
        folder.copy(&cloud, &format!("dec/processor{processor}/0.02/lagrangian/kinematicCloud"));
    }
    std::fs::create_dir_all(folder.path("dec/processor2/0.02")).unwrap();
    let one = folder.succeeds("info whole/0.02/lagrangian").stdout;
    mentions(&one, &["particles            5 in"]);
    for name in ["dec/0.02", "dec/0.02/lagrangian/kinematicCloud", "dec/processor*/0.02/lagrangian/kinematicCloud"] {
        mentions(
            &folder.succeeds(&format!("info {name}")).stdout,
            &["particles            15 in", "time                 0.02"],
        );
    }
    folder.succeeds("fields --particles dec/0.02 --grid 0,2,0,2,0,2 --cells 1 --fields density --out a.vti");
    // Columns keep the names that the parts have for them.
    let named =
        "fields --particles dec/0.02 --grid 0,2,0,2,0,2 --cells 1 --fields density --quantity size=d:sum --out d.vti";
    folder.succeeds(named);
    mentions(&folder.fails("info dec/0.04"), &["dec/0.04: cannot open"]);
}
