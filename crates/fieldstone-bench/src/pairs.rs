//! Pairs of a ball and an element that partially overlap, as `strobl2016`, Sec. 5, makes them.

use fieldstone_geometry::decomposition::{
    self, DecompositionElement, HexahedronCorners, hexahedron_to_2_wedges, hexahedron_to_5_tetrahedra,
};
use fieldstone_geometry::{Ball, CornerOrder, ElementKind, Orientation, OverlapBatch, Polyhedron};

use fieldstone_testing::Random;

/// What the unit cells of the mesh are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// One hexahedron per cell.
    Hexahedron,
    /// Two wedges per cell.
    Wedge,
    /// Five tetrahedra per cell.
    FiveTetrahedra,
}

impl Shape {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Hexahedron, Self::Wedge, Self::FiveTetrahedra];

    /// Name in bench names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hexahedron => "hex",
            Self::Wedge => "wedge",
            Self::FiveTetrahedra => "tet5",
        }
    }

    /// The same element for the kernel and for the decomposition.
    fn elements(self, cell: &HexahedronCorners) -> Vec<(Polyhedron, DecompositionElement)> {
        let polyhedron = |kind, corners: &[[f64; 3]]| {
            Polyhedron::element(kind, CornerOrder::Cgns, corners, Orientation::Refuse).expect("a unit cell's part")
        };
        let other = "a unit cell's part suits both methods";
        match self {
            Self::Hexahedron => {
                vec![(polyhedron(ElementKind::Hexahedron, cell), DecompositionElement::hexahedron(*cell).expect(other))]
            }
            Self::Wedge => hexahedron_to_2_wedges(cell)
                .map(|c| (polyhedron(ElementKind::Wedge, &c), DecompositionElement::wedge(c).expect(other)))
                .to_vec(),
            Self::FiveTetrahedra => hexahedron_to_5_tetrahedra(cell)
                .map(|c| (polyhedron(ElementKind::Tetrahedron, &c), DecompositionElement::tetrahedron(c).expect(other)))
                .to_vec(),
        }
    }
}

/// Balls, elements, and the pairs of them that partially overlap.
///
/// Ball centres are uniform in the central unit cell of a mesh that covers every ball. Of all pairs of ball and
/// element those are kept where neither contains the other and they are not apart: for the others both methods have
/// cheap answers, and how many of these there are says nothing about either.
///
/// ```
/// use fieldstone_bench::{Pairs, Shape};
/// let pairs = Pairs::new(Shape::Hexahedron, 1.0, 1, 1);
/// // A ball of the cell's own size reaches all but a few corners of its 27 cells, and contains none.
/// assert!((16..=27).contains(&pairs.len()));
/// let shares: f64 = (0..pairs.len()).map(|k| fieldstone_geometry::overlap_volume(pairs.get(k).0, pairs.get(k).1)).sum();
/// assert!((shares / pairs.get(0).0.volume() - 1.0).abs() < 1e-14);
/// ```
#[derive(Debug)]
pub struct Pairs {
    balls: Vec<Ball>,
    polyhedra: Vec<Polyhedron>,
    elements: Vec<DecompositionElement>,
    pairs: Vec<(u32, u32)>,
}

impl Pairs {
    /// All partial overlaps of as many balls of radius `r` as it takes to get `at_least` pairs.
    pub fn new(shape: Shape, r: f64, at_least: usize, seed: u64) -> Self {
        let reach = r.ceil() as i32;
        let mut this = Self { balls: Vec::new(), polyhedra: Vec::new(), elements: Vec::new(), pairs: Vec::new() };
        for k in -reach..=reach {
            for j in -reach..=reach {
                for i in -reach..=reach {
                    let low = [i, j, k].map(|x| f64::from(x) - 0.5);
                    let at = |dx: f64, dy: f64, dz: f64| [low[0] + dx, low[1] + dy, low[2] + dz];
                    let corners = [
                        at(0., 0., 0.),
                        at(1., 0., 0.),
                        at(1., 1., 0.),
                        at(0., 1., 0.),
                        at(0., 0., 1.),
                        at(1., 0., 1.),
                        at(1., 1., 1.),
                        at(0., 1., 1.),
                    ];
                    for (polyhedron, element) in shape.elements(&corners) {
                        this.polyhedra.push(polyhedron);
                        this.elements.push(element);
                    }
                }
            }
        }
        let mut random = Random(seed);
        while this.pairs.len() < at_least {
            let ball = Ball::new(random.point(-0.5, 0.5), r).expect("a finite centre");
            let index = this.balls.len() as u32;
            this.balls.push(ball);
            for (element, e) in this.elements.iter().enumerate() {
                let volume = decomposition::overlap_volume(&ball, e);
                if volume > 0.0 && volume < e.volume() && volume < ball.volume() {
                    this.pairs.push((index, element as u32));
                }
            }
        }
        this
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Whether there is no pair.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// A pair, the element in both forms.
    pub fn get(&self, pair: usize) -> (&Ball, &Polyhedron, &DecompositionElement) {
        let (ball, element) = self.pairs[pair];
        (&self.balls[ball as usize], &self.polyhedra[element as usize], &self.elements[element as usize])
    }

    /// All pairs at once, in one call of the kernel's batch; writes to `volumes`, one per pair.
    pub fn batch(&self, batch: &mut OverlapBatch, volumes: &mut [f64]) {
        batch.pairs(&self.balls, &self.polyhedra, &self.pairs, volumes);
    }

    /// Sum over all pairs of what `method` returns.
    #[inline]
    pub fn sum(&self, mut method: impl FnMut(&Ball, &Polyhedron, &DecompositionElement) -> f64) -> f64 {
        let mut sum = 0.0;
        for &(ball, element) in &self.pairs {
            let at = element as usize;
            sum += method(&self.balls[ball as usize], &self.polyhedra[at], &self.elements[at]);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fieldstone_geometry::overlap_volume;

    #[test]
    fn the_rivals_are_given_the_same_work_and_agree_on_it() {
        for shape in Shape::ALL {
            for r in [0.1, 0.3, 0.6, 1.0] {
                let pairs = Pairs::new(shape, r, 200, 7);
                let mut batched = vec![0.0; pairs.len()];
                pairs.batch(&mut OverlapBatch::default(), &mut batched);
                for (k, &volume) in batched.iter().enumerate() {
                    let (ball, polyhedron, element) = pairs.get(k);
                    assert!((overlap_volume(ball, polyhedron) - volume).abs() < 1e-13 * r.powi(3));
                    let difference = overlap_volume(ball, polyhedron) - decomposition::overlap_volume(ball, element);
                    assert!(difference.abs() < 1e-13 * r.powi(3), "{} r = {r}: {difference:e}", shape.name());
                }
            }
        }
    }
}
