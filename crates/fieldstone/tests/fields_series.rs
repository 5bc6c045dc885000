//! `fieldstone fields` over frames: one file each, means in time, displacements.

#![allow(clippy::unwrap_used)]

mod support;

use std::f64::consts::PI;

use fieldstone::io::vtk;
use support::Folder;
use support::cases::{MERCURY, column, json, mentions, mercury};

#[test]
fn series_become_one_file_per_frame_a_mean_or_a_smoothed_mean() {
    let folder = mercury();
    let momentum = |file: &str| column(&folder, file, "momentum")[0];
    let m = 3.0 * PI / 6.0;
    let near = |a: f64, b: f64| (a - b).abs() < 1e-13;
    folder.succeeds(&format!("{MERCURY} --out all.pvd --json all.json"));
    let steps = vtk::read_pvd(&folder.path("all.pvd")).unwrap();
    assert_eq!(steps, [(0.0, folder.path("all_0.vti")), (1.0, folder.path("all_1.vti"))]);
    assert!(near(momentum("all_0.vti"), m) && near(momentum("all_1.vti"), 3.0 * m));
    assert_eq!(vtk::read_vtk(&folder.path("all_1.vti")).unwrap().time, Some(1.0));
    assert_eq!(json(&folder, "all.json")["frames"], 2);
    folder.succeeds(&format!("{MERCURY} --average --out mean.vti"));
    assert!(near(momentum("mean.vti"), 2.0 * m));
    // Around the first frame the second, one width away, counts e^(−1/2).
    folder.succeeds(&format!("{MERCURY} --smooth 1 --out smooth.pvd"));
    let w = (-0.5f64).exp();
    assert!(near(momentum("smooth_0.vti"), (1.0 + 3.0 * w) / (1.0 + w) * m));
    // Around the middle both count the same.
    folder.succeeds(&format!("{MERCURY} --smooth 1 --out middle.vti"));
    assert!(near(momentum("middle.vti"), 2.0 * m));
    folder.succeeds(&format!("{MERCURY} --frames 0 --out first.vti"));
    assert!(near(momentum("first.vti"), m));
    // Temperature about the window's mean or each frame's: u is 1 and 3, so the variance is 1, a third of it in T.
    for (which, expected) in [("window", 1.0 / 3.0), ("frame", 0.0)] {
        folder.succeeds(&format!(
            "{MERCURY} --average --fields granular_temperature --mean-velocity {which} --out t.vti"
        ));
        assert!(near(column(&folder, "t.vti", "granular_temperature")[0], expected));
    }
    let message = folder.fails(&format!("{MERCURY} --frames : --out two.vti"));
    mentions(&message, &["two.vti: the frames give several results", ".pvd or .stat", "--average"]);
    let message = folder.fails(&format!("{MERCURY} --frames 5: --out two.pvd"));
    mentions(&message, &["box.data: none of the 2 frames, 0 to 1, is in the range 5:; check --frames"]);
    for (range, reason) in [("5", "range 5;"), ("-3", "range -3;"), ("1:0", "range 1:0, which ends before it begins;")]
    {
        let message = folder.fails(&format!("{MERCURY} --frames={range} --out two.pvd"));
        mentions(&message, &["box.data: none of the 2 frames, 0 to 1, is in the", reason]);
    }
}

