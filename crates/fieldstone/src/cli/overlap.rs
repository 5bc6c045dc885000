//! `fieldstone overlap`: a table of balls and elements.

use std::path::PathBuf;

use anyhow::{Context, anyhow, bail};
use clap::{Args, ValueEnum};
use fieldstone::fields::{Method, Weights};
use fieldstone::geometry::{Ball, CornerOrder, ElementKind, Orientation, Polyhedron, Precision, certified_overlap};
use fieldstone::io::{CsvTable, CsvWriter};
use fieldstone::mesh::{CellList, Mesh};
use fieldstone::particles::Particles;
use rayon::prelude::*;

use super::{outputs, report};

/// Exact overlap of spheres with single elements, row by row of a table
///
/// The table has the columns cx cy cz r x0 y0 z0 x1 y1 z1 …, in any order; other columns are carried through. Added are
/// volume, and with --method kernel, the default, sphere_area, one area per face (f0_area …, faces in CGNS numbering) and the
/// gradient of the volume with respect to the centre.
#[derive(Debug, Args)]
#[command(after_long_help = "Example:\n  \
    fieldstone overlap --element hex --cases hexahedra.csv --order cgns --out overlaps.csv\n\n\
    Units: all lengths as in the table; areas and the gradient are their squares, volumes their cubes.")]
