//! What `fieldstone fields` says of input that cannot be meant.

#![allow(clippy::unwrap_used)]

mod support;

use support::Folder;
use support::cases::{GRAINS, MERCURY, column, grains, mentions, mercury};

#[test]
fn wrong_input_is_named_with_its_place_and_a_remedy() {
    let folder = grains();
    let edit = |file: &str, from: &str, to: &str| {
        let text = std::fs::read_to_string(folder.path(file)).unwrap();
        assert!(text.contains(from), "{file}: {from}");
        folder.write(&format!("bad_{file}"), text.replacen(from, to, 1));
    };
    let mut all = String::new();
    let mut show = |line: String| {
        let message = folder.fails(&line);
        all.push_str(&format!("$ fieldstone {line}\n{message}\n"));
    };
    edit("pair.dump", " 9922 ", " 4711 ");
    let bad = GRAINS.replace("pair.dump", "bad_pair.dump");
    show(format!("{bad} --cells 2 --out out.vti"));
    edit("pair.dump", "\n26001\n", "\n26002\n");
    show(format!("{bad} --cells 2 --out out.vti"));
    folder.write("balls.csv", "x,y,z,radius,vx,vy,vz,s1,s2\n0,0,0,1,0,0,0,1,2\n");
    show("fields --particles balls.csv --cells 2 --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --quantity s=s1,s2 --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --quantity s=s3 --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --fields contact_stress --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --fields speed --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --function lucy --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --width 1 --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --grid 0,0,0,1,1,1 --out out.vti".into());
    show("fields --particles balls.csv --density 1 --out out.vti".into());
    show("fields --particles balls.csv --density 1 --cells 2,2 --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --coordinates RZ --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --out out.vtu".into());
    show("fields --particles balls.csv --cells 2 --density 1 --periodic x --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --out balls.csv".into());
    show("fields --particles balls.csv --cells 2 --mass-column weight --out out.vti".into());
    show("fields --cells 2 --out out.vti".into());
    insta::assert_snapshot!("fields_messages", all);

    let folder = mercury();
    let text = std::fs::read_to_string(folder.path("box.fstat")).unwrap();
    let second = text.rfind("# 1 1").unwrap();
    folder.write("box.fstat", &text[..second]);
    mentions(
        &folder.fails(&format!("{MERCURY} --out out.stat")),
        &["box.fstat: there are no more contacts for frame 1 of box.data"],
    );
    folder.write("box.fstat", &text);
    mentions(
        &folder.fails("fields --particles box.data --contacts box.fstat --cells 2 --out out.stat"),
        &["box.data, frame 0: the particles have neither a column 'mass' nor 'density'", "--restart"],
    );
}

#[test]
fn fields_that_hold_nothing_are_refused_with_what_led_to_them() {
    let folder = Folder::new();
    folder
        .write("balls.csv", "x,y,z,radius,mass,vx,vy,vz,type\n0.3,0.3,0.3,0.1,1,0,0,0,1\n0.7,0.7,0.7,0.2,1,0,0,0,2\n");
    let fields = "fields --particles balls.csv --fields density --out out.vti";
    let unit = "--grid 0,1,0,1,0,1 --cells 4";
    for (line, parts) in [
        (
            "--grid 10,11,0,1,0,1 --cells 4".into(),
            &["balls.csv in the grid: none of the 2 particles", "check units"][..],
        ),
        (format!("{unit} --species 7"), &["--species: balls.csv: no particle is of type 7; the types are 1, 2"]),
        (format!("{unit} --radii 1,0"), &["--radii", "radii from 1 to 0", "the smaller number first"]),
        (format!("{unit} --region 5,0,0,1,0,1"), &["--region", "x of the region from 5 to 0", "smaller number first"]),
        (format!("{unit} --radii 1,2"), &["none of the 2 particles is left by", "radii are 0.1 to 0.2"]),
        (format!("{unit} --region 5,6,0,1,0,1"), &["is left by", "span (0.3, 0.3, 0.3) to (0.7, 0.7, 0.7)"]),
        (
            // The nearest centre of a cell is (0.075² · 3)^½ = 0.13 away.
            format!("{unit} --function gauss --width 1 --cutoff 0.05"),
            &["no cell's centre lies within 0.05 of a particle", "--cutoff, or smaller cells"],
        ),
    ] {
        mentions(&folder.fails(&format!("{fields} {line}")), parts);
    }
    // One of several types may be missing, but not in silence.
    let run = folder.succeeds(&format!("{fields} {unit} --species 1,7"));
    mentions(&run.stderr, &["warning: --species: no particle is of type 7; the types are 1, 2"]);
    // A series in which one frame has nothing in the cells is fine.
    let ball = |x: f64| format!("x,y,z,radius,mass,vx,vy,vz\n{x},0.5,0.5,0.1,1,0,0,0\n");
    folder.write("f_0.csv", ball(0.5));
    folder.write("f_1.csv", ball(9.5));
    folder.succeeds(&format!("fields --particles f_{{}}.csv {unit} --fields density --out out.pvd"));
    mentions(
        &folder.fails(&format!("fields --particles f_{{}}.csv --frames 1 {unit} --fields density --out out.pvd")),
        &["f_0.csv in the grid: none of the 1 particles lies in the mesh"],
    );
}

