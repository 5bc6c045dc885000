//! Where tests find their data.
//!
//! Small files are in the repository's `data` folder and are always there. Larger sets live beside the
//! checkout, in `../shared/data`, or wherever `FIELDSTONE_DATA` points; a test that needs one of them asks
//! [`extended`] and returns early, saying so, where the set is missing.

pub mod pairs;
mod random;

use std::io::Read;
use std::path::{Path, PathBuf};

pub use random::Random;

/// The repository's root.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().expect("the repository exists")
}

/// A file or folder of the data in the repository: below `data`, or among the demo's input.
///
/// ```
/// assert!(fieldstone_testing::data("overlap-cases").is_dir());
/// assert!(fieldstone_testing::data("bed_twist").is_dir());
/// ```
pub fn data(name: &str) -> PathBuf {
    let path = repository().join("data").join(name);
    if path.exists() { path } else { repository().join("crates/fieldstone/demo").join(name) }
}

/// A file or folder of the extended data sets; `None`, said on standard error, where it is missing.
pub fn extended(name: &str) -> Option<PathBuf> {
    let root = std::env::var_os("FIELDSTONE_DATA").map_or_else(|| repository().join("../shared/data"), PathBuf::from);
    let path = root.join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("not run on {name}: no such data set in {} (set FIELDSTONE_DATA)", root.display());
    None
}

/// Content of a text file, decompressed where its name ends in `.gz`.
///
/// # Panics
/// Where the file cannot be read: a test without its data must not pass.
pub fn read_text(path: &Path) -> String {
    let raw = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut text = String::new();
    if path.extension().is_some_and(|e| e == "gz") {
        flate2::read::GzDecoder::new(&raw[..]).read_to_string(&mut text).expect("valid gzip");
    } else {
        text = String::from_utf8(raw).expect("valid UTF-8");
    }
    text
}
