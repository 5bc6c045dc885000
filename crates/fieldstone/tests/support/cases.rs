//! Small cases, and how results are looked at.

#![allow(dead_code, reason = "not every suite needs all")]

use std::path::Path;

use fieldstone::io::vtk;
use fieldstone_testing::data;

use super::Folder;

/// Balls in and around the mesh `data/openfoam/refined`, a skewed box of about 1 × 1 × 1.
pub const BALLS: &str = "\
id,x,y,z,radius,weight
1,0.5,0.5,0.5,0.25,1
2,0.1,0.15,0.2,0.1,2
3,0.9,0.8,0.85,0.12,3
4,0.3,0.75,0.25,0.2,4
5,0.6,0.2,0.05,0.1,5
6,2,2,2,0.1,6
";

/// A folder with the mesh `case` of 19 cells and the particles `balls.csv`.
pub fn small_case() -> Folder {
    let folder = Folder::new();
    folder.copy(&data("openfoam/refined"), "case");
    folder.write("balls.csv", BALLS);
    folder
}

/// A dump of one ball, `id x y z radius`, in a box: its flags, and its bounds line by line.
pub fn one_ball(bounds: &str, ball: &str) -> String {
    format!(
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS {bounds}\nITEM: ATOMS id x y z radius\n{ball}\n"
    )
}

/// Five grains of a chute flow with all contacts among them and with the floor; periodic in x and y.
pub fn grains() -> Folder {
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

pub const GRAINS: &str = "fields --particles part.dump --contacts pair.dump --contacts-preset liggghts-pair \
                      --contacts wall.dump --contacts-preset liggghts-wall";

/// Two balls of radius 1/2 pressed together in a MercuryDPM box of two frames, one of them on the floor.
pub fn mercury() -> Folder {
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

pub const MERCURY: &str = "fields --particles box.data --contacts box.fstat --restart box.restart --cells 2,1,1";

pub fn json(folder: &Folder, file: &str) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(folder.path(file)).unwrap()).unwrap()
}

/// A column of a `.vtu` or `.vti`.
pub fn column(folder: &Folder, file: &str, name: &str) -> Vec<f64> {
    vtk::read_vtk(&folder.path(file)).unwrap().array(name).unwrap().values.to_f64()
}

pub fn numbers(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

pub fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

pub fn size(a: &[f64]) -> f64 {
    a.iter().map(|x| x.abs()).fold(0.0, f64::max)
}

#[track_caller]
pub fn mentions(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
}
