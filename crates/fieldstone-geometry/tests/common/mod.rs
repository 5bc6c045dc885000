//! What the geometry tests share: shapes, an independent volume, a clipper.
//!
//! [`sliced_volume`] is the oracle of closed forms that nobody has written down: it integrates the areas of
//! planar slices and knows nothing of solid angles.

#![allow(dead_code, clippy::unwrap_used)]

use fieldstone_geometry::{CornerOrder, ElementKind, Orientation, Polyhedron};
pub use fieldstone_testing::Random;

pub mod invariants;

pub type Point = [f64; 3];

pub fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The point at `t` on the way from `a` to `b`.
pub fn between(a: Point, b: Point, t: f64) -> Point {
    [0, 1, 2].map(|k| a[k] + t * (b[k] - a[k]))
}

/// Corners of the unit shape of a kind, in CGNS order; all have edges along the axes at the origin.
pub fn unit_corners(kind: ElementKind) -> Vec<Point> {
    let [o, x, y, z] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    match kind {
        ElementKind::Tetrahedron => vec![o, x, y, z],
        ElementKind::Pyramid => vec![o, x, [1., 1., 0.], y, z],
        ElementKind::Wedge => vec![o, x, y, z, [1., 0., 1.], [0., 1., 1.]],
        _ => vec![o, x, [1., 1., 0.], y, z, [1., 0., 1.], [1.; 3], [0., 1., 1.]],
    }
}

pub fn element(kind: ElementKind, corners: &[Point]) -> Polyhedron {
    Polyhedron::element(kind, CornerOrder::Cgns, corners, Orientation::Refuse).unwrap()
}

/// Corners of a convex element of the kind, of size about 1, with planar faces (to rounding) that are not
/// parallel: the unit shape with its top scaled and shifted, under a random affine map. No slivers: the volume is
/// at least 1 % of the cube of the size (6 % for a corner of a cube, 19 % for a cube).
pub fn generic_corners(kind: ElementKind, random: &mut Random) -> Vec<Point> {
    loop {
        let (scale, shift) = (random.uniform(0.5, 1.3), random.point(-0.3, 0.3));
        let map: [Point; 3] = [0; 3].map(|_| random.point(-1.0, 1.0));
        if dot(map[0], cross(map[1], map[2])) < 0.05 {
            continue;
        }
        let corners: Vec<Point> = unit_corners(kind)
            .iter()
            .map(|p| {
                let s = 1.0 + (scale - 1.0) * p[2];
                let q = [p[0] * s + shift[0] * p[2], p[1] * s + shift[1] * p[2], p[2]];
                map.map(|row| dot(row, q))
            })
            .collect();
        if element(kind, &corners).volume() >= 0.01 * size_of(&corners).powi(3) {
            return corners;
        }
    }
}

/// A point on an edge or at a corner, off by 1e-18 to 1e-11 of `r`, along each axis on its own.
pub fn beside_an_edge<F: AsRef<[usize]>>(corners: &[Point], faces: &[F], r: f64, random: &mut Random) -> Point {
    let face = faces[random.below(faces.len())].as_ref();
    let k = random.below(face.len());
    let t = [0.0, 0.5, random.uniform(0.0, 1.0)][random.below(3)];
    let on = between(corners[face[k]], corners[face[(k + 1) % face.len()]], t);
    on.map(|x| x + r * [0.0, 1.0, -1.0][random.below(3)] * 10f64.powf(random.uniform(-18.0, -11.0)))
}

/// Largest distance of two corners.
pub fn size_of(corners: &[Point]) -> f64 {
    let mut largest = 0.0f64;
    for (k, &a) in corners.iter().enumerate() {
        for &b in &corners[..k] {
            largest = largest.max(dot(sub(a, b), sub(a, b)));
        }
    }
    largest.sqrt()
}

/// Corners and faces (counter-clockwise seen from outside) of a polyhedron, before it is built.
#[derive(Debug, Clone)]
pub struct Shape {
    pub corners: Vec<Point>,
    pub faces: Vec<Vec<usize>>,
}

impl Shape {
    pub fn of(kind: ElementKind, corners: &[Point]) -> Self {
        Self { corners: corners.to_vec(), faces: kind.faces().iter().map(|f| f.to_vec()).collect() }
    }

    pub fn cuboid(low: Point, high: Point) -> Self {
        let corners: Vec<Point> = unit_corners(ElementKind::Hexahedron)
            .iter()
            .map(|p| [0, 1, 2].map(|k| if p[k] == 0.0 { low[k] } else { high[k] }))
            .collect();
        Self::of(ElementKind::Hexahedron, &corners)
    }

    pub fn build(&self) -> Polyhedron {
        Polyhedron::from_faces(&self.corners, &self.faces, Orientation::Refuse).unwrap()
    }

