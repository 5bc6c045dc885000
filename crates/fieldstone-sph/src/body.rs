use std::f64::consts::PI;
use std::sync::Arc;

use rayon::prelude::*;

use crate::{ClosedSurface, FluidOptions, Motion, Pose, Slip, SphError};

/// A solid shape.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// An axis-parallel box.
    Box {
        /// Lower corner.
        low: [f64; 3],
        /// Upper corner.
        high: [f64; 3],
    },
    /// A cylinder along an axis; in two dimensions along z it is a disc.
    Cylinder {
        /// A point on the axis, in the middle of the cylinder.
        centre: [f64; 3],
        /// Radius.
        radius: f64,
        /// Length along the axis.
        length: f64,
        /// 0, 1 or 2 for x, y or z.
        axis: usize,
    },
    /// A sphere; in two dimensions a disc.
    Sphere {
        /// Centre.
        centre: [f64; 3],
        /// Radius.
        radius: f64,
    },
    /// The inside of a surface of triangles; in three dimensions only.
    Surface(Arc<ClosedSurface>),
}

impl Shape {
    /// The box around it.
    pub fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        match *self {
            Self::Surface(ref surface) => surface.bounds(),
            Self::Box { low, high } => (low, high),
            Self::Sphere { centre, radius } => (centre.map(|c| c - radius), centre.map(|c| c + radius)),
            Self::Cylinder { centre, radius, length, axis } => {
                let half: [f64; 3] = std::array::from_fn(|k| if k == axis { 0.5 * length } else { radius });
                (std::array::from_fn(|k| centre[k] - half[k]), std::array::from_fn(|k| centre[k] + half[k]))
            }
        }
    }

    /// Distance into the solid from its surface; negative outside. In two dimensions z does not count.
    pub fn depth(&self, x: [f64; 3], dimension: usize) -> f64 {
        match *self {
            Self::Surface(ref surface) => surface.depth(x),
            Self::Box { low, high } => {
                (0..dimension).map(|k| (x[k] - low[k]).min(high[k] - x[k])).fold(f64::INFINITY, f64::min)
            }
            Self::Sphere { centre, radius } => {
                radius - (0..dimension).map(|k| (x[k] - centre[k]).powi(2)).sum::<f64>().sqrt()
            }
            Self::Cylinder { centre, radius, length, axis } => {
                let across = (0..dimension).filter(|&k| k != axis).map(|k| (x[k] - centre[k]).powi(2)).sum::<f64>();
                let side = radius - across.sqrt();
                if axis < dimension { side.min(0.5 * length - (x[axis] - centre[axis]).abs()) } else { side }
            }
        }
    }

    /// Unit vector along which a point inside leaves the solid soonest. In two dimensions z does not count.
    ///
    /// Accuracy: rounding; 1e-6 for a surface of triangles, whose depth is differentiated. Where two ways out are equally long, one of
    /// them, or of a surface what lies between.
    pub fn way_out(&self, x: [f64; 3], dimension: usize) -> [f64; 3] {
        let mut way = [0.0; 3];
        let along =
            |k: usize, toward: f64| -> [f64; 3] { std::array::from_fn(|a| if a == k { toward.signum() } else { 0.0 }) };
        match *self {
            Self::Box { low, high } => {
                let (mut least, mut nearest) = (f64::INFINITY, way);
                for k in 0..dimension {
                    for (distance, toward) in [(x[k] - low[k], -1.0), (high[k] - x[k], 1.0)] {
                        if distance < least {
                            (least, nearest) = (distance, along(k, toward));
                        }
                    }
                }
                return nearest;
            }
            Self::Sphere { centre, .. } => (0..dimension).for_each(|k| way[k] = x[k] - centre[k]),
            Self::Cylinder { centre, radius, length, axis } => {
                (0..dimension).filter(|&k| k != axis).for_each(|k| way[k] = x[k] - centre[k]);
                let side = radius - length_of(way);
                if axis < dimension && 0.5 * length - (x[axis] - centre[axis]).abs() < side {
                    return along(axis, x[axis] - centre[axis]);
                }
            }
            Self::Surface(ref surface) => {
                let (low, high) = surface.bounds();
                let step = 1e-6 * (0..3).map(|k| high[k] - low[k]).fold(f64::INFINITY, f64::min);
                for (k, way) in way.iter_mut().enumerate() {
                    let beside = |sign: f64| {
                        surface.depth(std::array::from_fn(|a| x[a] + if a == k { sign * step } else { 0.0 }))
                    };
                    *way = beside(-1.0) - beside(1.0);
                }
            }
        }
        let length = length_of(way);
        // The centre of a disc, and the middle of a solid of triangles, are as far from every side.
        if length > 0.0 { way.map(|w| w / length) } else { along(dimension - 1, 1.0) }
    }

    /// Whether a point is inside. In two dimensions z does not count.
    pub fn contains(&self, x: [f64; 3], dimension: usize) -> bool {
        match self {
            Self::Surface(surface) => surface.contains(x),
            other => other.depth(x, dimension) > 0.0,
        }
    }

    /// Its own volume; the area in two dimensions.
    pub fn volume(&self, dimension: usize) -> f64 {
        match *self {
            Self::Surface(ref surface) => surface.volume(),
            Self::Box { low, high } => (0..dimension).map(|k| high[k] - low[k]).product(),
            Self::Sphere { radius, .. } if dimension == 2 => PI * radius * radius,
            Self::Sphere { radius, .. } => 4.0 / 3.0 * PI * radius.powi(3),
            Self::Cylinder { radius, axis, .. } if axis >= dimension => PI * radius * radius,
            Self::Cylinder { radius, length, .. } if dimension == 2 => 2.0 * radius * length,
            Self::Cylinder { radius, length, .. } => PI * radius * radius * length,
        }
    }

    /// Whether its bounds are divided evenly into cells, instead of cutting it out of cubes.
    fn is_divided(&self) -> bool {
        matches!(self, Self::Box { .. } | Self::Surface(_))
    }

    /// Number of cells along each axis that its bounds are divided into, or covered with, and the edges of a cell.
    pub(crate) fn cells(&self, spacing: f64, dimension: usize) -> ([usize; 3], [f64; 3]) {
        let (low, high) = self.bounds();
        let even = self.is_divided();
        let mut counts = [1usize; 3];
        let mut cell = [0.0; 3];
        for k in 0..dimension {
            let extent = high[k] - low[k];
            // A round shape is never cut at the last cell.
            let cells = extent / spacing;
            let rounded = if even { cells.round() } else { 2.0 * (0.5 * cells).ceil() };
            counts[k] = rounded.max(1.0) as usize;
            cell[k] = if even { extent / counts[k] as f64 } else { spacing };
        }
        (counts, cell)
    }

    /// Centres of lattice cells inside the shape, and their volume. A box is divided evenly, its cells close to cubes
    /// of edge `spacing`, and so is the box around a surface; round shapes are cut out of a lattice that is symmetric
    /// to their centre.
    pub fn lattice(&self, spacing: f64, dimension: usize) -> (Vec<[f64; 3]>, f64) {
        let even = self.is_divided();
        let (low, high) = self.bounds();
        let (counts, cell) = self.cells(spacing, dimension);
        let middle: [f64; 3] = std::array::from_fn(|k| if k < dimension { 0.5 * (low[k] + high[k]) } else { 0.0 });
        let centre = |index: [usize; 3]| -> [f64; 3] {
            std::array::from_fn(|a| {
                if a >= dimension {
                    0.0
                } else if even {
                    low[a] + (index[a] as f64 + 0.5) * cell[a]
                } else {
                    middle[a] + (index[a] as f64 + 0.5 - 0.5 * counts[a] as f64) * cell[a]
                }
            })
        };
        let row = |i: usize| -> Vec<[f64; 3]> {
            let cells = (0..counts[1]).flat_map(|j| (0..counts[2]).map(move |k| [i, j, k]));
            cells.map(centre).filter(|&x| self.contains(x, dimension)).collect()
        };
        let rows: Vec<Vec<[f64; 3]>> = (0..counts[0]).into_par_iter().map(row).collect();
        let points = rows.concat();
        (points, cell[..dimension].iter().product())
    }
}

