//! Contact readers against small files: excerpts of what programs wrote, tables written by hand, and damaged ones.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use fieldstone_io::{ContactOptions, ContactPreset, IoError, ParticleOptions, open_contacts, read_frame, read_restart};
use fieldstone_particles::{Contact, Contacts, Domain, Particles, Partner};
use fieldstone_testing::{Random, extended, read_text};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/contacts").join(name)
}

fn particles(name: &str) -> Particles {
    read_frame(&fixture(name), &ParticleOptions::default(), 0).unwrap()
}

fn preset(preset: ContactPreset) -> ContactOptions {
    ContactOptions { preset: Some(preset), columns: None }
}

fn try_read(path: &Path, options: &ContactOptions, particles: &Particles) -> Result<(Contacts, Vec<String>), IoError> {
    let mut reader = open_contacts(path, options)?;
    let contacts = reader.next_frame(particles)?.expect("a frame");
    Ok((contacts, reader.warnings().to_vec()))
}

fn read(path: &Path, options: &ContactOptions, particles: &Particles) -> Contacts {
    let (contacts, warnings) = try_read(path, options, particles).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    contacts
}

/// The result for a file of this content.
fn read_content(
    name: &str,
    content: &str,
    options: &ContactOptions,
    particles: &Particles,
) -> Result<(Contacts, Vec<String>), IoError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    try_read(&path, options, particles)
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Two unit spheres that touch at the origin, ids 7 and 9, and one beyond the periodic boundary of a box of length 10.
fn three() -> Particles {
    let positions = vec![[-0.95, 0.0, 0.0], [0.95, 0.0, 0.0], [7.2, 0.0, 0.0]];
    let domain = Domain::new([-1.0, -5.0, -5.0], [9.0, 5.0, 5.0], [true, false, false]).unwrap();
    let particles = Particles::new(positions).unwrap().with_uniform_radius(1.0).unwrap();
    particles.with_ids(vec![7, 9, 4]).unwrap().with_domain(domain)
}

#[test]
fn pairs_of_liggghts_reach_through_the_periodic_boundary() {
    let particles = particles("liggghts_part.dump");
    let contacts = read(&fixture("liggghts_pair.dump"), &preset(ContactPreset::LiggghtsPair), &particles);
    assert_eq!(contacts.len(), 4);
    let radii = particles.radii().unwrap();
    let overlaps = [8.928_797_920_55e-6, 1.584_435_476_14e-5, 1.524_269_777_54e-5, 1.103_636_752_44e-5];
    for (contact, overlap) in contacts.iter().zip(overlaps) {
        let Partner::Particle(other) = contact.partner else { panic!("{contact:?}") };
        let reach = radii[contact.particle as usize] + radii[other as usize] - overlap;
        assert!((length(contact.branch) - reach).abs() < 1e-15, "{contact:?}");
    }
    // Particle 8865 is at y = 0.00044, its partner 8270 at 0.0391 in a box of 0.04.
    let second = contacts.get(1);
    assert_eq!(second.force, [-0.003_279_864_379_02, 0.003_375_868_417_86, -0.001_073_687_088_81]);
    assert!((second.branch[1] - (0.039_131_024_701_600_4 - 0.04 - 0.000_441_990_180_887_288)).abs() < 1e-16);
}

#[test]
fn of_the_walls_of_liggghts_those_without_force_are_left_out() {
    let particles = particles("liggghts_part.dump");
    let walls = read(&fixture("liggghts_wall.dump"), &preset(ContactPreset::LiggghtsWall), &particles);
    let arm = [walls.get(0).arm[0], walls.get(0).arm[1], -0.000_787_020_860_351_673];
    let force = [-0.008_725_119_103_31, -0.003_079_525_817_77, 0.004_822_253_982_63];
    assert_eq!(walls.len(), 1);
    assert_eq!(walls.get(0), Contact { particle: 3, partner: Partner::Wall(0), force, arm, branch: arm });
    assert!(arm[0].abs() < 1e-13 && arm[1].abs() < 1e-13);
    // Garbage in the columns that nobody needs is not looked at.
    let garbage = std::fs::read_to_string(fixture("liggghts_wall.dump")).unwrap();
    let garbage: Vec<String> = garbage
        .lines()
        .enumerate()
        .map(
            |(k, line)| {
                if k < 9 { line.into() } else { format!("{} 1e-4x40 nan", line.rsplitn(3, ' ').last().unwrap()) }
            },
        )
        .collect();
    let read = read_content("wall.dump", &garbage.join("\n"), &preset(ContactPreset::LiggghtsWall), &particles);
    assert_eq!(read.unwrap().0, walls);
}

