//! Opening files: compressed or not, with errors that name them.

use std::fs::File;
use std::io::{BufReader, Error, ErrorKind, Read};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

use crate::IoError;

/// A buffered byte stream over the file's content, decompressed where the file is gzip by its first bytes.
///
/// # Errors
/// [`IoError::System`] where the file cannot be opened, or is a folder, a pipe or a device.
pub fn open(path: &Path) -> Result<BufReader<Box<dyn Read + Send>>, IoError> {
    let system = |source| IoError::System { path: path.into(), action: "open", source };
    // Before opening: that would wait for the other end of a pipe.
    let metadata = std::fs::metadata(path).map_err(system)?;
    if metadata.is_dir() {
        return Err(system(Error::new(ErrorKind::IsADirectory, "it is a folder")));
    }
    if !metadata.is_file() {
        // The format is found by a first look, and frames are counted before one is read.
        let reason = "it is a pipe or a device, and files are read more than once; save the data in a file first";
        return Err(system(Error::new(ErrorKind::Unsupported, reason)));
    }
    let mut raw = BufReader::with_capacity(1 << 16, File::open(path).map_err(system)?);
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
