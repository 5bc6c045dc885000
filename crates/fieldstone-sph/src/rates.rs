use crate::FluidOptions;
use crate::cluster::{BLOCK, Distances, LANES, Receivers, improved};
use crate::neighbour_list::PairSum;
use crate::pair::{PairFactors, slope};
use crate::points::{Carrier, Points};

/// Rates of one particle.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Rate {
    /// Du/Dt.
    pub(crate) acceleration: [f64; 3],
    /// Dρ/Dt.
    pub(crate) density: f64,
    /// Power of the viscous term.
    pub(crate) viscous_power: f64,
    /// Rate of compression energy by δ.
    pub(crate) diffusive_power: f64,
    /// Power of the pressure term and rate of compression energy by the divergence: cancel in pairs of particles.
    pub(crate) boundary_power: f64,
}

/// The right-hand sides.
///
/// $$ \frac{D\rho_i}{Dt} = -\rho_i\sum_j (u_j - u_i)\cdot\nabla_iW_{ij}V_j + \delta h c_0\,
///    2\sum_j \psi_{ij}\frac{(x_j - x_i)\cdot\nabla_iW_{ij}}{|x_j - x_i|^2}V_j $$
/// $$ \frac{Du_i}{Dt} = -\frac1{\rho_i}\sum_j(p_i + p_j)\nabla_iW_{ij}V_j + \frac{2(d+2)\mu}{\rho_i}\sum_j
///    \pi_{ij}\nabla_iW_{ij}V_j + g $$
///
/// With ∇ᵢW = g (x_j − x_i), the quotient in Eq. 5 is g, so nothing is divided by a distance there.
///
/// Source: `liu2022`, Eq. 4, 5 (with the V_j that belongs there), 7.
pub(crate) struct Rates<'a, const VISCOUS_COLUMN: bool> {
    carriers: &'a [Carrier],
    gradients: &'a [[f64; 4]],
    viscous: &'a [[f64; 4]],
    /// Regions with tensile control: inside, p_i changes its sign where it is negative.
    tensile: Option<&'a [u8]>,
    pair: PairFactors,
    /// 2 δ h c₀.
    diffusion: f64,
    gravity: [f64; 3],
}

impl<'a, const VISCOUS_COLUMN: bool> Rates<'a, VISCOUS_COLUMN> {
    pub(crate) fn new(fluid: &FluidOptions, points: &'a Points, tensile: Option<&'a [u8]>) -> Self {
        Self {
            carriers: &points.carriers,
            gradients: &points.gradients,
            viscous: &points.viscous,
            tensile,
            pair: PairFactors::new(fluid),
            diffusion: 2.0 * fluid.delta * fluid.h() * fluid.sound_speed,
            gravity: fluid.gravity,
        }
    }
}

impl<const VISCOUS_COLUMN: bool> PairSum for Rates<'_, VISCOUS_COLUMN> {
    type Output = Rate;

    #[inline(always)]
    fn of(&self, members: &[u32; LANES], list: &[u32]) -> [Rate; LANES] {
        let zero = [0.0f64; LANES];
        let at = Receivers::of(members, self.carriers);
        let mut ri = zero;
        let (mut ui, mut vi, mut wi) = (zero, zero, zero);
        let (mut gxi, mut gyi, mut gzi) = (zero, zero, zero);
        // p_i + p_j over c₀² is ρ_j plus this.
        let mut own = zero;
        for l in 0..LANES {
            let i = members[l] as usize;
            [_, _, _, _, ri[l], ui[l], vi[l], wi[l]] = self.carriers[i];
            [gxi[l], gyi[l], gzi[l], _] = self.gradients[i];
            own[l] = self.pair.own(ri[l], self.tensile, i);
        }
        let (mut px, mut py, mut pz) = (zero, zero, zero);
        let (mut fx, mut fy, mut fz) = (zero, zero, zero);
        let (mut divergence, mut diffusion) = (zero, zero);
        let mut distances = Distances::ZERO;
        for block in list.chunks(BLOCK) {
            distances.find(&at, self.carriers, block, self.pair.inverse_square);
            for ((&j, squares), guesses) in block.iter().zip(&distances.squares).zip(&distances.guesses) {
                let [x, y, z, v, r, uj, vj, wj] = self.carriers[j as usize];
                let [gx, gy, gz, _] = self.gradients[j as usize];
                let [us, vs, ws, weight] = if VISCOUS_COLUMN { self.viscous[j as usize] } else { [uj, vj, wj, 1.0] };
                for l in 0..LANES {
                    let (dx, dy, dz) = (x - at.x[l], y - at.y[l], z - at.z[l]);
                    let s = squares[l];
                    let inverse = improved(guesses[l], s);
                    let g = slope(s, inverse, v);
                    let along = (uj - ui[l]).mul_add(dx, (vj - vi[l]).mul_add(dy, (wj - wi[l]) * dz));
                    divergence[l] = g.mul_add(along, divergence[l]);
                    let change = (gx + gxi[l]).mul_add(dx, (gy + gyi[l]).mul_add(dy, (gz + gzi[l]) * dz));
                    diffusion[l] = g.mul_add((-0.5f64).mul_add(change, r - ri[l]), diffusion[l]);
                    let pressure = g * (r + own[l]);
                    px[l] = pressure.mul_add(dx, px[l]);
                    py[l] = pressure.mul_add(dy, py[l]);
                    pz[l] = pressure.mul_add(dz, pz[l]);
                    let approach = (us - ui[l]).mul_add(dx, (vs - vi[l]).mul_add(dy, (ws - wi[l]) * dz));
                    let friction = g * approach * (inverse * inverse);
                    let friction = if VISCOUS_COLUMN { weight * friction } else { friction };
                    fx[l] = friction.mul_add(dx, fx[l]);
                    fy[l] = friction.mul_add(dy, fy[l]);
                    fz[l] = friction.mul_add(dz, fz[l]);
                }
            }
        }
        let mut rates = [Rate::default(); LANES];
        for l in 0..LANES {
            let PairFactors { slope, stiffness, rest_density, mass, .. } = self.pair;
            let (pressure, friction) = (self.pair.pressure(ri[l]), self.pair.friction(ri[l]));
            let (px, py, pz) = (pressure * px[l], pressure * py[l], pressure * pz[l]);
            let (fx, fy, fz) = (friction * fx[l], friction * fy[l], friction * fz[l]);
            let divergence = -ri[l] * slope * divergence[l];
            let diffusion = self.diffusion * slope * diffusion[l];
            let compression = mass * stiffness * (ri[l] - rest_density) / (ri[l] * ri[l]);
            rates[l] = Rate {
                acceleration: [(px + fx) + self.gravity[0], (py + fy) + self.gravity[1], (pz + fz) + self.gravity[2]],
                density: divergence + diffusion,
                viscous_power: mass * (fx * ui[l] + fy * vi[l] + fz * wi[l]),
                diffusive_power: compression * diffusion,
                boundary_power: mass * (px * ui[l] + py * vi[l] + pz * wi[l]) + compression * divergence,
            };
        }
        rates
    }
}
