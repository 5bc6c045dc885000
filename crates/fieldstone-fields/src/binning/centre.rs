//! All of the ball where its centre is, with or without averaging over neighbours.

use fieldstone_geometry::Ball;
use fieldstone_mesh::Cells;

pub(super) fn bin<C: Cells>(cells: &C, ball: &Ball, scratch: &mut C::Scratch, out: &mut Vec<(u32, f64)>) {
    if let Some(cell) = cells.locate(ball.centre(), scratch) {
        out.push((cell, ball.volume()));
    }
}

/// Each cell's solid fraction becomes the mean of its own and its face neighbours'.
///
/// Volume is not conserved where cells differ in size or lie at the boundary: that is the scheme's.
///
/// Source: `strobl2016`, Sec. 2, after `lim2006`.
pub(super) fn bin_smoothed<C: Cells>(cells: &C, ball: &Ball, scratch: &mut C::Scratch, out: &mut Vec<(u32, f64)>) {
    let Some(home) = cells.locate(ball.centre(), scratch) else { return };
    let fraction = ball.volume() / cells.cell_volume(home as usize);
    let mut give = |cell: u32| {
        let mut members = 1.0;
        cells.for_each_neighbour(cell as usize, &mut |_, _| members += 1.0);
        out.push((cell, fraction / members * cells.cell_volume(cell as usize)));
    };
    give(home);
    cells.for_each_neighbour(home as usize, &mut |cell, _| give(cell));
}
