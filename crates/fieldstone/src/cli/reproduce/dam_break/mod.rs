//! Tables 1–3 of the paper on free-surface detection: four methods on the flows of three dam breaks.

mod picture;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{anyhow, bail};
use clap::{Args, ValueEnum};
use fieldstone::io::AtomicFile;
use fieldstone::sph::{Case, SHIPPED, Solver};
use fieldstone::surface::{Comparison, Exact, Haque, Marrone, SurfaceDetection, Wang};

use self::picture::Panel;
use super::progress;
use super::sections::make_folder;
use crate::cli::{arguments, report};

/// Free-surface detection in dam breaks: Liu et al. (2022), Tables 1 to 3
///
/// Runs each flow with the exact detection in its shifting, and compares the methods of Haque, Marrone and Wang with
/// the exact labels at the paper's times. Leaves tables.csv, a picture per flow and time (red free surface, blue inner,
/// green misidentified), and index.md. The counts depend on the flow, the accuracies M hardly.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:\n  \
    fieldstone reproduce dam-break validation --slab --spacing 0.03 --only table1\n  \
    fieldstone reproduce dam-break validation --slab --spacing 0.01")]
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
    /// Only these tables
    #[arg(long, value_name = "TABLES", value_delimiter = ',', value_enum)]
    only: Vec<Table>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Table {
    /// Dam break at 0.6, 1.45 and 1.8 s
    Table1,
    /// Two columns at 0, 0.4 and 0.8 s
    Table2,
    /// Obstacle at 0, 0.4 and 0.7 s
    Table3,
}

/// The paper's TP, and M of Haque, Marrone and Wang, at a time.
struct Printed {
    time: f64,
    reference: usize,
    accuracy: [f64; 3],
}

impl Table {
    fn printed(self) -> [Printed; 3] {
        let rows = match self {
            Self::Table1 => [
                (0.6, 10_440, [0.701, 0.842, 0.842]),
                (1.45, 13_380, [0.663, 0.717, 0.724]),
                (1.8, 19_380, [0.721, 0.780, 0.766]),
            ],
            Self::Table2 => [
                (0.0, 16_882, [1.0, 1.0, 1.0]),
                (0.4, 17_274, [0.948, 0.959, 0.962]),
                (0.8, 38_281, [0.610, 0.686, 0.681]),
            ],
            Self::Table3 => [
                (0.0, 16_680, [1.0, 1.0, 1.0]),
                (0.4, 37_647, [0.676, 0.733, 0.738]),
                (0.7, 71_173, [0.657, 0.633, 0.670]),
            ],
        };
        rows.map(|(time, reference, accuracy)| Printed { time, reference, accuracy })
    }

    fn title(self) -> &'static str {
        match self {
            Self::Table1 => "Table 1: dam break",
            Self::Table2 => "Table 2: two columns at opposite corners",
            Self::Table3 => "Table 3: impact against an obstacle",
        }
    }

    fn file(self) -> &'static str {
        match self {
            Self::Table1 => "table1",
            Self::Table2 => "table2",
            Self::Table3 => "table3",
        }
    }

    fn case(self, spacing: f64, slab: bool) -> anyhow::Result<Case> {
        let (name, spacing) = match self {
            Self::Table1 if slab => ("dam-break-slab", spacing),
            Self::Table1 => ("dam-break", spacing),
            Self::Table2 => ("double-dam-break", 2.0 * spacing),
            Self::Table3 => ("obstacle", 0.5 * spacing),
        };
        let Some(shipped) = SHIPPED.iter().find(|c| c.name == name) else { bail!("no case {name}") };
        shipped.at_spacing(Some(spacing)).map_err(|e| anyhow!("--spacing: {e}"))
    }

    /// Layers across the flow, where all are alike.
    fn layers(self, slab: bool, spacing: f64) -> Option<f64> {
        match self {
            Self::Table1 if slab => Some(9.0),
            Self::Table1 => Some((0.3 / spacing).round()),
            _ => None,
        }
    }
}

const NAMES: [&str; 3] = ["Haque", "Marrone", "Wang"];

