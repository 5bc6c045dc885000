//! `fieldstone plot`: pictures of fields.

mod canvas;
mod data;
mod profile;
mod slice;

use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{anyhow, bail};
use clap::Args;
use fieldstone::fields::FieldName;
use fieldstone::mesh::Cells;

use super::arguments::ending;
use super::{outputs, report};
use data::{Lattice, Places, Plotted, known_field, read};
use profile::{ProfilePicture, means};
use slice::SlicePicture;

/// A picture of a field: a slice as a colour map, or a profile over one coordinate
///
/// Profiles are means over the other coordinates: by mass for velocities and other quantities per mass where the file
/// has the density (for a species its own), else by volume. Fields on the nodes of a .vti, as of fieldstone grid, are
/// taken for what is nearest to each node; nodes without fluid count with the 0 that they hold.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:\n  \
    fieldstone plot chute.vti --field velocity --component x --slice y=0.02\n  \
    fieldstone plot chute.vti --field density --profile z --out density.svg\n  \
    fieldstone plot box.stat --field contact_stress --component zz --profile z")]
pub(crate) struct Plot {
    /// Result of fieldstone fields, fraction or grid: .vti, .vtu, .pvd, .csv or .stat; .gz too
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Field to show, as in density or contact_stress
    #[arg(long, value_name = "NAME")]
    field: String,
    /// Component, as in x, zz or magnitude [default: the magnitude in slices, all in profiles]
    #[arg(long, value_name = "NAME")]
    component: Option<String>,
    /// Plane of a slice, as in z=0.1 [default: the middle of y, or the plane of the two resolved directions]
    #[arg(long, value_name = "AXIS=VALUE", conflicts_with = "profile", allow_hyphen_values = true)]
    slice: Option<Plane>,
    /// Coordinate of a profile: x, y, z, r (from the vertical axis through the middle), or height and angle of
    /// cylindrical cells
    #[arg(long, value_name = "AXIS")]
    profile: Option<String>,
    /// Bins of a profile where cells are in no rows: meshes, and r
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    bins: u32,
    /// Frame of a .pvd or .stat file, from 0; negative counts from the end
    #[arg(long, value_name = "K", default_value_t = -1, allow_negative_numbers = true)]
    frame: i64,
    /// Picture: .png or .svg [default: FILE's name with that of the field, as .png]
    #[arg(short, long, value_name = "OUT")]
    out: Option<PathBuf>,
}

/// A plane across an axis.
#[derive(Debug, Clone)]
struct Plane {
    axis: String,
    at: f64,
}

impl FromStr for Plane {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=').and_then(|(axis, at)| Some((axis.trim(), at.trim().parse::<f64>().ok()?)));
        match parts {
            Some((axis, at)) if !axis.is_empty() && at.is_finite() => Ok(Self { axis: axis.into(), at }),
            _ => Err(format!("'{text}' is no plane; give an axis and a value, as in z=0.1")),
        }
    }
}

/// What of a field is shown.
enum Shown {
    Component(usize),
    Magnitude,
}

impl Plot {
    pub fn run(self) -> anyhow::Result<()> {
        let out = self.out.clone().unwrap_or_else(|| {
            let compressed = ending(&self.file) == "gz";
            let plain = if compressed { self.file.with_extension("") } else { self.file.clone() };
            let stem = plain.file_stem().unwrap_or_default().to_string_lossy();
            let component = self.component.as_ref().map_or(String::new(), |c| format!("_{c}"));
            self.file.with_file_name(format!("{stem}_{}{component}.png", self.field))
        });
        if !matches!(ending(&out).as_str(), "png" | "svg") {
            bail!("--out {}: pictures are .png or .svg", out.display());
        }
        outputs::check("--out", &out, &[&self.file])?;
        let plotted = read(&self.file, &self.field, self.frame)?;
        let resolved = match &plotted.places {
            Places::Lattice(lattice) => lattice.counts().iter().filter(|n| **n > 1).count(),
            Places::Mesh(_) => 3,
        };
        match &self.profile {
            Some(axis) => canvas::save(&out, &self.profile(&plotted, axis)?)?,
            None if self.slice.is_none() && resolved < 2 => {
                let axis = match &plotted.places {
                    Places::Lattice(lattice) => {
                        let longest = (0..3).max_by_key(|&k| (lattice.counts()[k], k)).unwrap_or(2);
                        lattice.names[longest].clone()
                    }
                    Places::Mesh(_) => "z".into(),
                };
                canvas::save(&out, &self.profile(&plotted, &axis)?)?;
            }
            None => canvas::save(&out, &self.slice(&plotted)?)?,
        }
        report::print(&format!("written to           {}\n", out.display()))
    }

