//! The short cuts of the search for the largest cone against the plain search.

use fieldstone_testing::Random;

use super::*;

/// The cone that [`super::polish`] finds, with every axis held against all directions.
fn plain(start: DVec3, directions: &UnitDirections, near: &mut Vec<(f64, DVec3)>) -> (f64, DVec3) {
    let angle = |m: DVec3| directions.nearest(m).clamp(-1.0, 1.0).acos();
    let mut best = (angle(start), start);
    for _ in 0..6 {
        near.clear();
        for ((&x, &y), &z) in directions.x.iter().zip(&directions.y).zip(&directions.z) {
            let axis = DVec3::new(x, y, z);
            near.push((axis.dot(best.1), axis));
        }
        near.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        near.dedup_by(|a, b| (a.1 - b.1).length_squared() < 1e-20);
        near.truncate(TOUCHING);
        let mut improved = best;
        let mut offer = |m: DVec3| {
            if m == DVec3::ZERO {
                return;
            }
            for m in [m, -m] {
                let found = angle(m);
                if found > improved.0 {
                    improved = (found, m);
                }
            }
        };
        for (i, (_, a)) in near.iter().enumerate() {
            offer(*a);
            // Two opposite neighbours alone leave a ring of equal cones.
            offer(a.any_orthonormal_vector());
            for (j, (_, b)) in near.iter().enumerate().skip(i + 1) {
                offer((*a + *b).normalize_or_zero());
                for (_, c) in &near[j + 1..] {
                    offer((*b - *a).cross(*c - *a).normalize_or_zero());
                }
            }
        }
        if improved.0 <= best.0 + 1e-13 {
            break;
        }
        best = improved;
    }
    best
}

/// Unit directions, padded as those of a neighbourhood are.
fn padded(mut axes: Vec<DVec3>) -> UnitDirections {
    let first = axes[0];
    axes.resize(axes.len().next_multiple_of(8), first);
    let of = |component: fn(&DVec3) -> f64| axes.iter().map(component).collect();
    UnitDirections { x: of(|a| a.x), y: of(|a| a.y), z: of(|a| a.z) }
}

#[test]
fn cones_found_with_short_cuts_are_those_of_the_plain_search_to_the_bit() {
    let mut random = Random(11);
    let mut lattice = Vec::new();
    for k in 0..125 {
        let axis = DVec3::new(f64::from(k / 25 - 2), f64::from(k / 5 % 5 - 2), f64::from(k % 5 - 2));
        if axis != DVec3::ZERO {
            lattice.push(axis.normalize());
        }
    }
    let mut sets = vec![lattice, vec![DVec3::X], vec![DVec3::X, -DVec3::X], vec![DVec3::X, DVec3::Y, -DVec3::X]];
    for count in [2, 3, 5, 12, 33, 60] {
        sets.push((0..count).map(|_| DVec3::from_array(random.direction())).collect());
    }
    let (mut near, mut again) = (Vec::new(), 0);
    for axes in sets {
        let directions = padded(axes);
        let mut settled = Vec::new();
        for _ in 0..40 {
            let start = DVec3::from_array(random.direction());
            let found = polish(start, &directions, &mut near, &settled);
            assert_eq!(found, plain(start, &directions, &mut near), "{directions:?} from {start}");
            again += usize::from(settled.contains(&found));
            settled.push(found);
        }
    }
    // The short cut of starts that arrive where others were is in use.
    assert!(again > 100, "{again}");
}
