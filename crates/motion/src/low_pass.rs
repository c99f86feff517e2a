//! Butterworth low-pass without phase: forward and backward.

use std::f64::consts::PI;

use sci_rs::signal::filter::design::{
    DigitalFilter, FilterBandType, FilterOutputType, Sos, butter_dyn,
};
use sci_rs::signal::filter::sosfilt_zi_dyn;

use rayon::prelude::*;

use armident_recording::{Fault, RecordingError};

/// Order of the low-pass where nothing else is asked for. Forward and backward it counts twice.
pub const DEFAULT_ORDER: usize = 4;
/// Highest order.
pub const HIGHEST_ORDER: usize = 8;
/// Lowest cutoff as a share of the sample rate.
pub const LOWEST_CUTOFF_SHARE: f64 = 1e-4;
/// The cutoff must stay below this share of the sample rate.
pub const CUTOFF_SHARE_BOUND: f64 = 0.49;
/// BandMotion filtered at a time, for the processor's vector lanes: a recursion waits for itself most of the
/// time.
const LANES: usize = 4;
/// Points of the quadrature between the cutoff and the nearer end of the spectrum.
const POINTS_PER_BAND: f64 = 64.0;

/// A Butterworth low-pass run forward and backward over a signal, so that it delays nothing.
///
/// Agrees with `scipy.signal.sosfiltfilt(butter(order, cutoff_hz, fs=rate_hz, output="sos"), x)`:
/// the cutoff is where one pass has half the power (both passes together a quarter), the ends are
/// continued by odd extension, the state starts in the steady state of the first value. A signal
/// shorter than the usual extension is extended by one sample less than its length.
#[derive(Debug, Clone)]
pub struct ZeroPhaseLowPass {
    order: usize,
    cutoff_hz: f64,
    rate_hz: f64,
    /// Sections in the steady state of a constant input of 1.
    steady_sections: Vec<Sos<f64>>,
}

impl ZeroPhaseLowPass {
    /// A filter of this order for signals with `rate_hz` samples per second.
    ///
    /// # Errors
    /// An order outside 1 to [`HIGHEST_ORDER`]; a cutoff below [`LOWEST_CUTOFF_SHARE`] of the
    /// sample rate or not below [`CUTOFF_SHARE_BOUND`] of it.
    pub fn new(order: usize, cutoff_hz: f64, rate_hz: f64) -> Result<Self, RecordingError> {
        let fault = |fault| RecordingError::new(fault, "low-pass filter");
        if !(1..=HIGHEST_ORDER).contains(&order) {
            return Err(fault(Fault::OrderOutOfRange { order, highest: HIGHEST_ORDER }));
        }
        let (lowest_hz, below_hz) = (LOWEST_CUTOFF_SHARE * rate_hz, CUTOFF_SHARE_BOUND * rate_hz);
        // written so that NaN is refused
        let possible = cutoff_hz >= lowest_hz && cutoff_hz < below_hz && rate_hz.is_finite();
        let sections = if possible { sections(order, cutoff_hz / rate_hz) } else { None };
        let Some(mut steady_sections) = sections else {
            return Err(fault(Fault::CutoffOutOfRange { cutoff_hz, rate_hz, lowest_hz, below_hz }));
        };
        sosfilt_zi_dyn::<_, _, Sos<f64>>(steady_sections.iter_mut());
        Ok(Self { order, cutoff_hz, rate_hz, steady_sections })
    }

    /// The filtered signal, as long as the given one.
    pub fn filter(&self, signal: &[f64]) -> Vec<f64> {
        let mut filtered = signal.to_vec();
        self.filter_together([&mut filtered[..]]);
        filtered
    }

    /// Filters signals in their place, several at a time: a few times faster than one after the other, with
    /// the same numbers.
    pub fn filter_columns(&self, columns: &mut [Vec<f64>]) {
        for together in columns.chunks_mut(LANES) {
            match together {
                [a, b, c, d] if [&*b, &*c, &*d].iter().all(|x| x.len() == a.len()) => {
                    self.filter_together([&mut a[..], &mut b[..], &mut c[..], &mut d[..]]);
                }
                others => others.iter_mut().for_each(|x| self.filter_together([&mut x[..]])),
            }
        }
    }

    /// The same on all processors.
    pub fn filter_columns_in_parallel(&self, columns: &mut [Vec<f64>]) {
        columns.par_chunks_mut(LANES).for_each(|together| self.filter_columns(together));
    }

