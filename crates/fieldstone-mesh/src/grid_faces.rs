//! The faces of a Cartesian grid.

use fieldstone_geometry::Ball;

use crate::{Faces, Grid};

impl Grid {
    /// Faces normal to x, y and z: all of one direction after the other, x fastest within each.
    fn faces_along(&self, axis: usize) -> [usize; 3] {
        let mut counts = self.cells();
        counts[axis] += 1;
        counts
    }

    /// Number of the face normal to `axis` below the cell with indices `at`, which may be one beyond the last.
    pub fn face_at(&self, axis: usize, at: [usize; 3]) -> usize {
        let before: usize = (0..axis).map(|k| self.faces_along(k).iter().product::<usize>()).sum();
        let [nx, ny, _] = self.faces_along(axis);
        before + at[0] + nx * (at[1] + ny * at[2])
    }

    /// Direction of a face's normal and its indices.
    fn face_indices(&self, mut face: usize) -> (usize, [usize; 3]) {
        for axis in 0..2 {
            let count = self.faces_along(axis).iter().product();
            if face < count {
                return (axis, split(face, self.faces_along(axis)));
            }
            face -= count;
        }
        (2, split(face, self.faces_along(2)))
    }

    /// Index along `axis` of the cell that holds a coordinate, as [`crate::Cells::locate`] finds it;
    /// −1 and the number of cells beyond the ends.
    ///
    fn index_along(&self, axis: usize, x: f64) -> i64 {
        if x < self.low()[axis] {
            return -1;
        }
        if x > self.high()[axis] {
            return self.cells()[axis] as i64;
        }
        self.span(axis, x, x)[0].min(self.cells()[axis] - 1) as i64
    }
}

fn split(at: usize, [nx, ny, _]: [usize; 3]) -> [usize; 3] {
    [at % nx, at / nx % ny, at / (nx * ny)]
}

impl Faces for Grid {
    fn face_count(&self) -> usize {
        (0..3).map(|axis| self.faces_along(axis).iter().product::<usize>()).sum()
    }

    fn face_sides(&self, face: usize) -> [Option<u32>; 2] {
        let (axis, at) = self.face_indices(face);
        let back = at[axis].checked_sub(1).map(|below| {
            let mut cell = at;
            cell[axis] = below;
            self.cell_at(cell) as u32
        });
        [back, (at[axis] < self.cells()[axis]).then(|| self.cell_at(at) as u32)]
    }

    fn face_vector(&self, face: usize) -> [f64; 3] {
        let (axis, at) = self.face_indices(face);
        let mut vector = [0.0; 3];
        vector[axis] =
            [(axis + 1) % 3, (axis + 2) % 3].map(|k| self.plane(k, at[k] + 1) - self.plane(k, at[k])).iter().product();
        vector
    }

    /// A walk from cell to cell: the planes between the two ends' indices in the order in which they are passed. It
    /// starts and ends where the ends are by construction.
    fn for_each_crossing(&self, start: [f64; 3], end: [f64; 3], visit: &mut dyn FnMut(u32, f64)) {
        let along: [f64; 3] = std::array::from_fn(|k| end[k] - start[k]);
        let mut at: [i64; 3] = std::array::from_fn(|k| self.index_along(k, start[k]));
        let end: [i64; 3] = std::array::from_fn(|k| self.index_along(k, end[k]));
        if at == end {
            return;
        }
        let mut steps: Vec<(f64, usize, usize)> = Vec::new();
        for axis in 0..3 {
            let (low, high) = (at[axis].min(end[axis]), at[axis].max(end[axis]));
            for plane in low + 1..=high {
                steps.push(((self.plane(axis, plane as usize) - start[axis]) / along[axis], axis, plane as usize));
            }
        }
        // Of one axis the planes are in order; where rounding sees ties, any order is a walk.
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, axis, plane) in steps {
            let forward = end[axis] > at[axis];
            let mut face = at;
            face[axis] = plane as i64;
            let inside = |k: usize| k == axis || (at[k] >= 0 && at[k] < self.cells()[k] as i64);
            if (0..3).all(inside) {
                visit(self.face_at(axis, face.map(|i| i as usize)) as u32, if forward { 1.0 } else { -1.0 });
            }
            at[axis] += if forward { 1 } else { -1 };
        }
    }

    /// Discs cut by rectangles, in closed form: error some 1e-15 of the disc.
    fn for_each_cut(&self, ball: &Ball, visit: &mut dyn FnMut(u32, [f64; 3])) {
        let (c, r) = (ball.centre(), ball.radius());
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let [first, last] = self.span(axis, c[axis] - r, c[axis] + r);
            for plane in first..=last {
                let d = (self.plane(axis, plane) - c[axis]) / r;
                let s2 = (1.0 - d) * (1.0 + d);
                if s2 <= 0.0 {
                    continue;
                }
                let s = r * s2.sqrt();
                let spans = [u, v].map(|k| self.span(k, c[k] - s, c[k] + s));
                for j in spans[1][0]..spans[1][1] {
                    for i in spans[0][0]..spans[0][1] {
                        let side = |k: usize, index: usize| (self.plane(k, index) - c[k]) / s;
                        let (u0, u1, v0, v1) = (side(u, i), side(u, i + 1), side(v, j), side(v, j + 1));
                        let area =
                            (corner_area(u1, v1) - corner_area(u0, v1)) - (corner_area(u1, v0) - corner_area(u0, v0));
                        if area > 0.0 {
                            let mut at = [0; 3];
                            (at[axis], at[u], at[v]) = (plane, i, j);
                            let mut vector = [0.0; 3];
                            vector[axis] = area * s * s;
                            visit(self.face_at(axis, at) as u32, vector);
                        }
                    }
                }
            }
        }
    }
}

