//! Contacts from LIGGGHTS and LAMMPS `dump local`.

use std::path::Path;

use fieldstone_particles::{Contacts, Domain, Particles};

use crate::contact_assembly::ContactAssembly;
use crate::contact_columns::{ContactColumns, ResolvedColumns};
use crate::contact_resolver::Resolver;
use crate::contacts::check_stamp;
use crate::dump_stream::{DumpHead, DumpRows, DumpStream};
use crate::frames::unless_failed;
use crate::line_blocks::LinePlace;
use crate::lines::words;
use crate::{ContactOptions, ContactPreset, ContactReader, FrameStamp, IoError, Position};

/// Reads the contacts of a `dump local`, frame by frame, compressed or not.
///
/// Particles are found by their ids. Where the particles' box is periodic, arms and branches lead to the image that is
/// touched. Wall rows without a force are left out.
///
/// | preset | particle, partner | force on the particle | contact point |
/// |---|---|---|---|
/// | LIGGGHTS pairs | `[13]`, `[14]` | `[16..18]` | `[33..35]` of 35 columns, else from the radii |
/// | LIGGGHTS walls | `[15]`, wall number `[13]` | `[16..18]` | `[1..3]` |
/// | LAMMPS pairs | `patom1`, `patom2` | `fx fy fz` (normal) plus `p1 p2 p3` (tangential) | from the radii |
///
/// The forces need not be those that acted: in the one LIGGGHTS frame measured (a chute of 12,092 grains) the sum of a
/// particle's contact forces and its weight differs from the force that the particles' dump states by 1.3 % in the
/// median. The files do not say why. Where it matters, compare the two first.
pub struct ContactDumpReader {
    stream: DumpStream,
    options: ContactOptions,
    head: Option<DumpHead>,
    /// The line that `columns` was made from.
    column_line: Vec<u8>,
    columns: Option<ResolvedColumns>,
    failed: bool,
}

/// Why a row is no contact.
enum Unread {
    /// Its columns are wrong.
    Row(LinePlace, String),
    /// The particles or the point that it names are.
    Contact(IoError),
}

impl ContactDumpReader {
    /// Opens a dump of contacts.
    ///
    /// # Errors
    /// [`IoError::System`] where the file cannot be opened; [`IoError::Content`] where the options do not say what the
    /// columns are.
    pub fn open(path: &Path, options: &ContactOptions) -> Result<Self, IoError> {
        let readable = [ContactPreset::LiggghtsPair, ContactPreset::LiggghtsWall, ContactPreset::LammpsPair];
        if options.columns.is_none() && !options.preset.is_some_and(|preset| readable.contains(&preset)) {
            let found = "a dump names its columns after computes, which does not tell what they hold";
            let remedy = "give the preset liggghts-pair, liggghts-wall or lammps-pair, or the columns, as in \
                          id1=c_p[13],id2=c_p[14],force=c_p[16..18]";
            return Err(IoError::content(path, Position::File, found, remedy));
        }
        Ok(Self {
            stream: DumpStream::open(path, DumpRows::Entries)?,
            options: options.clone(),
            head: None,
            column_line: Vec::new(),
            columns: None,
            failed: false,
        })
    }

    fn settle_columns(&mut self, head: &DumpHead) -> Result<(), IoError> {
        if self.columns.is_some() && self.column_line == head.column_line {
            return Ok(());
        }
        let names = head.names();
        let mapping = match (&self.options.columns, self.options.preset) {
            (Some(columns), _) => Ok(columns.clone()),
            (None, Some(ContactPreset::LiggghtsWall)) => ContactColumns::liggghts_wall(&names),
            (None, Some(ContactPreset::LammpsPair)) => ContactColumns::lammps_pair(&names),
            (None, _) => ContactColumns::liggghts_pair(&names),
        };
        let resolved = mapping.and_then(|mapping| ResolvedColumns::new(mapping, names));
        let remedy = "name the columns, as in id1=c_p[13],id2=c_p[14],force=c_p[16..18]";
        self.columns = Some(resolved.map_err(|missing| self.stream.lines.error(missing, remedy))?);
        self.column_line.clone_from(&head.column_line);
        Ok(())
    }

    fn look_ahead(&mut self) -> Result<Option<FrameStamp>, IoError> {
        if self.head.is_none() {
            self.head = self.stream.head(true)?;
        }
        Ok(self.head.as_ref().map(|head| FrameStamp { step: head.step, time: head.time }))
    }

    fn box_ahead(&mut self) -> Result<Option<Domain>, IoError> {
        self.look_ahead()?;
        match self.head.as_ref().and_then(|head| head.cell.clone()) {
            Some(cell) => self.stream.domain(&cell),
            None => Ok(None),
        }
    }

    fn read_frame(&mut self, particles: &Particles) -> Result<Option<Contacts>, IoError> {
        let Some(stamp) = self.look_ahead()? else { return Ok(None) };
        let Some(head) = self.head.take() else { return Ok(None) };
        check_stamp(self.stream.lines.path(), self.stream.lines.number(), stamp, particles)?;
        self.settle_columns(&head)?;
        let path = self.stream.lines.path().to_path_buf();
        let Some(columns) = self.columns.take() else { return Ok(None) };
        let resolver = Resolver::new(particles, &columns, &path)?;
        let mut assembly = ContactAssembly::new(particles, &path);
        let mut read = 0;
        while read < head.count {
            let block = self.stream.take_rows(read, head.count)?;
            let first = self.stream.lines.number() + 1 - block.len();
            let parts = block.parse(|lines| {
                let mut rows = Vec::with_capacity(lines.size_hint().0);
                for line in lines {
                    let values = columns.read(words(line.bytes)).map_err(|found| Unread::Row(line.place, found))?;
                    rows.extend(resolver.row(&values, line.place.number).map_err(Unread::Contact)?);
                }
                Ok(rows)
            });
            let parts = parts.map_err(|unread| match unread {
                Unread::Contact(error) => error,
                Unread::Row(line, found) if line.complete => {
                    line.error(&path, found, "correct the row, or write the file again")
                }
                Unread::Row(line, _) => self.stream.truncated(read + (line.number - first), head.count),
            })?;
            assembly.append(parts);
            read += block.len();
            self.stream.lines.reuse(block);
        }
        let (contacts, warnings) = assembly.finish()?;
        warnings.into_iter().for_each(|warning| self.stream.warn(warning));
        self.columns = Some(columns);
        self.stream.frame += 1;
        Ok(Some(contacts))
    }

    fn pass_frame(&mut self) -> Result<bool, IoError> {
        self.look_ahead()?;
        let Some(head) = self.head.take() else { return Ok(false) };
        self.stream.pass_rows(head.count)?;
        Ok(true)
    }
}

impl ContactReader for ContactDumpReader {
    fn peek(&mut self) -> Result<Option<FrameStamp>, IoError> {
        unless_failed(self, |reader| &mut reader.failed, Self::look_ahead)
    }

    fn next_box(&mut self) -> Result<Option<Domain>, IoError> {
        unless_failed(self, |reader| &mut reader.failed, Self::box_ahead)
    }

    fn next_frame(&mut self, particles: &Particles) -> Result<Option<Contacts>, IoError> {
        unless_failed(self, |reader| &mut reader.failed, |reader| reader.read_frame(particles))
    }

    fn skip_frame(&mut self) -> Result<bool, IoError> {
        unless_failed(self, |reader| &mut reader.failed, Self::pass_frame)
    }

    fn warnings(&self) -> &[String] {
        &self.stream.warnings
    }
}
