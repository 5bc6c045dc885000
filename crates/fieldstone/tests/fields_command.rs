//! `fieldstone fields` as users run it, on small cases that come with the tests: closed forms, conservation, balances.

#![allow(clippy::unwrap_used)]

mod support;

use std::f64::consts::PI;

use fieldstone::io::{CsvTable, ParticleOptions, Values, read_frame, read_stat, vtk, write_particles_csv};
use support::Folder;
use support::cases::{GRAINS, MERCURY, apart, column, grains, json, mentions, mercury, numbers, size};

#[test]
fn a_liggghts_frame_with_pairs_and_walls_conserves_and_balances() {
    let folder = grains();
    let run = folder.succeeds(&format!("{GRAINS} --cells 6,5,40 --fields all --out out.vti --json out.json"));
    mentions(&run.stdout, &["mass clipped         0  (0.0000 %, outside the cells)", "compression positive"]);
    let account = json(&folder, "out.json");
    let keys: Vec<&str> = account.as_object().unwrap().keys().map(String::as_str).collect();
    for key in [
        "mass_in",
        "mass_binned",
        "mass_clipped",
        "momentum_in",
        "momentum_binned",
        "stress_sum_contacts",
        "stress_sum_fields",
        "balance_residual",
        "frames",
        "seconds",
    ] {
        assert!(keys.contains(&key), "{key}");
    }
    let value = |key: &str| account[key].as_f64().unwrap();
    assert!((value("mass_binned") / value("mass_in") - 1.0).abs() < 1e-12);
    assert!(value("balance_residual") < 1e-12 && value("frames") == 1.0);
    for (a, b) in [("momentum_in", "momentum_binned"), ("stress_sum_contacts", "stress_sum_fields")] {
        let (a, b) = (numbers(&account[a]), numbers(&account[b]));
        assert!(size(&a) > 0.0 && apart(&a, &b) <= 1e-12 * size(&a));
    }
    // What the JSON says is what the fields hold.
    let volume = column(&folder, "out.vti", "cell_volume");
    let density = column(&folder, "out.vti", "density");
    let mass: f64 = density.iter().zip(&volume).map(|(rho, v)| rho * v).sum();
    assert!((mass / value("mass_in") - 1.0).abs() < 1e-12);
    let momentum = column(&folder, "out.vti", "momentum");
    let velocity = column(&folder, "out.vti", "velocity");
    let product: Vec<f64> = velocity.iter().enumerate().map(|(k, u)| u * density[k / 3]).collect();
    assert!(apart(&momentum, &product) <= 1e-12 * size(&momentum));
}

#[test]
fn a_mercury_box_gives_closed_forms_in_vti_csv_and_stat() {
    let folder = mercury();
    for out in ["out.vti", "out.csv"] {
        folder.succeeds(&format!("{MERCURY} --fields standard,velocity --out {out}"));
    }
    folder.succeeds(&format!("{MERCURY} --out out.stat"));
    // Each ball fills its unit cell: π/6, ρ = 3 π/6. The pair's stress is half of f ⊗ b = 2 in each, the floor's f ⊗ l = 5/2.
    let rho = 3.0 * PI / 6.0;
    let table = CsvTable::read(&folder.path("out.csv")).unwrap();
    let stress = column(&folder, "out.vti", "contact_stress");
    assert!(apart(&column(&folder, "out.vti", "density"), &[rho, rho]) < 1e-15);
    assert_eq!((stress[0], stress[8], stress[9]), (1.0, 2.5, 1.0));
    for (k, name) in ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"].iter().enumerate() {
        assert_eq!(table.column(&format!("contact_stress_{name}")).unwrap(), [stress[k], stress[9 + k]]);
    }
    assert_eq!(table.column("x").unwrap(), [0.5, 1.5]);
    assert!(apart(&table.column("velocity_x").unwrap(), &[3.0, 0.0]) < 1e-14);
    // The last frame alone in a file of one result, all frames in a .stat.
    let file = read_stat(&folder.path("out.stat")).unwrap();
    assert_eq!(file.blocks.iter().map(|block| block.time).collect::<Vec<_>>(), [0.0, 1.0]);
    let names: Vec<&str> = file.fields.iter().map(|field| field.name.as_str()).collect();
    let theirs =
        ["VolumeFraction", "Density", "Momentum", "MomentumFlux", "ContactStress", "InteractionForce", "ParticleSize"];
    assert_eq!(names, theirs);
    assert!(apart(&file.blocks[1].data[4], &stress) < 1e-5);
    let text = std::fs::read_to_string(folder.path("out.stat")).unwrap();
    assert!(text.starts_with(
        "CG<XYZ> min 0 0 0 max 2 1 1 timeMin 0 n 2 1 1 width 0 ExactOverlap\ntime x y z 5:VolumeFraction 6:"
    ));
    assert!(text.contains("\n1 0.5 0.5 0.5 0.523599 1.5708 4.71239 0 0 14.1372 "), "{text}");
}

