//! Files that LAMMPS, LIGGGHTS and MercuryDPM wrote.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::{Path, PathBuf};

use fieldstone_io::{DumpReader, FrameReader, IoError, MercuryReader, ParticleOptions, open_particles, read_frame};
use fieldstone_particles::Particles;
use fieldstone_testing::{data, extended, read_text};

/// In the repository, or in the extended sets.
fn packed_cylinder() -> Option<PathBuf> {
    let name = "packed-cylinder/packed.dump.gz";
    Some(data(name)).filter(|path| path.exists()).or_else(|| extended(name))
}

fn only_frame(path: &Path) -> Particles {
    let mut reader = open_particles(path, &ParticleOptions::default()).unwrap();
    let particles = reader.next_frame().unwrap().expect("a frame");
    assert!(reader.next_frame().unwrap().is_none());
    assert!(reader.warnings().is_empty(), "{:?}", reader.warnings());
    particles
}

/// Along periodic directions a particle may be a little outside: the programs wrap it only now and then.
fn assert_inside_the_box(particles: &Particles) {
    let domain = particles.domain().expect("a box");
    let slack = particles.radii().unwrap().iter().copied().fold(0.0, f64::max);
    for (i, p) in particles.positions().iter().enumerate() {
        for k in 0..3 {
            let slack = if domain.periodic()[k] { slack } else { 0.0 };
            let inside = domain.low()[k] - slack <= p[k] && p[k] <= domain.high()[k] + slack;
            assert!(inside, "particle {i} at {p:?} leaves {domain:?}");
        }
    }
}

/// Mass of all particles if each has the density.
fn mass_at(particles: &Particles, density: f64) -> f64 {
    let thirds = 4.0 / 3.0 * std::f64::consts::PI * density;
    particles.radii().unwrap().iter().map(|r| thirds * r.powi(3)).sum()
}

#[test]
fn the_packed_cylinder_has_2400_balls_whose_mass_is_their_volume_times_2500() {
    let Some(path) = packed_cylinder() else { return };
    let particles = only_frame(&path);
    assert_eq!(particles.len(), 2400);
    assert_eq!(particles.step(), Some(160_000));
    assert_eq!(particles.domain().unwrap().periodic(), [false; 3]);
    assert_inside_the_box(&particles);
    let mass: f64 = particles.quantity("mass").unwrap().data.iter().sum();
    let expected = mass_at(&particles, 2500.0);
    assert!((mass / expected - 1.0).abs() < 1e-12, "{mass} against {expected}");
    assert_eq!(particles.quantity("velocity").unwrap().components, 3);
    assert_eq!(particles.ids().unwrap()[..3], [1, 2, 3]);
    assert_eq!(particles.positions()[0], [-0.01697791852811618, -0.01577033326889132, 0.01520442567591003]);
}

#[test]
fn the_chute_has_12092_balls_in_a_box_periodic_along_x_and_y() {
    let Some(path) = extended("liggghts-chute/oracle_part.26001.dump.gz") else { return };
    let particles = only_frame(&path);
    assert_eq!(particles.len(), 12_092);
    assert_eq!(particles.domain().unwrap().periodic(), [true, true, false]);
    assert_inside_the_box(&particles);
    assert_eq!(particles.quantity("f_stressTensor_").unwrap().components, 9);
    assert_eq!(particles.quantity("image").unwrap().data[..3], [1.0, 0.0, 0.0]);
    let mass: f64 = particles.quantity("mass").unwrap().data.iter().sum();
    let expected = mass_at(&particles, 2500.0);
    assert!((mass / expected - 1.0).abs() < 1e-9, "{mass} against {expected}");
}

