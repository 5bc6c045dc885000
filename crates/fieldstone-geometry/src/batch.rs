//! Volumes of many overlaps at once: many balls in one element, many elements in one ball, or any pairs.

use crate::inside::{InsideScratch, InsideVolume, inside_volume, inside_volumes};
use crate::overlap::volume_and_path;
use crate::{Ball, Polyhedron};

/// Balls up to this many are quicker one by one than in a register that they do not fill.
const A_FEW: usize = 2;

/// Computes volumes of overlaps in batches, the balls of an element a register at a time; keeps its memory between calls.
///
/// The results are those of [`crate::overlap_volume`], with the same promise and the same bits.
///
/// ```
/// use fieldstone_geometry::{Ball, OverlapBatch, Polyhedron, overlap_volume};
/// let cube = Polyhedron::cuboid([0.0; 3], [1.0; 3])?;
/// let balls = [0.1, 0.3, 0.6].map(|r| Ball::new([0.9, 0.8, 0.5], r));
/// let balls = balls.into_iter().collect::<Result<Vec<_>, _>>()?;
/// let mut volumes = [0.0; 3];
/// OverlapBatch::default().balls_in_element(&balls, &cube, &mut volumes);
/// for (ball, volume) in balls.iter().zip(volumes) {
///     assert_eq!(volume, overlap_volume(ball, &cube));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct OverlapBatch {
    /// Pairs by element.
    order: Vec<u32>,
    ends: Vec<u32>,
    /// Pairs that need another formula or more digits.
    left_over: Vec<usize>,
    scratch: InsideScratch,
    beyond_f64: u64,
    evaluated: u64,
}

impl OverlapBatch {
    /// Volume of each ball inside one element.
    ///
    /// # Panics
    /// Where `out` is shorter than `balls`.
    pub fn balls_in_element(&mut self, balls: &[Ball], element: &Polyhedron, out: &mut [f64]) {
        check_room(balls.len(), out);
        self.run(balls.len(), |k| (k, balls[k]), element, out);
        self.finish(|k| (&balls[k], element), out);
    }

    /// Volume of one ball inside each element.
    ///
    /// One by one, as [`crate::overlap_volume`] does: elements of different shapes do not share a register. For many balls
    /// in many elements [`OverlapBatch::pairs`] is quicker.
    ///
    /// # Panics
    /// Where `out` is shorter than `elements`.
    pub fn ball_in_elements(&mut self, ball: &Ball, elements: &[Polyhedron], out: &mut [f64]) {
        check_room(elements.len(), out);
        for (k, element) in elements.iter().enumerate() {
            self.run(1, |_| (k, *ball), element, out);
        }
        self.finish(|k| (ball, &elements[k]), out);
    }

    /// Volume of the ball inside the element for each pair of indices into the two lists.
    ///
    /// Pairs with the same element are evaluated together, wherever they stand in the list.
    ///
    /// # Panics
    /// Where an index is out of range, or `out` is shorter than `pairs`.
    pub fn pairs(&mut self, balls: &[Ball], elements: &[Polyhedron], pairs: &[(u32, u32)], out: &mut [f64]) {
        check_room(pairs.len(), out);
        let (order, ends) = self.by_element(elements.len(), pairs);
        let mut start = 0;
        for (element, &end) in elements.iter().zip(&ends) {
            let group = &order[start..end as usize];
            start = end as usize;
            let pair = |k: usize| (group[k] as usize, balls[pairs[group[k] as usize].0 as usize]);
            self.run(group.len(), pair, element, out);
        }
        (self.order, self.ends) = (order, ends);
        self.finish(|k| (&balls[pairs[k].0 as usize], &elements[pairs[k].1 as usize]), out);
    }

    /// Pairs evaluated so far, not counting those clearly apart or covered, and how many of them needed more digits than
    /// `f64` has.
    pub fn path_counts(&self) -> (u64, u64) {
        (self.evaluated, self.beyond_f64)
    }

    /// Pairs sorted by element, by counting, and the end of each element's pairs.
    fn by_element(&mut self, elements: usize, pairs: &[(u32, u32)]) -> (Vec<u32>, Vec<u32>) {
        let (mut order, mut ends) = (std::mem::take(&mut self.order), std::mem::take(&mut self.ends));
        ends.clear();
        ends.resize(elements, 0);
        for &(_, element) in pairs {
            ends[element as usize] += 1;
        }
        let mut sum = 0;
        for end in &mut ends {
            // First the start of the group, which becomes its end as the group fills.
            (*end, sum) = (sum, sum + *end);
        }
        order.resize(pairs.len(), 0);
        for (k, &(_, element)) in pairs.iter().enumerate() {
            let at = &mut ends[element as usize];
            order[*at as usize] = k as u32;
            *at += 1;
        }
        (order, ends)
    }

    /// The volumes of `count` balls in an element; `ball` says where each result goes.
    fn run(&mut self, count: usize, ball: impl Fn(usize) -> (usize, Ball), element: &Polyhedron, out: &mut [f64]) {
        let Some(frames) = element.frames() else {
            self.left_over.extend((0..count).map(|k| ball(k).0));
            return;
        };
        let Self { left_over, evaluated, scratch, .. } = self;
        let mut take = |k: usize, found: InsideVolume| {
            let at = ball(k).0;
            if found.promised {
                *evaluated += u64::from(found.evaluated);
                out[at] = found.volume;
            } else {
                left_over.push(at);
            }
        };
        if count <= A_FEW {
            (0..count).for_each(|k| take(k, inside_volume(&ball(k).1, element, frames)));
        } else {
            inside_volumes(count, |k| ball(k).1, element, frames, scratch, take);
        }
    }

    /// What the quick way has left over, one by one.
    fn finish<'a>(&mut self, pair: impl Fn(usize) -> (&'a Ball, &'a Polyhedron), out: &mut [f64]) {
        for k in self.left_over.drain(..) {
            let (ball, element) = pair(k);
            let (volume, beyond_f64) = volume_and_path(ball, element);
            out[k] = volume;
            self.evaluated += 1;
            self.beyond_f64 += u64::from(beyond_f64);
        }
    }
}

fn check_room(count: usize, out: &[f64]) {
    assert!(out.len() >= count, "{count} results do not fit into {} places", out.len());
}
