//! Tables, XYZ and MercuryDPM files, branch by branch.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::PathBuf;

use fieldstone_io::{
    CsvReader, CsvTable, CsvWriter, FrameReader, IoError, MercuryReader, OneFrame, ParticleOptions, Separator,
    XyzReader, open_particles, read_frame, write_csv, write_particles_csv,
};
use fieldstone_particles::{Domain, Particles, Quantity};
use tempfile::TempDir;

struct File {
    _folder: TempDir,
    path: PathBuf,
}

fn named(name: &str, content: impl AsRef<[u8]>) -> File {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    File { _folder: folder, path }
}

fn file(content: impl AsRef<[u8]>) -> File {
    named("particles.txt", content)
}

/// The first frame and the warnings, the format being found out by the content.
fn read(content: impl AsRef<[u8]>) -> (Particles, Vec<String>) {
    let file = file(content);
    let mut reader = open_particles(&file.path, &ParticleOptions::default()).unwrap();
    let particles = reader.next_frame().unwrap().expect("a frame");
    (particles, reader.warnings().to_vec())
}

fn refused(content: impl AsRef<[u8]>) -> String {
    let file = file(content);
    let mut reader = match open_particles(&file.path, &ParticleOptions::default()) {
        Ok(reader) => reader,
        Err(error) => return error.to_string(),
    };
    loop {
        match reader.next_frame() {
            Ok(Some(_)) => {}
            Ok(None) => panic!("read to the end"),
            Err(error) => {
                assert!(reader.next_frame().unwrap().is_none(), "after an error there is nothing more");
                return error.to_string();
            }
        }
    }
}

fn column(particles: &Particles, name: &str) -> (usize, Vec<f64>) {
    let quantity = particles.quantity(name).unwrap();
    (quantity.components, quantity.data.clone())
}

#[test]
fn every_separator_gives_the_same_particles() {
    let expected = read("x,y,z,r\n0,1,2,0.5\n3,4,5,0.25\n").0;
    assert_eq!(expected.positions(), [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]);
    assert_eq!(expected.radii().unwrap(), [0.5, 0.25]);
    for content in [
        "x;y;z;r\n0;1;2;0.5\n3;4;5;0.25\n",
        "x\ty\tz\tr\n0\t1\t2\t0.5\n3\t4\t5\t0.25\n",
        "x y  z r\n 0 1 2 0.5\n3   4\t5 0.25",
        "x, y, z, r\r\n0, 1, 2, 0.5\r\n3 ,4 ,5 ,0.25\r\n",
        "\"x\",\"y\",\"z\",\"r\"\n\"0\",\"1\",\"2\",\"0.5\"\n3,4,5,0.25\n",
        "\u{feff}x,y,z,r,\n0,1,2,0.5,\n3,4,5,0.25,\n",
        "# made by a script\n# x y z r\n0 1 2 0.5\n\n# half way\n3 4 5 0.25\n",
        "# x y z r\n# made by hand today\n0 1 2 0.5\n3 4 5 0.25\n",
        "#x,y,z,r\n0,1,2,0.5\n3,4,5,0.25\n",
        "# a comment of some words here\n0 1 2 0.5\n3 4 5 0.25\n",
        "0 1 2 0.5\n3 4 5 0.25\n",
        "0,1,2,0.5\n3,4,5,0.25\n",
        "#format x_y_z_r\n0\t1\t2\t0.5\n3\t4\t5\t0.25\n",
        "#x_y_z_r\n0\t1\t2\t0.5\n3\t4\t5\t0.25\n",
    ] {
        assert_eq!(read(content).0, expected, "{content:?}");
    }
}

#[test]
fn names_of_coordinates_and_sizes_have_their_usual_variants() {
    for names in [
        "X,Y,Z,Radius",
        "px,py,pz,RAD",
        "\"Points:0\",\"Points:1\",\"Points:2\",\"radius\"",
        "Points_0,Points_1,Points_2,r",
        "position_x,position_y,position_z,R",
    ] {
        let (p, _) = read(format!("{names}\n1,2,3,4\n"));
        assert_eq!((p.positions()[0], p.radii().unwrap()[0]), ([1.0, 2.0, 3.0], 4.0), "{names}");
    }
    for size in ["d", "Diameter", "diam"] {
        assert_eq!(read(format!("x,y,z,{size}\n1,2,3,4\n")).0.radii().unwrap(), [2.0]);
    }
}

