//! Power by frequency under a Hann window.

use std::f64::consts::PI;
use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};

/// Periodograms of windows of one length. Non-generic, so that the transform is compiled once, here.
pub struct Periodogram {
    window: Vec<f64>,
    transform: Arc<dyn RealToComplex<f64>>,
    windowed: Vec<f64>,
    spectrum: Vec<Complex<f64>>,
    power: Vec<f64>,
}

impl Periodogram {
    /// Of `samples` evenly sampled values.
    #[inline(never)]
    pub fn new(samples: usize) -> Self {
        let at = |k: usize| (PI * (k as f64 + 0.5) / samples as f64).sin().powi(2);
        let transform = RealFftPlanner::new().plan_fft_forward(samples);
        Self {
            window: (0..samples).map(at).collect(),
            windowed: transform.make_input_vec(),
            spectrum: transform.make_output_vec(),
            power: Vec::new(),
            transform,
        }
    }

    /// `|X_k|² / Σ w²` of the values less their straight line, k = 0 to half of the samples, in the unit of the values squared:
    /// white noise of variance σ² has the mean σ² at every k. Zeros where there are not as many values as samples.
    #[inline(never)]
    pub fn of(&mut self, values: &[f64]) -> &[f64] {
        self.power.clear();
        self.power.resize(self.spectrum.len(), 0.0);
        if values.len() != self.window.len() {
            return &self.power;
        }
        let n = values.len() as f64;
        let lever = |k: usize| k as f64 - 0.5 * (n - 1.0);
        let mean = values.iter().sum::<f64>() / n;
        let moment: f64 = values.iter().enumerate().map(|(k, x)| lever(k) * (x - mean)).sum();
        let slope = moment / (0..values.len()).map(|k| lever(k).powi(2)).sum::<f64>();
        for (k, (x, w)) in self.windowed.iter_mut().zip(&self.window).enumerate() {
            *x = w * (values[k] - mean - slope * lever(k));
        }
        if self.transform.process(&mut self.windowed, &mut self.spectrum).is_ok() {
            let squares: f64 = self.window.iter().map(|w| w * w).sum();
            let power = self.power.iter_mut().zip(&self.spectrum);
            power.for_each(|(power, x)| *power = x.norm_sqr() / squares);
        }
        &self.power
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of amplitude a, on a bin, is a² n / 6 there (its share of the window's coherent power) and a quarter of
    /// that beside it; a straight line is nothing.
    #[test]
    fn sine_on_a_line() {
        let (n, bin, amplitude) = (240_usize, 17_usize, 0.3);
        let phase = |k: usize| 2.0 * PI * (bin * k) as f64 / n as f64;
        let values: Vec<f64> =
            (0..n).map(|k| 2.0 - 0.01 * k as f64 + amplitude * phase(k).sin()).collect();
        let mut periodogram = Periodogram::new(n);
        let power = periodogram.of(&values).to_vec();
        let peak = amplitude * amplitude * n as f64 / 6.0;
        assert!((power[bin] / peak - 1.0).abs() < 0.01, "{} {peak}", power[bin]);
        assert!((power[bin + 1] / peak - 0.25).abs() < 0.01);
        assert!(power[3] < 1e-3 * peak && power[60] < 1e-4 * peak);
        assert!(periodogram.of(&values[1..]).iter().all(|x| *x == 0.0));
    }
}