#[test]
fn frames_computed_at_the_same_time_are_those_of_one_after_the_other() {
    let folder = mercury();
    // Seven frames: more than threads, and no multiple of them.
    let (mut data, mut contacts) = (String::new(), String::new());
    for frame in 0..7 {
        let x = 0.4 + 0.03 * f64::from(frame);
        data += &format!(
            "2 {frame} 0 0 0 2 1 1\n{x} 0.5 0.5 {frame} 0 0 0.5 0 0 0 0 0 0 0\n1.5 0.5 0.5 0 0 1 0.5 0 0 0 0 0 0 0\n"
        );
        contacts += &format!(
            "# {frame} 1\n# 0 0 0 2 1 1\n# 0.5 0.5 0 0 0 0\n{frame} 0 -1 {x} 0.5 0 0 0 {frame} 0 0 0 -1 0 0 0\n"
        );
    }
    folder.write("many.data", data);
    folder.write("many.fstat", contacts);
    let run = |threads: &str, out: &str| {
        let line = format!(
            "fields --particles many.data --contacts many.fstat --density 2 --cells 6 --face-fields faces_{out} --to-particles \
             back_{out} --out {out}"
        );
        let status = std::process::Command::new(env!("CARGO_BIN_EXE_fieldstone"))
            .args(line.split_whitespace())
            .current_dir(folder.path(""))
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap();
        assert!(status.status.success(), "{}", String::from_utf8_lossy(&status.stderr));
        let steps = vtk::read_pvd(&folder.path(out)).unwrap();
        steps
            .into_iter()
            .map(|(time, path)| (time, column(&folder, path.file_name().unwrap().to_str().unwrap(), "density")))
            .collect::<Vec<_>>()
    };
    let one = run("1", "one.pvd");
    assert_eq!(one.len(), 7);
    assert_eq!(run("4", "four.pvd"), one);
    for frame in 0..7 {
        // Each by itself, but for the settings that the file repeats.
        folder.succeeds(&format!(
            "fields --particles many.data --contacts many.fstat --density 2 --cells 6 --frames {frame} --out alone.vti"
        ));
        for name in ["density", "contact_stress"] {
            let alone = column(&folder, "alone.vti", name);
            assert_eq!(column(&folder, &format!("four_{frame}.vti"), name), alone, "{name} of frame {frame}");
        }
        let same = |name: &str| [format!("{name}_one_{frame}.vtp"), format!("{name}_four_{frame}.vtp")];
        for [a, b] in [same("faces"), same("back")] {
            assert_eq!(
                vtk::read_vtk(&folder.path(&a)).unwrap().cell_data,
                vtk::read_vtk(&folder.path(&b)).unwrap().cell_data
            );
        }
    }
}

#[test]
fn bounds_taken_from_the_first_frames_particles_are_told_and_belong_to_the_result() {
    let folder = Folder::new();
    let frame = |x: f64| format!("x,y,z,radius,mass\n0,0,0,0.5,2\n{x},0,0,0.5,1\n");
    folder.write("balls_0.csv", frame(1.0));
    folder.write("balls_1.csv", frame(9.0));
    let line = "fields --particles balls_*.csv --cells 2,1,1 --fields density";
    let run = folder.succeeds(&format!("{line} --average --out mean.csv"));
    let bounds = "--grid=-0.5,1.5,-0.5,0.5,-0.5,0.5";
    mentions(&run.stderr, &["balls_0.csv, frame 0: the files state no box", bounds, "give bounds that hold them all"]);
    mentions(&run.stdout, &["16.6667 %"]);
    let repeated = |file: &str| std::fs::read_to_string(folder.path(file)).unwrap();
    mentions(&repeated("mean.csv"), &["grid = [-0.5, 1.5, -0.5, 0.5, -0.5, 0.5]"]);
    // The same bounds, given, need no warning and lead to the same numbers.
    let given = folder.succeeds(&format!("{line} {bounds} --average --out given.csv"));
    assert!(!given.stderr.contains("no box"), "{}", given.stderr);
    assert_eq!(repeated("given.csv").replace("given.csv", "mean.csv"), repeated("mean.csv"));
    // A box, from a file or from the command line, is where the cells reach in any frame.
    let boxed = folder.succeeds(&format!("{line} --box 0,9,0,1,0,1 --periodic none --average --out boxed.csv"));
    assert!(!boxed.stderr.contains("no box") && !repeated("boxed.csv").contains("grid ="), "{}", boxed.stderr);
    // Around an axis both the bounds and the place of the axis are taken.
    let line = "fields --particles balls_*.csv --coordinates R --cells 1 --fields density --average";
    let around = folder.succeeds(&format!("{line} --out around.csv"));
    mentions(&around.stderr, &["--grid=0,0.5,0,1 --origin=0.5,0,-0.5"]);
    mentions(&repeated("around.csv"), &["grid = [0.0, 0.5, 0.0, 1.0]", "origin = [0.5, 0.0, -0.5]"]);
    let given = folder.succeeds(&format!("{line} --grid=0,0.5,0,1 --origin=0.5,0,-0.5 --out given.csv"));
    assert!(!given.stderr.contains("no box"), "{}", given.stderr);
    assert_eq!(repeated("given.csv").replace("given.csv", "around.csv"), repeated("around.csv"));
}

