//! Particles built row by row.

use fieldstone_particles::{Particles, ParticlesError, Quantity};

use crate::column_names::{SizeColumn, sizes_differ};
use crate::columns::{Cell, Columns};
use crate::line_blocks::{LinePlace, Lines};

/// Numbers of one row, reused from row to row.
#[derive(Debug, Clone, Default)]
pub(crate) struct Row {
    pub(crate) numbers: Vec<f64>,
    pub(crate) id: i64,
    pub(crate) kind: i64,
}

/// What is wrong with a row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Fault {
    Few { found: usize },
    Many { found: usize, word: String },
    Number { column: usize, word: String },
    Integer { column: usize, word: String },
    NotFinite { column: usize, value: f64 },
    Radius { column: usize, value: f64 },
    Huge { column: usize, value: f64 },
    Size { column: usize, value: f64 },
    Differs { column: usize, earlier: usize },
    Sizes { radius: (usize, f64), diameter: (usize, f64) },
}

/// Coordinates and sizes beyond this, and sizes below its reciprocal, have cubes that are no numbers.
const LARGEST: f64 = 1e100;

impl Fault {
    /// What was found, and what to do.
    pub(crate) fn describe(&self, columns: &Columns) -> (String, String) {
        let name = |column: &usize| format!("column {} '{}'", column + 1, columns.names[*column]);
        let expected = || format!("{} columns are expected: {}", columns.len(), columns.names.join(" "));
        let repair = "correct the row, or write the file again".to_string();
        match self {
            Self::Few { found } => (format!("the row has {found} columns; {}", expected()), repair),
            Self::Many { found, word } => {
                (format!("the row has {found} columns, the first one too many being '{word}'; {}", expected()), repair)
            }
            Self::Number { column, word } if word.is_empty() => (format!("{} is empty", name(column)), repair),
            Self::Number { column, word } => {
                let remedy = if word.contains(',') && !word.contains('.') {
                    "decimal commas are not read: write the file with decimal points".into()
                } else {
                    repair
                };
                (format!("{} holds '{word}', which is no number", name(column)), remedy)
            }
            Self::Integer { column, word } if is_long_integer(word) => (
                format!(
                    "{} holds '{word}', which is too large: from {} to {} can be read",
                    name(column),
                    i64::MIN,
                    i64::MAX
                ),
                repair,
            ),
            Self::Integer { column, word } => (format!("{} holds '{word}', which is no integer", name(column)), repair),
            Self::NotFinite { column, value } => (
                format!("{} is {value}; positions must be finite", name(column)),
                "a particle was lost or the simulation diverged: remove the row or take an earlier frame".into(),
            ),
            Self::Radius { column, value } => (
                format!("{} is {value}; sizes must be above 0 and finite", name(column)),
                "correct the row, or remove it where it is a point particle".into(),
            ),
            Self::Huge { column, value } => (
                format!("{} is {value:?}; coordinates must be at most {LARGEST:?} in size", name(column)),
                "the simulation diverged: remove the row or take an earlier frame".into(),
            ),
            Self::Size { column, value } => (
                format!(
                    "{} is {value:?}; sizes must be between {:?} and {LARGEST:?} for their volumes to be numbers",
                    name(column),
                    LARGEST.recip()
                ),
                repair,
            ),
            Self::Differs { column, earlier } => (
                format!("{} holds another value than column {} of the same name", name(column), earlier + 1),
                "rename one of the two columns".into(),
            ),
            Self::Sizes { radius, diameter } => (
                format!(
                    "{} is {} and {} is {}, which is not twice as much",
                    name(&radius.0),
                    radius.1,
                    name(&diameter.0),
                    diameter.1
                ),
                "remove or rename the one that is wrong".into(),
            ),
        }
    }
}

/// Whether a word is an integer, though one of more than 64 bits.
fn is_long_integer(word: &str) -> bool {
    let digits = word.strip_prefix(['-', '+']).unwrap_or(word);
    digits.len() > 18 && digits.bytes().all(|byte| byte.is_ascii_digit())
}

/// Particles under construction.
#[derive(Debug, Default)]
pub(crate) struct Assembly {
    positions: Vec<[f64; 3]>,
    radii: Vec<f64>,
    ids: Vec<i64>,
    types: Vec<i64>,
    data: Vec<Vec<f64>>,
}

