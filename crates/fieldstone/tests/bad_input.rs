//! Bad input: one clear message, exit code 1, nothing left behind.

#![allow(clippy::unwrap_used)]

mod support;

use std::io::{Read, Write};

use fieldstone_testing::{Random, data};
use support::Folder;

const BALLS: &str = "x,y,z,radius\n0.5,0.5,0.5,0.25\n0.1,0.15,0.2,0.1\n";

/// A folder with the mesh `case` of 19 cells, its files as plain text, and the particles `balls.csv`.
fn small_case() -> Folder {
    let folder = Folder::new();
    folder.write("balls.csv", BALLS);
    for name in ["points", "faces", "owner", "neighbour"] {
        let path = data(&format!("openfoam/refined/constant/polyMesh/{name}.gz"));
        folder.write(&format!("case/constant/polyMesh/{name}"), fieldstone_testing::read_text(&path));
    }
    folder.copy(&data("openfoam/refined/constant/polyMesh/boundary"), "case/constant/polyMesh/boundary");
    folder
}

/// Changes a file of the mesh.
fn edit(folder: &Folder, name: &str, change: impl FnOnce(&str) -> String) {
    let name = format!("case/constant/polyMesh/{name}");
    let text = std::fs::read_to_string(folder.path(&name)).unwrap();
    let changed = change(&text);
    assert_ne!(text, changed, "the edit hit nothing");
    folder.write(&name, changed);
}

/// The `index`th item of an OpenFOAM list of one item a line: its line, from 0.
fn item(text: &str, index: usize) -> usize {
    text.lines().position(|line| line.trim() == "(").unwrap() + 1 + index
}

fn replace_line(text: &str, at: usize, with: &str) -> String {
    let lines: Vec<&str> = text.lines().enumerate().map(|(k, line)| if k == at { with } else { line }).collect();
    lines.join("\n") + "\n"
}

const RUN: &str = "fraction --mesh case --particles balls.csv --out out.vtu --json out.json";

#[track_caller]
fn mentions(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "'{part}' is missing in:\n{message}");
    }
}

#[test]
fn the_small_case_is_fine_before_anything_is_broken() {
    let folder = small_case();
    folder.succeeds(RUN);
    assert!(folder.path("out.vtu").is_file() && folder.path("out.json").is_file());
}

#[test]
fn missing_files_are_named_with_what_to_do() {
    let folder = small_case();
    let message = folder.fails("fraction --mesh case --particles lost.csv --out out.vtu");
    mentions(&message, &["lost.csv: cannot open", "No such file", "check the name"]);
    let message = folder.fails("fraction --mesh lost --particles balls.csv --out out.vtu");
    mentions(&message, &["lost: cannot open", "check the name"]);
    std::fs::remove_file(folder.path("case/constant/polyMesh/owner")).unwrap();
    mentions(&folder.fails(RUN), &["owner"]);
    mentions(&folder.fails("info lost"), &["lost: cannot open"]);
    mentions(&folder.fails("overlap --element tet --cases lost.csv --out o.csv"), &["lost.csv: cannot open"]);
}

#[test]
fn a_folder_without_a_mesh_or_cloud_is_no_input() {
    let folder = small_case();
    std::fs::create_dir(folder.path("empty")).unwrap();
    let message = folder.fails("fraction --mesh empty --particles balls.csv --out out.vtu");
    mentions(&message, &["empty: no polyMesh was found here", "give a case folder"]);
    let message = folder.fails("fraction --mesh case --particles case --out out.vtu");
    mentions(&message, &["case: no particle cloud was found here", "lagrangian"]);
}

