//! Files that appear whole or not at all.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::IoError;

/// A file under construction: written under a temporary name in the target's folder, renamed by
/// [`AtomicFile::commit`], removed when dropped before that.
#[derive(Debug)]
pub struct AtomicFile {
    target: PathBuf,
    stream: BufWriter<NamedTempFile>,
}

impl AtomicFile {
    /// Starts a file that will be called `target`; its folder must exist.
    ///
    /// # Errors
    /// [`IoError::System`] where the folder cannot be written to.
    pub fn create(target: &Path) -> Result<Self, IoError> {
        let folder = match target.parent() {
            Some(p) if !p.as_os_str().is_empty() => p,
            _ => Path::new("."),
        };
        let file = tempfile::Builder::new()
            .prefix(".fieldstone-")
            .tempfile_in(folder)
            .map_err(|source| IoError::System { path: target.into(), action: "write", source })?;
        Ok(Self { target: target.into(), stream: BufWriter::with_capacity(1 << 18, file) })
    }

    /// Gives the file its name; an older file of that name is replaced.
    ///
    /// # Errors
    /// [`IoError::System`]: disk full, or the name cannot be taken. Nothing is left behind then.
    pub fn commit(self) -> Result<(), IoError> {
        let Self { target, stream } = self;
        let system = |source| IoError::System { path: target.clone(), action: "write", source };
        let file = stream.into_inner().map_err(|e| system(e.into_error()))?;
        // Temporary files are private; results are as readable as any file that the user creates.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let permissions = std::fs::Permissions::from_mode(0o644);
            file.as_file().set_permissions(permissions).map_err(system)?;
        }
        file.persist(&target).map_err(|e| system(e.error))?;
        Ok(())
    }

    /// Runs `body` on a new file and commits it where `body` succeeds.
    ///
    /// # Errors
    /// Those of [`AtomicFile::create`], `body` and [`AtomicFile::commit`].
    pub fn write(target: &Path, body: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<(), IoError> {
        let mut file = Self::create(target)?;
        body(&mut file.stream).map_err(|source| IoError::System { path: target.into(), action: "write", source })?;
        file.commit()
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.stream.flush()
    }
}
