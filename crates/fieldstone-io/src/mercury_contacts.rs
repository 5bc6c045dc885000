//! MercuryDPM's `.fstat` files.

use std::path::Path;

use fieldstone_particles::{Contacts, Particles, Partner};

use crate::contact_assembly::{ContactAssembly, Row, Touch, length};
use crate::contacts::check_stamp;
use crate::frames::unless_failed;
use crate::lines::{LineReader, integer, number, shown, skip_blanks, words};
use crate::{ContactReader, FrameStamp, IoError};

const COLUMNS: [&str; 16] =
    ["t", "i", "j", "cx", "cy", "cz", "delta", "deltat", "fn", "ft", "nx", "ny", "nz", "tx", "ty", "tz"];

/// Reads the contacts of a MercuryDPM `.fstat` file, frame by frame, compressed or not.
///
/// A frame is three lines that begin with `#`, the first with the time, and rows `t i j cx cy cz δ δt fn ft nx ny nz tx ty
/// tz`. Particles are named by their place in the `.data` file. Pairs are listed from both sides and taken once. The force
/// on particle i is
///
/// $$ f = f_n n + f_t t, $$
///
/// the opposite for a wall, whose number −1, −2, … becomes 0, 1, … as in the `.restart` file. Both rows of a pair
/// through a periodic boundary have the same image's contact point, so it is rebuilt: the arm is $-(R_i - \delta/2)\,n$
/// and the partner is the image at about $-(R_i + R_j - \delta)\,n$. This needs no knowledge of the boundaries.
pub struct MercuryContactReader {
    lines: LineReader,
    /// Time of the frame whose header has been read.
    ahead: Option<f64>,
    frame: usize,
    warnings: Vec<String>,
    failed: bool,
}

impl MercuryContactReader {
    /// Opens an `.fstat` file.
    ///
    /// # Errors
    /// [`IoError::System`] where the file cannot be opened.
    pub fn open(path: &Path) -> Result<Self, IoError> {
        let lines = LineReader::open(path)?;
        Ok(Self { lines, ahead: None, frame: 0, warnings: Vec::new(), failed: false })
    }

    /// Whether a file that starts like this is an `.fstat` file: three comments of 2, 6 and 6 or more numbers.
    pub(crate) fn fits(start: &[u8]) -> bool {
        let mut lines = start.split(|&b| b == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty());
        let mut numbers = || {
            let comment = lines.next()?.strip_prefix(b"#")?;
            words(comment).map(number).collect::<Option<Vec<f64>>>().map(|found| found.len())
        };
        numbers().is_some_and(|n| n >= 1) && numbers() == Some(6) && numbers().is_some_and(|n| n >= 2)
    }

    fn look_ahead(&mut self) -> Result<Option<FrameStamp>, IoError> {
        if self.ahead.is_none() {
            self.ahead = self.head()?;
        }
        Ok(self.ahead.map(|time| FrameStamp { step: None, time: Some(time) }))
    }

    /// Reads the three lines before the rows.
    fn head(&mut self) -> Result<Option<f64>, IoError> {
        loop {
            if !self.lines.advance()? {
                return Ok(None);
            }
            if skip_blanks(self.lines.line(), 0) < self.lines.line().len() {
                break;
            }
        }
        let time = self.lines.line().trim_ascii().strip_prefix(b"#").and_then(|rest| number(words(rest).next()?));
        let Some(time) = time.filter(|time| time.is_finite()) else {
            let line = shown(self.lines.line());
            let found = format!("'{line}' stands where the header of frame {} is expected: # t …", self.frame);
            return Err(self.lines.error(found, "this is no MercuryDPM .fstat file, or it is damaged"));
        };
        for _ in 0..2 {
            if !self.lines.advance()? {
                let found = format!("the file ends within the header of frame {}", self.frame);
                return Err(self.lines.error(found, "the file is cut, or still being written"));
            }
            if !self.lines.line().trim_ascii_start().starts_with(b"#") {
                let found = "the header of a frame has three lines that begin with #";
                return Err(self.lines.error(found, "this is no MercuryDPM .fstat file, or it is damaged"));
            }
        }
        Ok(Some(time))
    }