#[test]
fn files_of_another_kind_are_told_from_meshes_and_particles() {
    let folder = small_case();
    folder.copy(&data("packed-cylinder/packed.dump.gz"), "packed.dump.gz");
    folder.write("surface.stl", "solid floor\n facet normal 0 0 1\n");
    folder.write("contacts.dump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n0\nITEM: ENTRIES c_a[1]\n");
    folder.write("box.fstat", "# 0 1\n# \n# \n");
    folder.write("junk", b"\x00\x01\xfe\xff\x00junk".repeat(40));
    folder.write("nothing", "");
    for (mesh, parts) in [
        ("packed.dump.gz", ["this is a LIGGGHTS or LAMMPS dump of particles", "readable here: OpenFOAM"]),
        ("surface.stl", ["this is a surface", "readable here: OpenFOAM"]),
        ("junk", ["the content is not that of a mesh", "readable here: OpenFOAM"]),
        ("nothing", ["nothing: the file is empty", "readable here: OpenFOAM"]),
    ] {
        mentions(&folder.fails(&format!("fraction --mesh {mesh} --particles balls.csv --out out.vtu")), &parts);
    }
    // Results of an earlier run, in the wrong place.
    folder.succeeds("fraction --mesh case --particles balls.csv --out result.vtu");
    let message = folder.fails("fraction --mesh case --particles result.vtu --radius 0.1 --out out.vtu");
    mentions(&message, &["result.vtu: the file holds a mesh of volume cells", "give it as the mesh"]);
    folder.succeeds("fraction --grid 0,1,0,1,0,1 --cells 2,2,2 --particles balls.csv --out result.vti");
    let message = folder.fails("fraction --mesh result.vti --particles balls.csv --out out.vtu");
    mentions(&message, &["result.vti: the file holds a regular grid", "--grid and --cells"]);
    for (particles, parts) in [
        ("contacts.dump", ["contacts.dump:3: this is a dump local", "give a dump custom"]),
        ("surface.stl", ["this looks like a file of triangles", "readable here: LIGGGHTS"]),
        ("box.fstat", [".fstat file of contacts", "are read from the .data file"]),
        ("junk", ["the content is binary", "readable here: LIGGGHTS"]),
        ("nothing", ["nothing: the file is empty", "readable here: LIGGGHTS"]),
    ] {
        mentions(&folder.fails(&format!("fraction --mesh case --particles {particles} --out out.vtu")), &parts);
        mentions(&folder.fails(&format!("info {particles}")), &parts[..1]);
    }
}

#[test]
fn truncated_files_are_told_with_the_place_where_they_end() {
    let folder = small_case();
    edit(&folder, "faces", |text| text[..text.len() / 2].into());
    mentions(&folder.fails(RUN), &["case/constant/polyMesh/faces:", "\n  "]);

    let folder = small_case();
    folder.write("cut.dump", "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id x y z radius\n1 .5 .5 .5 .1\n");
    let message = folder.fails("fraction --mesh case --particles cut.dump --out out.vtu");
    mentions(&message, &["cut.dump:10", "\n  "]);

    // A gzip stream that ends in the middle.
    let whole = std::fs::read(data("packed-cylinder/packed.dump.gz")).unwrap();
    folder.write("cut.dump.gz", &whole[..whole.len() / 2]);
    let message = folder.fails("fraction --mesh case --particles cut.dump.gz --out out.vtu");
    mentions(&message, &["cut.dump.gz", "copy it again"]);

    folder.succeeds("fraction --mesh case --particles balls.csv --out whole.vtu");
    let whole = std::fs::read(folder.path("whole.vtu")).unwrap();
    folder.write("cut.vtu", &whole[..2 * whole.len() / 3]);
    mentions(&folder.fails("fraction --mesh cut.vtu --particles balls.csv --out out.vtu"), &["cut.vtu", "\n  "]);

    let msh = std::fs::read(data("gmsh/box_v41_bin.msh")).unwrap();
    folder.write("cut.msh", &msh[..msh.len() / 2]);
    mentions(&folder.fails("fraction --mesh cut.msh --particles balls.csv --out out.vtu"), &["cut.msh", "\n  "]);
}

#[test]
fn a_corrupt_gzip_stream_is_told_as_damaged() {
    let folder = small_case();
    let mut gz = std::fs::read(data("packed-cylinder/packed.dump.gz")).unwrap();
    let middle = gz.len() / 2;
    gz[middle..middle + 100].fill(0x55);
    folder.write("bad.dump.gz", gz);
    mentions(&folder.fails("fraction --mesh case --particles bad.dump.gz --out out.vtu"), &["bad.dump.gz", "\n  "]);
}

#[test]
fn radii_that_are_nan_negative_zero_or_text_are_told_with_their_line() {
    for bad in ["nan", "-0.1", "0", "inf", "big"] {
        let folder = small_case();
        folder.write("bad.csv", format!("x,y,z,radius\n0.5,0.5,0.5,0.1\n0.5,0.5,0.7,{bad}\n"));
        let message = folder.fails("fraction --mesh case --particles bad.csv --out out.vtu");
        mentions(&message, &["bad.csv:3: ", "radius"]);
    }
}

