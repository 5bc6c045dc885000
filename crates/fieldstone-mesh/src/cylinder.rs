//! Cylindrical grids: shells, rings and sectors around an axis.

use std::f64::consts::{PI, TAU};

use fieldstone_geometry::Ball;

use crate::cells::ElementSink;
use crate::cylinder_overlap::{Sector, ball_in_sector};
use crate::{Cells, MeshError, PathCounts};

/// A grid of shells around an axis that is parallel to x, y or z, cut by sectors and by planes across the axis.
///
/// Cells are numbered with the radius fastest, then the angle, then the height. `R` is one sector and one height,
/// `RZ` one sector: along them fields are averages.
///
/// The overlap with a ball has closed-form cross-sections integrated along the axis by quadrature with error control: what is
/// within each cylinder to 1e-13 r³, and a cell's volume is a difference of two of them. Cells wholly inside the ball have exactly
/// their volume. Of those that it cuts the error is 2e-13 r³ however small they are: cells far smaller than the ball
/// miss [`fieldstone_geometry::PROMISE`], and volumes below 1e-13 r³ are left out.
///
/// ```
/// use fieldstone_geometry::Ball;
/// use fieldstone_mesh::{Cells, CylinderGrid};
/// // Two shells around z; a ball on the axis, drilled through by the inner one.
/// let grid = CylinderGrid::new(2, [0.0; 3], [0.0, 1.0], [-1.0, 1.0], [2, 1, 1])?;
/// let mut found = Vec::new();
/// grid.overlap_ball(&Ball::new([0.0; 3], 1.0)?, &mut grid.scratch(), &mut found);
/// // What is left is a napkin ring of height √3: π h³/6.
/// let ring = std::f64::consts::PI * 3.0f64.sqrt().powi(3) / 6.0;
/// assert!((found[1].1 - ring).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct CylinderGrid {
    axis: usize,
    pub(crate) origin: [f64; 3],
    radii: [f64; 2],
    heights: [f64; 2],
    cells: [usize; 3],
}

impl CylinderGrid {
    /// Shells between two `radii` around the line through `origin` along `axis` (0 to 2 for x to z), between two
    /// `heights` along it, with `cells` along radius, angle and height. Angles start at the next axis in the order x, y,
    /// z, x.
    ///
    /// # Errors
    /// [`MeshError::Cylinder`] for radii or heights that are not finite or not rising, a negative radius, no cells along
    /// a coordinate, or an axis beyond 2; [`MeshError::TooLarge`] beyond 2³² − 2 cells.
    pub fn new(
        axis: usize,
        origin: [f64; 3],
        radii: [f64; 2],
        heights: [f64; 2],
        cells: [usize; 3],
    ) -> Result<Self, MeshError> {
        let rising = |[a, b]: [f64; 2]| a.is_finite() && b.is_finite() && a < b;
        let usable =
            axis < 3 && rising(radii) && radii[0] >= 0.0 && rising(heights) && origin.iter().all(|x| x.is_finite());
        if !usable || cells.contains(&0) {
            return Err(MeshError::Cylinder { axis, radii, heights, cells });
        }
        let count = cells.iter().try_fold(1usize, |n, &c| n.checked_mul(c)).unwrap_or(usize::MAX);
        if count >= u32::MAX as usize {
            return Err(MeshError::TooLarge { what: "cells", count });
        }
        Ok(Self { axis, origin, radii, heights, cells })
    }

    /// Cells along radius, angle and height.
    pub fn cells(&self) -> [usize; 3] {
        self.cells
    }

    /// Direction of the axis: 0 to 2 for x to z.
    pub fn axis(&self) -> usize {
        self.axis
    }

    /// Radius of surface `index`, from 0 to the number of shells.
    pub fn radius(&self, index: usize) -> f64 {
        between(self.radii, index, self.cells[0])
    }

    /// Angle of half-plane `index`, from 0 to the number of sectors.
    pub fn angle(&self, index: usize) -> f64 {
        between([0.0, TAU], index, self.cells[1])
    }

    /// Height of plane `index`, from 0 to the number of layers, from the origin.
    pub fn height(&self, index: usize) -> f64 {
        between(self.heights, index, self.cells[2])
    }

    /// Number of the cell at the given indices along radius, angle and height.
    pub fn cell_at(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.cells[0] * (j + self.cells[1] * k)
    }

