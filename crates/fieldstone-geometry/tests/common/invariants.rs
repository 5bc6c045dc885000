//! What holds for every ball and every polyhedron: one checker for the property tests and the fuzzer.

use fieldstone_geometry::{Ball, Polyhedron, certified_overlap, flatness, overlap, overlap_volume};

use super::{Point, Random, Shape, cross, dot, sub};

/// By how much the worst case of each invariant used up what rounding may do; above 1 is a failure.
#[derive(Debug, Default, Clone)]
pub struct Report {
    pub worst: std::collections::BTreeMap<&'static str, f64>,
}

impl Report {
    pub fn note(&mut self, name: &'static str, error: f64, allowed: f64) -> Result<(), String> {
        if error == 0.0 {
            self.worst.entry(name).or_default();
            return Ok(());
        }
        let share = error / allowed;
        let worst = self.worst.entry(name).or_default();
        *worst = worst.max(share);
        // Written so that a NaN fails.
        if share <= 1.0 { Ok(()) } else { Err(format!("{name}: off by {error:e}, allowed {allowed:e}")) }
    }
}

/// Checks all invariants for one pair.
///
/// `random` chooses the cutting plane, the permutations and the directions.
pub fn check(shape: &Shape, centre: Point, r: f64, random: &mut Random, report: &mut Report) -> Result<(), String> {
    let ball = Ball::new(centre, r).map_err(|e| e.to_string())?;
    let polyhedron = shape.build();
    let certified = certified_overlap(&ball, &polyhedron);
    let whole = &certified.overlap;
    let tolerance = allowed(&ball, &polyhedron);
    let (low, high) = polyhedron.bounds();
    let size = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    let surface: f64 = polyhedron.face_areas().iter().sum();
    // Corners that the test computes are rounded, and faces bend by that much.
    let bent = 8.0 * f64::EPSILON * size * surface.min(ball.surface_area());

    // Ranges.
    let smaller = ball.volume().min(polyhedron.volume());
    if !(0.0..=smaller).contains(&whole.volume) {
        return Err(format!("volume {:e} is not in [0, {smaller:e}]", whole.volume));
    }
    if !(0.0..=ball.surface_area()).contains(&whole.sphere_area) {
        return Err(format!("sphere area {:e} is not in [0, 4πr²]", whole.sphere_area));
    }
    for (&area, &face) in whole.face_areas.iter().zip(polyhedron.face_areas()) {
        if !(0.0..=face.min(4.0 * r * r)).contains(&area) {
            return Err(format!("face area {area:e} is not in [0, {face:e}]"));
        }
    }
    if whole.gradient.iter().any(|x| !x.is_finite()) {
        return Err(format!("gradient {:?}", whole.gradient));
    }
    let alone = overlap_volume(&ball, &polyhedron);
    report.note("volume alone", (whole.volume - alone).abs(), tolerance + 1e-12 * smaller)?;

    // Additive: the parts on both sides of a plane.
    let through = [0, 1, 2].map(|k| random.uniform(low[k], high[k]));
    let n = random.direction();
    if let Some(parts) = shape.split(n, dot(n, through), 0.02 * size) {
        let parts = parts.map(|p| p.build());
        let (mut sum, mut area) = (0.0, 0.0);
        let (mut allowed_sum, mut allowed_area) = (tolerance + 2.0 * bent, certified.sphere_area_error);
        for part in &parts {
            let found = certified_overlap(&ball, part);
            sum += found.overlap.volume;
            area += found.overlap.sphere_area;
            allowed_sum += allowed(&ball, part);
            allowed_area += found.sphere_area_error;
        }
        report.note("additive", (sum - whole.volume).abs(), allowed_sum)?;
        // A sphere along a bent face gains or loses a strip as wide as the root of what the face is bent by.
        allowed_area += 1e-6 * surface.min(ball.surface_area());
        report.note("sphere area is additive", (area - whole.sphere_area).abs(), allowed_area)?;
    }

    // Monotone in r.
    for factor in [1.0 + 1e-12, 1.0 + 1e-6, 1.01, 1.5] {
        let larger = Ball::new(centre, r * factor).unwrap();
        let more = overlap(&larger, &polyhedron).volume;
        report.note("monotone", (whole.volume - more).max(0.0), tolerance + allowed(&larger, &polyhedron))?;
    }

    // Symmetric: corners relabelled, axes permuted and reversed; exact in the input.
    let (turned, moved) = relabelled(shape, centre, random);
    let (turned, moved) = (turned.build(), Ball::new(moved, r).unwrap());
    let same = overlap(&moved, &turned).volume;
    report.note("symmetric", (same - whole.volume).abs(), tolerance + allowed(&moved, &turned) + bent)?;

    // Scaled by a power of two: every operation is the same but for the exponent.
    let exponent = random.whole(-60, 60) as i32;
    let scale = 2f64.powi(exponent);
    let scaled = shape.map(|p| p.map(|x| x * scale)).build();
    let large = overlap(&Ball::new(centre.map(|x| x * scale), r * scale).unwrap(), &scaled);
    if large.volume != whole.volume * scale.powi(3) || large.sphere_area != whole.sphere_area * scale * scale {
        return Err(format!(
            "scaled by 2^{exponent}: volume {:e} for {:e}, sphere area {:e} for {:e}",
            large.volume,
            whole.volume * scale.powi(3),
            large.sphere_area,
            whole.sphere_area * scale * scale
        ));
    }

    // The divergence theorem ties volume, sphere area and face areas; the gradient is minus the sum of the areas'
    // normals.
    if !polyhedron.has_warped_faces() {
        let mut three_volumes = r * whole.sphere_area;
        let mut gradient = [0.0; 3];
        let mut rounding = 3.0 * tolerance + r * (certified.sphere_area_error + 1e-15 * whole.sphere_area);
        let mut rounding_gradient = 0.0;
        for (k, face) in shape.faces.iter().enumerate() {
            let ring: Vec<Point> = face.iter().map(|&k| shape.corners[k]).collect();
            let (area, error) = (whole.face_areas[k], certified.face_area_errors[k]);
            let n = normal(shape, face);
            let to = sub(ring[0], centre);
            three_volumes += dot(n, to) * area;
            for k in 0..3 {
                gradient[k] -= n[k] * area;
            }
            // A flat face's normal is uncertain by its extent over its height.
            let tilt = 32.0 * f64::EPSILON * flatness(&ring) * area;
            rounding += tilt * (dot(to, to).sqrt() + size) + error * dot(n, to).abs();
            rounding_gradient += tilt + error;
        }
        report.note("divergence theorem", (three_volumes - 3.0 * whole.volume).abs(), rounding)?;
        let off = (0..3).map(|k| (gradient[k] - whole.gradient[k]).abs()).fold(0.0, f64::max);
        report.note("gradient is the sum of areas", off, rounding_gradient)?;
    }

    // Derivatives: over a short way the volume changes by the mean of the derivative, which lies among its values.
    let h = 1e-4 * r.min(size);
    let direction = random.direction();
    let (mut areas, mut slopes) = (Vec::new(), Vec::new());
    let mut ends = [0.0; 4];
    let mut rounding = [0.0; 2];
    for i in 0..=8u8 {
        let t = (f64::from(i) - 4.0) / 4.0;
        let grown = Ball::new(centre, r + t * h).unwrap();
        let shifted = Ball::new([0, 1, 2].map(|k| centre[k] + t * h * direction[k]), r).unwrap();
        let (a, b) = (overlap(&grown, &polyhedron), overlap(&shifted, &polyhedron));
        areas.push(a.sphere_area);
        slopes.push(dot(b.gradient, direction));
        if i % 8 == 0 {
            let end = usize::from(i / 8);
            (ends[end], ends[2 + end]) = (a.volume, b.volume);
            rounding[0] += allowed(&grown, &polyhedron);
            rounding[1] += allowed(&shifted, &polyhedron);
        }
    }
    for (name, values, step, allowed) in [
        ("dV/dr is the sphere area", &areas, ends[1] - ends[0], rounding[0]),
        ("dV/dc is the gradient", &slopes, ends[3] - ends[2], rounding[1]),
    ] {
        let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
        let mean = step / (2.0 * h);
        // Between samples a square root may peak; and the centre's step is rounded where it is far from the origin.
        let far = centre.iter().fold(r, |m, x| m.max(x.abs()));
        let allowed = 0.5 * (high - low)
            + allowed / h
            + 2.0 * f64::EPSILON * far / h * low.abs().max(high.abs())
            + 1e-7 * surface.min(ball.surface_area());
        report.note(name, (low - mean).max(mean - high).max(0.0), allowed)?;
    }
    Ok(())
}