fn length_of(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// A solid body, at rest or in a prescribed motion: ghost particles whose pressure is interpolated from the fluid.
///
/// Bodies are neither mirrored nor repeated. Where one stands on a wall, let it reach beyond by the kernel's radius 2h. Along a periodic
/// axis it stays 2h away from both faces, or goes 2h beyond both, or is given a second time, a period farther: refused otherwise.
///
/// Bodies at rest, and bodies with the same motion, may overlap: together they are one solid, and what several of them cover
/// belongs to the first, with its slip and in its force. Bodies that move otherwise must not overlap at time 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Its shape, where it is without a displacement.
    pub shape: Shape,
    /// Friction.
    pub slip: Slip,
    /// How it moves, without turning; at rest where absent.
    pub motion: Option<Motion>,
}

impl Body {
    /// A body at rest.
    pub fn new(shape: Shape, slip: Slip) -> Self {
        Self { shape, slip, motion: None }
    }

    /// Where it is and how it moves at a time.
    pub fn pose(&self, time: f64) -> Pose {
        self.motion.as_ref().map_or_else(Pose::default, |motion| motion.at(time))
    }

    /// Whether a point lies in it at a time.
    pub fn contains(&self, x: [f64; 3], time: f64, dimension: usize) -> bool {
        self.shape.contains(self.as_at_rest(x, time), dimension)
    }