    /// Indices of a cell along radius, angle and height.
    pub fn indices(&self, cell: usize) -> [usize; 3] {
        let [nr, nt, _] = self.cells;
        [cell % nr, cell / nr % nt, cell / (nr * nt)]
    }

    /// Distance from the axis, angle in 0…2π and height of a point.
    fn coordinates(&self, p: [f64; 3]) -> [f64; 3] {
        let d: [f64; 3] = std::array::from_fn(|k| p[k] - self.origin[k]);
        let (u, v) = (d[(self.axis + 1) % 3], d[(self.axis + 2) % 3]);
        let angle = v.atan2(u);
        [u.hypot(v), if angle < 0.0 { (angle + TAU).min(TAU) } else { angle }, d[self.axis]]
    }

    /// The point at a distance from the axis, an angle and a height.
    pub(crate) fn point(&self, [s, angle, z]: [f64; 3]) -> [f64; 3] {
        let mut p = self.origin;
        p[(self.axis + 1) % 3] += s * angle.cos();
        p[(self.axis + 2) % 3] += s * angle.sin();
        p[self.axis] += z;
        p
    }

    /// Least and largest distance of a box's points from the axis.
    pub(crate) fn distances(&self, low: [f64; 3], high: [f64; 3]) -> [f64; 2] {
        let reach = |k: usize| {
            let (a, b) = (low[k] - self.origin[k], high[k] - self.origin[k]);
            (if a <= 0.0 && b >= 0.0 { 0.0 } else { a.abs().min(b.abs()) }, a.abs().max(b.abs()))
        };
        let ((u_near, u_far), (v_near, v_far)) = (reach((self.axis + 1) % 3), reach((self.axis + 2) % 3));
        [u_near.hypot(v_near), u_far.hypot(v_far)]
    }

    fn index(range: [f64; 2], count: usize, x: f64) -> Option<usize> {
        if !(x >= range[0] && x <= range[1]) {
            return None;
        }
        let mut i = (((x - range[0]) / (range[1] - range[0]) * count as f64) as usize).min(count - 1);
        // Division and the surfaces round differently: step to where the surfaces themselves say.
        while i > 0 && between(range, i, count) > x {
            i -= 1;
        }
        while i + 1 < count && between(range, i + 1, count) <= x {
            i += 1;
        }
        Some(i)
    }

    /// Shells that hold distances from the axis between two.
    pub(crate) fn shells(&self, low: f64, high: f64) -> std::ops::Range<usize> {
        Self::span(self.radii, self.cells[0], low, high)
    }

    /// Layers that hold heights between two, from the origin.
    pub(crate) fn layers(&self, low: f64, high: f64) -> std::ops::Range<usize> {
        Self::span(self.heights, self.cells[2], low, high)
    }

    /// Indices that an interval meets, as a half-open range.
    fn span(range: [f64; 2], count: usize, low: f64, high: f64) -> std::ops::Range<usize> {
        if high < range[0] || low > range[1] {
            return 0..0;
        }
        let first = Self::index(range, count, low.max(range[0])).unwrap_or(0);
        let last = Self::index(range, count, high.min(range[1])).unwrap_or(count - 1);
        first..last + 1
    }
}

/// Value `index` of `count` equal steps over a range.
fn between(range: [f64; 2], index: usize, count: usize) -> f64 {
    if index == count { range[1] } else { range[0] + (range[1] - range[0]) * (index as f64 / count as f64) }
}

/// Square of the largest distance of a cell's points from one that is `d` from the axis, with angles and heights measured from it.
fn farthest2(d: f64, radii: [f64; 2], angles: [f64; 2], heights: [f64; 2]) -> f64 {
    let opposite = angles.iter().any(|a| a.abs() >= PI) && angles[0] <= PI && angles[1] >= -PI;
    let half2 = if opposite { 1.0 } else { angles.map(|a| (0.5 * a).sin().powi(2)).into_iter().fold(0.0, f64::max) };
    // The distance across grows from its least value to both sides: it is largest at one of the radii.
    let across = radii.map(|s| (s - d) * (s - d) + 4.0 * s * d * half2);
    across[0].max(across[1]) + heights[0].abs().max(heights[1].abs()).powi(2)
}

impl Cells for CylinderGrid {
    type Scratch = PathCounts;

    const PLACES_IN_MEMORY: bool = false;

