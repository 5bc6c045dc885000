//! Dumps, branch by branch.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::PathBuf;

use fieldstone_io::{DumpReader, FrameReader, ParticleOptions, open_particles, read_frame};
use fieldstone_particles::{Domain, Particles};
use tempfile::TempDir;

struct File {
    _folder: TempDir,
    path: PathBuf,
}

fn file(content: impl AsRef<[u8]>) -> File {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("particles.dump");
    std::fs::write(&path, content).unwrap();
    File { _folder: folder, path }
}

/// A frame with this box (its header line's rest and its lines), column names and rows.
fn frame(box_: &str, columns: &str, rows: &[&str]) -> String {
    let body: String = rows.iter().flat_map(|row| [row, "\n"]).collect();
    let count = rows.len();
    format!("ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS {box_}\nITEM: ATOMS {columns}\n{body}")
}

const UNIT: &str = "pp pp ff\n0 1\n0 2\n0 4";

fn read(content: impl AsRef<[u8]>) -> (Particles, Vec<String>) {
    let file = file(content);
    let mut reader = DumpReader::open(&file.path).unwrap();
    let particles = reader.next_frame().unwrap().expect("a frame");
    (particles, reader.warnings().to_vec())
}

fn refused(content: impl AsRef<[u8]>) -> String {
    let file = file(content);
    let mut reader = DumpReader::open(&file.path).unwrap();
    let error = loop {
        match reader.next_frame() {
            Ok(Some(_)) => {}
            Ok(None) => panic!("read to the end"),
            Err(error) => break error.to_string(),
        }
    };
    assert!(reader.next_frame().unwrap().is_none(), "after an error there is nothing more");
    assert!(!reader.skip_frame().unwrap());
    assert!(error.contains("particles.dump:"), "the file is named: {error}");
    error
}

fn column(particles: &Particles, name: &str) -> (usize, Vec<f64>) {
    let quantity = particles.quantity(name).unwrap();
    (quantity.components, quantity.data.clone())
}

#[test]
fn columns_in_any_order_are_told_by_their_names() {
    let (p, warnings) = read(frame(
        UNIT,
        "omegaz fy vz radius z vy type y fx vx id x rho mass omegax omegay fz ix iz iy",
        &["1 2 3 0.5 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19"],
    ));
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(p.positions(), [[11.0, 7.0, 4.0]]);
    assert_eq!(p.radii().unwrap(), [0.5]);
    assert_eq!((p.ids().unwrap(), p.types().unwrap()), (&[10][..], &[6][..]));
    assert_eq!(column(&p, "velocity"), (3, vec![9.0, 5.0, 3.0]));
    assert_eq!(column(&p, "force"), (3, vec![8.0, 2.0, 16.0]));
    assert_eq!(column(&p, "angular_velocity"), (3, vec![14.0, 15.0, 1.0]));
    assert_eq!(column(&p, "image"), (3, vec![17.0, 19.0, 18.0]));
    assert_eq!(column(&p, "density"), (1, vec![12.0]));
    assert_eq!(column(&p, "mass"), (1, vec![13.0]));
    assert_eq!(p.quantities().len(), 6);
    assert_eq!(p.domain(), Some(&Domain::new([0.0; 3], [1.0, 2.0, 4.0], [true, true, false]).unwrap()));
}

#[test]
fn numbered_columns_become_one_quantity_only_where_all_from_one_on_are_there() {
    let (p, _) = read(frame(UNIT, "x y z c_st[2] c_st[1] c_st[3] c_q[2] c_q[3] f_a[1]", &["0 0 0 2 1 3 7 8 9"]));
    assert_eq!(column(&p, "c_st"), (3, vec![1.0, 2.0, 3.0]));
    assert_eq!(column(&p, "c_q[2]"), (1, vec![7.0]));
    assert_eq!(column(&p, "c_q[3]"), (1, vec![8.0]));
    assert_eq!(column(&p, "f_a[1]"), (1, vec![9.0]));
}

#[test]
fn a_group_whose_name_is_taken_stays_a_set_of_scalars() {
    let (p, _) =
        read(frame(UNIT, "x y z velocity vx vy vz c_a c_a[1] c_a[2] rho density", &["0 0 0 1 2 3 4 5 6 7 8 9"]));
    let all: Vec<_> = p.quantities().iter().map(|q| (q.name.as_str(), q.data[0])).collect();
    let expected = [
        ("velocity", 1.0),
        ("vx", 2.0),
        ("vy", 3.0),
        ("vz", 4.0),
        ("c_a", 5.0),
        ("c_a[1]", 6.0),
        ("c_a[2]", 7.0),
        ("rho", 8.0),
        ("density", 9.0),
    ];
    assert_eq!(all, expected);
}

