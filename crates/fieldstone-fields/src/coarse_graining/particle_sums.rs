//! What each particle brings to the sums: its own numbers, and those of its contacts.

use fieldstone_particles::{Contact, Partner};
use rayon::prelude::*;

use super::frame::Frame;
use super::layout::{Column, Group, Layout};
use super::options::QuantityKind;

/// `width` numbers for each carrier, where carriers are particles or their periodic images.
///
/// `carriers` lists particle and centre of each image; without it every particle is its own. `origin` is what positions
/// are measured from where only differences matter.
pub(super) fn particle_quantities(
    frame: &Frame<'_>,
    layout: &Layout,
    carriers: Option<&[(u32, [f64; 3])]>,
    origin: [f64; 3],
    factor: f64,
) -> Vec<f64> {
    let width = layout.width(Group::Particle);
    let count = carriers.map_or(frame.len(), <[_]>::len);
    let mut values = vec![0.0; count * width];
    let at = |column| layout.within(Group::Particle, column).map(|slot| slot.start);
    use Column::*;
    let slots = [
        Volume,
        Mass,
        Momentum,
        MomentumFlux,
        Size,
        KineticEnergy,
        KineticEnergyFlux,
        AngularMomentum,
        Spin,
        Inertia,
        MassPosition,
        MassPosition2,
        MassDisplacement,
        MassDisplacementPosition,
    ]
    .map(|column| (column, at(column)));
    let users: Vec<usize> = (0..frame.user.len()).filter_map(|q| at(User(q))).collect();
    values.par_chunks_mut(width.max(1)).enumerate().for_each(|(carrier, row)| {
        let (particle, centre) = match carriers {
            Some(list) => (list[carrier].0 as usize, list[carrier].1),
            None => (carrier, frame.positions[carrier]),
        };
        if !frame.selected[particle] {
            return;
        }
        let (m, v) = (frame.masses[particle], frame.velocity(particle));
        for (column, start) in slots {
            let Some(start) = start else { continue };
            let row = &mut row[start..];
            match column {
                Volume => row[0] = frame.volumes[particle],
                Mass => row[0] = m,
                Momentum => row[..3].copy_from_slice(&v.map(|v| m * v)),
                MomentumFlux => row[..6].copy_from_slice(&symmetric(v, v).map(|vv| m * vv)),
                Size => {
                    let mut power = 1.0;
                    for entry in &mut row[..6] {
                        *entry = power;
                        power *= frame.radii[particle];
                    }
                }
                KineticEnergy => row[0] = 0.5 * m * dot(v, v),
                KineticEnergyFlux => row[..3].copy_from_slice(&v.map(|u| 0.5 * m * dot(v, v) * u)),
                AngularMomentum => {
                    let orbital = cross(centre, v);
                    let spin = frame.spin(particle);
                    let inertia = frame.inertia(particle);
                    (0..3).for_each(|k| row[k] = m * orbital[k] + inertia * spin[k]);
                }
                Spin => row[..3].copy_from_slice(&frame.spin(particle).map(|w| frame.inertia(particle) * w)),
                Inertia => row[0] = frame.inertia(particle),
                MassDisplacement => row[..3].copy_from_slice(&frame.displacement(particle).map(|d| m * d)),
                _ => {
                    let r: [f64; 3] = std::array::from_fn(|k| centre[k] - origin[k]);
                    match column {
                        MassPosition => row[..3].copy_from_slice(&r.map(|x| m * x)),
                        MassPosition2 => row[..6].copy_from_slice(&symmetric(r, r).map(|rr| m * rr)),
                        _ => row[..9].copy_from_slice(&outer(frame.displacement(particle), r).map(|dr| m * dr)),
                    }
                }
            }
        }
        for (quantity, &start) in users.iter().enumerate() {
            let (kind, columns) = &frame.user[quantity];
            let by = match kind {
                QuantityKind::Sum => 1.0,
                QuantityKind::MassMean => m,
                QuantityKind::VolumeMean => frame.volumes[particle],
            };
            for (k, column) in columns.iter().enumerate() {
                row[start + k] = by * column.data[particle];
            }
        }
        let factor = factor * frame.parcel(particle);
        row.iter_mut().for_each(|x| *x *= factor);
    });
    values
}

