//! Text dumps of LIGGGHTS and LAMMPS (`dump custom`, `dump atom`).

use std::path::Path;

use fieldstone_particles::{Domain, Particles};

use crate::assembly::{Assembly, Row};
use crate::columns::{Columns, Dialect, non_spherical};
use crate::dump_box::{BoxFault, DumpBox};
use crate::lines::{LineReader, integer, number, shown, skip_blanks, text, words};
use crate::{FrameReader, IoError, ParticleOptions};

/// Reads the particles of a LIGGGHTS or LAMMPS text dump, frame by frame, compressed or not.
///
/// | columns | become |
/// |---|---|
/// | `x y z`, else `xu yu zu`, else `xs ys zs` or `xsu ysu zsu` times the box | positions |
/// | `radius`, else half of `diameter` or `d` | radii |
/// | `id`, `type` | ids, types |
/// | `vx vy vz`, `fx fy fz`, `omegax …`, `tqx …`, `angmomx …`, `ix iy iz` | `velocity`, `force`, `angular_velocity`, `torque`, `angular_momentum`, `image` |
/// | `name[1] … name[n]`, all of them | `name` with n components |
/// | `mass`, `density` or `rho`, any other | a scalar of that name |
///
/// Columns may stand in any order, rows keep the file's order. The box becomes the particles' domain with its
/// periodic directions, orthogonal or triclinic (`BOX BOUNDS xy xz yz`, whose bounds are those of the box around
/// the tilted one; `BOX BOUNDS abc origin` where `a` is along x and `b` in the plane of x and y). A box turned
/// otherwise is left out, and [`FrameReader::warnings`] says so. Text columns are passed over, with a warning too.
///
/// ```
/// use fieldstone_io::{DumpReader, FrameReader};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("two.dump");
/// std::fs::write(&path, "ITEM: TIMESTEP\n40\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp ff ff\n0 1\n0 1\n0 1\n\
///     ITEM: ATOMS id diameter x y z\n7 0.5 0.1 0.2 0.3\n3 0.25 0.4 0.5 0.6\n")?;
/// let mut reader = DumpReader::open(&path)?;
/// let particles = reader.next_frame()?.expect("one frame");
/// assert_eq!(particles.radii()?, [0.25, 0.125]);
/// assert_eq!(particles.step(), Some(40));
/// assert_eq!(particles.domain().map(|d| d.periodic()), Some([true, false, false]));
/// assert!(reader.next_frame()?.is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct DumpReader {
    lines: LineReader,
    options: ParticleOptions,
    /// The `ITEM: ATOMS` line that `columns` was made from: most files repeat it in every frame.
    column_line: Vec<u8>,
    columns: Option<Columns>,
    frame: usize,
    units: Option<String>,
    warnings: Vec<String>,
    failed: bool,
}

struct Head {
    count: u64,
    step: Option<i64>,
    time: Option<f64>,
    cell: Option<DumpBox>,
}

impl DumpReader {
    /// Opens a dump of spheres.
    ///
    /// # Errors
    /// [`IoError::System`] where the file cannot be opened. What is wrong inside is found while frames are read.
    pub fn open(path: &Path) -> Result<Self, IoError> {
        Self::open_with(path, &ParticleOptions::default())
    }

    /// Opens a dump, with options.
    ///
    /// # Errors
    /// As [`DumpReader::open`].
    pub fn open_with(path: &Path, options: &ParticleOptions) -> Result<Self, IoError> {
        Ok(Self {
            lines: LineReader::open(path)?,
            options: *options,
            column_line: Vec::new(),
            columns: None,
            frame: 0,
            units: None,
            warnings: Vec::new(),
            failed: false,
        })
    }

    /// The unit style that the file states (`si`, `lj`, …), once a frame that states it has been read.
    pub fn units(&self) -> Option<&str> {
        self.units.as_deref()
    }

