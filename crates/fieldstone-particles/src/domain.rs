use crate::ParticlesError;

/// The simulation box: a corner, three edge vectors, and which of them are periodic.
///
/// Orthogonal boxes are `low ≤ x < high` in each direction. Triclinic ones have the edges that LAMMPS gives them,
///
/// $$ a = (l_x, 0, 0), \qquad b = (xy, l_y, 0), \qquad c = (xz, yz, l_z). $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | `low` | corner at which the edges start | length |
/// | `lengths` | $l_x, l_y, l_z$, above 0 | length |
/// | `tilt` | $xy, xz, yz$ | length |
///
/// In a periodic direction a position outside is wrapped by whole edge vectors; any subset may be periodic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Domain {
    low: [f64; 3],
    high: [f64; 3],
    tilt: [f64; 3],
    periodic: [bool; 3],
}

impl Domain {
    /// An orthogonal box from `low` to `high`, periodic in the directions marked.
    ///
    /// # Errors
    /// [`ParticlesError::EmptyBox`] where an upper bound is not above the lower one (NaN included).
    pub fn new(low: [f64; 3], high: [f64; 3], periodic: [bool; 3]) -> Result<Self, ParticlesError> {
        for axis in 0..3 {
            let extent = high[axis] - low[axis];
            if extent.is_nan() || extent <= 0.0 || extent.is_infinite() {
                return Err(ParticlesError::EmptyBox { axis: ['x', 'y', 'z'][axis], low: low[axis], high: high[axis] });
            }
        }
        Ok(Self { low, high, tilt: [0.0; 3], periodic })
    }

    /// A triclinic box at `low` with the edges `(lx, 0, 0)`, `(xy, ly, 0)` and `(xz, yz, lz)`, `tilt` being
    /// `[xy, xz, yz]`, periodic along the edges marked.
    ///
    /// Without tilt this is the box of [`Domain::new`] from `low` to `low + lengths`.
    ///
    /// # Errors
    /// [`ParticlesError::EmptyBox`] for a length that is not above 0, [`ParticlesError::Tilt`] for a tilt that is
    /// not finite.
    ///
    /// ```
    /// use fieldstone_particles::Domain;
    /// let sheared = Domain::triclinic([0.0; 3], [2.0, 1.0, 1.0], [0.5, 0.0, 0.0], [true; 3])?;
    /// assert_eq!(sheared.cell_vectors()[1], [0.5, 1.0, 0.0]);
    /// assert_eq!(sheared.volume(), 2.0);
    /// // One edge b up, half a length to the right.
    /// assert_eq!(sheared.wrap([1.75, 1.5, 0.5]), [1.25, 0.5, 0.5]);
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    pub fn triclinic(
        low: [f64; 3],
        lengths: [f64; 3],
        tilt: [f64; 3],
        periodic: [bool; 3],
    ) -> Result<Self, ParticlesError> {
        let upright = Self::new(low, std::array::from_fn(|k| low[k] + lengths[k]), periodic)?;
        if let Some(index) = tilt.iter().position(|t| !t.is_finite()) {
            return Err(ParticlesError::Tilt { name: ["xy", "xz", "yz"][index], value: tilt[index] });
        }
        // A tilt of −0 is none.
        Ok(Self { tilt: tilt.map(|t| t + 0.0), ..upright })
    }

    /// Corner at which the edges start: the lower corner of an orthogonal box.
    pub fn low(&self) -> [f64; 3] {
        self.low
    }

    /// `low` plus the three lengths: the upper corner of an orthogonal box, and of a triclinic one that of the
    /// box without its tilt (LAMMPS's `xhi yhi zhi`).
    pub fn high(&self) -> [f64; 3] {
        self.high
    }