/// Numbers per particle that its contacts add up to, before they are spread by the particle's weights.
///
/// `sign` is that of $\sum f_{ij} \otimes l_{ij}$. Each pair counts on both its sides, each with its own arm.
pub(super) fn contact_sums(
    frame: &Frame<'_>,
    layout: &Layout,
    sides: &[Contact],
    walls_in_contact_force: bool,
    sign: f64,
    factor: f64,
    mut add: impl FnMut(usize, usize, &[f64]),
) {
    use Column::*;
    let at = |column| layout.within(Group::Particle, column).map(|slot| slot.start);
    let [force, stress, boundary, count, fabric, couple, energy] =
        [ContactForce, Stress, BoundaryForce, ContactCount, Fabric, Couple, ContactEnergy].map(at);
    for contact in sides {
        let i = contact.particle as usize;
        let is_wall = matches!(contact.partner, Partner::Wall(_));
        let mut side = |particle: usize, f: [f64; 3], arm: [f64; 3]| {
            if let Some(start) = force
                && (walls_in_contact_force || !is_wall)
            {
                add(particle, start, &f.map(|f| factor * f));
            }
            if let Some(start) = stress {
                add(particle, start, &outer(f, arm).map(|s| sign * factor * s));
            }
            if let Some(start) = boundary
                && is_wall
            {
                add(particle, start, &f.map(|f| factor * f));
            }
            if let Some(start) = count {
                add(particle, start, &[factor]);
            }
            if let Some(start) = fabric {
                let n = unit(contact.branch);
                add(particle, start, &symmetric(n, n).map(|x| factor * frame.volumes[particle] * x));
            }
            if let Some(start) = couple {
                add(particle, start, &outer(cross(arm, f), arm).map(|x| sign * factor * x));
            }
            if let Some(start) = energy {
                // Energy flows the way it flows, whatever sign stresses have.
                let power = dot(f, frame.velocity(particle));
                add(particle, start, &arm.map(|l| -factor * power * l));
            }
        };
        side(i, contact.force, contact.arm);
        if let Partner::Particle(other) = contact.partner {
            side(other as usize, contact.force.map(|f| -f), contact.partner_arm());
        }
    }
}

/// `width` numbers for each branch.
pub(super) fn branch_quantities(
    frame: &Frame<'_>,
    layout: &Layout,
    sides: &[Contact],
    sign: f64,
    factor: f64,
) -> Vec<f64> {
    use Column::*;
    let width = layout.width(Group::Branch);
    let at = |column| layout.within(Group::Branch, column).map(|slot| slot.start);
    let [stress, fabric, couple, energy] = [Stress, Fabric, Couple, ContactEnergy].map(at);
    let mut values = vec![0.0; sides.len() * width];
    values.par_chunks_mut(width.max(1)).zip(sides).for_each(|(row, contact)| {
        let (f, branch) = (contact.force, contact.branch);
        let i = contact.particle as usize;
        let other = match contact.partner {
            Partner::Particle(other) => Some(other as usize),
            Partner::Wall(_) => None,
        };
        if let Some(start) = stress {
            row[start..start + 9].copy_from_slice(&outer(f, branch).map(|s| sign * s));
        }
        if let Some(start) = fabric {
            let n = unit(branch);
            let volume = frame.volumes[i] + other.map_or(0.0, |j| frame.volumes[j]);
            row[start..start + 6].copy_from_slice(&symmetric(n, n).map(|x| volume * x));
        }
        if let Some(start) = couple {
            let torque = match other {
                // (T_i − T_j)/2 with T_j = −l_j × f.
                Some(_) => {
                    let sum: [f64; 3] = std::array::from_fn(|k| contact.arm[k] + contact.partner_arm()[k]);
                    cross(sum, f).map(|t| 0.5 * t)
                }
                None => cross(contact.arm, f),
            };
            row[start..start + 9].copy_from_slice(&outer(torque, branch).map(|x| sign * x));
        }
        if let Some(start) = energy {
            let power = match other {
                Some(j) => 0.5 * (dot(f, frame.velocity(i)) + dot(f, frame.velocity(j))),
                None => dot(f, frame.velocity(i)),
            };
            row[start..start + 3].copy_from_slice(&branch.map(|b| -power * b));
        }
        row.iter_mut().for_each(|x| *x *= factor);
    });
    values
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a ⊗ b, row by row.
pub(super) fn outer(a: [f64; 3], b: [f64; 3]) -> [f64; 9] {
    std::array::from_fn(|k| a[k / 3] * b[k % 3])
}

/// xx, xy, xz, yy, yz, zz of a ⊗ b.
pub(super) fn symmetric(a: [f64; 3], b: [f64; 3]) -> [f64; 6] {
    [a[0] * b[0], a[0] * b[1], a[0] * b[2], a[1] * b[1], a[1] * b[2], a[2] * b[2]]
}

/// Direction of a vector; none for one of no length.
fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = dot(v, v).sqrt();
    if length > 0.0 { v.map(|x| x / length) } else { [0.0; 3] }
}
