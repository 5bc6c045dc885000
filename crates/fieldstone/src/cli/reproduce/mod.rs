//! `fieldstone reproduce`: published figures, computed anew.

mod clock;
mod dam_break;
mod overlap;
pub(crate) mod plots;
mod random;
mod sections;
mod surface;

use clap::{Args, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};

use super::report;

/// Compute the figures of a publication anew
#[derive(Debug, Args)]
pub(crate) struct Reproduce {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    Overlap(overlap::Overlap),
    Surface(surface::SurfaceFigures),
    DamBreak(dam_break::DamBreak),
}

impl Reproduce {
    pub fn run(self) -> anyhow::Result<()> {
        match self.what {
            What::Overlap(overlap) => overlap.run(),
            What::Surface(surface) => surface.run(),
            What::DamBreak(dam_break) => dam_break.run(),
        }
    }
}

/// Progress on standard error, where that is a terminal.
fn progress(steps: u64, what: &str) -> anyhow::Result<ProgressBar> {
    let style = ProgressStyle::with_template("{msg:<10} {bar:30} {percent:>3} %  {eta} left")?;
    Ok(ProgressBar::new(steps).with_style(style).with_message(what.to_string()))
}
