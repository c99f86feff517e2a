//! Rate, jitter and gaps of time stamps.

use armident_numeric::order_statistic;
use serde::Serialize;

/// Steps longer than this many median steps are gaps.
pub const GAP_STEPS: f64 = 2.5;
/// Relative deviation of a step from the mean that still counts as even.
const EVEN_TOLERANCE: f64 = 1e-3;

/// A time interval without samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gap {
    /// Stamp of the last sample before it \[s\].
    pub at_s: f64,
    /// Time to the first sample after it \[s\].
    pub length_s: f64,
}

/// Statistics of the steps between time stamps.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Timing {
    /// Median step \[s\].
    pub median_step_s: f64,
    /// Samples per second: of even stamps from their mean step, else from the median step.
    pub rate_hz: f64,
    /// Last stamp minus first \[s\].
    pub duration_s: f64,
    /// Standard deviation of the steps as a share of the median step, without gaps.
    pub jitter: f64,
    /// Steps longer than [`GAP_STEPS`] median steps.
    pub gaps: Vec<Gap>,
    /// Whether all steps are equal, within a thousandth and the rounding of the stamps.
    pub is_even: bool,
}

impl Timing {
    /// Of strictly increasing stamps \[s\]. Fewer than two have step 0 and are even.
    pub fn of(time_s: &[f64]) -> Self {
        let steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        // lower of the two middle steps if their number is even
        let median_step_s = order_statistic(&mut steps.clone(), steps.len().saturating_sub(1) / 2);
        let (Some(first), Some(last), Some(median_step_s)) =
            (time_s.first(), time_s.last(), median_step_s)
        else {
            return Self {
                median_step_s: 0.0,
                rate_hz: 0.0,
                duration_s: 0.0,
                jitter: 0.0,
                gaps: Vec::new(),
                is_even: true,
            };
        };
        let duration_s = last - first;
        let longest_s = GAP_STEPS * median_step_s;
        let gaps: Vec<Gap> = time_s
            .iter()
            .zip(&steps)
            .filter(|(_, step)| **step > longest_s)
            .map(|(at_s, step)| Gap { at_s: *at_s, length_s: *step })
            .collect();

        let regular = || steps.iter().filter(|step| **step <= longest_s);
        let count = regular().count() as f64;
        let mean = regular().sum::<f64>() / count;
        let variance = regular().map(|step| (step - mean).powi(2)).sum::<f64>() / count;

        let mean_step_s = duration_s / steps.len() as f64;
        let is_even = !loses_samples(&steps, median_step_s) && is_even(time_s, &steps, mean_step_s);
        let rate_hz = 1.0 / if is_even { mean_step_s } else { median_step_s };
        let jitter = variance.sqrt() / median_step_s;
        Self { median_step_s, rate_hz, duration_s, jitter, gaps, is_even }
    }
}

/// Whether a few steps are twice the usual one: single missing samples. If they are many, the
/// stamps are rounded to the step (800 Hz in whole milliseconds: 1, 1, 1, 2).
fn loses_samples(steps: &[f64], median_step_s: f64) -> bool {
    const LOST: f64 = 1.5;
    const FEW: f64 = 0.1;
    let long = steps.iter().filter(|step| **step > LOST * median_step_s).count();
    long > 0 && (long as f64) < FEW * steps.len() as f64
}

/// Whether all steps are equal. If stamps are rounded so coarsely that steps differ (120 Hz in
/// whole milliseconds: 8, 8, 9), all stamps must lie on one line within their rounding.
fn is_even(time_s: &[f64], steps: &[f64], mean_step_s: f64) -> bool {
    let rounding_s = rounding_s(time_s, mean_step_s);
    let tolerance_s = EVEN_TOLERANCE * mean_step_s;
    let steps_agree =
        steps.iter().all(|step| (step - mean_step_s).abs() <= tolerance_s + 1.01 * rounding_s);
    let on_a_line = || {
        let line_s = |k: usize| time_s[0] + k as f64 * mean_step_s;
        time_s.iter().enumerate().all(|(k, t)| (t - line_s(k)).abs() <= 1.01 * rounding_s)
    };
    steps_agree && (rounding_s <= tolerance_s || on_a_line())
}

