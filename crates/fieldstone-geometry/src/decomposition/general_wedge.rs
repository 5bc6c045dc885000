//! The general spherical wedge: what two planes cut out of the ball (Algorithm 3, Fig. 6 and 7).
//!
//! # How the printed algorithm is read here
//!
//! Algorithm 3 gets the two planes as a point and a normal each, and forms each angle of Fig. 7 as
//! $\tfrac\pi2 \pm \mathrm{angle}(\vec n_i, \hat d)$, the sign from the position of the plane's point $\vec c_i$
//! (lines 13–14, 16–17, 20–21, 24–25). All these lines say one thing: $\alpha_i$ is the angle between $\hat d$ and the
//! half-plane of plane $i$ that bounds the wedge. Let $\vec o_i$ be the unit vector along that half-plane, at right
//! angles to the common line, and $s_i = \vec d\cdot\vec n_i$, $c_i = \vec d\cdot\vec o_i$; then
//! $|s_i| = |\vec d|\sin\alpha_i$ and $c_i = |\vec d|\cos\alpha_i$, which is all that Eq. 5 needs. The sign of $d_i$ in
//! lines 13–14 is the sign of $c_i$, so the points $\vec c_i$ are not needed, nor any angle. Each printed case was
//! checked against this and against numerical integration.
//!
//! # Corrections
//!
//! * Lines 8–11 (a plane through the centre): the printed fourth argument $s$ of `regularizedWedge` appears neither in
//!   Eq. 5 nor in the text. Where $s \ge 0$ the call is right. Where $s < 0$ the plane through the centre is bounded by
//!   the half-plane *towards and past* the centre, and the wedge is
//!   $\tfrac23\pi r^3 - V_{\triangleleft}(r, d, \pi - \alpha)$. A test holds both against numerical integration.
//! * Line 8 compares $|s_i|$ with ε itself, and the angle of line 9 comes from the normals. Here it comes from $s_i$ and $c_i$,
//!   so what has to be rounding noise is $\sin\alpha_i$: $|s_i|$ is compared with $\varepsilon\,|\vec d|$. Else a plane at any
//!   angle would count as one along $\vec d$ where the common line passes the centre at little more than ε.
//! * Lines 2–5 leave out $-\tfrac\pi2 (s_0 + s_1) r^2$, half a disc at each plane, which is added.
//! * Line 12 overwrites $\vec d$ by its direction; lines 13–14 then need the vector as it was.
//! * Line 22 subtracts from the whole ball what is right only if the two half-planes lie on the far side. With nearly
//!   antiparallel normals (a sliver's sharp edge) $s_0$ and $s_1$ are rounding noise, and their signs can ask for line
//!   18 or 22 where line 28 holds: the printed rule then returns the whole ball for a wedge of no volume. So lines 15
//!   and 19 also look at the $c_i$, which are not small when the $s_i$ are.

use std::f64::consts::PI;

use glam::DVec3;

use super::part::Part;
use super::regularized_wedge::{half_chord, unit_regularized_wedge};

/// Below this multiple of the radius a distance from the centre counts as zero, and so does the sine of an angle (ε of
/// Algorithm 3).
pub(crate) const EPSILON: f64 = 4.0 * f64::EPSILON;

/// Volume of a general spherical wedge.
///
/// The part of the ball of radius `r` around the origin with $\vec n_0\cdot(\vec x - \vec d) > 0$ and
/// $\vec n_1\cdot(\vec x - \vec d) > 0$, composed of regularized wedges
/// ([`regularized_wedge_volume`](super::regularized_wedge_volume)) as in Fig. 7:
///
/// $$ V = \begin{cases}
///   V_\triangleleft(\alpha_0) + V_\triangleleft(\alpha_1) & s_0, s_1 \ge 0 \\\\
///   \tfrac43\pi r^3 - V_\triangleleft(\alpha_0) - V_\triangleleft(\alpha_1) & s_0, s_1 < 0 \\\\
///   |V_\triangleleft(\alpha_0) - V_\triangleleft(\alpha_1)| & \text{otherwise}
/// \end{cases} \qquad s_i = \vec d\cdot\vec n_i $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | `r` | radius of the ball, > 0 | length |
/// | `d` | from the centre to the foot of the perpendicular on the planes' common line, at most `r` long | length |
/// | `n0`, `n1` | unit normals, not parallel; both point into the wedge | – |
///
/// `None` where the normals are parallel: such planes have no common line.
///
/// Error a few ε r³; nearly parallel normals amplify it by 1/sin of their angle.
///
/// Source: `strobl2016`, Algorithm 3; see this function's module for the corrections.
///
/// ```
/// use fieldstone_geometry::decomposition::general_wedge_volume;
/// // Two planes at right angles through the centre: a quarter of the ball.
/// let v = general_wedge_volume(1.0, [0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
/// assert!((v.unwrap() - std::f64::consts::FRAC_PI_3).abs() < 1e-15);
/// ```
pub fn general_wedge_volume(r: f64, d: [f64; 3], n0: [f64; 3], n1: [f64; 3]) -> Option<f64> {
    let (d, n0, n1) = (DVec3::from(d) / r, DVec3::from(n0), DVec3::from(n1));
    let line = n0.cross(n1).try_normalize()?;
    let (o0, o1) = (line.cross(n0), n1.cross(line));
    Some(r * r * r / 3.0 * WedgePlanes::new(d, [n0, n1], [o0, o1]).part())
}

