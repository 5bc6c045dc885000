use crate::cluster::LANES;
use crate::neighbour_list::PairSum;
use crate::points::Carrier;

/// Counts the points within a reach, the particle itself among them.
pub(crate) struct NeighbourCount<'a> {
    limit: f64,
    carriers: &'a [Carrier],
}

impl<'a> NeighbourCount<'a> {
    pub(crate) fn new(reach: f64, carriers: &'a [Carrier]) -> Self {
        Self { limit: reach * reach, carriers }
    }
}

impl PairSum for NeighbourCount<'_> {
    type Output = u32;

    #[inline(always)]
    fn of(&self, members: &[u32; LANES], list: &[u32]) -> [u32; LANES] {
        let mut counts = [0; LANES];
        for l in 0..LANES {
            let own = &self.carriers[members[l] as usize];
            for &j in list {
                let other = &self.carriers[j as usize];
                let (dx, dy, dz) = (other[0] - own[0], other[1] - own[1], other[2] - own[2]);
                counts[l] += u32::from(dx * dx + dy * dy + dz * dz < self.limit);
            }
        }
        counts
    }
}
