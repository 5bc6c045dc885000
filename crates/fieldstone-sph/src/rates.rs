use crate::FluidOptions;
use crate::kernel::{TINY, inverse_root};
use crate::neighbour_list::{LANES, PairSum};
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
    ranks: &'a [u32],
    /// Particles whose p_i changes its sign where it is negative: inside, with tensile control.
    tensile: Option<&'a [u8]>,
    /// 1/h².
    inverse_square: f64,
    factor: f64,
    /// c₀², ρ₀, 2 δ h c₀, 2 (d + 2) μ, m, g.
    stiffness: f64,
    rest_density: f64,
    diffusion: f64,
    friction: f64,
    mass: f64,
    gravity: [f64; 3],
}

impl<'a, const VISCOUS_COLUMN: bool> Rates<'a, VISCOUS_COLUMN> {
    pub(crate) fn new(fluid: &FluidOptions, points: &'a Points, tensile: Option<&'a [u8]>) -> Self {
        let kernel = fluid.kernel();
        let h = fluid.h();
        Self {
            carriers: &points.carriers,
            gradients: &points.gradients,
            viscous: &points.viscous,
            ranks: points.grid().ranks(),
            tensile,
            inverse_square: 1.0 / (h * h),
            factor: kernel.slope_factor(),
            stiffness: fluid.sound_speed * fluid.sound_speed,
            rest_density: fluid.density,
            diffusion: 2.0 * fluid.delta * h * fluid.sound_speed,
            friction: 2.0 * (fluid.dimension as f64 + 2.0) * fluid.dynamic_viscosity(),
            mass: fluid.particle_mass(),
            gravity: fluid.gravity,
        }
    }
}

#[inline(always)]
fn total(t: &[f64; LANES]) -> f64 {
    ((t[0] + t[4]) + (t[1] + t[5])) + ((t[2] + t[6]) + (t[3] + t[7]))
}

impl<const VISCOUS_COLUMN: bool> PairSum for Rates<'_, VISCOUS_COLUMN> {
    type Scratch = ();
    type Output = Rate;

    #[inline(always)]
    fn of(&self, receiver: usize, list: &[u32], (): &mut ()) -> Rate {
        let rank = self.ranks[receiver] as usize;
        let [xi, yi, zi, _, ri, ui, vi, wi] = self.carriers[rank];
        let [gxi, gyi, gzi, _] = self.gradients[rank];
        let excess = ri - self.rest_density;
        let free = match self.tensile {
            None => true,
            Some(flags) => flags[receiver] != 0,
        };
        // p_i + p_j over c₀² is ρ_j plus this.
        let own = if excess < 0.0 && !free { -excess } else { excess } - self.rest_density;
        let (mut px, mut py, mut pz) = ([0.0f64; LANES], [0.0f64; LANES], [0.0f64; LANES]);
        let (mut fx, mut fy, mut fz) = ([0.0f64; LANES], [0.0f64; LANES], [0.0f64; LANES]);
        let (mut divergence, mut diffusion) = ([0.0f64; LANES], [0.0f64; LANES]);
        for block in list.chunks_exact(LANES) {
            let (mut x, mut y, mut z) = ([0.0f64; LANES], [0.0f64; LANES], [0.0f64; LANES]);
            let (mut v, mut r) = ([0.0f64; LANES], [0.0f64; LANES]);
            let (mut uj, mut vj, mut wj) = ([0.0f64; LANES], [0.0f64; LANES], [0.0f64; LANES]);
            let (mut gx, mut gy, mut gz) = ([0.0f64; LANES], [0.0f64; LANES], [0.0f64; LANES]);
            for l in 0..LANES {
                let j = &self.carriers[block[l] as usize];
                x[l] = j[0];
                y[l] = j[1];
                z[l] = j[2];
                v[l] = j[3];
                r[l] = j[4];
                uj[l] = j[5];
                vj[l] = j[6];
                wj[l] = j[7];
            }
            for l in 0..LANES {
                let j = &self.gradients[block[l] as usize];
                gx[l] = j[0];
                gy[l] = j[1];
                gz[l] = j[2];
            }
            let (mut us, mut vs, mut ws) = (uj, vj, wj);
            let mut weight = [1.0f64; LANES];
            if VISCOUS_COLUMN {
                for l in 0..LANES {
                    let j = &self.viscous[block[l] as usize];
                    us[l] = j[0];
                    vs[l] = j[1];
                    ws[l] = j[2];
                    weight[l] = j[3];
                }
            }
            for l in 0..LANES {
                let (dx, dy, dz) = (x[l] - xi, y[l] - yi, z[l] - zi);
                let s = (dx * dx + dy * dy + dz * dz) * self.inverse_square;
                let s = if s > TINY { s } else { TINY };
                let inverse = inverse_root(s);
                let left = 1.0 - 0.5 * (s * inverse);
                let left = if left > 0.0 { left } else { 0.0 };
                let g = left * left * left * v[l];
                divergence[l] += g * ((uj[l] - ui) * dx + (vj[l] - vi) * dy + (wj[l] - wi) * dz);
                let slope = (gx[l] + gxi) * dx + (gy[l] + gyi) * dy + (gz[l] + gzi) * dz;
                diffusion[l] += g * ((r[l] - ri) - 0.5 * slope);
                let pressure = g * (r[l] + own);
                px[l] += pressure * dx;
                py[l] += pressure * dy;
                pz[l] += pressure * dz;
                let approach = (us[l] - ui) * dx + (vs[l] - vi) * dy + (ws[l] - wi) * dz;
                let friction = g * approach * (inverse * inverse);
                let friction = if VISCOUS_COLUMN { weight[l] * friction } else { friction };
                fx[l] += friction * dx;
                fy[l] += friction * dy;
                fz[l] += friction * dz;
            }
        }
        let pressure = -self.factor * self.stiffness / ri;
        let friction = self.factor * self.friction * self.inverse_square / ri;
        let (px, py, pz) = (pressure * total(&px), pressure * total(&py), pressure * total(&pz));
        let (fx, fy, fz) = (friction * total(&fx), friction * total(&fy), friction * total(&fz));
        let divergence = -ri * self.factor * total(&divergence);
        let diffusion = self.diffusion * self.factor * total(&diffusion);
        let compression = self.mass * self.stiffness * excess / (ri * ri);
        Rate {
            acceleration: [(px + fx) + self.gravity[0], (py + fy) + self.gravity[1], (pz + fz) + self.gravity[2]],
            density: divergence + diffusion,
            viscous_power: self.mass * (fx * ui + fy * vi + fz * wi),
            diffusive_power: compression * diffusion,
            boundary_power: self.mass * (px * ui + py * vi + pz * wi) + compression * divergence,
        }
    }
}
