//! `fieldstone reproduce overlap`: the figures of Strobl, Formella and Pöschel (2016).

mod approximations;
mod fig10;
mod fig11;
mod fig12;
mod fig9;
mod meshes;
mod misses;
mod page;
mod samples;
mod sec52;

use std::path::PathBuf;

use anyhow::bail;
use clap::{Args, ValueEnum};

use self::samples::Schedule;
use super::sections::{compute, make_folder, write_page};
use super::{clock, plots, progress};

/// Overlap of spheres and mesh elements: Strobl, Formella and Pöschel (2016), Sec. 5
///
/// Leaves one table (CSV) and one picture (PNG) per figure, and index.md, which says what agrees and what is better.
/// The tables are the same for any number of threads, times excepted.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:\n  \
    fieldstone reproduce overlap validation\n  \
    fieldstone reproduce overlap validation --only fig10,fig11 --samples 100")]
pub(super) struct Overlap {
    /// Folder for the results; made where it is missing
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Spheres per radius up to 1; a tenth of it up to 4, a fiftieth above
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    samples: u32,
    /// The paper's 100,000 spheres at every radius: takes months of processor time
    #[arg(long, conflicts_with = "samples")]
    full: bool,
    /// Only these figures, e.g. fig10,fig11
    #[arg(long, value_name = "FIGURES", value_delimiter = ',', value_enum)]
    only: Vec<Figure>,
    /// Radii of Fig. 10 and 11 [default: 41 from 0.05 to 20, equally spaced on a logarithmic axis]
    #[arg(long, value_name = "R,R,…", value_delimiter = ',')]
    radii: Vec<f64>,
}

/// What can be computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Figure {
    /// The two meshes
    Fig9,
    /// Error over the radius, six meshes
    Fig10,
    /// Error over the radius, ten angles of shear
    Fig11,
    /// Time per sphere over the radius
    Fig12,
    /// Time for 45,000 particles
    Sec52,
    /// Approximations as a ball crosses a cell
    Approximations,
}

/// What every figure needs to know.
struct Settings {
    folder: PathBuf,
    schedule: Schedule,
    radii: Vec<f64>,
    /// Whether the radii are those of the paper.
    paper_radii: bool,
}

impl Overlap {
    pub fn run(self) -> anyhow::Result<()> {
        if let Some(radius) = self.radii.iter().find(|r| !(1e-3..=20.0).contains(*r)) {
            bail!("--radii: {radius} is out of range; radii from 0.001 to 20 sides of a cell are possible");
        }
        make_folder(&self.folder)?;
        let paper_radii = self.radii.is_empty();
        let settings = Settings {
            folder: self.folder,
            schedule: if self.full { Schedule::Full } else { Schedule::Thinned(self.samples) },
            radii: if paper_radii { samples::paper_radii() } else { self.radii },
            paper_radii,
        };
        let sections = compute(&self.only, |figure| match figure {
            Figure::Fig9 => fig9::run(&settings),
            Figure::Fig10 => fig10::run(&settings),
            Figure::Fig11 => fig11::run(&settings),
            Figure::Fig12 => fig12::run(&settings),
            Figure::Sec52 => sec52::run(&settings),
            Figure::Approximations => approximations::run(&settings),
        })?;
        write_page(&settings.folder, page::head(&settings, &sections), &sections)
    }
}
