//! Comparison of two models by their errors on the same left-out folds.
//!
//! Hypothesis: both models have the same expected logarithm of the error. Statistic: the mean over the folds of the
//! logarithm of the error ratio, over its standard error from the scatter of the folds (paired t statistic).
//!
//! References: own; the paired comparison is that of T. G. Dietterich, Approximate statistical tests for comparing
//! supervised classification learning algorithms, Neural Computation 10 (1998).

/// Mean of the gains of folds over its standard error: the paired t statistic.
pub fn paired_t(gains: &[f64]) -> f64 {
    let count = gains.len() as f64;
    let mean = gains.iter().sum::<f64>() / count;
    let variance = gains.iter().map(|g| (g - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    mean / (variance / count).sqrt().max(f64::MIN_POSITIVE)
}

/// Share by which the errors of some columns fall (geometric mean over columns and folds); none unless the mean is
/// positive and above `least_t` of its standard errors.
///
/// `before` and `after` are squared errors as `[fold][column]`.
pub fn significant_gain(
    before: &[Vec<f64>],
    after: &[Vec<f64>],
    columns: &[usize],
    least_t: f64,
) -> Option<f64> {
    let count = before.len() as f64;
    let gains: Vec<f64> = (before.iter().zip(after))
        .map(|(before, after)| {
            let logs = columns.iter().map(|&column| 0.5 * (before[column] / after[column]).ln());
            logs.sum::<f64>() / columns.len() as f64
        })
        .collect();
    let mean = gains.iter().sum::<f64>() / count;
    (mean > 0.0 && paired_t(&gains) > least_t).then(|| 1.0 - (-mean).exp())
}

#[cfg(test)]
mod tests {
    use super::significant_gain;

    #[test]
    fn gain_needs_agreement_of_folds() {
        let before = vec![vec![1.0]; 4];
        let even: Vec<Vec<f64>> = [0.80, 0.82, 0.81, 0.79].map(|e: f64| vec![e * e]).into();
        let gain = significant_gain(&before, &even, &[0], 2.0).unwrap();
        assert!((gain - 0.195).abs() < 0.001, "{gain}");
        let uneven: Vec<Vec<f64>> = [0.3, 1.4, 0.7, 1.2].map(|e: f64| vec![e * e]).into();
        assert!(significant_gain(&before, &uneven, &[0], 2.0).is_none());
        assert!(significant_gain(&even, &before, &[0], 0.0).is_none());
    }
}
