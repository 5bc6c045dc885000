//! Time per partially overlapping pair of the decomposition method, after the protocol of `strobl2016`, Sec. 5.2.
//!
//! A ball at a random place in the central cell of a mesh of unit cubes (or their splits into wedges or tetrahedra);
//! only pairs with a partial overlap are timed.

use std::time::Instant;

use fieldstone_geometry::Ball;
use fieldstone_geometry::decomposition::{
    DecompositionElement, HexahedronCorners, hexahedron_to_2_wedges, hexahedron_to_5_tetrahedra, overlap_volume,
};
use fieldstone_testing::Random;

fn mesh(kind: &str, reach: i32) -> Result<Vec<DecompositionElement>, Box<dyn std::error::Error>> {
    let mut elements = Vec::new();
    for k in -reach..=reach {
        for j in -reach..=reach {
            for i in -reach..=reach {
                let [x, y, z] = [i, j, k].map(|n| f64::from(n) - 0.5);
                let (u, v, w) = (x + 1.0, y + 1.0, z + 1.0);
                let cell: HexahedronCorners =
                    [[x, y, z], [u, y, z], [u, v, z], [x, v, z], [x, y, w], [u, y, w], [u, v, w], [x, v, w]];
                match kind {
                    "hex" => elements.push(DecompositionElement::hexahedron(cell)?),
                    "wedge" => {
                        for part in hexahedron_to_2_wedges(&cell) {
                            elements.push(DecompositionElement::wedge(part)?);
                        }
                    }
                    _ => {
                        for part in hexahedron_to_5_tetrahedra(&cell) {
                            elements.push(DecompositionElement::tetrahedron(part)?);
                        }
                    }
                }
            }
        }
    }
    Ok(elements)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{:<8}{:>6}{:>10}{:>12}{:>24}", "mesh", "r", "pairs", "ns/pair", "sum of volumes");
    for kind in ["hex", "wedge", "tet5"] {
        for radius in [0.1, 0.3, 0.6, 1.0] {
            let elements = mesh(kind, if radius > 0.9 { 2 } else { 1 })?;
            // SplitMix64: any other program can draw the same balls.
            let mut random = Random(42);
            let mut pairs = Vec::new();
            while pairs.len() < 20_000 {
                let centre = random.point(-0.5, 0.5);
                let ball = Ball::new(centre, radius)?;
                for (index, element) in elements.iter().enumerate() {
                    let volume = overlap_volume(&ball, element);
                    let most = ball.volume().min(element.volume());
                    if volume > 1e-9 * most && volume < (1.0 - 1e-9) * most {
                        pairs.push((ball, index));
                    }
                }
            }
            // The fastest of many passes: what other programs take from the processor only ever adds.
            let mut best = f64::INFINITY;
            let mut sum = 0.0;
            for _ in 0..15 {
                let start = Instant::now();
                sum = pairs.iter().map(|(ball, index)| overlap_volume(ball, &elements[*index])).sum();
                best = best.min(start.elapsed().as_nanos() as f64);
            }
            let each = best / pairs.len() as f64;
            println!("{kind:<8}{radius:>6}{:>10}{:>12.1}{sum:>24.12}", pairs.len(), each);
        }
    }
    Ok(())
}