    /// Corners of the axis-aligned box around this one; `low` and `high` where it is orthogonal.
    ///
    /// ```
    /// use fieldstone_particles::Domain;
    /// let sheared = Domain::triclinic([0.0; 3], [2.0, 1.0, 1.0], [-0.5, 0.0, 0.25], [true; 3])?;
    /// assert_eq!(sheared.bounds(), ([-0.5, 0.0, 0.0], [2.0, 1.25, 1.0]));
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    pub fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let [xy, xz, yz] = self.tilt;
        let shifts = [[0.0, xy, xz, xy + xz], [0.0, yz, 0.0, 0.0], [0.0; 4]];
        (
            std::array::from_fn(|k| self.low[k] + shifts[k].into_iter().fold(0.0, f64::min)),
            std::array::from_fn(|k| self.high[k] + shifts[k].into_iter().fold(0.0, f64::max)),
        )
    }

    /// Which directions are periodic.
    pub fn periodic(&self) -> [bool; 3] {
        self.periodic
    }

    /// The same box with other periodic directions.
    #[must_use]
    pub fn with_periodic(mut self, periodic: [bool; 3]) -> Self {
        self.periodic = periodic;
        self
    }

    /// `[lx, ly, lz]`: edge lengths of an orthogonal box, the diagonal of the edge vectors of a triclinic one.
    pub fn lengths(&self) -> [f64; 3] {
        std::array::from_fn(|k| self.high[k] - self.low[k])
    }

    /// Tilt factors `[xy, xz, yz]`; zero where the box is orthogonal.
    pub fn tilt(&self) -> [f64; 3] {
        self.tilt
    }

    /// Whether the edges are parallel to the axes.
    pub fn is_orthogonal(&self) -> bool {
        self.tilt == [0.0; 3]
    }

    /// Edge vectors `a`, `b` and `c`.
    pub fn cell_vectors(&self) -> [[f64; 3]; 3] {
        let [lx, ly, lz] = self.lengths();
        let [xy, xz, yz] = self.tilt;
        [[lx, 0.0, 0.0], [xy, ly, 0.0], [xz, yz, lz]]
    }

    /// Distances between opposite faces, along `a`, `b` and `c`; the edge lengths of an orthogonal box.
    ///
    /// A ball reaches across the pair of faces `k` where its diameter exceeds height `k`.
    pub fn heights(&self) -> [f64; 3] {
        let [lx, ly, lz] = self.lengths();
        if self.is_orthogonal() {
            return [lx, ly, lz];
        }
        let [xy, xz, yz] = self.tilt;
        // Volume over the area of the face: |b × c| = |(ly lz, −xy lz, xy yz − ly xz)|, |a × c| = lx |(0, lz, yz)|.
        let across_a = (1.0f64).hypot(xy / ly).hypot((xy / ly * yz - xz) / lz);
        [lx / across_a, ly / (1.0f64).hypot(yz / lz), lz]
    }

    /// Volume of the box, $l_x l_y l_z$ with any tilt.
    pub fn volume(&self) -> f64 {
        self.lengths().into_iter().product()
    }

    /// Coordinates of `position` as fractions of the edge vectors: 0 to 1 inside the box.
    pub fn fractions(&self, position: [f64; 3]) -> [f64; 3] {
        self.fractions_of_vector(std::array::from_fn(|k| position[k] - self.low[k]))
    }

    fn fractions_of_vector(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [lx, ly, lz] = self.lengths();
        let [xy, xz, yz] = self.tilt;
        let c = z / lz;
        let b = (y - c * yz) / ly;
        [(x - (b * xy + c * xz)) / lx, b, c]
    }

    /// The lattice vector of whole numbers of edges.
    fn lattice_vector(&self, [a, b, c]: [f64; 3]) -> [f64; 3] {
        let [lx, ly, lz] = self.lengths();
        let [xy, xz, yz] = self.tilt;
        [a * lx + (b * xy + c * xz), b * ly + c * yz, c * lz]
    }

    /// `position` moved into the box by whole edge vectors along the periodic directions.
    ///
    /// An orthogonal box holds the result exactly; in a triclinic one rounding may leave it outside by some
    /// units in the last place.
    ///
    /// ```
    /// use fieldstone_particles::Domain;
    /// let unit = Domain::new([0.0; 3], [1.0; 3], [true, false, false])?;
    /// assert_eq!(unit.wrap([-0.25, 2.0, 0.5]), [0.75, 2.0, 0.5]);
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    pub fn wrap(&self, position: [f64; 3]) -> [f64; 3] {
        if !self.is_orthogonal() {
            return self.wrap_triclinic(position);
        }
        std::array::from_fn(|k| {
            let x = position[k];
            if !self.periodic[k] || (x >= self.low[k] && x < self.high[k]) {
                return x;
            }
            let length = self.high[k] - self.low[k];
            let wrapped = x - length * ((x - self.low[k]) / length).floor();
            // Rounding may land a tiny negative offset exactly on the upper bound, which belongs to the next box.
            if wrapped >= self.high[k] { self.low[k] } else { wrapped }
        })
    }

    fn wrap_triclinic(&self, position: [f64; 3]) -> [f64; 3] {
        let mut at = position;
        // From c to a: the fraction along an edge is not changed by moving along those before it. The second round
        // takes back what rounding left on the upper face, which belongs to the next box.
        for _ in 0..2 {
            for axis in [2, 1, 0] {
                let steps = self.fractions(at)[axis].floor();
                if self.periodic[axis] && steps != 0.0 {
                    let mut count = [0.0; 3];
                    count[axis] = -steps;
                    let shift = self.lattice_vector(count);
                    at = std::array::from_fn(|k| at[k] + shift[k]);
                }
            }
        }
        at
    }

    /// The shortest vector that differs from `vector` by whole edges along the periodic directions: the separation
    /// of the nearest images of two points.
    ///
    /// Exact to rounding for any tilt: the periodic edges are reduced to a basis of shortest vectors, whose sums
    /// with coefficients −1, 0 and 1 hold all that bound the lattice's Voronoi cell.
    ///
    /// ```
    /// use fieldstone_particles::Domain;
    /// let unit = Domain::new([0.0; 3], [1.0; 3], [true, true, false])?;
    /// assert_eq!(unit.minimum_image([0.75, 0.25, 0.75]), [-0.25, 0.25, 0.75]);
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    pub fn minimum_image(&self, vector: [f64; 3]) -> [f64; 3] {
        if self.is_orthogonal() {
            let lengths = self.lengths();
            return std::array::from_fn(|k| {
                if self.periodic[k] { vector[k] - lengths[k] * (vector[k] / lengths[k]).round() } else { vector[k] }
            });
        }
        let near = self.fractions_of_vector(vector);
        let count = std::array::from_fn(|k| if self.periodic[k] { -near[k].round() } else { 0.0 });
        let shift = self.lattice_vector(count);
        let edges: Vec<[f64; 3]> = (0..3).filter(|&k| self.periodic[k]).map(|k| self.cell_vectors()[k]).collect();
        shortest_in_lattice(std::array::from_fn(|k| vector[k] + shift[k]), edges)
    }

    /// Centres of all periodic images of a ball that reach into the box, the wrapped original first.
    ///
    /// A ball whose radius exceeds the box reaches in through several images per direction: all are listed. So are
    /// some that pass by a corner or an edge of the box, since each pair of faces is looked at alone: the list is
    /// complete, not minimal.
    ///
    /// ```
    /// use fieldstone_particles::Domain;
    /// let unit = Domain::new([0.0; 3], [1.0; 3], [true, true, false])?;
    /// let centres: Vec<_> = unit.images([0.1, 0.5, 0.0], 0.2).collect();
    /// assert_eq!(centres, [[0.1, 0.5, 0.0], [1.1, 0.5, 0.0]]);
    /// # Ok::<(), fieldstone_particles::ParticlesError>(())
    /// ```
    pub fn images(&self, centre: [f64; 3], radius: f64) -> Images {
        let origin = self.wrap(centre);
        let lengths = self.lengths();
        let mut range = [[0i64; 2]; 3];
        if self.is_orthogonal() {
            for k in 0..3 {
                if self.periodic[k] {
                    // Image m reaches in where origin + m L + r > low and origin + m L − r < high.
                    range[k][0] = ((self.low[k] - origin[k] - radius) / lengths[k]).floor() as i64 + 1;
                    range[k][1] = ((self.high[k] - origin[k] + radius) / lengths[k]).ceil() as i64 - 1;
                }
            }
        } else {
            let (at, heights) = (self.fractions(origin), self.heights());
            for k in 0..3 {
                if self.periodic[k] {
                    // The same in fractions, of which the radius covers r / height. They carry rounding errors: a ball
                    // that just fails to touch is listed rather than one that touches left out.
                    let reach = radius / heights[k] * (1.0 + 1e-12) + 1e-12;
                    range[k][0] = ((-at[k] - reach).floor() as i64 + 1).min(0);
                    range[k][1] = ((1.0 - at[k] + reach).ceil() as i64 - 1).max(0);
                }
            }
        }
        Images { origin, domain: *self, range, next: None, done: false }
    }
}

