//! Seconds that a whole job of coarse graining takes: 100,000 spheres and 300,000 contacts are read from MercuryDPM's
//! text files, the 29 standard fields are computed on 20³, 50³ and 100³ cells, and written as `.vti`.
//!
//! `cargo run --release -p fieldstone-bench --bin fields [REPEATS [FOLDER]]`, with `RAYON_NUM_THREADS` for another
//! number of threads; the input files are left in FOLDER where one is given. Of the repeats the best of each part is
//! printed: elapsed seconds, and processor seconds of all threads, which other work on the machine disturbs less. The
//! decomposition method takes its turn in the same run.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::time::Instant;

use fieldstone_bench::{Packing, process_seconds};
use fieldstone_fields::{
    CoarseGraining, CoarseGrainingOptions, FieldName, Fields, Function, Kernel, KernelShape, Method,
};
use fieldstone_io::vtk::{VtkArrays, VtkCompression, VtkEncoding, VtkFormat, VtkImage, VtkWedges, write_vti};
use fieldstone_io::{ContactFiles, ContactOptions, DataArray, ParticleOptions, Series, SeriesFrame};
use fieldstone_mesh::Grid;

/// What `fieldstone fields` writes grids with.
const LZ4: VtkEncoding =
    VtkEncoding { format: VtkFormat::AppendedRaw, compression: VtkCompression::Lz4, wedges: VtkWedges::SinceVtk97 };

/// Elapsed and processor seconds of a task.
fn timed<T>(task: impl FnOnce() -> T) -> ([f64; 2], T) {
    let (start, before) = (Instant::now(), process_seconds());
    let result = task();
    ([start.elapsed().as_secs_f64(), process_seconds() - before], result)
}

fn read([data, contacts]: &[std::path::PathBuf; 2]) -> SeriesFrame {
    let contacts = ContactFiles { files: vec![contacts.clone()], options: ContactOptions::default() };
    let mut series = Series::new(vec![data.clone()], ParticleOptions::default()).with_contacts(contacts);
    series.next().unwrap().unwrap()
}

fn compute(grid: &Grid, frame: &SeriesFrame, function: Function) -> Fields {
    let options = CoarseGrainingOptions {
        function,
        fields: FieldName::standard(),
        particle_density: Some(2.0),
        ..CoarseGrainingOptions::default()
    };
    let mut grains = CoarseGraining::new(grid, options).unwrap();
    grains.accumulate(&frame.particles, frame.contacts.as_ref(), 1.0).unwrap();
    grains.finish().unwrap()
}

fn write(path: &Path, grid: &Grid, fields: Fields, encoding: VtkEncoding) {
    let arrays: Vec<DataArray> = (fields.fields.into_iter())
        .map(|field| DataArray::floats(&field.name, field.components.len(), field.data))
        .collect();
    write_vti(path, &VtkImage::from(grid), VtkArrays { cells: &arrays, ..VtkArrays::default() }, encoding).unwrap();
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let repeats: usize = arguments.next().map_or(3, |n| n.parse().expect("a number of repeats"));
    let temporary = tempfile::tempdir().unwrap();
    let folder = arguments.next().map_or(temporary.path().into(), std::path::PathBuf::from);
    let packing = Packing::new([50, 50, 40], 1);
    let files = packing.write(&folder, "packing", 1).unwrap();
    let out = folder.join("fields.vti");
    let size = |path: &Path| std::fs::metadata(path).unwrap().len() as f64 / 1e6;
    println!(
        "{} spheres ({:.0} MB), {} contacts ({:.0} MB), {} threads, best of {repeats}",
        packing.len(),
        size(&files[0]),
        packing.contacts(),
        size(&files[1]),
        rayon::current_num_threads()
    );
    let functions = [
        ("exact", Function::Overlap(Method::Kernel)),
        ("exact, decomposition", Function::Overlap(Method::Decomposition)),
        ("gauss, w = 0.5", Function::Kernel(Kernel::new(KernelShape::Gauss, 0.5, None).unwrap())),
        ("lucy, w = 1", Function::Kernel(Kernel::new(KernelShape::Lucy, 1.0, None).unwrap())),
    ];
    println!(
        "{:>6} {:>20} {:>13} {:>13} {:>13} {:>13} {:>11}",
        "cells", "function", "reading", "computing", "writing", "whole", "mass error"
    );
    for n in [20, 50, 100] {
        let grid = Grid::new([0.0; 3], packing.high(), [n; 3]).unwrap();
        for (name, function) in functions {
            let repeats = if function == Function::Overlap(Method::Decomposition) { 1 } else { repeats };
            let mut best = [[f64::INFINITY; 2]; 4];
            let mut error = 0.0;
            for _ in 0..repeats {
                let (whole, parts) = timed(|| {
                    let (reading, frame) = timed(|| read(&files));
                    let (computing, fields) = timed(|| compute(&grid, &frame, function));
                    let l = fields.ledger;
                    error = (l.mass_in - l.mass_binned - l.mass_clipped) / l.mass_in;
                    let (writing, ()) = timed(|| write(&out, &grid, fields, LZ4));
                    [reading, computing, writing]
                });
                for (best, part) in best.iter_mut().zip(parts.into_iter().chain([whole])) {
                    best.iter_mut().zip(part).for_each(|(b, s)| *b = b.min(s));
                }
            }
            let cells = format!("{n}³");
            let [reading, computing, writing, whole] = best.map(|[elapsed, cpu]| format!("{elapsed:.2} {cpu:.2}"));
            println!("{cells:>6} {name:>20} {reading:>13} {computing:>13} {writing:>13} {whole:>13} {error:>11.1e}");
        }
    }
    println!("\n{:>26} {:>8} {:>10} {:>6}", "100³ cells written as", "elapsed", "processor", "MB");
    let grid = Grid::new([0.0; 3], packing.high(), [100; 3]).unwrap();
    let fields = compute(&grid, &read(&files), functions[0].1);
    let encodings = [
        ("raw", VtkEncoding { compression: VtkCompression::None, ..LZ4 }),
        ("lz4, raw", LZ4),
        ("zlib, raw", VtkEncoding { compression: VtkCompression::Zlib, ..LZ4 }),
        ("zlib, base64", VtkEncoding::default()),
    ];
    for (name, encoding) in encodings {
        let best = (0..repeats)
            .map(|_| {
                let copy = fields.clone();
                timed(|| write(&out, &grid, copy, encoding)).0
            })
            .min_by(|a, b| a[0].total_cmp(&b[0]))
            .unwrap();
        println!("{name:>26} {:>8.3} {:>10.3} {:>6.0}", best[0], best[1], size(&out));
    }
}
