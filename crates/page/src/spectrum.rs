//! Residuals by frequency, by order in the position, and by lag.

use std::f64::consts::{PI, TAU};

use armident_kinematics::JointKind;
use armident_motion::Periodogram;

use crate::drawing::PlotSeries;
use crate::reduce::{rounded, rounded_some};
use crate::sheet::Sheet;

/// Length of the stretches whose periodograms are averaged \[s\].
const STRETCH_S: f64 = 4.0;
/// Values of a drawn spectrum.
const POINTS: usize = 300;
/// Orders looked at: cycles a turn, or a metre.
const HIGHEST_ORDER: f64 = 150.0;
const ORDER_STEP: f64 = 0.5;
/// Positions a turn (a metre) that residuals are averaged in before their orders are taken.
const POSITIONS: f64 = 2048.0;
/// Longest lag \[s\] and number of lags of the autocorrelation.
const LONGEST_LAG_S: f64 = 0.5;
const LAGS: usize = 50;
/// Samples of a recording that the autocorrelation looks at.
const CORRELATED: usize = 100_000;

/// Amplitude spectral density \[N m/√Hz or N/√Hz\] after Welch (1967): Hann windows, half overlapping.
/// Of several frequencies that fall on one drawn point the strongest is kept.
pub(crate) fn spectrum(sheets: &[&Sheet], joint: usize) -> PlotSeries {
    let Some(first) = sheets.first() else { return PlotSeries::default() };
    let rate_hz = first.motion.rate_hz;
    let shortest = sheets.iter().map(|s| s.kept.len()).min().unwrap_or(0);
    let n = ((STRETCH_S * rate_hz) as usize).min(shortest) / 2 * 2;
    if n < 16 {
        return PlotSeries::default();
    }
    let mut periodogram = Periodogram::new(n);
    let mut densities = Vec::new();
    for model in 0..first.residual.len() {
        let mut sum = vec![0.0; n / 2 + 1];
        let mut count = 0.0_f64;
        // recordings of another rate have other frequencies
        for sheet in sheets.iter().filter(|s| (s.motion.rate_hz / rate_hz - 1.0).abs() < 1e-3) {
            let residual = sheet.of(&sheet.residual[model][joint]);
            for start in (0..=residual.len().saturating_sub(n)).step_by(n / 2) {
                let Some(piece) = residual.get(start..start + n) else { continue };
                count += 1.0;
                for (sum, power) in sum.iter_mut().zip(periodogram.of(piece)) {
                    *sum += 2.0 * power / rate_hz;
                }
            }
        }
        densities.push(sum.iter().map(|s| (s / count.max(1.0)).sqrt()).collect::<Vec<f64>>());
    }
    let chunk = (n / 2).div_ceil(POINTS).max(1);
    let hertz = rate_hz / n as f64;
    // the mean is taken out: nothing is left at frequency 0
    let x: Vec<f64> =
        (1..=n / 2).step_by(chunk).map(|k| (k as f64 + 0.5 * (chunk - 1) as f64) * hertz).collect();
    let strongest = |density: &Vec<f64>| {
        let values: Vec<Option<f64>> = density[1..]
            .chunks(chunk)
            .map(|c| Some(c.iter().copied().fold(0.0, f64::max)).filter(|x| *x > 0.0))
            .collect();
        significant(&values)
    };
    PlotSeries { values: densities.iter().map(strongest).collect(), x: rounded(&x) }
}

/// Four significant digits: spectra span decades.
fn significant(values: &[Option<f64>]) -> Vec<Option<f64>> {
    values.iter().map(|x| x.and_then(|x| format!("{x:.3e}").parse().ok())).collect()
}

