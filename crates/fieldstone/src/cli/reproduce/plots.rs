//! Line plots, several side by side, with linear or logarithmic axes.

use std::path::Path;

use anyhow::{Context, anyhow};
use fieldstone::io::AtomicFile;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

use crate::cli::picture::{register_fonts, viridis};

/// An axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    pub name: &'static str,
    pub range: [f64; 2],
    pub logarithmic: bool,
}

/// A line with its name in the legend.
#[derive(Debug, Clone)]
pub(super) struct Curve {
    pub name: String,
    pub points: Vec<(f64, f64)>,
    pub colour: RGBColor,
    pub dashed: bool,
}

/// One plot of a picture.
#[derive(Debug, Clone)]
pub(super) struct Plot {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub curves: Vec<Curve>,
    /// Where the legend goes, if any.
    pub legend: Option<SeriesLabelPosition>,
}

/// Size of each plot in pixels.
const SIZE: (u32, u32) = (700, 640);

/// Colours that can be told apart, also by those who see red and green alike (after Okabe and Ito).
pub(crate) const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 0, 0),
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// The area that is drawn on.
pub(crate) type Area<'a> = DrawingArea<BitMapBackend<'a>, plotters::coord::Shift>;

/// Draws the plots side by side to a PNG file.
pub(super) fn draw(path: &Path, plots: &[Plot]) -> anyhow::Result<()> {
    save(path, (SIZE.0 * plots.len() as u32, SIZE.1), |root| {
        for (area, plot) in root.split_evenly((1, plots.len())).iter().zip(plots) {
            let ([x0, x1], [y0, y1]) = (plot.x.range, plot.y.range);
            match (plot.x.logarithmic, plot.y.logarithmic) {
                (true, true) => draw_plot(area, plot, (x0..x1).log_scale(), (y0..y1).log_scale()),
                (false, true) => draw_plot(area, plot, x0..x1, (y0..y1).log_scale()),
                (true, false) => draw_plot(area, plot, (x0..x1).log_scale(), y0..y1),
                (false, false) => draw_plot(area, plot, x0..x1, y0..y1),
            }?;
        }
        Ok(())
    })
}

/// A PNG file of what `draw` draws on white.
pub(crate) fn save(
    path: &Path,
    (width, height): (u32, u32),
    draw: impl FnOnce(&Area<'_>) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    register_fonts();
    let mut pixels = vec![255; 3 * width as usize * height as usize];
    {
        let root = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
        draw(&root)
            .and_then(|()| Ok(root.present()?))
            .with_context(|| format!("{}: cannot draw the picture", path.display()))?;
    }
    // Lines on white: without filters and with patience they take half the space of the plotting library's own files.
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Best);
    encoder.set_filter(png::FilterType::NoFilter);
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&pixels))
        .with_context(|| format!("{}: cannot encode the picture", path.display()))?;
    AtomicFile::write(path, |out| out.write_all(&bytes))?;
    Ok(())
}

fn draw_plot<X, Y>(area: &Area<'_>, plot: &Plot, x: X, y: Y) -> anyhow::Result<()>
where
    X: AsRangedCoord<Value = f64>,
    Y: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let failed = |e: &dyn std::fmt::Display| anyhow!("{e}");
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .margin_right(26)
        .caption(&plot.title, ("sans-serif", 24))
        .x_label_area_size(48)
        .y_label_area_size(86)
        .build_cartesian_2d(x, y)
        .map_err(|e| failed(&e))?;
    chart
        .configure_mesh()
        .x_desc(plot.x.name)
        .y_desc(plot.y.name)
        .x_labels(8)
        .y_labels(9)
        .x_label_formatter(&|v| label(*v, plot.x.logarithmic))
        .y_label_formatter(&|v| label(*v, plot.y.logarithmic))
        .light_line_style(RGBColor(240, 240, 240))
        .bold_line_style(RGBColor(215, 215, 215))
        .label_style(("sans-serif", 18))
        .axis_desc_style(("sans-serif", 20))
        .draw()
        .map_err(|e| failed(&e))?;
    for curve in &plot.curves {
        // Values beyond the axis, zeros on a logarithmic one among them, lie on its end.
        let points = curve.points.iter().map(|&(x, y)| (x, y.clamp(plot.y.range[0], plot.y.range[1])));
        let style = ShapeStyle { color: curve.colour.to_rgba(), filled: false, stroke_width: 2 };
        let series = if curve.dashed {
            chart.draw_series(DashedLineSeries::new(points, 8, 6, style))
        } else {
            chart.draw_series(LineSeries::new(points, style))
        };
        series
            .map_err(|e| failed(&e))?
            .label(&curve.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], style));
    }
    if let Some(position) = &plot.legend {
        draw_legend(&mut chart, position.clone(), 17)?;
    }
    Ok(())
}

/// The names of all series that have one.
pub(crate) fn draw_legend<'a, B: DrawingBackend + 'a, C: CoordTranslate>(
    chart: &mut ChartContext<'a, B, C>,
    position: SeriesLabelPosition,
    size: i32,
) -> anyhow::Result<()> {
    chart
        .configure_series_labels()
        .position(position)
        .background_style(WHITE.mix(0.85))
        .border_style(RGBColor(190, 190, 190))
        .legend_area_size(30)
        .margin(8)
        .label_font(("sans-serif", size))
        .draw()
        .map_err(|e| anyhow!("{e}"))
}

/// A number at an axis: powers of ten for what is far from 1 on a logarithmic axis.
fn label(v: f64, logarithmic: bool) -> String {
    if logarithmic && !(1e-2..1e4).contains(&v.abs()) {
        return format!("{v:.0e}");
    }
    // Sums of ticks carry rounding; six digits are more than an axis needs.
    ((v * 1e6).round() / 1e6).to_string()
}

/// Colours from dark to light for an ordered series of `count` curves.
pub(super) fn ordered_colour(index: usize, count: usize) -> RGBColor {
    let [r, g, b] = viridis(0.92 * index as f64 / (count.max(2) - 1) as f64);
    RGBColor(r, g, b)
}
