//! The mesh as a set of cells.

use fieldstone_geometry::Ball;
use glam::DVec3;

use crate::{Cells, Mesh, MeshScratch};

impl Cells for Mesh {
    type Scratch = MeshScratch;

    fn scratch(&self) -> MeshScratch {
        MeshScratch::new(self)
    }

    fn cell_count(&self) -> usize {
        self.cell_volumes().len()
    }

    fn cell_volume(&self, cell: usize) -> f64 {
        self.cell_volumes()[cell]
    }

    fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let [low, high] = self
            .bounds
            .iter()
            .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[a, b], [low, high]| [a.min(*low), b.max(*high)]);
        (low.to_array(), high.to_array())
    }

    fn overlap_ball(&self, ball: &Ball, scratch: &mut MeshScratch, out: &mut Vec<(u32, f64)>) {
        self.overlap_ball_volumes(ball, scratch, out);
    }

    fn overlap_cuboid(&self, low: [f64; 3], high: [f64; 3], scratch: &mut MeshScratch, out: &mut Vec<(u32, f64)>) {
        self.overlap_cuboid_volumes(DVec3::from(low), DVec3::from(high), scratch, out);
    }

    fn locate(&self, point: [f64; 3], scratch: &mut MeshScratch) -> Option<u32> {
        self.locate_point(DVec3::from(point), &mut scratch.ring)
    }

    fn for_each_neighbour(&self, cell: usize, visit: &mut dyn FnMut(u32)) {
        let parts = self.parts();
        for &face in self.cell_faces(cell) {
            if let Some(&neighbour) = parts.neighbour.get(face as usize) {
                let owner = parts.owner[face as usize];
                visit(if owner as usize == cell { neighbour } else { owner });
            }
        }
    }
}