#[test]
fn radii_beyond_what_volumes_can_hold_are_refused() {
    let folder = small_case();
    for radius in ["1e200", "1e-200"] {
        let message =
            folder.fails(&format!("fraction --mesh case --particles balls.csv --out o.vtu --radius {radius}"));
        mentions(&message, &["balls.csv: particle 0 has radius", "between 1e-100 and 1e100"]);
    }
}

#[test]
fn positions_that_are_no_numbers_are_told_with_their_line() {
    let folder = small_case();
    folder.write("bad.csv", "x,y,z,radius\n0.5,0.5,0.5,0.1\n0.5,nan,0.5,0.1\n");
    let message = folder.fails("fraction --mesh case --particles bad.csv --out out.vtu");
    mentions(&message, &["bad.csv:3: "]);
}

#[test]
fn a_row_with_too_few_or_too_many_columns_is_told_with_its_line() {
    for row in ["0.5,0.5,0.5", "0.5,0.5,0.5,0.1,7,8"] {
        let folder = small_case();
        folder.write("bad.csv", format!("x,y,z,radius\n0.5,0.5,0.5,0.1\n{row}\n"));
        let message = folder.fails("fraction --mesh case --particles bad.csv --out out.vtu");
        let count = row.split(',').count();
        mentions(&message, &["bad.csv:3: ", &format!("{count} columns"), "4"]);
    }
    let folder = small_case();
    let header = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n";
    folder.write("bad.dump", format!("{header}ITEM: ATOMS id x y z radius\n1 0.5 0.5 0.5\n"));
    mentions(&folder.fails("fraction --mesh case --particles bad.dump --out out.vtu"), &["bad.dump:10: "]);
}

#[test]
fn a_cell_or_point_out_of_range_is_told_with_the_file() {
    let folder = small_case();
    edit(&folder, "faces", |text| {
        let at = item(text, 3);
        replace_line(text, at, "4(0 1 2 8812)")
    });
    mentions(&folder.fails(RUN), &["faces", "8812", "55 points", "different time steps"]);

    let folder = small_case();
    edit(&folder, "owner", |text| {
        let at = item(text, 3);
        replace_line(text, at, "-7")
    });
    mentions(&folder.fails(RUN), &["owner", "-7"]);

    // A label far too large would ask for the memory of two billion cells.
    let folder = small_case();
    edit(&folder, "owner", |text| {
        let at = item(text, 3);
        replace_line(text, at, "2000000000")
    });
    mentions(&folder.fails(RUN), &["2000000000"]);

    let folder = small_case();
    let msh = fieldstone_testing::read_text(&data("gmsh/box_v22.msh"));
    // A row of $Elements: number, type (5 is a hexahedron), count of tags, tags, corners.
    let is_hexahedron = |line: &str| line.split(' ').nth(1) == Some("5") && line.split(' ').count() > 10;
    let (at, line) = msh.lines().enumerate().find(|(_, line)| is_hexahedron(line)).unwrap();
    let (most, _) = line.trim().rsplit_once(' ').unwrap();
    folder.write("bad.msh", replace_line(&msh, at, &format!("{most} 999999")));
    mentions(
        &folder.fails("fraction --mesh bad.msh --particles balls.csv --out out.vtu"),
        &["bad.msh:", "999999", "\n  "],
    );
}

#[test]
fn a_face_with_two_vertices_is_told() {
    let folder = small_case();
    edit(&folder, "faces", |text| {
        let at = item(text, 5);
        replace_line(text, at, "2(0 1)")
    });
    mentions(&folder.fails(RUN), &["faces", "face 5", "at least three"]);
}

#[test]
fn a_mesh_with_a_hole_is_told_with_the_cell_and_the_edge() {
    let folder = small_case();
    // A quadrilateral of the boundary loses a corner: its cell is open along two edges.
    edit(&folder, "faces", |text| {
        let last = item(text, 81);
        let ring = text.lines().nth(last).unwrap().trim().to_string();
        let corners: Vec<&str> = ring.split(['(', ')']).nth(1).unwrap().split_whitespace().collect();
        assert_eq!(corners.len(), 4);
        replace_line(text, last, &format!("3({})", corners[..3].join(" ")))
    });
    mentions(&folder.fails(RUN), &["case/constant/polyMesh", "has a hole", "edge between points"]);
}