/// What the volume may be off by: the bound that comes with it, and the rounding of the result itself.
pub fn allowed(ball: &Ball, polyhedron: &Polyhedron) -> f64 {
    certified_overlap(ball, polyhedron).volume_error + f64::EPSILON * ball.volume().min(polyhedron.volume())
}

/// Unit outward normal of a planar face.
pub fn normal(shape: &Shape, face: &[usize]) -> Point {
    let apex = shape.corners[face[0]];
    let mut area = [0.0; 3];
    for pair in face[1..].windows(2) {
        let n = cross(sub(shape.corners[pair[0]], apex), sub(shape.corners[pair[1]], apex));
        for k in 0..3 {
            area[k] += n[k];
        }
    }
    let length = dot(area, area).sqrt();
    area.map(|x| x / length)
}

/// The same pair with corners renumbered, faces reordered and started elsewhere, and the axes permuted and reversed.
pub fn relabelled(shape: &Shape, centre: Point, random: &mut Random) -> (Shape, Point) {
    let mut axes = [0, 1, 2];
    let mut odd = false;
    for k in (1..3).rev() {
        let other = random.below(k + 1);
        axes.swap(k, other);
        odd ^= other != k;
    }
    let signs = [0; 3].map(|_| if random.below(2) == 0 { 1.0 } else { -1.0 });
    let mirrored = odd ^ (signs.iter().product::<f64>() < 0.0);
    let map = |p: Point| [0, 1, 2].map(|k| signs[k] * p[axes[k]]);

    let count = shape.corners.len();
    let mut new: Vec<usize> = (0..count).collect();
    for k in (1..count).rev() {
        new.swap(k, random.below(k + 1));
    }
    let mut corners = vec![[0.0; 3]; count];
    for (k, &p) in shape.corners.iter().enumerate() {
        corners[new[k]] = map(p);
    }
    let mut faces: Vec<Vec<usize>> = shape
        .faces
        .iter()
        .map(|face| {
            let mut ring: Vec<usize> = face.iter().map(|&k| new[k]).collect();
            // A mirror image is wound the other way round.
            if mirrored {
                ring.reverse();
            }
            let start = random.below(ring.len());
            ring.rotate_left(start);
            ring
        })
        .collect();
    for k in (1..faces.len()).rev() {
        faces.swap(k, random.below(k + 1));
    }
    (Shape { corners, faces }, map(centre))
}
