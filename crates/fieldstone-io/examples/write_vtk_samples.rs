//! Writes a file of every kind in every encoding, and `expected.json` with the numbers that went into them.
//!
//! ```sh
//! cargo run -p fieldstone-io --example write_vtk_samples -- FOLDER && python tools/check_vtk_output.py FOLDER
//! ```

use std::error::Error;
use std::path::{Path, PathBuf};

use fieldstone_io::vtk::{
    VtkArrays, VtkCompression, VtkEncoding, VtkFormat, VtkImage, VtkWedges, read_vtk_mesh, write_pvd, write_vti,
    write_vtp_particles, write_vtp_surface, write_vtu,
};
use fieldstone_io::{DataArray, Values};
use fieldstone_mesh::Mesh;
use fieldstone_particles::{Particles, Quantity};
use serde_json::{Value, json};

/// Numbers that use all bits of a double.
fn irregular(n: usize, seed: u32) -> Vec<f64> {
    (0..n).map(|k| ((k as f64 + f64::from(seed)) * 12.9898).sin() * 43758.5453).collect()
}

/// One column of each type, and a vector.
fn columns(rows: usize, seed: u32) -> Vec<DataArray> {
    let whole: Vec<i64> = (0..rows as i64).map(|k| (k - 2) << 33).collect();
    let narrow: Vec<f32> = irregular(rows, seed).iter().map(|&x| x as f32).collect();
    let bytes: Vec<u8> = (0..rows).map(|k| (k * 37 % 256) as u8).collect();
    vec![
        DataArray::scalar("fraction <&> \"quoted\"", irregular(rows, seed)),
        DataArray::floats("velocity", 3, irregular(3 * rows, seed + 1)),
        DataArray::floats("stress", 9, irregular(9 * rows, seed + 2)),
        DataArray::integers("count", whole),
        DataArray { name: "narrow".into(), components: 1, values: Values::F32(narrow) },
        DataArray { name: "bytes".into(), components: 1, values: Values::U8(bytes) },
    ]
}

/// A text as results have it: how they were made.
const MADE: &str = "# with these settings\ncells = [1, 2]\nout = \"a <&>.vtu\"\n";

fn json_columns(arrays: &[DataArray]) -> Value {
    let one = |a: &DataArray| {
        let numbers = match &a.values {
            Values::I64(v) => json!(v),
            Values::U8(v) => json!(v),
            floats => json!(floats.to_f64()),
        };
        let kind = match a.values {
            Values::F64(_) => "float64",
            Values::F32(_) => "float32",
            Values::I64(_) => "int64",
            Values::U8(_) => "uint8",
        };
        (a.name.clone(), json!({"components": a.components, "type": kind, "numbers": numbers}))
    };
    arrays.iter().map(one).collect::<serde_json::Map<_, _>>().into()
}

struct Samples {
    folder: PathBuf,
    expected: Vec<Value>,
}

impl Samples {
    fn add(&mut self, name: &str, mut what: Value) -> PathBuf {
        what["file"] = json!(name);
        self.expected.push(what);
        self.folder.join(name)
    }

    fn mesh(&mut self, name: &str, mesh: &Mesh, encoding: VtkEncoding) -> Result<(), Box<dyn Error>> {
        let (points, cells) = (columns(mesh.parts().points.len(), 1), columns(mesh.cell_count(), 7));
        let path = self.add(
            name,
            json!({
                "wedges_before_vtk97": encoding.wedges == VtkWedges::BeforeVtk97,
                "texts": {"made": MADE}, "points": mesh.parts().points, "volumes": mesh.cell_volumes(), "time": 0.75,
                "point_data": json_columns(&points), "cell_data": json_columns(&cells),
            }),
        );
        let arrays = VtkArrays {
            points: &points,
            cells: &cells,
            time: Some(0.75),
            texts: &[("made", MADE)],
            ..VtkArrays::default()
        };
        write_vtu(&path, mesh, arrays, encoding)?;
        Ok(())
    }

    fn grid(&mut self, name: &str, grid: &VtkImage, encoding: VtkEncoding) -> Result<(), Box<dyn Error>> {
        let (points, cells) = (columns(grid.point_count(), 3), columns(grid.cell_count(), 4));
        let path = self.add(
            name,
            json!({
                "origin": grid.origin, "spacing": grid.spacing, "cells": grid.cells,
                "point_data": json_columns(&points), "cell_data": json_columns(&cells),
            }),
        );
        let arrays = VtkArrays { points: &points, cells: &cells, ..VtkArrays::default() };
        write_vti(&path, grid, arrays, encoding)?;
        Ok(())
    }