    /// BandMotion of one length, forward and backward, continued at both ends by odd extension.
    pub(crate) fn filter_together<const W: usize>(&self, mut signals: [&mut [f64]; W]) {
        let n = signals[0].len();
        let Some(last) = n.checked_sub(1) else { return };
        let pad = self.default_pad().min(last);
        let at = |k: usize| -> [f64; W] { std::array::from_fn(|lane| signals[lane][k]) };
        let mirrored = |end: usize, k: usize| -> [f64; W] {
            std::array::from_fn(|lane| 2.0 * signals[lane][end] - signals[lane][k])
        };
        let mut values: Vec<[f64; W]> = Vec::with_capacity(n + 2 * pad);
        values.extend((1..=pad).rev().map(|k| mirrored(0, k)));
        values.extend((0..n).map(at));
        values.extend((1..=pad).map(|k| mirrored(last, last - k)));
        self.pass(values.iter_mut());
        self.pass(values.iter_mut().rev());
        for (k, value) in values[pad..pad + n].iter().enumerate() {
            for (signal, value) in signals.iter_mut().zip(value) {
                signal[k] = *value;
            }
        }
    }

    /// One pass, started in the steady state of the first value.
    fn pass<'a, const W: usize>(&self, values: impl Iterator<Item = &'a mut [f64; W]>) {
        // orders up to 8 have up to four sections
        match &self.steady_sections[..] {
            [a] => pass([a], values),
            [a, b] => pass([a, b], values),
            [a, b, c] => pass([a, b, c], values),
            [a, b, c, d] => pass([a, b, c, d], values),
            _ => {}
        }
    }

    /// Samples of extension at each end: three times the number of coefficients.
    pub(crate) fn default_pad(&self) -> usize {
        let first_order_sections = self.order % 2;
        3 * (2 * self.steady_sections.len() + 1 - first_order_sections)
    }

    /// Noise-equivalent bandwidth of both passes together \[Hz\]: the integral of |H|⁴ from 0 to
    /// half the sample rate. White noise of variance s² comes out with s² times this, divided by
    /// half the sample rate.
    pub fn effective_bandwidth_hz(&self) -> f64 {
        // |H|⁴ is periodic in the frequency, where the trapezoidal rule converges geometrically; the
        // nearest singularity is a fraction of the distance of the cutoff from either end away
        let cutoff_share = self.cutoff_hz / self.rate_hz;
        let narrowest_share = cutoff_share.min(0.5 - cutoff_share);
        let intervals = (POINTS_PER_BAND * 0.5 / narrowest_share).ceil() as usize;
        let inner: f64 =
            (1..intervals).map(|k| self.passed(0.5 * k as f64 / intervals as f64)).sum();
        let ends = 0.5 * (self.passed(0.0) + self.passed(0.5));
        self.rate_hz * 0.5 / intervals as f64 * (inner + ends)
    }

    /// |H|⁴ at a frequency, as a share of the sample rate.
    fn passed(&self, share: f64) -> f64 {
        let cutoff = (PI * self.cutoff_hz / self.rate_hz).tan();
        // of the bilinear transform; the tangent of a right angle is large enough here
        let ratio = (PI * share).tan() / cutoff;
        (1.0 + ratio.powi(2 * self.order as i32)).powi(-2)
    }

    /// Share of independent samples in filtered white noise: 2 bandwidth / rate.
    pub fn independent_share(&self) -> f64 {
        2.0 * self.effective_bandwidth_hz() / self.rate_hz
    }

    /// Standard deviation of the derivative of filtered white noise of deviation 1 a sample \[1/s\].
    pub(crate) fn noise_gain_of_rate(&self) -> f64 {
        const POINTS: usize = 400;
        let power = |k: usize| {
            let share = 0.5 * (k as f64 + 0.5) / POINTS as f64;
            self.passed(share) * (2.0 * PI * share * self.rate_hz).powi(2)
        };
        ((0..POINTS).map(power).sum::<f64>() / POINTS as f64).sqrt()
    }

    /// Order of one pass.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Cutoff \[Hz\].
    pub fn cutoff_hz(&self) -> f64 {
        self.cutoff_hz
    }

    /// Samples per second of the signals this filter is for.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }
}

