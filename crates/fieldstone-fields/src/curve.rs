//! An order of particles that keeps neighbours together.

use rayon::prelude::*;

/// The particles in an order in which neighbours in the list are neighbours in space.
///
/// A simulation lists them in any order. The cells and faces around a ball are some kilobytes, and a mesh of any size
/// is beyond the caches: in the order of the list every ball would wait for memory.
///
/// The order is Morton's curve through 1024³ boxes around all particles, equal boxes by number.
pub(crate) fn along_a_curve(positions: &[[f64; 3]]) -> Vec<usize> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in positions {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    // Boxes are cubes: a flat layer of particles is walked as a layer.
    let extent = (0..3).map(|k| high[k] - low[k]).fold(f64::MIN_POSITIVE, f64::max);
    let mut keyed: Vec<(u32, usize)> = positions
        .par_iter()
        .enumerate()
        .map(|(particle, p)| {
            let key = (0..3).fold(0, |key, k| key | spread_bits(((p[k] - low[k]) / extent * 1023.0) as u32) << k);
            (key, particle)
        })
        .collect();
    keyed.par_sort_unstable();
    keyed.into_iter().map(|(_, particle)| particle).collect()
}

/// The lowest ten bits, two zeros between each and the next.
fn spread_bits(x: u32) -> u32 {
    let x = x.min(1023);
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_visits_every_particle_once_also_in_a_plane_or_at_one_point() {
        for spread in [[1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [0.0; 3]] {
            let positions: Vec<[f64; 3]> =
                (0..1000).map(|i| [0, 1, 2].map(|k| spread[k] * f64::from(i * (2 * k as i32 + 7) % 101))).collect();
            let mut order = along_a_curve(&positions);
            order.sort_unstable();
            assert_eq!(order, (0..1000).collect::<Vec<_>>());
        }
        assert!(along_a_curve(&[]).is_empty());
    }
}
