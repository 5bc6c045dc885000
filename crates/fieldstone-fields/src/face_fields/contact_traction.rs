//! The contact forces that cross each face.

use fieldstone_mesh::Faces;
use fieldstone_particles::{Contacts, Domain, Particles, Partner};
use rayon::prelude::*;

use crate::FieldsError;
use crate::checks::check_partners;
use crate::periodic::{Periods, longest_branch};

/// Contacts handled by one task.
const BLOCK: usize = 1024;

/// Faces or cells, and a force for each.
type Forces = Vec<(u32, [f64; 3])>;

/// Contact forces across faces, and how well they close the momentum balance of each cell.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactTraction {
    /// For each face the momentum that contacts carry through it along its normal, per time: a force. Over the face's
    /// area it is the traction, compression positive.
    pub forces: Vec<[f64; 3]>,
    /// For each cell $\sum F_i - \sum f_{wall} + \sum_{f} \pm T_f$: rounding, where all centres are found in the cells
    /// that their branches end in.
    pub residuals: Vec<[f64; 3]>,
    /// Largest component of a residual over the largest component of a contact force.
    pub balance_residual: f64,
}

/// The contact forces that cross each face of the cells.
///
/// $$ T_f = \sum_{\text{branches through } f} \pm f, \qquad
///    \sum_{i \in c} F_i = \sum_{\text{wall contacts in } c} f - \sum_{f \in \partial c} \pm T_f $$
///
/// | symbol | meaning | shape, unit |
/// |---|---|---|
/// | T_f | sum over branches that pass the face, + from back to front | 3 per face, force |
/// | F_i | contact forces on particle i, whose centre is in the cell | 3, force |
/// | ± in the balance | + where the face's normal points out of the cell | |
///
/// The force on a particle comes along the branch from its partner's centre, or along the arm from the wall's contact
/// point, and is handed on unchanged by every cell on the way. So the balance is exact for each cell, of any size: the
/// face form of $\partial_t j = -\nabla\cdot\sigma + \mathrm{IFD}$ for a single snapshot. Where a wall's contact point
/// lies outside all cells, its force comes in through the boundary's faces.
///
/// With a `domain`, images of contacts and centres are counted along its periodic directions; what lies exactly on a
/// periodic face of the cells lies above it, and counts once.
///
/// Cost: linear in contacts and faces passed. The same bits for any number of threads.
///
/// # Errors
/// A contact of a particle that there is not; a periodic box of which more than 10⁵ copies reach the cells.
///
/// Source: derived here; the force across a surface is what Cauchy defined stress by.
///
/// ```
/// use fieldstone_fields::contact_traction;
/// use fieldstone_mesh::Grid;
/// use fieldstone_particles::{Contact, Contacts, Particles, Partner};
/// // Two balls pushed apart by a force of 2, across the face between two cells.
/// let two = Particles::new(vec![[0.5; 3], [1.5, 0.5, 0.5]])?;
/// let mut contacts = Contacts::new();
/// let (arm, branch) = ([0.5, 0.0, 0.0], [1.0, 0.0, 0.0]);
/// contacts.push(2, Contact { particle: 0, partner: Partner::Particle(1), force: [-2.0, 0.0, 0.0], arm, branch })?;
/// let grid = Grid::new([0.0; 3], [2.0, 1.0, 1.0], [2, 1, 1])?;
/// let traction = contact_traction(&grid, &two, &contacts, None)?;
/// assert_eq!(traction.forces[grid.face_at(0, [1, 0, 0])], [2.0, 0.0, 0.0]);
/// assert_eq!(traction.balance_residual, 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn contact_traction<C: Faces>(
    cells: &C,
    particles: &Particles,
    contacts: &Contacts,
    domain: Option<&Domain>,
) -> Result<ContactTraction, FieldsError> {
    let positions = particles.positions();
    check_partners(contacts, positions.len())?;
    let periods = Periods::new(domain, [false; 3], cells.bounds());
    periods.check(0.5 * longest_branch(contacts.iter()))?;
    let indices: Vec<usize> = (0..contacts.len()).collect();
    // What each block of contacts brings to faces, and walls to cells, in the order of the contacts.
    let blocks: Vec<(Forces, Forces)> = indices
        .par_chunks(BLOCK)
        .map_init(
            || cells.scratch(),
            |scratch, block| {
                let (mut through, mut walls) = (Forces::new(), Forces::new());
                for &index in block {
                    let contact = contacts.get(index);
                    let centre = positions[contact.particle as usize];
                    let from = other_end(centre, contact.branch, contact.partner, positions);
                    let is_wall = matches!(contact.partner, Partner::Wall(_));
                    let low = std::array::from_fn(|k| centre[k].min(from[k]));
                    let high = std::array::from_fn(|k| centre[k].max(from[k]));
                    periods.for_each(low, high, |shift| {
                        let moved = |at: [f64; 3]| periods.off_faces(std::array::from_fn(|k| at[k] + shift[k]));
                        let (start, end) = (moved(from), moved(centre));
                        cells.for_each_crossing(start, end, &mut |face, way| {
                            through.push((face, contact.force.map(|f| way * f)));
                        });
                        if is_wall && let Some(cell) = cells.locate(start, scratch) {
                            walls.push((cell, contact.force));
                        }
                    });
                }
                (through, walls)
            },
        )
        .collect();
    let mut forces = vec![[0.0; 3]; cells.face_count()];
    let mut residuals = vec![[0.0; 3]; cells.cell_count()];
    let add = |sum: &mut [f64; 3], sign: f64, x: [f64; 3]| (0..3).for_each(|k| sum[k] += sign * x[k]);
    for (through, walls) in &blocks {
        through.iter().for_each(|&(face, f)| add(&mut forces[face as usize], 1.0, f));
        walls.iter().for_each(|&(cell, f)| add(&mut residuals[cell as usize], -1.0, f));
    }
    let mut scratch = cells.scratch();
    for (&at, force) in positions.iter().zip(contacts.force_sums(positions.len())) {
        periods.for_each(at, at, |shift| {
            let moved = periods.off_faces(std::array::from_fn(|k| at[k] + shift[k]));
            if let Some(cell) = cells.locate(moved, &mut scratch) {
                add(&mut residuals[cell as usize], 1.0, force);
            }
        });
    }
    // Most faces of fine cells are passed by no branch.
    for (face, &force) in forces.iter().enumerate().filter(|(_, force)| **force != [0.0; 3]) {
        let [back, front] = cells.face_sides(face);
        back.into_iter().for_each(|cell| add(&mut residuals[cell as usize], 1.0, force));
        front.into_iter().for_each(|cell| add(&mut residuals[cell as usize], -1.0, force));
    }
    let largest = |x: &[f64; 3]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let scale = contacts.iter().map(|c| largest(&c.force)).fold(0.0, f64::max);
    let worst = residuals.iter().map(largest).fold(0.0, f64::max);
    Ok(ContactTraction { forces, residuals, balance_residual: if scale > 0.0 { worst / scale } else { 0.0 } })
}

/// Where a branch comes from: the partner's own position where it is there but for rounding, so that it is found in the
/// cell that its centre is found in even if it lies on a face.
fn other_end(centre: [f64; 3], branch: [f64; 3], partner: Partner, positions: &[[f64; 3]]) -> [f64; 3] {
    let end: [f64; 3] = std::array::from_fn(|k| centre[k] + branch[k]);
    let Partner::Particle(other) = partner else { return end };
    let own = positions[other as usize];
    let largest = |v: [f64; 3]| v.into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let apart = largest(std::array::from_fn(|k| end[k] - own[k]));
    if apart <= 1e-9 * largest(branch) { own } else { end }
}
