//! Fronts of a collapsing column: Koshizuka and Oka (1996), Martin and Moyce (1952).

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{anyhow, bail};
use fieldstone::io::source::read_all;
use plotters::chart::SeriesLabelPosition;

use super::super::flow_run::FlowRun;
use super::data::{Curved, gauge, pairs, relative_rms};
use super::{clipped, computed, measured, percent};
use crate::cli::reproduce::plots::{Axis, COLOURS, Plot, draw};

/// Width of the computed column, and gravity.
const WIDTH: f64 = 0.146;
const GRAVITY: f64 = 9.81;
/// Width of the column of the file in metres and seconds.
const FILE_WIDTH: f64 = 1.0;
/// Where the wall of Koshizuka and Oka stands, over the column's width.
const WALL: f64 = 4.0;

pub(super) fn section(flow: &FlowRun, folder: &Path, data: &Path) -> anyhow::Result<String> {
    // T = t √(2 g/a), Z = x/a; H = height over its start.
    let scaled = |curve: Curved, width: f64, height: f64| -> Curved {
        curve.into_iter().map(|(t, x)| (t * (2.0 * GRAVITY / width).sqrt(), x / height)).collect()
    };
    let front = scaled(gauge(flow, "front")?, WIDTH, WIDTH);
    let height = scaled(gauge(flow, "height")?, WIDTH, 2.0 * WIDTH);
    let last = front.last().map_or(0.0, |p| p.0);
    let before_wall = |curve: Curved| -> Curved { curve.into_iter().filter(|p| p.1 < WALL).collect() };
    let seen = |curve: Curved| -> Curved { curve.into_iter().filter(|p| p.0 <= last).collect() };
    let fronts = [
        (
            "Koshizuka and Oka, file",
            before_wall(scaled(pairs(&data.join("koshizuka_oka_1996_front.txt"))?, FILE_WIDTH, FILE_WIDTH)),
        ),
        ("Koshizuka and Oka, digitised", before_wall(pairs(&data.join("pysph_ko_data.txt"))?)),
        ("Martin and Moyce, a = 28.6 mm", seen(pairs(&data.join("pysph_mm_data_1.txt"))?)),
        ("Martin and Moyce, a = 57.2 mm", seen(pairs(&data.join("pysph_mm_data_2.txt"))?)),
        ("Martin and Moyce, table 2", seen(table(data, "T", "Z")?)),
    ];
    // The height's time is t √(g/a).
    let heights: Curved = seen(table(data, "tau", "H")?.into_iter().map(|(t, h)| (t * 2f64.sqrt(), h)).collect());

    let resolution = WIDTH / flow.case.sections.spacing;
    let mut text = format!(
        "## Collapsing column\n\n![Front and height](column.png)\n\nA column 1 × 2, a/Δx = {resolution:.0}, in two dimensions, on a floor \
         without slip, with a viscosity that was chosen with the curves at hand ({}); front Z = x/a \
         and height H over T = t √(2g/a). Root mean square of computed over measured − 1, and the front's mean speed dZ/dT from \
         Z = 1.8 to 3.8, which does not depend on how the gate opened; that of the computation opens at once:\n\n\
         | measurement | points | RMS | speed, computed | measured | error |\n|---|---|---|---|---|---|\n",
        flow.settings(),
    );
    for (name, curve, ours) in
        fronts.iter().map(|(n, c)| (*n, c, &front)).chain([("Martin and Moyce, height, table 6", &heights, &height)])
    {
        let rms = relative_rms(ours, curve).unwrap_or(f64::NAN);
        let _ = write!(text, "| {name} | {} | {:.1} % |", curve.len(), 100.0 * rms);
        let _ = match (speed(ours), speed(curve)) {
            (Some(a), Some(b)) => writeln!(text, " {a:.3} | {b:.3} | {} |", percent(a / b - 1.0)),
            _ => writeln!(text, " – | – | – |"),
        };
    }
    let mut curves = vec![computed("computed", &front)];
    curves.extend(fronts.iter().zip(&COLOURS[1..]).map(|((name, curve), colour)| measured(name, curve, *colour)));
    let axis = |name: &'static str, high: f64| Axis { name, range: [0.0, high], logarithmic: false };
    let plots = [
        Plot {
            title: "Front".into(),
            x: axis("t √(2g/a)", last),
            y: axis("x/a", 10.0),
            curves,
            legend: Some(SeriesLabelPosition::UpperLeft),
        },
        Plot {
            title: "Height".into(),
            x: axis("t √(2g/a)", last),
            y: axis("height over its start", 1.05),
            curves: vec![computed("computed", &height), measured("Martin and Moyce, table 6", &heights, COLOURS[1])],
            legend: Some(SeriesLabelPosition::UpperRight),
        },
    ];
    draw(&folder.join("column.png"), &plots.map(clipped))?;
    Ok(text + "\n")
}

