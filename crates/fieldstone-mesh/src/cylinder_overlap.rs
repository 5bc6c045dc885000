//! Ball in cylinder sector: closed-form cross-sections, integrated along the axis.

use std::f64::consts::{PI, TAU};

/// Part of a cylinder of radius `radius` around the axis, between two angles, measured from the direction in which
/// the ball's centre lies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sector {
    pub radius: f64,
    /// From −2π to 2π, rising by at most 2π.
    pub angles: [f64; 2],
}

/// Area of a disc of radius `rho`, whose centre is `d` from the axis, in the sector.
///
/// $$ A = \int \tfrac12 (s_{out}^2 - s_{in}^2) \, d\alpha, \qquad
///    s_\pm = d\cos\alpha \pm \sqrt{\rho^2 - d^2 \sin^2\alpha}, $$
///
/// with both ends cut off at 0 and at the sector's radius: between the angles where the circles meet and where rays
/// touch the disc the integrand is one of a few forms, each with an elementary integral.
pub(crate) fn disc_in_sector(d: f64, rho: f64, sector: Sector) -> f64 {
    let Sector { radius, angles } = sector;
    if rho <= 0.0 || radius <= 0.0 || d - rho >= radius {
        return 0.0;
    }
    let whole = angles[1] - angles[0] >= TAU * (1.0 - 1e-15);
    if whole && d + rho <= radius {
        return PI * rho * rho;
    }
    // Angles at which the integrand changes its form, all symmetric about 0.
    let tangent = if d >= rho { (rho / d).asin() } else { PI };
    // By the half angle, which keeps its digits where the disc is small and far away.
    let meet = {
        let half2 = (rho - (d - radius)) * (rho + (d - radius)) / (4.0 * d * radius);
        (half2 > 0.0 && half2 < 1.0).then(|| 2.0 * half2.sqrt().asin())
    };
    let mut marks = [0.0; 14];
    let mut count = 0;
    let (mut low, mut high) = (angles[0], angles[1]);
    if whole {
        (low, high) = (-PI, PI);
    }
    let mut mark = |x: f64| {
        if x > low && x < high {
            marks[count] = x;
            count += 1;
        }
    };
    for turn in [-TAU, 0.0, TAU] {
        for angle in [Some(tangent), meet].into_iter().flatten() {
            mark(turn + angle);
            mark(turn - angle);
        }
    }
    let marks = &mut marks[..count];
    marks.sort_by(f64::total_cmp);
    // ∫ 2 d cos α √(ρ² − d² sin² α): the chord of the ray in the disc, times the mean of its ends.
    let chords = |alpha: f64| {
        let u = d * alpha.sin();
        let root = ((rho - u) * (rho + u)).max(0.0).sqrt();
        // The angle from the root itself: where a ray touches the disc, their errors of √ε cancel.
        u * root + rho * rho * u.atan2(root)
    };
    // ½ ∫ s₊², of use with the axis inside the disc.
    let far_ends = |alpha: f64| 0.5 * (rho * rho * alpha + 0.5 * d * d * (2.0 * alpha).sin() + chords(alpha));
    // ½ ∫ R² − s₋², in terms that are as small as the disc.
    let near_ends = |alpha: f64| {
        let gap = (radius - d) * (radius + d) - rho * rho;
        0.5 * (gap * alpha + d * d * beyond_sine(alpha) + chords(alpha))
    };
    let mut area = 0.0;
    let mut a = low;
    for b in marks.iter().copied().chain([high]) {
        let middle = 0.5 * (a + b);
        let (along, sine) = (d * middle.cos(), d * middle.sin());
        let chord2 = (rho - sine) * (rho + sine);
        if b > a && chord2 > 0.0 {
            let (far, near) = (along + chord2.sqrt(), along - chord2.sqrt());
            area += match (near > 0.0, far < radius) {
                _ if far <= 0.0 || near >= radius => 0.0,
                (true, true) => chords(b) - chords(a),
                (true, false) => near_ends(b) - near_ends(a),
                (false, true) => far_ends(b) - far_ends(a),
                (false, false) => 0.5 * radius * radius * (b - a),
            };
        }
        a = b;
    }
    area.clamp(0.0, PI * rho * rho)
}

