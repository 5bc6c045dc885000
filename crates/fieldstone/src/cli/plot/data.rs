//! One field of a file of results, whatever its format.

use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use fieldstone::fields::{FieldName, component_names};
use fieldstone::io::{CsvTable, DataArray, read_stat, vtk};
use fieldstone::mesh::{Cells, Mesh};

use crate::cli::arguments::ending_of_input;
use crate::cli::fields::mercury_name;
use crate::cli::info::is_over_time;

/// Cells that are all combinations of intervals along three coordinates.
#[derive(Debug)]
pub(super) struct Lattice {
    /// Names of the coordinates.
    pub names: [String; 3],
    /// Bounds of the intervals along each.
    pub edges: [Vec<f64>; 3],
    /// The cell at each place, first coordinate fastest; none where the file has none there.
    pub cells: Vec<Option<u32>>,
}

impl Lattice {
    pub fn counts(&self) -> [usize; 3] {
        [0, 1, 2].map(|k| self.edges[k].len() - 1)
    }

    pub fn cell(&self, [i, j, k]: [usize; 3]) -> Option<u32> {
        let [nx, ny, _] = self.counts();
        self.cells[i + nx * (j + ny * k)]
    }

    /// The interval along an axis that holds a value.
    pub fn interval(&self, axis: usize, value: f64) -> Option<usize> {
        let edges = &self.edges[axis];
        let last = edges.len() - 1;
        let inside = value >= edges[0] && value <= edges[last];
        inside.then(|| (edges.partition_point(|&edge| edge <= value)).saturating_sub(1).min(last - 1))
    }

    /// From lists of centres along each axis, and the place of each cell.
    fn new(names: [String; 3], centres: [Vec<f64>; 3], places: &[[usize; 3]]) -> Self {
        let counts = [0, 1, 2].map(|k: usize| centres[k].len());
        let mut cells = vec![None; counts.iter().product()];
        for (cell, [i, j, k]) in places.iter().enumerate() {
            cells[i + counts[0] * (j + counts[1] * k)] = Some(cell as u32);
        }
        Self { names, edges: centres.map(|c| edges_around(&c)), cells }
    }
}

/// Bounds halfway between centres; a lone centre gets an interval of length 1.
fn edges_around(centres: &[f64]) -> Vec<f64> {
    let n = centres.len();
    let step = |a: usize, b: usize| if n > 1 { 0.5 * (centres[b] - centres[a]) } else { 0.5 };
    let mut edges = vec![centres[0] - step(0, 1.min(n - 1))];
    edges.extend(centres.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])));
    edges.push(centres[n - 1] + step(n.saturating_sub(2), n - 1));
    edges
}

/// Where the field lives.
pub(super) enum Places {
    Lattice(Lattice),
    Mesh(Box<Mesh>),
}

/// A field with its cells.
pub(super) struct Plotted {
    pub places: Places,
    pub volumes: Vec<f64>,
    /// Mass density of what the field is of, all particles or a species, where the file has it.
    pub density: Option<Vec<f64>>,
    /// Names of the components; one empty name for a scalar.
    pub components: Vec<String>,
    /// Cell by cell.
    pub data: Vec<f64>,
}

impl Plotted {
    pub fn value(&self, cell: usize, component: usize) -> f64 {
        self.data[cell * self.components.len() + component]
    }
}

/// A table of columns by name, with the cells.
struct Table {
    places: Places,
    volumes: Vec<f64>,
    /// Names as the file has them, components, numbers.
    columns: Vec<(String, usize, Vec<f64>)>,
}