#[test]
fn coordinates_are_taken_plain_then_unwrapped_then_scaled() {
    let (p, _) = read(frame(UNIT, "xs ys zs xu yu zu x y z", &["0 0 0 1 2 3 4 5 6"]));
    assert_eq!(p.positions(), [[4.0, 5.0, 6.0]]);
    assert_eq!(column(&p, "xu"), (1, vec![1.0]));
    let (p, _) = read(frame(UNIT, "xs ys zs xu yu zu", &["0 0 0 1 2 3"]));
    assert_eq!(p.positions(), [[1.0, 2.0, 3.0]]);
    for names in ["xs ys zs", "xsu ysu zsu"] {
        let (p, _) = read(frame("pp pp pp\n-1 1\n0 2\n1 5", names, &["0.25 0.5 0.75"]));
        assert_eq!(p.positions(), [[-0.5, 1.0, 4.0]]);
    }
}

#[test]
fn sizes_are_taken_from_radius_before_diameter_before_d() {
    for (names, rows, expected) in [
        ("x y z diameter radius", "0 0 0 6.001 3", 3.0),
        ("x y z d diameter", "0 0 0 2 8", 4.0),
        ("x y z d", "0 0 0 2", 1.0),
    ] {
        assert_eq!(read(frame(UNIT, names, &[rows])).0.radii().unwrap(), [expected], "{names}");
    }
    assert!(read(frame(UNIT, "x y z", &["0 0 0"])).0.radii().is_err());
}

#[test]
fn a_tilted_box_is_freed_from_the_bounds_around_it() {
    // Edges (4, 0, 0), (1, 5, 0), (-2, 0.5, 6) from (0, 0, 0): bounds are those of the parallelepiped.
    let (p, warnings) = read(frame("xy xz yz pp pp ff\n-2 5 1\n0 5.5 -2\n0 6 0.5", "xs ys zs", &["0.5 0.5 0.5"]));
    assert_eq!(p.positions(), [[1.5, 2.75, 3.0]]);
    let domain = p.domain().unwrap();
    assert_eq!(domain.cell_vectors(), [[4.0, 0.0, 0.0], [1.0, 5.0, 0.0], [-2.0, 0.5, 6.0]]);
    assert_eq!((domain.low(), domain.periodic()), ([0.0; 3], [true, true, false]));
    assert_eq!(domain.bounds(), ([-2.0, 0.0, 0.0], [5.0, 5.5, 6.0]));
    assert!(warnings.is_empty(), "{warnings:?}");
}

#[test]
fn a_box_of_three_edge_vectors_is_kept_where_they_form_a_lower_triangle() {
    let (p, warnings) = read(frame("abc origin pp ff pp\n4 0 0 -2\n1 5 0 -3\n0.5 0.25 6 -4", "xs ys zs", &["1 1 1"]));
    assert_eq!(p.positions(), [[3.5, 2.25, 2.0]]);
    assert_eq!((p.domain().unwrap().tilt(), warnings.len()), ([1.0, 0.5, 0.25], 0));
    let (p, warnings) = read(frame("abc origin pp ff pp\n0 4 0 -2\n-5 1 0 -3\n0 0 6 -4", "xs ys zs", &["1 1 1"]));
    assert_eq!(p.positions(), [[-7.0, 2.0, 2.0]]);
    assert!(p.domain().is_none() && warnings[0].contains("read without a box"), "{warnings:?}");
}

#[test]
fn a_triclinic_box_without_tilt_is_an_orthogonal_box() {
    let expected = Domain::new([-1.0, 0.0, 1.0], [3.0, 5.0, 7.0], [true, false, true]).unwrap();
    for box_ in ["xy xz yz pp ff pp\n-1 3 0\n0 5 0\n1 7 0", "abc origin pp ff pp\n4 0 0 -1\n0 5 0 0\n0 0 6 1"] {
        let (p, warnings) = read(frame(box_, "x y z", &["0 0 0"]));
        assert_eq!(p.domain(), Some(&expected));
        assert!(warnings.is_empty());
    }
}

#[test]
fn a_box_without_flags_is_taken_as_not_periodic_with_a_warning() {
    let (p, warnings) = read(frame("\n0 1\n0 1\n0 1", "x y z", &["0 0 0"]));
    assert_eq!(p.domain().unwrap().periodic(), [false; 3]);
    assert!(warnings[0].contains("which directions are periodic"), "{warnings:?}");
}