    pub fn map(&self, f: impl Fn(Point) -> Point) -> Self {
        Self { corners: self.corners.iter().map(|&p| f(p)).collect(), faces: self.faces.clone() }
    }

    /// The parts of a shape (convex, or all triangles) with n·x ≤ d and with n·x ≥ d; `None` where a corner is within `gap` of the plane
    /// (parts thinner than that have no faces that `f64` can tell) or where nothing is cut.
    pub fn split(&self, n: Point, d: f64, gap: f64) -> Option<[Self; 2]> {
        let side: Vec<f64> = self.corners.iter().map(|&p| dot(n, p) - d).collect();
        if side.iter().any(|s| s.abs() < gap) || side.iter().all(|&s| s < 0.0) || side.iter().all(|&s| s > 0.0) {
            return None;
        }
        // One new corner on each edge that the plane cuts, shared by both parts, so that they fit exactly.
        let mut corners = self.corners.clone();
        let mut on_edge = std::collections::BTreeMap::new();
        let parts = [-1.0, 1.0].map(|sign| {
            let mut faces = Vec::new();
            let mut cut = std::collections::BTreeMap::new();
            for face in &self.faces {
                let mut ring = Vec::new();
                let (mut enters, mut leaves) = (None, None);
                for (k, &a) in face.iter().enumerate() {
                    let b = face[(k + 1) % face.len()];
                    if sign * side[a] > 0.0 {
                        ring.push(a);
                    }
                    if side[a] * side[b] < 0.0 {
                        let new = *on_edge.entry((a.min(b), a.max(b))).or_insert_with(|| {
                            let (low, high) = (a.min(b), a.max(b));
                            corners.push(between(corners[low], corners[high], side[low] / (side[low] - side[high])));
                            corners.len() - 1
                        });
                        ring.push(new);
                        if sign * side[a] > 0.0 {
                            leaves = Some(new);
                        } else {
                            enters = Some(new);
                        }
                    }
                }
                if ring.len() >= 3 {
                    faces.push(ring);
                }
                // The cut runs against the new edge of each face.
                if let (Some(from), Some(to)) = (enters, leaves) {
                    cut.insert(from, to);
                }
            }
            // One loop where the shape is convex, else maybe several.
            while let Some((first, second)) = cut.pop_first() {
                let mut ring = vec![first, second];
                while let Some(next) = cut.remove(ring.last().unwrap()) {
                    if next != first {
                        ring.push(next);
                    }
                }
                faces.push(ring);
            }
            faces
        });
        Some(parts.map(|faces| Self { corners: corners.clone(), faces }.compact()))
    }

    /// Without the corners that no face uses.
    fn compact(self) -> Self {
        let mut new = vec![usize::MAX; self.corners.len()];
        let mut corners = Vec::new();
        let faces = self
            .faces
            .iter()
            .map(|face| {
                face.iter()
                    .map(|&k| {
                        if new[k] == usize::MAX {
                            new[k] = corners.len();
                            corners.push(self.corners[k]);
                        }
                        new[k]
                    })
                    .collect()
            })
            .collect();
        Self { corners, faces }
    }
}

/// Volume of ball ∩ shape by integrating the areas of slices: error some 1e-13 of the smaller cube of the sizes.
///
/// The faces may be non-convex: each is fanned into signed triangles. Slices are taken along a direction in general
/// position; between the heights at which the area of a slice is not smooth it is integrated by an adaptive
/// Gauss–Legendre rule.
pub fn sliced_volume(shape: &Shape, centre: Point, r: f64) -> f64 {
    let turn = general_rotation();
    let points: Vec<Point> = shape
        .corners
        .iter()
        .map(|&p| {
            let q = sub(p, centre).map(|x| x / r);
            turn.map(|row| dot(row, q))
        })
        .collect();
    let triangles: Vec<[Point; 3]> = shape
        .faces
        .iter()
        .flat_map(|f| f[1..].windows(2).map(|w| [points[f[0]], points[w[0]], points[w[1]]]).collect::<Vec<_>>())
        .collect();

    let mut heights = vec![-1.0, 1.0];
    heights.extend(points.iter().map(|p| p[2]));
    for [a, b, c] in &triangles {
        let n = cross(sub(*b, *a), sub(*c, *a));
        let nn = dot(n, n);
        if nn == 0.0 {
            continue;
        }
        let d = dot(n, *a);
        let middle = d * n[2] / nn;
        heights.push(middle);
        let rise = ((1.0 - d * d / nn) * (1.0 - n[2] * n[2] / nn)).max(0.0).sqrt();
        heights.extend([middle - rise, middle + rise]);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let along = sub(*q, *p);
            let (aa, pa) = (dot(along, along), dot(*p, along));
            let foot = between(*p, *q, -pa / aa);
            let half = ((1.0 - dot(foot, foot)) / aa).max(0.0).sqrt();
            for t in [-pa / aa - half, -pa / aa + half] {
                if (-1e-9..=1.0 + 1e-9).contains(&t) {
                    heights.push(p[2] + t * along[2]);
                }
            }
        }
    }
    let low = points.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min).max(-1.0);
    let high = points.iter().map(|p| p[2]).fold(f64::NEG_INFINITY, f64::max).min(1.0);
    heights.retain(|h| (low..=high).contains(h));
    heights.sort_by(f64::total_cmp);

    let area = |z: f64| -> f64 {
        let s2 = 1.0 - z * z;
        let mut sum = 0.0;
        for triangle in &triangles {
            let (mut enter, mut leave) = (None, None);
            for k in 0..3 {
                let (p, q) = (triangle[k], triangle[(k + 1) % 3]);
                if (p[2] >= z) != (q[2] >= z) {
                    let at = between(p, q, (z - p[2]) / (q[2] - p[2]));
                    // With the inside on the left, the slice of a face runs from where its outline goes down to
                    // where it goes up.
                    if q[2] >= z {
                        leave = Some(at);
                    } else {
                        enter = Some(at);
                    }
                }
            }
            if let (Some(p), Some(q)) = (enter, leave) {
                sum += disc_sector(p, q, s2);
            }
        }
        sum
    };
    let mut volume = 0.0;
    let mut start = low;
    for &end in &heights {
        if end - start > 2e-15 {
            volume += refined(&area, start, end, gauss(&area, start, end), 16);
            start = end;
        }
    }
    volume * r.powi(3)
}