#[test]
fn a_mesh_that_no_particle_reaches_is_told_with_both_extents() {
    let folder = small_case();
    // Millimetres for metres.
    folder.write("far.csv", "x,y,z,radius\n500,500,500,25\n100,150,200,10\n");
    let message = folder.fails("fraction --mesh case --particles far.csv --out out.vtu --json out.json");
    mentions(
        &message,
        &["far.csv in case: none of the 2 particles", "(100, 150, 200) to (500, 500, 500)", "check units"],
    );
    let message =
        folder.fails("fraction --grid 0,1,0,1,0,1 --cells 2,2,2 --particles far.csv --out out.vti --json out.json");
    mentions(&message, &["far.csv in the grid: none of the 2 particles", "(0, 0, 0) to (1, 1, 1)"]);
}

#[test]
fn an_output_that_cannot_be_written_is_told_before_the_work() {
    let folder = small_case();
    folder.write("file", "a regular file");
    folder.write("case/0/alpha.solids/keep", "a folder in the place of a field");
    std::fs::create_dir(folder.path("taken.vtu")).unwrap();
    for (out, parts) in [
        ("missing/out.vtu", ["--out missing/out.vtu: the folder missing does not exist", "make it first"]),
        ("missing/0", ["--out missing/0: the folder missing does not exist", "make it first"]),
        ("file/out.vtu", ["--out file/out.vtu: file is a file, not a folder", "choose another place"]),
        ("file/0", ["--out file/0: file is a file, not a folder", "choose another place"]),
        ("taken.vtu", ["--out taken.vtu: this is a folder", "give the name of a file"]),
        ("balls.csv", ["--out balls.csv: this would overwrite another file of this run", "choose another name"]),
        ("case/../balls.csv", ["this would overwrite another file of this run", "choose another name"]),
        ("case/0", ["case/0/alpha.solids: there is a folder of this name", "remove it first"]),
        ("out.vti", ["--out out.vti: a mesh is written as .vtu", ".csv"]),
        ("out.xyz", ["--out out.xyz: the ending is not known", "use .vtu"]),
        ("case", ["--out case: the ending is not known", "CASE/0"]),
    ] {
        mentions(&folder.fails(&format!("fraction --mesh case --particles balls.csv --out {out}")), &parts);
    }
    for (json, part) in [
        ("missing/s.json", "the folder missing does not exist"),
        ("file/s.json", "file is a file"),
        ("taken.vtu", "this is a folder"),
        ("out.vtu", "this would overwrite another file of this run"),
    ] {
        let message = folder.fails(&format!("fraction --mesh case --particles balls.csv --out out.vtu --json {json}"));
        mentions(&message, &[&format!("--json {json}"), part]);
    }
    let message = folder.fails("fraction --mesh case --particles balls.csv --out out.csv --binary");
    mentions(&message, &["--binary goes with an OpenFOAM time folder"]);
    mentions(&folder.fails("demo file"), &["file: cannot make the folder", "give another"]);
    mentions(&folder.fails("demo file/results"), &["file/results: cannot make the folder"]);

    folder.write("t.csv", "cx,cy,cz,r,x0,y0,z0,x1,y1,z1,x2,y2,z2,x3,y3,z3\n0,0,0,0.5,0,0,0,1,0,0,0,1,0,0,0,1\n");
    for out in ["missing/o.csv", "file/o.csv", "taken.vtu", "t.csv"] {
        let message = folder.fails(&format!("overlap --element tet --cases t.csv --out {out}"));
        mentions(&message, &[&format!("--out {out}: ")]);
    }
}

