//! The low-pass through which a drive reports its effort, `T dy/dt + y = effort`, and back.

use std::f64::consts::TAU;

use armident_recording::RecordingError;

use crate::band_motion::BandMotion;
use crate::decimate::low_pass;
use crate::differentiate::differentiate;

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

impl BandMotion {
    /// With its efforts as they were before a low-pass of first order with this time constant \[s\]. Only what the comparison
    /// sees is corrected, up to one and a half times its band: above, the correction would be noise times the frequency.
    ///
    /// # Errors
    /// A rate that allows no low-pass.
    pub fn before_low_pass(mut self, time_constant_s: f64) -> Result<Self, RecordingError> {
        /// Where the correction ends, over the end of the band.
        const CORRECTED: f64 = 1.5;
        let filter = low_pass(CORRECTED * self.band_hz, self.rate_hz)?;
        for effort in self.effort.iter_mut().filter(|effort| !effort.is_empty()) {
            let rate = differentiate(&filter.filter(effort), self.rate_hz);
            effort.iter_mut().zip(&rate).for_each(|(e, rate)| *e += time_constant_s * rate);
        }
        // the noise in the band grows with the correction, at each frequency by the same factor as the effort
        let gain = |f_hz: f64| (TAU * f_hz * time_constant_s).powi(2) + 1.0;
        let over = (self.band.mean_power(gain) / self.band.mean_power(|_| 1.0)).sqrt();
        for noise in self.effort_noise.iter_mut().chain(&mut self.effort_noise_in_band) {
            *noise *= over;
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use armident_recording::{JointChannels, Recording};

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
        let joint = JointChannels {
            effort: Some(reported(&effort, rate_hz, TIME_CONSTANT_S)),
            position: Some(time_s.iter().map(|t| (2.0 * t).sin()).collect()),
            ..JointChannels::new("elbow")
        };
        let recording = Recording::new("run", time_s, vec![joint]).unwrap();
        let shown = BandMotion::below(&recording, &["elbow".to_owned()], 10.0).unwrap();
        let noise = shown.effort_noise_in_band[0];
        let before = shown.before_low_pass(TIME_CONSTANT_S).unwrap();
        for k in 100..1100 {
            let found = before.effort[0][k];
            assert!((found - effort[k]).abs() < 0.01, "{k}: {found} {}", effort[k]);
        }
        // at 10 Hz the correction is a factor of 2.1, at 0 Hz none
        let over = before.effort_noise_in_band[0] / noise;
        assert!((1.2..2.0).contains(&over), "{over}");
    }
}
