//! Frames of particles, read one at a time.

use fieldstone_particles::Particles;

use crate::IoError;

/// A file of particle frames that is read from front to back, one frame in memory at a time.
pub trait FrameReader {
    /// The next frame; `None` after the last.
    ///
    /// # Errors
    /// [`IoError`] with the line or byte where the content stops making sense.
    fn next_frame(&mut self) -> Result<Option<Particles>, IoError>;

    /// Passes over the next frame, checking no more of it than is needed to find its end; `false` after the last.
    ///
    /// # Errors
    /// As [`FrameReader::next_frame`].
    fn skip_frame(&mut self) -> Result<bool, IoError> {
        Ok(self.next_frame()?.is_some())
    }

    /// What the user should know about the frames read so far, one sentence each: what was left out, and what had
    /// to be assumed.
    fn warnings(&self) -> &[String] {
        &[]
    }
}

/// One step of a reader that has not failed yet; nothing (`None`, `false`) after an error, since where the next
/// frame starts is then unknown.
pub(crate) fn unless_failed<R, T: Default>(
    reader: &mut R,
    failed: fn(&mut R) -> &mut bool,
    step: impl FnOnce(&mut R) -> Result<T, IoError>,
) -> Result<T, IoError> {
    if *failed(reader) {
        return Ok(T::default());
    }
    let result = step(reader);
    *failed(reader) = result.is_err();
    result
}
