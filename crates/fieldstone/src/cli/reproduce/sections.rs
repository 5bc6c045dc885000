//! Figure by figure: what each has to say, how long it took, and the page with all of them.

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, anyhow};
use clap::ValueEnum;
use fieldstone::io::AtomicFile;

use super::{clock, report};

/// What a figure has to say, and what it took.
pub(super) struct Section {
    text: String,
    seconds: f64,
    processor_seconds: f64,
}

/// Makes the folder for the results.
pub(super) fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)
        .map_err(|e| anyhow!("{}: cannot make the folder: {e}; give another", folder.display()))
}

/// Computes all figures in order, or those named only.
pub(super) fn compute<F: ValueEnum + PartialEq>(
    only: &[F],
    mut figure: impl FnMut(&F) -> Result<String>,
) -> Result<Vec<Section>> {
    let wanted = F::value_variants().iter().filter(|figure| only.is_empty() || only.contains(figure));
    wanted
        .map(|wanted| {
            let start = (Instant::now(), clock::process_seconds());
            let text = figure(wanted)?;
            let processor_seconds = clock::process_seconds() - start.1;
            Ok(Section { text, seconds: start.0.elapsed().as_secs_f64(), processor_seconds })
        })
        .collect()
}

/// Seconds that all sections took, and seconds of processor time.
pub(super) fn took(sections: &[Section]) -> (f64, f64) {
    sections.iter().fold((0.0, 0.0), |(a, b), s| (a + s.seconds, b + s.processor_seconds))
}

/// Writes index.md, and prints where it is.
pub(super) fn write_page(folder: &Path, head: String, sections: &[Section]) -> Result<()> {
    let mut text = head;
    for section in sections {
        text.push_str(&section.text);
        text.push('\n');
    }
    let path = folder.join("index.md");
    AtomicFile::write(&path, |out| out.write_all(text.trim_end().as_bytes()).and_then(|()| writeln!(out)))?;
    report::print(&format!("written to           {}\n", path.display()))
}
