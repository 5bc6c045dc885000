//! Fig. 7 and 8: two-dimensional surfaces with periodic perturbations; Eq. 31.

use std::path::Path;

use anyhow::{Result, anyhow};
use fieldstone::io::AtomicFile;
use fieldstone::surface::{
    Dilts, InnerParticles, Marrone, PerturbedSurface, Sun, SurfaceDetection, Surroundings, Wang,
};
use plotters::prelude::*;

use super::super::plots::{Area, save};

/// Particles from trough to crest.
const STEPS: usize = 3;
const PANEL: (u32, u32) = (460, 420);
const FREE: RGBColor = RGBColor(213, 40, 40);
const INNER: RGBColor = RGBColor(70, 110, 200);
const MISTAKEN: RGBColor = RGBColor(20, 160, 60);

/// A surface with the labels by one method.
struct Panel {
    title: String,
    surface: PerturbedSurface,
    labels: Vec<bool>,
    reference: Vec<bool>,
}

impl Panel {
    fn new(title: String, method: &dyn SurfaceDetection, surface: PerturbedSurface) -> Result<Self> {
        let labels = labels(method, &surface)?;
        // The scanning sector, which these figures are about.
        let reference = self::labels(&Sun::default(), &surface)?;
        Ok(Self { title, surface, labels, reference })
    }

    fn sees_trough(&self) -> bool {
        self.labels[self.surface.trough]
    }
}

fn labels(method: &dyn SurfaceDetection, surface: &PerturbedSurface) -> Result<Vec<bool>> {
    let surroundings = Surroundings { dimension: 2, ..Surroundings::new(1.0) };
    let grid = surroundings.grid(&surface.positions, method.reach(1.0))?;
    Ok(method.detect(&surroundings.scene(&grid))?.labels())
}

fn surface(degrees: f64, inner: InnerParticles) -> Result<PerturbedSurface> {
    Ok(PerturbedSurface::new(degrees.to_radians(), STEPS, inner)?)
}

pub(super) fn fig7(folder: &Path) -> Result<String> {
    let angles = [175.0, 130.0, 85.0];
    // What the paper says of the particle in the trough.
    let paper = [[true, false, false], [true, true, false]];
    let methods: [&dyn SurfaceDetection; 2] = [&Dilts::default(), &Sun::default()];
    let mut rows = Vec::new();
    for method in methods {
        let mut row = Vec::new();
        for degrees in angles {
            let title = format!("{}, {degrees}°", title(method));
            row.push(Panel::new(title, method, surface(degrees, InnerParticles::Uniform)?)?);
        }
        rows.push(row);
    }
    draw(&folder.join("fig7.png"), &rows)?;
    AtomicFile::write(&folder.join("fig7.csv"), |out| {
        writeln!(out, "method,angle,trough_is_free_surface,paper")?;
        for ((method, row), paper) in methods.iter().zip(&rows).zip(&paper) {
            for ((degrees, panel), paper) in angles.iter().zip(row).zip(paper) {
                writeln!(out, "{},{degrees},{},{paper}", method.name(), panel.sees_trough())?;
            }
        }
        Ok(())
    })?;
    let agree = rows.iter().flatten().zip(paper.as_flattened()).filter(|(panel, paper)| panel.sees_trough() == **paper);
    let mut text = format!(
        "## Perturbed surfaces (Fig. 7, Eq. 31)\n\n![Labels](fig7.png)\n\nRed: free surface; blue: inner; green: not as by \
         the scanning sector. The particle in the central trough is labelled as the paper says in {} of 6 cases.\n\n\
         The smallest angle of a trough that the exposed circle sees, 2 arccos(Δx / 2R), and the angles between which its \
         label changes here:\n\n| R/Δx | Eq. 31 | inner at | free at |\n|---|---|---|---|\n",
        agree.count()
    );
    AtomicFile::write(&folder.join("eq31.csv"), |out| writeln!(out, "radius,smallest_angle,inner_at,free_at"))?;
    let mut table = String::from("radius,smallest_angle,inner_at,free_at\n");
    for radius in [1.0, 1.25, 1.5, 1.75] {
        let method = Dilts { radius };
        let limit = method.smallest_visible_angle().to_degrees();
        // Bisect between angles whose labels are known to differ.
        let (mut inner, mut free) = (limit - 5.0, limit + 5.0);
        for _ in 0..24 {
            let middle = 0.5 * (inner + free);
            let perturbed = surface(middle, InnerParticles::Uniform)?;
            let sees = labels(&method, &perturbed)?[perturbed.trough];
            *(if sees { &mut free } else { &mut inner }) = middle;
        }
        text += &format!("| {radius} | {limit:.4}° | {inner:.4}° | {free:.4}° |\n");
        table += &format!("{radius},{limit},{inner},{free}\n");
    }
    AtomicFile::write(&folder.join("eq31.csv"), |out| out.write_all(table.as_bytes()))?;
    text += "\nThe paper gives 133° for R = 1.25 Δx.\n";
    Ok(text)
}

