use crate::kernel::{TINY, inverse_root};
use crate::neighbour_list::{LANES, PairSum};
use crate::points::Carrier;
use crate::{FluidOptions, ShiftingOptions};

/// Where a particle is: region F of Eq. 11.
pub(crate) const FREE: u8 = 1;

/// Shift of each particle and the region it is in, from the columns of
/// [`Points::fill_shifting`](crate::points::Points::fill_shifting).
///
/// Source: `liu2022`, Eq. 10, 11.
pub(crate) struct Shift<'a> {
    carriers: &'a [Carrier],
    ranks: &'a [u32],
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

impl<'a> Shift<'a> {
    pub(crate) fn new(
        fluid: &FluidOptions,
        shifting: &ShiftingOptions,
        carriers: &'a [Carrier],
        ranks: &'a [u32],
    ) -> Self {
        let (kernel, h) = (fluid.kernel(), fluid.h());
        let mach = shifting.mach.unwrap_or(fluid.expected_speed / fluid.sound_speed);
        Self {
            carriers,
            ranks,
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

impl Shift<'_> {
    /// Σ V (χ + R (W/W(Δx))ⁿ) g (x_j − x_i) of the neighbours closer than the root of `closest`, by lanes.
    #[inline(always)]
    fn sums<const FOUR: bool>(&self, blocks: &[[[f64; LANES]; 5]], closest: f64, base: f64) -> [[f64; LANES]; 3] {
        let (mut tx, mut ty, mut tz) = ([0.0f64; LANES], [0.0f64; LANES], [0.0f64; LANES]);
        for [dx, dy, dz, squares, v] in blocks {
            for l in 0..LANES {
                let s = squares[l] * self.inverse_square;
                let s = if s > TINY { s } else { TINY };
                let p = 0.5 * (s * inverse_root(s));
                let left = 1.0 - p;
                let left = if left > 0.0 { left } else { 0.0 };
                let cube = left * left * left;
                let relative = self.relative * (1.0 + 4.0 * p) * (cube * left);
                let square = relative * relative;
                let power = if FOUR { square * square } else { relative.powi(self.n) };
                let g = cube * v[l] * (base + self.r * power);
                let g = if squares[l] < closest { g } else { 0.0 };
                tx[l] += g * dx[l];
                ty[l] += g * dy[l];
                tz[l] += g * dz[l];
            }
        }
        [tx, ty, tz]
    }
}

/// Displacements to one particle's neighbours, distances squared, volumes.
#[derive(Debug, Default)]
pub(crate) struct ShiftScratch {
    blocks: Vec<[[f64; LANES]; 5]>,
}

impl PairSum for Shift<'_> {
    type Scratch = ShiftScratch;
    /// Shift, and 0 on the free surface, 1 near it, 2 inside.
    type Output = ([f64; 3], u8);

    #[inline(always)]
    fn of(&self, receiver: usize, list: &[u32], scratch: &mut ShiftScratch) -> ([f64; 3], u8) {
        let rank = self.ranks[receiver] as usize;
        let [xi, yi, zi, _, far, ..] = self.carriers[rank];
        if far == 0.0 {
            return ([0.0; 3], 0);
        }
        scratch.blocks.resize(list.len() / LANES, [[0.0; LANES]; 5]);
        let blocks = &mut scratch.blocks[..list.len() / LANES];
        let reach = 2.0 * self.h;
        let mut nearest = [reach * reach; LANES];
        for (block, out) in list.chunks_exact(LANES).zip(blocks.iter_mut()) {
            let (mut x, mut y, mut z) = ([0.0f64; LANES], [0.0f64; LANES], [0.0f64; LANES]);
            let mut v = [0.0f64; LANES];
            // Infinity where the neighbour is not on the free surface.
            let mut away = [0.0f64; LANES];
            for l in 0..LANES {
                let j = &self.carriers[block[l] as usize];
                x[l] = j[0];
                y[l] = j[1];
                z[l] = j[2];
                v[l] = j[3];
                away[l] = j[4];
            }
            let [ox, oy, oz, os, ov] = out;
            for l in 0..LANES {
                let (dx, dy, dz) = (x[l] - xi, y[l] - yi, z[l] - zi);
                let s = dx * dx + dy * dy + dz * dz;
                ox[l] = dx;
                oy[l] = dy;
                oz[l] = dz;
                os[l] = s;
                ov[l] = v[l];
                let s = s + away[l];
                nearest[l] = if s < nearest[l] { s } else { nearest[l] };
            }
        }
        let mut closest = nearest[0];
        for s in nearest {
            closest = if s < closest { s } else { closest };
        }
        let inside = closest >= reach * reach;
        let base = if inside { 1.0 } else { 0.0 };
        let total = if self.n == 4 {
            self.sums::<true>(blocks, closest, base)
        } else {
            self.sums::<false>(blocks, closest, base)
        };
        let mut shift = [0.0; 3];
        for k in 0..3 {
            let t = &total[k];
            let sum = ((t[0] + t[4]) + (t[1] + t[5])) + ((t[2] + t[6]) + (t[3] + t[7]));
            shift[k] = self.scale * self.slope_factor * sum;
        }
        let length = (shift[0] * shift[0] + shift[1] * shift[1] + shift[2] * shift[2]).sqrt();
        if length > self.cap {
            for s in &mut shift {
                *s *= self.cap / length;
            }
        }
        (shift, if inside { 2 } else { 1 })
    }
}
