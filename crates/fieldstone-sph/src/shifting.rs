use crate::cluster::{BLOCK, Distances, LANES, Receivers, improved};
use crate::neighbour_list::PairSum;
use crate::points::Carrier;
use crate::{FluidOptions, ShiftingOptions};

/// Farther than 2h from every particle of the free surface: region I.
pub(crate) const INSIDE: u8 = 2;

/// Shift of each particle and the region it is in, from the columns of
/// [`Points::fill_shifting`](crate::points::Points::fill_shifting).
///
/// `FOUR` tells that n is 4, for which a power is two products.
///
/// Source: `liu2022`, Eq. 10, 11.
pub(crate) struct Shift<'a, const FOUR: bool> {
    carriers: &'a [Carrier],
    /// 1/h².
    inverse_square: f64,
    slope_factor: f64,
    /// α_d/W(Δx), so that W/W(Δx) is this times (1 + 2q)(1 − q/2)⁴.
    relative: f64,
    r: f64,
    n: i32,
    scale: f64,
    cap: f64,
    /// Of the squared distance of the nearest free-surface particle, below which neighbours near the surface count.
    share: f64,
}

/// Distances computed in two ways are the same up to this: what takes in, or leaves out, the nearest particle.
const SAME: f64 = 1.0 + 1e-9;

impl<'a, const FOUR: bool> Shift<'a, FOUR> {
    /// `share` is the time step over the one that sound alone would allow.
    pub(crate) fn new(fluid: &FluidOptions, shifting: &ShiftingOptions, share: f64, carriers: &'a [Carrier]) -> Self {
        let (kernel, h) = (fluid.kernel(), fluid.h());
        let mach = shifting.mach_number(fluid);
        Self {
            carriers,
            inverse_square: 1.0 / (h * h),
            slope_factor: kernel.slope_factor(),
            relative: kernel.alpha() / kernel.value(fluid.spacing),
            r: shifting.r,
            n: shifting.n,
            scale: -shifting.k_cfl * mach * shifting.factor * h * h * share,
            cap: shifting.cap * fluid.spacing,
            share: if shifting.nearest_counts { SAME } else { 1.0 / SAME },
        }
    }
}

impl<const FOUR: bool> PairSum for Shift<'_, FOUR> {
    /// Shift, and 0 on the free surface, 1 near it, 2 inside.
    type Output = ([f64; 3], u8);

    #[inline(always)]
    fn of(&self, members: &[u32; LANES], list: &[u32]) -> [([f64; 3], u8); LANES] {
        let zero = [0.0f64; LANES];
        let at = Receivers::of(members, self.carriers);
        let mut away = zero;
        for l in 0..LANES {
            away[l] = self.carriers[members[l] as usize][4];
        }
        let mut shifts = [([0.0; 3], 0); LANES];
        if away == zero {
            return shifts;
        }
        // Of the free surface; squares over h², the kernel's reach where there is none.
        let mut closest = [4.0; LANES];
        for &j in list {
            let [x, y, z, _, away, ..] = self.carriers[j as usize];
            // Few are on the free surface.
            if away == 0.0 {
                for (l, closest) in closest.iter_mut().enumerate() {
                    let s = at.square(l, x, y, z) * self.inverse_square;
                    *closest = if s < *closest { s } else { *closest };
                }
            }
        }
        let (mut base, mut limit) = (zero, zero);
        for l in 0..LANES {
            base[l] = if closest[l] >= 4.0 { 1.0 } else { 0.0 };
            limit[l] = self.share * closest[l];
        }
        let (mut tx, mut ty, mut tz) = (zero, zero, zero);
        let mut distances = Distances::ZERO;
        for block in list.chunks(BLOCK) {
            distances.find(&at, self.carriers, block, self.inverse_square);
            for ((&j, squares), guesses) in block.iter().zip(&distances.squares).zip(&distances.guesses) {
                let [x, y, z, v, ..] = self.carriers[j as usize];
                for l in 0..LANES {
                    let (dx, dy, dz) = (x - at.x[l], y - at.y[l], z - at.z[l]);
                    let s = squares[l];
                    let p = (0.5 * s) * improved(guesses[l], s);
                    let left = 1.0 - p;
                    let left = if left > 0.0 { left } else { 0.0 };
                    let cube = left * left * left;
                    let relative = self.relative * p.mul_add(4.0, 1.0) * (cube * left);
                    let power =
                        if FOUR { (relative * relative) * (relative * relative) } else { relative.powi(self.n) };
                    let g = cube * v * self.r.mul_add(power, base[l]);
                    let g = if s < limit[l] { g } else { 0.0 };
                    tx[l] = g.mul_add(dx, tx[l]);
                    ty[l] = g.mul_add(dy, ty[l]);
                    tz[l] = g.mul_add(dz, tz[l]);
                }
            }
        }
        for l in 0..LANES {
            if away[l] == 0.0 {
                continue;
            }
            let mut shift = [tx[l], ty[l], tz[l]].map(|t| self.scale * self.slope_factor * t);
            let length = (shift[0] * shift[0] + shift[1] * shift[1] + shift[2] * shift[2]).sqrt();
            if length > self.cap {
                for s in &mut shift {
                    *s *= self.cap / length;
                }
            }
            shifts[l] = (shift, if base[l] > 0.0 { 2 } else { 1 });
        }
        shifts
    }
}
