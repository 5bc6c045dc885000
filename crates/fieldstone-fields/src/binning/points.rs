//! The ball as points of equal volume.

use fieldstone_geometry::Ball;
use fieldstone_mesh::Cells;

use crate::periodic::Image;

/// Each point is looked up for itself: one on a periodic face belongs to one of the ball's images.
pub(super) fn bin<C: Cells>(
    cells: &C,
    ball: &Ball,
    image: &Image<'_>,
    points: &[[f64; 3]],
    scratch: &mut C::Scratch,
    out: &mut Vec<(u32, f64)>,
) {
    let r = ball.radius();
    let share = ball.volume() / points.len() as f64;
    for point in points {
        let at = image.of(std::array::from_fn(|k| image.original[k] + r * point[k]));
        if let Some(cell) = at.and_then(|at| cells.locate(at, scratch)) {
            out.push((cell, share));
        }
    }
}

/// The centre and two shells of 14 points, along the axes and the diagonals of a cube.
///
/// Each point stands for 1/29 of the volume and lies at the mean radius of its shell,
/// $\tfrac34 (b^4 - a^4) / (b^3 - a^3)$ between $a$ and $b$.
pub(super) fn satellites() -> Vec<[f64; 3]> {
    let mut points = vec![[0.0; 3]];
    for shell in 0..2 {
        let [a, b] = [shell, shell + 1].map(|s| (f64::from(1 + 14 * s) / 29.0).cbrt());
        let radius = 0.75 * (b.powi(4) - a.powi(4)) / (b.powi(3) - a.powi(3));
        for sign in [-1.0, 1.0] {
            points.extend([[sign, 0.0, 0.0], [0.0, sign, 0.0], [0.0, 0.0, sign]].map(|p| p.map(|x| x * radius)));
        }
        let diagonal = radius / 3f64.sqrt();
        for corner in 0..8 {
            points.push(std::array::from_fn(|k| if corner >> k & 1 == 0 { diagonal } else { -diagonal }));
        }
    }
    points
}

/// Centres of the cells of a cubic grid around the ball that lie in it: the grid whose count comes closest to `n`.
pub(super) fn regular(n: u32) -> Vec<[f64; 3]> {
    let guess = (f64::from(n) * 6.0 / std::f64::consts::PI).cbrt().round().max(1.0) as u32;
    (guess.saturating_sub(1).max(1)..=guess + 1)
        .map(regular_grid)
        .min_by_key(|points| points.len().abs_diff(n as usize))
        .unwrap_or_default()
}

fn regular_grid(side: u32) -> Vec<[f64; 3]> {
    let at = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(side) - 1.0;
    let mut points = Vec::new();
    for k in 0..side {
        for j in 0..side {
            for i in 0..side {
                let p = [at(i), at(j), at(k)];
                if p.iter().map(|x| x * x).sum::<f64>() <= 1.0 {
                    points.push(p);
                }
            }
        }
    }
    points
}

/// `n` points, uniform in the unit ball, the same ones for the same seed.
pub(super) fn random(n: u32, seed: u64) -> Vec<[f64; 3]> {
    // SplitMix64, started at a scrambled seed: started at the seeds themselves, streams would be shifts of each other.
    let scramble = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let mut state = scramble(seed.wrapping_add(0x632b_e59b_d9b4_e019));
    let mut uniform = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (scramble(state) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut points = Vec::with_capacity(n as usize);
    while points.len() < n as usize {
        let p = [uniform(), uniform(), uniform()];
        if p.iter().map(|x| x * x).sum::<f64>() <= 1.0 {
            points.push(p);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn satellites_lie_on_shells_of_equal_volume() {
        let points = satellites();
        assert_eq!(points.len(), 29);
        let radius = |p: &[f64; 3]| p.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(points[1..15].iter().all(|p| (radius(p) - 0.62761).abs() < 1e-5));
        assert!(points[15..].iter().all(|p| (radius(p) - 0.90853).abs() < 1e-5));
    }

    #[test]
    fn regular_points_come_close_to_the_number_asked_for() {
        // Cubic grids of 1³, 2³, 3³, 5³, 12³ and 58³ cells around the ball.
        for (n, found) in [(1, 1), (8, 8), (20, 19), (100, 81), (1000, 912), (100_000, 102_208)] {
            assert_eq!(regular(n).len(), found, "for {n}");
        }
    }

    #[test]
    fn random_points_fill_the_ball_evenly_and_repeat() {
        let points = random(100_000, 3);
        assert_eq!(points, random(100_000, 3));
        // No two particles get clouds that share points.
        for seed in 4..20 {
            assert!(random(100, seed).iter().all(|p| !points[..1000].contains(p)), "seed {seed}");
        }
        let inner = points.iter().filter(|p| p.iter().map(|x| x * x).sum::<f64>() < 0.25).count();
        // One eighth of the volume, ± 5 standard deviations.
        assert!((inner as f64 - 12_500.0).abs() < 5.0 * 105.0, "{inner}");
    }
}