/// The rule on [a, b] in the variable x = sin, which takes out square roots at the ends.
fn gauss(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let quarter_turn = std::f64::consts::FRAC_PI_2;
    let sum = gauss_legendre().iter().map(|&(x, weight)| {
        let (sine, cosine) = (quarter_turn * x).sin_cos();
        weight * cosine * f(middle + half * sine)
    });
    half * quarter_turn * sum.sum::<f64>()
}

/// The integral over [a, b], halved as long as that changes it: singular points just outside spoil the rule.
fn refined(f: &impl Fn(f64) -> f64, a: f64, b: f64, whole: f64, depth: u32) -> f64 {
    let middle = 0.5 * (a + b);
    let (left, right) = (gauss(f, a, middle), gauss(f, middle, b));
    if (left + right - whole).abs() <= 1e-14 || depth == 0 {
        return left + right;
    }
    refined(f, a, middle, left, depth - 1) + refined(f, middle, b, right, depth - 1)
}

/// Signed area of the part of the disc of squared radius `s2` in the triangle (centre, p, q) of the plane.
fn disc_sector(p: Point, q: Point, s2: f64) -> f64 {
    let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
    let a = dx * dx + dy * dy;
    if a == 0.0 {
        return 0.0;
    }
    let angle = |px: f64, py: f64, qx: f64, qy: f64| (px * qy - py * qx).atan2(px * qx + py * qy);
    let turn = p[0] * q[1] - p[1] * q[0];
    let b = p[0] * dx + p[1] * dy;
    let root = (s2 * a - turn * turn).max(0.0).sqrt();
    let (low, high) = (((-b - root) / a).max(0.0), ((-b + root) / a).min(1.0));
    if low >= high {
        return 0.5 * s2 * angle(p[0], p[1], q[0], q[1]);
    }
    let mut area = turn * (high - low);
    if low > 0.0 {
        area += s2 * angle(p[0], p[1], p[0] + low * dx, p[1] + low * dy);
    }
    if high < 1.0 {
        area += s2 * angle(p[0] + high * dx, p[1] + high * dy, q[0], q[1]);
    }
    0.5 * area
}

fn general_rotation() -> [Point; 3] {
    // From a unit quaternion without any symmetry.
    let q = [0.62f64, 0.31, -0.47, 0.29];
    let n = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [w, x, y, z] = q.map(|c| c / n);
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// Nodes and weights on [−1, 1], found by Newton's method on the Legendre polynomial.
fn gauss_legendre() -> &'static [(f64, f64)] {
    static RULE: std::sync::OnceLock<Vec<(f64, f64)>> = std::sync::OnceLock::new();
    RULE.get_or_init(|| {
        let n = 16;
        (1..=n)
            .map(|i| {
                let mut x = (std::f64::consts::PI * (f64::from(i) - 0.25) / (f64::from(n) + 0.5)).cos();
                let mut slope = 1.0;
                for _ in 0..100 {
                    let (mut p, mut before) = (1.0, 0.0);
                    for k in 0..n {
                        let k = f64::from(k);
                        (p, before) = (((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0), p);
                    }
                    slope = f64::from(n) * (x * p - before) / (x * x - 1.0);
                    let step = p / slope;
                    x -= step;
                    if step.abs() < 1e-16 {
                        break;
                    }
                }
                (x, 2.0 / ((1.0 - x * x) * slope * slope))
            })
            .collect()
    })
}