#[test]
fn masses_that_cannot_be_are_told_with_file_column_and_value() {
    let folder = Folder::new();
    let fields = |header: &str, row: &str, options: &str| {
        folder.write("b.csv", format!("x,y,z,radius{header}\n0.5,0.5,0.5,0.25{row}\n"));
        folder.fails(&format!("fields --particles b.csv --cells 2 --out o.vti --fields density,velocity {options}"))
    };
    mentions(&fields(",mass", ",nan", ""), &["b.csv, frame 0: particle 0 has mass = NaN"]);
    mentions(&fields(",mass", ",-1", ""), &["b.csv, frame 0: particle 0: the column 'mass' holds -1.0"]);
    mentions(&fields(",w", ",-1", "--mass-column w"), &["--mass-column w: b.csv, frame 0: particle 0 has -1"]);
    mentions(&fields("", "", ""), &["b.csv, frame 0", "(they have: no other columns)"]);
    mentions(&fields(",mass,vx,vy,vz", ",1,nan,0,0", ""), &["b.csv, frame 0: particle 0 has velocity = NaN"]);
}

#[test]
fn an_unknown_mean_of_a_quantity_is_told_with_those_that_there_are() {
    let folder = Folder::new();
    folder.write("b.csv", "x,y,z,radius,mass,s:0\n0.5,0.5,0.5,0.25,2,7\n");
    let fields = "fields --particles b.csv --cells 2 --fields density --out o.vti";
    mentions(
        &folder.fails(&format!("{fields} --quantity m=mass:avg")),
        &["there is no column 'mass:avg'", "if 'avg' is no part", "choose one of sum, mass-mean, volume-mean"],
    );
    // Names of columns may hold a colon themselves.
    folder.succeeds(&format!("{fields} --quantity m=s:0 --quantity n=s:0:mass-mean"));
    assert_eq!(column(&folder, "o.vti", "n")[0], 7.0);
    let message = folder.fails(&format!("{fields} --quantity m=weight"));
    assert!(message.contains("'weight'") && !message.contains("choose one of sum"), "{message}");
}

#[test]
fn contacts_that_are_given_twice_are_refused_or_told() {
    let folder = grains();
    let twice = format!("{GRAINS} --contacts ./pair.dump --contacts-preset liggghts-pair --cells 2 --out o.vti");
    mentions(&folder.fails(&twice), &["--contacts ./pair.dump: the file is given twice, also as pair.dump"]);
    // A copy has another name.
    folder.copy(&folder.path("pair.dump"), "copy.dump");
    let told = folder.succeeds(&twice.replace("./pair.dump", "copy.dump")).stderr;
    mentions(&told, &["contacts of frame 0 of part.dump, 4 are there again", "is of particle ", "every file, once"]);
    assert!(!folder.succeeds(&format!("{GRAINS} --cells 2 --out o.vti")).stderr.contains("there again"));
    // The same row twice.
    folder.write("balls.csv", "id,x,y,z,radius\n7,0,0,0,1\n9,1.9,0,0,1\n");
    folder.write("rows.csv", "id1,id2,fx,fy,fz\n7,9,-2,0,0\n7,9,-2,0,0\n7,9,-1,0,0\n");
    let line =
        "fields --particles balls.csv --contacts rows.csv --density 1 --cells 2 --fields contact_stress --out o.vti";
    mentions(
        &folder.succeeds(line).stderr,
        &["rows.csv: of the 3 contacts of frame 0 of balls.csv, 1 are there again", "particle 7 with particle 9"],
    );
    assert!(!folder.succeeds(line).stderr.contains("a wall is a mesh"));
}

#[test]
fn contacts_with_triangles_of_a_wall_that_are_alike_are_told_to_be_kept() {
    let folder = grains();
    // Two coplanar triangles of a floor, at the edge between them.
    folder.write("balls.csv", "id,x,y,z,radius\n7,0,0,0,1\n9,1.9,0,0,1\n");
    folder.write("walls.csv", "id1,id2,fx,fy,fz,px,py,pz\n7,-1,0,0,1,0,0,-1\n7,-1,0,0,1,0,0,-1\n");
    let line =
        "fields --particles balls.csv --contacts walls.csv --density 1 --cells 2 --fields contact_stress --out o.vti";
    mentions(
        &folder.succeeds(line).stderr,
        &["1 are there again", "with wall", "1 of them are with walls", "each of its triangles", "keep those"],
    );
}

#[test]
fn a_table_without_a_line_of_names_is_read_with_a_warning() {
    let folder = grains();
    folder.write("bare.csv", "1 0.5 0.5 0.5\n");
    folder.write("named.csv", "x y z r\n1 0.5 0.5 0.5\n");
    for command in ["fields --density 1 --cells 2 --fields density", "fraction --grid 0,2,0,1,0,1 --cells 2"] {
        let bare = folder.succeeds(&format!("{command} --particles bare.csv --out o.vti")).stderr;
        mentions(&bare, &["warning: there is no line of names: the columns are taken as x y z radius", "id,x,y,z"]);
        let named = folder.succeeds(&format!("{command} --particles named.csv --out o.vti")).stderr;
        assert!(!named.contains("line of names"), "{named}");
    }
}