#[test]
fn the_radius_is_a_quantity_and_the_weight_of_the_density_a_field_by_its_name() {
    let folder = Folder::new();
    folder.write("two.csv", "x,y,z,radius,mass\n0.3,0.5,0.5,0.1,1\n0.7,0.5,0.5,0.2,3\n");
    let line = "fields --particles two.csv --grid 0,1,0,1,0,1 --cells 1 --out o.vti";
    folder.succeeds(&format!("{line} --fields density --quantity r=radius:mass-mean"));
    assert!((column(&folder, "o.vti", "r")[0] - (0.1 + 3.0 * 0.2) / 4.0).abs() < 1e-12);
    folder.succeeds(&format!("{line} --fields body_force_density --gravity 0,0,-10"));
    assert!((column(&folder, "o.vti", "body_force_density")[2] + 40.0).abs() < 1e-9);
    let message = folder.fails(&format!("{line} --fields body_force_density"));
    mentions(&message, &["--fields body_force_density", "needs --gravity"]);
}

#[test]
fn settings_in_toml_take_names_of_contacts_and_the_text_of_the_command_line() {
    let folder = mercury();
    let fields = |contacts: &str, cells: &str| {
        let text = format!("particles = \"box.data\"\ndensity = 6\nout = \"o.vti\"\ncells = {cells}\n{contacts}\n");
        folder.write("run.toml", text);
        folder.succeeds("fields run.toml");
        column(&folder, "o.vti", "contact_stress")
    };
    let whole = fields("[[contacts]]\nfile = \"box.fstat\"", "[2, 1, 1]");
    assert!(whole.iter().any(|s| *s != 0.0));
    assert_eq!(fields("contacts = \"box.fstat\"", "\"2,1,1\""), whole);
    assert_eq!(fields("contacts = [\"box.fstat\"]", "[2, 1, 1]"), whole);
    for (wrong, reason) in [
        ("contacts = 3", "a list of names, or tables [[contacts]]"),
        ("contacts-preset = \"mercury\"", "unknown key `contacts-preset`"),
        ("contacts-preset = \"mercury\"", "write [[contacts]], and below it file = \"NAME\" with preset = \"NAME\""),
        ("cells = \"two\"", "'two' stands where a number is expected"),
    ] {
        folder.write("bad.toml", wrong);
        mentions(&folder.fails("fields bad.toml"), &["bad.toml:1: ", reason]);
    }
}

#[test]
fn settings_in_toml_do_the_same_and_the_result_repeats_them() {
    let folder = mercury();
    folder.write(
        "run.toml",
        "particles = \"box.data\"\nrestart = \"box.restart\"\ncells = [2, 1, 1]\nout = \"a.csv\"\nsign = \"tension\"\n\
         quantity = [\"speed=velocity:mass-mean\"]\n[[contacts]]\nfile = \"box.fstat\"\n",
    );
    folder.succeeds("fields run.toml");
    folder.succeeds("fields --config run.toml --sign compression --out b.csv");
    let read = |file: &str, name: &str| CsvTable::read(&folder.path(file)).unwrap().column(name).unwrap();
    assert_eq!(read("a.csv", "contact_stress_zz")[0], -2.5);
    assert_eq!(read("b.csv", "contact_stress_zz")[0], 2.5);
    assert!((read("a.csv", "speed_x")[0] - 3.0).abs() < 1e-14);
    // The echo is itself a file of settings.
    let text = std::fs::read_to_string(folder.path("a.csv")).unwrap();
    let echo: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix('#')).collect();
    mentions(
        &text,
        &[
            "## fieldstone ",
            "# sign = \"tension\"",
            "# function = \"exact\"",
            "## density: rho = sum m phi, in mass",
            "## time 1\n",
        ],
    );
    assert!(!text.contains("# #"), "{text}");
    folder.write("again.toml", echo.join("\n"));
    folder.succeeds("fields again.toml --out again.csv");
    let rows = |text: &str| text.lines().filter(|l| !l.starts_with('#')).map(String::from).collect::<Vec<_>>();
    assert_eq!(rows(&std::fs::read_to_string(folder.path("again.csv")).unwrap()), rows(&text));
    // In a .vti they are field data, the codes of their bytes, and can be run again.
    folder.succeeds("fields run.toml --out a.vti");
    let image = vtk::read_vtk(&folder.path("a.vti")).unwrap();
    let Values::U8(bytes) = &image.array("fieldstone").unwrap().values else { panic!("the settings are no bytes") };
    folder.write("bytes.toml", std::str::from_utf8(bytes).unwrap());
    folder.succeeds("fields bytes.toml --out b.vti");
    let data = |name: &str| vtk::read_vtk(&folder.path(name)).unwrap().cell_data;
    assert_eq!(data("a.vti"), data("b.vti"));
    assert!(image.skipped.is_empty() && !folder.succeeds("info a.vti").stdout.contains("fieldstone "));

    // One number stands for a list of one, as on the command line.
    let single = "particles = \"box.data\"\ncells = 2\nspecies = 0\nframes = 1\ndensity = 2\nfields = \"density\"\n";
    folder.write("single.toml", single);
    folder.succeeds("fields single.toml --out single.vti");
    folder.succeeds(
        "fields --particles box.data --cells 2 --species 0 --frames 1 --density 2 --fields density --out l.vti",
    );
    assert_eq!(column(&folder, "single.vti", "density"), column(&folder, "l.vti", "density"));
    for (wrong, reason) in [
        ("cells = 2.5", "bad.toml:1: invalid type: floating point `2.5`"),
        ("cells = -2", "bad.toml:1: invalid value: integer `-2`"),
        ("cells = true", "expected a number or a list of numbers"),
        ("frames = true", "expected a string or a whole number"),
    ] {
        folder.write("bad.toml", wrong);
        mentions(&folder.fails("fields bad.toml"), &[reason]);
    }
    folder.write("bad.toml", "particles = \"box.data\"\nwidht = 1\n");
    mentions(&folder.fails("fields bad.toml"), &["bad.toml:2: unknown key `widht`", "`width`", "`stress-form`"]);
    folder.write("bad.toml", "particles = \"box.data\"\n\nwidth = \"wide\"\n");
    mentions(&folder.fails("fields bad.toml"), &["bad.toml:3: invalid type"]);
    folder.write("bad.toml", "function = \"round\"\n");
    mentions(&folder.fails("fields bad.toml"), &["bad.toml:1: there is no function 'round'; choose exact, gauss"]);
    folder.write("bad.toml", "density = -1.0\n");
    mentions(&folder.fails("fields bad.toml"), &["--density is -1"]);
    folder.write("bad.toml", "[[contacts]]\nfile = \"a\"\nprset = \"mercury\"\n");
    mentions(&folder.fails("fields bad.toml"), &["bad.toml:3: unknown key `prset`", "`preset`"]);
}