#[test]
fn vectors_are_grouped_from_either_style_of_names() {
    let (p, warnings) = read(
        "id,type,v:0,v:1,v:2,Points:0,Points:1,Points:2,vx,vy,vz,t_x,t_y,t_z,s:0,s:1,a:1,a:2,Mass,name\n\
         7,2,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,glass\n",
    );
    assert_eq!((p.ids().unwrap(), p.types().unwrap()), (&[7][..], &[2][..]));
    assert_eq!(p.positions(), [[4.0, 5.0, 6.0]]);
    assert_eq!(column(&p, "velocity"), (3, vec![7.0, 8.0, 9.0]));
    // The name was taken, so the other one stays apart.
    assert_eq!(column(&p, "v:1"), (1, vec![2.0]));
    assert_eq!(column(&p, "t"), (3, vec![10.0, 11.0, 12.0]));
    assert_eq!(column(&p, "s"), (2, vec![13.0, 14.0]));
    assert_eq!(column(&p, "a:2"), (1, vec![16.0]));
    assert_eq!(column(&p, "mass"), (1, vec![17.0]));
    assert_eq!(warnings, ["column 'name' holds text and is passed over"]);
}

#[test]
fn paraview_names_of_liggghts_vectors_become_the_standard_ones() {
    let (p, _) = read(
        "\"Points:0\",\"Points:1\",\"Points:2\",\"v:0\",\"v:1\",\"v:2\",\"omega:0\",\"omega:1\",\"omega:2\",\"f:0\",\"f:1\",\"f:2\"\n0,0,0,1,2,3,4,5,6,7,8,9\n",
    );
    assert_eq!(column(&p, "velocity").1, [1.0, 2.0, 3.0]);
    assert_eq!(column(&p, "angular_velocity").1, [4.0, 5.0, 6.0]);
    assert_eq!(column(&p, "force").1, [7.0, 8.0, 9.0]);
}

#[test]
fn yade_exports_name_their_columns_in_a_comment() {
    let (p, _) = read("#format x_y_z_r_matId\n0\t0\t1\t0.5\t3\n");
    assert_eq!((p.radii().unwrap()[0], p.types().unwrap()[0]), (0.5, 3));
    let (p, _) = read("#format x_y_z_r_attrs\n0\t0\t1\t0.5\t3\t4\n");
    assert_eq!((column(&p, "attr_1").1[0], column(&p, "attr_2").1[0]), (3.0, 4.0));
    let (p, _) = read("#format x_y_z_r_attrs\n# x y z r dist vel_x vel_y vel_z\n0\t0\t1\t0.5\t3\t4\t5\t6\n");
    assert_eq!((column(&p, "dist").1, column(&p, "vel")), (vec![3.0], (3, vec![4.0, 5.0, 6.0])));
}

#[test]
fn a_table_of_nothing_but_a_header_is_an_empty_frame() {
    let (p, _) = read("x,y,z,radius\n");
    assert!(p.is_empty() && p.radii().unwrap().is_empty());
}

#[test]
fn empty_fields_are_nan_in_quantities_and_errors_in_positions() {
    let (p, _) = read("x,y,z,q\n0,0,0,\n");
    assert!(column(&p, "q").1[0].is_nan());
    let error = refused("x,y,z,q\n0,0,0,1\n0,,0,1\n");
    assert!(error.contains(":3: column 2 'y' is empty"), "{error}");
}

