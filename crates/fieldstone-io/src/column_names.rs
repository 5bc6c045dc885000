//! What the usual properties of particles are called, for all formats that name their columns.

/// Which names a file uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dialect {
    /// LIGGGHTS and LAMMPS: exact names, arrays as `name[1]`, `name[2]`, …
    Dump,
    /// Spreadsheets, scripts and VTK: letter case does not matter, vectors as `name:0` or `name_x`.
    Table,
}

/// Names that a dialect knows, in order of preference.
struct Naming {
    /// Coordinates, and whether they are fractions of the box.
    positions: &'static [([&'static str; 3], bool)],
    radii: &'static [&'static str],
    diameters: &'static [&'static str],
    types: &'static [&'static str],
}

const DUMP: Naming = Naming {
    positions: &[
        (["x", "y", "z"], false),
        (["xu", "yu", "zu"], false),
        (["xs", "ys", "zs"], true),
        (["xsu", "ysu", "zsu"], true),
    ],
    radii: &["radius"],
    diameters: &["diameter", "d"],
    types: &["type"],
};

const TABLE: Naming = Naming {
    positions: &[
        (["x", "y", "z"], false),
        (["px", "py", "pz"], false),
        (["points:0", "points:1", "points:2"], false),
        (["points_0", "points_1", "points_2"], false),
        (["position:0", "position:1", "position:2"], false),
        (["position_x", "position_y", "position_z"], false),
        (["pos_x", "pos_y", "pos_z"], false),
        (["pos.x", "pos.y", "pos.z"], false),
    ],
    radii: &["radius", "radii", "r", "rad"],
    diameters: &["diameter", "d", "diam"],
    types: &["type", "matid"],
};

/// Radii and diameters whose names say so; short ones beside them may be anything: r a distance from an axis, d one from a
/// wall.
const SPELT_OUT: (&[&str], &[&str]) = (&["radius", "radii", "rad"], &["diameter", "diam"]);

/// Standard names of vectors, and what arrays of three numbers are called.
const VECTORS: [(&str, &[&str]); 3] = [
    ("velocity", &["velocity", "v", "U", "Vel"]),
    ("force", &["force", "f"]),
    ("angular_velocity", &["angular_velocity", "omega"]),
];

/// Standard names of scalars, and what files call them.
const SCALARS: [(&str, &[&str]); 2] = [("mass", &["mass"]), ("density", &["density", "rho", "rhop"])];

/// Whether a quantity of this name is one that computations look for.
pub(crate) fn is_standard(name: &str) -> bool {
    VECTORS.iter().chain(&SCALARS).any(|(standard, _)| *standard == name)
}

/// Share by which a diameter may differ from twice the radius: files are written with few digits, and wrong columns are
/// off by factors.
const SIZES_AGREE: f64 = 1e-3;

/// Whether a diameter contradicts the radius beside it; NaN, for an empty field, says nothing against it.
pub(crate) fn sizes_differ(radius: f64, diameter: f64) -> bool {
    (diameter - 2.0 * radius).abs() > SIZES_AGREE * 2.0 * radius
}

/// Where the size of particles is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SizeColumn {
    pub(crate) column: usize,
    /// What makes a radius of its numbers.
    pub(crate) factor: f64,
    /// A column that states the diameter beside the radius.
    pub(crate) diameter: Option<usize>,
}

impl Dialect {
    fn naming(self) -> &'static Naming {
        match self {
            Self::Dump => &DUMP,
            Self::Table => &TABLE,
        }
    }

    fn is(self, name: &str, alias: &str) -> bool {
        // A capital is the name only as it stands: U is OpenFOAM's velocity, Vel DualSPHysics's; u may be a displacement.
        let exact = self == Self::Dump || alias.bytes().any(|b| b.is_ascii_uppercase());
        name == alias || (!exact && name.eq_ignore_ascii_case(alias))
    }

    /// The standard name of a column of scalars.
    pub(crate) fn scalar(self, name: &str) -> Option<&'static str> {
        let known = |(_, aliases): &(&str, &[&str])| aliases.iter().any(|alias| self.is(name, alias));
        SCALARS.iter().find(|entry| known(entry)).map(|(standard, _)| *standard)
    }

    /// The standard name of an array of vectors.
    pub(crate) fn vector(self, name: &str) -> Option<&'static str> {
        let known = |(_, aliases): &(&str, &[&str])| self == Self::Table && aliases.iter().any(|a| self.is(name, a));
        VECTORS.iter().find(|entry| known(entry)).map(|(standard, _)| *standard)
    }
}