#[cfg(unix)]
#[test]
fn a_device_as_output_is_written_to_and_never_replaced() {
    let folder = small_case();
    folder.succeeds("fraction --mesh case --particles balls.csv --out out.vtu --json /dev/null");
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
    if std::fs::metadata("/dev/full").is_ok() {
        let run = folder.fieldstone("fraction --mesh case --particles balls.csv --out out.vtu --json /dev/full");
        assert_eq!(run.code, Some(1));
        mentions(&run.stderr, &["error: /dev/full: cannot write: No space left", "make room"]);
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_as_input_is_refused_instead_of_waited_for() {
    let folder = small_case();
    let made = std::process::Command::new("mkfifo").arg(folder.path("pipe")).status();
    if !made.is_ok_and(|status| status.success()) {
        return;
    }
    for line in [
        "info pipe",
        "fraction --mesh case --particles pipe --out out.vtu",
        "fraction --mesh pipe --particles balls.csv --out out.vtu",
        "overlap --element tet --cases pipe --out out.csv",
    ] {
        let run = folder.fieldstone(line);
        assert_eq!(run.code, Some(1), "{}", run.stderr);
        mentions(&run.stderr, &["pipe: cannot open: it is a pipe or a device", "save the data in a file first"]);
    }
}

#[test]
fn clumps_and_superquadrics_are_refused_and_not_taken_for_spheres() {
    let header = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n";
    for (columns, row, word) in [
        ("id_multisphere", "1", "clump"),
        ("shapex shapey shapez blockiness1 blockiness2", "1 1 2 4 4", "superquadric"),
    ] {
        let folder = small_case();
        folder.write("odd.dump", format!("{header}ITEM: ATOMS id x y z radius {columns}\n1 0.5 0.5 0.5 0.1 {row}\n"));
        let line = "fraction --mesh case --particles odd.dump --out out.vtu";
        mentions(&folder.fails(line), &["odd.dump:9", word, "--allow-non-spherical"]);
        folder.succeeds(&format!("{line} --allow-non-spherical"));
    }
}

#[test]
fn a_table_that_does_not_fit_the_element_is_told_with_the_line_or_column() {
    let folder = Folder::new();
    let header = "cx,cy,cz,r,x0,y0,z0,x1,y1,z1,x2,y2,z2,x3,y3,z3";
    let good = "0,0,0,0.5,0,0,0,1,0,0,0,1,0,0,0,1";
    let line = "overlap --element tet --cases t.csv --out o.csv";
    for (header, row, parts) in [
        (header, "0,0,0,-0.5,0,0,0,1,0,0,0,1,0,0,0,1", ["t.csv:3: ", "radius is -0.5"]),
        (header, "0,0,nan,0.5,0,0,0,1,0,0,0,1,0,0,0,1", ["t.csv:3: ", "NaN"]),
        (header, "0,0,0,0.5,0,0,0,1,0,0,0,1,0,0,0,up", ["t.csv:3: ", "'up', which is no number"]),
        (header, "0,0,0,0.5,0,0,0,1,0,0,0,1,0,1,1,0", ["t.csv:3: the tetrahedron encloses no volume", "--element"]),
        (header, "0,0,0,0.5,0,0,0,1,0,0,0,1,0,0,0", ["t.csv:3: ", "15 columns"]),
        ("cx,cy,cz,R0,x0,y0,z0,x1,y1,z1,x2,y2,z2,x3,y3,z3", good, ["t.csv: there is no column 'r'", "rename"]),
    ] {
        folder.write("t.csv", format!("{header}\n{good}\n{row}\n"));
        mentions(&folder.fails(line), &parts);
    }
    folder.write("t.csv", format!("{header},volume\n{good},1\n"));
    mentions(&folder.fails(line), &["t.csv: there is a column 'volume' already", "rename or remove it"]);
    folder.write("t.csv", "");
    mentions(&folder.fails(line), &["t.csv: there is neither a header row nor a row of numbers"]);
    folder.copy(&data("overlap-cases/hex.csv.gz"), "t.csv");
    mentions(&folder.fails(line), &["there is a column 'x4', but a tetrahedron has only the corners 0 to 3"]);
    folder.copy(&data("overlap-cases/tet.csv.gz"), "t.csv");
    mentions(&folder.fails(&line.replace("tet", "hex")), &["there is no column 'x4'"]);
}

#[test]
fn messages_read_well() {
    let folder = small_case();
    let mut all = String::new();
    let mut show = |line: &str| {
        let run = folder.fieldstone(line);
        all += &format!("$ fieldstone {line}\n{}[exit code {}]\n\n", run.stderr, run.code.unwrap());
    };
    folder.write("far.csv", "x,y,z,radius\n500,500,500,25\n");
    folder.write("negative.csv", "x,y,z,radius\n0.5,0.5,0.5,0.1\n0.5,0.5,0.7,-0.1\n");
    show("fraction --mesh case --particles lost.csv --out out.vtu");
    show("fraction --mesh case --particles negative.csv --out out.vtu");
    show("fraction --mesh case --particles far.csv --out out.vtu");
    show("fraction --mesh balls.csv --particles balls.csv --out out.vtu");
    show("fraction --mesh case --particles balls.csv --out results/out.vtu");
    show("fraction --mesh case --particles balls.csv --out out.vtu --radius -1");
    show("fraction --grid 0,1,0,1 --cells 2,2,2 --particles balls.csv --out out.vti");
    edit(&folder, "faces", |text| {
        let at = item(text, 3);
        replace_line(text, at, "4(0 1 2 8812)")
    });
    show("fraction --mesh case --particles balls.csv --out out.vtu");
    insta::assert_snapshot!("messages", all);
}

/// One damage as disks, transfers and editors do it.
fn damage(content: &mut Vec<u8>, random: &mut Random) {
    let at = random.below(content.len());
    let length = 1 + random.below(40.min(content.len() - at));
    match random.below(7) {
        0 => content.truncate(at),
        1 => content[at] ^= 1 << random.below(8),
        2 => content[at] = b"0123456789.-e() {};\n\0\xff"[random.below(22)],
        3 => drop(content.drain(at..at + length)),
        4 => content[at..at + length].fill(0),
        5 => {
            let piece = content[at..at + length].to_vec();
            let to = random.below(content.len());
            content.splice(to..to, piece);
        }
        _ => {
            // A number that is far too large, where a number is.
            let digit = content.iter().skip(at).position(u8::is_ascii_digit).unwrap_or(0);
            content.splice(at + digit..at + digit, *b"99999999");
        }
    }
}

#[test]
fn files_damaged_at_random_end_in_results_or_a_message_never_in_a_panic() {
    let mut names: Vec<String> =
        ["points", "faces", "owner", "neighbour"].map(|name| format!("bed/constant/polyMesh/{name}.gz")).into();
    names.push("bed/constant/polyMesh/boundary".into());
    names.push("packed.dump.gz".into());
    let mut random = Random(20);
    let (mut fine, mut refused) = (0, 0);
    let folder = Folder::new();
    folder.copy(&data("bed_twist"), "bed");
    folder.copy(&data("packed-cylinder/packed.dump.gz"), "packed.dump.gz");
    for round in 0..60 {
        let name = &names[round % names.len()];
        let path = folder.path(name);
        let original = std::fs::read(&path).unwrap();
        let zipped = name.ends_with(".gz");
        let mut content = original.clone();
        // Mostly the content itself: a damaged stream is noticed by its checksum.
        if zipped && round % 10 != 0 {
            content.clear();
            flate2::read::GzDecoder::new(&original[..]).read_to_end(&mut content).unwrap();
        }
        for _ in 0..1 + random.below(3) {
            damage(&mut content, &mut random);
            if content.is_empty() {
                content.push(b' ');
            }
        }
        if zipped && round % 10 != 0 {
            let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
            gz.write_all(&content).unwrap();
            content = gz.finish().unwrap();
        }
        std::fs::write(&path, content).unwrap();
        let before = folder.files().len();
        let run = folder.fieldstone("fraction --mesh bed --particles packed.dump.gz --out out.vtu --json out.json");
        match run.code {
            Some(0) => {
                fine += 1;
                assert!(folder.path("out.vtu").is_file() && folder.path("out.json").is_file());
                std::fs::remove_file(folder.path("out.vtu")).unwrap();
                std::fs::remove_file(folder.path("out.json")).unwrap();
            }
            Some(1) => {
                refused += 1;
                assert!(run.stderr.starts_with("error: "), "round {round}, {name}: {}", run.stderr);
            }
            code => panic!("round {round}, {name}: exit code {code:?}\n{}", run.stderr),
        }
        assert_eq!(folder.files().len(), before, "round {round}, {name}: files were left behind");
        std::fs::write(&path, original).unwrap();
    }
    println!("{fine} runs gave results, {refused} a message");
    assert!(refused > 20, "the damage does no damage: {refused} of 60 runs refused");
}