/// Reads a field of the file; of a file over time, at the block or step `frame` (negative from the end).
pub(super) fn read(path: &Path, field: &str, frame: i64) -> anyhow::Result<Plotted> {
    let ending = ending_of_input(path);
    if matches!(ending.as_str(), "vti" | "vtu" | "csv") {
        place(path, frame, 1)?;
    }
    let table = match ending.as_str() {
        "vti" | "vtu" => from_vtk(path, field)?,
        "pvd" => {
            let steps = vtk::read_pvd(path)?;
            let files: Vec<PathBuf> = steps.into_iter().map(|(_, file)| file).collect();
            from_vtk(&files[place(path, frame, files.len())?], field)?
        }
        "stat" => from_stat(path, frame)?,
        "csv" => from_csv(path, field)?,
        _ => bail!(
            "{}: give a .vti, .vtu, .pvd, .csv or .stat file (or one of them as .gz) that fieldstone fields wrote",
            path.display()
        ),
    };
    let find = |wanted: &str| table.columns.iter().find(|(name, ..)| is(name, wanted));
    let Some((name, count, data)) = find(field) else {
        let names: Vec<&str> = table.columns.iter().map(|(name, ..)| name.as_str()).collect();
        bail!("{}: there is no field '{field}'; it has {}", path.display(), names.join(", "))
    };
    let known = known_field(name).filter(|known| known.components().len() == *count);
    let components = match known {
        Some(known) => known.components().iter().map(|c| (*c).to_string()).collect(),
        None => component_names(*count),
    };
    let density = find(&density_of(field)).map(|(.., data)| data.clone());
    Ok(Plotted { components, data: data.clone(), density, volumes: table.volumes, places: table.places })
}

/// A field's name without the species, and the species: `density` and 2 of `density_species_2`, and of MercuryCG's
/// `DensitySpecies2` the same.
fn apart(name: &str) -> (&str, Option<i64>) {
    let parts = name.rsplit_once("_species_").or_else(|| name.rsplit_once("Species"));
    match parts.and_then(|(of_all, species)| Some((of_all, species.parse().ok()?))) {
        Some((of_all, species)) => (of_all, Some(species)),
        None => (name, None),
    }
}

/// The field that a file's name stands for, be it of all particles or of a species.
pub(super) fn known_field(name: &str) -> Option<FieldName> {
    let (of_all, _) = apart(name);
    FieldName::ALL.iter().copied().find(|known| is(of_all, known.name()))
}

/// The density that a field is a mean by: that of the same species.
fn density_of(field: &str) -> String {
    let (_, species) = apart(field);
    species.map_or("density".into(), |species| format!("density_species_{species}"))
}

/// Place of a frame in a list.
fn place(path: &Path, frame: i64, count: usize) -> anyhow::Result<usize> {
    let at = if frame < 0 { frame + count as i64 } else { frame };
    usize::try_from(at).ok().filter(|&at| at < count).ok_or_else(|| {
        anyhow!("{}: frame {frame} was asked for, and the file has {count}, from 0; -1 is the last", path.display())
    })
}

/// Whether a file's name of a field is the wanted one, ours or MercuryCG's.
fn is(name: &str, wanted: &str) -> bool {
    name == wanted || name == mercury_name(wanted)
}

fn three(names: [&str; 3]) -> [String; 3] {
    names.map(String::from)
}

