//! The ball as a cube of equal volume.

use fieldstone_geometry::Ball;
use fieldstone_mesh::Cells;

/// Source: `strobl2016`, Sec. 2, after `tomiyama1997`.
pub(super) fn bin<C: Cells>(cells: &C, ball: &Ball, scratch: &mut C::Scratch, out: &mut Vec<(u32, f64)>) {
    let half = 0.5 * ball.volume().cbrt();
    let centre = ball.centre();
    cells.overlap_cuboid(centre.map(|x| x - half), centre.map(|x| x + half), scratch, out);
}