#[test]
fn bad_rows_of_tables_are_told_with_their_lines() {
    let error = refused("x;y;z\n1,5;0;0\n");
    assert!(error.contains(":2:") && error.contains("decimal commas"), "{error}");
    let error = refused("x,y,z\n0,0,0\n\n# note\n0,0\n");
    assert!(error.contains(":5: the row has 2 columns; 3 columns are expected: x y z"), "{error}");
    assert!(refused("x,y,z\n0,0,0,9\n").contains("the first one too many being '9'"));
    assert!(refused("x,y,z\n0,0,nan\n").contains("column 3 'z' is NaN"));
    assert!(refused("x,y,z,r\n0,0,0,-1\n").contains("sizes must be above 0"));
    assert!(refused("x,y,q\n0,0,0\n").contains("no complete set of coordinates"));
    assert!(refused("0 0 0 1 2\n").contains(":1: a row of 5 columns begins the file, without names"));
    assert!(refused("# only\n# comments\n").contains("neither a header row nor"));
    assert!(refused("x,y,z,id_multisphere\n0,0,0,1\n").contains("clumps"));
    assert!(refused("x,y,z,id\n0,0,0,1.5\n").contains("which is no integer"));
}

#[test]
fn what_is_no_file_of_particles_is_named() {
    for (content, word) in [
        (&b""[..], "empty"),
        (b" \n\n", "empty"),
        (b"MercuryDPM 1.0 name box\n", ".data file"),
        (b"LAMMPS data file\n\n2 atoms\n", "dumps"),
        (b"{\"x\": 1}\n", "JSON"),
        (b"solid cube\n", "STL"),
        (b"\x00\x01\x02\x03", "binary"),
    ] {
        let file = file(content);
        match open_particles(&file.path, &ParticleOptions::default()).err().expect("refused") {
            error @ IoError::UnknownFormat { .. } => {
                let text = error.to_string();
                assert!(text.contains(word) && text.contains("LIGGGHTS or LAMMPS dump, VTK"), "{text}");
            }
            other => panic!("{other}"),
        }
    }
    let contacts = named("run.fstat", "# 0\n# a\n# b\n0 1 2\n");
    let error = open_particles(&contacts.path, &ParticleOptions::default()).err().expect("refused");
    assert!(error.to_string().contains(".fstat"), "{error}");
    let missing = contacts.path.with_file_name("nothing.dump");
    let error = open_particles(&missing, &ParticleOptions::default()).err().expect("refused");
    assert!(error.to_string().contains("nothing.dump: cannot open"), "{error}");
    let folder = contacts.path.parent().unwrap();
    let error = open_particles(folder, &ParticleOptions::default()).unwrap().next_frame().unwrap_err().to_string();
    assert!(error.contains("no particle cloud was found"), "{error}");
}

#[test]
fn a_table_gives_columns_by_name_and_rows_unchanged() {
    let file = file("# balls\ncx cy  cz r note\n0  0 1 0.5 a,b\n# gap\n1 0 2 0.25 \"c d\"\n");
    let table = CsvTable::read(&file.path).unwrap();
    assert_eq!(table.names(), ["cx", "cy", "cz", "r", "note"]);
    assert_eq!((table.len(), table.separator()), (2, Separator::Blanks));
    assert!(table.rows().eq([(3, "0  0 1 0.5 a,b"), (5, "1 0 2 0.25 \"c d\"")]));
    assert_eq!(table.column("R").unwrap(), [0.5, 0.25]);
    assert!(table.has("CX") && !table.has("x"));
    let error = table.column("note").unwrap_err().to_string();
    assert!(error.contains(":3: column 'note' holds 'a,b'"), "{error}");
    let error = table.column("volume").unwrap_err().to_string();
    assert!(error.contains("no column 'volume'; the columns are cx cy cz r note"), "{error}");
}

#[test]
fn a_table_with_an_uneven_row_is_refused() {
    let file = file("a,b\n1,2\n1\n");
    assert!(CsvTable::read(&file.path).unwrap_err().to_string().contains(":3: the row has 1 columns, but 2"));
}

#[test]
fn a_table_is_passed_on_with_more_columns_and_the_rest_unchanged() {
    for (content, expected) in [
        ("cx,r,note\n0.10,1,\"a, b\"\n2,3e0,c\n", "cx,r,note,volume,area\n0.10,1,\"a, b\",0.1,-0.0\n2,3e0,c,2,1e300\n"),
        ("cx;r;\n0.10;1;\n2;3;\n", "cx;r;volume;area\n0.10;1;0.1;-0.0\n2;3;2;1e300\n"),
        ("# cx r\n0.10 1\n2 3\n", "cx r volume area\n0.10 1 0.1 -0.0\n2 3 2 1e300\n"),
    ] {
        let input = file(content);
        let table = CsvTable::read(&input.path).unwrap();
        let out = input.path.with_file_name("out.csv");
        let mut writer = CsvWriter::extending(&out, &table, &["volume", "area"]).unwrap();
        for ((_, row), numbers) in table.rows().zip([[0.1, -0.0], [2.0, 1e300]]) {
            writer.row_extending(row, &numbers).unwrap();
        }
        assert!(!out.exists(), "nothing appears before it is complete");
        writer.finish().unwrap();
        assert_eq!(std::fs::read_to_string(&out).unwrap(), expected);
        assert!(CsvTable::read(&out).unwrap().column("area").unwrap()[0].is_sign_negative());
    }
}

