//! Contacts with LAMMPS's granular walls, from columns of the particles.

use std::path::{Path, PathBuf};

use fieldstone_particles::{Contact, Contacts, Particles, ParticlesError, Partner};

use crate::{ContactReader, FrameStamp, IoError};

/// Contacts with walls from the eight per-atom columns of LAMMPS's `fix wall/gran … contacts`, as dumped with the
/// particles: flag, force on the particle (3), contact point (3), radius.
///
/// `column` is the quantity's name, `f_ID`; without it, the only quantity of eight components is taken. Particles whose
/// flag is 0 touch no wall. The wall's number is 0: the fix does not tell several planes apart.
///
/// # Errors
/// [`ParticlesError::NoColumn`] where there is no such quantity, or several; [`ParticlesError::ContactNotFinite`].
///
/// ```
/// use fieldstone_io::lammps_wall_contacts;
/// use fieldstone_particles::{Particles, Quantity};
/// let data = vec![1.0, 0.0, 0.0, 9.81, 2.0, 0.0, 0.0, 0.5];
/// let one = Particles::new(vec![[2.0, 0.0, 0.49]])?.with_quantity(Quantity { name: "f_w".into(), components: 8, data })?;
/// let walls = lammps_wall_contacts(&one, None)?;
/// assert_eq!(walls.get(0).arm, [0.0, 0.0, -0.49]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn lammps_wall_contacts(particles: &Particles, column: Option<&str>) -> Result<Contacts, ParticlesError> {
    let wanted = column.unwrap_or("f_… of 8 components");
    let mut fitting = particles
        .quantities()
        .iter()
        .filter(|quantity| quantity.components == 8 && column.is_none_or(|name| quantity.name == name));
    let (Some(quantity), None) = (fitting.next(), fitting.next()) else {
        let available: Vec<_> =
            particles.quantities().iter().map(|q| format!("{} ({})", q.name, q.components)).collect();
        return Err(ParticlesError::NoColumn { name: wanted.into(), available: available.join(", ") });
    };
    let mut contacts = Contacts::new();
    for (index, (row, centre)) in quantity.data.chunks_exact(8).zip(particles.positions()).enumerate() {
        let &[flag, fx, fy, fz, x, y, z, _] = row else { continue };
        if flag == 0.0 {
            continue;
        }
        let reach = [x - centre[0], y - centre[1], z - centre[2]];
        let arm = particles.domain().map_or(reach, |domain| domain.minimum_image(reach));
        let contact =
            Contact { particle: index as u32, partner: Partner::Wall(0), force: [fx, fy, fz], arm, branch: arm };
        contacts.push(particles.len(), contact)?;
    }
    Ok(contacts)
}

/// [`lammps_wall_contacts`] as a reader: one frame of contacts to each frame of particles.
pub(crate) struct LammpsWallReader {
    path: PathBuf,
}

impl LammpsWallReader {
    pub(crate) fn new(path: &Path) -> Self {
        Self { path: path.into() }
    }
}

impl ContactReader for LammpsWallReader {
    fn peek(&mut self) -> Result<Option<FrameStamp>, IoError> {
        Ok(Some(FrameStamp::default()))
    }

    fn next_frame(&mut self, particles: &Particles) -> Result<Option<Contacts>, IoError> {
        let contacts = lammps_wall_contacts(particles, None);
        contacts.map(Some).map_err(|source| IoError::Particles { path: self.path.clone(), source })
    }

    fn skip_frame(&mut self) -> Result<bool, IoError> {
        Ok(true)
    }

    fn warnings(&self) -> &[String] {
        &[]
    }
}