#[test]
fn contacts_and_weight_give_the_force_on_a_grain_of_lammps() {
    let particles = particles("lammps_part.dump");
    let mut contacts = read(&fixture("lammps_pair.dump"), &preset(ContactPreset::LammpsPair), &particles);
    contacts.extend(&read(&fixture("lammps_part.dump"), &preset(ContactPreset::LammpsWall), &particles));
    // Grain 80, with everything that touches it.
    let index = 2;
    let sum = contacts.force_sums(particles.len())[index];
    let mass = particles.quantity("mass").unwrap().data[index];
    let scale = 1.0 / 1.04f64.sqrt();
    let stated = &particles.quantity("force").unwrap().data[3 * index..3 * index + 3];
    for (k, gravity) in [0.2 * scale, 0.0, -scale].into_iter().enumerate() {
        assert!((sum[k] + mass * gravity - stated[k]).abs() < 1e-12, "{sum:?} {stated:?}");
    }
}

#[test]
fn tables_name_particles_by_id_or_by_position() {
    let by_id = "id1,id2,fx,fy,fz,cx,cy,cz\n7,9,-3,1,0,0,0,0\n9,,0,0,2,0.95,0,-1\n9,-5,0,0,2,0.95,0,-1\n";
    let (contacts, warnings) = read_content("a.csv", by_id, &ContactOptions::default(), &three()).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    let first = contacts.get(0);
    assert_eq!((first.particle, first.partner), (0, Partner::Particle(1)));
    assert_eq!((first.arm, first.branch), ([0.95, 0.0, 0.0], [1.9, 0.0, 0.0]));
    assert_eq!([contacts.get(1).partner, contacts.get(2).partner], [Partner::Wall(-1), Partner::Wall(-5)]);
    assert_eq!(contacts.get(2).arm, [0.0, 0.0, -1.0]);
    // The first position is that of an image one box length to the right.
    let by_position = "x1;y1;z1;x2;y2;z2;fx;fy;fz\n9.05;0;0;0.95;0;0;-3;1;0\n";
    let (contacts, _) = read_content("a.csv", by_position, &ContactOptions::default(), &three()).unwrap();
    assert_eq!((contacts.get(0).particle, contacts.get(0).partner), (0, Partner::Particle(1)));
    assert!((contacts.get(0).arm[0] - 0.95).abs() < 1e-15);
    let off = by_position.replace("9.05", "9.15");
    let error = read_content("a.csv", &off, &ContactOptions::default(), &three()).unwrap_err().to_string();
    assert!(error.contains("a.csv:2: no particle has its centre at (9.15, 0, 0)"), "{error}");
}

#[test]
fn pairs_listed_twice_are_taken_once_and_real_second_contacts_stay() {
    let twice = "i,j,fx,fy,fz\n7,9,-3,1,0\n9,7,3,-1,0\n7,4,1,0,0\n4,7,-1,0,0\n";
    let (contacts, warnings) = read_content("a.csv", twice, &ContactOptions::default(), &three()).unwrap();
    assert_eq!(contacts.len(), 2);
    assert!(warnings[0].contains("listed twice"), "{warnings:?}");
    // Beyond the boundary at −1: 10 to the left of 7.2.
    assert!((contacts.get(1).branch[0] + 1.85).abs() < 1e-14);
    // Mirrored lines that do not agree.
    let unequal = twice.replace("4,7,-1,", "4,7,-1.5,");
    let (contacts, warnings) = read_content("a.csv", &unequal, &ContactOptions::default(), &three()).unwrap();
    assert_eq!(contacts.len(), 2);
    assert!(warnings[1].contains("two lines of 1 pairs do not mirror each other, by up to 3.3e-1"), "{warnings:?}");
    // Not all pairs have both lines, so two lines with other forces are two contacts.
    let mixed = "i,j,fx,fy,fz\n7,9,-3,1,0\n7,4,1,0,0\n4,7,-1.5,0,0\n";
    let (contacts, warnings) = read_content("a.csv", mixed, &ContactOptions::default(), &three()).unwrap();
    assert_eq!((contacts.len(), warnings.len()), (3, 0));
}

