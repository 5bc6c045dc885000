//! Which reader a file of particles needs.

use std::io::Read;
use std::path::{Path, PathBuf};

use fieldstone_particles::Particles;

use crate::columns::non_spherical;
use crate::lines::{integer, number, shown, words};
use crate::openfoam::{parts_of_cloud, read_cloud, read_parts};
use crate::vtk::read_vtk_particles;
use crate::{
    CsvReader, DumpReader, FrameReader, IoError, MercuryReader, Position, XyzReader, read_bgeo, read_ply, source,
};

/// Options for reading particles.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ParticleOptions {
    /// Take each row as a ball of its own even where columns say that it is an ellipsoid, a superquadric or a
    /// member of a clump, instead of refusing the file.
    pub allow_non_spherical: bool,
}

type Reader = Box<dyn FrameReader + Send>;

/// What decides on the format: the first bytes, decompressed, and the name.
struct Start<'a> {
    path: &'a Path,
    bytes: &'a [u8],
}

impl Start<'_> {
    fn lines(&self) -> impl Iterator<Item = &[u8]> {
        let lines = self.bytes.split(|&b| b == b'\n').map(<[u8]>::trim_ascii);
        lines.skip_while(|line| line.is_empty())
    }

    /// Whether the first line begins with one of these.
    fn begins(&self, texts: &[&str]) -> bool {
        let first = self.lines().next().unwrap_or_default();
        texts.iter().any(|text| first.starts_with(text.as_bytes()))
    }

    /// Numbers in line `index`; `None` where it holds anything else.
    fn numbers(&self, index: usize) -> Option<Vec<f64>> {
        words(self.lines().nth(index)?).map(number).collect()
    }

    /// Whether the name ends in one of these, `.gz` left away.
    fn named(&self, endings: &[&str]) -> bool {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let name = name.strip_suffix(".gz").unwrap_or(&name);
        endings.iter().any(|ending| name.ends_with(ending))
    }
}

struct Format {
    name: &'static str,
    fits: fn(&Start) -> bool,
    open: fn(&Path, &ParticleOptions) -> Result<Reader, IoError>,
}

/// Formats in the order in which they are tried: the most particular first.
const FORMATS: &[Format] = &[
    Format {
        name: "LIGGGHTS or LAMMPS dump",
        fits: |start| start.bytes.trim_ascii_start().starts_with(b"ITEM:"),
        open: |path, options| Ok(Box::new(DumpReader::open_with(path, options)?)),
    },
    Format {
        name: "VTK",
        fits: |start| start.begins(&["# vtk DataFile", "<?xml", "<VTKFile"]),
        open: |path, options| Ok(whole_file(path, options, read_vtk_particles)),
    },
    Format {
        name: "PLY",
        fits: |start| start.bytes.starts_with(b"ply\n") || start.bytes.starts_with(b"ply\r\n"),
        open: |path, options| Ok(whole_file(path, options, read_ply)),
    },
    Format {
        name: "classic .bgeo",
        fits: |start| start.bytes.starts_with(b"BgeoV"),
        open: |path, options| Ok(whole_file(path, options, read_bgeo)),
    },
    Format {
        name: "OpenFOAM cloud",
        fits: |start| start.path.is_dir() || start.begins(&["/*", "FoamFile"]),
        open: |path, options| Ok(whole_file(path, options, read_cloud)),
    },
    Format {
        name: "MercuryDPM .data",
        fits: |start| {
            let Some(&[count, _, ..]) = start.numbers(0).as_deref() else { return false };
            let header = start.numbers(0).map(|n| n.len());
            let row = start.numbers(1).map(|n| n.len());
            // Eight numbers begin three dimensions, six begin two; the latter's own error says so.
            count >= 0.0
                && count.fract() == 0.0
                && match header {
                    Some(8) => row != Some(8) || count == 0.0,
                    Some(6) => row == Some(8),
                    _ => false,
                }
        },
        open: |path, _| Ok(Box::new(MercuryReader::open(path)?)),
    },
    Format {
        name: "XYZ",
        fits: |start| {
            let first = start.lines().next().and_then(integer);
            first.is_some_and(|count| count >= 0)
        },
        open: |path, _| Ok(Box::new(XyzReader::open(path)?)),
    },
    Format {
        name: "CSV",
        fits: |start| !start.bytes.contains(&0) && other_format(start).is_none(),
        open: |path, options| Ok(Box::new(CsvReader::open_with(path, options)?)),
    },
];

