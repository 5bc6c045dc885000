//! Balls and meshes of whole jobs.

use fieldstone_geometry::{CornerOrder, ElementKind};
use fieldstone_mesh::{CellList, Mesh};
use fieldstone_particles::Particles;

use fieldstone_testing::Random;

/// A box of unit hexahedra, its inner points moved by up to `jitter` along each axis.
///
/// With any jitter every face inside is warped. The box's surface stays as it is.
///
/// ```
/// let mesh = fieldstone_bench::box_of_hexahedra([3, 4, 5], 0.2, 1);
/// assert_eq!(mesh.cell_count(), 60);
/// assert!((mesh.cell_volumes().iter().sum::<f64>() - 60.0).abs() < 1e-12);
/// ```
pub fn box_of_hexahedra(cells: [usize; 3], jitter: f64, seed: u64) -> Mesh {
    let [nx, ny, nz] = cells;
    let mut random = Random(seed);
    let mut points = Vec::with_capacity((nx + 1) * (ny + 1) * (nz + 1));
    for k in 0..=nz {
        for j in 0..=ny {
            for i in 0..=nx {
                let at = [i as f64, j as f64, k as f64];
                let inner = (1..nx).contains(&i) && (1..ny).contains(&j) && (1..nz).contains(&k);
                points.push(if inner && jitter > 0.0 { at.map(|x| x + random.uniform(-jitter, jitter)) } else { at });
            }
        }
    }
    let mut list = CellList::new();
    let point = |i: usize, j: usize, k: usize| (i + (nx + 1) * (j + (ny + 1) * k)) as u32;
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let corners = [
                    point(i, j, k),
                    point(i + 1, j, k),
                    point(i + 1, j + 1, k),
                    point(i, j + 1, k),
                    point(i, j, k + 1),
                    point(i + 1, j, k + 1),
                    point(i + 1, j + 1, k + 1),
                    point(i, j + 1, k + 1),
                ];
                list.push(ElementKind::Hexahedron, CornerOrder::Cgns, &corners).expect("eight corners");
            }
        }
    }
    Mesh::from_cells(points, list).expect("a jitter below half a cell")
}

/// `count` balls of radius `r`, uniform where they lie wholly in the box from 0 to `high`.
///
/// In random order, as a simulation's particles are once they have moved: neighbours in the list are
/// nowhere near each other in space.
pub fn random_balls(count: usize, r: f64, high: [f64; 3], seed: u64) -> Particles {
    let mut random = Random(seed);
    let positions = (0..count).map(|_| high.map(|high| random.uniform(r, high - r))).collect();
    Particles::new(positions).and_then(|p| p.with_uniform_radius(r)).expect("finite positions and a positive radius")
}
