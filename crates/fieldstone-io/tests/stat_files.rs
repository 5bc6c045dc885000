//! MercuryCG's `.stat` files: written and read back, cut and damaged, and one of its own.

#![allow(clippy::unwrap_used)]

use fieldstone_io::{IoError, StatField, StatFile, StatHeader, StatWriter, read_stat};
use fieldstone_testing::Random;
use proptest::prelude::*;
use std::path::Path;

fn header(coordinates: &str, points: [usize; 3]) -> StatHeader {
    StatHeader {
        coordinates: coordinates.parse().unwrap(),
        low: [-1.0, 0.0, 0.5],
        high: [1.0, 2.5, 3.5],
        time_min: 0.25,
        points,
        width: 0.5,
        function: "Gauss width 0.5 cutoff 1.5".into(),
    }
}

fn write(path: &Path, header: &StatHeader, fields: &[StatField], blocks: &[(f64, Vec<Vec<f64>>)]) {
    let mut writer = StatWriter::create(path, header.clone(), fields.to_vec()).unwrap();
    for (time, data) in blocks {
        writer.block(*time, &data.iter().map(Vec::as_slice).collect::<Vec<_>>()).unwrap();
    }
    writer.finish().unwrap();
}

fn field(name: &str, components: usize) -> StatField {
    StatField { name: name.into(), components }
}

#[test]
fn rows_have_z_fastest_and_averaged_coordinates_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("xz.stat");
    // Cells with x fastest: (0,0), (1,0), (0,1), (1,1).
    write(&path, &header("XZ", [2, 1, 2]), &[field("Density", 1)], &[(1.5, vec![vec![1.0, 2.0, 3.0, 4.0]])]);
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(
        text,
        "CG<XZ> min -1 0 0.5 max 1 2.5 3.5 timeMin 0.25 n 2 1 2 width 0.5 Gauss width 0.5 cutoff 1.5\n\
         time x z 4:Density \n1.5 -0.5 1.25 1\n1.5 -0.5 2.75 3\n1.5 0.5 1.25 2\n1.5 0.5 2.75 4\n"
    );
    let file = read_stat(&path).unwrap();
    assert_eq!(file.header, header("XZ", [2, 1, 2]));
    assert_eq!(file.blocks[0].data[0], [1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn lists_of_numbers_that_do_not_fit_the_fields_are_refused_and_the_file_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("z.stat");
    let mut writer = StatWriter::create(&path, header("Z", [1, 1, 2]), vec![field("Density", 1)]).unwrap();
    for (data, expected) in [
        (&[][..], "0 lists of numbers were given for 1 fields"),
        (&[&[1.0][..]][..], "field 'Density' of 2 points times 1 components has 1 numbers"),
    ] {
        let error = writer.block(0.5, data).unwrap_err();
        assert!(matches!(error, IoError::Content { .. }) && error.to_string().contains(expected), "{error}");
    }
    writer.block(0.5, &[&[1.0, 2.0]]).unwrap();
    writer.finish().unwrap();
    assert_eq!(read_stat(&path).unwrap().blocks.len(), 1);
}

proptest! {
    #[test]
    fn what_is_written_reads_back_to_six_digits(
        points in prop::array::uniform3(1usize..5),
        components in prop::collection::vec(1usize..10, 1..4),
        seed in any::<u32>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("any.stat");
        let count: usize = points.iter().product();
        let value = |k: usize| {
            let x = Random(u64::from(seed) + k as u64).uniform(-0.5, 0.5);
            x * 10f64.powi((k % 23) as i32 - 11)
        };
        let fields: Vec<StatField> = components.iter().enumerate().map(|(k, &n)| field(&format!("F{k}"), n)).collect();
        let data: Vec<Vec<f64>> = components.iter().map(|&n| (0..n * count).map(value).collect()).collect();
        write(&path, &header("XYZ", points), &fields, &[(0.0, data.clone()), (1.0, data.clone())]);
        let file = read_stat(&path).unwrap();
        prop_assert_eq!(&file.fields, &fields);
        prop_assert_eq!(file.blocks.len(), 2);
        for block in &file.blocks {
            for (a, b) in block.data.iter().flatten().zip(data.iter().flatten()) {
                prop_assert!((a - b).abs() <= 5.1e-6 * b.abs(), "{} {}", a, b);
            }
        }
    }
}

fn message(path: &Path) -> String {
    let error: IoError = read_stat(path).unwrap_err();
    error.to_string()
}

#[test]
fn cut_and_foreign_files_are_named_with_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file.stat");
    write(&path, &header("XYZ", [2, 2, 2]), &[field("Density", 1)], &[(0.0, vec![vec![1.0; 8]])]);
    let text = std::fs::read_to_string(&path).unwrap();
    for (content, parts) in [
        (String::new(), ["file.stat", "where the header CG<XYZ>"]),
        ("x,y,z\n".into(), ["file.stat:1", "where the header CG<XYZ>"]),
        (text.replace("n 2 2 2", "n 2 0 2"), ["file.stat:1", "where the header CG<XYZ>"]),
        (text.replace("5:Density", "Density"), ["file.stat:2", "does not name columns"]),
        (text.replacen("0 -0.5 0.625", "0 -0.5", 1), ["file.stat:3", "has not the 5 numbers"]),
        (text.replacen(" 1\n", " one\n", 1), ["file.stat:3", "has not the 5 numbers"]),
        (
            text.lines().take(6).fold(String::new(), |all, l| all + l + "\n"),
            ["file.stat:6", "ends after 4 of the 8 rows"],
        ),
        (text.replace("n 2 2 2", "n 2 2 99999999999"), ["file.stat:2", "too many points"]),
    ] {
        std::fs::write(&path, content).unwrap();
        let found = message(&path);
        assert!(parts.iter().all(|part| found.contains(part)), "{found}");
    }
}

#[test]
fn mercury_cgs_own_file_is_read_and_written_again_byte_by_byte() {
    let Some(folder) = fieldstone_testing::extended("mercury-box") else { return };
    for name in ["box1000.O.stat", "box1000.Lucy.n20.stat.gz", "box1000.Gauss.n20.stat.gz"] {
        let path = folder.join(name);
        let StatFile { header, fields, blocks } = read_stat(&path).unwrap();
        assert_eq!(fields.iter().map(|f| f.components).sum::<usize>(), 29);
        let copy = tempfile::tempdir().unwrap();
        let target = copy.path().join("copy.stat");
        let blocks: Vec<(f64, Vec<Vec<f64>>)> = blocks.into_iter().map(|block| (block.time, block.data)).collect();
        write(&target, &header, &fields, &blocks);
        let (a, b) = (std::fs::read_to_string(&target).unwrap(), fieldstone_testing::read_text(&path));
        assert!(a == b, "{name}: {:?}", a.lines().zip(b.lines()).find(|(a, b)| a != b));
    }
}