#[test]
fn averaged_directions_cylinders_and_meshes_hold_the_same_mass() {
    let folder = mercury();
    let mass = PI;
    let close = |a: f64| (a / mass - 1.0).abs() < 1e-12;
    for coordinates in ["O", "X", "YZ", "XYZ"] {
        folder.succeeds(&format!(
            "fields --particles box.data --density 3 --coordinates {coordinates} --cells 3 --out o.csv --json o.json"
        ));
        assert!(close(json(&folder, "o.json")["mass_binned"].as_f64().unwrap()), "{coordinates}");
    }
    for (coordinates, cells) in [("R", "4"), ("RZ", "4,3"), ("RTZ", "4,5,3")] {
        folder.succeeds(&format!(
            "fields --particles box.data --density 3 --coordinates {coordinates} --axis x --origin 0,0.5,0.5 \
             --grid 0,0.8,0,2 --cells {cells} --out r.csv --json r.json"
        ));
        assert!(close(json(&folder, "r.json")["mass_binned"].as_f64().unwrap()), "{coordinates}");
        let table = CsvTable::read(&folder.path("r.csv")).unwrap();
        let total: f64 = (table.column("density").unwrap().iter())
            .zip(table.column("cell_volume").unwrap())
            .map(|(rho, v)| rho * v)
            .sum();
        assert!(close(total));
    }
    folder.copy(&fieldstone_testing::data("openfoam/refined"), "case");
    folder.write("one.csv", "x,y,z,radius,vx,vy,vz\n0.5,0.5,0.5,0.25,1,0,0\n");
    folder.succeeds("fields --particles one.csv --density 2 --mesh case --fields all --out m.vtu --json m.json");
    let account = json(&folder, "m.json");
    assert!((account["mass_binned"].as_f64().unwrap() / (2.0 * PI / 48.0) - 1.0).abs() < 1e-12);
}

#[test]
fn what_no_field_needs_is_not_said_to_be_zero() {
    let folder = mercury();
    let run = folder.succeeds(&format!("{MERCURY} --fields density --out d.vti --json d.json"));
    assert!(!run.stdout.contains("momentum binned") && !run.stdout.contains("Σ σ V"), "{}", run.stdout);
    let account = json(&folder, "d.json");
    assert!(account["momentum_binned"].is_null() && account["stress_sum_fields"].is_null());
    assert_eq!(numbers(&account["stress_sum_contacts"])[0], 2.0);
    for how in ["lz4", "raw", "text"] {
        folder.succeeds(&format!("{MERCURY} --fields density --encoding {how} --out {how}.vti"));
        assert_eq!(column(&folder, "d.vti", "density"), column(&folder, &format!("{how}.vti"), "density"), "{how}");
    }
}