#[test]
fn the_lammps_pack_has_729_grains_with_a_stress_of_six_components() {
    for (step, name) in [(4000, "lammps-pack/part.4000.dump.gz"), (4500, "lammps-pack/part.4500.dump.gz")] {
        let Some(path) = extended(name) else { return };
        let particles = only_frame(&path);
        assert_eq!((particles.len(), particles.step()), (729, Some(step)));
        assert_inside_the_box(&particles);
        assert_eq!(particles.quantity("c_st").unwrap().components, 6);
        assert_eq!(particles.quantity("f_w").unwrap().components, 8);
        let mass: f64 = particles.quantity("mass").unwrap().data.iter().sum();
        assert!((mass / mass_at(&particles, 1.909_859_3) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn the_vtk_file_of_the_chute_holds_as_many_balls_as_the_dump_one_step_later() {
    let Some(path) = extended("liggghts-chute/part_26000.vtk.gz") else { return };
    let particles = only_frame(&path);
    assert_eq!(particles.len(), 12_092);
    let largest = particles.radii().unwrap().iter().copied().fold(0.0, f64::max);
    assert!((largest - 0.0012).abs() < 1e-9, "{largest}");
}

#[test]
fn dumps_of_contacts_given_as_particles_are_refused_by_name() {
    for name in ["packed-cylinder/contacts.dump.gz", "lammps-pack/pair.4000.dump.gz"] {
        let Some(path) = extended(name) else { return };
        let error = DumpReader::open(&path).unwrap().next_frame().unwrap_err();
        assert!(error.to_string().contains("dump local (contacts"), "{error}");
    }
}

#[test]
fn five_mercury_frames_are_read_with_their_times() {
    let Some(path) = extended("mercury-box/box1000.data.gz") else { return };
    let mut reader = open_particles(&path, &ParticleOptions::default()).unwrap();
    let mut times = Vec::new();
    let mut last = None;
    while let Some(particles) = reader.next_frame().unwrap() {
        assert_eq!(particles.len(), 1000);
        assert_eq!(particles.types().unwrap(), vec![0; 1000]);
        times.push(particles.time().unwrap());
        last = Some(particles);
    }
    assert_eq!(times, [0.0, 2.5, 5.0, 7.5, 10.0]);
    let last = last.unwrap();
    assert_eq!(last.domain().unwrap().high(), [11.2, 11.2, 13.2]);
    assert_inside_the_box(&last);
    assert_eq!(read_frame(&path, &ParticleOptions::default(), -1).unwrap(), last);
    assert_eq!(read_frame(&path, &ParticleOptions::default(), 4).unwrap(), last);
    for (wanted, available) in [(5, 5), (-6, 5), (i64::MAX, 5), (i64::MIN, 5)] {
        match read_frame(&path, &ParticleOptions::default(), wanted).unwrap_err() {
            IoError::NoSuchFrame { wanted: w, available: a, .. } => assert_eq!((w, a), (wanted, available)),
            other => panic!("{other}"),
        }
    }
    // The restart file of the same run is no substitute, and says where the particles are.
    let Some(restart) = extended("mercury-box/box1000.restart.gz") else { return };
    let error = open_particles(&restart, &ParticleOptions::default()).err().expect("refused").to_string();
    assert!(error.contains(".data file"), "{error}");
}

#[test]
fn a_compressed_file_and_its_plain_text_give_the_same_bits() {
    for path in [packed_cylinder(), extended("mercury-box/box1000.data.gz")].into_iter().flatten() {
        let folder = tempfile::tempdir().unwrap();
        let plain = folder.path().join("plain");
        std::fs::write(&plain, read_text(&path)).unwrap();
        let options = ParticleOptions::default();
        assert_eq!(read_frame(&plain, &options, 0).unwrap(), read_frame(&path, &options, 0).unwrap());
    }
}

#[test]
fn skipped_frames_leave_the_reader_where_read_ones_do() {
    let Some(path) = extended("mercury-box/box1000.data.gz") else { return };
    let mut read = MercuryReader::open(&path).unwrap();
    let mut skip = MercuryReader::open(&path).unwrap();
    for _ in 0..3 {
        assert!(read.next_frame().unwrap().is_some());
        assert!(skip.skip_frame().unwrap());
    }
    assert_eq!(read.next_frame().unwrap(), skip.next_frame().unwrap());

    let (Some(a), Some(b)) = (extended("lammps-pack/part.4000.dump.gz"), extended("lammps-pack/part.4500.dump.gz"))
    else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let both = folder.path().join("both.dump");
    std::fs::write(&both, read_text(&a) + &read_text(&b)).unwrap();
    let mut reader = DumpReader::open(&both).unwrap();
    assert!(reader.skip_frame().unwrap());
    assert_eq!(reader.next_frame().unwrap().unwrap(), only_frame(&b));
    assert!(!reader.skip_frame().unwrap());
}

#[test]
fn half_a_row_at_the_end_of_a_data_file_is_none_whether_its_frame_is_read_or_passed_over() {
    let row = "0 0 0 1 0 0 0.5 0 0 0 0 0 0 0\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.data");
    let whole = format!("3 0 0 0 0 2 1 1\n{}", row.repeat(3));
    for (cut, rows) in [(0, 3), (1, 3), (4, 2), (row.len() - 1, 2), (row.len(), 2), (row.len() + 9, 1)] {
        std::fs::write(&path, &whole[..whole.len() - cut]).unwrap();
        let read = MercuryReader::open(&path).unwrap().next_frame().map(|frame| frame.is_some());
        let skipped = MercuryReader::open(&path).unwrap().skip_frame();
        let text = |result: Result<bool, IoError>| result.map_err(|e| e.to_string());
        let (read, skipped) = (text(read), text(skipped));
        assert_eq!(read, skipped, "without the last {cut} bytes");
        match rows {
            3 => assert_eq!(read, Ok(true)),
            _ => {
                let message = read.unwrap_err();
                assert!(message.contains(&format!("ends after {rows} of the 3 particles")), "{message}");
            }
        }
    }
}
