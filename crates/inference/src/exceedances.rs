//! Level that a series exceeds at a stated rate: peaks over a threshold with a generalised Pareto tail.
//!
//! Exceedances that follow each other are one episode, of which the largest counts. Sources: A. C. Davison, R. L. Smith, Models
//! for exceedances over high thresholds, Journal of the Royal Statistical Society B 52, 1990; J. R. M. Hosking, J. R. Wallis,
//! Parameter and quantile estimation for the generalized Pareto distribution, Technometrics 29, 1987 (probability-weighted
//! moments).

/// Episodes that a tail is fitted to, at least where the series has so many.
const EPISODES: usize = 40;
/// Fewest episodes that make a tail.
const FEWEST: usize = 10;
/// Shapes of a tail, lightest and heaviest: some tens of episodes do not determine more.
const SHAPES: [f64; 2] = [-0.5, 0.5];
/// Levels tried between the median and the largest value.
const LEVELS: usize = 400;

/// Largest value of each episode above a level. Values above it that are less than `apart` samples after another one belong
/// to the same episode; series are separate.
pub fn episodes(series: &[&[f64]], level: f64, apart: usize) -> Vec<f64> {
    let mut peaks: Vec<f64> = Vec::new();
    for values in series {
        let mut last: Option<usize> = None;
        for (k, value) in values.iter().enumerate().filter(|(_, value)| **value > level) {
            match (last, peaks.last_mut()) {
                (Some(before), Some(peak)) if k - before < apart => *peak = peak.max(*value),
                _ => peaks.push(*value),
            }
            last = Some(k);
        }
    }
    peaks
}

/// The upper tail of a series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tail {
    /// Level from which it is fitted.
    pub from: f64,
    /// Episodes above that level, per sample.
    pub rate: f64,
    /// Episodes that it was fitted to.
    pub episodes: usize,
    /// Scale of the generalised Pareto distribution of the excess.
    pub scale: f64,
    /// Its shape: 0 exponential, negative with an end.
    pub shape: f64,
}

impl Tail {
    /// The tail of series, from a level that has more episodes than `rate` per sample and at least some tens; none of series
    /// that are too short. See [`episodes`] for `apart`.
    pub fn of(series: &[&[f64]], apart: usize, rate: f64) -> Option<Self> {
        let mut sorted: Vec<f64> = series.iter().copied().flatten().copied().collect();
        if sorted.iter().any(|value| !value.is_finite()) {
            return None;
        }
        if sorted.is_empty() {
            return None;
        }
        sorted.sort_by(f64::total_cmp);
        let wanted = EPISODES.max((2.0 * rate * sorted.len() as f64).ceil() as usize);
        // downwards to the first level that has enough; lower levels join episodes, so that there may be none
        let mut best: Option<(f64, Vec<f64>)> = None;
        for k in 1..=LEVELS {
            let share = 0.5 * (k as f64 / LEVELS as f64).powi(3);
            let from = sorted[sorted.len() - 1 - (share * (sorted.len() - 1) as f64) as usize];
            let peaks = episodes(series, from, apart);
            if best.as_ref().is_none_or(|(_, most)| peaks.len() > most.len()) {
                best = Some((from, peaks));
            }
            if best.as_ref().is_some_and(|(_, most)| most.len() >= wanted) {
                break;
            }
        }
        let (from, peaks) = best.filter(|(_, peaks)| peaks.len() >= FEWEST)?;
        let (scale, shape) = pareto(peaks.iter().map(|peak| peak - from).collect());
        let rate = peaks.len() as f64 / sorted.len() as f64;
        Some(Self { from, rate, episodes: peaks.len(), scale, shape })
    }

    /// The level above which there are so many episodes per sample; the lowest that is known for rates above
    /// [`rate`](Self::rate).
    pub fn level(&self, rate: f64) -> f64 {
        let ratio = (self.rate / rate).max(1.0);
        let excess = if self.shape.abs() < 1e-9 {
            ratio.ln()
        } else {
            (ratio.powf(self.shape) - 1.0) / self.shape
        };
        self.from + self.scale * excess
    }
}

/// Scale and shape of a generalised Pareto distribution, by probability-weighted moments; the mean is kept where the shape is at
/// a bound.
fn pareto(mut excess: Vec<f64>) -> (f64, f64) {
    excess.sort_by(f64::total_cmp);
    let n = excess.len() as f64;
    let mean = excess.iter().sum::<f64>() / n;
    let weighted = excess.iter().enumerate();
    let weighted: f64 = weighted.map(|(k, x)| x * (1.0 - (k as f64 + 0.65) / n)).sum::<f64>() / n;
    let shape = 2.0 - mean / (mean - 2.0 * weighted);
    let shape = if shape.is_finite() { shape.clamp(SHAPES[0], SHAPES[1]) } else { 0.0 };
    (mean * (1.0 - shape), shape)
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    fn exponential(samples: usize, seed: u64) -> Vec<f64> {
        let mut random = rand_pcg::Pcg64::seed_from_u64(seed);
        (0..samples).map(|_| -(1.0 - random.random_range(0.0..1.0_f64)).ln()).collect()
    }

    #[test]
    fn neighbours_are_one_episode() {
        let values = [0.0, 2.0, 3.0, 0.0, 2.5, 0.0, 0.0, 0.0, 4.0];
        assert_eq!(episodes(&[&values], 1.0, 3), [3.0, 4.0]);
        assert_eq!(episodes(&[&values], 1.0, 1), [2.0, 3.0, 2.5, 4.0]);
        assert_eq!(episodes(&[&values, &values[4..]], 1.0, 3), [3.0, 4.0, 2.5, 4.0]);
    }

    /// An exponential variable is above `ln(1 / rate)` at a rate.
    #[test]
    fn exponential_tails_are_continued() {
        let values = exponential(20_000, 7);
        let tail = Tail::of(&[&values], 1, 1e-3).unwrap();
        assert!(tail.shape.abs() < 0.25, "{tail:?}");
        for rate in [1e-3_f64, 2e-4, 5e-5] {
            let expected = -rate.ln();
            assert!((tail.level(rate) - expected).abs() < 1.0, "{} {expected}", tail.level(rate));
        }
    }

    /// The observed rate on other samples of the same kind.
    #[test]
    fn rates_hold_on_other_samples() {
        for seed in 0..10 {
            let tail = Tail::of(&[&exponential(50_000, seed)], 1, 1e-3).unwrap();
            let other = exponential(50_000, 100 + seed);
            let found = episodes(&[&other], tail.level(1e-3), 1).len();
            assert!((25..=100).contains(&found), "{found}");
        }
    }

    #[test]
    fn short_series_have_no_tail() {
        assert_eq!(Tail::of(&[&[1.0, 2.0, 3.0, 1.0]], 1, 0.1), None);
    }
}
