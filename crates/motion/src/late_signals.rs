//! Signals as they are seen late: after a delay and a low-pass of first order, exact at every frequency.

use std::f64::consts::TAU;
use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

/// How late a signal is: `T dy/dt + y = signal(t - delay)`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SignalLag {
    /// Delay \[s\], negative where the signal is seen early.
    pub delay_s: f64,
    /// Time constant `T` of a low-pass of first order \[s\].
    pub time_constant_s: f64,
}

impl SignalLag {
    fn response(self, w: f64) -> Complex<f64> {
        let phase = -w * self.delay_s;
        Complex::new(phase.cos(), phase.sin()) / Complex::new(1.0, w * self.time_constant_s)
    }
}

/// Signals of one length on an even grid and their Fourier transforms. The signals are continued beyond their ends by their
/// mirror images, which is right up to a few time constants from the ends; they should hold nothing near half the rate.
pub struct LateSignals {
    samples: usize,
    rate_hz: f64,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    spectra: Vec<Vec<Complex<f64>>>,
}

impl LateSignals {
    /// Of signals of the same length.
    #[inline(never)]
    pub fn new(signals: &[Vec<f64>], rate_hz: f64) -> Self {
        let samples = signals.first().map_or(0, Vec::len);
        let mut planner = RealFftPlanner::new();
        // an empty transform is none
        let length = (2 * samples).max(2);
        let mut all = Self {
            samples,
            rate_hz,
            forward: planner.plan_fft_forward(length),
            inverse: planner.plan_fft_inverse(length),
            spectra: Vec::new(),
        };
        all.spectra = signals.iter().map(|signal| all.spectrum(signal)).collect();
        all
    }

    /// The signals with a lag.
    pub fn with(&self, lag: SignalLag) -> Vec<Vec<f64>> {
        self.spectra.iter().map(|spectrum| self.filtered(spectrum, |w| lag.response(w))).collect()
    }

    /// The derivative of a signal that is seen late, of the length of these, by its delay.
    pub fn by_delay(&self, late: &[f64]) -> Vec<f64> {
        self.filtered(&self.spectrum(late), |w| Complex::new(0.0, -w))
    }

    /// The same by the time constant of its low-pass \[s\].
    pub fn by_time_constant(&self, late: &[f64], time_constant_s: f64) -> Vec<f64> {
        let response = |w: f64| Complex::new(0.0, -w) / Complex::new(1.0, w * time_constant_s);
        self.filtered(&self.spectrum(late), response)
    }

    fn spectrum(&self, signal: &[f64]) -> Vec<Complex<f64>> {
        let mut both: Vec<f64> = signal.iter().chain(signal.iter().rev()).copied().collect();
        let mut spectrum = self.forward.make_output_vec();
        both.resize(self.forward.len(), 0.0);
        // the lengths are those of the plan
        let done = self.forward.process(&mut both, &mut spectrum);
        debug_assert!(done.is_ok());
        spectrum
    }

    fn filtered(
        &self,
        spectrum: &[Complex<f64>],
        response: impl Fn(f64) -> Complex<f64>,
    ) -> Vec<f64> {
        let length = self.inverse.len();
        let at = |k: usize| TAU * self.rate_hz * k as f64 / length as f64;
        let mut product: Vec<Complex<f64>> =
            spectrum.iter().enumerate().map(|(k, x)| x * response(at(k)) / length as f64).collect();
        // real signals have real values at both ends of the spectrum
        for end in [0, length / 2] {
            if let Some(value) = product.get_mut(end) {
                value.im = 0.0;
            }
        }
        let mut late = self.inverse.make_output_vec();
        let done = self.inverse.process(&mut product, &mut late);
        debug_assert!(done.is_ok());
        late.truncate(self.samples);
        late
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 40.0;
    const LAG: SignalLag = SignalLag { delay_s: 0.013, time_constant_s: 0.021 };

    fn wave(phase: f64) -> Vec<f64> {
        (0..1001).map(|k| (TAU * 6.0 * f64::from(k) / RATE_HZ + phase).sin()).collect()
    }

    /// Away from the ends, where the mirror image is another signal.
    fn largest_difference(found: &[f64], expected: impl Fn(usize) -> f64) -> f64 {
        (100..900).map(|k| (found[k] - expected(k)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn wave_near_the_band_edge_is_late_and_smaller() {
        let signals = LateSignals::new(&[wave(0.3), wave(0.0)], RATE_HZ);
        let w = TAU * 6.0;
        let phase = w * LAG.delay_s + (w * LAG.time_constant_s).atan();
        let gain = (w * LAG.time_constant_s).atan().cos();
        let late = &signals.with(LAG)[0];
        let exact = |k: usize| gain * (w * k as f64 / RATE_HZ + 0.3 - phase).sin();
        assert!(largest_difference(late, exact) < 2e-3);
        let same = &signals.with(SignalLag::default())[1];
        assert!(largest_difference(same, |k| wave(0.0)[k]) < 1e-12);
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let signals = LateSignals::new(&[wave(0.3)], RATE_HZ);
        let step = 1e-6;
        let late = signals.with(LAG).remove(0);
        let found = [signals.by_delay(&late), signals.by_time_constant(&late, LAG.time_constant_s)];
        let later = SignalLag { delay_s: LAG.delay_s + step, ..LAG };
        let slower = SignalLag { time_constant_s: LAG.time_constant_s + step, ..LAG };
        for (found, lag) in found.iter().zip([later, slower]) {
            let moved = &signals.with(lag)[0];
            let difference = |k: usize| (moved[k] - late[k]) / step;
            assert!(largest_difference(found, difference) < 0.01 * TAU * 6.0);
        }
    }
}
