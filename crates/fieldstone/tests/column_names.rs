//! Columns by the names that files have for them, parcels, and particles without velocities, on the command line.

#![allow(clippy::unwrap_used)]

mod support;

use fieldstone::io::{CsvTable, vtk};
use support::Folder;

/// A dump of one particle with a stress of six numbers, 11 to 16, and two weights.
fn dump() -> Folder {
    let folder = Folder::new();
    folder.write(
        "one.dump",
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n\
         ITEM: ATOMS id type x y z radius mass vx vy vz c_st[1] c_st[2] c_st[3] c_st[4] c_st[5] c_st[6] c_w[1] c_w[2]\n\
         1 2 .5 .5 .5 .25 3 4 5 6 11 12 13 14 15 16 7 8\n",
    );
    folder
}

/// Two particles without velocities.
fn still() -> Folder {
    let folder = Folder::new();
    folder.write("still.csv", "x,y,z,r,mass,nParticle\n.25,.5,.5,.125,2,1\n.75,.5,.5,.25,3,10\n");
    folder
}

const BOX: &str = "--grid 0,1,0,1,0,1 --cells 1";

/// What a run prints, and what it warns of.
fn told(folder: &Folder, line: &str) -> (String, String) {
    let run = folder.succeeds(line);
    (run.stdout, run.stderr)
}

/// The only row's value of a column.
fn value(folder: &Folder, file: &str, column: &str) -> f64 {
    let table = CsvTable::read(&folder.path(file)).unwrap();
    table.column(column).unwrap()[0]
}

#[test]
fn a_numbered_column_of_a_quantity_is_the_files_column_of_that_name() {
    let folder = dump();
    let run = |quantity: &str| {
        folder.succeeds(&format!(
            "fields --particles one.dump {BOX} --fields density --quantity a={quantity}:sum --out a.csv"
        ));
        value(&folder, "a.csv", "a")
    };
    let names = ["c_st[1]", "c_st[2]", "c_st[6]", "c_w[2]", "vy", "velocity[2]", "type", "Radius", "Mass"];
    let values = [11.0, 12.0, 16.0, 8.0, 5.0, 5.0, 2.0, 0.25, 3.0];
    for (name, wanted) in names.into_iter().zip(values) {
        assert!((run(name) - wanted).abs() < 1e-12 * wanted, "{name}");
    }
    for wrong in ["c_st[0]", "c_st[7]", "velocity[0]"] {
        let message = folder
            .fails(&format!("fields --particles one.dump {BOX} --quantity a={wrong} --out a.csv --fields density"));
        assert!(message.contains(&format!("there is no column '{wrong}'")), "{message}");
        assert!(message.contains("velocity (vx, vy, vz), c_st (c_st[1] … c_st[6]), c_w (c_w[1], c_w[2])"), "{message}");
        assert!(message.contains("id, type, radius"), "{message}");
    }
}

#[test]
fn every_option_finds_a_column_by_the_files_name_in_any_letter_case() {
    let folder = Folder::new();
    let mut rows = String::from("Type,x,y,z,Mass,c_w[1],c_w[2],Vel.x [m/s],Vel.y [m/s],Vel.z [m/s]\n");
    for k in 0..64 {
        let (x, y, z) = (k % 4, k / 4 % 4, k / 16);
        rows += &format!("{},{x},{y},{z},2,3,5,1,0,0\n", usize::from(z > 0));
    }
    folder.write("lattice.csv", &rows);
    for boundary in ["Type=0", "type=0", "c_w[1]=0", "MASS=0"] {
        let text =
            told(&folder, &format!("detect --particles lattice.csv --spacing 1 --boundary {boundary} --out s.csv")).0;
        assert_eq!(text.contains("boundary             16"), boundary.ends_with("ype=0"), "{text}");
    }
    let header = std::fs::read_to_string(folder.path("s.csv")).unwrap();
    assert!(header.lines().next().unwrap().contains("c_w[1],c_w[2]"), "{header}");
    let message = folder.fails("detect --particles lattice.csv --spacing 1 --boundary Kind=0 --out s.csv");
    assert!(
        message.ends_with("mass (Mass), c_w (c_w[1], c_w[2]), velocity (Vel.x, Vel.y, Vel.z), type (Type)\n"),
        "{message}"
    );
    let (text, _) = told(
        &folder,
        "grid --particles lattice.csv --spacing 1 --fields Mass,c_w[2],velocity --conserve Mass,c_w[1] --out g.vti",
    );
    assert!(text.contains("Mass of particles    128"), "{text}");
    assert!(text.contains("c_w[1] of particles  192"), "{text}");
    let image = vtk::read_vtk(&folder.path("g.vti")).unwrap();
    let most = |name: &str| image.array(name).unwrap().values.to_f64().into_iter().fold(0.0, f64::max);
    assert!((most("c_w[2]") - 5.0).abs() < 1e-12 && (most("mass") - 2.0).abs() < 1e-12);
    folder.write("w.csv", "x,y,z,r,W,M\n.5,.5,.5,.25,4,3\n");
    folder.succeeds(&format!("fraction --particles w.csv {BOX} --parcel-weight w --out f.csv"));
    let ball = std::f64::consts::PI / 48.0;
    assert!((value(&folder, "f.csv", "solid_volume") - 4.0 * ball).abs() < 1e-15);
    folder.succeeds(&format!("fields --particles w.csv {BOX} --mass-column m --fields density --out d.csv"));
    assert!((value(&folder, "d.csv", "density") - 3.0).abs() < 1e-14);
}