/// The fields on cells; of a grid those on nodes, where the wanted one is there.
fn from_vtk(path: &Path, field: &str) -> anyhow::Result<Table> {
    let file = vtk::read_vtk(path)?;
    let numbers = |array: &DataArray| (array.name.clone(), array.components, array.values.to_f64());
    if file.image.is_none() && !file.has_volume_cells() {
        bail!(
            "{}: the file has no volume cells to show fields on; fieldstone grid makes a .vti with fields from particles",
            path.display()
        );
    }
    let has = |arrays: &[DataArray]| arrays.iter().any(|array| is(&array.name, field));
    let on_nodes = !has(&file.cell_data) && has(&file.point_data);
    if !has(&file.cell_data) && (!on_nodes || file.image.is_none()) {
        let names = |arrays: &[DataArray]| arrays.iter().map(|a| a.name.clone()).collect::<Vec<_>>().join(", ");
        let (cells, nodes) = (names(&file.cell_data), names(&file.point_data));
        let path = path.display();
        match (cells.is_empty(), nodes.is_empty(), file.image.is_some()) {
            (true, true, _) => {
                bail!("{path}: the file has no fields; give a result of fieldstone fields, fraction or grid")
            }
            (false, true, _) => bail!("{path}: there is no field '{field}'; it has {cells}"),
            (true, false, true) => bail!("{path}: there is no field '{field}'; it has {nodes}, on nodes"),
            (false, false, true) => bail!("{path}: there is no field '{field}'; it has {cells}, and on nodes {nodes}"),
            (true, false, false) => bail!(
                "{path}: its fields are on nodes ({nodes}), and plot takes those on cells, on nodes only of a .vti: give \
                 another file, or interpolate them to cells in ParaView"
            ),
            (false, false, false) => bail!(
                "{path}: there is no field '{field}' on cells; it has {cells}, and {nodes} on nodes, which plot takes of a \
                 .vti only"
            ),
        }
    }
    let arrays = if on_nodes { &file.point_data } else { &file.cell_data };
    let mut columns: Vec<_> = arrays.iter().map(numbers).collect();
    let Some(image) = &file.image else {
        let found = file.to_mesh()?;
        for (_, components, data) in &mut columns {
            let rows = found.file_cells.iter().map(|&cell| cell as usize * *components);
            *data = rows.flat_map(|at| data[at..at + *components].to_vec()).collect();
        }
        let volumes = found.mesh.cell_volumes().to_vec();
        return Ok(Table { places: Places::Mesh(Box::new(found.mesh)), volumes, columns });
    };
    if image.direction != vtk::VtkImage::ALIGNED {
        bail!("{}: the grid's axes are not x, y and z", path.display());
    }
    if on_nodes {
        let places = around_nodes(image);
        let volumes = volumes(&places);
        return Ok(Table { places: Places::Lattice(places), volumes, columns });
    }
    let count = image.cells.map(|n| n.max(1));
    let edges = [0, 1, 2].map(|k| (0..=count[k]).map(|i| image.origin[k] + image.spacing[k] * i as f64).collect());
    let cells = (0..image.cell_count() as u32).map(Some).collect();
    let volumes = vec![image.spacing.iter().product(); image.cell_count()];
    let places = Places::Lattice(Lattice { names: three(["x", "y", "z"]), edges, cells });
    Ok(Table { places, volumes, columns })
}

/// Each node with what is nearer to it than to any other, up to the grid's faces; a grid's only layer gets the thickness
/// of a cell.
fn around_nodes(image: &vtk::VtkImage) -> Lattice {
    let edges: [Vec<f64>; 3] = [0, 1, 2].map(|k| {
        let at = |i: f64| image.origin[k] + image.spacing[k] * i;
        match image.cells[k] {
            0 => vec![at(-0.5), at(0.5)],
            last => {
                let mut edges = vec![at(0.0)];
                edges.extend((0..last).map(|i| at(i as f64 + 0.5)));
                edges.push(at(last as f64));
                edges
            }
        }
    });
    Lattice { names: three(["x", "y", "z"]), edges, cells: (0..image.point_count() as u32).map(Some).collect() }
}

/// Volumes of all places of a lattice, the first coordinate fastest.
fn volumes(lattice: &Lattice) -> Vec<f64> {
    let widths = |k: usize| -> Vec<f64> { lattice.edges[k].windows(2).map(|pair| pair[1] - pair[0]).collect() };
    let [x, y, z] = [widths(0), widths(1), widths(2)];
    let rows = z.iter().flat_map(|c| y.iter().map(move |b| b * c));
    rows.flat_map(|area| x.iter().map(move |a| a * area)).collect()
}

fn from_stat(path: &Path, frame: i64) -> anyhow::Result<Table> {
    let mut file = read_stat(path)?;
    let grid = file.header.grid().map_err(|e| anyhow!("{}: {e}", path.display()))?;
    let block = file.blocks.swap_remove(place(path, frame, file.blocks.len())?);
    let columns = file.fields.iter().zip(block.data).map(|(f, data)| (f.name.clone(), f.components, data)).collect();
    let edges = [0, 1, 2].map(|k| (0..=grid.cells()[k]).map(|i| grid.plane(k, i)).collect());
    let count = grid.cell_count();
    let places = Lattice { names: three(["x", "y", "z"]), edges, cells: (0..count as u32).map(Some).collect() };
    let volumes = (0..count).map(|cell| grid.cell_volume(cell)).collect();
    Ok(Table { places: Places::Lattice(places), volumes, columns })
}

