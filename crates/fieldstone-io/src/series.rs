//! Frames of particles with their contacts, from one file or many, one at a time.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use fieldstone_particles::{Contacts, Domain, Particles, Partner};

use crate::contact_repeats::{Repeats, repeated};
use crate::{
    ContactOptions, ContactReader, FrameRange, FrameReader, FrameStamp, IoError, ParticleOptions, Position,
    open_contacts, open_particles,
};

/// A frame of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct SeriesFrame {
    /// Place of the frame among all frames of the files, from 0.
    pub index: usize,
    /// The file that the particles come from.
    pub path: PathBuf,
    /// The particles.
    pub particles: Particles,
    /// Their contacts, those of all sources one after the other; `None` where the series has no source of contacts.
    pub contacts: Option<Contacts>,
}

/// Files of contacts that belong to the particles of a series.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ContactFiles {
    /// The files, in the order of their frames.
    pub files: Vec<PathBuf>,
    /// How to read them.
    pub options: ContactOptions,
}

/// Frames of particles, each with its contacts, read one at a time.
///
/// Contacts are matched with particles by the time step where both files state it (dumps), else by the time
/// (MercuryDPM), else by their order. Frames of contacts without particles are passed over; a frame of particles without
/// contacts is an error. Several sources of contacts (pairs and walls) are joined. After an error the series ends.
///
/// ```
/// use fieldstone_io::{FrameRange, ParticleOptions, Series, find_files};
/// # let folder = tempfile::tempdir()?;
/// for step in [9, 10, 11] {
///     std::fs::write(folder.path().join(format!("balls_{step}.csv")), format!("x,y,z,r\n0,0,{step},0.5\n"))?;
/// }
/// let pattern = folder.path().join("balls_*.csv");
/// let files = find_files(&pattern.to_string_lossy())?;
/// let series = Series::new(files, ParticleOptions::default()).with_range("1:".parse::<FrameRange>()?);
/// // Read on a thread of its own, at most one frame ahead.
/// let heights: Result<Vec<f64>, _> =
///     series.in_background(1)?.map(|frame| frame.map(|f| f.particles.positions()[0][2])).collect();
/// assert_eq!(heights?, [10.0, 11.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Series {
    files: Vec<PathBuf>,
    options: ParticleOptions,
    sources: Vec<ContactSource>,
    range: FrameRange,
    /// In place of the files' box.
    given_box: Option<Domain>,
    /// Directions that are periodic whatever the files say.
    periodic: [bool; 3],
    /// Whether the user has been told where the box is from.
    told_of_box: bool,
    /// Whether the user has been told of contacts that are listed more than once.
    told_of_repeats: bool,
    /// Time of each file, where a list of them states it.
    times: Vec<f64>,
    current: Option<(PathBuf, Box<dyn FrameReader + Send>)>,
    /// The next file to open.
    next_file: usize,
    /// Place of the next frame among all.
    next_index: usize,
    warnings: Vec<String>,
    done: bool,
}

impl Series {
    /// The frames of these files, one after the other.
    pub fn new(files: Vec<PathBuf>, options: ParticleOptions) -> Self {
        Self {
            files,
            options,
            sources: Vec::new(),
            range: FrameRange::default(),
            given_box: None,
            periodic: [false; 3],
            told_of_box: false,
            told_of_repeats: false,
            times: Vec::new(),
            current: None,
            next_file: 0,
            next_index: 0,
            warnings: Vec::new(),
            done: false,
        }
    }

    /// The same series with contacts from one more source.
    #[must_use]
    pub fn with_contacts(mut self, contacts: ContactFiles) -> Self {
        self.sources.push(ContactSource::new(contacts));
        self
    }

    /// Times of the files, one each, for frames that state none themselves.
    #[must_use]
    pub fn with_times(mut self, times: Vec<f64>) -> Self {
        self.times = times;
        self
    }

    /// Only these frames, counted over all files.
    #[must_use]
    pub fn with_range(mut self, range: FrameRange) -> Self {
        self.range = range;
        self
    }

    /// The same series in this box, whatever the files state.
    #[must_use]
    pub fn with_box(mut self, domain: Domain) -> Self {
        self.given_box = Some(domain);
        self
    }

    /// The same series with these directions periodic, beside those that the files state.
    #[must_use]
    pub fn with_periodic(mut self, periodic: [bool; 3]) -> Self {
        self.periodic = periodic;
        self
    }

