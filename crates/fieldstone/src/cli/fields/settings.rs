//! Everything that `fieldstone fields` can be told, on the command line or in a TOML file.

use std::fmt;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{anyhow, bail};
use clap::{Args, ValueEnum};
use fieldstone::fields::{ContactForm, KernelShape, MeanVelocity, Method, QuantityKind, SignConvention};
use fieldstone::io::vtk::{VtkCompression, VtkEncoding, VtkFormat};
use serde::de::{self, IntoDeserializer, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::contacts::ContactSources;
use crate::cli::arguments::positive;

/// Numbers: separated by commas on the command line, a list or the same text in TOML, or one number in either.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(transparent)]
pub(crate) struct Numbers<T>(pub Vec<T>);

impl<'de, T: Deserialize<'de> + FromStr> Deserialize<'de> for Numbers<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrMore<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de> + FromStr> Visitor<'de> for OneOrMore<T> {
            type Value = Numbers<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or a list of numbers")
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Self::Value, E> {
                T::deserialize(number.into_deserializer()).map(|one| Numbers(vec![one]))
            }

            fn visit_f64<E: de::Error>(self, number: f64) -> Result<Self::Value, E> {
                T::deserialize(number.into_deserializer()).map(|one| Numbers(vec![one]))
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<Self::Value, E> {
                text.parse().map_err(E::custom)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
                let mut numbers = Vec::new();
                while let Some(number) = list.next_element()? {
                    numbers.push(number);
                }
                Ok(Numbers(numbers))
            }
        }

        deserializer.deserialize_any(OneOrMore(PhantomData))
    }
}

/// Text in TOML, where the command line takes one number as it stands: `frames = 3`.
fn text_or_whole<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    deserializer.deserialize_any(TextOrNumber { whole: true })
}

/// The same with any number: `parcel-weight = 2.5`.
fn text_or_number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    deserializer.deserialize_any(TextOrNumber { whole: false })
}

struct TextOrNumber {
    whole: bool,
}

impl Visitor<'_> for TextOrNumber {
    type Value = Option<String>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.whole { "a string or a whole number" } else { "a string or a number" })
    }

    fn visit_f64<E: de::Error>(self, number: f64) -> Result<Self::Value, E> {
        if self.whole {
            return Err(E::invalid_type(de::Unexpected::Float(number), &self));
        }
        Ok(Some(number.to_string()))
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<Self::Value, E> {
        Ok(Some(number.to_string()))
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Self::Value, E> {
        Ok(Some(text.into()))
    }
}

/// Text with commas, or in TOML also a list of the words between them: `fields = ["density", "velocity"]`.
fn text_or_texts<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    struct TextOrTexts;

    impl<'de> Visitor<'de> for TextOrTexts {
        type Value = Option<String>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a string or a list of strings")
        }

        fn visit_str<E: de::Error>(self, text: &str) -> Result<Self::Value, E> {
            Ok(Some(text.into()))
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
            let mut words: Vec<String> = Vec::new();
            while let Some(word) = list.next_element()? {
                words.push(word);
            }
            Ok(Some(words.join(",")))
        }
    }

    deserializer.deserialize_any(TextOrTexts)
}

impl<T: FromStr> FromStr for Numbers<T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |word: &str| {
            let word = word.trim();
            word.parse::<T>().map_err(|_| format!("'{word}' stands where a number is expected"))
        };
        text.split(',').map(number).collect::<Result<_, _>>().map(Self)
    }
}

impl<T: Copy> Numbers<T> {
    /// Exactly `N` of them.
    pub fn exactly<const N: usize>(&self, option: &str) -> anyhow::Result<[T; N]> {
        <[T; N]>::try_from(self.0.as_slice())
            .map_err(|_| anyhow!("--{option}: {} numbers were found; give {N}, separated by commas", self.0.len()))
    }
}

/// How cells see particles, by name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum FunctionName {
    Overlap(Method),
    Kernel(KernelShape),
}

