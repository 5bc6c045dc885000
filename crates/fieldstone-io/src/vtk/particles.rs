//! Particles from VTK points.

use std::path::Path;

use fieldstone_particles::{Particles, ParticlesError, Quantity};

use super::data::{VtkData, VtkKind};
use super::fault::Fault;
use super::read_vtk;
use super::scalar::whole_numbers;
use crate::{DataArray, IoError, Position};

/// Reads the points of a `.vtu`, `.vtp` or legacy file as particles.
///
/// | array on points | becomes |
/// |---|---|
/// | `radius`, `Radius`, `radii`, `R` | radii |
/// | `diameter`, `Diameter`, `d` | radii, halved, where there is no radius |
/// | `id`, `ID`, `Id`; `type`, `Type` | ids, types, where they are whole numbers |
/// | `v`, `velocity`, `Velocity`, `U` | `velocity` |
/// | `f`, `force`, `Force` | `force` |
/// | `omega` | `angular_velocity` |
/// | `rho`, `density` | `density` |
/// | any other | a quantity of its own name |
///
/// Points that a parallel program marked as copies in `vtkGhostType` are left out. Field data `TimeValue` give
/// the time.
///
/// # Errors
/// Those of [`read_vtk`]; [`IoError::Content`] for a regular grid; [`IoError::Particles`] where a radius is not
/// above zero or a position is not finite.
///
/// ```
/// use fieldstone_io::vtk::read_vtk_particles;
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("one.vtk");
/// std::fs::write(&path, "# vtk DataFile Version 4.2\none\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n1 2 3\n\
///     POINT_DATA 1\nFIELD f 2\ndiameter 1 1 double\n0.5\nv 3 1 double\n0 0 -1\n")?;
/// let particles = read_vtk_particles(&path)?;
/// assert_eq!(particles.radii()?, [0.25]);
/// assert_eq!(particles.quantity("velocity")?.data, [0.0, 0.0, -1.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_vtk_particles(path: &Path) -> Result<Particles, IoError> {
    read_vtk(path)?.to_particles()
}

const RADIUS: [&str; 4] = ["radius", "Radius", "radii", "R"];
const DIAMETER: [&str; 3] = ["diameter", "Diameter", "d"];
const ID: [&str; 3] = ["id", "ID", "Id"];
const TYPE: [&str; 2] = ["type", "Type"];

/// Standard names, what files call them, and numbers per particle.
const STANDARD: [(&str, &[&str], usize); 4] = [
    ("velocity", &["velocity", "Velocity", "v", "U"], 3),
    ("force", &["force", "Force", "f"], 3),
    ("angular_velocity", &["angular_velocity", "omega"], 3),
    ("density", &["density", "Density", "rho"], 1),
];

impl VtkData {
    /// The points with their columns as particles.
    ///
    /// # Errors
    /// As [`read_vtk_particles`].
    pub fn to_particles(&self) -> Result<Particles, IoError> {
        if self.kind == VtkKind::ImageData {
            let fault = Fault::new(
                Position::File,
                "the file holds a regular grid, not particles",
                "give a file of points: .vtu, .vtp, or legacy POLYDATA",
            );
            return Err(fault.in_file(&self.path));
        }
        if self.has_volume_cells() {
            let fault = Fault::new(
                Position::File,
                "the file holds a mesh of volume cells, whose points are no particles",
                "give it as the mesh, and a file of points as the particles",
            );
            return Err(fault.in_file(&self.path));
        }
        self.particles().map_err(|source| IoError::Particles { path: self.path.clone(), source })
    }

