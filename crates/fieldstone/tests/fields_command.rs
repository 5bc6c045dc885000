//! `fieldstone fields` and `fieldstone plot` as users run them, on small cases that come with the tests.

#![allow(clippy::unwrap_used)]

mod support;

use std::f64::consts::PI;
use std::io::Write;
use std::path::Path;

use fieldstone::io::{CsvTable, read_stat, vtk};
use support::Folder;

/// Five grains of a chute flow with all contacts among them and with the floor; periodic in x and y.
fn grains() -> Folder {
    let folder = Folder::new();
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fieldstone-io/tests/fixtures/contacts");
    for (from, to) in [
        ("liggghts_part.dump", "part.dump"),
        ("liggghts_pair.dump", "pair.dump"),
        ("liggghts_wall.dump", "wall.dump"),
        ("lammps_part.dump", "lammps.dump"),
        ("lammps_pair.dump", "lammps_pair.dump"),
    ] {
        folder.copy(&fixtures.join(from), to);
    }
    folder
}

const GRAINS: &str = "fields --particles part.dump --contacts pair.dump --contacts-preset liggghts-pair \
                      --contacts wall.dump --contacts-preset liggghts-wall";

/// Two balls of radius 1/2 pressed together in a MercuryDPM box of two frames, one of them on the floor.
fn mercury() -> Folder {
    let folder = Folder::new();
    let frame = |t: f64, v: f64| {
        format!("2 {t} 0 0 0 2 1 1\n0.5 0.5 0.5 {v} 0 0 0.5 0 0 0 0 0 0 0\n1.5 0.5 0.5 0 0 {v} 0.5 0 0 0 0 0 0 0\n")
    };
    folder.write("box.data", frame(0.0, 1.0) + &frame(1.0, 3.0));
    let contacts = |t: f64| {
        format!(
            "# {t} 1\n# 0 0 0 2 1 1\n# 0.5 0.5 0 0 0 0\n{t} 0 1 1 0.5 0.5 0 0 2 0 -1 0 0 0 0 0\n{t} 1 0 1 0.5 0.5 0 0 2 0 1 0 0 0 0 0\n\
             {t} 0 -1 0.5 0.5 0 0 0 5 0 0 0 -1 0 0 0\n"
        )
    };
    folder.write("box.fstat", contacts(0.0) + &contacts(1.0));
    folder.write(
        "box.restart",
        "MercuryDPM 1.0 name box\nxMin 0 xMax 2 yMin 0 yMax 1 zMin 0 zMax 1\ntimeStep 0.5 time 1 ntimeSteps 2 timeMax 1\n\
         systemDimensions 3 particleDimensions 3 gravity 0 0 -1\nSpecies 1\nLinearViscoelasticSpecies id 0 density 3 \
         stiffness 1\nWalls 0\nBoundaries 0\nParticles 0\nInteractions 0\n",
    );
    folder
}

const MERCURY: &str = "fields --particles box.data --contacts box.fstat --restart box.restart --cells 2,1,1";

fn json(folder: &Folder, file: &str) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(folder.path(file)).unwrap()).unwrap()
}

fn column(folder: &Folder, file: &str, name: &str) -> Vec<f64> {
    vtk::read_vtk(&folder.path(file)).unwrap().array(name).unwrap().values.to_f64()
}

fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn size(a: &[f64]) -> f64 {
    a.iter().map(|x| x.abs()).fold(0.0, f64::max)
}

