//! The narrow band in which everything is compared.

use std::f64::consts::PI;

/// Cut-off (-6 dB) of the band \[Hz\]: motions of arms and their friction live below; the noise of
/// efforts and of differentiated encoders mostly above.
pub const BAND_HZ: f64 = 10.0;
/// Share of the sample rate that the cut-off may be: there differences of fourth order lose 4 % of a
/// derivative, and less below.
const BAND_SHARE: f64 = 1.0 / 6.0;
/// Rows kept per cycle of the cut-off: a little above twice.
const ROWS_PER_CYCLE: f64 = 2.5;
/// Half the length of the kernel \[s\]: a transition of 4 Hz on either side.
const HALF_LENGTH_S: f64 = 0.25;
/// Samples closer to an end than this \[s\] are not used: the kernel and the low-pass of the
/// kinematics reach there.
pub const EDGE_S: f64 = 0.3;

/// A zero-phase low-pass whose output is formed only at the rows that are kept: a windowed sine
/// cardinal. One kept row costs its taps, which is a tenth of a recursive filter over all samples.
#[derive(Debug, Clone)]
pub struct Band {
    taps: Vec<f64>,
    /// Sample index of each row.
    pub kept: Vec<usize>,
    /// Rows per second.
    pub rows_hz: f64,
    rate_hz: f64,
    cutoff_hz: f64,
    left_out_s: Vec<(f64, f64)>,
}

impl Band {
    /// Up to `highest_hz`, or what the rate allows.
    pub fn new(rate_hz: f64, samples: usize, highest_hz: f64) -> Self {
        let cutoff_hz = highest_hz.min(BAND_SHARE * rate_hz);
        let cutoff = cutoff_hz / rate_hz;
        // as many cycles of the cut-off whatever it is
        let longer = BAND_HZ / cutoff_hz;
        let half = (HALF_LENGTH_S * longer * rate_hz).round().max(1.0) as usize;
        let mut taps: Vec<f64> = (0..=2 * half)
            .map(|k| {
                let t = k as f64 - half as f64;
                let window = 0.5 * (1.0 + (PI * t / (half as f64 + 1.0)).cos());
                let x = 2.0 * PI * cutoff * t;
                window * if t == 0.0 { 1.0 } else { x.sin() / x }
            })
            .collect();
        let sum: f64 = taps.iter().sum();
        taps.iter_mut().for_each(|tap| *tap /= sum);
        let step = (rate_hz / (ROWS_PER_CYCLE * cutoff_hz)).round().max(1.0) as usize;
        let edge = ((EDGE_S * longer * rate_hz).ceil() as usize).max(half);
        let kept = (edge..samples.saturating_sub(edge)).step_by(step).collect();
        Self {
            taps,
            kept,
            rows_hz: rate_hz / step as f64,
            rate_hz,
            cutoff_hz,
            left_out_s: Vec::new(),
        }
    }

    /// The cut-off \[Hz\].
    pub fn cutoff_hz(&self) -> f64 {
        self.cutoff_hz
    }

    /// Without rows in these intervals since the first sample \[s\].
    #[must_use]
    pub(crate) fn without(mut self, intervals_s: Vec<(f64, f64)>) -> Self {
        let rate_hz = self.rate_hz;
        let is_in = |k: usize, (from_s, to_s): &(f64, f64)| {
            (*from_s..=*to_s).contains(&(k as f64 / rate_hz))
        };
        self.kept.retain(|k| !intervals_s.iter().any(|interval| is_in(*k, interval)));
        self.left_out_s = intervals_s;
        self
    }

    /// Intervals that are left out, since the first sample \[s\].
    pub(crate) fn left_out_s(&self) -> &[(f64, f64)] {
        &self.left_out_s
    }

    /// The rows of a column given at every sample.
    pub fn rows(&self, column: &[f64]) -> Vec<f64> {
        self.at(column, &self.kept)
    }

    /// Appends the rows of columns of which only a few are not zero at a sample: `few` of them, with their
    /// values. Each row costs its taps so many times, however many columns there are.
    pub fn rows_of_few(&self, entries: &[(usize, f64)], few: usize, rows: &mut [Vec<f64>]) {
        let half = self.taps.len() / 2;
        let mut sums = vec![0.0; rows.len()];
        for &i in &self.kept {
            sums.fill(0.0);
            let window = &entries[few * (i - half)..few * (i - half + self.taps.len())];
            for (tap, entries) in self.taps.iter().zip(window.chunks_exact(few)) {
                for (column, value) in entries {
                    sums[*column] += tap * value;
                }
            }
            for (rows, sum) in rows.iter_mut().zip(&sums) {
                rows.push(*sum);
            }
        }
    }