fn from_csv(path: &Path, field: &str) -> anyhow::Result<Table> {
    let table = CsvTable::read(path)?;
    if is_over_time(&table) {
        bail!(
            "{}: this is a table over time, as gauges.csv of fieldstone sph run, and no field on cells: info tells its columns, \
             and a program for tables plots them",
            path.display()
        );
    }
    let axes = if table.has("angle") { ["r", "angle", "height"] } else { ["x", "y", "z"] };
    let mut places = vec![[0; 3]; table.len()];
    let mut centres: [Vec<f64>; 3] = Default::default();
    for (k, axis) in axes.iter().enumerate() {
        let values = table.column(axis)?;
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.dedup();
        if sorted.is_empty() {
            bail!("{}: the table has no rows", path.display());
        }
        for (place, value) in places.iter_mut().zip(&values) {
            place[k] = sorted.partition_point(|x| x < value);
        }
        centres[k] = sorted;
    }
    let count = centres.iter().map(Vec::len).try_fold(1usize, |n, m| n.checked_mul(m));
    if count.is_none_or(|count| count > table.len()) {
        bail!("{}: the rows are those of a mesh, whose cells are not in the table; plot the .vtu", path.display());
    }
    let mut columns = Vec::new();
    for wanted in [field, &density_of(field)] {
        if columns.iter().any(|(name, ..): &(String, usize, Vec<f64>)| name == wanted) {
            continue;
        }
        let own = |name: &&String| {
            let suffix = name.strip_prefix(wanted).and_then(|rest| rest.strip_prefix('_'));
            suffix.is_some_and(|suffix| known_field(wanted).is_none_or(|known| known.components().contains(&suffix)))
        };
        let names: Vec<&String> = match table.names().iter().find(|name| *name == wanted) {
            Some(name) => vec![name],
            None => table.names().iter().filter(own).collect(),
        };
        let parts: Vec<Vec<f64>> = names.iter().map(|name| table.column(name)).collect::<Result<_, _>>()?;
        if !parts.is_empty() {
            let data = (0..table.len()).flat_map(|row| parts.iter().map(move |part| part[row])).collect();
            columns.push((wanted.to_string(), parts.len(), data));
        }
    }
    if !columns.iter().any(|(name, ..)| name == field) {
        bail!("{}: there is no field '{field}'; it has {}", path.display(), table.names().join(", "));
    }
    let volumes = if table.has("cell_volume") { table.column("cell_volume")? } else { vec![1.0; table.len()] };
    Ok(Table { places: Places::Lattice(Lattice::new(three(axes), centres, &places)), volumes, columns })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_lie_halfway_between_centres() {
        assert_eq!(edges_around(&[1.0, 2.0, 3.0]), [0.5, 1.5, 2.5, 3.5]);
        assert_eq!(edges_around(&[2.0]), [1.5, 2.5]);
    }

    #[test]
    fn a_field_of_a_species_goes_with_the_density_of_that_species() {
        for (field, density) in [
            ("velocity", "density"),
            ("velocity_species_2", "density_species_2"),
            ("VelocitySpecies12", "density_species_12"),
            ("my_species_of_grain", "density"),
        ] {
            assert_eq!(density_of(field), density);
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("two.csv");
        let names = "x,y,z,density,density_species_1,velocity_species_1_x,velocity_species_1_y,velocity_species_1_z";
        std::fs::write(&path, format!("{names}\n0,0,0,4,3,5,6,7\n1,0,0,2,0,0,0,0\n")).unwrap();
        let plotted = read(&path, "velocity_species_1", -1).unwrap();
        assert_eq!(plotted.density.as_deref(), Some(&[3.0, 0.0][..]));
        assert_eq!(
            (plotted.components, plotted.data),
            (vec!["x".into(), "y".into(), "z".into()], vec![5.0, 6.0, 7.0, 0.0, 0.0, 0.0])
        );
        assert_eq!(known_field("velocity_species_2"), Some(FieldName::Velocity));
        assert_eq!(known_field("ContactStressSpecies2"), Some(FieldName::ContactStress));
        assert_eq!(known_field("velocity_of_grain"), None);
    }
}