    fn warn(&mut self, warning: String) {
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// Reads up to the `ITEM: ATOMS` line and stays there; `None` at the end of the file. The box is parsed only
    /// where somebody wants it.
    fn head(&mut self, with_box: bool) -> Result<Option<Head>, IoError> {
        let (mut count, mut step, mut time, mut cell) = (None, None, None, None);
        let mut begun = false;
        loop {
            if !self.lines.advance()? {
                if begun {
                    let found = format!("the file ends within the header of frame {}", self.frame);
                    return Err(self.lines.error(found, "the file is cut, or still being written"));
                }
                return Ok(None);
            }
            let line = self.lines.line();
            if skip_blanks(line, 0) == line.len() {
                continue;
            }
            let Some(item) = line.strip_prefix(b"ITEM:") else {
                let found = format!("'{}' stands where an 'ITEM:' line is expected", shown(line));
                let remedy = if self.frame > 0 {
                    "the frame before has more rows than its number of atoms says"
                } else {
                    "this is no LIGGGHTS or LAMMPS text dump"
                };
                return Err(self.lines.error(found, remedy));
            };
            begun = true;
            let item: Vec<&[u8]> = words(item).take(3).collect();
            match item.as_slice() {
                [b"TIMESTEP", ..] => step = Some(self.value("a time step", integer)?),
                [b"UNITS", ..] => self.units = Some(self.value("a unit style", |word| Some(text(word)))?),
                [b"TIME", ..] => time = Some(self.value("a time", number)?),
                [b"NUMBER", b"OF", b"ATOMS"] => {
                    count = Some(self.value("a number of atoms", |w| u64::try_from(integer(w)?).ok())?);
                }
                [b"NUMBER", b"OF", ..] | [b"ENTRIES", ..] => {
                    let found = "this is a dump local (contacts or other entries), not particles";
                    return Err(self.lines.error(found, "give a dump custom with positions as the particles"));
                }
                [b"BOX", b"BOUNDS", ..] if with_box => cell = Some(DumpBox::read(&mut self.lines)?),
                [b"BOX", b"BOUNDS", ..] => {
                    for _ in 0..3 {
                        self.lines.advance()?;
                    }
                }
                [b"ATOMS", ..] => {
                    let Some(count) = count else {
                        let found = "the rows begin, but no 'ITEM: NUMBER OF ATOMS' came before them";
                        return Err(self.lines.error(found, "write the file again"));
                    };
                    return Ok(Some(Head { count, step, time, cell }));
                }
                _ => {
                    let warning = format!("passed over '{}', which is not known in dumps", shown(self.lines.line()));
                    self.warn(warning);
                    self.pass_over_section()?;
                }
            }
        }
    }

    fn pass_over_section(&mut self) -> Result<(), IoError> {
        while self.lines.advance()? {
            if self.lines.line().starts_with(b"ITEM:") {
                self.lines.stay();
                break;
            }
        }
        Ok(())
    }

    /// The single word in the next line.
    fn value<T>(&mut self, what: &str, parse: impl Fn(&[u8]) -> Option<T>) -> Result<T, IoError> {
        if !self.lines.advance()? {
            let found = format!("the file ends where {what} is expected");
            return Err(self.lines.error(found, "the file is cut, or still being written"));
        }
        let mut found = words(self.lines.line());
        match (found.next().and_then(parse), found.next()) {
            (Some(value), None) => Ok(value),
            _ => {
                let found = format!("'{}' stands where {what} is expected", shown(self.lines.line()));
                Err(self.lines.error(found, "write the file again"))
            }
        }
    }

    /// Makes the columns' meaning from the current line.
    fn settle_columns(&mut self) -> Result<(), IoError> {
        if self.columns.is_some() && self.column_line == self.lines.line() {
            return Ok(());
        }
        let names: Vec<String> = words(self.lines.line()).skip(2).map(text).collect();
        if !self.options.allow_non_spherical
            && let Some((found, remedy)) = non_spherical(&names)
        {
            return Err(self.lines.error(found, remedy));
        }
        if names.iter().any(|name| name == "mol") {
            self.warn(
                "column 'mol': if molecules are clumps of overlapping spheres, their overlaps are counted twice".into(),
            );
        }
        match Columns::new(names, Dialect::Dump) {
            Ok(columns) => {
                self.columns = Some(columns);
                self.column_line = self.lines.line().to_vec();
                Ok(())
            }
            Err(missing) => Err(self.lines.error(missing, "write the dump with columns x y z")),
        }
    }

    fn domain(&mut self, cell: Option<&DumpBox>) -> Result<Option<Domain>, IoError> {
        let Some(cell) = cell else {
            self.warn("the file states no box".into());
            return Ok(None);
        };
        if !cell.flagged() {
            self.warn("the file does not say which directions are periodic: none is taken to be".into());
        }
        match cell.domain() {
            Ok(domain) => Ok(Some(domain)),
            Err(BoxFault::Turned { periodic }) => {
                let mut warning =
                    "the box's edges do not start along x and in the plane of x and y, as they do in restricted \
                     triclinic boxes: read without a box"
                        .to_string();
                if periodic {
                    warning.push_str("; particles at a periodic boundary are not continued on the other side");
                }
                self.warn(warning);
                Ok(None)
            }
            Err(BoxFault::Empty(reason)) => Err(self.lines.error(reason, "the box is wrong: write the file again")),
        }
    }

    fn read_frame(&mut self) -> Result<Option<Particles>, IoError> {
        let Some(head) = self.head(true)? else { return Ok(None) };
        self.settle_columns()?;
        let domain = self.domain(head.cell.as_ref())?;
        // Taken out while rows are read: warnings may come up in between.
        let Some(mut columns) = self.columns.take() else { return Ok(None) };
        if columns.scaled() && head.cell.is_none() {
            let found = "the coordinates are fractions of the box, but no 'ITEM: BOX BOUNDS' came before them";
            return Err(self.lines.error(found, "write the dump with columns x y z"));
        }
        let expected = usize::try_from(head.count).unwrap_or(usize::MAX);
        let mut assembly = None;
        let mut row = Row::default();
        for index in 0..head.count {
            self.next_row(index, head.count)?;
            let line = self.lines.line();
            if assembly.is_none() {
                for name in columns.pass_over_text(words(line)) {
                    self.warn(format!("column '{name}' holds text and is passed over"));
                }
                assembly = Some(Assembly::new(&columns, expected));
            }
            let Some(assembly) = &mut assembly else { continue };
            let line = self.lines.line();
            let result = columns.read_words(line, &mut row).and_then(|()| {
                assembly.push(&columns, &row, |p| match &head.cell {
                    Some(cell) if columns.scaled() => cell.place(p),
                    _ => p,
                })
            });
            if let Err(fault) = result {
                if !self.lines.complete() {
                    return Err(self.truncated(index, head.count));
                }
                let (found, remedy) = fault.describe(&columns);
                return Err(self.lines.error(found, remedy));
            }
        }
        if head.count > 0 && !self.lines.complete() {
            self.warn("the last row has no line end: if the file is cut, its last number may be too".into());
        }
        let assembly = assembly.unwrap_or_else(|| Assembly::new(&columns, 0));
        let particles = assembly
            .finish(&columns)
            .map_err(|source| IoError::Particles { path: self.lines.path().into(), source })?
            .at(head.step, head.time);
        self.columns = Some(columns);
        self.frame += 1;
        Ok(Some(match domain {
            Some(domain) => particles.with_domain(domain),
            None => particles,
        }))
    }

    fn pass_frame(&mut self) -> Result<bool, IoError> {
        let Some(head) = self.head(false)? else { return Ok(false) };
        for index in 0..head.count {
            self.next_row(index, head.count)?;
        }
        self.frame += 1;
        Ok(true)
    }

    /// Goes to the row of atom `index`.
    #[inline]
    fn next_row(&mut self, index: u64, count: u64) -> Result<(), IoError> {
        if !self.lines.advance()? {
            return Err(self.truncated(index, count));
        }
        // No column begins with a capital I that a number could be confused with: only a new section does.
        if self.lines.line().starts_with(b"ITEM:") {
            let found = format!("frame {} has {index} rows, but its number of atoms is {count}", self.frame);
            return Err(self.lines.error(found, "the program that wrote it was stopped: remove the incomplete frame"));
        }
        Ok(())
    }

    fn truncated(&self, index: u64, count: u64) -> IoError {
        let found = format!("the file ends after {index} of the {count} atoms of frame {}", self.frame);
        self.lines.error(found, "the file is cut, or still being written; earlier frames can be read")
    }
}

impl FrameReader for DumpReader {
    fn next_frame(&mut self) -> Result<Option<Particles>, IoError> {
        if self.failed {
            return Ok(None);
        }
        let result = self.read_frame();
        self.failed = result.is_err();
        result
    }

    fn skip_frame(&mut self) -> Result<bool, IoError> {
        if self.failed {
            return Ok(false);
        }
        let result = self.pass_frame();
        self.failed = result.is_err();
        result
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}
