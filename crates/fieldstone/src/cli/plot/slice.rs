//! A slice through cells as a colour map.

use anyhow::{anyhow, bail};
use fieldstone::mesh::{Cells, Mesh};
use plotters::coord::Shift;
use plotters::prelude::*;

use super::canvas::{Painting, tick};
use super::data::Lattice;
use crate::cli::picture::viridis;

/// Points along the longer side of a slice through a mesh.
const SAMPLES: usize = 500;
const MARGIN: u32 = 16;
const LEFT: u32 = 92;
const BOTTOM: u32 = 58;
const TOP: u32 = 52;
const BAR: u32 = 150;

/// A colour map over a plane.
pub(super) struct SlicePicture {
    pub title: String,
    /// Names of the axis to the right and of the axis up.
    pub names: [String; 2],
    /// Bounds of columns and rows.
    pub edges: [Vec<f64>; 2],
    /// Rows from below, each from the left.
    pub values: Vec<Option<f64>>,
}

impl SlicePicture {
    /// The layer of a lattice across `axis` that holds `at`.
    pub fn of_lattice(
        lattice: &Lattice,
        axis: usize,
        at: f64,
        value: impl Fn(usize) -> Option<f64>,
    ) -> anyhow::Result<(Self, f64)> {
        let Some(layer) = lattice.interval(axis, at) else {
            let edges = &lattice.edges[axis];
            bail!(
                "--slice {}={at}: the cells reach from {} to {}",
                lattice.names[axis],
                edges[0],
                edges[edges.len() - 1]
            )
        };
        let [right, up] = others(axis);
        let n = lattice.counts();
        let mut values = Vec::with_capacity(n[right] * n[up]);
        for row in 0..n[up] {
            for column in 0..n[right] {
                let mut place = [0; 3];
                (place[axis], place[right], place[up]) = (layer, column, row);
                values.push(lattice.cell(place).and_then(|cell| value(cell as usize)));
            }
        }
        let edges = [right, up].map(|k| lattice.edges[k].clone());
        let names = [right, up].map(|k| lattice.names[k].clone());
        let middle = 0.5 * (lattice.edges[axis][layer] + lattice.edges[axis][layer + 1]);
        Ok((Self { title: String::new(), names, edges, values }, middle))
    }

    /// The plane through a mesh, sampled.
    pub fn of_mesh(mesh: &Mesh, axis: usize, at: f64, value: impl Fn(usize) -> Option<f64>) -> anyhow::Result<Self> {
        let (low, high) = mesh.bounds();
        if !(at >= low[axis] && at <= high[axis]) {
            bail!("--slice {}={at}: the mesh reaches from {} to {}", ["x", "y", "z"][axis], low[axis], high[axis]);
        }
        let [right, up] = others(axis);
        let extent = [right, up].map(|k| high[k] - low[k]);
        let step = extent[0].max(extent[1]) / SAMPLES as f64;
        let count = extent.map(|e| ((e / step).round() as usize).max(1));
        let edge = |k: usize, side: usize| -> Vec<f64> {
            (0..=count[side]).map(|i| low[k] + extent[side] * i as f64 / count[side] as f64).collect()
        };
        let edges = [edge(right, 0), edge(up, 1)];
        let mut scratch = mesh.scratch();
        let mut values = Vec::with_capacity(count[0] * count[1]);
        for y in edges[1].windows(2) {
            for x in edges[0].windows(2) {
                let mut point = [at; 3];
                (point[right], point[up]) = (0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]));
                values.push(mesh.locate(point, &mut scratch).and_then(|cell| value(cell as usize)));
            }
        }
        let names = [right, up].map(|k| ["x", "y", "z"][k].to_string());
        Ok(Self { title: String::new(), names, edges, values })
    }

    fn extent(&self, side: usize) -> [f64; 2] {
        let edges = &self.edges[side];
        [edges[0], edges[edges.len() - 1]]
    }

    /// Lowest and highest value, never the same, and whether colours are to differ around zero.
    fn range(&self) -> ([f64; 2], bool) {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for v in self.values.iter().flatten().filter(|v| v.is_finite()) {
            (low, high) = (low.min(*v), high.max(*v));
        }
        if low > high {
            return ([0.0, 1.0], false);
        }
        if low < 0.0 && high > 0.0 {
            let size = high.max(-low);
            return ([-size, size], true);
        }
        if low == high {
            let pad = if low == 0.0 { 1.0 } else { 0.5 * low.abs() };
            return ([low - pad, high + pad], false);
        }
        ([low, high], false)
    }

    /// Pixels of the map itself: true to shape, as far as that fits.
    fn inner(&self) -> (u32, u32) {
        let [[x0, x1], [y0, y1]] = [self.extent(0), self.extent(1)];
        let ratio = ((x1 - x0) / (y1 - y0)).clamp(0.15, 3.0);
        let (width, height) = if ratio > 1.0 { (900.0, 900.0 / ratio) } else { (850.0 * ratio, 850.0) };
        (width.max(200.0) as u32, height.max(200.0) as u32)
    }
}