#[test]
fn empty_last_fields_stay_where_they_are_when_columns_are_added() {
    for (content, expected) in [
        ("r,note\n1,\n2,a\n", "r,note,volume\n1,,0.5\n2,a,0.5\n"),
        ("r,note,by\n1,,\n2,,b\n", "r,note,by,volume\n1,,,0.5\n2,,b,0.5\n"),
        // With a separator behind the last column, too, in the header or in the rows alone.
        ("r,note,\n1,,\n2,a\n", "r,note,volume\n1,,0.5\n2,a,0.5\n"),
        ("r,note,by,,\n1,,,\n2,,\n", "r,note,by,volume\n1,,,0.5\n2,,,0.5\n"),
        ("r;note\r\n1; \r\n2;a;\r\n", "r;note;volume\n1;;0.5\n2;a;0.5\n"),
        ("r\tnote\n1\t\n2\ta\t\n", "r\tnote\tvolume\n1\t\t0.5\n2\ta\t0.5\n"),
        ("r\tnote\tby\t\n1\t\t\n2\t\t\t\n", "r\tnote\tby\tvolume\n1\t\t\t0.5\n2\t\t\t0.5\n"),
    ] {
        let input = file(content);
        let table = CsvTable::read(&input.path).unwrap();
        let out = input.path.with_file_name("out.csv");
        let mut writer = CsvWriter::extending(&out, &table, &["volume"]).unwrap();
        for (_, row) in table.rows() {
            writer.row_extending(row, &[0.5]).unwrap();
        }
        writer.finish().unwrap();
        assert_eq!(std::fs::read_to_string(&out).unwrap(), expected, "of {content:?}");
        assert_eq!(CsvTable::read(&out).unwrap().column("volume").unwrap(), [0.5; 2], "of {content:?}");
    }
}

#[test]
fn columns_of_different_lengths_are_refused_and_nothing_is_written() {
    let input = file("");
    let out = input.path.with_file_name("out.csv");
    let error = write_csv(&out, &[("a", &[1.0, 2.0]), ("b", &[1.0])]).unwrap_err();
    assert!(matches!(error, IoError::Content { .. }) && !out.exists());
    assert!(error.to_string().contains("column 'b' has 1 rows, but 'a' has 2"), "{error}");
}

#[test]
fn written_numbers_read_back_to_the_same_bits() {
    let numbers = [
        0.0,
        -0.0,
        1.0,
        -3.0,
        0.1,
        1.0 / 3.0,
        5e-324,
        f64::MAX,
        f64::MIN_POSITIVE,
        1e15,
        1e16,
        9007199254740993.0,
        -1e22,
        f64::INFINITY,
        f64::NAN,
    ];
    let file = file("");
    write_csv(&file.path, &[("n", &numbers), ("odd, name", &numbers)]).unwrap();
    let back = CsvTable::read(&file.path).unwrap();
    for name in ["n", "odd, name"] {
        let bits: Vec<u64> = back.column(name).unwrap().iter().map(|n| n.to_bits()).collect();
        assert_eq!(bits, numbers.map(f64::to_bits));
    }
}

