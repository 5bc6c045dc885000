//! Faces between cells: what crosses them, and how much of a ball they cut.

use fieldstone_geometry::Ball;

use crate::Cells;

/// Cells with faces: what leaves one through a face enters the other.
///
/// Every face has a back and a front cell, one of which may be missing, and a normal from back to front.
pub trait Faces: Cells {
    /// Number of faces.
    fn face_count(&self) -> usize;

    /// The cells behind and in front of a face.
    fn face_sides(&self, face: usize) -> [Option<u32>; 2];

    /// Area times unit normal of a face.
    fn face_vector(&self, face: usize) -> [f64; 3];

    /// Calls `visit` with each face that the segment from `start` to `end` passes, and +1 where from back to front, −1 the other way.
    ///
    /// Of each cell the segment leaves as often as it enters, but for the cells that hold its ends: those are the ones
    /// that [`Cells::locate`] finds, unless an end lies on a face within rounding.
    fn for_each_crossing(&self, start: [f64; 3], end: [f64; 3], visit: &mut dyn FnMut(u32, f64));

    /// Calls `visit` with each face that cuts the ball, and the vector area of the part of it inside the ball.
    fn for_each_cut(&self, ball: &Ball, visit: &mut dyn FnMut(u32, [f64; 3]));
}
