//! One file per way to share out a ball among cells.

mod centre;
mod cube;
mod decomposition;
mod points;

use fieldstone_geometry::Ball;
use fieldstone_mesh::{Cells, PathCounts};

use crate::periodic::Image;
use crate::{FieldsError, Method};

/// A method made ready for a set of cells.
pub(crate) struct Binning<'a, C: Cells> {
    cells: &'a C,
    method: Method,
    /// Points of the unit ball, each standing for the same share of its volume.
    points: Vec<[f64; 3]>,
    /// Cells in parts that the decomposition can take.
    elements: Option<decomposition::Elements>,
}

impl<'a, C: Cells> Binning<'a, C> {
    /// Whether the method can do with these cells.
    pub fn check(cells: &C, method: Method) -> Result<(), FieldsError> {
        if matches!(method, Method::Decomposition | Method::Cube) && !cells.is_polyhedral() {
            return Err(FieldsError::Combination {
                what: "round cells have no planar faces: choose the exact kernel or points instead of decomposition or cubes",
            });
        }
        Ok(())
    }

    pub fn new(cells: &'a C, method: Method) -> Result<Self, FieldsError> {
        Self::check(cells, method)?;
        let points = match method {
            Method::Divided => points::satellites(),
            Method::Sampled(n) => points::regular(n),
            _ => Vec::new(),
        };
        let elements = match method {
            Method::Decomposition => Some(decomposition::Elements::new(cells)?),
            _ => None,
        };
        Ok(Self { cells, method, points, elements })
    }

    /// Whether a ball counts where its centre is, whatever its radius.
    pub fn by_centre(&self) -> bool {
        matches!(self.method, Method::Centre | Method::CentreSmoothed)
    }

    /// Appends (cell, volume) pairs for `ball`, which is at the centre of `image`, in any order and possibly several per cell.
    ///
    /// `seed` must differ between balls and be the same for a ball in every run.
    pub fn bin(&self, ball: &Ball, image: &Image<'_>, seed: u64, scratch: &mut C::Scratch, out: &mut Vec<(u32, f64)>) {
        if let Some(elements) = &self.elements {
            return elements.bin(self.cells, ball, out);
        }
        match self.method {
            Method::Kernel | Method::KernelF64 | Method::Decomposition => self.cells.overlap_ball(ball, scratch, out),
            Method::Centre => centre::bin(self.cells, ball, scratch, out),
            Method::CentreSmoothed => centre::bin_smoothed(self.cells, ball, scratch, out),
            Method::Cube => cube::bin(self.cells, ball, scratch, out),
            Method::Divided | Method::Sampled(_) => points::bin(self.cells, ball, image, &self.points, scratch, out),
            Method::MonteCarlo(n) => points::bin(self.cells, ball, image, &points::random(n, seed), scratch, out),
        }
    }

    /// Volume of the ball that found a cell, given its row.
    ///
    /// Averaging over neighbours changes the sum of a row; what it started from was the whole ball.
    pub fn placed(&self, ball: &Ball, row: &[(u32, f64)]) -> f64 {
        if self.method == Method::CentreSmoothed {
            return if row.is_empty() { 0.0 } else { ball.volume() };
        }
        row.iter().map(|p| p.1).sum()
    }

    /// Working memory of one thread.
    pub fn scratch(&self) -> C::Scratch {
        if self.method == Method::KernelF64 { self.cells.fast_scratch() } else { self.cells.scratch() }
    }

    /// How often balls have been evaluated with this working memory.
    pub fn path_counts(&self, scratch: &C::Scratch) -> PathCounts {
        self.cells.path_counts(scratch)
    }
}
