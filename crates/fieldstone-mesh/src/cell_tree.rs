//! A tree of bounding boxes over cells: which cells can meet a box?

use glam::DVec3;

/// Cells in a leaf at most.
const LEAF: usize = 4;

#[derive(Debug, Clone, Copy)]
struct Node {
    low: DVec3,
    high: DVec3,
    /// Leaf: first entry of `cells`. Inner node: index of the second child (the first follows directly).
    index: u32,
    /// Cells in the leaf; 0 for an inner node.
    count: u32,
}

/// Bounding-volume hierarchy, split at the median of the longest side.
///
/// The same for any number of threads, and balanced whatever the grading of the mesh.
#[derive(Debug, Clone)]
pub(crate) struct CellTree {
    nodes: Vec<Node>,
    cells: Vec<u32>,
}

impl CellTree {
    pub fn new(bounds: &[[DVec3; 2]]) -> Self {
        let mut cells: Vec<u32> = (0..bounds.len() as u32).collect();
        let mut nodes = Vec::with_capacity(bounds.len());
        if !cells.is_empty() {
            build(bounds, &mut cells, 0, &mut nodes);
        }
        Self { nodes, cells }
    }

    /// Calls `visit` with every cell whose bounds meet the box, in the tree's order; boundaries count as meeting.
    pub fn query(&self, bounds: &[[DVec3; 2]], low: DVec3, high: DVec3, mut visit: impl FnMut(u32)) {
        let meets = |a: DVec3, b: DVec3| a.cmple(high).all() && b.cmpge(low).all();
        // The depth is log₂ of at most 2³² cells, and each level leaves one node waiting.
        let mut stack = [0u32; 40];
        let mut waiting = usize::from(!self.nodes.is_empty());
        while waiting > 0 {
            waiting -= 1;
            let at = stack[waiting] as usize;
            let node = self.nodes[at];
            if !meets(node.low, node.high) {
                continue;
            }
            if node.count > 0 {
                for &cell in &self.cells[node.index as usize..(node.index + node.count) as usize] {
                    let [a, b] = bounds[cell as usize];
                    if meets(a, b) {
                        visit(cell);
                    }
                }
            } else {
                stack[waiting] = node.index;
                stack[waiting + 1] = at as u32 + 1;
                waiting += 2;
            }
        }
    }
}

fn build(bounds: &[[DVec3; 2]], cells: &mut [u32], offset: u32, nodes: &mut Vec<Node>) {
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for &cell in cells.iter() {
        low = low.min(bounds[cell as usize][0]);
        high = high.max(bounds[cell as usize][1]);
    }
    let at = nodes.len();
    nodes.push(Node { low, high, index: offset, count: cells.len() as u32 });
    if cells.len() <= LEAF {
        return;
    }
    let extent = high - low;
    let axis = (0..3).fold(0, |best, k| if extent[k] > extent[best] { k } else { best });
    let middle = cells.len() / 2;
    let key = |cell: u32| bounds[cell as usize][0][axis] + bounds[cell as usize][1][axis];
    cells.select_nth_unstable_by(middle, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
    let (left, right) = cells.split_at_mut(middle);
    build(bounds, left, offset, nodes);
    nodes[at].index = nodes.len() as u32;
    nodes[at].count = 0;
    build(bounds, right, offset + middle as u32, nodes);
}

#[cfg(test)]
mod tests {
    use fieldstone_testing::Random;

    use super::*;

    #[test]
    fn finds_exactly_the_boxes_that_meet_a_box() {
        let mut random = Random(7);
        let mut next = || random.unit();
        // Boxes of very different sizes.
        let bounds: Vec<[DVec3; 2]> = (0..1000)
            .map(|_| {
                let low = DVec3::new(next(), next(), next());
                [low, low + DVec3::new(next(), next(), next()).powf(4.0)]
            })
            .collect();
        let tree = CellTree::new(&bounds);
        for _ in 0..200 {
            let low = DVec3::new(next(), next(), next());
            let high = low + 0.1 * next();
            let mut found = Vec::new();
            tree.query(&bounds, low, high, |c| found.push(c));
            found.sort_unstable();
            let expected: Vec<u32> = (0..1000)
                .filter(|&c| {
                    let [a, b] = bounds[c as usize];
                    (0..3).all(|k| a[k] <= high[k] && b[k] >= low[k])
                })
                .collect();
            assert_eq!(found, expected);
        }
    }
}
