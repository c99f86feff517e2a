//! Unwrapping of angles logged modulo a full turn.

use std::f64::consts::TAU;

use armident_numeric::{extremes, range};

/// A step is a wrap if it differs from a full turn by less than this \[rad\], and no other step may
/// be longer: a joint that moves faster per sample is indistinguishable from one that wraps.
const LONGEST_OTHER_STEP: f64 = 1.0;
/// Values of a wrapped angle lie within a turn and the rounding of the log \[rad\].
const WINDOW: f64 = TAU + 0.02;
/// Largest step beside a full turn of an angle that crosses the end of its range by noise \[rad\].
const NOISE: f64 = 0.1;

/// Unwraps an angle that jumps by full turns; returns the samples after the jumps.
///
/// Only channels that are wrapped throughout change: all values within one turn, every step either
/// within 1 rad of a full turn or shorter than 1 rad. Lengths and speeds do so only if they jump
/// from one end of a range of 2 π to the other.
pub(crate) fn unwrap_turns(values: &mut [f64]) -> Vec<usize> {
    let range = range(values);
    if !(TAU - LONGEST_OTHER_STEP..=WINDOW).contains(&range) {
        return Vec::new();
    }
    let step = |k: usize| values[k] - values[k - 1];
    let is_wrap = |k: &usize| (step(*k).abs() - TAU).abs() < LONGEST_OTHER_STEP;
    let wraps: Vec<usize> = (1..values.len()).filter(is_wrap).collect();
    let others_are_short =
        (1..values.len()).all(|k| is_wrap(&k) || step(k).abs() < LONGEST_OTHER_STEP);
    if wraps.is_empty() || !others_are_short {
        return Vec::new();
    }
    let signs: Vec<f64> = wraps.iter().map(|k| step(*k).signum()).collect();
    let (mut turns, mut next) = (0.0, 0);
    for (k, value) in values.iter_mut().enumerate() {
        if wraps.get(next) == Some(&k) {
            turns -= signs[next];
            next += 1;
        }
        *value += TAU * turns;
    }
    wraps
}

/// Whether a sample of an angle that is logged modulo a full turn lies a full turn from the one before or after: noise at the
/// end of the range crosses it back and forth.
pub(crate) fn is_wrap_of(values: &[f64], sample: usize) -> bool {
    let [smallest, largest] = extremes(values.iter().copied());
    let near_end =
        |value: f64| value - smallest < LONGEST_OTHER_STEP || largest - value < LONGEST_OTHER_STEP;
    let steps = [sample.checked_sub(1), Some(sample + 1)].into_iter().flatten();
    let is_turn = |other: usize| {
        let step = values.get(other).map_or(0.0, |value| value - values[sample]);
        (step.abs() - TAU).abs() < NOISE
    };
    largest - smallest <= WINDOW && near_end(values[sample]) && steps.into_iter().any(is_turn)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn wrapped(angle: f64, from: f64) -> f64 {
        from + (angle - from).rem_euclid(TAU)
    }

    #[test]
    fn turning_joints_become_continuous() {
        for from in [-PI, 0.0] {
            let angle: Vec<f64> = (0..4000).map(|k| 9.0 * (2e-3 * f64::from(k)).sin()).collect();
            let mut values: Vec<f64> = angle.iter().map(|a| wrapped(*a, from)).collect();
            let jumps = unwrap_turns(&mut values);
            assert!(jumps.len() > 3);
            let offset = values[0] - angle[0];
            for (value, angle) in values.iter().zip(&angle) {
                assert!((value - angle - offset).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn other_channels_do_not_change() {
        let swing: Vec<f64> = (0..500).map(|k| 3.1 * (0.02 * f64::from(k)).sin()).collect();
        let turning: Vec<f64> = (0..500).map(|k| 0.1 * f64::from(k)).collect();
        let mut spike = swing.clone();
        spike[77] += TAU;
        let square: Vec<f64> = (0..500).map(|k| if k % 50 < 25 { 0.0 } else { 4.0 }).collect();
        for values in [swing, turning, spike, square, vec![f64::NAN; 9], vec![]] {
            let mut copy = values.clone();
            assert!(unwrap_turns(&mut copy).is_empty());
            assert!(copy.iter().zip(&values).all(|(a, b)| a.to_bits() == b.to_bits()));
        }
    }
}