#[test]
fn a_particle_may_touch_its_own_image_and_both_images_of_a_neighbour() {
    // A box of two diameters: the neighbour is touched on either side.
    let domain = Domain::new([0.0; 3], [3.9, 9.0, 9.0], [true, false, false]).unwrap();
    let two = Particles::new(vec![[1.0, 4.0, 4.0], [2.95, 4.0, 4.0]]).unwrap().with_uniform_radius(1.0).unwrap();
    let two = two.with_ids(vec![1, 2]).unwrap().with_domain(domain);
    let rows = "id1,id2,fx,fy,fz,cx,cy,cz\n1,2,-3,0,0,1.975,4,4\n1,2,5,0,0,0.025,4,4\n";
    let (contacts, warnings) = read_content("a.csv", rows, &ContactOptions::default(), &two).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert!((contacts.get(0).branch[0] - 1.95).abs() < 1e-14 && (contacts.get(1).branch[0] + 1.95).abs() < 1e-14);
    let domain = Domain::new([0.0; 3], [1.9, 9.0, 9.0], [true, false, false]).unwrap();
    let one = Particles::new(vec![[1.0, 4.0, 4.0]]).unwrap().with_uniform_radius(1.0).unwrap();
    let one = one.with_ids(vec![1]).unwrap().with_domain(domain);
    let rows = "id1,id2,fx,fy,fz,cx,cy,cz\n1,1,-3,0,0,1.95,4,4\n1,1,3,0,0,0.05,4,4\n";
    let (contacts, _) = read_content("a.csv", rows, &ContactOptions::default(), &one).unwrap();
    assert_eq!(contacts.len(), 1);
    assert!((contacts.get(0).branch[0] - 1.9).abs() < 1e-14, "{:?}", contacts.get(0));
}

/// Three spheres of a Mercury run: 0 and 1 touch, 0 and 2 through the boundary, 1 stands on wall 0.
fn fstat() -> String {
    let header = "# 0.5 1\n# 0 0 0 10 10 10\n# 1 1 0 0 0 0\n";
    let mut rows = String::from("0.5 1 -1 3 4 -0.005 0.01 0 50 2 0 0 -1 1 0 0\n");
    for (i, j, sign) in [(0, 1, -1), (1, 0, 1)] {
        rows += &format!("0.5 {i} {j} 2 4 1 0.1 0 20 3 {sign} 0 0 0 {} 0\n", -sign);
    }
    for (i, j, sign) in [(0, 2, 1), (2, 0, -1)] {
        rows += &format!("0.5 {i} {j} 0.05 4 1 0.1 0 7 0 {sign} 0 0 0 1 0\n");
    }
    format!("{header}{rows}{}", header.replace("# 0.5", "# 1"))
}

fn mercury_particles() -> Particles {
    let positions = vec![[1.05, 4.0, 0.99], [2.95, 4.0, 0.99], [9.15, 4.0, 0.99]];
    let domain = Domain::new([0.0; 3], [10.0; 3], [false; 3]).unwrap();
    let particles = Particles::new(positions).unwrap().with_uniform_radius(1.0).unwrap();
    particles.with_domain(domain).at(None, Some(0.5))
}

#[test]
fn the_fstat_file_gives_forces_by_its_signs_and_arms_without_knowing_the_boundaries() {
    let (contacts, warnings) =
        read_content("a.fstat", &fstat(), &ContactOptions::default(), &mercury_particles()).unwrap();
    assert_eq!(warnings, ["pairs are listed twice, once from either side: each is taken once"]);
    let wall = contacts.get(0);
    assert_eq!((wall.particle, wall.partner), (1, Partner::Wall(0)));
    assert_eq!(wall.force, [-2.0, 0.0, 50.0]);
    assert!(length([wall.arm[0] - 0.05, wall.arm[1], wall.arm[2] + 0.995]) < 1e-12, "{wall:?}");
    // n points from the partner to the particle, which is pushed along it.
    let pair = contacts.get(1);
    assert_eq!((pair.particle, pair.partner, pair.force), (0, Partner::Particle(1), [-20.0, 3.0, 0.0]));
    assert!((pair.arm[0] - 0.95).abs() < 1e-15 && (pair.branch[0] - 1.9).abs() < 1e-14, "{pair:?}");
    let through = contacts.get(2);
    assert_eq!((through.particle, through.partner, through.force), (0, Partner::Particle(2), [7.0, 0.0, 0.0]));
    assert_eq!((through.arm, through.branch), ([-0.95, 0.0, 0.0], [-1.9, 0.0, 0.0]));
}

