//! Values on the lattice that the paper and the literature give.
#![allow(clippy::unwrap_used)]

mod common;

use common::{block, labels};
use fieldstone_surface::{Depth, DivergenceThresholds, Kernel, Marrone, Smoothing, lattice_divergence};

const WENDLAND: Smoothing = Smoothing { kernel: Kernel::WendlandC2, length: 2.0 };
const GAUSSIAN: Smoothing = Smoothing { kernel: Kernel::ImprovedGaussian, length: 1.5 };

#[test]
fn the_position_divergence_has_the_values_of_fig_6_with_both_kernels() {
    let layer = |smoothing: &Smoothing, n| lattice_divergence(smoothing, &Depth::plane(n), 3);
    // The paper prints 1.874 and 2.571; the other digits are this program's, from a finite sum.
    assert!((layer(&WENDLAND, 1) - 1.8738).abs() < 5e-5, "{}", layer(&WENDLAND, 1));
    assert!((layer(&WENDLAND, 2) - 2.5710).abs() < 5e-5, "{}", layer(&WENDLAND, 2));
    assert!((layer(&WENDLAND, 3) - 2.946).abs() < 5e-4, "{}", layer(&WENDLAND, 3));
    for (n, expected) in [(1, 1.874), (2, 2.571), (3, 2.923)] {
        assert!((layer(&GAUSSIAN, n) - expected).abs() < 5e-4, "{n}: {}", layer(&GAUSSIAN, n));
    }
    let bulk = lattice_divergence(&GAUSSIAN, &Depth { layers: [None; 3] }, 3);
    assert!((bulk - 2.995).abs() < 5e-4, "{bulk}");
}

#[test]
fn derived_thresholds_are_the_papers_for_its_kernels() {
    for smoothing in [WENDLAND, GAUSSIAN] {
        let derived = DivergenceThresholds::from_lattice(&smoothing, 3);
        assert!((derived.free - 1.8).abs() < 1e-3 && (derived.inner - 2.8).abs() < 1e-3, "{derived:?}");
    }
}

#[test]
fn the_papers_thresholds_leave_the_corner_a_small_margin() {
    let [corner, third] = DivergenceThresholds::PAPER.margins(&WENDLAND, 3);
    assert!((corner - 0.028).abs() < 5e-4, "{corner}");
    assert!((third - 0.146).abs() < 5e-4, "{third}");
}

#[test]
fn derived_thresholds_separate_the_layers_for_any_smoothing_length_and_dimension() {
    for kernel in [Kernel::WendlandC2, Kernel::ImprovedGaussian] {
        for dimension in [2, 3] {
            for tenths in 12..=22 {
                let smoothing = Smoothing { kernel, length: 0.1 * f64::from(tenths) };
                let layer = |n| lattice_divergence(&smoothing, &Depth::plane(n), dimension);
                let thresholds = DivergenceThresholds::from_lattice(&smoothing, dimension);
                assert!(thresholds.free < layer(1) && thresholds.inner < layer(3), "{smoothing:?} {thresholds:?}");
                assert!(thresholds.inner > layer(2), "{smoothing:?} {thresholds:?}");
            }
        }
    }
}

#[test]
fn the_smallest_eigenvalue_has_the_lattice_values_that_marrones_thresholds_are_for() {
    let positions = block([15; 3], 0.0, 1);
    let at = |x: usize, y: usize, z: usize| x + 15 * (y + 15 * z);
    // With both thresholds at one value the umbrella has no say: free is what is below it.
    let below = |threshold, particle: usize| {
        let method = Marrone { free: threshold, inner: threshold, ..Marrone::default() };
        labels(&positions, &method, 1.0, 3)[particle]
    };
    for (name, particle, value) in [
        ("surface", at(7, 7, 0), 0.500),
        ("second layer", at(7, 7, 1), 0.773),
        ("third layer", at(7, 7, 2), 0.973),
        ("edge", at(7, 0, 0), 0.227),
        ("corner", at(0, 0, 0), 0.162),
    ] {
        // These are of a kernel that integrates to one; the printed constant makes them 0.17 % less.
        let value = value / 1.0017;
        assert!(below(value + 5e-4, particle) && !below(value - 5e-4, particle), "{name}: not {value}");
    }
}
