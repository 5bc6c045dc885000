//! Fills and bodies that do not fit the mirror walls beside them.

use super::Prepared;
use crate::{Shape, SphError};

/// How far the outermost layer of a fill may be from half a cell off a wall, over the cell.
const OFF: f64 = 0.05;

/// A box of fluid that does not end at the wall beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FillBesideWall {
    /// Number of the fill, from 0.
    pub fill: usize,
    /// Number of the `[[wall]]`, from 0.
    pub wall: usize,
    /// Its normal, into the fluid.
    pub normal: [f64; 3],
    /// Distance of the fill's outermost layer of particles from the wall.
    pub distance: f64,
    /// What it is where a fill ends at the wall: half a cell of its lattice.
    pub half_cell: f64,
}

/// A body that stands on a wall, or ends close behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyAtWall {
    /// Number of the body, from 0.
    pub body: usize,
    /// Number of the `[[wall]]`, from 0.
    pub wall: usize,
    /// Its normal, into the fluid.
    pub normal: [f64; 3],
    /// How far the body reaches beyond the wall at the start; below 0 where it does not.
    pub beyond: f64,
    /// How far it must: the kernel's reach, 2h.
    pub needed: f64,
}

impl Prepared<'_> {
    /// Boxes of fluid whose outermost layer is not half a cell from a wall beside them, by more than a twentieth of the cell.
    ///
    /// Their particles begin too close to their images behind the wall, or too far from them, and burst off or fall against it. A gap
    /// of a cell or more is one that is meant. Walls along no axis cut boxes in steps and do not count.
    ///
    /// # Errors
    /// As [`Case::flow`](crate::Case::flow).
    ///
    /// ```
    /// # use fieldstone_sph::Case;
    /// let filled = |low: f64, high: f64| {
    ///     Case::parse(
    ///         &format!(
    ///             "dimension = 2\nspacing = 0.05\n[domain]\nlow = [0, 0]\nhigh = [1, 1]\n[fluid]\ndensity = 1000\nexpected_speed = 2\n\
    ///              [time]\nend = 1\n[[fill]]\nshape = \"box\"\nlow = [{low}, 0]\nhigh = [{high}, 0.5]\n[[wall]]\nkind = \"tank\"\n"
    ///         ),
    ///         "tank.toml",
    ///     )
    /// };
    /// assert_eq!(filled(0.0, 1.0)?.prepare()?.fills_off_walls()?, []);
    /// let off = filled(0.0, 1.02)?.prepare()?.fills_off_walls()?;
    /// assert!(off.len() == 1 && off[0].normal == [-1.0, 0.0, 0.0] && (off[0].distance - 0.0055).abs() < 1e-9);
    /// # Ok::<(), fieldstone_sph::SphError>(())
    /// ```
    pub fn fills_off_walls(&self) -> Result<Vec<FillBesideWall>, SphError> {
        let s = &self.case.sections;
        let mut found = Vec::new();
        for (fill, section) in s.fill.iter().enumerate() {
            let shape = self.case.shape("fill", fill, &section.keys())?;
            if !matches!(shape, Shape::Box { .. }) {
                continue;
            }
            let (_, cell) = shape.cells(s.spacing, s.dimension);
            let (points, _) = shape.lattice(s.spacing, s.dimension);
            for (index, wall) in self.flow.boundaries.walls.iter().enumerate() {
                let normal = wall.plane.normal();
                let Some(axis) = (0..s.dimension).find(|&k| normal[k].abs() > 1.0 - 1e-9) else { continue };
                // What lies behind the wall is not filled.
                let inside = points.iter().map(|&x| wall.plane.distance(x)).filter(|&distance| distance >= 0.0);
                let distance = inside.fold(f64::INFINITY, f64::min);
                let (cell, half_cell) = (cell[axis], 0.5 * cell[axis]);
                if (distance - half_cell).abs() > OFF * cell && distance < (1.5 - 1e-6) * cell {
                    let wall = self.case.section_of_wall(index);
                    found.push(FillBesideWall { fill, wall, normal, distance, half_cell });
                }
            }
        }
        Ok(found)
    }

    /// Bodies that stand on a mirror wall at the start without reaching 2h beyond it.
    ///
    /// Bodies are not mirrored: beside the foot of such a one the fluid finds none of its ghosts behind the wall, and gets through
    /// between both. A body that ends half a spacing or more before the wall leaves a gap that is meant.
    ///
    /// ```
    /// # use fieldstone_sph::Case;
    /// let standing = |foot: f64| {
    ///     Case::parse(
    ///         &format!(
    ///             "dimension = 2\nspacing = 0.02\n[domain]\nlow = [-0.2, 0]\nhigh = [1, 1]\n[fluid]\ndensity = 1000\nexpected_speed = 2\n\
    ///              [time]\nend = 1\n[[fill]]\nshape = \"box\"\nlow = [0, 0]\nhigh = [1, 0.24]\n[[wall]]\nkind = \"tank\"\n\
    ///              [[body]]\nshape = \"box\"\nlow = [-0.1, {foot}]\nhigh = [0, 0.5]\n"
    ///         ),
    ///         "piston.toml",
    ///     )
    /// };
    /// let at_walls = standing(0.0)?.prepare()?.bodies_at_walls();
    /// assert!(at_walls.len() == 1 && at_walls[0].normal == [0.0, 1.0, 0.0] && at_walls[0].beyond == 0.0);
    /// assert_eq!(standing(-0.1)?.prepare()?.bodies_at_walls(), []);
    /// # Ok::<(), fieldstone_sph::SphError>(())
    /// ```
    pub fn bodies_at_walls(&self) -> Vec<BodyAtWall> {
        let crate::Flow { fluid, boundaries, .. } = &self.flow;
        let needed = fluid.kernel().reach();
        let mut found = Vec::new();
        for (body, solid) in boundaries.bodies.iter().enumerate() {
            let ((low, high), moved) = (solid.shape.bounds(), solid.pose(0.0).displacement);
            for (index, wall) in boundaries.walls.iter().enumerate() {
                let (normal, offset) = (wall.plane.normal(), wall.plane.offset());
                let ends = |k: usize| [low[k], high[k]].map(|x| normal[k] * (x + moved[k]));
                let [nearest, farthest] = [f64::min as fn(f64, f64) -> f64, f64::max]
                    .map(|pick| (0..fluid.dimension).map(&ends).map(|[a, b]| pick(a, b)).sum::<f64>() - offset);
                if nearest < 0.5 * fluid.spacing && nearest > -needed * (1.0 - 1e-9) && farthest > 0.0 {
                    // Not −0, which messages would show.
                    let beyond = 0.0 - nearest;
                    found.push(BodyAtWall { body, wall: self.case.section_of_wall(index), normal, beyond, needed });
                }
            }
        }
        found
    }
}
