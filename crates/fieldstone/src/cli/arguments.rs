//! Arguments that several subcommands share.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{anyhow, bail};
use clap::Args;
use fieldstone::io::{
    FrameRange, ParticleOptions, Series, find_files, find_times, read_frame_with_warnings, read_mesh,
};
use fieldstone::mesh::{Grid, Mesh};
use fieldstone::particles::{Domain, Particles};

use super::report;

/// Where the cells come from.
#[derive(Debug, Args)]
pub(crate) struct CellsArguments {
    /// Mesh: an OpenFOAM case or polyMesh folder, Gmsh .msh (2.0 to 2.2, 4.1), VTK .vtu or .vtk
    #[arg(long, value_name = "MESH", conflicts_with_all = ["grid", "cells"], required_unless_present = "grid")]
    pub mesh: Option<PathBuf>,
    /// Cartesian grid instead of a mesh: bounds in the particles' unit of length, e.g. -0.05,0.05,-0.05,0.05,0,0.1
    // The first bound may be negative, which must not be taken for an option.
    #[arg(
        long,
        value_name = "XMIN,XMAX,YMIN,YMAX,ZMIN,ZMAX",
        value_parser = bounds,
        allow_hyphen_values = true,
        requires = "cells"
    )]
    pub grid: Option<[f64; 6]>,
    /// Cells of the grid along x, y and z, or one number for all three, e.g. 20,20,40 or 20
    #[arg(long, value_name = "N", value_parser = counts, allow_hyphen_values = true, requires = "grid")]
    pub cells: Option<[usize; 3]>,
}

/// Cells of either kind.
pub(crate) enum CellSet {
    Mesh(Box<Mesh>),
    Grid(Grid),
}

impl CellsArguments {
    pub fn read(&self) -> anyhow::Result<CellSet> {
        match (&self.mesh, self.grid, self.cells) {
            (Some(path), ..) => Ok(CellSet::Mesh(Box::new(read_mesh(path)?))),
            (None, Some([x0, x1, y0, y1, z0, z1]), Some(cells)) => {
                let grid = Grid::new([x0, y0, z0], [x1, y1, z1], cells).map_err(|e| anyhow!("--grid, --cells: {e}"))?;
                check_memory(grid.cells().iter().product::<usize>() as u64, FRACTION_BYTES, available_memory())?;
                Ok(CellSet::Grid(grid))
            }
            _ => bail!("give either --mesh, or --grid with six numbers and --cells with three"),
        }
    }

    /// What the cells are called in messages.
    pub fn name(&self) -> String {
        self.mesh.as_ref().map_or_else(|| "the grid".into(), |path| path.display().to_string())
    }
}

/// Numbers separated by commas.
pub(crate) fn list<T: FromStr + Copy + Default, const N: usize>(text: &str, example: &str) -> Result<[T; N], String> {
    let words: Vec<&str> = text.split(',').map(str::trim).collect();
    if words.len() != N {
        return Err(format!("{} numbers were found; give {N}, separated by commas, as in {example}", words.len()));
    }
    let mut numbers = [T::default(); N];
    for (number, word) in numbers.iter_mut().zip(words) {
        *number = word.parse().map_err(|_| format!("'{word}' stands where a number is expected, as in {example}"))?;
    }
    Ok(numbers)
}

pub(crate) fn bounds(text: &str) -> Result<[f64; 6], String> {
    list(text, "-0.05,0.05,-0.05,0.05,0,0.1")
}

fn counts(text: &str) -> Result<[usize; 3], String> {
    const EXAMPLE: &str = "20,20,40 or 20";
    if text.contains(',') { list(text, EXAMPLE) } else { list(text, EXAMPLE).map(|[n]| [n; 3]) }
}

/// A finite number above 0.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && f64::is_finite(x) => Ok(x),
        _ => Err("give a finite number above 0".into()),
    }
}

/// A finite number, 0 or above.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x >= 0.0 && f64::is_finite(x) => Ok(x),
        _ => Err("give a finite number, 0 or above".into()),
    }
}

/// A number above 0 and up to 1.
pub(crate) fn fraction(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 && x <= 1.0 => Ok(x),
        _ => Err("give a number above 0 and at most 1".into()),
    }
}

/// Memory that the program can still get, in bytes, where the system tells: what is free, within the limit of the shell
/// (`ulimit -v`).
pub(crate) fn available_memory() -> Option<u64> {
    [free_memory(), address_space()].into_iter().flatten().min()
}