    /// What the user should know about the frames read so far, one sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let mut all = self.warnings.clone();
        let open = self.current.iter().flat_map(|(_, reader)| reader.warnings());
        merge(&mut all, open.chain(self.sources.iter().flat_map(ContactSource::warnings)));
        all
    }

    /// Reads on a thread of its own, at most `ahead` frames (at least one) before the consumer.
    ///
    /// Frames and errors arrive in their order, the same as without the thread. Dropping the receiver stops the thread
    /// after the frame that it is at.
    ///
    /// # Errors
    /// [`IoError::System`] where the system grants no thread.
    pub fn in_background(mut self, ahead: usize) -> Result<BackgroundSeries, IoError> {
        let path = self.files.first().cloned().unwrap_or_default();
        let (sender, frames) = sync_channel(ahead.max(1));
        let body = move || {
            for frame in self.by_ref() {
                if sender.send(frame).is_err() {
                    break;
                }
            }
            self.warnings()
        };
        let thread = std::thread::Builder::new().name("fieldstone-series".into()).spawn(body);
        let thread = thread.map_err(|source| IoError::System { path, action: "start a thread to read", source })?;
        Ok(BackgroundSeries { frames: Some(frames), thread: Some(thread), warnings: Vec::new() })
    }

    /// Opens the next file; `false` after the last.
    fn open_next(&mut self) -> Result<bool, IoError> {
        if let Some((_, reader)) = self.current.take() {
            merge(&mut self.warnings, reader.warnings().iter());
        }
        let Some(path) = self.files.get(self.next_file) else { return Ok(false) };
        self.next_file += 1;
        self.current = Some((path.clone(), open_particles(path, &self.options)?));
        Ok(true)
    }

    fn read_next(&mut self) -> Result<Option<SeriesFrame>, IoError> {
        if self.range.from_the_end() {
            self.range = self.range.counted(self.count_frames()?);
        }
        loop {
            if self.range.is_over(self.next_index) {
                return Ok(None);
            }
            let Some((path, reader)) = &mut self.current else {
                if self.open_next()? {
                    continue;
                }
                return Ok(None);
            };
            if !self.range.contains(self.next_index) {
                if reader.skip_frame()? {
                    self.next_index += 1;
                } else if !self.open_next()? {
                    return Ok(None);
                }
                continue;
            }
            let Some(mut particles) = reader.next_frame()? else {
                if self.open_next()? {
                    continue;
                }
                return Ok(None);
            };
            let (path, index) = (path.clone(), self.next_index);
            self.next_index += 1;
            if particles.time().is_none()
                && let Some(&time) = self.times.get(self.next_file - 1)
            {
                let step = particles.step();
                particles = particles.at(step, Some(time));
            }
            for source in &mut self.sources {
                source.go_to(&path, index, &particles)?;
            }
            let particles = self.in_box(&path, particles)?;
            let mut contacts: Option<Contacts> = None;
            for source in &mut self.sources {
                let found = source.take(&path, index, &particles)?;
                match &mut contacts {
                    Some(contacts) => contacts.extend(&found),
                    None => contacts = Some(found),
                }
            }
            self.look_for_repeats(&path, index, &particles, contacts.as_ref());
            return Ok(Some(SeriesFrame { index, path, particles, contacts }));
        }
    }

    /// Notes contacts that are listed more than once: all sources together, since one may be a copy of another.
    fn look_for_repeats(&mut self, path: &Path, index: usize, particles: &Particles, contacts: Option<&Contacts>) {
        let Some(contacts) = contacts.filter(|_| !self.told_of_repeats) else { return };
        let Some(Repeats { count, with_walls, first }) = repeated(contacts) else { return };
        self.told_of_repeats = true;
        let id = |index: u32| particles.ids().map_or(i64::from(index), |ids| ids[index as usize]);
        let contact = contacts.get(first);
        let partner = match contact.partner {
            Partner::Particle(other) => format!("particle {}", id(other)),
            Partner::Wall(wall) => format!("wall {wall}"),
        };
        let files: Vec<String> = self
            .sources
            .iter()
            .filter_map(|source| source.current.as_ref())
            .map(|(path, _)| path.display().to_string())
            .collect();
        let walls = match with_walls {
            0 => String::new(),
            some => format!(
                "; {some} of them are with walls: where a wall is a mesh, each of its triangles that meet there may have its own: keep \
                 those"
            ),
        };
        self.warnings.push(format!(
            "{}: of the {} contacts of frame {index} of {}, {count} are there again with the same force and point, and count \
             again; the first is of particle {} with {partner}: give every row, and every file, once{walls}",
            files.join(", "),
            contacts.len(),
            path.display(),
            id(contact.particle)
        ));
    }

    /// The particles in their box: the one that was given, else that of their file, else that of their contacts.
    ///
    /// Without it, contacts through a periodic boundary would reach across the whole box.
    fn in_box(&mut self, path: &Path, particles: Particles) -> Result<Particles, IoError> {
        let mut domain = self.given_box.or(particles.domain().copied());
        for source in &mut self.sources {
            if domain.is_some() {
                break;
            }
            let Some((from, found)) = source.next_box()? else { continue };
            domain = Some(found);
            if !std::mem::replace(&mut self.told_of_box, true) {
                let axes: String =
                    "xyz".chars().zip(found.periodic()).filter(|(_, p)| *p).map(|(axis, _)| axis).collect();
                let axes = if axes.is_empty() { "none".into() } else { axes };
                self.warnings.push(format!(
                    "{} states no box: the box of its contacts in {} is taken (periodic directions: {axes})",
                    path.display(),
                    from.display()
                ));
            }
        }
        Ok(match domain {
            Some(domain) => {
                let stated = domain.periodic();
                particles.with_domain(domain.with_periodic([0, 1, 2].map(|k| stated[k] || self.periodic[k])))
            }
            None => particles,
        })
    }

    /// How many frames the files hold, whatever the range: all of them are gone through.
    ///
    /// # Errors
    /// As reading the frames.
    pub fn count_frames(&self) -> Result<usize, IoError> {
        let mut count = 0;
        for path in &self.files {
            let mut reader = open_particles(path, &self.options)?;
            while reader.skip_frame()? {
                count += 1;
            }
        }
        Ok(count)
    }
}