#[test]
fn braces_in_the_names_of_results_are_refused_with_the_way_to_a_result_for_each_frame() {
    let folder = mercury();
    for (names, parts) in [
        ("--out density_{}.vti", ["--out density_{}.vti: names are not numbered here", ".pvd file, or a .stat file,"]),
        ("--face-fields faces_{}.vtp --out a.vti", ["--face-fields faces_{}.vtp: names are", "give a .pvd file"]),
        ("--to-particles back_{}.csv --out a.vti", ["--to-particles back_{}.csv: names are", "give a .pvd file"]),
        ("--json a_{}.json --out a.vti", ["--json a_{}.json: this is one file, and {} in its name", "leave it out"]),
    ] {
        mentions(&folder.fails(&format!("{MERCURY} {names}")), &parts);
    }
    let message = folder.fails("fraction --particles box.data --grid 0,1,0,1,0,1 --cells 1 --out a_{}.vti");
    mentions(&message, &["--out a_{}.vti: this is one file, and {} in its name would stay as it is"]);
}

#[test]
fn files_of_a_series_never_take_the_name_of_an_input() {
    let folder = Folder::new();
    let balls = "x,y,z,radius,mass,vx,vy,vz\n0.5,0.5,0.5,0.25,1,0,0,0\n";
    folder.write("balls.csv", balls);
    let cells = "--grid 0,1,0,1,0,1 --cells 2 --fields density";
    folder.succeeds(&format!("fields --particles balls.csv {cells} --to-particles run_1.vtp --out run_7.vti"));
    for (line, input) in [
        ("fields --particles run_1.vtp --to-particles run.pvd --out out.pvd", "run_1.vtp"),
        ("fields --particles run_1.vtp --face-fields run.pvd --out out.pvd", "run_1.vtp"),
        ("fields --particles balls.csv --out run.pvd --json run_3.vti", "run_3.vti"),
    ] {
        let message = folder.fails(&format!("{line} {cells}"));
        mentions(&message, &["run.pvd", "run_NUMBER.vt", &format!("could overwrite {input}"), "choose another name"]);
    }
    // Results of an earlier run are replaced.
    folder.succeeds(&format!("fields --particles balls.csv {cells} --out run.pvd"));
}

#[test]
fn the_last_frame_has_no_displacement_and_is_not_counted() {
    let folder = Folder::new();
    for (number, x) in [(0, 0.4), (1, 0.5), (2, 0.6)] {
        folder.write(&format!("f_{number}.csv"), format!("id,x,y,z,radius,mass\n1,{x},0.5,0.5,0.1,1\n"));
    }
    let fields = "fields --particles f_{}.csv --grid 0,1,0,1,0,1 --cells 1 --fields density,displacement";
    let run = folder.succeeds(&format!("{fields} --out s.pvd --json s.json"));
    mentions(&run.stdout, &["frames               2\n"]);
    mentions(&run.stderr, &["warning: f_2.csv, frame 2: there is no next frame to be displaced to"]);
    mentions(&std::fs::read_to_string(folder.path("s.json")).unwrap(), &["\"frames\": 2"]);
    assert_eq!(vtk::read_pvd(&folder.path("s.pvd")).unwrap().len(), 2);
    // By default one result comes of the last two frames, and nothing is missing.
    let run = folder.succeeds(&format!("{fields} --out s.vti"));
    mentions(&run.stdout, &["frames               1\n"]);
    assert_eq!(run.stderr, "");
    mentions(
        &folder.fails(&format!("{fields} --frames 2 --out t.vti")),
        &["f_2.csv, frame 2: displacements are those to the next frame", "give at least two (--frames)"],
    );
}