/// What is left of the limit of the program's address space, where there is one.
fn address_space() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
    let sizes = std::fs::read_to_string("/proc/self/statm").ok()?;
    // In pages, of 4 kB on nearly all systems.
    let used = 4096 * sizes.split_whitespace().next()?.parse::<u64>().ok()?;
    Some(limit.saturating_sub(used))
}

fn free_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(1024 * line.trim().trim_end_matches("kB").trim().parse::<u64>().ok()?)
}

/// Bytes per cell of solid fractions: fields, their copies while they are written, and centre counts.
const FRACTION_BYTES: u64 = 120;

/// Refuses a grid for whose fields the memory does not suffice: systems that promise more than they have end the
/// program without a word.
pub(crate) fn check_memory(cells: u64, bytes_per_cell: u64, available: Option<u64>) -> anyhow::Result<()> {
    let needed = cells.saturating_mul(bytes_per_cell);
    if let Some(available) = available
        && needed > available
    {
        let gigabytes = |bytes: u64| bytes as f64 / 1e9;
        bail!(
            "--cells: the fields of {cells} cells need about {:.1} GB of memory, and {:.1} GB are free; give fewer cells",
            gigabytes(needed),
            gigabytes(available)
        );
    }
    Ok(())
}

/// Where the particles come from.
#[derive(Debug, Args)]
pub(crate) struct ParticleArguments {
    /// Particles: LIGGGHTS or LAMMPS dump, CSV, VTK (.vtu, .vtp, .vtk), MercuryDPM .data, XYZ, OpenFOAM positions;
    /// .gz too. A pattern in quotes or a .pvd for several, of which --frame takes one
    #[arg(long, value_name = "FILE|PATTERN")]
    pub particles: PathBuf,
    /// Radius of all particles, in the file's unit of length, instead of the file's own
    #[arg(long, value_name = "R", value_parser = positive, allow_negative_numbers = true, conflicts_with = "diameter")]
    pub radius: Option<f64>,
    /// Diameter of all particles, in the file's unit of length, instead of the file's own
    #[arg(long, value_name = "D", value_parser = positive, allow_negative_numbers = true)]
    pub diameter: Option<f64>,
    /// Frame to take where there are several, from 0; negative counts from the end
    #[arg(long, value_name = "K", default_value_t = -1, allow_negative_numbers = true)]
    pub frame: i64,
    /// Treat superquadrics, ellipsoids and members of clumps as balls of the radius that the file gives
    #[arg(long)]
    pub allow_non_spherical: bool,
}

impl ParticleArguments {
    /// The files that the name stands for.
    pub fn files(&self) -> anyhow::Result<Vec<PathBuf>> {
        // A name that is no text is no pattern either.
        Ok(self.particles.to_str().map_or_else(|| Ok(vec![self.particles.clone()]), find_files)?)
    }

    /// The one frame that is asked for, of a file, or of all files one after the other.
    fn frame_with_warnings(&self, options: &ParticleOptions) -> anyhow::Result<(Particles, Vec<String>)> {
        let files = self.files()?;
        if let [file] = files.as_slice()
            && *file == self.particles
        {
            return Ok(read_frame_with_warnings(file, options, self.frame)?);
        }
        let range: FrameRange = self.frame.to_string().parse()?;
        let times = find_times(&self.particles.to_string_lossy())?;
        let mut series = Series::new(files.clone(), *options).with_times(times).with_range(range);
        match series.next() {
            Some(frame) => Ok((frame?.particles, series.warnings())),
            None => {
                let count = Series::new(files, *options).count_frames()?;
                bail!("--particles {}: {}; check --frame", self.particles.display(), range.why_empty(count))
            }
        }
    }

    pub fn read(&self) -> anyhow::Result<Particles> {
        let options = ParticleOptions { allow_non_spherical: self.allow_non_spherical };
        let (particles, warnings) = self.frame_with_warnings(&options)?;
        let given = self.radius.or(self.diameter.map(|d| 0.5 * d));
        let particles = match given {
            Some(radius) => {
                particles.with_uniform_radius(radius).map_err(|e| anyhow!("--radius or --diameter: {e}"))?
            }
            None => particles,
        };
        if particles.is_empty() {
            // A pour begins, and an open flow ends, with such a frame: its fields are those of empty space.
            report::warn(&format!(
                "{}: the frame holds no particle: every field is that of empty space; another is chosen with --frame",
                self.particles.display()
            ));
            return Ok(particles.with_radii(Vec::new())?);
        }
        particles.radii().map_err(|e| anyhow!("{}: {e}", self.particles.display()))?;
        // A file that is refused needs no more said of it.
        warnings.iter().for_each(|warning| report::warn(warning));
        Ok(particles)
    }
}