#[test]
fn parcels_count_as_many_particles_and_a_warning_says_where_they_do_not() {
    let folder = still();
    let run = |options: &str| {
        told(
            &folder,
            &format!("fields --particles still.csv {BOX} --fields volume_fraction,density {options} --out p.csv"),
        )
    };
    let (_, warnings) = run("");
    assert!(warnings.contains("'nParticle' says that parcels stand for up to 10 particles"), "{warnings}");
    assert!((value(&folder, "p.csv", "density") - 5.0).abs() < 1e-14);
    let (text, warnings) = run("--parcel-weight nParticle");
    assert!(warnings.is_empty() && text.contains("mass                 32\n"), "{warnings}{text}");
    assert!((value(&folder, "p.csv", "density") - 32.0).abs() < 1e-13);
    let volume = 4.0 / 3.0 * std::f64::consts::PI * (0.125f64.powi(3) + 10.0 * 0.25f64.powi(3));
    assert!((value(&folder, "p.csv", "volume_fraction") - volume).abs() < 1e-14);
    run("--parcel-weight 2.5");
    assert!((value(&folder, "p.csv", "density") - 12.5).abs() < 1e-13);
    folder.write(
        "p.toml",
        "particles = \"still.csv\"\ngrid = [0,1,0,1,0,1]\ncells = 1\nfields = \"density\"\nparcel-weight = 2.5\n",
    );
    folder.succeeds("fields p.toml --out t.csv");
    assert!((value(&folder, "t.csv", "density") - 12.5).abs() < 1e-13);
    let (_, warnings) = told(&folder, &format!("fraction --particles still.csv {BOX} --out f.csv"));
    assert!(warnings.contains("give --parcel-weight nParticle"), "{warnings}");
    let line = format!("fields --particles still.csv --contacts c.csv --parcel-weight 2 {BOX} --out p.csv");
    let refused = folder.fieldstone(&line);
    assert!(refused.code == Some(2) && refused.stderr.contains("cannot be used with"), "{}", refused.stderr);
    folder.write(
        "c.toml",
        "particles = \"still.csv\"\ncontacts = \"c.csv\"\nparcel-weight = 2\ncells = 1\nout = \"c.csv\"\n",
    );
    let message = folder.fails("fields c.toml");
    assert!(message.contains("--contacts and --parcel-weight exclude each other"), "{message}");
    let message = folder.fails(&format!("fields --particles still.csv --parcel-weight w {BOX} --out p.csv"));
    assert!(message.contains("there is no column 'w'"), "{message}");
    // What crosses a face is the parcels' flux, too.
    folder.write("moving.csv", "x,y,z,r,mass,vx,vy,vz,n\n1,.5,.5,.25,2,3,0,0,7\n");
    let flux = |options: &str| {
        folder.succeeds(&format!(
            "fields --particles moving.csv --grid 0,2,0,1,0,1 --cells 2,1,1 {options} --fields density --face-fields f.vtp --out m.vti"
        ));
        let faces = vtk::read_vtk(&folder.path("f.vtp")).unwrap();
        faces.array("solid_flux").unwrap().values.to_f64().into_iter().fold(0.0, f64::max)
    };
    let disc = std::f64::consts::PI / 16.0;
    assert!((flux("") - 3.0 * disc).abs() < 1e-14 && (flux("--parcel-weight n") - 21.0 * disc).abs() < 1e-13);
}

#[test]
fn particles_without_velocities_have_all_fields_but_those_of_motion() {
    let folder = still();
    for fields in ["", "--fields all"] {
        let (_, warnings) =
            told(&folder, &format!("fields --particles still.csv --parcel-weight 1 {BOX} {fields} --out s.csv"));
        assert!(
            warnings.contains("have no velocities, so these fields are left out: momentum, momentum_flux"),
            "{warnings}"
        );
        assert!((value(&folder, "s.csv", "density") - 5.0).abs() < 1e-14);
        assert!(!CsvTable::read(&folder.path("s.csv")).unwrap().has("momentum_x"));
    }
    let message = folder.fails(&format!("fields --particles still.csv {BOX} --fields density,velocity --out s.csv"));
    for part in ["there is no column 'velocity'", "mass, nParticle, radius (r)", "leave out of --fields"] {
        assert!(message.contains(part), "{message}");
    }
}
