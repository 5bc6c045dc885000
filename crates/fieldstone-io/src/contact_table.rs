//! Contacts from a table of text: CSV and its dialects.

use std::path::Path;

use fieldstone_particles::{Contacts, Particles};

use crate::contact_assembly::ContactAssembly;
use crate::contact_columns::{ContactColumns, ResolvedColumns};
use crate::contact_resolver::Resolver;
use crate::csv::{Header, fields};
use crate::lines::{LineReader, skip_blanks};
use crate::{ContactOptions, ContactReader, FrameStamp, IoError};

/// Reads contacts from a table with a header row: one frame.
///
/// Without a mapping the names decide, whatever their letter case:
///
/// | names | meaning |
/// |---|---|
/// | `id1 id2`, `i j`, `particle partner` | the two particles; a wall has an empty or negative second one |
/// | `x1 y1 z1 x2 y2 z2` | their centres, where there are no ids |
/// | `fx fy fz`, or `fnx fny fnz ftx fty ftz` | force on the first, or its normal and tangential parts |
/// | `cx cy cz`, `px py pz`, `x y z` | contact point; without it the radii decide |
pub struct ContactTableReader {
    lines: LineReader,
    options: ContactOptions,
    warnings: Vec<String>,
    done: bool,
}

impl ContactTableReader {
    /// Opens a table of contacts.
    ///
    /// # Errors
    /// [`IoError::System`] where the file cannot be opened.
    pub fn open(path: &Path, options: &ContactOptions) -> Result<Self, IoError> {
        Ok(Self { lines: LineReader::open(path)?, options: options.clone(), warnings: Vec::new(), done: false })
    }

    fn read(&mut self, particles: &Particles) -> Result<Contacts, IoError> {
        let lines = &mut self.lines;
        let path = lines.path().to_path_buf();
        let header = Header::read(lines)?;
        let mapping = self.options.columns.clone().map_or_else(|| ContactColumns::of_table(&header.names), Ok);
        let columns = mapping
            .and_then(|mapping| ResolvedColumns::new(mapping, header.names.clone()))
            .map_err(|missing| lines.error(missing, "name the columns, as in id1=a,id2=b,force=fx/fy/fz"))?;
        let resolver = Resolver::new(particles, &columns, &path)?;
        let mut assembly = ContactAssembly::new(particles, &path);
        while lines.advance()? {
            let line = lines.line();
            if skip_blanks(line, 0) == line.len() || line.trim_ascii_start().starts_with(b"#") {
                continue;
            }
            let values = columns
                .read(fields(line, header.separator))
                .map_err(|found| lines.error(found, "correct the row, or write the file again"))?;
            if let Some(row) = resolver.row(&values, lines.number())? {
                assembly.push(row);
            }
        }
        let (contacts, warnings) = assembly.finish()?;
        self.warnings.extend(warnings);
        Ok(contacts)
    }
}

impl ContactReader for ContactTableReader {
    fn peek(&mut self) -> Result<Option<FrameStamp>, IoError> {
        Ok((!self.done).then(FrameStamp::default))
    }

    fn next_frame(&mut self, particles: &Particles) -> Result<Option<Contacts>, IoError> {
        if std::mem::replace(&mut self.done, true) {
            return Ok(None);
        }
        self.read(particles).map(Some)
    }

    fn skip_frame(&mut self) -> Result<bool, IoError> {
        Ok(!std::mem::replace(&mut self.done, true))
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}
