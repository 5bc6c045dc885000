use fieldstone_particles::{NeighbourGrid, NeighbourOptions};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::fluid_region::FluidRegion;
use crate::{Detection, NodeField, Nodes, PeriodicFaces, Smoothing, SurfaceError, Surroundings, normals};

/// How the distance from the free surface follows from its particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SurfaceDistance {
    /// From the plane through the nearest surface particle, as printed: jumps where another one becomes the nearest.
    Nearest,
    /// Averaged over the surface particles within R with weights (1 − r²/R²)⁴, R = 2 Δx, or where the
    /// nearest is farther than Δx twice its distance, at most 2 Δx more: continuous, so surfaces are smooth, and no particle decides alone.
    #[default]
    Blended,
}

/// Options of [`level_set`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelSetOptions {
    /// Kernel and smoothing length h/Δx, for the normals and the scale 2h of the level set.
    pub smoothing: Smoothing,
    /// Which distance.
    pub distance: SurfaceDistance,
    /// Points farther than this from all particles, in spacings, are outside: normals of spray and of rims span planes
    /// that reach into nothing. Half the diagonal of a lattice's cube is 0.87.
    pub cover: f64,
    /// Whether the fluid ends at the faces of a periodic box.
    pub periodic_faces: PeriodicFaces,
}

impl Default for LevelSetOptions {
    /// The paper's kernel and smoothing length (Wendland C2, h = 2 Δx), blended, 1.2 Δx, an end at periodic faces.
    fn default() -> Self {
        let smoothing = Smoothing { kernel: crate::Kernel::WendlandC2, length: 2.0 };
        let (distance, periodic_faces) = (SurfaceDistance::default(), PeriodicFaces::default());
        Self { smoothing, distance, cover: 1.2, periodic_faces }
    }
}

/// Averages reach at least this far, over the spacing.
const BLEND: f64 = 2.0;

/// No point inside a lattice is farther than this from its particles, over the spacing (√3/2).
const DENSE: f64 = 0.9;

/// Of the smallest eigenvalue of the neighbours' scatter to its trace: below, they lie in a sheet.
const FLAT: f64 = 0.08;

/// Radius of the ball that has a particle's volume, over the spacing: (3/4π)^{1/3}.
const BALL: f64 = 0.620_350_490_899_400_1;

/// In the plane that of the circle: π^{−1/2}.
const CIRCLE: f64 = 0.564_189_583_547_756_3;

/// What a surface particle says about the points near it.
#[derive(Debug, Clone, Copy)]
enum Shape {
    /// Fluid on one side of a plane, the normal outwards.
    Side(DVec3),
    /// A sheet of one layer, in the plane a line: its normal, and at a rim the outward direction along it, else zero.
    Sheet(DVec3, DVec3),
    /// Spray: a ball of this radius over the spacing.
    Drop(f64),
}

