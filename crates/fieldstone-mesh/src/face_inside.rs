//! A face's share of the overlap from the part of it inside the ball: the quick way, for most balls.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::surface::FaceSum;

/// How near the centre may be to an edge, and its foot to a corner, in units of the radius.
///
/// The angles at a point at distance δ lose 1/δ in accuracy. Nearer points, some 0.1 % of all, take the slow way.
const NEAR: f64 = 1.0 / 64.0;

/// Terms of the convex polygon `corners` with unit `normal` at `distance`, |d| < 1, for the unit ball around 0.
///
/// [`fieldstone_geometry::face_terms`] adds up the solid angle Ω of the face *outside* the ball, for which every face
/// of a cell is needed. Around a closed cell the whole faces make 4π with the centre inside and 0 without, so with
/// Ω′ the solid angle of what is *inside*,
///
/// $$ 3 V = 4\pi\,[0 \in \text{cell}] + \sum_f (d_f A_f - \Omega'_f), $$
///
/// and faces out of the ball's reach contribute nothing. With P the foot of the centre on the plane, w = 1 with P in
/// the polygon and 0 without, and the sums over the pieces of edges inside the ball,
///
/// $$ A = \tfrac12 \sum h\,(b-a) + \tfrac12 s^2 \bigl(2\pi w - \sum \Delta\varphi\bigr), \qquad
///    \operatorname{sgn}(d)\,\Omega' = \sum (\Delta\varphi - \Delta G) + (1 - |d|) \bigl(2\pi w - \sum \Delta\varphi\bigr), $$
///
/// in the notation of `face_terms`, ΔG with |d|. An edge outside the ball only has its side looked at, and a whole
/// disc is a cap.
///
/// Unlike there, the terms are not continuous: they jump where the centre passes through a face, all together and
/// by a whole turn. That is sound only while it is beyond doubt which face the centre passes, so `None` is returned
/// where it is near an edge.
///
/// The result holds −Ω′ in place of Ω.
pub(crate) fn face_inside(normal: DVec3, distance: f64, corners: &[DVec3]) -> Option<FaceSum> {
    let d = distance.abs();
    let side = if distance < 0.0 { -1.0 } else { 1.0 };
    let d2 = d * d;
    let s2 = (1.0 - d) * (1.0 + d);
    let (mut triangles, mut turn, mut angle) = (0.0, 0.0, 0.0);
    let (mut foot_inside, mut any_inside) = (true, false);
    let mut nearest2: f64 = 1.0;
    let mut a = *corners.last()?;
    for &b in corners {
        let along = b - a;
        let length2 = along.length_squared();
        // Never −0: it counts as inside, and the arc tangent would put it outside.
        let moment = a.dot(along.cross(normal)) + 0.0;
        foot_inside &= moment >= 0.0;
        // Without a root or a division for the edges that miss the disc.
        if moment * moment < s2 * length2 {
            let scale = 1.0 / length2.sqrt();
            let h = moment * scale;
            let (ta, tb) = (a.dot(along) * scale, b.dot(along) * scale);
            let h2 = h * h;
            let t = (s2 - h2).max(0.0).sqrt();
            let (low, high) = (ta.max(-t), tb.min(t));
            if low < high {
                let beyond = d2 + h2;
                let nearest = 0f64.clamp(low, high);
                let corner2 = h2 + ta.abs().min(tb.abs()).powi(2);
                nearest2 = nearest2.min(beyond + nearest * nearest).min(corner2);
                any_inside = true;
                let r_low = if ta > -t { (beyond + ta * ta).sqrt() } else { 1.0 };
                let r_high = if tb < t { (beyond + tb * tb).sqrt() } else { 1.0 };
                let product = low * high;
                let leverage = if product > 0.0 {
                    beyond * ((high - low) * (high + low)) / (high * r_low + low * r_high)
                } else {
                    high * r_low - low * r_high
                };
                let (zx, zy) = (h2 + product, h * (high - low));
                let (wx, wy) = (h2 * (r_low * r_high) + d2 * product, h * d * leverage);
                triangles += zy;
                turn += zy.atan2(zx);
                angle += (zy * wx - zx * wy).atan2(zx * wx + zy * wy);
            }
        }
        a = b;
    }
    if !any_inside {
        if !foot_inside {
            return Some(FaceSum::default());
        }
        let flat = (1.0 - d) * (1.0 - d);
        return Some(FaceSum {
            volume3: -side * PI * flat * (2.0 + d),
            solid_angle: -side * TAU * (1.0 - d),
            area: PI * s2,
            ..FaceSum::default()
        });
    }
    if nearest2 < NEAR * NEAR {
        return None;
    }
    let rest = if foot_inside { TAU } else { 0.0 } - turn;
    let area = (0.5 * (triangles + s2 * rest)).max(0.0);
    let solid_angle = -side * (angle + (1.0 - d) * rest);
    let nearness = 1.0 / nearest2.sqrt();
    Some(FaceSum { volume3: distance * area + solid_angle, solid_angle, area, nearness, ..FaceSum::default() })
}
