//! Which time a frame is of, and whether times rise from frame to frame.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use anyhow::bail;
use fieldstone::io::{ParticleOptions, Series};
use fieldstone::particles::Particles;

/// Times of frames: their own, else by their step, else by the number in the name of their file, else by their place.
pub(super) struct Clock {
    time_step: f64,
    /// Steps by the files' names.
    named: HashMap<PathBuf, i64>,
}

impl Clock {
    /// The clock of a series of which `first` is a frame; with a note for the user where frames have neither times nor
    /// steps nor numbers in their names.
    pub fn new(
        files: &[PathBuf],
        options: ParticleOptions,
        time_step: Option<f64>,
        first: &Particles,
    ) -> anyhow::Result<(Self, Option<String>)> {
        let mut clock = Self { time_step: time_step.unwrap_or(1.0), named: HashMap::new() };
        if first.time().is_some() || first.step().is_some() {
            return Ok((clock, None));
        }
        // A file of several frames has one name for all of them.
        if let Some(numbers) = numbers_in(files)
            && Series::new(vec![files[0].clone()], options).count_frames()? == 1
        {
            clock.named = files.iter().cloned().zip(numbers).collect();
            return Ok((clock, None));
        }
        let note = format!(
            "{}: the frames state neither time nor step, and there is no rising number in names of files: they are taken to \
             be equally spaced, {} apart in time",
            files[0].display(),
            clock.time_step
        );
        Ok((clock, Some(note)))
    }

    /// Time that a frame is taken to be of.
    pub fn time_of(&self, path: &Path, index: usize, particles: &Particles) -> f64 {
        let named = || self.named.get(path).copied();
        let step = particles.step().or_else(named).map_or(index as f64, |step| step as f64);
        particles.time().unwrap_or(self.time_step * step)
    }
}

/// The number in each name that tells several files apart: their names are the same but for it, and it rises.
fn numbers_in(files: &[PathBuf]) -> Option<Vec<i64>> {
    if files.len() < 2 {
        return None;
    }
    let names: Vec<(Vec<&str>, Vec<&str>)> =
        files.iter().map(|file| file.file_name()?.to_str().map(parts)).collect::<Option<_>>()?;
    let (around, _) = &names[0];
    if names.iter().any(|(other, _)| other != around) {
        return None;
    }
    let mut different = (0..names[0].1.len()).filter(|&k| names.iter().any(|(_, digits)| digits[k] != names[0].1[k]));
    let (Some(at), None) = (different.next(), different.next()) else { return None };
    let numbers: Vec<i64> = names.iter().map(|(_, digits)| digits[at].parse().ok()).collect::<Option<_>>()?;
    numbers.is_sorted_by(|a, b| a < b).then_some(numbers)
}

/// What stands before, between and after the runs of digits in a name, and those runs.
///
/// A piece that is empty is one, too: names whose pieces are the same have as many runs, in the same places.
fn parts(name: &str) -> (Vec<&str>, Vec<&str>) {
    let (mut around, mut digits, mut rest) = (Vec::new(), Vec::new(), name);
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let (before, run) = rest.split_at(start);
        let (run, after) = run.split_at(run.find(|c: char| !c.is_ascii_digit()).unwrap_or(run.len()));
        around.push(before);
        digits.push(run);
        rest = after;
    }
    around.push(rest);
    (around, digits)
}

/// Watches over frames whose times do not rise.
#[derive(Default)]
pub(super) struct TimeOrder {
    /// What cannot be computed of such frames.
    refused: Option<&'static str>,
    last: Option<(f64, String)>,
    /// The first two.
    found: Option<String>,
    count: usize,
}

impl TimeOrder {
    pub fn new(refused: Option<&'static str>) -> Self {
        Self { refused, ..Self::default() }
    }

    /// Takes the next frame.
    pub fn add(&mut self, time: f64, name: &str) -> anyhow::Result<()> {
        if let Some((before, earlier)) = self.last.replace((time, name.into()))
            && time <= before
        {
            let found = format!("{name}: its time is {time}, and that of the frame before it, {earlier}, is {before}");
            if let Some(what) = self.refused {
                bail!(
                    "{found}: {what} needs times that rise; give the frames in their order, each once (--particles, --frames)"
                );
            }
            self.found.get_or_insert(found);
            self.count += 1;
        }
        Ok(())
    }

    /// What the user should know.
    pub fn warning(&self) -> Option<String> {
        let more = if self.count > 1 { format!(" (and {} more like this)", self.count - 1) } else { String::new() };
        let found = self.found.as_ref()?;
        Some(format!("{found}{more}: times do not rise; the frames are kept in the order of the files"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_that_tells_files_apart_is_their_step() {
        let of = |names: &[&str]| numbers_in(&names.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(of(&["a/part_26000.vtk", "a/part_30000.vtk"]), Some(vec![26000, 30000]));
        assert_eq!(of(&["run2_9.vtk.gz", "run2_10.vtk.gz"]), Some(vec![9, 10]));
        for none in [
            &["one_5.vtk"][..],
            &["a.vtk", "b.vtk"],
            &["a_1_5.vtk", "a_2_6.vtk"],
            &["a_1.vtk", "b_2.vtk"],
            &["a_2.vtk", "a_1.vtk"],
            &["a_99999999999999999999.vtk", "a_99999999999999999998.vtk"],
        ] {
            assert_eq!(of(none), None, "{none:?}");
        }
    }

    #[test]
    fn names_with_numbers_in_other_places_tell_no_steps() {
        for names in [["out.csv", "1out.csv"], ["1out.csv", "out.csv"], ["run2.csv", "5run2.csv"], ["1out", "out2"]] {
            assert_eq!(numbers_in(&names.map(PathBuf::from)), None, "{names:?}");
        }
        assert_eq!(numbers_in(&["1out", "2out"].map(PathBuf::from)), Some(vec![1, 2]));
    }
}