    fn particles(&self) -> Result<Particles, ParticlesError> {
        let ghosts = self.duplicates(&self.point_data);
        let keep = |point: usize| ghosts.get(point) != Some(&true);
        let positions = self.points.iter().enumerate().filter(|&(k, _)| keep(k)).map(|(_, &p)| p).collect();
        let kept = |array: &DataArray| -> Vec<f64> {
            let n = array.components.max(1);
            array.values.to_f64().into_iter().enumerate().filter(|&(k, _)| keep(k / n)).map(|(_, x)| x).collect()
        };
        let kept_whole = |array: &DataArray| -> Option<Vec<i64>> {
            let numbers = whole_numbers(&array.values)?;
            Some(numbers.into_iter().enumerate().filter(|&(k, _)| keep(k)).map(|(_, x)| x).collect())
        };
        let mut particles = Particles::new(positions)?.at(None, self.time);
        let mut used = Vec::new();
        if let Some(array) = self.first_of(&RADIUS, 1) {
            particles = particles.with_radii(kept(array))?;
            used.push(array.name.as_str());
        } else if let Some(array) = self.first_of(&DIAMETER, 1) {
            particles = particles.with_radii(kept(array).into_iter().map(|d| 0.5 * d).collect())?;
            used.push(&array.name);
        }
        if let Some((array, ids)) = self.first_of(&ID, 1).and_then(|a| Some((a, kept_whole(a)?))) {
            particles = particles.with_ids(ids)?;
            used.push(&array.name);
        }
        if let Some((array, types)) = self.first_of(&TYPE, 1).and_then(|a| Some((a, kept_whole(a)?))) {
            particles = particles.with_types(types)?;
            used.push(&array.name);
        }
        let mut renamed = Vec::new();
        for (standard, names, components) in STANDARD {
            if let Some(array) = self.first_of(names, components) {
                renamed.push((array.name.as_str(), standard));
            }
        }
        for array in &self.point_data {
            if used.contains(&array.name.as_str()) || array.name == "vtkGhostType" {
                continue;
            }
            let standard = renamed.iter().find(|(name, _)| *name == array.name).map(|&(_, standard)| standard);
            let name = standard.unwrap_or(&array.name).to_owned();
            particles = particles.with_quantity(Quantity { name, components: array.components, data: kept(array) })?;
        }
        Ok(particles)
    }

    /// The first of `names` that is an array on points with so many components.
    fn first_of(&self, names: &[&str], components: usize) -> Option<&DataArray> {
        names.iter().find_map(|name| self.point_data.iter().find(|a| a.name == *name && a.components == components))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Values;

    fn two(arrays: Vec<DataArray>) -> VtkData {
        let mut d = VtkData::new(VtkKind::PolyData);
        d.points = vec![[0.0; 3], [1.0, 0.0, 0.0]];
        d.point_data = arrays;
        d
    }

    #[test]
    fn a_radius_wins_over_a_diameter_which_stays_a_quantity() {
        let p = two(vec![DataArray::scalar("d", vec![9.0, 9.0]), DataArray::scalar("Radius", vec![0.5, 0.25])]);
        let p = p.to_particles().unwrap();
        assert_eq!(p.radii().unwrap(), [0.5, 0.25]);
        assert_eq!(p.quantity("d").unwrap().data, [9.0, 9.0]);
    }

    #[test]
    fn a_scalar_called_v_is_no_velocity() {
        let p = two(vec![DataArray::scalar("v", vec![1.0, 2.0])]).to_particles().unwrap();
        assert!(p.quantity("velocity").is_err());
        assert_eq!(p.quantity("v").unwrap().components, 1);
    }

    #[test]
    fn two_names_of_the_velocity_do_not_overwrite_each_other() {
        let arrays = vec![DataArray::floats("v", 3, vec![1.0; 6]), DataArray::floats("velocity", 3, vec![2.0; 6])];
        let p = two(arrays).to_particles().unwrap();
        assert_eq!(p.quantity("velocity").unwrap().data, [2.0; 6]);
        assert_eq!(p.quantity("v").unwrap().data, [1.0; 6]);
    }

    #[test]
    fn ghost_copies_are_left_out_of_every_column() {
        let ghost = DataArray { name: "vtkGhostType".into(), components: 1, values: Values::U8(vec![1, 0]) };
        let arrays = vec![
            ghost,
            DataArray::integers("id", vec![7, 8]),
            DataArray::floats("v", 3, vec![0.0, 0.0, 0.0, 1.0, 2.0, 3.0]),
        ];
        let p = two(arrays).to_particles().unwrap();
        assert_eq!((p.len(), p.ids().unwrap()), (1, &[8][..]));
        assert_eq!(p.quantity("velocity").unwrap().data, [1.0, 2.0, 3.0]);
    }

    #[test]
    fn float_ids_count_where_they_are_whole_and_stay_a_quantity_where_not() {
        let p = two(vec![DataArray::scalar("id", vec![1.0, 2.0]), DataArray::scalar("type", vec![1.0, 1.5])]);
        let p = p.to_particles().unwrap();
        assert_eq!(p.ids().unwrap(), [1, 2]);
        assert!(p.types().is_none() && p.quantity("type").is_ok());
    }
}