#[test]
fn frames_of_another_time_or_step_are_refused() {
    let later = mercury_particles().at(None, Some(0.75));
    let error = read_content("a.fstat", &fstat(), &ContactOptions::default(), &later).unwrap_err().to_string();
    assert!(error.contains("a.fstat:3: the contacts are of time 0.5, the particles of time 0.75"), "{error}");
    let other = particles("liggghts_part.dump").at(Some(26_000), None);
    let error = try_read(&fixture("liggghts_pair.dump"), &preset(ContactPreset::LiggghtsPair), &other).unwrap_err();
    assert!(error.to_string().contains("of step 26001, the particles of step 26000"), "{error}");
}

#[test]
fn damaged_rows_are_named_with_their_line() {
    let content = std::fs::read_to_string(fixture("liggghts_pair.dump")).unwrap();
    let particles = particles("liggghts_part.dump");
    let options = preset(ContactPreset::LiggghtsPair);
    let changed = |from: &str, to: &str| {
        assert!(content.contains(from), "{from}");
        let error = read_content("p.dump", &content.replacen(from, to, 1), &options, &particles).unwrap_err();
        error.to_string()
    };
    for (from, to, expected) in [
        (" 9922 8865 ", " 9923 8865 ", ":10: the contact names particle 9923, which is not among the 5"),
        (" 9922 8865 ", " 8865 8865 ", ":10: the contact is of particle 8865 with itself"),
        (" 9922 8865 ", " 9922.5 8865 ", ":10: column 13 'c_pp[13]' holds '9922.5', which is no integer"),
        (" 0.0032073678012 ", " nan ", ":10: column 16 'c_pp[16]' is NaN"),
        (" 0.0032073678012 ", " 0.003x ", ":10: column 16 'c_pp[16]' holds '0.003x'"),
        ("\n4\n", "\n5\n", ":13: the file ends after 4 of the 5 entries of frame 0"),
        ("c_pp[17]", "c_qq[17]", "one array with columns name[1] to name[18] is expected, 0 are there"),
        ("NUMBER OF ENTRIES", "NUMBER OF ATOMS", "this is a dump of particles, not of contacts"),
    ] {
        let error = changed(from, to);
        assert!(error.contains(expected), "{to}: {error}");
    }
    // Cut within the last row, before the last column needed.
    let cut = &content[..content.trim_end().rfind(' ').unwrap() - 40];
    let error = read_content("p.dump", cut, &options, &particles).unwrap_err().to_string();
    assert!(error.contains("the file ends after 3 of the 4 entries"), "{error}");
}

#[test]
fn a_mapping_that_names_missing_columns_lists_those_present() {
    let particles = particles("lammps_part.dump");
    let columns = "id1=c_pl[1],id2=c_pl[3],force=c_fl[12..14]".parse().unwrap();
    let options = ContactOptions { preset: None, columns: Some(columns) };
    let error = try_read(&fixture("lammps_pair.dump"), &options, &particles).unwrap_err().to_string();
    assert!(
        error.contains("no column c_pl[3], c_fl[12], c_fl[13], c_fl[14]; the columns are index c_pl[1]"),
        "{error}"
    );
    let error = try_read(&fixture("lammps_pair.dump"), &ContactOptions::default(), &particles).unwrap_err().to_string();
    assert!(error.contains("give the preset liggghts-pair, liggghts-wall or lammps-pair"), "{error}");
    let error = read_content("a.csv", "a,b\n1,2\n", &ContactOptions::default(), &particles).unwrap_err().to_string();
    assert!(error.contains("the particle is missing") && error.contains("among a b"), "{error}");
}