impl FromStr for FunctionName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "exact" {
            return Ok(Self::Overlap(Method::Kernel));
        }
        text.parse().map(Self::Kernel).or_else(|_| text.parse().map(Self::Overlap)).map_err(|_| {
            format!(
                "there is no function '{text}'; choose exact, gauss, lucy, heaviside or linear, or one of the \
                 approximations of the overlap that fraction --method has"
            )
        })
    }
}

impl fmt::Display for FunctionName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Overlap(Method::Kernel) => f.write_str("exact"),
            Self::Overlap(method) => method.fmt(f),
            Self::Kernel(shape) => shape.fmt(f),
        }
    }
}

/// A field of any columns: `NAME=COLUMNS[:sum|mass-mean|volume-mean]`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct QuantityName {
    pub name: String,
    pub columns: Vec<String>,
    pub kind: QuantityKind,
}

const KINDS: [(&str, QuantityKind); 3] =
    [("sum", QuantityKind::Sum), ("mass-mean", QuantityKind::MassMean), ("volume-mean", QuantityKind::VolumeMean)];

impl FromStr for QuantityName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("'{text}' is not of the form NAME=COLUMNS[:sum|mass-mean|volume-mean]");
        let (name, rest) = text.split_once('=').ok_or_else(wrong)?;
        let (columns, kind) = match rest.rsplit_once(':') {
            Some((columns, kind)) if KINDS.iter().any(|(known, _)| *known == kind) => (columns, kind),
            // Names of columns may hold a colon: `stress:0`.
            _ => (rest, "sum"),
        };
        let kind = KINDS.iter().find(|(known, _)| *known == kind).map_or(QuantityKind::Sum, |(_, kind)| *kind);
        let columns: Vec<String> = columns.split(',').map(|column| column.trim().to_string()).collect();
        if name.trim().is_empty() || columns.iter().any(String::is_empty) {
            return Err(wrong());
        }
        Ok(Self { name: name.trim().into(), columns, kind })
    }
}

impl QuantityName {
    /// What a colon in the last column's name may have been meant for.
    pub fn kind_hint(&self) -> String {
        let kind = self.columns.last().and_then(|column| column.rsplit_once(':')).map(|(_, kind)| kind.trim());
        kind.map_or(String::new(), |kind| {
            let known: Vec<&str> = KINDS.iter().map(|(name, _)| *name).collect();
            format!("; if '{kind}' is no part of a column's name, choose one of {}", known.join(", "))
        })
    }
}

impl fmt::Display for QuantityName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = KINDS.iter().find(|(_, kind)| *kind == self.kind).map_or("sum", |(name, _)| *name);
        write!(f, "{}={}:{kind}", self.name, self.columns.join(","))
    }
}

/// Values that are written as text in TOML, as on the command line.
macro_rules! as_text {
    ($($type:ty),*) => {$(
        impl Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
            }
        }
    )*};
}

as_text!(FunctionName, QuantityName);

