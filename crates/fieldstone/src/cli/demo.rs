//! `fieldstone demo`: the main job on data that comes with the program.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use clap::Args;
use fieldstone::fields::{Method, SolidFractionOptions};
use fieldstone::io::openfoam::read_poly_mesh;
use fieldstone::io::{AtomicFile, ParticleOptions, read_frame};
use fieldstone::mesh::{Cells, Mesh};
use fieldstone::particles::Particles;

use super::picture::{Plane, Slice, draw};
use super::timing::Timing;
use super::{fraction, report};

/// Run the main job on a packing and a mesh that come with the program
///
/// 2,400 spheres of 5 to 7 mm, poured into a cylinder with LAMMPS, on a twisted OpenFOAM mesh of 6,144 hexahedra, two thirds
/// of whose faces are warped. Leaves solid_fraction.vtu, solid_fraction.png, summary.txt and summary.json.
#[derive(Debug, Args)]
pub(crate) struct Demo {
    /// Folder for the results; made where it is missing
    #[arg(default_value = "fieldstone-demo")]
    folder: PathBuf,
}

/// The demo's input, unpacked where it is needed.
const FILES: [(&str, &[u8]); 6] = [
    ("packed.dump.gz", include_bytes!("../../demo/packed-cylinder/packed.dump.gz")),
    ("polyMesh/points.gz", include_bytes!("../../demo/bed_twist/constant/polyMesh/points.gz")),
    ("polyMesh/faces.gz", include_bytes!("../../demo/bed_twist/constant/polyMesh/faces.gz")),
    ("polyMesh/owner.gz", include_bytes!("../../demo/bed_twist/constant/polyMesh/owner.gz")),
    ("polyMesh/neighbour.gz", include_bytes!("../../demo/bed_twist/constant/polyMesh/neighbour.gz")),
    ("polyMesh/boundary", include_bytes!("../../demo/bed_twist/constant/polyMesh/boundary")),
];

impl Demo {
    pub fn run(self) -> anyhow::Result<()> {
        std::fs::create_dir_all(&self.folder).map_err(|e| {
            anyhow!("{}: cannot make the folder: {e}; give another, as in: fieldstone demo DIR", self.folder.display())
        })?;
        let mut timing = Timing::default();
        let (particles, mesh) = timing.measure("read", input)?;
        let outcome = fraction::compute(&mesh, &particles, &SolidFractionOptions::default(), &mut timing)?;

        let vtu = self.folder.join("solid_fraction.vtu");
        let png = self.folder.join("solid_fraction.png");
        timing.measure("write", || fraction::write_vtu(&vtu, &mesh, &outcome))?;
        timing.measure("picture", || picture(&png, &mesh, &particles, &outcome.fields.solid_fraction))?;

        let inverted = mesh.inverted_cells().len();
        let mut text = report::ledger(&outcome.fields, inverted);
        text.push_str("\nThe same packing by the approximations in use elsewhere:\n\n");
        text.push_str(&comparison(&mesh, &particles, &outcome.fields.solid_fraction)?);
        let _ = write!(text, "\n{}", timing.table());
        AtomicFile::write(&self.folder.join("summary.txt"), |out| out.write_all(text.as_bytes()))?;
        fraction::write_summary(&self.folder.join("summary.json"), &outcome, inverted, &timing)?;
        let _ = writeln!(
            text,
            "\nresults in {}: open solid_fraction.vtu in ParaView, look at solid_fraction.png",
            self.folder.display()
        );
        report::print(&text)
    }
}

fn input() -> anyhow::Result<(Particles, Mesh)> {
    let folder = tempfile::tempdir().context("cannot make a temporary folder for the demo's input")?;
    std::fs::create_dir(folder.path().join("polyMesh")).context("cannot unpack the demo's input")?;
    for (name, content) in FILES {
        std::fs::write(folder.path().join(name), content).context("cannot unpack the demo's input")?;
    }
    let particles = read_frame(&folder.path().join("packed.dump.gz"), &ParticleOptions::default(), -1)?;
    let mesh = read_poly_mesh(&folder.path().join("polyMesh"))?;
    Ok((particles, mesh))
}

/// Worst and typical error of each approximation, against the exact field.
fn comparison(mesh: &Mesh, particles: &Particles, exact: &[f64]) -> anyhow::Result<String> {
    let mut text = format!(
        "{:<18} {:>16} {:>12} {:>12} {:>12}\n",
        "method", "largest fraction", "above 1", "worst error", "rms error"
    );
    let methods = [
        Method::Kernel,
        Method::Centre,
        Method::CentreSmoothed,
        Method::Cube,
        Method::Divided,
        Method::Sampled(20),
        Method::MonteCarlo(100),
    ];
    for method in methods {
        let options = SolidFractionOptions { method, ..SolidFractionOptions::default() };
        let result = fieldstone::fields::solid_fraction(mesh, particles, &options)?;
        let errors = result.solid_fraction.iter().zip(exact).map(|(a, b)| (a - b).abs());
        let (worst, squares) = errors.fold((0.0, 0.0), |(w, s): (f64, f64), e| (w.max(e), s + e * e));
        let _ = writeln!(
            text,
            "{:<18} {:>16.4} {:>12} {worst:>12.4} {:>12.4}",
            method.to_string(),
            result.ledger.max_solid_fraction,
            result.ledger.cells_above_one,
            (squares / exact.len() as f64).sqrt()
        );
    }
    Ok(text)
}

fn picture(path: &Path, mesh: &Mesh, particles: &Particles, fraction: &[f64]) -> anyhow::Result<()> {
    let plane = Plane { axes: [0, 2, 1], at: 0.0 };
    let circles = particles
        .positions()
        .iter()
        .zip(particles.radii()?)
        .filter_map(|(&centre, &radius)| plane.circle(centre, radius))
        .collect();
    // The empty upper part of the mesh would make the packing small.
    let top = particles.positions().iter().zip(particles.radii()?).map(|(p, r)| p[2] + r).fold(0.0, f64::max);
    let (low, mut high) = mesh.bounds();
    high[2] = high[2].min(1.15 * top);
    let slice = Slice {
        title: "2,400 spheres in a cylinder, slice y = 0".into(),
        plane,
        bounds: (low, high),
        range: [0.0, 1.0],
        label: "solid fraction",
        circles,
    };
    let mut scratch = mesh.scratch();
    draw(path, &slice, |point| mesh.locate(point, &mut scratch).map(|cell| fraction[cell as usize]))
}
