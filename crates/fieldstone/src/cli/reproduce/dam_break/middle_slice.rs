//! Free surface and pressure in the plane in the middle of the tank.

use anyhow::anyhow;
use fieldstone::particles::Domain;
use fieldstone::sph::Solver;
use fieldstone::surface::{
    Column, Exact, LevelSetOptions, NodeField, Nodes, SurfaceOptions, Surroundings, detect_surface, interpolate,
    level_set,
};

/// A piece of a line in the plane of x and z.
pub(super) type Segment = [[f64; 2]; 2];

/// Surroundings of the fluid for what looks at particles without a solver.
pub(super) fn surroundings(solver: &Solver) -> anyhow::Result<Surroundings> {
    let (fluid, boundaries) = (&solver.flow().fluid, &solver.flow().boundaries);
    let periodic = boundaries.periodic.iter().any(|&p| p);
    let domain = Domain::new(boundaries.low, boundaries.high, boundaries.periodic);
    Ok(Surroundings {
        domain: periodic.then_some(domain?),
        walls: boundaries.walls.iter().map(|w| w.plane).collect(),
        volumes: Some(solver.state().density.iter().map(|d| fluid.particle_mass() / d).collect()),
        ..Surroundings::new(fluid.spacing)
    })
}

/// The level set of the free surface (Eq. 33, 34) on nodes.
pub(super) fn surface_field(solver: &Solver, nodes: &Nodes) -> anyhow::Result<NodeField> {
    let around = surroundings(solver)?;
    let positions = &solver.state().x;
    let found = detect_surface(positions, &Exact::default(), &around, &SurfaceOptions::LABELS)?;
    Ok(level_set(positions, &around, &found.detection, nodes, &LevelSetOptions::default())?)
}

/// The middle of the tank along y.
pub(super) fn middle(solver: &Solver) -> f64 {
    let boundaries = &solver.flow().boundaries;
    0.5 * (boundaries.low[1] + boundaries.high[1])
}

/// Level set and pressure on the nodes of a plane across y.
pub(super) struct MiddleSlice {
    field: NodeField,
    pressure: Vec<f64>,
}

impl MiddleSlice {
    /// The plane in the middle, with nodes `cell` spacings apart.
    pub fn new(solver: &Solver, cell: f64) -> anyhow::Result<Self> {
        let (state, fluid) = (solver.state(), &solver.flow().fluid);
        let nodes = Nodes::around(&state.x, 1.5 * fluid.spacing, cell * fluid.spacing)?.slice(1, middle(solver))?;
        let field = surface_field(solver, &nodes)?;
        let pressures: Vec<f64> = state.density.iter().map(|&d| fluid.pressure(d)).collect();
        let points: Vec<[f64; 3]> = (0..nodes.len()).map(|n| nodes.position(n)).collect();
        let columns = [Column { components: 1, data: &pressures }];
        let found = interpolate(&state.x, &surroundings(solver)?, &columns, &points, 1.5)?;
        let pressure = found.values.into_iter().next().ok_or_else(|| anyhow!("there is no pressure"))?;
        Ok(Self { field, pressure })
    }

    /// Pressure at a point of the plane; `None` outside the fluid.
    pub fn pressure(&self, [x, z]: [f64; 2]) -> Option<f64> {
        let nodes = &self.field.nodes;
        let (origin, spacing, counts) = (nodes.origin(), nodes.spacing(), nodes.counts());
        let cell = |k: usize, value: f64| {
            let at = (value - origin[k]) / spacing[k];
            let inside = at >= 0.0 && at < (counts[k] - 1) as f64;
            inside.then(|| (at as usize, at - at.floor()))
        };
        let ((i, a), (k, b)) = (cell(0, x)?, cell(2, z)?);
        let blend = |values: &[f64]| {
            let at = |i: usize, k: usize| values[nodes.node_at([i, 0, k])];
            (1.0 - b) * ((1.0 - a) * at(i, k) + a * at(i + 1, k))
                + b * ((1.0 - a) * at(i, k + 1) + a * at(i + 1, k + 1))
        };
        (blend(&self.field.values) > self.field.surface_value).then(|| blend(&self.pressure))
    }

    /// The free surface: the level of the field on the triangles of the nodes' squares; not where walls end the fluid.
    pub fn line(&self) -> Vec<Segment> {
        let nodes = &self.field.nodes;
        let [nx, _, nz] = nodes.counts();
        let mut segments = Vec::new();
        for k in 0..nz - 1 {
            for i in 0..nx - 1 {
                let [a, b, c, d] =
                    [[i, k], [i + 1, k], [i, k + 1], [i + 1, k + 1]].map(|[i, k]| nodes.node_at([i, 0, k]));
                for triangle in [[a, b, d], [a, d, c]] {
                    segments.extend(self.cut(triangle));
                }
            }
        }
        segments
    }

    fn cut(&self, triangle: [usize; 3]) -> Option<Segment> {
        let level = self.field.surface_value;
        let inside = |n: usize| self.field.values[n] > level;
        let at_wall = |n: usize| self.field.at_wall.get(n) == Some(&true);
        if triangle.iter().any(|&n| at_wall(n)) {
            return None;
        }
        let mut ends = Vec::with_capacity(2);
        for (p, q) in [(0, 1), (1, 2), (2, 0)] {
            let (p, q) = (triangle[p], triangle[q]);
            if inside(p) != inside(q) {
                let t = (level - self.field.values[p]) / (self.field.values[q] - self.field.values[p]);
                let (from, to) = (self.field.nodes.position(p), self.field.nodes.position(q));
                ends.push([0, 2].map(|axis| from[axis] + t * (to[axis] - from[axis])));
            }
        }
        <Segment>::try_from(ends).ok()
    }
}