#[test]
fn gravity_species_and_displacements_are_at_hand() {
    let folder = mercury();
    let run = folder.succeeds(&format!("{MERCURY} --gravity 0,0,-2 --out g.vti"));
    mentions(&run.stdout, &["weight               (0, 0, -6.283185)"]);
    let density = column(&folder, "g.vti", "density");
    let body = column(&folder, "g.vti", "body_force_density");
    assert_eq!(body[2], -2.0 * density[0]);
    folder.succeeds(&format!("{MERCURY} --fields displacement,density --out d.vti"));
    assert!(apart(&column(&folder, "d.vti", "displacement"), &[0.0; 6]) < 1e-15);
    let message = folder.fails(&format!("{MERCURY} --frames -1 --fields displacement --out d2.vti"));
    mentions(&message, &["no frame"]);
    folder.succeeds(&format!("{MERCURY} --species 0 --out s.vti"));
    assert_eq!(column(&folder, "s.vti", "density"), density);
    let message = folder.fails(&format!("{MERCURY} --species 7 --out none.vti"));
    mentions(&message, &["box.data: no particle is of type 7; the types are 0"]);
}

/// Three cells along x, the two balls of different types; what crosses the faces is known in closed form.
const SPECIES: &str =
    "fields --particles species.data --contacts box.fstat --density 3 --grid 0,2,0,1,0,1 --cells 3,1,1";

fn two_species() -> Folder {
    let folder = mercury();
    let text = std::fs::read_to_string(folder.path("box.data")).unwrap();
    let second = |line: &str| {
        if line.starts_with("1.5") { format!("{} 1", line.strip_suffix(" 0").unwrap()) } else { line.into() }
    };
    folder.write("species.data", text.lines().map(|line| second(line) + "\n").collect::<String>());
    folder
}

#[test]
fn what_crosses_the_faces_closes_the_balance_of_every_cell_from_the_file_alone() {
    let folder = two_species();
    folder.succeeds(&format!("{SPECIES} --frames 0 --face-fields faces.vtp --out o.vti --json o.json"));
    assert_eq!(json(&folder, "o.json")["balance_residual"], 0.0);
    let faces = |file: &str, name: &str| column(&folder, file, name);
    let force = faces("faces.vtp", "contact_force");
    let (back, front) = (faces("faces.vtp", "back_cell"), faces("faces.vtp", "front_cell"));
    // 4 faces along x, 6 along y and z each.
    assert_eq!((back.len(), force.len()), (16, 48));
    // Ball 0 is pushed by 2 from ball 1 and by 5 from the floor, which it touches in cell 0; ball 1 is in cell 2.
    for (cell, forces, walls) in [(0, [-2.0, 0.0, 5.0], 5.0), (1, [0.0; 3], 0.0), (2, [2.0, 0.0, 0.0], 0.0)] {
        for k in 0..3 {
            let out = |face: usize| {
                f64::from(u8::from(back[face] == cell as f64)) - f64::from(u8::from(front[face] == cell as f64))
            };
            let left: f64 = (0..16).map(|face| out(face) * force[3 * face + k]).sum();
            let wall = if k == 2 { walls } else { 0.0 };
            assert_eq!(forces[k], wall - left, "cell {cell}, component {k}");
        }
    }
    // The ball of radius 1/2 that moves with 1 is cut at a distance of 1/6 from its centre.
    let disc = PI * (0.25 - 1.0 / 36.0);
    let flux = faces("faces.vtp", "solid_flux");
    assert!((flux[1] - disc).abs() < 1e-15 && flux[2].abs() < 1e-15, "{flux:?}");
    // Force over area, and the area from the file.
    let (traction, vector) = (faces("faces.vtp", "contact_traction"), faces("faces.vtp", "face_vector"));
    assert_eq!((traction[3], vector[3]), (2.0, 1.0));
    let polygons = vtk::read_vtk(&folder.path("faces.vtp")).unwrap();
    assert!(polygons.cells.types().iter().all(|kind| *kind == 9), "{:?}", polygons.cells.types());

    // The mean over both frames, in the second of which the ball moves with 3; and one file for each.
    folder.succeeds(&format!("{SPECIES} --average --face-fields faces.vtp --out o.vti"));
    assert!((faces("faces.vtp", "solid_flux")[1] - 2.0 * disc).abs() < 1e-15);
    folder.succeeds(&format!("{SPECIES} --face-fields faces.pvd --out o.pvd"));
    assert_eq!(vtk::read_pvd(&folder.path("faces.pvd")).unwrap().len(), 2);
    assert!((faces("faces_1.vtp", "solid_flux")[1] - 3.0 * disc).abs() < 1e-15);
}

