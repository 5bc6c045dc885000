//! Ball in mesh: the overlap with every cell, each face evaluated once per ball.

use std::f64::consts::PI;

use fieldstone_geometry::{Ball, ErrorBound, PROMISE, Vector, overlap, overlap_volume, volume_from_terms};
use glam::DVec3;

use crate::surface::FaceSum;
use crate::{Mesh, PathCounts};

/// Volumes below this, in units of the radius cubed, do not tell by their sign whether the centre is in the cell.
const UNDECIDED: f64 = 1e-9;

/// How the faces in reach of a ball are evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Way {
    /// From what of them is inside the ball, see [`crate::face_inside`].
    Inside,
    /// From what of them is outside it: any ball, any face, but every face of a cell is needed.
    Outside,
}

/// A face had to be evaluated from outside: start the ball again that way.
#[derive(Debug)]
pub(crate) struct NotFromInside;

/// Rounding error of the volume from inside in units of ε ρ r³ / δ, beyond what [`ErrorBound`] counts, with ρ the distance of
/// the farthest corner and δ that of the nearest edge, see [`crate::face_inside`]: angles there lose 1/δ.
///
/// With it the bounds are 6 times the largest error of 400,000 random and adversarial pairs within the promise, small balls near
/// edges among them; `error_bounds.rs` asserts 5 times, for a tenth of them unless asked for more.
const NEAR_ROUNDING: f64 = 8.0;

/// Overlap of one ball with one cell, by `f64` alone.
#[derive(Debug, Clone, Copy)]
pub(crate) struct InF64 {
    pub volume: f64,
    pub sphere_area: f64,
    /// Bounds of the errors of volume and sphere area, the latter where the former keeps the promise; `None` where the cell is plainly apart from the ball, or inside it.
    pub errors: Option<[f64; 2]>,
}

/// Working memory of [`crate::Cells::overlap_ball`] and its siblings: one per thread.
///
/// One number per face of the mesh; nothing of that size has to be cleared between balls.
#[derive(Debug, Clone)]
pub struct MeshScratch {
    /// For each face the number of the ball for which it was evaluated last, and in the lower half its place in `sums`.
    ///
    /// Zeros that the operating system hands out on first use: what is not near any ball of the thread costs nothing.
    places: Vec<u64>,
    /// Of the faces evaluated for this ball.
    sums: Vec<FaceSum>,
    ball: u32,
    candidates: Vec<u32>,
    pub(crate) ring: Vec<Vector<f64>>,
    shifted: Vec<DVec3>,
    promise: bool,
    pub(crate) counts: PathCounts,
    pub(crate) polygon: Vec<DVec3>,
    pub(crate) clipped: Vec<DVec3>,
}

impl MeshScratch {
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let faces = mesh.parts().owner.len();
        Self {
            places: vec![0; faces],
            sums: Vec::new(),
            ball: 0,
            candidates: Vec::new(),
            ring: Vec::new(),
            shifted: Vec::new(),
            promise: true,
            counts: PathCounts::default(),
            polygon: Vec::new(),
            clipped: Vec::new(),
        }
    }

    pub(crate) fn in_f64_alone(mut self) -> Self {
        self.promise = false;
        self
    }

    pub(crate) fn next_ball(&mut self) {
        self.sums.clear();
        self.ball = self.ball.wrapping_add(1);
        if self.ball == 0 {
            self.places.fill(0);
            self.ball = 1;
        }
    }

    /// What was found for a face and this ball.
    #[inline]
    fn sum(&self, face: usize) -> Option<&FaceSum> {
        let place = self.places[face];
        (place >> 32 == u64::from(self.ball)).then(|| &self.sums[place as u32 as usize])
    }

    #[inline]
    fn keep(&mut self, face: usize, sum: FaceSum) {
        self.places[face] = u64::from(self.ball) << 32 | self.sums.len() as u64;
        self.sums.push(sum);
    }
}

/// Overlap of one ball with one cell of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellOverlap {
    /// The cell.
    pub cell: u32,
    /// Volume of the ball in the cell.
    pub volume: f64,
    /// Area of the ball's surface in the cell.
    pub sphere_area: f64,
}

