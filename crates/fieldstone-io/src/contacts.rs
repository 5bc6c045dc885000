//! Which reader a file of contacts needs.

use std::io::Read;
use std::path::Path;
use std::str::FromStr;

use fieldstone_particles::{Contacts, Domain, Particles};
use serde::{Deserialize, Serialize};

use crate::contact_columns::ContactColumns;
use crate::contact_dump::ContactDumpReader;
use crate::contact_table::ContactTableReader;
use crate::lammps_walls::LammpsWallReader;
use crate::mercury_contacts::MercuryContactReader;
use crate::{IoError, Position, source};

/// Step and time of a frame, as far as its source states them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameStamp {
    /// Time step.
    pub step: Option<i64>,
    /// Time.
    pub time: Option<f64>,
}

impl FrameStamp {
    /// The stamp of a frame of particles.
    pub fn of(particles: &Particles) -> Self {
        Self { step: particles.step(), time: particles.time() }
    }

    /// How this frame stands to another: by step where both state it, else by time; `None` where neither can tell.
    ///
    /// Times are equal within 10⁻⁶ of their size, since programs print them with different numbers of digits.
    ///
    /// ```
    /// use std::cmp::Ordering;
    /// use fieldstone_io::FrameStamp;
    /// let a = FrameStamp { step: Some(100), time: None };
    /// let b = FrameStamp { step: Some(200), time: Some(0.1) };
    /// assert_eq!(a.compare(&b), Some(Ordering::Less));
    /// assert_eq!(a.compare(&FrameStamp { step: None, time: Some(0.1) }), None);
    /// ```
    pub fn compare(&self, other: &Self) -> Option<std::cmp::Ordering> {
        if let (Some(own), Some(other)) = (self.step, other.step) {
            return Some(own.cmp(&other));
        }
        let (own, other) = (self.time?, other.time?);
        if (own - other).abs() <= 1e-6 * own.abs().max(other.abs()) {
            return Some(std::cmp::Ordering::Equal);
        }
        own.partial_cmp(&other)
    }
}

impl std::fmt::Display for FrameStamp {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.step, self.time) {
            (Some(step), _) => write!(f, "step {step}"),
            (None, Some(time)) => write!(f, "time {time}"),
            (None, None) => write!(f, "neither step nor time"),
        }
    }
}

/// A file of contact frames that is read from front to back, together with the particles of the same frames.
///
/// Pairs may be listed once or twice, once from either side with the opposite force: the reader tells by the mirrored
/// rows, takes each pair once, and says so among its warnings.
pub trait ContactReader {
    /// Step and time of the next frame, which stays the next one; `None` after the last.
    ///
    /// # Errors
    /// [`IoError`] with the line where the content stops making sense.
    fn peek(&mut self) -> Result<Option<FrameStamp>, IoError>;

    /// The box that the next frame states, with its periodic directions; `None` where it states none.
    ///
    /// # Errors
    /// As [`ContactReader::peek`].
    fn next_box(&mut self) -> Result<Option<Domain>, IoError> {
        Ok(None)
    }

    /// The next frame, resolved against the particles of the same frame; `None` after the last.
    ///
    /// # Errors
    /// As [`ContactReader::peek`]; a contact of a particle that is not there; a step or time other than the
    /// particles'.
    fn next_frame(&mut self, particles: &Particles) -> Result<Option<Contacts>, IoError>;

    /// Passes over the next frame; `false` after the last.
    ///
    /// # Errors
    /// As [`ContactReader::peek`].
    fn skip_frame(&mut self) -> Result<bool, IoError>;

    /// What the user should know about the frames read so far, one sentence each.
    fn warnings(&self) -> &[String];
}

/// Programs whose order of columns is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactPreset {
    /// LIGGGHTS `compute pair/gran/local` with all keywords, in a `dump local`.
    LiggghtsPair,
    /// LIGGGHTS `compute wall/gran/local`, in a `dump local`.
    LiggghtsWall,
    /// LAMMPS `compute pair/local dist force fx fy fz p1 p2 p3` and `compute property/local patom1 patom2`, in a
    /// `dump local`; the column `force` may be missing.
    LammpsPair,
    /// LAMMPS `fix wall/gran … contacts`, whose eight columns stand in the dump of the particles.
    LammpsWall,
    /// MercuryDPM `.fstat`.
    Mercury,
}

impl ContactPreset {
    /// All presets with their names.
    pub const ALL: [(&'static str, Self); 5] = [
        ("liggghts-pair", Self::LiggghtsPair),
        ("liggghts-wall", Self::LiggghtsWall),
        ("lammps-pair", Self::LammpsPair),
        ("lammps-wall", Self::LammpsWall),
        ("mercury", Self::Mercury),
    ];
}

impl FromStr for ContactPreset {
    type Err = IoError;

