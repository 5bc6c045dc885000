//! `fieldstone reproduce surface`: the free-surface figures of Liu et al. (2022).

mod lattice;
mod perturbed;
mod tables;
mod times;

use std::path::PathBuf;

use anyhow::bail;
use clap::{Args, ValueEnum};

use super::sections::{compute, make_folder, took, write_page};

/// Free-surface detection: Liu et al. (2022), Sec. 3.2, 4.1 and 4.2
///
/// Leaves a table (CSV) and, where there is something to see, a picture (PNG) per figure, and index.md, which says what
/// agrees. Labels are the same for any number of threads; times are of one thread.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:\n  \
    fieldstone reproduce surface validation\n  \
    fieldstone reproduce surface validation --only tables --frames dam_23.bgeo,dam_9.bgeo --spacing 0.05")]
pub(super) struct SurfaceFigures {
    /// Folder for the results; made where it is missing
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Frames for the table of methods, instead of blocks of a lattice with more and more disorder
    #[arg(long, value_name = "FILE,…", value_delimiter = ',', requires = "spacing")]
    frames: Vec<PathBuf>,
    /// Initial distance of the frames' particles: one for all, or one each
    #[arg(long, value_name = "DX,…", value_delimiter = ',')]
    spacing: Vec<f64>,
    /// Up to a million particles and the mean of ten detections, as in the paper (slow methods: one): some twenty minutes
    #[arg(long)]
    full: bool,
    /// Only these figures, e.g. fig6,fig7
    #[arg(long, value_name = "FIGURES", value_delimiter = ',', value_enum)]
    only: Vec<Figure>,
}

/// What can be computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Figure {
    /// Position divergence on the lattice
    Fig6,
    /// Perturbed surfaces of three angles, and the smallest visible angle (Eq. 31)
    Fig7,
    /// A perturbed surface with lost and aggregated inner particles
    Fig8,
    /// Methods beside each other on frames (layout of Tables 1 to 3)
    Tables,
    /// Time over the number of particles
    Fig13,
}

impl SurfaceFigures {
    pub fn run(self) -> anyhow::Result<()> {
        if !self.frames.is_empty() && self.spacing.len() != 1 && self.spacing.len() != self.frames.len() {
            bail!(
                "--spacing: {} numbers for {} frames; give one for all, or one each",
                self.spacing.len(),
                self.frames.len()
            );
        }
        if let Some(bad) = self.spacing.iter().find(|s| !(**s > 0.0 && s.is_finite())) {
            bail!("--spacing: {bad} is no distance; give a finite number above 0");
        }
        make_folder(&self.folder)?;
        let sections = compute(&self.only, |figure| match figure {
            Figure::Fig6 => lattice::run(&self.folder),
            Figure::Fig7 => perturbed::fig7(&self.folder),
            Figure::Fig8 => perturbed::fig8(&self.folder),
            Figure::Tables => tables::run(&self.folder, &self.frames, &self.spacing),
            Figure::Fig13 => times::run(&self.folder, self.full),
        })?;
        let (seconds, processor) = took(&sections);
        let head = format!(
            "# Free-surface detection\n\nFigures of W.-B. Liu et al. (2022), arXiv:2205.02742, computed anew. All numbers below come \
             from one run of `fieldstone reproduce surface`; the paper's are quoted from its text. The run took {seconds:.0} s, \
             {processor:.0} s of processor time.\n\n"
        );
        write_page(&self.folder, head, &sections)
    }
}
