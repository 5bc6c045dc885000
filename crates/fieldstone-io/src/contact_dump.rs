//! Contacts from LIGGGHTS and LAMMPS `dump local`.

use std::path::Path;

use fieldstone_particles::{Contacts, Particles};

use crate::contact_assembly::ContactAssembly;
use crate::contact_columns::{ContactColumns, ResolvedColumns};
use crate::contact_resolver::Resolver;
use crate::contacts::check_stamp;
use crate::dump_stream::{DumpHead, DumpRows, DumpStream};
use crate::frames::unless_failed;
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
/// LIGGGHTS's dumps do not repeat the forces of the step: `compute pair/gran/local` evaluates them again, with the
/// velocities of the step's end and without limiting the tangential spring of sliding contacts.
pub struct ContactDumpReader {
    stream: DumpStream,
    options: ContactOptions,
    head: Option<DumpHead>,
    /// The line that `columns` was made from.
    column_line: Vec<u8>,
    columns: Option<ResolvedColumns>,
    failed: bool,
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
            self.head = self.stream.head(false)?;
        }
        Ok(self.head.as_ref().map(|head| FrameStamp { step: head.step, time: head.time }))
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
        for index in 0..head.count {
            self.stream.next_row(index, head.count)?;
            let lines = &self.stream.lines;
            let values = columns.read(words(lines.line())).map_err(|found| {
                if lines.complete() {
                    lines.error(found, "correct the row, or write the file again")
                } else {
                    self.stream.truncated(index, head.count)
                }
            })?;
            if let Some(row) = resolver.row(&values, lines.number())? {
                assembly.push(row);
            }
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