/// The columns of a file of which the meaning is not decided yet.
#[derive(Debug, Clone)]
pub(crate) struct FreeColumns<'a> {
    dialect: Dialect,
    names: Vec<&'a str>,
    free: Vec<bool>,
}

impl<'a> FreeColumns<'a> {
    pub(crate) fn new(dialect: Dialect, names: impl IntoIterator<Item = &'a str>) -> Self {
        let names: Vec<&str> = names.into_iter().collect();
        Self { dialect, free: vec![true; names.len()], names }
    }

    /// Columns that have their meaning.
    pub(crate) fn take(&mut self, columns: impl IntoIterator<Item = usize>) {
        columns.into_iter().for_each(|column| self.free[column] = false);
    }

    /// Their places and names.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, &'a str)> {
        self.names.iter().copied().enumerate().filter(|&(column, _)| self.free[column])
    }

    /// The column of this name: one that is spelt so before one of other letter case.
    fn find(&self, alias: &str) -> Option<usize> {
        let exact = self.iter().find(|(_, name)| *name == alias);
        exact.or_else(|| self.iter().find(|(_, name)| self.dialect.is(name, alias))).map(|(column, _)| column)
    }

    fn any(&self, aliases: &[&str]) -> Option<usize> {
        aliases.iter().find_map(|alias| self.find(alias))
    }

    pub(crate) fn three(&self, aliases: &[&str; 3]) -> Option<[usize; 3]> {
        Some([self.find(aliases[0])?, self.find(aliases[1])?, self.find(aliases[2])?])
    }

    /// The coordinates, and whether they are fractions of the box.
    ///
    /// # Errors
    /// The sets that would do, as part of a sentence.
    pub(crate) fn positions(&self) -> Result<([usize; 3], bool), String> {
        let sets = self.dialect.naming().positions;
        sets.iter()
            .find_map(|(set, scaled)| Some((self.three(set)?, *scaled)))
            .ok_or_else(|| sets.iter().map(|(set, _)| set.join(" ")).collect::<Vec<_>>().join(", or "))
    }

    /// The radius, else the diameter.
    pub(crate) fn size(&self) -> Option<SizeColumn> {
        let Naming { radii, diameters, .. } = self.dialect.naming();
        let Some(column) = self.any(radii) else {
            return Some(SizeColumn { column: self.any(diameters)?, factor: 0.5, diameter: None });
        };
        let spelt_out = SPELT_OUT.0.iter().any(|name| self.names[column].eq_ignore_ascii_case(name));
        let diameter = if spelt_out { self.any(SPELT_OUT.1) } else { None };
        Some(SizeColumn { column, factor: 1.0, diameter })
    }

    pub(crate) fn id(&self) -> Option<usize> {
        self.find("id")
    }

    pub(crate) fn kind(&self) -> Option<usize> {
        self.any(self.dialect.naming().types)
    }

    /// Columns that bear other names than the standard ones, with those: the usual names of scalars.
    pub(crate) fn renamed_scalars(&self) -> Vec<(usize, &'static str)> {
        self.renamed(&SCALARS)
    }

    /// As [`FreeColumns::renamed_scalars`], where each column is an array of vectors.
    pub(crate) fn renamed_vectors(&self) -> Vec<(usize, &'static str)> {
        self.renamed(&VECTORS)
    }

    fn renamed(&self, known: &[(&'static str, &[&str])]) -> Vec<(usize, &'static str)> {
        // What has the standard name keeps it, whatever it is.
        let open = known.iter().filter(|(standard, _)| !self.names.contains(standard));
        open.filter_map(|(standard, aliases)| Some((self.any(aliases)?, *standard))).collect()
    }
}