/// The decimal place to which all stamps are rounded \[s\], or the resolution of their floating
/// point where that is coarser; the decimal place counts only below the mean step.
fn rounding_s(time_s: &[f64], mean_step_s: f64) -> f64 {
    let largest_s = time_s.iter().fold(0.0_f64, |largest, t| largest.max(t.abs()));
    let float_s = 4.0 * f64::EPSILON * largest_s;
    let decimal_s = (0..=9)
        .map(|digits| 10.0_f64.powi(digits))
        .filter(|per_s| 1.0 / per_s < mean_step_s)
        .find(|per_s| {
            time_s.iter().all(|t| {
                let scaled = t * per_s;
                (scaled - scaled.round()).abs() <= 1e-6 + 4.0 * f64::EPSILON * scaled.abs()
            })
        })
        .map_or(0.0, |per_s| 1.0 / per_s);
    decimal_s.max(float_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounded(stamps: impl Iterator<Item = f64>, per_s: f64) -> Vec<f64> {
        stamps.map(|t| (t * per_s).round() / per_s).collect()
    }

    #[test]
    fn even_stamps_have_rate_and_no_jitter() {
        let timing = Timing::of(&(0..1000).map(|k| f64::from(k) * 0.005).collect::<Vec<_>>());
        assert!(timing.is_even && timing.gaps.is_empty());
        assert!((timing.rate_hz - 200.0).abs() < 1e-9);
        assert!((timing.duration_s - 4.995).abs() < 1e-12);
        assert!(timing.jitter < 1e-9);
    }

    #[test]
    fn rounded_stamps_are_even() {
        // 120 Hz in whole milliseconds, 300 Hz in microseconds, epoch seconds in microseconds
        for (rate_hz, per_s, start_s) in
            [(120.0, 1e3, 0.0), (300.0, 1e6, 3.0), (250.0, 1e6, 1.7e9), (1000.0, 1e3, 0.5)]
        {
            let stamps = rounded((0..5000).map(|k| start_s + f64::from(k) / rate_hz), per_s);
            let timing = Timing::of(&stamps);
            assert!(timing.is_even, "{rate_hz} Hz");
            assert!((timing.rate_hz / rate_hz - 1.0).abs() < 1e-4, "{}", timing.rate_hz);
        }
    }

    #[test]
    fn jitter_and_drift_are_uneven() {
        let jittered =
            (0..500).map(|k| f64::from(k) * 0.005 + 4e-4 * f64::from(k * 7919 % 13 - 6) / 6.0);
        let timing = Timing::of(&rounded(jittered, 1e5));
        assert!(!timing.is_even);
        assert!(timing.jitter > 0.03 && timing.jitter < 0.15, "{}", timing.jitter);
        // 8 ms that become 9 ms: rounding to milliseconds does not explain it
        let steps = (0..400).map(|k| if k < 200 { 0.008 } else { 0.009 });
        let drifting = steps.scan(0.0, |t, step| {
            *t += step;
            Some(*t)
        });
        assert!(!Timing::of(&rounded(drifting, 1e3)).is_even);
    }

    #[test]
    fn single_missing_samples_are_uneven() {
        for every in [50, 700] {
            let kept = (0..1200).filter(|k| k % every != every / 2);
            let timing = Timing::of(&rounded(kept.map(|k| f64::from(k) * 0.01), 1e2));
            assert!(!timing.is_even);
            assert!((timing.rate_hz - 100.0).abs() < 1e-6);
        }
        let timing = Timing::of(&rounded((0..5000).map(|k| f64::from(k) / 800.0), 1e3));
        assert!(timing.is_even);
    }

    #[test]
    fn gaps_do_not_count_as_jitter() {
        let stamps: Vec<f64> = (0..400)
            .filter(|k| !(100..105).contains(k) && *k != 200)
            .map(|k| f64::from(k) * 0.01)
            .collect();
        let timing = Timing::of(&stamps);
        assert_eq!(timing.gaps.len(), 1);
        assert!((timing.gaps[0].at_s - 0.99).abs() < 1e-12);
        assert!((timing.gaps[0].length_s - 0.06).abs() < 1e-12);
        assert!(!timing.is_even);
        assert!((timing.rate_hz - 100.0).abs() < 1e-6);
        assert!(timing.jitter < 0.06);
    }

    #[test]
    fn fewer_than_two_stamps_are_even() {
        assert!(Timing::of(&[]).is_even);
        assert_eq!(Timing::of(&[3.0]).duration_s, 0.0);
    }
}
