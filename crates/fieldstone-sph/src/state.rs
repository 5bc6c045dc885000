/// Position, velocity and density of every fluid particle, sorted in space now and then.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct State {
    /// Positions.
    pub x: Vec<[f64; 3]>,
    /// Velocities.
    pub u: Vec<[f64; 3]>,
    /// Densities.
    pub density: Vec<f64>,
    /// Number that a particle keeps for life, in the order in which the particles were given.
    pub id: Vec<u32>,
}

impl State {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// A checksum of all bits.
    pub(crate) fn fingerprint(&self) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        for vector in self.x.iter().chain(&self.u) {
            vector.iter().for_each(|x| hasher.update(&x.to_le_bytes()));
        }
        self.density.iter().for_each(|x| hasher.update(&x.to_le_bytes()));
        self.id.iter().for_each(|id| hasher.update(&id.to_le_bytes()));
        hasher.finalize()
    }

    /// Puts particles into another order, `order[new] = old`; those that are not in it are dropped.
    pub(crate) fn reorder(&mut self, order: &[u32]) {
        self.x = picked(&self.x, order);
        self.u = picked(&self.u, order);
        self.density = picked(&self.density, order);
        self.id = picked(&self.id, order);
    }
}

pub(crate) fn picked<T: Copy>(column: &[T], order: &[u32]) -> Vec<T> {
    order.iter().map(|&old| column[old as usize]).collect()
}