#[test]
fn damaged_fstat_files_are_refused_and_cut_ones_keep_their_earlier_frames() {
    let particles = mercury_particles();
    for (from, to, expected) in [
        ("0.5 0 2 ", "0.5 0 3 ", ":7: the contact names particle 3, but there are 3 from 0 on"),
        (" 20 3 ", " inf 3 ", ":5: column 9 'fn' holds 'inf', which is no finite number"),
        ("0.5 0 1 2 4 1 ", "0.5 0 1 2 4 ", ":5: the row has 15 columns; 16 are expected"),
    ] {
        let damaged = fstat().replacen(from, to, 1);
        let error = read_content("a.fstat", &damaged, &ContactOptions::default(), &particles).unwrap_err().to_string();
        assert!(error.contains(expected), "{to}: {error}");
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.fstat");
    std::fs::write(&path, fstat() + "1 0 1 2 4 1 0.1 0 20 3 -1").unwrap();
    let mut reader = open_contacts(&path, &ContactOptions::default()).unwrap();
    assert!(reader.next_frame(&particles).unwrap().is_some());
    let later = particles.at(None, Some(1.0));
    let error = reader.next_frame(&later).unwrap_err().to_string();
    assert!(error.contains("the file is cut"), "{error}");
    assert!(reader.next_frame(&later).unwrap().is_none() && !reader.skip_frame().unwrap());
}

#[test]
fn every_cut_of_a_file_ends_in_contacts_or_an_error() {
    let particles = particles("liggghts_part.dump");
    let content = std::fs::read_to_string(fixture("liggghts_pair.dump")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut");
    for length in (0..content.len()).step_by(7) {
        std::fs::write(&path, &content[..length]).unwrap();
        let Ok(mut reader) = open_contacts(&path, &preset(ContactPreset::LiggghtsPair)) else { continue };
        if let Ok(Some(contacts)) = reader.next_frame(&particles) {
            assert_eq!(contacts.len(), 4, "cut after {length}");
        }
    }
}

const RESTART: &str = "MercuryDPM 1.0 name small\n\
    xMin 0 xMax 10 yMin 0 yMax 10 zMin 0 zMax 12\n\
    timeStep 0.5 time 2.5 ntimeSteps 5 timeMax 10\n\
    systemDimensions 3 particleDimensions 3 gravity 0 0 -9.8 writeVTK 0\n\
    Species 2\n\
    LinearViscoelasticSpecies id 0 density 2 stiffness 1\n\
    LinearViscoelasticSpecies id 1 density 5 stiffness 1\n\
    LinearViscoelasticMixedSpecies idMixed 0 stiffness 1\n\
    Walls 1\n\
    InfiniteWall id 0 indSpecies 1 position 0 0 1 orientation 1 0 0 0\n\
    Boundaries 2\n\
    PeriodicBoundary id 0 normal -1 0 0 scaleFactor 1 distanceLeft -9 distanceRight -1 shift -8 0 0\n\
    DeletionBoundary id 1 normal 0 0 1 distance 3\n\
    Particles 2\n\
    BaseParticle id 4 indSpecies 0 position 1 2 3 orientation 1 0 0 0 velocity 0 0 -1 angularVelocity 0 0 0 force 0 0 1 torque 0 0 0 radius 0.5 invMass 0.25 timeStamp 0\n\
    SphericalParticle id 7 indSpecies 1 position 4 5 6 orientation 1 0 0 0 velocity 0 0 2 angularVelocity 0 0 0 force 0 0 1 torque 0 0 0 radius 1 invMass 0 timeStamp 0\n\
    Interactions 0\n";

#[test]
fn the_restart_file_gives_densities_masses_walls_and_periodic_directions() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.restart");
    std::fs::write(&path, RESTART).unwrap();
    let restart = read_restart(&path).unwrap();
    assert_eq!((restart.time, restart.gravity), (Some(2.5), Some([0.0, 0.0, -9.8])));
    assert_eq!(restart.species.iter().map(|s| s.density).collect::<Vec<_>>(), [2.0, 5.0]);
    assert_eq!((restart.walls.len(), restart.walls[0].species), (1, 1));
    let domain = Domain::new([1.0, 0.0, 0.0], [9.0, 10.0, 12.0], [true, false, false]).unwrap();
    assert_eq!(restart.domain, Some(domain));
    assert_eq!(restart.warnings, ["boundary DeletionBoundary is passed over"]);
    assert_eq!(restart.particles.ids().unwrap(), [4, 7]);
    let mass = &restart.particles.quantity("mass").unwrap().data;
    // The first by its inverse mass; the second is fixed and has none.
    let sphere = 4.0 / 3.0 * std::f64::consts::PI;
    assert!((mass[0] - 4.0).abs() < 1e-15 && (mass[1] - 5.0 * sphere).abs() < 1e-14, "{mass:?}");
    assert_eq!(restart.particles.quantity("velocity").unwrap().data[3..], [0.0, 0.0, 2.0]);

    let of_data = Particles::new(vec![[0.0; 3]; 2]).unwrap().with_radii(vec![1.0, 2.0]).unwrap();
    let of_data = restart.complete(of_data.with_types(vec![1, 0]).unwrap()).unwrap();
    let mass = &of_data.quantity("mass").unwrap().data;
    assert!((mass[0] - 5.0 * sphere).abs() < 1e-14 && (mass[1] - 16.0 * sphere).abs() < 1e-13);
    assert_eq!(of_data.domain(), Some(&domain));
    let error = restart.complete(of_data.clone().with_types(vec![1, 3]).unwrap()).unwrap_err().to_string();
    assert!(
        error.contains("a.restart: particle 1 is of species 3, which the file does not have; it has 0, 1"),
        "{error}"
    );
    let none = RESTART.replace("density 5", "density -1");
    std::fs::write(&path, &none).unwrap();
    let line = 1 + none.lines().position(|line| line.contains("density -1")).unwrap();
    let error = read_restart(&path).unwrap_err().to_string();
    let found =
        format!("a.restart:{line}: species 1, of which particle 1 is, has density -1; densities must be above 0");
    assert!(error.contains(&found), "{error}");
}

#[test]
fn cut_and_foreign_restart_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.restart");
    for (content, expected) in [
        (RESTART.split("Particles 2").next().unwrap().to_string(), "the file ends before its particles"),
        (RESTART.split("Spherical").next().unwrap().to_string(), "the file ends after 1 of 2 entries"),
        (RESTART.replace("radius 1 ", "radius one "), "a.restart:16: the entry has no valid 'radius'"),
        (RESTART.replace("Spherical", "SuperQuadric"), "not a sphere"),
        ("ITEM: TIMESTEP\n".into(), "no MercuryDPM .restart file"),
    ] {
        std::fs::write(&path, content).unwrap();
        let error = read_restart(&path).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}

#[test]
fn data_and_restart_of_the_mercury_box_give_its_mass() {
    let (Some(data), Some(restart)) =
        (extended("mercury-box/box1000.data.gz"), extended("mercury-box/box1000.restart.gz"))
    else {
        return;
    };
    let last = read_frame(&data, &ParticleOptions::default(), -1).unwrap();
    let restart = read_restart(&restart).unwrap();
    assert_eq!((restart.walls.len(), restart.particles.len()), (5, 1000));
    assert!((restart.time.unwrap() - 10.0).abs() < 1e-9);
    let last = restart.complete(last).unwrap();
    let total = |particles: &Particles| particles.quantity("mass").unwrap().data.iter().sum::<f64>();
    println!("mass {} from .data and density, {} from .restart", total(&last), total(&restart.particles));
    assert!((total(&last) - 1001.9).abs() < 0.05);
    assert!((total(&last) / total(&restart.particles) - 1.0).abs() < 1e-9);
    for (a, b) in last.positions().iter().zip(restart.particles.positions()) {
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-13), "{a:?} {b:?}");
    }
}

