//! Points around the circles for which round cells without sectors stand.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::CylinderGrid;

/// Fewest points around a circle.
const FEWEST: f64 = 8.0;

/// Most points around a circle: closer together, their angles would round to one.
const MOST: f64 = 1e15;

/// Share of a radius that rounding may take.
const ROUNDING: f64 = 1e-12;

impl CylinderGrid {
    /// Calls `visit` with the points in a box that stand for rings, with the ring's cell and the share of the point in it.
    ///
    /// Each ring's points, at most `spacing` apart, are equally far from each other around the circle in the middle of the
    /// cell's radii and heights, the first at angle 0; what the grid averages along its axis, one height, is in every box
    /// there. Sectors are ignored. The points are found by arithmetic and held nowhere, so a call costs the part of
    /// the circles that the box is seen under from the axis, over the spacing, however many points a circle has.
    ///
    /// ```
    /// use fieldstone_mesh::CylinderGrid;
    /// let ring = CylinderGrid::new(2, [0.0; 3], [0.9, 1.1], [0.0, 1.0], [1, 1, 1])?;
    /// let (mut points, mut share) = (0, 0.0);
    /// ring.for_each_ring_point([0.0, 0.0, 0.0], [2.0, 2.0, 1.0], 1e-3, |_, of_ring, _| {
    ///     points += 1;
    ///     share += of_ring;
    /// });
    /// // A quarter of the circle.
    /// assert!((share - 0.25f64).abs() < 1e-3 && points > 1570);
    /// # Ok::<(), fieldstone_mesh::MeshError>(())
    /// ```
    pub fn for_each_ring_point(
        &self,
        low: [f64; 3],
        high: [f64; 3],
        spacing: f64,
        mut visit: impl FnMut(u32, f64, [f64; 3]),
    ) {
        let axis = self.axis();
        let (low_height, high_height) = (low[axis] - self.origin[axis], high[axis] - self.origin[axis]);
        let one_height = self.cells()[2] == 1;
        let layers = if one_height { 0..1 } else { self.layers(low_height, high_height) };
        let [near, far] = self.distances(low, high);
        let seen = self.seen_under(low, high);
        let inside = |p: [f64; 3]| (0..3).all(|k| one_height && k == axis || (low[k]..=high[k]).contains(&p[k]));
        for k in layers {
            let z = 0.5 * (self.height(k) + self.height(k + 1));
            for i in self.shells(near, far) {
                let s = 0.5 * (self.radius(i) + self.radius(i + 1));
                // A box that holds the axis is seen under all angles, also by circles that it does not reach.
                if !(near * (1.0 - ROUNDING)..=far * (1.0 + ROUNDING)).contains(&s) {
                    continue;
                }
                let count = (TAU * s / spacing).ceil().clamp(FEWEST, MOST) as i64;
                let share = 1.0 / count as f64;
                for n in numbers(seen, count) {
                    let p = self.point([s, TAU * n.rem_euclid(count) as f64 / count as f64, z]);
                    if inside(p) {
                        visit(self.cell_at([i, 0, k]) as u32, share, p);
                    }
                }
            }
        }
    }

    /// Angles between which a box is seen from the axis; `None` where it holds a point of the axis.
    fn seen_under(&self, low: [f64; 3], high: [f64; 3]) -> Option<[f64; 2]> {
        let (u, v) = ((self.axis() + 1) % 3, (self.axis() + 2) % 3);
        let [us, vs] = [u, v].map(|k| [low[k] - self.origin[k], high[k] - self.origin[k]]);
        if us[0] <= 0.0 && us[1] >= 0.0 && vs[0] <= 0.0 && vs[1] >= 0.0 {
            return None;
        }
        // From the direction of the middle, from which the corners are less than half a turn away.
        let middle = [0.5 * (us[0] + us[1]), 0.5 * (vs[0] + vs[1])];
        let mut angles = [0.0f64; 2];
        for (u, v) in us.into_iter().flat_map(|u| vs.map(|v| (u, v))) {
            let angle = (middle[0] * v - middle[1] * u).atan2(middle[0] * u + middle[1] * v);
            angles = [angles[0].min(angle), angles[1].max(angle)];
        }
        let towards = middle[1].atan2(middle[0]);
        Some(angles.map(|angle| towards + angle))
    }
}

/// Numbers of the points, of `count` around a circle, between two angles: beyond 0…count by whole turns.
fn numbers(seen: Option<[f64; 2]>, count: i64) -> Range<i64> {
    let Some(angles) = seen else { return 0..count };
    // One to either side, for what rounding may have taken away.
    let first = (angles[0] / TAU * count as f64).floor() as i64 - 1;
    let end = (angles[1] / TAU * count as f64).ceil() as i64 + 2;
    if end - first >= count { 0..count } else { first..end }
}
