//! Rivals taking turns.

/// Runs each of `rivals` once per turn, in their order, and returns what each reports, turn by turn.
///
/// A rival measures itself and returns a time. One turn more is run first and dropped: it warms the caches.
pub fn take_turns<const N: usize>(turns: usize, mut rivals: [&mut dyn FnMut() -> f64; N]) -> [Vec<f64>; N] {
    let mut times: [Vec<f64>; N] = std::array::from_fn(|_| Vec::with_capacity(turns));
    for turn in 0..=turns {
        for (rival, times) in rivals.iter_mut().zip(&mut times) {
            let time = rival();
            if turn > 0 {
                times.push(time);
            }
        }
    }
    times
}

/// The median; NaN of nothing.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let n = sorted.len();
    match n {
        0 => f64::NAN,
        _ => 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_of_an_even_number_is_the_mean_of_the_middle_two() {
        assert_eq!(median([4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median([3.0, 1.0, 2.0]), 2.0);
        assert!(median([]).is_nan());
    }

    #[test]
    fn rivals_alternate_and_the_first_turn_is_dropped() {
        let order = std::cell::RefCell::new(String::new());
        let mut call = 0.0;
        let mut first = || {
            order.borrow_mut().push('a');
            call += 1.0;
            call
        };
        let mut second = || {
            order.borrow_mut().push('b');
            0.5
        };
        let [a, b] = take_turns(2, [&mut first, &mut second]);
        assert_eq!((a, b), (vec![2.0, 3.0], vec![0.5, 0.5]));
        assert_eq!(order.into_inner(), "ababab");
    }
}
