//! Particles from VTK points.

use std::path::Path;

use fieldstone_particles::{Particles, ParticlesError, Quantity};

use super::data::{VtkData, VtkKind};
use super::fault::Fault;
use super::read_vtk;
use super::scalar::whole_numbers;
use crate::column_names::{Dialect, FreeColumns, SizeColumn, sizes_differ};
use crate::{DataArray, IoError, Position};

/// Reads the points of a `.vtu`, `.vtp` or legacy file as particles.
///
/// | array on points | becomes |
/// |---|---|
/// | `radius`, `radii`, `r`, `rad` | radii |
/// | `diameter`, `d`, `diam` | radii, halved, where there is no radius |
/// | `id`; `type`, `matId` | ids, types, where they are whole numbers |
/// | `v`, `velocity`, `U`, `Vel` | `velocity` |
/// | `f`, `force` | `force` |
/// | `omega` | `angular_velocity` |
/// | `mass`; `rho`, `Rhop`, `density` | `mass`; `density` |
/// | any other | a quantity of its own name |
///
/// What is renamed is found by the file's name, too ([`Particles::column`]).
///
/// Letter case does not matter, but for `U`; the names are those of tables ([`crate::CsvReader`]).
///
/// Points that a parallel program marked as copies in `vtkGhostType` are left out. Field data `TimeValue` give
/// the time.
///
/// # Errors
/// Those of [`read_vtk`]; [`IoError::Content`] for a regular grid, and where a `diameter` is not twice the `radius` beside
/// it; [`IoError::Particles`] where a radius is not above zero or a position is not finite.
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
        let scalars = self.columns(1);
        let size = scalars.size();
        if let Some(SizeColumn { column, diameter: Some(other), .. }) = size {
            self.check_sizes(&self.point_data[column], &self.point_data[other])?;
        }
        self.particles(scalars, size).map_err(|source| IoError::Particles { path: self.path.clone(), source })
    }

    /// The arrays on points with so many components, to be looked up by their names.
    fn columns(&self, components: usize) -> FreeColumns<'_> {
        let mut columns = FreeColumns::new(Dialect::Table, self.point_data.iter().map(|array| array.name.as_str()));
        columns.take((0..self.point_data.len()).filter(|&k| self.point_data[k].components != components));
        columns
    }

    /// Refuses diameters that contradict the radii.
    fn check_sizes(&self, radius: &DataArray, diameter: &DataArray) -> Result<(), IoError> {
        let sizes = radius.values.to_f64().into_iter().zip(diameter.values.to_f64());
        let Some((point, (r, d))) = sizes.enumerate().find(|&(_, (r, d))| sizes_differ(r, d)) else { return Ok(()) };
        let found = format!(
            "at point {point} '{}' is {r} and '{}' is {d}, which is not twice as much",
            radius.name, diameter.name
        );
        Err(IoError::content(&self.path, Position::File, found, "remove or rename the array that is wrong"))
    }

    fn particles(&self, mut scalars: FreeColumns<'_>, size: Option<SizeColumn>) -> Result<Particles, ParticlesError> {
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
        if let Some(SizeColumn { column, factor, .. }) = size {
            let sizes = kept(&self.point_data[column]);
            particles = particles.with_radii(sizes.into_iter().map(|size| factor * size).collect())?;
            let of = if factor == 1.0 { "radius" } else { "diameter" };
            particles = particles.with_source_names(of, &[&self.point_data[column].name]);
            scalars.take([column]);
        }
        let mut used: Vec<usize> = size.map(|size| size.column).into_iter().collect();
        if let Some((column, ids)) = scalars.id().and_then(|c| Some((c, kept_whole(&self.point_data[c])?))) {
            particles = particles.with_ids(ids)?.with_source_names("id", &[&self.point_data[column].name]);
            used.push(column);
        }
        if let Some((column, types)) = scalars.kind().and_then(|c| Some((c, kept_whole(&self.point_data[c])?))) {
            particles = particles.with_types(types)?.with_source_names("type", &[&self.point_data[column].name]);
            used.push(column);
        }
        let mut renamed = scalars.renamed_scalars();
        renamed.extend(self.columns(3).renamed_vectors());
        for (column, array) in self.point_data.iter().enumerate() {
            if used.contains(&column) || array.name == "vtkGhostType" {
                continue;
            }
            let standard = renamed.iter().find(|&&(of, _)| of == column).map(|&(_, standard)| standard);
            let name = standard.unwrap_or(&array.name).to_owned();
            let quantity = Quantity { name: name.clone(), components: array.components, data: kept(array) };
            particles = particles.with_quantity(quantity)?.with_source_names(&name, &[&array.name]);
        }
        Ok(particles)
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
    fn names_are_found_in_any_letter_case_as_in_tables() {
        let arrays = ["RAD", "Mass", "Rho", "ID", "MatId"].map(|name| DataArray::scalar(name, vec![2.0, 4.0]));
        let mut arrays = arrays.to_vec();
        arrays.push(DataArray::floats("VELOCITY", 3, vec![1.0; 6]));
        arrays.push(DataArray::floats("u", 3, vec![3.0; 6]));
        let p = two(arrays).to_particles().unwrap();
        assert_eq!(
            (p.radii().unwrap(), p.ids().unwrap(), p.types().unwrap()),
            (&[2.0, 4.0][..], &[2, 4][..], &[2, 4][..])
        );
        for name in ["mass", "density"] {
            assert_eq!(p.quantity(name).unwrap().data, [2.0, 4.0], "{name}");
        }
        assert_eq!(p.quantity("velocity").unwrap().data, [1.0; 6]);
        // A displacement, perhaps.
        assert_eq!(p.quantity("u").unwrap().data, [3.0; 6]);
    }

    #[test]
    fn a_diameter_that_is_not_twice_the_radius_beside_it_is_refused_with_its_point_and_both_values() {
        let sizes = |diameters| {
            let arrays = [("radius", vec![0.5, 0.25]), ("Diameter", diameters)];
            two(arrays.map(|(name, data)| DataArray::scalar(name, data)).to_vec()).to_particles()
        };
        assert_eq!(sizes(vec![1.0, 0.5]).unwrap().quantity("Diameter").unwrap().data, [1.0, 0.5]);
        let message = sizes(vec![1.0, 0.25]).unwrap_err().to_string();
        let expected = "at point 1 'radius' is 0.25 and 'Diameter' is 0.25, which is not twice as much";
        assert!(message.contains(expected), "{message}");
    }

    #[test]
    fn a_scalar_called_v_is_no_velocity() {
        let p = two(vec![DataArray::scalar("v", vec![1.0, 2.0])]).to_particles().unwrap();
        assert!(p.quantity("velocity").is_err());
        assert_eq!(p.quantity("v").unwrap().components, 1);
    }

    #[test]
    fn the_arrays_of_dualsphysics_have_their_meaning_and_are_found_by_their_own_names() {
        let arrays = vec![
            DataArray::floats("Vel", 3, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
            DataArray::scalar("Rhop", vec![998.0, 999.0]),
            DataArray::integers("Type", vec![0, 3]),
        ];
        let p = two(arrays).to_particles().unwrap();
        assert_eq!((p.quantity("density").unwrap().data[1], p.types().unwrap()), (999.0, &[0, 3][..]));
        assert_eq!(p.quantity("velocity").unwrap().data, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        for (name, value) in [("Vel[2]", 5.0), ("velocity[2]", 5.0), ("Rhop", 999.0), ("Type", 3.0)] {
            assert_eq!(p.column(name).unwrap().data[1], value, "{name}");
        }
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
