//! What is said of input that can be read, or nearly, but is not what was meant.

#![allow(clippy::unwrap_used)]

mod support;

use support::Folder;
use support::cases::mentions;

#[test]
fn a_boundary_value_that_no_particle_has_is_told_with_those_that_there_are() {
    let folder = Folder::new();
    let row = |k: usize, kind: usize| format!("{k},0,0,{kind},{}\n", 0.5 * k as f64);
    let rows: String = (0..20).map(|k| row(k, if k < 5 { 0 } else { 3 })).collect();
    folder.write("block.csv", format!("x,y,z,type,height\n{rows}"));
    let line = "detect --particles block.csv --spacing 1 --out out.csv";
    let run = folder.succeeds(&format!("{line} --boundary type=7"));
    mentions(&run.stderr, &["--boundary type=7: block.csv: no particle has this value", "there are 0, 3"]);
    let run = folder.succeeds(&format!("{line} --boundary height=0.25"));
    mentions(&run.stderr, &["--boundary height=0.25: block.csv", "there are 20 values from 0 to 9.5"]);
    let run = folder.succeeds(&format!("{line} --boundary type=0"));
    assert!(!run.stderr.contains("--boundary"), "{}", run.stderr);
}

#[test]
fn a_cell_that_is_listed_twice_is_told_with_the_cell_that_it_repeats() {
    let folder = Folder::new();
    // A cube, listed twice, and one away from it whose corners make it inside out.
    let mut text = String::from("# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n");
    text += "0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1\nCELLS 2 18\n8 0 1 2 3 4 5 6 7\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 2\n12\n12\n";
    folder.write("twice.vtk", text);
    folder.write("ball.csv", "x,y,z,radius\n0.5,0.5,0.5,0.25\n");
    let run = folder.succeeds("fraction --mesh twice.vtk --particles ball.csv --out a.vtu");
    let told = "twice.vtk: 1 cells are listed twice (cell 1 has the corners of cell 0, from 0), and what lies in them is counted";
    mentions(&run.stderr, &[told, "list each once"]);
    assert!(!run.stderr.contains("inside out"), "{}", run.stderr);
}

#[test]
fn a_time_folder_without_a_mesh_is_told_what_it_lacks() {
    let folder = Folder::new();
    folder.write("case/0.5/U", "");
    mentions(&folder.fails("info case/0.5"), &["no polyMesh was found here", "a time folder that holds a polyMesh"]);
}

#[test]
fn the_programs_own_files_are_told_with_the_command_that_takes_them() {
    let folder = Folder::new();
    folder.write("checkpoint.bin", b"FSTNSPH\x06\0\0\0");
    folder.write("case.toml", "name = \"a\"\n[[fill]]\nshape = \"box\"\n");
    folder.write("gauges.csv", "time,p0,front\n0,1,2\n0.5,3,-4\n");
    mentions(&folder.fails("info checkpoint.bin"), &["a checkpoint of `fieldstone sph run`", "--resume"]);
    mentions(&folder.fails("info case.toml"), &["fieldstone sph check", "sph run", "fieldstone fields"]);
    mentions(&folder.fails("plot gauges.csv --field p0"), &["gauges.csv: this is a table over time", "info tells"]);
    let run = folder.succeeds("info gauges.csv");
    mentions(&run.stdout, &["times, one a row     2", "front, -4 to 2"]);
}

#[test]
fn compressions_and_encodings_that_are_not_read_are_named_with_the_way_out() {
    let folder = Folder::new();
    for (start, parts) in [
        (&b"BZh91AY&SY"[..], ["compressed with bzip2", "bunzip2"]),
        (b"\xfd7zXZ\0\0\x04", ["compressed with xz", "unxz"]),
        (b"\x28\xb5\x2f\xfd\x24", ["compressed with Zstandard", "unzstd"]),
        (b"PK\x03\x04\x14", ["a zip archive", "unzip"]),
        (b"\xff\xfex\0,\0y\0", ["text in UTF-16", "UTF-8"]),
        (b"\xfe\xff\0x\0,\0y", ["text in UTF-16", "UTF-8"]),
    ] {
        folder.write("a.csv", start);
        mentions(&folder.fails("info a.csv"), &parts);
        mentions(&folder.fails("fields --particles a.csv --cells 1 --out o.vti"), &parts);
        mentions(&folder.fails("fraction --mesh a.csv --particles a.csv --out o.vtu"), &parts);
    }
}

#[test]
fn what_reaches_nothing_has_a_volume_and_a_gradient_of_zero_without_a_sign() {
    let folder = Folder::new();
    folder.write("far.csv", "cx,cy,cz,r,x0,y0,z0,x1,y1,z1,x2,y2,z2,x3,y3,z3\n9,9,9,1,0,0,0,1,0,0,0,1,0,0,0,1\n");
    for method in ["kernel", "kernel-f64", "decomposition", "centre", "cube", "divided", "sampled:50", "monte-carlo:50"]
    {
        folder.succeeds(&format!(
            "overlap --element tet --cases far.csv --order cgns --method {method} --out {method}.csv"
        ));
        let text = std::fs::read_to_string(folder.path(&format!("{method}.csv"))).unwrap();
        let row = text.lines().nth(1).unwrap();
        assert!(row.split(',').skip(16).all(|number| !number.starts_with('-')), "{method}: {row}");
    }
}