#[test]
fn particles_written_as_a_table_read_back_the_same() {
    let quantity = |name: &str, components, data| Quantity { name: name.into(), components, data };
    let particles = Particles::new(vec![[0.1, 1.0 / 3.0, -2e-9], [1.0, 2.0, 3.0]])
        .and_then(|p| p.with_radii(vec![0.1, 7e-5]))
        .and_then(|p| p.with_ids(vec![9_007_199_254_740_993, 1]))
        .and_then(|p| p.with_types(vec![1, 2]))
        .and_then(|p| p.with_quantity(quantity("velocity", 3, vec![1.0, 2.0, 3.0, 0.1, 0.2, 0.3])))
        .and_then(|p| p.with_quantity(quantity("mass", 1, vec![1e-5, 2e-5])))
        .and_then(|p| p.with_quantity(quantity("c_st", 6, (0..12).map(|k| f64::from(k) / 7.0).collect())))
        .unwrap();
    let file = file("");
    write_particles_csv(&file.path, &particles).unwrap();
    assert_eq!(CsvReader::open(&file.path).unwrap().next_frame().unwrap().unwrap(), particles);
    let bare = Particles::new(vec![[1.0, 2.0, 3.0]]).unwrap();
    write_particles_csv(&file.path, &bare).unwrap();
    assert_eq!(std::fs::read_to_string(&file.path).unwrap(), "x,y,z\n1,2,3\n");
}

#[test]
fn plain_xyz_rows_have_a_name_or_a_type_and_perhaps_a_radius() {
    let (p, warnings) = read("2\nAtoms. Timestep: 40\nC 0 0 1\nFe 1 2 3\n");
    assert_eq!((p.positions()[1], p.step()), ([1.0, 2.0, 3.0], Some(40)));
    let told = "column 'species' holds text and is passed over: types are numbers; to tell species apart, write numbers in \
                place of names";
    assert_eq!(warnings, [told]);
    let (p, warnings) = read("2\n\n3 0 0 1 0.5\n4 1 2 3 0.25\n");
    assert_eq!((p.types().unwrap(), p.radii().unwrap()), (&[3, 4][..], &[0.5, 0.25][..]));
    assert!(warnings.is_empty());
}

#[test]
fn extended_xyz_names_its_columns_box_and_time() {
    let (p, _) = read(
        "1\nLattice=\"2 0 0 0 3 0 0 0 4\" Origin=\"-1 0 1\" pbc=\"T F T\" Time=0.5 \
         Properties=id:I:1:species:S:1:pos:R:3:velo:R:3:radius:R:1:stress:R:6\n9 A 1 2 3 4 5 6 0.5 1 2 3 4 5 6\n",
    );
    assert_eq!((p.ids().unwrap(), p.positions()[0], p.time()), (&[9][..], [1.0, 2.0, 3.0], Some(0.5)));
    assert_eq!(column(&p, "velocity").1, [4.0, 5.0, 6.0]);
    assert_eq!(column(&p, "stress").0, 6);
    let domain = Domain::new([-1.0, 0.0, 1.0], [1.0, 3.0, 5.0], [true, false, true]).unwrap();
    assert_eq!(p.domain(), Some(&domain));
    let (p, warnings) = read("1\nLattice=\"0 2 0 3 0 0 0 0 4\"\nA 0 0 0\n");
    assert!(p.domain().is_none() && warnings[0].contains("read without a box"), "{warnings:?}");
    let (p, _) = read("1\nLattice=\"2 0 0 1 3 0 0 0 4\"\nA 0 0 0\n");
    assert_eq!(p.domain().unwrap().tilt(), [1.0, 0.0, 0.0]);
}

#[test]
fn xyz_frames_follow_each_other_and_can_be_skipped() {
    let file = named("a.xyz", "1\nfirst\nA 0 0 0\n0\nempty\n2\nlast\nA 0 0 1\nA 0 0 2\n\n");
    let mut reader = XyzReader::open(&file.path).unwrap();
    assert!(reader.skip_frame().unwrap());
    assert!(reader.next_frame().unwrap().unwrap().is_empty());
    assert_eq!(reader.next_frame().unwrap().unwrap().len(), 2);
    assert!(reader.next_frame().unwrap().is_none() && !reader.skip_frame().unwrap());
    assert_eq!(read_frame(&file.path, &ParticleOptions::default(), -3).unwrap().len(), 1);
}

