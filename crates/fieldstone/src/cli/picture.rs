//! Pictures of a slice through cells: a colour per point, particle outlines over it, axes and a colour bar.

use std::path::Path;
use std::sync::Once;

use anyhow::{Context, anyhow};
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

/// The plane that is shown, as two axes (0 x, 1 y, 2 z) and the position along the third.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    /// Axis to the right, axis up, axis through the paper.
    pub axes: [usize; 3],
    /// Coordinate along the third axis.
    pub at: f64,
}

impl Plane {
    /// The point of space at (right, up).
    pub fn point(&self, right: f64, up: f64) -> [f64; 3] {
        let mut point = [0.0; 3];
        point[self.axes[0]] = right;
        point[self.axes[1]] = up;
        point[self.axes[2]] = self.at;
        point
    }

    /// The circle that the plane cuts from a ball: its centre in the plane and its radius.
    pub fn circle(&self, centre: [f64; 3], radius: f64) -> Option<([f64; 2], f64)> {
        let height = centre[self.axes[2]] - self.at;
        let r2 = radius * radius - height * height;
        (r2 > 0.0).then(|| ([centre[self.axes[0]], centre[self.axes[1]]], r2.sqrt()))
    }
}

/// What is drawn.
pub(crate) struct Slice<'a> {
    pub title: String,
    pub plane: Plane,
    /// Lower and upper corner of the box around the cells.
    pub bounds: ([f64; 3], [f64; 3]),
    /// Colour scale, lowest and highest value.
    pub range: [f64; 2],
    /// Name of the quantity, under the colour bar.
    pub label: &'a str,
    /// Circles drawn as outlines: centre in the plane and radius.
    pub circles: Vec<([f64; 2], f64)>,
}

/// Height of the picture in pixels; its width follows from the slice's shape.
const HEIGHT: u32 = 1100;
const MARGIN: u32 = 90;
const BAR: u32 = 170;