#[test]
fn a_mean_around_a_time_without_frames_is_told_with_the_times_and_what_to_do() {
    let folder = Folder::new();
    for number in [9, 10, 100] {
        folder.write(&format!("f_{number}.dump"), frame_at(number));
    }
    let fields = "fields --particles f_{}.dump --cells 1 --density 1 --fields density --out s.csv";
    // The middle of 9 and 100 is 54.5, and 10 is nearest: 44.5 away.
    mentions(
        &folder.fails(&format!("{fields} --smooth 1")),
        &["--smooth 1", "around 54.5", "within three widths", "f_10.dump, frame 1, at 10", "a larger width", ".pvd"],
    );
    folder.succeeds(&format!("{fields} --smooth 15"));
}

/// A dump of one ball at a step.
fn frame_at(step: u32) -> String {
    format!(
        "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n\
         ITEM: ATOMS id x y z radius\n1 .5 .5 .5 .1\n"
    )
}

#[test]
fn frames_whose_times_do_not_rise_are_told_and_have_no_displacements() {
    let folder = Folder::new();
    for (steps, times) in [([4500, 4000], "its time is 4000"), ([4000, 4000], "its time is 4000")] {
        folder.write("a.dump", steps.map(frame_at).concat());
        let fields = "fields --particles a.dump --density 1 --cells 1 --fields";
        let told = folder.succeeds(&format!("{fields} density --out o.pvd")).stderr;
        let before = format!("frame 0, is {}", steps[0]);
        mentions(&told, &["a.dump, frame 1", times, &before, "times do not rise"]);
        for (options, what) in
            [("displacement --out d.pvd", "displacement"), ("density --smooth 100 --out d.pvd", "--smooth")]
        {
            let message = folder.fails(&format!("{fields} {options}"));
            mentions(&message, &["a.dump, frame 1", times, &before, &format!("{what} needs times that rise")]);
            assert!(!folder.path("d.pvd").exists());
        }
    }
    folder.write("a.dump", [4000, 4500].map(frame_at).concat());
    let told = folder.succeeds("fields --particles a.dump --density 1 --cells 1 --fields displacement --out o.pvd");
    assert!(!told.stderr.contains("times do not rise"));
}

#[test]
fn the_number_in_the_name_is_the_step_where_files_state_neither_step_nor_time() {
    let folder = Folder::new();
    for step in [26000, 26500, 30000] {
        folder.write(&format!("part_{step}.csv"), "x,y,z,radius\n.5,.5,.5,.1\n");
        folder.write(&format!("{}.csv", ["a", "b", "c"][step % 3]), "x,y,z,radius\n.5,.5,.5,.1\n");
    }
    let times = |options: &str| {
        let told =
            folder.succeeds(&format!("fields {options} --density 1 --cells 1 --fields density --out o.pvd")).stderr;
        let steps = vtk::read_pvd(&folder.path("o.pvd")).unwrap();
        (steps.into_iter().map(|(time, _)| time).collect::<Vec<_>>(), told)
    };
    assert_eq!(times("--particles part_*.csv").0, [26000.0, 26500.0, 30000.0]);
    let (found, told) = times("--particles part_*.csv --timestep 0.5 --frames 1:");
    assert_eq!(found, [13250.0, 15000.0]);
    assert!(!told.contains("equally spaced"), "{told}");
    let (found, told) = times("--particles ?.csv --timestep 0.5");
    assert_eq!(found, [0.0, 0.5, 1.0]);
    mentions(&told, &["a.csv: the frames state neither time nor step", "equally spaced, 0.5 apart"]);
}

