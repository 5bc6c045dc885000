//! Arguments that several subcommands share.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use fieldstone::io::{ParticleOptions, read_frame, read_mesh};
use fieldstone::mesh::{Grid, Mesh};
use fieldstone::particles::{Domain, Particles};

/// Where the cells come from.
#[derive(Debug, Args)]
pub(crate) struct CellsArguments {
    /// Mesh: an OpenFOAM case or polyMesh folder, Gmsh .msh (2.2, 4.1), VTK .vtu or .vtk
    #[arg(long, value_name = "MESH", conflicts_with_all = ["grid", "cells"])]
    pub mesh: Option<PathBuf>,
    /// Cartesian grid instead of a mesh, e.g. -0.05,0.05,-0.05,0.05,0,0.1
    #[arg(
        long,
        value_name = "XMIN,XMAX,YMIN,YMAX,ZMIN,ZMAX",
        value_delimiter = ',',
        num_args = 6,
        allow_negative_numbers = true,
        requires = "cells",
        required_unless_present = "mesh"
    )]
    pub grid: Option<Vec<f64>>,
    /// Cells of the grid along x, y and z, e.g. 20,20,40
    #[arg(long, value_name = "NX,NY,NZ", value_delimiter = ',', num_args = 3, requires = "grid")]
    pub cells: Option<Vec<usize>>,
}

/// Cells of either kind.
pub(crate) enum CellSet {
    Mesh(Box<Mesh>),
    Grid(Grid),
}

impl CellsArguments {
    pub fn read(&self) -> anyhow::Result<CellSet> {
        match (&self.mesh, self.grid.as_deref(), self.cells.as_deref()) {
            (Some(path), ..) => Ok(CellSet::Mesh(Box::new(read_mesh(path)?))),
            (None, Some(&[x0, x1, y0, y1, z0, z1]), Some(&[nx, ny, nz])) => {
                let grid = Grid::new([x0, y0, z0], [x1, y1, z1], [nx, ny, nz]).context("--grid and --cells")?;
                Ok(CellSet::Grid(grid))
            }
            _ => bail!("give either --mesh, or --grid with six numbers and --cells with three"),
        }
    }
}

/// Where the particles come from.
#[derive(Debug, Args)]
pub(crate) struct ParticleArguments {
    /// Particles: LIGGGHTS or LAMMPS dump, CSV, VTK (.vtu, .vtp, .vtk), MercuryDPM .data, XYZ, OpenFOAM positions;
    /// .gz too
    #[arg(long, value_name = "FILE")]
    pub particles: PathBuf,
    /// Radius of all particles, in the file's unit of length, instead of the file's own
    #[arg(long, value_name = "R", conflicts_with = "diameter")]
    pub radius: Option<f64>,
    /// Diameter of all particles, instead of the file's own
    #[arg(long, value_name = "D")]
    pub diameter: Option<f64>,
    /// Frame to take from a file of several, from 0; negative counts from the end
    #[arg(long, value_name = "K", default_value_t = -1, allow_negative_numbers = true)]
    pub frame: i64,
    /// Treat superquadrics, ellipsoids and members of clumps as balls of the radius that the file gives
    #[arg(long)]
    pub allow_non_spherical: bool,
}

impl ParticleArguments {
    pub fn read(&self) -> anyhow::Result<Particles> {
        let options = ParticleOptions { allow_non_spherical: self.allow_non_spherical };
        let particles = read_frame(&self.particles, &options, self.frame)?;
        let given = self.radius.or(self.diameter.map(|d| 0.5 * d));
        let particles = match given {
            Some(radius) => particles.with_uniform_radius(radius).context("--radius or --diameter")?,
            None => particles,
        };
        if particles.is_empty() {
            bail!("{}: the frame holds no particle", self.particles.display());
        }
        particles.radii().with_context(|| self.particles.display().to_string())?;
        Ok(particles)
    }
}

/// Which periodic directions to honour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Periodic {
    /// Those of the file, where the mesh does not reach beyond the box.
    Auto,
    /// Exactly these.
    Given([bool; 3]),
}

impl std::str::FromStr for Periodic {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "none" => Ok(Self::Given([false; 3])),
            _ if !text.is_empty() && text.chars().all(|c| "xyz".contains(c)) => {
                Ok(Self::Given(['x', 'y', 'z'].map(|axis| text.contains(axis))))
            }
            _ => Err(format!("'{text}' is not auto, none, or some of the letters x, y and z")),
        }
    }
}

impl Periodic {
    /// The box whose periodic directions are to be honoured, if any; with a note for the user.
    pub fn domain(
        self,
        particles: &Particles,
        (low, high): ([f64; 3], [f64; 3]),
    ) -> anyhow::Result<(Option<Domain>, Option<String>)> {
        let Some(domain) = particles.domain() else {
            return match self {
                Self::Given(axes) if axes != [false; 3] => {
                    bail!("--periodic needs a simulation box, and the particle file states none")
                }
                _ => Ok((None, None)),
            };
        };
        let Self::Auto = self else {
            let Self::Given(axes) = self else { return Ok((None, None)) };
            return Ok((axes.contains(&true).then(|| domain.with_periodic(axes)), None));
        };
        let lengths = domain.lengths();
        let inside = |k: usize| {
            let slack = 1e-9 * lengths[k];
            low[k] >= domain.low()[k] - slack && high[k] <= domain.high()[k] + slack
        };
        let axes: [bool; 3] = std::array::from_fn(|k| domain.periodic()[k] && inside(k));
        let refused: String =
            (0..3).filter(|&k| domain.periodic()[k] && !axes[k]).map(|k| ['x', 'y', 'z'][k]).collect();
        let note = (!refused.is_empty()).then(|| {
            format!(
                "the box is periodic along {refused}, but the mesh reaches beyond it there: no images are made \
                 (--periodic {refused} makes them)"
            )
        });
        Ok((axes.contains(&true).then(|| domain.with_periodic(axes)), note))
    }
}

/// Ending of a path in lower case, without `.gz`.
pub(crate) fn ending(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}
