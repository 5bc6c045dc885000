//! Opening files: compressed or not, with errors that name them.

use std::fs::File;
use std::io::{BufReader, Error, ErrorKind, Read};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

use crate::{IoError, Position};

/// Compressions and encodings that are not read: their first bytes, what they are, and the remedy.
const FOREIGN: [(&[u8], &str, &str); 6] = [
    (b"BZh", "the file is compressed with bzip2", "unpack it with bunzip2, or compress it with gzip instead"),
    (b"\xfd7zXZ\0", "the file is compressed with xz", "unpack it with unxz, or compress it with gzip instead"),
    (
        b"\x28\xb5\x2f\xfd",
        "the file is compressed with Zstandard",
        "unpack it with unzstd, or compress it with gzip instead",
    ),
    (b"PK\x03\x04", "the file is a zip archive", "unpack it with unzip, or compress a single file with gzip instead"),
    (b"\xff\xfe", "the file is text in UTF-16", "save it as UTF-8, as with: iconv -f UTF-16 -t UTF-8"),
    (b"\xfe\xff", "the file is text in UTF-16", "save it as UTF-8, as with: iconv -f UTF-16 -t UTF-8"),
];

/// A buffered byte stream over the file's content, decompressed where the file is gzip by its first bytes.
///
/// # Errors
/// [`IoError::System`] where the file cannot be opened, or is a folder, a pipe or a device; [`IoError::Content`] where it is
/// compressed or encoded in a way that is not read.
pub fn open(path: &Path) -> Result<BufReader<Box<dyn Read + Send>>, IoError> {
    let system = |source| IoError::System { path: path.into(), action: "open", source };
    // Before opening: that would wait for the other end of a pipe.
    let metadata = std::fs::metadata(path).map_err(|error| {
        if path.as_os_str() != "-" {
            return system(error);
        }
        let reason = "there is no file of this name, and standard input (/dev/stdin) is not read, since files are read more than \
                      once; save the data in a file first";
        system(Error::new(error.kind(), reason))
    })?;
    if metadata.is_dir() {
        return Err(system(Error::new(ErrorKind::IsADirectory, "it is a folder")));
    }
    if !metadata.is_file() {
        // The format is found by a first look, and frames are counted before one is read.
        let reason = "it is a pipe or a device, and files are read more than once; save the data in a file first";
        return Err(system(Error::new(ErrorKind::Unsupported, reason)));
    }
    let mut raw = BufReader::with_capacity(1 << 16, File::open(path).map_err(system)?);
    let start = std::io::BufRead::fill_buf(&mut raw).map_err(system)?;
    if let Some((_, found, remedy)) = FOREIGN.iter().find(|(magic, ..)| start.starts_with(magic)) {
        return Err(IoError::content(path, Position::File, *found, *remedy));
    }
    let gzip = start.starts_with(&[0x1f, 0x8b]);
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