#[test]
fn the_solid_flux_of_a_mesh_is_the_rate_at_which_its_cells_fill() {
    let folder = Folder::new();
    folder.copy(&fieldstone_testing::data("openfoam/refined"), "case");
    let (v, h) = ([0.3, -0.7, 0.2], 1e-6);
    for (name, t) in [("before", -0.5 * h), ("now", 0.0), ("after", 0.5 * h)] {
        let at = [0.45, 0.52, 0.5].iter().zip(v).map(|(x, v): (&f64, f64)| (x + t * v).to_string());
        let row = at.collect::<Vec<_>>().join(",");
        folder.write(&format!("{name}.csv"), format!("x,y,z,radius,vx,vy,vz\n{row},0.25,{},{},{}\n", v[0], v[1], v[2]));
        folder.succeeds(&format!(
            "fields --particles {name}.csv --density 1 --mesh case --fields volume_fraction --face-fields {name}.vtp \
             --out {name}.vtu"
        ));
    }
    let [before, after] = ["before.vtu", "after.vtu"].map(|file| column(&folder, file, "volume_fraction"));
    let volumes = column(&folder, "now.vtu", "cell_volume");
    let mut rates = vec![0.0; volumes.len()];
    let [flux, back, front] = ["solid_flux", "back_cell", "front_cell"].map(|name| column(&folder, "now.vtp", name));
    for (face, q) in flux.iter().enumerate() {
        for (side, sign) in [(&back, -1.0), (&front, 1.0)] {
            if side[face] >= 0.0 {
                rates[side[face] as usize] += sign * q;
            }
        }
    }
    let mut moving = 0;
    for (cell, rate) in rates.iter().enumerate() {
        let difference = (after[cell] - before[cell]) * volumes[cell] / h;
        // The difference has lost ten digits.
        assert!((rate - difference).abs() < 1e-8, "cell {cell}: {rate} {difference}");
        moving += usize::from(rate.abs() > 1e-3);
    }
    assert!(moving > 3);
}

#[test]
fn fields_of_the_species_add_up_to_those_of_all() {
    let folder = two_species();
    let fields =
        "--frames 0 --fields standard,velocity,contact_force_density --quantity speed=velocity:sum --gravity 0,0,-2";
    folder.succeeds(&format!("{SPECIES} {fields} --per-species --out all.vti"));
    for name in [
        "volume_fraction",
        "density",
        "momentum",
        "momentum_flux",
        "contact_stress",
        "contact_force_density",
        "particle_size",
        "speed",
        "body_force_density",
    ] {
        let [all, a, b] = ["", "_species_0", "_species_1"].map(|of| column(&folder, "all.vti", &format!("{name}{of}")));
        let sum: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + b).collect();
        let scale = all.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!(apart(&all, &sum) <= 1e-15 * scale, "{name}: {all:?} {sum:?}");
        assert!(a.iter().chain(&b).any(|x| *x != 0.0), "{name}");
    }
    // What the two exert on each other cancels in the sum over cells; the floor's 5 is left.
    let total = |name: &str| -> f64 {
        let volumes = column(&folder, "all.vti", "cell_volume");
        column(&folder, "all.vti", name).as_chunks::<3>().0.iter().zip(volumes).map(|(f, v)| f[0] * v).sum()
    };
    let [a, b] = [0, 1].map(|of| total(&format!("boundary_force_density_species_{of}")));
    assert!((a + 2.0).abs() < 1e-14 && (b - 2.0).abs() < 1e-14, "{a} {b}");
    // Each is what a run of its own gives.
    folder.succeeds(&format!("{SPECIES} {fields} --species 1 --out one.vti"));
    for name in ["density", "velocity", "contact_stress", "boundary_force_density"] {
        assert_eq!(
            column(&folder, "one.vti", name),
            column(&folder, "all.vti", &format!("{name}_species_1")),
            "{name}"
        );
    }
    // Only one of them, and as a table of MercuryCG's.
    folder.succeeds(&format!("{SPECIES} --fields density --species 1 --per-species --out s.stat"));
    let text = std::fs::read_to_string(folder.path("s.stat")).unwrap();
    mentions(&text, &["time x y z 5:Density 6:DensitySpecies1"]);
    let message = folder.fails("fields --particles box.data --radius 1 --density 1 --cells 1 --species 7 --per-species --face-fields f.vtk --out o.vti");
    mentions(&message, &["--face-fields f.vtk", ".vtp"]);
    folder.write("plain.csv", "x,y,z,radius\n0,0,0,1\n");
    let message = folder.fails("fields --particles plain.csv --density 1 --cells 1 --per-species --out o.vti");
    mentions(&message, &["plain.csv", "no types"]);
}