/// $\alpha - \sin\alpha \cos\alpha$, by its series where that cancels.
fn beyond_sine(alpha: f64) -> f64 {
    let x = 2.0 * alpha;
    if x.abs() > 0.5 {
        return 0.5 * (x - x.sin());
    }
    let x2 = x * x;
    // x³/6 − x⁵/120 + …, the next term below 1e-17 of the first.
    let series = 1.0
        - x2 / 20.0
            * (1.0 - x2 / 42.0 * (1.0 - x2 / 72.0 * (1.0 - x2 / 110.0 * (1.0 - x2 / 156.0 * (1.0 - x2 / 210.0)))));
    x * x2 / 12.0 * series
}

/// Difference of two halves and the whole, in units of r³, at which they are taken: a tenth of the error that is claimed, since
/// where heights crowd together halves may agree by chance, to 1e-13 with an error ten times as large.
const AGREEMENT: f64 = 1e-14;

/// Halvings at most. Each leaves an error of a third or less where a square root begins; more of them cost time without end where
/// the section's own rounding is above what is allowed.
const HALVINGS: u32 = 8;

/// Volume of the ball of radius `r`, whose centre is `d` from the axis, in the sector between the heights `z`,
/// measured along the axis from the centre.
///
/// Cross-sections are in closed form; along the axis, $z = r \sin t$ and Gauss–Legendre quadrature between the heights
/// at which the cross-section changes its form, halved until both halves agree with the whole to [`AGREEMENT`], at most
/// [`HALVINGS`] times. At those heights the area has half-integer powers, which $t = a + (b - a)(3x^2 - 2x^3)$ makes smooth.
///
/// Accuracy: 1e-13 r³, whatever the volume.
pub(crate) fn ball_in_sector(d: f64, r: f64, sector: Sector, z: [f64; 2]) -> f64 {
    let (low, high) = (z[0].max(-r), z[1].min(r));
    if low >= high || d - r >= sector.radius {
        return 0.0;
    }
    let (low, high) = ((low / r).clamp(-1.0, 1.0).asin(), (high / r).clamp(-1.0, 1.0).asin());
    let radius = sector.radius;
    let mut marks = vec![low, high];
    let mut mark = |rho: f64| {
        if rho > 0.0 && rho < r {
            let t = (rho / r).acos();
            marks.extend([t, -t].into_iter().filter(|t| *t > low && *t < high));
        }
    };
    mark((d - radius).abs());
    mark(d + radius);
    mark(d);
    for angle in sector.angles {
        let (along, across) = (d * angle.cos(), d * angle.sin());
        mark((along - radius).hypot(across));
        if along > 0.0 {
            mark(across.abs());
        }
    }
    marks.sort_by(f64::total_cmp);
    let slice = |t: f64| {
        let cosine = t.cos();
        disc_in_sector(d, r * cosine, sector) * r * cosine
    };
    let allowed = AGREEMENT * r * r * r;
    marks.windows(2).filter(|w| w[1] > w[0]).map(|w| adaptive(&slice, w[0], w[1], allowed)).sum()
}

/// Abscissae and weights of Gauss–Legendre quadrature with 16 points on −1…1, the positive half.
const GAUSS: [[f64; 2]; 8] = [
    [0.095_012_509_837_637_44, 0.189_450_610_455_068_5],
    [0.281_603_550_779_258_9, 0.182_603_415_044_923_6],
    [0.458_016_777_657_227_4, 0.169_156_519_395_002_54],
    [0.617_876_244_402_643_7, 0.149_595_988_816_576_73],
    [0.755_404_408_355_003, 0.124_628_971_255_533_87],
    [0.865_631_202_387_831_7, 0.095_158_511_682_492_78],
    [0.944_575_023_073_232_6, 0.062_253_523_938_647_89],
    [0.989_400_934_991_649_9, 0.027_152_459_411_754_094],
];

fn gauss(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let (mid, half) = (0.5 * (a + b), 0.5 * (b - a));
    half * GAUSS.iter().map(|[x, w]| w * (f(mid + half * x) + f(mid - half * x))).sum::<f64>()
}

fn adaptive(f: &impl Fn(f64) -> f64, a: f64, b: f64, allowed: f64) -> f64 {
    let smooth = |x: f64| {
        let t = a + (b - a) * x * x * (3.0 - 2.0 * x);
        f(t) * (b - a) * 6.0 * x * (1.0 - x)
    };
    halve(&smooth, 0.0, 1.0, gauss(&smooth, 0.0, 1.0), allowed, 0)
}