    fn shown(&self, plotted: &Plotted, name: &str) -> anyhow::Result<Shown> {
        if name == "magnitude" {
            return self.magnitude(plotted);
        }
        let at = plotted.components.iter().position(|component| component == name);
        at.map(Shown::Component).ok_or_else(|| {
            let names = plotted.components.join(", ");
            let found = match names.as_str() {
                "" => "it is a scalar".into(),
                _ if is_without_order(&plotted.components) => format!("there are {names}"),
                _ => format!("there are {names} and magnitude"),
            };
            anyhow!("--component {name}: {} has no such component; {found}", self.field)
        })
    }

    fn magnitude(&self, plotted: &Plotted) -> anyhow::Result<Shown> {
        if is_without_order(&plotted.components) {
            bail!(
                "--component magnitude: {} has six components without names, and which of a symmetric tensor's count twice is \
                 not known; choose one of {} (--component)",
                self.field,
                plotted.components.join(", ")
            );
        }
        Ok(Shown::Magnitude)
    }

    fn label(&self, shown: &Shown, plotted: &Plotted) -> String {
        let field = self.field.replace('_', " ");
        match shown {
            Shown::Component(k) => format!("{field} {}", plotted.components[*k]).trim_end().into(),
            Shown::Magnitude => format!("|{field}|"),
        }
    }

    fn slice(&self, plotted: &Plotted) -> anyhow::Result<SlicePicture> {
        let shown = match &self.component {
            Some(name) => self.shown(plotted, name)?,
            None if plotted.components.len() == 1 => Shown::Component(0),
            None => self.magnitude(plotted)?,
        };
        // Where nothing is, a mean of nothing is no value.
        let density = plotted.density.as_ref().filter(|_| is_per_mass(&self.field));
        let value = |cell: usize| density.is_none_or(|rho| rho[cell] > 0.0).then(|| value_of(plotted, cell, &shown));
        let (mut picture, name) = match &plotted.places {
            Places::Lattice(lattice) => {
                let (axis, at) = self.plane(lattice)?;
                let (picture, middle) = SlicePicture::of_lattice(lattice, axis, at, value)?;
                let averaged = lattice.counts()[axis] == 1;
                let edges = &lattice.edges[axis];
                let middle = canvas::tick(middle, [edges[0], edges[edges.len() - 1]]);
                let place = if averaged { String::new() } else { format!(", {} = {middle}", lattice.names[axis]) };
                (picture, place)
            }
            Places::Mesh(mesh) => {
                let (low, high) = mesh.bounds();
                let (axis, at) = match &self.slice {
                    Some(plane) => (axis_of(&["x", "y", "z"].map(String::from), &plane.axis, "slice")?, plane.at),
                    None => (1, 0.5 * (low[1] + high[1])),
                };
                let picture = SlicePicture::of_mesh(mesh, axis, at, value)?;
                (picture, format!(", {} = {}", ["x", "y", "z"][axis], canvas::tick(at, [low[axis], high[axis]])))
            }
        };
        picture.title = format!("{}{name}", self.label(&shown, plotted));
        Ok(picture)
    }

    fn plane(&self, lattice: &Lattice) -> anyhow::Result<(usize, f64)> {
        if let Some(plane) = &self.slice {
            return Ok((axis_of(&lattice.names, &plane.axis, "slice")?, plane.at));
        }
        let counts = lattice.counts();
        let axis = [1, 0, 2].into_iter().min_by_key(|&k| counts[k].min(2)).unwrap_or(1);
        let edges = &lattice.edges[axis];
        Ok((axis, 0.5 * (edges[0] + edges[edges.len() - 1])))
    }

    fn profile(&self, plotted: &Plotted, axis: &str) -> anyhow::Result<ProfilePicture> {
        let shown: Vec<Shown> = match &self.component {
            Some(name) => vec![self.shown(plotted, name)?],
            None => (0..plotted.components.len()).map(Shown::Component).collect(),
        };
        let (at, bins) = self.bins(plotted, axis)?;
        let by_mass = is_per_mass(&self.field);
        let density = plotted.density.as_ref().filter(|_| by_mass);
        let weight = |cell: usize| plotted.volumes[cell] * density.map_or(1.0, |density| density[cell]);
        let lines = shown.iter().map(|shown| {
            let cells = (bins.iter().enumerate())
                .filter_map(|(cell, bin)| Some((((*bin)?), weight(cell), value_of(plotted, cell, shown))));
            (self.label(shown, plotted), means(at.len(), cells))
        });
        let field = self.field.replace('_', " ");
        let by = if density.is_some() { "mass" } else { "volume" };
        Ok(ProfilePicture {
            title: format!("{field}, mean by {by}"),
            axis: axis.into(),
            lines: lines.collect(),
            at,
            upright: matches!(axis, "z" | "height"),
        })
    }