#[test]
fn particles_take_from_fields_what_cells_give() {
    let folder = two_species();
    folder.succeeds(&format!("{SPECIES} --frames 0 --to-particles back.vtp --out o.vti"));
    let volume = PI / 6.0;
    let (fraction, volumes) = (column(&folder, "o.vti", "volume_fraction"), column(&folder, "o.vti", "cell_volume"));
    for (name, width) in [("density", 1), ("momentum", 3), ("contact_stress", 9)] {
        let (field, back) = (column(&folder, "o.vti", name), column(&folder, "back.vtp", &format!("field_{name}")));
        assert_eq!(back.len(), 2 * width);
        for k in 0..width {
            let given: f64 = (0..3).map(|cell| volumes[cell] * fraction[cell] * field[width * cell + k]).sum();
            let taken: f64 = (0..2).map(|i| volume * back[width * i + k]).sum();
            assert!((given - taken).abs() <= 1e-14 * given.abs().max(1.0), "{name} {k}: {given} {taken}");
        }
    }
    // The particles' own columns are still there.
    assert_eq!(column(&folder, "back.vtp", "velocity")[0], 1.0);
    // A constant comes back as that constant, and times the part of the particle that is in the cells.
    let one = SPECIES.replace("--grid 0,2,0,1,0,1 --cells 3,1,1", "--grid 0,1.5,0,1,0,1 --cells 1");
    folder.succeeds(&format!("{one} --frames 0 --to-particles back.csv --out one.vti"));
    let table = CsvTable::read(&folder.path("back.csv")).unwrap();
    let inside = table.column("fraction_in_cells").unwrap();
    assert!((inside[0] - 1.0).abs() < 1e-15 && (inside[1] - 0.5).abs() < 1e-15, "{inside:?}");
    let density = column(&folder, "one.vti", "density")[0];
    for (found, part) in table.column("field_density").unwrap().iter().zip([1.0, 0.5]) {
        assert!((found - part * density).abs() < 1e-14 * density);
    }
    folder.succeeds(&format!("{SPECIES} --to-particles back.pvd --out o.pvd"));
    assert_eq!(vtk::read_pvd(&folder.path("back.pvd")).unwrap().len(), 2);
    for (options, reason) in [
        ("--to-particles b.vti --frames 0 --out x.vti", "ends in .vtp or .csv"),
        ("--to-particles b.vtp --out x.pvd", "ends in .pvd, since there is a result for each frame"),
        ("--to-particles b.vtp --average --out x.vti", "leave out --average"),
        ("--to-particles b.vtp --function lucy --width 1 --out x.vti", "--function exact"),
        ("--to-particles x.vti --frames 0 --out x.vti", "overwrite another file"),
    ] {
        mentions(&folder.fails(&format!("{SPECIES} {options}")), &[reason]);
    }
    let round = "fields --particles species.data --density 3 --coordinates RZ --cells 2,2";
    mentions(&folder.fails(&format!("{round} --face-fields f.vtp --out r.csv")), &["cylindrical"]);
}

#[test]
fn lammps_contacts_come_from_columns_or_presets() {
    let folder = grains();
    let particles = "fields --particles lammps.dump --cells 4 --fields contact_stress,boundary_force_density";
    let walls = "--contacts lammps.dump --contacts-preset lammps-wall";
    folder.succeeds(&format!(
        "{particles} --contacts lammps_pair.dump --contacts-preset lammps-pair {walls} --out a.vti"
    ));
    folder.succeeds(&format!(
        "{particles} --contacts lammps_pair.dump \
         --contacts-columns id1=c_pl[1],id2=c_pl[2],normal=c_fl[3..5],tangential=c_fl[6..8] {walls} --out b.vti"
    ));
    let stress = column(&folder, "a.vti", "contact_stress");
    assert!(size(&stress) > 0.0 && size(&column(&folder, "a.vti", "boundary_force_density")) > 0.0);
    assert_eq!(stress, column(&folder, "b.vti", "contact_stress"));
    for wrong in ["--contacts-preset lammps-pair --contacts lammps_pair.dump", "--contacts a --contacts-preset nobody"]
    {
        assert_eq!(folder.fieldstone(&format!("{particles} {wrong} --out c.vti")).code, Some(2), "{wrong}");
    }
}

#[test]
fn the_account_on_the_terminal_reads_well() {
    let folder = grains();
    let run = folder.succeeds(&format!("{GRAINS} --cells 6,5,10 --out out.vti"));
    let kernel = folder.succeeds(&format!("{GRAINS} --cells 6,5,10 --function gauss --width 0.002 --out out.stat"));
    let text = format!("{}{}\n{}{}", run.stdout, run.stderr, kernel.stdout, kernel.stderr);
    // The residual is rounding, and the time is the machine's.
    let steady = |line: &str| match line.split_whitespace().next() {
        Some("seconds") => "seconds              …".to_string(),
        Some("balance") => "balance residual     …  (worst cell, over the largest contact force)".to_string(),
        _ => line.to_string(),
    };
    insta::assert_snapshot!("fields_account", text.lines().map(steady).collect::<Vec<_>>().join("\n"));
    insta::assert_snapshot!("help_fields", folder.succeeds("fields --help").stdout);
    insta::assert_snapshot!("help_plot", folder.succeeds("plot --help").stdout);
}

#[test]
fn in_cells_of_several_periods_a_particle_gets_the_mean_over_its_images() {
    let folder = Folder::new();
    folder.write(
        "one.dump",
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp ff ff\n0 1\n0 1\n0 1\n\
         ITEM: ATOMS id x y z radius mass\n1 .5 .5 .5 .25 3\n",
    );
    let fields = "fields --particles one.dump --grid 0,2,0,1,0,1 --cells 1 --fields density --out o.vti";
    let run = folder.succeeds(&format!("{fields} --periodic x --to-particles back.csv"));
    mentions(&run.stdout, &["counted twice        3  (100.0000 %, in cells that overlap each other or repeat the"]);
    assert!(!run.stdout.contains("clipped"), "{}", run.stdout);
    // Two images of mass 3 in a volume of 2.
    assert!((column(&folder, "o.vti", "density")[0] - 3.0).abs() < 1e-13);
    let back = CsvTable::read(&folder.path("back.csv")).unwrap();
    assert!((back.column("field_density").unwrap()[0] - 3.0).abs() < 1e-13);
    assert!((back.column("fraction_in_cells").unwrap()[0] - 2.0).abs() < 1e-13);
}

