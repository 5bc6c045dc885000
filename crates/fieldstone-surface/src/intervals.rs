//! Arcs on a circle: is there a gap?

use std::f64::consts::TAU;

/// Middle of a gap that the arcs leave on the circle, as an angle in [0, 2π); `None` where they cover it.
///
/// An arc is a pair (start, end) with start ≤ end, of any multiple of 2π; arcs are closed, so touching ones leave no
/// gap. Sorts the arcs.
pub(crate) fn gap_on_circle(arcs: &mut [(f64, f64)]) -> Option<f64> {
    let mut covered_to = 0.0f64;
    for arc in arcs.iter_mut() {
        let turns = (arc.0 / TAU).floor();
        if arc.1 - arc.0 >= TAU {
            return None;
        }
        arc.0 -= turns * TAU;
        arc.1 -= turns * TAU;
        // What runs past a full turn covers the circle's beginning.
        covered_to = covered_to.max(arc.1 - TAU);
    }
    arcs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    for &(start, end) in arcs.iter() {
        if start > covered_to {
            return Some(0.5 * (start + covered_to));
        }
        covered_to = covered_to.max(end);
        if covered_to >= TAU {
            return None;
        }
    }
    Some(0.5 * (covered_to + TAU))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn touching_arcs_leave_no_gap_and_a_missing_piece_is_found_across_zero() {
        assert_eq!(gap_on_circle(&mut []), Some(0.5 * TAU));
        assert_eq!(gap_on_circle(&mut [(0.0, 3.0), (3.0, 5.0), (5.0, TAU)]), None);
        assert_eq!(gap_on_circle(&mut [(-3.0, 1.0), (1.0, TAU - 3.0)]), None);
        let gap = gap_on_circle(&mut [(0.5, TAU - 0.5)]).unwrap();
        assert!((gap - 0.25).abs() < 1e-15, "{gap}");
        let gap = gap_on_circle(&mut [(-1.0, 1.0), (TAU + 1.5, TAU + 4.0)]).unwrap();
        assert!((gap - 1.25).abs() < 1e-15, "{gap}");
        assert_eq!(gap_on_circle(&mut [(2.0, 2.0 + TAU)]), None);
    }
}