    fn particles(&mut self, name: &str, n: usize, encoding: VtkEncoding) -> Result<(), Box<dyn Error>> {
        let positions: Vec<[f64; 3]> = irregular(3 * n, 9).as_chunks::<3>().0.to_vec();
        let radii: Vec<f64> = irregular(n, 10).iter().map(|x| x.abs() + 1.0).collect();
        let ids: Vec<i64> = (0..n as i64).rev().collect();
        let velocity = Quantity { name: "velocity".into(), components: 3, data: irregular(3 * n, 11) };
        let columns = [
            DataArray::scalar("radius", radii.clone()),
            DataArray::integers("id", ids.clone()),
            DataArray::floats("velocity", 3, velocity.data.clone()),
        ];
        let path = self.add(name, json!({"points": positions, "point_data": json_columns(&columns), "time": 2.5}));
        let particles = Particles::new(positions)?.with_radii(radii)?.with_ids(ids)?.with_quantity(velocity)?;
        write_vtp_particles(&path, &particles.at(None, Some(2.5)), encoding)?;
        Ok(())
    }

    fn surface(&mut self, name: &str, encoding: VtkEncoding) -> Result<(), Box<dyn Error>> {
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let (on_points, on_cells) = (columns(4, 5), columns(4, 6));
        let path = self.add(
            name,
            json!({
                "points": points, "triangles": triangles, "time": 1.5,
                "point_data": json_columns(&on_points), "cell_data": json_columns(&on_cells),
            }),
        );
        let arrays = VtkArrays { points: &on_points, cells: &on_cells, time: Some(1.5), ..VtkArrays::default() };
        write_vtp_surface(&path, &points, &triangles, arrays, encoding)?;
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("give the folder to write to")?);
    std::fs::create_dir_all(&folder)?;
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/vtk");
    let standard = read_vtk_mesh(&fixtures.join("plain_f64_raw_zlib_uint64.vtu"))?;
    let mixed = read_vtk_mesh(&fixtures.join("mixed_f64_raw_zlib_uint64.vtu"))?;
    let mut samples = Samples { folder: folder.clone(), expected: Vec::new() };
    for (format, format_name) in [
        (VtkFormat::Ascii, "ascii"),
        (VtkFormat::Inline, "inline"),
        (VtkFormat::AppendedBase64, "base64"),
        (VtkFormat::AppendedRaw, "raw"),
    ] {
        for (compression, compression_name) in [
            (VtkCompression::None, "none"),
            (VtkCompression::Zlib, "zlib"),
            (VtkCompression::Lz4, "lz4"),
            (VtkCompression::Lzma, "lzma"),
        ] {
            let encoding = VtkEncoding { format, compression, ..VtkEncoding::default() };
            let tag = format!("{format_name}_{compression_name}");
            samples.mesh(&format!("standard_{tag}.vtu"), &standard, encoding)?;
            samples.mesh(&format!("polyhedra_{tag}.vtu"), &mixed, encoding)?;
            let grid = VtkImage::aligned([-1.0, 0.1, 1e-3], [0.1, 0.2, 0.3], [3, 2, 4]);
            samples.grid(&format!("grid_{tag}.vti"), &grid, encoding)?;
            samples.particles(&format!("particles_{tag}.vtp"), 17, encoding)?;
            samples.particles(&format!("no_particles_{tag}.vtp"), 0, encoding)?;
            samples.surface(&format!("surface_{tag}.vtp"), encoding)?;
        }
    }
    // More than one compressed block, whole and partial.
    let large = VtkImage::aligned([0.0; 3], [1.0; 3], [32, 32, 37]);
    samples.grid("large.vti", &large, VtkEncoding::default())?;
    let flat = VtkImage::aligned([0.0; 3], [1.0; 3], [5, 4, 0]);
    samples.grid("flat.vti", &flat, VtkEncoding::default())?;

    let old = VtkEncoding { wedges: VtkWedges::BeforeVtk97, ..VtkEncoding::default() };
    samples.mesh("wedges_before_vtk97.vtu", &standard, old)?;

    let steps = [(0.0, "standard_raw_zlib.vtu".into()), (0.5, "polyhedra_raw_zlib.vtu".into())];
    write_pvd(&folder.join("series.pvd"), &steps)?;
    let expected = json!({"files": samples.expected, "series": {"file": "series.pvd", "times": [0.0, 0.5]}});
    std::fs::write(folder.join("expected.json"), serde_json::to_string(&expected)?)?;
    println!("{} files in {}", samples.expected.len() + 1, folder.display());
    Ok(())
}
