//! Frames of particles with their contacts, from one file or many, one at a time.

use std::cmp::Ordering;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use fieldstone_particles::{Contacts, Particles};

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

    /// Only these frames, counted over all files.
    #[must_use]
    pub fn with_range(mut self, range: FrameRange) -> Self {
        self.range = range;
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
            let Some(particles) = reader.next_frame()? else {
                if self.open_next()? {
                    continue;
                }
                return Ok(None);
            };
            let (path, index) = (path.clone(), self.next_index);
            self.next_index += 1;
            let mut contacts: Option<Contacts> = None;
            for source in &mut self.sources {
                let found = source.frame_for(&path, index, &particles)?;
                match &mut contacts {
                    Some(contacts) => contacts.extend(&found),
                    None => contacts = Some(found),
                }
            }
            return Ok(Some(SeriesFrame { index, path, particles, contacts }));
        }
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

    /// The contacts of frame `index` of the particles.
    fn frame_for(&mut self, particle_path: &Path, index: usize, particles: &Particles) -> Result<Contacts, IoError> {
        let wanted = FrameStamp::of(particles);
        let missing = |path: &Path, what: String| {
            let found = format!("{what} for frame {index} of {} ({wanted})", particle_path.display());
            Err(IoError::content(path, Position::File, found, "give the contacts of every frame, or a range of frames"))
        };
        loop {
            let Some((path, reader)) = &mut self.current else {
                let Some(path) = self.contacts.files.get(self.next_file) else {
                    let last = self.contacts.files.last().map_or(particle_path, PathBuf::as_path);
                    return missing(last, "there are no more contacts".into());
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
                Ordering::Equal => {
                    let path = path.clone();
                    self.next_index += 1;
                    return match reader.next_frame(particles)? {
                        Some(contacts) => Ok(contacts),
                        None => missing(&path, "the file ends where contacts are expected".into()),
                    };
                }
                Ordering::Greater => {
                    return missing(path, format!("the next contacts are of {stamp}: there are none"));
                }
            }
        }
    }
}
