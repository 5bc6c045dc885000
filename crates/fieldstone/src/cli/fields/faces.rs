//! What crosses the faces of the cells: over time, and as a file of polygons.

use std::path::Path;

use anyhow::bail;
use fieldstone::fields::{FieldsError, ParcelWeight, contact_traction, solid_flux};
use fieldstone::io::DataArray;
use fieldstone::io::vtk::{VtkArrays, VtkEncoding, write_vtp_polygons};
use fieldstone::mesh::{Faces, Grid};
use fieldstone::particles::Domain;

use super::cells::CellSet;
use super::frames::Frame;

/// What crosses the faces in one frame.
#[derive(Debug, Default)]
pub(super) struct FaceSums {
    /// Residual of the worst cell's momentum balance.
    pub balance: Option<f64>,
    forces: Option<Vec<[f64; 3]>>,
    fluxes: Option<Vec<f64>>,
}

impl FaceSums {
    /// Looks at the balance of momentum, and keeps what crosses each face where it is wanted.
    pub fn new<C: Faces>(
        cells: &C,
        frame: &Frame,
        parcels: Option<&ParcelWeight>,
        domain: Option<&Domain>,
        keep: bool,
    ) -> Result<Self, FieldsError> {
        let (particles, contacts) = (&frame.particles, frame.contacts.as_ref());
        let traction = contacts.map(|contacts| contact_traction(cells, particles, contacts, domain)).transpose()?;
        let flows = keep && particles.quantity("velocity").is_ok();
        let weighted;
        let particles = match parcels.filter(|_| flows) {
            // The flux is linear in the velocities: so many particles carry as much as one that moves so much faster.
            Some(weight) => {
                let weights = weight.of(particles)?;
                let mut velocity = particles.quantity("velocity")?.clone();
                let rows = velocity.data.chunks_mut(velocity.components.max(1));
                rows.zip(weights).for_each(|(row, weight)| row.iter_mut().for_each(|v| *v *= weight));
                weighted = particles.clone().with_quantity(velocity)?;
                &weighted
            }
            None => particles,
        };
        Ok(Self {
            balance: traction.as_ref().map(|traction| traction.balance_residual),
            forces: traction.filter(|_| keep).map(|traction| traction.forces),
            fluxes: if flows { Some(solid_flux(cells, particles, domain)?.fluxes) } else { None },
        })
    }
}

/// Means over frames of what crosses the faces.
#[derive(Debug, Default)]
pub(super) struct FaceFields {
    weight: f64,
    forces: Option<Vec<[f64; 3]>>,
    fluxes: Option<Vec<f64>>,
}

impl FaceFields {
    pub fn add(&mut self, frame: &FaceSums, weight: f64) {
        self.weight += weight;
        add(&mut self.forces, &frame.forces, |sum, f| (0..3).for_each(|k| sum[k] += weight * f[k]));
        add(&mut self.fluxes, &frame.fluxes, |sum, q| *sum += weight * q);
    }

    /// Divides the sums by their weight.
    #[must_use]
    pub fn mean(mut self) -> Self {
        let weight = std::mem::replace(&mut self.weight, 1.0);
        self.forces.iter_mut().flatten().for_each(|f| *f = f.map(|f| f / weight));
        self.fluxes.iter_mut().flatten().for_each(|q| *q /= weight);
        self
    }

    /// Writes the faces as polygons, each wound so that its normal leads from the cell behind it to the one in front.
    pub fn write(
        &self,
        path: &Path,
        cells: &CellSet,
        time: f64,
        echo: &str,
        encoding: VtkEncoding,
    ) -> anyhow::Result<()> {
        match cells {
            CellSet::Mesh(mesh) => {
                let parts = mesh.parts();
                let (mut corners, mut ends) = (Vec::new(), Vec::new());
                for face in 0..mesh.face_count() {
                    corners.extend_from_slice(parts.face(face));
                    ends.push(corners.len());
                }
                self.write_polygons(path, mesh.as_ref(), &parts.points, &corners, &ends, time, echo, encoding)
            }
            CellSet::Grid(grid) => {
                let (points, corners) = rectangles(grid);
                let ends: Vec<usize> = (1..=grid.face_count()).map(|k| 4 * k).collect();
                self.write_polygons(path, grid, &points, &corners, &ends, time, echo, encoding)
            }
            CellSet::Cylinder(_) => bail!("this output does not go with these cells"),
        }
    }

