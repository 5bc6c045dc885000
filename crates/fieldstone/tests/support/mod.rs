//! A folder to run the program in.

pub mod cases;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// A temporary folder; the program runs inside it, so that messages show short names.
pub struct Folder(TempDir);

/// What a run of the program gave.
#[derive(Debug)]
pub struct Run {
    /// Exit code; `None` where a signal ended the program.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file, in a folder of its own where the name has one.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, content).unwrap();
        path
    }

    /// Copies a file, or a folder with all that is in it.
    #[allow(dead_code, reason = "not every suite copies files")]
    pub fn copy(&self, from: &Path, name: &str) -> PathBuf {
        if from.is_dir() {
            for entry in std::fs::read_dir(from).unwrap() {
                let entry = entry.unwrap();
                self.copy(&entry.path(), &format!("{name}/{}", entry.file_name().display()));
            }
            return self.path(name);
        }
        self.write(name, std::fs::read(from).unwrap())
    }

    /// All files in the folder and below, by name and content.
    pub fn files(&self) -> Vec<(PathBuf, Vec<u8>)> {
        fn visit(folder: &Path, found: &mut Vec<(PathBuf, Vec<u8>)>) {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    found.push((path.clone(), Vec::new()));
                    visit(&path, found);
                } else {
                    found.push((path.clone(), std::fs::read(&path).unwrap()));
                }
            }
        }
        let mut found = Vec::new();
        visit(self.0.path(), &mut found);
        found.sort();
        found
    }

    /// Runs the program in the folder, not in a terminal and not as wide as one.
    pub fn run<S: AsRef<OsStr>>(&self, arguments: impl IntoIterator<Item = S>) -> Run {
        let output = Command::new(env!("CARGO_BIN_EXE_fieldstone"))
            .args(arguments)
            .current_dir(self.0.path())
            .env_remove("COLUMNS")
            .output()
            .unwrap();
        Run {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs a command line of words without blanks in them.
    pub fn fieldstone(&self, line: &str) -> Run {
        self.run(line.split_whitespace())
    }

    /// As [`Folder::fieldstone`], for a run that must succeed.
    #[track_caller]
    pub fn succeeds(&self, line: &str) -> Run {
        let run = self.fieldstone(line);
        assert_eq!(run.code, Some(0), "fieldstone {line}\n{}{}", run.stdout, run.stderr);
        run
    }

    /// As [`Folder::fieldstone`], for a run that must end with exit code 1 and a message, and leave everything as it
    /// was; the message.
    #[allow(dead_code, reason = "not every suite has refusals")]
    #[track_caller]
    pub fn fails(&self, line: &str) -> String {
        let before = self.files();
        let run = self.fieldstone(line);
        assert_eq!(run.code, Some(1), "fieldstone {line}\n{}{}", run.stdout, run.stderr);
        assert!(run.stderr.starts_with("error: ") && !run.stderr.contains("panicked"), "{}", run.stderr);
        assert_eq!(run.stderr.matches("error: ").count(), 1, "one message: {}", run.stderr);
        assert_eq!(run.stdout, "", "a failed run reports no results");
        let after = self.files();
        assert!(before == after, "fieldstone {line}\nleft behind: {:?}", new_names(&before, &after));
        run.stderr
    }
}

fn new_names(before: &[(PathBuf, Vec<u8>)], after: &[(PathBuf, Vec<u8>)]) -> Vec<PathBuf> {
    after.iter().filter(|file| !before.contains(file)).map(|file| file.0.clone()).collect()
}