/// Amplitude of the residual at every order of the position, every piece of the path weighing by its
/// length: gear and motor ripple are lines here at any speed.
pub(crate) fn orders(sheets: &[&Sheet], joint: usize, kind: JointKind) -> PlotSeries {
    let Some(first) = sheets.first() else { return PlotSeries::default() };
    let cycle = if kind.is_rotational() { TAU } else { 1.0 };
    let all = || sheets.iter().flat_map(|s| &s.motion.position[joint]);
    let from = all().copied().fold(f64::MAX, f64::min);
    let to = all().copied().fold(f64::MIN, f64::max);
    let cells = ((to - from) / cycle * POSITIONS) as usize + 1;
    // less than a hundredth of a turn holds no order
    if !(20..1 << 20).contains(&cells) {
        return PlotSeries::default();
    }
    let count = (HIGHEST_ORDER / ORDER_STEP) as usize;
    let x: Vec<f64> = (1..=count).map(|k| k as f64 * ORDER_STEP).collect();
    let amplitudes = |model: usize| -> Vec<Option<f64>> {
        let mut sums = vec![0.0; cells];
        let mut weights = vec![0.0; cells];
        for sheet in sheets {
            let (q, v) = (&sheet.motion.position[joint], &sheet.motion.velocity[joint]);
            for k in sheet.kept.clone() {
                let Some(r) = sheet.residual[model][joint].get(k) else { continue };
                let cell = (((q[k] - from) / cycle * POSITIONS) as usize).min(cells - 1);
                let length = v[k].abs() / sheet.motion.rate_hz;
                sums[cell] += length * r;
                weights[cell] += length;
            }
        }
        let path: f64 = weights.iter().sum();
        if path <= 0.0 {
            return vec![None; count];
        }
        let mean = sums.iter().sum::<f64>() / path;
        let values: Vec<Option<f64>> = x
            .iter()
            .map(|order| {
                let (mut cosine, mut sine) = (0.0, 0.0);
                for (cell, (s, w)) in sums.iter().zip(&weights).enumerate() {
                    let phase = 2.0 * PI * order * (cell as f64 + 0.5) / POSITIONS;
                    let (sin, cos) = phase.sin_cos();
                    cosine += (s - mean * w) * cos;
                    sine += (s - mean * w) * sin;
                }
                Some(2.0 * cosine.hypot(sine) / path)
            })
            .collect();
        rounded_some(&values)
    };
    PlotSeries { values: (0..first.residual.len()).map(amplitudes).collect(), x }
}

/// Autocorrelation by lag of each model's residual, and what 95 of 100 lags of white noise stay below.
pub(crate) fn autocorrelation(sheets: &[&Sheet], joint: usize) -> (PlotSeries, f64) {
    let Some(first) = sheets.first() else { return (PlotSeries::default(), 0.0) };
    let rate_hz = first.motion.rate_hz;
    let step = ((LONGEST_LAG_S * rate_hz / LAGS as f64).round() as usize).max(1);
    let of = |model: usize| -> Vec<Option<f64>> {
        let pieces: Vec<&[f64]> = sheets
            .iter()
            .map(|s| s.of(&s.residual[model][joint]))
            .map(|r| &r[..r.len().min(CORRELATED)])
            .collect();
        let count: usize = pieces.iter().map(|p| p.len()).sum();
        let mean = pieces.iter().copied().flatten().sum::<f64>() / count.max(1) as f64;
        let variance: f64 = pieces.iter().copied().flatten().map(|x| (x - mean).powi(2)).sum();
        let values: Vec<Option<f64>> = (0..=LAGS)
            .map(|lag| {
                let product = |p: &[f64]| -> f64 {
                    p.iter()
                        .zip(p.iter().skip(lag * step))
                        .map(|(a, b)| (a - mean) * (b - mean))
                        .sum()
                };
                let sum: f64 = pieces.iter().map(|p| product(p)).sum();
                (variance > 0.0).then(|| sum / variance)
            })
            .collect();
        rounded_some(&values)
    };
    let count: usize = sheets.iter().map(|s| s.kept.len().min(CORRELATED)).sum();
    let x: Vec<f64> = (0..=LAGS).map(|lag| (lag * step) as f64 / rate_hz).collect();
    let series = PlotSeries { values: (0..first.residual.len()).map(of).collect(), x: rounded(&x) };
    (series, 1.96 / (count.max(1) as f64).sqrt())
}