    /// Unit vector along which a point inside leaves it soonest at a time.
    pub(crate) fn way_out(&self, x: [f64; 3], time: f64, dimension: usize) -> [f64; 3] {
        self.shape.way_out(self.as_at_rest(x, time), dimension)
    }

    /// Distance into it from its surface at a time; negative outside.
    pub(crate) fn depth(&self, x: [f64; 3], time: f64, dimension: usize) -> f64 {
        self.shape.depth(self.as_at_rest(x, time), dimension)
    }

    /// A point at a time, where it would be had the body not moved.
    fn as_at_rest(&self, x: [f64; 3], time: f64) -> [f64; 3] {
        let moved = self.pose(time).displacement;
        std::array::from_fn(|k| x[k] - moved[k])
    }

    /// Whether both stay where they are to each other.
    pub(crate) fn moves_with(&self, other: &Self) -> bool {
        self.motion == other.motion
    }

    /// A place at time 0 that lies in two bodies: a lattice point of one in the other.
    pub(crate) fn common_place(&self, other: &Self, fluid: &FluidOptions) -> Option<[f64; 3]> {
        let bounds = [self, other].map(|body| (body.shape.bounds(), body.pose(0.0).displacement));
        let [((low, high), moved), ((other_low, other_high), other_moved)] = bounds;
        let apart = |k: usize| {
            high[k] + moved[k] <= other_low[k] + other_moved[k] || other_high[k] + other_moved[k] <= low[k] + moved[k]
        };
        // Lattices cost something, and most bodies are far from each other.
        if (0..fluid.dimension).any(apart) {
            return None;
        }
        [(self, other), (other, self)].into_iter().find_map(|(one, two)| {
            let moved = one.pose(0.0).displacement;
            let (points, _) = one.shape.lattice(fluid.spacing, fluid.dimension);
            let placed = points.into_par_iter().map(|x| std::array::from_fn(|k| x[k] + moved[k]));
            placed.find_first(|&x| two.contains(x, 0.0, fluid.dimension))
        })
    }

    /// Ghost particles, without displacement: the outermost layer of thickness 2h, and the volume of each.
    pub(crate) fn ghosts(&self, fluid: &FluidOptions) -> (Vec<[f64; 3]>, f64) {
        let (mut points, volume) = self.shape.lattice(fluid.spacing, fluid.dimension);
        let reach = fluid.kernel().reach();
        let near: Vec<bool> = points.par_iter().map(|&x| self.shape.depth(x, fluid.dimension) < reach).collect();
        let mut near = near.into_iter();
        points.retain(|_| near.next().unwrap_or(true));
        (points, volume)
    }

