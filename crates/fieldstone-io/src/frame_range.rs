//! Which frames of a series to read, and which files they are in.

use std::cmp::Ordering;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::vtk::read_pvd;
use crate::{IoError, Position};

/// A range of frames `start:stop:step`, as in Python: from `start` on, before `stop`, every `step`-th.
///
/// Each part may be left out. Frames count from 0; negative numbers count from the end. A single number is one frame.
///
/// ```
/// use fieldstone_io::FrameRange;
/// let every_other: FrameRange = "2:7:2".parse()?;
/// assert_eq!((0..9).filter(|&frame| every_other.contains(frame)).collect::<Vec<_>>(), [2, 4, 6]);
/// // The last frame of five.
/// let last: FrameRange = "-1".parse()?;
/// assert!(last.counted(5).contains(4) && !last.counted(5).contains(3));
/// # Ok::<(), fieldstone_io::IoError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameRange {
    start: i64,
    /// `None` up to the last.
    stop: Option<i64>,
    step: usize,
}

impl Default for FrameRange {
    fn default() -> Self {
        Self { start: 0, stop: None, step: 1 }
    }
}

impl FromStr for FrameRange {
    type Err = IoError;

    fn from_str(text: &str) -> Result<Self, IoError> {
        let wrong = |why| IoError::FrameRange { text: text.into(), why };
        let number = |part: &str| part.trim().parse::<i64>().map_err(|_| wrong("a part is no whole number"));
        let optional = |part: &str| if part.trim().is_empty() { Ok(None) } else { number(part).map(Some) };
        match text.split(':').collect::<Vec<_>>().as_slice() {
            [one] => {
                let start = number(one)?;
                // After the last frame there is none to stop before.
                Ok(Self { start, stop: start.checked_add(1).filter(|&stop| stop != 0), step: 1 })
            }
            [start, stop] => Ok(Self { start: optional(start)?.unwrap_or(0), stop: optional(stop)?, step: 1 }),
            [start, stop, step] => {
                let step = optional(step)?.unwrap_or(1);
                let step =
                    usize::try_from(step).ok().filter(|&step| step > 0).ok_or_else(|| wrong("the step is below 1"))?;
                Ok(Self { start: optional(start)?.unwrap_or(0), stop: optional(stop)?, step })
            }
            _ => Err(wrong("it has more than three parts")),
        }
    }
}

/// As it is parsed: `start:stop:step`, or the number of a single frame.
impl fmt::Display for FrameRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { start, stop, step } = *self;
        if step == 1 && stop == start.checked_add(1).filter(|&next| next != 0) {
            return write!(f, "{start}");
        }
        write!(f, "{start}:{}", stop.map_or(String::new(), |stop| stop.to_string()))?;
        if step == 1 { Ok(()) } else { write!(f, ":{step}") }
    }
}

impl FrameRange {
    /// Why none of `count` frames is in this range, and which there are; as part of a sentence.
    ///
    /// ```
    /// use fieldstone_io::FrameRange;
    /// let range: FrameRange = "3:1".parse()?;
    /// assert_eq!(range.why_empty(4), "none of the 4 frames, 0 to 3, is in the range 3:1, which ends before it begins");
    /// # Ok::<(), fieldstone_io::IoError>(())
    /// ```
    pub fn why_empty(&self, count: usize) -> String {
        if count == 0 {
            return "there are no frames".into();
        }
        let there = match count {
            1 => "the only frame, 0, is not".to_string(),
            _ => format!("none of the {count} frames, 0 to {}, is", count - 1),
        };
        // Bounds from either end are compared where the number of frames is known.
        let stop = self.stop.filter(|stop| (*stop < 0) == (self.start < 0));
        let reversed = if stop.is_some_and(|stop| stop <= self.start) { ", which ends before it begins" } else { "" };
        format!("{there} in the range {self}{reversed}")
    }

    /// Whether a bound counts from the end, so that the number of frames has to be known: see [`FrameRange::counted`].
    pub fn from_the_end(&self) -> bool {
        self.start < 0 || self.stop.is_some_and(|stop| stop < 0)
    }

    /// The same range where there are `count` frames, with bounds from the start.
    #[must_use]
    pub fn counted(&self, count: usize) -> Self {
        let count = i64::try_from(count).unwrap_or(i64::MAX);
        let from_start = |bound: i64| if bound < 0 { count.saturating_add(bound).max(0) } else { bound };
        Self { start: from_start(self.start), stop: self.stop.map(from_start), step: self.step }
    }

