//! Fields on cells: `volScalarField` and its kin.

use std::io::Write;
use std::path::{Path, PathBuf};

use fieldstone_mesh::Patch;

use crate::{AtomicFile, IoError, Position};

use super::list::Item;
use super::stream::Stream;

/// Exponents of a physical unit: mass, length, time, temperature, amount of substance, current, luminous intensity.
///
/// ```
/// use fieldstone_io::openfoam::Dimensions;
/// assert_eq!(Dimensions::VELOCITY.to_string(), "[0 1 -1 0 0 0 0]");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dimensions(pub [f64; 7]);

impl Dimensions {
    /// A fraction, a count.
    pub const NONE: Self = Self([0.0; 7]);
    /// Mass per volume.
    pub const DENSITY: Self = Self([1.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    /// Length per time.
    pub const VELOCITY: Self = Self([0.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0]);
    /// Momentum per volume.
    pub const MOMENTUM_DENSITY: Self = Self([1.0, -2.0, -1.0, 0.0, 0.0, 0.0, 0.0]);
    /// Force per area: pressure and stress.
    pub const PRESSURE: Self = Self([1.0, -1.0, -2.0, 0.0, 0.0, 0.0, 0.0]);
}

impl std::fmt::Display for Dimensions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let exponents: Vec<String> = self.0.iter().map(f64::to_string).collect();
        write!(f, "[{}]", exponents.join(" "))
    }
}

/// How a written field stores its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FieldEncoding {
    /// Text, with the fewest digits that give back the same number.
    #[default]
    Text,
    /// Little-endian 64-bit floats.
    Binary,
}

/// A field on cells, to be written by [`write_vol_field`].
#[derive(Debug, Clone, Copy)]
pub struct VolField<'a> {
    /// Name, which is the file's: `alpha.solids`, `voidfraction`, `U.solids`.
    pub name: &'a str,
    /// Unit.
    pub dimensions: Dimensions,
    /// Numbers per cell: 1 scalar, 3 vector, 6 symmetric tensor (xx xy xz yy yz zz), 9 tensor.
    pub components: usize,
    /// `components` numbers per cell, cell by cell.
    pub values: &'a [f64],
}

/// Class of a field, and that of one value.
fn classes(components: usize) -> Option<(&'static str, &'static str)> {
    Some(match components {
        1 => ("volScalarField", "scalar"),
        3 => ("volVectorField", "vector"),
        6 => ("volSymmTensorField", "symmTensor"),
        9 => ("volTensorField", "tensor"),
        _ => return None,
    })
}

/// Boundary condition on a patch of this kind: the kind itself where OpenFOAM accepts no other.
///
/// None of them needs a value: OpenFOAM takes that of the cells beside.
fn condition(kind: &str) -> &str {
    // Forks have coupled patches of their own, and all of them are constraints: cyclicPeriodicAMI, cyclicRepeatAMI, …
    let coupled = kind.starts_with("cyclic") || kind.starts_with("processor");
    let constraint = matches!(
        kind,
        "empty"
            | "wedge"
            | "symmetry"
            | "symmetryPlane"
            | "nonuniformTransformCyclic"
            | "nonConformalCyclic"
            | "nonConformalError"
            | "nonConformalProcessorCyclic"
            | "overset"
    );
    if coupled || constraint { kind } else { "zeroGradient" }
}