impl Iterator for Series {
    type Item = Result<SeriesFrame, IoError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.done {
            return None;
        }
        let frame = self.read_next().transpose();
        self.done = !matches!(frame, Some(Ok(_)));
        frame
    }
}

/// A [`Series`] that is read on a thread of its own.
pub struct BackgroundSeries {
    frames: Option<Receiver<Result<SeriesFrame, IoError>>>,
    thread: Option<JoinHandle<Vec<String>>>,
    warnings: Vec<String>,
}

impl BackgroundSeries {
    /// What the user should know about the frames, one sentence each; complete once the last frame has been taken.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Waits for the thread; its panic, if it had one, goes on here.
    fn join(&mut self) {
        self.frames = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(warnings)) => self.warnings = warnings,
            Some(Err(panic)) if !std::thread::panicking() => std::panic::resume_unwind(panic),
            _ => {}
        }
    }
}

impl Iterator for BackgroundSeries {
    type Item = Result<SeriesFrame, IoError>;

    fn next(&mut self) -> Option<Self::Item> {
        let frame = self.frames.as_ref()?.recv();
        if frame.is_err() {
            self.join();
        }
        frame.ok()
    }
}

impl Drop for BackgroundSeries {
    fn drop(&mut self) {
        self.join();
    }
}

fn merge<'a>(into: &mut Vec<String>, from: impl Iterator<Item = &'a String>) {
    for warning in from {
        if !into.contains(warning) {
            into.push(warning.clone());
        }
    }
}

/// One source of contacts: its files, read in step with the particles.
struct ContactSource {
    contacts: ContactFiles,
    current: Option<(PathBuf, Box<dyn ContactReader + Send>)>,
    next_file: usize,
    /// Place of the next frame among all frames of the source.
    next_index: usize,
    warnings: Vec<String>,
}

impl ContactSource {
    fn new(contacts: ContactFiles) -> Self {
        Self { contacts, current: None, next_file: 0, next_index: 0, warnings: Vec::new() }
    }

    fn warnings(&self) -> impl Iterator<Item = &String> {
        self.warnings.iter().chain(self.current.iter().flat_map(|(_, reader)| reader.warnings()))
    }

    /// Goes to the contacts of frame `index` of the particles.
    fn go_to(&mut self, particle_path: &Path, index: usize, particles: &Particles) -> Result<(), IoError> {
        let wanted = FrameStamp::of(particles);
        loop {
            let Some((path, reader)) = &mut self.current else {
                let Some(path) = self.contacts.files.get(self.next_file) else {
                    let last = self.contacts.files.last().map_or(particle_path, PathBuf::as_path);
                    return Err(missing(last, "there are no more contacts", particle_path, index, wanted));
                };
                self.next_file += 1;
                self.current = Some((path.clone(), open_contacts(path, &self.contacts.options)?));
                continue;
            };
            let Some(stamp) = reader.peek()? else {
                merge(&mut self.warnings, reader.warnings().iter());
                self.current = None;
                continue;
            };
            if self.contacts.options.in_particle_file() {
                self.next_index = index;
            }
            match stamp.compare(&wanted).unwrap_or_else(|| self.next_index.cmp(&index)) {
                Ordering::Less => {
                    reader.skip_frame()?;
                    self.next_index += 1;
                }
                Ordering::Equal => return Ok(()),
                Ordering::Greater => {
                    let what = format!("the next contacts are of {stamp}: there are none");
                    return Err(missing(path, &what, particle_path, index, wanted));
                }
            }
        }
    }

    /// The box that the contacts gone to state, and their file.
    fn next_box(&mut self) -> Result<Option<(PathBuf, Domain)>, IoError> {
        let Some((path, reader)) = &mut self.current else { return Ok(None) };
        Ok(reader.next_box()?.map(|domain| (path.clone(), domain)))
    }

    /// The contacts gone to.
    fn take(&mut self, particle_path: &Path, index: usize, particles: &Particles) -> Result<Contacts, IoError> {
        self.next_index += 1;
        let (path, found) = match &mut self.current {
            Some((path, reader)) => (path.as_path(), reader.next_frame(particles)?),
            None => (particle_path, None),
        };
        let what = "the file ends where contacts are expected";
        found.ok_or_else(|| missing(path, what, particle_path, index, FrameStamp::of(particles)))
    }
}

/// Contacts that are not there for a frame of particles.
fn missing(path: &Path, what: &str, particles: &Path, index: usize, wanted: FrameStamp) -> IoError {
    let found = format!("{what} for frame {index} of {} ({wanted})", particles.display());
    IoError::content(path, Position::File, found, "give the contacts of every frame, or a range of frames")
}
