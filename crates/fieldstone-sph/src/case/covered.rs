//! Fills that begin without the weight of those upon them.

use super::Prepared;
use super::sections::{Pressure, PressureName};
use crate::{Shape, SphError};

impl Prepared<'_> {
    /// Hydrostatic fills without `surface` that another fill lies upon, against gravity and within a spacing, each with that fill.
    ///
    /// Their pressure begins from their own top, without the weight of what is above it.
    ///
    /// # Errors
    /// As [`Case::flow`](crate::Case::flow).
    ///
    /// ```
    /// # use fieldstone_sph::Case;
    /// let layers = |surface: &str| {
    ///     Case::parse(
    ///         &format!(
    ///             "dimension = 2\nspacing = 0.05\n[domain]\nlow = [0, 0]\nhigh = [1, 1]\n[fluid]\ndensity = 1000\nexpected_speed = 2\n\
    ///              expected_pressure = 5000\ngravity = [0, -9.81]\n[time]\nend = 1\n\
    ///              [[fill]]\nshape = \"box\"\nlow = [0, 0]\nhigh = [1, 0.25]\npressure = \"hydrostatic\"\n{surface}\n\
    ///              [[fill]]\nshape = \"box\"\nlow = [0, 0.25]\nhigh = [1, 0.5]\npressure = \"hydrostatic\"\n"
    ///         ),
    ///         "layers.toml",
    ///     )
    /// };
    /// assert_eq!(layers("")?.prepare()?.covered_fills()?, [(0, 1)]);
    /// assert_eq!(layers("surface = 0.5")?.prepare()?.covered_fills()?, []);
    /// # Ok::<(), fieldstone_sph::SphError>(())
    /// ```
    pub fn covered_fills(&self) -> Result<Vec<(usize, usize)>, SphError> {
        let s = &self.case.sections;
        let levelling = self.flow.boundaries.levelling(self.flow.fluid.gravity);
        let size = levelling.iter().map(|g| g * g).sum::<f64>().sqrt();
        if size == 0.0 {
            return Ok(Vec::new());
        }
        let shape = |(nth, fill): (usize, &super::FillSection)| self.case.shape("fill", nth, &fill.keys());
        let shapes: Vec<Shape> = s.fill.iter().enumerate().map(shape).collect::<Result<_, _>>()?;
        let mut covered = Vec::new();
        for (nth, fill) in s.fill.iter().enumerate() {
            if fill.pressure != Pressure::Named(PressureName::Hydrostatic) || fill.surface.is_some() {
                continue;
            }
            let (points, _) = shapes[nth].lattice(s.spacing, s.dimension);
            // A particle at the top is half a spacing below it: these are half a spacing, and a whole one, above.
            let above = |x: &[f64; 3]| {
                [1.0, 1.5].map(|steps| std::array::from_fn(|k| x[k] - steps * s.spacing * levelling[k] / size))
            };
            let higher = (0..shapes.len())
                .filter(|&other| other != nth)
                .find(|&other| points.iter().flat_map(above).any(|x: [f64; 3]| shapes[other].contains(x, s.dimension)));
            covered.extend(higher.map(|other| (nth, other)));
        }
        Ok(covered)
    }
}
