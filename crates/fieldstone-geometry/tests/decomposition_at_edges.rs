//! The decomposition where the centre is within rounding of an edge or corner, against closed forms and the kernel.

#![allow(clippy::unwrap_used, reason = "a test that cannot build its input has failed")]

mod common;

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use common::{Point, between, element, unit_corners};
use fieldstone_geometry::decomposition::{DecompositionElement, overlap_sphere_area, overlap_volume};
use fieldstone_geometry::{Ball, ElementKind, overlap};

/// From below what `f64` resolves beside a radius of 0.3 to far above.
const NUDGES: [f64; 13] = [0.0, 1e-17, 5e-17, 1e-16, 2e-16, 3.2e-16, 5e-16, 1e-15, 3e-15, 1e-14, 1e-13, 3e-13, 1e-12];

const KINDS: [ElementKind; 3] = [ElementKind::Tetrahedron, ElementKind::Wedge, ElementKind::Hexahedron];

/// What the method promises, of the ball's volume.
const OF_BALL: f64 = 5e-15;

fn decomposed(kind: ElementKind, corners: &[Point]) -> DecompositionElement {
    match kind {
        ElementKind::Tetrahedron => DecompositionElement::tetrahedron(corners.try_into().unwrap()),
        ElementKind::Wedge => DecompositionElement::wedge(corners.try_into().unwrap()),
        _ => DecompositionElement::hexahedron(corners.try_into().unwrap()),
    }
    .unwrap()
}

/// All nudges in two directions, equal and unequal, in all combinations of signs.
fn pairs() -> impl Iterator<Item = [f64; 2]> {
    let signed = || NUDGES.into_iter().flat_map(|x| [x, -x]);
    signed().flat_map(move |a| signed().map(move |b| [a, b]))
}

fn holds(element: &DecompositionElement, centre: Point, r: f64, volume: f64, area: f64) {
    let ball = Ball::new(centre, r).unwrap();
    let found = overlap_volume(&ball, element);
    let error = (found - volume).abs() / ball.volume();
    assert!(error <= OF_BALL, "{} {centre:?}, r {r}: {found} for {volume}, {error:e} of the ball", element.kind());
    let found = overlap_sphere_area(&ball, element);
    let error = (found - area).abs() / ball.surface_area();
    assert!(error <= OF_BALL, "{} {centre:?}, r {r}: area {found} for {area}", element.kind());
}

#[test]
fn a_ball_within_rounding_of_an_edge_is_a_slice_and_two_halves_of_thin_discs() {
    let r = 0.3_f64;
    // The right-angled edge that each kind has along z.
    for kind in KINDS {
        let element = decomposed(kind, &unit_corners(kind));
        for [x, y] in pairs() {
            let (slice, inside) = (FRAC_PI_2, x + y);
            let volume = 2.0 / 3.0 * slice * r.powi(3) + FRAC_PI_2 * r * r * inside;
            let area = 2.0 * slice * r * r + PI * r * inside;
            holds(&element, [x, y, 0.45], r, volume, area);
        }
    }
    // The far edges of the cube, where the distances are exact though the coordinates are rounded.
    let cube = decomposed(ElementKind::Hexahedron, &unit_corners(ElementKind::Hexahedron));
    for [x, y] in pairs() {
        let (x, y) = (1.0 + x, 1.0 + y);
        let inside = (1.0 - x) + (1.0 - y);
        let volume = PI / 3.0 * r.powi(3) + FRAC_PI_2 * r * r * inside;
        holds(&cube, [x, y, 0.5], r, volume, PI * r * r + PI * r * inside);
    }
    // The sharp edge of the wedge, of 45°: its planes are y = 0 and x + y = 1.
    let wedge = decomposed(ElementKind::Wedge, &unit_corners(ElementKind::Wedge));
    for [x, y] in pairs() {
        let x = 1.0 + x;
        let inside = y + ((1.0 - x) - y) * 0.5f64.sqrt();
        let volume = 2.0 / 3.0 * FRAC_PI_4 * r.powi(3) + FRAC_PI_2 * r * r * inside;
        holds(&wedge, [x, y, 0.5], r, volume, 2.0 * FRAC_PI_4 * r * r + PI * r * inside);
    }
}

