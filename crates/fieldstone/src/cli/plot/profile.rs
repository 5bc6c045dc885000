//! Averages over all directions but one, as lines.

use anyhow::anyhow;
use plotters::coord::Shift;
use plotters::prelude::*;

use super::canvas::{Painting, tick};
use crate::cli::reproduce::plots::{COLOURS, draw_legend};

/// Mean values over a coordinate.
pub(super) struct ProfilePicture {
    pub title: String,
    /// Name of the coordinate.
    pub axis: String,
    /// Middles of the bins.
    pub at: Vec<f64>,
    /// Names and values; bins without cells have none.
    pub lines: Vec<(String, Vec<Option<f64>>)>,
    /// Whether the coordinate goes up, as heights do.
    pub upright: bool,
}

/// Weighted means in bins.
pub(super) fn means(bins: usize, cells: impl Iterator<Item = (usize, f64, f64)>) -> Vec<Option<f64>> {
    let mut sums = vec![[0.0; 2]; bins];
    for (bin, weight, value) in cells {
        sums[bin][0] += weight * value;
        sums[bin][1] += weight;
    }
    sums.iter().map(|&[sum, weight]| (weight > 0.0).then(|| sum / weight)).collect()
}

fn around(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return [0.0, 1.0];
    }
    let pad = if low == high { 0.5 * low.abs().max(1e-300) } else { 0.05 * (high - low) };
    [low - pad, high + pad]
}

impl Painting for ProfilePicture {
    fn size(&self) -> (u32, u32) {
        (820, 680)
    }

    fn paint<DB: DrawingBackend>(&self, root: &DrawingArea<DB, Shift>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let failed = |e: &dyn std::fmt::Display| anyhow!("{e}");
        root.fill(&WHITE).map_err(|e| failed(&e))?;
        let along = around(self.at.iter().copied());
        let values = around(self.lines.iter().flat_map(|(_, line)| line.iter().flatten().copied()));
        let value_name = if self.lines.len() == 1 { self.lines[0].0.as_str() } else { "" };
        let (x, y, x_name, y_name) = if self.upright {
            (values, along, value_name, self.axis.as_str())
        } else {
            (along, values, self.axis.as_str(), value_name)
        };
        let mut chart = ChartBuilder::on(root)
            .margin(16)
            .margin_right(30)
            .caption(&self.title, ("sans-serif", 24))
            .x_label_area_size(52)
            .y_label_area_size(96)
            .build_cartesian_2d(x[0]..x[1], y[0]..y[1])
            .map_err(|e| failed(&e))?;
        chart
            .configure_mesh()
            .x_desc(x_name)
            .y_desc(y_name)
            .x_labels(7)
            .y_labels(9)
            .x_label_formatter(&|v| tick(*v, x))
            .y_label_formatter(&|v| tick(*v, y))
            .light_line_style(RGBColor(240, 240, 240))
            .bold_line_style(RGBColor(215, 215, 215))
            .label_style(("sans-serif", 18))
            .axis_desc_style(("sans-serif", 20))
            .draw()
            .map_err(|e| failed(&e))?;
        for (k, (name, line)) in self.lines.iter().enumerate() {
            let colour = COLOURS[k % COLOURS.len()];
            let style = ShapeStyle { color: colour.to_rgba(), filled: true, stroke_width: 2 };
            let points: Vec<(f64, f64)> = (self.at.iter().zip(line))
                .filter_map(|(&at, value)| value.map(|v| if self.upright { (v, at) } else { (at, v) }))
                .collect();
            if points.len() <= 80 && k < COLOURS.len() {
                chart.draw_series(points.iter().map(|&p| Circle::new(p, 3, style))).map_err(|e| failed(&e))?;
            }
            // Colours come again after seven lines, dashed.
            let series = if k < COLOURS.len() {
                chart.draw_series(LineSeries::new(points, style))
            } else {
                chart.draw_series(DashedLineSeries::new(points, 8, 6, style))
            };
            series
                .map_err(|e| failed(&e))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], style));
        }
        if self.lines.len() > 1 {
            draw_legend(&mut chart, SeriesLabelPosition::UpperRight, 18)?;
        }
        Ok(())
    }
}
