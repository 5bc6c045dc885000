use crate::neighbour_list::{LANES, PairSum};
use crate::points::Carrier;
use crate::{FluidOptions, ShiftingOptions};

/// Where a particle is: region F of Eq. 11.
pub(crate) const FREE: u8 = 1;

/// Shift of each particle and the region it is in.
///
/// Source: `liu2022`, Eq. 10, 11.
pub(crate) struct Shift<'a> {
    carriers: &'a [Carrier],
    /// 1 for free-surface points.
    flags: &'a [u8],
    ranks: &'a [u32],
    h: f64,
    inverse_reach: f64,
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
        flags: &'a [u8],
        ranks: &'a [u32],
    ) -> Self {
        let (kernel, h) = (fluid.kernel(), fluid.h());
        let mach = shifting.mach.unwrap_or(fluid.expected_speed / fluid.sound_speed);
        Self {
            carriers,
            flags,
            ranks,
            h,
            inverse_reach: 1.0 / kernel.reach(),
            slope_factor: kernel.slope_factor(),
            relative: kernel.alpha() / kernel.value(fluid.spacing),
            r: shifting.r,
            n: shifting.n,
            scale: -shifting.k_cfl * mach * shifting.factor * h * h,
            cap: shifting.cap * fluid.spacing,
        }
    }
}

/// Distances squared of one particle's neighbours.
#[derive(Debug, Default)]
pub(crate) struct ShiftScratch {
    squared: Vec<f64>,
}

impl PairSum for Shift<'_> {
    type Scratch = ShiftScratch;
    /// Shift, and 0 on the free surface, 1 near it, 2 inside.
    type Output = ([f64; 3], u8);

    #[inline(always)]
    fn of(&self, receiver: usize, list: &[u32], scratch: &mut ShiftScratch) -> ([f64; 3], u8) {
        let rank = self.ranks[receiver] as usize;
        if self.flags[rank] == FREE {
            return ([0.0; 3], 0);
        }
        let [xi, yi, zi, ..] = self.carriers[rank];
        scratch.squared.resize(list.len(), 0.0);
        let squared = &mut scratch.squared[..list.len()];
        let reach = 2.0 * self.h;
        let mut nearest = reach * reach;
        for (k, &j) in list.iter().enumerate() {
            let j = j as usize;
            let c = &self.carriers[j];
            let (dx, dy, dz) = (c[0] - xi, c[1] - yi, c[2] - zi);
            let s = dx * dx + dy * dy + dz * dz;
            squared[k] = s;
            let s = if self.flags[j] == FREE { s } else { f64::INFINITY };
            nearest = if s < nearest { s } else { nearest };
        }
        let inside = nearest >= reach * reach;
        let base = if inside { 1.0 } else { 0.0 };
        let mut total = [[0.0f64; LANES]; 3];
        for (block, squares) in list.chunks_exact(LANES).zip(squared.chunks_exact(LANES)) {
            let (mut x, mut y, mut z, mut v) =
                ([0.0f64; LANES], [0.0f64; LANES], [0.0f64; LANES], [0.0f64; LANES]);
            for l in 0..LANES {
                let j = &self.carriers[block[l] as usize];
                x[l] = j[0];
                y[l] = j[1];
                z[l] = j[2];
                v[l] = j[3];
            }
            for l in 0..LANES {
                let p = squares[l].sqrt() * self.inverse_reach;
                let left = 1.0 - p;
                let left = if left > 0.0 { left } else { 0.0 };
                let cube = left * left * left;
                let relative = self.relative * (1.0 + 4.0 * p) * (cube * left);
                let mut power = relative;
                for _ in 1..self.n {
                    power *= relative;
                }
                let g = cube * v[l] * (base + self.r * power);
                let g = if squares[l] < nearest { g } else { 0.0 };
                total[0][l] += g * (x[l] - xi);
                total[1][l] += g * (y[l] - yi);
                total[2][l] += g * (z[l] - zi);
            }
        }
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
