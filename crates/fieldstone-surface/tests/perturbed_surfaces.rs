//! Two-dimensional surfaces with periodic perturbations: which method sees the troughs.
#![allow(clippy::unwrap_used)]

mod common;

use common::labels;
use fieldstone_surface::{
    Dilts, Exact, Geometrical, InnerParticles, Marrone, PerturbedSurface, SemiGeometrical, Sun, SurfaceDetection, Wang,
};

fn surface(degrees: f64, inner: InnerParticles) -> PerturbedSurface {
    PerturbedSurface::new(degrees.to_radians(), 3, inner).unwrap()
}

fn sees_trough(method: &dyn SurfaceDetection, surface: &PerturbedSurface) -> bool {
    labels(&surface.positions, method, 1.0, 2)[surface.trough]
}

#[test]
fn dilts_sees_175_degrees_only_and_sun_130_too_as_in_fig_7() {
    for (degrees, dilts, sun) in [(175.0, true, true), (130.0, false, true), (85.0, false, false)] {
        let surface = surface(degrees, InnerParticles::Uniform);
        assert_eq!(sees_trough(&Dilts::default(), &surface), dilts, "Dilts at {degrees}°");
        assert_eq!(sees_trough(&Sun::default(), &surface), sun, "Sun at {degrees}°");
    }
}

#[test]
fn the_smallest_angle_that_dilts_sees_is_that_of_eq_31() {
    for radius in [1.0, 1.25, 1.5] {
        let method = Dilts { radius };
        let limit = method.smallest_visible_angle().to_degrees();
        for (degrees, seen) in [(limit - 0.1, false), (limit + 0.1, true)] {
            assert_eq!(sees_trough(&method, &surface(degrees, InnerParticles::Uniform)), seen, "{radius}, {degrees}°");
        }
    }
}

#[test]
fn the_smallest_angle_that_sun_sees_is_its_sector_and_a_right_angle_is_a_tie() {
    for (degrees, seen) in [(89.99, false), (90.0, false), (90.01, true)] {
        for method in [&Sun::default() as &dyn SurfaceDetection, &Exact::default(), &Geometrical::default()] {
            assert_eq!(sees_trough(method, &surface(degrees, InnerParticles::Uniform)), seen, "{degrees}°");
        }
    }
}

#[test]
fn normals_mislead_marrone_and_wang_where_inner_particles_are_lost_or_aggregated_as_in_fig_8() {
    for (inner, by_normal) in
        [(InnerParticles::Uniform, true), (InnerParticles::Lost, false), (InnerParticles::Aggregated, false)]
    {
        let surface = surface(100.0, inner);
        assert!(sees_trough(&Sun::default(), &surface), "Sun, {inner:?}");
        assert_eq!(sees_trough(&Marrone::default(), &surface), by_normal, "Marrone, {inner:?}");
        assert_eq!(sees_trough(&Wang::default(), &surface), by_normal, "Wang, {inner:?}");
    }
}

#[test]
fn the_chain_and_nothing_below_it_is_the_surface() {
    for degrees in [175.0, 130.0, 100.0] {
        let surface = surface(degrees, InnerParticles::Uniform);
        let sun = labels(&surface.positions, &Sun::default(), 1.0, 2);
        let central = |i: &usize| {
            let p = surface.positions[*i];
            p[0].abs() < 5.0 && p[1] > -6.0
        };
        for i in (0..sun.len()).filter(central) {
            assert_eq!(sun[i], i < surface.surface, "{degrees}°: {:?}", surface.positions[i]);
        }
        let semi = labels(&surface.positions, &SemiGeometrical::default(), 1.0, 2);
        let differing = (0..sun.len()).filter(central).filter(|&i| sun[i] != semi[i]).count();
        assert!(differing <= 2, "{degrees}°: {differing}");
    }
}