/// Sections one behind the other (transposed direct form II), in place.
fn pass<'a, const W: usize, const S: usize>(
    sections: [&Sos<f64>; S],
    values: impl Iterator<Item = &'a mut [f64; W]>,
) {
    let coefficients = sections.map(|s| [s.b[0], s.b[1], s.b[2], s.a[1], s.a[2]]);
    let mut state: Option<[[[f64; W]; 2]; S]> = None;
    for value in values {
        let state = state.get_or_insert_with(|| {
            sections.map(|s| [value.map(|first| s.zi0 * first), value.map(|first| s.zi1 * first)])
        });
        for ([b0, b1, b2, a1, a2], [z0, z1]) in coefficients.iter().zip(state) {
            for lane in 0..W {
                let x = value[lane];
                let y = b0 * x + z0[lane];
                z0[lane] = b1 * x - a1 * y + z1[lane];
                z1[lane] = b2 * x - a2 * y;
                value[lane] = y;
            }
        }
    }
}

fn sections(order: usize, cutoff_share: f64) -> Option<Vec<Sos<f64>>> {
    let filter = butter_dyn(
        order,
        vec![cutoff_share],
        Some(FilterBandType::Lowpass),
        Some(false),
        Some(FilterOutputType::Sos),
        Some(1.0),
    );
    match filter {
        DigitalFilter::Sos(filter) => Some(filter.sos),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_slow_signals_and_delays_nothing() {
        let filter = ZeroPhaseLowPass::new(4, 5.0, 200.0).unwrap();
        let line: Vec<f64> = (0..600).map(|k| 2.0 - 0.1 * f64::from(k)).collect();
        // the steady state at the start is that of a constant, so the ends of a line are not kept
        for (got, want) in filter.filter(&line).iter().zip(&line).skip(250).take(100) {
            assert!((got - want).abs() < 1e-6, "{got} {want}");
        }
        let mut pulse = vec![0.0; 1001];
        pulse[500] = 1.0;
        let filtered = filter.filter(&pulse);
        for k in 0..100 {
            assert!((filtered[500 - k] - filtered[500 + k]).abs() < 1e-9);
        }
    }

    #[test]
    fn signals_filtered_together_are_those_filtered_alone() {
        for order in 1..=HIGHEST_ORDER {
            let filter = ZeroPhaseLowPass::new(order, 5.0, 200.0).unwrap();
            let signal = |k: usize| (0..300).map(move |t| ((k * t) as f64 * 0.01).sin() + k as f64);
            let columns: Vec<Vec<f64>> = (0..7).map(|k| signal(k).collect()).collect();
            let alone: Vec<Vec<f64>> = columns.iter().map(|c| filter.filter(c)).collect();
            let (mut together, mut parallel) = (columns.clone(), columns);
            filter.filter_columns(&mut together);
            filter.filter_columns_in_parallel(&mut parallel);
            assert_eq!(together, alone);
            assert_eq!(parallel, alone);
        }
    }

    #[test]
    fn any_length_is_filtered() {
        let filter = ZeroPhaseLowPass::new(4, 5.0, 200.0).unwrap();
        for length in 0..40 {
            let filtered = filter.filter(&vec![1.5; length]);
            assert_eq!(filtered.len(), length);
            assert!(filtered.iter().all(|value| (value - 1.5).abs() < 1e-9));
        }
    }

    #[test]
    fn a_pulse_carries_the_effective_bandwidth() {
        // sum of the squared impulse response = bandwidth / (rate / 2), by Parseval
        for (order, cutoff_hz) in [(1, 20.0), (2, 3.0), (4, 10.0), (5, 60.0), (8, 90.0)] {
            let filter = ZeroPhaseLowPass::new(order, cutoff_hz, 200.0).unwrap();
            let mut pulse = vec![0.0; 4001];
            pulse[2000] = 1.0;
            let energy: f64 = filter.filter(&pulse).iter().map(|value| value * value).sum();
            assert!(
                (energy / filter.independent_share() - 1.0).abs() < 1e-9,
                "{order} {cutoff_hz}"
            );
        }
    }

    #[test]
    fn impossible_filters_say_what_is_possible() {
        let hint = |order, cutoff_hz, rate_hz| {
            let error = ZeroPhaseLowPass::new(order, cutoff_hz, rate_hz).unwrap_err();
            format!("{error} / {}", error.hint().unwrap())
        };
        assert_eq!(
            hint(4, 98.0, 200.0),
            "cut-off 98 Hz is out of range at 200 samples per second / choose a cut-off from 0.02 Hz \
             to below 98 Hz"
        );
        assert_eq!(
            hint(0, 5.0, 200.0),
            "low-pass order 0 is out of range / choose an order from 1 to 8"
        );
        for cutoff_hz in [0.0, -1.0, f64::NAN, f64::INFINITY, 0.01] {
            assert!(hint(4, cutoff_hz, 200.0).contains("out of range"));
        }
        for rate_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(hint(4, 1.0, rate_hz).contains("out of range"));
        }
    }
}
