//! Text dumps of LIGGGHTS and LAMMPS (`dump custom`, `dump atom`).

use std::path::Path;

use fieldstone_particles::{Domain, Particles};

use crate::assembly::Assembly;
use crate::column_names::Dialect;
use crate::columns::{Columns, non_spherical};
use crate::dump_box::DumpBox;
use crate::dump_stream::{DumpHead, DumpRows, DumpStream};
use crate::frames::unless_failed;
use crate::lines::words;
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
    stream: DumpStream,
    options: ParticleOptions,
    /// The `ITEM: ATOMS` line that `columns` was made from: most files repeat it in every frame.
    column_line: Vec<u8>,
    columns: Option<Columns>,
    failed: bool,
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
            stream: DumpStream::open(path, DumpRows::Atoms)?,
            options: *options,
            column_line: Vec::new(),
            columns: None,
            failed: false,
        })
    }

    /// The unit style that the file states (`si`, `lj`, …), once a frame that states it has been read.
    pub fn units(&self) -> Option<&str> {
        self.stream.units.as_deref()
    }

    /// Makes the columns' meaning from the header.
    fn settle_columns(&mut self, head: &DumpHead) -> Result<(), IoError> {
        if self.columns.is_some() && self.column_line == head.column_line {
            return Ok(());
        }
        let names = head.names();
        if !self.options.allow_non_spherical
            && let Some((found, remedy)) = non_spherical(&names)
        {
            return Err(self.stream.lines.error(found, remedy));
        }
        if names.iter().any(|name| name == "mol") {
            self.stream.warn(
                "column 'mol': if molecules are clumps of overlapping spheres, their overlaps are counted twice".into(),
            );
        }
        match Columns::new(names, Dialect::Dump) {
            Ok(columns) => {
                self.columns = Some(columns);
                self.column_line.clone_from(&head.column_line);
                Ok(())
            }
            Err(missing) => Err(self.stream.lines.error(missing, "write the dump with columns x y z")),
        }
    }

    fn domain(&mut self, cell: Option<&DumpBox>) -> Result<Option<Domain>, IoError> {
        let Some(cell) = cell else {
            self.stream.warn("the file states no box".into());
            return Ok(None);
        };
        self.stream.domain(cell)
    }

    fn read_frame(&mut self) -> Result<Option<Particles>, IoError> {
        let Some(head) = self.stream.head(true)? else { return Ok(None) };
        self.settle_columns(&head)?;
        let domain = self.domain(head.cell.as_ref())?;
        // Taken out while rows are read: warnings may come up in between.
        let Some(mut columns) = self.columns.take() else { return Ok(None) };
        if columns.scaled() && head.cell.is_none() {
            let found = "the coordinates are fractions of the box, but no 'ITEM: BOX BOUNDS' came before them";
            return Err(self.stream.lines.error(found, "write the dump with columns x y z"));
        }
        let expected = usize::try_from(head.count).unwrap_or(usize::MAX);
        let mut assembly = None;
        let mut read = 0;
        while read < head.count {
            let block = self.stream.take_rows(read, head.count)?;
            if let (None, Some(line)) = (&assembly, block.first_line()) {
                for name in columns.pass_over_text(words(line.bytes)) {
                    self.stream.warn(format!("column '{name}' holds text and is passed over"));
                }
            }
            let first = self.stream.lines.number() + 1 - block.len();
            let place = |p| match &head.cell {
                Some(cell) if columns.scaled() => cell.place(p),
                _ => p,
            };
            let parts = block.parse(|lines| Assembly::of_lines(&columns, lines, place)).map_err(|(line, fault)| {
                if !line.complete {
                    return self.stream.truncated(read + (line.number - first), head.count);
                }
                let (found, remedy) = fault.describe(&columns);
                line.error(self.stream.lines.path(), found, remedy)
            })?;
            let assembly = assembly.get_or_insert_with(|| Assembly::new(&columns, expected));
            parts.into_iter().for_each(|part| assembly.append(part));
            read += block.len();
            self.stream.lines.reuse(block);
        }
        if head.count > 0 && !self.stream.lines.complete() {
            self.stream.warn("the last row has no line end: if the file is cut, its last number may be too".into());
        }
        let assembly = assembly.unwrap_or_else(|| Assembly::new(&columns, 0));
        let particles = assembly
            .finish(&columns)
            .map_err(|source| IoError::Particles { path: self.stream.lines.path().into(), source })?
            .at(head.step, head.time);
        self.columns = Some(columns);
        self.stream.frame += 1;
        Ok(Some(match domain {
            Some(domain) => particles.with_domain(domain),
            None => particles,
        }))
    }

    fn pass_frame(&mut self) -> Result<bool, IoError> {
        let Some(head) = self.stream.head(false)? else { return Ok(false) };
        self.stream.pass_rows(head.count)?;
        Ok(true)
    }
}

impl FrameReader for DumpReader {
    fn next_frame(&mut self) -> Result<Option<Particles>, IoError> {
        unless_failed(self, |reader| &mut reader.failed, Self::read_frame)
    }

    fn skip_frame(&mut self) -> Result<bool, IoError> {
        unless_failed(self, |reader| &mut reader.failed, Self::pass_frame)
    }

    fn warnings(&self) -> &[String] {
        &self.stream.warnings
    }
}