    fn scratch(&self) -> PathCounts {
        PathCounts::default()
    }

    fn fast_scratch(&self) -> PathCounts {
        PathCounts::default()
    }

    fn path_counts(&self, scratch: &PathCounts) -> PathCounts {
        *scratch
    }

    fn cell_count(&self) -> usize {
        self.cells.iter().product()
    }

    fn cell_volume(&self, cell: usize) -> f64 {
        let [i, j, k] = self.indices(cell);
        let (a, b) = (self.radius(i), self.radius(i + 1));
        0.5 * (b - a) * (b + a) * (self.angle(j + 1) - self.angle(j)) * (self.height(k + 1) - self.height(k))
    }

    fn cell_centre(&self, cell: usize) -> [f64; 3] {
        let [i, j, k] = self.indices(cell);
        let mid = |a: f64, b: f64| 0.5 * (a + b);
        self.point([
            mid(self.radius(i), self.radius(i + 1)),
            mid(self.angle(j), self.angle(j + 1)),
            mid(self.height(k), self.height(k + 1)),
        ])
    }

    fn as_rings(&self) -> Option<&CylinderGrid> {
        (self.cells[1] == 1).then_some(self)
    }

    fn averaged(&self) -> [bool; 3] {
        std::array::from_fn(|k| k == self.axis && self.cells[2] == 1)
    }