    /// Goes to the next row; `false` at the end of the frame.
    fn next_row(&mut self) -> Result<bool, IoError> {
        while self.lines.advance()? {
            let line = self.lines.line().trim_ascii_start();
            if line.starts_with(b"#") {
                self.lines.stay();
                return Ok(false);
            }
            if !line.is_empty() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn read_frame(&mut self, particles: &Particles) -> Result<Option<Contacts>, IoError> {
        let Some(stamp) = self.look_ahead()? else { return Ok(None) };
        self.ahead = None;
        let path = self.lines.path().to_path_buf();
        check_stamp(&path, self.lines.number(), stamp, particles)?;
        let radii = particles.radii().map_err(|source| IoError::Particles { path: path.clone(), source })?;
        let mut assembly = ContactAssembly::new(particles, &path);
        while self.next_row()? {
            let row = self.row(particles, radii)?;
            assembly.push(row);
        }
        let (contacts, warnings) = assembly.finish()?;
        for warning in warnings {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
        self.frame += 1;
        Ok(Some(contacts))
    }

    fn row(&self, particles: &Particles, radii: &[f64]) -> Result<Row, IoError> {
        let repair = "correct the row, or write the file again";
        let line = self.lines.line();
        let mut values = [0.0; 16];
        let mut count = 0;
        for word in words(line) {
            if let Some(slot) = values.get_mut(count) {
                *slot = number(word).filter(|value| value.is_finite()).ok_or_else(|| {
                    let found = format!("column {} '{}' holds '{}'", count + 1, COLUMNS[count], shown(word));
                    self.lines.error(found + ", which is no finite number", repair)
                })?;
            }
            count += 1;
        }
        if count != 16 {
            let found = format!("the row has {count} columns; 16 are expected: {}", COLUMNS.join(" "));
            let cut = "the file is cut, or still being written; earlier frames can be read";
            return Err(self.lines.error(found, if self.lines.complete() { repair } else { cut }));
        }
        let [_, _, _, cx, cy, cz, overlap, _, normal, tangential, nx, ny, nz, tx, ty, tz] = values;
        let mut indices = words(line).skip(1).map(integer);
        let (Some(Some(i)), Some(Some(j))) = (indices.next(), indices.next()) else {
            return Err(self.lines.error("columns 2 and 3 do not hold the indices of the two bodies", repair));
        };
        let index = |of: i64| {
            u32::try_from(of).ok().filter(|&k| (k as usize) < particles.len()).ok_or_else(|| {
                let found = format!("the contact names particle {of}, but there are {} from 0 on", particles.len());
                self.lines.error(found, "give the .data file of the same run, with all of its particles")
            })
        };
        let particle = index(i)?;
        let n = [nx, ny, nz];
        let own = radii[particle as usize] - 0.5 * overlap;
        let force = [normal * nx + tangential * tx, normal * ny + tangential * ty, normal * nz + tangential * tz];
        let along = |factor: f64| n.map(|component| factor * component);
        let (partner, force, touch) = if j < 0 {
            let centre = particles.positions()[particle as usize];
            let stated = [cx - centre[0], cy - centre[1], cz - centre[2]];
            // The stated point may be of another image; on walls n points into the wall.
            let near = length(stated) <= 1.5 * radii[particle as usize];
            let arm = if near { stated } else { along(own) };
            (Partner::Wall(-(j + 1)), force.map(|f| -f), Touch::Vectors { arm, branch: arm })
        } else {
            let other = index(j)?;
            let reach = radii[particle as usize] + radii[other as usize] - overlap;
            (Partner::Particle(other), force, Touch::Vectors { arm: along(-own), branch: along(-reach) })
        };
        Ok(Row { particle, partner, force, normal_force: None, touch, line: self.lines.number() })
    }

    fn pass_frame(&mut self) -> Result<bool, IoError> {
        if self.look_ahead()?.is_none() {
            return Ok(false);
        }
        self.ahead = None;
        while self.next_row()? {}
        self.frame += 1;
        Ok(true)
    }
}

impl ContactReader for MercuryContactReader {
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
        &self.warnings
    }
}