#[test]
fn the_default_grid_of_a_tilted_periodic_box_holds_everything_once() {
    let folder = Folder::new();
    // Tilts xy 0.3, xz 0.1, yz 0.2: the bounds that dumps state are those around the tilted box.
    let bounds = "ITEM: BOX BOUNDS xy xz yz pp pp pp\n0 1.4 0.3\n0 1.2 0.1\n0 1 0.2\n";
    let balls = "1 0.5 0.5 0.5 0.1 1 0 0 0\n2 1.2 0.9 0.6 0.1 2 0 0 0\n3 0.15 1.1 0.95 0.1 4 0 0 0\n";
    let head = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n3\n";
    folder.write("tilted.dump", format!("{head}{bounds}ITEM: ATOMS id x y z radius mass vx vy vz\n{balls}"));
    let fields = "fields --particles tilted.dump --cells 4 --fields density --out out.vti";
    let run = folder.succeeds(fields);
    mentions(&run.stdout, &["mass binned          7  (100.0000 %)"]);
    assert_eq!(run.stderr, "");
    folder.succeeds("fraction --particles tilted.dump --grid 0,1,0,1,0,1 --cells 2,2,2 --out a.vti");
    assert!((column(&folder, "a.vti", "particle_count").iter().sum::<f64>() - 3.0).abs() < 1e-15);
    let volume: f64 = column(&folder, "a.vti", "solid_volume").iter().sum();
    assert!((volume / (3.0 * 4.0 / 3.0 * PI * 0.001) - 1.0).abs() < 1e-12, "{volume}");

    // Cells around the whole box are too wide, and the warning says along what, and what to do.
    let run = folder.succeeds(&format!("{fields} --grid 0,1.4,0,1.2,0,1"));
    let remedy = "one period (0 to 1 along x, 0 to 1 along y), or --periodic xyz";
    mentions(&run.stderr, &["the box is periodic along xyz, but the cells are wider than it along xy", remedy]);
    // Without images the box as it is, tilted, holds all centres.
    let run = folder.succeeds(&format!("{fields} --periodic none"));
    let found = vtk::read_vtk(&folder.path("out.vti")).unwrap();
    assert!(found.image.unwrap().spacing.iter().zip([0.35, 0.3, 0.25]).all(|(a, b)| (a - b).abs() < 1e-12));
    assert!(!run.stdout.contains("(100.0000 %)"));
}

#[test]
fn a_quantity_of_a_vector_has_the_names_of_its_axes_in_the_file_and_in_plots() {
    let folder = Folder::new();
    folder.write("b.csv", "x,y,z,radius,mass,vx,vy,vz\n0.5,0.5,0.5,0.25,2,1,2,3\n0.5,0.5,1.5,0.25,2,1,2,3\n");
    let fields = "fields --particles b.csv --grid 0,1,0,1,0,2 --cells 1,1,2 --fields density --out o.csv";
    folder.succeeds(&format!("{fields} --quantity ke=velocity:mass-mean"));
    let table = CsvTable::read(&folder.path("o.csv")).unwrap();
    for (name, value) in [("ke_x", 1.0), ("ke_y", 2.0), ("ke_z", 3.0)] {
        assert_eq!(table.column(name).unwrap(), [value, value], "{name}");
    }
    folder.succeeds(&format!("{fields} --quantity ke=velocity:mass-mean --quantity s=velocity,velocity:mass-mean"));
    assert_eq!(CsvTable::read(&folder.path("o.csv")).unwrap().column("s_4").unwrap(), [2.0, 2.0]);
    for (options, name) in [
        ("--field ke --component z", "ke z"),
        ("--field ke_z", "ke z, mean by volume"),
        ("--field s --component 4", "s 4"),
    ] {
        folder.succeeds(&format!("plot o.csv {options} --profile z --out p.svg"));
        mentions(&std::fs::read_to_string(folder.path("p.svg")).unwrap(), &[name]);
    }
}

