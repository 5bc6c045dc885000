//! Files that appear whole or not at all.

use std::fs::{File, OpenOptions, Permissions};
use std::io::{BufWriter, Error, ErrorKind, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::IoError;

/// How names of temporary files begin.
const PREFIX: &str = ".fieldstone-";

/// A file under construction: written under a temporary name in the target's folder, renamed by
/// [`AtomicFile::commit`], removed when dropped before that.
///
/// Its content is on the disk before the name is given, so that a broken computer leaves the older file or the whole new
/// one. A new file is as readable as the user's umask lets it be; one that replaces another keeps that one's permissions.
///
/// A symbolic link stays, and the file that it leads to is replaced. Devices and pipes are written to directly: to
/// put a file in their place would break the system for everybody else.
#[derive(Debug)]
pub struct AtomicFile {
    target: PathBuf,
    stream: BufWriter<Sink>,
}

#[derive(Debug)]
enum Sink {
    Temporary(NamedTempFile),
    Device(File),
}

impl AtomicFile {
    /// Starts a file that will be called `target`; its folder must exist.
    ///
    /// # Errors
    /// [`IoError::System`] where the folder cannot be written to, or there is a folder called `target`.
    pub fn create(target: &Path) -> Result<Self, IoError> {
        let system = |source| IoError::System { path: target.into(), action: "write", source };
        let found = std::fs::metadata(target).ok();
        if found.as_ref().is_some_and(std::fs::Metadata::is_dir) {
            return Err(system(Error::new(ErrorKind::IsADirectory, "there is a folder of this name")));
        }
        let buffered = |target: PathBuf, sink| Self { target, stream: BufWriter::with_capacity(1 << 18, sink) };
        if found.as_ref().is_some_and(|f| !f.is_file()) {
            let device = OpenOptions::new().write(true).open(target).map_err(system)?;
            return Ok(buffered(target.into(), Sink::Device(device)));
        }
        let resolved = if found.is_some() { target.canonicalize().map_err(system)? } else { target.into() };
        let folder = match resolved.parent() {
            Some(p) if !p.as_os_str().is_empty() => p,
            _ => Path::new("."),
        };
        let file = temporary(folder, found.map(|f| f.permissions()))
            // The error names the temporary file, which means nothing to the user.
            .map_err(|e| system(Error::new(e.kind(), e.kind().to_string())))?;
        Ok(buffered(resolved, Sink::Temporary(file)))
    }

    /// Gives the file its name; an older file of that name is replaced.
    ///
    /// # Errors
    /// [`IoError::System`]: disk full, or the name cannot be taken. Nothing is left behind then.
    pub fn commit(self) -> Result<(), IoError> {
        let Self { target, stream } = self;
        let system = |source| IoError::System { path: target.clone(), action: "write", source };
        let Sink::Temporary(file) = stream.into_inner().map_err(|e| system(e.into_error()))? else { return Ok(()) };
        file.as_file().sync_all().map_err(system)?;
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

/// A temporary file with the permissions that the result is to have: those of the file that it replaces, or else those of
/// any file that the user creates, which the umask limits.
#[cfg(unix)]
fn temporary(folder: &Path, replaced: Option<Permissions>) -> std::io::Result<NamedTempFile> {
    use std::os::unix::fs::PermissionsExt;
    let mode = replaced.map(|permissions| permissions.mode() & 0o777);
    let wanted = Permissions::from_mode(mode.unwrap_or(0o666));
    let file = tempfile::Builder::new().prefix(PREFIX).permissions(wanted.clone()).tempfile_in(folder)?;
    // The umask has taken what the old file may have been given in spite of it.
    if mode.is_some_and(|mode| file.as_file().metadata().is_ok_and(|now| now.permissions().mode() & 0o777 != mode)) {
        file.as_file().set_permissions(wanted)?;
    }
    Ok(file)
}

#[cfg(not(unix))]
fn temporary(folder: &Path, _: Option<Permissions>) -> std::io::Result<NamedTempFile> {
    tempfile::Builder::new().prefix(PREFIX).tempfile_in(folder)
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.stream.flush()
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        match self {
            // Not the wrapper itself, whose errors name the temporary file.
            Self::Temporary(file) => file.as_file_mut().write(bytes),
            Self::Device(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> std::io::Result<()> {
        match self {
            Self::Temporary(file) => file.as_file_mut().flush(),
            Self::Device(file) => file.flush(),
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_symbolic_link_stays_and_the_file_behind_it_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let (link, file) = (folder.path().join("link"), folder.path().join("file"));
        std::fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        AtomicFile::write(&link, |out| out.write_all(b"new")).unwrap();
        assert!(link.is_symlink());
        assert_eq!(std::fs::read(&file).unwrap(), b"new");
    }

    fn mode(path: &Path) -> u32 {
        use std::os::unix::fs::PermissionsExt;
        std::fs::metadata(path).expect("a file that was written").permissions().mode() & 0o777
    }

    #[test]
    fn a_new_file_is_as_readable_as_the_umask_lets_it_be() {
        const FOLDER: &str = "FIELDSTONE_UMASK_TEST";
        if let Some(folder) = std::env::var_os(FOLDER) {
            return AtomicFile::write(&Path::new(&folder).join("file"), |out| out.write_all(b"new")).unwrap();
        }
        // The umask belongs to the process: the test runs itself in one that has another.
        let name = "atomic_file::tests::a_new_file_is_as_readable_as_the_umask_lets_it_be";
        for (umask, expected) in [("022", "644"), ("002", "664"), ("077", "600")] {
            let folder = tempfile::tempdir().unwrap();
            let mut shell = std::process::Command::new("sh");
            shell.arg("-c").arg(format!("umask {umask}; exec \"$0\" --exact {name}"));
            let output = shell.arg(std::env::current_exe().unwrap()).env(FOLDER, folder.path()).output().unwrap();
            assert!(output.status.success(), "{output:?}");
            assert_eq!(format!("{:o}", mode(&folder.path().join("file"))), expected, "umask {umask}");
        }
    }

    #[test]
    fn a_file_that_replaces_another_keeps_its_permissions() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        for kept in [0o600, 0o640, 0o666, 0o755] {
            std::fs::write(&file, "old").unwrap();
            std::fs::set_permissions(&file, Permissions::from_mode(kept)).unwrap();
            AtomicFile::write(&file, |out| out.write_all(b"new")).unwrap();
            assert_eq!(
                (format!("{:o}", mode(&file)), std::fs::read(&file).unwrap()),
                (format!("{kept:o}"), b"new".into())
            );
        }
    }

    #[test]
    fn a_device_is_written_to_and_not_replaced_by_a_file() {
        let null = Path::new("/dev/null");
        AtomicFile::write(null, |out| out.write_all(b"text")).unwrap();
        assert!(!std::fs::metadata(null).unwrap().is_file());
    }

    #[test]
    fn a_folder_in_the_place_of_the_file_is_named_and_nothing_is_left_behind() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("result.csv");
        std::fs::create_dir(&place).unwrap();
        let message = AtomicFile::create(&place).unwrap_err().to_string();
        assert!(message.contains("result.csv: cannot write: there is a folder of this name"), "{message}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
