//! Derivatives of the efforts of a whole motion, and columns formed sample by sample.

use crate::motion::WholeArmMotion;

/// Change of position \[rad or m\] or angle \[rad\] of the one-sided differences: its square is lost.
pub(crate) const STEP: f64 = 1e-5;

/// `(f(step) - rigid) / step`, joint-major.
pub(crate) fn derivative(
    motion: &WholeArmMotion<'_>,
    step: f64,
    f: impl Fn(f64) -> Vec<Vec<f64>>,
) -> Vec<Vec<f64>> {
    let mut moved = f(step);
    for (moved, rigid) in moved.iter_mut().zip(motion.rigid_effort) {
        for (moved, rigid) in moved.iter_mut().zip(rigid) {
            *moved = (*moved - rigid) / step;
        }
    }
    moved
}

/// Central differences per second; one-sided at the ends.
pub(crate) fn rate(values: &[f64], rate_hz: f64) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    (0..values.len())
        .map(|t| {
            let (before, after) = (t.saturating_sub(1), (t + 1).min(last));
            (values[after] - values[before]) * rate_hz / (after - before).max(1) as f64
        })
        .collect()
}

/// One column formed sample by sample.
pub(crate) fn column(samples: usize, f: impl Fn(usize) -> f64) -> Vec<f64> {
    (0..samples).map(f).collect()
}
