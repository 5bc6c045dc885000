use fieldstone_mesh::Grid;

use crate::SurfaceError;

/// Corners of the cells of a regular grid, or of one plane of it: where level sets and gridded fields live.
///
/// Nodes are numbered with x fastest. A slice has a single node along one axis.
///
/// ```
/// use fieldstone_surface::Nodes;
/// let nodes = Nodes::around(&[[0.0; 3], [1.0, 0.0, 0.0]], 0.5, 0.25)?;
/// assert_eq!(nodes.counts(), [9, 5, 5]);
/// assert_eq!(nodes.position(0), [-0.5, -0.5, -0.5]);
/// # Ok::<(), fieldstone_surface::SurfaceError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Nodes {
    origin: [f64; 3],
    spacing: [f64; 3],
    counts: [usize; 3],
}

/// More nodes than this cannot be numbered by the surfaces made from them.
const MOST: usize = u32::MAX as usize / 8;

impl Nodes {
    /// `counts` nodes along each axis from `origin` on, `spacing` apart.
    ///
    /// # Errors
    /// [`SurfaceError::Option`] for numbers that are not finite, a spacing of 0 or less, no or more than 5·10⁸ nodes.
    pub fn new(origin: [f64; 3], spacing: [f64; 3], counts: [usize; 3]) -> Result<Self, SurfaceError> {
        if let Some(&value) = origin.iter().find(|x| !x.is_finite()) {
            return Err(SurfaceError::Option { name: "the origin of the nodes", value, allowed: "finite" });
        }
        if let Some(&value) = spacing.iter().find(|s| !(**s > 0.0 && s.is_finite())) {
            return Err(SurfaceError::Option { name: "the distance of nodes", value, allowed: "finite and above 0" });
        }
        let total = counts.iter().try_fold(1usize, |n, &c| n.checked_mul(c)).unwrap_or(usize::MAX);
        if total == 0 || total > MOST {
            let allowed = "at least 1 and at most 536870911; give larger cells or a smaller region";
            return Err(SurfaceError::Option { name: "the number of nodes", value: total as f64, allowed });
        }
        Ok(Self { origin, spacing, counts })
    }

    /// Nodes `cell` apart around all `positions` and `margin` beyond them. They lie at whole multiples of `cell`, so
    /// that grids of successive frames fit together.
    ///
    /// # Errors
    /// As [`Nodes::new`]; no positions.
    pub fn around(positions: &[[f64; 3]], margin: f64, cell: f64) -> Result<Self, SurfaceError> {
        if positions.is_empty() {
            return Err(SurfaceError::Option { name: "the number of particles", value: 0.0, allowed: "at least 1" });
        }
        if !(cell > 0.0 && cell.is_finite()) {
            return Err(SurfaceError::Option { name: "the size of cells", value: cell, allowed: "finite and above 0" });
        }
        let ends = |k: usize| {
            let least = positions.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
            let most = positions.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max);
            [((least - margin) / cell).floor(), ((most + margin) / cell).ceil()]
        };
        let ends = [ends(0), ends(1), ends(2)];
        // A float that is no count saturates and is refused below.
        let counts = ends.map(|[low, high]| ((high - low) as usize).saturating_add(1));
        Self::new(ends.map(|[low, _]| low * cell), [cell; 3], counts)
    }

    /// The corners of a grid's cells.
    ///
    /// # Errors
    /// Too many of them.
    pub fn of(grid: &Grid) -> Result<Self, SurfaceError> {
        Self::new(grid.low(), grid.spacing(), grid.cells().map(|n| n + 1))
    }

    /// The grid whose corners these are; `None` for a slice.
    pub fn grid(&self) -> Option<Grid> {
        let cells = self.counts.map(|n| n - 1);
        let high = std::array::from_fn(|k| self.origin[k] + self.spacing[k] * cells[k] as f64);
        Grid::new(self.origin, high, cells).ok()
    }

    /// The nodes of one plane, at `at` along `axis` (0 x, 1 y, 2 z).
    ///
    /// # Errors
    /// `at` is outside the nodes; `axis` is above 2.
    pub fn slice(&self, axis: usize, at: f64) -> Result<Self, SurfaceError> {
        if axis > 2 {
            return Err(SurfaceError::Option { name: "the axis", value: axis as f64, allowed: "0, 1 or 2" });
        }
        let high = self.origin[axis] + self.spacing[axis] * (self.counts[axis] - 1) as f64;
        if !(at >= self.origin[axis] && at <= high) {
            let allowed = "within the particles and their margin";
            return Err(SurfaceError::Option { name: "the position of the slice", value: at, allowed });
        }
        let (mut origin, mut counts) = (self.origin, self.counts);
        (origin[axis], counts[axis]) = (at, 1);
        Self::new(origin, self.spacing, counts)
    }

    /// First node.
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// Distance of neighbouring nodes along each axis.
    pub fn spacing(&self) -> [f64; 3] {
        self.spacing
    }

    /// Nodes along each axis.
    pub fn counts(&self) -> [usize; 3] {
        self.counts
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.counts.iter().product()
    }

    /// Never: there is at least one node.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Number of the node at the given indices.
    pub fn node_at(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.counts[0] * (j + self.counts[1] * k)
    }

    /// Where a node is.
    pub fn position(&self, node: usize) -> [f64; 3] {
        let [nx, ny, _] = self.counts;
        let at = [node % nx, node / nx % ny, node / (nx * ny)];
        std::array::from_fn(|k| self.origin[k] + self.spacing[k] * at[k] as f64)
    }
}

/// One number on each of the [`Nodes`].
#[derive(Debug, Clone, PartialEq)]
pub struct NodeField {
    /// Where.
    pub nodes: Nodes,
    /// One number per node, x fastest.
    pub values: Vec<f64>,
    /// The value on the surface; larger ones are inside the fluid.
    pub surface_value: f64,
    /// Whether the fluid ends at a node's other side because of a wall, a boundary particle or the box, and not because
    /// of a free surface. Empty where there is nothing of the kind.
    pub at_wall: Vec<bool>,
}

/// Share of the field's range within which a node counts as on the surface: what rounding leaves on walls.
const ON_SURFACE: f64 = 1e-9;

impl NodeField {
    /// Whether a node is in the fluid, or on its surface or a wall to rounding: where quantities of it have values.
    pub fn holds_fluid(&self, node: usize) -> bool {
        self.values[node] >= self.surface_value - ON_SURFACE
    }
}