impl Assembly {
    /// Room for `expected` particles; a count that a file merely claims reserves little.
    pub(crate) fn new(columns: &Columns, expected: usize) -> Self {
        let room = expected.min(1 << 14);
        let data = columns.groups.iter().map(|group| Vec::with_capacity(room * group.columns.len())).collect();
        Self {
            positions: Vec::with_capacity(room),
            radii: Vec::with_capacity(if columns.size.is_some() { room } else { 0 }),
            data,
            ..Self::default()
        }
    }

    /// The rows of these lines; what is wrong with the first that is no row, and that line.
    pub(crate) fn of_lines(
        columns: &Columns,
        lines: Lines<'_>,
        place: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Result<Self, (LinePlace, Fault)> {
        let mut assembly = Self::new(columns, lines.size_hint().0);
        let mut row = Row::default();
        for line in lines {
            columns
                .read_words(line.bytes, &mut row)
                .and_then(|()| assembly.push(columns, &row, &place))
                .map_err(|fault| (line.place, fault))?;
        }
        Ok(assembly)
    }

    /// Adds a row; `place` turns scaled coordinates into positions.
    pub(crate) fn push(
        &mut self,
        columns: &Columns,
        row: &Row,
        place: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Result<(), Fault> {
        let position = place(columns.position.map(|c| row.numbers[c]));
        for (axis, value) in position.into_iter().enumerate() {
            if !value.is_finite() {
                return Err(Fault::NotFinite { column: columns.position[axis], value });
            }
            if value.abs() > LARGEST {
                return Err(Fault::Huge { column: columns.position[axis], value });
            }
        }
        if let Some(SizeColumn { column, factor, diameter }) = columns.size {
            let value = row.numbers[column];
            // The product is checked too: half of the smallest diameter is 0.
            if !(value.is_finite() && factor * value > 0.0) {
                return Err(Fault::Radius { column, value });
            }
            if !(LARGEST.recip()..=LARGEST).contains(&(factor * value)) {
                return Err(Fault::Size { column, value });
            }
            if let Some(other) = diameter.filter(|&other| columns.cells[other] == Cell::Number)
                && sizes_differ(value, row.numbers[other])
            {
                return Err(Fault::Sizes { radius: (column, value), diameter: (other, row.numbers[other]) });
            }
            self.radii.push(factor * value);
        }
        for &(column, earlier) in &columns.repeated {
            let differs = row.numbers[column].to_bits() != row.numbers[earlier].to_bits();
            if differs && columns.cells[column] != Cell::Text {
                return Err(Fault::Differs { column, earlier });
            }
        }
        self.positions.push(position);
        if columns.id.is_some() {
            self.ids.push(row.id);
        }
        if columns.kind.is_some() {
            self.types.push(row.kind);
        }
        for (data, group) in self.data.iter_mut().zip(&columns.groups) {
            for &column in &group.columns {
                data.push(row.numbers[column]);
            }
        }
        Ok(())
    }

    /// Adds the particles of another assembly with the same columns.
    pub(crate) fn append(&mut self, mut other: Self) {
        self.positions.append(&mut other.positions);
        self.radii.append(&mut other.radii);
        self.ids.append(&mut other.ids);
        self.types.append(&mut other.types);
        self.data.iter_mut().zip(&mut other.data).for_each(|(data, more)| data.append(more));
    }

    /// Turns the column `name` into types where it holds nothing but integers.
    pub(crate) fn integers_to_types(&mut self, columns: &mut Columns, name: &str) {
        let Some(index) = columns.groups.iter().position(|g| g.name == name && g.columns.len() == 1) else { return };
        if columns.kind.is_some() || !self.data[index].iter().all(|v| v.fract() == 0.0 && v.abs() < 1e15) {
            return;
        }
        self.types = self.data.remove(index).into_iter().map(|v| v as i64).collect();
        columns.kind = Some(columns.groups.remove(index).columns[0]);
    }

    pub(crate) fn finish(self, columns: &Columns) -> Result<Particles, ParticlesError> {
        let mut particles = Particles::new(self.positions)?;
        if columns.size.is_some() {
            particles = particles.with_radii(self.radii)?;
        }
        if columns.id.is_some() {
            particles = particles.with_ids(self.ids)?;
        }
        if columns.kind.is_some() {
            particles = particles.with_types(self.types)?;
        }
        for (group, data) in columns.groups.iter().zip(self.data) {
            let quantity = Quantity { name: group.name.clone(), components: group.columns.len(), data };
            particles = particles.with_quantity(quantity)?;
        }
        Ok(columns.with_source_names(particles))
    }
}
