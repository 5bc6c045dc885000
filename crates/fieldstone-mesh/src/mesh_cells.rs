//! The mesh as a set of cells.

use fieldstone_geometry::{Ball, ElementKind};
use glam::DVec3;

use crate::cells::ElementSink;
use crate::{Cells, Mesh, MeshScratch, PathCounts};

impl Cells for Mesh {
    type Scratch = MeshScratch;

    fn scratch(&self) -> MeshScratch {
        MeshScratch::new(self)
    }

    fn fast_scratch(&self) -> MeshScratch {
        MeshScratch::new(self).in_f64_alone()
    }

    fn path_counts(&self, scratch: &MeshScratch) -> PathCounts {
        scratch.counts
    }

    fn cell_count(&self) -> usize {
        self.cell_volumes().len()
    }

    fn cell_volume(&self, cell: usize) -> f64 {
        self.cell_volumes()[cell]
    }

    fn cell_centre(&self, cell: usize) -> [f64; 3] {
        self.centres[cell].to_array()
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

    fn for_each_neighbour(&self, cell: usize, visit: &mut dyn FnMut(u32, f64)) {
        let parts = self.parts();
        // Neighbour, place among the faces, area: a face that one side splits, or a cell that bends, meets the same cell again.
        let mut met: Vec<(u32, usize, f64)> = Vec::new();
        for (place, &face) in self.cell_faces(cell).iter().enumerate() {
            if let Some(&neighbour) = parts.neighbour.get(face as usize) {
                let owner = parts.owner[face as usize];
                let other = if owner as usize == cell { neighbour } else { owner };
                met.push((other, place, self.surface.area_vectors[face as usize].length()));
            }
        }
        met.sort_unstable_by_key(|&(other, place, _)| (other, place));
        met.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            kept.2 += if same { next.2 } else { 0.0 };
            same
        });
        // In the order of the faces, which is that of the mesh and not of the cells' numbers.
        met.sort_unstable_by_key(|&(_, place, _)| place);
        for (other, _, area) in met {
            let distance = (self.centres[cell] - self.centres[other as usize]).length();
            // Centres that coincide are no neighbours that anything could flow between.
            if distance != 0.0 {
                visit(other, area / distance);
            }
        }
    }

    fn for_each_candidate(&self, low: [f64; 3], high: [f64; 3], visit: &mut dyn FnMut(u32)) {
        self.tree.query(&self.bounds, DVec3::from(low), DVec3::from(high), visit);
    }

    fn for_each_element(&self, cell: usize, visit: &mut ElementSink<'_>) {
        let planar = self.cell_faces(cell).iter().all(|&face| self.surface.pieces(face as usize).len() == 1);
        let kind = self.cell_kind(cell);
        let upright = self.orientation(cell) > 0.0;
        if let Some(corners) = self.cell_corners(cell)
            && planar
            && upright
            && kind != ElementKind::Pyramid
        {
            let points: Vec<[f64; 3]> = corners.iter().map(|&k| self.parts().points[k as usize]).collect();
            visit(1.0, kind, &points);
            return;
        }
        // Tetrahedra between the centre and the triangles of the surface; behind the centre they count negative.
        let apex = self.centres[cell];
        for (face, sign) in self.signed_faces(cell) {
            for piece in self.surface.pieces(face) {
                let ring = self.surface.ring(piece);
                let at = |k: usize| self.surface.vertices[ring[k] as usize];
                for k in 1..ring.len() - 1 {
                    let (a, b, c) = (at(0), at(k), at(k + 1));
                    let volume = (b - a).cross(c - a).dot(a - apex) * sign * self.orientation(cell);
                    // Corners in the order that makes the tetrahedron's own volume positive.
                    let towards_centre = (b - a).cross(c - a).dot(apex - a) > 0.0;
                    let (b, c) = if towards_centre { (b, c) } else { (c, b) };
                    if volume != 0.0 {
                        let corners = [a, b, c, apex].map(|v| v.to_array());
                        visit(volume.signum(), ElementKind::Tetrahedron, &corners);
                    }
                }
            }
        }
    }
}
