//! Flat cells against integer arithmetic.

#![allow(clippy::unwrap_used)]

use fieldstone_geometry::{Ball, CornerOrder, ElementKind, PROMISE};
use fieldstone_mesh::{CellList, Cells, Mesh, MeshError};
use fieldstone_testing::Random;

/// Corners are whole numbers up to this, so that `f64` holds them, and `i128` six times the volume.
const SIDE: f64 = (1u64 << 38) as f64;

type Corner = [i128; 3];

fn point(random: &mut Random, size: f64) -> Corner {
    random.point(-size, size).map(|x| x.round() as i128)
}

fn plus(a: Corner, b: Corner) -> Corner {
    [0, 1, 2].map(|k| a[k] + b[k])
}

fn determinant(a: Corner, b: Corner, c: Corner) -> i128 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// A cell of one kind spanned by three vectors from an origin.
fn cell(kind: ElementKind, origin: Corner, [a, b, c]: [Corner; 3]) -> Result<Mesh, MeshError> {
    let ends: &[&[Corner]] = match kind {
        ElementKind::Tetrahedron => &[&[], &[a], &[b], &[c]],
        ElementKind::Wedge => &[&[], &[a], &[b], &[c], &[a, c], &[b, c]],
        _ => &[&[], &[a], &[a, b], &[b], &[c], &[a, c], &[a, b, c], &[b, c]],
    };
    let corners: Vec<[f64; 3]> =
        ends.iter().map(|along| along.iter().fold(origin, |at, &v| plus(at, v)).map(|x| x as f64)).collect();
    let mut list = CellList::new();
    list.push(kind, CornerOrder::Cgns, &(0..corners.len() as u32).collect::<Vec<_>>())?;
    Mesh::from_cells(corners, list)
}

const KINDS: [(ElementKind, f64); 3] =
    [(ElementKind::Tetrahedron, 6.0), (ElementKind::Wedge, 2.0), (ElementKind::Hexahedron, 1.0)];

#[test]
fn flat_cells_have_their_volume_to_the_promise() {
    let (mut worst, mut compared) = (0.0f64, 0);
    for seed in 0..3000 {
        let random = &mut Random(seed);
        let (kind, parts) = KINDS[seed as usize % 3];
        // The third vector leaves the plane of the others by anything from their own size down to single units.
        let off = 2f64.powf(random.uniform(2.0, 36.0));
        let (origin, a) = (point(random, SIDE), point(random, SIDE / 8.0));
        let mut near = |v: Corner| plus(v, point(random, off));
        // A thin sheet, or a needle.
        let (b, c) = if seed % 2 == 0 {
            let b = plus([a[1], a[2], a[0]], [1, -1, 2]);
            (b, near(plus(a, b)))
        } else {
            (near([0; 3]), near(a))
        };
        let determinant = determinant(a, b, c);
        let exact = determinant.unsigned_abs() as f64 / parts;
        let Ok(mesh) = cell(kind, origin, [a, b, c]) else {
            assert!(exact < 1e-30 * SIDE.powi(3), "seed {seed}");
            continue;
        };
        assert!(mesh.inverted_cells().is_empty(), "seed {seed}");
        let mirrored = determinant < 0 && kind != ElementKind::Wedge;
        assert_eq!(mesh.inverted_elements(), usize::from(mirrored), "seed {seed}");
        compared += 1;
        // A ball around all of it has all of it.
        let mut found = Vec::new();
        let ball = Ball::new(origin.map(|x| x as f64), SIDE).unwrap();
        mesh.overlap_ball(&ball, &mut mesh.scratch(), &mut found);
        let volume = mesh.cell_volumes()[0];
        assert_eq!(found, [(0, volume)], "seed {seed}");
        let error = (volume / exact - 1.0).abs();
        assert!(error <= PROMISE, "seed {seed}, {kind}: {volume:e} of {exact:e}, off by {error:e}");
        worst = worst.max(error);
        let (low, high) = mesh.cell_bounds(0);
        assert!((0..3).all(|k| (low[k]..=high[k]).contains(&mesh.cell_centre(0)[k])), "seed {seed}");
    }
    println!("largest relative error {worst:.1e}");
    assert!(worst < 0.5 * PROMISE && compared > 2500, "{worst:e} of {compared}");
}

#[test]
fn cells_in_a_tilted_plane_are_refused() {
    for seed in 0..300 {
        let random = &mut Random(seed);
        let (kind, _) = KINDS[seed as usize % 3];
        let (origin, a, b) = (point(random, SIDE), point(random, SIDE / 8.0), point(random, SIDE / 8.0));
        let found = cell(kind, origin, [a, b, plus(a, b)]);
        assert!(matches!(found, Err(MeshError::NoVolume { cell: 0, .. })), "seed {seed}: {found:?}");
    }
}
