//! Particle readers against files made at random: right ones must come back bit for bit, damaged ones must end
//! in a frame or an error, soon and in little memory.

#![allow(clippy::unwrap_used)]

use std::fmt::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use fieldstone_io::{CsvTable, DumpReader, FrameReader, MercuryReader, ParticleOptions, open_particles};
use fieldstone_testing::{Random, data, extended, read_text};
use proptest::prelude::*;

/// Column names of a dump, and where the values of each go.
const COLUMNS: [&str; 15] = [
    "id", "type", "x", "y", "z", "radius", "vx", "vy", "vz", "mass", "c_s[1]", "c_s[2]", "c_s[3]", "c_s[4]", "f_other",
];

/// Between these, sizes can be computed with.
const SMALLEST: f64 = 1e-100;
const LARGEST: f64 = 1e100;

fn finite() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |v| v.is_finite()),
        -1.0..1.0f64,
        (-1000i32..1000).prop_map(f64::from),
    ]
}

/// A coordinate that can be computed with.
fn coordinate() -> impl Strategy<Value = f64> {
    finite().prop_map(|x| if x.abs() > LARGEST { x.signum() * LARGEST } else { x })
}

/// A radius that can be computed with, any of its 64 bits.
fn positive() -> impl Strategy<Value = f64> {
    (SMALLEST.to_bits()..=LARGEST.to_bits()).prop_map(f64::from_bits)
}

type Grain = (i64, i32, [f64; 3], f64, [f64; 3], [f64; 6]);

fn grain() -> impl Strategy<Value = Grain> {
    let triple = || prop::array::uniform3(finite());
    (
        any::<i64>(),
        any::<i32>(),
        prop::array::uniform3(coordinate()),
        positive(),
        triple(),
        prop::array::uniform6(finite()),
    )
}

fn value(grain: &Grain, column: usize) -> String {
    let (id, kind, x, radius, v, q) = grain;
    match column {
        0 => id.to_string(),
        1 => kind.to_string(),
        2..=4 => format!("{:?}", x[column - 2]),
        5 => format!("{radius:?}"),
        6..=8 => format!("{:e}", v[column - 6]),
        _ => format!("{:.17e}", q[column - 9]),
    }
}

fn bits<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> Vec<u64> {
    numbers.into_iter().map(|n| n.to_bits()).collect()
}