/// Formats that are known by their first bytes or name, but from which no particles are read here.
fn other_format(start: &Start) -> Option<&'static str> {
    if start.begins(&["MercuryDPM"]) {
        return Some("a MercuryDPM .restart file; the particles are read from the .data file");
    }
    if start.begins(&["LAMMPS", "LIGGGHTS"]) {
        return Some("a data file to start a simulation from; the particles are read from dumps");
    }
    if start.bytes.starts_with(b"FSTNSPH") {
        return Some("a checkpoint of `fieldstone sph run`, which goes on from it with --resume");
    }
    if start.named(&[".toml"]) {
        return Some(
            "settings in TOML: a case for `fieldstone sph check` and `sph run`, or settings for `fieldstone fields`",
        );
    }
    if start.begins(&["{", "["]) {
        return Some("a JSON file");
    }
    if start.begins(&["solid"]) {
        return Some("a file of triangles (STL)");
    }
    if start.named(&[".fstat"]) {
        return Some("a MercuryDPM .fstat file of contacts; the particles are read from the .data file");
    }
    None
}

/// A reader for the only frame of a file that a function reads as a whole.
fn whole_file(path: &Path, options: &ParticleOptions, read: fn(&Path) -> Result<Particles, IoError>) -> Reader {
    let allowed = options.allow_non_spherical;
    Box::new(OneFrame::new(path, move |path: &Path| {
        let particles = read(path)?;
        let names: Vec<String> = particles.quantities().iter().map(|quantity| quantity.name.clone()).collect();
        match non_spherical(&names) {
            Some((found, remedy)) if !allowed => Err(IoError::content(path, Position::File, found, remedy)),
            _ => Ok(particles),
        }
    }))
}

/// Opens a file of particles, deciding on the format by its content.
///
/// LIGGGHTS and LAMMPS text dumps, VTK points, PLY point clouds, classic `.bgeo`, OpenFOAM clouds (by their folder or
/// a file; of a decomposed case by the path that the reconstructed one would have, processor by processor), MercuryDPM `.data`, XYZ and tables (CSV, `# x y z`, YADE's text export) are read; all of them compressed with gzip, too.
///
/// # Errors
/// [`IoError::UnknownFormat`] tells what the content looks like; [`IoError::System`] where the file cannot be
/// opened. What is wrong inside is found while frames are read.
///
/// ```
/// use fieldstone_io::{ParticleOptions, open_particles};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("balls.txt");
/// std::fs::write(&path, "#format x_y_z_r\n0 0 1 0.5\n1 0 1 0.5\n")?;
/// let mut reader = open_particles(&path, &ParticleOptions::default())?;
/// assert_eq!(reader.next_frame()?.map(|particles| particles.len()), Some(2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn open_particles(path: &Path, options: &ParticleOptions) -> Result<Box<dyn FrameReader + Send>, IoError> {
    let parts = parts_of_cloud(path);
    if !parts.is_empty() {
        return Ok(Box::new(OneFrame::new(path, move |_: &Path| read_parts(&parts))));
    }
    let mut bytes = Vec::new();
    if !path.is_dir() {
        let read = source::open(path)?.take(1 << 13).read_to_end(&mut bytes);
        read.map_err(|source| IoError::System { path: path.into(), action: "read", source })?;
    }
    let unknown = |found: String| IoError::UnknownFormat {
        path: path.into(),
        found,
        readable: FORMATS.iter().map(|format| format.name).collect::<Vec<_>>().join(", "),
    };
    if bytes.starts_with(b"\xef\xbb\xbf") {
        bytes.drain(..3);
    }
    if bytes.trim_ascii().is_empty() && !path.is_dir() {
        return Err(unknown("the file is empty".into()));
    }
    let start = Start { path, bytes: &bytes };
    match FORMATS.iter().find(|format| (format.fits)(&start)) {
        Some(format) => (format.open)(path, options),
        None => Err(unknown(match other_format(&start) {
            Some(other) => format!("this looks like {other}"),
            None => format!("the content is binary and begins with '{}'", shown(&bytes[..bytes.len().min(16)])),
        })),
    }
}

