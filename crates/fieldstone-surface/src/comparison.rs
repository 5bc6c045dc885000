use crate::SurfaceError;

/// How a labelling differs from a reference.
///
/// $$ M = \frac{TP - EP}{TP} $$
///
/// | symbol | meaning |
/// |---|---|
/// | TP | free-surface particles of the reference |
/// | EP | misidentified particles: misses and false positives |
///
/// Source: `liu2022`, Eq. 32.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Comparison {
    /// Free-surface particles of the reference.
    pub reference: usize,
    /// Free-surface particles of the reference that the other labelling takes for inner ones.
    pub misses: usize,
    /// Inner particles of the reference that the other labelling takes for free-surface ones.
    pub false_positives: usize,
}

impl Comparison {
    /// Compares `labels` with a `reference`, true for the free surface.
    ///
    /// # Errors
    /// [`SurfaceError::Length`] where they are of different sets.
    ///
    /// ```
    /// use fieldstone_surface::Comparison;
    /// let c = Comparison::new(&[true, true, true, false], &[true, true, false, true])?;
    /// assert_eq!((c.reference, c.misses, c.false_positives), (3, 1, 1));
    /// assert_eq!(c.accuracy(), Some(1.0 / 3.0));
    /// # Ok::<(), fieldstone_surface::SurfaceError>(())
    /// ```
    pub fn new(reference: &[bool], labels: &[bool]) -> Result<Self, SurfaceError> {
        if reference.len() != labels.len() {
            return Err(SurfaceError::Length { name: "a labelling", found: labels.len(), expected: reference.len() });
        }
        let count = |r, l| reference.iter().zip(labels).filter(|&(&a, &b)| a == r && b == l).count();
        let misses = count(true, false);
        Ok(Self { reference: misses + count(true, true), misses, false_positives: count(false, true) })
    }

    /// EP, the number of misidentified particles.
    pub fn misidentified(&self) -> usize {
        self.misses + self.false_positives
    }

    /// M; `None` where the reference has no free-surface particle. Negative where EP exceeds TP.
    pub fn accuracy(&self) -> Option<f64> {
        (self.reference > 0).then(|| (self.reference as f64 - self.misidentified() as f64) / self.reference as f64)
    }
}
