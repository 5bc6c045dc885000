//! What the columns of a text file mean.
//!
//! Dumps, tables, XYZ and MercuryDPM files differ in how they name columns; from the names on they share
//! this code.

use std::collections::BTreeMap;

use fieldstone_particles::Particles;

use crate::assembly::{Fault, Row};
use crate::column_names::{Dialect, FreeColumns, SizeColumn, is_standard};
use crate::lines::{integer, number, shown, skip_blanks, words};

/// How a column is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cell {
    Number,
    Id,
    Type,
    /// Passed over: names of elements and the like.
    Text,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Group {
    pub(crate) name: String,
    pub(crate) columns: Vec<usize>,
}

/// The meaning of each column.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Columns {
    pub(crate) names: Vec<String>,
    pub(crate) cells: Vec<Cell>,
    /// Columns without which there is no particle: they may not be empty.
    needed: Vec<bool>,
    pub(crate) position: [usize; 3],
    scaled: bool,
    pub(crate) size: Option<SizeColumn>,
    pub(crate) id: Option<usize>,
    pub(crate) kind: Option<usize>,
    pub(crate) groups: Vec<Group>,
    /// Columns that bear the name of an earlier one.
    pub(crate) repeated: Vec<(usize, usize)>,
}

const VECTORS: [(&str, [&str; 3]); 6] = [
    ("velocity", ["vx", "vy", "vz"]),
    ("force", ["fx", "fy", "fz"]),
    ("angular_velocity", ["omegax", "omegay", "omegaz"]),
    ("angular_momentum", ["angmomx", "angmomy", "angmomz"]),
    ("torque", ["tqx", "tqy", "tqz"]),
    ("image", ["ix", "iy", "iz"]),
];

impl Columns {
    /// Decides by the names.
    ///
    /// # Errors
    /// What is missing, as a sentence: there is no complete set of coordinates.
    pub(crate) fn new(names: Vec<String>, dialect: Dialect) -> Result<Self, String> {
        let repeated = repeated(&names);
        let mut free = FreeColumns::new(dialect, names.iter().map(String::as_str));
        free.take(repeated.iter().map(|&(column, _)| column));
        let (position, scaled) = free
            .positions()
            .map_err(|sets| format!("no complete set of coordinates ({sets}) among the columns {}", names.join(" ")))?;
        free.take(position);
        let (size, id, kind) = (free.size(), free.id(), free.kind());
        let singles = [size.map(|size| size.column), id, kind];
        free.take(singles.into_iter().flatten());
        let groups = groups(free, dialect);

        let mut cells = vec![Cell::Number; names.len()];
        let mut needed = vec![false; names.len()];
        for column in position.into_iter().chain(singles.into_iter().flatten()) {
            needed[column] = true;
        }
        if let Some(column) = id {
            cells[column] = Cell::Id;
        }
        if let Some(column) = kind {
            cells[column] = Cell::Type;
        }
        for &(column, earlier) in &repeated {
            cells[column] = cells[earlier];
            needed[column] = needed[earlier];
        }
        Ok(Self { names, cells, needed, position, scaled, size, id, kind, groups, repeated })
    }

    /// Whether a column is more than a quantity of its own name.
    pub(crate) fn has_meaning(&self, column: usize) -> bool {
        let standard = |group: &Group| {
            group.columns.contains(&column)
                && (VECTORS.iter().any(|(name, _)| *name == group.name) || is_standard(&group.name))
        };
        self.needed[column] || self.kind == Some(column) || self.groups.iter().any(standard)
    }

    /// The particles with what these columns are called.
    pub(crate) fn with_source_names(&self, mut particles: Particles) -> Particles {
        let size = self.size.map(|size| (if size.factor == 1.0 { "radius" } else { "diameter" }, size.column));
        let singles = [("id", self.id), ("type", self.kind)].into_iter().filter_map(|(of, column)| Some((of, column?)));
        for (of, column) in singles.chain(size) {
            particles = particles.with_source_names(of, &[&self.names[column]]);
        }
        for group in &self.groups {
            let names: Vec<&String> = group.columns.iter().map(|&column| &self.names[column]).collect();
            particles = particles.with_source_names(&group.name, &names);
        }
        particles
    }

    /// Whether the coordinates are fractions of the box.
    pub(crate) fn scaled(&self) -> bool {
        self.scaled
    }

    pub(crate) fn len(&self) -> usize {
        self.names.len()
    }

