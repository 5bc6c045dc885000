//! Contacts that LIGGGHTS, LAMMPS and MercuryDPM wrote, held against the forces that act on the particles.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::path::Path;

use fieldstone_io::{ContactOptions, ContactPreset, ParticleOptions, open_contacts, open_particles, read_frame};
use fieldstone_particles::{Contacts, Particles, Partner};
use fieldstone_testing::extended;

fn preset(preset: ContactPreset) -> ContactOptions {
    ContactOptions { preset: Some(preset), columns: None }
}

/// The only frame of contacts, and the warnings.
fn contacts(path: &Path, options: &ContactOptions, particles: &Particles) -> (Contacts, Vec<String>) {
    let mut reader = open_contacts(path, options).unwrap();
    let contacts = reader.next_frame(particles).unwrap().expect("a frame");
    (contacts, reader.warnings().to_vec())
}

fn first_frame(path: &Path) -> Particles {
    read_frame(path, &ParticleOptions::default(), 0).unwrap()
}

/// Largest and root-mean-square difference of contact forces plus weight from the forces that the file states.
fn imbalance(particles: &Particles, contacts: &Contacts, gravity: [f64; 3]) -> (f64, f64) {
    let stated = &particles.quantity("force").unwrap().data;
    let mass = &particles.quantity("mass").unwrap().data;
    let sums = contacts.force_sums(particles.len());
    let (mut largest, mut squares) = (0.0f64, 0.0);
    for (i, sum) in sums.iter().enumerate() {
        for k in 0..3 {
            let difference = sum[k] + mass[i] * gravity[k] - stated[3 * i + k];
            largest = largest.max(difference.abs());
            squares += difference * difference;
        }
    }
    (largest, (squares / stated.len() as f64).sqrt())
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Every pair of touching spheres: the branch is shorter than the radii's sum, and the arm ends between the centres.
fn assert_touching(particles: &Particles, contacts: &Contacts) {
    let radii = particles.radii().unwrap();
    for contact in contacts.iter() {
        let own = radii[contact.particle as usize];
        assert!(length(contact.arm) <= own * (1.0 + 1e-9), "{contact:?}");
        if let Partner::Particle(other) = contact.partner {
            let other = radii[other as usize];
            assert!(length(contact.branch) <= (own + other) * (1.0 + 1e-9), "{contact:?}");
            assert!(length(contact.partner_arm()) <= other * (1.0 + 1e-9), "{contact:?}");
        }
    }
}

#[test]
fn contacts_and_weight_give_the_forces_of_the_lammps_pack() {
    // At step 4000 the forces were computed from the very velocities that are dumped; at 4500 half a step lies between.
    for (step, expected) in [(4000, 1e-10), (4500, 0.8)] {
        let Some(path) = extended(&format!("lammps-pack/part.{step}.dump.gz")) else { return };
        let Some(pairs) = extended(&format!("lammps-pack/pair.{step}.dump.gz")) else { return };
        let particles = first_frame(&path);
        let (mut all, warnings) = contacts(&pairs, &preset(ContactPreset::LammpsPair), &particles);
        assert!(warnings.is_empty(), "{warnings:?}");
        let (walls, _) = contacts(&path, &preset(ContactPreset::LammpsWall), &particles);
        all.extend(&walls);
        assert_touching(&particles, &all);
        let scale = 1.0 / 1.04f64.sqrt();
        let (largest, rms) = imbalance(&particles, &all, [0.2 * scale, 0.0, -scale]);
        println!("step {step}: {} contacts, largest {largest:e}, rms {rms:e}", all.len());
        assert!(largest < expected, "step {step}: {largest:e}");
        // The same without the tangential forces is far off: their sign is checked, too.
        assert!(rms < 0.06, "{rms}");
    }
}

#[test]
fn contacts_of_the_packed_cylinder_are_read_by_preset_and_by_mapping_alike() {
    let (Some(path), Some(pairs)) =
        (extended("packed-cylinder/packed.dump.gz"), extended("packed-cylinder/contacts.dump.gz"))
    else {
        return;
    };
    let particles = first_frame(&path);
    let (by_preset, warnings) = contacts(&pairs, &preset(ContactPreset::LammpsPair), &particles);
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(by_preset.len(), 5715);
    assert_touching(&particles, &by_preset);
    let columns = "id1=c_id[1],id2=c_id[2],normal=c_c[2..4],tangential=c_c[5..7]".parse().unwrap();
    let options = ContactOptions { preset: None, columns: Some(columns) };
    assert_eq!(contacts(&pairs, &options, &particles).0, by_preset);
    // The tangential forces taken for normal ones are not along the lines of centres.
    let columns = "id1=c_id[1],id2=c_id[2],normal=c_c[5..7],tangential=c_c[2..4]".parse().unwrap();
    let (_, warnings) = contacts(&pairs, &ContactOptions { preset: None, columns: Some(columns) }, &particles);
    assert!(warnings[0].contains("not along the line of centres"), "{warnings:?}");
}

#[test]
fn the_chute_has_26580_pairs_and_344_wall_contacts_with_force() {
    let (Some(path), Some(pairs), Some(walls)) = (
        extended("liggghts-chute/oracle_part.26001.dump.gz"),
        extended("liggghts-chute/oracle_pair.26001.dump.gz"),
        extended("liggghts-chute/oracle_wall.26001.dump.gz"),
    ) else {
        return;
    };
    let particles = first_frame(&path);
    let (pairs, warnings) = contacts(&pairs, &preset(ContactPreset::LiggghtsPair), &particles);
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(pairs.len(), 26_580);
    assert_touching(&particles, &pairs);
    let through_boundary = pairs.iter().filter(|c| {
        let Partner::Particle(other) = c.partner else { return false };
        let [a, b] = [c.particle, other].map(|i| particles.positions()[i as usize]);
        (0..3).any(|k| (b[k] - a[k] - c.branch[k]).abs() > 0.01)
    });
    // LIGGGHTS flags 1,263 of them; it counts by ghosts, which is not quite the same.
    let count = through_boundary.count();
    println!("{count} pairs through a periodic boundary");
    assert!((1200..1300).contains(&count), "{count}");
    // LIGGGHTS puts the contact point where it divides the line of centres in proportion to the radii; from the radii
    // alone the point is put in the middle of the overlap, a few hundredths of the overlap away.
    let columns = "id1=c_pp[13],id2=c_pp[14],force=c_pp[16..18],overlap=c_pp[32]".parse().unwrap();
    let path_of_pairs = extended("liggghts-chute/oracle_pair.26001.dump.gz").unwrap();
    let (rebuilt, _) = contacts(&path_of_pairs, &ContactOptions { preset: None, columns: Some(columns) }, &particles);
    let radii = particles.radii().unwrap();
    let (mut stated, mut middle) = (0.0f64, 0.0f64);
    for (a, b) in pairs.iter().zip(rebuilt.iter()) {
        let Partner::Particle(other) = a.partner else { panic!("{a:?}") };
        let [own, other] = [a.particle, other].map(|i| radii[i as usize]);
        let proportional = a.branch.map(|x| x * own / (own + other));
        stated = stated.max(length([0, 1, 2].map(|k| a.arm[k] - proportional[k])));
        middle = middle.max(length([0, 1, 2].map(|k| a.arm[k] - b.arm[k])) / (own + other - length(a.branch)));
        assert!(length([0, 1, 2].map(|k| a.branch[k] - b.branch[k])) < 1e-15);
    }
    println!("contact points: {stated:e} from the proportional ones, {middle:e} of the overlap from the middle");
    assert!(stated < 5e-13, "{stated:e}");
    assert!(middle < 0.11, "{middle:e}");

    let (walls, warnings) = contacts(&walls, &preset(ContactPreset::LiggghtsWall), &particles);
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(walls.len(), 344);
    // Four rows are of contacts with edges of triangles; all others are with the plane right below.
    assert!(walls.iter().all(|c| c.arm[2] < -0.0007));
    assert_eq!(walls.iter().filter(|c| c.arm[0].abs().max(c.arm[1].abs()) > 1e-13).count(), 4);
    // The forces in the dump are not quite those that acted; some are near them. That their sign and their particles are
    // right is seen by that.
    let mut all = pairs.clone();
    all.extend(&walls);
    let gravity = [9.81 * 0.406_736_64, 0.0, -9.81 * 0.913_545_46];
    let (largest, rms) = imbalance(&particles, &all, gravity);
    println!("chute: largest {largest:e}, rms {rms:e}");
    let sums = all.force_sums(particles.len());
    let stated = &particles.quantity("force").unwrap().data;
    let mass = &particles.quantity("mass").unwrap().data;
    let mut relative: Vec<f64> = (0..particles.len())
        .map(|i| {
            let off = length([0, 1, 2].map(|k| sums[i][k] + mass[i] * gravity[k] - stated[3 * i + k]));
            off / length([0, 1, 2].map(|k| sums[i][k].abs().max(stated[3 * i + k].abs())))
        })
        .collect();
    relative.sort_by(f64::total_cmp);
    println!("chute: median of the relative difference {:.2e}", relative[relative.len() / 2]);
    assert!(relative[relative.len() / 10] < 1e-2);
}

#[test]
fn the_mercury_box_has_the_wall_forces_that_carry_its_weight() {
    let (Some(data), Some(fstat)) = (extended("mercury-box/box1000.data.gz"), extended("mercury-box/box1000.fstat.gz"))
    else {
        return;
    };
    let mut frames = open_particles(&data, &ParticleOptions::default()).unwrap();
    let mut reader = open_contacts(&fstat, &ContactOptions::default()).unwrap();
    let mut last = None;
    while let Some(particles) = frames.next_frame().unwrap() {
        assert_eq!(reader.peek().unwrap().unwrap().time, particles.time());
        let contacts = reader.next_frame(&particles).unwrap().expect("contacts of every frame");
        assert_touching(&particles, &contacts);
        last = Some((particles, contacts));
    }
    assert!(reader.next_frame(&Particles::default()).unwrap().is_none());
    assert_eq!(reader.warnings(), ["pairs are listed twice, once from either side: each is taken once"]);
    let (particles, contacts) = last.unwrap();
    let pairs = contacts.iter().filter(|c| matches!(c.partner, Partner::Particle(_))).count();
    let walls: Vec<_> = contacts.iter().filter(|c| matches!(c.partner, Partner::Wall(_))).collect();
    assert_eq!((2 * pairs + walls.len(), particles.len()), (4285, 1000));
    let force = [0, 1, 2].map(|k| walls.iter().map(|c| c.force[k]).sum::<f64>());
    println!("{pairs} pairs, {} walls, force {force:?}", walls.len());
    for (found, expected) in force.iter().zip([3.58, -1.02, 1000.2]) {
        assert!((found - expected).abs() < 0.05, "{force:?}");
    }
    let all = contacts.force_sums(particles.len());
    let total = [0, 1, 2].map(|k| all.iter().map(|f| f[k]).sum::<f64>());
    assert!((0..3).all(|k| (total[k] - force[k]).abs() < 1e-9), "{total:?}");
    // Walls 0 to 4, as in the restart file.
    for wall in 0..5 {
        assert!(walls.iter().any(|c| c.partner == Partner::Wall(wall)), "wall {wall}");
    }
}
