use crate::SphError;

/// Where a body is at a time, relative to where its shape says, and how it moves.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pose {
    /// Displacement.
    pub displacement: [f64; 3],
    /// Velocity, its derivative.
    pub velocity: [f64; 3],
    /// Acceleration, the derivative of that.
    pub acceleration: [f64; 3],
}

/// A prescribed motion: displacements at times, and a monotone cubic between them.
///
/// $$ x(t) = x_k + m_k\,\tau + c_k\,\tau^2 + d_k\,\tau^3, \qquad \tau = t - t_k, \qquad
///    m_k = \frac{3(\eta_{k-1} + \eta_k)}{\frac{\eta_{k-1} + 2\eta_k}{s_{k-1}} + \frac{2\eta_{k-1} + \eta_k}{s_k}}
///    \text{ or } 0 $$
///
/// | symbol | meaning | unit |
/// |---|---|---|
/// | t_k, x_k | rows of the table | time, length |
/// | η_k, s_k | interval and slope between rows k and k + 1 | time, length/time |
/// | m_k | velocity at row k; 0 where the slopes beside it differ in sign or one is 0 | length/time |
///
/// Each axis passes through its rows, has a continuous velocity between the first and the last, and never
/// overshoots: where the table rests, the body rests. Before the first row and from the last on it is at rest, so
/// the velocity jumps there unless the table begins and ends with two rows at one place. Two rows make a straight
/// line.
///
/// Displacement, velocity and acceleration are functions of the time alone: nothing drifts, and a resumed run finds
/// the same bits.
///
/// Accuracy: fourth order in the displacement where it is monotone, second at its extremes; the acceleration is
/// piecewise linear and jumps at rows. Cost: a binary search.
///
/// Source: `fritsch1984`, with the three-point formula at the ends.
///
/// ```
/// use fieldstone_sph::Motion;
/// // At rest, then forward by 0.3 in a second, then at rest.
/// let rows = [(0.0, [0.0; 3]), (1.0, [0.0; 3]), (2.0, [0.3, 0.0, 0.0]), (3.0, [0.3, 0.0, 0.0])];
/// let motion = Motion::new(&rows)?;
/// assert_eq!(motion.at(1.0).velocity, [0.0; 3]);
/// assert!((motion.at(1.5).displacement[0] - 0.15).abs() < 1e-15);
/// assert!((motion.at(1.5).velocity[0] - 0.45).abs() < 1e-15);
/// # Ok::<(), fieldstone_sph::SphError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    times: Vec<f64>,
    displacements: Vec<[f64; 3]>,
    /// Velocities at the rows.
    slopes: Vec<[f64; 3]>,
}

impl Motion {
    /// A motion from rows of time and displacement.
    ///
    /// # Errors
    /// [`SphError::Motion`]: less than two rows, a number that is not finite, a time that does not rise.
    pub fn new(rows: &[(f64, [f64; 3])]) -> Result<Self, SphError> {
        let fault = |row: usize, message: String| Err(SphError::Motion { row: row + 1, message });
        if rows.len() < 2 {
            let message = format!("the motion has {} rows; give two at least, a start and an end", rows.len());
            return fault(rows.len().saturating_sub(1), message);
        }
        for (row, (time, displacement)) in rows.iter().enumerate() {
            if let Some(bad) = [*time].iter().chain(displacement).find(|x| !x.is_finite()) {
                return fault(row, format!("{bad} was found; time and displacement must be finite"));
            }
            if row > 0 && *time <= rows[row - 1].0 {
                let before = rows[row - 1].0;
                return fault(row, format!("time {time} follows {before}; times must rise from row to row"));
            }
        }
        let times: Vec<f64> = rows.iter().map(|r| r.0).collect();
        let displacements: Vec<[f64; 3]> = rows.iter().map(|r| r.1).collect();
        let mut slopes = vec![[0.0; 3]; rows.len()];
        for axis in 0..3 {
            let values: Vec<f64> = displacements.iter().map(|d| d[axis]).collect();
            for (slope, m) in slopes.iter_mut().zip(monotone_slopes(&times, &values)) {
                slope[axis] = m;
            }
        }
        Ok(Self { times, displacements, slopes })
    }