#[test]
fn units_and_time_are_read_wherever_they_stand() {
    let content = format!("ITEM: UNITS\nsi\nITEM: TIME\n0.25\n{}", frame(UNIT, "x y z", &["0 0 0"]));
    let file = file(&content);
    let mut reader = DumpReader::open(&file.path).unwrap();
    assert_eq!(reader.units(), None);
    let p = reader.next_frame().unwrap().unwrap();
    assert_eq!(reader.units(), Some("si"));
    assert_eq!((p.step(), p.time()), (Some(5), Some(0.25)));
}

#[test]
fn several_frames_may_change_their_columns_and_counts() {
    let content = [
        frame(UNIT, "id x y z radius", &["1 0 0 0 1", "2 0 0 1 1"]),
        frame(UNIT, "z y x", &[]),
        "\n".into(),
        frame(UNIT, "z y x element", &["1 2 3 Fe"]),
    ]
    .concat();
    let file = file(&content);
    let mut reader = DumpReader::open(&file.path).unwrap();
    let first = reader.next_frame().unwrap().unwrap();
    assert_eq!((first.len(), first.ids().is_some()), (2, true));
    let empty = reader.next_frame().unwrap().unwrap();
    assert!(empty.is_empty() && empty.domain().is_some() && empty.ids().is_none());
    let last = reader.next_frame().unwrap().unwrap();
    assert_eq!(last.positions(), [[3.0, 2.0, 1.0]]);
    assert_eq!(reader.warnings(), ["column 'element' holds text and is passed over"]);
    assert!(reader.next_frame().unwrap().is_none());
    let options = ParticleOptions::default();
    assert_eq!(read_frame(&file.path, &options, -1).unwrap(), last);
    assert_eq!(read_frame(&file.path, &options, -2).unwrap(), empty);
    assert_eq!(read_frame(&file.path, &options, 0).unwrap(), first);
    assert!(read_frame(&file.path, &options, 3).unwrap_err().to_string().contains("holds 3"));
}

#[test]
fn type_labels_are_passed_over_and_the_rest_is_kept() {
    let (p, warnings) = read(frame(UNIT, "id type x y z q", &["1 glass 0 0 0 nan"]));
    assert!(p.types().is_none() && p.ids().is_some());
    assert!(column(&p, "q").1[0].is_nan(), "a quantity may be NaN");
    assert_eq!(warnings, ["column 'type' holds text and is passed over"]);
}

#[test]
fn ids_above_two_to_the_53_are_exact() {
    let (p, _) = read(frame(UNIT, "id x y z", &["9007199254740993 0 0 0"]));
    assert_eq!(p.ids().unwrap(), [9_007_199_254_740_993]);
}

#[test]
fn windows_line_ends_tabs_and_trailing_blanks_do_not_matter() {
    let content = frame(UNIT, "id x y z", &["1\t0.5  0 0 ", " 2 0 0 0.5"]);
    let (unix, _) = read(&content);
    assert_eq!(read(content.replace('\n', "\r\n")).0, unix);
    assert_eq!(unix.positions(), [[0.5, 0.0, 0.0], [0.0, 0.0, 0.5]]);
}

#[test]
fn an_unknown_section_is_passed_over_with_a_warning() {
    let content = frame(UNIT, "x y z", &["0 0 1"]).replace("ITEM: BOX", "ITEM: LABEL\nfoo\nbar\nITEM: BOX");
    let (p, warnings) = read(content);
    assert_eq!(p.len(), 1);
    assert!(warnings[0].contains("ITEM: LABEL"), "{warnings:?}");
}

#[test]
fn a_column_named_twice_is_read_once_where_both_agree() {
    let (p, _) = read(frame(UNIT, "id x y z x id", &["1 0.5 0 0 0.5 1"]));
    assert_eq!((p.len(), p.quantities().len()), (1, 0));
    let error = refused(frame(UNIT, "id x y z x", &["1 0.5 0 0 0.5", "2 0.5 0 0 0.25"]));
    assert!(error.contains(":11: column 5 'x' holds another value than column 2"), "{error}");
}

#[test]
fn shapes_and_clumps_are_refused_unless_allowed() {
    let cases = [
        ("shapex shapey shapez blockiness1 blockiness2 quat1 quat2 quat3 quat4", "superquadrics", "shapex"),
        ("quatw quati quatj quatk", "superquadrics", "quatw"),
        ("c_shape[1] c_shape[2] c_shape[3]", "ellipsoids", "c_shape"),
        ("id_multisphere", "clumps", "id_multisphere"),
        ("body", "clumps", "body"),
        ("c_clump[1]", "clumps", "c_clump[1]"),
    ];
    for (columns, what, kept) in cases {
        let zeros = vec!["1"; 3 + columns.split(' ').count()].join(" ");
        let content = frame(UNIT, &format!("x y z {columns}"), &[&zeros]);
        let error = refused(&content);
        assert!(error.contains(what) && error.contains(":9:"), "{error}");
        let file = file(&content);
        let options = ParticleOptions { allow_non_spherical: true };
        let p = open_particles(&file.path, &options).unwrap().next_frame().unwrap().unwrap();
        assert!(p.quantity(kept).is_ok(), "{kept} is kept as a column");
    }
}