/// Two planes as Algorithm 3 sees them from the centre of the unit ball.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WedgePlanes {
    /// Distances of the planes from the centre, positive where the wedge's half-space does not contain it.
    pub s: [f64; 2],
    /// Distance of the common line from the plane's foot point, along the half-plane that bounds the wedge.
    pub c: [f64; 2],
    /// The planes' normals, which point into the wedge.
    pub normals: [DVec3; 2],
}

impl WedgePlanes {
    /// From the separation vector, the normals, and the directions of the half-planes.
    #[inline(always)]
    pub fn new(d: DVec3, normals: [DVec3; 2], half_planes: [DVec3; 2]) -> Self {
        Self { s: [d.dot(normals[0]), d.dot(normals[1])], c: [d.dot(half_planes[0]), d.dot(half_planes[1])], normals }
    }

    /// Squared distance of the common line from the centre.
    #[inline(always)]
    pub fn distance_squared(&self) -> f64 {
        self.s[0] * self.s[0] + self.c[0] * self.c[0]
    }

    fn part(self) -> f64 {
        unit_general_wedge(&self, half_chord(self.distance_squared())).triple_volume
    }

    /// Angle of the wedge, $\pi - \mathrm{angle}(\vec n_0, \vec n_1)$; two-argument, so also good near 0 and π.
    fn angle(&self) -> f64 {
        let [n0, n1] = self.normals;
        n0.cross(n1).length().atan2(-n0.dot(n1))
    }
}

/// Algorithm 3 for the unit ball, `half_chord` being half the length of the common line inside it.
#[inline]
pub(crate) fn unit_general_wedge(planes: &WedgePlanes, half_chord: f64) -> Part {
    let ([s0, s1], [c0, c1]) = (planes.s, planes.c);
    let b = half_chord;
    let distance_squared = planes.distance_squared();
    // Lines 2–5: the common line passes through the centre, a slice like an orange's. So close to it the separation
    // vector may be rounding, without a direction, but its length still takes half a disc off at each plane.
    if distance_squared < EPSILON * EPSILON {
        let slice = Part { triple_volume: 2.0, area: 2.0 } * planes.angle();
        return slice - Part { triple_volume: 1.5 * PI, area: PI } * (s0 + s1);
    }
    // Lines 8–11: a plane through the centre, so that one half-plane lies along the separation vector. That is a matter
    // of the angle between the two, whatever the vector's length.
    let along = EPSILON * EPSILON * distance_squared;
    if s0 * s0 < along || s1 * s1 < along {
        let (through_centre, s, c) = if s0.abs() > s1.abs() { (c1, s0, c0) } else { (c0, s1, c1) };
        let other = unit_regularized_wedge(s.abs(), b, c);
        // Outwards exactly where s ≥ 0, but this sign is not rounding noise where both planes meet the centre.
        return if through_centre >= 0.0 { other } else { Part::BALL * 0.5 - other };
    }
    let w0 = unit_regularized_wedge(s0.abs(), b, c0);
    let w1 = unit_regularized_wedge(s1.abs(), b, c1);
    if s0 >= 0.0 && s1 >= 0.0 && (c0 >= 0.0 || c1 >= 0.0) {
        w0 + w1 // Fig. 7c
    } else if s0 < 0.0 && s1 < 0.0 && (c0 < 0.0 || c1 < 0.0) {
        Part::BALL - (w0 + w1) // Fig. 7b
    } else {
        (w0 - w1).abs() // Fig. 7a
    }
}
