//! Values on the lattice that the paper and the literature give.
#![allow(clippy::unwrap_used)]

use fieldstone_surface::{Depth, DivergenceThresholds, Kernel, Smoothing, lattice_divergence};

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