/// The level set of the free surface: φ > φ₀ inside the fluid, φ₀ = −Δx/4h on the surface, from −1 to 1.
///
/// $$ d = (x_F - x)\cdot n_F, \qquad \phi = \max(-1, \min(1, d / 2h)) $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | x_F, n_F | the nearest surface particle and its outward normal ([`normals`]) | length, – |
/// | h | smoothing length, 2 Δx | length |
/// | φ₀ | [`NodeField::surface_value`]: half a spacing outside the surface particles | – |
///
/// Beyond the paper: where a particle's neighbours lie in a plane, d = −|(x_F − x)·n| with that plane's normal, a sheet Δx
/// thick. Other particles without a normal, or whose neighbours leave the cones along both n and −n empty, have no side:
/// there d = 0.62 Δx − Δx/2 − |x − x_F|, a ball of the particle's volume. In two dimensions lines are what sheets are in
/// three, and circles of 0.56 Δx what balls are; nodes are then one layer, at any z. Distances are blended by default ([`SurfaceDistance`]). Points beyond
/// [`LevelSetOptions::cover`] are outside. Walls, boundary particles (half way to them) and, where
/// [`LevelSetOptions::periodic_faces`] says so, the faces of a periodic box end the fluid: nodes where they do are marked
/// in [`NodeField::at_wall`].
///
/// Cost: a neighbour search per node. The result does not depend on the number of threads.
///
/// Source: `liu2022`, Eq. 33, 34; `marrone2010`.
///
/// # Errors
/// A label or position too few; a cover outside 1 to 4; as [`normals`].
///
/// ```
/// use fieldstone_surface::{Exact, LevelSetOptions, Nodes, SurfaceOptions, Surroundings, detect_surface, level_set};
/// let block: Vec<[f64; 3]> =
///     (0..1000).map(|i| [i % 10, i / 10 % 10, i / 100].map(|k| f64::from(k) + 0.5)).collect();
/// let around = Surroundings::new(1.0);
/// let found = detect_surface(&block, &Exact::default(), &around, &SurfaceOptions::LABELS)?;
/// let nodes = Nodes::around(&block, 2.0, 0.5)?;
/// let field = level_set(&block, &around, &found.detection, &nodes, &LevelSetOptions::default())?;
/// let at = |x: [f64; 3]| (0..nodes.len()).find(|&n| nodes.position(n) == x).map(|n| field.values[n]);
/// // In the middle of a face of the block, half a spacing outside its particles.
/// assert!((at([10.0, 5.0, 5.0]).unwrap_or(1.0) - field.surface_value).abs() < 1e-12);
/// assert!(at([5.0; 3]) == Some(1.0) && at([11.5, 5.0, 5.0]) == Some(-1.0));
/// # Ok::<(), fieldstone_surface::SurfaceError>(())
/// ```
pub fn level_set(
    positions: &[[f64; 3]],
    surroundings: &Surroundings,
    detection: &Detection,
    nodes: &Nodes,
    options: &LevelSetOptions,
) -> Result<NodeField, SurfaceError> {
    let (spacing, dimension) = (surroundings.spacing, surroundings.dimension);
    if detection.len() != positions.len() {
        return Err(SurfaceError::Length { name: "labels", found: detection.len(), expected: positions.len() });
    }
    if !(options.cover >= 1.0 && options.cover <= 4.0) {
        let name = "the cover over the spacing";
        return Err(SurfaceError::Option { name, value: options.cover, allowed: "between 1 and 4" });
    }
    let support = options.smoothing.support() * spacing;
    let wide = surroundings.grid(positions, support.max(2.5 * spacing))?;
    let normals = normals(&surroundings.scene(&wide), &options.smoothing)?;
    let members: Vec<usize> = (0..positions.len()).filter(|&i| detection.is_free_surface(i)).collect();
    let shapes: Vec<Shape> =
        members.par_iter().map(|&i| shape(&wide, i, DVec3::from_array(normals[i]), 2.5 * spacing)).collect();

    let surface: Vec<[f64; 3]> = members.iter().map(|&i| positions[i]).collect();
    let reach = (2.0 * options.smoothing.length + 1.0) * spacing;
    let search = NeighbourOptions { reach: reach + BLEND * spacing, dimension, domain: surroundings.domain };
    let near = NeighbourGrid::build(&surface, search)?;
    // Beyond the cover as far as an edge of a cell may reach.
    let seen = (options.cover + 0.5) * spacing;
    let points = surroundings.grid(positions, seen)?;
    let region = FluidRegion::new(surroundings, seen, options.periodic_faces);
    let scale = 2.0 * options.smoothing.length * spacing;
    let surface_value = -0.5 * spacing / scale;
    let value = |node: usize| -> (f64, bool) {
        let at = nodes.position(node);
        let within = region.at(&points, at);
        if within.nearest > seen {
            return (-1.0, within.limit <= 0.0);
        }
        let distance = match options.distance {
            SurfaceDistance::Nearest => nearest(&near, &shapes, at, reach, spacing),
            SurfaceDistance::Blended => blended(&near, &shapes, at, reach, spacing),
        };
        // Half a spacing outside the particles it is 0; the cover sets in where no point of a lattice is.
        let steepness = (scale + 0.5 * spacing) / ((options.cover - DENSE) * spacing);
        let covered = steepness * (options.cover * spacing - within.nearest);
        let free = (distance + 0.5 * spacing).min(covered);
        let inside = free.min(within.limit);
        ((inside / scale + surface_value).clamp(-1.0, 1.0), within.limit <= free && within.limit <= 0.0)
    };
    let pairs: Vec<(f64, bool)> = (0..nodes.len()).into_par_iter().map(value).collect();
    let at_wall = if region.has_limits() { pairs.iter().map(|p| p.1).collect() } else { Vec::new() };
    Ok(NodeField { nodes: nodes.clone(), values: pairs.into_iter().map(|p| p.0).collect(), surface_value, at_wall })
}

