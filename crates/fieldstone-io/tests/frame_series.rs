//! Series of frames with contacts, by name, range, step, time and order, in the foreground and in the background.

#![allow(clippy::unwrap_used)]

use std::fmt::Write;
use std::path::PathBuf;

use fieldstone_io::{
    ContactFiles, ContactOptions, ContactPreset, IoError, ParticleOptions, Series, SeriesFrame, find_files,
};
use fieldstone_testing::extended;

fn write_dump(text: &mut String, step: i64) {
    write!(text, "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n-9 9\n-9 9\n-9 9\n")
        .unwrap();
    write!(text, "ITEM: ATOMS id x y z radius\n1 0 0 0 0.5\n2 1 0 0 0.5\n").unwrap();
}

fn write_pairs(text: &mut String, step: i64) {
    write!(text, "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS ff ff ff\n-9 9\n-9 9\n-9 9\n")
        .unwrap();
    writeln!(text, "ITEM: ENTRIES c_i[1] c_i[2] c_f[1] c_f[2] c_f[3]\n1 2 {} 0 0", -step).unwrap();
}

fn pair_columns() -> ContactOptions {
    ContactOptions { preset: None, columns: Some("id1=c_i[1],id2=c_i[2],force=c_f[1..3]".parse().unwrap()) }
}

/// Particles in three files of two frames each, contacts of the listed steps in one file.
fn small_series(contact_steps: &[i64], range: &str) -> (tempfile::TempDir, Series) {
    let folder = tempfile::tempdir().unwrap();
    for file in [8, 9, 10] {
        let mut text = String::new();
        write_dump(&mut text, 100 * file);
        write_dump(&mut text, 100 * file + 50);
        std::fs::write(folder.path().join(format!("part.{file}.dump")), text).unwrap();
    }
    let mut text = String::new();
    contact_steps.iter().for_each(|&step| write_pairs(&mut text, step));
    std::fs::write(folder.path().join("pairs.dump"), text).unwrap();
    let files = find_files(&folder.path().join("part.{}.dump").to_string_lossy()).unwrap();
    let contacts = ContactFiles { files: vec![folder.path().join("pairs.dump")], options: pair_columns() };
    let series = Series::new(files, ParticleOptions::default()).with_contacts(contacts);
    (folder, series.with_range(range.parse().unwrap()))
}

/// Index and step of each frame, whose contact has a force equal to the step.
fn steps(frames: Vec<SeriesFrame>) -> Vec<(usize, i64)> {
    let step = |frame: SeriesFrame| {
        let step = frame.particles.step().unwrap();
        assert_eq!(frame.contacts.unwrap().get(0).force[0], -(step as f64));
        (frame.index, step)
    };
    frames.into_iter().map(step).collect()
}

#[test]
fn contacts_are_matched_by_step_and_superfluous_ones_passed_over() {
    let all = [1, 800, 850, 870, 900, 950, 1000, 1050, 2000];
    let (_folder, series) = small_series(&all, ":");
    let frames = series.collect::<Result<Vec<_>, _>>().unwrap();
    assert_eq!(steps(frames), [(0, 800), (1, 850), (2, 900), (3, 950), (4, 1000), (5, 1050)]);
    for (range, expected) in [
        ("1:5:2", vec![(1, 850), (3, 950)]),
        ("-2:", vec![(4, 1000), (5, 1050)]),
        ("-1", vec![(5, 1050)]),
        ("2", vec![(2, 900)]),
        ("7:", vec![]),
        ("3:2", vec![]),
    ] {
        let (_folder, series) = small_series(&all, range);
        assert_eq!(steps(series.collect::<Result<Vec<_>, _>>().unwrap()), expected, "{range}");
    }
}

#[test]
fn the_background_gives_the_same_frames_and_errors_in_the_same_order() {
    // The contacts of step 950 are missing.
    let some = [800, 850, 900, 1000, 1050];
    let (_folder, series) = small_series(&some, ":");
    let foreground: Vec<Result<SeriesFrame, IoError>> = series.collect();
    for ahead in [0, 1, 2, 9] {
        let (_folder, series) = small_series(&some, ":");
        let background: Vec<Result<SeriesFrame, IoError>> = series.in_background(ahead).unwrap().collect();
        assert_eq!(background.len(), 4);
        for (a, b) in foreground.iter().zip(&background) {
            match (a, b) {
                (Ok(a), Ok(b)) => {
                    assert_eq!((a.index, &a.particles, &a.contacts), (b.index, &b.particles, &b.contacts))
                }
                (Err(a), Err(b)) => {
                    for error in [a.to_string(), b.to_string()] {
                        let expected = "the next contacts are of step 1000: there are none for frame 3";
                        assert!(error.contains(expected) && error.contains("(step 950)"), "{error}");
                    }
                }
                other => panic!("{other:?}"),
            }
        }
    }
}