/// Draws the slice to a PNG file; `value` is asked once per pixel, from the top left, row by row.
pub(crate) fn draw(
    path: &Path,
    slice: &Slice<'_>,
    mut value: impl FnMut([f64; 3]) -> Option<f64>,
) -> anyhow::Result<()> {
    register_fonts();
    let (low, high) = slice.bounds;
    let [right, up, _] = slice.plane.axes;
    let (left, bottom) = (low[right], low[up]);
    let (width, height) = (high[right] - left, high[up] - bottom);
    let inner_height = HEIGHT - 2 * MARGIN;
    let inner_width = (f64::from(inner_height) * width / height).clamp(200.0, 2400.0) as u32;
    let total_width = inner_width + 2 * MARGIN + BAR;

    let mut pixels = vec![255u8; 3 * inner_width as usize * inner_height as usize];
    for row in 0..inner_height {
        let y = bottom + height * (1.0 - (f64::from(row) + 0.5) / f64::from(inner_height));
        for column in 0..inner_width {
            let x = left + width * (f64::from(column) + 0.5) / f64::from(inner_width);
            if let Some(v) = value(slice.plane.point(x, y)) {
                let t = (v - slice.range[0]) / (slice.range[1] - slice.range[0]);
                let at = 3 * (row as usize * inner_width as usize + column as usize);
                pixels[at..at + 3].copy_from_slice(&viridis(t));
            }
        }
    }

    let drawing = |e: &dyn std::fmt::Display| anyhow!("{}: cannot draw the picture: {e}", path.display());
    // Beside the target and renamed at the end, so that no half picture is left behind; the ending tells the encoder.
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let file = tempfile::Builder::new()
        .prefix(".fieldstone-")
        .suffix(".png")
        .tempfile_in(folder)
        .with_context(|| format!("{}: cannot write", path.display()))?
        .into_temp_path();
    {
        let root = BitMapBackend::new(&file, (total_width, HEIGHT)).into_drawing_area();
        root.fill(&WHITE).map_err(|e| drawing(&e))?;
        let (picture, bar) = root.split_horizontally(inner_width + 2 * MARGIN);
        let mut chart = ChartBuilder::on(&picture)
            .margin_top(MARGIN - 50)
            .margin_left(14)
            .margin_right(MARGIN - 74)
            .margin_bottom(MARGIN - 65)
            .caption(&slice.title, ("sans-serif", 26))
            .x_label_area_size(45)
            .y_label_area_size(85)
            .build_cartesian_2d(left..left + width, bottom..bottom + height)
            .map_err(|e| drawing(&e))?;
        let (plot_width, plot_height) = chart.plotting_area().dim_in_pixel();
        let image = resample(&pixels, [inner_width, inner_height], [plot_width, plot_height]);
        let element = BitMapElement::with_owned_buffer((left, bottom + height), (plot_width, plot_height), image)
            .ok_or_else(|| drawing(&"the raster has the wrong size"))?;
        chart.draw_series(std::iter::once(element)).map_err(|e| drawing(&e))?;
        let outline = ShapeStyle { color: WHITE.mix(0.55), filled: false, stroke_width: 1 };
        chart
            .draw_series(slice.circles.iter().map(|&([x, y], r)| {
                let points: Vec<(f64, f64)> = (0..=48)
                    .map(|k| (f64::from(k) / 48.0 * std::f64::consts::TAU).sin_cos())
                    .map(|(s, c)| (x + r * c, y + r * s))
                    .filter(|p| p.0 >= left && p.0 <= left + width && p.1 >= bottom && p.1 <= bottom + height)
                    .collect();
                PathElement::new(points, outline)
            }))
            .map_err(|e| drawing(&e))?;
        let name = |axis: usize| ["x", "y", "z"][axis];
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc(name(right))
            .y_desc(name(up))
            .x_labels(6)
            .y_labels(8)
            .label_style(("sans-serif", 19))
            .axis_desc_style(("sans-serif", 22))
            .draw()
            .map_err(|e| drawing(&e))?;

        let steps = 200u32;
        let mut scale = ChartBuilder::on(&bar)
            .margin_top(MARGIN)
            .margin_bottom(MARGIN)
            .margin_right(60)
            .y_label_area_size(62)
            .build_cartesian_2d(0.0..1.0, slice.range[0]..slice.range[1])
            .map_err(|e| drawing(&e))?;
        let span = slice.range[1] - slice.range[0];
        scale
            .draw_series((0..steps).map(|k| {
                let [a, b] = [k, k + 1].map(|k| f64::from(k) / f64::from(steps));
                let [r, g, blue] = viridis(0.5 * (a + b));
                let corners = [(0.0, slice.range[0] + a * span), (1.0, slice.range[0] + b * span)];
                Rectangle::new(corners, RGBColor(r, g, blue).filled())
            }))
            .map_err(|e| drawing(&e))?;
        scale
            .configure_mesh()
            .disable_mesh()
            .disable_x_axis()
            .y_desc(slice.label)
            .y_labels(8)
            .label_style(("sans-serif", 19))
            .axis_desc_style(("sans-serif", 22))
            .draw()
            .map_err(|e| drawing(&e))?;
        root.present().map_err(|e| drawing(&e))?;
    }
    // Temporary files are private; pictures are as readable as any file that the user creates.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o644))
            .with_context(|| format!("{}: cannot write", path.display()))?;
    }
    file.persist(path).with_context(|| format!("{}: cannot write", path.display()))?;
    Ok(())
}

/// The nearest pixel of the raster for each pixel of the plot.
fn resample(pixels: &[u8], [w, h]: [u32; 2], [to_w, to_h]: [u32; 2]) -> Vec<u8> {
    let mut out = Vec::with_capacity(3 * to_w as usize * to_h as usize);
    for row in 0..to_h {
        let from_row = (u64::from(row) * u64::from(h) / u64::from(to_h)) as usize;
        for column in 0..to_w {
            let from = (u64::from(column) * u64::from(w) / u64::from(to_w)) as usize;
            let at = 3 * (from_row * w as usize + from);
            out.extend_from_slice(&pixels[at..at + 3]);
        }
    }
    out
}

/// The viridis colour map, linear between nine of its colours; clamped to its ends.
pub(crate) fn viridis(t: f64) -> [u8; 3] {
    const COLOURS: [[f64; 3]; 9] = [
        [68.0, 1.0, 84.0],
        [71.0, 44.0, 122.0],
        [59.0, 81.0, 139.0],
        [44.0, 113.0, 142.0],
        [33.0, 144.0, 141.0],
        [39.0, 173.0, 129.0],
        [92.0, 200.0, 99.0],
        [170.0, 220.0, 50.0],
        [253.0, 231.0, 37.0],
    ];
    let x = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) } * 8.0;
    let k = (x as usize).min(7);
    let f = x - k as f64;
    std::array::from_fn(|c| (COLOURS[k][c] * (1.0 - f) + COLOURS[k + 1][c] * f).round() as u8)
}

/// Fonts come with the program, so that pictures look alike on every machine.
pub(crate) fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // A font that does not load leaves the picture without text, which drawing then reports.
        let _ = register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
    });
}