    /// Marks columns that hold words, going by the first row, and returns their names. A column that has a
    /// meaning stays numeric, so that a damaged number in it is found; types may be labels.
    pub(crate) fn pass_over_text<'a>(&mut self, first_row: impl Iterator<Item = &'a [u8]>) -> Vec<String> {
        let mut passed = Vec::new();
        for (column, word) in first_row.take(self.names.len()).enumerate() {
            let wordy = word.iter().any(u8::is_ascii_alphabetic) && number(word).is_none();
            let starts_like_a_number = word.first().is_some_and(|b| b.is_ascii_digit() || b"+-.".contains(b));
            let label = self.kind == Some(column);
            if !wordy || (starts_like_a_number && !label) || (self.needed[column] && !label) {
                continue;
            }
            if self.groups.iter().any(|g| g.columns.contains(&column) && g.columns.len() > 1) {
                continue;
            }
            if label {
                self.kind = None;
            }
            self.needed[column] = false;
            self.cells[column] = Cell::Text;
            self.groups.retain(|group| !group.columns.contains(&column));
            passed.push(self.names[column].clone());
        }
        for &(column, earlier) in &self.repeated {
            self.cells[column] = self.cells[earlier];
        }
        passed
    }

    /// Reads one row whose numbers are separated by blanks.
    pub(crate) fn read_words(&self, line: &[u8], row: &mut Row) -> Result<(), Fault> {
        row.numbers.resize(self.names.len(), 0.0);
        let mut at = skip_blanks(line, 0);
        for (column, cell) in self.cells.iter().enumerate() {
            if at == line.len() {
                return Err(Fault::Few { found: column });
            }
            if *cell == Cell::Number {
                // The number is parsed where it stands: looking for its end first would scan it twice.
                match fast_float2::parse_partial::<f64, _>(&line[at..]) {
                    Ok((value, length)) if line.get(at + length).is_none_or(u8::is_ascii_whitespace) => {
                        row.numbers[column] = value;
                        at += length;
                    }
                    _ => return Err(Fault::Number { column, word: shown(word_at(line, at)) }),
                }
            } else {
                let word = word_at(line, at);
                self.read_cell(column, word, row)?;
                at += word.len();
            }
            at = skip_blanks(line, at);
        }
        if at < line.len() {
            return Err(Fault::Many { found: words(line).count(), word: shown(word_at(line, at)) });
        }
        Ok(())
    }

    /// Reads one row from its fields; an empty field is NaN in a column that no particle needs.
    pub(crate) fn read_fields<'a>(&self, fields: impl Iterator<Item = &'a [u8]>, row: &mut Row) -> Result<(), Fault> {
        row.numbers.resize(self.names.len(), 0.0);
        let mut found = 0;
        let mut extra = None;
        for field in fields {
            if found < self.names.len() {
                self.read_cell(found, field, row)?;
            } else if extra.is_none() && !field.is_empty() {
                extra = Some(shown(field));
            }
            found += 1;
        }
        if found < self.names.len() {
            return Err(Fault::Few { found });
        }
        extra.map_or(Ok(()), |word| Err(Fault::Many { found, word }))
    }

    fn read_cell(&self, column: usize, word: &[u8], row: &mut Row) -> Result<(), Fault> {
        match self.cells[column] {
            Cell::Text => {}
            Cell::Number if word.is_empty() && !self.needed[column] => row.numbers[column] = f64::NAN,
            Cell::Number => match number(word) {
                Some(value) => row.numbers[column] = value,
                None => return Err(Fault::Number { column, word: shown(word) }),
            },
            Cell::Id | Cell::Type => {
                let Some(value) = integer(word) else {
                    return Err(Fault::Integer { column, word: shown(word) });
                };
                // Compared with a repeated column's; the exact value goes beside it.
                row.numbers[column] = value as f64;
                if self.id == Some(column) {
                    row.id = value;
                } else if self.kind == Some(column) {
                    row.kind = value;
                }
            }
        }
        Ok(())
    }
}

fn word_at(line: &[u8], at: usize) -> &[u8] {
    words(&line[at..]).next().unwrap_or_default()
}

/// Columns that bear the name of an earlier one, and that one.
fn repeated(names: &[String]) -> Vec<(usize, usize)> {
    let mut first = BTreeMap::new();
    let earlier = |(column, name)| Some((column, *first.entry(name).or_insert(column)));
    names.iter().enumerate().filter_map(earlier).filter(|(column, earlier)| column != earlier).collect()
}

