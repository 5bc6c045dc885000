//! Opening files: compressed or not, with errors that name them.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

use crate::IoError;

/// A buffered byte stream over the file's content, decompressed where the file is gzip by its first bytes.
///
/// # Errors
/// [`IoError::System`] where the file cannot be opened or is a folder.
pub fn open(path: &Path) -> Result<BufReader<Box<dyn Read + Send>>, IoError> {
    let system = |source| IoError::System { path: path.into(), action: "open", source };
    let file = File::open(path).map_err(system)?;
    if file.metadata().map_err(system)?.is_dir() {
        return Err(system(std::io::Error::new(std::io::ErrorKind::IsADirectory, "it is a folder")));
    }
    let mut raw = BufReader::with_capacity(1 << 16, file);
    let gzip = std::io::BufRead::fill_buf(&mut raw).map_err(system)?.starts_with(&[0x1f, 0x8b]);
    let stream: Box<dyn Read + Send> = if gzip { Box::new(MultiGzDecoder::new(raw)) } else { Box::new(raw) };
    Ok(BufReader::with_capacity(1 << 18, stream))
}

/// The file's whole content, decompressed where it is gzip.
///
/// # Errors
/// [`IoError::System`] where it cannot be opened or read, a truncated gzip stream included.
pub fn read_all(path: &Path) -> Result<Vec<u8>, IoError> {
    let mut content = Vec::new();
    open(path)?.read_to_end(&mut content).map_err(|source| IoError::System {
        path: path.into(),
        action: "read",
        source,
    })?;
    Ok(content)
}