    /// Times and displacements of the table.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (f64, [f64; 3])> {
        self.times.iter().copied().zip(self.displacements.iter().copied())
    }

    /// Displacement, velocity and acceleration at a time.
    pub fn at(&self, time: f64) -> Pose {
        let after = self.times.partition_point(|&t| t <= time);
        let last = self.times.len() - 1;
        if after == 0 || after > last {
            let displacement = self.displacements[if after == 0 { 0 } else { last }];
            return Pose { displacement, ..Pose::default() };
        }
        let row = after - 1;
        let tau = time - self.times[row];
        let mut pose = Pose::default();
        for axis in 0..3 {
            let (m, c, d) = self.cubic(row, axis);
            pose.displacement[axis] = self.displacements[row][axis] + tau * (m + tau * (c + tau * d));
            pose.velocity[axis] = m + tau * (2.0 * c + 3.0 * d * tau);
            pose.acceleration[axis] = 2.0 * c + 6.0 * d * tau;
        }
        pose
    }

    /// Least and largest displacement along an axis from time 0 to another.
    pub(crate) fn range(&self, axis: usize, until: f64) -> [f64; 2] {
        // Between rows no cubic overshoots.
        let rows = self.times.iter().zip(&self.displacements);
        let within = rows.filter(|(time, _)| (0.0..=until).contains(*time)).map(|(_, displacement)| displacement[axis]);
        let ends = [0.0, until].map(|time| self.at(time).displacement[axis]);
        within.chain(ends).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    }

    /// Bounds of speed and acceleration from one time to another: the root of the squares of each axis' largest.
    pub fn largest(&self, from: f64, to: f64) -> (f64, f64) {
        let (mut speed, mut acceleration) = (0.0f64, 0.0f64);
        for row in 0..self.times.len() - 1 {
            let (start, end) = (self.times[row].max(from), self.times[row + 1].min(to));
            if start > end {
                continue;
            }
            let (first, last) = (start - self.times[row], end - self.times[row]);
            let (mut speeds, mut accelerations) = (0.0, 0.0);
            for axis in 0..3 {
                let (m, c, d) = self.cubic(row, axis);
                let velocity = |tau: f64| (m + tau * (2.0 * c + 3.0 * d * tau)).abs();
                let extreme = -c / (3.0 * d);
                let between = if extreme > first && extreme < last { velocity(extreme) } else { 0.0 };
                let fastest = velocity(first).max(velocity(last)).max(between);
                let strongest = (2.0 * c + 6.0 * d * first).abs().max((2.0 * c + 6.0 * d * last).abs());
                speeds += fastest * fastest;
                accelerations += strongest * strongest;
            }
            speed = speed.max(speeds.sqrt());
            acceleration = acceleration.max(accelerations.sqrt());
        }
        (speed, acceleration)
    }

    /// m, c and d between a row and the next.
    fn cubic(&self, row: usize, axis: usize) -> (f64, f64, f64) {
        let interval = self.times[row + 1] - self.times[row];
        let slope = (self.displacements[row + 1][axis] - self.displacements[row][axis]) / interval;
        let (m, n) = (self.slopes[row][axis], self.slopes[row + 1][axis]);
        (m, (3.0 * slope - 2.0 * m - n) / interval, (m + n - 2.0 * slope) / (interval * interval))
    }
}

