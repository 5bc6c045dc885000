//! Flows that were measured, beside the measurements: no time is shifted.
//!
//! Buchner's and SPHERIC's go without particle shifting, with which the pressure on Buchner's wall rises later and stays lower; the
//! column has it, or gaps open in the water that slows down. The column's floor has friction, with the one viscosity that was chosen with
//! the curves at hand, whatever the spacing.

mod buchner;
mod column;
mod data;
mod spheric_2;
mod tall_structure;

use std::path::Path;

use fieldstone::sph::Case;
use plotters::style::RGBColor;

use self::data::Curved;
use super::flow_run::{FlowRun, Flows};
use crate::cli::reproduce::plots::{COLOURS, Curve, Plot};

/// A flow with measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Experiment {
    Column,
    Buchner,
    Spheric2,
    TallStructure,
}

impl Experiment {
    /// Files with its measurements.
    pub fn files(self) -> &'static [&'static str] {
        match self {
            Self::Column => &[
                "koshizuka_oka_1996_front.txt",
                "pysph_ko_data.txt",
                "pysph_mm_data_1.txt",
                "pysph_mm_data_2.txt",
                "martin_moyce_1952_tables_2_6.txt",
            ],
            Self::Buchner => &["buchner2002_pressure.txt"],
            Self::Spheric2 => &["spheric_test2_kleefsman.dat.gz"],
            Self::TallStructure => &["pysph_yeh_and_petroff_force_data.txt", "pysph_yeh_and_petroff_v_data.txt"],
        }
    }

    /// Its section of the page, with measurements from the folder `data`; spacings are those of the cases over `refinement`.
    pub fn section(self, flows: &Flows, refinement: f64, folder: &Path, data: &Path) -> anyhow::Result<String> {
        let run = |name: &str, text: &str| -> anyhow::Result<FlowRun> {
            let mut case = Case::parse(text, name)?;
            case.sections.spacing /= refinement;
            let end = case.sections.time.end;
            flows.run(name, case, &[end], &[])
        };
        let (name, text) = match self {
            Self::Column => ("column", include_str!("column.toml")),
            Self::Buchner => ("buchner", include_str!("buchner.toml")),
            Self::Spheric2 => ("spheric-2", include_str!("spheric-2.toml")),
            Self::TallStructure => ("tall-structure", include_str!("tall-structure.toml")),
        };
        let flow = run(name, text)?;
        match self {
            Self::Column => column::section(&flow, folder, data),
            Self::Buchner => buchner::section(&flow, folder, data),
            Self::Spheric2 => {
                let slice = run("spheric-2-slice", include_str!("spheric-2-slice.toml"))?;
                spheric_2::section(&flow, &slice, folder, data)
            }
            Self::TallStructure => tall_structure::section(&flow, folder, data),
        }
    }
}

/// A computed curve, a full line.
fn computed(name: &str, points: &Curved) -> Curve {
    Curve { name: name.into(), points: points.clone(), colour: COLOURS[0], dashed: false }
}

/// A measured curve, dashed.
fn measured(name: &str, points: &Curved, colour: RGBColor) -> Curve {
    Curve { name: name.into(), points: points.clone(), colour, dashed: true }
}

/// A plot of what lies between the ends of its first axis.
fn clipped(mut plot: Plot) -> Plot {
    let [low, high] = plot.x.range;
    for curve in &mut plot.curves {
        curve.points.retain(|p| (low..=high).contains(&p.0));
    }
    plot
}

/// "−3.1 %".
fn percent(ratio: f64) -> String {
    format!("{:+.1} %", 100.0 * ratio).replace('-', "−")
}