#[track_caller]
fn mentions(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
}

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
fn series_become_one_file_per_frame_a_mean_or_a_smoothed_mean() {
    let folder = mercury();
    let momentum = |file: &str| column(&folder, file, "momentum")[0];
    let m = 3.0 * PI / 6.0;
    let near = |a: f64, b: f64| (a - b).abs() < 1e-13;
    folder.succeeds(&format!("{MERCURY} --out all.pvd --json all.json"));
    let steps = vtk::read_pvd(&folder.path("all.pvd")).unwrap();
    assert_eq!(steps, [(0.0, folder.path("all_0.vti")), (1.0, folder.path("all_1.vti"))]);
    assert!(near(momentum("all_0.vti"), m) && near(momentum("all_1.vti"), 3.0 * m));
    assert_eq!(vtk::read_vtk(&folder.path("all_1.vti")).unwrap().time, Some(1.0));
    assert_eq!(json(&folder, "all.json")["frames"], 2);
    folder.succeeds(&format!("{MERCURY} --average --out mean.vti"));
    assert!(near(momentum("mean.vti"), 2.0 * m));
    // Around the first frame the second, one width away, counts e^(−1/2).
    folder.succeeds(&format!("{MERCURY} --smooth 1 --out smooth.pvd"));
    let w = (-0.5f64).exp();
    assert!(near(momentum("smooth_0.vti"), (1.0 + 3.0 * w) / (1.0 + w) * m));
    // Around the middle both count the same.
    folder.succeeds(&format!("{MERCURY} --smooth 1 --out middle.vti"));
    assert!(near(momentum("middle.vti"), 2.0 * m));
    folder.succeeds(&format!("{MERCURY} --frames 0 --out first.vti"));
    assert!(near(momentum("first.vti"), m));
    // Temperature about the window's mean or each frame's: u is 1 and 3, so the variance is 1, a third of it in T.
    for (which, expected) in [("window", 1.0 / 3.0), ("frame", 0.0)] {
        folder.succeeds(&format!(
            "{MERCURY} --average --fields granular_temperature --mean-velocity {which} --out t.vti"
        ));
        assert!(near(column(&folder, "t.vti", "granular_temperature")[0], expected));
    }
    let message = folder.fails(&format!("{MERCURY} --frames : --out two.vti"));
    mentions(&message, &["two.vti: the frames give several results", ".pvd or .stat", "--average"]);
    let message = folder.fails(&format!("{MERCURY} --frames 5: --out two.pvd"));
    mentions(&message, &["box.data: none of the 2 frames, 0 to 1, is in the range 5:; check --frames"]);
    for (range, reason) in [("5", "range 5;"), ("-3", "range -3;"), ("1:0", "range 1:0, which ends before it begins;")]
    {
        let message = folder.fails(&format!("{MERCURY} --frames={range} --out two.pvd"));
        mentions(&message, &["box.data: none of the 2 frames, 0 to 1, is in the", reason]);
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
    let echo: Vec<&str> =
        text.lines().filter_map(|line| line.strip_prefix("# ")).take_while(|l| !l.starts_with("time")).collect();
    mentions(
        &text,
        &["# fieldstone ", "# sign = \"tension\"", "# function = \"exact\"", "# density: ρ = Σ m φ, in mass"],
    );
    folder.write("again.toml", echo.join("\n"));
    folder.succeeds("fields again.toml --out again.csv");
    let rows = |text: &str| text.lines().filter(|l| !l.starts_with('#')).map(String::from).collect::<Vec<_>>();
    assert_eq!(rows(&std::fs::read_to_string(folder.path("again.csv")).unwrap()), rows(&text));
    // In a .vti they are field data, which our reader passes over.
    folder.succeeds("fields run.toml --out a.vti");
    assert_eq!(vtk::read_vtk(&folder.path("a.vti")).unwrap().skipped, ["fieldstone"]);

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
        ("cells = \"2\"", "expected a number or a list of numbers"),
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
fn frames_computed_at_the_same_time_are_those_of_one_after_the_other() {
    let folder = mercury();
    // Seven frames: more than threads, and no multiple of them.
    let (mut data, mut contacts) = (String::new(), String::new());
    for frame in 0..7 {
        let x = 0.4 + 0.03 * f64::from(frame);
        data += &format!(
            "2 {frame} 0 0 0 2 1 1\n{x} 0.5 0.5 {frame} 0 0 0.5 0 0 0 0 0 0 0\n1.5 0.5 0.5 0 0 1 0.5 0 0 0 0 0 0 0\n"
        );
        contacts += &format!(
            "# {frame} 1\n# 0 0 0 2 1 1\n# 0.5 0.5 0 0 0 0\n{frame} 0 -1 {x} 0.5 0 0 0 {frame} 0 0 0 -1 0 0 0\n"
        );
    }
    folder.write("many.data", data);
    folder.write("many.fstat", contacts);
    let run = |threads: &str, out: &str| {
        let line = format!(
            "fields --particles many.data --contacts many.fstat --density 2 --cells 6 --face-fields faces_{out} --to-particles \
             back_{out} --out {out}"
        );
        let status = std::process::Command::new(env!("CARGO_BIN_EXE_fieldstone"))
            .args(line.split_whitespace())
            .current_dir(folder.path(""))
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap();
        assert!(status.status.success(), "{}", String::from_utf8_lossy(&status.stderr));
        let steps = vtk::read_pvd(&folder.path(out)).unwrap();
        steps
            .into_iter()
            .map(|(time, path)| (time, column(&folder, path.file_name().unwrap().to_str().unwrap(), "density")))
            .collect::<Vec<_>>()
    };
    let one = run("1", "one.pvd");
    assert_eq!(one.len(), 7);
    assert_eq!(run("4", "four.pvd"), one);
    for frame in 0..7 {
        // Each by itself, but for the settings that the file repeats.
        folder.succeeds(&format!(
            "fields --particles many.data --contacts many.fstat --density 2 --cells 6 --frames {frame} --out alone.vti"
        ));
        for name in ["density", "contact_stress"] {
            let alone = column(&folder, "alone.vti", name);
            assert_eq!(column(&folder, &format!("four_{frame}.vti"), name), alone, "{name} of frame {frame}");
        }
        let same = |name: &str| [format!("{name}_one_{frame}.vtp"), format!("{name}_four_{frame}.vtp")];
        for [a, b] in [same("faces"), same("back")] {
            assert_eq!(
                vtk::read_vtk(&folder.path(&a)).unwrap().cell_data,
                vtk::read_vtk(&folder.path(&b)).unwrap().cell_data
            );
        }
    }
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
fn wrong_input_is_named_with_its_place_and_a_remedy() {
    let folder = grains();
    let edit = |file: &str, from: &str, to: &str| {
        let text = std::fs::read_to_string(folder.path(file)).unwrap();
        assert!(text.contains(from), "{file}: {from}");
        folder.write(&format!("bad_{file}"), text.replacen(from, to, 1));
    };
    let mut all = String::new();
    let mut show = |line: String| {
        let message = folder.fails(&line);
        all.push_str(&format!("$ fieldstone {line}\n{message}\n"));
    };
    edit("pair.dump", " 9922 ", " 4711 ");
    let bad = GRAINS.replace("pair.dump", "bad_pair.dump");
    show(format!("{bad} --cells 2 --out out.vti"));
    edit("pair.dump", "\n26001\n", "\n26002\n");
    show(format!("{bad} --cells 2 --out out.vti"));
    folder.write("balls.csv", "x,y,z,radius,vx,vy,vz,s1,s2\n0,0,0,1,0,0,0,1,2\n");
    show("fields --particles balls.csv --cells 2 --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --quantity s=s1,s2 --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --quantity s=s3 --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --fields contact_stress --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --fields speed --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --function lucy --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --width 1 --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --grid 0,0,0,1,1,1 --out out.vti".into());
    show("fields --particles balls.csv --density 1 --out out.vti".into());
    show("fields --particles balls.csv --density 1 --cells 2,2 --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --coordinates RZ --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --out out.vtu".into());
    show("fields --particles balls.csv --cells 2 --density 1 --periodic x --out out.vti".into());
    show("fields --particles balls.csv --cells 2 --density 1 --out balls.csv".into());
    show("fields --particles balls.csv --cells 2 --mass-column weight --out out.vti".into());
    show("fields --cells 2 --out out.vti".into());
    insta::assert_snapshot!("fields_messages", all);

    let folder = mercury();
    let text = std::fs::read_to_string(folder.path("box.fstat")).unwrap();
    let second = text.rfind("# 1 1").unwrap();
    folder.write("box.fstat", &text[..second]);
    mentions(
        &folder.fails(&format!("{MERCURY} --out out.stat")),
        &["box.fstat: there are no more contacts for frame 1 of box.data"],
    );
    folder.write("box.fstat", &text);
    mentions(
        &folder.fails("fields --particles box.data --contacts box.fstat --cells 2 --out out.stat"),
        &["box.data, frame 0: the particles have neither a column 'mass' nor 'density'", "--restart"],
    );
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
fn in_cells_of_several_periods_a_particle_gets_the_mean_over_its_images() {
    let folder = Folder::new();
    folder.write(
        "one.dump",
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp ff ff\n0 1\n0 1\n0 1\n\
         ITEM: ATOMS id x y z radius mass\n1 .5 .5 .5 .25 3\n",
    );
    let fields = "fields --particles one.dump --grid 0,2,0,1,0,1 --cells 1 --fields density --out o.vti";
    folder.succeeds(&format!("{fields} --periodic x --to-particles back.csv"));
    // Two images of mass 3 in a volume of 2.
    assert!((column(&folder, "o.vti", "density")[0] - 3.0).abs() < 1e-13);
    let back = CsvTable::read(&folder.path("back.csv")).unwrap();
    assert!((back.column("field_density").unwrap()[0] - 3.0).abs() < 1e-13);
    assert!((back.column("fraction_in_cells").unwrap()[0] - 2.0).abs() < 1e-13);
}

#[test]
fn files_of_a_series_never_take_the_name_of_an_input() {
    let folder = Folder::new();
    let balls = "x,y,z,radius,mass,vx,vy,vz\n0.5,0.5,0.5,0.25,1,0,0,0\n";
    folder.write("balls.csv", balls);
    let cells = "--grid 0,1,0,1,0,1 --cells 2 --fields density";
    folder.succeeds(&format!("fields --particles balls.csv {cells} --to-particles run_1.vtp --out run_7.vti"));
    for (line, input) in [
        ("fields --particles run_1.vtp --to-particles run.pvd --out out.pvd", "run_1.vtp"),
        ("fields --particles run_1.vtp --face-fields run.pvd --out out.pvd", "run_1.vtp"),
        ("fields --particles balls.csv --out run.pvd --json run_3.vti", "run_3.vti"),
    ] {
        let message = folder.fails(&format!("{line} {cells}"));
        mentions(&message, &["run.pvd", "run_NUMBER.vt", &format!("could overwrite {input}"), "choose another name"]);
    }
    // Results of an earlier run are replaced.
    folder.succeeds(&format!("fields --particles balls.csv {cells} --out run.pvd"));
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
fn fields_that_hold_nothing_are_refused_with_what_led_to_them() {
    let folder = Folder::new();
    folder
        .write("balls.csv", "x,y,z,radius,mass,vx,vy,vz,type\n0.3,0.3,0.3,0.1,1,0,0,0,1\n0.7,0.7,0.7,0.2,1,0,0,0,2\n");
    let fields = "fields --particles balls.csv --fields density --out out.vti";
    let unit = "--grid 0,1,0,1,0,1 --cells 4";
    for (line, parts) in [
        (
            "--grid 10,11,0,1,0,1 --cells 4".into(),
            &["balls.csv in the grid: none of the 2 particles", "check units"][..],
        ),
        (format!("{unit} --species 7"), &["--species: balls.csv: no particle is of type 7; the types are 1, 2"]),
        (format!("{unit} --radii 1,0"), &["--radii", "radii from 1 to 0", "the smaller number first"]),
        (format!("{unit} --region 5,0,0,1,0,1"), &["--region", "x of the region from 5 to 0", "smaller number first"]),
        (format!("{unit} --radii 1,2"), &["none of the 2 particles is left by", "radii are 0.1 to 0.2"]),
        (format!("{unit} --region 5,6,0,1,0,1"), &["is left by", "span (0.3, 0.3, 0.3) to (0.7, 0.7, 0.7)"]),
        (
            // The nearest centre of a cell is (0.075² · 3)^½ = 0.13 away.
            format!("{unit} --function gauss --width 1 --cutoff 0.05"),
            &["no cell's centre lies within 0.05 of a particle", "--cutoff, or smaller cells"],
        ),
    ] {
        mentions(&folder.fails(&format!("{fields} {line}")), parts);
    }
    // One of several types may be missing, but not in silence.
    let run = folder.succeeds(&format!("{fields} {unit} --species 1,7"));
    mentions(&run.stderr, &["warning: --species: no particle is of type 7; the types are 1, 2"]);
    // A series in which one frame has nothing in the cells is fine.
    let ball = |x: f64| format!("x,y,z,radius,mass,vx,vy,vz\n{x},0.5,0.5,0.1,1,0,0,0\n");
    folder.write("f_0.csv", ball(0.5));
    folder.write("f_1.csv", ball(9.5));
    folder.succeeds(&format!("fields --particles f_{{}}.csv {unit} --fields density --out out.pvd"));
    mentions(
        &folder.fails(&format!("fields --particles f_{{}}.csv --frames 1 {unit} --fields density --out out.pvd")),
        &["f_0.csv in the grid: none of the 1 particles lies in the mesh"],
    );
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
fn masses_that_cannot_be_are_told_with_file_column_and_value() {
    let folder = Folder::new();
    let fields = |header: &str, row: &str, options: &str| {
        folder.write("b.csv", format!("x,y,z,radius{header}\n0.5,0.5,0.5,0.25{row}\n"));
        folder.fails(&format!("fields --particles b.csv --cells 2 --out o.vti --fields density,velocity {options}"))
    };
    mentions(&fields(",mass", ",nan", ""), &["b.csv, frame 0: particle 0 has mass = NaN"]);
    mentions(&fields(",mass", ",-1", ""), &["b.csv, frame 0: particle 0: the column 'mass' holds -1.0"]);
    mentions(&fields(",w", ",-1", "--mass-column w"), &["--mass-column w: b.csv, frame 0: particle 0 has -1"]);
    mentions(&fields("", "", ""), &["b.csv, frame 0", "(they have: no other columns)"]);
    mentions(&fields(",mass,vx,vy,vz", ",1,nan,0,0", ""), &["b.csv, frame 0: particle 0 has velocity = NaN"]);
}

#[test]
fn an_unknown_mean_of_a_quantity_is_told_with_those_that_there_are() {
    let folder = Folder::new();
    folder.write("b.csv", "x,y,z,radius,mass,s:0\n0.5,0.5,0.5,0.25,2,7\n");
    let fields = "fields --particles b.csv --cells 2 --fields density --out o.vti";
    mentions(
        &folder.fails(&format!("{fields} --quantity m=mass:avg")),
        &["there is no column 'mass:avg'", "if 'avg' is no part", "choose one of sum, mass-mean, volume-mean"],
    );
    // Names of columns may hold a colon themselves.
    folder.succeeds(&format!("{fields} --quantity m=s:0 --quantity n=s:0:mass-mean"));
    assert_eq!(column(&folder, "o.vti", "n")[0], 7.0);
    let message = folder.fails(&format!("{fields} --quantity m=weight"));
    assert!(message.contains("'weight'") && !message.contains("choose one of sum"), "{message}");
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
fn the_last_frame_has_no_displacement_and_is_not_counted() {
    let folder = Folder::new();
    for (number, x) in [(0, 0.4), (1, 0.5), (2, 0.6)] {
        folder.write(&format!("f_{number}.csv"), format!("id,x,y,z,radius,mass\n1,{x},0.5,0.5,0.1,1\n"));
    }
    let fields = "fields --particles f_{}.csv --grid 0,1,0,1,0,1 --cells 1 --fields density,displacement";
    let run = folder.succeeds(&format!("{fields} --out s.pvd --json s.json"));
    mentions(&run.stdout, &["frames               2\n"]);
    mentions(&run.stderr, &["warning: f_2.csv, frame 2: there is no next frame to be displaced to"]);
    mentions(&std::fs::read_to_string(folder.path("s.json")).unwrap(), &["\"frames\": 2"]);
    assert_eq!(vtk::read_pvd(&folder.path("s.pvd")).unwrap().len(), 2);
    // By default one result comes of the last two frames, and nothing is missing.
    let run = folder.succeeds(&format!("{fields} --out s.vti"));
    mentions(&run.stdout, &["frames               1\n"]);
    assert_eq!(run.stderr, "");
    mentions(
        &folder.fails(&format!("{fields} --frames 2 --out t.vti")),
        &["f_2.csv, frame 2: displacements are those to the next frame", "give at least two (--frames)"],
    );
}

#[test]
fn a_mean_around_a_time_without_frames_is_told_with_the_times_and_what_to_do() {
    let folder = Folder::new();
    for number in [9, 10, 100] {
        folder.write(&format!("f_{number}.dump"), frame_at(number));
    }
    let fields = "fields --particles f_{}.dump --cells 1 --density 1 --fields density --out s.csv";
    // The middle of 9 and 100 is 54.5, and 10 is nearest: 44.5 away.
    mentions(
        &folder.fails(&format!("{fields} --smooth 1")),
        &["--smooth 1", "around 54.5", "within three widths", "f_10.dump, frame 1, at 10", "a larger width", ".pvd"],
    );
    folder.succeeds(&format!("{fields} --smooth 15"));
}

/// A dump of one ball at a step.
fn frame_at(step: u32) -> String {
    format!(
        "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n\
         ITEM: ATOMS id x y z radius\n1 .5 .5 .5 .1\n"
    )
}
