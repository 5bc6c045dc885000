use crate::ParticlesError;

/// What a particle touches in a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Partner {
    /// Another particle, by its index in the particle set.
    Particle(u32),
    /// A wall, by the number that the source gives it.
    Wall(i64),
}

/// One contact: the force on a particle, and where it acts.
///
/// All vectors are relative, so a contact through a periodic boundary is like any other: `arm` and `branch` lead
/// to the image that is touched, however far away the partner's own position is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Index of the particle that the force acts on.
    pub particle: u32,
    /// What it touches.
    pub partner: Partner,
    /// Force on the particle; on a partner that is a particle its opposite acts.
    pub force: [f64; 3],
    /// Vector from the particle's centre to the contact point.
    pub arm: [f64; 3],
    /// Branch vector: from the particle's centre to the partner's; for a wall the arm again.
    pub branch: [f64; 3],
}

impl Contact {
    /// Vector from the partner's centre to the contact point; zero for a wall.
    ///
    /// ```
    /// use fieldstone_particles::{Contact, Partner};
    /// let touch = Contact {
    ///     particle: 0,
    ///     partner: Partner::Particle(1),
    ///     force: [-2.0, 0.0, 0.0],
    ///     arm: [0.5, 0.0, 0.0],
    ///     branch: [1.0, 0.0, 0.0],
    /// };
    /// assert_eq!(touch.partner_arm(), [-0.5, 0.0, 0.0]);
    /// ```
    pub fn partner_arm(&self) -> [f64; 3] {
        std::array::from_fn(|k| self.arm[k] - self.branch[k])
    }
}

/// The contacts of a particle set, as a structure of arrays; each pair once.
///
/// | column | shape | unit |
/// |---|---|---|
/// | particles, partners | N | index, or index and wall number |
/// | forces (on the particle) | N × 3 | force |
/// | arms (centre to contact point) | N × 3 | length |
/// | branches (centre to partner's centre, for walls the arm) | N × 3 | length |
///
/// Contacts are resolved: they hold indices instead of ids, and vectors to the image that is touched instead of
/// positions. Readers build them with the particles of the same frame at hand.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Contacts {
    particles: Vec<u32>,
    partners: Vec<Option<u32>>,
    walls: Vec<i64>,
    forces: Vec<[f64; 3]>,
    arms: Vec<[f64; 3]>,
    branches: Vec<[f64; 3]>,
}

impl Contacts {
    /// No contact yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a contact between particles of a set of `particle_count`.
    ///
    /// # Errors
    /// [`ParticlesError::UnknownParticle`] for an index beyond the set, [`ParticlesError::SelfContact`] for a
    /// particle that touches itself without an image between, [`ParticlesError::ContactNotFinite`] for NaN or infinity.
    ///
    /// ```
    /// use fieldstone_particles::{Contact, Contacts, Partner};
    /// let mut contacts = Contacts::new();
    /// let arm = [0.0, 0.0, -0.5];
    /// contacts.push(1, Contact { particle: 0, partner: Partner::Wall(2), force: [0.0, 0.0, 9.81], arm, branch: arm })?;
    /// assert_eq!(contacts.get(0).partner, Partner::Wall(2));
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    pub fn push(&mut self, particle_count: usize, contact: Contact) -> Result<(), ParticlesError> {
        let index = self.len();
        let partner = match contact.partner {
            Partner::Particle(other) => Some(other),
            Partner::Wall(_) => None,
        };
        for particle in [Some(contact.particle), partner].into_iter().flatten() {
            if particle as usize >= particle_count {
                return Err(ParticlesError::UnknownParticle { index, particle, particle_count });
            }
        }
        if partner == Some(contact.particle) && contact.branch == [0.0; 3] {
            return Err(ParticlesError::SelfContact { index, particle: contact.particle });
        }
        for (what, vector) in [("force", contact.force), ("arm", contact.arm), ("branch", contact.branch)] {
            if let Some(&value) = vector.iter().find(|v| !v.is_finite()) {
                return Err(ParticlesError::ContactNotFinite { index, what, value });
            }
        }
        self.particles.push(contact.particle);
        self.partners.push(partner);
        self.walls.push(match contact.partner {
            Partner::Wall(wall) => wall,
            Partner::Particle(_) => 0,
        });
        self.forces.push(contact.force);
        self.arms.push(contact.arm);
        self.branches.push(contact.branch);
        Ok(())
    }

