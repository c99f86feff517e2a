//! Sampled values: through a low-pass, fewer of them, and between their samples.

use std::f64::consts::TAU;

use crate::{CUTOFF_SHARE_BOUND, ZeroPhaseLowPass};
use armident_recording::RecordingError;

/// Cut-off of the low-pass of positions before they are differentiated \[Hz\], well above the band:
/// columns with signs and products are formed from it and only then filtered.
const KINEMATICS_HZ: f64 = 25.0;
const KINEMATICS_ORDER: usize = 4;

/// `|K|² ω^(2 order)` of the zero-phase low-pass (its magnitude counts twice).
pub(crate) fn kinematics_power(f_hz: f64, order: i32) -> f64 {
    let magnitude = 1.0 / (1.0 + (f_hz / KINEMATICS_HZ).powi(2 * KINEMATICS_ORDER as i32));
    magnitude * magnitude * (TAU * f_hz).powi(2 * order)
}

/// The low-pass of positions before they are differentiated, at this rate.
///
/// # Errors
/// A rate that allows no low-pass.
pub fn kinematics_filter(rate_hz: f64) -> Result<ZeroPhaseLowPass, RecordingError> {
    low_pass(KINEMATICS_HZ, rate_hz)
}

/// Its cut-off at this rate.
pub(crate) fn kinematics_cutoff_hz(rate_hz: f64) -> f64 {
    KINEMATICS_HZ.min(highest_cutoff_hz(rate_hz))
}

fn highest_cutoff_hz(rate_hz: f64) -> f64 {
    0.9 * CUTOFF_SHARE_BOUND * rate_hz
}

/// A low-pass of this cut-off, or of the highest that the rate allows.
///
/// # Errors
/// A rate that allows no low-pass.
pub fn low_pass(cutoff_hz: f64, rate_hz: f64) -> Result<ZeroPhaseLowPass, RecordingError> {
    ZeroPhaseLowPass::new(KINEMATICS_ORDER, cutoff_hz.min(highest_cutoff_hz(rate_hz)), rate_hz)
}

pub(crate) fn every<T: Copy>(step: usize, values: &[T]) -> Vec<T> {
    values.iter().copied().step_by(step).collect()
}

/// Every so many samples the mean of as many around it, the outermost by half where the number is even;
/// of fewer at the ends, so that a line stays a line.
pub(crate) fn means(step: usize, values: &[f64]) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let outer = if step.is_multiple_of(2) { 0.5 } else { 1.0 };
    let mean = |t: usize| {
        let half = (step / 2).min(t).min(last - t);
        if half == 0 {
            return values[t];
        }
        let inner: f64 = values[t + 1 - half..t + half].iter().sum();
        let weight = (2 * half - 1) as f64 + 2.0 * outer;
        (inner + outer * (values[t - half] + values[t + half])) / weight
    };
    (0..values.len()).step_by(step).map(mean).collect()
}

/// A value between two samples, by the cubic through four neighbours; held at the ends.
pub(crate) fn between(values: &[f64], place: f64) -> f64 {
    let (whole, last) = (place.floor(), values.len() as i64 - 1);
    let x = place - whole;
    let weights = [
        -x * (x - 1.0) * (x - 2.0) / 6.0,
        (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0,
        -(x + 1.0) * x * (x - 2.0) / 2.0,
        (x + 1.0) * x * (x - 1.0) / 6.0,
    ];
    let at = |k: i64| values[(whole as i64 + k).clamp(0, last) as usize];
    weights.iter().zip(-1..).map(|(w, k)| w * at(k)).sum()
}

/// Values `samples` later.
pub fn later(values: &[f64], samples: f64) -> Vec<f64> {
    if samples == 0.0 {
        return values.to_vec();
    }
    (0..values.len()).map(|t| between(values, t as f64 + samples)).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::{between, later, means};

    /// A line stays a line up to its ends; of what alternates with every sample nothing is left.
    #[test]
    fn means_around_the_samples_that_remain() {
        for step in [2, 3, 4, 5] {
            let line: Vec<f64> = (0..41).map(|k| 2.0 * f64::from(k) - 7.0).collect();
            let expected: Vec<f64> = line.iter().copied().step_by(step).collect();
            for (got, expected) in means(step, &line).iter().zip(&expected) {
                assert!((got - expected).abs() < 1e-12, "{step}: {got} {expected}");
            }
            let waves = (0..41).map(|k| (TAU * f64::from(k) / step as f64).cos());
            let left = means(step, &waves.collect::<Vec<_>>());
            let inner = &left[1..left.len() - 1];
            assert!(inner.iter().all(|x| x.abs() < 1e-12), "{step}: {inner:?}");
        }
        assert_eq!(means(4, &[]), Vec::<f64>::new());
        assert_eq!(means(4, &[3.0]), [3.0]);
    }

    /// A cubic is what it is between its samples too, and its ends are held.
    #[test]
    fn between_samples_lies_a_cubic() {
        let cubic = |x: f64| 2.0 - x + 0.3 * x * x - 0.01 * x.powi(3);
        let values: Vec<f64> = (0..20).map(|k| cubic(f64::from(k))).collect();
        for place in [1.0, 4.25, 9.5, 17.9] {
            assert!((between(&values, place) - cubic(place)).abs() < 1e-12, "{place}");
        }
        assert_eq!(later(&values, 2.0)[..18], values[2..]);
        assert_eq!(later(&values, 40.0), [values[19]; 20]);
        assert!((later(&values, 0.5)[7] - cubic(7.5)).abs() < 1e-12);
        assert!(later(&[], 1.5).is_empty());
    }
}