/// Writes a field on cells into a time folder, `CASE/0` say, and returns the file's path.
///
/// The time folder is made where it is missing; the case must exist. `cells` and `patches` are those of the mesh that
/// OpenFOAM will read the field with. Each patch gets `zeroGradient`, or its own kind where it is a constraint
/// (`empty`, `cyclic…`, `processor…`, `symmetry`, `wedge`, `nonConformalCyclic`, `overset`, …).
///
/// # Errors
/// [`IoError::Content`] where the name is no OpenFOAM word, the number of values is not `components` (1, 3, 6 or 9)
/// times `cells`, or a value is NaN or infinite, which OpenFOAM cannot read; [`IoError::System`] where the file cannot
/// be written.
///
/// ```
/// use fieldstone_io::openfoam::{Dimensions, FieldEncoding, VolField, read_internal_field, write_vol_field};
/// # let case = tempfile::tempdir().unwrap();
/// let field = VolField { name: "alpha.solids", dimensions: Dimensions::NONE, components: 1, values: &[0.25, 0.6] };
/// let file = write_vol_field(&case.path().join("0"), &field, 2, &[], FieldEncoding::Text)?;
/// assert_eq!(read_internal_field(&file)?.values(2)?, [0.25, 0.6]);
/// # Ok::<(), fieldstone_io::IoError>(())
/// ```
pub fn write_vol_field(
    time_folder: &Path,
    field: &VolField<'_>,
    cells: usize,
    patches: &[Patch],
    encoding: FieldEncoding,
) -> Result<PathBuf, IoError> {
    let path = time_folder.join(field.name);
    let refuse = |found: String, remedy: &str| Err(IoError::content(&path, Position::File, found, remedy));
    let forbidden = |c: char| c.is_whitespace() || c.is_control() || "\"'/\\;{}()[]$#".contains(c);
    if field.name.is_empty() || field.name.starts_with('.') || field.name.contains(forbidden) {
        return refuse(
            format!("'{}' cannot be the name of a field", field.name),
            "use letters, digits, '.', '_' and '-'",
        );
    }
    let Some((class, item)) = classes(field.components) else {
        return refuse(
            format!("a field with {} numbers per cell has no OpenFOAM class", field.components),
            "1, 3, 6 or 9 numbers per cell can be written",
        );
    };
    if cells.checked_mul(field.components) != Some(field.values.len()) {
        return refuse(
            format!("{} numbers were given for {cells} cells with {} each", field.values.len(), field.components),
            "pass the values of all cells of the mesh",
        );
    }
    if let Some(k) = field.values.iter().position(|v| !v.is_finite()) {
        return refuse(
            format!("cell {} has the value {}", k / field.components, field.values[k]),
            "OpenFOAM reads finite numbers only: replace the value, by 0 where a cell holds no particle",
        );
    }
    if !time_folder.is_dir() {
        std::fs::create_dir(time_folder).map_err(|source| IoError::System {
            path: time_folder.into(),
            action: "create",
            source,
        })?;
    }
    let location = time_folder.canonicalize().ok().and_then(|p| Some(p.file_name()?.to_string_lossy().into_owned()));
    AtomicFile::write(&path, |out| {
        writeln!(out, "FoamFile\n{{")?;
        writeln!(out, "    version     2.0;")?;
        match encoding {
            FieldEncoding::Text => writeln!(out, "    format      ascii;")?,
            FieldEncoding::Binary => {
                writeln!(out, "    format      binary;\n    arch        \"LSB;label=32;scalar=64\";")?;
            }
        }
        writeln!(out, "    class       {class};")?;
        if let Some(location) = location {
            writeln!(out, "    location    \"{location}\";")?;
        }
        writeln!(out, "    object      {};\n}}\n", field.name)?;
        writeln!(out, "dimensions      {};\n", field.dimensions)?;
        writeln!(out, "internalField   nonuniform List<{item}>\n{cells}")?;
        write_values(out, field, encoding)?;
        writeln!(out, ";\n\nboundaryField\n{{")?;
        for patch in patches {
            let quote = if patch.name.contains(forbidden) { "\"" } else { "" };
            writeln!(out, "    {quote}{}{quote}\n    {{", patch.name)?;
            writeln!(out, "        type            {};\n    }}", condition(&patch.kind))?;
        }
        writeln!(out, "}}")
    })?;
    Ok(path)
}

fn write_values(out: &mut dyn Write, field: &VolField<'_>, encoding: FieldEncoding) -> std::io::Result<()> {
    match encoding {
        FieldEncoding::Binary => {
            out.write_all(b"(")?;
            for v in field.values {
                out.write_all(&v.to_le_bytes())?;
            }
        }
        // `{:?}` writes the shortest digits that read back the same, with an exponent where that is shorter.
        FieldEncoding::Text if field.components == 1 => {
            writeln!(out, "(")?;
            for v in field.values {
                writeln!(out, "{v:?}")?;
            }
        }
        FieldEncoding::Text => {
            writeln!(out, "(")?;
            for cell in field.values.chunks_exact(field.components) {
                for (k, v) in cell.iter().enumerate() {
                    write!(out, "{}{v:?}", if k == 0 { '(' } else { ' ' })?;
                }
                writeln!(out, ")")?;
            }
        }
    }
    out.write_all(b")")
}

/// Values of a field on cells as its file states them.
#[derive(Debug, Clone, PartialEq)]
pub enum InternalValues {
    /// One value for all cells, `components` numbers.
    Uniform(Vec<f64>),
    /// `components` numbers per cell, cell by cell.
    Nonuniform(Vec<f64>),
}

/// What [`read_internal_field`] reads from a field's file.
#[derive(Debug, Clone, PartialEq)]
pub struct InternalField {
    /// File.
    pub path: PathBuf,
    /// Class, `volScalarField` say.
    pub class: String,
    /// Unit; `None` where the file does not write it as numbers.
    pub dimensions: Option<Dimensions>,
    /// Numbers per cell.
    pub components: usize,
    /// Values inside the mesh.
    pub internal: InternalValues,
}

