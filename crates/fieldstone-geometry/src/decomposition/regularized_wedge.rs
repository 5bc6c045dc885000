//! The regularized spherical wedge: one of its two planes contains the ball's centre (Sec. 4.3, Eq. 3–5).

use super::part::Part;

/// Volume of a regularized spherical wedge.
///
/// $$ V = \tfrac13 a b c + a\left(\tfrac13 a^2 - r^2\right)\arctan\tfrac bc
///      + \tfrac23 r^3 \arctan\frac{b \sin\alpha}{r\cos\alpha},
///    \qquad a = d\sin\alpha,\; b = \sqrt{r^2 - d^2},\; c = d\cos\alpha $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | `r` | radius of the ball, > 0 | length |
/// | `d` | distance of the planes' common line from the centre, 0 ≤ `d` ≤ `r` | length |
/// | `alpha` | angle in \[0, π\] from the half-plane that points away from the centre to the other one | rad |
///
/// So `alpha` = π/2 is half a cap and `alpha` = π half the ball. Beyond π/2 the value is the cap with its plane at
/// distance `a` less the wedge of π − `alpha`, as the paper has it. (With two-argument arc tangents Eq. 5 itself
/// holds up to π, where `c` < 0; the paper's form loses less near the end of the range.)
///
/// Error a few ε r³. For `d > r` the line misses the ball; `b` is then taken as 0.
///
/// Source: `strobl2016`, Eq. 5 and the sentence after it.
///
/// ```
/// use fieldstone_geometry::{cap_volume, decomposition::regularized_wedge_volume};
/// let half_cap = regularized_wedge_volume(2.0, 0.5, std::f64::consts::FRAC_PI_2);
/// assert!((half_cap - 0.5 * cap_volume(2.0, 0.5)).abs() < 1e-14);
/// ```
pub fn regularized_wedge_volume(r: f64, d: f64, alpha: f64) -> f64 {
    let d = d / r;
    let (sin, cos) = alpha.sin_cos();
    // At d = 0 Eq. 5 leaves atan2(sin α, cos α), which the scaled form below would lose: it has d in both arguments.
    let triple_volume =
        if d == 0.0 { 2.0 * alpha } else { unit_regularized_wedge(d * sin, half_chord(d * d), d * cos).triple_volume };
    triple_volume * (r * r * r) / 3.0
}

/// Half the length of a line's chord in the unit ball, from the squared distance of the line.
///
/// Rounding can put a line through a point of the sphere just outside the ball: its chord is then a point.
#[inline(always)]
pub(crate) fn half_chord(distance_squared: f64) -> f64 {
    (1.0 - distance_squared).max(0.0).sqrt()
}

/// Eq. 5 for the unit ball, from the lengths it is made of instead of the angle.
///
/// `a` = d sin α is the distance of the oblique plane from the centre and `c` = d cos α the part of the separation
/// vector within that plane: the caller has both as scalar products, so that neither the angle nor its sine and
/// cosine are ever formed. The last arc tangent is that of $b\sin\alpha / \cos\alpha = ab/c$.
///
/// The sphere area is ∂V/∂r, $2 r \left(r \arctan\frac{ab}{rc} - a \arctan\frac bc\right)$.
#[inline]
pub(crate) fn unit_regularized_wedge(a: f64, b: f64, c: f64) -> Part {
    let a = a.min(1.0);
    if c < 0.0 { Part::cap(a) - acute(a, b, -c) } else { acute(a, b, c) }
}

#[inline(always)]
fn acute(a: f64, b: f64, c: f64) -> Part {
    let in_plane = b.atan2(c);
    let on_sphere = (a * b).atan2(c);
    Part {
        triple_volume: a * b * c + a * (a * a - 3.0) * in_plane + 2.0 * on_sphere,
        area: 2.0 * (on_sphere - a * in_plane),
    }
}
