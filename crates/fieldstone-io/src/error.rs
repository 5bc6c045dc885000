use std::fmt;
use std::io::ErrorKind;
use std::path::PathBuf;

use thiserror::Error;

/// Where in a file something was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Position {
    /// Line of a text file, from 1.
    Line(u64),
    /// Byte offset in a binary file (after decompression), from 0.
    Byte(u64),
    /// The file as a whole.
    File,
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(n) => write!(f, ":{n}"),
            Self::Byte(n) => write!(f, ": byte {n}"),
            Self::File => Ok(()),
        }
    }
}

/// Why a file cannot be read or written.
///
/// Every message names the file, the place in it, what was found, and what to do.
#[derive(Debug, Error)]
pub enum IoError {
    /// The operating system refused to open, read or write.
    #[error("{}: cannot {action}: {source}{}", path.display(), advice(source.kind()))]
    System {
        /// File or folder.
        path: PathBuf,
        /// What was tried: `open`, `read`, `write`.
        action: &'static str,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The content breaks the rules of its format.
    #[error("{}{position}: {found}\n  {remedy}", path.display())]
    Content {
        /// File.
        path: PathBuf,
        /// Line or byte.
        position: Position,
        /// What was found, and what was expected there.
        found: String,
        /// What the user can do.
        remedy: String,
    },
    /// The file is none of the formats that can be read for this purpose.
    #[error("{}: {found}\n  readable here: {readable}", path.display())]
    UnknownFormat {
        /// File.
        path: PathBuf,
        /// What its name and first bytes look like.
        found: String,
        /// Formats that would do.
        readable: String,
    },
    /// The file holds less frames than asked for.
    #[error("{}: frame {wanted} was asked for, but the file holds {available}; frames count from 0, and -1 is the last", path.display())]
    NoSuchFrame {
        /// File.
        path: PathBuf,
        /// Frame asked for.
        wanted: i64,
        /// Frames in the file.
        available: usize,
    },
    /// A text is no [`FrameRange`](crate::FrameRange).
    #[error("'{text}' is no range of frames: {why}; as in 10:20, ::5 or -1")]
    FrameRange {
        /// The text.
        text: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// The columns named for a contact make none: what is wrong, and what to do.
    #[error("{0}")]
    ContactColumns(String),
    /// No preset of contact columns has this name.
    #[error("'{name}' is no preset of contact columns; there are {known}")]
    UnknownPreset {
        /// Name asked for.
        name: String,
        /// Names that there are.
        known: String,
    },
    /// What was read makes no valid particle set.
    #[error("{}: {source}", path.display())]
    Particles {
        /// File.
        path: PathBuf,
        /// The reason.
        source: fieldstone_particles::ParticlesError,
    },
    /// What was read makes no valid mesh.
    #[error("{}: {source}", path.display())]
    Mesh {
        /// File.
        path: PathBuf,
        /// The reason.
        source: fieldstone_mesh::MeshError,
    },
}

impl IoError {
    /// Shorthand for [`IoError::Content`].
    pub fn content(
        path: impl Into<PathBuf>,
        position: Position,
        found: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Content { path: path.into(), position, found: found.into(), remedy: remedy.into() }
    }
}

/// What to do about a refusal of the operating system, where that can be said.
fn advice(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::NotFound => "\n  check the name; a relative one starts at the current folder",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "\n  check the permissions, or give another place"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "\n  make room, or give another place",
        ErrorKind::UnexpectedEof => "\n  the file ends too early: copy it again, or write it again",
        ErrorKind::InvalidInput | ErrorKind::InvalidData => "\n  the file is damaged: copy it again, or write it again",
        _ => "",
    }
}