impl InternalField {
    /// Values of a mesh of `cells` cells, a uniform one repeated.
    ///
    /// # Errors
    /// [`IoError::Content`] where the file has values for another number of cells.
    pub fn values(&self, cells: usize) -> Result<Vec<f64>, IoError> {
        match &self.internal {
            InternalValues::Uniform(value) => Ok(value.repeat(cells)),
            InternalValues::Nonuniform(values) if values.len() == cells * self.components => Ok(values.clone()),
            InternalValues::Nonuniform(values) => Err(IoError::content(
                &self.path,
                Position::File,
                format!("the field has values for {} cells, but the mesh has {cells}", values.len() / self.components),
                "the field and the mesh may come from different cases or time steps",
            )),
        }
    }
}

/// Reads the unit and the internal values of a field on cells; its boundary is not looked at.
///
/// # Errors
/// [`IoError`] with line or byte: no field, a class other than `vol…Field` of scalars, vectors and tensors, macros
/// (`$name`, `#calc`), a damaged list.
pub fn read_internal_field(path: &Path) -> Result<InternalField, IoError> {
    let mut stream = Stream::open(path)?;
    let class = stream.header().class.clone();
    let components = match class.trim_end_matches("::Internal") {
        "volScalarField" => 1,
        "volVectorField" => 3,
        "volSymmTensorField" => 6,
        "volTensorField" => 9,
        _ => {
            return Err(stream.error_at(
                0,
                format!("the header says 'class {class}'"),
                "fields on cells are readable: volScalarField, volVectorField, volSymmTensorField, volTensorField",
            ));
        }
    };
    let mut dimensions = None;
    loop {
        if stream.peek().is_none() {
            return Err(stream
                .error("the file has no internalField", "give a field on cells, as a solver or setFields writes it"));
        }
        match stream.word()?.as_str() {
            "dimensions" => {
                dimensions = read_dimensions(&mut stream)?;
                stream.skip_value()?;
            }
            // The second name is that of fields without a boundary.
            "internalField" | "value" => {
                let internal = match components {
                    1 => read_internal::<f64>(&mut stream, |v| vec![v])?,
                    3 => read_internal::<[f64; 3]>(&mut stream, |v| v.to_vec())?,
                    6 => read_internal::<[f64; 6]>(&mut stream, |v| v.to_vec())?,
                    _ => read_internal::<[f64; 9]>(&mut stream, |v| v.to_vec())?,
                };
                return Ok(InternalField { path: path.into(), class, dimensions, components, internal });
            }
            directive if directive.starts_with('#') => {
                stream.word_or_string()?;
            }
            _ => stream.skip_value()?,
        }
    }
}

/// `[0 1 -1 0 0 0 0]`, or five numbers; `None` for unit names.
fn read_dimensions(stream: &mut Stream) -> Result<Option<Dimensions>, IoError> {
    let start = stream.at;
    stream.expect(b'[', "dimensions")?;
    let mut exponents = [0.0; 7];
    let mut count = 0;
    while stream.peek().is_some_and(|b| b != b']') {
        match stream.scalar() {
            Ok(value) if count < 7 => exponents[count] = value,
            _ => {
                stream.at = start;
                return Ok(None);
            }
        }
        count += 1;
    }
    stream.expect(b']', "dimensions")?;
    Ok((count == 5 || count == 7).then_some(Dimensions(exponents)))
}

fn read_internal<T: Item>(stream: &mut Stream, numbers: impl Fn(T) -> Vec<f64>) -> Result<InternalValues, IoError> {
    if matches!(stream.peek(), Some(b'$' | b'#')) {
        return Err(stream.error(
            format!("internalField is the macro {}", stream.describe_next()),
            "macros are not evaluated: write the value itself, or let foamDictionary -expand do it",
        ));
    }
    match stream.word()?.as_str() {
        "uniform" => {
            if matches!(stream.peek(), Some(b'$' | b'#')) {
                return Err(stream.error(
                    format!("the uniform value is the macro {}", stream.describe_next()),
                    "macros are not evaluated: write the value itself, or let foamDictionary -expand do it",
                ));
            }
            Ok(InternalValues::Uniform(numbers(T::from_text(stream)?)))
        }
        "nonuniform" => {
            while stream.peek().is_some_and(|b| b.is_ascii_alphabetic()) {
                stream.word()?;
            }
            let mut values = Vec::new();
            // One value for N cells is as good as a uniform field, whatever N is.
            let start = stream.at;
            if let super::list::ListStart::Uniform(_) = stream.list_start("values", true)? {
                return Ok(InternalValues::Uniform(numbers(T::from_text(stream)?)));
            }
            stream.at = start;
            stream.each("values", 0, |_, item: T| {
                values.extend(numbers(item));
                Ok(())
            })?;
            Ok(InternalValues::Nonuniform(values))
        }
        other => Err(stream.error(
            format!("internalField is '{other}'"),
            "expected 'uniform' and a value, or 'nonuniform' and a list",
        )),
    }
}