#[test]
fn a_ball_within_rounding_of_a_corner_is_an_eighth_and_three_quarters_of_thin_discs() {
    let r = 0.4_f64;
    for kind in KINDS {
        let element = decomposed(kind, &unit_corners(kind));
        for [x, y] in pairs() {
            for z in [0.0, 1e-16, -1e-16, 3.2e-16, -3.2e-16, 1e-13, -1e-13, x, y, -x] {
                let inside = x + y + z;
                let volume = PI / 6.0 * r.powi(3) + FRAC_PI_4 * r * r * inside;
                holds(&element, [x, y, z], r, volume, FRAC_PI_2 * r * r + FRAC_PI_2 * r * inside);
            }
        }
    }
}

#[test]
fn within_rounding_of_every_edge_and_corner_the_decomposition_is_the_kernel() {
    for kind in KINDS {
        // Turned and sheared, so that no plane is parallel to an axis.
        let skew = |p: Point| {
            [
                p[0] + 0.2 * p[1] - 0.1 * p[2],
                0.9 * p[1] + 0.15 * p[0] + 0.1 * p[2],
                1.1 * p[2] - 0.2 * p[0] + 0.05 * p[1],
            ]
        };
        for corners in [unit_corners(kind), unit_corners(kind).into_iter().map(skew).collect::<Vec<_>>()] {
            let (ours, kernel) = (decomposed(kind, &corners), element(kind, &corners));
            for face in kind.faces() {
                for (k, &from) in face.iter().enumerate() {
                    let to = face[(k + 1) % face.len()];
                    for t in [0.0, 0.45] {
                        let on = between(corners[from], corners[to], t);
                        for [a, b] in pairs() {
                            for nudge in [[a, b, 0.0], [0.0, a, b], [b, a, -a]] {
                                let centre = [0, 1, 2].map(|i| on[i] + nudge[i]);
                                let exact = overlap(&Ball::new(centre, 0.3).unwrap(), &kernel);
                                holds(&ours, centre, 0.3, exact.volume, exact.sphere_area);
                            }
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn a_lattice_of_decimal_fractions_on_a_grid_of_its_cells_is_cut_into_eighths() {
    // A fortieth times a whole number is beside the whole number over forty by an ulp or none, which are ulps of all
    // sizes along the lattice.
    let plane = |n: u32| f64::from(n) / 40.0;
    let r = 0.0125_f64;
    let mut beside = 0;
    for (i, j, k) in (1..40).flat_map(|i| (1..40).flat_map(move |j| [3, 7, 20].map(|k| (i, j, k)))) {
        let at = [i, j, k];
        let centre = at.map(|n| f64::from(n) * 0.025);
        // How far the centre is beyond the planes: the difference of two neighbours is exact.
        let off: Point = std::array::from_fn(|a| centre[a] - plane(at[a]));
        beside += usize::from(off != [0.0; 3]);
        for octant in 0..8u32 {
            let upper = [0, 1, 2].map(|a| octant >> a & 1);
            let corner = |p: Point| std::array::from_fn(|a| plane(at[a] - 1 + upper[a] + u32::from(p[a] == 1.0)));
            let corners: Vec<Point> = unit_corners(ElementKind::Hexahedron).into_iter().map(corner).collect();
            let inside: f64 = (0..3).map(|a| if upper[a] == 1 { off[a] } else { -off[a] }).sum();
            let volume = PI / 6.0 * r.powi(3) + FRAC_PI_4 * r * r * inside;
            let area = FRAC_PI_2 * r * r + FRAC_PI_2 * r * inside;
            holds(&decomposed(ElementKind::Hexahedron, &corners), centre, r, volume, area);
        }
    }
    assert!(beside > 1000, "{beside} centres are beside a plane");
}
