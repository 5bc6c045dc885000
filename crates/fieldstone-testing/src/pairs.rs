//! Random and adversarial pairs of a ball and an element, as plain numbers: for every crate that bounds the error of their overlap.

use crate::Random;

fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] + t * (b[k] - a[k]))
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// A tetrahedron, or an affine image of the unit wedge, pyramid or cube: generic, on a lattice, flattened, or offset.
///
/// Its kind, as a place in `ElementKind::STANDARD`, and its corners in CGNS order; on a lattice it may have no volume.
pub fn element(random: &mut Random) -> (usize, Vec<[f64; 3]>) {
    let kind = random.below(4);
    let lattice = random.below(4) == 0;
    let mut axes = [random.point(-1.0, 1.0), random.point(-1.0, 1.0), random.point(-1.0, 1.0)];
    let origin = if random.below(8) == 0 { random.point(-1.0, 1.0).map(|x| x * 1e6) } else { random.point(-1.0, 1.0) };
    if lattice {
        axes = axes.map(|a| a.map(|x| (4.0 * x).round() / 4.0));
    }
    if random.below(4) == 0 {
        let flat = 10f64.powf(3.0 * random.uniform(-1.0, 1.0) - 3.0);
        let [a, b, c] = axes;
        axes[2] = [0, 1, 2].map(|k| flat * c[k] + a[k] * 0.4 + b[k] * 0.3);
    }
    let at = |u: f64, v: f64, w: f64| [0, 1, 2].map(|k| origin[k] + u * axes[0][k] + v * axes[1][k] + w * axes[2][k]);
    let corners = match kind {
        0 => vec![at(0., 0., 0.), at(1., 0., 0.), at(0., 1., 0.), at(0., 0., 1.)],
        1 => vec![at(0., 0., 0.), at(1., 0., 0.), at(1., 1., 0.), at(0., 1., 0.), at(0.5, 0.5, 1.)],
        2 => {
            vec![at(0., 0., 0.), at(1., 0., 0.), at(0., 1., 0.), at(0., 0., 1.), at(1., 0., 1.), at(0., 1., 1.)]
        }
        _ => [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
            .map(|[u, v, w]| at(f64::from(u), f64::from(v), f64::from(w)))
            .to_vec(),
    };
    (kind, corners)
}

/// A ball near the element: its centre anywhere, on a corner, edge or face; its surface anywhere or through a corner,
/// or touching an edge or a face.
///
/// Its centre and radius, which may be 0, from the element's corners and bounds.
pub fn ball(corners: &[[f64; 3]], (low, high): ([f64; 3], [f64; 3]), random: &mut Random) -> ([f64; 3], f64) {
    let pick = |random: &mut Random| corners[random.below(corners.len())];
    let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    let (a, b, c) = (pick(random), pick(random), pick(random));
    let centre = match random.below(8) {
        0 => a,
        1 => mix(a, b, 0.5 + 0.5 * random.uniform(-1.0, 1.0)),
        2 => mix(mix(a, b, 0.5), c, 0.5 + 0.5 * random.uniform(-1.0, 1.0)),
        _ => {
            let reach = size * 10f64.powf(1.5 * random.uniform(-1.0, 1.0));
            let p = random.point(-1.0, 1.0);
            [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]) + reach * p[k])
        }
    };
    let radius = match random.below(6) {
        0 => distance(centre, pick(random)),
        1 => distance(centre, mix(a, b, 0.5)),
        2 => size * 10f64.powf(6.0 * random.uniform(-1.0, 1.0)),
        3 => size * 10f64.powf(2.0 * random.uniform(-1.0, 1.0)),
        _ => {
            distance(centre, mix(a, b, 0.5 + 0.5 * random.uniform(-1.0, 1.0))) * (1.0 + 0.3 * random.uniform(-1.0, 1.0))
        }
    };
    (centre, radius)
}