/// Area of the part of the unit disc with x < `a` and y < `b`.
fn corner_area(a: f64, b: f64) -> f64 {
    let (a, b) = (a.clamp(-1.0, 1.0), b.clamp(-1.0, 1.0));
    // ∫_{−1}^{a} of the chord's length below b.
    let root = |x: f64| ((1.0 - x) * (1.0 + x)).max(0.0).sqrt();
    let half = |x: f64| 0.5 * (x * root(x) + x.asin());
    let w = root(b);
    let mut area = 0.0;
    // Where |x| < w the line y = b cuts the chord; elsewhere the chord is all below it, or all above.
    let middle = a.clamp(-w, w);
    area += b * (middle + w) + (half(middle) - half(-w));
    if b > 0.0 {
        let left = a.min(-w);
        area += 2.0 * (half(left) - half(-1.0));
        if a > w {
            area += 2.0 * (half(a) - half(w));
        }
    }
    if a < -w {
        // Only the left part counts; the middle was clamped to nothing.
        return if b > 0.0 { 2.0 * (half(a) - half(-1.0)) } else { 0.0 };
    }
    area
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corner_areas_are_those_of_discs_half_discs_quarters_and_segments() {
        let pi = std::f64::consts::PI;
        let segment = |h: f64| h.acos() - h * (1.0 - h * h).sqrt();
        for (a, b, area) in [
            (2.0, 2.0, pi),
            (0.0, 2.0, 0.5 * pi),
            (0.0, 0.0, 0.25 * pi),
            (-1.0, 0.3, 0.0),
            (2.0, -0.4, segment(0.4)),
            (2.0, 0.4, pi - segment(0.4)),
            (-0.4, 2.0, segment(0.4)),
            // Two segments that do not meet.
            (0.9, 0.8, pi - segment(0.9) - segment(0.8)),
            (-0.9, -0.8, 0.0),
        ] {
            assert!((corner_area(a, b) - area).abs() < 1e-15, "{a} {b}: {}", corner_area(a, b) - area);
        }
        for k in 0..200 {
            let (a, b) = ((f64::from(k) * 0.7).sin(), (f64::from(k) * 1.3).cos());
            assert!((corner_area(a, b) - corner_area(b, a)).abs() < 1e-15, "{a} {b}");
        }
    }

    #[test]
    fn a_segment_walks_from_the_cell_of_one_end_to_that_of_the_other() {
        use crate::Cells;
        use fieldstone_testing::Random;
        let grid = Grid::new([0.0; 3], [3.0, 2.0, 2.0], [5, 4, 3]).unwrap();
        let random = &mut Random(5);
        for _ in 0..2000 {
            let start: [f64; 3] = random.point(-0.5, 3.5);
            let along: [f64; 3] = random.point(-1.5, 1.5);
            let mut balance = vec![0.0; grid.cell_count()];
            let end = std::array::from_fn(|k| start[k] + along[k]);
            grid.for_each_crossing(start, end, &mut |face, way| {
                let [back, front] = grid.face_sides(face as usize);
                back.into_iter().for_each(|c| balance[c as usize] -= way);
                front.into_iter().for_each(|c| balance[c as usize] += way);
            });
            let mut scratch = grid.scratch();
            if let Some(c) = grid.locate(start, &mut scratch) {
                balance[c as usize] += 1.0;
            }
            if let Some(c) = grid.locate(end, &mut scratch) {
                balance[c as usize] -= 1.0;
            }
            assert!(balance.iter().all(|b| *b == 0.0), "{start:?} {along:?}");
        }
    }
}