/// The two axes across an axis: the one to the right, and the one up.
fn others(axis: usize) -> [usize; 2] {
    [[1, 2], [0, 2], [0, 1]][axis]
}

/// From blue through white to red, for −1 to 1.
fn diverging(t: f64) -> [u8; 3] {
    const ENDS: [[f64; 3]; 2] = [[33.0, 84.0, 165.0], [178.0, 36.0, 36.0]];
    let end = ENDS[usize::from(t > 0.0)];
    let f = t.abs().min(1.0);
    end.map(|c| (255.0 + (c - 255.0) * f).round() as u8)
}

fn colour(value: f64, [low, high]: [f64; 2], around_zero: bool) -> RGBColor {
    let [r, g, b] = if around_zero { diverging(value / high) } else { viridis((value - low) / (high - low)) };
    RGBColor(r, g, b)
}

impl Painting for SlicePicture {
    fn size(&self) -> (u32, u32) {
        let (width, height) = self.inner();
        (MARGIN + LEFT + width + MARGIN + BAR, TOP + height + BOTTOM + MARGIN)
    }

    fn paint<DB: DrawingBackend>(&self, root: &DrawingArea<DB, Shift>) -> anyhow::Result<()>
    where
        DB::ErrorType: 'static,
    {
        let failed = |e: &dyn std::fmt::Display| anyhow!("{e}");
        root.fill(&WHITE).map_err(|e| failed(&e))?;
        let (width, _) = self.size();
        let (map, bar) = root.split_horizontally(width - BAR);
        let [x, y] = [self.extent(0), self.extent(1)];
        let mut chart = ChartBuilder::on(&map)
            .margin_left(MARGIN)
            .margin_right(MARGIN)
            .margin_bottom(MARGIN)
            .margin_top(TOP)
            .x_label_area_size(BOTTOM)
            .y_label_area_size(LEFT)
            .build_cartesian_2d(x[0]..x[1], y[0]..y[1])
            .map_err(|e| failed(&e))?;
        let (range, around_zero) = self.range();
        let columns = self.edges[0].len() - 1;
        let mut rectangles = Vec::new();
        for (row, values) in self.values.chunks_exact(columns).enumerate() {
            let colours: Vec<Option<RGBColor>> =
                values.iter().map(|v| v.filter(|v| v.is_finite()).map(|v| colour(v, range, around_zero))).collect();
            let mut first = 0;
            // Neighbours of one colour are one rectangle: fewer of them, and no seams.
            for run in colours.chunk_by(|a, b| a == b) {
                let last = first + run.len();
                if let Some(colour) = run[0] {
                    let corners =
                        [(self.edges[0][first], self.edges[1][row]), (self.edges[0][last], self.edges[1][row + 1])];
                    rectangles.push(Rectangle::new(corners, colour.filled()));
                }
                first = last;
            }
        }
        chart.draw_series(rectangles).map_err(|e| failed(&e))?;
        chart
            .configure_mesh()
            .disable_mesh()
            .x_desc(&self.names[0])
            .y_desc(&self.names[1])
            .x_labels(6)
            .y_labels(8)
            .x_label_formatter(&|v| tick(*v, x))
            .y_label_formatter(&|v| tick(*v, y))
            .label_style(("sans-serif", 19))
            .axis_desc_style(("sans-serif", 22))
            .draw()
            .map_err(|e| failed(&e))?;
        root.draw(&Text::new(self.title.clone(), (MARGIN as i32 + 8, 16), ("sans-serif", 24).into_font()))
            .map_err(|e| failed(&e))?;

        let steps = 200;
        let mut scale = ChartBuilder::on(&bar)
            .margin_top(TOP)
            .margin_bottom(MARGIN + BOTTOM)
            .margin_right(24)
            .y_label_area_size(96)
            .build_cartesian_2d(0.0..1.0, range[0]..range[1])
            .map_err(|e| failed(&e))?;
        let at = |k: i32| range[0] + (range[1] - range[0]) * f64::from(k) / f64::from(steps);
        scale
            .draw_series((0..steps).map(|k| {
                let shade = colour(0.5 * (at(k) + at(k + 1)), range, around_zero);
                Rectangle::new([(0.0, at(k)), (1.0, at(k + 1))], shade.filled())
            }))
            .map_err(|e| failed(&e))?;
        scale
            .configure_mesh()
            .disable_mesh()
            .disable_x_axis()
            .y_labels(8)
            .y_label_formatter(&|v| tick(*v, range))
            .label_style(("sans-serif", 19))
            .draw()
            .map_err(|e| failed(&e))
    }
}
