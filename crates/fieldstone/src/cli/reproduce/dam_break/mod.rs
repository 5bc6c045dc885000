//! `fieldstone reproduce dam-break`: Sec. 4.2 to 4.4 of the paper on free-surface detection, on flows computed here.

mod cone_angle;
mod flow_run;
mod measured;
mod middle_slice;
mod picture;
mod shaded;
mod shifting;
mod tables;
mod times;
mod visualization;
mod window;

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::{Args, ValueEnum};
use fieldstone::io::AtomicFile;

use self::flow_run::{Changes, Flows, IntegratorName};
use self::measured::Experiment;
use self::tables::Table;
use super::sections::make_folder;
use crate::cli::{arguments, report, sph};

/// Free-surface detection in dam breaks: Liu et al. (2022), Sec. 4.2 to 4.4
///
/// Runs each flow with the exact detection in its shifting, and compares the methods of Haque, Marrone and Wang with
/// the exact labels at the paper's times. Leaves tables (CSV), pictures (red free surface, blue inner, green
/// misidentified), and index.md. The counts depend on the flow, the accuracies M hardly. Flows are kept in DIR/flows with
/// checkpoints: stopped at any time, the same command goes on.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:\n  \
    fieldstone reproduce dam-break validation --slab --spacing 0.03 --only table1\n  \
    fieldstone reproduce dam-break validation --slab --spacing 0.01 --integrator rk4 --cfl 1.5\n  \
    fieldstone reproduce dam-break validation --only column,buchner --measurements measured")]
pub(super) struct DamBreak {
    /// Folder for the results; made where it is missing
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Spacing of the dam break of Table 1; Table 2 uses twice, Table 3 half of it, as in the paper (0.01)
    #[arg(long, value_name = "DX", default_value_t = 0.02, value_parser = arguments::positive)]
    spacing: f64,
    /// A slab of nine layers, periodic across, for Table 1 instead of the whole tank
    #[arg(long)]
    slab: bool,
    /// Time integrator, instead of the case's
    #[arg(long, value_enum)]
    integrator: Option<IntegratorName>,
    /// CFL number, instead of the case's; the shift per step goes with it
    #[arg(long, value_name = "C", value_parser = arguments::positive)]
    cfl: Option<f64>,
    /// Artificial viscosity α, instead of the case's; the paper does not say its own
    #[arg(long, value_name = "A", value_parser = arguments::not_negative)]
    alpha: Option<f64>,
    /// Shifting by Eq. 11 to the letter: near the surface only particles closer than the nearest free-surface one count
    #[arg(long)]
    eq11_as_printed: bool,
    /// Folder with measurements, for column, buchner, spheric2 and structure: the files are named where one is missing
    #[arg(long, value_name = "FOLDER")]
    measurements: Option<PathBuf>,
    /// Spacings of the measured flows are divided by this; their arithmetic grows with its third power, in three dimensions with
    /// its fourth
    #[arg(long, value_name = "N", default_value_t = 1.0, value_parser = arguments::positive)]
    refinement: f64,
    /// Only these parts; the page keeps the others of earlier calls
    #[arg(long, value_name = "PARTS", value_delimiter = ',', value_enum)]
    only: Vec<Part>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// Dam break at 0.6, 1.45 and 1.8 s, with Fig. 10
    #[value(alias = "fig10")]
    Table1,
    /// One layer in the right-hand window
    Fig11,
    /// Cones of 66.5, 56 and 45 degrees
    Fig12,
    /// Times of detection
    Fig13,
    /// Two columns at 0, 0.4 and 0.8 s, with Fig. 14
    #[value(alias = "fig14")]
    Table2,
    /// Obstacle at 0, 0.4 and 0.7 s, with Fig. 15
    #[value(alias = "fig15")]
    Table3,
    /// Free surface and pressure
    Fig16,
    /// Shifting by Wang's and by the exact detection, to 2.97 s
    Fig18,
    /// Front and height of a column against measurements
    Column,
    /// Pressure on a wall against Buchner's measurement
    Buchner,
    /// Pressure on a box and water levels against SPHERIC test 2
    Spheric2,
    /// Force on a tall structure against the measurement of Yeh and Petroff
    Structure,
}