/// What to say of particles that are parcels by OpenFOAM's column, where nobody asks for their weights.
pub(crate) fn unused_parcels(particles: &Particles) -> Option<String> {
    const COLUMN: &str = "nParticle";
    let weights = particles.column(COLUMN).ok().filter(|column| column.components == 1)?;
    let most = weights.data.iter().copied().fold(0.0, f64::max);
    weights.data.iter().any(|weight| *weight != 1.0).then(|| {
        format!(
            "the column '{COLUMN}' says that parcels stand for up to {} particles each, and goes unused: each counts as one \
             particle; give --parcel-weight {COLUMN}",
            report::number(most)
        )
    })
}

/// Which periodic directions to honour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Periodic {
    /// Those of the file, where the cells do not reach beyond the box; in a tilted one, where they are no wider than it.
    Auto,
    /// Exactly these.
    Given([bool; 3]),
}

impl FromStr for Periodic {
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
    /// The box that `--box` gives, in place of that of the file.
    pub fn given_box(self, [x0, x1, y0, y1, z0, z1]: [f64; 6]) -> anyhow::Result<Domain> {
        let Self::Given(axes) = self else {
            bail!("--box: say along which axes the box is periodic, as in --periodic xy, or --periodic none");
        };
        Domain::new([x0, y0, z0], [x1, y1, z1], axes).map_err(|e| anyhow!("--box: {e}"))
    }

    /// The box whose periodic directions are to be honoured, if any; with a note for the user.
    pub fn domain(
        self,
        particles: &Particles,
        (low, high): ([f64; 3], [f64; 3]),
    ) -> anyhow::Result<(Option<Domain>, Option<String>)> {
        let Some(domain) = particles.domain() else {
            return match self {
                Self::Given(axes) if axes != [false; 3] => {
                    bail!("--periodic: the particle file states no box; give it with --box")
                }
                _ => Ok((None, None)),
            };
        };
        let Self::Auto = self else {
            let Self::Given(axes) = self else { return Ok((None, None)) };
            return Ok((axes.contains(&true).then(|| domain.with_periodic(axes)), None));
        };
        let wide = |k: usize| high[k] - low[k] > domain.lengths()[k] * (1.0 + 1e-9);
        let beyond = |k: usize| {
            let slack = 1e-9 * domain.lengths()[k];
            low[k] < domain.low()[k] - slack || high[k] > domain.high()[k] + slack
        };
        // No upright cells fill a tilted box, but in any that are no wider than its period everything is once.
        let tilted = !domain.is_orthogonal();
        let refuses = |k: usize| if tilted { wide(k) } else { beyond(k) };
        let axes: [bool; 3] = std::array::from_fn(|k| domain.periodic()[k] && !refuses(k));
        let named = |chosen: &dyn Fn(usize) -> bool| -> String {
            (0..3).filter(|&k| chosen(k)).map(|k| ['x', 'y', 'z'][k]).collect()
        };
        let all = named(&|k| domain.periodic()[k]);
        let refused = named(&|k| domain.periodic()[k] && !axes[k]);
        let note = (!refused.is_empty()).then(|| {
            // As the user would write them: the ends are differences of the numbers in the file.
            let short = |x: f64| format!("{x:.9e}").parse::<f64>().unwrap_or(x);
            let ends: Vec<String> = (0..3)
                .filter(|&k| domain.periodic()[k] && !axes[k])
                .map(|k| format!("{} to {} along {}", short(domain.low()[k]), short(domain.high()[k]), ['x', 'y', 'z'][k]))
                .collect();
            format!(
                "the box is periodic along {all}, but the cells {} along {refused}: no images are made there, since cells \
                 outside would get them twice; give cells of one period ({}), or --periodic {all} for images in all cells",
                if tilted { "are wider than it" } else { "reach beyond it" },
                ends.join(", ")
            )
        });
        Ok((axes.contains(&true).then(|| domain.with_periodic(axes)), note))
    }
}

/// Ending of a path in lower case.
pub(crate) fn ending(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// Ending of an input's path in lower case, without `.gz`: whether a file is compressed shows in its first bytes.
pub(crate) fn ending_of_input(path: &Path) -> String {
    match ending(path).as_str() {
        "gz" => ending(&path.with_extension("")),
        other => other.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_larger_than_the_memory_is_refused_with_both_numbers() {
        let check = |available| check_memory(1_000_000_000, FRACTION_BYTES, available);
        let message = check(Some(16_000_000_000)).unwrap_err().to_string();
        assert!(message.contains("1000000000 cells need about 120.0 GB") && message.contains("16.0 GB are free"));
        assert!(check(Some(130_000_000_000)).is_ok() && check(None).is_ok());
    }
}
