//! Readers that give no further frame after an error.

use crate::IoError;

/// Remembers that a reader has failed: where in the file the next frame starts is then unknown.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct StopAfterError {
    failed: bool,
}

impl StopAfterError {
    /// What `step` gives, or `None` where an earlier step failed.
    pub(crate) fn run<T>(
        &mut self,
        step: impl FnOnce() -> Result<Option<T>, IoError>,
    ) -> Result<Option<T>, IoError> {
        if self.failed {
            return Ok(None);
        }
        let result = step();
        self.failed = result.is_err();
        result
    }
}
