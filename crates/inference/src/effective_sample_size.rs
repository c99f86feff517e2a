//! How many independent samples an autocorrelated series is worth.
//!
//! Method: samples over the integrated autocorrelation time `1 + 2 Σ ρ_k`, summed over the initial sequence of positive
//! pairs `ρ_2m + ρ_2m+1`.
//!
//! References: C. J. Geyer, Practical Markov chain Monte Carlo, Statistical Science 7 (1992).

use armident_numeric::dot;

/// Integrated autocorrelation time of some series about their common mean, at least 1: samples per independent sample.
pub fn correlation_time(series: &[Vec<f64>]) -> f64 {
    let count: usize = series.iter().map(Vec::len).sum();
    let mean = series.iter().flatten().sum::<f64>() / count as f64;
    let product = |lag: usize| -> f64 {
        series
            .iter()
            .flat_map(|s| s.iter().zip(s.iter().skip(lag)).map(|(a, b)| (a - mean) * (b - mean)))
            .sum()
    };
    let variance = product(0);
    if variance.is_nan() || variance <= 0.0 {
        return 1.0;
    }
    let mut time = -1.0;
    for pair in 0..count / 4 {
        let sum = (product(2 * pair) + product(2 * pair + 1)) / variance;
        if sum <= 0.0 {
            break;
        }
        time += 2.0 * sum;
    }
    time.max(1.0)
}

/// Independent samples per row of residuals: one over its autocorrelation time, joints by their number
/// of rows. The recordings begin at `starts`, whose last is the end. Model discrepancy has a longer correlation time
/// than noise in the band.
pub fn independent_share(residual: &[Vec<f64>], starts: &[usize], rows_hz: f64) -> f64 {
    // the duration of a motion; beyond, the estimate is noise
    const LONGEST_S: f64 = 2.0;
    let mut time = 0.0;
    for residual in residual {
        let square = dot(residual, residual).max(f64::MIN_POSITIVE);
        let correlation = |lag: usize| -> f64 {
            let pairs = starts.windows(2).map(|p| &residual[p[0]..p[1]]);
            pairs
                .map(|r| dot(&r[..r.len().saturating_sub(lag)], &r[lag.min(r.len())..]))
                .sum::<f64>()
                / square
        };
        let lags = (1..(LONGEST_S * rows_hz) as usize).map(correlation);
        time += 1.0 + 2.0 * lags.take_while(|c| *c > 0.0).sum::<f64>();
    }
    residual.len() as f64 / time
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// A first-order series with coefficient a: (1 + a) / (1 - a).
    #[test]
    fn correlation_time_matches_first_order_series() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(3);
        for a in [0.0, 0.5, 0.8] {
            let mut x = 0.0;
            let series: Vec<f64> = (0..40_000)
                .map(|_| {
                    x = a * x + random.random_range(-1.0..1.0);
                    x
                })
                .collect();
            let expected = (1.0 + a) / (1.0 - a);
            let found = correlation_time(&[series]);
            assert!((found / expected - 1.0).abs() < 0.15, "{found} for {expected}");
        }
        assert_eq!(correlation_time(&[vec![1.0; 10]]), 1.0);
    }
}