    #[allow(clippy::too_many_arguments, reason = "what a file holds, and where it goes")]
    fn write_polygons<C: Faces>(
        &self,
        path: &Path,
        cells: &C,
        points: &[[f64; 3]],
        corners: &[u32],
        ends: &[usize],
        time: f64,
        echo: &str,
        encoding: VtkEncoding,
    ) -> anyhow::Result<()> {
        let vectors: Vec<[f64; 3]> = (0..cells.face_count()).map(|face| cells.face_vector(face)).collect();
        let areas: Vec<f64> = vectors.iter().map(|[x, y, z]| x.hypot(*y).hypot(*z)).collect();
        let side = |which: usize| -> Vec<i64> {
            (0..cells.face_count()).map(|face| cells.face_sides(face)[which].map_or(-1, i64::from)).collect()
        };
        let mut data = vec![
            DataArray::integers("back_cell", side(0)),
            DataArray::integers("front_cell", side(1)),
            DataArray::floats("face_vector", 3, vectors.into_flattened()),
        ];
        if let Some(forces) = &self.forces {
            let over = |f: &[f64; 3], area: f64| if area > 0.0 { f.map(|f| f / area) } else { [0.0; 3] };
            let tractions: Vec<[f64; 3]> = forces.iter().zip(&areas).map(|(f, area)| over(f, *area)).collect();
            data.push(DataArray::floats("contact_force", 3, forces.as_flattened().to_vec()));
            data.push(DataArray::floats("contact_traction", 3, tractions.into_flattened()));
        }
        if let Some(fluxes) = &self.fluxes {
            data.push(DataArray::scalar("solid_flux", fluxes.clone()));
        }
        let axes = ["x", "y", "z"].map(String::from);
        let names = ["face_vector", "contact_force", "contact_traction"].map(|name| (name, &axes[..]));
        let arrays = VtkArrays {
            cells: &data,
            time: Some(time),
            texts: &[("fieldstone", echo)],
            component_names: &names,
            ..VtkArrays::default()
        };
        Ok(write_vtp_polygons(path, points, corners, ends, arrays, encoding)?)
    }
}

/// Adds where there is something to add; the first frame makes the sums.
fn add<T: Copy + Default>(sums: &mut Option<Vec<T>>, frame: &Option<Vec<T>>, each: impl Fn(&mut T, &T)) {
    if let Some(frame) = frame {
        let sums = sums.get_or_insert_with(|| vec![T::default(); frame.len()]);
        sums.iter_mut().zip(frame).for_each(|(sum, x)| each(sum, x));
    }
}

/// Corners of a grid's cells, and the four of each face in the order of the faces.
fn rectangles(grid: &Grid) -> (Vec<[f64; 3]>, Vec<u32>) {
    let [nx, ny, nz] = grid.cells();
    let mut points = Vec::with_capacity((nx + 1) * (ny + 1) * (nz + 1));
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                points.push([grid.plane(0, i), grid.plane(1, j), grid.plane(2, k)]);
            }
        }
    }
    let point = |at: [usize; 3]| (at[0] + (nx + 1) * (at[1] + (ny + 1) * at[2])) as u32;
    let mut corners = Vec::with_capacity(4 * grid.face_count());
    for axis in 0..3 {
        let mut counts = grid.cells();
        counts[axis] += 1;
        for k in 0..counts[2] {
            for j in 0..counts[1] {
                for i in 0..counts[0] {
                    // Around the normal, which leads along the axis.
                    for (u, v) in [(0, 0), (1, 0), (1, 1), (0, 1)] {
                        let mut at = [i, j, k];
                        at[(axis + 1) % 3] += u;
                        at[(axis + 2) % 3] += v;
                        corners.push(point(at));
                    }
                }
            }
        }
    }
    (points, corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rectangles_are_the_grids_faces_and_lie_around_their_normals() {
        let grid = Grid::new([0.0, 1.0, -1.0], [3.0, 2.0, 1.0], [3, 1, 4]).unwrap();
        let (points, corners) = rectangles(&grid);
        assert_eq!(corners.len(), 4 * grid.face_count());
        for (face, corners) in corners.as_chunks::<4>().0.iter().enumerate() {
            let [a, b, _, d] = corners.map(|p| points[p as usize]);
            let (u, v): ([f64; 3], [f64; 3]) =
                (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| d[k] - a[k]));
            let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let wanted = grid.face_vector(face);
            assert!((0..3).all(|k| (normal[k] - wanted[k]).abs() < 1e-15), "{face}: {normal:?} {wanted:?}");
            // Between the two cells' centres.
            let middle: [f64; 3] =
                std::array::from_fn(|k| corners.iter().map(|&p| points[p as usize][k]).sum::<f64>() / 4.0);
            if let [Some(back), Some(front)] = grid.face_sides(face) {
                let [back, front] = [back, front].map(|cell| grid.centre(cell as usize));
                assert!((0..3).all(|k| (0.5 * (back[k] + front[k]) - middle[k]).abs() < 1e-15), "{face}");
            }
        }
    }
}
