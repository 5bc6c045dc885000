//! Contacts that are listed more than once: by a row, or a whole file, that is there again.

use std::hash::{DefaultHasher, Hash, Hasher};

use fieldstone_particles::{Contact, Contacts, Partner};
use rayon::prelude::*;

/// Contacts that are an earlier one again, to the last bit.
#[derive(Debug, PartialEq)]
pub(crate) struct Repeats {
    pub(crate) count: usize,
    /// How many of them are with walls.
    pub(crate) with_walls: usize,
    /// Place of the first.
    pub(crate) first: usize,
}

/// The contacts that are an earlier one again; none where all differ.
///
/// Contacts without force do not count: they change no sum, and programs list them where bodies merely come near.
pub(crate) fn repeated(contacts: &Contacts) -> Option<Repeats> {
    let mut keys: Vec<(u64, usize)> = (0..contacts.len())
        .into_par_iter()
        .map(|index| (contacts.get(index), index))
        .filter(|(contact, _)| contact.force != [0.0; 3])
        .map(|(contact, index)| (key(&contact), index))
        .collect();
    keys.par_sort_unstable();
    let again = |group: &[(u64, usize)]| {
        let first = contacts.get(group[0].1);
        group[1..]
            .iter()
            .map(|(_, index)| *index)
            .filter(move |&index| contacts.get(index) == first)
            .collect::<Vec<_>>()
    };
    let found: Vec<usize> = keys.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1).flat_map(again).collect();
    let with_walls = found.iter().filter(|&&k| matches!(contacts.get(k).partner, Partner::Wall(_))).count();
    found.iter().min().map(|&first| Repeats { count: found.len(), with_walls, first })
}

fn key(contact: &Contact) -> u64 {
    let mut hasher = DefaultHasher::new();
    contact.particle.hash(&mut hasher);
    match contact.partner {
        Partner::Particle(other) => (0, i64::from(other)).hash(&mut hasher),
        Partner::Wall(wall) => (1, wall).hash(&mut hasher),
    }
    for vector in [contact.force, contact.arm, contact.branch] {
        // Both zeros are equal, and must not differ here.
        vector.map(|x| (x + 0.0).to_bits()).hash(&mut hasher);
    }
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_that_are_there_again_are_counted_and_others_are_not() {
        let wall = |force: f64, wall: i64| Contact {
            particle: 0,
            partner: Partner::Wall(wall),
            force: [0.0, 0.0, force],
            arm: [0.0, 0.0, -1.0],
            branch: [0.0, 0.0, -1.0],
        };
        let mut contacts = Contacts::new();
        for contact in [wall(1.0, 0), wall(2.0, 0), wall(1.0, 1), wall(0.0, 0), wall(0.0, 0)] {
            contacts.push(1, contact).unwrap();
        }
        assert_eq!(repeated(&contacts), None);
        contacts.push(1, wall(2.0, 0)).unwrap();
        contacts.push(1, wall(1.0, 0)).unwrap();
        assert_eq!(repeated(&contacts), Some(Repeats { count: 2, with_walls: 2, first: 5 }));
    }
}
