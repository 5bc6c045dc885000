//! First and second moments against closed forms, polynomial integrals, Monte Carlo and each other.

#![allow(clippy::unwrap_used, clippy::needless_range_loop)]

use fieldstone_geometry::{Ball, Moments, PROMISE, Polyhedron, overlap_moments, overlap_volume};
use fieldstone_testing::Random;
use proptest::prelude::*;

fn tetrahedron() -> Polyhedron {
    Polyhedron::tetrahedron([[0.1, 0.0, 0.2], [1.0, 0.1, 0.0], [0.2, 1.1, 0.1], [0.3, 0.2, 0.9]]).unwrap()
}

fn sum(parts: &[Moments]) -> (f64, [f64; 3], [f64; 6]) {
    parts.iter().fold((0.0, [0.0; 3], [0.0; 6]), |(v, m, s), p| {
        (v + p.volume, [0, 1, 2].map(|k| m[k] + p.first[k]), [0, 1, 2, 3, 4, 5].map(|k| s[k] + p.second[k]))
    })
}

#[test]
fn a_cap_has_its_closed_form() {
    // ∫ over the cap z > a of the unit ball: M_z = π (1 − a²)² / 4, ∫ z² = π (2/15 − a³/3 + a⁵/5).
    for a in [-0.9_f64, -0.3, 0.0, 0.5, 0.97] {
        let half_space = Polyhedron::cuboid([-3.0, -3.0, a], [3.0; 3]).unwrap();
        let m = overlap_moments(&Ball::new([0.0; 3], 1.0).unwrap(), &half_space);
        let pi = std::f64::consts::PI;
        assert!((m.first[2] - pi * (1.0 - a * a).powi(2) / 4.0).abs() < 1e-15);
        assert!((m.second[5] - pi * (2.0 / 15.0 - a.powi(3) / 3.0 + a.powi(5) / 5.0)).abs() < 1e-15);
        assert!(m.first[0].abs() < 1e-16 && m.second[1].abs() < 1e-16);
    }
}

#[test]
fn an_element_inside_the_ball_has_its_own_polynomial_moments_for_balls_of_any_size() {
    // For a tetrahedron: ∫ x = V x̄, ∫ x_i x_j = V/20 (Σ_k v_ki v_kj + 16 x̄_i x̄_j).
    let tet = tetrahedron();
    let v: Vec<[f64; 3]> = tet.corners().collect();
    for (radius, limit) in [(3.0, 1e-12), (1e3, 1e-12), (1e6, 1e-12)] {
        let centre = [0.25, 0.5, 0.125];
        let m = overlap_moments(&Ball::new(centre, radius).unwrap(), &tet);
        let at: Vec<[f64; 3]> = v.iter().map(|p| [0, 1, 2].map(|k| p[k] - centre[k])).collect();
        let mean = [0, 1, 2].map(|k| at.iter().map(|p| p[k]).sum::<f64>() / 4.0);
        for i in 0..3 {
            assert!((m.first[i] - tet.volume() * mean[i]).abs() < limit * tet.volume(), "r {radius}: {m:?}");
        }
        for (k, (i, j)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
            let exact = tet.volume() / 20.0 * (at.iter().map(|p| p[i] * p[j]).sum::<f64>() + 16.0 * mean[i] * mean[j]);
            assert!((m.second[k] - exact).abs() < limit * tet.volume(), "r {radius}, {i}{j}");
        }
    }
}

#[test]
fn moments_agree_with_a_million_random_points() {
    let tet = tetrahedron();
    let corners: Vec<[f64; 3]> = tet.corners().collect();
    let ball = Ball::new([0.4, 0.3, 0.35], 0.4).unwrap();
    let m = overlap_moments(&ball, &tet);
    // Uniform points of the tetrahedron by sorted spacings.
    let mut random = Random(1);
    let n = 1_000_000;
    let (mut first, mut second) = ([0.0; 3], [0.0; 6]);
    for _ in 0..n {
        let mut u = [random.unit(), random.unit(), random.unit()];
        u.sort_by(f64::total_cmp);
        let weights = [u[0], u[1] - u[0], u[2] - u[1], 1.0 - u[2]];
        let x: [f64; 3] =
            std::array::from_fn(|k| (0..4).map(|c| weights[c] * corners[c][k]).sum::<f64>() - ball.centre()[k]);
        if x.iter().map(|c| c * c).sum::<f64>() <= 0.16 {
            for (k, (i, j)) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].into_iter().enumerate() {
                second[k] += x[i] * x[j];
            }
            (0..3).for_each(|k| first[k] += x[k]);
        }
    }
    let share = tet.volume() / f64::from(n);
    // Five standard deviations of a mean over a million points of magnitude 0.4 and 0.16.
    for k in 0..3 {
        assert!((first[k] * share - m.first[k]).abs() < 5e-3 * 0.4 * tet.volume());
    }
    for k in 0..6 {
        assert!((second[k] * share - m.second[k]).abs() < 5e-3 * 0.16 * tet.volume());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_parts_of_a_split_box_add_up(
        centre in prop::array::uniform3(-0.5f64..1.5),
        radius in 0.05f64..3.0,
        cut in 0.05f64..0.95,
        axis in 0usize..3,
    ) {
        let ball = Ball::new(centre, radius).unwrap();
        let (mut low, mut high) = ([0.0; 3], [1.0; 3]);
        low[axis] = cut;
        high[axis] = cut;
        let whole = overlap_moments(&ball, &Polyhedron::cuboid([0.0; 3], [1.0; 3]).unwrap());
        let parts = [
            overlap_moments(&ball, &Polyhedron::cuboid([0.0; 3], high).unwrap()),
            overlap_moments(&ball, &Polyhedron::cuboid(low, [1.0; 3]).unwrap()),
        ];
        let (v, m, s) = sum(&parts);
        // Three results, each within the promise of the smaller of the ball and the box.
        let far = centre.map(|x| x.abs().max((1.0 - x).abs())).iter().map(|x| x * x).sum::<f64>().sqrt();
        let (limit, reach) = (3.0 * PROMISE * ball.volume().min(1.0), radius.min(far));
        prop_assert!((v - whole.volume).abs() < limit);
        for k in 0..3 {
            prop_assert!((m[k] - whole.first[k]).abs() < limit * reach);
        }
        for k in 0..6 {
            prop_assert!((s[k] - whole.second[k]).abs() < limit * reach * reach);
        }
    }

    #[test]
    fn volumes_are_those_of_the_kernel_and_moments_obey_cauchy_and_schwarz(
        centre in prop::array::uniform3(-0.5f64..1.5),
        radius in 0.05f64..3.0,
    ) {
        let ball = Ball::new(centre, radius).unwrap();
        let tet = tetrahedron();
        let m = overlap_moments(&ball, &tet);
        prop_assert!((m.volume - overlap_volume(&ball, &tet)).abs() <= 2e-12 * tet.volume());
        for (k, diagonal) in [0, 3, 5].into_iter().enumerate() {
            prop_assert!(m.first[k].powi(2) <= m.volume * m.second[diagonal] * (1.0 + 1e-9) + 1e-20);
        }
    }
}
