//! A packing with its contacts, as a simulation has it in memory and as MercuryDPM writes it.

use std::io::Write;
use std::path::{Path, PathBuf};

use fieldstone_testing::Random;

/// One sphere.
#[derive(Debug, Clone, Copy)]
struct Sphere {
    at: [f64; 3],
    radius: f64,
    velocity: [f64; 3],
}

/// Spheres on a cubic lattice of spacing 1, shaken by a tenth of it; each touches its next in each direction, and the
/// last ones touch the walls of the box.
#[derive(Debug, Clone)]
pub struct Packing {
    counts: [usize; 3],
    spheres: Vec<Sphere>,
    forces: Vec<[f64; 2]>,
}

impl Packing {
    /// `counts` spheres along x, y and z, three contacts for each.
    ///
    /// ```
    /// let packing = fieldstone_bench::Packing::new([5, 4, 3], 1);
    /// assert_eq!((packing.len(), packing.contacts()), (60, 180));
    /// ```
    pub fn new(counts: [usize; 3], seed: u64) -> Self {
        let mut random = Random(seed);
        let [nx, ny, nz] = counts;
        let mut spheres = Vec::with_capacity(nx * ny * nz);
        for at in 0..nx * ny * nz {
            let place = [at % nx, at / nx % ny, at / (nx * ny)];
            spheres.push(Sphere {
                at: place.map(|n| n as f64 + 0.5 + random.uniform(-0.1, 0.1)),
                radius: random.uniform(0.475, 0.525),
                velocity: [(); 3].map(|()| random.uniform(-0.5, 0.5)),
            });
        }
        let forces = (0..3 * spheres.len()).map(|_| [random.uniform(0.5, 1.5), random.uniform(0.0, 0.3)]).collect();
        Self { counts, spheres, forces }
    }

    /// Number of spheres.
    pub fn len(&self) -> usize {
        self.spheres.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.spheres.is_empty()
    }

    /// Number of contacts, each pair counted once.
    pub fn contacts(&self) -> usize {
        3 * self.spheres.len()
    }

    /// The upper corner of the box, whose lower one is the origin.
    pub fn high(&self) -> [f64; 3] {
        self.counts.map(|n| n as f64)
    }

    /// Writes `NAME.data` and `NAME.fstat` with as many digits as MercuryDPM does, every pair from either side, in
    /// `frames` frames in which the spheres move on with their velocities.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn write(&self, folder: &Path, name: &str, frames: usize) -> std::io::Result<[PathBuf; 2]> {
        let paths = ["data", "fstat"].map(|ending| folder.join(format!("{name}.{ending}")));
        let [mut data, mut contacts] = [None, None];
        for (file, path) in [&mut data, &mut contacts].into_iter().zip(&paths) {
            *file = Some(std::io::BufWriter::with_capacity(1 << 20, std::fs::File::create(path)?));
        }
        let (Some(mut data), Some(mut contacts)) = (data, contacts) else { return Ok(paths) };
        let [nx, ny, nz] = self.counts;
        for frame in 0..frames {
            let time = 0.01 * frame as f64;
            let moved: Vec<Sphere> = (self.spheres.iter())
                .map(|s| Sphere { at: std::array::from_fn(|k| s.at[k] + time * s.velocity[k]), ..*s })
                .collect();
            writeln!(data, "{} {time} 0 0 0 {nx} {ny} {nz}", self.len())?;
            for s in &moved {
                let numbers: Vec<f64> = s.velocity.into_iter().chain([s.radius]).collect();
                writeln!(data, "{} {} 0 0 0 0 0 0 0", words(&s.at, 15), words(&numbers, 10))?;
            }
            writeln!(contacts, "# {time} 0\n# 0 0 0 {nx} {ny} {nz}\n# 0.475 0.525 0 0 0 0")?;
            self.write_contacts(&moved, time, &mut contacts)?;
        }
        data.flush()?;
        contacts.flush()?;
        Ok(paths)
    }

    fn write_contacts(&self, spheres: &[Sphere], time: f64, out: &mut impl Write) -> std::io::Result<()> {
        let [nx, ny, _] = self.counts;
        let mut row = |i: usize, j: i64, point: [f64; 3], overlap: f64, force: [f64; 2], n: [f64; 3]| {
            // Some direction across the normal.
            let t = [n[1] * 0.8 - n[2] * 0.6, n[2] * 0.0 - n[0] * 0.8, n[0] * 0.6 - n[1] * 0.0];
            let length = (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt();
            let t = t.map(|x| x / length);
            let numbers: Vec<f64> = [point[0], point[1], point[2], overlap, 0.0, force[0], force[1]]
                .into_iter()
                .chain(n)
                .chain(t)
                .collect();
            writeln!(out, "{time} {i} {j} {}", words(&numbers, 10))
        };
        for (i, a) in spheres.iter().enumerate() {
            let place = [i % nx, i / nx % ny, i / (nx * ny)];
            for (axis, step) in [1, nx, nx * ny].into_iter().enumerate() {
                let force = self.forces[3 * i + axis];
                if place[axis] + 1 < self.counts[axis] {
                    let b = &spheres[i + step];
                    let apart: [f64; 3] = std::array::from_fn(|k| a.at[k] - b.at[k]);
                    let distance = apart.iter().map(|x| x * x).sum::<f64>().sqrt();
                    let n = apart.map(|x| x / distance);
                    let overlap = a.radius + b.radius - distance;
                    let point = std::array::from_fn(|k| a.at[k] - (a.radius - 0.5 * overlap) * n[k]);
                    row(i, (i + step) as i64, point, overlap, force, n)?;
                    row(i + step, i as i64, point, overlap, force, n.map(|x| -x))?;
                } else {
                    let n = std::array::from_fn(|k| if k == axis { 1.0 } else { 0.0 });
                    let point = std::array::from_fn(|k| a.at[k] + a.radius * n[k]);
                    row(i, -(1 + axis as i64), point, 0.0, force, n)?;
                }
            }
        }
        Ok(())
    }
}

/// Numbers rounded to so many digits, without zeros at their ends.
fn words(numbers: &[f64], digits: usize) -> String {
    let rounded = numbers.iter().map(|x| format!("{x:.0$e}", digits - 1).parse::<f64>().unwrap_or(*x).to_string());
    rounded.collect::<Vec<_>>().join(" ")
}