#[test]
fn bad_xyz_files_are_told_with_their_lines() {
    assert!(refused("2\n\nA 0 0 0\n").contains("ends after 1 of the 2 particles of frame 0"));
    assert!(refused("2\n\nA 0 0 0\nA 0").contains("ends after 1 of the 2 particles"));
    assert!(refused("1\n\nA 0 0 0\nA 0 0 0\n").contains(":4: 'A 0 0 0' stands where frame 1's number"));
    assert!(refused("1\n\n0 0 0\n").contains(":3: the row has 3 columns"));
    assert!(refused("1\nProperties=pos:R\nA 0 0 0\n").contains("no list of name:kind:count"));
    assert!(refused("1\nProperties=vel:R:3\n0 0 0\n").contains("no complete set of coordinates"));
    assert!(refused("1\n\nA 0 0 nan\n").contains(":3: column 4 'z' is NaN"));
    assert!(refused("1").contains("before the comment line"));
    assert!(refused("9000000000000000000\n\nA 0 0 0\n").contains("ends after 1 of the 9000000000000000000"));
}

const MERCURY: &str = "2 0.5 0 0 0 1 2 3\n1 2 3 4 5 6 7 8 9 10 11 12 13 0\n.1 .2 .3 4 5 6 .5 8 9 10 11 12 13 2\n";

#[test]
fn mercury_columns_have_their_fixed_meaning() {
    let (p, warnings) = read(MERCURY);
    assert!(warnings.is_empty());
    assert_eq!((p.positions()[0], p.radii().unwrap()), ([1.0, 2.0, 3.0], &[7.0, 0.5][..]));
    assert_eq!(column(&p, "velocity").1[..3], [4.0, 5.0, 6.0]);
    assert_eq!(column(&p, "orientation").1[..3], [8.0, 9.0, 10.0]);
    assert_eq!(column(&p, "angular_velocity").1[..3], [11.0, 12.0, 13.0]);
    assert_eq!((p.types().unwrap(), p.time(), p.step()), (&[0, 2][..], Some(0.5), None));
    assert_eq!(p.domain(), Some(&Domain::new([0.0; 3], [1.0, 2.0, 3.0], [false; 3]).unwrap()));
    assert_eq!(p.quantities().len(), 3);
}

#[test]
fn mercury_rows_that_end_in_another_number_than_a_species_keep_it() {
    let (p, _) = read(MERCURY.replace(" 13 2\n", " 13 2.5\n"));
    assert!(p.types().is_none());
    assert_eq!(column(&p, "info").1, [0.0, 2.5]);
}

#[test]
fn mercury_frames_may_be_empty_and_boxes_flat() {
    let file = file(format!("0 0 0 0 0 1 1 1\n0 1 0 0 0 1 1 0\n{MERCURY}"));
    let mut reader = open_particles(&file.path, &ParticleOptions::default()).unwrap();
    assert!(reader.next_frame().unwrap().unwrap().domain().is_some());
    let flat = reader.next_frame().unwrap().unwrap();
    assert!(flat.is_empty() && flat.domain().is_none() && flat.types().is_some());
    assert!(reader.warnings()[0].contains("box is empty"));
    assert_eq!(reader.next_frame().unwrap().unwrap().len(), 2);
    assert!(reader.next_frame().unwrap().is_none());
}

#[test]
fn bad_mercury_files_are_told_with_their_lines() {
    let cut = MERCURY.lines().take(2).collect::<Vec<_>>().join("\n");
    assert!(refused(format!("{cut}\n")).contains("ends after 1 of the 2 particles of frame 0"));
    assert!(refused(format!("{cut}\n.1 .2")).contains("ends after 1 of the 2 particles of frame 0"));
    assert!(refused(format!("{MERCURY}{MERCURY}1 2 3\n")).contains("where the header of frame 2 is expected"));
    assert!(refused(MERCURY.replace(".2 .3", ".2 x")).contains(":3: column 3 'z' holds 'x'"));
    assert!(refused("1 0 0 0 1 1\n0 0 0 0 0.5 0 0 0\n").contains("two-dimensional"));
    let file = file("a b c\n");
    let error = MercuryReader::open(&file.path).unwrap().next_frame().unwrap_err().to_string();
    assert!(error.contains(":1: 'a b c' stands where the header of frame 0"), "{error}");
}