#[test]
fn molecules_are_read_with_a_word_on_overlaps() {
    let (_, warnings) = read(frame(UNIT, "mol x y z", &["1 0 0 0"]));
    assert!(warnings[0].contains("counted twice"), "{warnings:?}");
}

#[test]
fn a_bad_number_is_told_with_line_column_and_word() {
    let error = refused(frame(UNIT, "id x y z", &["1 0 0 0", "2 0 1.2.3 0"]));
    assert!(error.contains(":11: column 3 'y' holds '1.2.3', which is no number"), "{error}");
    let error = refused(frame(UNIT, "id x y z", &["1.5 0 0 0"]));
    assert!(error.contains(":10: column 1 'id' holds '1.5', which is no integer"), "{error}");
    // In the first row too: only words that begin with a letter are text.
    let error = refused(frame(UNIT, "x y z q", &["0 0 0 1x"]));
    assert!(error.contains("'1x'"), "{error}");
    let error = refused(frame(UNIT, "x y z vx vy vz", &["0 0 0 a b c"]));
    assert!(error.contains("'vx' holds 'a'"), "{error}");
}

#[test]
fn a_row_with_too_few_or_too_many_columns_tells_both_numbers() {
    let error = refused(frame(UNIT, "id x y z", &["1 0 0 0", "2 0 0"]));
    assert!(error.contains(":11: the row has 3 columns; 4 columns are expected: id x y z"), "{error}");
    let error = refused(frame(UNIT, "id x y z", &["1 0 0 0 77 78"]));
    assert!(error.contains("the row has 6 columns") && error.contains("'77'"), "{error}");
}

#[test]
fn a_position_that_is_nan_or_infinite_is_refused_with_its_line() {
    for bad in ["nan", "-nan", "inf", "1e999"] {
        let error = refused(frame(UNIT, "id x y z", &["1 0 0 0", &format!("2 0 0 {bad}")]));
        assert!(error.contains(":11: column 4 'z' is "), "{error}");
    }
}

#[test]
fn sizes_that_are_zero_negative_or_nan_are_refused_with_their_line() {
    for bad in ["0", "-1", "nan", "inf", "4e-324"] {
        let error = refused(frame(UNIT, "x y z diameter", &["0 0 0 1", &format!("0 0 0 {bad}")]));
        assert!(error.contains(":11: column 4 'diameter' is "), "{bad}: {error}");
    }
}

#[test]
fn numbers_beyond_what_can_be_computed_with_are_refused_shortly_and_with_their_line() {
    for (row, reason) in [
        ("2 1e300 0 0 1", "column 2 'x' is 1e300; coordinates must be at most 1e100 in size"),
        ("2 0 0 0 1e300", "column 5 'radius' is 1e300; sizes must be between 1e-100 and 1e100"),
        ("99999999999999999999 0 0 0 1", "which is too large: from -9223372036854775808 to 9223372036854775807"),
    ] {
        let error = refused(frame(UNIT, "id x y z radius", &["1 0 0 0 1", row]));
        assert!(error.contains(":11: ") && error.contains(reason), "{error}");
    }
}

#[test]
fn a_cut_frame_says_how_many_atoms_are_there() {
    let whole = frame(UNIT, "id x y z", &["1 0 0 0"]) + &frame(UNIT, "id x y z", &["1 0 0 0", "2 0 0 0", "3 0 0 0.5"]);
    let cut = whole.strip_suffix("3 0 0 0.5\n").unwrap();
    let error = refused(cut);
    assert!(error.contains("the file ends after 2 of the 3 atoms of frame 1"), "{error}");
    // In the middle of a row, and of a number.
    for rest in ["3", "3 0 0", "3 0 0 -"] {
        let error = refused(format!("{cut}{rest}"));
        assert!(error.contains(":22: the file ends after 2 of the 3 atoms of frame 1"), "{error}");
    }
    // A row that is complete but for its line end cannot be told from a cut number: it is read, with a word.
    let (_, warnings) = read(frame(UNIT, "id x y z", &["1 0 0 0"]).trim_end());
    assert!(warnings[0].contains("no line end"), "{warnings:?}");
}

