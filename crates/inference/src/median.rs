//! The median of independent values and its interval.
//!
//! Method: order statistics; the number of values below the true median is binomial, whatever their distribution.
//!
//! References: W. J. Conover, Practical Nonparametric Statistics, 3rd ed. (1999), section 3.2.

use statrs::distribution::{Binomial, DiscreteCDF};

/// Median of some values, the mean of the two in the middle of an even number; none of none.
pub fn median(values: &[f64]) -> Option<f64> {
    middle_of(&sorted(values))
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

fn middle_of(sorted: &[f64]) -> Option<f64> {
    let n = sorted.len();
    Some(0.5 * (sorted.get(n.checked_sub(1)? / 2)? + sorted.get(n / 2)?))
}

/// Median of some values and its 95 % interval: an interval from six values on, a median from one.
pub fn median_with_interval_95(values: &[f64]) -> Option<(f64, Option<[f64; 2]>)> {
    let sorted = sorted(values);
    let n = sorted.len();
    let median = middle_of(&sorted)?;
    let below = Binomial::new(0.5, n as u64).ok()?;
    // as many values may lie outside on each side
    let outside = (0..n as u64 / 2).take_while(|k| below.cdf(*k) <= 0.025).count();
    let interval = (outside > 0).then(|| [sorted[outside - 1], sorted[n - outside]]);
    Some((median, interval))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use super::*;

    /// Conover's table: the second and the ninth of ten values, the sixth and the fifteenth of twenty; none of five.
    #[test]
    fn interval_is_that_of_printed_table() {
        let of = |n: usize| {
            let values: Vec<f64> = (1..=n).rev().map(|k| k as f64).collect();
            median_with_interval_95(&values).unwrap()
        };
        assert_eq!(of(10), (5.5, Some([2.0, 9.0])));
        assert_eq!(of(20), (10.5, Some([6.0, 15.0])));
        assert_eq!(of(6), (3.5, Some([1.0, 6.0])));
        assert_eq!(of(5), (3.0, None));
        assert_eq!(median_with_interval_95(&[]), None);
    }
}