#[test]
fn a_file_of_contacts_that_was_cut_between_two_lines_is_told_with_the_number_of_pairs() {
    let folder = mercury();
    let text = std::fs::read_to_string(folder.path("box.fstat")).unwrap();
    // A third ball, and a pair of which only the first line is there.
    let data = std::fs::read_to_string(folder.path("box.data")).unwrap();
    let more = "0.5 0.5 1.4 0 0 0 0.5 0 0 0 0 0 0 0\n";
    let last = data.rfind("2 1 0 0 0 2 1 1").unwrap();
    folder.write("box.data", data[last..].replacen('2', "3", 1) + more);
    let last = text.rfind("# 1 1\n").unwrap();
    folder.write("box.fstat", format!("{}1 0 2 0.5 0.5 1 0.1 0 2 0 0 0 -1 0 0 0\n", &text[last..]));
    let told = folder.succeeds(&format!("{MERCURY} --out o.vti")).stderr;
    mentions(&told, &["1 of 2 pairs are listed from one side only", "cut or damaged", "leave this frame out"]);
}

#[test]
fn a_cut_off_is_refused_for_kernels_that_end_at_their_width() {
    let folder = Folder::new();
    folder.write("one.csv", "x,y,z,radius\n0.5,0.5,0.5,0.2\n");
    let fields = "fields --particles one.csv --density 1 --fields density --grid 0,1,0,1,0,1 --cells 4 --width 0.5";
    for function in ["lucy", "heaviside", "linear"] {
        let message = folder.fails(&format!("{fields} --function {function} --cutoff 1 --out one.vti"));
        mentions(&message, &["--cutoff: only a Gaussian has a cut-off", "leave the cut-off out"]);
    }
    folder.succeeds(&format!("{fields} --function gauss --cutoff 1 --out one.vti"));
}

#[test]
fn a_kernel_or_radius_that_dwarfs_the_periodic_box_is_refused_with_its_file() {
    let folder = Folder::new();
    folder.write("one.csv", "x,y,z,radius\n0.5,0.5,0.5,0.2\n");
    let fields = "fields --particles one.csv --density 1 --fields density --box 0,1,0,1,0,1 --periodic xyz --cells 2";
    for (options, parts) in [
        ("--radius 2000", ["one.csv, frame 0: particle 0 has radius 2000", "only 1 long"]),
        ("--function gauss --width 300", ["copies of the periodic box are within reach", "the width of a kernel"]),
    ] {
        mentions(&folder.fails(&format!("{fields} {options} --out one.vti")), &parts);
    }
}

#[test]
fn files_whose_names_have_numbers_in_other_places_are_taken_in_their_order() {
    let folder = Folder::new();
    for name in ["1out.csv", "out.csv"] {
        folder.write(name, "x,y,z,radius\n0.5,0.5,0.5,0.2\n");
    }
    let line = "fields --particles *out.csv --density 1 --fields density --cells 2 --grid 0,1,0,1,0,1 --out all.pvd";
    folder.succeeds(line);
    assert!(folder.path("all_0.vti").is_file() && folder.path("all_1.vti").is_file());
}

#[test]
fn a_function_of_the_command_line_leaves_the_files_kernel_behind() {
    let folder = mercury();
    let settings = "particles = \"box.data\"\nrestart = \"box.restart\"\ncells = [2, 1, 1]\nfields = [\"density\", \"velocity\"]\n";
    folder
        .write("kernel.toml", format!("{settings}function = \"gauss\"\nwidth = 0.5\ncutoff = 1.5\nconserve = true\n"));
    folder.write("plain.toml", settings);
    folder.succeeds("fields kernel.toml --function exact --out exact.csv");
    folder.succeeds("fields plain.toml --function exact --out plain.csv");
    let text = |file: &str| std::fs::read_to_string(folder.path(file)).unwrap();
    assert_eq!(text("exact.csv").replace("exact.csv", "plain.csv"), text("plain.csv"));
    mentions(&text("plain.csv"), &["density", "velocity_x", "fields = \"density,velocity\""]);
    assert!(!text("plain.csv").contains("momentum"), "no more fields than the list names");
    // Another kernel keeps the width, but not a Gaussian's cut-off, and what the command line itself says is not dropped.
    folder.succeeds("fields kernel.toml --function lucy --out lucy.csv");
    mentions(&text("lucy.csv"), &["function = \"lucy\"", "width = 0.5", "conserve = true"]);
    mentions(&folder.fails("fields plain.toml --function exact --width 0.5 --out a.csv"), &["go with kernels"]);
    folder.write("wrong.toml", settings.replace("\"velocity\"", "3"));
    mentions(&folder.fails("fields wrong.toml --out a.csv"), &["wrong.toml", "string"]);
}
