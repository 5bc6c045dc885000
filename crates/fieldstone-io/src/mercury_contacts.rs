//! MercuryDPM's `.fstat` files.

use std::path::Path;

use fieldstone_particles::{Contacts, Particles, Partner};

use crate::contact_assembly::{ContactAssembly, Row, Touch, length};
use crate::contacts::check_stamp;
use crate::frames::unless_failed;
use crate::line_blocks::Line;
use crate::lines::{LineReader, number, shown, skip_blanks, words};
use crate::{ContactReader, FrameStamp, IoError};

/// What the lines before a frame begin with.
const COMMENT: &[u8] = b"#";
const REPAIR: &str = "correct the row, or write the file again";

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

    fn read_frame(&mut self, particles: &Particles) -> Result<Option<Contacts>, IoError> {
        let Some(stamp) = self.look_ahead()? else { return Ok(None) };
        self.ahead = None;
        let path = self.lines.path().to_path_buf();
        check_stamp(&path, self.lines.number(), stamp, particles)?;
        let radii = particles.radii().map_err(|source| IoError::Particles { path: path.clone(), source })?;
        let mut assembly = ContactAssembly::new(particles, &path);
        loop {
            let block = self.lines.take_lines(u64::MAX, COMMENT)?;
            if block.is_empty() {
                break;
            }
            let parts = block.parse(|lines| {
                let mut rows = Vec::with_capacity(lines.size_hint().0);
                for line in lines.filter(|line| !line.bytes.trim_ascii_start().is_empty()) {
                    rows.push(row(&line, &path, particles, radii)?);
                }
                Ok(rows)
            })?;
            assembly.append(parts);
            self.lines.reuse(block);
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

    fn pass_frame(&mut self) -> Result<bool, IoError> {
        if self.look_ahead()?.is_none() {
            return Ok(false);
        }
        self.ahead = None;
        loop {
            let block = self.lines.take_lines(u64::MAX, COMMENT)?;
            if block.is_empty() {
                break;
            }
            self.lines.reuse(block);
        }
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

/// The 16 numbers of a row.
///
/// Each is parsed where it stands; only a row that is wrong is taken apart word by word, to say what is wrong with it.
fn numbers(line: &Line<'_>, path: &Path) -> Result<[f64; 16], IoError> {
    let bytes = line.bytes;
    let mut values = [0.0; 16];
    let mut at = skip_blanks(bytes, 0);
    for value in &mut values {
        match fast_float2::parse_partial::<f64, _>(&bytes[at..]) {
            Ok((found, length)) if found.is_finite() && bytes.get(at + length).is_none_or(u8::is_ascii_whitespace) => {
                *value = found;
                at = skip_blanks(bytes, at + length);
            }
            _ => return Err(fault(line, path)),
        }
    }
    if at == bytes.len() { Ok(values) } else { Err(fault(line, path)) }
}

/// What is wrong with a row that has not 16 finite numbers.
fn fault(line: &Line<'_>, path: &Path) -> IoError {
    for (column, word) in words(line.bytes).enumerate().take(16) {
        if !number(word).is_some_and(f64::is_finite) {
            let found = format!("column {} '{}' holds '{}'", column + 1, COLUMNS[column], shown(word));
            return line.place.error(path, found + ", which is no finite number", REPAIR);
        }
    }
    let found = format!("the row has {} columns; 16 are expected: {}", words(line.bytes).count(), COLUMNS.join(" "));
    let cut = "the file is cut, or still being written; earlier frames can be read";
    line.place.error(path, found, if line.place.complete { REPAIR } else { cut })
}

/// The contact in a row.
fn row(line: &Line<'_>, path: &Path, particles: &Particles, radii: &[f64]) -> Result<Row, IoError> {
    let values = numbers(line, path)?;
    let [_, i, j, cx, cy, cz, overlap, _, normal, tangential, nx, ny, nz, tx, ty, tz] = values;
    // Numbers tell integers apart up to 2⁵³, far beyond any number of particles.
    let whole = |x: f64| (x.fract() == 0.0 && x.abs() <= 9_007_199_254_740_992.0).then_some(x as i64);
    let (Some(i), Some(j)) = (whole(i), whole(j)) else {
        return Err(line.place.error(path, "columns 2 and 3 do not hold the indices of the two bodies", REPAIR));
    };
    let index = |of: i64| {
        u32::try_from(of).ok().filter(|&k| (k as usize) < particles.len()).ok_or_else(|| {
            let found = format!("the contact names particle {of}, but there are {} from 0 on", particles.len());
            line.place.error(path, found, "give the .data file of the same run, with all of its particles")
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
    Ok(Row { particle, partner, force, normal_force: None, touch, line: line.place.number })
}