    /// Middles of the bins along a coordinate, and the bin of each cell.
    fn bins(&self, plotted: &Plotted, axis: &str) -> anyhow::Result<(Vec<f64>, Vec<Option<usize>>)> {
        let count = plotted.volumes.len();
        if let Places::Lattice(lattice) = &plotted.places
            && let Some(along) = lattice.names.iter().position(|name| name == axis)
        {
            let n = lattice.counts();
            let mut bins = vec![None; count];
            for (place, cell) in lattice.cells.iter().enumerate() {
                let at = [place % n[0], place / n[0] % n[1], place / (n[0] * n[1])];
                if let Some(cell) = cell {
                    bins[*cell as usize] = Some(at[along]);
                }
            }
            let at = lattice.edges[along].windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
            return Ok((at, bins));
        }
        let centres: Vec<[f64; 3]> = match &plotted.places {
            Places::Mesh(mesh) => (0..count).map(|cell| mesh.cell_centre(cell)).collect(),
            Places::Lattice(lattice) if lattice.names[0] == "x" => {
                let (n, middle) =
                    (lattice.counts(), |k: usize, i: usize| 0.5 * (lattice.edges[k][i] + lattice.edges[k][i + 1]));
                let mut centres = vec![[f64::NAN; 3]; count];
                for (place, cell) in lattice.cells.iter().enumerate() {
                    if let Some(cell) = cell {
                        let at = [place % n[0], place / n[0] % n[1], place / (n[0] * n[1])];
                        centres[*cell as usize] = [0, 1, 2].map(|k| middle(k, at[k]));
                    }
                }
                centres
            }
            Places::Lattice(lattice) => bail!("--profile {axis}: choose one of {}", lattice.names.join(", ")),
        };
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for c in &centres {
            (0..3).for_each(|k| (low[k], high[k]) = (low[k].min(c[k]), high[k].max(c[k])));
        }
        let values: Vec<f64> = match axis {
            "r" => {
                let middle = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
                centres.iter().map(|c| (c[0] - middle[0]).hypot(c[1] - middle[1])).collect()
            }
            _ => {
                let k = axis_of(&["x", "y", "z"].map(String::from), axis, "profile")?;
                centres.iter().map(|c| c[k]).collect()
            }
        };
        let (least, most) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
        let least = if axis == "r" { 0.0 } else { least };
        let (n, extent) = (self.bins as usize, (most - least).max(f64::MIN_POSITIVE));
        let bin = |v: &f64| Some((((v - least) / extent * n as f64) as usize).min(n - 1));
        let at = (0..n).map(|k| least + extent * (k as f64 + 0.5) / n as f64).collect();
        Ok((at, values.iter().map(bin).collect()))
    }
}

fn axis_of(names: &[String; 3], axis: &str, option: &str) -> anyhow::Result<usize> {
    names.iter().position(|name| name == axis).ok_or_else(|| {
        let r = if option == "profile" && names[0] == "x" { " or r" } else { "" };
        anyhow!("--{option} {axis}: choose one of {}{r}", names.join(", "))
    })
}

fn value_of(plotted: &Plotted, cell: usize, shown: &Shown) -> f64 {
    match shown {
        Shown::Component(k) => plotted.value(cell, *k),
        Shown::Magnitude => {
            let squares = plotted.components.iter().enumerate().map(|(k, name)| {
                // Of a symmetric tensor one of two equal components is there.
                let twice = plotted.components.len() == 6 && matches!(name.as_str(), "xy" | "xz" | "yz");
                plotted.value(cell, k).powi(2) * if twice { 2.0 } else { 1.0 }
            });
            squares.sum::<f64>().sqrt()
        }
    }
}

/// Whether a field is a quotient by the density.
fn is_per_mass(field: &str) -> bool {
    matches!(known_field(field), Some(FieldName::Velocity | FieldName::GranularTemperature | FieldName::Displacement))
}

/// Whether components are those of a symmetric tensor in an order that nobody knows.
fn is_without_order(components: &[String]) -> bool {
    components.len() == 6 && !components.iter().any(|name| name == "xy")
}