pub(crate) struct OverlapCases {
    /// Kind of element in every row
    #[arg(long, value_enum)]
    element: Element,
    /// Table of cases (.csv, .csv.gz)
    #[arg(long, value_name = "FILE")]
    cases: PathBuf,
    /// Result table (.csv): the columns of the cases, then the results
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// kernel, kernel-f64, decomposition, centre, cube, divided, sampled:N or monte-carlo:N; see fieldstone fraction --help
    ///
    /// All but kernel give the volume alone.
    #[arg(long, default_value = "kernel")]
    method: Method,
    /// Order of the corners
    #[arg(long, value_enum, default_value = "vtk")]
    order: Order,
    /// Add a column volume_error: a bound of the error of each volume
    #[arg(long)]
    bound: bool,
    /// Elements that are inside out
    #[arg(long, value_enum, default_value = "fix")]
    orientation: Inverted,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Element {
    Tet,
    Pyramid,
    Wedge,
    Hex,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Order {
    /// as in VTK up to 9.6: a wedge's first triangle is wound outwards; else as CGNS
    Vtk,
    /// as in CGNS: the first face is wound inwards
    Cgns,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Inverted {
    /// turn them
    Fix,
    /// stop with an error
    Refuse,
}

impl OverlapCases {
    pub fn run(self) -> anyhow::Result<()> {
        let kind = match self.element {
            Element::Tet => ElementKind::Tetrahedron,
            Element::Pyramid => ElementKind::Pyramid,
            Element::Wedge => ElementKind::Wedge,
            Element::Hex => ElementKind::Hexahedron,
        };
        let order = match self.order {
            Order::Vtk => CornerOrder::Vtk,
            Order::Cgns => CornerOrder::Cgns,
        };
        let orientation = match self.orientation {
            Inverted::Fix => Orientation::Fix,
            Inverted::Refuse => Orientation::Refuse,
        };
        if self.method == Method::CentreSmoothed {
            bail!("--method centre-smoothed averages over neighbours, and a single element has none");
        }
        if self.bound && self.method != Method::Kernel {
            bail!("--bound goes with --method kernel; the other methods know no bound of their error");
        }
        outputs::check("--out", &self.out, &[&self.cases])?;
        let table = CsvTable::read(&self.cases)?;
        let corner_count = kind.corner_count().unwrap_or(0);
        if table.has(&format!("x{corner_count}")) {
            bail!(
                "{}: there is a column 'x{corner_count}', but a {kind} has only the corners 0 to {}; choose another --element",
                self.cases.display(),
                corner_count - 1
            );
        }
        let column = |name: &str| table.column(name);
        let centre = [column("cx")?, column("cy")?, column("cz")?];
        let radius = column("r")?;
        let corners: Vec<[Vec<f64>; 3]> = (0..corner_count)
            .map(|k| Ok([column(&format!("x{k}"))?, column(&format!("y{k}"))?, column(&format!("z{k}"))?]))
            .collect::<anyhow::Result<_>>()?;

        let mut names = vec!["volume".to_string()];
        if self.method == Method::Kernel {
            names.push("sphere_area".into());
            names.extend((0..kind.faces().len()).map(|f| format!("f{f}_area")));
            names.extend(["gradient_x", "gradient_y", "gradient_z"].map(String::from));
            if self.bound {
                names.push("volume_error".into());
            }
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        if let Some(name) = names.iter().find(|name| table.has(name)) {
            bail!(
                "{}: there is a column '{name}' already, and one of that name is to be added; rename or remove it",
                self.cases.display()
            );
        }
        let rows: Vec<(u64, &str)> = table.rows().collect();
        let case = |row: usize| -> anyhow::Result<(Vec<f64>, Option<Precision>)> {
            let place = || format!("{}:{}", self.cases.display(), rows[row].0);
            let at = |columns: &[Vec<f64>; 3]| [columns[0][row], columns[1][row], columns[2][row]];
            let ball = Ball::new(at(&centre), radius[row]).map_err(|e| anyhow!("{}: {e}", place()))?;
            let points: Vec<[f64; 3]> = corners.iter().map(at).collect();
            let element = Polyhedron::element(kind, order, &points, orientation)
                .map_err(|e| anyhow!("{}: {e}\n  check the coordinates, --element and --order", place()))?;
            if self.method != Method::Kernel {
                let volume = self.by_other_method(kind, order, points, &ball).with_context(place)?;
                return Ok((vec![volume], None));
            }
            let certified = certified_overlap(&ball, &element);
            let result = certified.overlap;
            let mut numbers = vec![result.volume, result.sphere_area];
            numbers.extend(result.face_areas);
            // A ball that reaches nothing has a gradient of zero, of either sign.
            numbers.extend(result.gradient.map(|x| x + 0.0));
            if self.bound {
                numbers.push(certified.volume_error);
            }
            Ok((numbers, Some(certified.precision)))
        };
        // All rows before the file is begun: where one fails, or the run is broken off, nothing is left behind.
        let results: Vec<anyhow::Result<(Vec<f64>, Option<Precision>)>> =
            (0..rows.len()).into_par_iter().map(case).collect();
        // The first row that failed, whatever the number of threads.
        let results: Vec<(Vec<f64>, Option<Precision>)> = results.into_iter().collect::<anyhow::Result<_>>()?;
        let mut writer = CsvWriter::extending(&self.out, &table, &names)?;
        for ((_, row), (numbers, _)) in rows.iter().zip(&results) {
            writer.row_extending(row, numbers)?;
        }
        writer.finish()?;
        let beyond = results.iter().filter(|r| r.1.is_some_and(|p| p > Precision::F64)).count();
        let beyond = match self.method {
            Method::Kernel => format!("beyond 64 bits       {beyond}\n"),
            _ => String::new(),
        };
        report::print(&format!(
            "cases                {}\n{beyond}written to           {}\n",
            table.len(),
            self.out.display()
        ))
    }

    /// The element as a mesh of one cell, so that every method of `fraction` serves here too.
    fn by_other_method(
        &self,
        kind: ElementKind,
        order: CornerOrder,
        points: Vec<[f64; 3]>,
        ball: &Ball,
    ) -> anyhow::Result<f64> {
        let mut cells = CellList::new();
        let labels: Vec<u32> = (0..points.len() as u32).collect();
        cells.push(kind, order, &labels)?;
        let mesh = Mesh::from_cells(points, cells)?;
        let one = Particles::new(vec![ball.centre()])?.with_uniform_radius(ball.radius())?;
        let weights = Weights::build(&mesh, &one, self.method, None)?;
        // From 0.0: the sum of nothing is -0.0.
        Ok(weights.row(0).1.iter().fold(0.0, |sum, volume| sum + volume))
    }
}