fn halve(f: &impl Fn(f64) -> f64, a: f64, b: f64, whole: f64, allowed: f64, depth: u32) -> f64 {
    let mid = 0.5 * (a + b);
    let (left, right) = (gauss(f, a, mid), gauss(f, mid, b));
    if (left + right - whole).abs() <= allowed || depth >= HALVINGS {
        return left + right;
    }
    // Half to each: the errors of all pieces add up.
    halve(f, a, mid, left, 0.5 * allowed, depth + 1) + halve(f, mid, b, right, 0.5 * allowed, depth + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn full(radius: f64) -> Sector {
        Sector { radius, angles: [-PI, PI] }
    }

    #[test]
    fn lenses_half_discs_and_wedges_have_their_areas() {
        // Two unit discs one apart: 2π/3 − √3/2.
        let lens = 2.0 * PI / 3.0 - 3.0f64.sqrt() / 2.0;
        assert!((disc_in_sector(1.0, 1.0, full(1.0)) - lens).abs() < 2e-15);
        assert!((disc_in_sector(0.0, 1.0, full(0.5)) - 0.25 * PI).abs() < 1e-15);
        assert!((disc_in_sector(3.0, 1.0, full(9.0)) - PI).abs() < 1e-15);
        // Half of a disc on its own symmetry line, and a quarter about the axis.
        assert!((disc_in_sector(3.0, 1.0, Sector { radius: 9.0, angles: [0.0, PI] }) - 0.5 * PI).abs() < 1e-14);
        assert!(
            (disc_in_sector(0.0, 1.0, Sector { radius: 9.0, angles: [0.3, 0.3 + 0.5 * PI] }) - 0.25 * PI).abs() < 1e-15
        );
        // An axis inside the disc: the sectors of a fan add up.
        for d in [0.2, 0.9, 1.4] {
            let sum: f64 = (0..5)
                .map(|k| f64::from(k) * TAU / 5.0 - 1.0 - PI)
                .map(|a| disc_in_sector(d, 1.0, Sector { radius: 1.2, angles: [a, a + TAU / 5.0] }))
                .sum();
            assert!((sum - disc_in_sector(d, 1.0, full(1.2))).abs() < 4e-15, "{d}");
        }
    }

    #[test]
    fn a_ball_drilled_through_its_centre_loses_the_napkin_ring() {
        // Outside a cylinder of radius a through the centre: 4/3 π (r² − a²)^{3/2}.
        for (r, a) in [(1.0, 0.5), (2.0, 1.99), (1.0, 0.01)] {
            let inside = ball_in_sector(0.0, r, full(a), [-9.0, 9.0]);
            let ring = 4.0 / 3.0 * PI * ((r - a) * (r + a) * ((r - a) * (r + a)).sqrt());
            let ball = 4.0 / 3.0 * PI * r * r * r;
            assert!((inside + ring - ball).abs() < 1e-13 * ball, "{r} {a}: {:e}", inside + ring - ball);
        }
    }

    #[test]
    fn halves_that_agree_by_chance_do_not_end_the_integration_too_soon() {
        // A cylinder 1.3e-6 wider than the distance of its axis: both heights at which the section changes its form are within
        // 3e-6 of the pole. And a ball that touches the cylinder from inside. Truth: mpmath, 30 digits, integrated over the
        // plane across the axis.
        let found = |d, radius, angles| ball_in_sector(d, 1.0, Sector { radius, angles }, [-9.0, 9.0]);
        let near = found(1.0, 1.0000012631082629, [0.04540603065843066, 0.10823788373022653]);
        assert!((near - 0.056668732848370955).abs() < 1e-13, "{:e}", near - 0.056668732848370955);
        let touching = found(0.16088463448554835, 1.1608846344855484, [0.3, 1.1975979010256552]);
        assert!((touching - 0.7587794250172177).abs() < 1e-13, "{:e}", touching - 0.7587794250172177);
    }

    #[test]
    fn viviani_s_solid_has_its_volume() {
        // The unit ball and the cylinder of radius 1/2 through its centre's rim: (2π/3 − 8/9) over both halves.
        let volume = ball_in_sector(0.5, 1.0, full(0.5), [-9.0, 9.0]);
        assert!((volume - (2.0 * PI / 3.0 - 8.0 / 9.0)).abs() < 1e-13, "{:e}", volume - (2.0 * PI / 3.0 - 8.0 / 9.0));
    }
}