#[test]
fn the_vtk_file_of_the_chute_has_radii_masses_and_types() {
    let Some(path) = extended("liggghts-chute/part_26000.vtk.gz") else { return };
    let particles = read_frame(&path, &ParticleOptions::default(), 0).unwrap();
    let masses = &particles.quantity("mass").unwrap().data;
    for (radius, mass) in particles.radii().unwrap().iter().zip(masses) {
        let expected = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        assert!((mass / expected - 1.0).abs() < 1e-5, "{radius} {mass}");
    }
    assert!(particles.types().unwrap().iter().all(|&kind| kind == 1));
    assert_eq!(particles.ids().unwrap().len(), 12_092);
    assert!(read_text(&path).contains("FIELD FieldData 7"));
}

#[test]
fn a_preset_or_mapping_for_another_kind_of_file_is_refused() {
    let particles = mercury_particles();
    let error = read_content("a.fstat", &fstat(), &preset(ContactPreset::LiggghtsPair), &particles).unwrap_err();
    assert!(error.to_string().contains("not what the preset liggghts-pair is for"), "{error}");
    let columns = Some("id1=i,id2=j,force=fx/fy/fz".parse().unwrap());
    let options = ContactOptions { preset: None, columns };
    let error = read_content("a.fstat", &fstat(), &options, &particles).unwrap_err();
    assert!(error.to_string().contains("no names for its columns"), "{error}");
    assert!(read_content("a.fstat", &fstat(), &preset(ContactPreset::Mercury), &particles).is_ok());
    let error = read_content("a.csv", "id1,id2,fx,fy,fz\n", &preset(ContactPreset::Mercury), &particles).unwrap_err();
    assert!(error.to_string().contains("not what the preset mercury is for"), "{error}");
}