#[test]
fn contacts_that_end_early_are_an_error_of_the_first_frame_without() {
    let (_folder, series) = small_series(&[800, 850], ":");
    let frames: Vec<_> = series.collect();
    assert_eq!(frames.len(), 3);
    let error = frames[2].as_ref().unwrap_err().to_string();
    assert!(error.contains("there are no more contacts for frame 2") && error.contains("(step 900)"), "{error}");
}

#[test]
fn a_dropped_background_series_ends_its_thread() {
    let (_folder, series) = small_series(&[800, 850, 900, 950, 1000, 1050], ":");
    let mut background = series.in_background(1).unwrap();
    assert_eq!(background.next().unwrap().unwrap().index, 0);
    // Would wait for ever if the thread did not notice.
    drop(background);
}

#[test]
fn tables_are_matched_by_order_and_several_sources_joined() {
    let folder = tempfile::tempdir().unwrap();
    for k in [1, 2, 10] {
        let name = |kind: &str| folder.path().join(format!("{kind}{k}.csv"));
        std::fs::write(name("p"), "id,x,y,z,r\n1,0,0,0,0.5\n2,1,0,0,0.5\n").unwrap();
        std::fs::write(name("c"), format!("id1,id2,fx,fy,fz\n1,2,{k},0,0\n")).unwrap();
        std::fs::write(name("w"), format!("id1,fx,fy,fz,cx,cy,cz\n2,0,0,{k},1,0,-0.5\n")).unwrap();
    }
    let files = |kind: &str| find_files(&folder.path().join(format!("{kind}*.csv")).to_string_lossy()).unwrap();
    let contacts = |kind: &str| ContactFiles { files: files(kind), options: ContactOptions::default() };
    let series = Series::new(files("p"), ParticleOptions::default()).with_contacts(contacts("c"));
    let series = series.with_contacts(contacts("w")).with_range("::2".parse().unwrap());
    let found: Vec<(usize, f64, f64)> = series
        .map(|frame| frame.unwrap())
        .map(|frame| (frame.index, frame.contacts.unwrap()))
        .map(|(index, contacts)| (index, contacts.get(0).force[0], contacts.get(1).force[2]))
        .collect();
    assert_eq!(found, [(0, 1.0, 1.0), (2, 10.0, 10.0)]);
}

#[test]
fn a_pattern_that_no_file_fits_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let error = find_files(&folder.path().join("part_*.vtk").to_string_lossy()).unwrap_err().to_string();
    assert!(error.contains("no file fits"), "{error}");
}

#[test]
fn frames_of_the_mercury_box_are_matched_by_time_from_any_start() {
    let (Some(data), Some(fstat)) = (extended("mercury-box/box1000.data.gz"), extended("mercury-box/box1000.fstat.gz"))
    else {
        return;
    };
    let contacts = ContactFiles { files: vec![fstat], options: ContactOptions::default() };
    let series = Series::new(vec![data], ParticleOptions::default()).with_contacts(contacts);
    let mut background = series.with_range("1::3".parse().unwrap()).in_background(2).unwrap();
    let counts: Vec<_> = background
        .by_ref()
        .map(|f| f.unwrap())
        .map(|f| (f.particles.time().unwrap(), f.contacts.unwrap().len()))
        .collect();
    assert_eq!(counts, [(2.5, 983), (10.0, 2290)]);
    assert_eq!(background.warnings(), ["pairs are listed twice, once from either side: each is taken once"]);
}

#[test]
fn frames_of_the_lammps_pack_take_their_walls_from_the_particle_files() {
    let files = |kind: &str| -> Option<Vec<PathBuf>> {
        let one = extended(&format!("lammps-pack/{kind}.4000.dump.gz"))?;
        Some(find_files(&one.with_file_name(format!("{kind}.{{}}.dump.gz")).to_string_lossy()).unwrap())
    };
    let (Some(particles), Some(pairs)) = (files("part"), files("pair")) else { return };
    let preset = |preset| ContactOptions { preset: Some(preset), columns: None };
    let walls = ContactFiles { files: particles.clone(), options: preset(ContactPreset::LammpsWall) };
    let pairs = ContactFiles { files: pairs, options: preset(ContactPreset::LammpsPair) };
    let series = Series::new(particles, ParticleOptions::default()).with_contacts(pairs).with_contacts(walls);
    let counts: Vec<_> =
        series.map(|f| f.unwrap()).map(|f| (f.particles.step().unwrap(), f.contacts.unwrap().len())).collect();
    assert_eq!(counts, [(4000, 358), (4500, 394)]);
}