impl Mesh {
    /// Appends the overlap of `ball` with each cell that it reaches, and the area of each face inside the ball.
    ///
    /// The face areas belong to the faces of the cells listed; the flux of solid through a face is the ball's
    /// velocity times the normal times the area.
    ///
    /// The volumes keep the promise of [`fieldstone_geometry::overlap_volume`], and sphere areas that of
    /// [`fieldstone_geometry::overlap`], relative to the smaller of the sphere and the cell's surface; the areas of faces are those
    /// of `f64`, with errors of some 1e-15 r².
    ///
    /// Cost: one evaluation of [`fieldstone_geometry::face_terms`] per face of the cells in reach.
    pub fn overlap_ball_areas(
        &self,
        ball: &Ball,
        scratch: &mut MeshScratch,
        cells: &mut Vec<CellOverlap>,
        faces: &mut Vec<(u32, f64)>,
    ) {
        let (first_cell, start) = (cells.len(), faces.len());
        let r2 = ball.radius() * ball.radius();
        self.visit_cells(ball, scratch, |cell, way, scratch| {
            if cell.is_none() {
                cells.truncate(first_cell);
                faces.truncate(start);
            }
            let Some(cell) = cell else { return Ok(()) };
            let overlap = self.cell_overlap(ball, cell, way, scratch, false)?;
            if overlap.volume > 0.0 {
                for &face in self.cell_faces(cell as usize) {
                    let area = scratch.sum(face as usize).map_or(0.0, |sum| sum.area);
                    if area > 0.0 {
                        faces.push((face, r2 * area));
                    }
                }
                cells.push(overlap);
            }
            Ok(())
        });
        faces[start..].sort_unstable_by_key(|&(face, _)| face);
        // The two cells of a face report the very same evaluation.
        let mut kept = start;
        for k in start..faces.len() {
            if kept == start || faces[kept - 1].0 != faces[k].0 {
                faces[kept] = faces[k];
                kept += 1;
            }
        }
        faces.truncate(kept);
    }

    pub(crate) fn overlap_ball_volumes(&self, ball: &Ball, scratch: &mut MeshScratch, out: &mut Vec<(u32, f64)>) {
        let start = out.len();
        self.visit_cells(ball, scratch, |cell, way, scratch| {
            let Some(cell) = cell else {
                out.truncate(start);
                return Ok(());
            };
            let volume = self.cell_overlap(ball, cell, way, scratch, true)?.volume;
            if volume > 0.0 {
                out.push((cell, volume));
            }
            Ok(())
        });
    }

    /// Calls `visit` with the cells whose bounds meet the ball, in rising order.
    ///
    /// Where `visit` says that a face cannot be evaluated from inside, it is called with `None`, to drop what it
    /// has gathered for this ball, and with all the cells again, which then agree on the way.
    fn visit_cells(
        &self,
        ball: &Ball,
        scratch: &mut MeshScratch,
        mut visit: impl FnMut(Option<u32>, Way, &mut MeshScratch) -> Result<(), NotFromInside>,
    ) {
        scratch.next_ball();
        let centre = DVec3::from(ball.centre());
        let r2 = ball.radius() * ball.radius();
        let mut candidates = std::mem::take(&mut scratch.candidates);
        candidates.clear();
        self.tree.query(&self.bounds, centre - ball.radius(), centre + ball.radius(), |cell| {
            let [low, high] = self.bounds[cell as usize];
            if (centre - centre.clamp(low, high)).length_squared() < r2 * (1.0 + 8.0 * f64::EPSILON) {
                candidates.push(cell);
            }
        });
        candidates.sort_unstable();
        let counts = scratch.counts;
        let done = candidates.iter().try_for_each(|&cell| visit(Some(cell), Way::Inside, scratch));
        if done.is_err() {
            // What the first attempt has counted is counted again.
            scratch.counts = counts;
            scratch.next_ball();
            // From outside no face is refused.
            let _ = visit(None, Way::Outside, scratch);
            let _ = candidates.iter().try_for_each(|&cell| visit(Some(cell), Way::Outside, scratch));
        }
        scratch.candidates = candidates;
    }

    fn cell_overlap(
        &self,
        ball: &Ball,
        cell: u32,
        way: Way,
        scratch: &mut MeshScratch,
        volume_only: bool,
    ) -> Result<CellOverlap, NotFromInside> {
        let InF64 { mut volume, mut sphere_area, errors } = self.cell_in_f64(ball, cell, way, scratch, volume_only)?;
        if let Some([error, area_error]) = errors {
            scratch.counts.evaluated += 1;
            let whole = self.cell_volumes()[cell as usize];
            let kept = error <= PROMISE * whole.min(ball.volume())
                && (volume_only || area_error <= PROMISE * self.surface_of(cell as usize).min(ball.surface_area()));
            if scratch.promise && !kept {
                // Every cell that a mesh takes can stand alone: see `Mesh::assemble`.
                if let Ok(alone) = self.polyhedron_of_pieces(cell as usize) {
                    scratch.counts.beyond_f64 += 1;
                    if volume_only {
                        volume = overlap_volume(ball, &alone);
                    } else {
                        // Of one evaluation: an area in `f64` may see the ball pass by where the volume sees it cut.
                        let exact = overlap(ball, &alone);
                        (volume, sphere_area) = (exact.volume, exact.sphere_area);
                    }
                }
            }
        }
        Ok(CellOverlap { cell, volume, sphere_area })
    }

