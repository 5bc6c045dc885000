//! Triangles on a lattice, in a tree of bounding boxes: crossings of rays in whole numbers, distances, thickness.

use glam::{DVec3, dvec3};
use rayon::prelude::*;

type Corner = [i64; 3];

/// Triangles in a leaf.
const LEAF: usize = 4;

#[derive(Debug, Clone, PartialEq)]
struct Node {
    low: Corner,
    high: Corner,
    /// Triangles of a leaf.
    start: usize,
    end: usize,
    /// The second child of an inner node, whose first is the node after it; 0 in a leaf.
    second: usize,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TriangleTree {
    triangles: Vec<[Corner; 3]>,
    nodes: Vec<Node>,
}

fn wide(a: Corner, b: Corner) -> [i128; 3] {
    std::array::from_fn(|k| i128::from(b[k]) - i128::from(a[k]))
}

/// (b − a) × (c − a).
fn normal([a, b, c]: &[Corner; 3]) -> [i128; 3] {
    let (u, v) = (wide(*a, *b), wide(*a, *c));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn vector(x: Corner) -> DVec3 {
    dvec3(x[0] as f64, x[1] as f64, x[2] as f64)
}

/// On which side of the edge from a to b a point is, along x; never undecided but for edges along x, which bound
/// nothing. The point is moved by (ε³, ε, ε²).
fn side(a: Corner, b: Corner, p: Corner) -> i128 {
    let (edge, from) = (wide(a, b), wide(a, p));
    let area = edge[1] * from[2] - edge[2] * from[1];
    // ε times −edge z, then ε² times edge y.
    [area, -edge[2], edge[1]].into_iter().find(|x| *x != 0).unwrap_or(0).signum()
}

/// Whether a ray from p along +x crosses a triangle: 1 outwards, −1 inwards, 0 not.
fn crossing(triangle: &[Corner; 3], p: Corner) -> i64 {
    let [a, b, c] = *triangle;
    let first = side(a, b, p);
    if first == 0 || side(b, c, p) != first || side(c, a, p) != first {
        return 0;
    }
    let n = normal(triangle);
    let from = wide(a, p);
    let height = n[0] * from[0] + n[1] * from[1] + n[2] * from[2];
    let height = [height, n[1], n[2], n[0]].into_iter().find(|x| *x != 0).unwrap_or(0).signum();
    // Ahead where p is on the inner side of a face that the ray leaves through.
    if height == -first { first as i64 } else { 0 }
}

impl TriangleTree {
    /// A tree of the triangles that have an area.
    pub(crate) fn new(mut triangles: Vec<[Corner; 3]>) -> Self {
        triangles.retain(|t| normal(t) != [0; 3]);
        let mut nodes = Vec::with_capacity(triangles.len());
        let count = triangles.len();
        build(&mut triangles, 0, count, &mut nodes);
        Self { triangles, nodes }
    }

    pub(crate) fn triangles(&self) -> &[[Corner; 3]] {
        &self.triangles
    }

    /// Enclosed volume in cells; negative where normals point inwards.
    pub(crate) fn volume(&self) -> f64 {
        // About the middle of the box, where terms are smallest.
        let middle = self.nodes.first().map_or(DVec3::ZERO, |n| 0.5 * (vector(n.low) + vector(n.high)));
        let six = |t: &[Corner; 3]| {
            let [a, b, c] = t.map(|x| vector(x) - middle);
            a.dot(b.cross(c))
        };
        self.triangles.iter().map(six).sum::<f64>() / 6.0
    }

    /// How often the surface winds around a point.
    pub(crate) fn winding(&self, p: Corner) -> i64 {
        let mut sum = 0;
        let hit = |n: &Node| (1..3).all(|k| n.low[k] <= p[k] && p[k] <= n.high[k]) && p[0] <= n.high[0];
        self.visit(hit, |triangle| sum += crossing(triangle, p));
        sum
    }

    /// Calls `visit` on the triangles of all leaves whose boxes, and those around them, are `hit`.
    fn visit(&self, hit: impl Fn(&Node) -> bool, mut visit: impl FnMut(&[Corner; 3])) {
        let mut waiting = if self.nodes.is_empty() { vec![] } else { vec![0] };
        while let Some(index) = waiting.pop() {
            let node = &self.nodes[index];
            if !hit(node) {
                continue;
            }
            if node.second == 0 {
                self.triangles[node.start..node.end].iter().for_each(&mut visit);
            } else {
                waiting.extend([node.second, index + 1]);
            }
        }
    }

    /// Distance of a point from the nearest triangle, in cells.
    pub(crate) fn distance(&self, x: [f64; 3]) -> f64 {
        let x = DVec3::from_array(x);
        let away = |n: &Node| (vector(n.low) - x).max(x - vector(n.high)).max(DVec3::ZERO).length_squared();
        let mut nearest = f64::INFINITY;
        let mut waiting: Vec<(f64, usize)> = self.nodes.first().map(|n| (away(n), 0)).into_iter().collect();
        while let Some((square, index)) = waiting.pop() {
            if square >= nearest {
                continue;
            }
            let node = &self.nodes[index];
            if node.second == 0 {
                for t in &self.triangles[node.start..node.end] {
                    nearest = nearest.min(square_distance(x, t.map(vector)));
                }
                continue;
            }
            let children = [index + 1, node.second].map(|child| (away(&self.nodes[child]), child));
            // The nearer one is looked at first: last in.
            let order = if children[0].0 <= children[1].0 { [1, 0] } else { [0, 1] };
            waiting.extend(order.map(|k| children[k]));
        }
        nearest.sqrt()
    }

    /// Least length below `needed` of rays that go inwards from points of all triangles and leave through a face whose
    /// normal has a cosine above `opposite` to the ray, and where that ray starts.
    pub(crate) fn thinnest(&self, needed: f64, opposite: f64, inside_out: bool) -> Option<(f64, [f64; 3])> {
        let turn = if inside_out { -1.0 } else { 1.0 };
        let of_triangle = |triangle: &[Corner; 3]| {
            let [a, b, c] = triangle.map(vector);
            let inwards = -turn * (b - a).cross(c - a).normalize_or_zero();
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            let parts = (2.0 * longest / needed).ceil().max(1.0) as usize;
            let mut least: Option<(f64, [f64; 3])> = None;
            // Centroids of the equal triangles that it is divided into.
            for i in 0..parts {
                for j in 0..2 * (parts - i) - 1 {
                    let third = if j % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
                    let (s, t) = (i as f64 + third, (j / 2) as f64 + third);
                    let from = a + (s * (b - a) + t * (c - a)) / parts as f64;
                    let bound = least.map_or(needed, |l| l.0);
                    if let Some(length) = self.leaves_after(from, inwards, bound, opposite, turn) {
                        least = Some((length, from.to_array()));
                    }
                }
            }
            least
        };
        let each: Vec<_> = self.triangles.par_iter().map(of_triangle).collect();
        each.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Length of a ray up to the first face that it leaves through, where that is below `bound` and nearly at right
    /// angles to the ray.
    fn leaves_after(&self, from: DVec3, direction: DVec3, bound: f64, opposite: f64, turn: f64) -> Option<f64> {
        let to = from + bound * direction;
        let (low, high) = (from.min(to), from.max(to));
        let hit = |n: &Node| vector(n.low).cmple(high).all() && vector(n.high).cmpge(low).all();
        let (mut nearest, mut cosine) = (bound, 0.0);
        self.visit(hit, |triangle| {
            let [a, b, c] = triangle.map(vector);
            let n = turn * (b - a).cross(c - a);
            let across = n.dot(direction);
            if across <= 0.0 {
                return;
            }
            let length = n.dot(a - from) / across;
            // Beyond the rounding of the start's own plane.
            if length <= 1.0 || length >= nearest {
                return;
            }
            let x = from + length * direction;
            let within = [(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| (q - p).cross(x - p).dot(n) * turn >= 0.0);
            if within {
                (nearest, cosine) = (length, across / n.length());
            }
        });
        (nearest < bound && cosine > opposite).then_some(nearest)
    }
}

fn build(triangles: &mut [[Corner; 3]], start: usize, end: usize, nodes: &mut Vec<Node>) {
    if start == end {
        return;
    }
    let part = &mut triangles[start..end];
    let mut node = Node { low: [i64::MAX; 3], high: [i64::MIN; 3], start, end, second: 0 };
    for x in part.iter().flatten() {
        node.low = std::array::from_fn(|k| node.low[k].min(x[k]));
        node.high = std::array::from_fn(|k| node.high[k].max(x[k]));
    }
    let axis = (0..3).max_by_key(|&k| node.high[k] - node.low[k]).unwrap_or(0);
    let index = nodes.len();
    nodes.push(node);
    if end - start <= LEAF {
        return;
    }
    part.sort_unstable_by_key(|t| (t.iter().map(|x| x[axis]).sum::<i64>(), *t));
    let middle = start + (end - start) / 2;
    build(triangles, start, middle, nodes);
    nodes[index].second = nodes.len();
    build(triangles, middle, end, nodes);
}

/// Distance squared of a point from a triangle: from its plane where the foot lies inside, else from its nearest edge.
fn square_distance(x: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let n = (b - a).cross(c - a);
    let inside = |p: DVec3, q: DVec3| (q - p).cross(x - p).dot(n) >= 0.0;
    if inside(a, b) && inside(b, c) && inside(c, a) {
        let height = (x - a).dot(n);
        return height * height / n.length_squared();
    }
    let edge = |p: DVec3, q: DVec3| {
        let along = ((x - p).dot(q - p) / (q - p).length_squared()).clamp(0.0, 1.0);
        (x - p - along * (q - p)).length_squared()
    };
    edge(a, b).min(edge(b, c)).min(edge(c, a))
}
