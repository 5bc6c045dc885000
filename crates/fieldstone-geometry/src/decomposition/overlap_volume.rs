//! Volume of the overlap of a ball and an element (Algorithm 1, Eq. 2).

use glam::DVec3;

use super::cone::Cone;
use super::element::DecompositionElement;
use super::general_wedge::{WedgePlanes, unit_general_wedge};
use super::intersect_primitives::Intersections;
use super::part::Part;
use super::regularized_wedge::half_chord;

/// The overlap, or which of the shortcuts of Algorithm 1 applies.
enum Overlap {
    Nothing,
    WholeElement,
    /// In units of the radius.
    Ball(Part),
}

/// Volume and sphere area, see the functions of [`super`].
pub(super) fn volume(centre: [f64; 3], radius: f64, element: &DecompositionElement) -> f64 {
    match overlap(centre, radius, element) {
        Overlap::Nothing => 0.0,
        Overlap::WholeElement => element.volume(),
        // A huge ball's rounding errors can be larger than the element.
        Overlap::Ball(part) => (part.triple_volume * (radius * radius * radius) / 3.0).min(element.volume()),
    }
}

pub(super) fn sphere_area(centre: [f64; 3], radius: f64, element: &DecompositionElement) -> f64 {
    match overlap(centre, radius, element) {
        Overlap::Nothing | Overlap::WholeElement => 0.0,
        Overlap::Ball(part) => part.area * (radius * radius),
    }
}

#[inline]
fn overlap(centre: [f64; 3], radius: f64, element: &DecompositionElement) -> Overlap {
    let centre = DVec3::from(centre);
    // Line 2: bounding boxes.
    let clear = (centre + radius).cmple(element.lower) | (centre - radius).cmpge(element.upper);
    if clear.any() {
        return Overlap::Nothing;
    }
    let inverse_radius = 1.0 / radius;
    let mut found = Intersections::of_vertices(element, centre, inverse_radius);
    // Lines 3–5.
    if found.vertices.count_ones() == u32::from(element.counts.vertices) {
        return Overlap::WholeElement;
    }
    // The planes are needed below; that one of them keeps the ball outside is a second coarse test for nothing.
    if !found.planes(element, centre, inverse_radius) {
        return Overlap::Nothing;
    }
    found.edges_and_faces(element, inverse_radius);
    // Lines 7–11. A face is marked with any of its edges and vertices, so no face is nothing at all.
    if found.faces == 0 {
        let centre_inside = found.distance[..element.faces().len()].iter().all(|&d| d >= 0.0);
        return if centre_inside { Overlap::Ball(Part::BALL) } else { Overlap::Nothing };
    }
    Overlap::Ball(partial(element, &found))
}

/// Lines 12–24, for the unit ball.
fn partial(element: &DecompositionElement, found: &Intersections) -> Part {
    let (faces, edges, vertices) = (element.faces(), element.edges(), element.vertices());
    let mut part = Part::BALL;
    for index in bits(found.faces.into()) {
        part -= Part::cap(found.distance[index]);
    }
    let mut wedges = [Part::default(); 12];
    for index in bits(found.edges) {
        let edge = &edges[index];
        let face = edge.faces.map(usize::from);
        // The foot point itself, not the planes' distances: these have rounding errors of their own, and where the
        // line passes close to the centre the angles come from small numbers that must belong to one vector.
        let [m0, m1] = found.position[index];
        let near = if m0.abs() <= m1.abs() { 0 } else { 1 };
        let foot = found.points[usize::from(edge.vertices[near])] - edge.direction * found.position[index][near];
        let planes = WedgePlanes::new(foot, face.map(|f| faces[f].normal), edge.outward);
        wedges[index] = unit_general_wedge(&planes, half_chord(planes.distance_squared()));
        part += wedges[index];
    }
    for index in bits(found.vertices.into()) {
        let vertex = &vertices[index];
        let reach = vertex.edges.map(|e| {
            let e = usize::from(e);
            // Along the edge's line from the foot, the element being on the positive side.
            let [m0, m1] = found.position[e];
            let position = if usize::from(edges[e].vertices[0]) == index { m0 } else { -m1 };
            // Distance against the edge to the sphere. Half the chord anew from the vertex's depth: both summands are
            // positive, and near tangency a chord of the line's own rounding would contradict the vertex being inside.
            let depth = found.depth[index];
            let half_chord = (position * position + depth).sqrt();
            if position > 0.0 { position + half_chord } else { depth / (half_chord - position) }
        });
        let cone =
            Cone { vertex, point: found.points[index], edges, faces, reach, wedges: &wedges, index: index as u8 };
        part -= cone.part();
    }
    // A wrong set of primitives misses by a whole wedge or cone: do not let the clamp below hide it.
    // What distances lose to the coordinates' rounding grows with the element, seen from a small ball.
    debug_assert!(
        {
            let farthest = found.points.iter().map(|p| p.length()).fold(1.0, f64::max);
            part.triple_volume > -1e-12 * farthest && part.area > -1e-12 * farthest
        },
        "negative overlap {part:?} with {found:?}"
    );
    // Rounding can leave a tiny negative number where the overlap is next to nothing.
    Part { triple_volume: part.triple_volume.max(0.0), area: part.area.max(0.0) }
}

/// Positions of the set bits, lowest first.
#[inline(always)]
fn bits(mut set: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let next = (set != 0).then(|| set.trailing_zeros() as usize);
        set &= set.wrapping_sub(1);
        next
    })
}
