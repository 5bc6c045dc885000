//! What is wrong in a VTK file, before the file's name is known.

use std::fmt::Display;
use std::path::Path;

use crate::{IoError, Position};

/// A broken rule of the format; [`Fault::in_file`] makes the user's error of it.
#[derive(Debug)]
pub(super) struct Fault {
    pub position: Position,
    pub found: String,
    pub remedy: &'static str,
}

pub(super) type Parsed<T> = Result<T, Fault>;

/// Said where the bytes contradict each other and nothing but another copy of the file helps.
pub(super) const DAMAGED: &str = "the file is damaged or was cut short: copy or write it again";

impl Fault {
    pub fn new(position: Position, found: impl Into<String>, remedy: &'static str) -> Self {
        Self { position, found: found.into(), remedy }
    }

    /// A contradiction that only a new copy of the file resolves.
    pub fn damaged(position: Position, found: impl Into<String>) -> Self {
        Self::new(position, found, DAMAGED)
    }

    /// The same fault with the name of the array that it was found in.
    pub fn in_array(mut self, name: &str) -> Self {
        self.found = format!("array '{name}': {}", self.found);
        self
    }

    pub fn in_file(self, path: &Path) -> IoError {
        IoError::content(path, self.position, self.found, self.remedy)
    }
}

/// Turns any decoder's error into a fault at `position`.
pub(super) fn damaged<E: Display>(position: Position) -> impl FnOnce(E) -> Fault {
    move |error| Fault::damaged(position, error.to_string())
}