/// The quantities that the columns left over make: vectors first, then arrays, then one by one; in the file's order.
fn groups(mut free: FreeColumns<'_>, dialect: Dialect) -> Vec<Group> {
    let mut groups = Vec::new();
    for (name, members) in &VECTORS {
        if let Some(columns) = free.three(members) {
            groups.push(Group { name: (*name).into(), columns: columns.to_vec() });
        }
    }
    groups.extend(arrays(&free, dialect));
    // A name that something else already has stays with it: the members are then kept one by one.
    let mut used: Vec<String> = free.iter().map(|(_, name)| name.to_string()).collect();
    groups.retain(|group| {
        let fresh = !used.contains(&group.name);
        used.push(group.name.clone());
        fresh
    });
    for group in &groups {
        free.take(group.columns.iter().copied());
    }
    for (column, name) in free.iter() {
        let standard = dialect.scalar(name).filter(|standard| !used.iter().any(|u| u == standard));
        let name = standard.unwrap_or(name).to_string();
        used.push(name.clone());
        groups.push(Group { name, columns: vec![column] });
    }
    groups.sort_by_key(|group| group.columns.iter().copied().min());
    groups
}

/// Groups of columns that number their components: `c_st[1] … c_st[6]`, `v:0 v:1 v:2`, `v_x v_y v_z`, `Vel.x Vel.y Vel.z`.
fn arrays(free: &FreeColumns<'_>, dialect: Dialect) -> Vec<Group> {
    // Keyed by base name and style of numbering; values are component → column.
    let mut found: BTreeMap<(String, u8), BTreeMap<usize, usize>> = BTreeMap::new();
    for (column, name) in free.iter() {
        let member = bracketed(name).or_else(|| if dialect == Dialect::Table { suffixed(name) } else { None });
        if let Some((base, style, component)) = member {
            found.entry((base.into(), style)).or_default().insert(component, column);
        }
    }
    let mut groups = Vec::new();
    for ((base, style), members) in found {
        let start = usize::from(style == b'[');
        let consecutive = members.keys().copied().eq(start..start + members.len());
        if members.len() < 2 || !consecutive || (b"_.".contains(&style) && members.len() != 3) {
            continue;
        }
        let columns: Vec<usize> = members.into_values().collect();
        let standard = if columns.len() == 3 { dialect.vector(&base) } else { None };
        let name = standard.map_or(base, Into::into);
        groups.push(Group { name, columns });
    }
    groups
}

fn bracketed(name: &str) -> Option<(&str, u8, usize)> {
    let (base, index) = name.strip_suffix(']')?.rsplit_once('[')?;
    Some((base, b'[', index.parse().ok()?))
}

fn suffixed(name: &str) -> Option<(&str, u8, usize)> {
    if let Some((base, index)) = name.rsplit_once(':') {
        return Some((base, b':', index.parse().ok()?));
    }
    let (base, axis) = name.rsplit_once(['_', '.'])?;
    let component = ["x", "y", "z"].iter().position(|a| axis.eq_ignore_ascii_case(a))?;
    (!base.is_empty()).then_some((base, name.as_bytes()[base.len()], component))
}

/// Why rows with these columns are no balls, and what to do; `None` where nothing speaks against it.
pub(crate) fn non_spherical(names: &[String]) -> Option<(String, String)> {
    const SHAPES: [&str; 18] = [
        "shapex",
        "shapey",
        "shapez",
        "blockiness1",
        "blockiness2",
        "roundness1",
        "roundness2",
        "quat1",
        "quat2",
        "quat3",
        "quat4",
        "quatw",
        "quati",
        "quatj",
        "quatk",
        "c_shape[1]",
        "c_quat[4]",
        "c_orient[4]",
    ];
    const CLUMPS: [&str; 6] = ["id_multisphere", "clumptype", "nrigid", "body", "clump", "clump_id"];
    const CLUMP_STARTS: [&str; 5] = ["c_clump", "f_clump", "i_clump", "c_body", "i_body"];
    let (column, what) = names.iter().find_map(|name| {
        if SHAPES.contains(&name.as_str()) {
            Some((name, "ellipsoids or superquadrics"))
        } else if CLUMPS.contains(&name.as_str()) || CLUMP_STARTS.iter().any(|start| name.starts_with(start)) {
            Some((name, "members of clumps, whose overlaps would be counted twice"))
        } else {
            None
        }
    })?;
    let remedy = "only balls are read; to take each row as a ball of its own all the same, allow non-spherical particles \
         (--allow-non-spherical)";
    Some((format!("column '{column}' says that the particles are {what}"), remedy.into()))
}