#[test]
fn contacts_through_the_boundary_are_right_where_only_their_own_dump_states_the_box() {
    let folder = grains();
    let particles = read_frame(&folder.path("part.dump"), &ParticleOptions::default(), 0).unwrap();
    write_particles_csv(&folder.path("part.csv"), &particles).unwrap();
    let cells = "--grid 0,0.04,0,0.04,-0.005,0.12 --cells 2 --out o.vti --json";
    let bare = GRAINS.replace("part.dump", "part.csv");
    let sums = |line: &str, file: &str| {
        let run = folder.succeeds(&format!("{line} {cells} {file}"));
        let account = json(&folder, file);
        let [a, b] = ["stress_sum_contacts", "stress_sum_fields"].map(|key| numbers(&account[key]));
        // Branches across the whole box leave the cells, where it is open.
        assert!(line.contains("none") || apart(&a, &b) <= 1e-12 * size(&a), "{a:?} {b:?}");
        (a, run.stderr)
    };
    let (expected, _) = sums(GRAINS, "dump.json");
    let (found, told) = sums(&bare, "csv.json");
    assert!(apart(&expected, &found) <= 1e-12 * size(&expected), "{expected:?} {found:?}");
    mentions(&told, &["part.csv states no box", "its contacts in pair.dump is taken (periodic directions: xy)"]);
    // The box may be given; a wrong one makes branches across all of it.
    let (found, told) = sums(&format!("{bare} --box 0,0.04,0,0.04,-0.005,0.12 --periodic xy"), "given.json");
    assert!(apart(&expected, &found) <= 1e-12 * size(&expected) && !told.contains("states no box"), "{told}");
    let (open, _) = sums(&format!("{bare} --box 0,0.04,0,0.04,-0.005,0.12 --periodic none"), "open.json");
    assert!(apart(&expected, &open) > 0.1 * size(&expected), "{open:?}");
    for (options, reason) in [
        ("--box 0,1,0,1,0,1", "--box: say along which axes the box is periodic, as in --periodic xy"),
        ("--box 0,1,0,1 --periodic x", "--box"),
        ("--box 0,1,0,1,1,0 --periodic x", "--box: the box runs from 1 to 0 along z"),
    ] {
        mentions(&folder.fails(&format!("{bare} {options} --cells 2 --out o.vti")), &[reason]);
    }
    folder.write("a.csv", "x,y,z,radius\n0,0,0,1\n");
    let line = "fields --particles a.csv --density 1 --cells 2 --grid 0,1,0,1,0,1 --periodic x --out o.vti";
    mentions(&folder.fails(line), &["a.csv, frame 0: the files state no box; give it with --box"]);
}

/// The columns of a `.vti` or `.vtp` written as text: names of components, and the first row.
fn first_row(folder: &Folder, file: &str, name: &str) -> Vec<(String, f64)> {
    let text = std::fs::read_to_string(folder.path(file)).unwrap();
    let element = text.split("<DataArray ").find(|part| part.contains(&format!("Name=\"{name}\""))).unwrap();
    let names = element.split("ComponentName").skip(1).map(|part| part.split('"').nth(1).unwrap().to_string());
    let numbers = element.split_once('>').unwrap().1.split_ascii_whitespace().map(|word| word.parse().unwrap());
    names.zip(numbers).collect()
}

#[test]
fn symmetric_tensors_are_in_the_order_of_vtk_in_its_files_and_are_read_back_by_name() {
    let folder = two_species();
    let line = format!("{SPECIES} --frames 0 --fields momentum_flux,density --stress-form branch-in-cell");
    folder.succeeds(&format!("{line} --encoding text --to-particles back.vtp --out o.vti"));
    folder.succeeds(&format!("{line} --to-particles back.csv --out o.csv"));
    let (cells, back) =
        (CsvTable::read(&folder.path("o.csv")).unwrap(), CsvTable::read(&folder.path("back.csv")).unwrap());
    for (file, name, table) in [("o.vti", "momentum_flux", &cells), ("back.vtp", "field_momentum_flux", &back)] {
        let row = first_row(&folder, file, name);
        let names: Vec<&str> = row.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["xx", "yy", "zz", "xy", "yz", "xz"], "{file}");
        for (k, component) in ["xx", "xy", "xz", "yy", "yz", "zz"].iter().enumerate() {
            let expected = table.column(&format!("{name}_{component}")).unwrap()[0];
            assert!(row.contains(&((*component).into(), expected)), "{file} {component} {expected}: {row:?}");
            assert_eq!(column(&folder, file, name)[k], expected, "{file} {component}");
        }
    }
    // The momentum flux of what moves along x has one component only, so places that are mixed up show.
    assert!(first_row(&folder, "o.vti", "momentum_flux")[0].1 > 0.0);
}

#[test]
fn texts_in_vtk_files_are_ascii_whatever_the_formulas_and_names_of_files() {
    let folder = mercury();
    folder.write("größe.data", std::fs::read_to_string(folder.path("box.data")).unwrap());
    let line = MERCURY.replace("box.data", "größe.data");
    folder.succeeds(&format!("{line} --fields all --encoding text --face-fields faces.vtp --out o.vti"));
    for file in ["o.vti", "faces.vtp"] {
        let text = std::fs::read_to_string(folder.path(file)).unwrap();
        let codes = text.split("Name=\"fieldstone\"").nth(1).unwrap();
        let codes = codes.split_once('>').unwrap().1.split('<').next().unwrap();
        let bytes: Vec<u8> = codes.split_ascii_whitespace().map(|code| code.parse().unwrap()).collect();
        assert!(bytes.is_ascii(), "{file}");
        let echo = String::from_utf8(bytes).unwrap();
        mentions(&echo, &["gr\\u00f6\\u00dfe.data", "# density: rho = sum m phi, in mass/length^3"]);
        // Still settings that can be run.
        folder.write("echo.toml", echo);
        folder.succeeds("fields echo.toml --out again.vti");
    }
}
