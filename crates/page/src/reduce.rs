//! Fewer values that look the same.

/// Smallest and largest value of every block of `samples_per_pair` samples, in the order in which they
/// come, so that no peak is lost; all samples where a block is one sample.
pub(crate) fn smallest_and_largest(values: &[f64], samples_per_pair: usize) -> Vec<f64> {
    if samples_per_pair <= 1 {
        return values.to_vec();
    }
    let mut kept = Vec::with_capacity(2 * values.len().div_ceil(samples_per_pair));
    for block in values.chunks(samples_per_pair) {
        let at = |better: fn(f64, f64) -> bool| {
            (0..block.len()).fold(0, |best, k| if better(block[k], block[best]) { k } else { best })
        };
        let (low, high) = (at(|a, b| a < b), at(|a, b| a > b));
        kept.push(block[low.min(high)]);
        kept.push(block[low.max(high)]);
    }
    kept
}

/// Samples that a pair must stand for, so that `samples` become at most `points` values.
pub(crate) fn samples_per_pair(samples: usize, points: usize) -> usize {
    if samples <= points { 1 } else { (2 * samples).div_ceil(points) }
}

/// Values in steps of about a fifty-thousandth of the largest: what a screen shows, in few digits.
pub(crate) fn rounded(values: &[f64]) -> Vec<f64> {
    let largest = values.iter().filter(|x| x.is_finite()).fold(0.0_f64, |m, x| m.max(x.abs()));
    if largest <= 0.0 {
        return values.to_vec();
    }
    let decimals = 4 - largest.log10().floor() as i32;
    values.iter().map(|x| at_decimals(*x, decimals)).collect()
}

/// The same where values may be missing.
pub(crate) fn rounded_some(values: &[Option<f64>]) -> Vec<Option<f64>> {
    let known: Vec<f64> = values.iter().map(|x| x.unwrap_or(0.0)).collect();
    values.iter().zip(rounded(&known)).map(|(x, r)| x.map(|_| r)).collect()
}

fn at_decimals(x: f64, decimals: i32) -> f64 {
    // by division where the power is whole: 0.1 * 3 is not 0.3
    let power = 10f64.powi(decimals.abs());
    let rounded =
        if decimals >= 0 { (x * power).round() / power } else { (x / power).round() * power };
    // no minus zero in the file
    rounded + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_stay() {
        let mut values: Vec<f64> = (0..600_000).map(|k| (f64::from(k) * 1e-3).sin()).collect();
        values[123_456] = 7.0;
        values[123_457] = -9.0;
        let block = samples_per_pair(values.len(), 3000);
        let kept = smallest_and_largest(&values, block);
        assert!(kept.len() <= 3002, "{}", kept.len());
        let at = 2 * (123_456 / block);
        assert_eq!(kept[at..at + 2], [7.0, -9.0]);
        assert_eq!(smallest_and_largest(&values[..50], samples_per_pair(50, 3000)), values[..50]);
    }

    #[test]
    fn few_digits() {
        assert_eq!(rounded(&[12.345_678, -0.000_04]), [12.346, 0.0]);
        assert_eq!(rounded(&[123_456_789.0]), [123_460_000.0]);
        assert_eq!(
            serde_json::to_string(&rounded(&[0.3, 0.000_012_345])).unwrap(),
            "[0.3,0.00001]"
        );
    }
}