impl DamBreak {
    pub(super) fn run(self) -> anyhow::Result<()> {
        make_folder(&self.folder)?;
        let mut page = String::from(
            "# Free-surface detection in dam breaks\n\nTables 1 to 3 of Liu et al. (2022), computed anew by `fieldstone \
             reproduce dam-break`: TP free-surface particles by the exact method, EP misidentified ones (misses + false \
             positives), M = (TP − EP)/TP. The flow is computed with shifting by the exact detection. Numbers of \
             particles depend on spacing and flow; the paper's are quoted for comparison.\n\n",
        );
        let mut rows = String::from("table,time,method,tp,misses,false_positives,m,paper_m\n");
        for &table in Table::value_variants() {
            if self.only.is_empty() || self.only.contains(&table) {
                page.push_str(&self.table(table, &mut rows)?);
            }
        }
        AtomicFile::write(&self.folder.join("tables.csv"), |out| out.write_all(rows.as_bytes()))?;
        let path = self.folder.join("index.md");
        AtomicFile::write(&path, |out| out.write_all(page.as_bytes()))?;
        report::print(&format!("written to           {}\n", path.display()))
    }

    fn table(&self, table: Table, rows: &mut String) -> anyhow::Result<String> {
        let start = Instant::now();
        let case = table.case(self.spacing, self.slab)?;
        let mut solver = case.solver()?;
        let spacing = case.sections.spacing;
        let layers = table.layers(self.slab, spacing);
        let printed = table.printed();
        let end = printed[2].time;
        let bar = progress(1000, table.file())?;
        let mut text = String::new();
        for row in &printed {
            while solver.time() < row.time {
                solver.step()?;
                bar.set_position((1000.0 * solver.time() / end) as u64);
            }
            let (reference, others) = label(&solver)?;
            let picture = format!("{}_{:.2}s.png", table.file(), row.time);
            draw(&self.folder.join(&picture), &solver, table, row.time, &reference, &others)?;
            let mut line = format!("| {:.3} s |", solver.time());
            for ((name, labels), paper) in NAMES.iter().zip(&others).zip(row.accuracy) {
                let c = Comparison::new(&reference, labels)?;
                let m = c.accuracy().unwrap_or(f64::NAN);
                let (tp, ep) = (c.reference, c.misidentified());
                let _ = write!(line, " {tp}/{ep} ({} + {})/{m:.3}, paper {paper:.3} |", c.misses, c.false_positives);
                let _ = writeln!(
                    rows,
                    "{},{},{name},{tp},{},{},{m:.6},{paper}",
                    table.file(),
                    solver.time(),
                    c.misses,
                    c.false_positives
                );
            }
            let tp = reference.iter().filter(|&&l| l).count();
            if let Some(layers) = layers {
                let (ours, paper) = (tp as f64 / layers, row.reference as f64 / 30.0);
                let _ = write!(line, " {ours:.0} per layer, paper {paper:.0} |");
            } else {
                let _ = write!(line, " {tp}, paper {} |", row.reference);
            }
            let _ = writeln!(text, "{line}");
        }
        bar.finish_and_clear();
        let mut section = format!("## {}\n\n", table.title());
        let _ = writeln!(
            section,
            "Case `{}`, Δx = {spacing}, {} particles, {} steps in {:.0} s on {} threads. TP/EP (misses + false \
             positives)/M:\n\n| time | {} | free surface |\n|---|---|---|---|---|",
            case.sections.title,
            solver.state().len(),
            solver.steps(),
            start.elapsed().as_secs_f64(),
            rayon::current_num_threads(),
            NAMES.join(" | "),
        );
        section.push_str(&text);
        section.push('\n');
        for row in &printed {
            let _ = writeln!(section, "![at {:.2} s]({}_{:.2}s.png)", row.time, table.file(), row.time);
        }
        section.push('\n');
        Ok(section)
    }
}

/// Exact labels, and those of Haque, Marrone and Wang.
fn label(solver: &Solver) -> anyhow::Result<(Vec<bool>, [Vec<bool>; 3])> {
    let by = |method: &dyn SurfaceDetection| solver.labels(method);
    Ok((by(&Exact::default())?, [by(&Haque::default())?, by(&Marrone::default())?, by(&Wang::default())?]))
}

fn draw(
    path: &Path,
    solver: &Solver,
    table: Table,
    time: f64,
    reference: &[bool],
    others: &[Vec<bool>; 3],
) -> anyhow::Result<()> {
    let mut panels: Vec<Panel<'_>> =
        NAMES.iter().zip(others).map(|(name, labels)| Panel { title: format!("{name}, {time} s"), labels }).collect();
    panels.push(Panel { title: format!("exact, {time} s"), labels: reference });
    // The nearest layers of a flow that does not vary across; all of the others, the nearest ones last.
    let depth = if table == Table::Table1 { solver.flow().fluid.spacing } else { f64::INFINITY };
    picture::draw(path, solver, depth, reference, &panels)
}