/// Slope by least squares of a front between Z = 1.8 and 3.8; none for what does not go there.
fn speed(front: &[(f64, f64)]) -> Option<f64> {
    let points: Vec<&(f64, f64)> = front.iter().filter(|p| (1.8..=3.8).contains(&p.1)).collect();
    let n = points.len() as f64;
    let (mt, mz) = points.iter().fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    let (a, b) = points.iter().fold((0.0, 0.0), |s, p| (s.0 + (p.0 - mt) * (p.1 - mz), s.1 + (p.0 - mt).powi(2)));
    (points.len() > 2 && b > 0.0).then(|| a / b)
}

/// Two lines of numbers that begin with these names.
fn table(data: &Path, x: &str, y: &str) -> anyhow::Result<Curved> {
    let path = data.join("martin_moyce_1952_tables_2_6.txt");
    let bytes = read_all(&path)?;
    let text = String::from_utf8_lossy(&bytes);
    let (abscissae, ordinates) = (named_row(&text, &path, x)?, named_row(&text, &path, y)?);
    if abscissae.len() != ordinates.len() {
        bail!(
            "{}: {x} has {} numbers, but {y} has {}; each of one belongs to one of the other",
            path.display(),
            abscissae.len(),
            ordinates.len()
        );
    }
    Ok(abscissae.into_iter().zip(ordinates).collect())
}

/// The numbers behind a name at the start of a line. All of them: a word passed over would shift one row against another.
fn named_row(text: &str, path: &Path, name: &str) -> anyhow::Result<Vec<f64>> {
    let file = path.display();
    let found =
        text.lines().enumerate().find_map(|(n, line)| Some((n + 1, line.strip_prefix(name)?.strip_prefix(' ')?)));
    let Some((line, rest)) = found else {
        bail!("{file}: no line begins with '{name} '; give the folder with the measurements");
    };
    let number = |word: &str| {
        let value = word.parse::<f64>().ok().filter(|x| x.is_finite());
        value.ok_or_else(|| anyhow!("{file}:{line}: '{word}' among the values of {name} is no number; repair the file"))
    };
    let row = rest.split_whitespace().map(number).collect::<anyhow::Result<Vec<f64>>>()?;
    if row.is_empty() {
        bail!("{file}:{line}: there is no number after {name}; give the folder with the measurements");
    }
    Ok(row)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_bad_word_in_a_row_is_refused_with_its_line_and_shifts_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let write = |text: &str| std::fs::write(folder.path().join("martin_moyce_1952_tables_2_6.txt"), text).unwrap();
        write("# a = 2.25 in\nT 0.5 1.0 1.5\nZ 1.1 1.3 1.6\n");
        assert_eq!(table(folder.path(), "T", "Z").unwrap(), [(0.5, 1.1), (1.0, 1.3), (1.5, 1.6)]);
        for (text, part) in [
            ("# a = 2.25 in\nT 0.5 l.0 1.5\nZ 1.1 1.3 1.6\n", "tables_2_6.txt:2: 'l.0' among the values of T"),
            ("T 0.5 1.0 1.5\nZ 1.1 1.6\n", "T has 3 numbers, but Z has 2"),
            ("T 0.5 1.0 1.5\n", "no line begins with 'Z '"),
        ] {
            write(text);
            let message = table(folder.path(), "T", "Z").unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
        let message = table(&folder.path().join("lost"), "T", "Z").unwrap_err().to_string();
        assert!(message.contains("lost") && message.contains("martin_moyce_1952_tables_2_6.txt"), "{message}");
    }
}
