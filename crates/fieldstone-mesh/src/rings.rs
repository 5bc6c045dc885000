//! Rings of corners.

/// The loops that a ring falls into where it comes back to a corner, without those of less than three corners.
///
/// Taken together they run through the same edges as the ring, but for edges that it runs through in both directions: what
/// was closed stays closed. A ring without repetition is its only loop.
///
/// ```text
/// 0 1 1 2   →  0 1 2
/// 0 1 0 2   →  nothing
/// 0 1 2 0 3 4  →  0 1 2, 0 3 4
/// ```
pub(crate) fn simple_loops<T: Copy + PartialEq>(ring: &[T]) -> Vec<Vec<T>> {
    let mut loops = Vec::with_capacity(1);
    let mut path: Vec<T> = Vec::with_capacity(ring.len());
    for &corner in ring {
        if let Some(at) = path.iter().position(|&other| other == corner) {
            loops.push(path.split_off(at));
        }
        path.push(corner);
    }
    loops.push(path);
    loops.retain(|corners| corners.len() >= 3);
    loops
}

/// Whether two rings run through the same corners in the same order.
pub(crate) fn is_rotation(a: &[u32], b: &[u32]) -> bool {
    a.len() == b.len() && (0..a.len()).any(|shift| (0..a.len()).all(|k| a[(k + shift) % a.len()] == b[k]))
}

#[cfg(test)]
mod tests {
    use super::simple_loops;

    #[test]
    fn rings_fall_into_loops_where_they_come_back_to_a_corner() {
        assert_eq!(simple_loops(&[0, 1, 2, 3]), [[0, 1, 2, 3]]);
        assert_eq!(simple_loops(&[0, 1, 1, 2]), [[0, 1, 2]]);
        assert_eq!(simple_loops(&[0, 1, 2, 0]), [[0, 1, 2]]);
        assert_eq!(simple_loops(&[0, 1, 2, 0, 3, 4]), [[0, 1, 2], [0, 3, 4]]);
        assert_eq!(simple_loops(&[5, 0, 1, 2, 0]), [[0, 1, 2]]);
        for flat in [&[0, 1, 0, 2][..], &[0, 0, 3, 3], &[7, 7, 7, 7]] {
            assert!(simple_loops(flat).is_empty(), "{flat:?}");
        }
    }
}