#[test]
fn frames_that_a_pvd_lists_have_its_times() {
    let folder = Folder::new();
    let ball = |x: f64| format!("id,x,y,z,radius,mass\n1,{x},0.5,0.5,0.1,1\n");
    folder.write("a.csv", ball(0.3));
    folder.write("b.csv", ball(0.6));
    let entry = |time: f64, file: &str| format!("<DataSet timestep=\"{time}\" part=\"0\" file=\"{file}\"/>");
    let list = format!("<Collection>{}{}</Collection>", entry(0.5, "b.csv"), entry(2.5, "a.csv"));
    folder.write(
        "frames.pvd",
        format!("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">{list}</VTKFile>\n"),
    );
    let fields = "fields --particles frames.pvd --grid 0,1,0,1,0,1 --cells 2,1,1 --fields density,displacement";
    let run = folder.succeeds(&format!("{fields} --out out.pvd"));
    assert!(!run.stderr.contains("equally spaced"), "{}", run.stderr);
    let found = vtk::read_pvd(&folder.path("out.pvd")).unwrap();
    assert_eq!(found.len(), 1, "the last frame has no displacement");
    assert_eq!(found[0].0, 0.5);
    let density = vtk::read_vtk(&found[0].1).unwrap().array("density").unwrap().values.to_f64();
    assert!((density[1] - 2.0).abs() < 1e-12 && density[0] < 1e-20, "{density:?}");
}

#[test]
fn a_series_that_cannot_be_written_as_a_whole_leaves_what_was_there_before() {
    let folder = mercury();
    folder.write("all_0.vti", "before");
    std::fs::create_dir(folder.path("all_1.vti")).unwrap();
    mentions(&folder.fails(&format!("{MERCURY} --out all.pvd")), &["all_1.vti: there is a folder of this name"]);
    assert_eq!(std::fs::read_to_string(folder.path("all_0.vti")).unwrap(), "before");
    assert!(!folder.path("all.pvd").exists());
    std::fs::remove_dir(folder.path("all_1.vti")).unwrap();
    folder.succeeds(&format!("{MERCURY} --out all.pvd"));
    assert_eq!(vtk::read_pvd(&folder.path("all.pvd")).unwrap().len(), 2);
    assert_ne!(std::fs::read_to_string(folder.path("all_0.vti")).unwrap_or_default(), "before");
}

/// A dump of three frames in a box of 1: none, one and none particle of radius 0.1 in the middle.
const POUR: &str = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n0\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n\
    ITEM: ATOMS id type x y z vx vy vz radius mass\n\
    ITEM: TIMESTEP\n1\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n\
    ITEM: ATOMS id type x y z vx vy vz radius mass\n1 1 0.5 0.5 0.5 1 0 0 0.1 3\n\
    ITEM: TIMESTEP\n2\nITEM: NUMBER OF ATOMS\n0\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n\
    ITEM: ATOMS id type x y z vx vy vz radius mass\n";

#[test]
fn frames_without_particles_are_fields_of_zero_and_count_in_means() {
    let folder = Folder::new();
    folder.write("pour.dump", POUR);
    let run = folder.succeeds("fields --particles pour.dump --cells 1 --quantity m=mass:sum --out all.pvd");
    mentions(&run.stderr, &["warning: pour.dump, frame 0: the frame holds no particle", "pour.dump, frame 2: "]);
    for (frame, mass) in [(0, 0.0), (1, 3.0), (2, 0.0)] {
        let file = format!("all_{frame}.vti");
        assert!((column(&folder, &file, "density")[0] - mass).abs() < 1e-12, "{frame}");
        assert!((column(&folder, &file, "m")[0] - mass).abs() < 1e-12, "{frame}");
    }
    folder.succeeds("fields --particles pour.dump --cells 1 --average --out mean.vti");
    assert!((column(&folder, "mean.vti", "density")[0] - 1.0).abs() < 1e-12);
    assert!((column(&folder, "mean.vti", "momentum")[0] - 1.0).abs() < 1e-12);
    let run = folder.succeeds("fraction --particles pour.dump --frame 0 --grid 0,1,0,1,0,1 --cells 2 --out none.vti");
    mentions(&run.stderr, &["warning: pour.dump: the frame holds no particle"]);
    assert_eq!(column(&folder, "none.vti", "solid_fraction"), [0.0; 8]);
    // Without a box there is nothing to lay cells over.
    folder.write("none.csv", "x,y,z,radius,mass\n");
    let run = folder.fieldstone("fields --particles none.csv --cells 1 --fields density --out none.vti");
    assert_eq!(run.code, Some(1));
    mentions(&run.stderr, &["error: ", "the first frame holds no particle", "--grid"]);
}