    /// Rows so far apart that white noise is white in them again: at twice the cut-off.
    pub fn independent_rows(&self, column: &[f64]) -> Vec<f64> {
        let step = (self.rate_hz / (2.0 * self.cutoff_hz)).ceil().max(1.0) as usize;
        let (Some(&first), Some(&last)) = (self.kept.first(), self.kept.last()) else {
            return Vec::new();
        };
        self.at(column, &(first..=last).step_by(step).collect::<Vec<_>>())
    }

    fn at(&self, column: &[f64], places: &[usize]) -> Vec<f64> {
        let half = self.taps.len() / 2;
        places
            .iter()
            .map(|&i| {
                let window = &column[i - half..i - half + self.taps.len()];
                // four sums, so that the additions do not wait for each other
                let mut sums = [0.0; 4];
                let (a, b) = (window.chunks_exact(4), self.taps.chunks_exact(4));
                let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(x, t)| x * t).sum();
                for (x, t) in a.zip(b) {
                    for k in 0..4 {
                        sums[k] += x[k] * t[k];
                    }
                }
                rest + sums.iter().sum::<f64>()
            })
            .collect()
    }

    /// Variance that white noise of variance 1, coloured by the kernel `[c, 1 - 2c, c]` to variance 1
    /// again, keeps in the band.
    pub fn noise_gain(&self, colour: f64) -> f64 {
        let kernel = [colour, 1.0 - 2.0 * colour, colour];
        let n = self.taps.len();
        let both = (0..n + 2).map(|i| {
            (0..3)
                .filter(|k| i >= *k && i - k < n)
                .map(|k| kernel[k] * self.taps[i - k])
                .sum::<f64>()
        });
        both.map(|x| x * x).sum::<f64>() / kernel.iter().map(|x| x * x).sum::<f64>()
    }

    /// Mean over all frequencies of `|F|² g(f)`, for noise that a filter of power `g` has shaped.
    pub fn mean_power(&self, g: impl Fn(f64) -> f64) -> f64 {
        const POINTS: usize = 400;
        let half = self.taps.len() / 2;
        let power = |k: usize| {
            let f = (k as f64 + 0.5) / POINTS as f64 * 0.5 * self.rate_hz;
            let w = 2.0 * PI * f / self.rate_hz;
            let response: f64 = self.taps[half]
                + 2.0 * (1..=half).map(|t| self.taps[half + t] * (w * t as f64).cos()).sum::<f64>();
            response * response * g(f)
        };
        (0..POINTS).map(power).sum::<f64>() / POINTS as f64
    }

    /// Independent samples per row.
    pub fn independent_share(&self) -> f64 {
        // white noise in, so variance over share of the band: mean |F|² is 2 B / rate
        let bandwidth = 0.5 * self.rate_hz * self.mean_power(|_| 1.0);
        (2.0 * bandwidth / self.rows_hz).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_signals_pass_and_fast_ones_do_not() {
        let band = Band::new(200.0, 2000, BAND_HZ);
        let wave = |hz: f64| -> Vec<f64> {
            (0..2000).map(|k| (2.0 * PI * hz * f64::from(k) / 200.0).sin()).collect()
        };
        let gain = |hz: f64| {
            let signal = wave(hz);
            let rows = band.rows(&signal);
            let kept: f64 = band.kept.iter().map(|&i| signal[i] * signal[i]).sum();
            (rows.iter().map(|x| x * x).sum::<f64>() / kept).sqrt()
        };
        assert!((gain(3.1) - 1.0).abs() < 0.01, "{}", gain(3.1));
        assert!((gain(10.0) - 0.5).abs() < 0.05, "{}", gain(10.0));
        assert!(gain(16.0) < 0.01, "{}", gain(16.0));
        // columns of one entry a sample, as columns in full
        let wave = wave(3.1);
        let entries: Vec<(usize, f64)> =
            wave.iter().enumerate().map(|(k, x)| (k % 2, *x)).collect();
        let mut rows = vec![Vec::new(); 2];
        band.rows_of_few(&entries, 1, &mut rows);
        for (column, rows) in rows.iter().enumerate() {
            let full: Vec<f64> =
                entries.iter().map(|e| if e.0 == column { e.1 } else { 0.0 }).collect();
            for (few, full) in rows.iter().zip(band.rows(&full)) {
                assert!((few - full).abs() < 1e-12, "{few} {full}");
            }
        }
        let share = band.independent_share();
        assert!((0.6..0.85).contains(&share), "{share}");
        // white noise: the mean power over all frequencies is the sum of the squared taps
        assert!((band.noise_gain(0.0) / band.mean_power(|_| 1.0) - 1.0).abs() < 0.01);
    }
}
