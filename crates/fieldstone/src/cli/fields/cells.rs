//! The cells that fields are computed on.

use anyhow::{anyhow, bail};
use fieldstone::io::read_mesh;
use fieldstone::mesh::{Cells, Coordinates, CylinderGrid, Grid, Mesh};
use fieldstone::particles::Particles;

use super::frames::Frame;
use super::settings::{Numbers, Settings};
use crate::cli::arguments::{Periodic, available_memory, check_memory};

/// Bytes that a cell takes while its numbers are computed: the sums, the fields that come of them, and a copy while they
/// are written.
pub(super) fn bytes_per_cell(columns: usize) -> u64 {
    24 * columns as u64 + 100
}

/// Cells of any kind.
pub(super) enum CellSet {
    Mesh(Box<Mesh>),
    Grid(Grid),
    Cylinder(CylinderGrid),
}

impl CellSet {
    /// The cells that the settings ask for; bounds that they leave out are those of the first frame's box, else of its
    /// particles ([`over_particles`]).
    ///
    /// `columns` is the number of numbers per cell that will be held.
    pub fn new(settings: &Settings, first: &Particles, periodic: Periodic, columns: usize) -> anyhow::Result<Self> {
        if let Some(path) = &settings.mesh {
            return Ok(Self::Mesh(Box::new(read_mesh(path)?)));
        }
        let name = settings.coordinates.as_deref().unwrap_or("XYZ").to_ascii_uppercase();
        let cells = match name.as_str() {
            "R" | "RZ" | "RTZ" => Self::Cylinder(cylinder(settings, &name, first)?),
            _ => Self::Grid(grid(settings, &name, first, periodic)?),
        };
        let count = match &cells {
            Self::Grid(grid) => grid.cell_count(),
            Self::Cylinder(grid) => grid.cell_count(),
            Self::Mesh(_) => 0,
        };
        check_memory(count as u64, bytes_per_cell(columns), available_memory())?;
        Ok(cells)
    }

    /// How many cells there are.
    pub fn count(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.cell_count(),
            Self::Grid(grid) => grid.cell_count(),
            Self::Cylinder(grid) => grid.cell_count(),
        }
    }

    /// Volume of a cell.
    pub fn volume(&self, cell: usize) -> f64 {
        match self {
            Self::Mesh(mesh) => mesh.cell_volume(cell),
            Self::Grid(grid) => grid.cell_volume(cell),
            Self::Cylinder(grid) => grid.cell_volume(cell),
        }
    }
}

fn grid(settings: &Settings, name: &str, first: &Particles, periodic: Periodic) -> anyhow::Result<Grid> {
    let coordinates: Coordinates = name.parse().map_err(|_| {
        anyhow!("--coordinates {name}: choose O, X, Y, Z, XY, XZ, YZ, XYZ, or around an axis R, RZ, RTZ")
    })?;
    if settings.axis.is_some() || settings.origin.is_some() {
        bail!("--axis and --origin go with cylindrical coordinates: --coordinates R, RZ or RTZ");
    }
    let (low, high) = match &settings.grid {
        Some(bounds) => {
            let [x0, x1, y0, y1, z0, z1] = bounds.exactly("grid")?;
            let corners = ([x0, y0, z0], [x1, y1, z1]);
            let rises = |(a, b): ([f64; 3], [f64; 3])| (0..3).all(|k| a[k] < b[k]);
            if !rises(corners) && rises(([x0, x1, y0], [y1, z0, z1])) {
                bail!(
                    "--grid: the bounds do not rise; give them as XMIN,XMAX,YMIN,YMAX,ZMIN,ZMAX, here \
                     {x0},{y1},{x1},{z0},{y0},{z1}"
                );
            }
            corners
        }
        None => one_period(first, periodic, bounds_of(first)?),
    };
    let resolved: Vec<usize> = (0..3).filter(|&k| coordinates.resolved()[k]).collect();
    let mut cells = [1; 3];
    for (&axis, n) in
        resolved.iter().zip(counts(settings, &resolved.iter().map(|&k| ["x", "y", "z"][k]).collect::<Vec<_>>())?)
    {
        cells[axis] = n;
    }
    Grid::resolving(low, high, cells, coordinates).map_err(|e| anyhow!("--grid, --cells: {e}"))
}

/// Numbers of cells along the directions called `names`.
fn counts(settings: &Settings, names: &[&str]) -> anyhow::Result<Vec<usize>> {
    match settings.cells.as_ref().map(|cells| cells.0.as_slice()) {
        _ if names.is_empty() => Ok(Vec::new()),
        Some(&[n]) => Ok(vec![n; names.len()]),
        Some(list) if list.len() == names.len() => Ok(list.to_vec()),
        // Averaged directions may be named too, as MercuryCG does.
        Some(&[x, y, z]) if names.iter().all(|name| ["x", "y", "z"].contains(name)) => {
            let along = |name: &&str| match *name {
                "x" => x,
                "y" => y,
                _ => z,
            };
            Ok(names.iter().map(along).collect())
        }
        Some(list) => {
            bail!("--cells: {} numbers were found; give one, or one for each of {}", list.len(), names.join(", "))
        }
        None => bail!("give the cells: --mesh MESH, or --cells N for a grid over the box (or over --grid)"),
    }
}