    pub(crate) fn validate(&self, body: usize, fluid: &FluidOptions) -> Result<(), SphError> {
        let (low, high) = self.shape.bounds();
        let needed = 4.0 * fluid.spacing;
        for axis in 0..fluid.dimension {
            let thickness = high[axis] - low[axis];
            // A thickness of exactly four spacings may come rounded.
            if thickness.is_nan() || thickness < needed * (1.0 - 1e-9) {
                return Err(SphError::ThinBody { body, thickness, axis: ['x', 'y', 'z'][axis], needed });
            }
        }
        if let Shape::Surface(surface) = &self.shape {
            if fluid.dimension == 2 {
                let message = "a surface of triangles bounds a solid in three dimensions only".into();
                return Err(SphError::NoSolid { message });
            }
            if let Some((thickness, at)) = surface.thinner_than(needed * (1.0 - 1e-6)) {
                return Err(SphError::ThinSurface { body, thickness, at, needed });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_divided_evenly_and_fills_its_volume() {
        let shape = Shape::Box { low: [0.0; 3], high: [1.2, 0.3, 0.6] };
        let (points, volume) = shape.lattice(0.01, 3);
        assert_eq!(points.len(), 120 * 30 * 60);
        assert!((points.len() as f64 * volume - 0.216).abs() < 1e-12);
        assert!(points.iter().all(|p| shape.depth(*p, 3) > 0.0049));
    }

    #[test]
    fn the_way_out_leads_to_the_surface() {
        let corner = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let faces = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let surface = ClosedSurface::new(corner.to_vec(), faces).unwrap();
        let shapes = [
            Shape::Box { low: [-0.2, 0.0, 0.1], high: [1.0, 0.7, 0.9] },
            Shape::Sphere { centre: [0.3, 0.2, 0.4], radius: 0.5 },
            Shape::Cylinder { centre: [0.3, 0.3, 0.3], radius: 0.4, length: 0.6, axis: 2 },
            Shape::Surface(Arc::new(surface)),
        ];
        for (shape, dimension) in shapes.iter().flat_map(|s| [(s, 2), (s, 3)]) {
            if dimension == 2 && matches!(shape, Shape::Surface(_)) {
                continue;
            }
            for x in [[0.3, 0.25, 0.35], [0.21, 0.3, 0.2], [0.12, 0.2, 0.31]] {
                let (depth, way) = (shape.depth(x, dimension), shape.way_out(x, dimension));
                assert!(depth > 0.0 && (length_of(way) - 1.0).abs() < 1e-12 && (dimension == 3 || way[2] == 0.0));
                let at = |share: f64| -> [f64; 3] { std::array::from_fn(|k| x[k] + share * depth * way[k]) };
                assert!(shape.depth(at(1.0), dimension).abs() < 1e-5 * depth, "{shape:?} {x:?} {way:?}");
                assert!(!shape.contains(at(1.0001), dimension) && shape.contains(at(0.9999), dimension));
            }
            let centre = shape.bounds();
            let middle: [f64; 3] = std::array::from_fn(|k| 0.5 * (centre.0[k] + centre.1[k]));
            assert!((length_of(shape.way_out(middle, dimension)) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_disc_is_symmetric_to_its_centre() {
        let shape = Shape::Sphere { centre: [1.0, 2.0, 0.0], radius: 1.0 };
        let (points, volume) = shape.lattice(0.02, 2);
        let area = points.len() as f64 * volume;
        assert!((area / shape.volume(2) - 1.0).abs() < 5e-3, "{area}");
        let sum = points.iter().fold([0.0; 2], |s, p| [s[0] + p[0] - 1.0, s[1] + p[1] - 2.0]);
        assert!(sum[0].abs() < 1e-9 && sum[1].abs() < 1e-9, "{sum:?}");
    }
}
