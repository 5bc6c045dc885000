//! `fieldstone plot` on every kind of result.

#![allow(clippy::unwrap_used)]

mod support;

use std::io::Write;
use std::path::Path;

use fieldstone::io::vtk;
use support::Folder;
use support::cases::{GRAINS, grains, mentions};

/// Width, height and how many colours a PNG has.
fn picture(path: &Path) -> (u32, u32, usize) {
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(std::fs::File::open(path).unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let colours: std::collections::HashSet<[u8; 3]> = pixels.as_chunks::<3>().0.iter().copied().collect();
    (info.width, info.height, colours.len())
}

#[test]
fn slices_and_profiles_are_drawn_from_every_kind_of_result() {
    let folder = grains();
    let fields = "--fields density,velocity,contact_stress";
    for out in ["g.vti", "g.csv", "g.stat"] {
        folder.succeeds(&format!("{GRAINS} --cells 8,8,30 {fields} --out {out}"));
        folder.succeeds(&format!("plot {out} --field contact_stress --component zz --slice z=0.001 --out slice.png"));
        let (width, height, colours) = picture(&folder.path("slice.png"));
        assert!(width > 500 && height > 500 && colours > 30, "{out}: {width} {height} {colours}");
        folder.succeeds(&format!("plot {out} --field density --profile z --out profile.svg"));
        let text = std::fs::read_to_string(folder.path("profile.svg")).unwrap();
        mentions(&text, &["<svg", "density, mean by volume", ">\nz\n</text>"]);
    }
    folder.succeeds("plot g.vti --field velocity");
    assert!(folder.path("g_velocity.png").is_file());
    folder.succeeds(&format!("{GRAINS} --coordinates Z --cells 30 {fields} --out line.csv"));
    folder.succeeds("plot line.csv --field velocity --out line.svg");
    mentions(&std::fs::read_to_string(folder.path("line.svg")).unwrap(), &["velocity, mean by mass", "velocity y"]);
    for (line, parts) in [
        ("plot g.vti --field speed", ["no field 'speed'; it has", "density"]),
        ("plot g.csv --field speed", ["no field 'speed'; it has", "density"]),
        ("plot g.vti --field density --component x", ["density has no such component", "it is a scalar"]),
        ("plot g.vti --field density --frame 7", ["g.vti: frame 7 was asked for", "the file has 1, from 0"]),
        ("plot g.vti --field velocity --slice z=7", ["--slice z=7: the cells reach from", "to 0.12"]),
        ("plot g.vti --field velocity --slice w=7", ["--slice w: choose one of", "x, y, z"]),
        ("plot g.vti --field velocity --profile height", ["--profile height: choose one of", "x, y, z or r"]),
        ("plot g.vti --field velocity --out a.gif", ["a.gif: pictures are", ".svg"]),
        ("plot g.stat --field density --frame 3", ["frame 3 was asked for", "has 1"]),
        ("plot part.dump --field density", ["part.dump: give a .vti", "fieldstone fields wrote"]),
    ] {
        mentions(&folder.fails(line), &parts);
    }
}

#[test]
fn fields_on_the_nodes_of_a_grid_are_plotted_and_those_of_a_mesh_refused_with_their_names() {
    let folder = Folder::new();
    let mut text = String::from("x,y,z,pressure\n");
    for n in 0..512 {
        let [x, y, z] = [n % 8, n / 8 % 8, n / 64].map(|n| 0.1 * f64::from(n));
        text += &format!("{x},{y},{z},{}\n", 7.0 - 2.0 * z);
    }
    folder.write("fluid.csv", text);
    let grid = "grid --particles fluid.csv --spacing 0.1 --beyond-surface --fields pressure";
    folder.succeeds(&format!("{grid} --out g.vti"));
    folder.succeeds("plot g.vti --field pressure --slice y=0.3 --out slice.png");
    assert!(picture(&folder.path("slice.png")).2 > 8);
    folder.succeeds("plot g.vti --field pressure --profile z --out profile.svg");
    mentions(&std::fs::read_to_string(folder.path("profile.svg")).unwrap(), &["pressure, mean by volume"]);
    // A single layer of nodes.
    folder.succeeds(&format!("{grid} --slice y=0.3 --out s.vti"));
    folder.succeeds("plot s.vti --field pressure --out slice.png");
    mentions(
        &folder.fails("plot g.vti --field speed"),
        &["no field 'speed'; it has level_set, support, pressure, on nodes"],
    );

    let mesh = fieldstone::io::read_mesh(&fieldstone_testing::data("openfoam/decomposed/whole")).unwrap();
    let height = mesh.parts().points.iter().map(|p| p[2]).collect();
    let points = [fieldstone::io::DataArray::scalar("height", height)];
    let arrays = vtk::VtkArrays { points: &points, ..vtk::VtkArrays::default() };
    vtk::write_vtu(&folder.path("m.vtu"), &mesh, arrays, vtk::VtkEncoding::default()).unwrap();
    let message = folder.fails("plot m.vtu --field height");
    mentions(&message, &["m.vtu: its fields are on nodes (height)", "on cells", "ParaView"]);
}

#[test]
fn results_are_told_from_particles() {
    let folder = grains();
    let fields = "--cells 4,4,12 --fields density";
    for (out, parts) in [
        ("g.csv", ["cells, one a row     192\n", "column               density, "]),
        ("g.stat", ["results on points    4 × 4 × 12\n", "column               Density, "]),
    ] {
        folder.succeeds(&format!("{GRAINS} {fields} --out {out}"));
        let told = folder.succeeds(&format!("info {out}")).stdout;
        mentions(&told, &parts);
        assert!(!told.contains("particles"), "{told}");
    }
    let square = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    vtk::write_vtp_polygons(
        &folder.path("faces.vtp"),
        &square,
        &[0, 1, 2, 3],
        &[4],
        vtk::VtkArrays::default(),
        vtk::VtkEncoding::default(),
    )
    .unwrap();
    mentions(
        &folder.succeeds("info faces.vtp").stdout,
        &["surface              4 points\n", "polygons             1\n"],
    );
    vtk::write_pvd(&folder.path("run.pvd"), &[(0.0, "a.vti".into()), (0.5, "b.vti".into())]).unwrap();
    let told = folder.succeeds("info run.pvd").stdout;
    mentions(&told, &["files over time      2\n", "time                 0 to 0.5\n", "a.vti to b.vti"]);
}

/// Compresses a file of the folder; the name of the result.
fn compressed(folder: &Folder, name: &str) -> String {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(&std::fs::read(folder.path(name)).unwrap()).unwrap();
    let to = format!("{name}.gz");
    folder.write(&to, packed.finish().unwrap());
    to
}

#[test]
fn compressed_results_are_plotted_and_told_about_as_plain_ones() {
    let folder = grains();
    for out in ["g.vti", "g.csv", "g.stat"] {
        folder.succeeds(&format!("{GRAINS} --cells 4,4,12 --fields density --out {out}"));
        folder.succeeds(&format!("plot {out} --field density --profile z --out plain.svg"));
        let packed = compressed(&folder, out);
        folder.succeeds(&format!("plot {packed} --field density --profile z --out packed.svg"));
        let [plain, packed] = ["plain.svg", "packed.svg"].map(|name| std::fs::read(folder.path(name)).unwrap());
        assert!(plain == packed, "{out}");
    }
    assert_eq!(folder.succeeds("info g.vti.gz").stdout, folder.succeeds("info g.vti").stdout);
    folder.succeeds("plot g.vti.gz --field density");
    assert!(folder.path("g_density.png").is_file());
    mentions(&folder.fails("plot part.dump.gz --field density"), &["part.dump.gz: give a .vti"]);
}

#[test]
fn a_species_profile_is_a_mean_by_the_mass_of_that_species() {
    let folder = Folder::new();
    // One row of two cells over x: all of the first species in the first cell, the second one in both.
    let names = "x,y,z,cell_volume,density,density_species_1,density_species_2,velocity_species_1_x,velocity_species_1_y,\
                 velocity_species_1_z,velocity_species_2_x,velocity_species_2_y,velocity_species_2_z\n";
    folder.write("two.csv", format!("{names}0.5,0.5,0.5,1,4,3,1,5,0,0,8,0,0\n1.5,0.5,0.5,1,3,0,3,0,0,0,4,0,0\n"));
    for (field, by) in [("velocity_species_1", "mass"), ("velocity_species_2", "mass"), ("density_species_1", "volume")]
    {
        folder.succeeds(&format!("plot two.csv --field {field} --profile z --out two.svg"));
        let text = std::fs::read_to_string(folder.path("two.svg")).unwrap();
        mentions(&text, &[&format!("{}, mean by {by}", field.replace('_', " "))]);
    }
}

#[test]
fn six_components_without_names_have_no_magnitude() {
    let folder = Folder::new();
    let balls = "x,y,z,radius,s0,s1,s2,s3,s4,s5\n0.5,0.5,0.5,0.4,1,2,3,4,5,6\n";
    folder.write("balls.csv", balls);
    folder.succeeds(
        "fields --particles balls.csv --density 1 --fields density --quantity s=s0,s1,s2,s3,s4,s5 \
         --cells 4 --grid 0,1,0,1,0,1 --out s.vti",
    );
    for line in ["plot s.vti --field s", "plot s.vti --field s --component magnitude"] {
        mentions(&folder.fails(line), &["s has six components without names", "choose one of 0, 1, 2, 3, 4, 5"]);
    }
    mentions(&folder.fails("plot s.vti --field s --component xy"), &["there are 0, 1, 2, 3, 4, 5\n"]);
    folder.succeeds("plot s.vti --field s --component 3 --out s.png");
}