    /// Whether frame `index` is in the range, whose bounds count from the start.
    pub fn contains(&self, index: usize) -> bool {
        let start = usize::try_from(self.start).unwrap_or(0);
        index >= start && !self.is_over(index) && (index - start).is_multiple_of(self.step)
    }

    /// Whether neither frame `index` nor any after it is in the range.
    pub fn is_over(&self, index: usize) -> bool {
        self.stop.is_some_and(|stop| usize::try_from(stop).is_ok_and(|stop| index >= stop))
    }
}

/// Files whose names fit a pattern, those with smaller numbers in their names first: `part_9.vtk` before
/// `part_10.vtk`.
///
/// In the name of the file, not of its folder, `*` stands for any text, `?` for one character, and `{}` for a number. A
/// path without any of them, or that exists as it stands, is that file. A `.pvd` stands for the files that it lists, in its
/// order.
///
/// # Errors
/// [`IoError::System`] where the folder cannot be read, or no file fits; those of [`read_pvd`].
///
/// ```
/// use fieldstone_io::find_files;
/// # let folder = tempfile::tempdir()?;
/// for name in ["part_10.vtk", "part_9.vtk", "part_old.vtk"] {
///     std::fs::write(folder.path().join(name), "")?;
/// }
/// let found = find_files(&folder.path().join("part_{}.vtk").to_string_lossy())?;
/// assert_eq!(found, [folder.path().join("part_9.vtk"), folder.path().join("part_10.vtk")]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn find_files(pattern: &str) -> Result<Vec<PathBuf>, IoError> {
    let path = Path::new(pattern);
    if is_list(path) {
        let files: Vec<PathBuf> = read_pvd(path)?.into_iter().map(|(_, file)| file).collect();
        if files.is_empty() {
            return Err(IoError::content(
                path,
                Position::File,
                "the .pvd lists no file",
                "give one with at least a <DataSet>",
            ));
        }
        return Ok(files);
    }
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    if path.exists() || !["*", "?", "{}"].iter().any(|wild| name.contains(wild)) {
        return Ok(vec![path.into()]);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let listed = folder.unwrap_or(Path::new("."));
    let failed = |source| IoError::System { path: listed.into(), action: "read", source };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(listed).map_err(failed)? {
        let entry = entry.map_err(failed)?.file_name();
        let entry = entry.to_string_lossy();
        if fits(name.as_bytes(), entry.as_bytes()) {
            found.push(entry.into_owned());
        }
    }
    if found.is_empty() {
        let source = std::io::Error::new(std::io::ErrorKind::NotFound, "no file fits this pattern");
        return Err(IoError::System { path: path.into(), action: "find", source });
    }
    found.sort_by(|a, b| by_numbers(a.as_bytes(), b.as_bytes()));
    Ok(found.into_iter().map(|name| folder.map_or_else(|| PathBuf::from(&name), |folder| folder.join(&name))).collect())
}

/// Times of the files that [`find_files`] gives, where the pattern is a `.pvd`, which states them; else none.
///
/// # Errors
/// As [`crate::vtk::read_pvd`].
///
/// ```
/// use fieldstone_io::find_times;
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("run.pvd");
/// fieldstone_io::vtk::write_pvd(&path, &[(0.0, "run_0.vtp".into()), (0.1, "run_1.vtp".into())])?;
/// assert_eq!(find_times(&path.to_string_lossy())?, [0.0, 0.1]);
/// assert!(find_times("run_*.vtp")?.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn find_times(pattern: &str) -> Result<Vec<f64>, IoError> {
    let path = Path::new(pattern);
    if !is_list(path) {
        return Ok(Vec::new());
    }
    Ok(read_pvd(path)?.into_iter().map(|(time, _)| time).collect())
}

fn is_list(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pvd")) && path.is_file()
}

/// Whether a name fits a pattern.
fn fits(pattern: &[u8], name: &[u8]) -> bool {
    // Which lengths of the name the pattern so far can stand for: no backtracking, whatever the pattern.
    let mut reached = vec![false; name.len() + 1];
    reached[0] = true;
    let mut rest = pattern;
    while let Some((&first, after)) = rest.split_first() {
        let mut next = vec![false; name.len() + 1];
        let number = rest.starts_with(b"{}");
        for at in 0..name.len() {
            match first {
                b'*' => {
                    next[at] |= reached[at];
                    next[at + 1] |= next[at];
                }
                _ if number => next[at + 1] |= name[at].is_ascii_digit() && (reached[at] || next[at]),
                b'?' => next[at + 1] |= reached[at],
                byte => next[at + 1] |= reached[at] && name[at] == byte,
            }
        }
        if first == b'*' {
            next[name.len()] |= reached[name.len()];
        }
        reached = next;
        rest = if number { &rest[2..] } else { after };
    }
    reached[name.len()]
}