/// Names on the command line for what the library knows under others.
macro_rules! choice {
    ($(#[$doc:meta])* $name:ident for $target:ty { $($(#[$variant_doc:meta])* $variant:ident => $value:expr),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub(crate) enum $name {
            $($(#[$variant_doc])* $variant),*
        }

        impl From<$name> for $target {
            fn from(name: $name) -> Self {
                match name { $($name::$variant => $value),* }
            }
        }
    };
}

choice!(StressForm for ContactForm {
    /// at the particles, with their weights
    ParticleCentred => ContactForm::ParticleCentred,
    /// the kernel averaged along the branch
    LineIntegral => ContactForm::LineIntegral,
    /// the part of the branch's length in the cell
    BranchInCell => ContactForm::BranchInCell,
});

choice!(Sign for SignConvention {
    /// compression is positive
    Compression => SignConvention::CompressionPositive,
    /// tension is positive
    Tension => SignConvention::TensionPositive,
});

choice!(Mean for MeanVelocity {
    /// of all frames that are averaged
    Window => MeanVelocity::Window,
    /// of each frame
    Frame => MeanVelocity::Frame,
});

choice!(Encoding for VtkEncoding {
    /// compressed by zlib: smallest, and read by everything; slow where cells are many
    Zlib => VtkEncoding::default(),
    /// compressed by LZ4: as fast as bytes as they are, and empty cells take no place; not read by meshio
    Lz4 => VtkEncoding { format: VtkFormat::AppendedRaw, compression: VtkCompression::Lz4, ..VtkEncoding::default() },
    /// bytes as they are: largest
    Raw => VtkEncoding { format: VtkFormat::AppendedRaw, compression: VtkCompression::None, ..VtkEncoding::default() },
    /// text
    Text => VtkEncoding::TEXT,
});

choice!(Switch for bool {
    On => true,
    Off => false,
});

/// All settings; each may be left out.
#[derive(Debug, Clone, Default, PartialEq, Args, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub(crate) struct Settings {
    /// Particles: LIGGGHTS or LAMMPS dump, MercuryDPM .data, CSV, VTK, …; .gz too; a pattern in quotes for a series
    #[arg(long, value_name = "FILE")]
    pub particles: Option<String>,
    #[command(flatten)]
    #[serde(skip_serializing_if = "no_contacts")]
    pub contacts: ContactSources,
    /// MercuryDPM's .restart file, which has the densities and the periodic directions
    #[arg(long, value_name = "FILE")]
    pub restart: Option<PathBuf>,
    /// Density of all particles, in place of the file's masses
    #[arg(long, value_name = "ρ", value_parser = positive, allow_negative_numbers = true, conflicts_with = "mass_column")]
    pub density: Option<f64>,
    /// Column that holds the masses [default: mass, else density]
    #[arg(long, value_name = "NAME")]
    pub mass_column: Option<String>,
    /// Real particles per simulated one: a number, or the name of a column, such as OpenFOAM's nParticle
    ///
    /// Every sum over particles counts a parcel as so many particles, each of its radius, mass and velocity. Without
    /// contacts only, since what one between parcels stands for is not known.
    #[arg(long, value_name = "COLUMN|W", allow_negative_numbers = true, conflicts_with = "contacts")]
    #[serde(deserialize_with = "text_or_number")]
    pub parcel_weight: Option<String>,
    /// Radius of all particles, in place of the file's
    #[arg(long, value_name = "R", value_parser = positive, allow_negative_numbers = true)]
    pub radius: Option<f64>,
    /// Treat superquadrics, ellipsoids and members of clumps as balls of the radius that the file gives
    #[arg(long, num_args = 0, default_missing_value = "true")]
    pub allow_non_spherical: Option<bool>,
    /// Mesh: an OpenFOAM case or polyMesh folder, Gmsh .msh, VTK .vtu or .vtk
    #[arg(long, value_name = "MESH", conflicts_with_all = ["grid", "cells", "coordinates"])]
    pub mesh: Option<PathBuf>,
    /// Bounds of the grid: XMIN,XMAX,YMIN,YMAX,ZMIN,ZMAX [default: the box, else the first frame's particles]
    ///
    /// The default for a tilted box is one period of it, upright, along its periodic axes. Where the files state no box, a warning
    /// tells the bounds of the first frame's particles, and the settings that the result repeats hold them. For cylindrical coordinates RMIN,RMAX,ZMIN,ZMAX, heights along the axis from --origin.
    #[arg(long, value_name = "BOUNDS", allow_hyphen_values = true)]
    pub grid: Option<Numbers<f64>>,
    /// Cells of the grid along its resolved directions, or one number for all of them, e.g. 10,10,20 or 20
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub cells: Option<Numbers<usize>>,
    /// Resolved directions: O (none), X, Y, Z, XY, XZ, YZ, XYZ, or around an axis R, RZ, RTZ [default: XYZ]
    #[arg(long, value_name = "NAME")]
    pub coordinates: Option<String>,
    /// Axis of cylindrical coordinates: x, y or z [default: z]
    #[arg(long, value_name = "AXIS")]
    pub axis: Option<String>,
    /// A point on the axis, where heights are 0 [default: the middle of the box's lower end]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub origin: Option<Numbers<f64>>,
    /// exact (volume of the particle in the cell), or a kernel at the cell's centre: gauss, lucy, heaviside, linear
    /// [default: exact]
    #[arg(long, value_name = "NAME")]
    pub function: Option<FunctionName>,
    /// Width of the kernel: a Gaussian's standard deviation, else where the kernel ends
    #[arg(long, value_name = "W", value_parser = positive, allow_negative_numbers = true)]
    pub width: Option<f64>,
    /// Where a Gaussian is cut off; other kernels end at their width [default: 3 widths]
    #[arg(long, value_name = "C", value_parser = positive, allow_negative_numbers = true)]
    pub cutoff: Option<f64>,
    /// Scale each particle's kernel values so that they conserve mass
    #[arg(long, num_args = 0, default_missing_value = "true")]
    pub conserve: Option<bool>,
    /// standard (MercuryCG's 29 columns), binning, all, or names separated by commas [default: standard]
    ///
    /// The default and all leave out what needs contacts or velocities where there are none, and all what needs spins. docs/coarse-graining.md has all names with
    /// their formulas.
    #[arg(long, value_name = "LIST")]
    #[serde(deserialize_with = "text_or_texts")]
    pub fields: Option<String>,
    /// Field of any columns that the particles have; may be repeated
    ///
    /// sum is Σ φ q, a density; mass-mean and volume-mean are means of q. COLUMNS are one name of a scalar, vector or
    /// tensor, or 1, 3, 6 or 9 names of scalars, as the file has them (vx, c_st[1]) or as velocity[1]: components count from 1.
    #[arg(long = "quantity", value_name = "NAME=COLUMNS[:sum|mass-mean|volume-mean]")]
    #[serde(rename = "quantity", skip_serializing_if = "Vec::is_empty")]
    pub quantities: Vec<QuantityName>,
    /// How contacts are spread over cells [default: particle-centred for overlaps, line-integral for kernels]
    #[arg(long, value_enum, value_name = "FORM")]
    pub stress_form: Option<StressForm>,
    /// Sign of stresses [default: compression]
    #[arg(long, value_enum, value_name = "SIGN")]
    pub sign: Option<Sign>,
    /// Whether the contact force density counts forces of walls [default: on]
    #[arg(long, value_enum, value_name = "ON|OFF")]
    pub walls: Option<Switch>,
    /// Mean velocity that fluctuations are measured from, where frames are averaged [default: window]
    #[arg(long, value_enum, value_name = "WHICH")]
    pub mean_velocity: Option<Mean>,
    /// Acceleration of gravity: adds the field body_force_density = ρ g, and the weight to the account
    #[arg(long, value_name = "GX,GY,GZ", allow_hyphen_values = true)]
    pub gravity: Option<Numbers<f64>>,
    /// Types (species) that count; the others act like walls
    #[arg(long, value_name = "TYPES", allow_hyphen_values = true)]
    pub species: Option<Numbers<i64>>,
    /// Beside each field the same of every type (species) by itself, as density_species_2
    ///
    /// The types are those of --species, else those of the first frame.
    #[arg(long, num_args = 0, default_missing_value = "true")]
    pub per_species: Option<bool>,
    /// Least and largest radius of the particles that count
    #[arg(long, value_name = "RMIN,RMAX")]
    pub radii: Option<Numbers<f64>>,
    /// Box that holds the centres of the particles that count
    #[arg(long, value_name = "XMIN,XMAX,YMIN,YMAX,ZMIN,ZMAX", allow_hyphen_values = true)]
    pub region: Option<Numbers<f64>>,
    /// Periodic directions: auto (those of the file, where the cells do not reach beyond the box), none, or e.g. xy
    /// [default: auto]
    ///
    /// auto in a tilted box: where the cells are no wider than the box.
    #[arg(long, value_name = "AXES")]
    pub periodic: Option<String>,
    /// The simulation's box, in place of that of the files; --periodic says along which axes it is periodic
    ///
    /// Where the file of the particles states no box, that of a dump of contacts is taken.
    #[arg(long = "box", value_name = "XMIN,XMAX,YMIN,YMAX,ZMIN,ZMAX", allow_hyphen_values = true)]
    #[serde(rename = "box")]
    pub bounds: Option<Numbers<f64>>,
    /// Frames START:STOP:STEP as in Python, from 0, negative ones from the end
    ///
    /// Default: all for .pvd, .stat, --average and --smooth; else the last one.
    #[arg(long, value_name = "RANGE", allow_hyphen_values = true)]
    #[serde(deserialize_with = "text_or_whole")]
    pub frames: Option<String>,
    /// One result: the mean over the frames
    #[arg(long, num_args = 0, default_missing_value = "true", conflicts_with = "smooth")]
    pub average: Option<bool>,
    /// Gaussian mean over time of this standard deviation, around each frame; for one result around the middle
    #[arg(long, value_name = "W", value_parser = positive, allow_negative_numbers = true)]
    pub smooth: Option<f64>,
    /// Time per step, for files that state steps and no times [default: 1]
    ///
    /// Where files state neither, the number that rises in their names is the step, as in part_26000.vtk, else their place.
    #[arg(long, value_name = "DT", value_parser = positive, allow_negative_numbers = true)]
    pub timestep: Option<f64>,
    /// Result: .vti (grid), .vtu (mesh), .pvd (one of them per frame), .csv, or .stat (MercuryCG's layout)
    #[arg(short, long, value_name = "OUT")]
    pub out: Option<PathBuf>,
    /// How .vti, .vtu and .vtp files keep their numbers [default: lz4 for grids, zlib for meshes]
    #[arg(long, value_enum, value_name = "HOW")]
    pub encoding: Option<Encoding>,
    /// Also write what crosses the cells' faces, as polygons: .vtp, or .pvd with a file for each frame
    ///
    /// Grids and meshes only. contact_force, the force that contacts carry through a face along its normal, and the same
    /// over its area, contact_traction; solid_flux, the solid volume per time. They close the balances of momentum and
    /// solid volume of every cell. All particles count, whatever is selected.
    #[arg(long, value_name = "FILE")]
    pub face_fields: Option<PathBuf>,
    /// Also write the particles with the means of the fields over each of them, as field_density: .vtp, .csv, or .pvd
    ///
    /// By the same overlaps that made the fields; fraction_in_cells is the part of a particle that lies in cells.
    #[arg(long, value_name = "FILE")]
    pub to_particles: Option<PathBuf>,
    /// Also write the account as JSON; - is standard output, and the report then goes to standard error
    ///
    /// Keys: mass_in, mass_binned, mass_clipped, momentum_in, momentum_binned, stress_sum_contacts, stress_sum_fields,
    /// balance_residual, frames, seconds; particles, contacts, cells.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

fn no_contacts(contacts: &ContactSources) -> bool {
    contacts.0.is_empty()
}

impl Settings {
    /// Reads a TOML file.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| anyhow!("{}: cannot read: {e}", path.display()))?;
        toml::from_str(&text).map_err(|error| {
            let line = error.span().map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count());
            let place = line.map_or(String::new(), |line| format!(":{line}"));
            let message = error.message();
            // They follow their --contacts on the command line, and stand beside its file here.
            let remedy = if ["contacts-preset", "contacts-columns"]
                .iter()
                .any(|key| message.contains(&format!("field `{key}`")))
            {
                "; write [[contacts]], and below it file = \"NAME\" with preset = \"NAME\" or columns = \"MAP\""
            } else {
                ""
            };
            anyhow!("{}{place}: {}{remedy}", path.display(), message.replace("unknown field", "unknown key"))
        })
    }

    /// These settings, and those of `file` where these say nothing.
    pub fn or(self, file: Self) -> Self {
        macro_rules! either {
            ($($field:ident)*) => {
                Self {
                    contacts: if self.contacts.0.is_empty() { file.contacts } else { self.contacts },
                    quantities: if self.quantities.is_empty() { file.quantities } else { self.quantities },
                    $($field: self.$field.or(file.$field)),*
                }
            };
        }
        either!(particles restart density mass_column parcel_weight radius allow_non_spherical mesh grid cells coordinates axis origin
            function width cutoff conserve fields stress_form sign walls mean_velocity gravity species per_species radii region
            periodic bounds frames average smooth timestep out encoding face_fields to_particles json)
    }

    /// These settings of the command line before those of `file`, of which the kernel's go where the command line asks for
    /// overlaps instead, and the cut-off where it asks for a kernel that has none.
    pub fn before(self, mut file: Self) -> Self {
        match self.function {
            Some(FunctionName::Overlap(_)) => (file.width, file.cutoff, file.conserve) = (None, None, None),
            Some(FunctionName::Kernel(shape)) if shape != KernelShape::Gauss => file.cutoff = None,
            _ => {}
        }
        self.or(file)
    }

    /// Whether the cells lie around an axis.
    pub fn is_cylindrical(&self) -> bool {
        let name = self.coordinates.as_deref().map(str::to_ascii_uppercase);
        matches!(name.as_deref(), Some("R" | "RZ" | "RTZ"))
    }

    /// What clap refuses on the command line may come from a file.
    pub fn check(&self) -> anyhow::Result<()> {
        let positive = [
            ("density", self.density),
            ("radius", self.radius),
            ("width", self.width),
            ("cutoff", self.cutoff),
            ("smooth", self.smooth),
            ("timestep", self.timestep),
        ];
        for (name, value) in positive {
            if let Some(value) = value.filter(|v| !(*v > 0.0 && v.is_finite())) {
                bail!("--{name} is {value}; give a finite number above 0");
            }
        }
        let exclusive = [
            ("density", self.density.is_some(), "mass-column", self.mass_column.is_some()),
            ("contacts", !self.contacts.0.is_empty(), "parcel-weight", self.parcel_weight.is_some()),
            ("mesh", self.mesh.is_some(), "grid", self.grid.is_some()),
            ("mesh", self.mesh.is_some(), "cells", self.cells.is_some()),
            ("mesh", self.mesh.is_some(), "coordinates", self.coordinates.is_some()),
            ("average", self.average == Some(true), "smooth", self.smooth.is_some()),
        ];
        match exclusive.iter().find(|(_, a, _, b)| *a && *b) {
            Some((a, _, b, _)) => bail!("--{a} and --{b} exclude each other; leave one of them out"),
            None => Ok(()),
        }
    }

    /// The settings as TOML, with the defaults that matter filled in.
    pub fn echo(&self) -> anyhow::Result<String> {
        let mut all = self.clone();
        let function = *all.function.get_or_insert(FunctionName::Overlap(Method::Kernel));
        all.fields.get_or_insert_with(|| "standard".into());
        all.sign.get_or_insert(Sign::Compression);
        all.stress_form.get_or_insert(match function {
            FunctionName::Overlap(_) => StressForm::ParticleCentred,
            FunctionName::Kernel(_) => StressForm::LineIntegral,
        });
        all.periodic.get_or_insert_with(|| "auto".into());
        let version = env!("CARGO_PKG_VERSION");
        Ok(format!("# fieldstone {version}: fieldstone fields with these settings\n{}", toml::to_string(&all)?))
    }
}