proptest! {
    #[test]
    fn a_dump_with_its_columns_in_any_order_reads_back_to_the_same_bits(
        frames in prop::collection::vec(prop::collection::vec(grain(), 0..12), 1..4),
        order in Just((0..COLUMNS.len()).collect::<Vec<_>>()).prop_shuffle(),
    ) {
        let mut text = String::new();
        for (step, grains) in frames.iter().enumerate() {
            let names: Vec<&str> = order.iter().map(|&c| COLUMNS[c]).collect();
            write!(text, "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS pp ff pp\n0 1\n0 1\n0 1\n\
                ITEM: ATOMS {}\n", grains.len(), names.join(" ")).unwrap();
            for grain in grains {
                let row: Vec<String> = order.iter().map(|&c| value(grain, c)).collect();
                writeln!(text, "{} ", row.join(" ")).unwrap();
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("random.dump");
        std::fs::write(&path, text).unwrap();
        let mut reader = DumpReader::open(&path).unwrap();
        for (step, grains) in frames.iter().enumerate() {
            let p = reader.next_frame().unwrap().expect("as many frames as written");
            prop_assert_eq!(p.step(), Some(step as i64));
            prop_assert_eq!(p.ids().unwrap(), grains.iter().map(|g| g.0).collect::<Vec<_>>());
            prop_assert_eq!(p.types().unwrap(), grains.iter().map(|g| i64::from(g.1)).collect::<Vec<_>>());
            prop_assert_eq!(bits(p.positions().iter().flatten()), bits(grains.iter().flat_map(|g| &g.2)));
            prop_assert_eq!(bits(p.radii().unwrap()), bits(grains.iter().map(|g| &g.3)));
            prop_assert_eq!(bits(&p.quantity("velocity").unwrap().data), bits(grains.iter().flat_map(|g| &g.4)));
            prop_assert_eq!(bits(&p.quantity("mass").unwrap().data), bits(grains.iter().map(|g| &g.5[0])));
            prop_assert_eq!(bits(&p.quantity("c_s").unwrap().data), bits(grains.iter().flat_map(|g| &g.5[1..5])));
            prop_assert_eq!(bits(&p.quantity("f_other").unwrap().data), bits(grains.iter().map(|g| &g.5[5])));
        }
        prop_assert!(reader.next_frame().unwrap().is_none());
    }

    #[test]
    fn particles_written_as_a_table_read_back_to_the_same_bits(grains in prop::collection::vec(grain(), 1..12)) {
        use fieldstone_particles::{Particles, Quantity};
        let velocity = grains.iter().flat_map(|g| g.4).collect();
        let stress = grains.iter().flat_map(|g| g.5).collect();
        let written = Particles::new(grains.iter().map(|g| g.2).collect()).unwrap()
            .with_radii(grains.iter().map(|g| g.3).collect()).unwrap()
            .with_ids(grains.iter().map(|g| g.0).collect()).unwrap()
            .with_quantity(Quantity { name: "velocity".into(), components: 3, data: velocity }).unwrap()
            .with_quantity(Quantity { name: "stress".into(), components: 6, data: stress }).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("random.csv");
        fieldstone_io::write_particles_csv(&path, &written).unwrap();
        let read = open_particles(&path, &ParticleOptions::default()).unwrap().next_frame().unwrap().unwrap();
        prop_assert_eq!(bits(read.positions().iter().flatten()), bits(written.positions().iter().flatten()));
        prop_assert_eq!(bits(read.radii().unwrap()), bits(written.radii().unwrap()));
        prop_assert_eq!(read.ids(), written.ids());
        for (a, b) in read.quantities().iter().zip(written.quantities()) {
            prop_assert_eq!((&a.name, a.components, bits(&a.data)), (&b.name, b.components, bits(&b.data)));
        }
    }
}

fn damage(content: &[u8], random: &mut Random) -> Vec<u8> {
    const PIECES: [&[u8]; 16] = [
        b"\n",
        b" ",
        b"nan",
        b"-",
        b"1e999",
        b"ITEM:",
        b"ITEM: TIMESTEP\n",
        b"\0",
        b"\xff\xfe",
        b"99999999999999999999",
        b"4000000000000000000",
        b",",
        b"\"",
        b"#",
        b"xy xz yz",
        b"\r",
    ];
    let mut out = content.to_vec();
    for _ in 0..=random.below(4) {
        if out.is_empty() {
            break;
        }
        // Half of the damage goes to the headers, where it matters most.
        let reach = if random.below(2) == 0 { out.len().min(300) } else { out.len() };
        let at = random.below(reach);
        let end = (at + random.below(40)).min(out.len());
        match random.below(6) {
            0 => out.truncate(at),
            1 => out[at] = random.below(256) as u8,
            2 => drop(out.drain(at..end)),
            3 => {
                let copy = out[at..end].to_vec();
                out.splice(at..at, copy);
            }
            4 => drop(out.splice(at..at, PIECES[random.below(PIECES.len())].iter().copied())),
            _ => drop(out.splice(at..end, PIECES[random.below(PIECES.len())].iter().copied())),
        }
    }
    out
}

/// Real files where they are at hand, cut to a few frames' worth of lines, and one of each kind made here.
fn originals() -> Vec<(&'static str, Vec<u8>)> {
    let mut originals = vec![
        ("scaled.dump", b"ITEM: UNITS\nsi\nITEM: TIME\n0.5\nITEM: TIMESTEP\n1\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS xy xz yz pp pp ff\n-2 5 1\n0 5.5 -2\n0 6 0.5\nITEM: ATOMS id element xs ys zs d\n1 Fe 0 0 0 1\n2 C .5 .5 .5 1\n".to_vec()),
        ("table.csv", b"# note\nid,x,y,z,r,v:0,v:1,v:2,name\n1,0,0,1,0.5,1,2,3,\"a, b\"\n2,1,0,1,0.5,1,2,3,c\n".to_vec()),
        ("yade.txt", b"#format x_y_z_r_attrs\n# x y z r d v_x v_y v_z\n0\t0\t1\t0.5\t3\t4\t5\t6\n1\t0\t1\t0.5\t3\t4\t5\t6\n".to_vec()),
        ("ext.xyz", b"2\nLattice=\"2 0 0 0 3 0 0 0 4\" Properties=species:S:1:pos:R:3:radius:R:1\nA 0 0 1 0.5\nA 1 0 1 0.25\n1\nplain\nA 0 0 0\n".to_vec()),
        ("flat.data", b"2 0.5 0 0 0 1 2 3\n1 2 3 4 5 6 7 8 9 10 11 12 13 0\n.1 .2 .3 4 5 6 .5 8 9 10 11 12 13 2\n0 1 0 0 0 1 1 1\n".to_vec()),
    ];
    let packed = Some(data("packed-cylinder/packed.dump.gz")).filter(|path| path.exists());
    let real: [(&str, Option<PathBuf>, usize); 3] = [
        ("packed.dump", packed.or_else(|| extended("packed-cylinder/packed.dump.gz")), 49),
        ("pack.dump", extended("lammps-pack/part.4000.dump.gz"), 29),
        ("box.data", extended("mercury-box/box1000.data.gz"), 51),
    ];
    for (name, path, lines) in real {
        let Some(path) = path else { continue };
        let text = read_text(&path);
        let excerpt: String = text.split_inclusive('\n').take(lines).collect();
        // With its count corrected the excerpt is a whole frame, so that damage has something to break.
        let count = format!("ATOMS\n{}\nITEM: OLD COUNT\n", lines - 9);
        let (old, new) = if name == "box.data" { ("1000 ", "50 ") } else { ("ATOMS\n", count.as_str()) };
        originals.push((name, excerpt.replacen(old, new, 1).into_bytes()));
    }
    originals
}

#[test]
fn damaged_files_end_in_frames_or_an_error_without_panic_or_delay() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(20_240_607);
    let (mut frames, mut errors) = (0, 0);
    for (name, content) in originals() {
        let path = folder.path().join(name);
        for _ in 0..400 {
            std::fs::write(&path, damage(&content, &mut random)).unwrap();
            let begin = Instant::now();
            for allow_non_spherical in [false, true] {
                match open_particles(&path, &ParticleOptions { allow_non_spherical }) {
                    Err(_) => errors += 1,
                    Ok(mut reader) => loop {
                        match reader.next_frame() {
                            Ok(Some(particles)) => {
                                frames += 1;
                                assert!(particles.len() <= content.len());
                                assert!(reader.warnings().len() < 100);
                            }
                            Ok(None) => break,
                            Err(error) => {
                                errors += 1;
                                let text = error.to_string();
                                assert!(text.contains(name), "the file is named: {text}");
                                assert!(text.len() < 20_000, "the message is no dump of the file");
                                break;
                            }
                        }
                    },
                }
            }
            // A reader told to expect another format than the content has must not fall over either.
            let _ = DumpReader::open(&path).map(|mut reader| while let Ok(Some(_)) = reader.next_frame() {});
            let _ = MercuryReader::open(&path).map(|mut reader| while let Ok(Some(_)) = reader.next_frame() {});
            if let Ok(mut reader) = open_particles(&path, &ParticleOptions::default()) {
                while let Ok(true) = reader.skip_frame() {}
            }
            if let Ok(table) = CsvTable::read(&path) {
                for name in table.names() {
                    let _ = table.column(name);
                }
            }
            assert!(begin.elapsed() < Duration::from_secs(5), "{name} took {:?}", begin.elapsed());
        }
    }
    // Both ends must be reached often, or the damage would be too light or too heavy to test anything.
    assert!(frames > 500 && errors > 1000, "{frames} frames, {errors} errors");
}

#[test]
fn whatever_is_read_can_be_skipped_and_gives_the_same_number_of_frames() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(7);
    let mut compared = 0;
    for (name, content) in originals() {
        let path = folder.path().join(name);
        for round in 0..100 {
            let content = if round == 0 { content.clone() } else { damage(&content, &mut random) };
            std::fs::write(&path, content).unwrap();
            let options = ParticleOptions::default();
            let Ok(mut reader) = open_particles(&path, &options) else { continue };
            let mut read = 0;
            let complete = loop {
                match reader.next_frame() {
                    Ok(Some(_)) => read += 1,
                    Ok(None) => break true,
                    Err(_) => break false,
                }
            };
            if complete {
                let mut reader = open_particles(&path, &options).unwrap();
                let mut skipped = 0;
                while reader.skip_frame().unwrap() {
                    skipped += 1;
                }
                assert_eq!(skipped, read, "{name}, round {round}");
                compared += 1;
            }
            assert!(complete || round > 0, "{name} itself is whole");
        }
    }
    assert!(compared > 50, "{compared}");
}

#[test]
fn a_binary_file_without_line_ends_is_refused_before_it_fills_the_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.dump");
    let mut content = b"ITEM: TIMESTEP\n".to_vec();
    content.resize(20 << 20, b'7');
    std::fs::write(&path, content).unwrap();
    let error = DumpReader::open(&path).unwrap().next_frame().unwrap_err().to_string();
    assert!(error.contains(":2: the line is longer than 16 MiB"), "{error}");
}
