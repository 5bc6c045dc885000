use crate::kernel::{TINY, inverse_root};
use crate::neighbour_list::{LANES, PairSum};
use crate::points::Carrier;
use crate::{FluidOptions, ShiftingOptions};

/// Where a particle is: region F of Eq. 11.
pub(crate) const FREE: u8 = 1;

/// Shift of each particle and the region it is in, from the columns of
/// [`Points::fill_shifting`](crate::points::Points::fill_shifting).
///
/// `FOUR` tells that n is 4, for which a power is two products.
///
/// Source: `liu2022`, Eq. 10, 11.
pub(crate) struct Shift<'a, const FOUR: bool> {
    carriers: &'a [Carrier],
    h: f64,
    /// 1/h².
    inverse_square: f64,
    slope_factor: f64,
    /// α_d/W(Δx), so that W/W(Δx) is this times (1 + 2q)(1 − q/2)⁴.
    relative: f64,
    r: f64,
    n: i32,
    scale: f64,
    cap: f64,
}

impl<'a, const FOUR: bool> Shift<'a, FOUR> {
    pub(crate) fn new(
        fluid: &FluidOptions,
        shifting: &ShiftingOptions,
        carriers: &'a [Carrier],
        ) -> Self {
        let (kernel, h) = (fluid.kernel(), fluid.h());
        let mach = shifting.mach.unwrap_or(fluid.expected_speed / fluid.sound_speed);
        Self {
            carriers,
            h,
            inverse_square: 1.0 / (h * h),
            slope_factor: kernel.slope_factor(),
            relative: kernel.alpha() / kernel.value(fluid.spacing),
            r: shifting.r,
            n: shifting.n,
            scale: -shifting.k_cfl * mach * shifting.factor * h * h,
            cap: shifting.cap * fluid.spacing,
        }
    }
}

impl<const FOUR: bool> PairSum for Shift<'_, FOUR> {
    /// Shift, and 0 on the free surface, 1 near it, 2 inside.
    type Output = ([f64; 3], u8);

    #[inline(always)]
    fn of(&self, members: &[u32; LANES], list: &[u32]) -> [([f64; 3], u8); LANES] {
        let zero = [0.0f64; LANES];
        let (mut xi, mut yi, mut zi, mut away) = (zero, zero, zero, zero);
        for l in 0..LANES {
            [xi[l], yi[l], zi[l], _, away[l], ..] = self.carriers[members[l] as usize];
        }
        let mut shifts = [([0.0; 3], 0); LANES];
        if away == zero {
            return shifts;
        }
        let reach = 2.0 * self.h;
        let mut closest = [reach * reach; LANES];
        for &j in list {
            let [x, y, z, _, away, ..] = self.carriers[j as usize];
            // Few are on the free surface.
            if away == 0.0 {
                for l in 0..LANES {
                    let (dx, dy, dz) = (x - xi[l], y - yi[l], z - zi[l]);
                    let s = dx * dx + dy * dy + dz * dz;
                    closest[l] = if s < closest[l] { s } else { closest[l] };
                }
            }
        }
        let mut base = zero;
        for l in 0..LANES {
            base[l] = if closest[l] >= reach * reach { 1.0 } else { 0.0 };
        }
        let (mut tx, mut ty, mut tz) = (zero, zero, zero);
        for &j in list {
            let [x, y, z, v, ..] = self.carriers[j as usize];
            for l in 0..LANES {
                let (dx, dy, dz) = (x - xi[l], y - yi[l], z - zi[l]);
                let square = dx * dx + dy * dy + dz * dz;
                let s = square * self.inverse_square;
                let s = if s > TINY { s } else { TINY };
                let p = 0.5 * (s * inverse_root(s));
                let left = 1.0 - p;
                let left = if left > 0.0 { left } else { 0.0 };
                let cube = left * left * left;
                let relative = self.relative * (1.0 + 4.0 * p) * (cube * left);
                let power = if FOUR { (relative * relative) * (relative * relative) } else { relative.powi(self.n) };
                let g = cube * v * (base[l] + self.r * power);
                let g = if square < closest[l] { g } else { 0.0 };
                tx[l] += g * dx;
                ty[l] += g * dy;
                tz[l] += g * dz;
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
