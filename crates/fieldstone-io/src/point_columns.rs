//! Particles from binary records of named numbers.

use std::path::Path;

use fieldstone_particles::Particles;

use crate::assembly::{Assembly, Fault, Row};
use crate::column_names::Dialect;
use crate::columns::Columns;
use crate::{IoError, Position};

/// Rows of numbers whose columns are named as in tables.
pub(crate) struct PointColumns<'a> {
    path: &'a Path,
    columns: Columns,
    assembly: Assembly,
    row: Row,
}

impl<'a> PointColumns<'a> {
    /// # Errors
    /// [`IoError::Content`] where there are no coordinates among the names.
    pub(crate) fn new(path: &'a Path, names: Vec<String>, expected: usize) -> Result<Self, IoError> {
        let columns = Columns::new(names, Dialect::Table)
            .map_err(|missing| IoError::content(path, Position::File, missing, "name the coordinates x, y and z"))?;
        let assembly = Assembly::new(&columns, expected);
        let row = Row { numbers: vec![0.0; columns.len()], ..Row::default() };
        Ok(Self { path, columns, assembly, row })
    }

    /// Numbers of the row to be pushed next.
    pub(crate) fn row(&mut self) -> &mut [f64] {
        &mut self.row.numbers
    }

    /// Adds the row.
    pub(crate) fn push(&mut self, position: Position) -> Result<(), IoError> {
        self.push_row().map_err(|fault| {
            let (found, remedy) = fault.describe(&self.columns);
            IoError::content(self.path, position, found, remedy)
        })
    }

    fn push_row(&mut self) -> Result<(), Fault> {
        let numbers = &self.row.numbers;
        let whole = |column: Option<usize>| match column {
            // Every integer of 32 bits is exact in 64-bit floats.
            Some(column) if numbers[column].fract() == 0.0 => Ok(numbers[column] as i64),
            Some(column) => Err(Fault::Integer { column, word: numbers[column].to_string() }),
            None => Ok(0),
        };
        (self.row.id, self.row.kind) = (whole(self.columns.id)?, whole(self.columns.kind)?);
        self.assembly.push(&self.columns, &self.row, |p| p)
    }

    pub(crate) fn finish(self) -> Result<Particles, IoError> {
        let path = self.path;
        self.assembly.finish(&self.columns).map_err(|source| IoError::Particles { path: path.into(), source })
    }
}
