//! Squares of the sphere, and which of them a neighbour in a given direction covers for certain.

use std::fmt;

use glam::DVec3;

/// Squares per edge of a cube's face: 6 × 6² = 216 squares in all, so a set of them is four words. More squares decide
/// more particles at once, but cost more memory traffic on all: 384 were slower on disordered blocks.
const DIVISIONS: usize = 6;

/// 64-bit words of a set of squares.
pub(crate) const WORDS: usize = (6 * DIVISIONS * DIVISIONS).div_ceil(64);

/// Levels of each coordinate in the table over directions.
const LEVELS: usize = 16;

/// Neighbours may be rounded into the next cell: cells overlap by this much.
const OVERLAP: f64 = 1e-6;

/// A set of squares.
pub(crate) type Squares = [u64; WORDS];

/// A square on the sphere, bounded by great circles; its corners in order around it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Square {
    pub(crate) corners: [DVec3; 4],
}

impl Square {
    pub(crate) fn centre(&self) -> DVec3 {
        (self.corners[0] + self.corners[1] + self.corners[2] + self.corners[3]).normalize()
    }

    /// Four squares that together are this one.
    pub(crate) fn quarters(&self, centre: DVec3) -> [Self; 4] {
        let [a, b, c, d] = self.corners;
        let middle = |p: DVec3, q: DVec3| (p + q).normalize();
        let (ab, bc, cd, da) = (middle(a, b), middle(b, c), middle(c, d), middle(d, a));
        [[a, ab, centre, da], [ab, b, bc, centre], [centre, bc, c, cd], [da, centre, cd, d]]
            .map(|corners| Self { corners })
    }
}

/// For each cell of directions, the squares within θ of every direction in the cell.
///
/// Directions are scaled until their largest coordinate is ±1, and each coordinate is rounded to one of 16 levels, so
/// no case for the cube's face is needed; only the table's outermost shell is ever used. A square lies within θ of a
/// whole cell if and only if all its corners lie within θ of all corners of the cell: caps below 90° are convex, and
/// so are squares and cells.
pub(crate) struct CoverTable {
    pub(crate) squares: Vec<Square>,
    pub(crate) cos: f64,
    pub(crate) angle: f64,
    cells: Vec<Squares>,
    /// All squares.
    pub(crate) all: Squares,
}

impl fmt::Debug for CoverTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CoverTable").field("angle", &self.angle).finish_non_exhaustive()
    }
}

/// Point of the cube's face (axis, sign) at (u, v).
fn on_cube(axis: usize, sign: f64, u: f64, v: f64) -> DVec3 {
    let mut p = [0.0; 3];
    p[axis] = sign;
    p[(axis + 1) % 3] = u;
    p[(axis + 2) % 3] = v;
    DVec3::from_array(p)
}

/// The squares at the roots of the division: equal angles along each edge of a cube.
pub(crate) fn root_squares() -> Vec<Square> {
    let edge = |i: usize| (std::f64::consts::FRAC_PI_4 * (2.0 * i as f64 / DIVISIONS as f64 - 1.0)).tan();
    let mut squares = Vec::with_capacity(6 * DIVISIONS * DIVISIONS);
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            for i in 0..DIVISIONS {
                for j in 0..DIVISIONS {
                    let corner = |i, j| on_cube(axis, sign, edge(i), edge(j)).normalize();
                    squares.push(Square {
                        corners: [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)],
                    });
                }
            }
        }
    }
    squares
}

impl CoverTable {
    /// The table for caps of half-angle `angle` < 90°.
    pub(crate) fn new(angle: f64) -> Self {
        let squares = root_squares();
        let cos = angle.cos();
        let mut all = [0; WORDS];
        for q in 0..squares.len() {
            all[q / 64] |= 1 << (q % 64);
        }
        let bounds: Vec<(DVec3, f64)> = squares.iter().map(|s| bounding_cap(s.centre(), &s.corners)).collect();
        let mut cells = vec![[0; WORDS]; LEVELS * LEVELS * LEVELS];
        for (index, cell) in cells.iter_mut().enumerate() {
            let corners = cell_corners([index / (LEVELS * LEVELS), index / LEVELS % LEVELS, index % LEVELS]);
            if corners.is_empty() {
                continue;
            }
            let (centre, radius) = bounding_cap(corners.iter().sum::<DVec3>().normalize(), &corners);
            for (q, square) in squares.iter().enumerate() {
                let apart = centre.dot(bounds[q].0).clamp(-1.0, 1.0).acos();
                let covered = apart + radius + bounds[q].1 < angle
                    || apart < angle && corners.iter().all(|c| square.corners.iter().all(|s| c.dot(*s) >= cos));
                if covered {
                    cell[q / 64] |= 1 << (q % 64);
                }
            }
        }
        Self { squares, cos, angle, cells, all }
    }

