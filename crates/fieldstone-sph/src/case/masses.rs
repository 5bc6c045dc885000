//! What the particles of a case weigh, and by how much that is off.

use super::{Case, FillSection, Prepared};
use crate::SphError;

impl Case {
    /// Volume of each particle at rest, so that all together fill the bounds of the fills; none where that is Δxᵈ.
    ///
    /// A box that is no whole number of spacings long is divided into the nearest whole number: its particles stand closer, or farther
    /// apart, than Δx. With the mass ρ₀ Δxᵈ their density, which begins with the pressure, would not be that of their masses in space.
    pub(super) fn particle_volume(&self) -> Result<Option<f64>, SphError> {
        let s = &self.sections;
        let cube = s.spacing.powi(s.dimension as i32);
        let cells = self.lattices()?;
        let (count, volume) = cells.iter().fold((0.0, 0.0), |(n, v), (count, cell)| (n + count, v + count * cell));
        let mean = volume / count;
        // Rounding apart: a case with whole numbers of spacings keeps its bits.
        Ok(((mean / cube - 1.0).abs() > 1e-9 && mean.is_finite()).then_some(mean))
    }

    /// Number and volume of the cells that each fill's bounds are divided into.
    fn lattices(&self) -> Result<Vec<(f64, f64)>, SphError> {
        let s = &self.sections;
        let lattice = |(nth, fill): (usize, &FillSection)| {
            let (counts, cell) = self.shape("fill", nth, &fill.keys())?.cells(s.spacing, s.dimension);
            Ok((counts.iter().map(|&n| n as f64).product(), cell[..s.dimension].iter().product()))
        };
        s.fill.iter().enumerate().map(lattice).collect()
    }
}

impl Prepared<'_> {
    /// By how much the particles of each fill are heavier than their cell of its lattice, relatively.
    ///
    /// All particles have one mass. Where fills are divided into cells of one volume it is ρ₀ times that, whatever their lengths over Δx;
    /// else some are too heavy and some too light for the density with which they begin, and the pressure errs by as much.
    ///
    /// # Errors
    /// As [`Case::flow`].
    ///
    /// ```
    /// # use fieldstone_sph::SHIPPED;
    /// let double = SHIPPED.iter().find(|case| case.name == "double-dam-break").expect("a shipped case");
    /// let double = double.at_spacing(Some(0.07))?;
    /// // 0.8 m and 1.2 m are divided into 11 and 17: into cells of 373 and 352 cm³.
    /// let excess = double.prepare()?.excess_of_fills()?;
    /// assert!(excess[0] < 0.0 && excess[1] > 0.0);
    /// # Ok::<(), fieldstone_sph::SphError>(())
    /// ```
    pub fn excess_of_fills(&self) -> Result<Vec<f64>, SphError> {
        let particle = self.flow.fluid.particle_mass() / self.flow.fluid.density;
        Ok(self.case.lattices()?.into_iter().map(|(_, cell)| particle / cell - 1.0).collect())
    }

    /// By how much the fills' particles are heavier than what the fills' shapes hold at rest, relatively.
    ///
    /// Round fills are cut out of a lattice. What bodies and walls cut off does not count.
    ///
    /// # Errors
    /// As [`Case::state`].
    ///
    /// ```
    /// # use fieldstone_sph::Case;
    /// let case = Case::parse(
    ///     "dimension = 3\nspacing = 0.1\n[domain]\nlow = [0, 0, 0]\nhigh = [1, 1, 1]\n[fluid]\ndensity = 1000\nexpected_speed = 1\n\
    ///      expected_pressure = 0\ngravity = [0, 0, 0]\n[time]\nend = 1\n[[fill]]\nshape = \"sphere\"\ncentre = [0.5, 0.5, 0.5]\nradius = 0.3\n",
    ///     "ball.toml",
    /// )?;
    /// // 136 particles of a cubic decimetre in a ball of 113.
    /// assert!((case.prepare()?.excess_mass()? - (136.0 / 113.0973 - 1.0)).abs() < 1e-6);
    /// # Ok::<(), fieldstone_sph::SphError>(())
    /// ```
    pub fn excess_mass(&self) -> Result<f64, SphError> {
        let s = &self.case.sections;
        let particle = self.flow.fluid.particle_mass() / self.flow.fluid.density;
        let (mut count, mut volume) = (0, 0.0);
        for (nth, fill) in s.fill.iter().enumerate() {
            let shape = self.case.shape("fill", nth, &fill.keys())?;
            count += shape.lattice(s.spacing, s.dimension).0.len();
            volume += shape.volume(s.dimension);
        }
        Ok(count as f64 * particle / volume - 1.0)
    }
}