    /// Adds all of `others`, which belong to the same particles: walls to pairs, say.
    ///
    /// ```
    /// use fieldstone_particles::{Contact, Contacts, Partner};
    /// let arm = [0.0, 0.0, -0.5];
    /// let mut walls = Contacts::new();
    /// walls.push(1, Contact { particle: 0, partner: Partner::Wall(0), force: [0.0, 0.0, 1.0], arm, branch: arm })?;
    /// let mut all = Contacts::new();
    /// all.extend(&walls);
    /// assert_eq!(all, walls);
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    pub fn extend(&mut self, others: &Self) {
        self.particles.extend_from_slice(&others.particles);
        self.partners.extend_from_slice(&others.partners);
        self.walls.extend_from_slice(&others.walls);
        self.forces.extend_from_slice(&others.forces);
        self.arms.extend_from_slice(&others.arms);
        self.branches.extend_from_slice(&others.branches);
    }

    /// Number of contacts.
    pub fn len(&self) -> usize {
        self.particles.len()
    }

    /// Whether there is no contact at all.
    pub fn is_empty(&self) -> bool {
        self.particles.is_empty()
    }

    /// Contact `index`.
    ///
    /// # Panics
    /// Where `index` is not below [`Contacts::len`].
    pub fn get(&self, index: usize) -> Contact {
        Contact {
            particle: self.particles[index],
            partner: match self.partners[index] {
                Some(other) => Partner::Particle(other),
                None => Partner::Wall(self.walls[index]),
            },
            force: self.forces[index],
            arm: self.arms[index],
            branch: self.branches[index],
        }
    }

    /// All contacts in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Contact> + '_ {
        (0..self.len()).map(|index| self.get(index))
    }

    /// Sum of the contact forces on each particle of a set of `particle_count`: both sides of pairs, and walls.
    ///
    /// ```
    /// use fieldstone_particles::{Contact, Contacts, Partner};
    /// let mut contacts = Contacts::new();
    /// let (arm, branch) = ([0.5, 0.0, 0.0], [1.0, 0.0, 0.0]);
    /// contacts.push(2, Contact { particle: 0, partner: Partner::Particle(1), force: [-2.0, 0.0, 0.0], arm, branch })?;
    /// assert_eq!(contacts.force_sums(2), [[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    pub fn force_sums(&self, particle_count: usize) -> Vec<[f64; 3]> {
        let mut sums = vec![[0.0; 3]; particle_count];
        for contact in self.iter() {
            for (k, force) in contact.force.into_iter().enumerate() {
                sums[contact.particle as usize][k] += force;
                if let Partner::Particle(other) = contact.partner {
                    sums[other as usize][k] -= force;
                }
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(force: [f64; 3]) -> Contact {
        Contact { particle: 0, partner: Partner::Particle(1), force, arm: [0.5, 0.0, 0.0], branch: [1.0, 0.0, 0.0] }
    }

    #[test]
    fn a_contact_of_an_unknown_particle_is_refused_with_its_index() {
        let e = Contacts::new().push(1, pair([0.0; 3])).unwrap_err();
        assert!(e.to_string().contains("contact 0 names particle 1, but there are 1"), "{e}");
    }

    #[test]
    fn a_force_that_is_not_a_number_is_refused() {
        let e = Contacts::new().push(2, pair([0.0, f64::NAN, 0.0])).unwrap_err();
        assert!(e.to_string().contains("contact 0 has force NaN"), "{e}");
    }

    #[test]
    fn a_particle_may_touch_its_own_image_but_not_itself() {
        let own_image = Contact { partner: Partner::Particle(0), ..pair([1.0, 0.0, 0.0]) };
        let mut contacts = Contacts::new();
        contacts.push(1, own_image).unwrap();
        assert!(contacts.push(1, Contact { branch: [0.0; 3], ..own_image }).is_err());
        assert_eq!(contacts.force_sums(1), [[0.0; 3]]);
    }
}