#[test]
fn options_survive_a_configuration_file() {
    let text = r#"{"preset":"liggghts-wall","columns":{"id1":"c_w[15]","force":["c_w[16]","c_w[17]","c_w[18]"]}}"#;
    let options: ContactOptions = serde_json::from_str(text).unwrap();
    assert_eq!(options.preset, Some("liggghts-wall".parse().unwrap()));
    assert_eq!(options.columns, Some("id1=c_w[15],force=c_w[16..18]".parse().unwrap()));
    assert_eq!(serde_json::from_str::<ContactOptions>(&serde_json::to_string(&options).unwrap()).unwrap(), options);
    assert!(serde_json::from_str::<ContactOptions>(r#"{"presets":"mercury"}"#).is_err());
}

#[test]
fn files_damaged_at_random_end_in_contacts_or_an_error() {
    const PIECES: [&str; 12] =
        ["\n", " ", "nan", "-", "1e999", "ITEM:", "# ", "4000000000000000000", ",", "9", "..", "\0"];
    let (liggghts, lammps) = (particles("liggghts_part.dump"), particles("lammps_part.dump"));
    let table = "id1,id2,fx,fy,fz,cx,cy,cz\n7,9,-3,1,0,0,0,0\n9,7,3,-1,0,0,0,0\n9,,0,0,2,0.95,0,-1\n".to_string();
    let text = |name: &str| std::fs::read_to_string(fixture(name)).unwrap();
    let cases = [
        (text("liggghts_pair.dump"), preset(ContactPreset::LiggghtsPair), &liggghts),
        (text("liggghts_wall.dump"), preset(ContactPreset::LiggghtsWall), &liggghts),
        (text("lammps_pair.dump"), preset(ContactPreset::LammpsPair), &lammps),
        (fstat(), ContactOptions::default(), &mercury_particles()),
        (table, ContactOptions::default(), &three()),
    ];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged");
    let mut random = Random(7);
    let (mut read, mut refused) = (0, 0);
    for round in 0..600 {
        let (content, options, particles) = &cases[round % cases.len()];
        let mut damaged = content.clone();
        for _ in 0..=random.below(3) {
            let at = random.below(damaged.len());
            let end = (at + random.below(6)).min(damaged.len());
            damaged.replace_range(at..end, PIECES[random.below(PIECES.len())]);
        }
        std::fs::write(&path, &damaged).unwrap();
        let result = open_contacts(&path, options).and_then(|mut reader| {
            let first = reader.next_frame(particles)?;
            while reader.skip_frame()? {}
            Ok(first)
        });
        match result {
            Ok(Some(contacts)) => {
                read += 1;
                assert!(contacts.iter().all(|c| (c.particle as usize) < particles.len()));
            }
            Ok(None) => {}
            Err(error) => {
                refused += 1;
                assert!(error.to_string().contains("damaged"), "{error}");
            }
        }
    }
    println!("{read} read, {refused} refused");
    assert!(read > 50 && refused > 200, "{read} {refused}");
}

#[test]
fn restart_files_damaged_at_random_end_in_a_result_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged");
    let mut random = Random(11);
    for _ in 0..300 {
        let mut damaged = RESTART.to_string();
        let at = random.below(damaged.len());
        let end = (at + random.below(20)).min(damaged.len());
        damaged.replace_range(at..end, ["", "9", " ", "\n", "nan", "Particles 4000000000000000000\n"][random.below(6)]);
        std::fs::write(&path, &damaged).unwrap();
        if let Ok(restart) = read_restart(&path) {
            assert!(restart.particles.len() <= 2);
        }
    }
}
