//! The error bound of the `f64` path against the certified result, on random and adversarial pairs.
//!
//! The long run: `FIELDSTONE_PAIRS=6000000 cargo test --release -p fieldstone-geometry --test bounds encloses -- --nocapture`.

#![allow(clippy::unwrap_used)]

use fieldstone_geometry::{
    Ball, CornerOrder, ElementKind, Orientation, OverlapBatch, PROMISE, Polyhedron, Precision, certified_overlap,
    fast_overlap, fast_overlap_volume, overlap_in, overlap_volume,
};
use fieldstone_testing::{Random, pairs};

fn element(random: &mut Random) -> Option<Polyhedron> {
    let (kind, corners) = pairs::element(random);
    Polyhedron::element(ElementKind::STANDARD[kind], CornerOrder::Cgns, &corners, Orientation::Fix).ok()
}

fn ball(element: &Polyhedron, random: &mut Random) -> Option<Ball> {
    let corners: Vec<[f64; 3]> = element.corners().collect();
    let (centre, radius) = pairs::ball(&corners, element.bounds(), random);
    Ball::new(centre, radius).ok()
}

fn size(element: &Polyhedron) -> f64 {
    let (low, high) = element.bounds();
    (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Pairs tried by default; `FIELDSTONE_PAIRS` asks for more.
fn count() -> u64 {
    std::env::var("FIELDSTONE_PAIRS").ok().and_then(|n| n.parse().ok()).unwrap_or(20_000)
}

#[test]
fn the_bound_of_a_needle_face_without_area_inside_is_a_number() {
    // Found by the test below: flatness was infinite, and nothing times infinity no number.
    let random = &mut Random(425_593);
    let element = element(random).unwrap();
    let ball = ball(&element, random).unwrap();
    assert!(fast_overlap(&ball, &element).volume_error.is_finite());
}

#[test]
fn the_bound_holds_for_a_small_ball_whose_centre_is_near_a_corner() {
    // Found by the test below: angles at the corner magnify the rounding of distances, and of the normals of flat faces.
    for seed in [174_055, 8_595] {
        let random = &mut Random(seed);
        let element = element(random).unwrap();
        let ball = ball(&element, random).unwrap();
        let exact = overlap_in(&ball, &element, Precision::DoubleDouble).overlap.volume;
        let (volume, bound) = fast_overlap_volume(&ball, &element);
        assert!((volume - exact).abs() < 0.2 * bound && bound < PROMISE * ball.volume());
    }
}

#[test]
fn a_ball_in_an_element_without_thickness_has_next_to_no_volume_in_it() {
    // Found by the test below: five planes that are one to rounding, so that the centre seemed inside of all.
    let random = &mut Random(354_822);
    let element = element(random).unwrap();
    let ball = ball(&element, random).unwrap();
    assert!(fast_overlap_volume(&ball, &element).0 < 1e-25);
}

#[test]
fn an_element_that_is_nearly_flat_has_its_volume_to_the_last_digit() {
    // Found by the test below: of terms of size 1 a volume of 8e-22 is left, of which 106 bits know 13 digits.
    let corners = [
        [-0.9809315913985981, -0.4273507732269801, 0.9912916638830558],
        [-0.4809315913985981, -1.1773507732269801, 1.2412916638830558],
        [-1.480931591398598, 0.3226492267730199, 0.7412916638830558],
        [-0.9309547148703798, -0.5023681158308164, 1.0163032256189466],
        [-0.43095471487037984, -1.2523681158308164, 1.2663032256189466],
        [-1.4309547148703798, 0.24763188416918352, 0.7663032256189467],
    ];
    let element = Polyhedron::element(ElementKind::Wedge, CornerOrder::Cgns, &corners, Orientation::Fix).unwrap();
    let ball = Ball::new([-2.0138517699987495, 13.78354856765796, -21.901310298696067], 32.04317743697881).unwrap();
    let exact = overlap_in(&ball, &element, Precision::Wide).overlap.volume;
    let (volume, bound) = fast_overlap_volume(&ball, &element);
    assert!(exact > 7e-22 && exact < 8e-22 && exact == element.volume(), "{exact:e}");
    assert!((volume - exact).abs() <= bound && bound < 1e-15 * exact, "{volume:e} {exact:e}");
}

#[test]
fn three_corners_of_a_line_have_a_bound_in_every_precision() {
    // Found by the test below: a triangle of a warped face's fan without area had no number for its normal, after moving
    // and scaling it to the ball, which holds all of the element.
    let corners = [
        [-0.9623033383824016, -0.5408739865747383, -0.13567684278462888],
        [-0.7123033383824016, -0.7908739865747383, 0.3643231572153711],
        [-0.21230333838240156, -1.2908739865747383, 1.3643231572153711],
        [-0.46230333838240156, -1.0408739865747383, 0.8643231572153711],
        [-0.7123036701486982, -0.7908739865747383, 0.3643224936827779],
        [-0.46230367014869816, -1.0408739865747383, 0.8643224936827779],
        [0.037696329851301835, -1.5408739865747383, 1.8643224936827778],
        [-0.21230367014869816, -1.2908739865747383, 1.3643224936827778],
    ];
    let element = Polyhedron::element(ElementKind::Hexahedron, CornerOrder::Cgns, &corners, Orientation::Fix).unwrap();
    let ball = Ball::new([-0.47467019037062974, -1.112898348950287, 0.8188540477243219], 26378.251305867714).unwrap();
    assert!(element.corners().all(|corner| distance(corner, ball.centre()) < 10.0));
    for precision in [Precision::DoubleDouble, Precision::Wide] {
        let found = overlap_in(&ball, &element, precision);
        assert!((found.overlap.volume - element.volume()).abs() <= found.volume_error, "{found:?}");
        assert!(found.volume_error < 1e-15, "{found:?}");
    }
}

#[test]
fn the_bound_encloses_twice_the_error_of_f64_and_the_promise_is_kept() {
    let (mut compared, mut beyond, mut worst) = (0u64, [0u64; 3], [0.0f64; 4]);
    let mut ratios = Vec::new();
    for seed in 0..count() {
        let random = &mut Random(seed);
        let Some(element) = element(random) else { continue };
        let Some(ball) = ball(&element, random) else { continue };
        let fast = fast_overlap(&ball, &element);
        let certain = certified_overlap(&ball, &element);
        let smaller = ball.volume().min(element.volume());
        beyond[certain.precision as usize] += 1;
        // Of some corners on a lattice rounding alone makes an element; even 256 bits do not keep the promise for all.
        let promised = element.volume() > 1e-20 * size(&element).powi(3);
        assert!(!promised || certain.volume_error <= PROMISE * smaller, "seed {seed}: {certain:?}");
        let certain = match certain.precision {
            Precision::F64 => overlap_in(&ball, &element, Precision::DoubleDouble),
            _ => certain,
        };
        compared += 1;
        let error = (fast.overlap.volume - certain.overlap.volume).abs() - certain.volume_error;
        let area_error = (fast.overlap.sphere_area - certain.overlap.sphere_area).abs() - certain.sphere_area_error;
        worst[0] = worst[0].max(error / fast.volume_error);
        worst[1] = worst[1].max(area_error / fast.sphere_area_error.max(f64::MIN_POSITIVE));
        assert!(error <= fast.volume_error, "seed {seed}: error {error:e}, bound {:e}, {ball:?}", fast.volume_error);
        assert!(area_error <= fast.sphere_area_error.max(1e-300), "seed {seed}: area {area_error:e}");
        // The volume alone is summed over the edges inside the ball, where that can be done.
        let (volume, bound) = fast_overlap_volume(&ball, &element);
        let error = (volume - certain.overlap.volume).abs() - certain.volume_error;
        worst[2] = worst[2].max(error / bound.max(f64::MIN_POSITIVE));
        assert!(error <= bound, "seed {seed}: from inside {error:e}, bound {bound:e}, {ball:?}");
        let kept = (overlap_volume(&ball, &element) - certain.overlap.volume).abs() - certain.volume_error;
        assert!(!promised || kept <= PROMISE * smaller, "seed {seed}: {kept:e}");
        let faces = fast.overlap.face_areas.iter().zip(&certain.overlap.face_areas);
        for (k, (a, b)) in faces.enumerate() {
            let error = (a - b).abs() - certain.face_area_errors[k];
            worst[3] = worst[3].max(error / fast.face_area_errors[k].max(f64::MIN_POSITIVE));
            assert!(error <= fast.face_area_errors[k].max(1e-300), "seed {seed}: face {k} {error:e}");
        }
        if error > 0.0 {
            ratios.push(fast.volume_error / error);
        }
    }
    ratios.sort_by(f64::total_cmp);
    println!(
        "{compared} pairs ({beyond:?} in f64, 106 and 256 bits); largest error / bound {:.2e} (volume), \
         {:.2e} (sphere area), {:.2e} (volume from inside), {:.2e} (face areas); median bound / error {:.1e}",
        worst[0],
        worst[1],
        worst[2],
        worst[3],
        ratios[ratios.len() / 2]
    );
    assert!(compared > count() / 2);
    assert!(worst.iter().all(|&ratio| ratio <= 0.5), "{worst:?}");
}

#[test]
fn batches_give_the_bits_of_single_calls_and_count_their_slow_path() {
    let (mut balls, mut elements, mut pairs) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..5000 {
        let random = &mut Random(seed);
        let Some(element) = element(random) else { continue };
        let Some(ball) = ball(&element, random) else { continue };
        pairs.push((balls.len() as u32, elements.len() as u32));
        balls.push(ball);
        elements.push(element);
    }
    let mut batch = OverlapBatch::default();
    let mut volumes = vec![0.0; pairs.len()];
    batch.pairs(&balls, &elements, &pairs, &mut volumes);
    for (k, &volume) in volumes.iter().enumerate() {
        assert_eq!(volume, overlap_volume(&balls[k], &elements[k]), "{k}");
    }
    let (evaluated, beyond) = batch.path_counts();
    assert!(beyond > 0 && beyond < evaluated && evaluated <= pairs.len() as u64);

    // The same bits in other company.
    let mut alone = [0.0];
    for k in (0..pairs.len()).step_by(97) {
        batch.pairs(&balls, &elements, &pairs[k..=k], &mut alone);
        assert_eq!(alone[0], volumes[k]);
    }
    // Many balls fill registers; what they share them with changes nothing.
    let mut column = vec![0.0; balls.len()];
    for element in &elements[..40] {
        batch.balls_in_element(&balls, element, &mut column);
        for (ball, &volume) in balls.iter().zip(&column) {
            assert_eq!(volume, overlap_volume(ball, element), "{ball:?} {element:?}");
        }
    }
    let mut row = vec![0.0; 300];
    batch.ball_in_elements(&balls[7], &elements[..300], &mut row);
    assert_eq!(row[7], volumes[7]);
}
