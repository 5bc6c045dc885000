//! Sums that are documented to agree and do not are told of: nobody has to find them in the account.

#![allow(clippy::unwrap_used)]

mod support;

use support::Folder;
use support::cases::{mentions, one_ball};

/// Two unit cubes from x = 0 and from `second` on, each with corners of its own.
fn two_cubes(second: f64) -> String {
    let ring = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
    let corners = |from: f64| ring.map(|[x, y, z]| format!("{} {y} {z}\n", from + f64::from(x))).concat();
    format!(
        "# vtk DataFile Version 2.0\ntwo\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 16 double\n{}{}CELLS 2 18\n\
         8 0 1 2 3 4 5 6 7\n8 8 9 10 11 12 13 14 15\nCELL_TYPES 2\n12\n12\n",
        corners(0.0),
        corners(second)
    )
}

#[test]
fn cells_that_overlap_each_other_are_told_of_by_the_volume_and_the_mass_that_they_hold_twice() {
    let folder = Folder::new();
    folder.write("two.vtk", two_cubes(0.5));
    folder.write("one.dump", one_ball("ff ff ff\n0 1\n0 1\n0 1", "1 0.75 0.5 0.5 0.2"));
    let said = "the cells hold 200.0000 % of the particles' ";
    let run = folder.succeeds("fraction --mesh two.vtk --particles one.dump --out o.csv");
    mentions(&run.stderr, &[said, "volume, and none of them repeats the periodic box", "mend the mesh"]);
    let fields = "fields --mesh two.vtk --particles one.dump --density 1 --fields density --out o.csv";
    mentions(&folder.succeeds(fields).stderr, &[said, "mass"]);
    // In the first cell alone there is as much as there is.
    folder.write("one.dump", one_ball("ff ff ff\n0 1\n0 1\n0 1", "1 0.25 0.5 0.5 0.2"));
    assert_eq!(folder.succeeds("fraction --mesh two.vtk --particles one.dump --out o.csv").stderr, "");
    assert_eq!(folder.succeeds(fields).stderr, "");
}

#[test]
fn images_in_cells_of_several_periods_are_no_fault() {
    let folder = Folder::new();
    folder.write("one.dump", one_ball("pp pp pp\n0 1\n0 1\n0 1", "1 0.25 0.5 0.5 0.25"));
    let cells = "--grid 0,2,0,1,0,1 --cells 4,2,2 --particles one.dump --periodic x --out o.vti";
    assert_eq!(folder.succeeds(&format!("fraction {cells}")).stderr, "");
    assert_eq!(folder.succeeds(&format!("fields {cells} --density 1 --fields density")).stderr, "");
}

#[test]
fn points_on_periodic_faces_are_placed_once_in_the_account() {
    let folder = Folder::new();
    for (at, radius) in [("0 .5 .5", "0.1"), ("0 0 0", "0.1"), ("0 0 0", "0.5")] {
        folder.write("one.dump", one_ball("pp pp pp\n0 1\n0 1\n0 1", &format!("1 {at} {radius}")));
        for method in ["kernel", "centre", "divided", "sampled:20"] {
            let line = "fraction --particles one.dump --grid 0,1,0,1,0,1 --cells 4 --out o.vti --method";
            let run = folder.succeeds(&format!("{line} {method}"));
            mentions(&run.stdout, &["(100.0000 %)", "clipped volume       0  "]);
            assert_eq!(run.stderr, "", "{method}");
        }
    }
}

#[test]
fn stresses_that_miss_those_of_the_contacts_are_told_of_where_all_mass_is_in_the_cells() {
    let folder = Folder::new();
    let head =
        |items: &str| format!("ITEM: TIMESTEP\n0\nITEM: NUMBER OF {items}\nITEM: BOX BOUNDS ff ff ff\n0 3\n0 1\n0 1\n");
    let balls = "ITEM: ATOMS id x y z radius\n1 0.75 0.5 0.5 0.25\n2 1.45 0.5 0.5 0.25\n";
    folder.write("two.dump", head("ATOMS\n2") + balls);
    folder.write("pair.dump", head("ENTRIES\n1") + "ITEM: ENTRIES c_p[1] c_p[2] c_p[3] c_p[4] c_p[5]\n1 2 -4 0 0\n");
    let line = "fields --particles two.dump --density 1 --fields contact_stress --stress-form branch-in-cell --out o.csv \
                --contacts pair.dump --contacts-columns id1=c_p[1],id2=c_p[2],force=c_p[3..5]";
    // Two sevenths of the branch are in the gap between two cubes, which hold one ball each.
    folder.write("apart.vtk", two_cubes(1.2));
    let run = folder.succeeds(&format!("{line} --mesh apart.vtk"));
    mentions(
        &run.stderr,
        &["Σ σ V over the cells differs from Σ f ⊗ l over the contacts by 28.6 %", "all particles are in"],
    );
    // Without the gap it is all there.
    assert_eq!(folder.succeeds(&format!("{line} --grid 0,3,0,1,0,1 --cells 2,1,1")).stderr, "");
}

#[test]
fn a_kernel_between_or_on_the_few_points_where_it_is_sampled_is_told_of() {
    let folder = Folder::new();
    let fields =
        "fields --particles one.dump --density 1 --fields density --grid 0,1,0,1,0,1 --out o.vti --function gauss";
    let run = |at: &str, options: &str| {
        folder.write("one.dump", one_ball("pp pp pp\n0 1\n0 1\n0 1", &format!("1 {at} 0.1")));
        folder.succeeds(&format!("{fields} {options}"))
    };
    let advice = "give --conserve, finer cells or a larger --width";
    let surplus = run("0.5 0.5 0.5", "--cells 1 --width 0.1");
    mentions(&surplus.stderr, &["the sampled kernel gives the cells ", "% of the mass", advice]);
    mentions(&surplus.stdout, &["mass in surplus", "added by the sampled kernel"]);
    assert!(!surplus.stdout.contains("missed"), "{}", surplus.stdout);
    let missed = run("0.4 0.4 0.4", "--cells 2 --width 0.1");
    mentions(&missed.stderr, &["% of the mass", "or the kernel reaches beyond the outer cells", advice]);
    mentions(&missed.stdout, &["mass clipped", "missed by the sampled kernel"]);
    for fine in ["--cells 1 --width 0.1 --conserve", "--cells 20 --width 0.1"] {
        assert_eq!(run("0.5 0.5 0.5", fine).stderr, "", "{fine}");
    }
}