    /// Squares that a neighbour in a direction is certain to cover; `cell` from [`cell_of`].
    #[inline(always)]
    pub(crate) fn covered(&self, cell: usize) -> &Squares {
        &self.cells[cell & (LEVELS * LEVELS * LEVELS - 1)]
    }
}

fn bounding_cap(centre: DVec3, corners: &[DVec3]) -> (DVec3, f64) {
    let farthest = corners.iter().map(|c| c.dot(centre)).fold(1.0, f64::min);
    (centre, farthest.clamp(-1.0, 1.0).acos() + 1e-9)
}

/// Corners of all parts of the cube's surface that a cell of the table holds; none where it holds none.
fn cell_corners(levels: [usize; 3]) -> Vec<DVec3> {
    let range = |level: usize| {
        let step = 2.0 / LEVELS as f64;
        let low = -1.0 + step * level as f64;
        [low - OVERLAP, low + step + OVERLAP]
    };
    let mut corners = Vec::new();
    for axis in 0..3 {
        for (outermost, sign) in [(LEVELS - 1, 1.0), (0, -1.0)] {
            if levels[axis] == outermost {
                for u in range(levels[(axis + 1) % 3]) {
                    for v in range(levels[(axis + 2) % 3]) {
                        corners.push(on_cube(axis, sign, u, v).normalize());
                    }
                }
            }
        }
    }
    corners
}

/// Cell of the table for the direction of (x, y, z), which is not zero.
///
/// The addition of 1.5 · 2⁵² rounds to an integer that then is in the lowest bits: unlike a conversion, every
/// processor does that in lanes.
#[inline(always)]
pub(crate) fn cell_of(x: f64, y: f64, z: f64) -> u32 {
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const HALF: f64 = 0.5 * LEVELS as f64;
    let largest = max(max(x.abs(), y.abs()), z.abs());
    // A little less than half the levels, so that ±1 stay within the outermost ones.
    let scale = HALF * (1.0 - 1e-8) / largest;
    let level = |t: f64| ((t * scale + (HALF - 0.5)) + ROUND).to_bits() as u32 & (LEVELS as u32 - 1);
    (level(x) * LEVELS as u32 + level(y)) * LEVELS as u32 + level(z)
}

/// Unlike `f64::max`, one instruction.
#[inline(always)]
fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use fieldstone_testing::Random;

    use super::*;

    /// Distance of a direction to a square, as far as corners and interior samples tell.
    fn farthest(square: &Square, z: DVec3) -> f64 {
        let [a, b, c, d] = square.corners;
        let mut least = 1.0f64;
        for i in 0..=8 {
            for j in 0..=8 {
                let (u, v) = (f64::from(i) / 8.0, f64::from(j) / 8.0);
                let p = (a.lerp(b, u)).lerp(d.lerp(c, u), v).normalize();
                least = least.min(p.dot(z));
            }
        }
        least
    }

    #[test]
    fn squares_of_the_table_are_wholly_within_the_angle() {
        let mut random = Random(3);
        for degrees in [30.0f64, 45.0, 70.0, 89.0] {
            let table = CoverTable::new(degrees.to_radians());
            let mut covered = 0;
            for n in 0..400 {
                // Axes, diagonals and small multiples of them are the directions of lattices.
                let z = if n < 125 {
                    let t = |k: i32| f64::from(n / 5i32.pow(k as u32) % 5 - 2);
                    DVec3::new(t(0), t(1), t(2)).normalize_or(DVec3::X)
                } else {
                    random.direction().into()
                };
                let set = table.covered(cell_of(3.0 * z.x, 3.0 * z.y, 3.0 * z.z) as usize);
                for (q, square) in table.squares.iter().enumerate() {
                    if set[q / 64] >> (q % 64) & 1 == 1 {
                        covered += 1;
                        assert!(farthest(square, z) >= table.cos - 1e-12, "{z} {q}");
                    }
                }
            }
            // A set that is always empty would be right but useless.
            assert!(covered as f64 > 86_400.0 * 0.4 * (0.5 - 0.5 * (degrees - 14.0).to_radians().cos()), "{covered}");
        }
    }

    #[test]
    fn four_quarters_are_the_square_and_all_squares_are_the_sphere() {
        let area = |s: &Square| {
            let triangle = |a: DVec3, b: DVec3, c: DVec3| {
                2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
            };
            let [a, b, c, d] = s.corners;
            triangle(a, b, c) + triangle(a, c, d)
        };
        let squares = root_squares();
        let total: f64 = squares.iter().map(area).sum();
        assert!((total - 4.0 * std::f64::consts::PI).abs() < 1e-12, "{total}");
        for square in &squares {
            let parts: f64 = square.quarters(square.centre()).iter().map(area).sum();
            assert!((parts - area(square)).abs() < 1e-14);
        }
    }
}