/// Runs of digits by their number, everything else byte by byte.
fn by_numbers(a: &[u8], b: &[u8]) -> Ordering {
    let (mut a_rest, mut b_rest) = (a, b);
    while let (Some(x), Some(y)) = (a_rest.first(), b_rest.first()) {
        if x.is_ascii_digit() && y.is_ascii_digit() {
            let (p, after_p) = digits(a_rest);
            let (q, after_q) = digits(b_rest);
            // Without leading zeros the longer one is the larger.
            let order = p.len().cmp(&q.len()).then_with(|| p.cmp(q));
            if order != Ordering::Equal {
                return order;
            }
            (a_rest, b_rest) = (after_p, after_q);
        } else if x == y {
            (a_rest, b_rest) = (&a_rest[1..], &b_rest[1..]);
        } else {
            return x.cmp(y);
        }
    }
    // Names that differ in leading zeros only still need an order of their own.
    a_rest.len().cmp(&b_rest.len()).then_with(|| a.cmp(b))
}

/// The leading digits without leading zeros, and what follows them.
fn digits(text: &[u8]) -> (&[u8], &[u8]) {
    let end = text.iter().position(|b| !b.is_ascii_digit()).unwrap_or(text.len());
    let zeros = text[..end].iter().take_while(|&&b| b == b'0').count();
    (&text[zeros..end], &text[end..])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_fit_whole_names_only() {
        for (pattern, name, expected) in [
            ("part_*.vtk", "part_12.vtk", true),
            ("part_*.vtk", "part_.vtk", true),
            ("part_{}.vtk", "part_12.vtk", true),
            ("part_{}.vtk", "part_.vtk", false),
            ("part_{}.vtk", "part_1a.vtk", false),
            ("part_?.vtk", "part_12.vtk", false),
            ("*", "", true),
            ("a*b*c", "a-bb-c", true),
            ("a*b*c", "a-bb-", false),
            ("{}{}", "12", true),
            ("{}{}", "1", false),
        ] {
            assert_eq!(fits(pattern.as_bytes(), name.as_bytes()), expected, "{pattern} {name}");
        }
    }

    #[test]
    fn names_are_sorted_by_the_numbers_in_them() {
        let mut names = ["b1", "a10.2", "a10", "a9", "a010", "a2"];
        names.sort_by(|a, b| by_numbers(a.as_bytes(), b.as_bytes()));
        assert_eq!(names, ["a2", "a9", "a010", "a10", "a10.2", "b1"]);
    }

    #[test]
    fn ranges_that_are_none_say_what_one_looks_like() {
        for bad in ["", "a", "1:2:3:4", "1:2:0", "1:2:-1", "1.5"] {
            assert!(bad.parse::<FrameRange>().unwrap_err().to_string().contains("10:20"), "{bad}");
        }
    }

    #[test]
    fn ranges_are_written_as_they_are_read() {
        for text in ["3", "0", "-2", "-1", "3:1", "1:5", "1:5:2", "0:", "-1:0", "-3:-1", "2::3"] {
            let range: FrameRange = text.parse().unwrap();
            let shown = range.to_string();
            assert_eq!(shown.parse::<FrameRange>().unwrap(), range, "{text} {shown}");
            assert_eq!(shown, text);
        }
    }

    #[test]
    fn an_empty_range_tells_which_frames_there_are() {
        for (range, count, expected) in [
            ("5", 3, "none of the 3 frames, 0 to 2, is in the range 5"),
            ("-4", 3, "none of the 3 frames, 0 to 2, is in the range -4"),
            ("5:9", 1, "the only frame, 0, is not in the range 5:9"),
            ("-1:-3", 4, "none of the 4 frames, 0 to 3, is in the range -1:-3, which ends before it begins"),
            ("3:1", 0, "there are no frames"),
        ] {
            assert_eq!(range.parse::<FrameRange>().unwrap().why_empty(count), expected);
        }
    }

    #[test]
    fn bounds_from_the_end_are_cut_at_the_first_frame() {
        let range = "-3:-1".parse::<FrameRange>().unwrap();
        let frames = |count| (0..count).filter(|&k| range.counted(count).contains(k)).collect::<Vec<_>>();
        assert_eq!((frames(5), frames(2)), (vec![2, 3], vec![0]));
    }
}