#[test]
fn vtk_points_and_openfoam_clouds_are_opened_by_their_content() {
    let vtk = "# vtk DataFile Version 4.2\none\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n1 2 3\nPOINT_DATA 1\n\
               FIELD f 2\nradius 1 1 double\n0.5\nshapex 1 1 double\n0.5\n";
    assert!(refused(vtk).contains("column 'shapex' says that the particles are ellipsoids"));
    assert_eq!(read(vtk.replace("shapex", "height")).0.radii().unwrap(), [0.5]);
    let shape = file(vtk);
    let allowed = ParticleOptions { allow_non_spherical: true };
    assert_eq!(read_frame(&shape.path, &allowed, 0).unwrap().positions(), [[1.0, 2.0, 3.0]]);

    let header = |class: &str| format!("FoamFile\n{{\n format ascii;\n class {class};\n object positions;\n}}\n");
    let cloud = named("positions", format!("{}1\n(\n(1 2 3) 0\n)\n", header("Cloud<passiveParticle>")));
    std::fs::write(cloud.path.with_file_name("d"), format!("{}1(0.5)\n", header("scalarField"))).unwrap();
    for path in [cloud.path.as_path(), cloud.path.parent().unwrap()] {
        let p = read_frame(path, &ParticleOptions::default(), -1).unwrap();
        assert_eq!((p.positions(), p.radii().unwrap()), (&[[1.0, 2.0, 3.0]][..], &[0.25][..]));
    }
}

#[test]
fn a_function_that_reads_a_file_makes_a_reader_of_one_frame() {
    let file = file("");
    let read = |_: &std::path::Path| Ok(Particles::new(vec![[0.0; 3]]).unwrap());
    let mut reader = OneFrame::new(&file.path, read);
    assert_eq!(reader.next_frame().unwrap().unwrap().len(), 1);
    assert!(reader.next_frame().unwrap().is_none());
    let mut reader = OneFrame::new(&file.path, read);
    assert!(reader.skip_frame().unwrap() && !reader.skip_frame().unwrap());
}

#[test]
fn a_diameter_that_is_not_twice_the_radius_beside_it_is_refused_with_line_and_values() {
    let message = refused("x,y,z,radius,diameter\n0,0,0,1,2\n1,0,0,1,1\n");
    for part in ["particles.txt:3", "'radius' is 1", "'diameter' is 1, which is not twice as much", "remove or rename"]
    {
        assert!(message.contains(part), "{message}");
    }
    let dump = |diameter: f64| {
        format!(
            "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n\
             ITEM: ATOMS id x y z radius diameter\n1 .5 .5 .5 .1 {diameter}\n"
        )
    };
    let message = refused(dump(0.1));
    assert!(message.contains("particles.txt:10") && message.contains("is 0.1, which is not twice"), "{message}");
    // Few digits, empty fields and words are no contradiction, and short names may be something else.
    assert_eq!(read(dump(0.2)).0.radii().unwrap(), [0.1]);
    assert_eq!(read("x,y,z,radius,diameter\n0,0,0,0.3333,0.6667\n").0.radii().unwrap(), [0.3333]);
    assert_eq!(read("x,y,z,radius,diameter\n0,0,0,1,\n").0.radii().unwrap(), [1.0]);
    assert_eq!(read("x,y,z,radius,diameter\n0,0,0,1,large\n").0.radii().unwrap(), [1.0]);
    assert_eq!(read("x,y,z,radius,d\n0,0,0,1,7\n").0.radii().unwrap(), [1.0]);
}

