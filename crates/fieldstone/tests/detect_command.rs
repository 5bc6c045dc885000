//! `fieldstone detect`: what it says of its input.

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