    /// Area of a cell's faces.
    fn surface_of(&self, cell: usize) -> f64 {
        self.cell_faces(cell).iter().map(|&face| self.surface.area_vectors[face as usize].length()).sum()
    }

    /// The overlap without regard to the promise.
    pub(crate) fn cell_in_f64(
        &self,
        ball: &Ball,
        cell: u32,
        way: Way,
        scratch: &mut MeshScratch,
        volume_only: bool,
    ) -> Result<InF64, NotFromInside> {
        let at = cell as usize;
        let centre = DVec3::from(ball.centre());
        let r = ball.radius();
        let whole = self.cell_volumes()[at];
        let outward = self.orientation(at);
        let settled = |volume| Ok(InF64 { volume, sphere_area: 0.0, errors: None });

        // Inside by more than the rounding of the distances, which for a huge ball is more than a small cell.
        let surely = r * r * (1.0 - 8.0 * f64::EPSILON);
        let inside = |k: &u32| (self.surface.vertices[*k as usize] - centre).length_squared() <= surely;
        let all_inside = self.cell_vertices(at).iter().all(inside);
        if all_inside && volume_only {
            return settled(whole);
        }
        if !all_inside && self.is_convex(at) {
            // A plane that has the ball on its outer side settles a convex cell without a single angle.
            // By more than the rounding of planes and distances.
            let apart = r * (1.0 + 1e-9);
            let apart = self.signed_faces(at).any(|(face, sign)| {
                self.surface.pieces(face).any(|piece| outward * sign * self.surface.height(piece, centre) >= apart)
            });
            if apart {
                return settled(0.0);
            }
        }

        let scale = 1.0 / r;
        let (mut volume3, mut solid_angle, mut touched) = (0.0, 0.0, false);
        let mut nearest = f64::INFINITY;
        let [low, high] = self.bounds[at];
        let reach = (centre - low).abs().max((high - centre).abs()).length() * scale;
        let (mut bound, mut nearness) = (ErrorBound::new(reach), 0.0f64);
        for (face, sign) in self.signed_faces(at) {
            let sum = if let Some(&sum) = scratch.sum(face) {
                sum
            } else {
                let sum = match way {
                    Way::Inside => {
                        self.surface.sum_inside(face, centre, r, scale, &mut scratch.shifted).ok_or(NotFromInside)?
                    }
                    Way::Outside => self.surface.sum(face, centre, scale, &mut scratch.ring),
                };
                scratch.keep(face, sum);
                sum
            };
            volume3 += sign * sum.volume3;
            solid_angle += sign * sum.solid_angle;
            touched |= sum.area != 0.0;
            nearness = nearness.max(sum.nearness);
            // From inside, a face out of reach adds nothing, and no error.
            if way == Way::Outside || sum.area != 0.0 {
                let [flatness, warp] = self.surface.shapes[face];
                bound.add(sum.area, flatness, warp * scale);
            }
            nearest = nearest.min(if outward * sign > 0.0 { sum.distances[0] } else { -sum.distances[1] });
        }
        if all_inside {
            return settled(whole);
        }
        (volume3, solid_angle) = (outward * volume3, outward * solid_angle);
        if way == Way::Inside {
            // The sum lacks 4π where the centre is in the cell. It then lies between minus the ball and 0, otherwise
            // between 0 and the ball; and the centre is surely inside where it is on the inner side of every piece.
            let centre_inside = if volume3.abs() > UNDECIDED {
                volume3 < 0.0
            } else if nearest > 0.0 {
                true
            } else if self.is_convex(at) {
                false
            } else if !touched {
                let turns: i32 = self
                    .signed_faces(at)
                    .map(|(face, sign)| (outward * sign) as i32 * self.surface.crossings(face, centre))
                    .sum();
                turns > 0
            } else {
                (volume3, solid_angle) = (0.0, 0.0);
                for (face, sign) in self.signed_faces(at) {
                    let sum = self.surface.sum(face, centre, scale, &mut scratch.ring);
                    volume3 += outward * sign * sum.volume3;
                    solid_angle += outward * sign * sum.solid_angle;
                }
                false
            };
            if centre_inside {
                volume3 += 4.0 * PI;
                solid_angle += 4.0 * PI;
            }
        }
        let volume = volume_from_terms(ball, whole, volume3, solid_angle, touched);
        let sphere_area = if touched {
            (solid_angle * r * r).clamp(0.0, ball.surface_area())
        } else if volume > 0.0 {
            ball.surface_area()
        } else {
            0.0
        };
        // From outside there is no nearness.
        let near = NEAR_ROUNDING * f64::EPSILON * reach * nearness * r * r;
        let errors = Some([bound.volume(r) + near * r, bound.sphere_area(r) + near]);
        Ok(InF64 { volume, sphere_area, errors })
    }
}