pub(super) fn fig8(folder: &Path) -> Result<String> {
    let kinds = [
        ("uniform", InnerParticles::Uniform),
        ("lost", InnerParticles::Lost),
        ("aggregated", InnerParticles::Aggregated),
    ];
    let methods: [(&dyn SurfaceDetection, [bool; 3]); 3] = [
        (&Marrone::default(), [true, false, false]),
        (&Wang::default(), [true, false, false]),
        (&Sun::default(), [true; 3]),
    ];
    let mut rows = Vec::new();
    for (method, _) in &methods {
        let mut row = Vec::new();
        for (name, inner) in kinds {
            row.push(Panel::new(format!("{}, {name}", title(*method)), *method, surface(100.0, inner)?)?);
        }
        rows.push(row);
    }
    draw(&folder.join("fig8.png"), &rows)?;
    let mut agree = 0;
    let mut table = String::from("method,inner_particles,trough_is_free_surface,paper\n");
    for ((method, paper), row) in methods.iter().zip(&rows) {
        for (((name, _), panel), paper) in kinds.iter().zip(row).zip(paper) {
            agree += usize::from(panel.sees_trough() == *paper);
            table += &format!("{},{name},{},{paper}\n", method.name(), panel.sees_trough());
        }
    }
    AtomicFile::write(&folder.join("fig8.csv"), |out| out.write_all(table.as_bytes()))?;
    Ok(format!(
        "## Lost and aggregated inner particles (Fig. 8)\n\n![Labels](fig8.png)\n\nTroughs of 100°. The particle in the \
         central trough is labelled as the paper says in {agree} of 9 cases: methods that scan along a normal lose it where \
         inner particles are missing or crowd, because the normal turns.\n"
    ))
}

fn title(method: &dyn SurfaceDetection) -> String {
    let name = method.name();
    name.chars().take(1).flat_map(char::to_uppercase).chain(name.chars().skip(1)).collect()
}

fn draw(path: &Path, rows: &[Vec<Panel>]) -> Result<()> {
    let columns = rows.first().map_or(0, Vec::len);
    let size = (PANEL.0 * columns as u32, PANEL.1 * rows.len() as u32);
    save(path, size, |root| {
        for (area, panel) in root.split_evenly((rows.len(), columns)).iter().zip(rows.iter().flatten()) {
            draw_panel(area, panel)?;
        }
        Ok(())
    })
}

fn draw_panel(area: &Area<'_>, panel: &Panel) -> Result<()> {
    let failed = |e: &dyn std::fmt::Display| anyhow!("{e}");
    // The central trough with its neighbours; the same scale along both axes.
    let half = 6.2;
    let height = 2.0 * half * f64::from(PANEL.1 - 56) / f64::from(PANEL.0 - 16);
    let top = 3.6;
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .caption(&panel.title, ("sans-serif", 24))
        .build_cartesian_2d(-half..half, top - height..top)
        .map_err(|e| failed(&e))?;
    let visible = |p: &[f64; 3]| p[0].abs() < half - 0.3 && p[1] > top - height + 0.3 && p[1] < top - 0.3;
    let circles = panel.surface.positions.iter().enumerate().filter(|(_, p)| visible(p)).map(|(i, p)| {
        let colour = match (panel.labels[i], panel.reference[i]) {
            (a, b) if a != b => MISTAKEN,
            (true, _) => FREE,
            (false, _) => INNER,
        };
        Circle::new((p[0], p[1]), 11, colour.filled())
    });
    chart.draw_series(circles).map_err(|e| failed(&e))?;
    let p = panel.surface.positions[panel.surface.trough];
    let ring = ShapeStyle { color: BLACK.to_rgba(), filled: false, stroke_width: 2 };
    chart.draw_series(std::iter::once(Circle::new((p[0], p[1]), 14, ring))).map_err(|e| failed(&e))?;
    Ok(())
}