/// Reads one frame of a file: `index` counts from 0, or from the end where it is negative (−1 is the last).
///
/// Counting from the end passes over the file once to count its frames.
///
/// # Errors
/// [`IoError::NoSuchFrame`] tells how many there are; otherwise as [`open_particles`] and
/// [`FrameReader::next_frame`].
///
/// ```
/// use fieldstone_io::{ParticleOptions, read_frame};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("frames.xyz");
/// std::fs::write(&path, "1\nfirst\nA 0 0 0\n1\nsecond\nA 0 0 7\n")?;
/// let last = read_frame(&path, &ParticleOptions::default(), -1)?;
/// assert_eq!(last.positions(), [[0.0, 0.0, 7.0]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_frame(path: &Path, options: &ParticleOptions, index: i64) -> Result<Particles, IoError> {
    Ok(read_frame_with_warnings(path, options, index)?.0)
}

/// As [`read_frame`], with what [`FrameReader::warnings`] says of the frame.
///
/// # Errors
/// As [`read_frame`].
///
/// ```
/// use fieldstone_io::{ParticleOptions, read_frame_with_warnings};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("balls.csv");
/// std::fs::write(&path, "0 0 1 0.5\n")?;
/// let (balls, warnings) = read_frame_with_warnings(&path, &ParticleOptions::default(), 0)?;
/// assert_eq!(balls.radii()?, [0.5]);
/// assert!(warnings[0].contains("there is no line of names: the columns are taken as x y z radius"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_frame_with_warnings(
    path: &Path,
    options: &ParticleOptions,
    index: i64,
) -> Result<(Particles, Vec<String>), IoError> {
    let missing = |available| IoError::NoSuchFrame { path: path.into(), wanted: index, available };
    let from_start = if index < 0 {
        let mut reader = open_particles(path, options)?;
        let mut available = 0usize;
        while reader.skip_frame()? {
            available += 1;
        }
        let back = usize::try_from(index.unsigned_abs()).unwrap_or(usize::MAX);
        available.checked_sub(back).ok_or_else(|| missing(available))?
    } else {
        usize::try_from(index).unwrap_or(usize::MAX)
    };
    let mut reader = open_particles(path, options)?;
    for available in 0..from_start {
        if !reader.skip_frame()? {
            return Err(missing(available));
        }
    }
    let particles = reader.next_frame()?.ok_or_else(|| missing(from_start))?;
    Ok((particles, reader.warnings().to_vec()))
}

/// A reader of one frame, made from a function that reads a whole file.
#[derive(Debug, Clone)]
pub struct OneFrame<F> {
    path: PathBuf,
    read: Option<F>,
}

impl<F: FnOnce(&Path) -> Result<Particles, IoError>> OneFrame<F> {
    /// A reader whose only frame is `read(path)`, called when the frame is asked for.
    pub fn new(path: &Path, read: F) -> Self {
        Self { path: path.into(), read: Some(read) }
    }
}

impl<F: FnOnce(&Path) -> Result<Particles, IoError>> FrameReader for OneFrame<F> {
    fn next_frame(&mut self) -> Result<Option<Particles>, IoError> {
        self.read.take().map(|read| read(&self.path)).transpose()
    }

    fn skip_frame(&mut self) -> Result<bool, IoError> {
        Ok(self.read.take().is_some())
    }
}