/// The shortest of `vector` plus all whole combinations of up to three `edges`.
fn shortest_in_lattice(mut vector: [f64; 3], mut edges: Vec<[f64; 3]>) -> [f64; 3] {
    let dot = |u: &[f64; 3], v: &[f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    // Takes off the nearest multiple of `by`; whether that made it shorter by more than rounding.
    let reduce = |v: &mut [f64; 3], by: &[f64; 3]| {
        let steps = (dot(v, by) / dot(by, by)).round();
        let shorter: [f64; 3] = std::array::from_fn(|k| v[k] - steps * by[k]);
        let better = steps != 0.0 && dot(&shorter, &shorter) < dot(v, v) * (1.0 - 1e-14);
        if better {
            *v = shorter;
        }
        better
    };
    // Each round makes some edge shorter; a basis that no combination shortens is Minkowski-reduced.
    let mut changed = true;
    while changed {
        changed = false;
        for k in 0..edges.len() {
            let others: Vec<[f64; 3]> = (0..edges.len()).filter(|&j| j != k).map(|j| edges[j]).collect();
            for combination in small_combinations(&others) {
                changed |= reduce(&mut edges[k], &combination);
            }
        }
    }
    let steps = small_combinations(&edges);
    while steps.iter().any(|step| reduce(&mut vector, step)) {}
    vector
}

/// Combinations of `edges` with coefficients −1, 0 and 1, one of each pair of opposite ones, without zero.
fn small_combinations(edges: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let total = 3usize.pow(edges.len() as u32);
    (total / 2 + 1..total)
        .map(|code| {
            let mut sum = [0.0; 3];
            let mut rest = code;
            for edge in edges {
                let coefficient = (rest % 3) as f64 - 1.0;
                rest /= 3;
                for k in 0..3 {
                    sum[k] += coefficient * edge[k];
                }
            }
            sum
        })
        .collect()
}

/// Iterator over the centres that [`Domain::images`] lists.
#[derive(Debug, Clone)]
pub struct Images {
    origin: [f64; 3],
    domain: Domain,
    range: [[i64; 2]; 3],
    next: Option<[i64; 3]>,
    done: bool,
}

impl Iterator for Images {
    type Item = [f64; 3];

    fn next(&mut self) -> Option<[f64; 3]> {
        if self.done {
            return None;
        }
        let Some(mut cell) = self.next else {
            self.next = Some([self.range[0][0], self.range[1][0], self.range[2][0]]);
            return Some(self.origin);
        };
        loop {
            let current = cell;
            let mut axis = 0;
            loop {
                if axis == 3 {
                    self.done = true;
                    break;
                }
                cell[axis] += 1;
                if cell[axis] <= self.range[axis][1] {
                    break;
                }
                cell[axis] = self.range[axis][0];
                axis += 1;
            }
            self.next = Some(cell);
            if current != [0; 3] {
                let shift = self.domain.lattice_vector(current.map(|count| count as f64));
                return Some(std::array::from_fn(|k| self.origin[k] + shift[k]));
            }
            if self.done {
                return None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(periodic: [bool; 3]) -> Domain {
        Domain::new([-1.0; 3], [1.0; 3], periodic).unwrap()
    }

    #[test]
    fn a_ball_at_a_corner_of_a_periodic_box_has_eight_images() {
        let found: Vec<_> = cube([true; 3]).images([0.95; 3], 0.1).collect();
        assert_eq!(found.len(), 8);
        assert_eq!(found[0], [0.95; 3]);
        assert!(found.contains(&[-1.05, 0.95, -1.05]));
    }

    #[test]
    fn a_ball_larger_than_the_box_reaches_in_from_every_image_within_its_radius() {
        let found: Vec<_> = cube([true, false, false]).images([0.0; 3], 5.5).collect();
        // Images at −6 … 6 in steps of 2 reach into (−1, 1).
        assert_eq!(found.len(), 7);
    }

    #[test]
    fn without_periodic_directions_there_is_only_the_ball_itself() {
        assert_eq!(cube([false; 3]).images([3.0, 0.0, 0.0], 1.0).collect::<Vec<_>>(), [[3.0, 0.0, 0.0]]);
    }

    #[test]
    fn wrapping_a_tiny_negative_offset_stays_inside() {
        let d = Domain::new([0.0; 3], [1.0; 3], [true; 3]).unwrap();
        let w = d.wrap([-1e-18, 7.5, -3.25]);
        assert_eq!(w, [0.0, 0.5, 0.75]);
    }
}