#[test]
fn a_cut_header_says_in_which_frame() {
    let one = frame(UNIT, "id x y z", &["1 0 0 0"]);
    for cut in [
        "ITEM: TIMESTEP\n5\n",
        "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n",
    ] {
        let error = refused(format!("{one}{cut}"));
        assert!(error.contains("ends within the header of frame 1"), "{error}");
    }
    assert!(refused("ITEM: TIMESTEP\n").contains("ends where a time step is expected"));
    assert!(refused("ITEM: BOX BOUNDS ff ff ff\n0 1\n").contains("ends within the box"));
}

#[test]
fn a_wrong_number_of_atoms_is_found_either_way() {
    let two = frame(UNIT, "x y z", &["0 0 0", "0 0 1"]);
    let more = two.replace("ATOMS\n2", "ATOMS\n3") + &two;
    assert!(refused(more).contains(":12: frame 0 has 2 rows, but its number of atoms is 3"));
    let fewer = two.replace("ATOMS\n2", "ATOMS\n1");
    assert!(refused(fewer).contains("more rows than its number of atoms says"));
    for bad in ["-1", "two", "1.5", "", "1 2"] {
        let error = refused(two.replace("ATOMS\n2", &format!("ATOMS\n{bad}")));
        assert!(error.contains("where a number of atoms is expected"), "{error}");
    }
    let error = refused(two.replace("ITEM: NUMBER OF ATOMS\n2\n", ""));
    assert!(error.contains("no 'ITEM: NUMBER OF ATOMS'"), "{error}");
}

#[test]
fn a_number_of_atoms_beyond_any_memory_is_refused_without_using_it() {
    let huge =
        frame(UNIT, "x y z radius vx vy vz", &["0 0 0 1 0 0 0"]).replace("ATOMS\n1", "ATOMS\n9000000000000000000");
    assert!(refused(huge).contains("after 1 of the 9000000000000000000 atoms"));
}

#[test]
fn a_damaged_box_is_refused() {
    for (box_, word) in [
        ("pp pp ff\n0 1\n0 1 2\n0 1", "needs 2 numbers"),
        ("pp pp ff\n0 1\n0 x\n0 1", "needs 2 numbers"),
        ("pp pp ff\n0 1\n0 nan\n0 1", "needs 2 numbers"),
        ("xy xz yz pp pp ff\n0 1\n0 1\n0 1", "needs 3 numbers"),
        ("abc origin pp pp ff\n0 1 2\n0 1 2\n0 1 2", "needs 4 numbers"),
        ("pp ff\n0 1\n0 1\n0 1", "boundary flags"),
        ("pp qq ff\n0 1\n0 1\n0 1", "boundary flags"),
        ("pp pp ff\n0 1\n1 1\n0 1", "the upper bound must be above"),
    ] {
        let error = refused(frame(box_, "x y z", &["0 0 0"]));
        assert!(error.contains(word), "{box_}: {error}");
    }
}

#[test]
fn missing_coordinates_name_the_columns_that_are_there() {
    let error = refused(frame(UNIT, "id x y q", &["1 0 0 0"]));
    assert!(error.contains("no complete set of coordinates") && error.contains("id x y q"), "{error}");
    let no_box = "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS xs ys zs\n0 0 0\n";
    assert!(refused(no_box).contains("fractions of the box"));
    let (p, warnings) = read(no_box.replace("xs ys zs", "x y z"));
    assert!(p.domain().is_none() && warnings == ["the file states no box"]);
}

#[test]
fn contacts_and_other_text_are_told_apart_from_particles() {
    let local = frame(UNIT, "c_1 c_2", &["0 0"]).replace("NUMBER OF ATOMS", "NUMBER OF ENTRIES");
    assert!(refused(local).contains("this is a dump local (contacts"));
    assert!(refused("x y z\n0 0 0\n").contains("no LIGGGHTS or LAMMPS text dump"));
}

#[test]
fn a_compressed_file_that_was_cut_is_an_error_not_a_short_frame() {
    use std::io::Write;
    let rows: Vec<String> = (0..5000).map(|i| format!("{i} {} 0 0", f64::from(i).sqrt())).collect();
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(frame(UNIT, "id x y z", &rows).as_bytes()).unwrap();
    let bytes = encoder.finish().unwrap();
    assert_eq!(read(&bytes).0.len(), 5000);
    let file = file(&bytes[..bytes.len() / 2]);
    let error = DumpReader::open(&file.path).unwrap().next_frame().unwrap_err().to_string();
    assert!(error.contains("cannot read"), "{error}");
}