#[test]
fn units_of_si_behind_names_are_left_away_and_multiples_of_them_are_refused_with_the_column() {
    let (p, warnings) =
        read("x [m],y [m],z [m],r [m],Vel.x [m/s],Vel.y [m/s],Vel.z [m/s],T [degC]\n1,2,3,0.5,4,5,6,7\n");
    assert_eq!((p.positions(), p.radii().unwrap(), warnings.len()), (&[[1.0, 2.0, 3.0]][..], &[0.5][..], 0));
    assert_eq!(column(&p, "velocity"), (3, vec![4.0, 5.0, 6.0]));
    assert_eq!(column(&p, "T [degC]"), (1, vec![7.0]));
    for (header, named) in [
        ("x,y,z,Diameter [mm]", "column 4 'Diameter [mm]' is in mm, which is no unit of SI"),
        ("x [cm],y,z,r", "column 1 'x [cm]' is in cm"),
        ("x,y,z,vx [m/s],vy [m/s],vz [mm/s],r", "column 6 'vz [mm/s]' is in mm/s"),
        ("x,y,z,Rho [g/cm^3]", "column 4 'Rho [g/cm^3]' is in g/cm^3"),
    ] {
        let message = refused(format!("{header}\n1,2,3,4,5,6,7\n"));
        assert!(message.contains(":1: ") && message.contains(named), "{message}");
        assert!(message.contains("write the column in SI units"), "{message}");
    }
    // A quantity that nothing is computed of by itself keeps its unit for all to see.
    let (p, _) = read("x,y,z,r,Press [kPa]\n1,2,3,0.5,7\n");
    assert_eq!((p.len(), column(&p, "Press [kPa]")), (1, (1, vec![7.0])));
}

#[test]
fn lines_of_other_names_and_numbers_before_the_one_that_names_the_coordinates_are_passed_over() {
    let table = "Pos.x [m];Pos.y [m];Pos.z [m];Idp;Vel.x [m/s];Vel.y [m/s];Vel.z [m/s];Rhop [kg/m^3];Type\n\
                 0.5;0.25;1;17;1;2;3;998;3\n";
    let before = ["TimeStep [s];Np;Nbound\n0.25;1;0\n", "TimeStep: 0.25\nNp: 1\n", "# Run\nTime\n0.25\n\n", ""];
    for before in before {
        let (p, _) = read(format!("{before}{table}"));
        assert_eq!((p.positions(), p.types().unwrap()), (&[[0.5, 0.25, 1.0]][..], &[3][..]), "{before}");
        assert_eq!(column(&p, "velocity"), (3, vec![1.0, 2.0, 3.0]));
        assert_eq!((column(&p, "density"), column(&p, "Idp")), ((1, vec![998.0]), (1, vec![17.0])));
    }
    // Where no line names coordinates, the first is the one to be corrected.
    let message = refused("a;b;c\n1;2;3\nd;e;f\n4;5;6\n");
    assert!(message.contains(":1: no complete set of coordinates") && message.contains("columns a b c"), "{message}");
}

#[test]
fn columns_are_found_by_the_names_that_the_file_has_for_them() {
    let one = |particles: &Particles, name: &str| particles.column(name).unwrap().data[0];
    let (p, _) = read("ID,Type,X,Y,Z,Diam,vx,vy,vz,Mass,stress:0,stress:1\n7,2,1,2,3,0.5,4,5,6,9,10,11\n");
    let found = ["id", "ID", "Type", "type", "Diam", "radius", "vy", "velocity[2]", "Mass", "mass", "stress:1"];
    let values = [7.0, 7.0, 2.0, 2.0, 0.5, 0.25, 5.0, 5.0, 9.0, 9.0, 11.0];
    for (name, value) in found.into_iter().zip(values) {
        assert_eq!(one(&p, name), value, "{name}");
    }
    let message = p.column("weight").unwrap_err().to_string();
    let listed = "velocity (vx, vy, vz), mass (Mass), stress (stress:0, stress:1), id (ID), type (Type), radius, diameter (Diam)";
    assert!(message.ends_with(listed), "{message}");
}

#[test]
fn components_that_the_file_numbers_are_written_with_its_numbers() {
    let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n\
                ITEM: ATOMS x y z vx vy vz c_w[1] c_w[2] f_a[1] f_a[2] f_a[3]\n.5 .5 .5 1 2 3 4 5 6 7 8\n";
    let (p, _) = read(dump);
    assert_eq!([p.column("c_w[1]").unwrap().data[0], p.column("f_a[3]").unwrap().data[0]], [4.0, 8.0]);
    let out = file("");
    write_particles_csv(&out.path, &p).unwrap();
    let text = std::fs::read_to_string(&out.path).unwrap();
    let header = "x,y,z,velocity_x,velocity_y,velocity_z,c_w[1],c_w[2],f_a[1],f_a[2],f_a[3]";
    assert_eq!(text.lines().next(), Some(header));
    let (back, _) = read(text);
    assert_eq!(back.quantities(), p.quantities());
}
