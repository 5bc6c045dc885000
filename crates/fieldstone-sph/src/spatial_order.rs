//! An order of points in which neighbours in space are neighbours in memory.

use crate::cluster::LANES;

/// Points that are ordered by one task.
const TASK: usize = 8192;

/// Order of points, `order[new] = old`, in which every [`LANES`] consecutive ones fill a small box.
///
/// The points are halved across the longest edge of the box around them, again and again, always at a multiple of
/// [`LANES`]. Equal coordinates keep their order, so the result is the same for any number of threads.
pub(crate) fn spatial_order(x: &[[f64; 3]]) -> Vec<u32> {
    let mut points: Vec<([f64; 3], u32)> = x.iter().zip(0..).map(|(&x, i)| (x, i)).collect();
    halve(&mut points);
    points.into_iter().map(|(_, i)| i).collect()
}

fn halve(points: &mut [([f64; 3], u32)]) {
    if points.len() <= LANES {
        return;
    }
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (x, _) in points.iter() {
        for k in 0..3 {
            low[k] = low[k].min(x[k]);
            high[k] = high[k].max(x[k]);
        }
    }
    let mut axis = 0;
    for k in 1..3 {
        // Edges that differ by rounding are equal: the lattice decides, not its last digits.
        if high[k] - low[k] > (high[axis] - low[axis]) * (1.0 + 1e-6) {
            axis = k;
        }
    }
    let middle = (points.len() / 2).next_multiple_of(LANES);
    if middle < points.len() {
        points.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    }
    let (left, right) = points.split_at_mut(middle.min(points.len()));
    if left.len() > TASK {
        rayon::join(|| halve(left), || halve(right));
    } else {
        halve(left);
        halve(right);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fieldstone_testing::Random;
    use glam::DVec3;

    #[test]
    fn every_eight_of_a_shuffled_lattice_fill_a_cube_of_two() {
        let mut x: Vec<[f64; 3]> = (0..4096u32).map(|i| [i % 16, i / 16 % 16, i / 256].map(f64::from)).collect();
        let mut random = Random(77);
        x.sort_by_cached_key(|_| random.bits());
        let order = spatial_order(&x);
        let mut seen = order.clone();
        seen.sort_unstable();
        assert!(seen.iter().copied().eq(0..4096));
        for eight in order.chunks(LANES) {
            let corners = |pick: fn(DVec3, DVec3) -> DVec3| {
                eight.iter().map(|&i| DVec3::from_array(x[i as usize])).reduce(pick).unwrap()
            };
            assert_eq!(corners(DVec3::max) - corners(DVec3::min), DVec3::ONE);
        }
    }

    #[test]
    fn points_at_one_place_and_few_points_keep_their_order_or_at_least_their_number() {
        assert_eq!(spatial_order(&[[0.0; 3]; 5]), [0, 1, 2, 3, 4]);
        let mut order = spatial_order(&[[1.0; 3]; 100]);
        order.sort_unstable();
        assert!(order.into_iter().eq(0..100));
    }
}
