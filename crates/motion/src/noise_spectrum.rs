//! Noise of a channel, from what it holds above the band of any motion.

use std::f64::consts::PI;

use statrs::distribution::{ContinuousCDF, Gamma};

use crate::periodogram::Periodogram;

/// Length of a spectrum's window \[s\].
const WINDOW_S: f64 = 0.64;
/// Bands of frequency in which the level is measured.
const BANDS: usize = 8;
/// Quantile over time: impacts, stick-slip and ringing are local in time and lie above it.
const QUANTILE: f64 = 0.35;
/// Colours tried: shares `c` of the kernel `[c, 1 - 2c, c]`.
const COLOURS: usize = 21;
const COLOUR_STEP: f64 = 0.01;
/// Neighbouring ordinates of a Hann-windowed periodogram correlate by 4/9 and 1/36 (squared).
const HANN_CORRELATION: f64 = 2.0 * (4.0 / 9.0 + 1.0 / 36.0);

/// White noise through the kernel `[c, 1 - 2c, c]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// Standard deviation per sample, in the unit of the channel.
    pub deviation: f64,
    /// `c`, 0 (white) to 0.2.
    pub colour: f64,
}

/// The noise of evenly sampled values. Zero for fewer samples than two windows.
pub(crate) fn noise_of(values: &[f64], rate_hz: f64) -> Noise {
    let n = ((WINDOW_S * rate_hz).round() as usize).max(32);
    let none = Noise { deviation: 0.0, colour: 0.0 };
    if values.len() < 2 * n {
        return none;
    }
    let mut periodogram = Periodogram::new(n);

    let lowest = (20.0_f64.max(0.16 * rate_hz)).min(0.25 * rate_hz) / rate_hz;
    let edge = |band: usize| {
        let share = lowest + (0.49 - lowest) * band as f64 / BANDS as f64;
        (share * n as f64).round() as usize
    };
    let mut levels = vec![Vec::new(); BANDS];
    for start in (0..=values.len() - n).step_by(n / 2) {
        let power = periodogram.of(&values[start..start + n]);
        for (band, levels) in levels.iter_mut().enumerate() {
            let ordinates = &power[edge(band)..edge(band + 1).max(edge(band) + 1)];
            levels.push(ordinates.iter().sum::<f64>() / ordinates.len() as f64);
        }
    }
    let by_band: Vec<(f64, f64)> = levels
        .iter_mut()
        .enumerate()
        .map(|(band, levels)| {
            let ordinates = (edge(band + 1) - edge(band)).max(1) as f64;
            let free = ordinates / (1.0 + HANN_CORRELATION * (1.0 - 1.0 / ordinates));
            levels.sort_by(f64::total_cmp);
            let at = (QUANTILE * (levels.len() - 1) as f64).round() as usize;
            let expected = Gamma::new(free, free).map_or(1.0, |law| law.inverse_cdf(QUANTILE));
            let middle = 0.5 * (edge(band) + edge(band + 1)) as f64 / n as f64;
            (middle, levels[at] / expected)
        })
        .collect();
    if by_band.iter().any(|(_, level)| *level <= 0.0) {
        return none;
    }
    let shape = |colour: f64, share: f64| {
        (1.0 - 2.0 * colour + 2.0 * colour * (2.0 * PI * share).cos()).powi(2)
    };
    let fit = |colour: f64| {
        let logs: Vec<f64> =
            by_band.iter().map(|(share, level)| (level / shape(colour, *share)).ln()).collect();
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        let spread: f64 = logs.iter().map(|l| (l - mean).powi(2)).sum();
        (spread, mean, colour)
    };
    let best = (0..COLOURS)
        .map(|k| fit(COLOUR_STEP * k as f64))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or((0.0, 0.0, 0.0));
    let (_, log_level, colour) = best;
    let kernel = 2.0 * colour * colour + (1.0 - 2.0 * colour).powi(2);
    Noise { deviation: (log_level.exp() * kernel).sqrt(), colour }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform deviates from a fixed congruential sequence.
    fn uniform(n: usize) -> Vec<f64> {
        let mut state = 88_172_645_463_325_252_u64;
        (0..n)
            .map(|_| {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            })
            .collect()
    }

    #[test]
    fn finds_level_and_colour_under_a_motion_and_an_impact() {
        for colour in [0.0, 0.12] {
            let white = uniform(6000);
            let values: Vec<f64> = (1..5999)
                .map(|k| {
                    let noise =
                        colour * (white[k - 1] + white[k + 1]) + (1.0 - 2.0 * colour) * white[k];
                    let t = k as f64 / 200.0;
                    let ringing = if k > 3000 {
                        9.0 * (-(t - 15.0) * 3.0).exp() * (300.0 * t).sin()
                    } else {
                        0.0
                    };
                    20.0 * (2.0 * t).sin() + ringing + noise
                })
                .collect();
            let found = noise_of(&values, 200.0);
            let kernel: f64 = 2.0 * colour * colour + (1.0 - 2.0 * colour) * (1.0 - 2.0 * colour);
            let exact = (kernel / 12.0).sqrt();
            assert!((found.deviation / exact - 1.0).abs() < 0.08, "{found:?} {exact}");
            assert!((found.colour - colour).abs() < 0.03, "{found:?}");
        }
    }
}