    fn is_polyhedral(&self) -> bool {
        false
    }

    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let (mut low, mut high) = (self.origin, self.origin);
        for k in 0..3 {
            let [a, b] = if k == self.axis { self.heights } else { [-self.radii[1], self.radii[1]] };
            low[k] += a;
            high[k] += b;
        }
        (low, high)
    }

    fn overlap_ball(&self, ball: &Ball, scratch: &mut PathCounts, out: &mut Vec<(u32, f64)>) {
        let r = ball.radius();
        let [d, angle, z] = self.coordinates(ball.centre());
        let shells = self.shells(d - r, d + r);
        let layers = self.layers(z - r, z + r);
        for k in layers {
            let heights = [self.height(k) - z, self.height(k + 1) - z];
            for j in 0..self.cells[1] {
                // Angles from the direction of the centre, turned to lie within a turn of it.
                let mut angles = [self.angle(j) - angle, self.angle(j + 1) - angle];
                if self.cells[1] == 1 {
                    angles = [-PI, PI];
                } else if angles[0] > PI {
                    angles = angles.map(|a| a - TAU);
                } else if angles[1] < -PI {
                    angles = angles.map(|a| a + TAU);
                }
                // A sector that starts or ends beyond the angle under which the ball is seen has none of it.
                if d > r && self.cells[1] > 1 {
                    let seen = (r / d).asin() * (1.0 + 1e-12);
                    let meets = |a: [f64; 2]| a[0] < seen && a[1] > -seen;
                    if !meets(angles) && !meets(angles.map(|a| a - TAU)) && !meets(angles.map(|a| a + TAU)) {
                        continue;
                    }
                }
                let inside = |i: usize| {
                    let radius = self.radius(i);
                    if radius > 0.0 { ball_in_sector(d, r, Sector { radius, angles }, heights) } else { 0.0 }
                };
                let mut before = None;
                for i in shells.clone() {
                    let cell = self.cell_at([i, j, k]);
                    if farthest2(d, [self.radius(i), self.radius(i + 1)], angles, heights) < r * r * (1.0 - 1e-12) {
                        before = None;
                        out.push((cell as u32, self.cell_volume(cell)));
                        continue;
                    }
                    let (within, after) = (before.unwrap_or_else(|| inside(i)), inside(i + 1));
                    before = Some(after);
                    scratch.evaluated += 1;
                    let volume = (after - within).min(self.cell_volume(cell)).min(ball.volume());
                    // What the quadrature leaves of nothing is nothing.
                    if volume > 1e-13 * r * r * r {
                        out.push((cell as u32, volume));
                    }
                }
            }
        }
    }

    /// Boxes are not cut by cylinders: see [`Cells::is_polyhedral`].
    fn overlap_cuboid(&self, _: [f64; 3], _: [f64; 3], _: &mut PathCounts, _: &mut Vec<(u32, f64)>) {}

    fn locate(&self, point: [f64; 3], _: &mut PathCounts) -> Option<u32> {
        let [s, angle, z] = self.coordinates(point);
        let i = Self::index(self.radii, self.cells[0], s)?;
        let j = Self::index([0.0, TAU], self.cells[1], angle)?;
        let k = Self::index(self.heights, self.cells[2], z)?;
        Some(self.cell_at([i, j, k]) as u32)
    }

    fn for_each_neighbour(&self, cell: usize, visit: &mut dyn FnMut(u32, f64)) {
        let at = self.indices(cell);
        let (a, b) = (self.radius(at[0]), self.radius(at[0] + 1));
        let turn = self.angle(at[1] + 1) - self.angle(at[1]);
        let tall = self.height(at[2] + 1) - self.height(at[2]);
        for (axis, count) in self.cells.into_iter().enumerate() {
            for up in [false, true] {
                let mut other = at;
                if axis == 1 && count > 2 {
                    other[1] = (at[1] + if up { 1 } else { count - 1 }) % count;
                } else if up && at[axis] + 1 < count {
                    other[axis] += 1;
                } else if !up && at[axis] > 0 {
                    other[axis] -= 1;
                } else {
                    continue;
                }
                let over_distance = match axis {
                    0 => (if up { b } else { a }) * turn * tall / (b - a),
                    // Two sectors meet at both of their faces, and are named to each other once.
                    1 => (if count == 2 { 2.0 } else { 1.0 }) * (b - a) * tall / (0.5 * (a + b) * turn),
                    _ => 0.5 * (b - a) * (b + a) * turn / tall,
                };
                visit(self.cell_at(other) as u32, over_distance);
            }
        }
    }

    fn for_each_candidate(&self, low: [f64; 3], high: [f64; 3], visit: &mut dyn FnMut(u32)) {
        let [near, far] = self.distances(low, high);
        let shells = self.shells(near, far);
        let layers = self.layers(low[self.axis] - self.origin[self.axis], high[self.axis] - self.origin[self.axis]);
        for k in layers {
            for j in 0..self.cells[1] {
                for i in shells.clone() {
                    visit(self.cell_at([i, j, k]) as u32);
                }
            }
        }
    }

    /// Round cells have no elements with planar faces: see [`Cells::is_polyhedral`].
    fn for_each_element(&self, _: usize, _: &mut ElementSink<'_>) {}

    /// Cut where the segment meets cylinders, half-planes and planes: roots of quadratic and linear equations.
    fn clip_segment(&self, start: [f64; 3], along: [f64; 3], visit: &mut dyn FnMut(u32, f64)) -> bool {
        let p: [f64; 3] = std::array::from_fn(|k| start[k] - self.origin[k]);
        let (u, v, w) = ((self.axis + 1) % 3, (self.axis + 2) % 3, self.axis);
        let mut cuts = vec![0.0, 1.0];
        let mut cut = |t: f64| {
            if t > 0.0 && t < 1.0 {
                cuts.push(t);
            }
        };
        let (a, b) = (along[u] * along[u] + along[v] * along[v], p[u] * along[u] + p[v] * along[v]);
        if a > 0.0 {
            for i in 0..=self.cells[0] {
                let c = p[u] * p[u] + p[v] * p[v] - self.radius(i).powi(2);
                let root2 = b * b - a * c;
                if root2 > 0.0 {
                    // The root that does not cancel first, the other from their product.
                    let q = -(b + root2.sqrt().copysign(b));
                    cut(q / a);
                    if q != 0.0 {
                        cut(c / q);
                    }
                }
            }
        }
        if self.cells[1] > 1 {
            for j in 0..self.cells[1] {
                let (sine, cosine) = self.angle(j).sin_cos();
                let rate = along[v] * cosine - along[u] * sine;
                if rate != 0.0 {
                    cut(-(p[v] * cosine - p[u] * sine) / rate);
                }
            }
        }
        if along[w] != 0.0 {
            for k in 0..=self.cells[2] {
                cut((self.height(k) - p[w]) / along[w]);
            }
        }
        cuts.sort_by(f64::total_cmp);
        for pair in cuts.windows(2) {
            let middle = 0.5 * (pair[0] + pair[1]);
            let at = std::array::from_fn(|k| start[k] + middle * along[k]);
            if pair[1] > pair[0]
                && let Some(cell) = self.locate(at, &mut PathCounts::default())
            {
                visit(cell, pair[1] - pair[0]);
            }
        }
        true
    }
}