fn cylinder(settings: &Settings, name: &str, first: &Particles) -> anyhow::Result<CylinderGrid> {
    let axis = axis_of(settings)?;
    let (origin, [r0, r1, z0, z1]) = cylinder_bounds(settings, axis, first)?;
    let cells = match name {
        "R" => [counts(settings, &["r"])?[0], 1, 1],
        "RZ" => {
            let n = counts(settings, &["r", "height"])?;
            [n[0], 1, n[1]]
        }
        _ => {
            let n = counts(settings, &["r", "angle", "height"])?;
            [n[0], n[1], n[2]]
        }
    };
    CylinderGrid::new(axis, origin, [r0, r1], [z0, z1], cells).map_err(|e| anyhow!("--grid, --cells, --origin: {e}"))
}

fn axis_of(settings: &Settings) -> anyhow::Result<usize> {
    match settings.axis.as_deref().unwrap_or("z") {
        "x" => Ok(0),
        "y" => Ok(1),
        "z" => Ok(2),
        other => bail!("--axis {other}: choose x, y or z"),
    }
}

/// A point on the axis, and RMIN, RMAX, ZMIN, ZMAX from there: as given, else as the first frame's box has them.
fn cylinder_bounds(settings: &Settings, axis: usize, first: &Particles) -> anyhow::Result<([f64; 3], [f64; 4])> {
    let given = settings.grid.as_ref().map(|bounds| bounds.exactly("grid")).transpose()?;
    let origin = settings.origin.as_ref().map(|origin| origin.exactly("origin")).transpose()?;
    if let (Some(given), Some(origin)) = (given, origin) {
        return Ok((origin, given));
    }
    let (low, high) = bounds_of(first)?;
    let middle = || std::array::from_fn(|k| if k == axis { low[k] } else { 0.5 * (low[k] + high[k]) });
    let origin = origin.unwrap_or_else(middle);
    let across = [(axis + 1) % 3, (axis + 2) % 3];
    let bounds = given.unwrap_or_else(|| {
        let radius = across.map(|k| (high[k] - origin[k]).min(origin[k] - low[k])).into_iter().fold(f64::MAX, f64::min);
        [0.0, radius, low[axis] - origin[axis], high[axis] - origin[axis]]
    });
    Ok((origin, bounds))
}

/// The settings with the bounds that the first frame's particles take up, where neither the settings nor a box say how far
/// the cells reach; and what the user should know of that.
///
/// The particles of other frames may be anywhere else: these bounds belong to the result.
pub(super) fn over_particles(settings: &Settings, first: &Frame) -> anyhow::Result<Option<(Settings, String)>> {
    if settings.mesh.is_some() || settings.cells.is_none() || first.particles.domain().is_some() {
        return Ok(None);
    }
    let mut laid = settings.clone();
    let mut taken = Vec::new();
    let text = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    if settings.is_cylindrical() {
        let (origin, bounds) = cylinder_bounds(settings, axis_of(settings)?, &first.particles)?;
        if settings.grid.is_none() {
            taken.push(format!("--grid={}", text(&bounds)));
        }
        if settings.origin.is_none() {
            taken.push(format!("--origin={}", text(&origin)));
        }
        laid.grid = Some(Numbers(bounds.into()));
        laid.origin = Some(Numbers(origin.into()));
    } else if settings.grid.is_none() {
        let (low, high) = bounds_of(&first.particles)?;
        let bounds: Vec<f64> = (0..3).flat_map(|k| [low[k], high[k]]).collect();
        taken.push(format!("--grid={}", text(&bounds)));
        laid.grid = Some(Numbers(bounds));
    }
    if taken.is_empty() {
        return Ok(None);
    }
    let note = format!(
        "{}: the files state no box, so the cells reach as far as the particles of this frame: {}; particles of other \
         frames that are elsewhere are in no cell: give bounds that hold them all",
        first.name,
        taken.join(" ")
    );
    Ok(Some((laid, note)))
}

/// The bounds of a tilted box, but one period along the axes that count as periodic: the cells between them hold
/// everything once, and those around the whole box would hold some of it twice.
fn one_period(
    particles: &Particles,
    periodic: Periodic,
    (mut low, mut high): ([f64; 3], [f64; 3]),
) -> ([f64; 3], [f64; 3]) {
    if let Some(domain) = particles.domain() {
        let axes = match periodic {
            Periodic::Auto => domain.periodic(),
            Periodic::Given(axes) => axes,
        };
        for k in (0..3).filter(|&k| axes[k]) {
            (low[k], high[k]) = (domain.low()[k], domain.high()[k]);
        }
    }
    (low, high)
}

/// The box, or the space that the particles take up where there is none.
fn bounds_of(particles: &Particles) -> anyhow::Result<([f64; 3], [f64; 3])> {
    if let Some(domain) = particles.domain() {
        return Ok(domain.bounds());
    }
    if particles.is_empty() {
        bail!("the first frame holds no particle and states no box to lay cells over; give --grid, or other --frames");
    }
    let radii = particles.radii()?;
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (p, r) in particles.positions().iter().zip(radii) {
        for k in 0..3 {
            low[k] = low[k].min(p[k] - r);
            high[k] = high[k].max(p[k] + r);
        }
    }
    Ok((low, high))
}