impl Part {
    fn experiment(self) -> Option<Experiment> {
        match self {
            Self::Column => Some(Experiment::Column),
            Self::Buchner => Some(Experiment::Buchner),
            Self::Spheric2 => Some(Experiment::Spheric2),
            Self::Structure => Some(Experiment::TallStructure),
            _ => None,
        }
    }
}

impl DamBreak {
    pub(super) fn run(mut self) -> anyhow::Result<()> {
        if self.only.is_empty() {
            let measured = self.measurements.is_some();
            self.only =
                Part::value_variants().iter().copied().filter(|p| measured || p.experiment().is_none()).collect();
        }
        if let (None, Some(part)) = (&self.measurements, self.only.iter().find(|p| p.experiment().is_some())) {
            bail!("--only {}: give the folder with the measurements, --measurements", name(*part));
        }
        // Before any flow is computed, which takes minutes.
        if let Some(measurements) = &self.measurements {
            let wanted = self.only.iter().filter_map(|part| part.experiment()).flat_map(Experiment::files);
            if let Some(missing) = wanted.map(|file| measurements.join(file)).find(|path| !path.is_file()) {
                bail!(
                    "--measurements: there is no file {}; leave its part out of --only, or get it",
                    missing.display()
                );
            }
        }
        let sections = self.folder.join("sections");
        make_folder(&sections)?;
        let flows = Flows {
            folder: self.folder.clone(),
            changes: Changes {
                integrator: self.integrator,
                cfl: self.cfl,
                alpha: self.alpha,
                eq11_as_printed: self.eq11_as_printed,
            },
            interrupt: sph::stop_on_ctrl_c()?,
        };
        for &part in Part::value_variants().iter().filter(|p| self.only.contains(p)) {
            let text = self.section(part, &flows)?;
            let path = sections.join(name(part)).with_extension("md");
            AtomicFile::write(&path, |out| out.write_all(text.as_bytes()))?;
            self.write_page(&sections)?;
        }
        report::print(&format!("written to           {}\n", self.folder.join("index.md").display()))
    }

    fn section(&self, part: Part, flows: &Flows) -> anyhow::Result<String> {
        let folder = self.folder.as_path();
        let table = |table: Table| table.section(flows, folder, self.spacing, self.slab);
        let dam_break = || tables::dam_break(flows, self.spacing, self.slab, &[]);
        match part {
            Part::Table1 => table(Table::DamBreak),
            Part::Table2 => table(Table::TwoColumns),
            Part::Table3 => table(Table::Obstacle),
            Part::Fig11 => window::section(&dam_break()?, folder),
            Part::Fig12 => cone_angle::section(&dam_break()?, folder),
            Part::Fig13 => times::section(flows, folder, self.spacing, self.slab),
            Part::Fig16 => visualization::section(&dam_break()?, folder),
            Part::Fig18 => shifting::section(flows, folder, self.spacing, self.slab),
            Part::Column | Part::Buchner | Part::Spheric2 | Part::Structure => {
                let (Some(experiment), Some(data)) = (part.experiment(), &self.measurements) else {
                    return Ok(String::new());
                };
                experiment.section(flows, self.refinement, folder, data)
            }
        }
    }

    /// The page with all sections that there are, of this call and of earlier ones.
    fn write_page(&self, sections: &Path) -> anyhow::Result<()> {
        let mut page = String::from(HEAD);
        for &part in Part::value_variants() {
            if let Ok(text) = std::fs::read_to_string(sections.join(name(part)).with_extension("md")) {
                page.push_str(&text);
            }
        }
        let path = self.folder.join("index.md");
        Ok(AtomicFile::write(&path, |out| out.write_all(page.trim_end().as_bytes()).and_then(|()| writeln!(out)))?)
    }
}

fn name(part: Part) -> String {
    part.to_possible_value().map_or_else(String::new, |value| value.get_name().into())
}

const HEAD: &str = "# Free-surface detection in dam breaks\n\nSec. 4.2 to 4.4 of Liu et al. (2022), computed anew by \
    `fieldstone reproduce dam-break`: TP free-surface particles by the exact method, EP misidentified ones (misses + false \
    positives), M = (TP − EP)/TP. The flows are computed with shifting by the exact detection. Numbers of particles depend \
    on spacing and flow; the paper's are quoted for comparison. In pictures: red free surface, blue inner, green \
    misidentified particles.\n\n";