fn shape(grid: &NeighbourGrid, particle: usize, normal: DVec3, radius: f64) -> Shape {
    // Cone of 45°, the paper's.
    let cosine = std::f64::consts::FRAC_1_SQRT_2;
    let mut behind = false;
    let mut scatter = DMat3::ZERO;
    let visit = |_, displacement: [f64; 3], squared: f64| {
        if squared > 0.0 {
            let z = DVec3::from_array(displacement);
            behind |= -normal.dot(z) >= cosine * squared.sqrt();
            scatter += DMat3::from_cols(z * z.x, z * z.y, z * z.z);
        }
    };
    // The particle exists, and the grid was built for this radius.
    let _ = grid.for_each_neighbour(particle, radius, visit);
    let in_plane = grid.dimension() == 2;
    let trace = scatter.x_axis.x + scatter.y_axis.y + scatter.z_axis.z;
    if trace > 0.0 {
        let thin = if in_plane {
            let along = dominant_direction(scatter * (1.0 / trace));
            DVec3::new(-along.y, along.x, 0.0)
        } else {
            smallest_direction(scatter * (1.0 / trace))
        };
        let least = thin.dot(scatter * thin) / trace;
        // Of a line of particles two eigenvalues are small; in the plane a line is the sheet.
        let middle = 1.0 - least - largest_eigenvalue(scatter * (1.0 / trace));
        if least < FLAT && (in_plane || middle > 2.0 * FLAT) {
            let along = normal - thin * normal.dot(thin);
            let rim = if along.length() > 0.5 { along.normalize() } else { DVec3::ZERO };
            return Shape::Sheet(thin, rim);
        }
    }
    let drop = Shape::Drop(if in_plane { CIRCLE } else { BALL });
    if behind && normal != DVec3::ZERO { Shape::Side(normal) } else { drop }
}

/// Direction of the smallest eigenvalue of a symmetric matrix of trace 1 without negative ones.
fn smallest_direction(m: DMat3) -> DVec3 {
    dominant_direction(DMat3::IDENTITY - m)
}

fn largest_eigenvalue(m: DMat3) -> f64 {
    let direction = dominant_direction(m);
    direction.dot(m * direction)
}

fn dominant_direction(mut m: DMat3) -> DVec3 {
    // Squares converge to the projection on the largest eigenvalue's space, so fast that equal ones do not matter.
    for _ in 0..12 {
        m = m * m;
        let trace = m.x_axis.x + m.y_axis.y + m.z_axis.z;
        m *= 1.0 / trace.max(f64::MIN_POSITIVE);
    }
    let columns = [m.x_axis, m.y_axis, m.z_axis];
    let longest = columns.into_iter().fold(DVec3::ZERO, |a, b| if b.length() > a.length() { b } else { a });
    longest.normalize_or_zero()
}

/// d of Eq. 33 for one surface particle; `displacement` leads from the point to it.
fn distance(shape: Shape, displacement: [f64; 3], squared: f64, spacing: f64) -> f64 {
    let to = DVec3::from_array(displacement);
    match shape {
        Shape::Side(normal) => to.dot(normal),
        Shape::Sheet(normal, rim) if rim == DVec3::ZERO => -to.dot(normal).abs(),
        Shape::Sheet(normal, rim) => to.dot(rim).min(-to.dot(normal).abs()),
        Shape::Drop(radius) => (radius - 0.5) * spacing - squared.sqrt(),
    }
}

/// Eq. 33 as printed; infinite where no surface particle is near.
fn nearest(grid: &NeighbourGrid, shapes: &[Shape], at: [f64; 3], reach: f64, spacing: f64) -> f64 {
    let mut found = (f64::INFINITY, f64::INFINITY);
    let visit = |surface: usize, displacement, squared| {
        if squared < found.0 {
            found = (squared, distance(shapes[surface], displacement, squared, spacing));
        }
    };
    let _ = grid.for_each_within(at, reach, visit);
    found.1
}

/// The distances that surface particles say, averaged over those near the point, and over more the farther they are: of one
/// alone, in a crowd or in spray, the normal may point anywhere. Infinite where none is within reach.
fn blended(grid: &NeighbourGrid, shapes: &[Shape], at: [f64; 3], reach: f64, spacing: f64) -> f64 {
    let mut nearest2 = f64::INFINITY;
    // The grid reaches as far as any radius below.
    let _ = grid.for_each_within(at, reach, |_, _, squared| nearest2 = squared.min(nearest2));
    if nearest2 == f64::INFINITY {
        return f64::INFINITY;
    }
    let nearest = nearest2.sqrt();
    let radius = (2.0 * nearest).min(nearest + BLEND * spacing).max(BLEND * spacing);
    let (mut weights, mut sum) = (0.0, 0.0);
    let visit = |surface: usize, displacement, squared: f64| {
        let weight = (1.0 - squared / (radius * radius)).powi(4);
        weights += weight;
        sum += weight * distance(shapes[surface], displacement, squared, spacing);
    };
    let _ = grid.for_each_within(at, radius, visit);
    sum / weights
}