    fn from_str(text: &str) -> Result<Self, IoError> {
        let known = Self::ALL.iter().find(|(name, _)| *name == text).map(|&(_, preset)| preset);
        known.ok_or_else(|| IoError::UnknownPreset {
            name: text.into(),
            known: Self::ALL.map(|(name, _)| name).join(", "),
        })
    }
}

/// Options for reading contacts.
///
/// Neither is needed for MercuryDPM's `.fstat` and for tables whose header uses common names. A dump's columns are
/// called by the computes' names, so one of the two has to say what they are.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContactOptions {
    /// Whose order of columns the file has.
    pub preset: Option<ContactPreset>,
    /// Columns by name; they go before the preset.
    pub columns: Option<ContactColumns>,
}

impl ContactOptions {
    /// Whether the contacts are columns of the particles, not frames of a file of their own.
    pub(crate) fn in_particle_file(&self) -> bool {
        self.preset == Some(ContactPreset::LammpsWall)
    }
}

/// Opens a file of contacts, compressed or not, deciding on the format by its content and on the columns by the options.
///
/// # Errors
/// [`IoError::UnknownFormat`], [`IoError::System`]; [`IoError::Content`] for a dump without preset and columns. What is
/// wrong inside is found while frames are read.
///
/// ```
/// use fieldstone_io::{ContactOptions, open_contacts};
/// use fieldstone_particles::Particles;
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("contacts.csv");
/// std::fs::write(&path, "id1,id2,fx,fy,fz,cx,cy,cz\n7,9,-2,0,0,0.5,0,0\n7,,0,0,3,0,0,-0.5\n")?;
/// let particles = Particles::new(vec![[0.0; 3], [1.0, 0.0, 0.0]])?.with_ids(vec![7, 9])?;
/// let mut reader = open_contacts(&path, &ContactOptions::default())?;
/// let contacts = reader.next_frame(&particles)?.expect("one frame");
/// assert_eq!(contacts.force_sums(2), [[-2.0, 0.0, 3.0], [2.0, 0.0, 0.0]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn open_contacts(path: &Path, options: &ContactOptions) -> Result<Box<dyn ContactReader + Send>, IoError> {
    let mut start = Vec::new();
    let read = source::open(path)?.take(1 << 12).read_to_end(&mut start);
    read.map_err(|source| IoError::System { path: path.into(), action: "read", source })?;
    if options.preset == Some(ContactPreset::LammpsWall) {
        return Ok(Box::new(LammpsWallReader::new(path)));
    }
    if start.trim_ascii_start().starts_with(b"ITEM:") {
        return Ok(Box::new(ContactDumpReader::open(path, options)?));
    }
    let unknown = |found: &str| IoError::UnknownFormat {
        path: path.into(),
        found: found.into(),
        readable: "LIGGGHTS and LAMMPS dumps of local entries, MercuryDPM .fstat, tables (CSV)".into(),
    };
    if start.trim_ascii().is_empty() {
        return Err(unknown("the file is empty"));
    }
    if start.contains(&0) {
        return Err(unknown("the content is binary"));
    }
    let mercury = MercuryContactReader::fits(&start);
    let expected = mercury.then_some(ContactPreset::Mercury);
    if let Some(preset) = options.preset.filter(|&preset| Some(preset) != expected) {
        let name = ContactPreset::ALL.iter().find(|(_, p)| *p == preset).map_or("", |(name, _)| name);
        let found = format!("the file is not what the preset {name} is for");
        let remedy = "leave out the preset, or give the file that it is for";
        return Err(IoError::content(path, Position::File, found, remedy));
    }
    if mercury {
        if options.columns.is_some() {
            let found = "a MercuryDPM .fstat file has no names for its columns";
            return Err(IoError::content(path, Position::File, found, "leave out the mapping: its order is known"));
        }
        return Ok(Box::new(MercuryContactReader::open(path)?));
    }
    Ok(Box::new(ContactTableReader::open(path, options)?))
}

/// Refuses contacts of another frame than the particles'.
pub(crate) fn check_stamp(path: &Path, line: u64, own: FrameStamp, particles: &Particles) -> Result<(), IoError> {
    let theirs = FrameStamp::of(particles);
    if own.compare(&theirs).is_none_or(std::cmp::Ordering::is_eq) {
        return Ok(());
    }
    let found = format!("the contacts are of {own}, the particles of {theirs}");
    Err(IoError::content(path, Position::Line(line), found, "give particles and contacts of the same frame"))
}