/// Slopes at the rows with which the cubics between them are monotone where the rows are.
fn monotone_slopes(times: &[f64], values: &[f64]) -> Vec<f64> {
    let intervals: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
    let slopes: Vec<f64> = values.windows(2).zip(&intervals).map(|(v, h)| (v[1] - v[0]) / h).collect();
    let count = slopes.len();
    if count == 1 {
        return vec![slopes[0]; 2];
    }
    let inner = |k: usize| {
        let (h, h1, s, s1) = (intervals[k - 1], intervals[k], slopes[k - 1], slopes[k]);
        if s * s1 > 0.0 { 3.0 * (h + h1) / ((2.0 * h1 + h) / s + (h1 + 2.0 * h) / s1) } else { 0.0 }
    };
    // From the parabola through three rows, held within what keeps the end monotone.
    let end = |h: f64, h1: f64, s: f64, s1: f64| {
        let m = ((2.0 * h + h1) * s - h * s1) / (h + h1);
        if m * s <= 0.0 {
            0.0
        } else if s * s1 <= 0.0 && m.abs() > 3.0 * s.abs() {
            3.0 * s
        } else {
            m
        }
    };
    let mut found = vec![end(intervals[0], intervals[1], slopes[0], slopes[1])];
    found.extend((1..count).map(inner));
    found.push(end(intervals[count - 1], intervals[count - 2], slopes[count - 1], slopes[count - 2]));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along_x(rows: &[(f64, f64)]) -> Motion {
        Motion::new(&rows.iter().map(|&(t, x)| (t, [x, -2.0 * x, 0.0])).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn the_curve_is_that_of_scipys_pchip_interpolator() {
        let times = [0.0, 0.5, 0.75, 1.5, 2.0, 2.2, 3.0];
        let places = [0.0, 0.1, 0.5, 0.45, 0.45, 0.9, 1.0];
        let motion = along_x(&times.into_iter().zip(places).collect::<Vec<_>>());
        // Time; value, first and second derivative by SciPy 1.
        let expected = [
            (0.0, 0.0, 0.0, 0.8432432432432435),
            (0.2, 0.016518918918918928, 0.1634594594594595, 0.7913513513513514),
            (0.6, 0.25481081081081075, 2.2572972972972973, 5.189189189189193),
            (0.74, 0.4982806486486485, 0.33937297297297064, -32.5881081081081),
            (1.0, 0.48703703703703705, -0.08888888888888888, -0.17777777777777776),
            (1.7, 0.45, 0.0, 0.0),
            (2.1, 0.6677884615384615, 3.302884615384612, 1.4423076923076863),
            (2.5, 0.9654447115384616, 0.15324519230769235, -0.3966346153846155),
            (2.99, 0.9999891225961538, 0.00218149038461532, -0.21995192307692313),
        ];
        for (time, x, u, a) in expected {
            let pose = motion.at(time);
            for (found, value) in [(pose.displacement, x), (pose.velocity, u), (pose.acceleration, a)] {
                assert!((found[0] - value).abs() < 1e-13 * (1.0 + value.abs()), "{time}: {found:?} {value}");
                assert!((found[1] + 2.0 * value).abs() < 1e-13 * (1.0 + value.abs()) && found[2] == 0.0);
            }
        }
    }

    #[test]
    fn outside_the_table_the_body_rests_and_two_rows_make_a_straight_line() {
        let motion = along_x(&[(1.0, 0.5), (3.0, 1.5)]);
        assert_eq!(motion.at(0.0), Pose { displacement: [0.5, -1.0, 0.0], ..Pose::default() });
        assert_eq!(motion.at(3.0), Pose { displacement: [1.5, -3.0, 0.0], ..Pose::default() });
        let pose = motion.at(1.5);
        assert_eq!(
            (pose.displacement, pose.velocity, pose.acceleration),
            ([0.75, -1.5, 0.0], [0.5, -1.0, 0.0], [0.0; 3])
        );
    }

    #[test]
    fn the_largest_speed_is_found_between_rows_too() {
        let motion = along_x(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.3), (3.0, 0.3)]);
        let root = 5.0f64.sqrt();
        let (speed, acceleration) = motion.largest(0.0, 9.0);
        assert!((speed - 0.45 * root).abs() < 1e-14 && (acceleration - 1.8 * root).abs() < 1e-13);
        assert_eq!(motion.largest(0.0, 0.9), (0.0, 0.0));
        assert_eq!(motion.largest(4.0, 5.0), (0.0, 0.0));
        let sampled = |from: f64, to: f64| {
            let speed = |n: i32| {
                let u = motion.at(from + (to - from) * f64::from(n) / 1000.0).velocity;
                u[0].hypot(u[1])
            };
            (0..=1000).map(speed).fold(0.0, f64::max)
        };
        for (from, to) in [(0.5, 1.2), (1.1, 1.4), (1.3, 1.9), (1.8, 2.5)] {
            let (bound, found) = (motion.largest(from, to).0, sampled(from, to));
            assert!(bound >= found && bound < found * (1.0 + 1e-5), "{from} {to}: {bound} {found}");
        }
    }

    #[test]
    fn tables_that_are_none_are_refused_with_their_row() {
        let nowhere = [0.0; 3];
        for (rows, expected) in [
            (vec![], "row 1 of the motion: the motion has 0 rows; give two at least"),
            (vec![(0.0, nowhere)], "row 1 of the motion: the motion has 1 rows"),
            (vec![(0.0, nowhere), (1.0, nowhere), (1.0, nowhere)], "row 3 of the motion: time 1 follows 1; times must"),
            (vec![(0.0, nowhere), (f64::NAN, nowhere)], "row 2 of the motion: NaN was found"),
            (vec![(0.0, [f64::INFINITY, 0.0, 0.0]), (1.0, nowhere)], "row 1 of the motion: inf was found"),
        ] {
            let error = Motion::new(&rows).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{error}");
        }
    }
}
