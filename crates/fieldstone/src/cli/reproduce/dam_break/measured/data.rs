//! Tables of numbers, and curves made of them.

use std::path::Path;

use anyhow::{Context, bail};
use fieldstone::io::source::read_all;

use super::super::flow_run::FlowRun;

/// Abscissa and ordinate, in rising order of the abscissa where it is interpolated.
pub(super) type Curved = Vec<(f64, f64)>;

/// Rows of numbers, all of one length; other lines are titles.
pub(super) fn rows(path: &Path, columns: usize) -> anyhow::Result<Vec<Vec<f64>>> {
    let bytes = read_all(path)?;
    // One of the sources is not in UTF-8.
    let text = String::from_utf8_lossy(&bytes);
    let numbers = |line: &str| line.split_whitespace().map(|w| w.parse::<f64>().ok()).collect::<Option<Vec<f64>>>();
    let rows: Vec<Vec<f64>> = text.lines().filter_map(numbers).filter(|row| row.len() == columns).collect();
    if rows.is_empty() {
        bail!("{}: no row of {columns} numbers was found; give the folder with the measurements", path.display());
    }
    Ok(rows)
}

/// Two columns as a curve.
pub(super) fn pairs(path: &Path) -> anyhow::Result<Curved> {
    Ok(rows(path, 2)?.into_iter().map(|row| (row[0], row[1])).collect())
}

/// Two columns of a file of many.
pub(super) fn column(rows: &[Vec<f64>], index: usize) -> Curved {
    rows.iter().map(|row| (row[0], row[index])).collect()
}

/// A gauge over time.
pub(super) fn gauge(flow: &FlowRun, name: &str) -> anyhow::Result<Curved> {
    let table = flow.gauges()?;
    let missing = || format!("the flow's table has no column {name}; remove its folder to compute it anew");
    let times = table.column("time").with_context(missing)?;
    Ok(times.iter().copied().zip(table.column(name).with_context(missing)?.iter().copied()).collect())
}

/// Linear between points; `None` beyond the ends.
pub(super) fn at(curve: &[(f64, f64)], x: f64) -> Option<f64> {
    let above = curve.partition_point(|p| p.0 < x);
    let (b, a) = (curve.get(above)?, curve.get(above.checked_sub(1)?)?);
    Some(a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0))
}

/// First abscissa at which the ordinate reaches `level`.
pub(super) fn arrival(curve: &[(f64, f64)], level: f64) -> Option<f64> {
    curve.iter().find(|p| p.1 >= level).map(|p| p.0)
}

/// Mean of the ordinates between two abscissae, by the trapezoidal rule: points may be dense in places.
pub(super) fn mean(curve: &[(f64, f64)], from: f64, to: f64) -> Option<f64> {
    let mut inside: Curved = curve.iter().copied().filter(|p| (from..=to).contains(&p.0)).collect();
    inside.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (first, last) = (inside.first()?.0, inside.last()?.0);
    let area: f64 = inside.windows(2).map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0)).sum();
    (last > first).then(|| area / (last - first))
}

/// Root of the mean square of computed over measured − 1, at the measured points that the computed curve spans.
pub(super) fn relative_rms(computed: &[(f64, f64)], measured: &[(f64, f64)]) -> Option<f64> {
    let errors: Vec<f64> = measured.iter().filter_map(|&(x, y)| Some(at(computed, x)? / y - 1.0)).collect();
    (!errors.is_empty()).then(|| (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_read_off_where_they_are_known_and_nowhere_else() {
        let line = [(0.0, 1.0), (2.0, 3.0), (3.0, 3.0)];
        assert_eq!(at(&line, 1.0), Some(2.0));
        assert_eq!((at(&line, -0.1), at(&line, 3.1)), (None, None));
        assert_eq!(arrival(&line, 2.5), Some(2.0));
        // Points crowd at one end: the mean over time is not the mean over points.
        assert_eq!(mean(&[(0.0, 0.0), (1.0, 0.0), (1.0, 4.0), (1.5, 4.0), (2.0, 4.0)], 0.0, 2.0), Some(2.0));
        assert_eq!(relative_rms(&line, &[(1.0, 2.0), (2.0, 1.5), (9.0, 7.0)]), Some(0.5f64.sqrt()));
    }
}
