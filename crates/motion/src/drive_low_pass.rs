//! The low-pass through which a drive reports its effort, `T dy/dt + y = effort`, and back.

use armident_recording::{Recording, RecordingError};

use crate::decimate::low_pass;
use crate::differentiate::differentiate;
use crate::grid::EvenGrid;

/// What a drive reports of an effort on an even grid, by a low-pass of first order with this time constant \[s\]; exact for an
/// effort that is linear between its samples, and at rest before the first.
pub fn reported(effort: &[f64], rate_hz: f64, time_constant_s: f64) -> Vec<f64> {
    let Some(&first) = effort.first() else { return Vec::new() };
    if time_constant_s <= 0.0 {
        return effort.to_vec();
    }
    let steps = 1.0 / (rate_hz * time_constant_s);
    let kept = (-steps).exp();
    let of_slope = 1.0 - (1.0 - kept) / steps;
    let mut reported = first;
    let mut all = Vec::with_capacity(effort.len());
    all.push(first);
    for pair in effort.windows(2) {
        reported = kept * reported + (1.0 - kept) * pair[0] + of_slope * (pair[1] - pair[0]);
        all.push(reported);
    }
    all
}

/// A recording with its efforts as they were before a low-pass of first order with this time constant \[s\]. Only what is below
/// `band_hz` is corrected: above, the correction would be noise times the frequency.
///
/// # Errors
/// Stamps that give no grid, a rate that allows no low-pass.
pub fn before_low_pass(
    recording: &Recording,
    time_constant_s: f64,
    band_hz: f64,
) -> Result<Recording, RecordingError> {
    let grid = EvenGrid::of(recording)?;
    let filter = low_pass(band_hz, grid.rate_hz())?;
    let mut before = recording.clone();
    for effort in before.joints.iter_mut().filter_map(|joint| joint.effort.as_mut()) {
        let slow = filter.filter(&grid.resample(effort));
        let rate = grid.at_stamps(&differentiate(&slow, grid.rate_hz()));
        effort.iter_mut().zip(&rate).for_each(|(e, rate)| *e += time_constant_s * rate);
    }
    Ok(before)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use armident_recording::JointChannels;

    use super::*;

    const TIME_CONSTANT_S: f64 = 0.03;

    /// Gain and lag of a low-pass of first order, in a wave of 2 Hz.
    #[test]
    fn wave_is_reported_smaller_and_later() {
        let (rate_hz, wave) = (200.0, TAU * 2.0);
        let effort: Vec<f64> = (0..800).map(|k| (wave * f64::from(k) / rate_hz).sin()).collect();
        let found = reported(&effort, rate_hz, TIME_CONSTANT_S);
        let phase = (wave * TIME_CONSTANT_S).atan();
        for (k, found) in found.iter().enumerate().skip(200) {
            let exact = phase.cos() * (wave * k as f64 / rate_hz - phase).sin();
            assert!((found - exact).abs() < 2e-3, "{k}: {found} {exact}");
        }
        assert_eq!(reported(&effort, rate_hz, 0.0), effort);
    }

    #[test]
    fn correction_undoes_the_low_pass() {
        let rate_hz = 100.0;
        let time_s: Vec<f64> = (0..1200).map(|k| f64::from(k) / rate_hz).collect();
        let effort: Vec<f64> = time_s.iter().map(|t| (5.0 * t).sin() + (13.0 * t).cos()).collect();
        let shown = reported(&effort, rate_hz, TIME_CONSTANT_S);
        let joint = JointChannels { effort: Some(shown), ..JointChannels::new("elbow") };
        let recording = Recording::new("run", time_s, vec![joint]).unwrap();
        let before = before_low_pass(&recording, TIME_CONSTANT_S, 15.0).unwrap();
        let found = before.joints[0].effort.as_ref().unwrap();
        for k in 100..1100 {
            assert!((found[k] - effort[k]).abs() < 0.01, "{k}: {} {}", found[k], effort[k]);
        }
    }
}
